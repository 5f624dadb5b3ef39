//! `pcsg bounds --compare`: what each method and each volume costs and gives, relative to the exact boxes.

use std::time::Instant;

use csg_graph::{Analysis, BigUint, Graph, Node, NodeId, Operator};
use csg_graph_bounds::{Aabb, ExactBoxes, Obb, Slabs, Sphere};
use serde::Serialize;

use super::instances::Instances;
use super::list::refinement;
use super::methods::{boxes_to_compute, exact_boxes};
use super::sweep::{Run, ratio};
use super::volume::Shown;
use crate::args::{BooleansArg, BoundsArgs, Format, MethodArg, VolumeArg};
use crate::load::Loaded;
use crate::progress::Spinner;
use crate::text::{json, push_table, seconds, short};
use crate::{Failure, print};

/// With more states than this, other volumes than boxes are made for the whole only: a node's takes a query a state and
/// direction.
const FEW_STATES: usize = 5_000;

/// What `--format json` prints.
#[derive(Serialize)]
struct Report {
    scene: String,
    rows: Vec<Row>,
}

/// A method with a volume. The time is that of all its volumes and of what they are made from; ratios are to the exact
/// boxes, and null where that is nothing or without end.
#[derive(Serialize)]
struct Row {
    method: &'static str,
    volume: &'static str,
    boxes: Option<String>,
    seconds: Option<f64>,
    root_volume_ratio: Option<f64>,
    root_area_ratio: Option<f64>,
    /// The geometric mean over all nodes.
    nodes_area_ratio: Option<f64>,
    /// Why it was not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    not_run: Option<String>,
}

/// What all are compared with.
struct Exact {
    boxes: ExactBoxes<Graph>,
    seconds: f64,
}

pub(super) fn run(args: &BoundsArgs, loaded: &Loaded) -> Result<(), Failure> {
    let analysis = loaded.analyse_unless_endless()?;
    let _spinner = Spinner::new("comparing");
    let start = Instant::now();
    let boxes = exact_boxes(loaded, &loaded.bounds_limits())?;
    let exact = Exact { boxes, seconds: start.elapsed().as_secs_f64() };

    let mut rows = Vec::new();
    for method in [MethodArg::Conventional, MethodArg::Chain] {
        rows.push(row_of_method(method, loaded, analysis.as_ref(), args.limit.each(), &exact)?);
    }
    let graph = &loaded.scene.graph;
    rows.push(row_of_volume::<Aabb>(VolumeArg::Aabb, graph, args.tolerance, &exact));
    rows.push(row_of_volume::<Slabs<7>>(VolumeArg::Slab14, graph, args.tolerance, &exact));
    rows.push(row_of_volume::<Slabs<9>>(VolumeArg::Slab18, graph, args.tolerance, &exact));
    rows.push(row_of_volume::<Slabs<13>>(VolumeArg::Slab26, graph, args.tolerance, &exact));
    rows.push(row_of_volume::<Sphere>(VolumeArg::Sphere, graph, args.tolerance, &exact));
    rows.push(row_of_volume::<Obb>(VolumeArg::Obb, graph, args.tolerance, &exact));
    rows.extend(rows_of_booleans(graph, args.tolerance, &exact));
    print(match args.format {
        Format::Table => table(&rows),
        Format::Json => json(&Report { scene: loaded.name.clone(), rows }),
    })
}

fn row_of_method(
    method: MethodArg,
    loaded: &Loaded,
    analysis: Option<&Analysis>,
    max_steps: u64,
    exact: &Exact,
) -> Result<Row, Failure> {
    let boxes = analysis.map(|analysis| boxes_to_compute(method, analysis));
    let run = analysis.map(|analysis| Run::new(method, loaded, analysis, max_steps)).transpose()?.flatten();
    let row = Row {
        method: method.name(),
        volume: VolumeArg::Aabb.name(),
        boxes: boxes.as_ref().map(BigUint::to_string),
        seconds: None,
        root_volume_ratio: None,
        root_area_ratio: None,
        nodes_area_ratio: None,
        not_run: None,
    };
    Ok(match (run, boxes) {
        (Some(Run { root, nodes, seconds }), _) => {
            Row { seconds: Some(seconds), ..row.compared(&root, Some(&nodes), exact) }
        }
        (None, Some(_)) => Row { not_run: Some(format!("beyond --max-steps {max_steps}")), ..row },
        (None, None) => Row { not_run: Some("the recursion never ends".to_owned()), ..row },
    })
}

