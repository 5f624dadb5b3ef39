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

use super::Place;
use crate::engine::Tracer;
use crate::{Hit, Light, Ray};

/// Shades several hits together, so that their shadow rays can be traced together.
#[derive(Debug, Default)]
pub(crate) struct Shader {
    points: Vec<Point>,
    shadow_rays: Vec<Ray>,
    ends: Vec<f64>,
    /// The points of the shadow rays, and what the light adds there.
    lit: Vec<(usize, Gain)>,
}

/// A hit that is being shaded.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Its number among the rays.
    ray: usize,
    start: DVec3,
    normal: DVec3,
    to_viewer: DVec3,
    gain: Gain,
}

/// What lights add to a surface: in its pigment, and on top of it.
#[derive(Clone, Copy, Debug)]
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
        self.points.clear();
        let seen = rays.iter().zip(hits).enumerate();
        self.points
            .extend(seen.filter_map(|(number, (ray, hit))| Some(Point::new(number, ray, hit.as_ref()?))));
        for light in lights {
            self.shadow_rays.clear();
            self.ends.clear();
            self.lit.clear();
            for (number, point) in self.points.iter_mut().enumerate() {
                let surface = &hits[point.ray].as_ref().expect("points are hits").surface;
                let Some((to_light, distance)) = light.way_from(point.start) else { continue };
                let facing = point.normal.dot(to_light);
                if facing <= 0.0 {
                    continue;
                }
                let mut gain =
                    Gain { matt: light.colour * (surface.diffuse * facing), highlight: DVec3::ZERO };
                if surface.specular != 0.0 {
                    let mirrored = point.normal * (2.0 * facing) - to_light;
                    let lobe = libm::pow(mirrored.dot(point.to_viewer).max(0.0), surface.shininess);
                    gain.highlight = light.colour * (surface.specular * lobe);
                }
                if light.shadow {
                    self.shadow_rays.push(Ray { origin: point.start, direction: to_light });
                    self.ends.push(distance);
                    self.lit.push((number, gain));
                } else {
                    point.gain.add(gain);
                }
            }
            let shadowed = tracer.occluded(&self.shadow_rays, &self.ends)?;
            for (lane, (number, gain)) in self.lit.iter().enumerate() {
                if shadowed >> lane & 1 == 0 {
                    self.points[*number].gain.add(*gain);
                }
            }
        }
        colours.clear();
        colours.resize(rays.len(), DVec3::ZERO);
        for point in &self.points {
            let surface = &hits[point.ray].as_ref().expect("points are hits").surface;
            let matt = point.gain.matt * surface.matt() + surface.emission;
            colours[point.ray] = surface.pigment * matt + point.gain.highlight;
        }
        Ok(())
    }
}

impl Point {
    fn new(number: usize, ray: &Ray, hit: &Hit) -> Self {
        let place = Place::new(ray, hit);
        let gain = Gain { matt: DVec3::splat(hit.surface.ambient), highlight: DVec3::ZERO };
        let start = place.before();
        Self { ray: number, start, normal: place.normal, to_viewer: place.to_viewer, gain }
    }
}

impl Gain {
    fn add(&mut self, other: Self) {
        self.matt += other.matt;
        self.highlight += other.highlight;
    }
}
