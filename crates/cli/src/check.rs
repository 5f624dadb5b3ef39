//! `pcsg check`: the mistakes in a scene, or how large the solid is.

use std::fmt::Write;

use csg_graph::{Analysis, StatesError, SymbolState};
use csg_graph_bounds::Aabb;
use serde::Serialize;

use crate::args::{CheckArgs, Format, USUAL_MEMORY};
use crate::engine::exact_boxes;
use crate::load::{Loaded, MAX_STATES, load};
use crate::regime::listing_bytes;
use crate::text::{grouped, json};
use crate::{Failure, bounds, extent, print};

/// What `check --format json` prints. Counts that outgrow the numbers of most JSON readers are decimal strings.
#[derive(Serialize)]
struct Report {
    scene: String,
    regime: &'static str,
    nodes: usize,
    states: String,
    distinct_states: String,
    node_states: String,
    instances: String,
    primitives: String,
    depth: u64,
    terminates: bool,
}

/// What it prints where the recursion never ends; of a solid that is bounded all the same, also how.
#[derive(Serialize)]
struct Endless {
    scene: String,
    regime: &'static str,
    nodes: usize,
    terminates: bool,
    counterexample: Vec<Visit>,
    #[serde(flatten)]
    bounded: Option<Bounded>,
}

/// What it prints where the states are too many to be listed.
#[derive(Serialize)]
struct Vast {
    scene: String,
    regime: &'static str,
    nodes: usize,
    more_states_than: usize,
    /// The states without what is random.
    keys: usize,
    min: [f64; 3],
    max: [f64; 3],
}

/// A recursion that never ends, but shrinks.
#[derive(Serialize)]
struct Bounded {
    node_states: usize,
    contraction: f64,
    min: [f64; 3],
    max: [f64; 3],
}

#[derive(Serialize)]
struct Visit {
    symbol: String,
    params: serde_json::Map<String, serde_json::Value>,
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), Failure> {
    let loaded = load(&args.scene)?;
    let graph = &loaded.scene.graph;
    match graph.analyse(&loaded.limits) {
        Ok(analysis) => finite(args, &loaded, &analysis),
        Err(StatesError::Endless { path }) => endless(args, &loaded, &path),
        Err(error @ StatesError::TooMany { limit, .. }) => vast(args, &loaded, &error, limit),
        Err(error) => Err(loaded.failure(&error)),
    }
}

/// A solid whose states can be listed is one that can be traced, unless its size is beyond numbers.
fn finite(args: &CheckArgs, loaded: &Loaded, analysis: &Analysis) -> Result<(), Failure> {
    if listing_bytes(analysis.node_states) <= USUAL_MEMORY.0 {
        exact_boxes(loaded)?;
    }
    print(match args.format {
        Format::Table => table(&loaded.name, analysis),
        Format::Json => json(&Report {
            scene: loaded.name.clone(),
            regime: "finite",
            nodes: analysis.nodes,
            states: analysis.states.to_string(),
            distinct_states: analysis.distinct_states.to_string(),
            node_states: analysis.node_states.to_string(),
            instances: analysis.instances.to_string(),
            primitives: analysis.primitives.to_string(),
            depth: analysis.depth,
            terminates: true,
        }),
    })
}

/// More states than can be listed are a mistake, unless they can be bounded without a list. Where nothing is random, they
/// may still be one.
fn vast(args: &CheckArgs, loaded: &Loaded, error: &StatesError, limit: usize) -> Result<(), Failure> {
    let graph = &loaded.scene.graph;
    let envelopes = loaded.envelopes(MAX_STATES)?;
    let root = loaded.refined_box(&envelopes)?;
    loaded.doubt(error, MAX_STATES);
    let report = Vast {
        scene: loaded.name.clone(),
        regime: "vast",
        nodes: graph.node_count(),
        more_states_than: limit,
        keys: envelopes.key_count(),
        min: root.min.to_array(),
        max: root.max.to_array(),
    };
    print(match args.format {
        Format::Json => json(&report),
        Format::Table => rows(
            &format!("{}: no mistakes; more states than are listed", report.scene),
            &[
                ("regime", "vast: what rays come to is compiled when they come to it".to_owned()),
                ("graph nodes", grouped(report.nodes)),
                (
                    "states",
                    format!(
                        "more than {} of all nodes; {} without what is random",
                        grouped(limit),
                        grouped(report.keys)
                    ),
                ),
                ("box", format!("at most {}", bounds::line(&root))),
            ],
        ),
    })
}

