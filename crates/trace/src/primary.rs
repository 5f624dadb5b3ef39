//! Primary rays without a picture: what the ray through the centre of each pixel meets, counted or kept.

use csg_graph::{EvalError, NodeId};

use crate::camera::Lens;
use crate::engine::Tracer;
use crate::render::check_size;
use crate::tiles::{self, Tile, Tiles};
use crate::{Beam, Counters, Footprint, Hit, Ray, RenderError, World};

/// What the primary rays of a picture cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PrimaryPass {
    /// The rays that met the solid.
    pub hits: u64,
    /// What was counted of all rays.
    pub counters: Counters,
}

/// What a pixel shows besides its colour: what the ray through its centre meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Probe {
    /// How far along the viewing direction; infinite where the ray meets nothing.
    pub depth: f32,
    /// The outward normal of the solid in the world, of length 1; zero where there is none.
    pub normal: [f32; 3],
    /// The point in the world; zero where there is none.
    pub position: [f32; 3],
    /// The recursion depth: the number of S-nodes on the path to the primitive.
    pub recursion: u32,
    /// The primitive node whose surface it is.
    pub node: Option<NodeId>,
    /// The state of the last S-node on the path to the primitive, by its place among all states: those that
    /// [`ExactBoxes::states`](csg_graph_bounds::ExactBoxes::states) lists, and `Graph::states` in the same order. The same for
    /// all engines.
    pub state: Option<u32>,
    /// The boxes that the ray was tested against.
    pub box_tests: u32,
    /// And the primitives.
    pub primitive_tests: u32,
}

/// Traces one ray through the centre of each pixel, on the threads of the rayon pool that it is called in, to where it
/// meets the solid, and keeps nothing: what a picture costs before it is shaded. Engines that find a hit before they find
/// out what is hit are not asked for that.
///
/// # Errors
/// As [`render`](fn@crate::render), of which it is a part.
///
/// # Panics
/// If the boxes are of another graph.
pub fn primary(world: &World<'_>, width: u32, height: u32) -> Result<PrimaryPass, RenderError> {
    let side = world.engine.side();
    trace(
        world,
        width,
        height,
        || world.engine.tracer(),
        |probing, tile| {
            let mut pass = PrimaryPass::default();
            let beam = tile.beam(probing.lens);
            for square in tile.squares(side) {
                pass.hits += probing.count_hits(&beam, square.pixels())?;
            }
            pass.counters = probing.tracer.take_counters();
            Ok(pass)
        },
    )
    .map(|(_, passes)| {
        passes.into_iter().fold(PrimaryPass::default(), |mut sum, pass| {
            sum.hits += pass.hits;
            sum.counters += pass.counters;
            sum
        })
    })
}

/// Traces one ray through the centre of each pixel, on the threads of the rayon pool that it is called in, and keeps what
/// it meets: a probe for each pixel, row by row from the upper left corner. Rays are traced one by one, so that each has
/// a cost of its own. A probe takes 56 bytes, and as many again until all are in rows. For the reference walk and the grid,
/// all states are listed first.
///
/// # Errors
/// As [`render`](fn@crate::render), and if the states have no list.
///
/// # Panics
/// If the boxes are of another graph.
pub fn probe(world: &World<'_>, width: u32, height: u32) -> Result<Vec<Probe>, RenderError> {
    let numbers = world.engine.state_numbers()?;
    let tracer = || world.engine.numbering_tracer(&numbers);
    let traced = trace(world, width, height, tracer, |probing, tile| {
        tile.pixels()
            .map(|pixel| {
                let hit = probing.nearest([pixel])?[0];
                let state = hit.and_then(|_| probing.tracer.last_symbol());
                Ok(Probe::new(hit.as_ref(), state, &probing.tracer.take_counters()))
            })
            .collect::<Result<Vec<_>, _>>()
    });
    let (tiles, probes) = traced.map(|(tiles, probes)| (tiles, probes.concat()))?;
    Ok(tiles.in_rows(&probes))
}

/// What `trace_tile` finds in each tile.
fn trace<'a, T: Send>(
    world: &World<'_>,
    width: u32,
    height: u32,
    tracer: impl Fn() -> Tracer<'a> + Sync,
    trace_tile: impl Fn(&mut Probing<'_>, &Tile) -> Result<T, EvalError> + Sync,
) -> Result<(Tiles, Vec<T>), RenderError> {
    check_size(width, height)?;
    let lens = world.camera.lens(width, height)?;
    let tiles = Tiles { width, height };
    let probing = || Probing { lens: &lens, tracer: tracer(), rays: Vec::new(), hits: Vec::new() };
    let found = tiles::find_in_each(tiles.iter(), probing, |probing, tile| trace_tile(probing, &tile))?;
    Ok((tiles, found))
}

/// What a thread probes with.
struct Probing<'a> {
    lens: &'a Lens,
    tracer: Tracer<'a>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

impl Probing<'_> {
    /// How many of the rays through some pixels of a beam meet anything, no more rays than the engine takes together.
    fn count_hits(
        &mut self,
        beam: &Beam,
        pixels: impl IntoIterator<Item = (u32, u32)>,
    ) -> Result<u64, EvalError> {
        self.aim(pixels);
        self.tracer.count_hits(beam.batch(&self.rays))
    }

    /// What the rays through some pixels meet, no more than the engine takes together.
    fn nearest(&mut self, pixels: impl IntoIterator<Item = (u32, u32)>) -> Result<&[Option<Hit>], EvalError> {
        self.aim(pixels);
        self.tracer.nearest((&self.rays).into(), &mut self.hits)?;
        Ok(&self.hits)
    }

    fn aim(&mut self, pixels: impl IntoIterator<Item = (u32, u32)>) {
        self.tracer.set_footprint(Footprint { width: 0.0, spread: self.lens.spread() });
        let ray = |(x, y): (u32, u32)| self.lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        self.rays.clear();
        self.rays.extend(pixels.into_iter().map(ray));
    }
}

impl Probe {
    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    fn new(hit: Option<&Hit>, state: Option<u32>, counters: &Counters) -> Self {
        Self {
            depth: hit.map_or(f32::INFINITY, |hit| hit.t as f32),
            normal: hit.map_or([0.0; 3], |hit| hit.normal.as_vec3().to_array()),
            position: hit.map_or([0.0; 3], |hit| hit.point.as_vec3().to_array()),
            recursion: hit.map_or(0, |hit| hit.depth),
            node: hit.map(|hit| hit.node),
            state,
            box_tests: u32::try_from(counters.box_tests).unwrap_or(u32::MAX),
            primitive_tests: u32::try_from(counters.primitive_tests).unwrap_or(u32::MAX),
        }
    }
}
