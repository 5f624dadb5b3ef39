//! From hits to light: the integrators.
//!
//! What a ray sees is given by an integral over all ways on which light comes to it \[KAJI86\]. [`direct`] takes the few of
//! them that can be listed: from each light straight to the surface, and on through mirrors and clear glass. [`path`]
//! takes all, by chance. Both take the rays of a square of the picture together, bounce by bounce.
//!
//! - [`local`]: ambient, diffuse, highlight, of hits side by side ([`places`]); [`bsdf`]: matt, metal ([`microfacet`]) and glass ([`dielectric`]),
//!   and what glass stands on ([`contact`]).
//! - [`daylight`]: the sky, and the sun to aim at; [`sampler`], [`warp`]: numbers by chance, and directions made of them.

mod bsdf;
mod contact;
mod daylight;
mod dielectric;
mod direct;
mod local;
mod microfacet;
mod path;
mod places;
mod sampler;
mod warp;

use csg_graph::EvalError;
use glam::DVec3;

use self::bsdf::Scattered;
use self::direct::Direct;
use self::path::Path;
use self::sampler::Sampler;
use crate::engine::Tracer;
use crate::{Hit, Ray, Settings, World};

/// How light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// Lights and the ambient part of surfaces, with mirror images and refraction (Whitted \[WHIT80\]). No surface lights
    /// another one. The sun is a light without extent; the roughness of metal is ignored.
    #[default]
    Direct,
    /// Global illumination: light from the sky, the sun, lights and emissive surfaces, and from one surface to the other,
    /// along paths drawn by chance (Kajiya \[KAJI86\]). The mean of a pixel is right for any number of samples, and its noise
    /// falls with their root. Ambient parts and highlights, which stand for such light, are left out.
    Path,
}

/// The light of a world, for the rays of a thread.
#[derive(Debug)]
pub(crate) enum Illumination {
    Direct(Box<Direct>),
    Path(Box<Path>),
}

impl Illumination {
    pub(crate) fn new(world: &World<'_>, settings: &Settings) -> Self {
        let bounces = settings.bounces;
        match settings.integrator {
            Integrator::Direct => Self::Direct(Box::new(Direct::new(world, bounces))),
            Integrator::Path => Self::Path(Box::new(Path::new(world, bounces))),
        }
    }

    /// The colours, in linear light, in which rays see what they hit, or the sky. The rays are one for each of some pixels,
    /// all of the same sample and no more than the engine takes together.
    pub(crate) fn colours(
        &mut self,
        tracer: &mut Tracer<'_>,
        pixels: &[(u32, u32)],
        sample: u32,
        rays: &[Ray],
        hits: &[Option<Hit>],
        colours: &mut Vec<DVec3>,
    ) -> Result<(), EvalError> {
        match self {
            Self::Direct(direct) => direct.colours(tracer, rays, hits, colours),
            Self::Path(path) => {
                let samplers = pixels.iter().map(|pixel| Sampler::new(*pixel, sample));
                path.colours(tracer, samplers, rays, hits, colours)
            }
        }
    }
}

/// How far rays start off the surface, relative to the coordinates of the hit and of the ray's origin.
///
/// A hit is off its surface by some ulps of these, more after badly conditioned transformations. This is about a million
/// ulps, and far below what a pixel covers in a picture of the whole.
const OFFSET: f64 = 1e-10;

/// A place on a surface that rays leave.
#[derive(Clone, Copy, Debug)]
struct Place {
    point: DVec3,
    /// On the side that the ray came from, of length 1.
    normal: DVec3,
    /// Back along the ray, of length 1.
    to_viewer: DVec3,
    offset: f64,
}

impl Place {
    fn new(ray: &Ray, hit: &Hit) -> Self {
        let to_viewer = -ray.direction.normalize_or_zero();
        let normal = if hit.normal.dot(to_viewer) < 0.0 { -hit.normal } else { hit.normal };
        let size = hit.point.abs().max(ray.origin.abs()).max_element();
        Self { point: hit.point, normal, to_viewer, offset: OFFSET * size }
    }

    /// Where rays start that stay on this side.
    fn before(&self) -> DVec3 {
        self.point + self.normal * self.offset
    }

    /// Where rays start that go through it.
    fn behind(&self) -> DVec3 {
        self.point - self.normal * self.offset
    }

    /// The ray that goes on.
    fn leave(&self, scattered: &Scattered) -> Ray {
        let origin = if scattered.is_behind { self.behind() } else { self.before() };
        Ray { origin, direction: scattered.direction }
    }
}
