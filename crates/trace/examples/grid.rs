//! The paper's grid beside the tree of the fast engine and the reference walk: what rays cost, and what memory.
//!
//! `cargo run --release -p csg-graph-trace --example grid` prints what the tables of docs/rendering.md show.
#![expect(clippy::print_stdout, reason = "the table")]

use std::error::Error;
use std::path::Path;

use cpu_time::ThreadTime;
use csg_graph::Graph;
use csg_graph_bounds::{ExactBoxes, Limits, exact};
use csg_graph_grammar::{Override, Scene, load};
use csg_graph_trace::{Accelerated, Camera, Grid, Lens, PACKET, Ray, Walk};

const SCENES: [(&str, &str); 3] =
    [("sympodial", "cnt = 12"), ("sierpinski", "n = 8"), ("cone_tower", "n = 1000")];

/// Voxels along the longest side; none is the default.
const RESOLUTIONS: [Option<u32>; 6] = [Some(16), Some(32), Some(64), Some(128), Some(256), None];

/// Of a square picture, in pixels.
const SIDE: u32 = 512;

/// Pictures, of which the middle one counts.
const TIMES: usize = 3;

/// So that no resolution of the table is cut short.
const BUDGET: usize = 1 << 28;

/// Traces rays: hits, tests of boxes and of primitives.
type Trace<'a> = &'a mut dyn FnMut(&[Ray]) -> (usize, u64, u64);

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "scene            engine             set-up s       bytes   Mray/s  boxes/ray  shapes/ray   hits"
    );
    for (name, set) in SCENES {
        let Scene { graph, look, .. } = scene(name, set)?;
        let camera = Camera {
            eye: look.camera.eye.ok_or("no eye")?,
            target: look.camera.target.ok_or("no target")?,
            up: look.camera.up.unwrap_or(glam::DVec3::Z),
            fov: look.camera.fov.ok_or("no field of view")?,
        };
        let lens = camera.lens(SIDE, SIDE)?;
        let report = |engine: &str, setup: f64, bytes: usize, trace: Trace<'_>| {
            let (hits, boxes, shapes, seconds) = picture(&lens, trace);
            let rays = f64::from(SIDE * SIDE);
            println!(
                "{name:<16} {engine:<16} {setup:>10.4} {bytes:>11} {:>8.3} {:>10.1} {:>11.2} {hits:>6}",
                rays / seconds * 1e-6,
                boxes as f64 / rays,
                shapes as f64 / rays,
            );
        };

        let (hyper_boxes, setup) = timed(|| boxes(&graph).map(ExactBoxes::into_hyper_boxes));
        let hyper_boxes = hyper_boxes?;
        let mut walk = Walk::new(&graph, Some(&hyper_boxes));
        report("reference", setup, size_of_val(&*hyper_boxes.nodes), &mut |rays| {
            let hits = rays.iter().filter(|ray| walk.nearest(ray).is_ok_and(|hit| hit.is_some())).count();
            let counters = walk.take_counters();
            (hits, counters.box_tests, counters.primitive_tests)
        });
        for budget in [Accelerated::DEFAULT_BUDGET, 1 << 24] {
            let (scene, setup) =
                timed(|| Ok::<_, Box<dyn Error>>(Accelerated::new(&graph, &boxes(&graph)?, budget)?));
            let scene = scene?;
            let mut tracer = scene.tracer();
            for (engine, packet) in [("fast", 1), ("fast, packets", PACKET)] {
                let mut found = vec![None; packet];
                report(engine, setup, scene.bytes(), &mut |rays| {
                    let mut hits = 0;
                    for rays in rays.chunks(packet) {
                        if packet == 1 {
                            hits += usize::from(tracer.nearest(&rays[0]).is_some());
                        } else {
                            found.fill(None);
                            tracer.nearest_of(rays, &mut found);
                            hits += found.iter().flatten().count();
                        }
                    }
                    let counters = tracer.take_counters();
                    (hits, counters.box_tests, counters.primitive_tests)
                });
            }
        }
        for resolution in RESOLUTIONS {
            let budget = if resolution.is_some() { BUDGET } else { Grid::DEFAULT_BUDGET };
            let (grid, setup) =
                timed(|| Ok::<_, Box<dyn Error>>(Grid::new(&graph, boxes(&graph)?, resolution, budget)?));
            let grid = grid?;
            let mut tracer = grid.tracer();
            let engine =
                format!("grid {}{}", grid.resolution(), if resolution.is_some() { "" } else { " (default)" });
            report(&engine, setup, grid.bytes(), &mut |rays| {
                let hits = rays.iter().filter(|ray| tracer.nearest(ray).is_some()).count();
                let counters = tracer.take_counters();
                (hits, counters.box_tests, counters.primitive_tests)
            });
        }
    }
    Ok(())
}

fn scene(name: &str, set: &str) -> Result<Scene, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let source = std::fs::read_to_string(folder.join(name).with_extension("pcsg"))?;
    let set = Override::parse(set).map_err(|_| "a mistake in the parameters")?;
    Ok(load(&source, &[set]).map_err(|_| "a mistake in the scene")?.scene)
}

fn boxes(graph: &Graph) -> Result<ExactBoxes<Graph>, Box<dyn Error>> {
    Ok(exact(graph, &Limits::default().with_gap(1e-2))?)
}

/// What a piece of work gives, and the seconds of this thread that it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = ThreadTime::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Traces all rays of a picture, in squares of 4 by 4: hits, tests of boxes and of primitives, and seconds.
fn picture(lens: &Lens, trace: Trace<'_>) -> (usize, u64, u64, f64) {
    let squares = (0..SIDE / 4).flat_map(|y| (0..SIDE / 4).map(move |x| (4 * x, 4 * y)));
    let rays: Vec<Ray> = squares
        .flat_map(|(x, y)| (0..16).map(move |at| (x + at % 4, y + at / 4)))
        .map(|(x, y)| lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5))
        .collect();
    let mut runs: Vec<_> = (0..TIMES).map(|_| timed(|| trace(&rays))).collect();
    runs.sort_by(|a, b| a.1.total_cmp(&b.1));
    let ((hits, boxes, shapes), seconds) = runs[TIMES / 2];
    (hits, boxes, shapes, seconds)
}
