//! One box a state: against the unfolded tree, the other algorithms, and answers that are known.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "../examples/growth/sympodial.rs"]
mod sympodial;

#[path = "../examples/states/dag.rs"]
mod dag;

#[path = "../examples/states/solids.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod solids;

use std::hash::{Hash, Hasher};

use csg_graph::{
    EvalError, Expr, Graph, GraphBuilder, NodeId, Operator, Primitive, PrimitiveKind, State, Transform,
    TransformKind,
};
use csg_graph_bounds::{
    Aabb, BoundsError, ExactBoxes, Limits, Scene, Step, chain, conventional, exact, root_box,
};
use dag::Dag;
use glam::{DAffine3, DVec3};
use solids::{cone_tower, mapped, sierpinski};
use sympodial::sympodial;

use PrimitiveKind::{Cone, Cube, HalfSpace, Octahedron, Sphere};
use TransformKind::{Move, Rot, RotX, RotZ, UScale};

fn boxes(graph: &Graph) -> ExactBoxes<Graph> {
    exact(graph, &Limits::default()).unwrap()
}

fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb::new(min.into(), max.into())
}

fn off(a: Aabb, b: Aabb) -> f64 {
    if a == b { 0.0 } else { (a.min - b.min).abs().max((a.max - b.max).abs()).max_element() }
}

/// The least box below a state, from all primitives of its unfolded tree.
fn unfolded(graph: &Graph, state: &State) -> Aabb {
    let mut found = Aabb::EMPTY;
    let mut waiting = vec![(state.clone(), DAffine3::IDENTITY)];
    while let Some((state, root_from_state)) = waiting.pop() {
        match Scene::step(graph, &state).unwrap() {
            Step::Shape(shape) => {
                let DAffine3 { matrix3, translation } = root_from_state;
                let rows = matrix3.transpose();
                let support = |sign: f64| {
                    let h = |axis: usize| {
                        csg_graph_bounds::Shape::support(&shape, sign * rows.col(axis))
                            + sign * translation[axis]
                    };
                    DVec3::new(h(0), h(1), h(2))
                };
                found = found.join(Aabb::new(-support(-1.0), support(1.0)));
            }
            Step::Same(below) => waiting.push((below, root_from_state)),
            Step::Map(map, below) => waiting.push((below, root_from_state * map.to_affine())),
            Step::Union(parts) => waiting.extend(parts.into_iter().map(|part| (part, root_from_state))),
            Step::Intersection(_) | Step::Difference(_) => unreachable!("the tests unfold unions"),
        }
    }
    found
}

#[test]
fn sympodial_tree_is_that_of_the_unfolded_primitives() {
    for cnt in [0, 1, 2, 3, 4, 8, 12, 16] {
        let graph = sympodial(cnt);
        let unfolded = unfolded(&graph, &graph.root_state());
        let found = boxes(&graph);
        assert!(off(found.root, unfolded) < 1e-9, "cnt = {cnt}: {:?} {unfolded:?}", found.root);
        assert!(found.gap < 1e-11, "cnt = {cnt}: {}", found.gap);
        let root = root_box(&graph, &Limits::default()).unwrap();
        assert!(off(root.aabb, unfolded) < 1e-9, "cnt = {cnt}: {root:?}");
    }
}

#[test]
fn every_state_has_its_own_least_box() {
    let graph = sympodial(8);
    let found = boxes(&graph);
    assert_eq!(found.states().len(), found.counts.states);
    for (state, state_box) in found.states() {
        let least = unfolded(&graph, state);
        assert!(off(state_box.aabb, least) < 1e-9, "{}: {state_box:?} {least:?}", graph.label(state));
        assert!(state_box.aabb.surface_area() <= 1.000_001 * least.surface_area());
        assert_eq!(found.of(state), Some(state_box));
    }
    let hyper = chain(&graph, &Limits::default()).unwrap();
    for (outer, inner) in hyper.nodes.iter().zip(&found.nodes) {
        let outer = Aabb::new(outer.min - 1e-11, outer.max + 1e-11);
        assert!(outer.encloses(*inner), "{outer:?} {inner:?}");
    }
}

