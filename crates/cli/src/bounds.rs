//! `pcsg bounds`: the hyper bounding boxes of all nodes.

use std::fmt::Write;
use std::time::Instant;

use csg_graph::{Analysis, BigUint, Graph};
use csg_graph_bounds::{Aabb, HyperBoxes, chain, conventional};
use glam::DVec3;
use serde::Serialize;

use crate::args::{BoundsArgs, Format, MethodArg};
use crate::load::{Loaded, load};
use crate::{Failure, print};

/// What `bounds --format json` prints. Coordinates without a number are null: an unbounded side, or an empty box.
#[derive(Serialize)]
struct Report {
    scene: String,
    method: &'static str,
    root: Corners,
    nodes: Vec<NodeBox>,
    seconds: f64,
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

impl MethodArg {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Conventional => "conventional",
            Self::Chain => "chain",
        }
    }

    /// Runs the algorithm; one that is known to take more than `max_steps` is not begun.
    pub(crate) fn compute(
        self,
        loaded: &Loaded,
        analysis: &Analysis,
        max_steps: u64,
    ) -> Result<HyperBoxes, Failure> {
        let (work, what) = match self {
            Self::Conventional => (&analysis.instances, "visits every node of the unfolded tree"),
            Self::Chain => {
                (&analysis.chain_boxes, "computes a box for every transformation above every primitive")
            }
        };
        if *work > BigUint::from(max_steps) {
            return Err(loaded.refused(format!(
                "the {} algorithm {what}: {work} steps, and --max-steps allows {max_steps}; let the recursion end earlier, \
                 try another method, or raise --max-steps",
                self.name()
            )));
        }
        // The walk counts nodes and boxes together, which is at most a few times the work.
        let limits = csg_graph_bounds::Limits::default().with_steps(max_steps.saturating_mul(4));
        let graph = &loaded.scene.graph;
        let boxes = match self {
            Self::Conventional => conventional(graph, &limits),
            Self::Chain => chain(graph, &limits),
        };
        boxes.map_err(|error| loaded.refused(error))
    }
}

pub(crate) fn run(args: &BoundsArgs) -> Result<(), Failure> {
    let loaded = load(&args.scene)?;
    let analysis = loaded.analyse()?;
    let graph = &loaded.scene.graph;
    let start = Instant::now();
    let boxes = args.method.compute(&loaded, &analysis, args.limit.max_steps)?;
    let seconds = start.elapsed().as_secs_f64();
    print(match args.format {
        Format::Table => table(graph, &boxes, args.method, seconds),
        Format::Json => {
            let node = |(id, node): (csg_graph::NodeId, &csg_graph::Node)| NodeBox {
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
                seconds,
            };
            serde_json::to_string_pretty(&report).expect("a report has only strings and numbers") + "\n"
        }
    })
}

fn table(graph: &Graph, boxes: &HyperBoxes, method: MethodArg, seconds: f64) -> String {
    let mut text = format!("{} boxes in {seconds:.3} s; the whole: {}\n", method.name(), corners(boxes.root));
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
    let point = |p: DVec3| format!("[{:>9.4}, {:>9.4}, {:>9.4}]", p.x, p.y, p.z);
    format!("{} .. {}", point(aabb.min), point(aabb.max))
}
