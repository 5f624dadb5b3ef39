//! Envelopes: that nothing is outside of them, that they are pure, and how tight they are.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "common/chance.rs"]
mod chance;
mod common;

use chance::{stochastic_sierpinski, terrain, tree};
use csg_graph::Graph;
use csg_graph_bounds::{Envelopes, Limits, Slabs};

/// What the tests' own arithmetic may err.
const TOLERANCE: f64 = 1e-11;

/// Unfolds the graph and looks for points outside of the envelopes of the states that they are below.
fn assert_sound(graph: &Graph) {
    let envelopes = Envelopes::new(graph.clone(), &Limits::default());
    let tree = common::unfold(graph, &graph.root_state());
    tree.sample(&mut |state, point| {
        let envelope = envelopes.of(state).unwrap();
        let slabs = envelope.slabs();
        let size = TOLERANCE * (1.0 + point.abs().max_element());
        for (i, d) in Slabs::<13>::DIRECTIONS.into_iter().enumerate() {
            let at = d.dot(point);
            assert!(
                at <= slabs.max[i] + size && at >= slabs.min[i] - size,
                "{point} in {:?} {:?} {d} {slabs:?}",
                graph.node_name(state.node()),
                graph.live_values(state),
            );
        }
    });
}

#[test]
fn nothing_is_outside() {
    for seed in 0..3 {
        assert_sound(&tree(seed, 5));
        assert_sound(&terrain(seed, 3, 0.3));
        assert_sound(&stochastic_sierpinski(seed, 3));
    }
}
