//! Rays that are traced together, and what is known of them.

use super::entry::Beam;
use crate::Ray;

/// Up to [`PACKET`](super::PACKET) rays that are traced together. Slices, arrays and vectors of rays become one by
/// themselves; rays that are in a [`Beam`] become one [by it](Beam::batch).
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    pub(crate) rays: &'a [Ray],
    /// What all of them are in, if that is known.
    pub(super) beam: Option<&'a Beam>,
}

impl<'a, R: AsRef<[Ray]> + ?Sized> From<&'a R> for Batch<'a> {
    fn from(rays: &'a R) -> Self {
        Self { rays: rays.as_ref(), beam: None }
    }
}

impl Batch<'_> {
    /// Whether directions are about as long as each other. Their parameters have one scale, in single precision.
    pub(super) fn has_one_scale(&self) -> bool {
        /// Of squares of lengths.
        const SPREAD: f64 = 1e12;
        if self.beam.is_some() {
            return true;
        }
        let squares = self.rays.iter().map(|ray| ray.direction.length_squared());
        let both = |[least, most]: [f64; 2], square: f64| [least.min(square), most.max(square)];
        let [least, most] = squares.fold([f64::INFINITY, 0.0], both);
        most <= SPREAD * least
    }
}

impl Beam {
    /// Rays of the beam; others may miss what they would meet. The way that all rays of the beam have in common is gone once
    /// for all batches of the same beam that follow each other, and is no part of what is [counted](crate::Counters).
    pub fn batch<'a>(&'a self, rays: &'a [Ray]) -> Batch<'a> {
        Batch { rays, beam: Some(self) }
    }
}
