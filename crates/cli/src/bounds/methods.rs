//! Running the algorithms: what each would cost is known before it is begun.

use csg_graph::{Analysis, BigUint, EvalError, Fault, Graph};
use csg_graph_bounds::{BoundsError, ExactBoxes, HyperBoxes, Limits, chain, conventional, exact};

use crate::Failure;
use crate::args::MethodArg;
use crate::load::Loaded;
use crate::progress::Spinner;
use crate::text::short;

/// Steps of an algorithm that take longer than one waits without a sign of life: a second or so.
const LONG: u32 = 3_000_000;

/// Refuses work that is known to be too much, before it is begun.
pub(crate) fn refuse_more_than(
    max_steps: u64,
    work: &BigUint,
    loaded: &Loaded,
    what: &str,
) -> Result<(), Failure> {
    if *work <= BigUint::from(max_steps) {
        return Ok(());
    }
    let shown = short(work);
    Err(loaded.refused(format!(
        "{what}: {shown} steps, and --max-steps allows {max_steps}; use the exact boxes, let the recursion end earlier, \
         or raise --max-steps"
    )))
}

/// The boxes that an algorithm computes: known beforehand for those that walk the unfolded tree, and for the exact one
/// the states.
pub(super) fn boxes_to_compute(method: MethodArg, analysis: &Analysis) -> BigUint {
    match method {
        MethodArg::Conventional => analysis.instances.clone(),
        MethodArg::Chain => analysis.chain_boxes.clone(),
        MethodArg::Exact => analysis.node_states.into(),
    }
}

/// The hyper boxes of a scene by one of the algorithms.
pub(crate) fn hyper_boxes(
    method: MethodArg,
    loaded: &Loaded,
    analysis: &Analysis,
    max_steps: u64,
) -> Result<HyperBoxes, Failure> {
    let graph = &loaded.scene.graph;
    // The work is known beforehand; the algorithms need not count it once more.
    let limits = loaded.bounds_limits().with_steps(u64::MAX);
    let work = boxes_to_compute(method, analysis);
    let what = match method {
        MethodArg::Conventional => "the conventional algorithm visits every node of the unfolded tree",
        MethodArg::Chain => "the chain algorithm computes a box for each transformation above each primitive",
        MethodArg::Exact => {
            return exact_boxes(loaded, &limits).map(ExactBoxes::into_hyper_boxes);
        }
    };
    refuse_more_than(max_steps, &work, loaded, what)?;
    let _spinner = (work > BigUint::from(LONG)).then(|| Spinner::new("bounding"));
    let walk = if method == MethodArg::Conventional { conventional } else { chain };
    walk(graph, &limits).map_err(|error| failure(loaded, error))
}

/// The boxes of all states of a scene. A recursion that leads to nothing is a mistake in it.
pub(crate) fn exact_boxes(loaded: &Loaded, limits: &Limits) -> Result<ExactBoxes<Graph>, Failure> {
    let graph = &loaded.scene.graph;
    let boxes = exact(graph, limits).map_err(|error| failure(loaded, error))?;
    match boxes.leads_nowhere() {
        Some(state) => Err(loaded.failure_at(state, Fault::Nothing)),
        None => Ok(boxes),
    }
}

/// The same of a recursion that never ends, with how much it shrinks by once round. What is subtracted has to shrink as well:
/// the boxes do not depend on it, but there would be no solid.
pub(crate) fn endless_boxes(loaded: &Loaded, limits: &Limits) -> Result<(ExactBoxes<Graph>, f64), Failure> {
    let boxes = exact_boxes(loaded, limits)?;
    let contraction = boxes.shrinks(&loaded.scene.graph).map_err(|error| failure(loaded, error))?;
    Ok((boxes, contraction))
}

/// Why an algorithm found no boxes.
pub(crate) fn failure(loaded: &Loaded, error: BoundsError<EvalError>) -> Failure {
    match error {
        BoundsError::Scene(error) => loaded.failure(&error.into()),
        BoundsError::Endless { .. } => {
            loaded.report_unlisted();
            loaded.refused(error)
        }
        BoundsError::TooManyStates { limit } => {
            loaded.refused(format!("there are more than {limit} states; raise --max-states"))
        }
        error => loaded.refused(error),
    }
}
