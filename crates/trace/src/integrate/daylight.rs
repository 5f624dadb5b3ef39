//! The sky as rays meet it, and the sun as something to aim at.

use glam::{DVec2, DVec3};

use super::warp::Cone;
use crate::{Sky, Sun};

/// A sky with a sun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Daylight {
    dome: Sky,
    pub(super) sun: Option<Disc>,
}

/// The sun's disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    cone: Cone,
    pub(super) radiance: DVec3,
}

impl Daylight {
    pub(super) fn new(sky: &Sky) -> Self {
        let disc = |sun: Sun| Disc { cone: Cone::new(sun.direction, sun.radius()), radiance: sun.radiance() };
        Self { dome: *sky, sun: sky.sun.map(disc) }
    }

    /// What is seen in a direction, of any length. `sun_counts` is what the sun counts there, given the density of
    /// [`Disc::sample`].
    pub(super) fn seen(&self, direction: DVec3, sun_counts: impl Fn(f64) -> f64) -> DVec3 {
        let dome = self.dome.radiance(direction);
        match &self.sun {
            Some(sun) if sun.cone.contains(direction.normalize_or_zero()) => {
                dome + sun.radiance * sun_counts(sun.cone.density())
            }
            _ => dome,
        }
    }
}

impl Disc {
    /// A direction to the disc, and the density of it over solid angle.
    pub(super) fn sample(&self, square: DVec2) -> (DVec3, f64) {
        (self.cone.sample(square), self.cone.density())
    }
}
