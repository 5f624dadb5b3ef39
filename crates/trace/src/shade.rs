//! Local shading: ambient, diffuse, and a highlight (Phong), with shadows.
//!
//! ```text
//! pigment · (ambient + Σ diffuse · max(0, N·L) · visible · light) + Σ specular · max(0, R·V)^shininess · visible · light
//! ```
//!
//! Surfaces are two-sided: N is turned to face the viewer. L points to the light, R is L mirrored about N, V points to the
//! viewer. A surface without attributes under one white light is pigment · (0.2 + 0.8 · max(0, N·L) · visible).

use csg_graph::EvalError;
use glam::DVec3;

use crate::{Hit, Light, Ray, Walk};

/// How far shadow rays start off the surface, relative to the coordinates of the hit and of the ray's origin.
///
/// A hit is off its surface by some ulps of these, more after badly conditioned transformations. This is about a million
/// ulps, and far below what a pixel covers in a picture of the whole.
const OFFSET: f64 = 1e-10;

/// The colour, in linear light, in which `ray` sees `hit`.
pub(crate) fn shade(walk: &mut Walk, lights: &[Light], ray: &Ray, hit: &Hit) -> Result<DVec3, EvalError> {
    let to_viewer = -ray.direction.normalize_or_zero();
    let normal = if hit.normal.dot(to_viewer) < 0.0 { -hit.normal } else { hit.normal };
    let size = hit.point.abs().max(ray.origin.abs()).max_element();
    let start = hit.point + normal * (OFFSET * size);

    let surface = &hit.surface;
    let mut matt = DVec3::splat(surface.ambient);
    let mut highlight = DVec3::ZERO;
    for light in lights {
        let Some((to_light, distance)) = light.way_from(start) else { continue };
        let facing = normal.dot(to_light);
        if facing <= 0.0 {
            continue;
        }
        let shadow_ray = Ray { origin: start, direction: to_light };
        if light.shadow && walk.occluded(&shadow_ray, distance)? {
            continue;
        }
        matt += light.colour * (surface.diffuse * facing);
        if surface.specular != 0.0 {
            let mirrored = normal * (2.0 * facing) - to_light;
            let lobe = libm::pow(mirrored.dot(to_viewer).max(0.0), surface.shininess);
            highlight += light.colour * (surface.specular * lobe);
        }
    }
    Ok(surface.pigment * matt + highlight)
}
