//! What a graph is compiled to: [super-nodes](SuperNode), states with what is below them written out as lists of
//! [items](Item), and a tree of boxes over each list.
//!
//! All of one kind is in one vector, and indices lead from one to the other, in 32 bits: what a ray meets is close together,
//! and half as large as pointers would make it.

use std::sync::{Arc, OnceLock};

use csg_graph::{EvalError, NodeId, Operator, Primitive, State};
use glam::{DAffine3, DVec3};

use super::cover::Cover;
use super::detail::Part;
use super::instance::Paint;
use super::look::Looks;
use super::sample::Sample;
use super::slabs::Slabs;
use super::survey::demand::Class;
use super::survey::outline::Outline;
use super::tree::{self, Child, Node};

/// A graph compiled for tracing, or a block of it.
#[derive(Debug, Default)]
pub(super) struct Compiled {
    pub(super) supers: Vec<SuperNode>,
    pub(super) nodes: Vec<Node>,
    /// What nodes have beside the boxes of their children.
    pub(super) slabs: Vec<Slabs>,
    pub(super) items: Vec<Item>,
    pub(super) shapes: Vec<Primitive>,
    pub(super) solids: Vec<Solid>,
    /// Where other blocks begin.
    pub(super) gates: Vec<Gate>,
    /// How large all items are, if rays may see it.
    pub(super) parts: Vec<Part>,
    /// And what is seen of what is too small.
    pub(super) looks: Looks,
    /// What is measured of a block of listed states once somebody comes to a small part of it, and the covers of all that.
    pub(super) measured: Vec<Child>,
    pub(super) covers: OnceLock<Box<[Cover]>>,
    pub(super) paints: Vec<Paint>,
    /// Of each item, the state of the last S-node between, by its place among all states; not among the items, where rays
    /// would carry it along.
    pub(super) symbols: Vec<Option<u32>>,
    /// Whether there are parts of it that coordinates do not tell apart.
    pub(super) is_too_fine: bool,
}

/// A state with what is below it written out.
#[derive(Clone, Debug)]
pub(super) struct SuperNode {
    /// The ball around it, in the frame of the state.
    pub(super) center: DVec3,
    pub(super) radius: f64,
    /// One by the radius.
    pub(super) to_unit: f64,
    /// How far its items reach: the radius, or infinitely far if some are unbounded.
    pub(super) reach: f64,
    /// Where its tree begins; `None` if it is empty.
    pub(super) root: Option<Child>,
}

/// The result of ∩ or \\.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    pub(super) operator: Operator,
    /// The operands, super-nodes in the frame of the solid.
    pub(super) operands: [u32; 2],
}

/// A state that has a block of its own.
#[derive(Debug)]
pub(super) struct Gate {
    pub(super) state: State,
    /// The first of the items that lead there.
    pub(super) first: u32,
    /// What is seen of it from afar, or what is wrong with it, once somebody has seen it.
    pub(super) sample: OnceLock<Result<Box<Sample>, Box<EvalError>>>,
    /// And those that it has its cover in common with, if any.
    pub(super) class: OnceLock<Option<Arc<Class>>>,
}

/// A part of a super-node.
#[derive(Clone, Debug)]
pub(super) struct Item {
    /// From the frame of the super-node into that of the item.
    pub(super) item_from_super: DAffine3,
    pub(super) content: Content,
    /// The node of a primitive.
    pub(super) node: NodeId,
    /// S-nodes between.
    pub(super) depth: u32,
    /// An index into the paints.
    pub(super) paint: Option<u32>,
}

/// What an item is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// An index into the shapes.
    Shape(u32),
    /// An index into the super-nodes.
    Super(u32),
    /// The first super-node of another block: an index into the gates.
    Gate(u32),
    /// The result of ∩ or \\: an index into the solids.
    Solid(u32),
}

/// What an item takes with its share of the tree.
pub(super) const BYTES: usize = size_of::<Item>() + size_of::<Node>() / 5;

/// And what slabs add to that.
pub(super) const SLAB_BYTES: usize = size_of::<Slabs>() / 4;

impl Compiled {
    /// Opens all boxes, unless small parts are judged by theirs.
    pub(super) fn without_boxes(mut self) -> Self {
        assert!(self.parts.is_empty(), "by its box is told what is small");
        for node in &mut self.nodes {
            let [lower, upper] = [f32::NEG_INFINITY, f32::INFINITY].map(|plane| [plane; tree::WIDTH]);
            node.planes = [lower, lower, lower, upper, upper, upper];
        }
        self.slabs.clear();
        for ball in &mut self.supers {
            ball.reach = f64::INFINITY;
        }
        self
    }

    /// The memory that it takes for rays; what is looked up for hits alone is not counted.
    pub(super) fn bytes(&self) -> usize {
        let Self { supers, nodes, slabs, items, shapes, solids, parts, looks, .. } = self;
        size_of_val(&**supers)
            + size_of_val(&**nodes)
            + size_of_val(&**slabs)
            + size_of_val(&**items)
            + shapes.iter().map(Primitive::bytes).sum::<usize>()
            + size_of_val(&**solids)
            + size_of_val(&**parts)
            + looks.bytes()
    }

    /// All the memory that it takes, more or less.
    pub(super) fn all_bytes(&self) -> usize {
        // What an allocator adds to each piece of memory, and how many pieces there are but for gates and hulls.
        const HEADER: usize = 16;
        const PIECES: usize = 10;
        let Self { parts, measured, gates, paints, symbols, .. } = self;
        let gate = |gate: &Gate| size_of_val(gate) + gate.state.bytes() + size_of::<Sample>() + 2 * HEADER;
        let gates = gates.iter().map(gate);
        let covers = (size_of::<Child>() + size_of::<Cover>()) * measured.len();
        let outlines = parts.iter().filter(|part| part.outline.is_some()).count();
        let heap = |paint: &Paint| if paint.spilled() { size_of_val(&**paint) } else { 0 };
        let paints = paints.iter().map(|paint| size_of_val(paint) + heap(paint));
        size_of::<Self>()
            + PIECES * HEADER
            + self.bytes()
            + covers
            + outlines * (size_of::<Outline>() + HEADER)
            + gates.sum::<usize>()
            + paints.sum::<usize>()
            + size_of_val(&**symbols)
    }

    /// Gives back memory that was asked for and is not used.
    pub(super) fn shrink(&mut self) {
        let Self { supers, nodes, slabs, items, shapes, solids, gates, paints, symbols, .. } = self;
        if symbols.iter().all(Option::is_none) {
            symbols.clear();
        }
        supers.shrink_to_fit();
        nodes.shrink_to_fit();
        slabs.shrink_to_fit();
        items.shrink_to_fit();
        shapes.shrink_to_fit();
        solids.shrink_to_fit();
        gates.shrink_to_fit();
        paints.shrink_to_fit();
        symbols.shrink_to_fit();
    }
}
