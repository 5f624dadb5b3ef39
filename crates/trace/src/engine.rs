//! What finds hits for a picture: the reference walk or the fast engine, asked for several rays at a time.

use csg_graph::{EvalError, Graph};
use csg_graph_bounds::HyperBoxes;

use crate::fast::{self, Accelerated};
use crate::{Counters, Hit, Ray, Walk};

/// What finds hits for a picture.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Engine<'a> {
    /// The walk over a graph, with its hyper boxes, or without any.
    Reference(&'a Graph, Option<&'a HyperBoxes>),
    /// The graph compiled. It has the same hits.
    Fast(&'a Accelerated),
}

/// What a thread asks.
#[derive(Debug)]
pub(crate) enum Tracer<'a> {
    Reference(Box<Walk<'a>>),
    Fast(Box<fast::Tracer<'a>>),
}

impl<'a> Engine<'a> {
    pub(crate) fn tracer(self) -> Tracer<'a> {
        match self {
            Self::Reference(graph, boxes) => Tracer::Reference(Box::new(Walk::new(graph, boxes))),
            Self::Fast(accelerated) => Tracer::Fast(Box::new(accelerated.tracer())),
        }
    }

    /// How many rays it takes together: a square of the picture with sides of that many pixels.
    pub(crate) fn side(self) -> u32 {
        match self {
            Self::Reference(..) => 1,
            Self::Fast(_) => fast::SIDE,
        }
    }
}

impl Tracer<'_> {
    /// The first hits of some rays, no more than the engine takes together.
    pub(crate) fn nearest(&mut self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) -> Result<(), EvalError> {
        hits.clear();
        match self {
            Self::Reference(walk) => {
                for ray in rays {
                    hits.push(walk.nearest(ray)?);
                }
            }
            Self::Fast(tracer) => {
                hits.resize(rays.len(), None);
                tracer.nearest_of(rays, hits);
            }
        }
        Ok(())
    }

    /// Which of some rays meet the solid before their ends, as a set of bits.
    pub(crate) fn occluded(&mut self, rays: &[Ray], ends: &[f64]) -> Result<u32, EvalError> {
        match self {
            Self::Reference(walk) => {
                let mut set = 0;
                for (lane, (ray, end)) in rays.iter().zip(ends).enumerate() {
                    set |= u32::from(walk.occluded(ray, *end)?) << lane;
                }
                Ok(set)
            }
            Self::Fast(tracer) => Ok(tracer.occluded_of(rays, ends)),
        }
    }

    /// The deepest recursion at which the last ray was turned away. The fast engine does not know.
    pub(crate) fn missed_depth(&self) -> u32 {
        match self {
            Self::Reference(walk) => walk.missed_depth(),
            Self::Fast(_) => 0,
        }
    }

    pub(crate) fn counters(&self) -> &Counters {
        match self {
            Self::Reference(walk) => walk.counters(),
            Self::Fast(tracer) => tracer.counters(),
        }
    }

    pub(crate) fn take_counters(&mut self) -> Counters {
        match self {
            Self::Reference(walk) => walk.take_counters(),
            Self::Fast(tracer) => tracer.take_counters(),
        }
    }
}
