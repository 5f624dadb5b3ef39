//! The unit ball.

use super::{End, Span, Spans};
use crate::Ray;

/// The half chord is √(1 − |p|²) for the point p closest to the centre, and the spans lie symmetrically about p.
pub(super) fn spans(ray: &Ray) -> Spans {
    let squared_length = ray.direction.length_squared();
    let middle = -ray.origin.dot(ray.direction) / squared_length;
    let closest = ray.at(middle);
    let half = ((1.0 - closest.length_squared()) / squared_length).sqrt();
    // Not a number where the line misses; `push` in `from_convex` drops the span then.
    let end = |offset: f64| End { t: middle + offset, normal: closest + ray.direction * offset };
    Spans::from_convex(Span { enter: end(-half), exit: end(half) })
}
