//! A state after one expansion: its largest parts opened, until there are so many, and a box about their envelopes.
//!
//! That is what a renderer has when it looks at a frontier state for the first time.

use csg_graph::{EvalError, Graph, Operator, State, Step};
use csg_graph_bounds::{Aabb, BoundsError, Envelopes, Volume};
use glam::DAffine3;

/// What an expansion gives.
pub(crate) struct Expansion {
    /// A box about the envelopes of all parts, in the frame of the state.
    pub(crate) bounds: Aabb,
    /// Whether parts are left that could be opened.
    pub(crate) open: bool,
}

/// A part of the state that could be opened.
struct Part {
    bounds: Aabb,
    state_from_part: DAffine3,
    state: State,
}

/// Opens the largest parts of a state until there are so many, or until only primitives and what is below ∩ and \ are left.
pub(crate) fn expand(
    graph: &Graph,
    envelopes: &Envelopes,
    state: &State,
    parts: usize,
) -> Result<Expansion, BoundsError<EvalError>> {
    let part = |state_from_part: DAffine3, state: State| {
        let envelope = envelopes.of(&state)?;
        let DAffine3 { matrix3, translation } = state_from_part;
        let support = |d| envelope.support(matrix3.transpose() * d) + translation.dot(d);
        Ok(Part { bounds: Aabb::from_support(support), state_from_part, state })
    };
    let mut open = vec![part(DAffine3::IDENTITY, state.clone())?];
    let mut done = Aabb::EMPTY;
    while open.len() < parts {
        let area = |index: &usize| open[*index].bounds.surface_area();
        let Some(largest) = (0..open.len()).max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
        let Part { mut state_from_part, mut state, .. } = open.swap_remove(largest);
        loop {
            match graph.step(&state).map_err(BoundsError::Scene)? {
                Step::Transform(part_from_below, below) => {
                    state_from_part *= part_from_below.to_affine();
                    state = below;
                }
                Step::Select(below) | Step::Calculate(below) | Step::Attribute(_, below) => state = below,
                Step::Operator(Operator::Union, operands) => {
                    for operand in operands {
                        open.push(part(state_from_part, operand)?);
                    }
                    break;
                }
                _ => {
                    done = done.join(part(state_from_part, state)?.bounds);
                    break;
                }
            }
        }
    }
    let bounds = open.iter().fold(done, |all, part| all.join(part.bounds));
    Ok(Expansion { bounds, open: !open.is_empty() })
}
