//! The fast engine against the walk.
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "common/agreement.rs"]
mod agreement;
mod common;
#[path = "common/sierpinski.rs"]
mod sierpinski;

use csg_graph::{Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Envelopes, Limits, exact};
use csg_graph_trace::{Accelerated, Camera, Footprint, PACKET, Ray, StateBounds, Walk, brute};
use glam::DVec3;
use proptest::prelude::*;

use agreement::{CLEARANCE, agree};
use sierpinski::sierpinski;

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
        let bounds = if budget == 0 {
            StateBounds::Exact(Box::new(exact(&graph, &Limits::default()).unwrap()))
        } else {
            StateBounds::Envelopes(Box::new(Envelopes::new(graph.clone(), &Limits::default())))
        };
        let on_demand = Accelerated::on_demand(graph.clone(), bounds, budget).unwrap();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let mut fast = scene.tracer();
        let mut lazy = on_demand.tracer();
        let rays: Vec<Ray> =
            places.into_iter().map(|(place, from)| common::ray_into(&hyper_boxes.root, place, from)).collect();
        let mut hits = vec![None; PACKET];
        fast.nearest_of(&rays, &mut hits);
        let mut found = vec![None; PACKET];
        lazy.nearest_of(&rays, &mut found);
        let ends: Vec<f64> = (0..PACKET).map(|lane| 0.2 * lane as f64).collect();
        let shadowed = fast.occluded_of(&rays, &ends);
        for (lane, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            prop_assert_eq!(&fast.nearest(ray), hit, "alone and in a packet");
            prop_assert_eq!(&lazy.nearest(ray), &found[lane], "alone and in a packet, on demand");
            if brute::line(&tree, ray).clearance < CLEARANCE {
                continue;
            }
            let expected = walk.nearest(ray).unwrap();
            prop_assert!(agree(expected.as_ref(), hit.as_ref()), "{ray:?}\n{expected:?}\n{hit:?}");
            prop_assert!(agree(expected.as_ref(), found[lane].as_ref()), "on demand");
            let is_shadowed = walk.occluded(ray, ends[lane]).unwrap();
            if expected.is_none_or(|hit| (hit.t - ends[lane]).abs() > 1e-9) {
                prop_assert_eq!(shadowed >> lane & 1 == 1, is_shadowed, "{:?} before {}", ray, ends[lane]);
                prop_assert_eq!(fast.occluded(ray, ends[lane]), is_shadowed);
                prop_assert_eq!(lazy.occluded(ray, ends[lane]), is_shadowed);
            }
        }
    }
}

#[test]
fn definitions_that_are_used_twice_are_not_written_out_for_ever() {
    // A row of balls, twice as long with each definition: 2⁴⁰ of them in one rule.
    let mut builder = GraphBuilder::new();
    let mut row = builder.primitive(PrimitiveKind::Sphere, []);
    for level in 0..40 {
        let offset = (4_u64 << level) as f64;
        let other = builder.transform(TransformKind::Move, [offset, 0.0, 0.0].map(Expr::from), row);
        row = builder.union([row, other]);
    }
    let graph = builder.finish(row).unwrap();
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let whole = Accelerated::new(&graph, &boxes, 4096).unwrap();
    let bounds = StateBounds::Exact(Box::new(exact(&graph, &Limits::default()).unwrap()));
    let on_demand = Accelerated::on_demand(graph.clone(), bounds, 1 << 20).unwrap();
    for number in [0.0, 1.0, 999.0, 1e9] {
        let ray = Ray { origin: DVec3::new(4.0 * number, 0.0, 9.0), direction: DVec3::NEG_Z };
        for engine in [&whole, &on_demand] {
            let hit = engine.tracer().nearest(&ray).unwrap();
            assert!((hit.t - 8.0).abs() < 1e-6, "ball {number}: {hit:?}");
        }
        let between = Ray { origin: ray.origin + DVec3::X * 2.0, ..ray };
        assert!(whole.tracer().nearest(&between).is_none());
    }
}