fn row_of_volume<V: Shown>(kind: VolumeArg, graph: &Graph, tolerance: Option<f64>, exact: &Exact) -> Row {
    let boxes = &exact.boxes;
    let start = Instant::now();
    let instances = Instances::new(boxes);
    let root_state = graph.root_state();
    let root = V::about(boxes.root, tolerance, |d| instances.of_state(&root_state, d));
    let of_node = |id: NodeId| V::about(boxes.nodes[id.index()], tolerance, |d| instances.of_node(id, d));
    let few = kind == VolumeArg::Aabb || boxes.counts.states <= FEW_STATES;
    let nodes: Option<Vec<V>> = few.then(|| graph.nodes().map(|(id, _)| of_node(id)).collect());
    let row = Row {
        method: MethodArg::Exact.name(),
        volume: kind.name(),
        boxes: Some(boxes.counts.states.to_string()),
        seconds: Some(exact.seconds + start.elapsed().as_secs_f64()),
        root_volume_ratio: None,
        root_area_ratio: None,
        nodes_area_ratio: None,
        not_run: None,
    };
    row.compared(&root, nodes.as_deref(), exact)
}

/// The whole by S-bounds and by search, where there is an ∩ or a \ that could make a difference.
fn rows_of_booleans(graph: &Graph, tolerance: Option<f64>, exact: &Exact) -> Vec<Row> {
    let differs = |node: &Node| matches!(node, Node::Operator(node) if node.operator != Operator::Union);
    if !graph.nodes().any(|(_, node)| differs(node)) {
        return Vec::new();
    }
    let of_root = |booleans: BooleansArg, aabb: Aabb, start: Instant| {
        let seconds = Some(exact.seconds + start.elapsed().as_secs_f64());
        Row {
            method: booleans.name(),
            boxes: None,
            seconds,
            ..row_of_volume::<Aabb>(VolumeArg::Aabb, graph, None, exact)
        }
        .compared(&aabb, None, exact)
    };
    let start = Instant::now();
    let context = of_root(BooleansArg::Context, exact.boxes.s_bounds(graph).root, start);
    let start = Instant::now();
    let solid = exact.boxes.root_solid(&refinement(tolerance)).aabb().aabb;
    vec![context, of_root(BooleansArg::Search, solid, start)]
}

impl Row {
    fn compared<V: Shown>(self, root: &V, nodes: Option<&[V]>, exact: &Exact) -> Self {
        let boxes = &exact.boxes;
        Self {
            root_volume_ratio: ratio(root.volume(), boxes.root.volume()),
            root_area_ratio: ratio(root.surface_area(), boxes.root.surface_area()),
            nodes_area_ratio: nodes.and_then(|nodes| mean_ratio(nodes, &boxes.nodes)),
            ..self
        }
    }
}

/// The geometric mean of the ratios of surface areas, where there are any.
fn mean_ratio<V: Shown>(found: &[V], exact: &[Aabb]) -> Option<f64> {
    let ratios = found.iter().zip(exact).filter_map(|(a, b)| ratio(a.surface_area(), b.surface_area()));
    let (sum, count) = ratios.fold((0.0, 0.0), |(sum, count), ratio| (sum + libm::log(ratio), count + 1.0));
    (count > 0.0).then(|| libm::exp(sum / count))
}

fn table(rows: &[Row]) -> String {
    let mut text = String::from("ratios are to the exact boxes\n\n");
    let heads = ["method", "volume", "boxes", "time", "root volume", "root surface", "nodes' surface", ""];
    let shown = |ratio: Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.3}"));
    let row = |row: &Row| {
        [
            row.method.to_owned(),
            row.volume.to_owned(),
            row.boxes.as_ref().map_or("-".to_owned(), short),
            row.seconds.map_or("-".to_owned(), seconds),
            shown(row.root_volume_ratio),
            shown(row.root_area_ratio),
            shown(row.nodes_area_ratio),
            row.not_run.as_ref().map_or_else(String::new, |why| format!("not run: {why}")),
        ]
    };
    let rows: Vec<_> = rows.iter().map(row).collect();
    push_table(&mut text, heads, [false, false, true, true, true, true, true, false], &rows);
    text
}
