//! The walk where the random graphs do not go: coincident faces, surfaces, depth.

use csg_graph::{AttributeTerm, Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, chain};
use csg_graph_trace::{Hit, Ray, Walk};
use glam::DVec3;

fn moved(builder: &mut GraphBuilder, offset: [f64; 3], body: NodeId) -> NodeId {
    builder.transform(TransformKind::Move, offset.map(Expr::from), body)
}

fn painted(builder: &mut GraphBuilder, colour: [f64; 3], body: NodeId) -> NodeId {
    builder.attribute(AttributeTerm::COLOR.into_iter().zip(colour.map(Expr::from)), body)
}

fn down(x: f64, y: f64) -> Ray {
    Ray { origin: DVec3::new(x, y, 10.0), direction: -DVec3::Z }
}

fn nearest(graph: &Graph, ray: &Ray) -> Option<Hit> {
    Walk::new(graph, None).nearest(ray).expect("no evaluation fails")
}

/// cube `operator` move(0, 0, dz) cube
fn two_cubes(operator: Operator, dz: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let cubes = [0.0, dz].map(|dz| {
        let cube = builder.primitive(PrimitiveKind::Cube, []);
        moved(&mut builder, [0.0, 0.0, dz], cube)
    });
    let both = builder.operator(operator, cubes[0], cubes[1]);
    builder.finish(both).expect("a sound graph")
}

/// Slanted rays from places with few digits, for which coincident faces are met at exactly one t.
fn slanted() -> impl Iterator<Item = Ray> {
    (0..40_i32).flat_map(|x| {
        (0..40_i32).map(move |y| Ray {
            origin: DVec3::new(3.5, -4.25, 7.0),
            direction: DVec3::new(f64::from(x).mul_add(-0.037, -2.9), f64::from(y).mul_add(0.041, 3.3), -6.1),
        })
    })
}

#[test]
fn a_solid_with_itself() {
    let single = two_cubes(Operator::Union, 0.0);
    let common = two_cubes(Operator::Intersection, 0.0);
    let nothing = two_cubes(Operator::Difference, 0.0);
    let mut hits = 0;
    for ray in slanted() {
        let hit = nearest(&single, &ray);
        hits += usize::from(hit.is_some());
        assert_eq!(nearest(&common, &ray), hit, "the left of two equal surfaces is shown");
        assert_eq!(nearest(&nothing, &ray), None);
    }
    assert!(hits > 500, "{hits} rays meet the cube");
}

#[test]
fn a_shared_face_leaves_no_skin() {
    // The upper half is taken away, along with the upper face.
    let lower = two_cubes(Operator::Difference, 1.0);
    // Nothing is taken away: the faces only touch.
    let whole = two_cubes(Operator::Difference, 2.0);
    let cube = two_cubes(Operator::Union, 0.0);
    for ray in slanted() {
        if let Some(hit) = nearest(&lower, &ray) {
            assert!(hit.point.z < 1e-9, "a skin at {}", hit.point);
        }
        assert_eq!(nearest(&whole, &ray), nearest(&cube, &ray));
    }
    let hit = nearest(&lower, &down(0.3, 0.2)).unwrap();
    assert_eq!((hit.t, hit.normal), (10.0, DVec3::Z));
}

#[test]
fn a_hole_shows_its_own_colour_or_what_is_inherited() {
    let (red, green) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let bowl = |paint_hole: bool, paint_cube_only: bool| {
        let mut builder = GraphBuilder::new();
        let mut cube = builder.primitive(PrimitiveKind::Cube, []);
        let ball = builder.primitive(PrimitiveKind::Sphere, []);
        let mut hole = moved(&mut builder, [0.0, 0.0, 1.0], ball);
        if paint_hole {
            hole = painted(&mut builder, green, hole);
        }
        if paint_cube_only {
            cube = painted(&mut builder, red, cube);
        }
        let mut bowl = builder.operator(Operator::Difference, cube, hole);
        if !paint_cube_only {
            bowl = painted(&mut builder, red, bowl);
        }
        nearest(&builder.finish(bowl).unwrap(), &down(0.0, 0.0)).unwrap()
    };
    assert_eq!(bowl(true, false).surface.pigment, DVec3::from(green));
    assert_eq!(bowl(false, false).surface.pigment, DVec3::from(red));
    assert_eq!(bowl(false, true).surface.pigment, DVec3::ONE);
    assert_eq!(bowl(true, true).normal, DVec3::Z);
}

