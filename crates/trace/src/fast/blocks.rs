//! Blocks of a graph, compiled when rays come to them.
//!
//! Where random numbers make every instance different, or the recursion never ends, the states cannot be compiled before
//! the first ray, and those that rays come to need not fit into memory either. So a graph is compiled in *blocks*: a state
//! opened to some number of items, with gates where it breaks off. What is behind a gate is compiled when a ray first goes
//! through it, and forgotten when memory is short and other blocks were of more use. This is \[KAJI83\]'s cheesecake: the
//! next level of a procedural object is made inside of the box that its last level has promised, only that here the
//! promise is proven.
//!
//! A block is a function of its state, so that a picture does not depend on what is remembered, by whom, or when. All
//! threads share what is remembered; each [holds](super::held) the blocks that its rays are in.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use csg_graph::{EvalError, Graph, Node, State};
use csg_graph_bounds::Aabb;
use fearless_simd::Level;
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use rustc_hash::FxHashMap;

use super::Accelerated;
use super::bounds::StateBounds;
use super::compiled::{BYTES, Compiled};
use super::detail::Footprint;
use super::survey::demand::Class;
use super::unions::Unions;

/// How much of a graph is in one block.
#[derive(Clone, Copy)]
pub(super) struct Granularity {
    /// The number of items that a state is opened to.
    pub(super) length: usize,
    /// And that behind each gate, for its box alone.
    pub(super) ahead: usize,
    /// The most bytes of blocks that rays come to together. Those that would come to more go alone, one after the other,
    /// so that less has to be held at one time. As it is a matter of the rays, pictures are the same for any memory.
    pub(super) together: usize,
    /// The most that one ray comes to: where there is more, nobody can wait for it.
    pub(super) alone: usize,
}

/// Where all states are known, those of few symbols are opened further: rays come to the same blocks again and again. What
/// these blocks may take together, in bytes.
const ROOM: usize = 1 << 14;

/// The most bytes of blocks that one ray comes to.
const ALONE: usize = 1 << 27;

impl Granularity {
    /// Where everything is looked into, rays come to most of what is in a block, and the fewer gates there are, with their
    /// envelopes for boxes, the fewer are passed in vain.
    const FINE: Self = Self { length: 64, ahead: 16, together: 1 << 22, alone: ALONE };

    /// Where small parts are not looked into, most of a long list would be too small. To look ahead would be as much work as
    /// the block itself.
    const COARSE: Self = Self { length: 8, ahead: 0, together: 1 << 21, alone: ALONE };

    /// That of a graph with such bounds for rays that look into what is large only.
    fn coarse(graph: &Graph, bounds: &StateBounds) -> Self {
        let StateBounds::Exact(boxes) = bounds else { return Self::COARSE };
        let is_symbol = |state: &State| matches!(graph.node(state.node()), Node::Symbol(_));
        let symbols = boxes.states().filter(|(state, _)| is_symbol(state)).count();
        let length = (ROOM / BYTES / symbols.max(1)).max(Self::COARSE.length);
        Self { length, ..Self::COARSE }
    }
}

/// What is too fine where nobody knows whether there is a last part: each ray that meets anything comes that far.
const FINEST_ON_DEMAND: f64 = 1e-12;

/// Of what part of the memory blocks are held by threads, and not only remembered.
pub(super) const HELD: usize = 16;

/// And what part is left to the allocator, for what is lost between blocks that came and went.
const LOST: usize = 8;

/// What there is of a graph.
#[derive(Debug)]
pub(super) enum Blocks {
    /// All of it.
    Whole { graph: Graph, block: Arc<Compiled> },
    /// What rays have come to.
    OnDemand(Box<OnDemand>),
}

/// A graph that is compiled as rays come to it.
pub(super) struct OnDemand {
    pub(super) graph: Graph,
    bounds: StateBounds,
    pub(super) unions: Unions,
    pub(super) granularity: Granularity,
    /// Made before anyone has said what rays look into, and coarse for all of them: whatever is wrong in it is an error at
    /// once, and what is further down should be one only if a ray comes there.
    pub(super) root: Arc<Compiled>,
    pub(super) remembered: Cache<State, Arc<Compiled>, Bytes>,
    pub(super) memory: usize,
    /// What was measured, by class and rounds.
    classes: Mutex<FxHashMap<(u32, u8), Arc<Class>>>,
    /// What threads hold together, in bytes.
    pub(super) held: Mutex<usize>,
}

impl Blocks {
    /// Measures what is seen of small parts where all is compiled, and keeps it.
    pub(super) fn with_looks(self, level: Level) -> Self {
        let found = self.survey(level);
        self.map_whole(|whole| whole.with_looks(found))
    }

    /// The same with something else made of all that is compiled, if it is.
    pub(super) fn map_whole(self, make: impl FnOnce(Compiled) -> Compiled) -> Self {
        let Self::Whole { graph, block } = self else { return self };
        let block = Arc::into_inner(block).expect("there is no tracer yet");
        Self::Whole { graph, block: Arc::new(make(block)) }
    }

    pub(super) fn graph(&self) -> &Graph {
        match self {
            Self::Whole { graph, .. } => graph,
            Self::OnDemand(source) => &source.graph,
        }
    }

