//! `pcsg check`: the mistakes in a scene, or how large the solid is.

use std::fmt::Write;

use csg_graph::{Analysis, StatesError, SymbolState};
use serde::Serialize;

use crate::args::{CheckArgs, Format};
use crate::text::{grouped, json};
use crate::{Failure, load, print};

/// What `check --format json` prints. Counts that outgrow the numbers of most JSON readers are decimal strings.
#[derive(Serialize)]
struct Report {
    scene: String,
    nodes: usize,
    states: String,
    distinct_states: String,
    node_states: String,
    instances: String,
    primitives: String,
    depth: u64,
    terminates: bool,
}

/// What it prints where the recursion never ends.
#[derive(Serialize)]
struct Endless {
    scene: String,
    nodes: usize,
    terminates: bool,
    counterexample: Vec<Visit>,
}

#[derive(Serialize)]
struct Visit {
    symbol: String,
    params: serde_json::Map<String, serde_json::Value>,
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), Failure> {
    let loaded = load::load(&args.scene)?;
    let graph = &loaded.scene.graph;
    match graph.analyse(&loaded.limits) {
        Ok(analysis) => print(match args.format {
            Format::Table => table(&loaded.name, &analysis),
            Format::Json => json(&Report {
                scene: loaded.name.clone(),
                nodes: analysis.nodes,
                states: analysis.states.to_string(),
                distinct_states: analysis.distinct_states.to_string(),
                node_states: analysis.node_states.to_string(),
                instances: analysis.instances.to_string(),
                primitives: analysis.primitives.to_string(),
                depth: analysis.depth,
                terminates: true,
            }),
        }),
        Err(error) => {
            if let (Format::Json, StatesError::Endless { path }) = (args.format, &error) {
                print(json(&Endless {
                    scene: loaded.name.clone(),
                    nodes: graph.node_count(),
                    terminates: false,
                    counterexample: path.iter().map(Visit::new).collect(),
                }))?;
            }
            Err(loaded.failure(&error))
        }
    }
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
    let rows = [
        ("graph nodes", grouped(analysis.nodes)),
        ("states", states),
        ("instances", grouped(&analysis.instances)),
        ("primitives", grouped(&analysis.primitives)),
        ("depth", grouped(analysis.depth)),
        ("terminates", "yes".to_owned()),
    ];
    let mut text = format!("{scene}: no mistakes\n");
    for (name, value) in rows {
        let _ = writeln!(text, "  {name:<12} {value}");
    }
    text
}
