//! From states to super-nodes: the graph as a ray finds it fastest.
//!
//! Following one state at a time, as the [reference walk](crate::Walk) does, a ray meets a transformation and a box at each
//! step. Here a state is *opened*: what is below it is written out into one list of items, the largest by surface area
//! first, until the list is as long as memory allows. The items are primitives and the states where the list breaks off,
//! each with the product of the transformations on its way; a [tree](super::tree) of exact boxes makes them fast to
//! search. Each state where some list breaks off is opened likewise, once, however many lists lead to it. This is partial
//! re-braiding \[BENT17\] over a graph that is cyclic, and the entry states of \[TRAX95\] §4 with a tree instead of a grid.
//!
//! The result of ∩ or \\ is an item, too: a *solid*, compiled once for each state, with a list and a tree for each of its
//! operands, in its own frame. As nothing of an operand matters outside of the result, their boxes are clipped by that of
//! the result, Cameron's S-bounds \[CAME89\] within one operator; what is left without a box is dropped.
//!
//! Nothing is unfolded: the work and the memory are the number of such states times the length of a list, and the lists
//! become shorter the more states there are. Where there are too many for any list, [blocks](super::blocks) are compiled
//! when rays come to them: one state opened, with *gates* to the blocks of the states where its list breaks off.

use std::sync::{Arc, OnceLock};

use csg_graph::{AttributeTerm, EvalError, Graph, NodeId, Operator, Primitive, State};
use csg_graph_bounds::Aabb;
use glam::{DAffine3, DVec3};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::Accelerated;
use super::blocks::Granularity;
use super::bounds::Bounds;
use super::cover::Cover;
use super::detail::Part;
use super::lists::{Lists, SHORTEST};
use super::look::Looks;
use super::sample::Sample;
use super::slabs::{self, Slabs};
use super::states::{Kind, Paint, Place, Resolved, States};
use super::survey::demand::Class;
use super::survey::outline::Outline;
use super::tree::{self, Child, Node};
use super::unions::Unions;
use crate::narrow::index;

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
const SLAB_BYTES: usize = size_of::<Slabs>() / 4;

impl Compiled {
    /// Compiles a whole graph within a budget of bytes, as far as the number of states allows.
    pub(super) fn whole(graph: &Graph, bounds: Bounds<'_>, budget: usize) -> Result<Self, EvalError> {
        let unions = Unions::new(graph);
        let (mut states, root) = States::all(graph, &unions, bounds)?;
        let affordable = budget / (BYTES + SLAB_BYTES);
        let mut length = affordable.max(SHORTEST);
        loop {
            // A try is given up as soon as it does not fit, so that all of them cost about as much as the last.
            if let Some(lists) = Lists::whole(&mut states, &root, length, affordable)? {
                let has_slabs = lists.total <= affordable;
                let whole = Self::close(lists, &states, None, has_slabs)?;
                let is_too_fine = bounds.finest() < Accelerated::FINEST;
                return Ok(if is_too_fine { Self { is_too_fine, ..whole.with_parts() } } else { whole });
            }
            length = (length / 2).max(SHORTEST);
        }
    }

    /// Compiles the block of a state.
    pub(super) fn block(
        graph: &Graph,
        bounds: Bounds<'_>,
        unions: &Unions,
        state: State,
        granularity: Granularity,
    ) -> Result<Self, EvalError> {
        // Listed states are few, and rays come to the same blocks again and again.
        let has_slabs = matches!(bounds, Bounds::Exact(_));
        // The items, and the unions above them.
        let mut states = States::new(graph, unions, bounds, 2 * granularity.length);
        let root = states.place(state)?;
        let lists = Lists::block(&mut states, &root, granularity.length)?;
        Self::close(lists, &states, Some(granularity), has_slabs)
    }

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

