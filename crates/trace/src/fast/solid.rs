//! The results of ∩ and \\ inside of super-nodes.

use csg_graph::State;

use crate::{Counters, Hit, Ray, Surface, Walk};

/// Asks the reference walk about solids that are more than unions.
#[derive(Debug)]
pub(super) struct Solids<'a> {
    walk: Walk<'a>,
}

impl<'a> Solids<'a> {
    pub(super) fn new(walk: Walk<'a>) -> Self {
        Self { walk }
    }

    /// The first boundary of a state's solid on a ray in its frame, not behind `end`.
    pub(super) fn first(&mut self, state: &State, ray: &Ray, end: f64) -> Option<f64> {
        self.hit(state, ray, end, Surface::default()).map(|hit| hit.t)
    }

    /// The same with all that is known of it, in the frame of the state, which has a surface.
    pub(super) fn hit(&mut self, state: &State, ray: &Ray, end: f64, surface: Surface) -> Option<Hit> {
        let hit = self.walk.nearest_below(state, ray, end.next_up(), surface);
        hit.expect("all states were evaluated when they were bounded")
    }

    pub(super) fn take_counters(&mut self) -> Counters {
        self.walk.take_counters()
    }
}
