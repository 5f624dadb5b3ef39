//! Slabs about primitives whose measures are intervals.

use csg_graph::{Interval, Primitive, PrimitiveKind};
use glam::DVec3;

use crate::{Shape, Slabs, Volume};

/// Slabs about all primitives of a kind with measures in these intervals: empty if there is none.
pub(super) fn slabs(kind: PrimitiveKind, args: &[Interval]) -> Slabs<13> {
    if args.iter().any(|arg| arg.is_empty()) {
        return Slabs::EMPTY;
    }
    match kind {
        // Of these, the one with the largest measure encloses all others.
        PrimitiveKind::Torus => largest(kind, args[0].intersect(Interval::new(0.0, 1.0))),
        PrimitiveKind::Frustum => largest(kind, args[0].intersect(Interval::new(0.0, f64::MAX))),
        PrimitiveKind::Hull => hull(args),
        _ => kind.evaluate(&[]).map_or(Slabs::EMPTY, |primitive| of_primitive(&primitive)),
    }
}

fn largest(kind: PrimitiveKind, measure: Interval) -> Slabs<13> {
    kind.evaluate(&[measure.max]).map_or(Slabs::EMPTY, |primitive| of_primitive(&primitive))
}

/// The hull of boxes, each of which a point is anywhere in.
fn hull(args: &[Interval]) -> Slabs<13> {
    Slabs::from_support(|d| {
        let far = args.chunks_exact(3).map(|point| {
            let far = |d: f64, x: Interval| {
                if d > 0.0 {
                    d * x.max
                } else if d < 0.0 {
                    d * x.min
                } else {
                    0.0
                }
            };
            let terms = DVec3::new(far(d.x, point[0]), far(d.y, point[1]), far(d.z, point[2]));
            terms.element_sum() + 4.0 * f64::EPSILON * terms.abs().element_sum()
        });
        far.fold(f64::NEG_INFINITY, f64::max)
    })
}

/// The planes of the axes are those of the box, which needs no margin.
pub(super) fn of_primitive(primitive: &Primitive) -> Slabs<13> {
    let bounds = primitive.bounds();
    let reach = bounds.min.abs().max(bounds.max.abs()).length();
    let rounding = if reach.is_finite() { 8.0 * f64::EPSILON * reach } else { 0.0 };
    let mut slabs = Slabs::<13>::from_support(|d| primitive.support(d) + rounding * d.length());
    for axis in 0..3 {
        slabs.min[axis] = bounds.min[axis];
        slabs.max[axis] = bounds.max[axis];
    }
    slabs
}
