//! What is measured, and what is found by looking into everything.

use std::sync::Arc;

use csg_graph::{Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use glam::DVec3;

use super::lines::Throws;
use super::*;
use crate::fast::Accelerated;
use crate::fast::bounds::Bounds;

/// A primitive in places, each of half the size of all, and so on, n times.
fn fractal(n: f64, kind: PrimitiveKind, places: &[[f64; 3]]) -> Graph {
    let mut builder = GraphBuilder::new();
    let primitive = builder.primitive(kind, []);
    let symbol = recursion(&mut builder, n, primitive, places);
    builder.finish(symbol).unwrap()
}

/// The symbol of such a fractal.
fn recursion(builder: &mut GraphBuilder, n: f64, primitive: NodeId, places: &[[f64; 3]]) -> NodeId {
    let n = builder.param("n", n);
    let symbol = builder.symbol("X");
    let parts: Vec<NodeId> = places
        .iter()
        .map(|place| {
            let smaller = builder.transform(TransformKind::UScale, [Expr::from(0.5)], symbol);
            builder.transform(TransformKind::Move, place.map(Expr::from), smaller)
        })
        .collect();
    let all = union(builder, parts);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], all);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [rest, primitive]);
    symbol
}

fn union(builder: &mut GraphBuilder, parts: Vec<NodeId>) -> NodeId {
    parts.into_iter().reduce(|one, other| builder.operator(Operator::Union, one, other)).unwrap()
}

const BUDGET: usize = Accelerated::DEFAULT_BUDGET;

