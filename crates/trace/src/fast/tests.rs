//! All levels of vector instructions against each other.

use csg_graph::{Expr, GraphBuilder, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use fearless_simd::Simd;
use glam::DVec3;

use super::*;
use crate::{Hit, Ray};

/// A tower of one primitive in every orientation.
fn tower(kind: PrimitiveKind) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", 12.0);
    let symbol = builder.symbol("X");
    let primitive = builder.primitive(kind, []);
    let smaller = builder.transform(TransformKind::Scale, [0.8, 0.7, -0.75].map(Expr::from), symbol);
    let turned = builder.transform(TransformKind::Rot, [1.0, 2.0, 3.0, 50.0].map(Expr::from), smaller);
    let moved = builder.transform(TransformKind::Move, [0.3, -0.4, 1.0].map(Expr::from), turned);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], moved);
    let both = builder.operator(csg_graph::Operator::Union, primitive, rest);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [both, primitive]);
    builder.finish(symbol).unwrap()
}

const KINDS: [PrimitiveKind; 5] = [
    PrimitiveKind::Sphere,
    PrimitiveKind::Cylinder,
    PrimitiveKind::Cone,
    PrimitiveKind::Cube,
    PrimitiveKind::Dodecahedron,
];

fn levels() -> impl Iterator<Item = Level> {
    let best = Level::new();
    let levels = [
        Some(best),
        best.as_avx2().map(|simd| simd.level()),
        best.as_sse4_2().map(|simd| simd.level()),
        best.as_sse2().map(|simd| simd.level()),
    ];
    levels.into_iter().flatten()
}

fn packets() -> impl Iterator<Item = [Ray; PACKET]> {
    (0..64).map(|row| {
        std::array::from_fn(|column| Ray {
            origin: DVec3::new(9.0, 7.0, 3.0),
            direction: DVec3::new(-9.0, column as f64 * 0.3 - 9.5, row as f64 * 0.1 - 5.0),
        })
    })
}

/// The hits of all packets.
fn hits_of(tracer: &mut Tracer<'_>) -> Vec<Option<Hit>> {
    let mut found = Vec::new();
    for rays in packets() {
        let mut packet = vec![None; PACKET];
        tracer.nearest_of(&rays, &mut packet);
        found.extend(packet);
    }
    found
}

/// Compares what towers show by all levels of vector instructions.
fn assert_alike(hits: impl Fn(Accelerated) -> Vec<Option<Hit>>) {
    for kind in KINDS {
        let graph = tower(kind);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let scene = |level| Accelerated { level, ..Accelerated::new(&graph, &boxes, 4096).unwrap() };
        let found: Vec<_> = levels().map(|level| hits(scene(level))).collect();
        assert!(found[0].iter().flatten().count() > 100, "{kind:?}");
        assert!(found.iter().all(|other| *other == found[0]), "{kind:?}");
    }
}

#[test]
fn all_levels_of_vector_instructions_have_the_same_hits() {
    assert_alike(|scene| {
        let mut tracer = scene.tracer();
        let found = hits_of(&mut tracer);
        let alone: Vec<_> = packets().flatten().map(|ray| tracer.nearest(&ray)).collect();
        assert_eq!(alone, found, "alone and in a packet");
        found
    });
}

#[test]
fn all_levels_of_vector_instructions_measure_and_meet_small_parts_alike() {
    assert_alike(|scene| {
        let all = hits_of(&mut scene.tracer());
        let scene = scene.with_detail(1.0);
        let mut tracer = scene.tracer();
        tracer.set_footprint(Footprint { width: 0.0, spread: 8.0 });
        let large = hits_of(&mut tracer);
        assert!(all != large, "something is small");
        large
    });
}

/// A tetrahedron of balls fills a third of its box.
#[test]
fn slabs_save_work_and_change_no_hit() {
    let source = "{ n = 40; } ST
        ST if(n > 0, 2, 1)
        1: ST -> sphere
        2: ST -> {n = n - 1} (
            move(0.5, 0.5, 0.5) uscale(0.5) ST | move(0.5, -0.5, -0.5) uscale(0.5) ST
            | move(-0.5, 0.5, -0.5) uscale(0.5) ST | move(-0.5, -0.5, 0.5) uscale(0.5) ST)";
    let camera =
        crate::Camera { eye: DVec3::new(3.4, -2.3, 1.6), target: DVec3::ZERO, up: DVec3::Z, fov: 40.0 };
    let lens = camera.lens(40, 40).unwrap();
    let rays: Vec<Ray> =
        (0..1600).map(|pixel| lens.ray(f64::from(pixel % 40) + 0.5, f64::from(pixel / 40) + 0.5)).collect();

    let graph = csg_graph_grammar::load(source, &[]).expect("a scene").scene.graph;
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let with_slabs = Compiled::whole(&graph, Bounds::Exact(&boxes), Accelerated::DEFAULT_BUDGET).unwrap();
    assert!(!with_slabs.slabs.is_empty() && with_slabs.bytes() <= Accelerated::DEFAULT_BUDGET);
    let mut without = Compiled::whole(&graph, Bounds::Exact(&boxes), Accelerated::DEFAULT_BUDGET).unwrap();
    without.slabs.clear();
    let [(hits, counted), (expected, all)] = [with_slabs, without].map(|compiled| {
        let (blocks, level) =
            (Blocks::Whole { graph: graph.clone(), block: Arc::new(compiled) }, Level::new());
        let scene = Accelerated { blocks, detail: 0.0, level };
        let mut tracer = scene.tracer();
        let alone: Vec<_> = rays.iter().map(|ray| tracer.nearest(ray)).collect();
        let counted = tracer.take_counters();
        let mut together = vec![None; rays.len()];
        for (rays, found) in rays.chunks(PACKET).zip(together.chunks_mut(PACKET)) {
            tracer.nearest_of(rays, found);
        }
        ([alone, together], [counted, tracer.take_counters()])
    });
    assert!(hits == expected && hits[0] == hits[1]);
    for (counted, all) in counted.iter().zip(all) {
        assert!(10 * counted.box_tests < 9 * all.box_tests, "{counted:?} of {all:?}");
        assert!(4 * counted.primitive_tests < 3 * all.primitive_tests, "{counted:?} of {all:?}");
    }
}

#[test]
fn rays_reach_as_far_as_their_hits_and_are_counted_once() {
    let graph = tower(PrimitiveKind::Cone);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(&graph, &boxes, 4096).unwrap();
    let mut tracer = scene.tracer();
    let hits = hits_of(&mut tracer);
    let mut rays = tracer.take_counters().rays;
    let reach = packets().flat_map(|rays| tracer.reach_of(&rays));
    for (t, hit) in reach.zip(&hits) {
        assert_eq!(t.to_bits(), hit.map_or(f64::INFINITY, |hit| hit.t).to_bits());
        rays -= 1;
    }
    assert_eq!(rays, 0);
    assert_eq!(tracer.take_counters().rays, hits.len() as u64);
}
