//! Glass: what its surface reflects and refracts, by the laws of Snell and Fresnel, and what it swallows, by that of Beer.

use glam::DVec3;

use crate::{Hit, Ray, Surface};

/// What happens to light at a smooth surface between two media.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refraction {
    /// The part that is reflected.
    pub(super) reflectance: f64,
    /// Where the rest goes; `None` if there is none.
    pub(super) direction: Option<DVec3>,
}

impl Refraction {
    /// For a ray that is seen from `to_viewer`, on the side of `normal`, both of length 1; `ratio` is the index of refraction
    /// on this side over that on the other. Light of all polarisations alike.
    pub(super) fn new(to_viewer: DVec3, normal: DVec3, ratio: f64) -> Self {
        let cos = normal.dot(to_viewer);
        let square = 1.0 - ratio * ratio * (1.0 - cos * cos);
        if square <= 0.0 {
            return Self { reflectance: 1.0, direction: None };
        }
        let refracted_cos = square.sqrt();
        let across = (ratio * cos - refracted_cos) / (ratio * cos + refracted_cos);
        let along = (cos - ratio * refracted_cos) / (cos + ratio * refracted_cos);
        let direction = normal * (ratio * cos - refracted_cos) - to_viewer * ratio;
        Self { reflectance: 0.5 * (across * across + along * along), direction: Some(direction.normalize()) }
    }
}

/// The glasses that a ray is in, the innermost last.
///
/// Where parts of a union overlap, rays meet the walls between them. A wall between equal glasses neither reflects nor
/// refracts, so that it is not seen.
#[derive(Clone, Debug, Default)]
pub(super) struct Media(Vec<Medium>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct Medium {
    ior: f64,
    pigment: DVec3,
    absorption: f64,
}

impl Medium {
    fn of(surface: &Surface) -> Self {
        Self { ior: surface.ior, pigment: surface.pigment, absorption: surface.absorption }
    }
}

impl Media {
    /// What is left of light on the way that a ray went to its hit.
    pub(super) fn transmittance(&self, ray: &Ray, hit: &Hit) -> DVec3 {
        let Some(medium) = self.0.last() else { return DVec3::ONE };
        let thickness = medium.absorption * ray.direction.length() * hit.t;
        medium.pigment.map(|channel| libm::pow(channel, thickness))
    }

    /// The glasses behind a surface, and the index of refraction before it over that behind it.
    pub(super) fn cross(&self, ray: &Ray, hit: &Hit) -> (Self, f64) {
        if hit.surface.glass == 0.0 {
            return (self.clone(), 1.0);
        }
        let surface = Medium::of(&hit.surface);
        let mut behind = self.clone();
        let before = if hit.normal.dot(ray.direction) < 0.0 {
            behind.0.push(surface);
            self.ior()
        } else if let Some(left) = behind.0.iter().rposition(|medium| *medium == surface) {
            behind.0.remove(left);
            self.ior()
        } else {
            // The camera is in this glass.
            surface.ior
        };
        let ratio = before / behind.ior();
        (behind, ratio)
    }

    fn ior(&self) -> f64 {
        self.0.last().map_or(1.0, |medium| medium.ior)
    }
}
