//! The grid against the walk.
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "common/agreement.rs"]
mod agreement;
mod common;
#[path = "common/sierpinski.rs"]
mod sierpinski;

use csg_graph::{Expr, Graph, GraphBuilder, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use csg_graph_trace::{Grid, Ray, Walk, brute};
use glam::{DVec3, Vec3Swizzles};
use proptest::prelude::*;

use agreement::{CLEARANCE, agree};
use sierpinski::sierpinski;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn hits_are_those_of_the_walk(
        graph in common::graph(),
        places in prop::collection::vec((prop::array::uniform3(0.0..1.0), prop::array::uniform3(0.0..1.0)), 16),
        resolution in prop::sample::select(vec![None, Some(1), Some(5), Some(30)]),
        budget in prop::sample::select(vec![0, 4096, 1 << 20]),
        // From outside, from within, and from far away, where voxels are of no use.
        start in prop::sample::select(vec![0.0, 0.7, -3e4]),
    ) {
        let tree = graph.unfold(2000).unwrap();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let hyper_boxes = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
        prop_assume!(!hyper_boxes.root.is_empty());
        let grid = Grid::new(&graph, boxes, resolution, budget).unwrap();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let mut tracer = grid.tracer();
        for (index, (place, from)) in places.into_iter().enumerate() {
            let outside = common::ray_into(&hyper_boxes.root, place, from);
            let ray = Ray { origin: outside.at(start), ..outside };
            if brute::line(&tree, &ray).clearance < CLEARANCE {
                continue;
            }
            let (expected, hit) = (walk.nearest(&ray).unwrap(), tracer.nearest(&ray));
            prop_assert!(agree(expected.as_ref(), hit.as_ref()), "{ray:?}\n{expected:?}\n{hit:?}");
            let end = 0.2 * index as f64 - start;
            if expected.is_none_or(|hit| (hit.t - end).abs() > 1e-9) {
                prop_assert_eq!(tracer.occluded(&ray, end), walk.occluded(&ray, end).unwrap(), "{:?} before {}", ray, end);
            }
        }
    }
}

fn moved(builder: &mut GraphBuilder, by: [f64; 3], body: csg_graph::NodeId) -> csg_graph::NodeId {
    builder.transform(TransformKind::Move, by.map(Expr::from), body)
}

/// A tree of cylinders that fork, each half as long as order suggests, painted by their order.
fn forks(orders: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", orders);
    let symbol = builder.symbol("TR");
    let cylinder = builder.primitive(PrimitiveKind::Cylinder, []);
    let thin = builder.transform(TransformKind::Scale, [0.14, 0.14, 1.0].map(Expr::from), cylinder);
    let trunk = builder.attribute([(csg_graph::AttributeTerm::Red, Expr::from(n) / orders)], thin);
    let branch = |builder: &mut GraphBuilder, angle: f64, factor: f64| {
        let smaller = builder.transform(TransformKind::UScale, [factor.into()], symbol);
        builder.transform(TransformKind::RotX, [angle.into()], smaller)
    };
    let branches = [branch(&mut builder, -60.0, 0.73), branch(&mut builder, 20.0, 0.67)];
    let fork = builder.union(branches);
    let turned = builder.transform(TransformKind::RotZ, [(-72.0).into()], fork);
    let raised = moved(&mut builder, [0.0, 0.0, 1.0], turned);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = builder.operator(Operator::Union, trunk, rest);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [trunk, both]);
    builder.finish(symbol).unwrap()
}

#[test]
fn at_depth_hits_are_those_of_the_walk() {
    for (graph, size) in
        [(sierpinski(5.0), 1.0), (sierpinski(20.0), 1.0), (forks(10.0), 3.0), (forks(30.0), 3.0)]
    {
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let hyper_boxes = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let budget = 1 << 19;
        let grid = Grid::new(&graph, boxes, Some(24), budget).unwrap();
        assert!(grid.bytes() < budget + 1024, "{} bytes", grid.bytes());
        assert!(grid.entries() > 300, "{} entry states", grid.entries());
        let mut tracer = grid.tracer();
        let (mut differ, mut met) = (0, 0);
        for index in 0..1000_u32 {
            // Towards places all over the solid.
            let share = |step: f64| (f64::from(index) * step).fract();
            let place = DVec3::new(share(0.754_877), share(0.569_840), share(0.618_034));
            let target = hyper_boxes.root.min + hyper_boxes.root.size() * place;
            let eye = DVec3::new(3.4, -2.3, 1.6) * size;
            let ray = Ray { origin: eye, direction: target - eye };
            let (expected, hit) = (walk.nearest(&ray).unwrap(), tracer.nearest(&ray));
            met += i32::from(hit.is_some());
            differ += i32::from(!agree(expected.as_ref(), hit.as_ref()));
        }
        assert!(met > 100, "{met} of 1000 rays hit");
        assert_eq!(differ, 0, "of {met} hits");
    }
}