    /// Gives all entries their exact boxes and each list its tree: of all there is, or of a block of some granularity, which
    /// may be a part of what never ends. Slabs are as much work as the boxes: not for what may soon be forgotten, nor where
    /// there are too many states for the budget, nor below operators, which do not ask by way of them.
    fn close(
        lists: Lists,
        states: &States<'_>,
        granularity: Option<Granularity>,
        has_slabs: bool,
    ) -> Result<Self, EvalError> {
        let mut slabs_of = if has_slabs { lists.in_unions() } else { Vec::new() }.into_iter();
        let Lists { lists, supers, numbers, solids, .. } = lists;
        let mut compiled = Self { solids, ..Self::default() };
        let mut gates: FxHashMap<u32, u32> = FxHashMap::default();
        let mut painted: FxHashMap<SmallVec<[(AttributeTerm, u64); 3]>, u32> = FxHashMap::default();
        for (clip, list) in lists {
            let (first, first_node) = (compiled.items.len(), compiled.nodes.len());
            let mut boxes = Vec::with_capacity(list.len());
            let has_slabs = slabs_of.next().unwrap_or(false);
            let mut reaches = Vec::with_capacity(if has_slabs { list.len() } else { 0 });
            compiled.items.reserve(list.len());
            compiled.symbols.reserve(list.len());
            for place in list {
                let mut bounds = states.exact_box(&place)?.intersect(clip);
                if let Some(Granularity { ahead: ahead @ 1.., .. }) = granularity
                    && states.is_worth_a_look(&place)
                {
                    bounds = bounds.intersect(states.box_ahead(&place, ahead).unwrap_or(Aabb::ALL));
                }
                if bounds.is_empty() {
                    continue;
                }
                boxes.push(bounds);
                if has_slabs {
                    reaches.push(states.slabs(&place)?);
                }
                let Resolved { state, kind, .. } = states.get(&place);
                let content = match kind {
                    Kind::Primitive(primitive) => Content::Shape(shape(&mut compiled.shapes, primitive)),
                    _ => match (supers.get(&place.target), numbers.get(&place.target)) {
                        (Some(number), _) => Content::Super(*number),
                        (_, Some(number)) => Content::Solid(*number),
                        (None, None) => Content::Gate(*gates.entry(place.target).or_insert_with(|| {
                            let (state, first) = (state.clone(), index(compiled.items.len()));
                            let (sample, class) = (OnceLock::new(), OnceLock::new());
                            compiled.gates.push(Gate { state, first, sample, class });
                            index(compiled.gates.len() - 1)
                        })),
                    },
                };
                let paint = (!place.paint.is_empty()).then(|| {
                    let key = place.paint.iter().map(|(term, value)| (*term, value.to_bits())).collect();
                    *painted.entry(key).or_insert_with(|| {
                        compiled.paints.push(place.paint.clone());
                        index(compiled.paints.len() - 1)
                    })
                });
                let Place { target_from_above: item_from_super, depth, symbol, .. } = place;
                let node = state.node();
                compiled.items.push(Item { item_from_super, content, node, depth, paint });
                compiled.symbols.push(symbol);
            }
            // What leads on has a box to be judged by even if it is alone, and what may lead back to itself always leads on.
            let leads_on = match compiled.items[first..] {
                [Item { content: Content::Super(_) | Content::Gate(_), .. }] => true,
                [Item { content: Content::Solid(_), .. }] => granularity.is_some(),
                _ => false,
            };
            let ball = super_node(&mut boxes, first, leads_on, &mut compiled.nodes);
            if has_slabs {
                reaches.iter_mut().for_each(|reach| *reach = reach.in_unit(ball.center, ball.to_unit));
                slabs::add(&mut compiled.nodes, first_node, first, &reaches, &mut compiled.slabs);
            }
            compiled.supers.push(ball);
        }
        compiled.shrink();
        Ok(compiled)
    }

    /// Gives back memory that was asked for and is not used.
    fn shrink(&mut self) {
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

/// The super-node whose items, the `first` and those behind it, have these boxes. If there is one and it does not lead on,
/// it needs no node.
fn super_node(boxes: &mut [Aabb], first: usize, leads_on: bool, nodes: &mut Vec<Node>) -> SuperNode {
    let (bounded, unbounded): (Vec<Aabb>, Vec<Aabb>) = boxes.iter().partition(|bounds| bounds.is_bounded());
    let all = bounded.into_iter().reduce(Aabb::join);
    let (center, radius) = all.map_or((DVec3::ZERO, 0.0), |all| (all.center(), 0.5 * all.size().length()));
    // A unit of any size for boxes without one.
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let reach = if unbounded.is_empty() { radius } else { f64::INFINITY };
    for bounds in &mut *boxes {
        *bounds = Aabb::new((bounds.min - center) / radius, (bounds.max - center) / radius);
    }
    let root = match boxes {
        [] => None,
        [alone] if leads_on => Some(tree::node_of_one(*alone, first, nodes)),
        _ => Some(tree::build(boxes, first, nodes)),
    };
    SuperNode { center, radius, to_unit: 1.0 / radius, reach, root }
}

/// The index of a shape among all; one of the last is not added again.
fn shape(shapes: &mut Vec<Primitive>, shape: &Primitive) -> u32 {
    const LAST: usize = 8;
    let recent = shapes.len().saturating_sub(LAST);
    let known = shapes[recent..].iter().position(|known| known == shape);
    index(known.map(|at| recent + at).unwrap_or_else(|| {
        shapes.push(shape.clone());
        shapes.len() - 1
    }))
}
