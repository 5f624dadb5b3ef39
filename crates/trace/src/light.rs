//! Lights: points and directions, without falloff.

use glam::DVec3;

use crate::{Camera, camera};

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where its light comes from.
    pub source: LightSource,
    /// Colour and strength, in linear light, at any distance the same: a white surface that faces it is seen in this
    /// colour.
    pub colour: DVec3,
    /// Whether solids stand in its way.
    pub shadow: bool,
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// A point of the world.
    Point(DVec3),
    /// From infinitely far away; the direction is that in which the light travels, of any length.
    Directional(DVec3),
}

impl Light {
    /// The light of a scene that has none: a white sun with shadows that shines over the camera's left shoulder.
    pub fn over_shoulder(camera: &Camera) -> Self {
        let forward = (camera.target - camera.eye).normalize_or(DVec3::Y);
        let (right, up) = camera::upright(forward, camera.up);
        let direction = forward + right * 0.7 - up * 0.9;
        Self { source: LightSource::Directional(direction), colour: DVec3::ONE, shadow: true }
    }

    /// The way to the light from `point`: its direction, of length 1, and how far it is; `None` if it has no direction.
    pub(crate) fn way_from(&self, point: DVec3) -> Option<(DVec3, f64)> {
        match self.source {
            LightSource::Point(position) => {
                let (direction, length) = (position - point).normalize_and_length();
                (length > 0.0).then_some((direction, length))
            }
            LightSource::Directional(direction) => Some((-direction.try_normalize()?, f64::INFINITY)),
        }
    }
}
