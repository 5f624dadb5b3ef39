//! From a world to a picture: what it is of, what it is like, and the samples that it is [made](crate::latent) from.

use std::ops::Range;

use csg_graph::{EvalError, StatesError};
use glam::{DVec2, DVec3};

use crate::camera::{CameraError, Lens};
use crate::engine::{Engine, Tracer};
use crate::integrate::Illumination;
use crate::latent::{SQUARE, Square};
use crate::tiles::Tile;
use crate::view::Patch;
use crate::{
    Batch, Beam, Camera, Counters, Film, Footprint, Hit, Integrator, LatentImage, Light, Ray, Sky, View,
    sampling,
};

/// The most pixels that a picture may have: 8192 by 8192. A pixel takes 36 bytes while the picture is made and developed,
/// or more: see [`LatentImage`].
pub const MAX_PIXELS: u64 = 1 << 26;

/// The most samples that a pixel may have.
pub const MAX_SAMPLES: u32 = 4096;

/// The most bounces of light from surface to surface.
pub const MAX_BOUNCES: u32 = 1024;

/// The most stops by which a picture may be made brighter or darker.
pub const MAX_EXPOSURE: f64 = 32.0;

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Rays through each pixel. One goes through its centre; more are spread over it and averaged.
    pub samples: u32,
    /// Squares of 4 by 4 pixels may do with fewer samples, from [`FEWEST_SAMPLES`](crate::FEWEST_SAMPLES) on, once their
    /// colours are known to within this many of the 255 steps that a screen has from black to white, as far as their
    /// samples and those of their neighbours tell. For the views that are colours of their own, shaded and normal. Without
    /// it, all pixels have all samples.
    pub noise: Option<f64>,
    /// What it shows.
    pub view: View,
    /// How its light is computed.
    pub integrator: Integrator,
    /// How often light is followed from one surface to the next: mirrors and glass for [`Integrator::Direct`], all surfaces
    /// for [`Integrator::Path`]. With one bounce, surfaces are lit by what shines of itself.
    pub bounces: u32,
    /// How much brighter than it is the light is taken, in stops, as photographers count: each doubles it. For the views with
    /// light, shaded and plate. It is a part of all that is kept of the picture, [films](Film) in linear light included.
    pub exposure: f64,
}

impl Default for Settings {
    /// What `pcsg render` takes where nobody asks for anything.
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples: 4,
            noise: None,
            view: View::Shaded,
            integrator: Integrator::Direct,
            bounces: 16,
            exposure: 0.0,
        }
    }
}

impl Settings {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let Self { width, height, samples, noise, view, integrator: _, bounces, exposure } = *self;
        check_size(width, height)?;
        if samples == 0 || samples > MAX_SAMPLES {
            return Err(RenderError::Samples { samples });
        }
        if bounces == 0 || bounces > MAX_BOUNCES {
            return Err(RenderError::Bounces { bounces });
        }
        if !(-MAX_EXPOSURE..=MAX_EXPOSURE).contains(&exposure) {
            return Err(RenderError::Exposure { exposure });
        }
        match noise {
            Some(noise) if noise.is_nan() || noise <= 0.0 => Err(RenderError::Noise { noise }),
            Some(_) if !matches!(view, View::Shaded | View::Normal) => Err(RenderError::NoiseOf { view }),
            _ => Ok(()),
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
    /// Noise below nothing cannot be reached.
    #[error("noise is allowed to be some steps above 0, not {noise}")]
    Noise {
        /// The steps that were asked for.
        noise: f64,
    },
    /// The view is relative to what the whole picture has, so that the noise of a pixel is not known by itself.
    #[error("noise is judged in the views shaded and normal, not in {view:?}")]
    NoiseOf {
        /// The view that was asked for.
        view: View,
    },
    /// The number of bounces is 0 or more than [`MAX_BOUNCES`].
    #[error("light bounces 1 to {MAX_BOUNCES} times, not {bounces}")]
    Bounces {
        /// The number that was asked for.
        bounces: u32,
    },
    /// The exposure is further from 0 than [`MAX_EXPOSURE`], or no number.
    #[error("a picture is exposed by -{MAX_EXPOSURE} to {MAX_EXPOSURE} stops more, not {exposure}")]
    Exposure {
        /// The stops that were asked for.
        exposure: f64,
    },
    /// The camera shows nothing.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The graph cannot be evaluated where a ray came to.
    #[error(transparent)]
    Eval(#[from] EvalError),
    /// The graph has no list of states, and what is asked for needs their numbers.
    #[error(transparent)]
    States(#[from] StatesError),
}

/// Makes the picture, on the threads of the rayon pool that it is called in.
///
/// `progress` is called now and then, from any of the threads, with the number of samples done, of width times height
/// times [`samples`](Settings::samples). The graph must unfold into something finite (`Graph::analyse` tells), or a ray
/// may never come back. [`LatentImage`] does the same in parts.
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
    let mut image = LatentImage::new(settings)?;
    image.expose(world, &|| false, progress)?;
    Ok((image.develop(), *image.counters()))
}

/// Refuses a picture without pixels, or with too many.
pub(crate) fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
    let total = u64::from(width) * u64::from(height);
    if total == 0 || total > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    Ok(())
}

/// Adds samples to tiles.
pub(crate) struct Painter<'a> {
    world: &'a World<'a>,
    view: View,
    /// What light is multiplied by.
    gain: f64,
    lens: Lens,
    /// Where in a pixel its samples are, in their order.
    places: Vec<DVec2>,
}