#[test]
fn order_60_takes_no_longer_than_its_states() {
    let found = boxes(&sympodial(60));
    assert_eq!(found.counts.states, 774);
    assert!(found.counts.expansions < 100_000, "{:?}", found.counts);
    assert!(found.gap < 1e-11);
    let limit = aabb([-1.233_582_03, -1.350_059_46, 0.0], [1.848_423_80, 1.224_842_73, 4.579_475_61]);
    assert!(off(found.root, limit) < 1e-8, "{:?}", found.root);
}

#[test]
fn supports_in_any_direction() {
    let graph = sympodial(6);
    let found = boxes(&graph);
    let root = graph.root_state();
    for d in [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-0.3, 0.1, -0.2), DVec3::new(1e-200, -1e-200, 0.0)] {
        // The support is a face in a frame where the direction is an axis.
        let z = d / d.abs().max_element();
        let world_from_tree = DAffine3::from_mat3(glam::DMat3::from_cols(
            DVec3::new(1.0, 0.0, z.x),
            DVec3::new(0.0, 1.0, z.y),
            DVec3::new(0.0, 0.0, z.z),
        ));
        let mut least = f64::NEG_INFINITY;
        let mut waiting = vec![(root.clone(), world_from_tree)];
        while let Some((state, map)) = waiting.pop() {
            match Scene::step(&graph, &state).unwrap() {
                Step::Shape(shape) => {
                    let row = map.matrix3.transpose().z_axis;
                    let support = csg_graph_bounds::Shape::support(&shape, row);
                    least = least.max(map.translation.z + support);
                }
                Step::Same(below) => waiting.push((below, map)),
                Step::Map(inner, below) => waiting.push((below, map * inner.to_affine())),
                Step::Union(parts) => waiting.extend(parts.into_iter().map(|part| (part, map))),
                Step::Intersection(_) | Step::Difference(_) => unreachable!("it is a union"),
            }
        }
        let support = found.support(&root, d).unwrap();
        let scale = d.abs().max_element();
        assert!(support.upper >= scale * least);
        assert!(support.upper - scale * least < 1e-10 * scale, "{support:?} {least}");
        let loose = found.support_within(&root, d, 0.1).unwrap();
        assert!(loose.upper >= scale * least);
        assert!(loose.upper - scale * least <= loose.gap + 1e-10 * scale, "{loose:?} {least}");
        // The sides of its box are 11 units long together.
        assert!(loose.gap <= 0.1 * 11.0 * scale, "{loose:?}");
    }
    let elsewhere = sympodial(7).root_state();
    assert_eq!(found.of(&elsewhere), None);
    assert_eq!(found.support(&elsewhere, DVec3::X), None);
    assert_eq!(found.support_within(&elsewhere, DVec3::X, 0.1), None);
}

/// A fractal with millions of touching points on every face of its box, and the same turned on its face and its edge.
#[test]
fn ties_are_not_searched() {
    let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    let upright = boxes(&sierpinski(40));
    assert!(off(upright.root, cube) < 1e-12);
    assert_eq!(upright.counts.queries, 0);

    let turned = |kind, args: &[f64]| {
        let mut b = GraphBuilder::new();
        let n = b.param("n", 40.0);
        let symbol = b.symbol("ST");
        let tetrahedron = b.primitive(PrimitiveKind::Tetrahedron, []);
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let copies = corners.map(|corner| {
            let half = mapped(&mut b, UScale, [0.5], symbol);
            mapped(&mut b, Move, corner.map(|x| 0.5 * x), half)
        });
        let all = b.union(copies);
        let step = b.calculate([(n, Expr::from(n) - 1.0)], all);
        b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [tetrahedron, step]);
        let top = b.transform(kind, args.iter().copied().map(Expr::from), symbol);
        b.finish(top).unwrap()
    };
    let on_its_face = boxes(&turned(Rot, &[1.0, -1.0, 0.0, libm::acos((1.0_f64 / 3.0).sqrt()).to_degrees()]));
    // The tetrahedron is 4/√3 high, and a quarter of it is below its centre.
    assert!((on_its_face.root.min.z + 1.0 / 3.0_f64.sqrt()).abs() < 1e-10, "{:?}", on_its_face.root);
    assert!((on_its_face.root.max.z - 3.0_f64.sqrt()).abs() < 1e-10, "{:?}", on_its_face.root);
    assert!(on_its_face.counts.expansions < 1_000, "{:?}", on_its_face.counts);
    assert!(on_its_face.gap < 1e-10);
    let on_its_edge = boxes(&turned(RotX, &[45.0]));
    assert!((on_its_edge.root.max.z - 2.0_f64.sqrt()).abs() < 1e-10);
    assert!(on_its_edge.counts.expansions < 1_000, "{:?}", on_its_edge.counts);
}

