//! S-bounds, and branch and bound on the solid: against answers that are known and against points.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

#[path = "../examples/states/solids.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod solids;

use std::convert::Infallible;
use std::rc::Rc;
use std::sync::Arc;

use common::{Instance, Kind, recipes, unfold};
use csg_graph::{Graph, GraphBuilder, NodeId, Operator, Primitive, PrimitiveKind, TransformKind};
use csg_graph_bounds::{
    Aabb, Cell, ExactBoxes, Limits, PointSet, Refinement, Scene, Shape, Side, Slabs, SolidBox, Step, Volume,
    exact,
};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use solids::{cheese, cone_tower, mapped};

use Operator::{Difference, Intersection, Union};
use PrimitiveKind::{Cube, Cylinder, HalfSpace, Sphere};
use TransformKind::{Move, RotX, RotY, RotZ};

fn boxes(graph: &Graph) -> ExactBoxes<Graph> {
    exact(graph, &Limits::default()).unwrap()
}

fn build(solid: impl FnOnce(&mut GraphBuilder) -> NodeId) -> Graph {
    let mut builder = GraphBuilder::new();
    let root = solid(&mut builder);
    builder.finish(root).unwrap()
}

fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb::new(min.into(), max.into())
}

fn off(a: Aabb, b: Aabb) -> f64 {
    if a == b { 0.0 } else { (a.min - b.min).abs().max((a.max - b.max).abs()).max_element() }
}

fn search(graph: &Graph) -> SolidBox {
    boxes(graph).root_solid(&Refinement::default()).aabb()
}

/// Two unit balls, their centers 1.6 apart.
fn lens(b: &mut GraphBuilder) -> NodeId {
    let ball = b.primitive(Sphere, []);
    let [low, high] = [-0.8, 0.8].map(|z| mapped(b, Move, [0.0, 0.0, z], ball));
    b.operator(Intersection, low, high)
}

#[test]
fn lens_of_two_balls() {
    let graph = build(lens);
    let least = aabb([-0.6, -0.6, -0.2], [0.6, 0.6, 0.2]);
    let boxes = boxes(&graph);
    assert!(off(boxes.s_bounds(&graph).root, aabb([-1.0, -1.0, -0.2], [1.0, 1.0, 0.2])) < 1e-12);
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let refinement = Refinement::default().with_tolerance(tolerance);
        let found = boxes.root_solid(&refinement).aabb();
        assert!(found.aabb.encloses(least), "{found:?}");
        assert!(found.gap <= 2.0 * tolerance && off(found.aabb, least) <= found.gap, "{found:?}");
    }
}

#[test]
fn any_direction_and_other_volumes() {
    let turned = build(|b| {
        let lens = lens(b);
        mapped(b, RotX, [37.0], lens)
    });
    let boxes = boxes(&turned);
    let mut search = boxes.root_solid(&Refinement::default());
    let (sin, cos) = libm::sincos(37_f64.to_radians());
    // Across the lens, and in its plane; of any length.
    for (direction, exact) in [(DVec3::new(0.0, -sin, cos), 0.2), (DVec3::new(0.0, cos, sin), 0.6)] {
        for length in [1.0, 1e-3, 1e5] {
            let found = search.support(length * direction);
            assert!(length * exact <= found.upper && found.upper <= length * exact + found.gap + 1e-9);
            assert!(found.gap <= 2e-3 * length);
        }
    }
    let slabs = Slabs::<13>::from_support(|d| search.support(d).upper);
    assert!(slabs.volume() < 0.5 * boxes.root.volume());
    assert!(search.counts().cells > 0);
}

