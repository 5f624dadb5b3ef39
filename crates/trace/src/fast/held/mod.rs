//! The blocks that a thread holds.
//!
//! What is [remembered](super::blocks) may be forgotten at any time, and a lock is between it and the threads that share it.
//! So each thread keeps the blocks that its rays are in, and knows them by small numbers: looked up once, they stay while
//! a question is asked. Where a thread holds too much, it lets go of all between two questions. Rays that would come to too
//! many blocks together are told so, and go alone.
//!
//! [`limits`]: where rays have to give up; [`small`]: what is seen of parts that are too small to be looked into.

mod limits;
mod small;

use std::cell::{Cell, RefCell};
use std::fmt;
use std::sync::Arc;

use csg_graph::{EvalError, Fault, State};
use elsa::FrozenVec;
use rustc_hash::FxHashMap;

use self::limits::Faults;
use super::blocks::{Blocks, HELD, OnDemand};
use super::compiled::{Compiled, Content, Item, SuperNode};
use super::detail::Footprint;
use super::hits::ROOT;
use crate::narrow::index;

/// About what it takes to know where a gate or a state leads, in bytes.
const ENTRY: usize = 64;

/// The bytes of blocks that are held where lines measure one.
const ALONE: usize = 1 << 20;

/// By how many bytes what a thread holds may differ from what others know of it.
const STEP: usize = 1 << 18;

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

/// The number of the block behind a gate, or what is wrong with it.
type Behind = Result<u32, Box<EvalError>>;

/// The blocks that a thread holds. The first is the root's.
pub(super) struct Held<'a> {
    source: &'a Blocks,
    blocks: FrozenVec<Arc<Compiled>>,
    /// Where gates of blocks lead, or what is wrong there.
    behind: RefCell<FxHashMap<(u32, u32), Behind>>,
    /// The numbers of the blocks, by their states: many gates lead to one.
    numbers: RefCell<FxHashMap<State, u32>>,
    /// Of each block, itself, its bytes and the last question that came to it.
    visits: RefCell<Vec<(Arc<Compiled>, usize, u32)>>,
    /// In how many rounds parts are measured that rays come to.
    rounds: u8,
    /// The most bytes, if it is not the memory that says so.
    limit: Option<usize>,
    share: Share<'a>,
    question: u32,
    /// The bytes of all blocks that the rays of the question have come to, and the most that they may.
    come_to: Cell<usize>,
    most: usize,
    faults: Faults,
}

impl<'a> Held<'a> {
    pub(super) fn new(source: &'a Blocks, rounds: u8) -> Self {
        let root = match source {
            Blocks::Whole { block, .. } => Arc::clone(block),
            Blocks::OnDemand(source) => Arc::clone(&source.root),
        };
        Self::at(source, root, rounds, None)
    }

    /// A block as if it were the root.
    pub(super) fn alone(source: &'a Blocks, block: Arc<Compiled>, rounds: u8) -> Self {
        Self::at(source, block, rounds, Some(ALONE))
    }

    fn at(source: &'a Blocks, root: Arc<Compiled>, rounds: u8, limit: Option<usize>) -> Self {
        let held = Self {
            source,
            blocks: FrozenVec::new(),
            behind: RefCell::default(),
            numbers: RefCell::default(),
            visits: RefCell::default(),
            rounds,
            limit,
            share: Share { source, bytes: Cell::new(0), noted: Cell::new(0) },
            question: 0,
            come_to: Cell::new(0),
            most: usize::MAX,
            faults: Faults::default(),
        };
        held.hold(root);
        held
    }

    fn hold(&self, block: Arc<Compiled>) -> u32 {
        let bytes = block.all_bytes();
        self.share.add(bytes);
        self.visits.borrow_mut().push((Arc::clone(&block), bytes, 0));
        self.blocks.push(block);
        index(self.blocks.len() - 1)
    }

    /// Begins a question. Lets go of what is held if it is too much, and says so: numbers are void then.
    pub(super) fn renew(&mut self) -> bool {
        let Blocks::OnDemand(source) = self.source else {
            // What is listed ends, so that each question is worth asking.
            self.faults.go_on();
            return false;
        };
        let limit = || source.memory / HELD / rayon::current_num_threads();
        let is_too_much = self.share.bytes.get() > self.limit.unwrap_or_else(limit);
        if is_too_much {
            let faults = std::mem::take(&mut self.faults);
            let root = Arc::clone(&self.visits.borrow()[ROOT as usize].0);
            *self = Self { faults, ..Self::at(self.source, root, self.rounds, self.limit) };
        }
        self.begin(source.granularity.alone);
        is_too_much
    }