#[test]
fn a_tower_of_100_000_cones() {
    let (cones, factor) = (100_000_u32, 1.0 - 4.0 / 100_000.0);
    let found = boxes(&cone_tower(cones, factor));
    let top = (1..cones).fold(1.0, |above, _| 0.6 + factor * above);
    assert!((found.root.max.z / top - 1.0).abs() < 1e-9);
    assert_eq!(found.counts.queries, 0);
}

#[test]
fn a_cheese_of_40_levels() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 40.0);
    let symbol = b.symbol("CH");
    let [cube, sphere] = [Cube, Sphere].map(|kind| b.primitive(kind, []));
    let hole = mapped(&mut b, UScale, [0.6], sphere);
    let copies = (0..8).map(|corner| {
        let sign = |bit: u32| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
        let half = mapped(&mut b, UScale, [0.5], symbol);
        mapped(&mut b, Move, [sign(0), sign(1), sign(2)], half)
    });
    let copies: Vec<NodeId> = copies.collect();
    let all = b.union(copies);
    let eaten = b.operator(Operator::Difference, all, hole);
    let step = b.calculate([(n, Expr::from(n) - 1.0)], eaten);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [cube, step]);
    let found = boxes(&b.finish(symbol).unwrap());
    assert!(off(found.root, Aabb::new(DVec3::NEG_ONE, DVec3::ONE)) < 1e-12);
    assert_eq!(found.counts.queries, 0);
}

