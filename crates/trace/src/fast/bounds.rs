//! Where the boxes of states come from.

use std::cell::OnceCell;

use csg_graph::{EvalError, Graph, Primitive, State};
use csg_graph_bounds::{Aabb, BoundsError, Envelope, Envelopes, ExactBoxes, Shape};
use glam::{DAffine3, DVec3};

use super::slabs::{DIAGONALS, Reach};

/// What is known of the extent of all states.
#[derive(Debug)]
pub enum StateBounds {
    /// The exact boxes of states that are all listed.
    Exact(Box<ExactBoxes<Graph>>),
    /// Envelopes of states that nobody lists.
    Envelopes(Box<Envelopes>),
}

/// What is known of the extent of all states, for who looks at it.
#[derive(Clone, Copy)]
pub(crate) enum Bounds<'a> {
    Exact(&'a ExactBoxes<Graph>),
    Envelopes(&'a Envelopes),
}

/// What is known of the extent of one.
pub(crate) struct Extent {
    pub(crate) aabb: Aabb,
    /// Once somebody has asked for more than the box; none if it may be anywhere.
    envelope: OnceCell<Option<Box<Envelope>>>,
}

/// Of states by chance, so many stand for all that have the same class: what chance has made of them.
const TYPICAL: [f64; 2] = [0.359, 0.618];

/// The gap of supports along diagonals, relative to the extent. They are more than those of boxes, and take most of the time
/// before the first ray; rays would hardly be faster for closer ones.
const SLAB_GAP: f64 = 2e-2;

impl StateBounds {
    /// What a state has in common with others that look alike from afar: if states are listed, it is alone; by chance,
    /// it is one of all those with the same envelope.
    pub(super) fn class(&self, state: &State) -> Option<u32> {
        match self {
            Self::Exact(_) => self.as_ref().index_of(state),
            Self::Envelopes(envelopes) => envelopes.class(state),
        }
    }

    /// How many classes there are, at most.
    pub(super) fn class_count(&self) -> usize {
        match self {
            Self::Exact(boxes) => boxes.states().len(),
            Self::Envelopes(envelopes) => envelopes.key_count(),
        }
    }

    /// States that stand for all of the class of one.
    pub(super) fn typical(&self, state: &State) -> Vec<State> {
        match self {
            Self::Exact(_) => vec![state.clone()],
            Self::Envelopes(envelopes) => TYPICAL.map(|chance| envelopes.typical(state, chance)).into(),
        }
    }

    pub(super) fn as_ref(&self) -> Bounds<'_> {
        match self {
            Self::Exact(boxes) => Bounds::Exact(boxes),
            Self::Envelopes(envelopes) => Bounds::Envelopes(envelopes),
        }
    }
}

impl Bounds<'_> {
    /// How large the smallest part is that has parts in it, by the whole. 0 if nobody lists them.
    pub(super) fn finest(&self) -> f64 {
        match self {
            Self::Exact(boxes) => boxes.finest(),
            Self::Envelopes(_) => 0.0,
        }
    }

    pub(super) fn of(&self, state: &State) -> Result<Extent, EvalError> {
        let aabb = match self {
            Self::Exact(boxes) => boxes.of(state).map_or(Aabb::ALL, |found| found.aabb),
            Self::Envelopes(envelopes) => match envelopes.aabb(state) {
                Ok(aabb) => aabb,
                Err(BoundsError::Scene(error)) => return Err(error),
                // It may be anywhere.
                Err(_) => Aabb::ALL,
            },
        };
        Ok(Extent { aabb, envelope: OnceCell::new() })
    }

    /// How far a state with that extent reaches in a direction, at most, by a query that may end at some gap if one is given.
    fn support(&self, state: &State, extent: &Extent, direction: DVec3, gap: Option<f64>) -> f64 {
        let along_axis = direction.abs().element_sum() <= direction.abs().max_element();
        match self {
            Self::Exact(boxes) => {
                let found = match gap {
                    Some(gap) => boxes.support_within(state, direction, gap),
                    None => boxes.support(state, direction),
                };
                found.map_or(f64::INFINITY, |support| support.upper)
            }
            Self::Envelopes(_) if along_axis => extent.aabb.support(direction),
            Self::Envelopes(envelopes) => {
                let envelope = extent.envelope.get_or_init(|| envelopes.of(state).ok().map(Box::new));
                envelope.as_ref().map_or(f64::INFINITY, |envelope| envelope.support(direction))
            }
        }
    }

    /// The box of a state with that extent, of which the primitive is known if it is one, in the frame above: six supports,
    /// not the box of a box.
    pub(super) fn image(
        &self,
        state: &State,
        extent: &Extent,
        primitive: Option<&Primitive>,
        above_from_state: &DAffine3,
    ) -> Aabb {
        if extent.aabb.is_empty() {
            return Aabb::EMPTY;
        }
        let outer = extent.aabb.image(above_from_state);
        let reach =
            |direction| self.image_support(state, extent, primitive, above_from_state, direction, None);
        let mut exact = outer;
        for (axis, direction) in DVec3::AXES.into_iter().enumerate() {
            exact.max[axis] = reach(direction).min(outer.max[axis]);
            exact.min[axis] = -reach(-direction).min(-outer.min[axis]);
        }
        exact
    }

    /// How far the same reaches along the diagonals.
    pub(super) fn slabs(
        &self,
        state: &State,
        extent: &Extent,
        primitive: Option<&Primitive>,
        above_from_state: &DAffine3,
    ) -> Reach {
        let reach = |direction| {
            self.image_support(state, extent, primitive, above_from_state, direction, Some(SLAB_GAP))
        };
        Reach { least: DIAGONALS.map(|diagonal| -reach(-diagonal)), most: DIAGONALS.map(reach) }
    }

    /// The support of an image.
    fn image_support(
        &self,
        state: &State,
        extent: &Extent,
        primitive: Option<&Primitive>,
        above_from_state: &DAffine3,
        direction: DVec3,
        gap: Option<f64>,
    ) -> f64 {
        let offset = above_from_state.translation.dot(direction);
        let direction_in_state = above_from_state.matrix3.transpose() * direction;
        let support = match primitive {
            Some(primitive) => primitive.support(direction_in_state),
            None => self.support(state, extent, direction_in_state, gap),
        };
        // Well within the padding of trees, and more than is rounded here.
        let reach = offset + support + (offset.abs() + support.abs()) * 1e-14;
        if reach.is_nan() { f64::INFINITY } else { reach }
    }

    /// Whether what is known of a state is common to all that differ by chance alone. It has been known before then; where
    /// the values of parameters count, as the heights of a terrain, it is close, and took longer to find.
    pub(super) fn are_common(&self, state: &State) -> bool {
        match self {
            Self::Exact(_) => false,
            Self::Envelopes(envelopes) => envelopes.is_common(state),
        }
    }

    /// The place of a state among all, if they are listed.
    pub(super) fn index_of(&self, state: &State) -> Option<u32> {
        let Self::Exact(boxes) = self else { return None };
        boxes.index_of(state).map(|index| u32::try_from(index).expect("2³² states outgrow memory"))
    }
}
