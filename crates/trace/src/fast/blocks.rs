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
//! threads share what is remembered; each *holds* the blocks that its rays are in, by small numbers.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::sync::Arc;

use csg_graph::{EvalError, Graph, State};
use elsa::FrozenVec;
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use rustc_hash::FxHashMap;

use super::bounds::StateBounds;
use super::compile::{BYTES, Compiled, Content, Item, SuperNode, index};
use super::detail::Footprint;
use super::sample::{Dice, Sample};
use super::unions::Unions;

/// The number of items that a state is opened to. Fewer mean more gates on the way of a ray, more mean more that no ray
/// meets.
const LENGTH: usize = 8;

/// Of what part of the memory blocks are held by threads, and not only remembered.
const HELD: usize = 8;

/// And what part is left to the allocator, for what is lost between blocks that came and went, and to the rest of the program.
const LOST: usize = 4;

/// What there is of a graph.
#[derive(Debug)]
pub(super) enum Blocks {
    /// All of it.
    Whole(Arc<Compiled>),
    /// What rays have come to.
    OnDemand(Box<OnDemand>),
}

/// A graph that is compiled as rays come to it.
pub(super) struct OnDemand {
    graph: Graph,
    bounds: StateBounds,
    unions: Unions,
    root: Arc<Compiled>,
    remembered: Cache<State, Arc<Compiled>, Bytes>,
    memory: usize,
}

#[derive(Clone)]
struct Bytes;

impl Weighter<State, Arc<Compiled>> for Bytes {
    fn weight(&self, state: &State, block: &Arc<Compiled>) -> u64 {
        (block.all_bytes() + state.bytes()) as u64
    }
}

impl OnDemand {
    /// A graph with bounds for its states, and the memory that blocks may take, in bytes.
    pub(super) fn new(graph: Graph, bounds: StateBounds, memory: usize) -> Result<Self, EvalError> {
        let capacity = memory - memory / HELD - memory / LOST;
        let estimated = capacity / (LENGTH * BYTES);
        let remembered = Cache::with_weighter(estimated.max(16), capacity as u64, Bytes);
        let unions = Unions::new(&graph);
        let root = Compiled::block(&graph, bounds.as_ref(), &unions, graph.root_state(), LENGTH)?;
        let root = Arc::new(root.with_parts());
        Ok(Self { graph, unions, bounds, root, remembered, memory })
    }

    pub(super) fn root(&self) -> Arc<Compiled> {
        Arc::clone(&self.root)
    }

    /// The block of a state.
    fn block(&self, state: &State) -> Result<Arc<Compiled>, EvalError> {
        self.remembered.get_or_insert_with(state, || {
            let Self { graph, bounds, unions, .. } = self;
            let block = Compiled::block(graph, bounds.as_ref(), unions, state.clone(), LENGTH)?;
            Ok(Arc::new(block.with_parts()))
        })
    }

    pub(super) fn bytes(&self) -> usize {
        usize::try_from(self.remembered.weight()).unwrap_or(usize::MAX)
    }
}

impl fmt::Debug for OnDemand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnDemand").field("blocks", &self.remembered.len()).finish_non_exhaustive()
    }
}

/// The blocks that a thread holds. The first is the root's.
pub(super) struct Held<'a> {
    source: &'a Blocks,
    blocks: FrozenVec<Arc<Compiled>>,
    /// Where gates of blocks lead.
    behind: RefCell<FxHashMap<(u32, u32), Option<u32>>>,
    /// The numbers of the blocks, by where they are in memory: many gates lead to one.
    numbers: RefCell<FxHashMap<usize, u32>>,
    bytes: Cell<usize>,
    /// What was wrong with a state that a ray came to.
    fault: Cell<Option<Box<EvalError>>>,
}

impl<'a> Held<'a> {
    pub(super) fn new(source: &'a Blocks) -> Self {
        let held = Self {
            source,
            blocks: FrozenVec::new(),
            behind: RefCell::default(),
            numbers: RefCell::default(),
            bytes: Cell::new(0),
            fault: Cell::new(None),
        };
        held.hold(match source {
            Blocks::Whole(whole) => Arc::clone(whole),
            Blocks::OnDemand(source) => source.root(),
        });
        held
    }

