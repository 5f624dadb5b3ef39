//! One scene at many values of a parameter, bounded by all algorithms: how boxes grow, and what they cost.

use std::time::Instant;

use csg_graph::{Analysis, BigUint, Graph, Node, StatesError};
use csg_graph_bounds::{Aabb, HyperBoxes};

use super::methods::{boxes_to_compute, hyper_boxes};
use crate::Failure;
use crate::args::{MethodArg, Sweep};
use crate::load::Loaded;
use crate::progress::Bar;

/// The most values that are tried.
const VALUES: u16 = 64;

/// All samples, in the order of the values.
pub(super) struct Samples {
    pub(super) samples: Vec<Sample>,
    /// Values at which the scene has mistakes.
    pub(super) left_out: Vec<i32>,
}

/// The scene at one value.
pub(super) struct Sample {
    pub(super) value: i32,
    analysis: Analysis,
    runs: [Option<Run>; 3],
}

/// An algorithm's answer.
#[derive(Clone)]
pub(super) struct Run {
    pub(super) root: Aabb,
    pub(super) nodes: Vec<Aabb>,
    pub(super) seconds: f64,
}

impl Run {
    /// Runs an algorithm, unless that takes too many steps.
    pub(super) fn new(
        method: MethodArg,
        loaded: &Loaded,
        analysis: &Analysis,
        max_steps: u64,
    ) -> Result<Option<Self>, Failure> {
        if method != MethodArg::Exact && boxes_to_compute(method, analysis) > BigUint::from(max_steps) {
            return Ok(None);
        }
        let start = Instant::now();
        let HyperBoxes { root, nodes, .. } = hyper_boxes(method, loaded, analysis, max_steps)?;
        Ok(Some(Self { root, nodes, seconds: start.elapsed().as_secs_f64() }))
    }
}

impl Sample {
    /// What an algorithm found, if its work was within reach.
    pub(super) fn run(&self, method: MethodArg) -> Option<&Run> {
        self.runs[method as usize].as_ref()
    }

    /// The boxes that an algorithm computes, or would.
    pub(super) fn boxes(&self, method: MethodArg) -> BigUint {
        boxes_to_compute(method, &self.analysis)
    }

    /// How much larger than the exact one the root box of an algorithm is, by volume; `None` if there is nothing to
    /// compare.
    pub(super) fn growth(&self, method: MethodArg) -> Option<f64> {
        let [found, exact] =
            [method, MethodArg::Exact].map(|method| self.run(method).map(|run| run.root.volume()));
        ratio(found?, exact?)
    }
}

/// `None` where there is nothing to compare: a volume of nothing, or one without end.
pub(super) fn ratio(found: f64, exact: f64) -> Option<f64> {
    Some(found / exact).filter(|ratio| ratio.is_finite() && *ratio > 0.0)
}

/// Bounds the scene at all values, whole numbers, of a parameter.
pub(super) fn samples(loaded: &Loaded, sweep: &Sweep, max_steps: u64) -> Result<Samples, Failure> {
    let values = sweep.values(VALUES);
    let bar = Bar::new(values.len() as u64);
    let mut found = Samples { samples: Vec::new(), left_out: Vec::new() };
    for (done, value) in values.iter().copied().enumerate() {
        match analysed(loaded, &sweep.name, value)? {
            Some((varied, analysis)) => {
                let run = |method| Run::new(method, &varied, &analysis, max_steps);
                let runs = [run(MethodArg::Conventional)?, run(MethodArg::Chain)?, run(MethodArg::Exact)?];
                found.samples.push(Sample { value, analysis, runs });
            }
            None => found.left_out.push(value),
        }
        bar.show(done as u64 + 1);
    }
    match found.left_out.first() {
        // The first mistake stands for all.
        Some(value) if found.samples.is_empty() => {
            let varied = loaded.varied(&sweep.name, value).map_err(|mistakes| loaded.mistakes(&mistakes))?;
            if varied.analyse_unless_endless()?.is_none() {
                return Err(loaded.refused("a recursion that never ends has no depth to draw; see --compare"));
            }
            Ok(found)
        }
        _ => Ok(found),
    }
}

/// The scene at one value, or `None` where it has mistakes. Too many states are a failure: they may take long, and other
/// values will hardly have fewer.
fn analysed(loaded: &Loaded, name: &str, value: i32) -> Result<Option<(Loaded, Analysis)>, Failure> {
    let Ok(varied) = loaded.varied(name, value) else { return Ok(None) };
    match varied.scene.graph.analyse(&varied.limits) {
        Ok(analysis) => Ok(Some((varied, analysis))),
        Err(error @ StatesError::TooMany { .. }) => Err(varied.failure_to_list(&error)),
        Err(_) => Ok(None),
    }
}

/// The parameter that counts a recursion down, from 0 to its value: of all that are whole, above zero, and set to one
/// less by some C-node, the largest.
pub(super) fn guess(graph: &Graph) -> Option<Sweep> {
    let initial = graph.initial();
    let counters = graph.nodes().filter_map(|(_, node)| match node {
        Node::Calculation(calculation) => Some(&calculation.assignments),
        _ => None,
    });
    let counters = counters.flatten().filter_map(|(param, expr)| {
        let value = initial.get(*param)?;
        let counts =
            expr.params().all(|read| read == *param) && is_close(expr.evaluate(initial), value - 1.0);
        let last = whole(value).filter(|value| *value > 0)?;
        counts.then_some((*param, last))
    });
    // Of equals the one that is declared first.
    let (param, last) = counters.max_by_key(|(param, last)| (*last, std::cmp::Reverse(param.index())))?;
    Some(Sweep { name: graph.param_name(param).to_owned(), first: 0, last })
}

fn is_close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

fn whole(value: f64) -> Option<i32> {
    // Written out, a number has no point only if it is whole.
    value.to_string().parse().ok()
}
