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