#[test]
fn a_single_shape() {
    let mut b = GraphBuilder::new();
    let sphere = b.primitive(Sphere, []);
    let graph = b.finish(sphere).unwrap();
    let found = boxes(&graph);
    assert_eq!(found.root, Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
    assert_eq!(found.nodes, [found.root]);
    assert_eq!((found.counts.states, found.counts.solids, found.counts.queries), (1, 1, 0));
    assert!(off(root_box(&graph, &Limits::default()).unwrap().aabb, found.root) < 1e-14);
}

#[test]
fn empty_solids_are_empty_in_every_frame() {
    let mut b = GraphBuilder::new();
    let cube = b.primitive(Cube, []);
    let far = mapped(&mut b, Move, [9.0, 0.0, 0.0], cube);
    let nothing = b.operator(Operator::Intersection, cube, far);
    let turned = mapped(&mut b, RotX, [30.0], nothing);
    let with_nothing = b.operator(Operator::Union, turned, cube);
    let root = mapped(&mut b, RotZ, [45.0], with_nothing);
    let graph = b.finish(root).unwrap();
    let found = boxes(&graph);
    assert_eq!(found.nodes[nothing.index()], Aabb::EMPTY);
    assert_eq!(found.nodes[turned.index()], Aabb::EMPTY);
    let diagonal = 2.0_f64.sqrt();
    assert!(off(found.root, aabb([-diagonal, -diagonal, -1.0], [diagonal, diagonal, 1.0])) < 1e-12);
    assert!(found.gap < 1e-12);
}

#[test]
fn half_spaces_end_where_they_can() {
    let mut b = GraphBuilder::new();
    let half_space = b.primitive(HalfSpace, []);
    let raised = mapped(&mut b, Move, [0.0, 0.0, 0.5], half_space);
    let tilted = mapped(&mut b, RotX, [30.0], raised);
    let cube = b.primitive(Cube, []);
    let cut = b.operator(Operator::Intersection, cube, raised);
    let both = b.operator(Operator::Intersection, cut, tilted);
    let turned = mapped(&mut b, RotZ, [45.0], both);
    let found = boxes(&b.finish(turned).unwrap());
    let raised = found.nodes[raised.index()];
    assert_eq!(raised, Aabb { max: DVec3::INFINITY.with_z(raised.max.z), ..Aabb::ALL });
    assert!((raised.max.z - 0.5).abs() < 1e-14);
    assert_eq!(found.nodes[tilted.index()], Aabb::ALL);
    assert!(off(found.nodes[both.index()], aabb([-1.0, -1.0, -1.0], [1.0, 1.0, 0.5])) < 1e-12);
    let diagonal = 2.0_f64.sqrt();
    assert!(off(found.root, aabb([-diagonal, -diagonal, -1.0], [diagonal, diagonal, 0.5])) < 1e-12);
}

/// An intersection reaches no further than either operand: turned and turned again, a lens of balls does not grow.
#[test]
fn an_intersection_is_bounded_by_its_operands() {
    let mut b = GraphBuilder::new();
    let sphere = b.primitive(Sphere, []);
    let far = mapped(&mut b, Move, [0.1, 0.0, 0.0], sphere);
    let lens = b.operator(Operator::Intersection, sphere, far);
    let mut top = lens;
    for _ in 0..30 {
        top = mapped(&mut b, RotZ, [45.0], top);
        top = mapped(&mut b, RotX, [45.0], top);
    }
    let graph = b.finish(top).unwrap();
    let found = boxes(&graph);
    assert!(found.root.size().max_element() < 2.2, "{:?}", found.root);
    assert!(conventional(&graph, &Limits::default()).unwrap().root.size().max_element() > 1e6);
}

/// What is left of two solids, small and beside a ball.
fn beside_a_ball(one: PrimitiveKind, other: PrimitiveKind, offset: [f64; 3]) -> [Aabb; 3] {
    let mut builder = GraphBuilder::new();
    let [one, other] = [one, other].map(|kind| builder.primitive(kind, []));
    let other = mapped(&mut builder, Move, offset, other);
    let common = builder.operator(Operator::Intersection, one, other);
    let ball = builder.primitive(Sphere, []);
    let small = mapped(&mut builder, UScale, [0.01], ball);
    let both = builder.operator(Operator::Union, common, small);
    let turned = mapped(&mut builder, RotZ, [45.0], both);
    let graph = builder.finish(turned).unwrap();
    let [conventional, chain] =
        [conventional, chain].map(|bound| bound(&graph, &Limits::default()).unwrap().root);
    [conventional, chain, boxes(&graph).root]
}

#[test]
fn where_a_query_gives_up_the_gap_is_that_of_the_boxes() {
    // What is in common of a ball and itself turned, again and again: each level has a query for twice as many.
    let mut builder = GraphBuilder::new();
    let mut solid = builder.primitive(Sphere, []);
    for _ in 0..17 {
        let one = builder.transform(Move, [0.2, 0.0, 0.0].map(Expr::from), solid);
        let one = builder.transform(RotZ, [40.0.into()], one);
        let other = builder.transform(Move, [0.0, 0.1, 0.0].map(Expr::from), solid);
        let other = builder.transform(RotX, [23.0.into()], other);
        solid = builder.operator(Operator::Intersection, one, other);
    }
    let found = boxes(&builder.finish(solid).unwrap());
    assert!(found.gap <= 4.0, "{}", found.gap);
}

#[test]
fn operands_that_are_apart_leave_nothing() {
    let ball = aabb([-0.01; 3], [0.01; 3]);
    // The boxes of these octahedra overlap where they are, and lie apart where they are turned, under the union.
    let [conventional, chain, exact] = beside_a_ball(Octahedron, Octahedron, [1.1, 1.1, 0.0]);
    assert!(off(exact, ball) < 1e-14 && chain.size().max_element() < 0.03);
    assert!(conventional.size().max_element() > 0.5);
    // Those of these overlap in both frames.
    for (one, other, offset) in [
        (Octahedron, Octahedron, [1.01, 0.01, 1.0]),
        (Octahedron, Octahedron, [0.7, 0.7, 0.7]),
        (Sphere, Sphere, [1.2, 1.0, 1.3]),
        (Sphere, Cube, [1.6, 1.6, 1.6]),
        (Cone, Cone, [1.0, 0.5, 0.9]),
    ] {
        let [_, chain, exact] = beside_a_ball(one, other, offset);
        assert!(off(exact, ball) < 1e-14, "{one:?} {other:?} {exact:?}");
        assert!(chain.size().max_element() > 0.1, "{one:?} {other:?} {chain:?}");
    }
}

#[test]
fn operands_that_touch_leave_a_point() {
    let diagonal = 2.0 / 3_f64.sqrt();
    for (one, other, offset) in [
        (Octahedron, Octahedron, [1.0, 1.0, 0.0]),
        (Octahedron, Octahedron, [0.5, 0.5, 1.0]),
        (Sphere, Sphere, [1.2, 1.6, 0.0]),
        (Sphere, Sphere, [diagonal; 3]),
        (Sphere, Cube, [2.0, 0.0, 0.0]),
        (Cone, Cube, [-1.5, 0.5, 1.5]),
    ] {
        let [_, _, exact] = beside_a_ball(one, other, offset);
        assert!(exact.size().max_element() > 0.2, "{one:?} {other:?} {exact:?}");
    }
}

#[test]
fn boxes_enclose_what_rounding_loses() {
    // At 1e16 there are no odd numbers: a cube moved there and back has no extent left.
    for turn in [0.0, 90.0, 30.0] {
        let mut b = GraphBuilder::new();
        let cube = b.primitive(Cube, []);
        let there = mapped(&mut b, Move, [1e16, 0.0, 0.0], cube);
        let back = mapped(&mut b, Move, [-1e16, 0.0, 0.0], there);
        let turned = mapped(&mut b, RotZ, [turn], back);
        let large = mapped(&mut b, UScale, [1e6], turned);
        let found = boxes(&b.finish(large).unwrap());
        assert!(found.nodes[back.index()].encloses(Aabb::new(DVec3::NEG_ONE, DVec3::ONE)));
        assert!(found.root.encloses(Aabb::new(DVec3::splat(-1e6), DVec3::splat(1e6))));
    }
}

#[test]
fn what_overflows_has_no_end() {
    let mut b = GraphBuilder::new();
    let cube = b.primitive(Cube, []);
    let large = mapped(&mut b, UScale, [1e200], cube);
    let beyond = mapped(&mut b, UScale, [1e200], large);
    let turned = mapped(&mut b, RotZ, [45.0], beyond);
    let found = boxes(&b.finish(turned).unwrap());
    assert!(found.nodes[large.index()].is_bounded());
    assert_eq!(found.nodes[beyond.index()], Aabb::ALL);
    assert_eq!(found.root, Aabb::ALL);
}

#[test]
fn a_gap_that_is_none_is_as_close_as_rounding_allows() {
    for graph in [sympodial(6), sierpinski(4)] {
        let with_gap = |gap| exact(&graph, &Limits::default().with_gap(gap)).unwrap().root;
        let least = with_gap(0.0);
        assert!(off(least, boxes(&graph).root) < 1e-11);
        assert_eq!([-1.0, f64::NEG_INFINITY, f64::NAN].map(with_gap), [least; 3]);
        assert!(with_gap(f64::INFINITY).encloses(least));
    }
}

/// Copies of a cube turned about its own centre, 2⁴⁰ of them: no bound tells them apart.
#[test]
fn work_is_limited_and_the_gap_certified() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 40.0);
    let symbol = b.symbol("X");
    let cube = b.primitive(Cube, []);
    let copies = [(RotX, 37.0), (RotZ, 7.0)].map(|(kind, angle)| mapped(&mut b, kind, [angle], symbol));
    let both = b.union(copies);
    let step = b.calculate([(n, Expr::from(n) - 1.0)], both);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [cube, step]);
    let graph = b.finish(symbol).unwrap();
    let found = exact(&graph, &Limits::default().with_expansions(100)).unwrap();
    assert!(found.counts.expansions <= 100 * found.counts.queries);
    assert!(found.root.encloses(Aabb::new(DVec3::splat(-1.4), DVec3::splat(1.4))));
    // All of it is in the ball of radius √3.
    let excess = found.root.max - 3.0_f64.sqrt();
    assert!(
        excess.max_element() > 0.1 && excess.max_element() <= found.gap,
        "{:?} {}",
        found.root,
        found.gap
    );
    let stingy = exact(&graph, &Limits::default().with_expansions(0)).unwrap();
    assert_eq!(stingy.counts.expansions, 0);
    assert!(stingy.root.encloses(found.root));
    assert!(conventional(&sympodial(4), &Limits::default()).unwrap().root.volume() > 0.0);
}