#[test]
fn what_coincides_is_there_once() {
    // Balls in a row, with each level two of one before: after forty, 2⁴⁰ balls in forty-one places.
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", 40.0);
    let symbol = builder.symbol("ROW");
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let moved = builder.transform(TransformKind::Move, [4.0, 0.0, 0.0].map(Expr::from), symbol);
    let both = builder.union([symbol, moved, symbol]);
    let less = builder.calculate([(n, Expr::from(n) - 1.0)], both);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [ball, less]);
    let graph = builder.finish(symbol).unwrap();
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap();
    let mut tracer = scene.tracer();
    for number in 0..41 {
        let ray = Ray { origin: DVec3::new(4.0 * f64::from(number), 0.0, 9.0), direction: DVec3::NEG_Z };
        assert_eq!(tracer.nearest(&ray).map(|hit| hit.t), Some(8.0));
        assert!(tracer.nearest(&Ray { origin: ray.origin + DVec3::X * 2.0, ..ray }).is_none());
    }
    assert!(tracer.take_counters().primitive_tests < 100);
}

#[test]
fn rays_of_any_length_may_go_together() {
    let graph = sierpinski(4.0);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap();
    let mut tracer = scene.tracer();
    let rays: [Ray; PACKET] = std::array::from_fn(|lane| {
        let aside = 0.5 + 0.002 * lane as f64;
        let direction = DVec3::new(0.01, -0.02, -1.0) * [1.0, 1e-9, 1e-18, 1e-27][lane % 4];
        Ray { origin: DVec3::new(aside, aside, 9.0), direction }
    });
    let mut together = [const { None }; PACKET];
    tracer.nearest_of(&rays, &mut together);
    assert!(together.iter().flatten().count() > 4);
    for (ray, hit) in rays.iter().zip(&together) {
        assert_eq!(tracer.nearest(ray).map(|hit| hit.t), hit.as_ref().map(|hit| hit.t));
    }
}

/// Cubes in a lattice, whose faces coincide exactly, and operators over them.
#[derive(Clone, Debug)]
enum Lattice {
    Cube { offset: [i32; 3], size: i32 },
    Half { height: i32 },
    Operator(Operator, Box<Lattice>, Box<Lattice>),
}

fn lattice() -> impl Strategy<Value = Lattice> {
    let cube =
        (prop::array::uniform3(-2..=2), 1..=2).prop_map(|(offset, size)| Lattice::Cube { offset, size });
    let half = (-2..=2).prop_map(|height| Lattice::Half { height });
    let operators = vec![Operator::Union, Operator::Intersection, Operator::Difference];
    prop_oneof![5 => cube, 1 => half].prop_recursive(5, 20, 2, move |inner| {
        (prop::sample::select(operators.clone()), inner.clone(), inner)
            .prop_map(|(operator, left, right)| Lattice::Operator(operator, Box::new(left), Box::new(right)))
    })
}

fn add(builder: &mut GraphBuilder, term: &Lattice) -> NodeId {
    let half = |number: i32| Expr::from(f64::from(number) * 0.5);
    match term {
        Lattice::Cube { offset, size } => {
            let cube = builder.primitive(PrimitiveKind::Cube, []);
            let cube = builder.transform(TransformKind::UScale, [half(*size)], cube);
            builder.transform(TransformKind::Move, offset.map(half), cube)
        }
        Lattice::Half { height } => {
            let below = builder.primitive(PrimitiveKind::HalfSpace, []);
            builder.transform(TransformKind::Move, [half(0), half(0), half(*height)], below)
        }
        Lattice::Operator(operator, left, right) => {
            let operands = [left, right].map(|operand| add(builder, operand));
            builder.operator(*operator, operands[0], operands[1])
        }
    }
}

/// Rays from places with few digits, for which coincident faces are at exactly one t; also along faces, and from inside.
fn dyadic_rays() -> impl Iterator<Item = Ray> {
    let directions =
        [[-2.0, 3.0, -4.0], [2.0, -1.0, -3.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.5], [-1.0, 0.0, 2.0]];
    let origins = (0..7_i32).flat_map(|x| (0..7_i32).map(move |y| [x, y, x * 3 + y * 5]));
    origins.flat_map(move |[x, y, z]| {
        directions.map(|direction| {
            let direction = DVec3::from(direction);
            let place = DVec3::new(f64::from(x), f64::from(y), f64::from(z % 7)) * 0.375 - 1.125;
            let away = if (x + y) % 3 == 0 { 0.0 } else { 4.0 };
            Ray { origin: place - direction * away, direction }
        })
    })
}

