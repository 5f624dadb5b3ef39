//! Where the boxes of states come from.

use csg_graph::{EvalError, Graph, State};
use csg_graph_bounds::{Aabb, BoundsError, Envelope, Envelopes, ExactBoxes};
use glam::DVec3;

/// What is known of the extent of all states.
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
    envelope: Option<Box<Envelope>>,
}

impl StateBounds {
    pub(super) fn as_ref(&self) -> Bounds<'_> {
        match self {
            Self::Exact(boxes) => Bounds::Exact(boxes),
            Self::Envelopes(envelopes) => Bounds::Envelopes(envelopes),
        }
    }
}

impl Bounds<'_> {
    pub(super) fn of(&self, state: &State) -> Result<Extent, EvalError> {
        match self {
            Self::Exact(boxes) => {
                let aabb = boxes.of(state).map_or(Aabb::EMPTY, |found| found.aabb);
                Ok(Extent { aabb, envelope: None })
            }
            Self::Envelopes(envelopes) => match envelopes.of(state) {
                Ok(envelope) => Ok(Extent { aabb: envelope.aabb(), envelope: Some(Box::new(envelope)) }),
                Err(BoundsError::Scene(error)) => Err(error),
                // It may be anywhere.
                Err(_) => Ok(Extent { aabb: Aabb::ALL, envelope: None }),
            },
        }
    }

    /// How far a state with that extent reaches in a direction, at most.
    pub(super) fn support(&self, state: &State, extent: &Extent, direction: DVec3) -> f64 {
        match (self, &extent.envelope) {
            (Self::Exact(boxes), _) => {
                boxes.support(state, direction).map_or(f64::INFINITY, |support| support.upper)
            }
            (_, Some(envelope)) => envelope.support(direction),
            (_, None) => extent.aabb.support(direction),
        }
    }

    /// The place of a state among all, if they are listed.
    pub(super) fn index_of(&self, state: &State) -> Option<u32> {
        let Self::Exact(boxes) = self else { return None };
        boxes.index_of(state).map(|index| u32::try_from(index).expect("2³² states outgrow memory"))
    }
}
