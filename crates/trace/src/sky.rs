//! What rays see that meet nothing: a sky, with or without a sun.
//!
//! The dome goes from a colour at the horizon to one straight above with the root of the height, as a clear sky brightens
//! towards the horizon the faster the closer. Below the horizon it has one colour, which stands for ground far away.

use glam::DVec3;

/// The surroundings of the solid: colours in linear light, z up.
///
/// ```
/// use csg_graph_trace::Sky;
/// use glam::DVec3;
///
/// let overcast = Sky::uniform(DVec3::splat(0.6));
/// assert_eq!(overcast.radiance(DVec3::new(1.0, 2.0, 0.5)), DVec3::splat(0.6));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sky {
    /// Straight above.
    pub zenith: DVec3,
    /// At the horizon.
    pub horizon: DVec3,
    /// Below the horizon.
    pub ground: DVec3,
    /// The sun, if there is one.
    pub sun: Option<Sun>,
}

/// A disc in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Where it is; of length 1.
    pub direction: DVec3,
    /// Its light, in the measure of a [`Light`](crate::Light)'s colour: a white surface that faces it is seen in this
    /// colour.
    pub colour: DVec3,
    /// How large it appears: its diameter in degrees, above 0 and at most 90.
    pub diameter: f64,
}

impl Sky {
    /// A clear day without a sun: deep blue above, pale at the horizon, over grey ground.
    pub const CLEAR: Self = Self {
        zenith: DVec3::new(0.12, 0.26, 0.62),
        horizon: DVec3::new(0.62, 0.74, 0.88),
        ground: DVec3::new(0.22, 0.20, 0.18),
        sun: None,
    };

    /// One colour all around, without a sun.
    pub const fn uniform(colour: DVec3) -> Self {
        Self { zenith: colour, horizon: colour, ground: colour, sun: None }
    }

    /// What is seen in a direction, of any length, besides the sun.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        if direction.z < 0.0 {
            return self.ground;
        }
        if self.zenith == self.horizon {
            return self.zenith;
        }
        let height = direction.z / direction.length();
        self.horizon + (self.zenith - self.horizon) * height.sqrt()
    }
}

impl Sun {
    /// The diameter of ours, in degrees.
    pub const DIAMETER: f64 = 0.53;

    /// Half the diameter, in radians.
    pub(crate) fn radius(&self) -> f64 {
        self.diameter.to_radians() / 2.0
    }

    /// What is seen on the disc.
    ///
    /// A surface that faces the disc receives this times ∫ cos = π·sin² over the disc, and gives back a π-th.
    pub fn radiance(&self) -> DVec3 {
        let sin = libm::sin(self.radius());
        self.colour / (sin * sin)
    }
}
