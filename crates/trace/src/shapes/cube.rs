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

/// The normal of the plane that a line crosses at `t`. Where it crosses an edge, the first plane is seen, as in [`span`].
#[inline(always)]
pub(super) fn normal_at(ray: &Ray, t: f64) -> DVec3 {
    let low = ((DVec3::NEG_ONE - ray.origin) / ray.direction - t).abs();
    let high = ((DVec3::ONE - ray.origin) / ray.direction - t).abs();
    let (mut closest, mut across, mut outward) = (f64::INFINITY, 0, 1.0);
    for axis in 0..3 {
        if low[axis] < closest {
            (closest, across, outward) = (low[axis], axis, -1.0);
        }
        if high[axis] < closest {
            (closest, across, outward) = (high[axis], axis, 1.0);
        }
    }
    let mut normal = DVec3::ZERO;
    normal[across] = outward;
    normal
}
