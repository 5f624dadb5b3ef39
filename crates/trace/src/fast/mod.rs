//! The fast engine: the graph compiled into [super-nodes](compiled), traced in [packets](packet).
//!
//! It finds the hits of the [reference walk](crate::Walk): t and normal differ only by how the products of transformations
//! are rounded. Where the walk asks one node after the other, evaluating its expressions each time, this one has
//! evaluated each state once, and goes down a few wide trees. It is in these parts:
//!
//! - [`states`], [`instance`], [`unions`], [`lists`], [`compile`]: states to super-nodes and solids, which are [`compiled`],
//!   with the boxes of [`bounds`];
//! - [`blocks`]: all of the graph at once, or what rays come to; [`held`]: what of it a thread holds;
//!   [`ahead`]: closer boxes of what rays may come to;
//! - [`tree`], [`slabs`]: their boxes in single precision, without corners where that is worth it; [`frame`], [`line`],
//!   [`point`]: what is tested against them;
//! - [`entry`]: where the rays of a beam begin, past the way that all of them have in common;
//! - [`packet`], [`single`]: the first hit of rays together and alone; [`lanes`] and [`shapes`] are their arithmetic;
//! - [`solid`], [`cuts`], [`face`]: the first boundary of the results of ∩ and \\, alone and together, and whose face it is;
//! - [`tracer`], [`batch`], [`inquiry`], [`hits`]: how a question begins and ends, which rays, what is asked of them, what was
//!   hit, and the way to it;
//! - [`resolve`], [`together`]: surface and normal there, for one ray and for several;
//! - [`detail`], [`look`], [`cover`], [`survey`], [`sample`]: what is too small to be looked into, and what is seen of it.

mod ahead;
mod batch;
mod blocks;
mod bounds;
mod compile;
mod compiled;
mod cover;
mod cuts;
mod detail;
mod entry;
mod face;
mod frame;
mod held;
mod hits;
mod inquiry;
pub(crate) mod instance;
pub(crate) mod lanes;
mod line;
mod lists;
mod look;
mod packet;
mod point;
mod resolve;
pub(crate) mod sample;
mod shapes;
mod single;
mod slabs;
mod solid;
pub(crate) mod states;
mod survey;
#[cfg(test)]
mod tests;
mod together;
mod tracer;
mod tree;
pub(crate) mod unions;

use std::sync::Arc;

use csg_graph::{EvalError, Graph};
use csg_graph_bounds::ExactBoxes;
use fearless_simd::Level;

pub use self::batch::Batch;
use self::blocks::{Blocks, OnDemand};
pub(crate) use self::bounds::Bounds;
pub use self::bounds::StateBounds;
use self::compiled::Compiled;
pub use self::detail::Footprint;
pub use self::entry::Beam;
use self::held::Held;
pub use self::tracer::Tracer;

/// Rays that are traced together.
pub const PACKET: usize = lanes::LANES;

/// The side of a square of as many pixels.
pub(crate) const PACKET_SIDE: u32 = 4;

/// A graph compiled for tracing.
#[derive(Debug)]
pub struct Accelerated {
    blocks: Blocks,
    /// The share of a pixel below which nothing is looked into.
    detail: f64,
    level: Level,
}

impl Accelerated {
    /// Memory that an engine takes if nobody says how much it may take, in bytes.
    pub const DEFAULT_BUDGET: usize = 3 << 17;

    /// Nothing is looked into that is smaller than this share of the whole and of its distance, where some parts of parts
    /// [are](ExactBoxes::finest): coordinates have hardly any digits left for what is in it. Its box stands for it.
    pub const FINEST: f64 = 1e-14;

    /// Compiles a graph with the boxes that belong to it. Takes `budget` bytes, or more if the graph has too many states
    /// for that.
    ///
    /// # Errors
    /// If an expression of the graph has no usable value.
    pub fn new(graph: &Graph, boxes: &ExactBoxes<Graph>, budget: usize) -> Result<Self, EvalError> {
        let block = Arc::new(Compiled::whole(graph, Bounds::Exact(boxes), budget)?);
        let blocks = Blocks::Whole { graph: graph.clone(), block };
        Ok(Self { blocks, detail: 0.0, level: Level::new() })
    }

    /// Compiles what rays come to, when they come to it, and remembers as much of it as there is `memory` for, in bytes. The
    /// hits are the same for any memory, and for any order of rays and number of threads; with less of it, more is
    /// compiled again.
    ///
    /// # Errors
    /// If an expression at the root of the graph has no usable value. Of others, [`Tracer::take_fault`] tells.
    pub fn on_demand(graph: Graph, bounds: StateBounds, memory: usize) -> Result<Self, EvalError> {
        let blocks = OnDemand::new(graph, bounds, memory)?;
        Ok(Self { blocks: Blocks::OnDemand(Box::new(blocks)), detail: 0.0, level: Level::new() })
    }

    /// The same with all boxes open: each ray is tested against every primitive of the unfolded tree. It has the same hits,
    /// to the last bit; tests show by it that boxes change what a ray costs and nothing else.
    ///
    /// # Panics
    /// If the graph is compiled on demand, where every ray would come to all of it; or if there is [detail](Self::with_detail)
    /// or something [too fine](Self::FINEST), which is told by boxes.
    pub fn without_boxes(self) -> Self {
        assert!(self.blocks.on_demand().is_none(), "without boxes nothing is on demand");
        Self { blocks: self.blocks.map_whole(Compiled::without_boxes), ..self }
    }

    /// Looks into nothing that is smaller than so many pixels: its box stands for it, and stops as many of the rays as what
    /// is in it would. A silhouette is then off by no more than that. 0 is to look into everything, which recursion that
    /// never ends does not allow. What is compiled at once is measured for that, which takes about as much time and
    /// memory again; what is compiled on demand is measured when a ray comes to something small of it.
    pub fn with_detail(self, pixels: f64) -> Self {
        let blocks = match self.blocks {
            Blocks::OnDemand(source) => Blocks::OnDemand(Box::new(source.for_rays(pixels <= 0.0))),
            whole if pixels > 0.0 => {
                whole.map_whole(|whole| whole.with_parts().with_outlines()).with_looks(self.level)
            }
            whole => whole,
        };
        Self { blocks, detail: pixels, ..self }
    }

    /// The memory of the acceleration structure, in bytes: where it is made on demand, of what is remembered now.
    pub fn bytes(&self) -> usize {
        match &self.blocks {
            Blocks::Whole { block, .. } => block.bytes(),
            Blocks::OnDemand(source) => source.bytes(),
        }
    }

    /// A tracer; each thread has its own.
    pub fn tracer(&self) -> Tracer<'_> {
        let rounds = if self.detail > 0.0 { self.blocks.rounds() } else { 0 };
        Tracer::new(Held::new(&self.blocks, rounds), self.level, self.detail)
    }
}
