//! What boxes cost: the three algorithms side by side, and the exact one on scenes of a million states, and on
//! recursion that never ends.
//!
//! ```text
//! cargo bench -p csg-graph-bounds
//! ```
//!
//! The throughput of the exact algorithm is in states, that of the other two in primitives of the unfolded tree: the law
//! of each is that it stays as it is while the tree grows.

#[expect(clippy::unwrap_used, reason = "the graphs are sound")]
mod chance;
#[path = "../examples/growth/sympodial.rs"]
mod sympodial;

#[path = "../examples/states/dag.rs"]
mod dag;

use std::convert::Infallible;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use csg_graph_bounds::{Aabb, Envelopes, Limits, Scene, Step, chain, conventional, exact, root_box};
use dag::Dag;
use glam::{DAffine3, DVec3};
use sympodial::sympodial;

/// The tree of Fig. 1.1a by the order of its branches.
fn algorithms(c: &mut Criterion) {
    let limits = Limits::default();
    let mut group = c.benchmark_group("sympodial");
    for cnt in [4, 8, 12] {
        let graph = sympodial(cnt);
        group.throughput(Throughput::Elements((1 << (cnt + 4)) + 1));
        group.sample_size(if cnt < 12 { 20 } else { 10 });
        group.bench_function(BenchmarkId::new("conventional", cnt), |b| {
            b.iter(|| conventional(black_box(&graph), &limits));
        });
        group.bench_function(BenchmarkId::new("chain", cnt), |b| {
            b.iter(|| chain(black_box(&graph), &limits));
        });
    }
    for cnt in [4, 8, 12, 16, 60, 300, 1000] {
        let graph = sympodial(cnt);
        let Ok(found) = exact(&graph, &limits) else { unreachable!("it has few states") };
        group.throughput(Throughput::Elements(found.counts.states as u64));
        group.sample_size(20);
        group.bench_function(BenchmarkId::new("exact", cnt), |b| {
            b.iter(|| exact(black_box(&graph), &limits).map(|found| found.root));
        });
        group.bench_function(BenchmarkId::new("root", cnt), |b| {
            b.iter(|| root_box(black_box(&graph), &limits));
        });
    }
    group.finish();
}

/// A scene tree without sharing: every node but the leaves holds four others, turned and moved.
struct Tree {
    transforms: u32,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Part {
    Transform(u32),
    Children(u32),
    Leaf(u32),
}

impl Scene for Tree {
    type State = Part;
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) -> Part {
        Part::Transform(0)
    }

    fn step(&self, part: &Part) -> Result<Step<Self>, Infallible> {
        // The children of i are 4 i + 1 to 4 i + 4, as in a heap.
        Ok(match *part {
            Part::Transform(i) => {
                let i_f64 = f64::from(i);
                let parent_from_children = DAffine3::from_translation(DVec3::new(
                    f64::from(i % 7) - 3.0,
                    f64::from(i % 5) - 2.0,
                    f64::from(i % 3),
                )) * DAffine3::from_rotation_z(0.1 * i_f64)
                    * DAffine3::from_rotation_x(0.07 * i_f64)
                    * DAffine3::from_scale(DVec3::splat(0.7));
                let leaf = 4 * u64::from(i) + 1 >= self.transforms.into();
                Step::Map(parent_from_children, if leaf { Part::Leaf(i) } else { Part::Children(i) })
            }
            Part::Children(i) => {
                let children = (4 * i + 1..=4 * i + 4).filter(|child| *child < self.transforms);
                Step::Union(children.map(Part::Transform).collect())
            }
            Part::Leaf(_) => Step::Shape(Aabb::new(DVec3::NEG_ONE, DVec3::ONE)),
        })
    }

    fn node(&self, part: &Part) -> usize {
        match part {
            Part::Transform(_) => 0,
            Part::Children(_) => 1,
            Part::Leaf(_) => 2,
        }
    }

    fn node_count(&self) -> usize {
        3
    }
}

/// Scenes of other people: time by the number of states.
fn states(c: &mut Criterion) {
    let limits = Limits::default();
    let mut group = c.benchmark_group("states");
    group.sample_size(10).warm_up_time(Duration::from_millis(1));
    for levels in [3_333, 33_333, 333_333] {
        group.throughput(Throughput::Elements(3 * u64::from(levels) + 1));
        for (name, turns) in [("dag", [0.0; 2]), ("turned dag", [-0.5, 0.8])] {
            let dag = Dag { levels, turns };
            group.bench_function(BenchmarkId::new(name, 3 * levels + 1), |b| {
                b.iter(|| exact(black_box(&dag), &limits).map(|found| found.root));
            });
        }
    }
    for transforms in [10_000, 100_000, 1_000_000] {
        let tree = Tree { transforms };
        // A transformation and what is below it.
        group.throughput(Throughput::Elements(2 * u64::from(transforms)));
        group.bench_function(BenchmarkId::new("tree of transforms", transforms), |b| {
            b.iter(|| exact(black_box(&tree), &limits).map(|found| found.root));
        });
    }
    group.finish();
}

