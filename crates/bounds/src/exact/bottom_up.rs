//! The boxes of all states, children before their parents.
//!
//! A shape has its own box, and states in one frame pass theirs up as always: joined, met, or as they are. Only a T-node
//! whose map turns or shears must ask for more than the box below it. Its six faces are support queries, in directions
//! that the map takes below; each prunes with the boxes that are already there. A face whose direction stays along an
//! axis is the image of the face below and asks nothing.

use glam::{DAffine3, DVec3};

use super::apart::are_apart;
use super::attractor::ERRORS;
use super::components::Components;
use super::query::{Found, Search, spread};
use super::solids::{Image, Solids};
use super::states::{States, Term};
use super::{Endless, StateBox, Support};
use crate::{Aabb, BoundsError, Limits, Scene, Shape};

/// What a bottom-up pass leaves: for each state, by its number, its box and the solid that it is an image of.
pub(super) struct BottomUp<S: Scene> {
    pub(super) states: States<S>,
    pub(super) boxes: Vec<StateBox>,
    pub(super) images: Vec<Image>,
    pub(super) solids: Solids<S::Shape>,
    pub(super) search: Search,
    /// What is known of recursion that never ends, if there is any.
    pub(super) endless: Option<Endless>,
}

impl<S: Scene> BottomUp<S> {
    /// Bounds all states. Unless there are intersections, whose boxes come from boxes, with no more expansions a query
    /// than `enough`.
    pub(super) fn new(scene: &S, limits: &Limits, enough: usize) -> Result<Self, BoundsError<S::Error>> {
        let mut states = States::explore(scene, limits)?;
        let intersects = states.terms.iter().any(|term| matches!(term, Term::Intersection(_)));
        let count = states.terms.len();
        let solids = Solids::new(std::mem::take(&mut states.shapes));
        let mut search = Search::new(limits);
        if enough < limits.expansions && !intersects {
            (search.limit, search.rough) = (enough, true);
        }
        let components =
            states.cyclic.then(|| Components::new(states.terms.len(), |state| states.below(state)));
        let (boxes, images) = (vec![EMPTY; count], vec![Image::NONE; count]);
        let mut found = Self { states, boxes, images, solids, search, endless: None };
        let mut operands: Vec<Image> = Vec::new();
        match components {
            None => (0..count).for_each(|state| found.bound(state, &mut operands)),
            Some(components) => {
                for component in components.iter() {
                    match component {
                        [state] if !found.states.below(*state).contains(state) => {
                            found.bound(*state as usize, &mut operands);
                        }
                        _ => found.attractor(scene, limits, component)?,
                    }
                }
            }
        }
        Ok(found)
    }

    /// Bounds a state, given those below it.
    fn bound(&mut self, state: usize, operands: &mut Vec<Image>) {
        let Self { states, boxes, images, solids, search, .. } = self;
        let (found, image) = match states.terms[state] {
            Term::Shape(shape) => {
                let aabb = solids.shapes[shape as usize].bounds();
                (StateBox { aabb, gap: 0.0 }, solids.shape(shape, aabb))
            }
            Term::Same(below) | Term::Difference([below, _]) => {
                (boxes[below as usize], images[below as usize])
            }
            Term::Map(map, below) => {
                let (map, below_box) = (&states.maps[map as usize], boxes[below as usize]);
                let image = solids.map(*map, images[below as usize]);
                let found = mapped(solids, search, image, map, below_box);
                let vanished = found.aabb.is_empty() && !below_box.aabb.is_empty();
                (found, if vanished { solids.nothing() } else { image })
            }
            Term::Union(ref parts) => {
                let parts = &states.parts[parts.start as usize..parts.end as usize];
                operands.clear();
                operands.extend(parts.iter().map(|part| images[*part as usize]));
                let found = parts.iter().map(|part| boxes[*part as usize]).fold(EMPTY, join);
                (found, solids.union(operands, found.aabb, found.gap))
            }
            Term::Intersection(operands) => {
                let [left, right] = operands.map(|operand| boxes[operand as usize]);
                let (aabb, gap) = (left.aabb.intersect(right.aabb), left.gap.max(right.gap));
                let operands = operands.map(|operand| images[operand as usize]);
                if aabb.is_empty() || are_apart(solids, search, operands, [left, right]) {
                    (EMPTY, solids.nothing())
                } else {
                    (StateBox { aabb, gap }, solids.intersection(operands, aabb, gap))
                }
            }
        };
        (boxes[state], images[state]) = (found, image);
    }