/// Compares the engine with the walk on dyadic rays, to the last bit of t, and counts hits.
fn compare_exactly(graph: &Graph, budget: usize) -> usize {
    let boxes = exact(graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(graph, &boxes, budget).unwrap();
    let mut walk = Walk::new(graph, None);
    let mut fast = scene.tracer();
    let mut hits = 0;
    for ray in dyadic_rays() {
        let (expected, hit) = (walk.nearest(&ray).unwrap(), fast.nearest(&ray));
        assert!(agree(expected.as_ref(), hit.as_ref()), "{ray:?}\n{expected:?}\n{hit:?}");
        assert_eq!(expected.map(|hit| hit.t), hit.map(|hit| hit.t));
        hits += usize::from(hit.is_some());
    }
    hits
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn coincident_faces_are_those_of_the_walk(term in lattice(), budget in prop::sample::select(vec![0, 1 << 20])) {
        let bounded = Lattice::Cube { offset: [0; 3], size: 8 };
        for term in [term.clone(), Lattice::Operator(Operator::Intersection, Box::new(term), Box::new(bounded))] {
            let mut builder = GraphBuilder::new();
            let root = add(&mut builder, &term);
            // A half-space alone is no scene.
            if let Ok(graph) = builder.finish(root) {
                compare_exactly(&graph, budget);
            }
        }
    }
}

#[test]
fn cubes_with_shared_faces() {
    let cube = |offset| Box::new(Lattice::Cube { offset, size: 2 });
    let operator = |operator, left, right| Box::new(Lattice::Operator(operator, left, right));
    let hits = |term: Box<Lattice>| {
        let mut builder = GraphBuilder::new();
        let root = add(&mut builder, &term);
        compare_exactly(&builder.finish(root).unwrap(), 1 << 20)
    };
    let [here, above, on_top] = [[0, 0, 0], [0, 0, 2], [0, 0, 4]];
    let whole = hits(cube(here));
    assert!(whole > 100, "{whole} hits");
    assert_eq!(hits(operator(Operator::Difference, cube(here), cube(here))), 0);
    assert_eq!(hits(operator(Operator::Intersection, cube(here), cube(here))), whole);
    assert_eq!(hits(operator(Operator::Intersection, cube(here), cube(on_top))), 0);
    assert_eq!(hits(operator(Operator::Difference, cube(here), cube(on_top))), whole);
    assert!(hits(operator(Operator::Difference, cube(here), cube(above))) < whole);
    let both = || operator(Operator::Union, cube(here), cube(on_top));
    assert_eq!(
        hits(operator(Operator::Difference, both(), operator(Operator::Union, cube(on_top), cube(here)))),
        0
    );
    assert_eq!(hits(operator(Operator::Difference, both(), cube(on_top))), whole);
}

/// A cube less a hole in its middle, twenty of half the size around that, and so on. Their faces coincide where they are
/// cubes of half the size of their cells.
fn holes(kind: PrimitiveKind, size: f64, levels: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", levels);
    let cells = builder.symbol("HO");
    let hole = builder.primitive(kind, []);
    let hole = builder.transform(TransformKind::UScale, [Expr::from(size)], hole);
    let cell = builder.transform(TransformKind::UScale, [Expr::from(0.5)], cells);
    let mut all = hole;
    for at in 0..27 {
        let place = [at / 9, at / 3 % 3, at % 3].map(|place| 0.5 * f64::from(place - 1));
        if place.iter().filter(|coordinate| **coordinate == 0.0).count() < 2 {
            let moved = builder.transform(TransformKind::Move, place.map(Expr::from), cell);
            let deeper = builder.calculate([(n, Expr::from(n) - 1.0)], moved);
            all = builder.operator(Operator::Union, all, deeper);
        }
    }
    builder.rules(cells, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [all, hole]);
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let rest = builder.operator(Operator::Difference, cube, cells);
    builder.finish(rest).unwrap()
}

#[test]
fn rays_through_holes_need_not_be_alone() {
    for (kind, size) in [(PrimitiveKind::Sphere, 0.6), (PrimitiveKind::Cube, 0.5), (PrimitiveKind::Cone, 0.5)]
    {
        let graph = holes(kind, size, 2.0);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let hyper_boxes = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
        let scene = Accelerated::new(&graph, &boxes, 1 << 16).unwrap();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let mut tracer = scene.tracer();
        let (mut found, mut shadowed) = (0, 0);
        for square in 0..400 {
            // Some begin outside, some in holes, and some in the solid. They fall apart more and more.
            let aside = f64::from(square % 20) / 8.0 - 1.25 + 1.0 / 128.0;
            let from = DVec3::new(
                aside,
                f64::from(square / 20) / 8.0 - 1.25,
                [-3.0, -0.875, 0.875][square as usize % 3],
            );
            let spread = 1.0 / f64::from(1 << (square % 8));
            let rays: Vec<Ray> = (0..PACKET)
                .map(|lane| {
                    let [x, y] = [lane % 4, lane / 4].map(|step| step as f64 * spread);
                    Ray { origin: from, direction: DVec3::new(x - aside, y - from.y, 1.0 + 0.125 * x) }
                })
                .collect();
            let mut hits = vec![None; PACKET];
            tracer.nearest_of(&rays, &mut hits);
            // Some end in the solid or its holes, some beyond it.
            let end = [0.25, 1.5, 6.0, f64::INFINITY][square as usize / 3 % 4];
            let dark = tracer.occluded_of(&rays, &[end; PACKET]);
            for (lane, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
                assert_eq!(tracer.nearest(ray), *hit, "alone and in a packet");
                let is_dark = dark >> lane & 1 == 1;
                assert_eq!(tracer.occluded(ray, end), is_dark, "alone and in a packet, {ray:?} before {end}");
                assert_eq!(hit.is_some_and(|hit| hit.t < end), is_dark, "{ray:?} before {end}");
                let expected = walk.nearest(ray).unwrap();
                assert!(agree(expected.as_ref(), hit.as_ref()), "{kind:?} {ray:?}\n{expected:?}\n{hit:?}");
            }
            found += hits.iter().flatten().count();
            shadowed += dark.count_ones();
        }
        assert!(found > 300 && shadowed > 100, "{kind:?}: {found} hits, {shadowed} in shadow");
    }
}

/// A plate with `count`² holes.
fn drilled(count: i32) -> Graph {
    let mut builder = GraphBuilder::new();
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let size = f64::from(count);
    let mut plate = builder.transform(TransformKind::Scale, [size, size, 0.2].map(Expr::from), cube);
    let drill = builder.primitive(PrimitiveKind::Cylinder, []);
    let drill = builder.transform(TransformKind::Scale, [0.7, 0.7, 1.0].map(Expr::from), drill);
    for place in 0..count * count {
        let [x, y] = [place / count, place % count].map(|at| 2.0 * f64::from(at) + 1.0 - size);
        let hole = builder.transform(TransformKind::Move, [x, y, -0.5].map(Expr::from), drill);
        plate = builder.operator(Operator::Difference, plate, hole);
    }
    builder.finish(plate).unwrap()
}

#[test]
fn what_is_not_met_is_not_asked() {
    let tests = [8, 16].map(|count| {
        let graph = drilled(count);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap();
        let hyper_boxes = boxes.into_hyper_boxes();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        let mut fast = scene.tracer();
        for place in 0..500 {
            let [x, y] = [place % 25, place / 25].map(|at| f64::from(at) * 0.037 * f64::from(count));
            let target = DVec3::new(x - 0.4 * f64::from(count), y - 0.4 * f64::from(count), 0.0);
            let ray =
                Ray { origin: target + DVec3::new(3.0, 2.0, 4.0), direction: DVec3::new(-3.0, -2.0, -4.0) };
            let (expected, hit) = (walk.nearest(&ray).unwrap(), fast.nearest(&ray));
            assert!(agree(expected.as_ref(), hit.as_ref()), "{expected:?}\n{hit:?}");
        }
        (fast.counters().primitive_tests, fast.counters().box_tests)
    });
    // Four times as many holes cost a level of the tree.
    let [few, many] = tests;
    assert!(many.0 < few.0 * 2 && many.1 < few.1 * 2, "{tests:?}");
}

/// Where the left operand is nowhere, so is the result.
#[test]
fn what_cuts_off_is_not_asked_where_nothing_is_left() {
    let mut b = GraphBuilder::new();
    let ring = b.primitive(PrimitiveKind::Torus, [0.05.into()]);
    let cube = b.primitive(PrimitiveKind::Cube, []);
    let cube = b.transform(TransformKind::UScale, [3.0.into()], cube);
    for operator in [Operator::Intersection, Operator::Difference] {
        let mut b = b.clone();
        let both = b.operator(operator, ring, cube);
        let graph = b.finish(both).unwrap();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let scene = Accelerated::new(&graph, &boxes, 1 << 12).unwrap();
        let mut tracer = scene.tracer();
        // Through the hole.
        let ray = Ray { origin: DVec3::new(0.2, 0.1, 5.0), direction: -DVec3::Z };
        assert_eq!(tracer.nearest(&ray), None);
        assert_eq!(tracer.counters().primitive_tests, 1, "{operator:?}");
    }
}

#[test]
fn a_hundred_thousand_differences_in_one_another() {
    for recursion_last in [true, false] {
        let mut builder = GraphBuilder::new();
        let n = builder.param("n", 1e5);
        let symbol = builder.symbol("TOWER");
        let cylinder = builder.primitive(PrimitiveKind::Cylinder, []);
        let smaller = builder.transform(TransformKind::UScale, [0.999_99.into()], symbol);
        let raised = builder.transform(TransformKind::Move, [0.0, 0.0, 0.5].map(Expr::from), smaller);
        let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
        let operands = if recursion_last { [cylinder, rest] } else { [rest, cylinder] };
        let both = builder.operator(Operator::Difference, operands[0], operands[1]);
        builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cylinder, both]);
        let graph = builder.finish(symbol).unwrap();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap();
        let hyper_boxes = boxes.into_hyper_boxes();
        let mut fast = scene.tracer();
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        for part in 1..10 {
            let height = 0.1 * f64::from(part) * hyper_boxes.root.max.z;
            let ray = Ray { origin: DVec3::new(-5.0, 1e-3, height), direction: DVec3::X };
            let (expected, hit) = (walk.nearest(&ray).unwrap(), fast.nearest(&ray));
            assert!(agree(expected.as_ref(), hit.as_ref()), "{expected:?}\n{hit:?}");
        }
        let from_above = Ray { origin: DVec3::new(0.1, 0.0, 2e5), direction: -DVec3::Z };
        let (expected, hit) = (walk.nearest(&from_above).unwrap(), fast.nearest(&from_above));
        assert!(agree(expected.as_ref(), hit.as_ref()), "{expected:?}\n{hit:?}");
    }
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

