//! Direct light with mirror images and refraction: Whitted's ray tracing \[WHIT80\].
//!
//! What a surface shows of itself is [local](super::local) shading. A ray that meets metal or glass branches, and each
//! branch counts as much as the surface reflects or passes on. Branches are followed one generation after the other, as
//! long as they can be seen: one that counts less than [`FAINT`] ends \[HALL83\].

use csg_graph::EvalError;
use glam::DVec3;

use super::Place;
use super::bsdf::Bsdf;
use super::contact::Contacts;
use super::daylight::Daylight;
use super::dielectric::Media;
use super::local::Shader;
use crate::engine::Tracer;
use crate::fast::PACKET;
use crate::{Hit, Light, LightSource, Ray, World};

/// What is not followed: less than a step of a screen's white.
const FAINT: f64 = 1.0 / 1024.0;

#[derive(Debug)]
pub(crate) struct Direct {
    daylight: Daylight,
    /// Those of the world, and its sun.
    lights: Vec<Light>,
    bounces: u32,
    shader: Shader,
    /// What is to be followed next.
    branches: Vec<Branch>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    contacts: Contacts,
    shades: Vec<DVec3>,
}

/// A ray on its way.
#[derive(Clone, Debug)]
struct Branch {
    /// The number of the ray that it began with.
    root: usize,
    ray: Ray,
    /// What its light counts there.
    weight: DVec3,
    media: Media,
}

impl Direct {
    pub(super) fn new(world: &World<'_>, bounces: u32) -> Self {
        let sun = world.background.sun.map(|sun| Light {
            source: LightSource::Directional(-sun.direction),
            colour: sun.colour,
            shadow: true,
        });
        Self {
            daylight: Daylight::new(&world.background),
            lights: world.lights.iter().copied().chain(sun).collect(),
            bounces,
            shader: Shader::default(),
            branches: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            contacts: Contacts::default(),
            shades: Vec::new(),
        }
    }

    pub(super) fn colours(
        &mut self,
        tracer: &mut Tracer<'_>,
        rays: &[Ray],
        hits: &[Option<Hit>],
        colours: &mut Vec<DVec3>,
    ) -> Result<(), EvalError> {
        self.shader.shade(tracer, &self.lights, rays, hits, colours)?;
        self.branches.clear();
        for (root, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            match hit {
                Some(hit) => self.branch(root, ray, hit, DVec3::ONE, &Media::default()),
                None => colours[root] = self.daylight.seen(ray.direction, |_| 1.0),
            }
        }
        for _ in 0..self.bounces {
            let branches = std::mem::take(&mut self.branches);
            if branches.is_empty() {
                break;
            }
            for together in branches.chunks(PACKET) {
                self.follow(tracer, together, colours)?;
            }
        }
        Ok(())
    }

    /// Adds what branches see, and what branches from them.
    fn follow(
        &mut self,
        tracer: &mut Tracer<'_>,
        branches: &[Branch],
        colours: &mut [DVec3],
    ) -> Result<(), EvalError> {
        self.rays.clear();
        self.rays.extend(branches.iter().map(|branch| branch.ray));
        let mut hits = std::mem::take(&mut self.hits);
        tracer.nearest((&self.rays).into(), &mut hits)?;
        self.contacts.replace(tracer, &self.rays, &mut hits)?;
        self.shader.shade(tracer, &self.lights, &self.rays, &hits, &mut self.shades)?;
        for (lane, (branch, hit)) in branches.iter().zip(&hits).enumerate() {
            let Branch { root, ray, weight, media } = branch;
            match hit {
                Some(hit) => {
                    let weight = weight * media.transmittance(ray, hit);
                    colours[*root] += weight * self.shades[lane];
                    self.branch(*root, ray, hit, weight, media);
                }
                None => colours[*root] += weight * self.daylight.seen(ray.direction, |_| 1.0),
            }
        }
        self.hits = hits;
        Ok(())
    }

    /// Branches where a ray meets metal or glass.
    fn branch(&mut self, root: usize, ray: &Ray, hit: &Hit, weight: DVec3, media: &Media) {
        if hit.surface.metal == 0.0 && hit.surface.glass == 0.0 {
            return;
        }
        let place = Place::new(ray, hit);
        let (behind, ratio) = media.cross(ray, hit);
        let (mirrored, passed) = Bsdf::new(&hit.surface, &place, ratio).images();
        for scattered in [Some(mirrored), passed].into_iter().flatten() {
            let weight = weight * scattered.weight;
            if weight.max_element() >= FAINT {
                let media = if scattered.is_behind { behind.clone() } else { media.clone() };
                self.branches.push(Branch { root, ray: place.leave(&scattered), weight, media });
            }
        }
    }
}