impl<'a> Painter<'a> {
    pub(crate) fn new(world: &'a World<'a>, settings: &Settings) -> Result<Self, CameraError> {
        let Settings { width, height, samples, view, exposure, .. } = *settings;
        let (lens, places) = (world.camera.lens(width, height)?, sampling::sequence(samples));
        Ok(Self { world, view, gain: libm::exp2(exposure), lens, places })
    }

    /// Brings the squares of a tile to their goals, one after the other, until `stop` says so.
    pub(crate) fn paint(
        &self,
        brush: &mut Brush<'_>,
        tile: &Tile,
        squares: &mut [Square],
        mut patch: Patch<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Painted, EvalError> {
        // What a pixel costs, and how deep its ray went, are known of single rays.
        let is_alone = matches!(self.view, View::Cost | View::Plate);
        let side = if is_alone { 1 } else { self.world.engine.side() };
        let (mut samples, mut hits) = (0, 0);
        let beam = tile.beam(&self.lens);
        for (square, own) in squares.iter_mut().zip(tile.squares(SQUARE)) {
            let mut patch = patch.split_off(own.pixel_count());
            if square.taken == square.goal {
                continue;
            }
            if stop() {
                break;
            }
            if square.taken == 0 {
                patch.touch();
            }
            let numbers = square.taken..square.goal;
            for together in own.squares(side) {
                let patch = patch.split_off(together.pixel_count());
                hits += self.expose(brush, &beam, &together, numbers.clone(), patch)?;
            }
            samples += numbers.len() as u64 * own.pixel_count() as u64;
            square.taken = square.goal;
        }
        Ok(Painted { samples, hits, counters: brush.tracer.take_counters() })
    }

    /// Exposes some pixels to their samples with these numbers, one sample of each at a time; gives the number of those that
    /// met the solid.
    fn expose(
        &self,
        brush: &mut Brush<'_>,
        beam: &Beam,
        together: &Tile,
        numbers: Range<u32>,
        mut patch: Patch<'_>,
    ) -> Result<u64, EvalError> {
        let Self { view, gain, .. } = *self;
        let Brush { tracer, illumination, pixels, rays, hits, colours } = brush;
        let Tile { columns, rows, .. } = together;
        pixels.clear();
        for y in rows.clone() {
            pixels.extend(columns.clone().map(|x| (x, y)));
        }
        let tests_before = tracer.counters().tests();
        let mut met = 0;
        for number in numbers {
            self.lens.rays(columns, rows, self.places[number as usize], rays);
            let footprint = Footprint { width: 0.0, spread: self.lens.spread() };
            tracer.set_footprint(footprint);
            // What all rays of a beam have in common is a part of what each of them costs.
            let batch = if view == View::Cost { Batch::from(&*rays) } else { beam.batch(rays) };
            tracer.nearest(batch, hits)?;
            met += hits.iter().flatten().count() as u64;
            // What leaves surfaces from here on sees as much as the closest of these rays.
            let nearest = hits.iter().flatten().map(|hit| hit.t).fold(f64::INFINITY, f64::min);
            tracer.set_footprint(footprint.onward(nearest));
            let missed = tracer.missed_depth();
            if matches!(view, View::Shaded | View::Plate | View::Cost) {
                illumination.colours(tracer, pixels, number, rays, hits, colours)?;
            }
            if view == View::Shaded {
                for (place, colour) in colours.iter().enumerate() {
                    patch.colour(place, number, *colour * gain);
                }
                continue;
            }
            for (place, hit) in hits.iter().enumerate() {
                match (view, hit) {
                    (View::Plate, Some(_)) => patch.colour(place, number, colours[place] * gain),
                    (View::Plate, None) => patch.missed(place, missed),
                    (View::Normal, Some(hit)) => patch.normal(place, number, hit.normal),
                    (View::Depth, Some(hit)) => patch.depth(place, hit.t),
                    (View::Normal | View::Depth, None) | (View::Shaded | View::Cost, _) => {}
                }
            }
        }
        if view == View::Cost {
            let tests = tracer.counters().tests() - tests_before;
            patch.cost(0, tests as f64);
        }
        Ok(met)
    }
}

/// What was added to a tile.
pub(crate) struct Painted {
    pub(crate) samples: u64,
    /// Of these, those that met the solid.
    pub(crate) hits: u64,
    /// What they took.
    pub(crate) counters: Counters,
}

/// What a thread paints with: a tracer, and memory for the rays that it traces together.
pub(crate) struct Brush<'a> {
    tracer: Tracer<'a>,
    illumination: Illumination,
    pixels: Vec<(u32, u32)>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    colours: Vec<DVec3>,
}

impl<'a> Brush<'a> {
    pub(crate) fn new(world: &World<'a>, settings: &Settings) -> Self {
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
