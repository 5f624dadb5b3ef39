//! `pcsg bounds`: the hyper bounding boxes of all nodes.

use std::fmt::Write;
use std::time::Instant;

use csg_graph::{Analysis, BigUint, Graph, Node, NodeId};
use csg_graph_bounds::{Aabb, BoundsError, ExactBoxes, HyperBoxes, Limits, chain, conventional, exact};
use glam::DVec3;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::args::{BoundsArgs, Format, MethodArg};
use crate::load::{Loaded, load};
use crate::progress::Spinner;
use crate::{Failure, print};

/// What `bounds --format json` prints. Coordinates without a number are null: an unbounded side, or an empty box.
#[derive(Serialize)]
struct Report {
    scene: String,
    method: &'static str,
    root: Corners,
    nodes: Vec<NodeBox>,
    #[serde(flatten)]
    exact: Option<ExactReport>,
    seconds: f64,
}

/// What is known of exact boxes besides.
#[derive(Serialize)]
struct ExactReport {
    gap: f64,
    states: Vec<StateBox>,
    counts: Counts,
}

#[derive(Serialize)]
struct Counts {
    states: usize,
    solids: usize,
    queries: u64,
    expansions: u64,
}

#[derive(Serialize)]
struct StateBox {
    symbol: String,
    params: Map<String, Value>,
    #[serde(flatten)]
    corners: Corners,
}

#[derive(Serialize)]
struct NodeBox {
    id: usize,
    kind: &'static str,
    name: String,
    #[serde(flatten)]
    corners: Corners,
}

#[derive(Serialize)]
struct Corners {
    min: [f64; 3],
    max: [f64; 3],
}

impl From<Aabb> for Corners {
    fn from(aabb: Aabb) -> Self {
        Self { min: aabb.min.to_array(), max: aabb.max.to_array() }
    }
}

/// Steps of an algorithm that take longer than one waits without a sign of life: a second or so.
const LONG: u32 = 3_000_000;

/// Refuses work that is known to be too much, before it is begun.
pub(crate) fn refuse_more_than(
    max_steps: u64,
    work: &BigUint,
    loaded: &Loaded,
    what: &str,
) -> Result<(), Failure> {
    if *work <= BigUint::from(max_steps) {
        return Ok(());
    }
    let digits = work.to_string();
    let shown = if digits.len() <= 30 { digits } else { format!("about 10^{}", digits.len() - 1) };
    Err(loaded.refused(format!(
        "{what}: {shown} steps, and --max-steps allows {max_steps}; use the exact boxes, let the recursion end earlier, \
         or raise --max-steps"
    )))
}

/// The hyper boxes of a scene by one of the algorithms.
pub(crate) fn hyper_boxes(
    method: MethodArg,
    loaded: &Loaded,
    analysis: &Analysis,
    max_steps: u64,
) -> Result<HyperBoxes, Failure> {
    let graph = &loaded.scene.graph;
    // The work is known beforehand; the algorithms need not count it once more.
    let limits = loaded.bounds_limits().with_steps(u64::MAX);
    let sign_of_life = |work: &BigUint| (*work > BigUint::from(LONG)).then(|| Spinner::new("bounding"));
    let boxes = match method {
        MethodArg::Conventional => {
            let work = &analysis.instances;
            let what = "the conventional algorithm visits every node of the unfolded tree";
            refuse_more_than(max_steps, work, loaded, what)?;
            let _spinner = sign_of_life(work);
            conventional(graph, &limits)
        }
        MethodArg::Chain => {
            let work = &analysis.chain_boxes;
            let what = "the chain algorithm computes a box for each transformation above each primitive";
            refuse_more_than(max_steps, work, loaded, what)?;
            let _spinner = sign_of_life(work);
            chain(graph, &limits)
        }
        MethodArg::Exact => exact(graph, &limits).map(ExactBoxes::into_hyper_boxes),
    };
    boxes.map_err(|error| failure(loaded, error))
}