#[test]
fn what_subtracts_nothing_here_leaves_the_solid_whole() {
    // The hole's box is missed by this ray, which must not count as missing the difference.
    let mut builder = GraphBuilder::new();
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let hole = moved(&mut builder, [1.0, 1.0, 1.0], ball);
    let bitten = builder.operator(Operator::Difference, cube, hole);
    let graph = builder.finish(bitten).unwrap();
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let mut walk = Walk::new(&graph, Some(&boxes));
    let hit = walk.nearest(&down(-0.5, -0.5)).unwrap().unwrap();
    assert_eq!((hit.t, hit.node), (9.0, cube));
    assert_eq!(walk.counters().boxes_missed, 1);
    assert_eq!(walk.counters().primitive_tests, 1);
}

#[test]
fn behind_the_origin_still_decides_what_is_inside() {
    // From within the hole of a hollow ball: the first boundary is that of the hole.
    let mut builder = GraphBuilder::new();
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let hole = builder.transform(TransformKind::UScale, [0.5.into()], ball);
    let hollow = builder.operator(Operator::Difference, ball, hole);
    let graph = builder.finish(hollow).unwrap();
    let hit = nearest(&graph, &Ray { origin: DVec3::ZERO, direction: DVec3::X }).unwrap();
    assert_eq!((hit.t, hit.normal), (0.5, -DVec3::X));
    let hit = nearest(&graph, &Ray { origin: DVec3::X * 0.75, direction: DVec3::X }).unwrap();
    assert_eq!((hit.t, hit.normal), (1.0 - 0.75, DVec3::X));
}

#[test]
fn depth_counts_symbols() {
    let tower = deep(10, Operator::Union, true);
    let hit = nearest(&tower, &Ray { origin: DVec3::new(-9.0, 0.0, 0.5), direction: DVec3::X }).unwrap();
    assert_eq!(hit.depth, 1);
    // From above, the cap of the last one.
    let hit = nearest(&tower, &Ray { origin: DVec3::new(0.0, 0.0, 30.0), direction: -DVec3::Z }).unwrap();
    assert_eq!(hit.depth, 10);
}

/// `T -> cylinder op {n = n-1} move(0, 0, 0.5) uscale(0.99999) T`, or with the operands exchanged.
fn deep(levels: u32, operator: Operator, recursion_last: bool) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", levels.into());
    let tower = builder.symbol("T");
    let cylinder = builder.primitive(PrimitiveKind::Cylinder, []);
    let smaller = builder.transform(TransformKind::UScale, [0.99999.into()], tower);
    let raised = moved(&mut builder, [0.0, 0.0, 0.5], smaller);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = if recursion_last {
        builder.operator(operator, cylinder, rest)
    } else {
        builder.operator(operator, rest, cylinder)
    };
    builder.rules(tower, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cylinder, both]);
    builder.finish(tower).expect("a sound graph")
}

#[test]
fn a_hundred_thousand_levels() {
    for (operator, recursion_last) in
        [(Operator::Union, true), (Operator::Union, false), (Operator::Difference, true)]
    {
        let graph = deep(100_000, operator, recursion_last);
        let mut walk = Walk::new(&graph, None);
        let across = Ray { origin: DVec3::new(-5.0, 0.0, 0.25), direction: DVec3::X };
        let hit = walk.nearest(&across).unwrap().unwrap();
        assert!((hit.t - 4.0).abs() < 1e-12 && hit.normal.distance(-DVec3::X) < 1e-12);
        let visited = walk.counters().nodes_visited;
        assert!(visited > 500_000 || operator == Operator::Difference, "{visited} nodes");
        let from_above = Ray { origin: DVec3::new(0.1, 0.0, 1e6), direction: -DVec3::Z };
        assert!(walk.nearest(&from_above).unwrap().is_some(), "{operator:?}");
    }
}

#[test]
fn an_evaluation_that_fails_is_an_error() {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", 3.0);
    let symbol = builder.symbol("S");
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let body = builder.calculate([(n, Expr::from(n) + 1.0)], ball);
    builder.rules(symbol, Some(Expr::from(n)), [body]);
    let graph = builder.finish(symbol).unwrap();
    let mut walk = Walk::new(&graph, None);
    let error = walk.nearest(&down(0.0, 0.0)).unwrap_err();
    assert_eq!(error.at.label, "S");
    assert!(walk.occluded(&down(0.0, 0.0), 1.0).is_err());
}
