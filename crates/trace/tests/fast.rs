//! The fast engine against the walk.
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

mod common;

use csg_graph::{Expr, Graph, GraphBuilder, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use csg_graph_trace::{Accelerated, Hit, PACKET, Ray, Walk, brute};
use glam::DVec3;
use proptest::prelude::*;

/// Where boundaries are closer than this, chance decides which of them is hit.
const CLEARANCE: f64 = 1e-4;

fn agree(walk: Option<&Hit>, fast: Option<&Hit>) -> bool {
    match (walk, fast) {
        (None, None) => true,
        (Some(walk), Some(fast)) => {
            (walk.t - fast.t).abs() <= 1e-9 * walk.t
                && walk.normal.distance(fast.normal) < 1e-7
                && (walk.node, walk.depth, walk.surface) == (fast.node, fast.depth, fast.surface)
        }
        _ => false,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn hits_are_those_of_the_walk(
        graph in common::graph(),
        places in prop::collection::vec((prop::array::uniform3(0.0..1.0), prop::array::uniform3(0.0..1.0)), PACKET),
        budget in prop::sample::select(vec![0, 4096, 1 << 20]),
    ) {
        let tree = graph.unfold(2000).unwrap();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let hyper_boxes = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
        prop_assume!(!hyper_boxes.root.is_empty());
        let scene = Accelerated::new(&graph, &boxes, budget).unwrap();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let mut fast = scene.tracer();
        let rays: Vec<Ray> =
            places.into_iter().map(|(place, from)| common::ray_into(&hyper_boxes.root, place, from)).collect();
        let mut hits = vec![None; PACKET];
        fast.nearest_of(&rays, &mut hits);
        let ends: Vec<f64> = (0..PACKET).map(|lane| 0.2 * lane as f64).collect();
        let shadowed = fast.occluded_of(&rays, &ends);
        for (lane, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            prop_assert_eq!(&fast.nearest(ray), hit, "alone and in a packet");
            if brute::line(&tree, ray).clearance < CLEARANCE {
                continue;
            }
            let expected = walk.nearest(ray).unwrap();
            prop_assert!(agree(expected.as_ref(), hit.as_ref()), "{ray:?}\n{expected:?}\n{hit:?}");
            let is_shadowed = walk.occluded(ray, ends[lane]).unwrap();
            if expected.is_none_or(|hit| (hit.t - ends[lane]).abs() > 1e-9) {
                prop_assert_eq!(shadowed >> lane & 1 == 1, is_shadowed, "{:?} before {}", ray, ends[lane]);
                prop_assert_eq!(fast.occluded(ray, ends[lane]), is_shadowed);
            }
        }
    }
}

/// Sierpiński's tetrahedron of balls.
fn sierpinski(levels: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", levels);
    let symbol = builder.symbol("ST");
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let corners = [[0.5, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];
    let parts = corners.map(|corner| {
        let half = builder.transform(TransformKind::UScale, [0.5.into()], symbol);
        builder.transform(TransformKind::Move, corner.map(Expr::from), half)
    });
    let union = builder.union(parts);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], union);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [ball, rest]);
    builder.finish(symbol).unwrap()
}

#[test]
fn at_depth_hits_are_those_of_the_walk() {
    for levels in [5.0, 20.0] {
        let graph = sierpinski(levels);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let hyper_boxes = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap();
        assert!(scene.bytes() < 1 << 19, "{} bytes", scene.bytes());
        let mut fast = scene.tracer();
        let mut differ = 0;
        let mut met = 0;
        for index in 0..2000 {
            // Towards points of the fractal, a little aside.
            let mut target = DVec3::ZERO;
            for level in 0..50 {
                let corner = index * 31 + level * level * 7 + index / (level + 1);
                let sign = |bit: i32| if corner >> bit & 1 == 0 { 0.5 } else { -0.5 };
                target = target * 0.5 + DVec3::new(sign(0), sign(1), sign(0) * sign(1) * 2.0);
            }
            let eye = DVec3::new(3.4, -2.3, 1.6);
            let aside = DVec3::new(1.0, 2.0, 3.0) * (f64::from(index % 7) * 1e-3);
            let ray = Ray { origin: eye, direction: target + aside - eye };
            let (expected, hit) = (walk.nearest(&ray).unwrap(), fast.nearest(&ray));
            met += i32::from(hit.is_some());
            differ += i32::from(!agree(expected.as_ref(), hit.as_ref()));
        }
        assert!(met > 200, "{met} of 2000 rays hit at {levels} levels");
        // At 40 levels a ball is 10⁻¹² wide, and rounding decides whether a ray meets it.
        assert_eq!(differ, 0, "of {met} hits at {levels} levels");
    }
}

#[test]
fn a_tower_of_a_hundred_thousand_levels() {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", 1e5);
    let symbol = builder.symbol("TOWER");
    let cone = builder.primitive(PrimitiveKind::Cone, []);
    let smaller = builder.transform(TransformKind::UScale, [0.999_9.into()], symbol);
    let raised = builder.transform(TransformKind::Move, [0.0, 0.0, 0.6].map(Expr::from), smaller);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = builder.operator(Operator::Union, cone, rest);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cone, both]);
    let graph = builder.finish(symbol).unwrap();
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let top = boxes.root.max.z;
    let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap();
    let mut fast = scene.tracer();
    for part in 1..10 {
        let ray = Ray { origin: DVec3::new(100.0, 1e-9, 0.1 * f64::from(part) * top), direction: -DVec3::X };
        let hit = fast.nearest(&ray).unwrap();
        assert!((99.0..=100.0).contains(&hit.t), "{hit:?}");
        assert!(fast.occluded(&ray, 100.0));
    }
}