#[test]
fn a_larger_gap_is_a_larger_box_by_no_more() {
    let graph = sympodial(60);
    let tight = boxes(&graph);
    let loose = exact(&graph, &Limits::default().with_gap(1e-2)).unwrap();
    assert!(loose.counts.expansions < tight.counts.expansions / 2);
    assert!(loose.gap < 1e-1);
    for (state, found) in loose.states() {
        let least = tight.of(state).unwrap().aabb;
        assert!(Aabb::new(found.aabb.min - 1e-11, found.aabb.max + 1e-11).encloses(least));
        assert!(off(found.aabb, least) <= found.gap + 1e-11, "{found:?} {least:?}");
    }
}

#[test]
fn recursion_that_never_ends_names_its_cycle() {
    let cycle = |factor: f64| {
        let mut b = GraphBuilder::new();
        let symbol = b.symbol("X");
        let cube = b.primitive(Cube, []);
        let again = mapped(&mut b, UScale, [factor], symbol);
        let both = b.operator(Operator::Union, cube, again);
        b.rules(symbol, None, [both]);
        b.finish(symbol).unwrap()
    };
    let error = exact(&cycle(1.2), &Limits::default()).map(|_| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the recursion never ends: X → ∪ → uscale leads back to itself and grows by a factor of 1.2000 each time round"
    );
    assert!(matches!(error, BoundsError::Endless { cycle, .. } if cycle == ["X", "∪", "uscale"]));
    let found = boxes(&cycle(0.5));
    assert!(off(found.root, aabb([-1.0; 3], [1.0; 3])) < 1e-11, "{:?}", found.root);
    assert_eq!(found.endless.map(|endless| endless.states), Some(3));
}

