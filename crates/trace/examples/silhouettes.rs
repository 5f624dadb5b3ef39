//! How far the silhouettes of what never ends are off: scenes of `scenes/endless` with what is smaller than half a pixel not
//! looked into, beside scenes that end far below.
//!
//! Small parts stop as many rays as they would, but by chance: it counts those that meet only the one or the other, and of
//! each kind those from which it is farther than half a pixel to any that meets the other.
//!
//! Nearness to the deeper solid is looked for in the solid first: a part may be far thinner than rays are close, as the last
//! stems of a fern, but there is something of it in its exact box, and where all of the box is near, so is that. One descent
//! serves all rays: a search for each would step through the same parts a hundred thousand times. Parts are gone into only
//! where rays are still open. What is larger than the circle is found by rays, and so is nearness to the endless one.
//!
//! `cargo run --release -p csg-graph-trace --example silhouettes [SCENE]`
#![expect(clippy::print_stdout, reason = "it prints a table")]

use std::error::Error;

use csg_graph::{Graph, Operator, Step};
use csg_graph_bounds::{Aabb, ExactBoxes, Limits, exact};
use csg_graph_grammar::{Scene, load};
use csg_graph_trace::{Accelerated, Camera, Footprint, Lens, PACKET, StateBounds, Tracer};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;

/// Pixels on a side of the picture, and rays on a side of a pixel.
const SIDE: u32 = 512;
const RAYS: u32 = 4;

/// What stands in a scene, and in one that ends.
type Change = (&'static str, &'static str);

/// Scenes, how many levels those that end have, and how these differ.
const SCENES: [(&str, u32, [Change; 2]); 3] = [
    (
        "sierpinski",
        12,
        [
            ("{} ST", "{ n = 12; } ST"),
            ("ST -> color", "ST if(n > 0, 2, 1) 1: ST -> tetrahedron 2: ST -> {n = n - 1} color"),
        ],
    ),
    (
        "menger",
        8,
        [
            ("c = 2 / 3;", "c = 2 / 3; n = 8;"),
            ("SPONGE -> color", "SPONGE if(n > 0, 2, 1) 1: SPONGE -> cube 2: SPONGE -> {n = n - 1} color"),
        ],
    ),
    (
        "fern",
        60,
        [
            ("bend = 3;", "bend = 3; n = 60;"),
            (
                "FERN -> color",
                "FERN if(n > 0, 2, 1) 1: FERN -> scale(stem, stem, 1.6) cylinder 2: FERN -> {n = n - 1} MORE MORE -> color",
            ),
        ],
    ),
];

/// Rays on a side of the picture.
const ACROSS: usize = (SIDE * RAYS) as usize;

/// Half a pixel, by which silhouettes may be off.
const NEAR: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| scene | levels of the deeper one | rays that meet the endless one | only the deeper one \
         | farther than ½ pixel | only the endless one | farther than ½ pixel |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    let asked = std::env::args().nth(1);
    for (name, levels, changes) in SCENES {
        if asked.as_ref().is_some_and(|asked| asked != name) {
            continue;
        }
        let path = format!("{}/../../scenes/endless/{name}.pcsg", env!("CARGO_MANIFEST_DIR"));
        let endless = std::fs::read_to_string(path)?;
        if let Some((from, _)) = changes.iter().find(|(from, _)| !endless.contains(from)) {
            return Err(format!("{name} has no `{from}` to be changed").into());
        }
        let ends = changes.iter().fold(endless.clone(), |text, (from, to)| text.replacen(from, to, 1));
        let (endless, ends) = (scene(&endless)?, scene(&ends)?);
        let look = endless.look.camera;
        let camera = Camera {
            eye: look.eye.ok_or("the scene has an eye")?,
            target: look.target.ok_or("the scene has a target")?,
            up: look.up.unwrap_or(DVec3::Z),
            fov: look.fov.unwrap_or(Camera::DEFAULT_FOV),
        };
        let lens = camera.lens(SIDE, SIDE)?;
        let bounds = StateBounds::Exact(Box::new(exact(&endless.graph, &Limits::default())?));
        let coarse = Accelerated::on_demand(endless.graph, bounds, 1 << 26)?.with_detail(0.5);
        let boxes = exact(&ends.graph, &Limits::default())?;
        let fine = Accelerated::new(&ends.graph, &boxes, 1 << 20)?;
        let footprint = Footprint { width: 0.0, spread: lens.spread() };
        let [endless, deeper] = [&coarse, &fine].map(|engine| met(engine, footprint, &lens));
        let only = |one: &[bool], other: &[bool]| {
            let only = one.iter().zip(other).map(|(one, other)| *one && !*other);
            only.collect::<Vec<_>>()
        };
        let (only_deeper, only_endless) = (only(&deeper, &endless), only(&endless, &deeper));
        let count = |rays: &[bool]| rays.iter().filter(|ray| **ray).count();
        let from_endless = far(&coarse, footprint, &lens, &only_deeper);
        let mut open = only_endless.clone();
        Solid::new(&ends.graph, &boxes, pixels(&lens)).close_near(&mut open);
        let from_deeper = far(&fine, footprint, &lens, &open);
        let [met, only_deeper, only_endless] =
            [&endless, &only_deeper, &only_endless].map(|rays| count(rays));
        println!(
            "| `endless/{name}` | {levels} | {met} | {only_deeper} | {from_endless} | {only_endless} | {from_deeper} |"
        );
    }
    Ok(())
}