/// Cubes in the eight corners of a cube, and these likewise.
fn corners(size: f64, aside: f64, levels: f64) -> Graph {
    let mut b = GraphBuilder::new();
    let n = b.param("n", levels);
    let symbol = b.symbol("CUBE");
    let cube = b.primitive(PrimitiveKind::Cube, []);
    let parts = (0..8).map(|corner| {
        let part = b.transform(TransformKind::UScale, [size.into()], symbol);
        let at = [0, 1, 2].map(|axis| Expr::from(if corner >> axis & 1 == 0 { -aside } else { aside }));
        b.transform(TransformKind::Move, at, part)
    });
    let parts: Vec<NodeId> = parts.collect();
    let union = b.union(parts);
    let rest = b.calculate([(n, Expr::from(n) - 1.0)], union);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [cube, rest]);
    b.finish(symbol).unwrap()
}

/// Where its parts are 10⁻⁹⁰ of the whole, nothing tells them apart: what holds them stands for them.
#[test]
fn parts_beyond_all_digits_are_not_looked_into() {
    let engines = [0.0, 40.0, 300.0].map(|levels| {
        let graph = corners(0.5, 0.5, levels);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        assert_eq!(boxes.finest() < Accelerated::FINEST, levels > 100.0);
        Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap()
    });
    let [mut cube, others @ ..] = engines.each_ref().map(Accelerated::tracer);
    let camera = Camera { eye: DVec3::new(3.4, -2.3, 1.6), target: DVec3::ZERO, up: DVec3::Z, fov: 60.0 };
    let lens = camera.lens(64, 64).unwrap();
    for mut tracer in others {
        for pixel in 0..64 * 64 {
            let ray = lens.ray(f64::from(pixel % 64), f64::from(pixel / 64));
            let [found, expected] = [&mut tracer, &mut cube].map(|tracer| tracer.nearest(&ray));
            let is_same = match (found, expected) {
                (Some(found), Some(expected)) => (found.t - expected.t).abs() < 1e-12,
                (found, expected) => found.is_some() == expected.is_some(),
            };
            assert!(is_same, "{ray:?}");
        }
    }
}

