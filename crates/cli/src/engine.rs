//! Engines made ready: boxes computed, states compiled, and what that took.

use std::time::{Duration, Instant};

use csg_graph::{Analysis, BigUint, Graph};
use csg_graph_bounds::{Aabb, ExactBoxes, HyperBoxes, Limits};
use csg_graph_trace::{Accelerated, Engine, Grid, StateBounds};

use crate::args::{BoxesArg, EngineArg, MethodArg, Plan};
use crate::load::Loaded;
use crate::regime::{Limit, Regime};
use crate::{Failure, bounds, extent, say};

/// The most boxes that the chain algorithm may compute where nobody asked for it: a second or two.
const AFFORDABLE_CHAIN: u32 = 2_000_000;

/// How much larger than the least ones the boxes of the fast engine and the grid may be, relative to their extent. Rays hardly notice
/// a hundredth, and it takes a third of the time of the least ones.
const GAP: f64 = 1e-2;

/// An engine, ready.
pub(crate) struct Prepared<'a> {
    structure: Structure<'a>,
    /// Which boxes rays are tested against.
    pub(crate) method: Option<MethodArg>,
    /// What their computation took.
    pub(crate) bounding_time: Duration,
    /// What everything took.
    pub(crate) setup_time: Duration,
    loaded: &'a Loaded,
}

enum Structure<'a> {
    Walked(Option<HyperBoxes>),
    Compiled(Box<Accelerated>),
    Gridded(Box<Grid<'a>>),
}

/// A structure, which boxes it has, and what their computation took.
type Made<'a> = (Structure<'a>, Option<MethodArg>, Duration);

impl<'a> Prepared<'a> {
    /// Makes an engine ready.
    pub(crate) fn new(loaded: &'a Loaded, regime: &Regime, plan: Plan) -> Result<Self, Failure> {
        let start = Instant::now();
        let (structure, method, bounding_time) = match (plan, regime) {
            (Plan::Reference { boxes, max_steps }, Regime::Finite(analysis)) => {
                walked(loaded, analysis, boxes, max_steps)
            }
            (Plan::Fast { budget, detail, .. }, Regime::Finite(_)) => compiled(loaded, budget, detail),
            (Plan::Fast { detail, memory, .. }, Regime::Vast(limit)) => vast(loaded, *limit, detail, memory),
            (Plan::Fast { detail, memory, .. }, Regime::Endless) => endless(loaded, detail, memory),
            (Plan::Grid { resolution, budget }, Regime::Finite(_)) => gridded(loaded, resolution, budget),
            (Plan::Reference { .. } | Plan::Grid { .. }, Regime::Vast(limit)) => {
                let Limit { states, option } = limit;
                Err(loaded.refused(format!(
                    "it has more than {states} states, and only the fast engine can trace what cannot be listed; raise {option} if there is an end to them"
                )))
            }
            (Plan::Reference { .. } | Plan::Grid { .. }, Regime::Endless) => {
                loaded.report_unlisted();
                Err(loaded.refused(
                    "only the fast engine can trace what never ends: it does not look into what is too small to be seen",
                ))
            }
        }?;
        Ok(Self { structure, method, bounding_time, setup_time: start.elapsed(), loaded })
    }

    /// What rays are given to.
    pub(crate) fn engine(&self) -> Engine<'_> {
        match &self.structure {
            Structure::Walked(boxes) => Engine::Reference(&self.loaded.scene.graph, boxes.as_ref()),
            Structure::Compiled(compiled) => Engine::Fast(compiled),
            Structure::Gridded(grid) => Engine::Grid(grid),
        }
    }

    /// Which one it is.
    pub(crate) fn kind(&self) -> EngineArg {
        match self.structure {
            Structure::Walked(_) => EngineArg::Reference,
            Structure::Compiled(_) => EngineArg::Fast,
            Structure::Gridded(_) => EngineArg::Grid,
        }
    }

    /// The memory that it takes besides the graph.
    pub(crate) fn bytes(&self) -> usize {
        match &self.structure {
            Structure::Walked(boxes) => {
                boxes.as_ref().map_or(0, |boxes| boxes.nodes.len() * size_of::<Aabb>())
            }
            Structure::Compiled(compiled) => compiled.bytes(),
            Structure::Gridded(grid) => grid.bytes(),
        }
    }
}

fn walked(
    loaded: &Loaded,
    analysis: &Analysis,
    boxes: Option<BoxesArg>,
    max_steps: u64,
) -> Result<Made<'static>, Failure> {
    let start = Instant::now();
    let method = boxes.map_or_else(|| Some(usual_method(analysis)), BoxesArg::method);
    let boxes = hyper_boxes(loaded, analysis, method, max_steps)?;
    Ok((Structure::Walked(boxes), method, start.elapsed()))
}

