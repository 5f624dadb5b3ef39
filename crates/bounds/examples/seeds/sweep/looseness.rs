//! By how much envelopes are too large: medians over states that a renderer may find at its frontier.
//!
//! These are symbols with more below them than one expansion sees. Of smaller ones, an expansion leaves nothing to be
//! bounded. Of each seed, some are looked at, evenly from all that there are.

use std::ops::Range;

use csg_graph::{Graph, Node};
use csg_graph_bounds::{Envelopes, Limits, exact};
use rayon::prelude::*;

use super::expansion::expand;
use super::{Failure, Reduced, each};

/// The parts of one expansion.
const PARTS: usize = 100;

/// How many symbols of a seed are looked at.
const SYMBOLS: usize = 32;

/// How large two boxes are, one about the envelope of a state and one about those of its parts after an expansion:
/// surface areas, in relation to the exact box.
type Ratios = [f64; 2];

/// The medians over all seeds, of the surface areas of the envelopes' boxes in relation to the exact ones: directly, and
/// after one expansion. `None` if no symbol has so much below it.
pub(crate) fn looseness(scene: &Reduced, seeds: Range<u64>) -> Result<[Option<f64>; 2], Failure> {
    let found: Result<Vec<Vec<Ratios>>, Failure> =
        each(scene, seeds, |_, graph, envelopes| ratios(graph, envelopes)).collect();
    let found = found?.concat();
    Ok([0, 1].map(|which| {
        let mut ratios: Vec<f64> = found.iter().map(|ratios| ratios[which]).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied()
    }))
}

fn ratios(graph: &Graph, envelopes: &Envelopes) -> Result<Vec<Ratios>, Failure> {
    let boxes = exact(graph, &Limits::default())?;
    let symbols: Vec<_> =
        boxes.states().filter(|(state, _)| matches!(graph.node(state.node()), Node::Symbol(_))).collect();
    let mut found = Vec::new();
    for (state, exact) in symbols.iter().rev().step_by(symbols.len().div_ceil(SYMBOLS)) {
        let least = exact.aabb.surface_area();
        let expansion = expand(graph, envelopes, state, PARTS)?;
        if expansion.open && least > 0.0 && least.is_finite() {
            let areas = [envelopes.of(state)?.aabb(), expansion.bounds].map(|bounds| bounds.surface_area());
            found.push(areas.map(|area| area / least));
        }
    }
    Ok(found)
}