/// Why an algorithm found no boxes.
pub(crate) fn failure(loaded: &Loaded, error: BoundsError<csg_graph::EvalError>) -> Failure {
    match error {
        BoundsError::Scene(error) => loaded.failure(&error.into()),
        error => loaded.refused(error),
    }
}

pub(crate) fn run(args: &BoundsArgs) -> Result<(), Failure> {
    let loaded = load(&args.scene)?;
    let analysis = loaded.analyse()?;
    let graph = &loaded.scene.graph;
    let start = Instant::now();
    let (boxes, exact) = match args.method {
        MethodArg::Exact => {
            let exact = exact(graph, &tolerant(loaded.bounds_limits(), args.tolerance));
            let exact = exact.map_err(|error| failure(&loaded, error))?;
            let report = ExactReport::new(graph, &exact);
            (exact.into_hyper_boxes(), Some(report))
        }
        method => (hyper_boxes(method, &loaded, &analysis, args.limit.max_steps)?, None),
    };
    let seconds = start.elapsed().as_secs_f64();
    print(match args.format {
        Format::Table => table(graph, &boxes, args.method, exact.as_ref(), seconds),
        Format::Json => {
            let node = |(id, node): (NodeId, &Node)| NodeBox {
                id: id.index(),
                kind: node.kind(),
                name: graph.node_name(id),
                corners: boxes.nodes[id.index()].into(),
            };
            let report = Report {
                scene: loaded.name.clone(),
                method: args.method.name(),
                root: boxes.root.into(),
                nodes: graph.nodes().map(node).collect(),
                exact,
                seconds,
            };
            serde_json::to_string_pretty(&report).expect("a report has only strings and numbers") + "\n"
        }
    })
}

fn tolerant(limits: Limits, tolerance: Option<f64>) -> Limits {
    tolerance.map_or(limits, |tolerance| limits.with_gap(tolerance))
}

impl ExactReport {
    fn new(graph: &Graph, exact: &ExactBoxes<Graph>) -> Self {
        let symbols = exact.states().filter(|(state, _)| matches!(graph.node(state.node()), Node::Symbol(_)));
        let state_box = |(state, found): (&csg_graph::State, csg_graph_bounds::StateBox)| StateBox {
            symbol: graph.node_name(state.node()),
            params: graph.live_values(state).into_iter().map(|(name, value)| (name, value.into())).collect(),
            corners: found.aabb.into(),
        };
        let counts = &exact.counts;
        Self {
            gap: exact.gap,
            states: symbols.map(state_box).collect(),
            counts: Counts {
                states: counts.states,
                solids: counts.solids,
                queries: counts.queries,
                expansions: counts.expansions,
            },
        }
    }
}

fn table(
    graph: &Graph,
    boxes: &HyperBoxes,
    method: MethodArg,
    exact: Option<&ExactReport>,
    seconds: f64,
) -> String {
    let mut text = format!("{} boxes in {seconds:.3} s; the whole: {}\n", method.name(), corners(boxes.root));
    if let Some(ExactReport { gap, counts, .. }) = exact {
        let Counts { states, queries, expansions, .. } = counts;
        let _ = writeln!(
            text,
            "{states} states, {queries} queries, {expansions} expansions; no gap above {gap:.1e}"
        );
    }
    let name_width = graph.nodes().map(|(id, _)| graph.node_name(id).chars().count()).max().unwrap_or(0);
    for (id, node) in graph.nodes() {
        let name = graph.node_name(id);
        let kind = node.kind();
        let shown = corners(boxes.nodes[id.index()]);
        let _ = writeln!(text, "{:>5}  {kind:<12}  {name:<name_width$}  {shown}", id.index());
    }
    text
}

fn corners(aabb: Aabb) -> String {
    if aabb.is_empty() {
        return "empty".to_owned();
    }
    let point = |p: DVec3| {
        // Rounding to four places may leave −0.
        let [x, y, z] = p.to_array().map(|c| if c.abs() < 5e-5 { 0.0 } else { c });
        format!("[{x:>9.4}, {y:>9.4}, {z:>9.4}]")
    };
    format!("{} .. {}", point(aabb.min), point(aabb.max))
}
