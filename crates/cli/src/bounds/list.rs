//! The volumes of a scene by one method: of the whole, of all nodes, and of all states.

use std::fmt::Write;
use std::time::Instant;

use csg_graph::{Graph, Node, NodeId, State};
use csg_graph_bounds::{
    Aabb, CellCounts, Endless, ExactBoxes, HyperBoxes, Obb, Refinement, Slabs, SolidBox, Sphere,
};
use serde::Serialize;
use serde_json::{Map, Value};

use super::instances::Instances;
use super::methods::{self, hyper_boxes};
use super::volume::{Entry, Shown, line};
use crate::args::{BooleansArg, BoundsArgs, Format, MethodArg, VolumeArg};
use crate::load::Loaded;
use crate::progress::Spinner;
use crate::text::{self, json, push_table};
use crate::{Failure, print};

/// What was found.
struct Found<V> {
    root: V,
    nodes: Vec<V>,
    /// Those of the states of symbols, if they were asked for.
    states: Option<Vec<StateVolume<V>>>,
    exact: Option<ExactFacts>,
    /// Of a search: the gap of the root, and what it took.
    search: Option<(f64, CellCounts)>,
    /// How much larger than the least one the volume of the root is at most, if it is not the least one.
    excess: Option<f64>,
    seconds: f64,
}

/// The volume of a state, which has a number among all states.
struct StateVolume<V> {
    id: usize,
    state: State,
    volume: V,
}

/// What is known of exact volumes besides.
struct ExactFacts {
    gap: f64,
    counts: csg_graph_bounds::Counts,
    endless: Option<Endless>,
}

/// What `--format json` prints. Coordinates without a number are null: an unbounded side, or an empty volume.
#[derive(Serialize)]
struct Report {
    scene: String,
    method: &'static str,
    volume: &'static str,
    booleans: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    directions: Option<Vec<[f64; 3]>>,
    root: Entry,
    nodes: Vec<NodeEntry>,
    #[serde(flatten)]
    exact: Option<ExactReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    search: Option<SearchReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    excess: Option<f64>,
    seconds: f64,
}

/// What branch and bound of the root came to, and what it took.
#[derive(Serialize)]
struct SearchReport {
    gap: f64,
    cells: u64,
    points: u64,
    opened: u64,
}

