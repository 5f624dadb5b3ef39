//! One scene, many rays, and all engines: what they say differently, and whether a silhouette excuses it.
//!
//! The reference walk is what the others are compared with: the fast engine ray by ray, in packets, and with all boxes
//! open; the grid; and the [unfolded tree](unfolded). Hits are the same if they are on the same primitive node, at the
//! same t up to [`PRECISION`]. Rays that pass an edge by less than rounding errors may be answered either way. That is
//! not taken on trust: such a ray is aimed anew, by [`ASIDE`] of its length to all sides, and it is at a *silhouette* if
//! the reference walk then gives some of these rays the other answer. What is not at a silhouette is a disagreement.

mod rays;
mod unfolded;

use std::error::Error;
use std::fmt;
use std::path::Path;

use csg_graph::{EvalError, Graph};
use csg_graph_bounds::{ExactBoxes, HyperBoxes, Limits, exact};
use csg_graph_grammar::{Override, Scene, load};
use csg_graph_trace::{Accelerated, Camera, Grid, GridTracer, Hit, PACKET, Ray, Tracer, Walk};
use rayon::prelude::*;

use rays::{BLOCK, Rays};
use unfolded::Unfolded;

/// How much t may differ, relative to the farther of the hit and the origin of the world: what a ray loses on its way
/// through the frames is relative to its coordinates.
const PRECISION: f64 = 1e-9;

/// How far rays are aimed aside to find out whether they pass an edge, relative to their length.
const ASIDE: f64 = 1e-7;

/// To how many sides.
const SIDES: u32 = 64;

/// How much farther a ray that is aimed aside may go, relative to its length: surfaces fall away behind an edge.
const BEHIND: f64 = 1e-3;

/// The boxes of the program's engines.
const GAP: f64 = 1e-2;

/// An engine that is compared with the reference walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Other {
    /// The fast engine, ray by ray.
    Single,
    /// And in packets.
    Packets,
    /// And with all its boxes open.
    Open,
    Grid,
    Unfolded,
}

impl Other {
    pub(crate) const ALL: [Self; 5] = [Self::Single, Self::Packets, Self::Open, Self::Grid, Self::Unfolded];
}

impl fmt::Display for Other {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Single => "fast, single",
            Self::Packets => "fast, packets",
            Self::Open => "fast, no boxes",
            Self::Grid => "grid",
            Self::Unfolded => "unfolded",
        })
    }
}

/// What was found of one engine.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) rays: u64,
    /// That differed at a silhouette.
    pub(crate) silhouettes: u64,
    /// That differed without one: all are counted, and some told.
    pub(crate) disagreements: u64,
    pub(crate) told: Vec<Disagreement>,
    /// The largest difference in t of hits that are the same, relative as [`PRECISION`] is.
    pub(crate) largest: f64,
}

/// A ray that was answered differently, not at a silhouette.
#[derive(Clone, Debug)]
#[expect(dead_code, reason = "printed as it is")]
pub(crate) struct Disagreement {
    ray: Ray,
    reference: Option<Hit>,
    other: Option<Hit>,
}

/// Disagreements that are told of each engine and scene.
const TOLD: usize = 3;

impl Tally {
    fn add(&mut self, other: Self) {
        self.rays += other.rays;
        self.silhouettes += other.silhouettes;
        self.disagreements += other.disagreements;
        self.told.extend(other.told);
        self.told.truncate(TOLD);
        self.largest = self.largest.max(other.largest);
    }
}

/// What was found in a scene: the rays that hit something, and the tallies of the engines in the order of the plan.
pub(crate) struct Findings {
    pub(crate) hits: u64,
    pub(crate) tallies: Vec<(Other, Tally)>,
}

/// A scene with all its engines.
pub(crate) struct Comparison {
    graph: Graph,
    pub(crate) camera: Camera,
    hyper_boxes: HyperBoxes,
    pub(crate) fast: Accelerated,
    open: Option<Accelerated>,
    unfolded: Option<Unfolded>,
    others: Vec<Other>,
}

/// What the rays of a packet meet.
type Hits = [Option<Hit>; PACKET];