#[test]
fn recursion_with_ever_new_values_is_stopped() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 0.0);
    let symbol = b.symbol("X");
    let cube = b.primitive(Cube, []);
    let again = b.calculate([(n, Expr::from(n) + 1.0)], symbol);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(-1.0), 2.0, 1.0)), [cube, again]);
    let graph = b.finish(symbol).unwrap();
    let limits = Limits::default().with_states(1_000);
    let error = exact(&graph, &limits).map(|_| ()).unwrap_err();
    assert_eq!(error, BoundsError::TooManyStates { limit: 1_000 });
    assert!(error.to_string().contains("raise `Limits::states`"));
    assert!(root_box(&graph, &limits).is_err());
}

#[test]
fn errors_of_the_scene_are_passed_on() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 0.0);
    let symbol = b.symbol("X");
    let cube = b.primitive(Cube, []);
    b.rules(symbol, Some(Expr::from(n)), [cube]);
    let result = exact(&b.finish(symbol).unwrap(), &Limits::default());
    assert!(matches!(result.map(|_| ()), Err(BoundsError::Scene(_))));
}

/// A graph whose states hash in another order.
struct Salted(Graph, u64);

#[derive(Clone, PartialEq, Eq)]
struct SaltedState(State, u64);

impl Hash for SaltedState {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.1.hash(hasher);
        self.0.hash(hasher);
    }
}