/// Copies of itself, and nothing else.
struct Attractor {
    maps: Vec<DAffine3>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Copies {
    All,
    One(usize),
}

impl Scene for Attractor {
    type State = Copies;
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) -> Copies {
        Copies::All
    }

    fn step(&self, copies: &Copies) -> Result<Step<Self>, Infallible> {
        Ok(match *copies {
            Copies::All => Step::Union((0..self.maps.len()).map(Copies::One).collect()),
            Copies::One(copy) => Step::Map(self.maps[copy], Copies::All),
        })
    }

    fn node(&self, _: &Copies) -> usize {
        0
    }

    fn node_count(&self) -> usize {
        1
    }
}

/// Recursion that never ends.
fn attractors(c: &mut Criterion) {
    let limits = Limits::default();
    let mut group = c.benchmark_group("attractors");
    let similar = |factor: f64, at: [f64; 3]| {
        DAffine3::from_translation(at.into()) * DAffine3::from_scale(DVec3::splat(factor))
    };
    let flat = |[xx, xz, zx, zz]: [f64; 4], y: f64, z: f64| {
        DAffine3::from_cols(
            DVec3::new(xx, 0.0, zx),
            DVec3::new(0.0, y, 0.0),
            DVec3::new(xz, 0.0, zz),
            DVec3::new(0.0, 0.0, z),
        )
    };
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let cells = (0..27).map(|cell| [cell % 3, cell / 3 % 3, cell / 9].map(|at| f64::from(at - 1)));
    let kept = cells.filter(|cell| cell.iter().filter(|at| at.abs() < 0.5).count() < 2);
    for (name, maps) in [
        ("sierpinski", corners.map(|corner| similar(0.5, corner.map(|x| 0.5 * x))).to_vec()),
        ("menger", kept.map(|cell| similar(1.0 / 3.0, cell.map(|x| x * 2.0 / 3.0))).collect()),
        (
            "dragon",
            [(0.25, 0.0), (0.75, 1.0)]
                .map(|(angle, x)| {
                    let turn = DAffine3::from_rotation_z(angle * std::f64::consts::PI);
                    similar(0.5_f64.sqrt(), [x, 0.0, 0.0]) * turn
                })
                .to_vec(),
        ),
        (
            "fern",
            vec![
                flat([0.02, 0.0, 0.0, 0.16], 0.02, 0.0),
                flat([0.85, 0.04, -0.04, 0.85], 0.85, 1.6),
                flat([0.20, -0.26, 0.23, 0.22], 0.3, 1.6),
                flat([-0.15, 0.28, 0.26, 0.24], 0.3, 0.44),
            ],
        ),
    ] {
        let attractor = Attractor { maps };
        group.bench_function(name, |b| {
            b.iter(|| exact(black_box(&attractor), &limits).map(|found| found.root));
        });
    }
    group.finish();
}

/// Envelopes: preparing for questions, and questions about states a few levels down, where all is random.
fn envelopes(c: &mut Criterion) {
    let mut group = c.benchmark_group("envelope");
    for (name, graph) in [
        ("tree", chance::tree(1, 20)),
        ("terrain", chance::terrain(1, 12, 0.3)),
        ("sierpinski", chance::stochastic_sierpinski(1, 20)),
        ("vine", chance::vine(1)),
        ("thinning", chance::thinning(1)),
    ] {
        group.sample_size(20);
        group.bench_function(BenchmarkId::new("new", name), |b| {
            b.iter(|| Envelopes::new(black_box(graph.clone()), &Limits::default()).key_count());
        });
        let envelopes = Envelopes::new(graph.clone(), &Limits::default());
        // Always the last part, as long as there is one.
        let mut state = graph.root_state();
        let mut asked = vec![state.clone()];
        while let Ok(step) = graph.step(&state)
            && let Some(below) = step.into_states().into_iter().flatten().last()
        {
            state = below;
            asked.push(state.clone());
        }
        group.throughput(Throughput::Elements(asked.len() as u64));
        group.bench_function(BenchmarkId::new("of", name), |b| {
            b.iter(|| asked.iter().filter(|state| envelopes.of(black_box(state)).is_ok()).count());
        });
        group.bench_function(BenchmarkId::new("aabb", name), |b| {
            b.iter(|| asked.iter().filter(|state| envelopes.aabb(black_box(state)).is_ok()).count());
        });
    }
    group.finish();
}

criterion_group!(benches, envelopes, algorithms, states, attractors);
criterion_main!(benches);
