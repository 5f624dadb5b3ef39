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
    /// The three parts of the surface, which add up to 1.
    matt: f64,
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
            matt: surface.matt(),
            metal: surface.metal,
            glass: (1.0 - surface.metal) * surface.glass,
            microfacets: (surface.roughness > 0.0).then(|| Microfacets::new(surface.roughness)),
            ratio,
        }
    }

    /// The light that reaches the viewer from a direction, with the cosine, per radiance from there and solid angle; and the
    /// density at which [`sample`](Self::sample) leads there. Mirrors and clear glass are left out, as no direction given
    /// from outside is theirs.
    pub(super) fn evaluate(&self, to_light: DVec3) -> (DVec3, f64) {
        let (cos, viewer_cos) = (self.normal.dot(to_light), self.normal.dot(self.to_viewer));
        if cos <= 0.0 || viewer_cos <= 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let mut light = self.albedo * (self.matt * cos / PI);
        let mut density = self.matt * warp::cosine_density(cos);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::sampler::Sampler;

    const SAMPLES: u32 = 4096;

    fn bsdf(surface: &Surface, angle: f64, ratio: f64) -> Bsdf {
        let normal = DVec3::new(2.0, -3.0, 6.0) / 7.0;
        let (sin, cos) = libm::sincos(angle.to_radians());
        let to_viewer = warp::upright(normal, DVec3::new(0.6 * sin, 0.8 * sin, cos));
        Bsdf::new(surface, &Place { point: DVec3::ZERO, normal, to_viewer, offset: 0.0 }, ratio)
    }

    fn white() -> Surface {
        Surface { diffuse: 1.0, ..Surface::default() }
    }

    /// What the viewer sees of it where light of 1 comes from everywhere.
    fn furnace(surface: &Surface, angle: f64, ratio: f64) -> f64 {
        let bsdf = bsdf(surface, angle, ratio);
        let seen = |sample| {
            let sampler = Sampler::new((1, 1), sample);
            let scattered = bsdf.sample(sampler.square(0).x, sampler.square(1));
            scattered.map_or(0.0, |scattered| scattered.weight.y)
        };
        (0..SAMPLES).map(seen).sum::<f64>() / f64::from(SAMPLES)
    }

    #[test]
    fn in_a_white_furnace_white_is_not_seen() {
        let metal = Surface { metal: 1.0, ..white() };
        let glass = Surface { glass: 1.0, ..white() };
        let mixed = Surface { metal: 0.3, glass: 0.4, ..white() };
        for (surface, angle) in [white(), metal, glass, mixed]
            .into_iter()
            .flat_map(|surface| [0.0, 40.0, 85.0].map(|a| (surface, a)))
        {
            for ratio in [1.0 / 1.5, 1.5] {
                let seen = furnace(&surface, angle, ratio);
                assert!((seen - 1.0).abs() < 1e-12, "{surface:?} at {angle}: {seen}");
            }
        }
    }

    /// What is lost goes from facet to facet; straight on and at the greatest roughness, 1 − ln 2 remains.
    #[test]
    fn rough_metal_gives_back_no_more_than_it_gets() {
        let seen = |roughness, angle| furnace(&Surface { metal: 1.0, roughness, ..white() }, angle, 1.0);
        for roughness in [0.01, 0.2, 0.4, 0.7, 1.0] {
            for angle in [0.0, 40.0, 85.0] {
                assert!(seen(roughness, angle) < 1.0 + 1e-9, "roughness {roughness} at {angle}");
            }
        }
        assert!((seen(1.0, 0.0) - (1.0 - std::f64::consts::LN_2)).abs() < 1e-3);
        for (roughness, least) in [(0.01, 0.9999), (0.2, 0.99), (0.4, 0.95), (0.7, 0.65)] {
            assert!(seen(roughness, 40.0) > least, "roughness {roughness}");
        }
    }

    /// The light of a sky of some pattern, once from directions as they are drawn, once from directions all alike.
    #[test]
    fn what_is_drawn_is_what_is_evaluated() {
        let pattern = |direction: DVec3| 1.0 + direction.x + direction.y * direction.z;
        let rough = Surface { metal: 0.6, roughness: 0.5, pigment: DVec3::new(0.9, 0.6, 0.2), ..white() };
        let mixed = Surface { glass: 0.5, ..rough };
        for (surface, angle) in
            [rough, mixed].into_iter().flat_map(|surface| [0.0, 50.0, 75.0].map(|a| (surface, a)))
        {
            let bsdf = bsdf(&surface, angle, 1.0);
            let (mut drawn, mut even, mut density) = (DVec3::ZERO, DVec3::ZERO, 0.0);
            for sample in 0..SAMPLES {
                let sampler = Sampler::new((7, 7), sample);
                let (part, square) = (sampler.square(0).x, sampler.square(1));
                if let Some(scattered) = bsdf.sample(part, square)
                    && let Some(density) = scattered.density
                {
                    drawn += scattered.weight * pattern(scattered.direction);
                    let (light, same) = bsdf.evaluate(scattered.direction);
                    assert!(
                        (light / same).distance(scattered.weight) < 1e-12
                            && (same - density).abs() < 1e-9 * same
                    );
                }
                // Over the hemisphere, whose solid angle is 2π.
                let direction = warp::upright(bsdf.normal, hemisphere(square));
                let (light, own) = bsdf.evaluate(direction);
                even += light * (2.0 * PI * pattern(direction));
                density += own * 2.0 * PI;
            }
            let count = f64::from(SAMPLES);
            assert!(
                (drawn - even).abs().max_element() < 0.02 * count,
                "{angle}: {} {}",
                drawn / count,
                even / count
            );
            // Of what the facets show, some is below the horizon.
            assert!(density < (1.0 - bsdf.glass) * 1.01 * count, "{angle}: {}", density / count);
        }
    }

    fn hemisphere(square: DVec2) -> DVec3 {
        let (sin, cos) = libm::sincos(2.0 * PI * square.y);
        let radius = (1.0 - square.x * square.x).sqrt();
        DVec3::new(radius * cos, radius * sin, square.x)
    }
}
