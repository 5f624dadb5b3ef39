//! Boxes of attractors that are guessed, and then shown to hold.
//!
//! Going round a cycle makes a box less loose by what the cycle shrinks. Where that is a millionth, no number of rounds is
//! enough, and yet the box may be plain: `A -> uscale(0.999999) A | sphere` is a sphere. So boxes are guessed between those
//! that are known and what is known to be inside of them, and a guess is taken if it explains itself: if all parts of
//! each solid, or their parts again, are within the face that was guessed when solids of the component are within theirs.
//!
//! **Why that is enough.** Let rₛ > 0 be any size of the solid s, and let D be the largest excess (hₛ(d) − face)/rₛ of all
//! faces d that were guessed. It is finite, since the boxes that were known before hold all solids. A point x of s that is
//! as far as that in direction d is an image of a point y of some part, d·x = o′ + d′·y. If the part is not in the
//! component, or was followed down to a shape, then d·x is at most the face, and D at most 0. If it is the solid t of the
//! component, then y exceeds no face of t by more than D rₜ, so that d·x exceeds what the guessed box of t gives by at most
//! |d′|₁ D rₜ. With |d′|₁ rₜ < rₛ wherever a search ends, D is less than itself, or at most 0: nothing exceeds any face. A
//! part in which |d′|₁ rₜ is larger, because it is turned against the axes, is followed further down. Of an
//! intersection, any one operand will do.
//!
//! **Rounding.** The points on the way are points of the solids, within the boxes that were known before, so that the
//! [errors](super::solids::Solid::error) of these cover it. They cover √3 rₜ times the error of d′, too, with rₜ the
//! largest coordinate of the box of t, and that is the size that is taken.

use glam::DVec3;

use super::attractor::FACES;
use super::query::below;
use super::solids::{Kind, Part, Solids};
use crate::{Aabb, Shape};

/// A part on the way down from a face.
struct Open {
    solid: u32,
    direction: DVec3,
    offset: f64,
    /// The largest offset on the way, and the most that were added up.
    largest: f64,
    depth: u32,
}

/// Boxes that may hold the declared solids from `first` on.
pub(super) struct Guess<'a, S> {
    pub(super) solids: &'a Solids<S>,
    pub(super) first: u32,
    pub(super) boxes: &'a [Aabb],
    /// How many parts may be looked into for a face.
    pub(super) limit: usize,
    /// How many were.
    pub(super) expansions: u64,
}

impl<S: Shape> Guess<'_, S> {
    /// Whether the boxes hold the solids, if those that are known do.
    pub(super) fn holds(&mut self) -> bool {
        (self.first..).zip(self.boxes).all(|(solid, guessed)| {
            let known = self.solids.solid(solid).bounds;
            !guessed.is_empty()
                && FACES.into_iter().all(|direction| {
                    let face = guessed.support(direction);
                    face >= known.support(direction) || self.face_holds(solid, direction, face)
                })
        })
    }

    fn face_holds(&mut self, solid: u32, direction: DVec3, face: f64) -> bool {
        let above = self.solids.solid(solid);
        let (size, error) = (above.bounds.magnitude(), above.error);
        let mut open = vec![Open { solid, direction, offset: 0.0, largest: 0.0, depth: 0 }];
        let mut left = self.limit;
        while let Some(next) = open.pop() {
            let rounding = 2.0 * f64::EPSILON * f64::from(next.depth) * next.largest;
            let within = |support: f64| (support + error + rounding).next_up() <= face;
            if next.depth > 0 && within(self.support(&next)) && self.shrinks(&next, size, error) {
                continue;
            }
            if left == 0 {
                return false;
            }
            left -= 1;
            self.expansions += 1;
            match &self.solids.solid(next.solid).kind {
                Kind::Shape(_) => return false,
                Kind::Union(parts) => {
                    open.extend(self.solids.parts(parts).iter().map(|part| next.part(part)));
                }
                Kind::Intersection(parts) => {
                    let parts = self.solids.parts(parts).iter().map(|part| next.part(part));
                    let least = parts.min_by(|a, b| self.support(a).total_cmp(&self.support(b)));
                    let Some(least) = least else { return false };
                    open.push(least);
                }
            }
        }
        true
    }

    /// The guessed box of a solid, if it is in the component.
    fn guessed(&self, solid: u32) -> Option<&Aabb> {
        self.boxes.get(solid.checked_sub(self.first)? as usize)
    }

    /// How far a part reaches if the guess is right.
    fn support(&self, part: &Open) -> f64 {
        let solid = self.solids.solid(part.solid);
        match solid.kind {
            Kind::Shape(shape) => part.offset + self.solids.shapes[shape as usize].support(part.direction),
            _ => self.guessed(part.solid).unwrap_or(&solid.bounds).support_above(part.direction, part.offset),
        }
    }

    /// Whether an excess of the part is less than that of the solid of the face, which has this size and error.
    fn shrinks(&self, part: &Open, size: f64, error: f64) -> bool {
        let below = self.solids.solid(part.solid).bounds.magnitude();
        let length = part.direction.abs().element_sum();
        self.guessed(part.solid).is_none() || (below * length + error) * (1.0 + 8.0 * f64::EPSILON) < size
    }
}

impl Open {
    fn part(&self, part: &Part) -> Self {
        let (direction, offset) = below(part, self.direction, self.offset);
        let largest = self.largest.max(offset.abs());
        Self { solid: part.solid, direction, offset, largest, depth: self.depth + 1 }
    }
}