#[test]
fn rays_in_the_faces_of_voxels_miss_nothing() {
    // Eight cubes that fill a larger one: their faces are those of voxels, for even resolutions.
    let mut builder = GraphBuilder::new();
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let corners = (0..8).map(|corner| [1, 2, 4].map(|bit| if corner & bit == 0 { -1.0 } else { 1.0 }));
    let cubes: Vec<_> = corners.map(|corner| moved(&mut builder, corner, cube)).collect();
    let union = builder.union(cubes);
    let graph = builder.finish(union).unwrap();
    let hyper_boxes = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
    let mut walk = Walk::new(&graph, Some(&hyper_boxes));
    for resolution in [1, 2, 4, 7, 8] {
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let grid = Grid::new(&graph, boxes, Some(resolution), 1 << 16).unwrap();
        let mut tracer = grid.tracer();
        let steps = || (-4..=4).map(|step| f64::from(step) * 0.5);
        for (y, z) in steps().flat_map(|y| steps().map(move |z| (y, z))) {
            for origin in [DVec3::new(-5.0, y, z), DVec3::new(0.0, y, z), DVec3::new(2.0, y, z)] {
                for direction in [DVec3::X, -DVec3::X, DVec3::ONE, DVec3::new(1.0, -1.0, 0.0), DVec3::ZERO] {
                    for ray in
                        [Ray { origin, direction }, Ray { origin: origin.zxy(), direction: direction.zxy() }]
                    {
                        assert_eq!(
                            tracer.nearest(&ray),
                            walk.nearest(&ray).unwrap(),
                            "{ray:?} in {resolution}"
                        );
                        assert_eq!(tracer.occluded(&ray, 4.0), walk.occluded(&ray, 4.0).unwrap(), "{ray:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_grid_of_nothing_has_no_hits() {
    let mut builder = GraphBuilder::new();
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let far = moved(&mut builder, [9.0, 0.0, 0.0], cube);
    let nothing = builder.operator(Operator::Intersection, cube, far);
    let graph = builder.finish(nothing).unwrap();
    let grid = Grid::new(&graph, exact(&graph, &Limits::default()).unwrap(), None, 0).unwrap();
    let ray = Ray { origin: DVec3::new(-5.0, 0.0, 0.0), direction: DVec3::X };
    assert_eq!((grid.entries(), grid.tracer().nearest(&ray)), (0, None));
}

#[test]
fn a_tower_of_a_hundred_thousand_levels() {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", 1e5);
    let symbol = builder.symbol("TOWER");
    let cone = builder.primitive(PrimitiveKind::Cone, []);
    let smaller = builder.transform(TransformKind::UScale, [0.999_9.into()], symbol);
    let raised = moved(&mut builder, [0.0, 0.0, 0.6], smaller);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = builder.operator(Operator::Union, cone, rest);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cone, both]);
    let graph = builder.finish(symbol).unwrap();
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let top = boxes.root.max.z;
    let grid = Grid::new(&graph, boxes, Some(1000), 1 << 22).unwrap();
    assert!(grid.bytes() < 1 << 23, "{} bytes", grid.bytes());
    let mut tracer = grid.tracer();
    for part in 1..10 {
        let ray = Ray { origin: DVec3::new(100.0, 1e-9, 0.1 * f64::from(part) * top), direction: -DVec3::X };
        let hit = tracer.nearest(&ray).unwrap();
        assert!((99.0..=100.0).contains(&hit.t), "{hit:?}");
        assert!(tracer.occluded(&ray, 100.0));
    }
}
