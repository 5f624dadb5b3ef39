//! From the unit square to directions, with the density at which they come out.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

/// A direction about the z axis, with a density of cos/π: a point of the unit disc, raised to the hemisphere.
pub(super) fn cosine(square: DVec2) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * square.y);
    let radius = square.x.sqrt();
    DVec3::new(radius * cos, radius * sin, (1.0 - square.x).sqrt())
}

/// The density of [`cosine`] at a direction with that cosine, over solid angle.
pub(super) fn cosine_density(cos: f64) -> f64 {
    cos.max(0.0) / PI
}

/// A cone of directions about an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    axis: DVec3,
    /// 1 − cos of the angle between the axis and the border, which keeps its digits where the angle is small.
    versine: f64,
}

impl Cone {
    /// The cone whose border is at `angle` radians from an axis of length 1.
    pub(super) fn new(axis: DVec3, angle: f64) -> Self {
        let half = libm::sin(angle / 2.0);
        Self { axis, versine: 2.0 * half * half }
    }

    /// A direction in the cone, all alike.
    pub(super) fn sample(&self, square: DVec2) -> DVec3 {
        let versine = square.x * self.versine;
        let radius = (versine * (2.0 - versine)).sqrt();
        let (sin, cos) = libm::sincos(TAU * square.y);
        upright(self.axis, DVec3::new(radius * cos, radius * sin, 1.0 - versine))
    }

    /// The density of [`sample`](Self::sample) at a direction in the cone, over solid angle.
    pub(super) fn density(&self) -> f64 {
        1.0 / (TAU * self.versine)
    }

    /// Whether a direction of length 1 is in the cone.
    pub(super) fn contains(&self, direction: DVec3) -> bool {
        // For two of length 1, half the square of their distance is 1 − cos.
        0.5 * direction.distance_squared(self.axis) <= self.versine
    }
}

/// A direction given about the z axis, about `axis` of length 1 instead.
pub(super) fn upright(axis: DVec3, direction: DVec3) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    x * direction.x + y * direction.y + axis * direction.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::sampler::Sampler;

    /// Means over directions agree with integrals.
    #[test]
    fn directions_have_their_densities() {
        let axis = DVec3::new(2.0, -3.0, 6.0) / 7.0;
        let mean = |value: &dyn Fn(DVec2) -> f64| {
            (0..4096).map(|sample| value(Sampler::new((1, 2), sample).square(0))).sum::<f64>() / 4096.0
        };
        // ∫ cos² · cos/π = 1/2 over the hemisphere.
        assert!((mean(&|square| cosine(square).z * cosine(square).z) - 0.5).abs() < 1e-3);
        for angle in [1e-5, 0.1, 1.0, 1.5] {
            let cone = Cone::new(axis, angle);
            assert!(
                (mean(&|square| f64::from(u8::from(cone.contains(cone.sample(square))))) - 1.0).abs() < 1e-2
            );
            // ∫ cos = π sin² over the cone.
            let sum = mean(&|square| cone.sample(square).dot(axis) / cone.density());
            let expected = PI * libm::sin(angle) * libm::sin(angle);
            assert!((sum / expected - 1.0).abs() < 1e-3, "{angle}: {sum} for {expected}");
            assert!(!cone.contains(-axis));
        }
    }
}
