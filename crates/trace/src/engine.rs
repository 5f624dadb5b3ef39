//! What finds hits for a picture: the reference walk, the fast engine or the grid, asked for several rays at a time.

use csg_graph::{EvalError, Graph, Limits, Node, State, StatesError};
use csg_graph_bounds::HyperBoxes;
use rustc_hash::FxHashMap;

use crate::fast::{self, Accelerated};
use crate::{Batch, Counters, Footprint, Grid, GridTracer, Hit, Ray, Walk};

/// What finds hits for a picture.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Engine<'a> {
    /// The walk over a graph, with its hyper boxes, or without any.
    Reference(&'a Graph, Option<&'a HyperBoxes>),
    /// The graph compiled. It has the same hits.
    Fast(&'a Accelerated),
    /// Voxels where rays enter the graph, which has the same hits, too.
    Grid(&'a Grid<'a>),
}

/// What a thread asks.
#[derive(Debug)]
pub(crate) enum Tracer<'a> {
    Reference(Box<Walk<'a>>),
    Fast(Box<fast::Tracer<'a>>),
    Grid(Box<GridTracer<'a>>),
}

impl<'a> Engine<'a> {
    pub(crate) fn tracer(self) -> Tracer<'a> {
        match self {
            Self::Reference(graph, boxes) => Tracer::Reference(Box::new(Walk::new(graph, boxes))),
            Self::Fast(accelerated) => Tracer::Fast(Box::new(accelerated.tracer())),
            Self::Grid(grid) => Tracer::Grid(Box::new(grid.tracer())),
        }
    }

    /// A tracer that knows which states its rays hit.
    pub(crate) fn numbering_tracer(self, numbers: &'a FxHashMap<State, u32>) -> Tracer<'a> {
        let mut tracer = self.tracer();
        match &mut tracer {
            Tracer::Reference(walk) => walk.number_states(numbers),
            Tracer::Grid(tracer) => tracer.walk_mut().number_states(numbers),
            Tracer::Fast(_) => {}
        }
        tracer
    }

    /// The numbers of all states of S-nodes, for engines that do not have them: as `ExactBoxes::states` lists them.
    pub(crate) fn state_numbers(self) -> Result<FxHashMap<State, u32>, StatesError> {
        let graph = match self {
            Self::Reference(graph, _) => graph,
            Self::Grid(grid) => grid.graph(),
            Self::Fast(_) => return Ok(FxHashMap::default()),
        };
        let mut limits = Limits::default();
        (limits.states, limits.values) = (usize::MAX, usize::MAX);
        let states = graph.states(&limits)?;
        let symbols = states
            .states()
            .iter()
            .zip(0_u32..)
            .filter(|(state, _)| matches!(graph.node(state.node()), Node::Symbol(_)));
        Ok(symbols.map(|(state, number)| (state.clone(), number)).collect())
    }

    /// How many rays it takes together: a square of the picture with sides of that many pixels.
    pub(crate) fn side(self) -> u32 {
        match self {
            Self::Reference(..) | Self::Grid(_) => 1,
            Self::Fast(_) => fast::PACKET_SIDE,
        }
    }
}

impl Tracer<'_> {
    /// Says how large a pixel is along the next rays.
    pub(crate) fn set_footprint(&mut self, pixel: Footprint) {
        if let Self::Fast(tracer) = self {
            tracer.set_footprint(pixel);
        }
    }

    /// The first hits of some rays, no more than the engine takes together.
    pub(crate) fn nearest(&mut self, batch: Batch<'_>, hits: &mut Vec<Option<Hit>>) -> Result<(), EvalError> {
        hits.clear();
        match self {
            Self::Reference(walk) => {
                for ray in batch.rays {
                    hits.push(walk.nearest(ray)?);
                }
            }
            Self::Fast(tracer) => {
                hits.resize(batch.rays.len(), None);
                tracer.nearest_of(batch, hits);
                tracer.take_fault().map_or(Ok(()), Err)?;
            }
            Self::Grid(tracer) => hits.extend(batch.rays.iter().map(|ray| tracer.nearest(ray))),
        }
        Ok(())
    }

    /// How many of some rays hit anything, no more rays than the engine takes together.
    pub(crate) fn count_hits(&mut self, batch: Batch<'_>) -> Result<u64, EvalError> {
        let rays = batch.rays;
        let mut count = 0;
        match self {
            Self::Reference(walk) => {
                for ray in rays {
                    count += u64::from(walk.nearest(ray)?.is_some());
                }
            }
            Self::Fast(tracer) => {
                let reach = tracer.reach_of(batch);
                tracer.take_fault().map_or(Ok(()), Err)?;
                count += reach[..rays.len()].iter().filter(|t| t.is_finite()).count() as u64;
            }
            Self::Grid(tracer) => {
                count += rays.iter().filter(|ray| tracer.nearest(ray).is_some()).count() as u64;
            }
        }
        Ok(count)
    }

    /// Which of some rays meet the solid before their ends, as a set of bits.
    pub(crate) fn occluded(&mut self, rays: &[Ray], ends: &[f64]) -> Result<u32, EvalError> {
        match self {
            Self::Reference(walk) => set_of(rays, ends, |ray, end| walk.occluded(ray, end)),
            Self::Fast(tracer) => {
                let set = tracer.occluded_of(rays, ends);
                tracer.take_fault().map_or(Ok(set), Err)
            }
            Self::Grid(tracer) => set_of(rays, ends, |ray, end| Ok(tracer.occluded(ray, end))),
        }
    }

    /// The deepest recursion at which the last ray was turned away. Only the walk knows.
    pub(crate) fn missed_depth(&self) -> u32 {
        match self {
            Self::Reference(walk) => walk.missed_depth(),
            Self::Fast(_) | Self::Grid(_) => 0,
        }
    }

    /// The state of the last S-node on the path to the last ray's hit, by its place among all states. The ray was alone,
    /// and the states have their [numbers](Engine::state_numbers).
    pub(crate) fn last_symbol(&self) -> Option<u32> {
        match self {
            Self::Reference(walk) => walk.last_symbol(),
            Self::Fast(tracer) => tracer.last_symbol(),
            Self::Grid(tracer) => tracer.last_symbol(),
        }
    }

    pub(crate) fn counters(&self) -> &Counters {
        match self {
            Self::Reference(walk) => walk.counters(),
            Self::Fast(tracer) => tracer.counters(),
            Self::Grid(tracer) => tracer.counters(),
        }
    }

    pub(crate) fn take_counters(&mut self) -> Counters {
        match self {
            Self::Reference(walk) => walk.take_counters(),
            Self::Fast(tracer) => tracer.take_counters(),
            Self::Grid(tracer) => tracer.take_counters(),
        }
    }
}

/// Those that something holds for, asked one by one.
fn set_of(
    rays: &[Ray],
    ends: &[f64],
    mut holds: impl FnMut(&Ray, f64) -> Result<bool, EvalError>,
) -> Result<u32, EvalError> {
    let mut set = 0;
    for (lane, (ray, end)) in rays.iter().zip(ends).enumerate() {
        set |= u32::from(holds(ray, *end)?) << lane;
    }
    Ok(set)
}