    fn hold(&self, block: Arc<Compiled>) -> u32 {
        *self.numbers.borrow_mut().entry(Arc::as_ptr(&block).addr()).or_insert_with(|| {
            self.bytes.set(self.bytes.get() + block.all_bytes());
            self.blocks.push(block);
            index(self.blocks.len() - 1)
        })
    }

    /// Lets go of what is held if it is too much. Numbers are void then.
    pub(super) fn renew(&mut self) {
        let Blocks::OnDemand(source) = self.source else { return };
        if self.bytes.get() > source.memory / HELD / rayon::current_num_threads() {
            *self = Self::new(self.source);
        }
    }

    /// A block that is held.
    #[inline(always)]
    pub(super) fn block(&self, number: u32) -> &Compiled {
        &self.blocks[number as usize]
    }

    #[inline(always)]
    pub(super) fn item(&self, block: u32, item: u32) -> &Item {
        &self.block(block).items[item as usize]
    }

    /// The super-node that an item of a block leads to, and the block that it is in.
    #[inline(always)]
    pub(super) fn inside(&self, block: u32, content: Content) -> Option<(u32, &SuperNode)> {
        match content {
            Content::Super(number) => Some((block, &self.block(block).supers[number as usize])),
            Content::Gate(gate) => {
                let block = self.enter(block, gate)?;
                Some((block, &self.block(block).supers[0]))
            }
            Content::Shape(_) | Content::Solid(_) => unreachable!("what is entered has something inside"),
        }
    }

    /// The block behind a gate, unless there is something wrong with it.
    #[inline(never)]
    fn enter(&self, block: u32, gate: u32) -> Option<u32> {
        let Blocks::OnDemand(source) = self.source else { unreachable!("a whole graph has no gates") };
        if let Some(known) = self.behind.borrow().get(&(block, gate)) {
            return *known;
        }
        let found = match source.block(&self.block(block).gates[gate as usize].state) {
            Ok(found) => Some(self.hold(found)),
            Err(fault) => {
                self.fault.set(Some(Box::new(fault)));
                None
            }
        };
        self.behind.borrow_mut().insert((block, gate), found);
        found
    }

    /// The size of what is not looked into in any case: recursion that never ends has no last part, and coordinates have no
    /// more digits.
    pub(super) fn finest(&self) -> Footprint {
        const DIGITS: f64 = 1e-12;
        match self.source {
            Blocks::Whole(_) => Footprint::LINE,
            Blocks::OnDemand(source) => {
                Footprint { width: DIGITS * source.root.supers[0].radius, spread: DIGITS }
            }
        }
    }

    /// What is seen of an item that is too small to be looked into.
    pub(super) fn sample(&self, block: u32, item: u32) -> Sample {
        let block = self.block(block);
        let mut dice = Dice::at(block.parts[item as usize].bounds.min);
        let (sample, gate) = Sample::of_item(block, item as usize, &mut dice);
        let (Some(gate), Blocks::OnDemand(source)) = (gate, self.source) else { return sample };
        let inner = gate.sample.get_or_init(|| {
            // Several items may lead here, and it must not matter which of them is seen first.
            let mut dice = Dice::at(block.parts[gate.first as usize].bounds.min);
            let drawn = Sample::of_state(&source.graph, &source.unions, &gate.state, &mut dice);
            drawn.map(Box::new).map_err(|fault| self.fault.set(Some(Box::new(fault)))).ok()
        });
        inner.as_ref().map_or(sample.clone(), |inner| sample.then(inner))
    }

    /// What was wrong with a state that a ray came to since the last question, if anything was.
    pub(super) fn take_fault(&self) -> Option<EvalError> {
        self.fault.take().map(|fault| *fault)
    }
}

impl fmt::Debug for Held<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Held").field("blocks", &self.blocks.len()).finish_non_exhaustive()
    }
}
