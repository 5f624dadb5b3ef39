//! How far the silhouettes of what never ends are off: scenes of `scenes/endless` with what is smaller than half a pixel not
//! looked into, beside scenes that end far below.
//!
//! Small parts stop as many rays as they would, but by chance: it counts those that meet only the one or the other. Of the rays
//! that meet something in the first and nothing in the second one, it counts those from which it is farther than
//! half a pixel to any that would. Nearness is looked for in the solid first: a part may be far thinner than rays are
//! close, as the last stems of a fern, but there is something of it in its exact box, and where all of the box is near, so
//! is that. What is larger than the circle is found by rays.
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

/// What was counted.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    met: u64,
    only_deeper: u64,
    only_endless: u64,
    far: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| scene | levels | rays that meet it | only the deeper one | only the endless one | farther than ½ pixel |"
    );
    println!("|---|---:|---:|---:|---:|---:|");
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
        let solid = Solid { graph: &ends.graph, boxes: &boxes, pixels: pixels(&lens) };
        let tally = (0..SIDE)
            .into_par_iter()
            .map_init(
                || (coarse.tracer(), fine.tracer()),
                |(coarse, fine), row| compare(coarse, fine, &solid, &lens, row),
            )
            .reduce(Tally::default, Tally::join);
        let Tally { met, only_deeper, only_endless, far } = tally;
        println!("| `endless/{name}` | {levels} | {met} | {only_deeper} | {only_endless} | {far} |");
    }
    Ok(())
}

fn scene(text: &str) -> Result<Scene, String> {
    load(text, &[]).map(|loaded| loaded.scene).map_err(|_| format!("a mistake in\n{text}"))
}

/// The rays of a row of pixels.
fn compare(
    coarse: &mut Tracer<'_>,
    fine: &mut Tracer<'_>,
    solid: &Solid<'_>,
    lens: &Lens,
    row: u32,
) -> Tally {
    coarse.set_footprint(Footprint { width: 0.0, spread: lens.spread() });
    let mut tally = Tally::default();
    for column in 0..SIDE {
        let places: Vec<[f64; 2]> = (0..RAYS * RAYS)
            .map(|ray| {
                let within = [ray % RAYS, ray / RAYS].map(|step| (f64::from(step) + 0.5) / f64::from(RAYS));
                [f64::from(column) + within[0], f64::from(row) + within[1]]
            })
            .collect();
        let rays: Vec<_> = places.iter().map(|[x, y]| lens.ray(*x, *y)).collect();
        let [mut endless, mut ends] = [[None; PACKET]; 2];
        coarse.nearest_of(&rays, &mut endless);
        fine.nearest_of(&rays, &mut ends);
        for (lane, place) in places.iter().enumerate() {
            tally.met += u64::from(endless[lane].is_some());
            match (endless[lane].is_some(), ends[lane].is_some()) {
                (false, true) => tally.only_deeper += 1,
                (true, false) => {
                    tally.only_endless += 1;
                    let is_near = solid.is_near(DVec2::from(*place)) || is_met_near(fine, lens, *place);
                    tally.far += u64::from(!is_near);
                }
                _ => {}
            }
        }
    }
    tally
}

/// Whether a ray no farther than half a pixel meets anything.
fn is_met_near(fine: &mut Tracer<'_>, lens: &Lens, [x, y]: [f64; 2]) -> bool {
    [4_i32, 16].into_iter().any(|steps| {
        let step = 0.5 / f64::from(steps);
        let row =
            |j: i32| (-steps..=steps).filter(move |i| i * i + j * j <= steps * steps).map(move |i| [i, j]);
        let around: Vec<_> = (-steps..=steps)
            .flat_map(row)
            .map(|[i, j]| lens.ray(x + f64::from(i) * step, y + f64::from(j) * step))
            .collect();
        around.chunks(PACKET).any(|rays| fine.reach_of(rays)[..rays.len()].iter().any(|t| t.is_finite()))
    })
}

/// The solid that ends.
struct Solid<'a> {
    graph: &'a Graph,
    boxes: &'a ExactBoxes<Graph>,
    pixels: Pixels,
}

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
    /// Where a point is seen that lies before the eye.
    fn of(&self, point: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = self.from_world * (point - self.eye);
        (z > 0.0).then(|| DVec2::new(x, y) / z)
    }
}

impl Solid<'_> {
    /// Whether all of the box of some part is no farther than half a pixel from a place of the picture.
    fn is_near(&self, place: DVec2) -> bool {
        let mut open = vec![(DAffine3::IDENTITY, self.graph.root_state())];
        while let Some((world_from_state, state)) = open.pop() {
            let bounds = self.boxes.of(&state).map_or(Aabb::ALL, |found| found.aabb);
            if bounds.is_empty() {
                continue;
            }
            let corners = bounds.corners().into_iter();
            let seen = corners
                .map(|corner| Some(self.pixels.of(world_from_state.transform_point3(corner))? - place));
            if let Some(corners) = seen.collect::<Option<Vec<_>>>() {
                if corners.iter().all(|corner| corner.length() <= 0.5) {
                    return true;
                }
                let min = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
                let max = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
                if DVec2::ZERO.clamp(min, max).length() > 0.5 {
                    continue;
                }
            }
            match self.graph.step(&state).expect("a state that has been traced") {
                Step::Transform(parent_from_child, below) => {
                    open.push((world_from_state * parent_from_child.to_affine(), below));
                }
                Step::Operator(Operator::Union, below) => {
                    open.extend(below.map(|below| (world_from_state, below)));
                }
                Step::Select(below) | Step::Calculate(below) | Step::Attribute(_, below) => {
                    open.push((world_from_state, below));
                }
                // What is cut or large was met by rays or was not.
                _ => {}
            }
        }
        false
    }
}

impl Tally {
    fn join(self, other: Self) -> Self {
        Self {
            met: self.met + other.met,
            only_deeper: self.only_deeper + other.only_deeper,
            only_endless: self.only_endless + other.only_endless,
            far: self.far + other.far,
        }
    }
}
