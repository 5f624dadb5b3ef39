//! Where rays have to give up.
//!
//! Where parts lie in each other, there may be more of them on one ray than anybody can wait for. Where recursion goes by
//! chance, nobody has shown that it shrinks, nor how fast. So what rays come to is counted, and too much of it is an error at
//! the node where it became too much. From then on what is found is void, so that the question ends soon.

use std::cell::Cell;

use csg_graph::{EvalError, Fault, NodeId};

use super::Held;
use crate::fast::hits::Hits;

/// Inside of so many super-nodes, one in the other, a ray may go on, and rays together: that takes some twenty megabytes, and
/// two.
const LONGEST: u32 = 1 << 16;
const DEEP: u32 = 1 << 10;

/// The most bytes of what the rays of a packet remember of where they came to, with what they keep for later in operands.
const KEPT: usize = 1 << 27;

/// How many questions below operators may wait for each other. What is listed ends.
const WAITING: usize = 1 << 13;

/// What was wrong where rays came to.
#[derive(Default)]
pub(super) struct Faults {
    found: Cell<Option<Box<EvalError>>>,
    is_void: Cell<bool>,
}

impl Faults {
    /// Something is wrong. It is told in place of what was wrong before.
    pub(super) fn note(&self, fault: Box<EvalError>) {
        self.found.set(Some(fault));
    }

    /// What is found is not void any more.
    pub(super) fn go_on(&self) {
        self.is_void.set(false);
    }
}

impl Held<'_> {
    /// Whether rays go on one by one inside of so many super-nodes.
    #[inline(always)]
    pub(in crate::fast) fn goes_alone(&self, inside: u32) -> bool {
        inside >= DEEP && self.source.on_demand().is_some()
    }

    /// Whether a way that goes on inside of so many super-nodes is too long, or what is found is void. Where nothing is listed,
    /// this is how recursion is found to shrink so slowly that it does not come to the size of a pixel.
    #[inline(always)]
    pub(in crate::fast) fn is_too_long(&self, inside: u32, hits: &Hits, way: u32) -> bool {
        if inside >= LONGEST && self.source.on_demand().is_some() {
            self.refuse(Fault::Slow, hits, way);
        }
        self.is_crowded(0, hits, way)
    }

    /// Whether rays that are on a way have come to too many super-nodes, with what they keep for later in operands, in bytes; or
    /// what is found is void.
    #[inline(always)]
    pub(in crate::fast) fn is_crowded(&self, kept: usize, hits: &Hits, way: u32) -> bool {
        if hits.bytes() + kept >= KEPT {
            self.refuse(Fault::Crowded, hits, way);
        }
        self.is_void()
    }

    /// Whether too many questions wait for each other below the operators on a way, or what is found is void.
    #[inline(always)]
    pub(in crate::fast) fn is_bottomless(&self, waiting: usize, hits: &Hits, way: u32) -> bool {
        if waiting > WAITING && self.source.on_demand().is_some() {
            self.refuse(Fault::Bottomless, hits, way);
        }
        self.is_void()
    }

    /// Whether what is found is void.
    #[inline(always)]
    pub(in crate::fast) fn is_void(&self) -> bool {
        self.faults.is_void.get()
    }

    #[cold]
    fn refuse(&self, fault: Fault, hits: &Hits, way: u32) {
        let (above, item) = hits.step(way);
        self.refuse_at(fault, self.item(hits.block(above), item).node);
    }

    #[cold]
    pub(super) fn refuse_at(&self, fault: Fault, node: NodeId) {
        // The first of them is where it became too much.
        if !self.faults.is_void.replace(true) {
            let at = csg_graph::Place { node, expr: None, label: self.source.graph().node_name(node) };
            self.faults.note(Box::new(EvalError { at, fault, values: Vec::new() }));
        }
    }

    /// What was wrong with a state that a ray came to since the last question, if anything was.
    pub(in crate::fast) fn take_fault(&self) -> Option<EvalError> {
        self.faults.go_on();
        self.faults.found.take().map(|fault| *fault)
    }
}
