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

use std::sync::atomic::{AtomicU64, Ordering};

use csg_graph::EvalError;
use rayon::prelude::*;

use crate::noise::{self, Errors};
use crate::render::{Brush, Painter};
use crate::tiles::{Tile, Tiles};
use crate::view::{Exposure, Extremes};
use crate::{Counters, Film, RenderError, Settings, View, World, fast};

/// Pixels on a side of a square: what the fast engine traces together.
pub(crate) const SQUARE: u32 = fast::SIDE;

/// A picture in the making: exposed to some of its samples, and more can follow.
///
/// [`render`](crate::render) makes a picture at once. This is for pictures that take long: they can be looked at, stopped,
/// [saved](Self::save), [loaded](Self::load) and continued, and come out the same.
///
/// It takes 24 bytes a pixel, or 48 if noise decides when a pixel has enough samples, and as much again for a moment each
/// time that it does; the [film](Film) that it is developed into, 12 more. The colour plate takes 16 more, and the views of
/// depth and cost only these 16.
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
    /// What is known of each tile.
    pub(crate) exposed: Vec<Exposed>,
    pub(crate) counters: Counters,
}

/// What is known of a tile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Exposed {
    pub(crate) exposure: Exposure,
    pub(crate) squares: Vec<Square>,
}

/// A pixel of a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    /// Among the pixels of the tile.
    pub(crate) place: usize,
    pub(crate) samples: u32,
}

impl Exposed {
    /// The pixels of the tile, square by square.
    pub(crate) fn pixels(&self, tile: &Tile) -> impl Iterator<Item = Pixel> {
        tile.squares(SQUARE).zip(&self.squares).flat_map(|(pixels, square)| {
            pixels.map(|at| Pixel { place: tile.place(at), samples: square.taken })
        })
    }
}

/// How many samples each pixel of a square has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Square {
    pub(crate) taken: u32,
    /// How many it is to have at the end of the pass.
    pub(crate) goal: u32,
}

impl Square {
    fn is_short(self) -> bool {
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
        let Settings { width, height, .. } = *settings;
        let tiles = Tiles { width, height };
        let unexposed = |index| {
            let squares = tiles.tile(index).squares(SQUARE).count();
            Exposed { exposure: Exposure::NONE, squares: vec![Square::default(); squares] }
        };
        let exposed = (0..tiles.count()).map(unexposed).collect();
        Ok(Self { settings: *settings, tiles, exposed, counters: Counters::default() })
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
            let spent = self.exposed.par_iter_mut().zip(0..tiles.count()).map_init(
                || Brush::new(world, &settings),
                |brush, (exposed, index)| {
                    let (taken, spent) = painter.paint(brush, &tiles.tile(index), exposed, stop)?;
                    if taken > 0 {
                        progress(done.fetch_add(taken, Ordering::Relaxed) + taken);
                    }
                    Ok::<_, EvalError>(spent)
                },
            );
            let sum = |mut a: Counters, b: Counters| {
                a += b;
                Ok(a)
            };
            self.counters += spent.try_reduce(Counters::default, sum)?;
        }
    }

    /// The picture of the samples so far. A pixel without any is black.
    pub fn develop(&self) -> Film {
        let Settings { width, height, view, .. } = self.settings;
        let mut extremes = Extremes::NONE;
        for (tile, exposed) in self.tiles() {
            extremes = extremes.join(exposed.exposure.extremes);
            if view == View::Cost {
                let seen = exposed.pixels(&tile).filter(|pixel| pixel.samples > 0);
                seen.for_each(|pixel| extremes.note(exposed.exposure.mean_cost(pixel.place, pixel.samples)));
            }
        }
        let develop = |exposed: &Exposed, pixel: Pixel| {
            exposed.exposure.develop(view, pixel.place, pixel.samples, &extremes)
        };
        Film::new(width, height, self.in_rows([0.0; 3], develop))
    }

    /// How many samples each pixel has, row by row from the upper left corner.
    pub fn samples(&self) -> Vec<u32> {
        self.in_rows(0, |_, pixel| pixel.samples)
    }

    /// What was counted of all samples.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    fn tiles(&self) -> impl Iterator<Item = (Tile, &Exposed)> {
        let tiles = self.tiles;
        (0..tiles.count()).map(move |index| tiles.tile(index)).zip(&self.exposed)
    }

    /// Something of each pixel, row by row.
    fn in_rows<T: Copy>(&self, blank: T, of: impl Fn(&Exposed, Pixel) -> T) -> Vec<T> {
        let [width, height] = [self.settings.width, self.settings.height].map(|side| side as usize);
        let mut rows = vec![blank; width * height];
        for (tile, exposed) in self.tiles() {
            let mut place = 0;
            for (y, columns) in tile.rows() {
                let squares = &exposed.squares[tile.first_square(SQUARE, y)..];
                let row = &mut rows[y as usize * width..][..width][columns];
                for (pixels, square) in row.chunks_mut(SQUARE as usize).zip(squares) {
                    for pixel in pixels {
                        *pixel = of(exposed, Pixel { place, samples: square.taken });
                        place += 1;
                    }
                }
            }
        }
        rows
    }

    /// Sets goals, unless some are not reached yet. Whether there is anything to do.
    fn set_goals(&mut self) -> bool {
        let most = self.settings.samples;
        if self.squares().any(Square::is_short) {
            return true;
        }
        let is_judged = |square: Square| square.taken >= noise::FEWEST && square.taken < most;
        let errors = self
            .settings
            .noise
            .filter(|_| self.squares().any(is_judged))
            .map(|limit| (limit, Errors::estimate(self)));
        let tiles = self.tiles;
        let mut has_any = false;
        for (exposed, index) in self.exposed.iter_mut().zip(0..tiles.count()) {
            for (square, mut pixels) in exposed.squares.iter_mut().zip(tiles.tile(index).squares(SQUARE)) {
                let is_quiet = |(limit, errors): &(f64, Errors)| {
                    is_judged(*square) && pixels.next().is_none_or(|corner| errors.around(corner) <= *limit)
                };
                if square.taken < most && !errors.as_ref().is_some_and(is_quiet) {
                    square.goal = square.next(most);
                    has_any = true;
                }
            }
        }
        has_any
    }

    fn squares(&self) -> impl Iterator<Item = Square> {
        self.exposed.iter().flat_map(|exposed| exposed.squares.iter().copied())
    }

    /// How many samples there may be to take, at most.
    fn left(&self) -> u64 {
        let most = self.settings.samples;
        let of_tile = |(tile, exposed): (Tile, &Exposed)| {
            let squares = exposed.squares.iter().zip(tile.squares(SQUARE));
            let short = squares.filter(|(square, _)| square.is_short());
            short.map(|(square, pixels)| u64::from(most - square.taken) * pixels.count() as u64).sum::<u64>()
        };
        self.tiles().map(of_tile).sum()
    }
}
