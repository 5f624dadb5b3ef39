//! What is measured, and what is found by looking into everything.

use csg_graph::{Expr, Graph, GraphBuilder, NodeId, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use glam::DVec3;

use super::*;
use crate::fast::Accelerated;
use crate::fast::bounds::Bounds;

/// A primitive in places, each of half the size of all, and so on, n times.
fn fractal(n: f64, kind: PrimitiveKind, places: &[[f64; 3]]) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", n);
    let symbol = builder.symbol("X");
    let primitive = builder.primitive(kind, []);
    let parts: Vec<NodeId> = places
        .iter()
        .map(|place| {
            let smaller = builder.transform(TransformKind::UScale, [Expr::from(0.5)], symbol);
            builder.transform(TransformKind::Move, place.map(Expr::from), smaller)
        })
        .collect();
    let all = parts
        .into_iter()
        .reduce(|one, other| builder.operator(csg_graph::Operator::Union, one, other))
        .unwrap();
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], all);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [rest, primitive]);
    builder.finish(symbol).unwrap()
}

const TETRAHEDRON: [[f64; 3]; 4] = [[0.5, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];

/// What is measured of the root of a graph in each direction, and what rays that look into everything find there.
fn compare(graph: &Graph) -> Vec<[f64; 2]> {
    let boxes = exact(graph, &Limits::default()).unwrap();
    let whole = Compiled::whole(graph, Bounds::Exact(&boxes), 1 << 18).unwrap().with_parts();
    let found = whole.survey(Level::new());
    let root = whole.root_node(0).unwrap();
    let scene = Accelerated::new(graph, &boxes, 1 << 18).unwrap();
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
    for n in [4, 12, 24, 40] {
        let cells = compare(&fractal(f64::from(n), PrimitiveKind::Sphere, &TETRAHEDRON));
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
        for [cover, stopped] in compare(&fractal(f64::from(n), PrimitiveKind::Cube, &square)) {
            assert!((cover - stopped).abs() < 0.05, "{n}: {cover} of {stopped}");
        }
    }
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
