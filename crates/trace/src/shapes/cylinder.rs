//! The cylinder: a disc swept along z from 0 to 1.

use glam::{DVec2, DVec3, Vec3Swizzles};

use super::{End, Span, cube};
use crate::Ray;

#[inline(always)]
pub(super) fn span(ray: &Ray) -> Option<Span> {
    let mut span = cube::slab(ray, 2, 0.0, 1.0)?;
    span.clip(side(ray)?);
    Some(span)
}

/// The normal where a line crosses the surface at `t`.
#[inline(always)]
pub(super) fn normal_at(ray: &Ray, t: f64) -> DVec3 {
    cap_at(ray, t).unwrap_or_else(|| ray.at(t).with_z(0.0))
}

/// The normal of a cap, if one is met at `t` by the arithmetic of its slab. Where caps and sides meet, the cap is seen.
#[inline(always)]
#[expect(clippy::float_cmp, reason = "the same quotients are equal")]
pub(super) fn cap_at(ray: &Ray, t: f64) -> Option<DVec3> {
    let (origin, direction) = (ray.origin.z, ray.direction.z);
    if (0.0 - origin) / direction == t {
        return Some(DVec3::NEG_Z);
    }
    ((1.0 - origin) / direction == t).then_some(DVec3::Z)
}

/// The part of the line inside of the infinite cylinder: the sphere's construction, in the xy plane.
#[inline(always)]
fn side(ray: &Ray) -> Option<Span> {
    let (origin, direction) = (ray.origin.xy(), ray.direction.xy());
    let squared_length = direction.length_squared();
    if squared_length == 0.0 {
        return (origin.length_squared() < 1.0).then_some(Span::LINE);
    }
    let middle = -origin.dot(direction) / squared_length;
    let closest: DVec2 = origin + direction * middle;
    let squared_half = (1.0 - closest.length_squared()) / squared_length;
    let end =
        |offset: f64| End { t: middle + offset, normal: DVec3::from((closest + direction * offset, 0.0)) };
    let half = squared_half.sqrt();
    (squared_half > 0.0).then(|| Span { enter: end(-half), exit: end(half) })
}