#[test]
fn half_spaces_and_de_morgan() {
    let half_space = |b: &mut GraphBuilder, z: f64| {
        let half_space = b.primitive(HalfSpace, []);
        mapped(b, Move, [0.0, 0.0, z], half_space)
    };
    let upper = aabb([-1.0, -1.0, 0.25], [1.0, 1.0, 1.0]);
    type Build<'a> = &'a dyn Fn(&mut GraphBuilder) -> NodeId;
    let cases: [(Build<'_>, Aabb); 6] = [
        (
            &|b| {
                let (cube, lower) = (b.primitive(Cube, []), half_space(b, 0.25));
                b.operator(Difference, cube, lower)
            },
            upper,
        ),
        // A \ (B ∪ C)
        (
            &|b| {
                let (cube, lower, other) = (b.primitive(Cube, []), half_space(b, 0.25), half_space(b, -0.5));
                let both = b.operator(Union, lower, other);
                b.operator(Difference, cube, both)
            },
            upper,
        ),
        // A \ (B ∩ C)
        (
            &|b| {
                let (cube, lower, other) = (b.primitive(Cube, []), half_space(b, 0.25), half_space(b, 0.5));
                let both = b.operator(Intersection, lower, other);
                b.operator(Difference, cube, both)
            },
            upper,
        ),
        // A \ (B \ C) where C does not matter: its part in B is below A.
        (
            &|b| {
                let (cube, lower, far) = (b.primitive(Cube, []), half_space(b, 0.25), half_space(b, -7.0));
                let rest = b.operator(Difference, lower, far);
                b.operator(Difference, cube, rest)
            },
            aabb([-1.0; 3], [1.0; 3]),
        ),
        // Turned by a quarter, about two axes.
        (
            &|b| {
                let (cube, lower) = (b.primitive(Cube, []), half_space(b, 0.25));
                let turned = mapped(b, RotY, [90.0], lower);
                let turned = mapped(b, RotZ, [-90.0], turned);
                b.operator(Difference, cube, turned)
            },
            aabb([-1.0, -1.0, -1.0], [1.0, -0.25, 1.0]),
        ),
        // What is above z = 0.25 and below -0.5.
        (
            &|b| {
                let (cube, lower, least) = (b.primitive(Cube, []), half_space(b, 0.25), half_space(b, -0.5));
                let cut = b.operator(Difference, cube, lower);
                b.operator(Intersection, cut, least)
            },
            Aabb::EMPTY,
        ),
    ];
    for (case, (solid, expected)) in cases.iter().enumerate() {
        let graph = build(solid);
        let boxes = boxes(&graph);
        let found = boxes.s_bounds(&graph).root;
        assert!(off(found, *expected) < 1e-12, "case {case}: {found:?}");
        let searched = boxes.root_solid(&Refinement::default()).aabb();
        // With C, only what is between -7 and 0.25 is cut off.
        let least = if case == 3 { upper } else { *expected };
        assert!(off(searched.aabb, least) < 2e-3, "case {case}: {searched:?}");
    }
}

#[test]
fn turned_half_space_cuts_to_a_tolerance() {
    let graph = build(|b| {
        let (cube, half_space) = (b.primitive(Cube, []), b.primitive(HalfSpace, []));
        let turned = mapped(b, RotX, [60.0], half_space);
        let moved = mapped(b, Move, [0.0, 0.0, -1.0], turned);
        b.operator(Difference, cube, moved)
    });
    // The plane z + 1 = √3 y leaves what is above it: y ≤ (z + 1) / √3, which is at most 2 / √3 > 1.
    let found = search(&graph);
    assert!(off(found.aabb, aabb([-1.0; 3], [1.0; 3])) < 2e-3);
    let graph = build(|b| {
        let (cube, half_space) = (b.primitive(Cube, []), b.primitive(HalfSpace, []));
        let turned = mapped(b, RotX, [60.0], half_space);
        let moved = mapped(b, Move, [0.0, 0.5, 1.0], turned);
        b.operator(Difference, cube, moved)
    });
    // y ≤ 0.5 + (z - 1) / √3
    let top = 0.5;
    let found = search(&graph);
    assert!(top <= found.aabb.max.y && found.aabb.max.y <= top + found.gap, "{found:?}");
    assert!(found.gap < 2e-3);
}

#[test]
fn context_is_joined_over_all_uses() {
    // A ball that is cut in one place and whole in another.
    let shared = build(|b| {
        let (ball, cube) = (b.primitive(Sphere, []), b.primitive(Cube, []));
        let corner = mapped(b, Move, [1.5, 0.0, 0.0], cube);
        let cut = b.operator(Intersection, ball, corner);
        let whole = mapped(b, Move, [0.0, 5.0, 0.0], ball);
        b.operator(Union, cut, whole)
    });
    let boxes_of = |graph: &Graph| {
        // It is made first.
        let ball = 0;
        let exact = boxes(graph);
        let bounds = exact.s_bounds(graph);
        (bounds.contexts[ball], bounds.root)
    };
    let (ball, root) = boxes_of(&shared);
    assert!(off(ball, aabb([-1.0; 3], [1.0; 3])) < 1e-12, "{ball:?}");
    assert!(off(root, aabb([-1.0, -1.0, -1.0], [1.0, 6.0, 1.0])) < 1e-12, "{root:?}");

    let alone = build(|b| {
        let (ball, cube) = (b.primitive(Sphere, []), b.primitive(Cube, []));
        let corner = mapped(b, Move, [1.5, 0.0, 0.0], cube);
        b.operator(Intersection, ball, corner)
    });
    let (ball, _) = boxes_of(&alone);
    assert!(off(ball, aabb([0.5, -1.0, -1.0], [1.0; 3])) < 1e-12, "{ball:?}");
}

#[test]
fn nothing_is_left_of_a_solid_without_itself() {
    let graph = build(|b| {
        let ball = b.primitive(Sphere, []);
        let moved = mapped(b, Move, [0.3, 0.0, 0.0], ball);
        b.operator(Difference, moved, moved)
    });
    assert_eq!(search(&graph).aabb, Aabb::EMPTY);
    // Two instances that coincide leave a film, which counts; but the search ends.
    let graph = build(|b| {
        let ball = b.primitive(Sphere, []);
        let [one, two] = [0.3, 0.3].map(|x| mapped(b, Move, [x, 0.0, 0.0], ball));
        b.operator(Difference, one, two)
    });
    let found = search(&graph);
    assert!(found.gap.is_infinite() || found.aabb.is_empty());
    assert!(found.counts.cells < 200_000, "{found:?}");
    // Operands of which any two meet, but not all three.
    let graph = build(|b| {
        let ball = b.primitive(Sphere, []);
        let [beside, above] = [[1.9, 0.0, 0.0], [0.95, 1.645, 0.0]].map(|at| mapped(b, Move, at, ball));
        let lens = b.operator(Intersection, ball, beside);
        b.operator(Intersection, lens, above)
    });
    assert!(!boxes(&graph).root.is_empty());
    assert_eq!(search(&graph).aabb, Aabb::EMPTY);
}

/// A cheese, cut.
fn cut_cheese(n: u32) -> Graph {
    build(|b| {
        let (cheese, half_space) = (cheese(b, n), b.primitive(HalfSpace, []));
        let plane = mapped(b, Move, [0.0, 0.0, 0.3], half_space);
        b.operator(Intersection, cheese, plane)
    })
}

#[test]
fn deep_recursion_is_opened_only_where_it_matters() {
    let found = search(&cut_cheese(40));
    assert!(off(found.aabb, aabb([-1.0; 3], [1.0, 1.0, 0.3])) < 0.01, "{found:?}");
    // A hundred thousand levels, all of them below an intersection.
    let graph = cone_tower(100_000, 0.9);
    let found = boxes(&graph).root_solid(&Refinement::default()).aabb();
    assert!(off(found.aabb, boxes(&graph).root) < 1e-9);
}

/// A scene whose shapes have the default classification.
struct Bare;

impl Scene for Bare {
    type State = u8;
    type Map = DAffine3;
    type Shape = Ball;
    type Error = Infallible;

    fn root(&self) -> u8 {
        0
    }

    fn step(&self, state: &u8) -> Result<Step<Self>, Infallible> {
        let moved = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
        Ok(match state {
            0 => Step::Intersection([1, 2]),
            1 => Step::Map(moved(-0.8), 3),
            2 => Step::Map(moved(0.8), 3),
            _ => Step::Shape(Ball),
        })
    }

    fn node(&self, state: &u8) -> usize {
        usize::from(*state)
    }

    fn node_count(&self) -> usize {
        4
    }
}

struct Ball;

impl Shape for Ball {
    fn bounds(&self) -> Aabb {
        aabb([-1.0; 3], [1.0; 3])
    }

    fn point_set(&self) -> csg_graph_bounds::PointSet<'_> {
        csg_graph_bounds::PointSet::sphere()
    }

    fn support(&self, direction: DVec3) -> f64 {
        direction.length()
    }
}

