//! The unit ball.

use super::{End, Span};
use crate::Ray;

/// The half chord is √(1 − |p|²) for the point p closest to the centre, and the spans lie symmetrically about p.
#[inline(always)]
pub(super) fn span(ray: &Ray) -> Span {
    let squared_length = ray.direction.length_squared();
    let middle = -ray.origin.dot(ray.direction) / squared_length;
    let closest = ray.at(middle);
    let half = ((1.0 - closest.length_squared()) / squared_length).sqrt();
    // Not a number where the line misses; a span without length is dropped.
    let end = |offset: f64| End { t: middle + offset, normal: closest + ray.direction * offset };
    Span { enter: end(-half), exit: end(half) }
}
