//! What single parts of a ray's way cost: scenes that consist of little else.
//!
//! ```text
//! cargo bench -p csg-graph-trace
//! ```
//!
//! The throughput is in rays; ray by ray and in packets, where an engine has both. Each group varies one thing, and what is
//! compared is the difference: between its scenes, or to the same scene in another group.

use std::hint::black_box;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use csg_graph::{Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{ExactBoxes, Limits, exact};
use csg_graph_trace::{Accelerated, Camera, Grid, PACKET, Ray};
use glam::DVec3;

/// Of the picture that rays are taken from, in pixels.
const SIDE: u32 = 64;

/// A graph of one solid.
fn graph(build: impl FnOnce(&mut GraphBuilder) -> NodeId) -> Graph {
    let mut builder = GraphBuilder::new();
    let root = build(&mut builder);
    builder.finish(root).expect("a sound graph")
}

fn moved(builder: &mut GraphBuilder, by: [f64; 3], body: NodeId) -> NodeId {
    builder.transform(TransformKind::Move, by.map(Expr::from), body)
}

/// Cubes in rows of `side`, each at the middle of a cell of size 4, as one union.
fn rows(side: u32, builder: &mut GraphBuilder, body: NodeId) -> NodeId {
    let at = |index: u32| 4.0 * f64::from(index) - 2.0 * f64::from(side - 1);
    let cells = (0..side).flat_map(|x| (0..side).map(move |y| [at(x), at(y), 0.0]));
    let parts: Vec<_> = cells.map(|cell| moved(builder, cell, body)).collect();
    builder.union(parts)
}

/// A union of itself twice, `levels` deep, so that each level is a state of its own: half the size, to the left and right.
fn halves(levels: u32) -> Graph {
    graph(|builder| {
        let n = builder.param("n", f64::from(levels));
        let symbol = builder.symbol("H");
        let ball = builder.primitive(PrimitiveKind::Sphere, []);
        let half = builder.transform(TransformKind::UScale, [0.5.into()], symbol);
        let parts = [[0.5, 0.3, 0.0], [-0.5, 0.0, 0.3]].map(|at| moved(builder, at, half));
        let both = builder.union(parts);
        let rest = builder.calculate([(n, Expr::from(n) - 1.0)], both);
        builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [ball, rest]);
        symbol
    })
}

fn boxes(graph: &Graph) -> ExactBoxes<Graph> {
    exact(graph, &Limits::default().with_gap(1e-2)).expect("few states")
}

/// Rays of a picture that the solid fills, in squares of [`PACKET`].
fn rays(graph: &Graph) -> Vec<Ray> {
    let lens = Camera::framing(&boxes(graph).root, 40.0, 1.0).lens(SIDE, SIDE).expect("it sees the solid");
    let squares = (0..SIDE / 4).flat_map(|y| (0..SIDE / 4).map(move |x| (4 * x, 4 * y)));
    let pixels = squares.flat_map(|(x, y)| (0..16).map(move |at| (x + at % 4, y + at / 4)));
    pixels.map(|(x, y)| lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5)).collect()
}

/// First hits of all rays, alone and in packets.
fn nearest(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, graph: &Graph, rays: &[Ray]) {
    let scene = Accelerated::new(graph, &boxes(graph), Accelerated::DEFAULT_BUDGET).expect("a sound graph");
    let mut tracer = scene.tracer();
    group.throughput(Throughput::Elements(rays.len() as u64));
    group.bench_function(BenchmarkId::new("single", name), |b| {
        b.iter(|| rays.iter().filter(|ray| tracer.nearest(black_box(ray)).is_some()).count());
    });
    let mut hits = [None; PACKET];
    group.bench_function(BenchmarkId::new("packets", name), |b| {
        b.iter(|| {
            let mut count = 0;
            for packet in rays.chunks_exact(PACKET) {
                tracer.nearest_of(black_box(packet), &mut hits);
                count += hits.iter().flatten().count();
            }
            count
        });
    });
}

/// Nodes of boxes: rays pass between balls, through the boxes of their rows, and meet none.
fn box_nodes(c: &mut Criterion) {
    let mut group = c.benchmark_group("boxes");
    for side in [4, 16, 64] {
        let graph = graph(|builder| {
            let ball = builder.primitive(PrimitiveKind::Sphere, []);
            rows(side, builder, ball)
        });
        // Along the rows, between the balls, a little inclined.
        let reach = 4.0 * f64::from(side);
        let between = (0..SIDE * SIDE).map(|index| {
            let share = f64::from(index % SIDE) / f64::from(SIDE);
            let row = 4.0 * (f64::from(side) * share).floor() - 2.0 * f64::from(side - 2);
            let height = 1.5 * (f64::from(index / SIDE) / f64::from(SIDE) - 0.5);
            let (origin, target) = (DVec3::new(-reach, row, height), DVec3::new(reach, row + 0.4, height));
            Ray { origin, direction: target - origin }
        });
        nearest(&mut group, &format!("{side} rows"), &graph, &between.collect::<Vec<_>>());
    }
    group.finish();
}

