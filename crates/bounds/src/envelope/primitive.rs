//! Envelopes of primitives whose measures are intervals.

use csg_graph::{Interval, Primitive, PrimitiveKind};
use glam::DVec3;

use super::body::{Body, ROUNDING};
use crate::{Aabb, Shape, Volume};

/// An envelope of all primitives of a kind with measures in these intervals: empty if there is none.
pub(super) fn body(kind: PrimitiveKind, args: &[Interval]) -> Body {
    if args.iter().any(|arg| arg.is_empty()) {
        return Body::EMPTY;
    }
    let of_kind =
        |args: &[f64]| kind.evaluate(args).map_or(Body::EMPTY, |primitive| of_primitive(&primitive));
    match kind {
        // Of these, the one with the largest measure encloses all others.
        PrimitiveKind::Torus => of_kind(&[args[0].max.min(1.0)]),
        PrimitiveKind::Frustum => of_kind(&[args[0].max.min(f64::MAX)]),
        PrimitiveKind::Hull => hull(args),
        _ => of_kind(&[]),
    }
}

/// The box of that envelope.
pub(super) fn aabb(kind: PrimitiveKind, args: &[Interval]) -> Aabb {
    if !matches!(kind, PrimitiveKind::Hull) || args.iter().any(|arg| arg.is_empty()) {
        return body(kind, args).slabs.aabb();
    }
    let coordinate =
        |axis: usize| args.iter().skip(axis).step_by(3).copied().fold(Interval::EMPTY, Interval::join);
    let [x, y, z] = [0, 1, 2].map(coordinate);
    Aabb { min: DVec3::new(x.min, y.min, z.min), max: DVec3::new(x.max, y.max, z.max) }
}

/// The hull of boxes, each of which a point is anywhere in.
fn hull(args: &[Interval]) -> Body {
    let farthest = |point: &[Interval]| {
        let [x, y, z] = [0, 1, 2].map(|axis| point[axis].min.abs().max(point[axis].max.abs()));
        DVec3::new(x, y, z).length() * (1.0 + ROUNDING)
    };
    let support = |d: DVec3, point: &[Interval]| {
        let terms = [0, 1, 2].map(|axis| match (d[axis], point[axis]) {
            (0.0, _) => 0.0,
            (d, x) => d * if d > 0.0 { x.max } else { x.min },
        });
        let terms = DVec3::from_array(terms);
        let sum = terms.element_sum() + ROUNDING * terms.abs().element_sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    };
    let radius = args.chunks_exact(3).map(farthest).fold(0.0, f64::max);
    let farthest =
        |d: DVec3| args.chunks_exact(3).map(|point| support(d, point)).fold(f64::NEG_INFINITY, f64::max);
    Body::new(|d| [farthest(d), farthest(-d)], radius)
}

/// The planes of the axes are those of the box, which needs no margin.
fn of_primitive(primitive: &Primitive) -> Body {
    let bounds = primitive.bounds();
    let reach = bounds.min.abs().max(bounds.max.abs()).length();
    let rounding = if reach.is_finite() { ROUNDING * reach } else { 0.0 };
    let radius = match primitive {
        Primitive::Sphere | Primitive::Cone => 1.0,
        Primitive::Cylinder => std::f64::consts::SQRT_2 * (1.0 + ROUNDING),
        Primitive::Torus { minor } => (1.0 + minor).next_up(),
        Primitive::Hull(hull) => {
            hull.points().iter().map(|point| point.length()).fold(0.0, f64::max) * (1.0 + ROUNDING)
        }
        _ => f64::INFINITY,
    };
    let supports = |d: DVec3| [d, -d].map(|d| primitive.support(d) + rounding * d.length());
    let mut body = Body::new(supports, radius);
    for axis in 0..3 {
        body.slabs.min[axis] = bounds.min[axis];
        body.slabs.max[axis] = bounds.max[axis];
    }
    body
}
