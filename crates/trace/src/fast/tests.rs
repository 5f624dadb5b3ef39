//! All levels of vector instructions against each other.

use csg_graph::{Expr, GraphBuilder, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use fearless_simd::Simd;
use glam::DVec3;

use super::*;

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

#[test]
fn all_levels_of_vector_instructions_have_the_same_hits() {
    for kind in KINDS {
        let graph = tower(kind);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let mut hits: Vec<Vec<Option<Hit>>> = Vec::new();
        for level in levels() {
            let scene = Accelerated { level, ..Accelerated::new(&graph, &boxes, 4096).unwrap() };
            let mut tracer = scene.tracer();
            let mut found = Vec::new();
            for rays in packets() {
                let mut packet = vec![None; PACKET];
                tracer.nearest_of(&rays, &mut packet);
                for (ray, hit) in rays.iter().zip(&packet) {
                    assert_eq!(tracer.nearest(ray), *hit, "alone and in a packet");
                }
                found.extend(packet);
            }
            assert!(found.iter().flatten().count() > 100, "{kind:?}");
            hits.push(found);
        }
        assert!(hits.iter().all(|found| *found == hits[0]), "{kind:?}");
    }
}

#[test]
fn all_levels_of_vector_instructions_measure_and_meet_small_parts_alike() {
    for kind in KINDS {
        let graph = tower(kind);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let mut hits: Vec<Vec<Option<Hit>>> = Vec::new();
        for level in levels() {
            let scene = Accelerated { level, ..Accelerated::new(&graph, &boxes, 4096).unwrap() };
            let scene = scene.with_detail(1.0);
            let mut tracer = scene.tracer();
            tracer.set_footprint(Footprint { width: 0.0, spread: 0.1 });
            let mut found = Vec::new();
            for rays in packets() {
                let mut packet = vec![None; PACKET];
                tracer.nearest_of(&rays, &mut packet);
                found.extend(packet);
            }
            assert!(found.iter().flatten().count() > 100, "{kind:?}");
            hits.push(found);
        }
        assert!(hits.iter().all(|found| *found == hits[0]), "{kind:?}");
    }
}

#[test]
fn rays_reach_as_far_as_their_hits_and_are_counted_once() {
    let graph = tower(PrimitiveKind::Cone);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let scene = Accelerated::new(&graph, &boxes, 4096).unwrap();
    let mut tracer = scene.tracer();
    for rays in packets() {
        let mut packet = vec![None; PACKET];
        tracer.nearest_of(&rays, &mut packet);
        assert_eq!(tracer.take_counters().rays, PACKET as u64);
        let reach = tracer.reach_of(&rays);
        assert_eq!(tracer.take_counters().rays, PACKET as u64);
        assert_eq!(reach, std::array::from_fn(|lane| packet[lane].map_or(f64::INFINITY, |hit| hit.t)));
    }
}
