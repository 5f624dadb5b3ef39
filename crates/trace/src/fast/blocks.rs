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
use std::sync::atomic::{AtomicUsize, Ordering};

use csg_graph::{EvalError, Fault, Graph, Node, State};
use elsa::FrozenVec;
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use rustc_hash::FxHashMap;

use super::bounds::StateBounds;
use super::compile::{BYTES, Compiled, Content, Item, SuperNode, index};
use super::detail::Footprint;
use super::hits::{Hits, Place};
use super::sample::{Dice, Sample};
use super::unions::Unions;

/// How a graph is cut into blocks.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    /// The number of items that a state is opened to.
    pub(super) length: usize,
    /// And that behind each gate, for its box alone.
    pub(super) ahead: usize,
    /// The most bytes of blocks that rays come to together. Those that would come to more go alone, one after the other,
    /// so that less has to be held at one time. As it is a matter of the rays, pictures are the same for any memory.
    together: usize,
}

/// Where everything is looked into, rays come to most of what is in a block, and the fewer gates there are, with their
/// envelopes for boxes, the fewer are passed in vain.
const FINE: Cut = Cut { length: 64, ahead: 16, together: 1 << 22 };

/// Where small parts are not looked into, most of a long list would be too small. To look ahead would be as much work as the
/// block itself.
const COARSE: Cut = Cut { length: 8, ahead: 0, together: 1 << 21 };

/// About what it takes to know where a gate leads, in bytes.
const ENTRY: usize = 64;

/// Where all states are known, those of few symbols are opened further: rays come to the same blocks again and again. What
/// these blocks may take together, in bytes.
const ROOM: usize = 1 << 14;

impl Cut {
    /// That of a graph with such bounds for rays that look into what is large only.
    fn coarse(graph: &Graph, bounds: &StateBounds) -> Self {
        let StateBounds::Exact(boxes) = bounds else { return COARSE };
        let is_symbol = |state: &State| matches!(graph.node(state.node()), Node::Symbol(_));
        let symbols = boxes.states().filter(|(state, _)| is_symbol(state)).count();
        Self { length: (ROOM / BYTES / symbols.max(1)).max(COARSE.length), ..COARSE }
    }
}

/// Of what part of the memory blocks are held by threads, and not only remembered.
const HELD: usize = 16;

/// And what part is left to the allocator, for what is lost between blocks that came and went.
const LOST: usize = 8;

/// By how many bytes what a thread holds may differ from what others know of it.
const STEP: usize = 1 << 18;

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
    cut: Cut,
    root: Arc<Compiled>,
    remembered: Cache<State, Arc<Compiled>, Bytes>,
    memory: usize,
    /// Of all threads together, in bytes.
    held: AtomicUsize,
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
        let capacity = capacity(memory, 0);
        let estimated = capacity / (FINE.length * BYTES);
        let remembered = Cache::with_weighter(estimated.max(16), capacity as u64, Bytes);
        let unions = Unions::new(&graph);
        let cut = Cut::coarse(&graph, &bounds);
        let root = Self::compile(&graph, &bounds, &unions, graph.root_state(), cut)?;
        Ok(Self { graph, unions, bounds, cut: FINE, root, remembered, memory, held: AtomicUsize::new(0) })
    }

    /// The same for rays that look into everything, or into what is large only.
    pub(super) fn for_rays(self, look_into_all: bool) -> Self {
        self.remembered.clear();
        Self { cut: if look_into_all { FINE } else { Cut::coarse(&self.graph, &self.bounds) }, ..self }
    }

    pub(super) fn root(&self) -> Arc<Compiled> {
        Arc::clone(&self.root)
    }

    /// The block of a state.
    fn block(&self, state: &State) -> Result<Arc<Compiled>, EvalError> {
        self.remembered.get_or_insert_with(state, || {
            let Self { graph, bounds, unions, cut, .. } = self;
            Self::compile(graph, bounds, unions, state.clone(), *cut)
        })
    }

    fn compile(
        graph: &Graph,
        bounds: &StateBounds,
        unions: &Unions,
        state: State,
        cut: Cut,
    ) -> Result<Arc<Compiled>, EvalError> {
        let block = Compiled::block(graph, bounds.as_ref(), unions, state, cut)?;
        Ok(Arc::new(block.with_parts().with_node_sizes()))
    }

    /// Remembers less where a thread holds more than it did.
    fn note_held(&self, before: usize, now: usize) {
        let all = self.held.fetch_add(now, Ordering::Relaxed) + now - before;
        self.held.fetch_sub(before, Ordering::Relaxed);
        self.remembered.set_capacity(capacity(self.memory, all) as u64);
    }

    pub(super) fn bytes(&self) -> usize {
        usize::try_from(self.remembered.weight()).unwrap_or(usize::MAX)
    }
}