#[test]
fn shapes_without_a_classification_of_their_own_still_bound() {
    let boxes = exact(&Bare, &Limits::default()).unwrap();
    let found = boxes.root_solid(&Refinement::default()).aabb();
    let least = aabb([-0.6, -0.6, -0.2], [0.6, 0.6, 0.2]);
    assert!(found.aabb.encloses(least) && off(found.aabb, least) < 1e-3, "{found:?}");
    assert!(found.gap.is_infinite());
    assert!(boxes.solid(&9, &Refinement::default()).is_none());
}

/// The solid with every node cut off at the context of its state.
fn contains_cut(instance: &Instance, context: &dyn Fn(&Instance) -> Aabb, p: DVec3) -> bool {
    let below = |below: &Instance, p: DVec3| contains_cut(below, context, p);
    context(instance).contains(p)
        && match &instance.kind {
            Kind::Primitive(_) => instance.contains(p),
            Kind::Same(operand) => below(operand, p),
            Kind::Map(map, operand) => below(operand, map.inverse_point(p)),
            Kind::Operator(operator, operands) => {
                let [left, right] = operands.each_ref().map(|operand| below(operand, p));
                match operator {
                    Union => left || right,
                    Intersection => left && right,
                    Difference => left && !right,
                }
            }
        }
}

