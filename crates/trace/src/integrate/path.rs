//! Path tracing \[KAJI86\]: the light of all ways on which it comes to a pixel, as the mean over ways drawn by chance.
//!
//! A path goes from the camera from surface to surface. At each it adds what it finds:
//!
//! - *Lights* have no extent and are never met. They are asked for directly: a shadow ray to each.
//! - *The sun* is small: a shadow ray to a point of its disc, and what paths meet of it, weighted against each other by the
//!   balance heuristic of multiple importance sampling \[VEAC97\]. Behind clear glass and in mirrors, paths alone find it.
//! - *The sky* is smooth and all around, and *emissive surfaces* cannot be listed, because the solid is never unfolded: both
//!   count where paths meet them.
//!
//! Directions are drawn as surfaces scatter, and from the fourth bounce on a path goes on with the probability of what
//! its light would still count (Russian roulette \[ARVO90\]), and counts the more if it does. Nothing is clamped.
//!
//! Light carries radiance over the square of the index of refraction, which refraction leaves as it is (\[VEAC97\] §5.2).

use std::f64::consts::PI;

use csg_graph::EvalError;
use glam::{DVec2, DVec3};

use super::Place;
use super::bsdf::Bsdf;
use super::contact::Contacts;
use super::daylight::Daylight;
use super::dielectric::Media;
use super::sampler::Sampler;
use crate::engine::Tracer;
use crate::{Hit, Light, Ray, World};

/// Bounces after which paths may end by chance.
const ROULETTE: u32 = 3;

/// What the numbers of a bounce decide.
#[derive(Clone, Copy, Debug)]
enum Choice {
    Part,
    Direction,
    Sun,
    Survival,
}

#[derive(Debug)]
pub(crate) struct Path {
    daylight: Daylight,
    lights: Vec<Light>,
    bounces: u32,
    strands: Vec<Strand>,
    vertices: Vec<Vertex>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    contacts: Contacts,
    shadows: Shadows,
}

/// The end of a path, on its way to the next surface.
#[derive(Clone, Debug)]
struct Strand {
    /// The number of the ray that it began with.
    root: usize,
    sampler: Sampler,
    ray: Ray,
    /// What its light counts.
    weight: DVec3,
    media: Media,
    /// The density at which the direction was drawn, where it might have been drawn towards the sun as well.
    density: Option<f64>,
}

/// The end of a path at a surface.
#[derive(Debug)]
struct Vertex {
    strand: Strand,
    place: Place,
    bsdf: Bsdf,
    /// What is behind the surface.
    behind: Media,
}

/// Light that arrives unless something is in the way.
#[derive(Debug, Default)]
struct Shadows {
    rays: Vec<Ray>,
    ends: Vec<f64>,
    light: Vec<(usize, DVec3)>,
}

impl Path {
    pub(super) fn new(world: &World<'_>, bounces: u32) -> Self {
        Self {
            daylight: Daylight::new(&world.background),
            lights: world.lights.clone(),
            bounces,
            strands: Vec::new(),
            vertices: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            contacts: Contacts::default(),
            shadows: Shadows::default(),
        }
    }

    pub(super) fn colours(
        &mut self,
        tracer: &mut Tracer<'_>,
        samplers: impl Iterator<Item = Sampler>,
        rays: &[Ray],
        hits: &[Option<Hit>],
        colours: &mut Vec<DVec3>,
    ) -> Result<(), EvalError> {
        colours.clear();
        colours.resize(rays.len(), DVec3::ZERO);
        let strand = |(root, (ray, sampler)): (usize, (&Ray, Sampler))| Strand {
            root,
            sampler,
            ray: *ray,
            weight: DVec3::ONE,
            media: Media::default(),
            density: None,
        };
        self.strands.clear();
        self.strands.extend(rays.iter().zip(samplers).enumerate().map(strand));
        self.hits.clear();
        self.hits.extend_from_slice(hits);
        for bounce in 0..self.bounces {
            self.arrive(colours);
            if self.vertices.is_empty() {
                return Ok(());
            }
            self.ask_lights(tracer, bounce, colours)?;
            self.go_on(bounce);
            self.rays.clear();
            self.rays.extend(self.strands.iter().map(|strand| strand.ray));
            tracer.nearest((&self.rays).into(), &mut self.hits)?;
            self.contacts.replace(tracer, &self.rays, &mut self.hits)?;
        }
        self.arrive(colours);
        Ok(())
    }

