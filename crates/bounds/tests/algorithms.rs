//! Boxes whose right answer is known.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "../examples/growth/sympodial.rs"]
mod sympodial;

#[path = "../examples/states/solids.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod solids;

use csg_graph::{Expr, Graph, GraphBuilder, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Aabb, BoundsError, EXCESS, HyperBoxes, Limits, chain, conventional};
use glam::DVec3;
use solids::{cone_tower, mapped, sierpinski};
use sympodial::sympodial;

use PrimitiveKind::{Cube, HalfSpace, Sphere};
use TransformKind::{Move, RotX, RotZ, UScale};

fn both(graph: &Graph) -> [HyperBoxes; 2] {
    let limits = Limits::default();
    [conventional(graph, &limits).unwrap(), chain(graph, &limits).unwrap()]
}

fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb::new(min.into(), max.into())
}

fn assert_close(found: Aabb, expected: Aabb) {
    let off = (found.min - expected.min).abs().max((found.max - expected.max).abs()).max_element();
    assert!(found == expected || off < 1e-12, "{found:?} is not {expected:?}");
}

#[test]
fn sympodial_tree() {
    let exact = [
        (8, aabb([-1.183_473_4, -1.285_000_8, 0.0], [1.794_397_3, 1.147_687_8, 4.534_666_4])),
        (12, aabb([-1.219_961_3, -1.331_941_7, 0.0], [1.834_825_7, 1.202_898_3, 4.571_158_4])),
    ];
    for (cnt, exact) in exact {
        let [conventional, chain] = both(&sympodial(cnt));
        // The numbers above are rounded.
        let rounded = Aabb::new(exact.min + 1e-7, exact.max - 1e-7);
        assert!(chain.root.encloses(rounded), "{chain:?}");
        assert!(conventional.root.encloses(chain.root));
        let excess = chain.root.size() / exact.size() - 1.0;
        assert!(excess.max_element() < EXCESS, "cnt = {cnt}: {excess}");
        assert!(conventional.root.volume() > 5.0 * chain.root.volume());
    }
}

#[test]
fn sierpinski_fits_the_cube_at_every_depth() {
    let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    for depth in 0..7 {
        for boxes in both(&sierpinski(depth)) {
            assert_close(boxes.root, cube);
        }
    }
}