fn grid(bounds: Aabb, steps: u32) -> impl Iterator<Item = DVec3> {
    let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
    (0..steps * steps * steps).map(move |i| {
        let share = DVec3::new(at(i % steps), at(i / steps % steps), at(i / steps / steps));
        bounds.min + bounds.size() * share
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_point_of_a_random_solid_escapes(recipe in recipes()) {
        let graph = recipe.graph();
        let tree = unfold(&graph, &graph.root_state());
        let exact = boxes(&graph);
        let cut = exact.s_bounds(&graph);
        let refinement = Refinement::default().with_tolerance(1e-2).with_cells(3000);
        let found = exact.root_solid(&refinement).aabb();
        prop_assert!(exact.root.encloses(cut.root) || exact.root == cut.root);
        prop_assert!(exact.root.encloses(found.aabb), "{:?} {:?}", exact.root, found);
        let margin = 1e-9 * exact.root.size().max_element();
        let grown = |bounds: Aabb| Aabb::new(bounds.min - margin, bounds.max + margin);
        let context = |instance: &Instance| grown(cut.context_of(&instance.state).unwrap());
        let mut points: Vec<DVec3> = grid(exact.root, 14).collect();
        points.extend(tree.sample(&mut |_, _| {}));
        for p in points {
            let contains = tree.contains(p);
            if contains {
                prop_assert!(grown(cut.root).contains(p), "{p} {:?}", cut.root);
                prop_assert!(grown(found.aabb).contains(p), "{p} {:?}", found.aabb);
            }
            // Points of surfaces may go either way.
            if exact.root.contains(p) && tree.contains(p + 1e-7) == contains {
                prop_assert_eq!(contains_cut(&tree, &context, p), contains, "{}", p);
            }
        }
    }

    #[test]
    fn classified_cells_are_where_their_points_are(
        kind in common::primitives(),
        half_space in prop::bool::weighted(0.1),
        center in prop::array::uniform3(-1.4..1.4),
        columns in prop::array::uniform9(-0.5..0.5),
        size in prop::sample::select(vec![1.0, 0.3, 0.1, 0.0]),
        slack in prop::sample::select(vec![0.0, 0.05]),
    ) {
        let common::Term::Primitive(kind, args) = kind else { unreachable!() };
        let primitive = if half_space { Primitive::HalfSpace } else { kind.evaluate(&args).unwrap() };
        let axes = size * DMat3::from_cols_array(&columns);
        let cell = Cell::new(DVec3::from_array(center), axes).with_slack(slack);
        let side = primitive.classify(&cell);
        prop_assert!(size > 0.0 || slack > 0.0 || side != Side::Mixed);
        let unit = aabb([-1.0; 3], [1.0; 3]);
        for t in grid(unit, 6).chain(unit.corners()) {
            for s in common::directions().step_by(7) {
                let p = cell.center + axes * t + slack * s;
                let contains = common::inside(&primitive, p);
                prop_assert!(side != Side::Outside || !contains, "{p}");
                prop_assert!(side != Side::Inside || contains, "{p}");
            }
        }
    }
}

#[test]
fn what_points_to_a_shape_is_that_shape() {
    /// All that a shape is asked, through as many pointers as one likes.
    fn answers(shape: impl Shape) -> (Aabb, usize, f64, Aabb, [Side; 2]) {
        let points = match shape.point_set() {
            PointSet::Points(points) => points.len(),
            PointSet::Unbounded => usize::MAX,
        };
        let cells = [aabb([-0.1; 3], [0.1; 3]), aabb([3.0; 3], [4.0; 3])].map(Cell::from);
        let support = shape.support(DVec3::new(1.0, -2.0, 0.5));
        (shape.bounds(), points, support, shape.complement_bounds(), cells.map(|cell| shape.classify(&cell)))
    }
    for kind in [Sphere, HalfSpace] {
        let shape = || kind.evaluate(&[]).unwrap();
        let expected = answers(shape());
        let owned = shape();
        let borrowed: &Primitive = &owned;
        assert_eq!(answers(borrowed), expected);
        assert_eq!(answers(Box::new(shape())), expected);
        assert_eq!(answers(Rc::new(shape())), expected);
        let shared: Arc<dyn Shape> = Arc::new(shape());
        assert_eq!(answers(&shared), expected);
    }
}

#[test]
fn classification_is_sharp() {
    let cylinder = Cylinder.evaluate(&[]).unwrap();
    let beside = Cell::from(aabb([0.72, 0.72, 0.2], [1.5, 1.5, 0.4]));
    assert_eq!(cylinder.classify(&beside), Side::Outside);
    let torus = PrimitiveKind::Torus.evaluate(&[0.3]).unwrap();
    assert_eq!(torus.classify(&Cell::from(aabb([-0.4, -0.4, -0.1], [0.4, 0.4, 0.1]))), Side::Outside);
    assert_eq!(torus.classify(&Cell::from(aabb([0.9, -0.1, -0.1], [1.1, 0.1, 0.1]))), Side::Inside);
    let half = Aabb { max: DVec3::INFINITY.with_x(2.0), ..Aabb::ALL };
    assert_eq!(half.complement_bounds(), Aabb { min: DVec3::NEG_INFINITY.with_x(2.0), ..Aabb::ALL });
    assert_eq!(half.classify(&Cell::point(DVec3::ZERO)), Side::Inside);
    assert_eq!(Aabb::ALL.complement_bounds(), Aabb::EMPTY);
    assert_eq!(Aabb::EMPTY.complement_bounds(), Aabb::ALL);
    assert_eq!(aabb([0.0; 3], [1.0; 3]).complement_bounds(), Aabb::ALL);
}