const TETRAHEDRON: [[f64; 3]; 4] = [[0.5, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];

/// What is measured of a graph that is compiled into some memory, and the first node of its root.
fn survey(graph: &Graph, budget: usize) -> (Surveyed, usize) {
    let boxes = exact(graph, &Limits::default()).unwrap();
    let whole = Compiled::whole(graph, Bounds::Exact(&boxes), budget).unwrap().with_parts();
    let root = whole.root_node(0).unwrap();
    (Blocks::Whole { graph: graph.clone(), block: Arc::new(whole) }.survey(Level::new()), root)
}

/// What is measured of the root of a graph in each direction, and what rays that look into everything find there.
fn compare(graph: &Graph, budget: usize) -> Vec<[f64; 2]> {
    let (found, root) = survey(graph, budget);
    let boxes = exact(graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(graph, &boxes, budget).unwrap();
    let mut tracer = scene.tracer();
    let mut dice = Dice::at(DVec3::ONE);
    let mut stopped = |cell: usize| {
        let throws = Throws::new(&mut dice);
        let mut tally = Tally::default();
        for number in 0..1000 {
            let (line, weight) = throws.line(&found.bounds[root], cell, number);
            tally.add(weight, f64::from(u8::from(tracer.occluded(&line, f64::INFINITY))));
        }
        tally.mean()
    };
    (0..CELLS).map(|cell| [f64::from(found.nodes[root].cells[cell]), stopped(cell)]).collect()
}

#[test]
fn covers_are_what_rays_find_at_any_depth() {
    // With much memory there are so many nodes that few lines are left for each.
    for (n, budget) in [(4, BUDGET), (12, BUDGET), (24, BUDGET), (40, BUDGET), (24, 1 << 24)] {
        let cells = compare(&fractal(f64::from(n), PrimitiveKind::Sphere, &TETRAHEDRON), budget);
        let [mut covers, mut found] = [0.0; 2];
        for (cell, [cover, stopped]) in cells.iter().enumerate() {
            // The centre of each face of the cube: along its axes a tetrahedron of any depth stops all.
            if cell % 9 != 4 {
                assert!((cover - stopped).abs() < 0.4 * stopped, "{n}, {cell}: {cover} of {stopped}");
                covers += cover;
                found += stopped;
            }
        }
        assert!((covers - found).abs() < 0.15 * found, "{n}: {covers} of {found}");
    }
}

#[test]
fn walls_have_no_holes() {
    // Squares of squares, none of which fills its box from all sides.
    let square = [[0.5, 0.5, 0.0], [-0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [-0.5, -0.5, 0.0]];
    for n in [5, 9, 20] {
        for [cover, stopped] in compare(&fractal(f64::from(n), PrimitiveKind::Cube, &square), BUDGET) {
            assert!((cover - stopped).abs() < 0.05, "{n}: {cover} of {stopped}");
        }
    }
}

#[test]
fn what_hardly_any_line_meets_stops_hardly_any() {
    let mut builder = GraphBuilder::new();
    let sphere = builder.primitive(PrimitiveKind::Sphere, []);
    let grain = builder.transform(TransformKind::UScale, [Expr::from(0.004)], sphere);
    let dust = recursion(&mut builder, 20.0, grain, &TETRAHEDRON);
    let (found, root) = survey(&builder.finish(dust).unwrap(), BUDGET);
    for cover in found.nodes[root].cells {
        assert!(cover < 0.05, "{cover}");
    }
}

#[test]
fn covers_are_of_rays_that_meet_slabs() {
    let graph = fractal(4.0, PrimitiveKind::Sphere, &TETRAHEDRON);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let whole = Arc::new(Compiled::whole(&graph, Bounds::Exact(&boxes), BUDGET).unwrap().with_parts());
    let found = Blocks::Whole { graph: graph.clone(), block: Arc::clone(&whole) }.survey(Level::new());
    let scene = Accelerated::new(&graph, &boxes, BUDGET).unwrap();
    let (mut tracer, mut dice) = (scene.tracer(), Dice::at(DVec3::ONE));
    let [mut lines, mut come, mut covered, mut stopped] = [0.0; 4];
    for at in whole.nodes_of(0) {
        let node = &whole.nodes[at];
        for slot in node.slots() {
            let Some(child) = node.children[slot].as_node() else { continue };
            for number in 0..20 * CELLS {
                let cell = number % CELLS;
                let (line, weight) = Throws::new(&mut dice).line(&found.bounds[child], cell, 0);
                let inside = Narrow::new(line, &whole.supers[0], ROOT, START, true).unwrap();
                let (_, met) = dispatch!(Level::new(), simd => {
                    single::met_in_slabs(simd, &whole, node, &inside.line, inside.start, f32::MAX)
                });
                let meets = f64::from(met >> slot & 1);
                lines += weight;
                come += weight * meets;
                covered += weight * meets * f64::from(found.nodes[child].cells[cell]);
                stopped += weight * f64::from(u8::from(tracer.is_stopped(&line, Some(Child::node(child)))));
            }
        }
    }
    assert!(come < 0.8 * lines, "{come} of {lines}");
    assert!((covered - stopped).abs() < 0.05 * stopped, "{covered} for {stopped}");
}

#[test]
fn balls_are_seen_from_all_sides() {
    let graph = fractal(4.0, PrimitiveKind::Sphere, &TETRAHEDRON);
    let (found, root) = survey(&graph, BUDGET);
    let mut dice = Dice::at(DVec3::ONE);
    for corner in 0..8 {
        let direction =
            DVec3::from([0, 1, 2].map(|axis| f64::from(corner >> axis & 1) * 2.0 - 1.0)).normalize();
        let draws = (0..1000).filter_map(|_| found.looks[root].draw(direction, &mut dice));
        let facing = draws.map(|seen| -seen.normal.as_dvec3().dot(direction)).sum::<f64>() / 1000.0;
        // ⅔ if there are normals in all directions; less where only some are seen from the side.
        assert!(facing > 0.55, "{facing} along {direction}");
    }
}

#[test]
fn crowns_beside_a_solid_stop_rays_as_they_do_without_it() {
    let apart = |has_ground: bool| {
        let mut builder = GraphBuilder::new();
        let sphere = builder.primitive(PrimitiveKind::Sphere, []);
        let crown = recursion(&mut builder, 9.0, sphere, &TETRAHEDRON);
        let places =
            (0..12).map(|i| [f64::from(i * 5 % 12) * 0.2, f64::from(i * 7 % 12) * 0.2, f64::from(i) * 0.2]);
        let mut parts: Vec<NodeId> = places
            .map(|place| builder.transform(TransformKind::Move, place.map(Expr::from), crown))
            .collect();
        if has_ground {
            let cube = builder.primitive(PrimitiveKind::Cube, []);
            let flat = builder.transform(TransformKind::Scale, [4.0, 4.0, 0.5].map(Expr::from), cube);
            let ground = builder.operator(Operator::Difference, flat, sphere);
            parts.push(builder.transform(TransformKind::Move, [1.0, 1.0, -1.0].map(Expr::from), ground));
        }
        let all = union(&mut builder, parts);
        let (found, root) = survey(&builder.finish(all).unwrap(), BUDGET);
        found.nodes[root].apart
    };
    let [without, with] = [false, true].map(apart);
    assert!((without - with).abs() < 0.3, "{without}, and with a ground {with}");
}

#[test]
fn lines_are_in_their_cells_and_meet_their_boxes() {
    let bounds = Aabb::new([-1.0, 2.0, 0.0].into(), [0.5, 2.1, 4.0].into());
    let mut dice = Dice::at(DVec3::ZERO);
    for cell in 0..CELLS {
        let throws = Throws::new(&mut dice);
        for number in 0..50 {
            let (line, _) = throws.line(&bounds, cell, number);
            assert_eq!(cover::cell(line.direction), cell);
            assert_eq!(cover::cell(-3.0 * line.direction), cell);
            assert!(crate::slab::interval(&bounds, &line).is_some());
        }
    }
}
