//! How far the silhouettes of what never ends are off: scenes of `scenes/endless` with what is smaller than half a pixel not
//! looked into, beside scenes that end far below.
//!
//! Of the rays that meet something in the first and nothing in the second one, it counts those from which it is farther than
//! half a pixel to any that would.
//!
//! `cargo run --release -p csg-graph-trace --example silhouettes`
#![expect(clippy::print_stdout, reason = "it prints a table")]

use std::error::Error;

use csg_graph_bounds::{Limits, exact};
use csg_graph_grammar::{Scene, load};
use csg_graph_trace::{Accelerated, Camera, Footprint, Lens, PACKET, StateBounds, Tracer};
use rayon::prelude::*;

/// Pixels on a side of the picture, and rays on a side of a pixel.
const SIDE: u32 = 512;
const RAYS: u32 = 4;

/// What stands in a scene, and in one that ends.
type Change = (&'static str, &'static str);

/// Scenes, how many levels those that end have, and how these differ.
const SCENES: [(&str, u32, [Change; 2]); 2] = [
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
    for (name, levels, changes) in SCENES {
        let path = format!("{}/../../scenes/endless/{name}.pcsg", env!("CARGO_MANIFEST_DIR"));
        let endless = std::fs::read_to_string(path)?;
        let ends = changes.iter().fold(endless.clone(), |text, (from, to)| text.replacen(from, to, 1));
        let (endless, ends) = (scene(&endless)?, scene(&ends)?);
        let asked = endless.look.camera;
        let camera = Camera {
            eye: asked.eye.ok_or("the scene has an eye")?,
            target: asked.target.ok_or("the scene has a target")?,
            up: asked.up.unwrap_or(glam::DVec3::Z),
            fov: asked.fov.unwrap_or(Camera::DEFAULT_FOV),
        };
        let lens = camera.lens(SIDE, SIDE)?;
        let bounds = StateBounds::Exact(Box::new(exact(&endless.graph, &Limits::default())?));
        let coarse = Accelerated::on_demand(endless.graph, bounds, 1 << 26)?.with_detail(0.5);
        let fine = Accelerated::new(&ends.graph, &exact(&ends.graph, &Limits::default())?, 1 << 20)?;
        let tally = (0..SIDE)
            .into_par_iter()
            .map_init(
                || (coarse.tracer(), fine.tracer()),
                |(coarse, fine), row| compare(coarse, fine, &lens, row),
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
fn compare(coarse: &mut Tracer<'_>, fine: &mut Tracer<'_>, lens: &Lens, row: u32) -> Tally {
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
                    tally.far += u64::from(!is_near(fine, lens, *place));
                }
                _ => {}
            }
        }
    }
    tally
}

/// Whether a ray no farther than half a pixel meets anything. What is looked for may be much thinner than a pixel.
fn is_near(fine: &mut Tracer<'_>, lens: &Lens, [x, y]: [f64; 2]) -> bool {
    [4_i32, 16, 64, 256].into_iter().any(|steps| {
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