fn scene(text: &str) -> Result<Scene, String> {
    load(text, &[]).map(|loaded| loaded.scene).map_err(|_| format!("a mistake in\n{text}"))
}

/// Where a ray goes through the picture.
fn place(column: usize, row: usize) -> DVec2 {
    (DVec2::new(column as f64, row as f64) + 0.5) / f64::from(RAYS)
}

fn tracer(engine: &Accelerated, footprint: Footprint) -> Tracer<'_> {
    let mut tracer = engine.tracer();
    tracer.set_footprint(footprint);
    tracer
}

/// Which rays meet a solid, row by row.
fn met(engine: &Accelerated, footprint: Footprint, lens: &Lens) -> Vec<bool> {
    let row = |tracer: &mut Tracer<'_>, row: usize| {
        let rays: Vec<_> =
            (0..ACROSS).map(|column| place(column, row)).map(|at| lens.ray(at.x, at.y)).collect();
        let reach = rays.chunks(PACKET).flat_map(|rays| tracer.reach_of(rays).into_iter().take(rays.len()));
        reach.map(f64::is_finite).collect::<Vec<_>>()
    };
    let rows = (0..ACROSS).into_par_iter().map_init(|| tracer(engine, footprint), row);
    rows.flatten_iter().collect()
}

/// How many of some rays have none around them, no farther than half a pixel, that meets a solid.
fn far(engine: &Accelerated, footprint: Footprint, lens: &Lens, rays: &[bool]) -> usize {
    let row = |tracer: &mut Tracer<'_>, (row, rays): (usize, &[bool])| {
        let asked = rays.iter().enumerate().filter(|(_, is_asked)| **is_asked);
        asked.filter(|(column, _)| !is_met_near(tracer, lens, place(*column, row))).count()
    };
    rays.par_chunks(ACROSS).enumerate().map_init(|| tracer(engine, footprint), row).sum()
}

/// Whether a ray no farther than half a pixel meets anything.
fn is_met_near(tracer: &mut Tracer<'_>, lens: &Lens, at: DVec2) -> bool {
    [4_i32, 16].into_iter().any(|steps| {
        let step = NEAR / f64::from(steps);
        let row =
            |j: i32| (-steps..=steps).filter(move |i| i * i + j * j <= steps * steps).map(move |i| [i, j]);
        let around: Vec<_> = (-steps..=steps)
            .flat_map(row)
            .map(|[i, j]| lens.ray(at.x + f64::from(i) * step, at.y + f64::from(j) * step))
            .collect();
        around.chunks(PACKET).any(|rays| tracer.reach_of(rays)[..rays.len()].iter().any(|t| t.is_finite()))
    })
}

/// The solid that ends: its unions and what is not gone into, each after what is below it.
struct Solid {
    parts: Vec<Part>,
    root: Placed,
    pixels: Pixels,
}

