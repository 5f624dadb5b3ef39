//! From a world to a picture: [tiles](crate::tiles) in parallel.

use std::sync::atomic::{AtomicU64, Ordering};

use csg_graph::EvalError;
use glam::DVec3;
use rayon::prelude::*;

use crate::camera::{CameraError, Lens};
use crate::engine::{Engine, Tracer};
use crate::integrate::Illumination;
use crate::tiles::{Tile, Tiles};
use crate::view::{Exposure, Extremes, Latent};
use crate::{Camera, Counters, Film, Hit, Integrator, Light, Ray, Sky, View, sampling};

/// The most pixels that a picture may have: 8192 by 8192. While it is made, a pixel takes 32 bytes.
pub const MAX_PIXELS: u64 = 1 << 26;

/// The most samples that a pixel may have.
pub const MAX_SAMPLES: u32 = 4096;

/// The most bounces of light from surface to surface.
pub const MAX_BOUNCES: u32 = 1024;

/// What a picture is of.
#[derive(Clone, Debug)]
pub struct World<'a> {
    /// The solid, and what finds where rays meet it. Engines and boxes change the time that it takes, and the plate and
    /// cost views.
    pub engine: Engine<'a>,
    /// Where it is seen from.
    pub camera: Camera,
    /// All lights. Without any, only the ambient part of surfaces is seen; see [`Light::over_shoulder`].
    pub lights: Vec<Light>,
    /// What is seen where there is no solid, and lights it by [`Integrator::Path`].
    pub background: Sky,
}

impl World<'_> {
    /// A pale sky.
    pub const DEFAULT_BACKGROUND: Sky = Sky::uniform(DVec3::new(0.55, 0.70, 0.90));
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
    /// How its light is computed.
    pub integrator: Integrator,
    /// How often light is followed from one surface to the next: mirrors and glass for [`Integrator::Direct`], all surfaces
    /// for [`Integrator::Path`]. With one bounce, surfaces are lit by what shines of itself.
    pub bounces: u32,
}

impl Default for Settings {
    /// What `pcsg render` takes where nobody asks for anything.
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples: 4,
            view: View::Shaded,
            integrator: Integrator::Direct,
            bounces: 16,
        }
    }
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
    /// The number of bounces is 0 or more than [`MAX_BOUNCES`].
    #[error("light bounces 1 to {MAX_BOUNCES} times, not {bounces}")]
    Bounces {
        /// The number that was asked for.
        bounces: u32,
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
    let Settings { width, height, samples, view, bounces, .. } = *settings;
    check_size(width, height)?;
    if samples == 0 || samples > MAX_SAMPLES {
        return Err(RenderError::Samples { samples });
    }
    if bounces == 0 || bounces > MAX_BOUNCES {
        return Err(RenderError::Bounces { bounces });
    }
    let painter = Painter { world, settings, lens: world.camera.lens(width, height)? };

    let tiles = Tiles { width, height };
    let done = AtomicU64::new(0);
    let painted: Vec<Painted> = (0..tiles.count())
        .into_par_iter()
        .map_init(
            || Brush::new(world, settings),
            |brush, index| {
                let painted = painter.paint(brush, &tiles.tile(index))?;
                let pixels = painted.pixels.len() as u64;
                progress(done.fetch_add(pixels, Ordering::Relaxed) + pixels);
                Ok(painted)
            },
        )
        .collect::<Result<_, EvalError>>()?;

    let mut counters = Counters::default();
    let mut extremes = Extremes::NONE;
    let mut latent = Vec::with_capacity(painted.len());
    for tile in painted {
        counters += tile.counters;
        extremes = extremes.join(tile.extremes);
        latent.push(tile.pixels);
    }
    let pixels = tiles.in_rows(&latent).map(|latent| view.develop(latent, &extremes)).collect();
    Ok((Film::new(width, height, pixels), counters))
}

/// Refuses a picture without pixels, or with too many.
pub(crate) fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
    let total = u64::from(width) * u64::from(height);
    if total == 0 || total > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    Ok(())
}

/// A finished tile.
struct Painted {
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
    fn paint(&self, brush: &mut Brush<'_>, tile: &Tile) -> Result<Painted, EvalError> {
        let mut extremes = Extremes::NONE;
        let mut exposures = vec![Exposure::default(); tile.pixel_count()];
        // What a pixel costs, and how deep its ray went, are known of single rays.
        let alone = matches!(self.settings.view, View::Cost | View::Plate);
        let side = if alone { 1 } else { self.world.engine.side() };
        for square in tile.squares(side) {
            brush.pixels.clear();
            brush.pixels.extend(square);
            self.expose(brush, |pixel| tile.place(pixel), &mut exposures, &mut extremes)?;
        }
        let samples = f64::from(self.settings.samples);
        let pixels = exposures.iter().map(|exposure| exposure.latent(samples)).collect();
        Ok(Painted { pixels, extremes, counters: brush.tracer.take_counters() })
    }

    /// Exposes the pixels of a brush, one sample of each at a time.
    fn expose(
        &self,
        brush: &mut Brush<'_>,
        place: impl Fn((u32, u32)) -> usize,
        exposures: &mut [Exposure],
        extremes: &mut Extremes,
    ) -> Result<(), EvalError> {
        let Settings { samples, view, .. } = *self.settings;
        let Brush { tracer, illumination, pixels, rays, hits, colours } = brush;
        let tests_before = tracer.counters().tests();
        for (sample, offset) in (0..).zip(sampling::places(samples)) {
            rays.clear();
            rays.extend(
                pixels.iter().map(|(x, y)| self.lens.ray(f64::from(*x) + offset.x, f64::from(*y) + offset.y)),
            );
            tracer.nearest(rays, hits)?;
            let missed = tracer.missed_depth();
            if matches!(view, View::Shaded | View::Plate | View::Cost) {
                illumination.colours(tracer, pixels, sample, rays, hits, colours)?;
            }
            for (lane, (pixel, hit)) in pixels.iter().zip(hits.iter()).enumerate() {
                let exposure = &mut exposures[place(*pixel)];
                match (view, hit) {
                    (View::Shaded, _) | (View::Plate, Some(_)) => exposure.colour(colours[lane]),
                    (View::Plate, None) => exposure.missed(missed, extremes),
                    (View::Normal, Some(hit)) => exposure.normal(hit.normal),
                    (View::Depth, Some(hit)) => exposure.depth(hit.t, extremes),
                    (View::Normal | View::Depth, None) | (View::Cost, _) => {}
                }
            }
        }
        if view == View::Cost {
            let tests = tracer.counters().tests() - tests_before;
            exposures[place(pixels[0])].cost(tests as f64, extremes);
        }
        Ok(())
    }
}

/// What a thread paints with: a tracer, and memory for the rays that it traces together.
struct Brush<'a> {
    tracer: Tracer<'a>,
    illumination: Illumination,
    pixels: Vec<(u32, u32)>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    colours: Vec<DVec3>,
}

impl<'a> Brush<'a> {
    fn new(world: &World<'a>, settings: &Settings) -> Self {
        Self {
            tracer: world.engine.tracer(),
            illumination: Illumination::new(world, settings),
            pixels: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            colours: Vec::new(),
        }
    }
}