    /// The box of the root.
    pub(super) fn root(&self) -> StateBox {
        *self.boxes.last().expect("there is always the root's")
    }

    /// The box of the root, by queries as the limits allow.
    pub(super) fn refined_root(&mut self, limits: &Limits) -> StateBox {
        let root = self.root();
        if !self.search.rough {
            return root;
        }
        let image = *self.images.last().expect("there is always the root's");
        mapped(&self.solids, &mut Search::new(limits), image, &DAffine3::IDENTITY, root)
    }
}

pub(super) const EMPTY: StateBox = StateBox { aabb: Aabb::EMPTY, gap: 0.0 };

fn join(a: StateBox, b: StateBox) -> StateBox {
    StateBox { aabb: a.aabb.join(b.aabb), gap: a.gap.max(b.gap) }
}

/// The box of `image`, which is what `map` makes of a state with the box `below`.
pub(super) fn mapped<S: Shape>(
    solids: &Solids<S>,
    search: &mut Search,
    image: Image,
    map: &DAffine3,
    below: StateBox,
) -> StateBox {
    if below.aabb.is_empty() {
        return EMPTY;
    }
    let rows = map.matrix3.transpose();
    let mut gap = 0.0_f64;
    let mut face = |axis: usize, sign: f64| {
        let known = Known { below, direction: sign * rows.col(axis), offset: sign * map.translation[axis] };
        let found = support(solids, search, image, sign * DVec3::AXES[axis], &known);
        gap = gap.max(found.gap);
        found.upper
    };
    let max = DVec3::new(face(0, 1.0), face(1, 1.0), face(2, 1.0));
    let min = DVec3::ZERO - DVec3::new(face(0, -1.0), face(1, -1.0), face(2, -1.0));
    // Above an intersection, upper bounds may have passed each other.
    let aabb = Aabb::new(min, max);
    if aabb.is_empty() { EMPTY } else { StateBox { aabb, gap } }
}

/// A box that holds what a query is for, in a frame where the query has this direction and the origin this support.
pub(super) struct Known {
    pub(super) below: StateBox,
    pub(super) direction: DVec3,
    pub(super) offset: f64,
}

/// The support of an image: that of a known box, if it is certain enough, or else by a query.
pub(super) fn support<S: Shape>(
    solids: &Solids<S>,
    search: &mut Search,
    image: Image,
    direction: DVec3,
    known: &Known,
) -> Support {
    let StateBox { aabb, gap } = known.below;
    if aabb.is_empty() {
        return Support { upper: f64::NEG_INFINITY, gap: 0.0 };
    }
    let outer = aabb.support_above(known.direction, known.offset);
    if !outer.is_finite() {
        return Support { upper: outer, gap: 0.0 };
    }
    let extent = known.direction.abs().dot(aabb.size());
    let part = solids.part(image);
    let touched = solids.solid(part.solid).touched;
    let uncertain = |gap| {
        if touched {
            spread(aabb.size(), gap, known.direction).min(extent)
        } else {
            spread(DVec3::splat(aabb.size().max_element()), gap, known.direction)
        }
    };
    let error = || solids.error(&part) * direction.length() * (1.0 + 4.0 * f64::EPSILON);
    // An attractor may be as flat as its rounding errors, and no query makes those smaller.
    let least = if solids.endless { ERRORS * error() } else { 0.0 };
    let tolerance = (search.gap * extent).max(least);
    // Twice, as in a query.
    if uncertain(if search.rough { 0.0 } else { gap }) <= 2.0 * tolerance {
        return Support { upper: outer, gap: uncertain(gap) };
    }
    let error = error();
    // Where numbers overflow, a query has nothing to compare.
    if !error.is_finite() {
        return Support { upper: outer, gap: uncertain(gap) };
    }
    let Found { lower, upper } = search.support(solids, &part, direction, outer, tolerance);
    // Above an intersection, a query that reached its limit knows nothing from below.
    Support { upper: (upper + error).next_up().min(outer), gap: (upper - lower).min(uncertain(gap)) }
}
