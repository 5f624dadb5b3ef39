//! The picture in the making.
//!
//! All pixels get their first sample, then all get their second one, and so on in passes of growing length: at any time
//! there is a picture of what was seen so far. What is kept of a pixel are sums, to which the next samples are added in the
//! order of their numbers. So the finished picture does not depend on how the work was cut into passes, nor on when it was
//! interrupted and taken up again.
//!
//! Samples are counted by squares of pixels. A pass gives each square that wants more a *goal*; a square reaches its goal
//! at once or not at all, and only when all have reached theirs, new ones are set. So what a square wants may depend on the
//! whole picture, as it does where [noise](crate::noise) decides, and still on nothing else.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use csg_graph::EvalError;
use rayon::prelude::*;
use smallvec::{SmallVec, smallvec};

use crate::noise::{self, Errors};
use crate::render::{Brush, Painter};
use crate::tiles::{self, Tile, Tiles};
use crate::view::{Exposure, Extremes};
use crate::{Counters, Film, RenderError, Settings, View, World, fast, srgb};

/// Pixels on a side of a square: what the fast engine traces together.
pub(crate) const SQUARE: u32 = fast::PACKET_SIDE;

/// A picture in the making: exposed to some of its samples, and more can follow.
///
/// [`render`](fn@crate::render) makes a picture at once. This is for pictures that take long: they can be looked at, stopped,
/// [saved](Self::save), [loaded](Self::load) and continued, and come out the same.
///
/// It takes 24 bytes a pixel, or 48 if noise decides when a pixel has enough samples, and as much again for a moment each
/// time that it does; the [film](Film) that it is developed into, 12 more, or the bytes of a screen, 3. The colour plate takes
/// 16 more, and the views of depth and cost only these 16.
///
/// ```
/// use csg_graph::{GraphBuilder, PrimitiveKind};
/// use csg_graph_bounds::{Limits, exact};
/// use csg_graph_trace::{Accelerated, Camera, Engine, LatentImage, Light, Settings, World, render};
///
/// let mut builder = GraphBuilder::new();
/// let ball = builder.primitive(PrimitiveKind::Sphere, []);
/// let graph = builder.finish(ball)?;
/// let boxes = exact(&graph, &Limits::default())?;
/// let camera = Camera::framing(&boxes.root, Camera::DEFAULT_FOV, 1.0);
/// let accelerated = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET)?;
/// let world = World {
///     engine: Engine::Fast(&accelerated),
///     camera,
///     lights: vec![Light::over_shoulder(&camera)],
///     background: World::DEFAULT_BACKGROUND,
/// };
/// let settings = Settings { width: 32, height: 32, samples: 9, ..Settings::default() };
///
/// let mut image = LatentImage::new(&settings)?;
/// let enough = std::sync::atomic::AtomicU64::new(0);
/// let stop = || enough.load(std::sync::atomic::Ordering::Relaxed) > 2000;
/// let is_complete = image.expose(&world, &stop, &|done| enough.store(done, std::sync::atomic::Ordering::Relaxed))?;
/// assert!(!is_complete && image.samples().contains(&2));
///
/// let mut file = Vec::new();
/// image.save(&mut file)?;
/// let mut again = LatentImage::load(&settings, &mut file.as_slice())?;
/// assert!(again.expose(&world, &|| false, &|_| {})?);
/// assert_eq!(again.develop(), render(&world, &settings, &|_| {})?.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LatentImage {
    pub(crate) settings: Settings,
    pub(crate) tiles: Tiles,
    pub(crate) exposure: Exposure,
    /// The squares of each tile.
    pub(crate) squares: Vec<Squares>,
    pub(crate) counters: Counters,
    /// Of the samples, those that met the solid.
    pub(crate) hits: u64,
}

/// Row by row of a tile.
pub(crate) type Squares = SmallVec<[Square; (tiles::SIDE / SQUARE * tiles::SIDE / SQUARE) as usize]>;

/// How many samples each pixel of a square has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Square {
    pub(crate) taken: u32,
    /// How many it is to have at the end of the pass.
    pub(crate) goal: u32,
}

