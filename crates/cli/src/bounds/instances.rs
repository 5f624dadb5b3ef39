//! The volume of a node: about all its states, each in the node's own frame.
//!
//! The hyper box of a node is the join of the boxes of its states. Spheres and oriented boxes do not join without growing,
//! so their hyper volumes are made like those of a state, from supports: that of a node is the largest of its states'.
//! States whose box shows that they do not reach as far as another one are not asked.

use csg_graph::{Graph, NodeId, State};
use csg_graph_bounds::{Aabb, ExactBoxes};
use glam::DVec3;

/// The states of each node, with their boxes.
pub(super) struct Instances<'a> {
    exact: &'a ExactBoxes<Graph>,
    of_node: Vec<Vec<(&'a State, Aabb)>>,
}

impl<'a> Instances<'a> {
    pub(super) fn new(exact: &'a ExactBoxes<Graph>) -> Self {
        let mut of_node = vec![Vec::new(); exact.nodes.len()];
        for (state, found) in exact.states() {
            of_node[state.node().index()].push((state, found.aabb));
        }
        Self { exact, of_node }
    }

    /// The support of a state.
    pub(super) fn of_state(&self, state: &State, direction: DVec3) -> f64 {
        let found = self.exact.support(state, direction);
        found.expect("the root leads to all states that are asked for").upper
    }

    /// The support of what is in any state of a node.
    pub(super) fn of_node(&self, node: NodeId, direction: DVec3) -> f64 {
        let states = &self.of_node[node.index()];
        let first = states.iter().max_by(|(_, a), (_, b)| {
            let [a, b] = [a, b].map(|aabb| reach(*aabb, direction));
            a.total_cmp(&b)
        });
        let Some((first, _)) = first else { return f64::NEG_INFINITY };
        let most = self.of_state(first, direction);
        let others = states.iter().filter(|(state, _)| !std::ptr::eq(*state, *first));
        others.fold(most, |most, (state, aabb)| {
            if reach(*aabb, direction) <= most { most } else { most.max(self.of_state(state, direction)) }
        })
    }
}

/// The support of a box, rounded up.
fn reach(aabb: Aabb, direction: DVec3) -> f64 {
    if aabb.is_empty() {
        return f64::NEG_INFINITY;
    }
    if !aabb.is_bounded() {
        return f64::INFINITY;
    }
    let magnitude = direction.abs().dot(aabb.min.abs().max(aabb.max.abs()));
    aabb.support(direction) + 4.0 * f64::EPSILON * magnitude
}