impl Comparison {
    /// Reads a scene of the corpus, given by its path from `scenes` without an extension, sets parameters, and makes
    /// engines ready.
    pub(crate) fn new(name: &str, set: &[String], others: &[Other]) -> Result<Self, Box<dyn Error>> {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().find(|folder| folder.join("scenes").is_dir());
        let path = path.ok_or("no folder has the scenes")?.join("scenes").join(name).with_extension("pcsg");
        let set: Result<Vec<_>, _> = set.iter().map(|set| Override::parse(set)).collect();
        let set = set.map_err(|mistakes| format!("{name}: {mistakes:?}"))?;
        let source = std::fs::read_to_string(path)?;
        let Scene { graph, look, .. } =
            load(&source, &set).map_err(|mistakes| format!("{name}: {mistakes:?}"))?.scene;
        let boxes = boxes(&graph)?;
        let framed = Camera::framing(&boxes.root, Camera::DEFAULT_FOV, 1.0);
        let camera = Camera {
            eye: look.camera.eye.unwrap_or(framed.eye),
            target: look.camera.target.unwrap_or(framed.target),
            up: look.camera.up.unwrap_or(framed.up),
            fov: look.camera.fov.unwrap_or(framed.fov),
        };
        let has = |other| others.contains(&other);
        let compiled = || Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET);
        let fast = compiled()?;
        let open = has(Other::Open).then(compiled).transpose()?.map(Accelerated::without_boxes);
        let unfolded = has(Other::Unfolded).then(|| Unfolded::new(&graph)).transpose()?;
        let hyper_boxes = boxes.into_hyper_boxes();
        Ok(Self { graph, camera, hyper_boxes, fast, open, unfolded, others: others.to_vec() })
    }

    /// Asks all engines for the first hits of at least so many rays.
    pub(crate) fn run(&self, count: usize) -> Result<Findings, Box<dyn Error>> {
        let grid = Grid::new(&self.graph, boxes(&self.graph)?, None, Grid::DEFAULT_BUDGET)?;
        let rays = Rays::new(&self.camera, &self.hyper_boxes.root)?;
        let blocks = (0..count.div_ceil(BLOCK)).into_par_iter().map_init(
            || Engines::new(self, &grid),
            |engines, block| {
                let mut found = Findings::none(&self.others);
                rays.block(block as u64, |packet| engines.compare(packet, &mut found))?;
                Ok(found)
            },
        );
        let mut sum = Findings::none(&self.others);
        for block in blocks.collect::<Result<Vec<Findings>, EvalError>>()? {
            sum.hits += block.hits;
            sum.tallies.iter_mut().zip(block.tallies).for_each(|((_, sum), (_, tally))| sum.add(tally));
        }
        Ok(sum)
    }
}

impl Findings {
    fn none(others: &[Other]) -> Self {
        Self { hits: 0, tallies: others.iter().map(|other| (*other, Tally::default())).collect() }
    }
}

fn boxes(graph: &Graph) -> Result<ExactBoxes<Graph>, Box<dyn Error>> {
    Ok(exact(graph, &Limits::default().with_gap(GAP))?)
}

/// What a thread asks.
struct Engines<'a> {
    reference: Walk<'a>,
    fast: Tracer<'a>,
    open: Option<Tracer<'a>>,
    grid: GridTracer<'a>,
    unfolded: Option<unfolded::Tracer<'a>>,
}

impl<'a> Engines<'a> {
    fn new(comparison: &'a Comparison, grid: &'a Grid<'a>) -> Self {
        Self {
            reference: Walk::new(&comparison.graph, Some(&comparison.hyper_boxes)),
            fast: comparison.fast.tracer(),
            open: comparison.open.as_ref().map(Accelerated::tracer),
            grid: grid.tracer(),
            unfolded: comparison.unfolded.as_ref().map(Unfolded::tracer),
        }
    }