/// The bytes of what may be remembered while threads hold so many.
fn capacity(memory: usize, held: usize) -> usize {
    (memory - memory / LOST).saturating_sub(held.max(memory / HELD))
}

/// The bytes that a thread holds.
struct Share<'a> {
    source: &'a Blocks,
    bytes: Cell<usize>,
    /// What the others know of.
    noted: Cell<usize>,
}

impl Share<'_> {
    fn add(&self, bytes: usize) {
        self.bytes.set(self.bytes.get() + bytes);
        if self.bytes.get() > self.noted.get() + STEP {
            self.note(self.bytes.get());
        }
    }

    fn note(&self, bytes: usize) {
        if let Blocks::OnDemand(source) = self.source
            && self.noted.get() != bytes
        {
            source.note_held(self.noted.replace(bytes), bytes);
        }
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        self.note(0);
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
    /// The numbers of the blocks, by their states: many gates lead to one.
    numbers: RefCell<FxHashMap<State, u32>>,
    /// Of each block, its bytes and the last question that came to it.
    visits: RefCell<Vec<(usize, u32)>>,
    share: Share<'a>,
    question: u32,
    /// The bytes of all blocks that the rays of the question have come to, and the most that they may.
    come_to: Cell<usize>,
    most: usize,
    /// What was wrong with a state that a ray came to.
    fault: Cell<Option<Box<EvalError>>>,
    /// How many questions below operators may wait for each other: none any more once they were too many.
    deepest: Cell<usize>,
}

/// How many questions below operators may wait for each other at first: what is listed ends.
fn deepest(source: &Blocks) -> usize {
    match source {
        Blocks::Whole(_) => usize::MAX,
        Blocks::OnDemand(_) => 1 << 13,
    }
}

impl<'a> Held<'a> {
    pub(super) fn new(source: &'a Blocks) -> Self {
        let held = Self {
            source,
            blocks: FrozenVec::new(),
            behind: RefCell::default(),
            numbers: RefCell::default(),
            visits: RefCell::default(),
            share: Share { source, bytes: Cell::new(0), noted: Cell::new(0) },
            question: 0,
            come_to: Cell::new(0),
            most: usize::MAX,
            fault: Cell::new(None),
            deepest: Cell::new(deepest(source)),
        };
        held.hold(match source {
            Blocks::Whole(whole) => Arc::clone(whole),
            Blocks::OnDemand(source) => source.root(),
        });
        held
    }

    fn hold(&self, block: Arc<Compiled>) -> u32 {
        let bytes = block.all_bytes();
        self.share.add(bytes);
        self.visits.borrow_mut().push((bytes, 0));
        self.blocks.push(block);
        index(self.blocks.len() - 1)
    }

    /// Begins a question. Lets go of what is held if it is too much, and says so: numbers are void then.
    pub(super) fn renew(&mut self) -> bool {
        let Blocks::OnDemand(source) = self.source else { return false };
        let is_too_much = self.share.bytes.get() > source.memory / HELD / rayon::current_num_threads();
        if is_too_much {
            let (fault, deepest) = (Cell::new(self.fault.take()), self.deepest.clone());
            *self = Self { fault, deepest, ..Self::new(self.source) };
        }
        self.begin(usize::MAX);
        is_too_much
    }

    /// Begins the question of rays that go together.
    pub(super) fn go_together(&mut self) {
        let Blocks::OnDemand(source) = self.source else { return };
        self.begin(source.cut.together);
    }

    /// Begins a question of rays that may come to so many bytes of blocks.
    fn begin(&mut self, most: usize) {
        self.question = self.question.wrapping_add(1);
        self.come_to.set(0);
        self.most = most;
    }