/// Dust so porous that no line that measures it meets any: it is looked into, but not farther than there are digits.
#[test]
fn what_nothing_stands_for_comes_to_an_end() {
    let graph = corners(0.3, 0.7, 100.0);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET).unwrap().with_detail(0.5);
    let mut tracer = scene.tracer();
    let camera = Camera { eye: DVec3::new(3.4, -2.3, 1.6), target: DVec3::ZERO, up: DVec3::Z, fov: 40.0 };
    let lens = camera.lens(256, 256).unwrap();
    tracer.set_footprint(Footprint { width: 0.0, spread: lens.spread() });
    for pixel in 0..256 * 256 {
        tracer.nearest(&lens.ray(f64::from(pixel % 256), f64::from(pixel / 256)));
    }
    assert!((256 * 256..256 * 256 * 200).contains(&tracer.counters().box_tests), "{:?}", tracer.counters());
    assert!(tracer.take_fault().is_none());
}

/// From ever closer by, also from among what is looked at.
#[test]
fn rays_of_a_beam_have_the_same_hits_as_others() {
    let scenes = [
        (sierpinski(24.0), [0.5; 3]),
        (holes(PrimitiveKind::Sphere, 0.6, 4.0), [0.75, 0.5, 0.75]),
        (drilled(6), [0.3; 3]),
    ];
    for (graph, target) in scenes {
        let target = DVec3::from(target);
        let boxes = || exact(&graph, &Limits::default()).unwrap();
        let envelopes = || Box::new(Envelopes::new(graph.clone(), &Limits::default()));
        let on_demand = |bounds, memory| Accelerated::on_demand(graph.clone(), bounds, memory).unwrap();
        for detail in [0.0, 1.0, 3.0] {
            let whole = Accelerated::new(&graph, &boxes(), 1 << 14).unwrap();
            let engines = [
                Some(whole).filter(|_| detail == 0.0),
                Some(on_demand(StateBounds::Exact(Box::new(boxes())), 1 << 20).with_detail(detail)),
                Some(on_demand(StateBounds::Envelopes(envelopes()), 0).with_detail(detail)),
            ];
            for engine in engines.into_iter().flatten() {
                for factor in [1.0, 30.0, 1e3, 1e6] {
                    let eye = target + DVec3::new(3.4, -2.3, 1.6) / factor;
                    let camera = Camera { eye, target, up: DVec3::Z, fov: 40.0 };
                    let [hits, others] = compare_beams(&engine, camera, detail == 0.0);
                    assert!(factor > 1.0 || hits > 50, "{hits} hits");
                    // Of what is small, rays are stopped by chance, in the order in which they come to it.
                    assert!(16 * others <= hits, "{others} others of {hits} hits");
                }
            }
        }
    }
}

