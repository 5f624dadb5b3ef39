//! Local shading: ambient, diffuse, and a highlight (Phong), with shadows.
//!
//! What a surface without metal, glass and light of its own shows is
//!
//! ```text
//! pigment · (ambient + Σ diffuse · max(0, N·L) · visible · light) + Σ specular · max(0, R·V)^shininess · visible · light
//! ```
//!
//! Surfaces are two-sided: N is turned to face the viewer. L points to the light, R is L mirrored about N, V points to the
//! viewer. Where metal or glass covers a part of the surface, pigment counts that much less; emission adds to the brackets. A
//! surface without attributes under one white light is pigment · (0.2 + 0.8 · max(0, N·L) · visible).

use csg_graph::EvalError;
use glam::DVec3;

use super::places::Places;
use crate::engine::Tracer;
use crate::fast::lanes::{LANES, each};
use crate::{Hit, Light, Ray};

/// Shades several hits together, so that their shadow rays can be traced together.
#[derive(Debug, Default)]
pub(crate) struct Shader {
    places: Places,
    gains: [Gain; LANES],
    shadow_rays: Vec<Ray>,
    ends: Vec<f64>,
    /// The rays whose hits have these shadow rays, and what the light adds there.
    lit: Vec<(usize, Gain)>,
}

/// What lights add to a surface: in its pigment, and on top of it.
#[derive(Clone, Copy, Debug, Default)]
struct Gain {
    matt: DVec3,
    highlight: DVec3,
}

impl Shader {
    /// The colours, in linear light, in which rays see their hits; nothing for those that hit nothing.
    pub(crate) fn shade(
        &mut self,
        tracer: &mut Tracer<'_>,
        lights: &[Light],
        rays: &[Ray],
        hits: &[Option<Hit>],
        colours: &mut Vec<DVec3>,
    ) -> Result<(), EvalError> {
        colours.clear();
        colours.resize(rays.len(), DVec3::ZERO);
        let Self { places, gains, shadow_rays, ends, lit } = self;
        let seen = places.set(rays, hits);
        if seen == 0 {
            return Ok(());
        }
        let surface = |lane: usize| &hits[lane].as_ref().expect("places are of hits").surface;
        each(seen, |lane| {
            gains[lane] = Gain { matt: DVec3::splat(surface(lane).ambient), highlight: DVec3::ZERO };
        });
        for light in lights {
            shadow_rays.clear();
            ends.clear();
            lit.clear();
            each(places.face(light), |lane| {
                let (surface, way) = (surface(lane), places.way(lane));
                let mut gain =
                    Gain { matt: light.colour * (surface.diffuse * way.facing), highlight: DVec3::ZERO };
                if surface.specular != 0.0 {
                    let [normal, to_viewer] = places.seen(lane);
                    let mirrored = normal * (2.0 * way.facing) - way.ray.direction;
                    let lobe = libm::pow(mirrored.dot(to_viewer).max(0.0), surface.shininess);
                    gain.highlight = light.colour * (surface.specular * lobe);
                }
                if light.shadow {
                    shadow_rays.push(way.ray);
                    ends.push(way.distance);
                    lit.push((lane, gain));
                } else {
                    gains[lane].add(gain);
                }
            });
            if lit.is_empty() {
                continue;
            }
            let shadowed = tracer.occluded(shadow_rays, ends)?;
            for (number, (lane, gain)) in lit.iter().enumerate() {
                if shadowed >> number & 1 == 0 {
                    gains[*lane].add(*gain);
                }
            }
        }
        each(seen, |lane| {
            let (surface, gain) = (surface(lane), &gains[lane]);
            let matt = gain.matt * surface.matt() + surface.emission;
            colours[lane] = surface.pigment * matt + gain.highlight;
        });
        Ok(())
    }
}

impl Gain {
    fn add(&mut self, other: Self) {
        self.matt += other.matt;
        self.highlight += other.highlight;
    }
}