    /// Begins the question of rays that go together.
    pub(super) fn go_together(&mut self) {
        let Blocks::OnDemand(source) = self.source else { return };
        self.begin(source.granularity.together);
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

    /// The same for who looks ahead: what is wrong there is not said before a ray comes to it.
    pub(super) fn inside_ahead(&self, block: u32, content: Content) -> Option<(u32, &SuperNode)> {
        let Content::Gate(gate) = content else { return self.inside(block, content) };
        let block = self.behind(block, gate)?.ok()?;
        Some((block, &self.block(block).supers[0]))
    }

    /// The block behind a gate, unless there is something wrong with it, or the rays have come to too much.
    #[inline(never)]
    fn enter(&self, block: u32, gate: u32) -> Option<u32> {
        let found = self.behind(block, gate);
        // Rays that went together go alone then.
        let is_alone = |source: &OnDemand| self.most == source.granularity.alone;
        if found.is_none() && self.source.on_demand().is_some_and(is_alone) {
            self.refuse_at(Fault::Crowded, self.block(block).gates[gate as usize].state.node());
        }
        found?.map_err(|fault| self.faults.note(fault)).ok()
    }

    /// The block behind a gate, or what is wrong with it; none if the rays have come to too much.
    #[inline(always)]
    fn behind(&self, block: u32, gate: u32) -> Option<Behind> {
        if self.come_to.get() > self.most {
            return None;
        }
        let known = self.behind.borrow().get(&(block, gate)).cloned();
        let found = known.unwrap_or_else(|| {
            let found = self.find(&self.block(block).gates[gate as usize].state);
            self.behind.borrow_mut().insert((block, gate), found.clone());
            self.share.add(ENTRY);
            found
        });
        if let Ok(number) = found {
            let (_, bytes, question) = &mut self.visits.borrow_mut()[number as usize];
            if std::mem::replace(question, self.question) != self.question {
                self.come_to.set(self.come_to.get() + *bytes);
            }
        }
        Some(found)
    }

    /// The block of a state.
    fn find(&self, state: &State) -> Behind {
        let Blocks::OnDemand(source) = self.source else { unreachable!("a whole graph has no gates") };
        if let Some(number) = self.numbers.borrow().get(state) {
            return Ok(*number);
        }
        let number = self.hold(source.block(state)?);
        self.numbers.borrow_mut().insert(state.clone(), number);
        self.share.add(state.bytes() + ENTRY);
        Ok(number)
    }

    /// The size of what is not looked into in any case.
    pub(super) fn finest(&self) -> Footprint {
        self.source.finest()
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

    use super::super::bounds::StateBounds;
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
        source.granularity.together = together;
        Blocks::OnDemand(Box::new(source))
    }

    #[test]
    fn what_is_too_much_together_is_not_for_one() {
        let blocks = blocks(0);
        let mut held = Held::new(&blocks, 0);
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
    fn what_is_too_much_for_one_is_an_error() {
        let Blocks::OnDemand(mut source) = blocks(0) else { unreachable!("it was made so") };
        source.granularity.alone = 0;
        let blocks = Blocks::OnDemand(source);
        let mut held = Held::new(&blocks, 0);
        held.renew();
        assert!(held.enter(ROOT, 0).is_some() && !held.is_void());
        assert!(held.enter(ROOT, 1).is_none() && held.is_void());
        assert_eq!(held.take_fault().map(|error| error.fault), Some(Fault::Crowded));
        held.renew();
        assert!(held.enter(ROOT, 1).is_some() && held.take_fault().is_none());
    }

    #[test]
    fn what_is_held_is_not_remembered_besides() {
        let blocks = blocks(usize::MAX);
        let Blocks::OnDemand(source) = &blocks else { unreachable!("it was made so") };
        let all = source.remembered.capacity();
        let held = Held::new(&blocks, 0);
        let mut open = vec![ROOT];
        while let Some(number) = open.pop() {
            let gates = 0..index(held.block(number).gates.len());
            let is_little = |_: &u32| *source.held.lock().unwrap() <= STEP;
            open.extend(gates.take_while(is_little).filter_map(|gate| held.enter(number, gate)));
        }
        let noted = *source.held.lock().unwrap();
        assert!(noted > STEP && noted <= held.share.bytes.get());
        assert!(source.remembered.capacity() <= all - (noted - source.memory / HELD) as u64 + 64);
        drop(held);
        assert_eq!(*source.held.lock().unwrap(), 0);
        assert!(source.remembered.capacity() >= all);
    }
}