    pub(super) fn on_demand(&self) -> Option<&OnDemand> {
        match self {
            Self::Whole { .. } => None,
            Self::OnDemand(source) => Some(source),
        }
    }

    /// The size of what is not looked into in any case. Coordinates have no digits left to tell its parts apart: a ray would
    /// meet the boxes of all or none of them, and unfold what is below.
    pub(super) fn finest(&self) -> Footprint {
        let (root, share) = match self {
            Self::Whole { block, .. } if !block.is_too_fine => return Footprint::LINE,
            Self::Whole { block, .. } => (block, Accelerated::FINEST),
            Self::OnDemand(source) => (&source.root, FINEST_ON_DEMAND),
        };
        Footprint { width: share * root.supers[0].radius, spread: share }
    }

    /// In how many rounds parts are measured when rays come to them. What is random ends, and has leaves not far
    /// below; for what never ends, more would only make it thinner.
    pub(super) fn rounds(&self) -> u8 {
        match self {
            Self::Whole { .. } => 0,
            Self::OnDemand(source) => match source.bounds {
                StateBounds::Exact(_) => 1,
                StateBounds::Envelopes(_) => 2,
            },
        }
    }
}

#[derive(Clone)]
pub(super) struct Bytes;

impl Weighter<State, Arc<Compiled>> for Bytes {
    fn weight(&self, state: &State, block: &Arc<Compiled>) -> u64 {
        (block.all_bytes() + state.bytes()) as u64
    }
}

impl OnDemand {
    /// A graph with bounds for its states, and the memory that blocks may take, in bytes.
    pub(super) fn new(graph: Graph, bounds: StateBounds, memory: usize) -> Result<Self, EvalError> {
        let capacity = capacity(memory, 0);
        let estimated = capacity / (Granularity::FINE.length * BYTES);
        let remembered = Cache::with_weighter(estimated.max(16), capacity as u64, Bytes);
        let unions = Unions::new(&graph);
        let coarse = Granularity::coarse(&graph, &bounds);
        let root = Self::compile(&graph, &bounds, &unions, graph.root_state(), coarse)?;
        let (granularity, classes, held) = (Granularity::FINE, Mutex::default(), Mutex::new(0));
        Ok(Self { graph, unions, bounds, granularity, root, remembered, memory, classes, held })
    }

    /// The same for rays that look into everything, or into what is large only.
    pub(super) fn for_rays(self, look_into_all: bool) -> Self {
        self.remembered.clear();
        let granularity =
            if look_into_all { Granularity::FINE } else { Granularity::coarse(&self.graph, &self.bounds) };
        Self { granularity, ..self }
    }

    /// The block of a state.
    pub(super) fn block(&self, state: &State) -> Result<Arc<Compiled>, EvalError> {
        self.remembered.get_or_insert_with(state, || {
            let Self { graph, bounds, unions, granularity, .. } = self;
            Self::compile(graph, bounds, unions, state.clone(), *granularity)
        })
    }

    fn compile(
        graph: &Graph,
        bounds: &StateBounds,
        unions: &Unions,
        state: State,
        granularity: Granularity,
    ) -> Result<Arc<Compiled>, EvalError> {
        let block = Compiled::block(graph, bounds.as_ref(), unions, state, granularity)?.with_parts();
        // By chance there are too many blocks for their nodes to be measured, and what is not measured would stop all rays.
        let is_listed = matches!(bounds, StateBounds::Exact(_));
        Ok(Arc::new(if is_listed { block.with_outlines().with_node_sizes() } else { block }))
    }

    /// The class of a state in so many rounds, if it has one.
    pub(super) fn class(&self, state: &State, rounds: u8) -> Option<Arc<Class>> {
        let key = (self.bounds.class(state)?, rounds);
        let mut classes = self.classes.lock().expect("nobody panics while adding a class");
        Some(Arc::clone(classes.entry(key).or_insert_with(|| Arc::new(Class::new(state.clone(), rounds)))))
    }

    pub(super) fn class_count(&self) -> usize {
        self.bounds.class_count()
    }

    /// States that stand for all of the class of one.
    pub(super) fn typical(&self, state: &State) -> Vec<State> {
        self.bounds.typical(state)
    }

    /// The box of a state.
    pub(super) fn bounds_of(&self, state: &State) -> Option<Aabb> {
        self.bounds.as_ref().of(state).ok().map(|extent| extent.aabb)
    }

    /// Remembers less where a thread holds more than it did.
    pub(super) fn note_held(&self, before: usize, now: usize) {
        // Locked until the capacity is set, which is that of the last note then, and no thread counts twice on the way.
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        *held = *held - before + now;
        self.remembered.set_capacity(capacity(self.memory, *held) as u64);
    }

    pub(super) fn bytes(&self) -> usize {
        usize::try_from(self.remembered.weight()).unwrap_or(usize::MAX)
    }
}

/// The bytes of what may be remembered while threads hold so many.
fn capacity(memory: usize, held: usize) -> usize {
    (memory - memory / LOST).saturating_sub(held.max(memory / HELD))
}

impl fmt::Debug for OnDemand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnDemand").field("blocks", &self.remembered.len()).finish_non_exhaustive()
    }
}
