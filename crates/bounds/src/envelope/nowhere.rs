//! Recursion that certainly leads to nothing, although its states are too many to be listed.
//!
//! Whatever way the numbers take, the keys have it. So a cycle of keys without any way out of it, and with one way round
//! only, is what all states of these keys are on, for ever. Whether the root leads there is another question, since keys
//! also have ways that no number takes: states are looked at as they are, in the order of their distance from the root.

use std::collections::VecDeque;

use csg_graph::{Node, State};
use rustc_hash::FxHashSet;

use super::Envelopes;
use crate::exact::Components;

impl Envelopes {
    /// A state that leads on and on along a single way, as [`ExactBoxes::leads_nowhere`](crate::ExactBoxes::leads_nowhere)
    /// finds, if there is one among the first so many states that the root leads to.
    ///
    /// # Cost
    /// Some microseconds for each of these states, where there is such a way at all.
    pub fn leads_nowhere(&self, limit: usize) -> Option<State> {
        let keys = &self.keys;
        let mut nowhere = vec![false; keys.len()];
        let components = Components::new(keys.len(), |key| keys.parts(key));
        for key in components.single_ways(|key| keys.parts(key)).flatten() {
            nowhere[*key as usize] = true;
        }
        if !nowhere.contains(&true) {
            return None;
        }
        let root = self.graph.root_state();
        let (mut met, mut open) = (FxHashSet::from_iter([root.clone()]), VecDeque::from([root]));
        while let Some(state) = open.pop_front() {
            let is_symbol = matches!(self.graph.node(state.node()), Node::Symbol(_));
            if is_symbol && keys.number(&state).is_some_and(|key| nowhere[key as usize]) {
                return Some(state);
            }
            // What cannot be evaluated is a mistake of its own, which is told of where it matters.
            let Ok(step) = self.graph.step(&state) else { continue };
            for below in step.into_states().into_iter().flatten() {
                if met.len() < limit && met.insert(below.clone()) {
                    open.push_back(below);
                }
            }
        }
        None
    }
}