/// A recursion that never ends is a mistake, unless it shrinks to a solid.
fn endless(args: &CheckArgs, loaded: &Loaded, path: &[SymbolState]) -> Result<(), Failure> {
    let exact = bounds::endless_boxes(loaded, &loaded.bounds_limits())
        .and_then(|found| extent::check(loaded, &found.0).map(|()| found));
    let bounded = exact.as_ref().ok().map(|(exact, contraction)| Bounded {
        node_states: exact.counts.states,
        contraction: *contraction,
        min: exact.root.min.to_array(),
        max: exact.root.max.to_array(),
    });
    let report = Endless {
        scene: loaded.name.clone(),
        regime: "endless",
        nodes: loaded.scene.graph.node_count(),
        terminates: false,
        counterexample: path.iter().map(Visit::new).collect(),
        bounded,
    };
    if report.bounded.is_some() {
        loaded.doubt(&StatesError::Endless { path: path.to_vec() }, MAX_STATES);
    }
    match (args.format, &report.bounded) {
        (Format::Json, _) => print(json(&report))?,
        (Format::Table, Some(bounded)) => print(endless_table(&report, bounded))?,
        (Format::Table, None) => {}
    }
    exact.map(drop)
}

impl Visit {
    fn new(state: &SymbolState) -> Self {
        let params = state.values.iter().map(|(name, value)| (name.clone(), (*value).into())).collect();
        Self { symbol: state.name.clone(), params }
    }
}

fn table(scene: &str, analysis: &Analysis) -> String {
    let states = format!(
        "{}  ({} distinct; {} of all nodes)",
        grouped(analysis.states),
        grouped(analysis.distinct_states),
        grouped(analysis.node_states),
    );
    let memory = listing_bytes(analysis.node_states);
    let regime = if memory > USUAL_MEMORY.0 {
        format!("finite: all states are listed, by `render` with --memory {}M", memory.div_ceil(1 << 20))
    } else {
        "finite: all states are listed".to_owned()
    };
    let found = [
        ("regime", regime),
        ("graph nodes", grouped(analysis.nodes)),
        ("states", states),
        ("instances", grouped(&analysis.instances)),
        ("primitives", grouped(&analysis.primitives)),
        ("depth", grouped(analysis.depth)),
        ("terminates", "yes".to_owned()),
    ];
    rows(&format!("{scene}: no mistakes"), &found)
}

/// A table below its title.
fn rows(title: &str, rows: &[(&str, String)]) -> String {
    let mut text = format!("{title}\n");
    for (name, value) in rows {
        let _ = writeln!(text, "  {name:<12} {value}");
    }
    text
}

fn endless_table(report: &Endless, bounded: &Bounded) -> String {
    let Bounded { node_states, contraction, min, max } = bounded;
    let aabb = Aabb { min: (*min).into(), max: (*max).into() };
    let found = [
        ("regime", "endless: what is too small to be seen is not looked into".to_owned()),
        ("graph nodes", grouped(report.nodes)),
        ("states", format!("{} of all nodes", grouped(node_states))),
        ("instances", "endless".to_owned()),
        ("terminates", "no".to_owned()),
        ("contraction", format!("{contraction:.6}: once round any cycle, sizes shrink to at most that")),
        ("box", bounds::line(&aabb)),
    ];
    rows(&format!("{}: no mistakes; an endless recursion that shrinks", report.scene), &found)
}