fn compiled(loaded: &Loaded, budget: usize, detail: Option<f64>) -> Result<Made<'static>, Failure> {
    let start = Instant::now();
    let boxes = exact_boxes(loaded)?;
    if let Some(note) = too_fine(&boxes) {
        say(format_args!("\x1b[1;96mnote\x1b[0m: {}: {note}", loaded.name));
    }
    let bounding_time = start.elapsed();
    let compiled = Accelerated::new(&loaded.scene.graph, &boxes, budget)
        .map_err(|error| loaded.failure(&error.into()))?;
    let compiled = match detail {
        Some(pixels) => compiled.with_detail(pixels),
        None => compiled,
    };
    Ok((Structure::Compiled(Box::new(compiled)), Some(MethodArg::Exact), bounding_time))
}

fn gridded(loaded: &Loaded, resolution: Option<u32>, budget: usize) -> Result<Made<'_>, Failure> {
    let start = Instant::now();
    let boxes = exact_boxes(loaded)?;
    refuse_too_fine(loaded, &boxes)?;
    let bounding_time = start.elapsed();
    let grid = Grid::new(&loaded.scene.graph, boxes, resolution, budget)
        .map_err(|error| loaded.failure(&error.into()))?;
    Ok((Structure::Gridded(Box::new(grid)), Some(MethodArg::Exact), bounding_time))
}

fn vast(loaded: &Loaded, limit: Limit, detail: Option<f64>, memory: usize) -> Result<Made<'static>, Failure> {
    /// Envelopes are about twice as large as what is in them.
    const DETAIL: f64 = 1.0;
    let start = Instant::now();
    let envelopes = loaded.envelopes(limit.option)?;
    let memory = memory.saturating_sub(envelopes.bytes());
    let bounds = StateBounds::Envelopes(Box::new(envelopes));
    on_demand(loaded, bounds, detail.unwrap_or(DETAIL), memory, start.elapsed())
}

fn endless(loaded: &Loaded, detail: Option<f64>, memory: usize) -> Result<Made<'static>, Failure> {
    const DETAIL: f64 = 0.5;
    if detail == Some(0.0) {
        return Err(loaded.refused(
            "there is no end to what --detail 0 looks into, as the recursion never ends; give it some part of a pixel",
        ));
    }
    let start = Instant::now();
    let (boxes, _) = bounds::endless_boxes(loaded, &limits(loaded))?;
    extent::check(loaded, &boxes)?;
    let bounds = StateBounds::Exact(Box::new(boxes));
    on_demand(loaded, bounds, detail.unwrap_or(DETAIL), memory, start.elapsed())
}

/// What is compiled when rays come to it.
fn on_demand(
    loaded: &Loaded,
    bounds: StateBounds,
    detail: f64,
    memory: usize,
    bounding_time: Duration,
) -> Result<Made<'static>, Failure> {
    let compiled = Accelerated::on_demand(loaded.scene.graph.clone(), bounds, memory)
        .map_err(|error| loaded.failure(&error.into()))?
        .with_detail(detail);
    Ok((Structure::Compiled(Box::new(compiled)), Some(MethodArg::Exact), bounding_time))
}

/// The boxes of all states, of a solid that can be seen.
pub(crate) fn exact_boxes(loaded: &Loaded) -> Result<ExactBoxes<Graph>, Failure> {
    let boxes = bounds::exact_boxes(loaded, &limits(loaded))?;
    extent::check(loaded, &boxes)?;
    Ok(boxes)
}

fn limits(loaded: &Loaded) -> Limits {
    loaded.bounds_limits().with_gap(GAP)
}

/// What there is to say of a solid with parts too small for coordinates to tell apart, which rays would unfold.
fn too_fine(boxes: &ExactBoxes<Graph>) -> Option<String> {
    let (finest, limit) = (boxes.finest(), Accelerated::FINEST);
    (finest < limit).then(|| {
        format!(
            "it has parts of {finest:.0e} of its size, too small for coordinates to tell them apart; the fast engine looks into nothing smaller than {limit:.0e} of the whole"
        )
    })
}

/// Refuses that for engines that look into everything.
fn refuse_too_fine(loaded: &Loaded, boxes: &ExactBoxes<Graph>) -> Result<(), Failure> {
    too_fine(boxes).map_or(Ok(()), |reason| Err(loaded.refused(reason)))
}

/// The boxes of the reference walk, if it has any.
fn hyper_boxes(
    loaded: &Loaded,
    analysis: &Analysis,
    method: Option<MethodArg>,
    max_steps: u64,
) -> Result<Option<HyperBoxes>, Failure> {
    let Some(method) = method else {
        let what = "without boxes, every ray visits every node of the unfolded tree";
        bounds::refuse_more_than(max_steps, &analysis.instances, loaded, what)?;
        return Ok(None);
    };
    // The rough ones are enough to tell how fine it is, and quickly found.
    refuse_too_fine(loaded, &exact_boxes(loaded)?)?;
    bounds::hyper_boxes(method, loaded, analysis, max_steps).map(Some)
}

/// The paper's algorithm where its work is small beside that of a picture.
fn usual_method(analysis: &Analysis) -> MethodArg {
    if analysis.chain_boxes <= BigUint::from(AFFORDABLE_CHAIN) { MethodArg::Chain } else { MethodArg::Exact }
}
