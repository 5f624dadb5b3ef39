//! From a world to a picture: tiles in parallel.
//!
//! A tile's pixels depend on nothing but their position, and tiles are put together in order, so that any number of threads
//! gives the same bytes.

use std::sync::atomic::{AtomicU64, Ordering};

use csg_graph::{EvalError, Graph};
use csg_graph_bounds::HyperBoxes;
use glam::DVec3;
use rayon::prelude::*;

use crate::camera::{CameraError, Lens};
use crate::shade::shade;
use crate::view::{Exposure, Extremes, Latent};
use crate::{Camera, Counters, Film, Light, View, Walk, sampling};

/// The most pixels that a picture may have: 8192 by 8192. While it is made, a pixel takes 32 bytes.
pub const MAX_PIXELS: u64 = 1 << 26;

/// The most samples that a pixel may have. More would change no byte of a picture.
pub const MAX_SAMPLES: u32 = 4096;

/// Pixels on a side of a tile: enough work to be worth handing out, little enough to share the last tiles.
const TILE: u32 = 16;

/// What a picture is of.
#[derive(Clone, Debug)]
pub struct World<'a> {
    /// The solid.
    pub graph: &'a Graph,
    /// Its hyper boxes, or `None` to do without. They change the time that it takes, and the plate and cost views.
    pub boxes: Option<&'a HyperBoxes>,
    /// Where it is seen from.
    pub camera: Camera,
    /// All lights. Without any, only the ambient part of surfaces is seen; see [`Light::over_shoulder`].
    pub lights: Vec<Light>,
    /// The colour where there is no solid, in linear light.
    pub background: DVec3,
}

impl World<'_> {
    /// A pale sky.
    pub const DEFAULT_BACKGROUND: DVec3 = DVec3::new(0.55, 0.70, 0.90);
}

/// What the picture is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Rays through each pixel. One goes through its centre; more are spread over it and averaged.
    pub samples: u32,
    /// What it shows.
    pub view: View,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture has no pixel or more than [`MAX_PIXELS`].
    #[error("a picture has 1 to {MAX_PIXELS} pixels, not {width} by {height}")]
    Size {
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
    },
    /// The number of samples is 0 or more than [`MAX_SAMPLES`].
    #[error("a pixel has 1 to {MAX_SAMPLES} samples, not {samples}")]
    Samples {
        /// The number that was asked for.
        samples: u32,
    },
    /// The camera shows nothing.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The graph cannot be evaluated where a ray came to.
    #[error(transparent)]
    Eval(#[from] EvalError),
}

/// Makes the picture, on the threads of the rayon pool that it is called in.
///
/// `progress` is called now and then, from any of the threads, with the number of pixels done. The graph must
/// unfold into something finite (`Graph::analyse` tells), or a ray may never come back.
///
/// # Errors
/// If the settings or the camera are out of range, or an evaluation fails.
///
/// # Panics
/// If the boxes are of another graph.
pub fn render(
    world: &World<'_>,
    settings: &Settings,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(Film, Counters), RenderError> {
    let Settings { width, height, samples, view } = *settings;
    let total = u64::from(width) * u64::from(height);
    if total == 0 || total > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    if samples == 0 || samples > MAX_SAMPLES {
        return Err(RenderError::Samples { samples });
    }
    let painter = Painter { world, settings, lens: world.camera.lens(width, height)? };

    let done = AtomicU64::new(0);
    let tiles: Vec<Tile> = (0..painter.tile_count())
        .into_par_iter()
        .map_init(
            || Walk::new(world.graph, world.boxes),
            |walk, index| {
                let tile = painter.tile(walk, index)?;
                let pixels = tile.pixels.len() as u64;
                progress(done.fetch_add(pixels, Ordering::Relaxed) + pixels);
                Ok(tile)
            },
        )
        .collect::<Result<_, EvalError>>()?;

    let mut counters = Counters::default();
    let mut extremes = Extremes::NONE;
    for tile in &tiles {
        counters += tile.counters;
        extremes = extremes.join(tile.extremes);
    }
    // Row by row: each row of tiles, each of its rows of pixels, across its tiles.
    let mut pixels = Vec::with_capacity(tiles.iter().map(|tile| tile.pixels.len()).sum());
    for row_of_tiles in tiles.chunks(width.div_ceil(TILE) as usize) {
        let rows = row_of_tiles[0].pixels.len() / row_of_tiles[0].width;
        for y in 0..rows {
            for tile in row_of_tiles {
                let row = &tile.pixels[y * tile.width..(y + 1) * tile.width];
                pixels.extend(row.iter().map(|latent| view.develop(latent, &extremes)));
            }
        }
    }
    Ok((Film::new(width, height, pixels), counters))
}

/// A finished tile.
struct Tile {
    width: usize,
    pixels: Vec<Latent>,
    extremes: Extremes,
    counters: Counters,
}

struct Painter<'a> {
    world: &'a World<'a>,
    settings: &'a Settings,
    lens: Lens,
}

impl Painter<'_> {
    fn tile_count(&self) -> u32 {
        self.settings.width.div_ceil(TILE) * self.settings.height.div_ceil(TILE)
    }

    fn tile(&self, walk: &mut Walk<'_>, index: u32) -> Result<Tile, EvalError> {
        let across = self.settings.width.div_ceil(TILE);
        let range = |tile: u32, size: u32| tile * TILE..size.min(tile.saturating_add(1).saturating_mul(TILE));
        let columns = range(index % across, self.settings.width);
        let rows = range(index / across, self.settings.height);
        let mut extremes = Extremes::NONE;
        let mut pixels = Vec::with_capacity(columns.len() * rows.len());
        for y in rows {
            for x in columns.clone() {
                pixels.push(self.pixel(walk, x, y, &mut extremes)?);
            }
        }
        Ok(Tile { width: columns.len(), pixels, extremes, counters: walk.take_counters() })
    }

    fn pixel(
        &self,
        walk: &mut Walk<'_>,
        x: u32,
        y: u32,
        extremes: &mut Extremes,
    ) -> Result<Latent, EvalError> {
        let Settings { samples, view, .. } = *self.settings;
        let lights = &self.world.lights;
        let mut exposure = Exposure::default();
        let tests_before = walk.counters().tests();
        for place in sampling::places(samples) {
            let ray = self.lens.ray(f64::from(x) + place.x, f64::from(y) + place.y);
            let hit = walk.nearest(&ray)?;
            match (view, &hit) {
                (View::Shaded | View::Plate, Some(hit)) => exposure.colour(shade(walk, lights, &ray, hit)?),
                (View::Shaded, None) => exposure.colour(self.world.background),
                (View::Plate, None) => exposure.missed(walk.missed_depth(), extremes),
                (View::Normal, Some(hit)) => exposure.normal(hit.normal),
                (View::Depth, Some(hit)) => exposure.depth(hit.t, extremes),
                // For what its shadow rays cost.
                (View::Cost, Some(hit)) => {
                    shade(walk, lights, &ray, hit)?;
                }
                (View::Normal | View::Depth | View::Cost, None) => {}
            }
        }
        if view == View::Cost {
            exposure.cost((walk.counters().tests() - tests_before) as f64, extremes);
        }
        Ok(exposure.latent(f64::from(samples)))
    }
}
