//! Solids bounded by planes: the convex hull and the half-space. Each plane cuts the line once.

use std::cmp::Ordering;

use csg_graph::{Face, Hull};
use glam::DVec3;

use super::{End, Span, Spans};
use crate::Ray;

pub(super) fn hull_spans(ray: &Ray, hull: &Hull) -> Spans {
    let mut span = Span::LINE;
    let meets = hull.faces().iter().all(|face| clip(&mut span, face, ray) && span.enter.t < span.exit.t);
    if meets { Spans::from_convex(span) } else { Spans::NONE }
}

/// z ≤ 0: half of the line, all of it, or none.
pub(super) fn half_space_spans(ray: &Ray) -> Spans {
    let mut span = Span::LINE;
    let meets = clip(&mut span, &Face { normal: DVec3::Z, offset: 0.0 }, ray);
    if meets { Spans::from_convex(span) } else { Spans::NONE }
}

/// Cuts off what is outside of the face's plane. Says whether anything may be left.
fn clip(span: &mut Span, face: &Face, ray: &Ray) -> bool {
    let distance = face.offset - face.normal.dot(ray.origin);
    let approach = face.normal.dot(ray.direction);
    let end = End { t: distance / approach, normal: face.normal };
    match approach.partial_cmp(&0.0) {
        Some(Ordering::Less) => span.clip_enter(end),
        Some(Ordering::Greater) => span.clip_exit(end),
        Some(Ordering::Equal) => return distance > 0.0,
        None => return false,
    }
    true
}