/// Asks for the hits of a small picture by beams and without; gives how many there are, and how many others.
fn compare_beams(engine: &Accelerated, camera: Camera, is_exact: bool) -> [usize; 2] {
    const TILE: u32 = 16;
    let lens = camera.lens(2 * TILE, 2 * TILE).unwrap();
    let (mut alone, mut together) = (engine.tracer(), engine.tracer());
    let pixel = Footprint { width: 0.0, spread: lens.spread() };
    for tracer in [&mut alone, &mut together] {
        tracer.set_footprint(pixel);
    }
    let [mut hits, mut others] = [0; 2];
    for tile in 0..4 {
        let [left, top] = [tile % 2 * TILE, tile / 2 * TILE];
        let beam = lens.beam(&(left..left + TILE), &(top..top + TILE));
        for row in top..top + TILE {
            let centre = |x: u32| lens.ray(f64::from(x) + 0.5, f64::from(row) + 0.5);
            let rays: Vec<Ray> = (left..left + TILE).map(centre).collect();
            let [mut expected, mut found] = [[None; PACKET]; 2];
            alone.nearest_of(&rays, &mut expected);
            together.nearest_of(beam.batch(&rays), &mut found);
            others += found.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
            let reach = [together.reach_of(beam.batch(&rays)), alone.reach_of(&rays)];
            for (reach, hits) in reach.iter().zip([found, expected]) {
                let far = |lane: usize| hits[lane].map_or(f64::INFINITY, |hit| hit.t);
                assert!((0..PACKET).all(|lane| far(lane).to_bits() == reach[lane].to_bits()), "row {row}");
            }
            hits += found.iter().flatten().count();
        }
    }
    assert!(others == 0 || !is_exact, "{others} others");
    // Below operators, rays that go together start again from the top, a few times more often where they begin further down.
    let [fewer, all] = [together.counters().box_tests, alone.counters().box_tests];
    assert!(!is_exact || 10 * fewer <= 11 * all, "{fewer} of {all}");
    [hits, others]
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
