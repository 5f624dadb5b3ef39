//! Support queries, best first: how far a solid reaches in a direction, without looking at most of it.
//!
//! A query keeps the solids that may hold the furthest point in a queue, ordered by the upper bound that the box of each
//! gives. The first is *expanded*: replaced by its parts, each with the direction taken into its own frame, d′ = Mᵀd,
//! and the support of that frame's origin, o′ = o + t·d. A shape has an exact support, o′ + h(d′), which is a lower bound
//! of the answer; so is every face of a box that is known to be touched. What cannot reach the best lower bound is
//! dropped, and the query ends when nothing else is left. No query expands a solid whose upper bound is below the
//! answer: with boxes as bounds, none can do with fewer expansions.
//!
//! ## Intersections
//!
//! A point of an intersection is in both operands, so that the intersection reaches no further than either, nor than its
//! box. The operand with the least bound is opened, and the other one kept with it. Wherever the search in the first one
//! ends, at a shape or with certainty, it goes on in the other one from there, up to what the first has left. So the
//! answer is the lesser of the two supports, although a best-first search seeks the greatest of everything, and nothing
//! nests. It is the support of no solid, and may be less than what a box that is touched on all sides would allow.
//!
//! ## Ending
//!
//! Unfolded far enough, a state graph without cycles ends at shapes, so each query does. It may end earlier, with a
//! *certified gap* between the best lower and the largest upper bound, and the upper bound stands:
//!
//! - when the gap is below the tolerance;
//! - when it has expanded as many solids as it may.
//!
//! Many parts may reach equally far: half of the 4ⁿ tetrahedra of Sierpiński's touch the top of their box, and three
//! quarters of those that touch a face touch it when it is laid on the table. They do not make queries long:
//!
//! - A direction along an axis of the solid's own frame asks for a face of its box, which is known. That is how all
//!   queries end at once under translations, scalings, mirrors and quarter turns.
//! - Equal upper bounds are expanded the last first, which is the deepest first, so that a tie is not searched broadly.
//! - A solid met again in another place can be *dominated*. If (o, d) and (o′, d′) ask for the same solid, the second
//!   can reach further than the first by at most o′ − o + h(d′ − d), h the support of the box: for parallel copies of one
//!   size by o′ − o. If that is nothing, the second is dropped. Where it is no more than rounding, it is dropped too, and
//!   what it might add is added to the answer. Below a solid that is a part of itself, the first must also be as deep: its
//!   own copies would otherwise be dropped for its sake, and its sake is theirs. Deeper and deeper this ends, at what was
//!   not dropped.
//!
//! ## Rounding
//!
//! Errors in directions and in the supports of shapes are covered by the solid's [error](super::solids::Solid::error).
//! The sum of offsets o′ has one more rounding a step, which is added to the answer here.

use std::collections::BinaryHeap;
use std::num::NonZeroU32;

use glam::DVec3;

use super::solids::{Kind, Part, Solid, Solids};
use crate::best_first::best_first;
use crate::narrow::index;
use crate::{Limits, Shape};

/// How many expanded solids are remembered that others may be dominated by. Ties come one after the other.
const RECENT: usize = 8;

/// What a query found: the support is at most `upper` and, where only unions are above shapes, at least `lower`. Both
/// up to the error of the solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) lower: f64,
    pub(super) upper: f64,
}

/// Queries, one after the other.
pub(super) struct Search {
    /// The most expansions of one query.
    pub(super) limit: usize,
    /// Whether a face of a known box is taken as it is, whatever its gap.
    pub(super) rough: bool,
    /// The gap at which a query may end, relative to the extent of what it is for.
    pub(super) gap: f64,
    /// How many queries there were.
    pub(super) queries: u64,
    /// How many solids all of them expanded.
    pub(super) expansions: u64,
    open: BinaryHeap<Open>,
    /// The last expanded, in a ring.
    recent: Vec<Open>,
    /// The operands that are yet to be asked, of all intersections that were expanded.
    operands: Vec<Operand>,
    query: Query,
}

