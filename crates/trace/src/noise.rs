//! When a part of the picture has samples enough: its noise is estimated, by what its samples say and by its neighbours.
//!
//! The estimate is on the scale of a screen, in its 255 steps from black to white, because that is where noise is seen: in
//! the dark a little light is a step, in the bright it takes much more. A pixel is in doubt for one of these reasons:
//!
//! - Its *halves* differ, the samples with even numbers and those with odd ones: half the difference is an estimate of how
//!   far the mean of all is off \[DAMM10\]. Of what is random in the samples it is the standard error; of an edge, which
//!   places as even as ours find quickly, it tells how quickly.
//! - It would have been in doubt for its neighbours: one such estimate is small by chance easily, so twice the root of their
//!   mean square counts, of a pixel and those around it.
//! - It is beside something else, and its samples may have missed that. By Laplace's rule of succession, what none of n
//!   samples has seen is expected to cover 1/(n + 2) of the pixel: so much of the *contrast* to its neighbours.
//!
//! A square of pixels gets more samples as long as one of its pixels is in doubt, or one of those around it. So an edge
//! that a few samples have missed is found from the side where others have met it, and all that was stopped can start again.
//!
//! Who stops by what is seen favours what is seen first: the mean of the samples that decided is no longer free of bias
//! \[KIRK91\]. No pixel is judged before it has [`FEWEST`] samples, it is judged a few times only, and never alone, and
//! what bias is left is of the size of the noise that was allowed.

use glam::DVec3;
use rayon::prelude::*;

use crate::latent::{LatentImage, SQUARE};
use crate::narrow::narrow;
use crate::srgb;
use crate::tiles::Tile;
use crate::view::Exposure;

/// The samples that a pixel has before [noise](crate::Settings::noise) can decide that it has enough.
pub const FEWEST: u32 = 16;

/// The estimated errors of a picture, in the steps of a screen.
pub(crate) struct Errors {
    width: usize,
    height: usize,
    /// Row by row.
    of_pixels: Vec<f32>,
}

/// What the samples of a pixel say.
#[derive(Clone, Copy)]
struct Sight {
    /// What a screen shows.
    shown: [f32; 3],
    /// How far that is off, as far as its halves tell.
    error: f32,
    samples: u32,
}

impl Errors {
    /// Estimates the errors of all pixels, which have [`FEWEST`] samples at least, or all there are.
    pub(crate) fn estimate(image: &LatentImage) -> Self {
        let [width, height] = [image.settings.width, image.settings.height].map(|side| side as usize);
        let sights = image.in_rows(Sight::NONE, |places, samples, to| {
            for (place, sight) in places.zip(to) {
                *sight = Sight::new(&image.exposure, place, samples);
            }
        });
        let of_row = |y: usize| {
            let sights = &sights;
            (0..width).map(move |x| {
                let own = sights[y * width + x];
                let (mut contrast, mut squares, mut count) = (0.0_f32, 0.0, 0.0);
                for other in around([x, y], [1, 1], [width, height]).map(|index| &sights[index]) {
                    contrast = contrast.max(own.contrast(other));
                    squares += other.error * other.error;
                    count += 1.0;
                }
                let missed = contrast / (own.samples as f32 + 2.0);
                own.error.max(2.0 * (squares / count).sqrt()).max(missed)
            })
        };
        Self { width, height, of_pixels: (0..height).into_par_iter().flat_map_iter(of_row).collect() }
    }

    /// The largest error in a square and right around it.
    pub(crate) fn around(&self, square: &Tile) -> f64 {
        let corner = [square.columns.start as usize, square.rows.start as usize];
        let pixels = around(corner, [SQUARE as usize; 2], [self.width, self.height]);
        f64::from(pixels.map(|index| self.of_pixels[index]).fold(0.0, f32::max))
    }
}

/// The indices of the pixels of a rectangle and of those right around it, in a picture of that size.
fn around(
    [x, y]: [usize; 2],
    [across, down]: [usize; 2],
    [width, height]: [usize; 2],
) -> impl Iterator<Item = usize> {
    let columns = x.saturating_sub(1)..(x + across + 1).min(width);
    let rows = y.saturating_sub(1)..(y + down + 1).min(height);
    rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

impl Sight {
    const NONE: Self = Self { shown: [0.0; 3], error: 0.0, samples: 0 };

    fn new(exposure: &Exposure, place: usize, samples: u32) -> Self {
        let [light, even] = [&exposure.light, &exposure.halves].map(|sums| DVec3::from(sums[place]));
        let mean = |light: DVec3, samples: u32| (light / f64::from(samples)).map(steps);
        let shown = mean(light, samples);
        let [even, odd] = [mean(even, samples.div_ceil(2)), mean(light - even, (samples / 2).max(1))];
        let error = ((even - odd) * 0.5).abs().max_element();
        Self { shown: shown.as_vec3().to_array(), error: narrow(error), samples }
    }

    /// How different two pixels look.
    fn contrast(&self, other: &Self) -> f32 {
        self.shown.iter().zip(other.shown).map(|(own, other)| (own - other).abs()).fold(0.0, f32::max)
    }
}

/// Linear light in the steps of a screen.
fn steps(linear: f64) -> f64 {
    255.0 * srgb::encode(linear)
}
