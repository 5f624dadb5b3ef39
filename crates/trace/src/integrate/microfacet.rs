//! Rough metal: a surface of tiny mirrors whose slopes are distributed as by GGX \[WALT07\].
//!
//! Directions are in a frame with the normal as its z axis. Mirrors are drawn from those that the viewer sees \[HEIT18\], so
//! that a sample weighs no more than 1. Light that would go from mirror to mirror is lost: in a white furnace, metal of
//! roughness 0.2 is white but for a hundredth, of 0.4 for a twentieth, of 0.7 for a third, and of 1 for two thirds.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

/// The spread of the slopes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacets {
    alpha: f64,
}

impl Microfacets {
    /// The least spread: with less, rounding would show.
    const LEAST: f64 = 1e-4;

    /// For a roughness above 0, whose square is the spread \[BURL12\].
    pub(super) fn new(roughness: f64) -> Self {
        Self { alpha: (roughness * roughness).max(Self::LEAST) }
    }

    /// The normal of a mirror that is seen from a direction above the surface.
    pub(super) fn sample(self, to_viewer: DVec3, square: DVec2) -> DVec3 {
        // Stretched, the surface is a hemisphere; what is seen of it is half a disc and half an ellipse.
        let view = (to_viewer * DVec3::new(self.alpha, self.alpha, 1.0)).normalize();
        let across = DVec3::new(-view.y, view.x, 0.0).normalize_or(DVec3::X);
        let along = view.cross(across);
        let radius = square.x.sqrt();
        let (sin, cos) = libm::sincos(TAU * square.y);
        let x = radius * cos;
        let shown = 0.5 * (1.0 + view.z);
        let y = (1.0 - shown) * (1.0 - x * x).sqrt() + shown * radius * sin;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let normal = across * x + along * y + view * z;
        DVec3::new(self.alpha * normal.x, self.alpha * normal.y, normal.z.max(0.0)).normalize_or(DVec3::Z)
    }

    /// The part of the light from a direction that reaches the viewer, with the cosine and without Fresnel's factor, and the
    /// density at which [`sample`](Self::sample) leads to that direction.
    pub(super) fn evaluate(self, to_viewer: DVec3, to_light: DVec3) -> (f64, f64) {
        let half = (to_viewer + to_light).normalize_or(DVec3::Z);
        let slope = 1.0 - half.z * half.z + self.alpha * self.alpha * half.z * half.z;
        let distribution = self.alpha * self.alpha / (PI * slope * slope);
        let shared = distribution / (4.0 * to_viewer.z);
        (shared * self.both_seen(to_viewer, to_light), shared * self.seen(to_viewer))
    }

    fn seen(self, direction: DVec3) -> f64 {
        1.0 / (1.0 + self.hidden(direction))
    }

    fn both_seen(self, to_viewer: DVec3, to_light: DVec3) -> f64 {
        1.0 / (1.0 + self.hidden(to_viewer) + self.hidden(to_light))
    }

    /// Smith's Λ: mirrors hidden for each one that is seen.
    fn hidden(self, direction: DVec3) -> f64 {
        let cos2 = direction.z * direction.z;
        let tan2 = (1.0 - cos2).max(0.0) / cos2;
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }
}

/// What a metal reflects, whose pigment is what it reflects of light that falls on it straight: Schlick's approximation
/// \[SCHL94\].
pub(super) fn schlick(pigment: DVec3, cos: f64) -> DVec3 {
    let rest = (1.0 - cos).clamp(0.0, 1.0);
    let square = rest * rest;
    pigment + (DVec3::ONE - pigment) * (square * square * rest)
}