/// What one query knows.
#[derive(Default)]
struct Query {
    tolerance: f64,
    /// The largest lower bound.
    best: f64,
    /// The largest upper bound of what is neither open nor dropped.
    closed: f64,
    /// How much further than anything expanded the dominated may reach.
    excess: f64,
    /// The largest offset, and the most that were added up.
    offset: f64,
    depth: u32,
    /// How many solids were opened and expanded.
    opened: u32,
    expanded: usize,
}

/// A solid that may hold the furthest point.
#[derive(Clone, Copy)]
struct Open {
    /// No point of it is further.
    upper: f64,
    /// The direction of the query in the frame of the solid.
    direction: DVec3,
    /// The support of the origin of that frame.
    offset: f64,
    solid: u32,
    depth: u32,
    sequence: u32,
    /// What else the point is in: an index into the operands, from 1.
    and: Option<NonZeroU32>,
}

/// An operand of an intersection, to be asked with what the others have left.
#[derive(Clone, Copy)]
struct Operand {
    part: Part,
    /// Direction and offset in the frame of the intersection.
    direction: DVec3,
    offset: f64,
    /// And what comes after it.
    and: Option<NonZeroU32>,
}

impl Search {
    /// As the limits allow.
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            limit: limits.expansions,
            gap: limits.gap,
            rough: false,
            queries: 0,
            expansions: 0,
            open: BinaryHeap::new(),
            recent: Vec::new(),
            operands: Vec::new(),
            query: Query::default(),
        }
    }

    /// The support of a part, which is known to be at most `upper`.
    pub(super) fn support<S: Shape>(
        &mut self,
        solids: &Solids<S>,
        part: &Part,
        direction: DVec3,
        upper: f64,
        tolerance: f64,
    ) -> Found {
        self.open.clear();
        self.recent.clear();
        self.operands.clear();
        self.query =
            Query { tolerance, best: f64::NEG_INFINITY, closed: f64::NEG_INFINITY, ..Query::default() };
        let all = Open { upper, direction, offset: 0.0, solid: 0, depth: 0, sequence: 0, and: None };
        self.enter(solids, part, &all);
        let mut unresolved = f64::NEG_INFINITY;
        while let Some(next) = self.open.pop() {
            if next.upper <= self.query.best + tolerance || self.query.expanded == self.limit {
                unresolved = next.upper;
                break;
            }
            if !self.is_dominated(solids, &next) {
                self.expand(solids, next);
            }
        }
        self.queries += 1;
        self.expansions += self.query.expanded as u64;
        let Query { best, closed, excess, offset, depth, .. } = self.query;
        let rounding = 2.0 * f64::EPSILON * f64::from(depth) * offset;
        Found { lower: best, upper: best.max(closed).max(unresolved) + excess + rounding }
    }

    fn expand<S: Shape>(&mut self, solids: &Solids<S>, next: Open) {
        match &solids.solid(next.solid).kind {
            Kind::Union(parts) => {
                for part in solids.parts(parts) {
                    self.enter(solids, part, &next);
                }
            }
            Kind::Intersection(parts) => {
                let parts = solids.parts(parts);
                let upper = |at: &usize| {
                    let (direction, offset) = below(&parts[*at], next.direction, next.offset);
                    offset + solids.solid(parts[*at].solid).bounds.support(direction)
                };
                // The one with the least bound is asked first, and often settles it.
                let first = (0..parts.len()).min_by(|a, b| upper(a).total_cmp(&upper(b)));
                let first = first.expect("an intersection without operands is never open");
                let mut common = next;
                for part in (0..parts.len()).filter(|at| *at != first).map(|at| parts[at]) {
                    let Open { direction, offset, and, .. } = common;
                    self.operands.push(Operand { part, direction, offset, and });
                    common.and = NonZeroU32::new(index(self.operands.len()));
                }
                self.enter(solids, &parts[first], &common);
            }
            Kind::Shape(_) => unreachable!("shapes are never open"),
        }
        if self.recent.len() < RECENT {
            self.recent.push(next);
        } else {
            self.recent[self.query.expanded % RECENT] = next;
        }
        self.query.expanded += 1;
    }

    /// Bounds a part of an expanded solid, and opens it if it may hold the furthest point. If its bound is certain, goes
    /// on to what else the point is in.
    fn enter<S: Shape>(&mut self, solids: &Solids<S>, part: &Part, above: &Open) {
        let (mut part, mut open) = (*part, Open { depth: above.depth + 1, ..*above });
        loop {
            (open.direction, open.offset) = below(&part, open.direction, open.offset);
            open.solid = part.solid;
            let Open { direction, offset, .. } = open;
            let query = &mut self.query;
            query.offset = query.offset.max(offset.abs());
            query.depth = query.depth.max(open.depth);
            let solid = solids.solid(part.solid);
            let extents = direction.abs() * solid.half;
            let support = offset + solid.center.dot(direction) + extents.element_sum();
            open.upper = support.min(open.upper);
            if open.upper <= query.best {
                return;
            }
            let lower = if let Kind::Shape(shape) = solid.kind {
                let exact = offset + solids.shapes[shape as usize].support(direction);
                open.upper = exact.min(open.upper);
                open.upper
            } else {
                let mut spread = 2.0 * but_the_largest(extents);
                if !solid.touched {
                    // What bounds a face of an intersection may do so from beside the box.
                    spread = 2.0 * but_the_largest(solid.half.max_element() * direction.abs());
                }
                // A point of the solid is at most so far below a face, and at most twice the extents below the support.
                let below = spread + solid.gap * direction.abs().max_element();
                let lower = (support - below.min(2.0 * extents.element_sum())).min(open.upper);
                let uncertain = match solid.touched {
                    _ if self.rough => spread,
                    true => open.upper - lower,
                    false => below,
                };
                // Twice, because the gap of a box that ended within the tolerance must be within it further up.
                if uncertain > 2.0 * query.tolerance && solid.kind.is_open() {
                    if solid.touched && open.and.is_none() {
                        query.best = query.best.max(lower);
                    }
                    query.opened += 1;
                    open.sequence = query.opened;
                    self.open.push(open);
                    return;
                }
                lower
            };
            let Some(next) = open.and else {
                query.best = query.best.max(lower);
                query.closed = query.closed.max(open.upper);
                return;
            };
            Operand { part, direction: open.direction, offset: open.offset, and: open.and } =
                self.operands[next.get() as usize - 1];
        }
    }

    /// Whether a solid was expanded in a place where it reaches as far, but for what is added to the excess.
    fn is_dominated<S: Shape>(&mut self, solids: &Solids<S>, next: &Open) -> bool {
        let Solid { center, half, .. } = solids.solid(next.solid);
        let most = 0.5 * self.query.tolerance - self.query.excess;
        let same = |known: &&Open| {
            known.solid == next.solid
                && (known.and.is_none() || known.and == next.and)
                && (known.depth >= next.depth || !solids.endless)
        };
        let known = self.recent.iter().filter(same);
        let further = known.map(|known| {
            let d = next.direction - known.direction;
            next.offset - known.offset + center.dot(d) + half.dot(d.abs())
        });
        let found = further.into_iter().find(|further| *further <= most);
        self.query.excess += found.unwrap_or(0.0).max(0.0);
        found.is_some()
    }
}

/// The direction of a query in the frame of a part, and the support of its origin, given those above.
pub(super) fn below(part: &Part, d: DVec3, offset: f64) -> (DVec3, f64) {
    let map = &part.chain.parent_from_child;
    let m = &map.matrix3;
    (DVec3::new(m.x_axis.dot(d), m.y_axis.dot(d), m.z_axis.dot(d)), offset + map.translation.dot(d))
}

/// How far the support of a solid may be below that of its box, of that size and certified within the gap: each face is
/// touched somewhere.
pub(super) fn spread(size: DVec3, gap: f64, direction: DVec3) -> f64 {
    let d = direction.abs();
    // 0 · ∞ is no extent at all.
    let extents = DVec3::select(d.cmpgt(DVec3::ZERO), d * size, DVec3::ZERO);
    but_the_largest(extents) + gap * d.max_element()
}

/// The sum of all coordinates but the largest.
fn but_the_largest(v: DVec3) -> f64 {
    (v.x + v.y).min(v.y + v.z).min(v.z + v.x)
}

best_first!(Open: upper, sequence);