#[test]
fn growth_under_rotations_by_45_degrees() {
    let mut b = GraphBuilder::new();
    let mut top = b.primitive(Cube, []);
    for _ in 0..8 {
        top = mapped(&mut b, RotZ, [45.0], top);
    }
    let [conventional, chain] = both(&b.finish(top).unwrap());
    assert!((conventional.root.volume() / (8.0 * 256.0) - 1.0).abs() < 1e-12);
    assert_close(chain.root, Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
}

#[test]
fn a_transformation_has_its_box_in_the_frame_that_it_maps_into() {
    let mut b = GraphBuilder::new();
    let cube = b.primitive(Cube, []);
    let moved = mapped(&mut b, Move, [5.0, 0.0, 0.0], cube);
    let turned = mapped(&mut b, RotZ, [90.0], moved);
    for boxes in both(&b.finish(turned).unwrap()) {
        assert_close(boxes.nodes[cube.index()], aabb([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]));
        assert_close(boxes.nodes[moved.index()], aabb([4.0, -1.0, -1.0], [6.0, 1.0, 1.0]));
        assert_close(boxes.nodes[turned.index()], aabb([-1.0, 4.0, -1.0], [1.0, 6.0, 1.0]));
        assert_eq!(boxes.root, boxes.nodes[turned.index()]);
    }
}

#[test]
fn hyper_boxes_join_all_instances() {
    // The tower's cones are 1, 2 and 4 large; its symbol is met with 3, 2 and 1 cones left.
    let graph = cone_tower(3, 2.0);
    let symbol = graph.root().index();
    for boxes in both(&graph) {
        assert!((boxes.root.max.z - (0.6 + 1.2 + 4.0)).abs() < 1e-12);
        assert!((boxes.root.max.x - 4.0).abs() < 1e-12);
        assert_eq!(boxes.nodes[symbol], boxes.root);
        for (node, bounds) in graph.nodes().map(|(id, _)| id).zip(&boxes.nodes) {
            let expected = match graph.node_name(node).as_str() {
                "cone" => aabb([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]),
                "uscale" => aabb([-4.0, -4.0, 0.0], [4.0, 4.0, 5.2]),
                "move" | "n" => aabb([-4.0, -4.0, 0.6], [4.0, 4.0, 5.8]),
                _ => boxes.root,
            };
            assert_close(*bounds, expected);
        }
    }
}

#[test]
fn what_is_never_reached_is_empty() {
    let mut b = GraphBuilder::new();
    let unused = b.primitive(Cube, []);
    let sphere = b.primitive(Sphere, []);
    for boxes in both(&b.finish(sphere).unwrap()) {
        assert_eq!(boxes.nodes[unused.index()], Aabb::EMPTY);
    }
}

#[test]
fn operators() {
    let mut b = GraphBuilder::new();
    let sphere = b.primitive(Sphere, []);
    let cube = b.primitive(Cube, []);
    let moved = mapped(&mut b, Move, [1.5, 0.0, 0.0], cube);
    let union = b.operator(Operator::Union, sphere, moved);
    let intersection = b.operator(Operator::Intersection, sphere, moved);
    let difference = b.operator(Operator::Difference, sphere, moved);
    let others = b.union([intersection, difference]);
    let all = b.union([union, others]);
    for boxes in both(&b.finish(all).unwrap()) {
        assert_close(boxes.nodes[union.index()], aabb([-1.0, -1.0, -1.0], [2.5, 1.0, 1.0]));
        assert_close(boxes.nodes[intersection.index()], aabb([0.5, -1.0, -1.0], [1.0, 1.0, 1.0]));
        assert_close(boxes.nodes[difference.index()], aabb([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]));
        // Operands keep their own boxes.
        assert_close(boxes.nodes[moved.index()], aabb([0.5, -1.0, -1.0], [2.5, 1.0, 1.0]));
    }
}

#[test]
fn empty_solids_are_empty_in_every_frame() {
    let mut b = GraphBuilder::new();
    let cube = b.primitive(Cube, []);
    let far = mapped(&mut b, Move, [9.0, 0.0, 0.0], cube);
    let nothing = b.operator(Operator::Intersection, cube, far);
    let turned = mapped(&mut b, RotX, [30.0], nothing);
    let less = b.operator(Operator::Difference, turned, cube);
    let moved = mapped(&mut b, Move, [1.0, 1.0, 1.0], less);
    let with_nothing = b.operator(Operator::Union, moved, cube);
    for boxes in both(&b.finish(with_nothing).unwrap()) {
        for node in [nothing, turned, less, moved] {
            assert_eq!(boxes.nodes[node.index()], Aabb::EMPTY);
        }
        assert_close(boxes.root, Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
    }
}

#[test]
fn half_spaces_are_bounded_by_what_they_meet() {
    let mut b = GraphBuilder::new();
    let half_space = b.primitive(HalfSpace, []);
    let tilted = mapped(&mut b, RotX, [30.0], half_space);
    let cube = b.primitive(Cube, []);
    let below = b.operator(Operator::Intersection, tilted, cube);
    let above = b.operator(Operator::Difference, cube, tilted);
    let apart = mapped(&mut b, Move, [4.0, 0.0, 0.0], above);
    let root = b.operator(Operator::Union, below, apart);
    for boxes in both(&b.finish(root).unwrap()) {
        assert_eq!(boxes.nodes[half_space.index()], Aabb { max: DVec3::INFINITY.with_z(0.0), ..Aabb::ALL });
        assert_eq!(boxes.nodes[tilted.index()], Aabb::ALL);
        assert_close(boxes.nodes[below.index()], Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
        assert_close(boxes.root, aabb([-1.0, -1.0, -1.0], [5.0, 1.0, 1.0]));
    }
}

#[test]
fn an_intersection_is_taken_frame_by_frame() {
    // Turned back, the cube within the diamond is a cube again; conventionally it has two boxes of boxes.
    for swapped in [false, true] {
        let mut b = GraphBuilder::new();
        let cube = b.primitive(Cube, []);
        let diamond = mapped(&mut b, RotZ, [45.0], cube);
        let large = mapped(&mut b, UScale, [10.0], cube);
        let [left, right] = if swapped { [large, diamond] } else { [diamond, large] };
        let within = b.operator(Operator::Intersection, left, right);
        let straight = mapped(&mut b, RotZ, [-45.0], within);
        let [conventional, chain] = both(&b.finish(straight).unwrap());
        assert_close(chain.root, Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
        assert_close(conventional.root, aabb([-2.0, -2.0, -1.0], [2.0, 2.0, 1.0]));
    }
}

#[test]
fn boxes_enclose_what_rounding_loses() {
    // At 1e16 there are no odd numbers: a cube moved there and back has no extent left.
    let mut b = GraphBuilder::new();
    let cube = b.primitive(Cube, []);
    let there = mapped(&mut b, Move, [1e16, 0.0, 0.0], cube);
    let back = mapped(&mut b, Move, [-1e16, 0.0, 0.0], there);
    let large = mapped(&mut b, UScale, [1e6], back);
    for boxes in both(&b.finish(large).unwrap()) {
        assert!(boxes.nodes[back.index()].encloses(Aabb::new(DVec3::NEG_ONE, DVec3::ONE)));
        assert!(boxes.root.encloses(Aabb::new(DVec3::splat(-1e6), DVec3::splat(1e6))));
    }
}

/// Two crossed rods have a small box in common, and their turned images large ones.
#[test]
fn an_intersection_is_not_taken_only_frame_by_frame() {
    let mut b = GraphBuilder::new();
    let cube = b.primitive(Cube, []);
    let rods =
        [[10.0, 1.0, 1.0], [1.0, 10.0, 1.0]].map(|size| mapped(&mut b, TransformKind::Scale, size, cube));
    let crossing = b.operator(Operator::Intersection, rods[0], rods[1]);
    let turned = mapped(&mut b, RotZ, [45.0], crossing);
    let diagonal = std::f64::consts::SQRT_2;
    for boxes in both(&b.finish(turned).unwrap()) {
        assert_close(boxes.root, aabb([-diagonal, -diagonal, -1.0], [diagonal, diagonal, 1.0]));
    }
}

#[test]
fn a_tower_of_100_000_cones() {
    let (cones, factor) = (100_000_u32, 1.0 - 4.0 / 100_000.0);
    let boxes = conventional(&cone_tower(cones, factor), &Limits::default()).unwrap();
    let top = (1..cones).fold(1.0, |above, _| 0.6 + factor * above);
    assert!((boxes.root.max.z / top - 1.0).abs() < 1e-9);
    assert!((boxes.root.max.x - 1.0).abs() < 1e-9);
    // Its chains are five thousand million boxes.
    let refused = chain(&cone_tower(cones, factor), &Limits::default().with_steps(5_000_000));
    assert_eq!(refused, Err(BoundsError::TooManySteps { limit: 5_000_000 }));
}

#[test]
fn chains_through_a_thousand_frames() {
    let [conventional, chain] = both(&cone_tower(1_000, 0.996));
    assert_close(chain.root, conventional.root);
}

#[test]
fn endless_recursion_is_an_error() {
    let mut b = GraphBuilder::new();
    let symbol = b.symbol("X");
    let cube = b.primitive(Cube, []);
    let smaller = mapped(&mut b, UScale, [0.5], symbol);
    let both = b.operator(Operator::Union, cube, smaller);
    b.rules(symbol, None, [both]);
    let graph = b.finish(symbol).unwrap();
    let limits = Limits::default().with_steps(50_000_000);
    assert_eq!(conventional(&graph, &limits), Err(BoundsError::TooDeep { limit: limits.held }));
    assert_eq!(chain(&graph, &limits), Err(BoundsError::TooManySteps { limit: limits.steps }));
    let few = limits.with_steps(100);
    let error = conventional(&graph, &few).unwrap_err();
    assert_eq!(error, BoundsError::TooManySteps { limit: 100 });
    assert!(error.to_string().contains("more than 100 steps"));
    assert!(chain(&graph, &limits.with_held(50)).unwrap_err().to_string().contains("more than 50 nodes"));
}

#[test]
fn errors_of_the_scene_are_passed_on() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 0.0);
    let symbol = b.symbol("X");
    let cube = b.primitive(Cube, []);
    b.rules(symbol, Some(Expr::from(n)), [cube]);
    let graph = b.finish(symbol).unwrap();
    for result in [conventional(&graph, &Limits::default()), chain(&graph, &Limits::default())] {
        assert!(matches!(result, Err(BoundsError::Scene(_))));
    }
}

/// Intersections nested to the right in the frame of ever more T-nodes hold a row of boxes each.
#[test]
fn rows_count_as_held() {
    let mut b = GraphBuilder::new();
    let symbol = b.symbol("X");
    let n = b.param("n", 2_000.0);
    let cube = b.primitive(Cube, []);
    let turned = mapped(&mut b, RotZ, [1.0], symbol);
    let rest = b.calculate([(n, Expr::from(n) - 1.0)], turned);
    let within = b.operator(Operator::Intersection, cube, rest);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [within, cube]);
    let graph = b.finish(symbol).unwrap();
    let limits = Limits::default().with_held(1_000_000);
    assert_eq!(chain(&graph, &limits), Err(BoundsError::TooDeep { limit: 1_000_000 }));
    assert_close(conventional(&graph, &limits).unwrap().root, Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
}
