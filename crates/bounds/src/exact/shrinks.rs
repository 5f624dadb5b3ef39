//! Whether what never ends shrinks whichever way is taken: also through what is subtracted.
//!
//! The box of a difference is that of its left operand, and that of an intersection no larger than what it has in common
//! with operands from outside of the recursion. So a solid may be bounded though it subtracts itself unchanged. But who
//! looks into it, as a ray does, goes through all operands, and comes to an end only if each of them gets smaller until it
//! is too small to matter. The [certificate](super::contraction) is the same, with all operands for parts.
//!
//! What shrinks may still be nothing: of `A -> uscale(0.5) A` a point is left.

use glam::DMat3;

use super::ExactBoxes;
use super::components::Components;
use super::contraction::{Contraction, Edge};
use super::states::Term;
use crate::limits::Round;
use crate::{BoundsError, Scene};

impl<S: Scene> ExactBoxes<S> {
    /// Proves of a scene with these boxes that whoever goes down in it comes to ever smaller parts, or to an end: through
    /// unions, and through all operands of ∩ and \\. Gives at most how much is left of distances once round any cycle of
    /// states, in suitable norms: less than 1, and 0 if all recursion ends.
    ///
    /// # Cost
    /// Where recursion never ends, some hundred passes over the states that lead back to themselves.
    ///
    /// # Errors
    /// If a state is below itself and not known to be smaller there, or is unbounded.
    pub fn shrinks(&self, scene: &S) -> Result<f64, BoundsError<S::Error>> {
        let states = &self.found.states;
        if !states.cyclic {
            return Ok(0.0);
        }
        let mut most = 0.0_f64;
        for component in Components::new(states.terms.len(), |state| states.operands(state)).iter() {
            let edges = self.ways(component);
            if edges.is_empty() {
                continue;
            }
            if let Some(unbounded) = component.iter().find(|state| self.is_unbounded(**state)) {
                return Err(states.endless(scene, vec![*unbounded], Round::Infinite));
            }
            let contraction = Contraction::new(component.len(), edges).map_err(|failure| {
                let cycle = failure.cycle.iter().map(|edge| component[edge.above]);
                states.endless(scene, cycle.collect(), failure.round)
            })?;
            most = most.max(contraction.factor);
        }
        Ok(most)
    }

    /// A state that leads on and on along a single way, if there is any: to no shape, and to no union of different ways. A
    /// point is left of it, which no ray can meet; where there are several ways, as in the attractors of iterated function
    /// systems, it is a solid without any shape.
    pub fn leads_nowhere(&self) -> Option<&S::State> {
        let states = &self.found.states;
        if !states.cyclic {
            return None;
        }
        let components = Components::new(states.terms.len(), |state| states.below(state));
        let cycle = components.single_ways(|state| states.below(state)).next()?;
        // The search came first to the one that it left last.
        cycle.last().map(|state| &states.states[*state as usize])
    }

    /// The ways from states of a component to states of it.
    fn ways(&self, component: &[u32]) -> Vec<Edge> {
        let states = &self.found.states;
        let mut edges = Vec::new();
        for (above, state) in component.iter().enumerate() {
            let (map, offset) = match states.terms[*state as usize] {
                Term::Map(map, _) => {
                    let map = &states.maps[map as usize];
                    (map.matrix3, map.translation.length())
                }
                _ => (DMat3::IDENTITY, 0.0),
            };
            let inside =
                states.operands(*state).iter().filter_map(|below| component.binary_search(below).ok());
            edges.extend(inside.map(|below| Edge { above, below, map, offset, drift: 0.0, state: *state }));
        }
        edges
    }

    fn is_unbounded(&self, state: u32) -> bool {
        let aabb = self.found.boxes[state as usize].aabb;
        !aabb.is_empty() && !aabb.is_bounded()
    }
}
