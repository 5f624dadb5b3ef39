//! How a surface scatters light: a mixture of matt, metal and glass.
//!
//! Metal covers a part of the surface, glass a part of what is left, and the rest is matt, which scatters alike in all
//! directions. The parts add up to 1 and none gives back more than it gets. Which part a ray meets is drawn by chance.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::Place;
use super::dielectric::Refraction;
use super::microfacet::{Microfacets, schlick};
use super::warp;
use crate::Surface;

/// The scattering at a point, for light that goes to one viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bsdf {
    /// On the viewer's side; as all directions here, of length 1.
    normal: DVec3,
    to_viewer: DVec3,
    pigment: DVec3,
    /// How much of its light the matt part gives back, per channel.
    albedo: DVec3,
    metal: f64,
    glass: f64,
    /// None for a metal as smooth as a mirror.
    microfacets: Option<Microfacets>,
    /// Of the indices of refraction on this side and on the other.
    ratio: f64,
}

/// Where a ray goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scattered {
    pub(super) direction: DVec3,
    /// What the light from there counts.
    pub(super) weight: DVec3,
    /// The density at which the direction was drawn, over solid angle; none for mirrors and clear glass, which leave no
    /// choice.
    pub(super) density: Option<f64>,
    /// Whether it goes on behind the surface.
    pub(super) is_behind: bool,
}

impl Bsdf {
    /// `ratio` is the index of refraction on the viewer's side over that on the other.
    pub(super) fn new(surface: &Surface, place: &Place, ratio: f64) -> Self {
        Self {
            normal: place.normal,
            to_viewer: place.to_viewer,
            pigment: surface.pigment,
            albedo: surface.pigment * surface.diffuse,
            metal: surface.metal,
            glass: (1.0 - surface.metal) * surface.glass,
            microfacets: (surface.roughness > 0.0).then(|| Microfacets::new(surface.roughness)),
            ratio,
        }
    }

    fn matt(&self) -> f64 {
        1.0 - self.metal - self.glass
    }

    /// The light that reaches the viewer from a direction, with the cosine, per radiance from there and solid angle; and the
    /// density at which [`sample`](Self::sample) leads there. Mirrors and clear glass are left out, as no direction given
    /// from outside is theirs.
    pub(super) fn evaluate(&self, to_light: DVec3) -> (DVec3, f64) {
        let (cos, viewer_cos) = (self.normal.dot(to_light), self.normal.dot(self.to_viewer));
        if cos <= 0.0 || viewer_cos <= 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let mut light = self.albedo * (self.matt() * cos / PI);
        let mut density = self.matt() * warp::cosine_density(cos);
        if let Some(microfacets) = self.microfacets
            && self.metal > 0.0
        {
            let (seen, drawn) = microfacets.evaluate(self.local(self.to_viewer), self.local(to_light));
            let half = (self.to_viewer + to_light).normalize_or(self.normal);
            light += schlick(self.pigment, half.dot(to_light)) * (self.metal * seen);
            density += self.metal * drawn;
        }
        (light, density)
    }

    /// A way on, drawn by three numbers from 0 to 1: which part of the surface, and where to. `None` where light goes
    /// nowhere.
    pub(super) fn sample(&self, part: f64, square: DVec2) -> Option<Scattered> {
        if part < self.glass {
            return Some(self.meet_glass(part / self.glass));
        }
        let direction = if part - self.glass < self.metal {
            let Some(microfacets) = self.microfacets else { return Some(self.mirror(self.metallic())) };
            let facet = microfacets.sample(self.local(self.to_viewer), square);
            reflected(self.to_viewer, warp::upright(self.normal, facet))
        } else {
            warp::upright(self.normal, warp::cosine(square))
        };
        let (light, density) = self.evaluate(direction);
        let scattered =
            Scattered { direction, weight: light / density, density: Some(density), is_behind: false };
        (density > 0.0).then_some(scattered)
    }

    /// The mirror image that the surface shows, and what is seen through it, both with what they count: the ways that leave
    /// no choice, if metal is taken as smooth.
    pub(super) fn images(&self) -> (Scattered, Option<Scattered>) {
        let Refraction { reflectance, direction } = self.refraction();
        let mirrored = self.metallic() * self.metal + self.glass * reflectance;
        let passed = DVec3::splat(self.glass * (1.0 - reflectance));
        (self.mirror(mirrored), direction.map(|direction| Scattered::behind(direction, passed)))
    }

    /// One of the two ways at glass, as often as it counts.
    fn meet_glass(&self, part: f64) -> Scattered {
        match self.refraction() {
            Refraction { reflectance, direction: Some(direction) } if part >= reflectance => {
                Scattered::behind(direction, DVec3::ONE)
            }
            _ => self.mirror(DVec3::ONE),
        }
    }

    fn refraction(&self) -> Refraction {
        Refraction::new(self.to_viewer, self.normal, self.ratio)
    }

    /// What smooth metal reflects.
    fn metallic(&self) -> DVec3 {
        schlick(self.pigment, self.normal.dot(self.to_viewer))
    }

    fn mirror(&self, weight: DVec3) -> Scattered {
        Scattered {
            direction: reflected(self.to_viewer, self.normal),
            weight,
            density: None,
            is_behind: false,
        }
    }

    /// A direction with the normal as its z axis, as [`warp::upright`] takes it.
    fn local(&self, direction: DVec3) -> DVec3 {
        let (x, y) = self.normal.any_orthonormal_pair();
        DVec3::new(direction.dot(x), direction.dot(y), direction.dot(self.normal))
    }
}

impl Scattered {
    fn behind(direction: DVec3, weight: DVec3) -> Self {
        Self { direction, weight, density: None, is_behind: true }
    }
}

/// A direction mirrored at a normal, both of length 1 and away from the surface.
fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    normal * (2.0 * normal.dot(direction)) - direction
}
