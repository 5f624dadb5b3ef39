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

#[cfg(test)]
mod tests {
    use super::*;

    fn at(angle: f64, ratio: f64) -> Refraction {
        let (sin, cos) = libm::sincos(angle.to_radians());
        Refraction::new(DVec3::new(sin, 0.0, cos), DVec3::Z, ratio)
    }

    #[test]
    fn known_reflectances() {
        // Straight on, ((n − 1) / (n + 1))², from either side.
        for ratio in [1.0 / 1.5, 1.5] {
            assert!((at(0.0, ratio).reflectance - 0.04).abs() < 1e-15);
        }
        // At Brewster's angle, tan = n, only light polarised across is reflected: half of ((n² − 1) / (n² + 1))².
        let brewster = libm::atan(1.5).to_degrees();
        let across = 1.25 / 3.25_f64;
        assert!((at(brewster, 1.0 / 1.5).reflectance - 0.5 * across * across).abs() < 1e-15);
        assert!((at(90.0, 1.0 / 1.5).reflectance - 1.0).abs() < 1e-12);
        let none = at(63.0, 1.0);
        assert!(none.reflectance < 1e-30 && none.direction.unwrap().x < 0.0);
    }

    #[test]
    fn refraction_follows_snell_and_can_be_reversed() {
        for (angle, ratio) in [(10.0, 1.0 / 1.33), (80.0, 1.0 / 2.4), (30.0, 1.5), (41.0, 1.5)] {
            let refraction = at(angle, ratio);
            let direction = refraction.direction.unwrap();
            let sin = libm::sin(f64::to_radians(angle));
            assert!((direction.x + ratio * sin).abs() < 1e-12 && direction.y == 0.0 && direction.z < 0.0);
            let back = Refraction::new(direction, -DVec3::Z, 1.0 / ratio);
            assert!((back.reflectance - refraction.reflectance).abs() < 1e-12);
            assert!((back.direction.unwrap().x - sin).abs() < 1e-12);
        }
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        let critical = libm::asin(1.0 / 1.5).to_degrees();
        assert!(at(critical - 1e-6, 1.5).direction.is_some());
        for angle in [critical + 1e-6, 60.0, 89.9] {
            let total = at(angle, 1.5);
            assert!(total.direction.is_none() && total.reflectance > 1.0 - 1e-15, "{angle}: {total:?}");
        }
    }
}