#[derive(Serialize)]
struct ExactReport {
    gap: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    contraction: Option<f64>,
    states: Vec<StateEntry>,
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
struct StateEntry {
    id: usize,
    symbol: String,
    params: Map<String, Value>,
    #[serde(flatten)]
    volume: Entry,
}

#[derive(Serialize)]
struct NodeEntry {
    id: usize,
    kind: &'static str,
    name: String,
    #[serde(flatten)]
    volume: Entry,
}

pub(super) fn run(args: &BoundsArgs, loaded: &Loaded) -> Result<(), Failure> {
    let analysis = loaded.analyse_unless_endless()?;
    let method = args.method.unwrap_or_else(|| {
        if analysis.is_none() || only_exact(args).is_some() { MethodArg::Exact } else { MethodArg::Chain }
    });
    if method == MethodArg::Exact {
        return match args.volume {
            VolumeArg::Aabb if args.booleans == BooleansArg::Context => run_context(args, loaded),
            _ if args.booleans == BooleansArg::Context => Err(Failure::Usage(format!(
                "S-bounds are axis-aligned boxes; leave out --volume {} or --booleans context",
                args.volume.name()
            ))),
            VolumeArg::Aabb => run_exact::<Aabb>(args, loaded),
            VolumeArg::Sphere => run_exact::<Sphere>(args, loaded),
            VolumeArg::Slab6 => run_exact::<Slabs<3>>(args, loaded),
            VolumeArg::Slab14 => run_exact::<Slabs<7>>(args, loaded),
            VolumeArg::Slab18 => run_exact::<Slabs<9>>(args, loaded),
            VolumeArg::Slab26 => run_exact::<Slabs<13>>(args, loaded),
            VolumeArg::Obb => run_exact::<Obb>(args, loaded),
        };
    }
    let name = method.name();
    if let Some(what) = only_exact(args) {
        return Err(Failure::Usage(format!(
            "{what} is for the exact method, and the {name} one makes axis-aligned boxes of nodes only; leave out \
             --method {name}"
        )));
    }
    let Some(analysis) = analysis else {
        return Err(loaded.refused(format!(
            "the recursion never ends, and the {name} algorithm walks all that it unfolds into; --method exact bounds \
             what shrinks as it recurses"
        )));
    };
    let start = Instant::now();
    let HyperBoxes { root, nodes, .. } = hyper_boxes(method, loaded, &analysis, args.limit.once())?;
    let seconds = start.elapsed().as_secs_f64();
    show(
        args,
        loaded,
        method,
        &Found { root, nodes, states: None, exact: None, search: None, excess: None, seconds },
    )
}

/// An argument that the other methods have no use for.
fn only_exact(args: &BoundsArgs) -> Option<String> {
    if args.volume != VolumeArg::Aabb {
        Some(format!("--volume {}", args.volume.name()))
    } else if args.booleans != BooleansArg::Algebra {
        Some(format!("--booleans {}", args.booleans.name()))
    } else if args.states {
        Some("--states".to_owned())
    } else {
        args.tolerance.map(|_| "--tolerance".to_owned())
    }
}

fn run_exact<V: Shown>(args: &BoundsArgs, loaded: &Loaded) -> Result<(), Failure> {
    let graph = &loaded.scene.graph;
    let spinner = Spinner::new("bounding");
    let start = Instant::now();
    let exact = exact_boxes(args, loaded)?;
    let with_states = args.states || args.format == Format::Json;
    let of_volumes = args.tolerance.filter(|_| args.booleans == BooleansArg::Algebra);
    let mut found = Found::<V>::about(graph, &exact, of_volumes, with_states);
    if args.booleans == BooleansArg::Search {
        let mut search = exact.root_solid(&refinement(args.tolerance));
        let SolidBox { aabb, gap, .. } = search.aabb();
        (found.root, found.excess) = V::certified(aabb, None, |direction| search.support(direction).upper);
        found.search = Some((gap, search.counts()));
    }
    found.seconds = start.elapsed().as_secs_f64();
    drop(spinner);
    show(args, loaded, MethodArg::Exact, &found)
}

/// S-bounds in place of the boxes.
fn run_context(args: &BoundsArgs, loaded: &Loaded) -> Result<(), Failure> {
    let graph = &loaded.scene.graph;
    let start = Instant::now();
    let exact = exact_boxes(args, loaded)?;
    let with_states = args.states || args.format == Format::Json;
    let mut found = Found::<Aabb>::about(graph, &exact, None, with_states);
    let contexts = exact.s_bounds(graph);
    for StateVolume { state, volume, .. } in found.states.iter_mut().flatten() {
        *volume = contexts.context_of(state).unwrap_or(Aabb::EMPTY);
    }
    let seconds = start.elapsed().as_secs_f64();
    let found = Found { root: contexts.root, nodes: contexts.contexts.clone(), seconds, ..found };
    show(args, loaded, MethodArg::Exact, &found)
}

/// The exact boxes, to the tolerance unless that is for something else.
fn exact_boxes(args: &BoundsArgs, loaded: &Loaded) -> Result<ExactBoxes<Graph>, Failure> {
    let limits = loaded.bounds_limits();
    let is_for_boxes = args.volume != VolumeArg::Sphere && args.booleans != BooleansArg::Search;
    let gap = args.tolerance.filter(|_| is_for_boxes).unwrap_or(limits.gap);
    methods::exact_boxes(loaded, &limits.with_gap(gap))
}

/// How far a search goes.
pub(super) fn refinement(tolerance: Option<f64>) -> Refinement {
    let usual = Refinement::default();
    tolerance.map_or(usual, |tolerance| usual.with_tolerance(tolerance))
}

impl<V: Shown> Found<V> {
    /// The volumes about exact supports.
    fn about(graph: &Graph, exact: &ExactBoxes<Graph>, tolerance: Option<f64>, with_states: bool) -> Self {
        let instances = Instances::new(exact);
        let of_state = |state: &State, aabb| V::about(aabb, tolerance, |d| instances.of_state(state, d));
        let of_node = |(id, _): (NodeId, &Node)| {
            V::about(exact.nodes[id.index()], tolerance, |d| instances.of_node(id, d))
        };
        let states = || {
            let all = exact.states().enumerate();
            let symbols = all.filter(|(_, (state, _))| matches!(graph.node(state.node()), Node::Symbol(_)));
            symbols
                .map(|(id, (state, found))| {
                    let volume = of_state(state, found.aabb);
                    StateVolume { id, state: state.clone(), volume }
                })
                .collect()
        };
        let facts = ExactFacts { gap: exact.gap, counts: exact.counts, endless: exact.endless };
        let root = graph.root_state();
        let (root, excess) = V::certified(exact.root, tolerance, |d| instances.of_state(&root, d));
        Self {
            root,
            nodes: graph.nodes().map(of_node).collect(),
            states: with_states.then(states),
            exact: Some(facts),
            search: None,
            excess,
            seconds: 0.0,
        }
    }
}

fn show<V: Shown>(
    args: &BoundsArgs,
    loaded: &Loaded,
    method: MethodArg,
    found: &Found<V>,
) -> Result<(), Failure> {
    print(match args.format {
        Format::Table => table(args, &loaded.scene.graph, method, found),
        Format::Json => json(&report(args, loaded, method, found)),
    })
}

fn report<V: Shown>(args: &BoundsArgs, loaded: &Loaded, method: MethodArg, found: &Found<V>) -> Report {
    let graph = &loaded.scene.graph;
    let nodes = graph.nodes().zip(&found.nodes).map(|((id, node), volume)| NodeEntry {
        id: id.index(),
        kind: node.kind(),
        name: graph.node_name(id),
        volume: Entry::new(volume),
    });
    let states = found.states.iter().flatten().map(|StateVolume { id, state, volume }| StateEntry {
        id: *id,
        symbol: graph.node_name(state.node()),
        params: graph.live_values(state).into_iter().map(|(name, value)| (name, value.into())).collect(),
        volume: Entry::new(volume),
    });
    let exact = found.exact.as_ref().map(|facts| ExactReport {
        gap: facts.gap,
        contraction: facts.endless.map(|endless| endless.contraction),
        states: states.collect(),
        counts: Counts {
            states: facts.counts.states,
            solids: facts.counts.solids,
            queries: facts.counts.queries,
            expansions: facts.counts.expansions,
        },
    });
    let directions = V::DIRECTIONS.iter().map(|direction| direction.to_array());
    Report {
        scene: loaded.name.clone(),
        method: method.name(),
        volume: args.volume.name(),
        booleans: args.booleans.name(),
        directions: (!V::DIRECTIONS.is_empty()).then(|| directions.collect()),
        root: Entry::new(&found.root),
        nodes: nodes.collect(),
        exact,
        search: found.search.map(|(gap, CellCounts { cells, points, opened, .. })| SearchReport {
            gap,
            cells,
            points,
            opened,
        }),
        excess: found.excess,
        seconds: found.seconds,
    }
}

fn table<V: Shown>(args: &BoundsArgs, graph: &Graph, method: MethodArg, found: &Found<V>) -> String {
    let is_context = args.booleans == BooleansArg::Context;
    let kind = if is_context { "S-bounds".to_owned() } else { V::kind() };
    let Found { root, seconds, .. } = found;
    let mut text =
        format!("{} {} in {}; the whole: {}\n", method.name(), kind, text::seconds(*seconds), line(root));
    let _ = writeln!(text, "volume {:.6}, surface area {:.6}", root.volume(), root.surface_area());
    if let Some(ExactFacts { gap, counts, .. }) = &found.exact {
        let (states, queries, expansions) = (counts.states, counts.queries, counts.expansions);
        let _ = writeln!(
            text,
            "{states} states, {queries} queries, {expansions} expansions; no gap above {gap:.1e}"
        );
    }
    if let Some(Endless { states, contraction, .. }) = found.exact.as_ref().and_then(|facts| facts.endless) {
        let _ = writeln!(
            text,
            "endless: {states} states lead back to themselves, and shrink to at most {contraction:.6} each time round"
        );
    }
    if let Some((gap, CellCounts { cells, points, .. })) = found.search {
        let _ = writeln!(text, "the whole by search: {cells} cells, {points} points; its gap is {gap:.1e}");
    }
    if let Some(excess) = found.excess {
        let _ = writeln!(text, "the radius of the whole is at most {excess:.1e} larger than the least one");
    }
    let size = |volume: &V| [volume.volume(), volume.surface_area()].map(|size| format!("{size:.6}"));
    let node = |((id, node), found): ((NodeId, &Node), &V)| {
        let [volume, area] = size(found);
        [id.index().to_string(), node.kind().to_owned(), graph.node_name(id), volume, area, line(found)]
    };
    let rows: Vec<_> = graph.nodes().zip(&found.nodes).map(node).collect();
    text.push('\n');
    let heads = ["node", "kind", "name", "volume", "surface", &kind];
    push_table(&mut text, heads, [true, false, false, true, true, false], &rows);
    if let Some(states) = &found.states {
        let state = |StateVolume { id, state, volume: found }: &StateVolume<V>| {
            let params =
                graph.live_values(state).into_iter().map(|(name, value)| format!("{name} = {value}"));
            let [volume, area] = size(found);
            let name = graph.node_name(state.node());
            [id.to_string(), name, params.collect::<Vec<_>>().join(", "), volume, area, line(found)]
        };
        let rows: Vec<_> = states.iter().map(state).collect();
        text.push('\n');
        let heads = ["state", "symbol", "parameters", "volume", "surface", &kind];
        push_table(&mut text, heads, [true, false, false, true, true, false], &rows);
    }
    text
}
