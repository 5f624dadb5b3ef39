//! The cone and the frustum: a disc whose radius changes linearly from 1 at z = 0 to `top` at z = 1.

use glam::{DVec3, Vec3Swizzles};

use super::{End, Span, Spans, cube, cylinder};
use crate::Ray;

pub(super) fn spans(ray: &Ray, top: f64) -> Spans {
    let Some(mut span) = cube::slab(ray, 2, 0.0, 1.0) else { return Spans::NONE };
    let Some(side) = side(ray, top - 1.0) else { return Spans::NONE };
    span.clip(side);
    Spans::from_convex(span)
}

/// The normal where a line crosses the surface at `t`.
#[inline(always)]
pub(super) fn normal_at(ray: &Ray, t: f64, top: f64) -> DVec3 {
    cylinder::cap_at(ray, t).unwrap_or_else(|| normal(ray.at(t), top - 1.0))
}

/// The part of the line inside of the infinite cone of radius 1 + slope·z, on the side of the apex where that is positive.
///
/// With p + t·d for the line and r + t·r′ for the radius along it, inside is where
/// f(t) = |p.xy + t·d.xy|² − (r + t·r′)² = a t² + 2 b t + c ≤ 0.
/// A line flatter than the cone (a > 0) is inside between the two roots. They lie on the same nappe; if that is the
/// wrong one, it is beyond the caps, which cut the span away. A steeper line (a < 0) has a root on each nappe, and is
/// inside beyond the one where the radius grows from, or before the one where it shrinks to.
fn side(ray: &Ray, slope: f64) -> Option<Span> {
    let middle = (DVec3::Z * 0.5 - ray.origin).dot(ray.direction) / ray.direction.length_squared();
    let (p, d) = (ray.at(middle), ray.direction);
    let (radius, growth) = (1.0 + slope * p.z, slope * d.z);
    let a = d.xy().length_squared() - growth * growth;
    let b = p.xy().dot(d.xy()) - radius * growth;
    let c = p.xy().length_squared() - radius * radius;
    if a == 0.0 && b == 0.0 {
        // Along the axis of a frustum that is a cylinder, or in a plane tangent to the cone.
        return (c < 0.0).then_some(Span::LINE);
    }
    let discriminant = if slope.abs() <= 1.0 {
        b * b - a * c
    } else {
        // The flatter the cone, the more of radius²·growth² is in both products. Without it: what is left is how far the
        // line passes the axis, in the plane through the apex and altogether.
        let (at_apex, past) = (p.xy() * growth - d.xy() * radius, p.xy().perp_dot(d.xy()));
        at_apex.length_squared() - past * past
    };
    // A steeper line passes the apex at worst: its discriminant is below 0 only by rounding.
    let meets = discriminant > 0.0 || a < 0.0;
    if !meets {
        return None;
    }
    // The root without cancellation first, the other from the product of the roots; a = 0 sends one to infinity.
    let q = -(b + discriminant.max(0.0).sqrt().copysign(b));
    let roots = if q == 0.0 { [0.0, 0.0] } else { [q / a, c / q] };
    let [first, second] = [roots[0].min(roots[1]), roots[0].max(roots[1])];
    let end = |root: f64| End { t: middle + root, normal: normal(p + d * root, slope) };
    Some(if a >= 0.0 {
        Span { enter: end(first), exit: end(second) }
    } else if growth < 0.0 {
        Span { exit: end(first), ..Span::LINE }
    } else {
        Span { enter: end(second), ..Span::LINE }
    })
}

/// Outward from the side at `point`; along the axis at the apex.
fn normal(point: DVec3, slope: f64) -> DVec3 {
    let radius = point.xy().length();
    if radius > 0.0 { DVec3::new(point.x, point.y, -slope * radius) } else { DVec3::Z * (-slope).signum() }
}
