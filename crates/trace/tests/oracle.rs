//! The walk against the unfolded tree, and with boxes against without.

mod common;

use csg_graph_bounds::{Limits, chain, conventional};
use csg_graph_trace::{Hit, Ray, Walk, brute};
use glam::DVec3;
use proptest::prelude::*;

/// Rays on which boundaries are closer than this in t are left to the tests of coincidence: which comes first is chance.
const CLEARANCE: f64 = 1e-4;

fn unit_cube() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(0.0..1.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn hits_are_those_of_the_unfolded_tree(
        graph in common::graph(),
        places in prop::collection::vec((unit_cube(), unit_cube()), 32),
    ) {
        let tree = graph.unfold(2000).unwrap();
        let boxes = chain(&graph, &Limits::default()).unwrap();
        prop_assume!(!boxes.root.is_empty());
        let mut walk = Walk::new(&graph, Some(&boxes));
        for (place, from) in places {
            let ray = common::ray_into(&boxes.root, place, from);
            let line = brute::line(&tree, &ray);
            let hit = walk.nearest(&ray).unwrap();
            if line.clearance < CLEARANCE {
                continue;
            }
            let expected = line.crossings.iter().find(|crossing| crossing.t > 0.0);
            prop_assert_eq!(hit.map(|hit| hit.node), expected.map(|crossing| crossing.node), "{:?}", ray);
            if let (Some(hit), Some(expected)) = (hit, expected) {
                prop_assert!((hit.t - expected.t).abs() < 1e-9, "{} for {}", hit.t, expected.t);
                prop_assert!(hit.normal.distance(expected.normal) < 1e-9, "{} for {}", hit.normal, expected.normal);
                prop_assert!((hit.normal.length() - 1.0).abs() < 1e-12);
                prop_assert!(hit.point.distance(ray.at(expected.t)) < 1e-8);
            }
        }
    }

    #[test]
    fn boxes_change_no_bit(
        graph in common::graph(),
        places in prop::collection::vec((unit_cube(), unit_cube()), 16),
        axis in 0..3_usize,
        end in 0.0..2.0,
    ) {
        let limits = Limits::default();
        let boxes = [conventional(&graph, &limits).unwrap(), chain(&graph, &limits).unwrap()];
        prop_assume!(!boxes[1].root.is_empty());
        let mut walks = [None, Some(&boxes[0]), Some(&boxes[1])].map(|boxes| Walk::new(&graph, boxes));
        for (place, from) in places {
            let across = common::ray_into(&boxes[1].root, place, from);
            let inside = across.at(1.0);
            let along = DVec3::AXES[axis];
            // From outside, along an axis, along the faces of a box, and from inside.
            let rays = [
                across,
                Ray { origin: inside - along * 100.0, direction: along },
                Ray { origin: (inside - along * 100.0).with_z(boxes[1].root.max.z), direction: along },
                Ray { origin: inside, direction: across.direction },
            ];
            for ray in rays {
                let hits: [Option<Hit>; 3] = walks.each_mut().map(|walk| walk.nearest(&ray).unwrap());
                prop_assert_eq!(hits[0], hits[1]);
                prop_assert_eq!(hits[0], hits[2]);
                let shadows = walks.each_mut().map(|walk| walk.occluded(&ray, end).unwrap());
                prop_assert_eq!(shadows, [hits[0].is_some_and(|hit| hit.t < end); 3]);
            }
        }
        let tests = walks.each_ref().map(|walk| walk.counters().primitive_tests);
        prop_assert!(tests[2] <= tests[0] && tests[1] <= tests[0], "{tests:?}");
    }

    #[test]
    fn boundaries_agree_with_membership(
        graph in common::graph(),
        place in unit_cube(),
        from in unit_cube(),
    ) {
        // The oracle is worth what its own two halves agree on.
        let tree = graph.unfold(2000).unwrap();
        let boxes = chain(&graph, &Limits::default()).unwrap();
        let ray = common::ray_into(&boxes.root, place, from);
        let line = brute::line(&tree, &ray);
        prop_assume!(line.clearance > CLEARANCE);
        for crossing in line.crossings {
            let outward = if crossing.normal.dot(ray.direction) > 0.0 { 1e-7 } else { -1e-7 };
            prop_assert!(!brute::contains(&tree, ray.at(crossing.t + outward)));
            prop_assert!(brute::contains(&tree, ray.at(crossing.t - outward)));
        }
    }
}