impl Square {
    fn is_short(&self) -> bool {
        self.taken < self.goal
    }

    /// How many samples there are after the next pass.
    fn next(self, most: u32) -> u32 {
        let more = if self.taken < noise::FEWEST { self.taken } else { (self.taken / 2).min(LONGEST) };
        self.taken.saturating_add(more.max(1)).min(most)
    }
}

/// The most samples of a pixel in one pass. A square is not interrupted, and should not take long.
const LONGEST: u32 = 256;

impl LatentImage {
    /// A picture without any sample.
    ///
    /// # Errors
    /// If the settings are out of range.
    pub fn new(settings: &Settings) -> Result<Self, RenderError> {
        settings.check()?;
        let Settings { width, height, view, noise, .. } = *settings;
        let tiles = Tiles { width, height };
        let exposure = Exposure::new(view, tiles, noise.is_some());
        let squares = tiles.iter().map(|tile| smallvec![Square::default(); tile.squares(SQUARE).count()]);
        let squares = squares.collect();
        Ok(Self { settings: *settings, tiles, exposure, squares, counters: Counters::default(), hits: 0 })
    }

    /// Adds samples until there are enough, which is to say `true`, or until `stop` says so, on the threads of the rayon
    /// pool that it is called in. The world has to be the same each time.
    ///
    /// `stop` is asked often, from all threads, and should be quick. `progress` is called now and then, from any of the
    /// threads, with the number of samples that are taken or turned out not to be needed, of width times height times
    /// [`samples`](Settings::samples). The graph must unfold into something finite (`Graph::analyse` tells), or a ray may
    /// never come back.
    ///
    /// # Errors
    /// If the camera shows nothing, or an evaluation fails. Then the picture is of no use any more.
    ///
    /// # Panics
    /// If the boxes of the world are of another graph.
    pub fn expose(
        &mut self,
        world: &World<'_>,
        stop: &(dyn Fn() -> bool + Sync),
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<bool, RenderError> {
        let Self { settings, tiles, .. } = *self;
        let painter = Painter::new(world, &settings)?;
        let all = u64::from(settings.width) * u64::from(settings.height) * u64::from(settings.samples);
        loop {
            if !self.set_goals() {
                return Ok(true);
            }
            if stop() {
                return Ok(false);
            }
            let done = AtomicU64::new(all - self.left());
            let patches = self.exposure.patches(tiles).zip(&mut self.squares).zip(tiles.iter());
            let brush = || Brush::new(world, &settings);
            let spent = tiles::find_in_each(patches, brush, |brush, ((patch, squares), tile)| {
                let painted = painter.paint(brush, &tile, squares, patch, stop)?;
                if painted.samples > 0 {
                    progress(done.fetch_add(painted.samples, Ordering::Relaxed) + painted.samples);
                }
                Ok::<_, EvalError>((painted.counters, painted.hits))
            })?;
            for (counters, hits) in spent {
                self.counters += counters;
                self.hits += hits;
            }
        }
    }

    /// The picture of the samples so far, on the threads of the rayon pool that it is called in. A pixel without any is
    /// black.
    pub fn develop(&self) -> Film {
        let Settings { width, height, .. } = self.settings;
        Film::new(width, height, self.developed([0.0; 3], |pixel| pixel))
    }

    /// The picture of the samples so far as [`Film::to_srgb8`] would give it, without a film, which takes four times the
    /// memory.
    pub fn to_srgb8(&self) -> Vec<u8> {
        let bytes = srgb::Bytes::new();
        self.developed([0; 3], |pixel| pixel.map(|channel| bytes.encode(channel))).into_flattened()
    }

    /// Something of each pixel in linear light, row by row.
    fn developed<T: Copy + Send + Sync>(&self, blank: T, of: impl Fn([f32; 3]) -> T + Sync) -> Vec<T> {
        let Self { settings: Settings { view, .. }, exposure, .. } = self;
        let mut extremes = exposure.extremes.iter().copied().fold(Extremes::NONE, Extremes::join);
        if *view == View::Cost {
            for (square, pixels) in self.squares().filter(|(square, _)| square.taken > 0) {
                pixels.places().for_each(|place| extremes.note(exposure.mean_cost(place, square.taken)));
            }
        }
        self.in_rows(blank, |places, samples, to| {
            exposure.develop(*view, places, samples, &extremes, to, &of);
        })
    }

    /// How many samples each pixel has, row by row from the upper left corner.
    pub fn samples(&self) -> Vec<u32> {
        self.in_rows(0, |_, samples, to| to.fill(samples))
    }

    /// How many samples all pixels have together.
    pub fn samples_taken(&self) -> u64 {
        self.squares().map(|(square, pixels)| u64::from(square.taken) * pixels.pixel_count() as u64).sum()
    }

    /// How many of these met the solid.
    pub fn hits(&self) -> u64 {
        self.hits
    }

    /// What was counted of all samples.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Something of each pixel, row by row. It is asked for square by square: the places of the pixels in the exposure, how
    /// many samples each of them has, and where it goes.
    pub(crate) fn in_rows<T: Copy + Send + Sync>(
        &self,
        blank: T,
        fill: impl Fn(Range<usize>, u32, &mut [T]) + Sync,
    ) -> Vec<T> {
        let Self { settings: Settings { width, height, .. }, tiles, squares, .. } = self;
        let [width, height] = [*width, *height].map(|side| side as usize);
        let mut picture = vec![blank; width * height];
        // A row of tiles each.
        let bands = picture.par_chunks_mut(width * tiles::SIDE as usize);
        let bands = bands.zip(squares.par_chunks(tiles.across() as usize)).zip(0..tiles.down());
        bands.for_each(|((rows, squares), band)| {
            let mut own = [blank; (SQUARE * SQUARE) as usize];
            for (squares, index) in squares.iter().zip(band * tiles.across()..) {
                let tile = tiles.tile(index);
                for (square, pixels) in squares.iter().zip(tile.squares(SQUARE)) {
                    let own = &mut own[..pixels.pixel_count()];
                    fill(pixels.places(), square.taken, own);
                    let mut start = (pixels.rows.start - tile.rows.start) as usize * width;
                    start += pixels.columns.start as usize;
                    for row in own.chunks_exact(pixels.columns.len()) {
                        rows[start..start + row.len()].copy_from_slice(row);
                        start += width;
                    }
                }
            }
        });
        picture
    }

    /// Sets goals, unless some are not reached yet. Whether there is anything to do.
    fn set_goals(&mut self) -> bool {
        let most = self.settings.samples;
        let mut all = self.squares.iter().flatten();
        if all.clone().any(Square::is_short) {
            return true;
        }
        let is_judged = |square: &Square| square.taken >= noise::FEWEST && square.taken < most;
        let errors =
            self.settings.noise.filter(|_| all.any(is_judged)).map(|limit| (limit, Errors::estimate(self)));
        let mut has_any = false;
        for (squares, tile) in self.squares.iter_mut().zip(self.tiles.iter()) {
            for (square, pixels) in squares.iter_mut().zip(tile.squares(SQUARE)) {
                let is_quiet =
                    |(limit, errors): &(f64, Errors)| is_judged(square) && errors.around(&pixels) <= *limit;
                if square.taken < most && !errors.as_ref().is_some_and(is_quiet) {
                    square.goal = square.next(most);
                    has_any = true;
                }
            }
        }
        has_any
    }

    /// All squares, and the pixels of each.
    fn squares(&self) -> impl Iterator<Item = (&Square, Tile)> {
        let tiles = self.squares.iter().zip(self.tiles.iter());
        tiles.flat_map(|(squares, tile)| squares.iter().zip(tile.squares(SQUARE)))
    }

    /// How many samples there may be to take, at most.
    fn left(&self) -> u64 {
        let most = self.settings.samples;
        let short = self.squares().filter(|(square, _)| square.is_short());
        short.map(|(square, pixels)| u64::from(most - square.taken) * pixels.pixel_count() as u64).sum()
    }
}