/// One primitive, which the boxes of nothing else hide.
fn primitives(c: &mut Criterion) {
    let mut group = c.benchmark_group("primitives");
    for kind in [
        PrimitiveKind::Sphere,
        PrimitiveKind::Cylinder,
        PrimitiveKind::Cone,
        PrimitiveKind::Cube,
        PrimitiveKind::Tetrahedron,
        PrimitiveKind::Dodecahedron,
        PrimitiveKind::Torus,
    ] {
        let minor = (kind == PrimitiveKind::Torus).then(|| Expr::from(0.3));
        let graph = graph(|builder| builder.primitive(kind, minor));
        nearest(&mut group, &format!("{kind:?}"), &graph, &rays(&graph));
    }
    group.finish();
}

/// Super-nodes, one in the other: the same solid opened as far as the budget goes, and hardly at all.
fn entries(c: &mut Criterion) {
    let mut group = c.benchmark_group("super-nodes");
    let graph = halves(14);
    let rays = rays(&graph);
    group.throughput(Throughput::Elements(rays.len() as u64));
    for budget in [0, 1 << 16, 1 << 22] {
        let scene = Accelerated::new(&graph, &boxes(&graph), budget).expect("a sound graph");
        let mut tracer = scene.tracer();
        let name = format!("{} bytes", scene.bytes());
        group.bench_function(BenchmarkId::new("single", name), |b| {
            b.iter(|| rays.iter().filter(|ray| tracer.nearest(black_box(ray)).is_some()).count());
        });
    }
    group.finish();
}

/// A plate less balls: none that a ray meets, and more of them.
fn booleans(c: &mut Criterion) {
    let mut group = c.benchmark_group("booleans");
    for (operator, name) in
        [(Operator::Union, "∪"), (Operator::Intersection, "∩"), (Operator::Difference, "\\")]
    {
        for side in [1, 8, 64] {
            let graph = graph(|builder| {
                let cube = builder.primitive(PrimitiveKind::Cube, []);
                let size = [2.0 * f64::from(side), 2.0 * f64::from(side), 0.8].map(Expr::from);
                let plate = builder.transform(TransformKind::Scale, size, cube);
                let ball = builder.primitive(PrimitiveKind::Sphere, []);
                let balls = rows(side, builder, ball);
                builder.operator(operator, plate, balls)
            });
            nearest(&mut group, &format!("plate {name} {} balls", side * side), &graph, &rays(&graph));
        }
    }
    group.finish();
}

/// From voxel to voxel, by resolution.
fn voxels(c: &mut Criterion) {
    let mut group = c.benchmark_group("voxels");
    let graph = halves(10);
    let rays = rays(&graph);
    group.throughput(Throughput::Elements(rays.len() as u64));
    for resolution in [1, 8, 64, 256] {
        let grid = Grid::new(&graph, boxes(&graph), Some(resolution), 1 << 26).expect("a sound graph");
        let mut tracer = grid.tracer();
        group.bench_function(BenchmarkId::from_parameter(resolution), |b| {
            b.iter(|| rays.iter().filter(|ray| tracer.nearest(black_box(ray)).is_some()).count());
        });
    }
    group.finish();
}

/// What a hit costs beyond being found: its normal, its surface, and the way to it. Asking only whether there is one leaves
/// that out.
fn hits(c: &mut Criterion) {
    let mut group = c.benchmark_group("hits");
    for (name, graph) in [
        ("sphere", graph(|builder| builder.primitive(PrimitiveKind::Sphere, []))),
        ("twenty levels", halves(20)),
    ] {
        let rays = rays(&graph);
        let scene = Accelerated::new(&graph, &boxes(&graph), 0).expect("a sound graph");
        let mut tracer = scene.tracer();
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(BenchmarkId::new("nearest", name), |b| {
            b.iter(|| rays.iter().filter(|ray| tracer.nearest(black_box(ray)).is_some()).count());
        });
        group.bench_function(BenchmarkId::new("occluded", name), |b| {
            b.iter(|| rays.iter().filter(|ray| tracer.occluded(black_box(ray), f64::INFINITY)).count());
        });
    }
    group.finish();
}

fn settings() -> Criterion {
    Criterion::default().sample_size(20)
}

criterion_group! {
    name = benches;
    config = settings();
    targets = box_nodes, primitives, entries, booleans, voxels, hits
}
criterion_main!(benches);