    /// Ends a question of rays that went together, and says whether they came to too much for that. Then gates have been
    /// left out, and what was found is void.
    pub(super) fn is_too_much(&mut self) -> bool {
        self.come_to.get() > std::mem::replace(&mut self.most, usize::MAX)
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

    /// The block behind a gate, unless there is something wrong with it, or the rays have come to too much.
    #[inline(never)]
    fn enter(&self, block: u32, gate: u32) -> Option<u32> {
        if self.come_to.get() > self.most {
            return None;
        }
        let known = self.behind.borrow().get(&(block, gate)).copied();
        let number = known.unwrap_or_else(|| {
            let found = self.find(&self.block(block).gates[gate as usize].state);
            self.behind.borrow_mut().insert((block, gate), found);
            self.share.add(ENTRY);
            found
        })?;
        let (bytes, question) = &mut self.visits.borrow_mut()[number as usize];
        if std::mem::replace(question, self.question) != self.question {
            self.come_to.set(self.come_to.get() + *bytes);
        }
        Some(number)
    }

    /// The block of a state.
    fn find(&self, state: &State) -> Option<u32> {
        let Blocks::OnDemand(source) = self.source else { unreachable!("a whole graph has no gates") };
        if let Some(number) = self.numbers.borrow().get(state) {
            return Some(*number);
        }
        match source.block(state) {
            Ok(found) => {
                let number = self.hold(found);
                self.numbers.borrow_mut().insert(state.clone(), number);
                Some(number)
            }
            Err(fault) => {
                self.fault.set(Some(Box::new(fault)));
                None
            }
        }
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

    /// Whether too many questions wait for each other below the operators on a way. Where recursion goes by chance, nobody has
    /// shown that it shrinks, and this is how it is found not to. What is found from then on is void.
    #[inline(always)]
    pub(super) fn is_bottomless(&self, waiting: usize, hits: &Hits, way: u32) -> bool {
        let is_bottomless = waiting > self.deepest.get();
        if is_bottomless {
            self.refuse(hits, way);
        }
        is_bottomless
    }

    /// Whether what is found is void.
    pub(super) fn is_void(&self) -> bool {
        self.deepest.get() == 0
    }

    #[cold]
    fn refuse(&self, hits: &Hits, way: u32) {
        let Blocks::OnDemand(source) = self.source else { unreachable!("all that is listed ends") };
        if self.deepest.replace(0) > 0 {
            let (above, item) = hits.step(way);
            let node = self.item(hits.block(above), item).node;
            let at = csg_graph::Place { node, expr: None, label: source.graph.node_name(node) };
            let fault = EvalError { at, fault: Fault::Bottomless, values: Vec::new() };
            self.fault.set(Some(Box::new(fault)));
        }
    }

    /// What is seen of a part that is too small to be looked into.
    pub(super) fn sample(&self, block: u32, part: Place) -> Sample {
        let (block, at) = (self.block(block), part.item as usize);
        let (sample, gate) = if part.is_node {
            Sample::of_node(block, at, &mut Dice::at(block.nodes[at].bounds(0).min))
        } else {
            Sample::of_item(block, at, &mut Dice::at(block.parts[at].bounds.min))
        };
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
        self.deepest.set(deepest(self.source));
        self.fault.take().map(|fault| *fault)
    }
}

impl fmt::Debug for Held<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Held").field("blocks", &self.blocks.len()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use csg_graph_bounds::{Envelopes, Limits};

    use super::super::hits::ROOT;
    use super::*;

    /// A tree that is all alike but for its angles, under a limit for what rays come to together.
    fn blocks(together: usize) -> Blocks {
        let source = "{ n = 30; } TREE
            TREE if(n > 0, 2, 1)
            1: TREE -> sphere
            2: TREE -> cylinder | {n = n - 1} move(0, 0, 1) uscale(0.7)
                       (rotx(rand(20, 40)) TREE | rotx(rand(-40, -20)) TREE)";
        let graph = csg_graph_grammar::load(source, &[]).expect("a scene").scene.graph;
        let bounds = StateBounds::Envelopes(Box::new(Envelopes::new(graph.clone(), &Limits::default())));
        let mut source = OnDemand::new(graph, bounds, 1 << 20).expect("a root");
        source.cut.together = together;
        Blocks::OnDemand(Box::new(source))
    }

    #[test]
    fn what_is_too_much_together_is_not_for_one() {
        let blocks = blocks(0);
        let mut held = Held::new(&blocks);
        assert!(held.block(ROOT).gates.len() > 1);
        held.go_together();
        assert!(held.enter(ROOT, 0).is_some() && held.enter(ROOT, 1).is_none());
        assert!(held.is_too_much());
        // Those that are held already count likewise, so that it does not matter what there was before.
        held.go_together();
        assert!(held.enter(ROOT, 0).is_some() && held.enter(ROOT, 1).is_none());
        assert!(held.is_too_much());
        held.renew();
        assert!(held.enter(ROOT, 0).is_some() && held.enter(ROOT, 1).is_some());
        assert!(!held.is_too_much());
    }

    #[test]
    fn what_is_held_is_not_remembered_besides() {
        let blocks = blocks(usize::MAX);
        let Blocks::OnDemand(source) = &blocks else { unreachable!("it was made so") };
        let all = source.remembered.capacity();
        let held = Held::new(&blocks);
        let mut open = vec![ROOT];
        while let Some(number) = open.pop()
            && source.held.load(Ordering::Relaxed) <= STEP
        {
            let gates = 0..index(held.block(number).gates.len());
            open.extend(gates.filter_map(|gate| held.enter(number, gate)));
        }
        let noted = source.held.load(Ordering::Relaxed);
        assert!(noted > STEP && noted <= held.share.bytes.get());
        assert!(source.remembered.capacity() <= all - (noted - source.memory / HELD) as u64 + 64);
        drop(held);
        assert_eq!(source.held.load(Ordering::Relaxed), 0);
        assert!(source.remembered.capacity() >= all);
    }
}