    /// Adds the light of what strands have met; those that met a surface become vertices.
    fn arrive(&mut self, colours: &mut [DVec3]) {
        self.vertices.clear();
        for (mut strand, hit) in self.strands.drain(..).zip(&self.hits) {
            let Some(hit) = hit else {
                // Where `ask_lights` has aimed at the sun as well, each of the two counts its part.
                let sun_counts =
                    |towards_sun: f64| strand.density.map_or(1.0, |own| own / (own + towards_sun));
                colours[strand.root] += strand.weight * self.daylight.seen(strand.ray.direction, sun_counts);
                continue;
            };
            strand.weight *= strand.media.transmittance(&strand.ray, hit);
            colours[strand.root] += strand.weight * hit.surface.pigment * hit.surface.emission;
            let place = Place::new(&strand.ray, hit);
            let (behind, ratio) = strand.media.cross(&strand.ray, hit);
            let bsdf = Bsdf::new(&hit.surface, &place, ratio);
            self.vertices.push(Vertex { strand, place, bsdf, behind });
        }
    }

    /// Adds the light that lights and the sun throw on the vertices.
    fn ask_lights(
        &mut self,
        tracer: &mut Tracer<'_>,
        bounce: u32,
        colours: &mut [DVec3],
    ) -> Result<(), EvalError> {
        for light in &self.lights {
            for Vertex { strand, place, bsdf, .. } in &self.vertices {
                let start = place.before();
                let Some((to_light, distance)) = light.way_from(start) else { continue };
                // A white surface that faces the light gives back its colour.
                let seen = strand.weight * bsdf.evaluate(to_light).0 * light.colour * PI;
                if light.shadow {
                    self.shadows.push(
                        Ray { origin: start, direction: to_light },
                        distance,
                        strand.root,
                        seen,
                    );
                } else {
                    colours[strand.root] += seen;
                }
            }
            self.shadows.trace(tracer, colours)?;
        }
        if let Some(sun) = &self.daylight.sun {
            for Vertex { strand, place, bsdf, .. } in &self.vertices {
                let (to_sun, towards_sun) = sun.sample(strand.square(bounce, Choice::Sun));
                let (scattered, own) = bsdf.evaluate(to_sun);
                let seen = strand.weight * scattered * sun.radiance / (own + towards_sun);
                let ray = Ray { origin: place.before(), direction: to_sun };
                self.shadows.push(ray, f64::INFINITY, strand.root, seen);
            }
            self.shadows.trace(tracer, colours)?;
        }
        Ok(())
    }

    /// Lets paths go on from their vertices, or end.
    fn go_on(&mut self, bounce: u32) {
        for Vertex { strand, place, bsdf, behind } in self.vertices.drain(..) {
            let part = strand.square(bounce, Choice::Part).x;
            let Some(scattered) = bsdf.sample(part, strand.square(bounce, Choice::Direction)) else {
                continue;
            };
            let mut weight = strand.weight * scattered.weight;
            if bounce >= ROULETTE {
                let survival = weight.max_element().min(1.0);
                if strand.square(bounce, Choice::Survival).x >= survival {
                    continue;
                }
                weight /= survival;
            }
            if weight.max_element() > 0.0 {
                self.strands.push(Strand {
                    ray: place.leave(&scattered),
                    weight,
                    media: if scattered.is_behind { behind } else { strand.media },
                    density: scattered.density,
                    ..strand
                });
            }
        }
    }
}

impl Strand {
    fn square(&self, bounce: u32, choice: Choice) -> DVec2 {
        self.sampler.square(4 * bounce + choice as u32)
    }
}

impl Shadows {
    fn push(&mut self, ray: Ray, end: f64, root: usize, light: DVec3) {
        if light.max_element() > 0.0 {
            self.rays.push(ray);
            self.ends.push(end);
            self.light.push((root, light));
        }
    }

    /// Adds the light that arrives.
    fn trace(&mut self, tracer: &mut Tracer<'_>, colours: &mut [DVec3]) -> Result<(), EvalError> {
        let shadowed = tracer.occluded(&self.rays, &self.ends)?;
        for (lane, (root, light)) in self.light.drain(..).enumerate() {
            if shadowed >> lane & 1 == 0 {
                colours[root] += light;
            }
        }
        self.rays.clear();
        self.ends.clear();
        Ok(())
    }
}
