//! How a file asks to be looked at: camera, lights, sky or background, image. What it leaves out is the renderer's to choose.

use glam::DVec3;

/// What the scene blocks of a file say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// `camera { … }`
    pub camera: Camera,
    /// `light { … }`, in their order. Empty if there is none.
    pub lights: Vec<Light>,
    /// `sky { … }`. There is no background where there is a sky.
    pub sky: Option<Sky>,
    /// `background { color = … }`, linear light.
    pub background: Option<DVec3>,
    /// `image { … }`
    pub image: Image,
}

/// A camera, as far as the file describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Camera {
    /// Where it is, in the frame of the world.
    pub eye: Option<DVec3>,
    /// What it looks at. Not where it is, if both are given.
    pub target: Option<DVec3>,
    /// What is upwards in the picture; of length 1.
    pub up: Option<DVec3>,
    /// The horizontal angle of view in degrees, between 0 and 180.
    pub fov: Option<f64>,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where its light comes from.
    pub source: LightSource,
    /// Its colour, linear; may exceed 1.
    pub color: DVec3,
    /// Whether things cast shadows in it.
    pub shadow: bool,
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// From a point of the world.
    Position(DVec3),
    /// From infinitely far away. This is the way it travels; of length 1.
    Direction(DVec3),
}

/// A sky, as far as the file describes it. Colours are linear and may exceed 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Sky {
    /// The colour straight above.
    pub zenith: Option<DVec3>,
    /// The colour at the horizon.
    pub horizon: Option<DVec3>,
    /// The colour below the horizon.
    pub ground: Option<DVec3>,
    /// Where the sun is; of length 1. Without it there is none, and the following two are `None`.
    pub sun: Option<DVec3>,
    /// The light of the sun, in the measure of a light's colour.
    pub sunlight: Option<DVec3>,
    /// How large the sun appears: its diameter in degrees, above 0 and at most 90.
    pub disc: Option<f64>,
}

/// How light is computed, where the file says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Integrator {
    /// From lights alone, with mirror images and refraction.
    Direct,
    /// From everything to everything.
    Path,
}

/// The measures of the picture, as far as the file gives them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: Option<u32>,
    /// Rows, at least 1.
    pub height: Option<u32>,
    /// Rays a pixel, at least 1.
    pub samples: Option<u32>,
    /// How light is computed.
    pub integrator: Option<Integrator>,
    /// How often light is followed from surface to surface, at least 1.
    pub bounces: Option<u32>,
    /// How much brighter the light is taken, in stops: each doubles it.
    pub exposure: Option<f64>,
}

impl Image {
    /// The most pixels that a side of a picture may have.
    pub const MAX_SIDE: u32 = 65_536;
    /// The most pixels that a picture may have.
    pub const MAX_PIXELS: u64 = 1 << 26;
    /// The most rays a pixel.
    pub const MAX_SAMPLES: u32 = 4096;
    /// The most bounces.
    pub const MAX_BOUNCES: u32 = 1024;
    /// The most stops by which the light is taken brighter or darker.
    pub const MAX_EXPOSURE: f64 = 32.0;
}