impl Scene for Salted {
    type State = SaltedState;
    type Map = Transform;
    type Shape = Primitive;
    type Error = EvalError;

    fn root(&self) -> SaltedState {
        SaltedState(self.0.root_state(), self.1)
    }

    fn step(&self, state: &SaltedState) -> Result<Step<Self>, EvalError> {
        let salted = |below| SaltedState(below, self.1);
        Ok(match Scene::step(&self.0, &state.0)? {
            Step::Shape(shape) => Step::Shape(shape),
            Step::Same(below) => Step::Same(salted(below)),
            Step::Map(map, below) => Step::Map(map, salted(below)),
            Step::Union(parts) => Step::Union(parts.into_iter().map(salted).collect()),
            Step::Intersection(operands) => Step::Intersection(operands.map(salted)),
            Step::Difference(operands) => Step::Difference(operands.map(salted)),
        })
    }

    fn node(&self, state: &SaltedState) -> usize {
        Scene::node(&self.0, &state.0)
    }

    fn node_count(&self) -> usize {
        Scene::node_count(&self.0)
    }
}

#[test]
fn results_do_not_depend_on_hash_order() {
    let graph = sympodial(9);
    let found = boxes(&graph);
    for salt in 0..4 {
        let salted = exact(&Salted(sympodial(9), salt), &Limits::default()).unwrap();
        assert_eq!((salted.root, &salted.nodes, salted.counts), (found.root, &found.nodes, found.counts));
        assert!(salted.states().map(|(state, found)| (&state.0, found)).eq(found.states()));
    }
}

#[test]
fn the_finest_part_is_the_last_with_parts_in_it() {
    let share = |levels: u32| boxes(&sierpinski(levels)).finest();
    assert!(share(0).is_infinite(), "a primitive has no parts");
    // Two of the four last tetrahedra, which are a union in that of all four.
    for levels in [1, 2, 10, 60, 1000] {
        let half = libm::ldexp(1.0, 1 - levels);
        let found = share(levels.unsigned_abs());
        assert!(found > 0.8 * half && found < half, "{levels} levels: {found}");
    }
    // What clips them may have no end.
    let mut b = GraphBuilder::new();
    let [sphere, cube] = [Sphere, Cube].map(|kind| b.primitive(kind, []));
    let both = b.union([sphere, cube]);
    let small = mapped(&mut b, UScale, [1e-9], both);
    let ground = b.primitive(HalfSpace, []);
    let clipped = b.operator(Operator::Intersection, ground, small);
    let all = b.union([cube, clipped]);
    let finest = boxes(&b.finish(all).unwrap()).finest();
    assert!(finest > 0.4e-9 && finest < 1.1e-9, "{finest}");
}

/// Its unfolded tree has 2 to the power of `levels` leaves.
fn dag(levels: u32) -> Dag {
    Dag { levels, turns: [-0.5, 0.8] }
}

#[test]
fn a_dag_of_90_000_states() {
    let found = exact(&dag(30_000), &Limits::default()).unwrap();
    assert_eq!(found.counts.states, 90_001);
    assert!(found.gap < 1e-10, "{}", found.gap);
    // Far from the leaves, one level more makes no difference.
    assert!(off(found.root, exact(&dag(100), &Limits::default()).unwrap().root) < 1e-9);
    // Close to them, the chain algorithm can do it: a cuboid is its point set.
    let few = exact(&dag(10), &Limits::default()).unwrap();
    let chain = chain(&dag(10), &Limits::default()).unwrap();
    assert!(off(few.root, chain.root) < 1e-11);
    assert!(few.nodes.iter().zip(&chain.nodes).all(|(few, chain)| off(*few, *chain) < 1e-11));
    assert_eq!(few.into_hyper_boxes().nodes.len(), 2);
}
