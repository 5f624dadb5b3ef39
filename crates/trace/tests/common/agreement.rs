//! When an engine agrees with the walk.

use csg_graph_trace::Hit;

/// Where boundaries are closer than this, chance decides which of them is hit.
pub(crate) const CLEARANCE: f64 = 1e-4;

/// Whether an engine has the hit of the walk.
pub(crate) fn agree(walk: Option<&Hit>, engine: Option<&Hit>) -> bool {
    match (walk, engine) {
        (None, None) => true,
        (Some(walk), Some(engine)) => {
            (walk.t - engine.t).abs() <= 1e-9 * walk.t
                && walk.normal.distance(engine.normal) < 1e-7
                && (walk.node, walk.depth, walk.surface) == (engine.node, engine.depth, engine.surface)
        }
        _ => false,
    }
}