    /// Adds what the engines say of a packet to what was found, and gives what the reference walk says.
    fn compare(&mut self, packet: &[Ray; PACKET], found: &mut Findings) -> Result<Hits, EvalError> {
        let mut reference = [None; PACKET];
        for (hit, ray) in reference.iter_mut().zip(packet) {
            *hit = self.reference.nearest(ray)?;
        }
        found.hits += reference.iter().flatten().count() as u64;
        let alone = packet.map(|ray| self.fast.nearest(&ray));
        for (other, tally) in &mut found.tallies {
            let answers = self.ask(*other, packet, &alone)?;
            // What a ray is asked together with, and which boxes are tested on its way, change no bit of its answer.
            let to_the_bit = matches!(other, Other::Packets | Other::Open);
            for ((ray, answer), (expected, alone)) in
                packet.iter().zip(answers).zip(reference.iter().zip(&alone))
            {
                tally.rays += 1;
                if to_the_bit && answer != *alone {
                    tally.disagree(ray, *alone, answer);
                    continue;
                }
                match difference(ray, expected.as_ref(), answer.as_ref()) {
                    Some(difference) => tally.largest = tally.largest.max(difference),
                    None if self.at_silhouette(ray, expected.as_ref(), answer.as_ref())? => {
                        tally.silhouettes += 1
                    }
                    None => tally.disagree(ray, *expected, answer),
                }
            }
        }
        Ok(reference)
    }

    fn ask(&mut self, other: Other, packet: &[Ray; PACKET], alone: &Hits) -> Result<Hits, EvalError> {
        let mut hits = [None; PACKET];
        match other {
            Other::Single => hits = *alone,
            Other::Packets => self.fast.nearest_of(packet, &mut hits),
            Other::Open => {
                let tracer = self.open.as_mut().expect("it was made ready");
                hits = packet.map(|ray| tracer.nearest(&ray));
            }
            Other::Grid => hits = packet.map(|ray| self.grid.nearest(&ray)),
            Other::Unfolded => {
                let tracer = self.unfolded.as_mut().expect("it was made ready");
                for (hit, ray) in hits.iter_mut().zip(packet) {
                    *hit = tracer.nearest(ray)?;
                }
            }
        }
        Ok(hits)
    }

    /// Whether the reference walk gives the other answer to the ray as well, aimed a little aside.
    fn at_silhouette(
        &mut self,
        ray: &Ray,
        own: Option<&Hit>,
        other: Option<&Hit>,
    ) -> Result<bool, EvalError> {
        let t = own.into_iter().chain(other).map(|hit| hit.t).fold(0.0, f64::max);
        let target = ray.at(t);
        let reach = target.distance(ray.origin).max(target.length());
        let across = ray.direction.any_orthogonal_vector().normalize();
        let along = ray.direction.cross(across).normalize();
        for side in 0..SIDES {
            // Around and around, farther each time.
            let share = f64::from(side + 1) / f64::from(SIDES);
            let angle = 2.4 * f64::from(side);
            let aside = across * libm::cos(angle) + along * libm::sin(angle);
            let aimed = target + aside * (share * ASIDE * reach);
            let aimed = Ray { direction: (aimed - ray.origin) / t, ..*ray };
            let answer = self.reference.nearest(&aimed)?;
            let alike = match (answer, other) {
                (None, None) => true,
                (Some(answer), Some(other)) => {
                    answer.node == other.node && (answer.t - other.t).abs() <= BEHIND * other.t.max(t)
                }
                _ => false,
            };
            if alike {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

impl Tally {
    fn disagree(&mut self, ray: &Ray, reference: Option<Hit>, other: Option<Hit>) {
        self.disagreements += 1;
        if self.told.len() < TOLD {
            self.told.push(Disagreement { ray: *ray, reference, other });
        }
    }
}

/// How much two hits differ in t, if they are the same.
fn difference(ray: &Ray, one: Option<&Hit>, other: Option<&Hit>) -> Option<f64> {
    match (one, other) {
        (None, None) => Some(0.0),
        (Some(one), Some(other)) => {
            let way = (one.t - other.t).abs() * ray.direction.length();
            let reach = one.point.distance(ray.origin).max(one.point.length());
            let relative = way / reach;
            (one.node == other.node && relative <= PRECISION).then_some(relative)
        }
        _ => None,
    }
}
