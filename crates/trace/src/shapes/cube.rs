//! The cube, and the slabs between two planes across a coordinate axis that it shares with the caps of other shapes
//! (\[KAY86\]).

use glam::DVec3;

use super::{End, Span};
use crate::Ray;

#[inline(always)]
pub(super) fn span(ray: &Ray) -> Option<Span> {
    let mut span = slab(ray, 0, -1.0, 1.0)?;
    span.clip(slab(ray, 1, -1.0, 1.0)?);
    span.clip(slab(ray, 2, -1.0, 1.0)?);
    Some(span)
}

/// The part of the line where `min` ≤ coordinate < `max`.
///
/// A line across the axis has the quotient 0/0 if it lies in a plane; it is decided here without dividing.
#[inline(always)]
pub(super) fn slab(ray: &Ray, axis: usize, min: f64, max: f64) -> Option<Span> {
    let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
    if direction == 0.0 {
        return (min <= origin && origin < max).then_some(Span::LINE);
    }
    let outward = DVec3::AXES[axis];
    let low = End { t: (min - origin) / direction, normal: -outward };
    let high = End { t: (max - origin) / direction, normal: outward };
    Some(if direction > 0.0 { Span { enter: low, exit: high } } else { Span { enter: high, exit: low } })
}
