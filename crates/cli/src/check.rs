//! `pcsg check`: the mistakes in a scene, or how large the solid is.

use std::fmt::Write;

use csg_graph::{Analysis, StatesError, SymbolState};
use serde::Serialize;

use crate::args::{CheckArgs, Format};
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

fn json(report: &impl Serialize) -> String {
    let text = serde_json::to_string_pretty(report).expect("a report has only strings and numbers");
    text + "\n"
}

fn table(scene: &str, analysis: &Analysis) -> String {
    let states = format!(
        "{}  ({} distinct; {} of all nodes)",
        grouped(&analysis.states.to_string()),
        grouped(&analysis.distinct_states.to_string()),
        grouped(&analysis.node_states.to_string()),
    );
    let rows = [
        ("graph nodes", grouped(&analysis.nodes.to_string())),
        ("states", states),
        ("instances", grouped(&analysis.instances.to_string())),
        ("primitives", grouped(&analysis.primitives.to_string())),
        ("depth", grouped(&analysis.depth.to_string())),
        ("terminates", "yes".to_owned()),
    ];
    let mut text = format!("{scene}: no mistakes\n");
    for (name, value) in rows {
        let _ = writeln!(text, "  {name:<12} {value}");
    }
    text
}

/// A number with a comma before every three digits.
fn grouped(digits: &str) -> String {
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
