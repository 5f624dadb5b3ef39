//! The envelopes of one seed, and the exact boxes that must lie in them.

use csg_graph::{EvalError, Graph, Operator, State, Step};
use csg_graph_bounds::{Aabb, BoundsError, Envelope, Envelopes, ExactBoxes, Limits, Slabs, StateBox, exact};
use glam::DVec3;

use super::{Failure, Tally};

/// Chance may make many more states of one seed than of another. Beyond this they are not listed.
const STATES: usize = 10_000;

/// How much further out exact supports may be than the solid, relative to its largest coordinate. They are rounded outwards.
const ROUNDING: f64 = 1e-9;

/// Compares all states of a graph with envelopes that are theirs, whatever the seed.
pub(super) fn check(graph: &Graph, envelopes: &Envelopes, seed: u64, shrink: f64) -> Result<Tally, Failure> {
    let mut tally = Tally { seeds: 1, ..Tally::default() };
    let boxes = match exact(graph, &Limits::default().with_states(STATES)) {
        Ok(boxes) => boxes,
        Err(error @ BoundsError::Scene(_)) => return Err(format!("seed {seed}: {error}").into()),
        Err(_) => {
            tally.unlisted = 1;
            return Ok(tally);
        }
    };
    let above_meets = above_meets(graph, &boxes)?;
    for ((state, found), above_meet) in boxes.states().zip(above_meets) {
        tally.states += 1;
        let (envelope, flat) = match (envelopes.of(state), envelopes.aabb(state)) {
            (Ok(envelope), Ok(flat)) if !above_meet => (envelope, flat),
            _ => {
                tally.skipped += 1;
                continue;
            }
        };
        if let Some((direction, excess)) = cut_off(&boxes, state, &found, (&envelope, flat), shrink) {
            tally.violations += 1;
            tally.told.push(format!(
                "seed {seed}: {} where {:?} reaches further than its envelope towards {direction}, by {excess:e}",
                graph.node_name(state.node()),
                graph.live_values(state),
            ));
        }
    }
    Ok(tally)
}

/// A direction in which the solid of a state reaches further than its envelope, and by how much.
fn cut_off(
    boxes: &ExactBoxes<Graph>,
    state: &State,
    found: &StateBox,
    (envelope, flat): (&Envelope, Aabb),
    shrink: f64,
) -> Option<(DVec3, f64)> {
    let exact = found.aabb;
    if exact.is_empty() {
        return None;
    }
    let coordinates = [exact.min.to_array(), exact.max.to_array()].into_iter().flatten();
    let size = coordinates.filter(|x| x.is_finite()).fold(0.0, |size: f64, x| size.max(x.abs()));
    let Slabs { mut min, mut max } = *envelope.slabs();
    // The box may be asked for by itself.
    for axis in 0..3 {
        min[axis] = min[axis].max(flat.min[axis]);
        max[axis] = max[axis].min(flat.max[axis]);
    }
    let planes = Slabs::<13>::DIRECTIONS.into_iter().enumerate().flat_map(|(i, direction)| {
        let inwards = shrink * (max[i] - min[i]);
        [(direction, max[i] - inwards), (-direction, -min[i] - inwards)]
    });
    for (direction, plane) in planes {
        let length = direction.length();
        let plane = plane.min(envelope.radius() * length);
        let margin = ROUNDING * size * length;
        // In most directions a corner of the box says it. The box reaches no less than the solid, along the axes as far.
        let corner = exact.support(direction);
        if corner <= plane + margin {
            continue;
        }
        let along_axis = direction.abs().element_sum() <= 1.0;
        let (reach, gap) = match boxes.support(state, direction) {
            Some(support) if !along_axis => (support.upper, support.gap),
            _ => (corner, found.gap),
        };
        let excess = reach - gap - plane;
        if excess > margin {
            return Some((direction, excess));
        }
    }
    None
}

/// Which states have an intersection below them that decides how far they reach. Its exact box is that of no solid, but of
/// what the boxes of both operands have in common, and need not lie in the envelope.
fn above_meets(graph: &Graph, boxes: &ExactBoxes<Graph>) -> Result<Vec<bool>, EvalError> {
    let mut above: Vec<bool> = Vec::with_capacity(boxes.counts.states);
    // Each state comes after those below it.
    for (state, _) in boxes.states() {
        let is_above = match graph.step(state)? {
            Step::Operator(Operator::Intersection, _) => true,
            Step::Operator(Operator::Difference, [left, _]) => reaches(&above, boxes, &left),
            step => step.into_states().iter().flatten().any(|below| reaches(&above, boxes, below)),
        };
        above.push(is_above);
    }
    Ok(above)
}

fn reaches(above: &[bool], boxes: &ExactBoxes<Graph>, below: &State) -> bool {
    // A state that leads back to itself may come before what is below it, and is taken for the worse.
    boxes.index_of(below).and_then(|index| above.get(index)).is_none_or(|above| *above)
}
