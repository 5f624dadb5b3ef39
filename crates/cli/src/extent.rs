//! How large a solid may be, and which of its parts makes it larger, smaller or further away than that.

use std::collections::BTreeSet;
use std::mem::discriminant;
use std::ops::Range;

use csg_graph::{Fault, Graph, Operator, State, Step};
use csg_graph_bounds::{Aabb, ExactBoxes};

use crate::Failure;
use crate::load::Loaded;

/// How large a solid may be: squares of lengths have to be numbers.
const SIZES: Range<f64> = 1e-150..1e150;

/// How many times as far from the origin as it is large a solid may be, so that coordinates tell its parts apart.
const FARTHEST: f64 = 1e13;

/// Refuses a solid that is too large, too small, or too far away. It points at what is, and has no part that is as well. Where
/// there is none, recursion leads on and on to what is too large or too small; and what gets ever smaller comes to nothing.
pub(crate) fn check(loaded: &Loaded, boxes: &ExactBoxes<Graph>) -> Result<(), Failure> {
    let Some(fault) = misfit(&boxes.root) else { return Ok(()) };
    let root = loaded.scene.graph.root_state();
    Err(match (culprit(&loaded.scene.graph, boxes, &fault), &fault) {
        (Some(state), _) => loaded.failure_at(&state, fault),
        (None, Fault::TooSmall { .. }) => loaded.failure_at(&root, Fault::Nothing),
        (None, _) => loaded.failure_at(&root, fault),
    })
}

/// The first state with such a fault that is below others of them and above none.
fn culprit(graph: &Graph, boxes: &ExactBoxes<Graph>, fault: &Fault) -> Option<State> {
    let is_faulty = |state: &State| {
        let found = boxes.of(state).and_then(|found| misfit(&found.aabb));
        found.is_some_and(|found| discriminant(&found) == discriminant(fault))
    };
    let mut met = BTreeSet::new();
    let mut pending = vec![graph.root_state()];
    while let Some(state) = pending.pop() {
        if met.insert(boxes.index_of(&state)) {
            let others = pending.len();
            pending.extend(bounding(graph, &state).into_iter().rev().flatten().filter(is_faulty));
            if pending.len() == others {
                return Some(state);
            }
        }
    }
    None
}

/// What is wrong with the extent of a box, if anything is.
fn misfit(aabb: &Aabb) -> Option<Fault> {
    if aabb.is_empty() {
        return None;
    }
    let reach = aabb.min.abs().max(aabb.max.abs()).max_element();
    let (size, distance) = (aabb.size().max_element(), aabb.center().length());
    if reach >= SIZES.end {
        Some(Fault::TooLarge { reach, most: SIZES.end })
    } else if size < SIZES.start {
        Some(Fault::TooSmall { size, least: SIZES.start })
    } else if distance >= FARTHEST * size {
        Some(Fault::TooFar { sizes: distance / size, most: FARTHEST })
    } else {
        None
    }
}

/// The states below one whose boxes make its own. Of an intersection, neither does alone.
fn bounding(graph: &Graph, state: &State) -> [Option<State>; 2] {
    match graph.step(state) {
        Err(_) | Ok(Step::Operator(Operator::Intersection, _)) => [None, None],
        Ok(Step::Operator(Operator::Difference, [left, _])) => [Some(left), None],
        Ok(step) => step.into_states(),
    }
}
