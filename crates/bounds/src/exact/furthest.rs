//! A point of a solid that is about the furthest in a direction.
//!
//! A support [`query`](super::query) certifies *how far* a solid reaches and does not look for *where*: most end at faces
//! of boxes, of which it is known only that something touches them. This search goes down to shapes, best first as well,
//! and is certain of nothing: it ends after some steps, wherever it is, and of the operands of an intersection it follows
//! the one with the least bound.
//!
//! The furthest point of a shape is the gradient of its support, so that shapes need not know more than that. It is taken
//! from differences. There is none where many points are equally far, as on the face of a cube, which is why a direction
//! should be nothing special.

use std::collections::BinaryHeap;

use glam::{DAffine3, DVec3};

use super::solids::{Kind, Part, Solids};
use crate::Shape;
use crate::best_first::best_first;

/// How many solids one search looks into.
const STEPS: usize = 64;

/// How much further a point has to be, relative to what is known of all, to be worth a step.
const WORTH: f64 = 1e-10;

/// By how much two directions differ for a gradient, relative to their size.
const DIFFERENCE: f64 = 1e-7;

/// A solid where it stands.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) root_from_place: DAffine3,
    pub(super) solid: u32,
}

/// One that may hold the furthest point.
struct Open {
    /// No point of it is further.
    upper: f64,
    /// How many were found before.
    sequence: usize,
    place: Place,
    /// The direction in its frame.
    direction: DVec3,
}

/// A point of a solid that is about the furthest in a direction. Not finite where there is no furthest.
pub(super) fn furthest<S: Shape>(solids: &Solids<S>, root: &Place, direction: DVec3) -> DVec3 {
    let first = Open::new(solids, *root, direction, 0);
    let worth = WORTH * first.upper.abs();
    let mut found = 1;
    let mut open = BinaryHeap::from([first]);
    let mut best: Option<DVec3> = None;
    for _ in 0..STEPS {
        let enough = best.map_or(f64::NEG_INFINITY, |point| point.dot(direction) + worth);
        let Some(next) = open.pop().filter(|next| next.upper > enough) else { break };
        let kind = &solids.solid(next.place.solid).kind;
        match kind {
            Kind::Shape(shape) => {
                let shape = &solids.shapes[*shape as usize];
                let point = next.place.root_from_place.transform_point3(gradient(shape, next.direction));
                if best.is_none_or(|best| point.dot(direction) > best.dot(direction)) {
                    best = Some(point);
                }
            }
            Kind::Union(parts) | Kind::Intersection(parts) => {
                let parts = solids.parts(parts).iter().map(|part| {
                    found += 1;
                    Open::new(solids, next.place.below(part), direction, found)
                });
                match kind {
                    Kind::Union(_) => open.extend(parts),
                    _ => open.extend(parts.min()),
                }
            }
        }
    }
    // Where it did not get down to a shape, it is about in the middle of what may be furthest.
    best.or_else(|| open.pop().map(|open| open.place.middle(solids))).unwrap_or(DVec3::NAN)
}

impl Place {
    /// Where a part stands in the frame of what it is a part of.
    pub(super) fn of(part: &Part) -> Self {
        Self { root_from_place: part.chain.parent_from_child, solid: part.solid }
    }

    /// Where a part of the solid stands.
    pub(super) fn below(&self, part: &Part) -> Self {
        Self { root_from_place: self.root_from_place * part.chain.parent_from_child, solid: part.solid }
    }

    /// The middle of the box of the solid.
    pub(super) fn middle<S: Shape>(&self, solids: &Solids<S>) -> DVec3 {
        self.root_from_place.transform_point3(solids.solid(self.solid).center)
    }
}

impl Open {
    fn new<S: Shape>(solids: &Solids<S>, place: Place, direction: DVec3, sequence: usize) -> Self {
        let local = place.root_from_place.matrix3.transpose() * direction;
        let support = solids.solid(place.solid).bounds.support(local);
        let upper = place.root_from_place.translation.dot(direction) + support;
        Self { upper, sequence, place, direction: local }
    }
}

/// The gradient of the support of a shape.
fn gradient<S: Shape>(shape: &S, direction: DVec3) -> DVec3 {
    let size = direction.abs().max_element();
    let unit = if size > 0.0 { direction / size } else { DVec3::ZERO };
    let along = |axis: DVec3| {
        let [before, behind] = [-DIFFERENCE, DIFFERENCE].map(|step| shape.support(unit + step * axis));
        (behind - before) / (2.0 * DIFFERENCE)
    };
    DVec3::from_array(DVec3::AXES.map(along))
}

// A tie is not searched broadly.
best_first!(Open: upper, sequence);
