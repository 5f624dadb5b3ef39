//! How a file asks to be looked at: camera, lights, background, image. What it leaves out is the renderer's to choose.

use glam::DVec3;

/// What the scene blocks of a file say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// `camera { … }`
    pub camera: Camera,
    /// `light { … }`, in their order. Empty if there is none.
    pub lights: Vec<Light>,
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

/// The measures of the picture, as far as the file gives them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: Option<u32>,
    /// Rows, at least 1.
    pub height: Option<u32>,
    /// Rays a pixel, at least 1.
    pub samples: Option<u32>,
}
