//! A picture in the making as bytes: all its sums, so that it goes on as if it had never been stopped.
//!
//! Numbers one after the other, little-endian, tile by tile: for each square the samples that it has and those it is to
//! have, the extremes, and the sums of all pixels, unless there are no samples. What picture they are of is not among them; whoever keeps them keeps
//! that too.

use std::io::{self, Read, Write};

use glam::DVec3;

use crate::latent::Square;
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
        for count in [rays, shadow_rays, nodes_visited, box_tests, boxes_missed, primitive_tests] {
            to.write_all(&count.to_le_bytes())?;
        }
        to.write_all(&deepest_recursion.to_le_bytes())?;
        for exposed in &self.exposed {
            for Square { taken, goal } in &exposed.squares {
                to.write_all(&taken.to_le_bytes())?;
                to.write_all(&goal.to_le_bytes())?;
            }
            let exposure = &exposed.exposure;
            let extremes = [exposure.extremes.least, exposure.extremes.greatest];
            let of_light = exposure.light.iter().chain(&exposure.halves).flat_map(DVec3::as_ref);
            for number in extremes.iter().chain(exposure.gauges.iter().flatten()).chain(of_light) {
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
        ] {
            *count = u64::from_le_bytes(bytes(from)?);
        }
        counters.deepest_recursion = u32::from_le_bytes(bytes(from)?);
        let Settings { samples, view, noise, .. } = *settings;
        let tiles = image.tiles;
        for (exposed, tile) in image.exposed.iter_mut().zip((0..tiles.count()).map(|index| tiles.tile(index)))
        {
            for Square { taken, goal } in &mut exposed.squares {
                *taken = u32::from_le_bytes(bytes(from)?);
                *goal = u32::from_le_bytes(bytes(from)?);
                if *taken > *goal || *goal > samples {
                    return Err(LoadError::Count { taken: *taken, goal: *goal, samples });
                }
            }
            let exposure = &mut exposed.exposure;
            if exposed.squares.iter().any(|square| square.taken > 0) {
                exposure.make_room(view, tile.pixel_count(), noise.is_some());
            }
            let extremes = [&mut exposure.extremes.least, &mut exposure.extremes.greatest];
            let of_light = exposure.light.iter_mut().chain(&mut exposure.halves).flat_map(DVec3::as_mut);
            for number in extremes.into_iter().chain(exposure.gauges.iter_mut().flatten()).chain(of_light) {
                *number = f64::from_le_bytes(bytes(from)?);
            }
        }
        Ok(image)
    }
}

/// The next bytes of a reader.
fn bytes<const N: usize>(from: &mut dyn Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}
