//! A picture in the making as bytes: all its sums, so that it goes on as if it had never been stopped.
//!
//! Numbers one after the other, little-endian, tile by tile: for each square the samples that it has and those it is to
//! have, the extremes, and the sums of all pixels, unless there are no samples. What picture they are of is not among them; whoever keeps them keeps
//! that too.

use std::io::{self, Read, Write};

use crate::latent::{SQUARE, Square};
use crate::{Counters, LatentImage, RenderError, Settings};

/// Why there is no picture to go on with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The settings are out of range.
    #[error(transparent)]
    Settings(#[from] RenderError),
    /// It cannot be read, or ends too soon.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// Numbers that do not fit to each other or to the settings.
    #[error("a square of pixels has {taken} samples on the way to {goal}, of {samples}")]
    Count {
        /// The samples that it is said to have.
        taken: u32,
        /// Those that it is to have.
        goal: u32,
        /// The most that a pixel has.
        samples: u32,
    },
}

impl LatentImage {
    /// Writes all that is known of the picture: as many bytes as it takes itself, in small pieces.
    ///
    /// # Errors
    /// If the writer has one.
    pub fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        let Counters {
            rays,
            shadow_rays,
            nodes_visited,
            box_tests,
            boxes_missed,
            primitive_tests,
            deepest_recursion,
        } = self.counters;
        for count in [rays, shadow_rays, nodes_visited, box_tests, boxes_missed, primitive_tests, self.hits] {
            to.write_all(&count.to_le_bytes())?;
        }
        to.write_all(&deepest_recursion.to_le_bytes())?;
        let exposure = &self.exposure;
        for ((squares, extremes), tile) in self.squares.iter().zip(&exposure.extremes).zip(self.tiles.iter())
        {
            for Square { taken, goal } in squares {
                to.write_all(&taken.to_le_bytes())?;
                to.write_all(&goal.to_le_bytes())?;
            }
            let places: Vec<_> =
                if has_samples(squares) { tile.runs(SQUARE).flatten().collect() } else { Vec::new() };
            let gauges = places.iter().filter_map(|place| exposure.gauges.get(*place)).flatten();
            let of_light = [&exposure.light, &exposure.halves];
            let of_light =
                of_light.into_iter().flat_map(|all| places.iter().filter_map(|place| all.get(*place)));
            for number in [extremes.least, extremes.greatest].iter().chain(gauges).chain(of_light.flatten()) {
                to.write_all(&number.to_le_bytes())?;
            }
        }
        Ok(())
    }

    /// Reads what was [saved](Self::save) of a picture with the same settings.
    ///
    /// # Errors
    /// If the settings are out of range, the reader has an error or ends too soon, or it gives what cannot be. Not all that
    /// is wrong can be told from the bytes.
    pub fn load(settings: &Settings, from: &mut dyn Read) -> Result<Self, LoadError> {
        let mut image = Self::new(settings)?;
        let counters = &mut image.counters;
        for count in [
            &mut counters.rays,
            &mut counters.shadow_rays,
            &mut counters.nodes_visited,
            &mut counters.box_tests,
            &mut counters.boxes_missed,
            &mut counters.primitive_tests,
            &mut image.hits,
        ] {
            *count = u64::from_le_bytes(bytes(from)?);
        }
        counters.deepest_recursion = u32::from_le_bytes(bytes(from)?);
        let samples = settings.samples;
        let Self { tiles, exposure, squares, .. } = &mut image;
        for ((squares, extremes), tile) in squares.iter_mut().zip(&mut exposure.extremes).zip(tiles.iter()) {
            for Square { taken, goal } in squares.iter_mut() {
                *taken = u32::from_le_bytes(bytes(from)?);
                *goal = u32::from_le_bytes(bytes(from)?);
                if *taken > *goal || *goal > samples {
                    return Err(LoadError::Count { taken: *taken, goal: *goal, samples });
                }
            }
            [extremes.least, extremes.greatest] = [number(from)?, number(from)?];
            if has_samples(squares) {
                let places: Vec<_> = tile.runs(SQUARE).flatten().collect();
                load_sums(&mut exposure.gauges, &places, from)?;
                load_sums(&mut exposure.light, &places, from)?;
                load_sums(&mut exposure.halves, &places, from)?;
            }
        }
        Ok(image)
    }
}

/// Whether there is anything to keep of a tile.
fn has_samples(squares: &[Square]) -> bool {
    squares.iter().any(|square| square.taken > 0)
}

/// Reads the sums of some pixels, if there are any in this view.
fn load_sums<const N: usize>(sums: &mut [[f64; N]], places: &[usize], from: &mut dyn Read) -> io::Result<()> {
    for place in places {
        if let Some(sums) = sums.get_mut(*place) {
            for sum in sums {
                *sum = number(from)?;
            }
        }
    }
    Ok(())
}

fn number(from: &mut dyn Read) -> io::Result<f64> {
    bytes(from).map(f64::from_le_bytes)
}

/// The next bytes of a reader.
fn bytes<const N: usize>(from: &mut dyn Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}