struct Part {
    bounds: Aabb,
    below: Vec<Placed>,
}

/// The number of a part, and its place in the one above.
type Placed = (DAffine3, usize);

/// Where points of the world are in the picture.
struct Pixels {
    eye: DVec3,
    /// To columns and rows of pixels, times the depth, and the depth.
    from_world: DMat3,
}

fn pixels(lens: &Lens) -> Pixels {
    let corner = lens.ray(0.0, 0.0);
    let [across, down] = [[1.0, 0.0], [0.0, 1.0]].map(|[x, y]| lens.ray(x, y).direction - corner.direction);
    let from_world = DMat3::from_cols(across, down, corner.direction).inverse();
    Pixels { eye: corner.origin, from_world }
}

impl Pixels {
    /// Where the corners of a box are seen, if all lie before the eye.
    fn of(&self, corners: [DVec3; 8]) -> Option<[DVec2; 8]> {
        let seen = corners.map(|corner| self.from_world * (corner - self.eye));
        seen.iter().all(|corner| corner.z > 0.0).then(|| seen.map(|corner| corner.truncate() / corner.z))
    }
}

impl Solid {
    fn new(graph: &Graph, boxes: &ExactBoxes<Graph>, pixels: Pixels) -> Self {
        let mut parts = Vec::new();
        let mut known: Vec<Placed> = Vec::new();
        for (state, found) in boxes.states() {
            let of = |below: &_| known[boxes.index_of(below).expect("what is below is listed before")];
            let below = match graph.step(state).expect("a state with a box") {
                Step::Transform(parent_from_child, below) => {
                    let (child_from_part, part) = of(&below);
                    known.push((parent_from_child.to_affine() * child_from_part, part));
                    continue;
                }
                Step::Select(below) | Step::Calculate(below) | Step::Attribute(_, below) => {
                    known.push(of(&below));
                    continue;
                }
                Step::Operator(Operator::Union, below) => below.iter().map(of).collect(),
                // What is cut or large is met by rays or is not.
                _ => Vec::new(),
            };
            known.push((DAffine3::IDENTITY, parts.len()));
            parts.push(Part { bounds: found.aabb, below });
        }
        Self { root: *known.last().expect("the root has a box"), parts, pixels }
    }

    /// Closes the rays from which no point in the box of some part is farther than half a pixel.
    fn close_near(&self, open: &mut [bool]) {
        let mut pending = vec![self.root];
        while let Some((world_from_part, part)) = pending.pop() {
            let Part { bounds, below } = &self.parts[part];
            if bounds.is_empty() {
                continue;
            }
            let corners = bounds.corners().map(|corner| world_from_part.transform_point3(corner));
            // A box that is not all before the eye may be seen anywhere.
            if self.pixels.of(corners).is_none_or(|corners| is_open_near(&corners, open)) {
                pending.extend(
                    below.iter().map(|(part_from_below, below)| (world_from_part * *part_from_below, *below)),
                );
            }
        }
    }
}

/// Closes the rays that are near all corners of a box, and says whether others are left that are near its rectangle.
#[expect(clippy::cast_possible_truncation, reason = "places are limited to the picture")]
fn is_open_near(corners: &[DVec2], open: &mut [bool]) -> bool {
    let min = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let max = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    // What a circle holds is in a square of its width.
    let is_small = (max - min).max_element() <= 2.0 * NEAR;
    let [columns, rows] = [(min.x, max.x), (min.y, max.y)].map(|(min, max)| {
        let ray = |at: f64| (at * f64::from(RAYS) - 0.5).clamp(0.0, ACROSS as f64);
        ray(min - NEAR).ceil() as usize..(ray(max + NEAR).floor() as usize + 1).min(ACROSS)
    });
    let mut is_open = false;
    for row in rows {
        for column in columns.clone() {
            let ray = &mut open[row * ACROSS + column];
            let at = place(column, row);
            if !*ray || at.distance(at.clamp(min, max)) > NEAR {
                continue;
            }
            if !is_small {
                return true;
            }
            *ray = corners.iter().any(|corner| corner.distance(at) > NEAR);
            is_open |= *ray;
        }
    }
    is_open
}
