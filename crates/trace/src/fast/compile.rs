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

use std::sync::OnceLock;

use csg_graph::{AttributeTerm, EvalError, Graph, Primitive, State};
use csg_graph_bounds::Aabb;
use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::Accelerated;
use super::blocks::Granularity;
use super::bounds::Bounds;
use super::compiled::{BYTES, Compiled, Content, Gate, Item, SLAB_BYTES, SuperNode};
use super::instance::{Instance, Paint};
use super::lists::{Lists, SHORTEST};
use super::slabs;
use super::states::{Kind, Resolved, States};
use super::tree::{self, Node};
use super::unions::Unions;
use crate::narrow::index;

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
                let whole = write(lists, &states, None, has_slabs)?;
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
        let root = states.instance(state)?;
        let lists = Lists::block(&mut states, &root, granularity.length)?;
        write(lists, &states, Some(granularity), has_slabs)
    }
}

/// Writes lists into what is compiled, one after the other: all items with their exact boxes, and each list with its tree.
struct Writer<'a> {
    states: &'a States<'a>,
    /// The super-nodes and the solids that states have become.
    supers: FxHashMap<u32, u32>,
    solids: FxHashMap<u32, u32>,
    /// Of a block, which may be a part of what never ends. Of all there is, none.
    granularity: Option<Granularity>,
    /// The gates to states, and the paints that there are already.
    gates: FxHashMap<u32, u32>,
    paints: FxHashMap<SmallVec<[(AttributeTerm, u64); 3]>, u32>,
    compiled: Compiled,
}

/// Compiles lists. Slabs are as much work as the boxes: not for what may soon be forgotten, nor where there are too many
/// states for the budget, nor below operators, which do not ask by way of them.
fn write(
    lists: Lists,
    states: &States<'_>,
    granularity: Option<Granularity>,
    has_slabs: bool,
) -> Result<Compiled, EvalError> {
    let mut slabs_of = if has_slabs { lists.in_unions() } else { Vec::new() }.into_iter();
    let Lists { lists, supers, numbers, solids, .. } = lists;
    let (gates, paints) = (FxHashMap::default(), FxHashMap::default());
    let compiled = Compiled { solids, ..Compiled::default() };
    let mut writer = Writer { states, supers, solids: numbers, granularity, gates, paints, compiled };
    for (clip, list) in lists {
        writer.write(clip, &list, slabs_of.next().unwrap_or(false))?;
    }
    writer.compiled.shrink();
    Ok(writer.compiled)
}

impl Writer<'_> {
    /// Writes a list whose boxes are clipped. What is left without a box is dropped.
    fn write(&mut self, clip: Aabb, list: &[Instance], has_slabs: bool) -> Result<(), EvalError> {
        let (first, first_node) = (self.compiled.items.len(), self.compiled.nodes.len());
        let mut boxes = Vec::with_capacity(list.len());
        let mut reaches = Vec::with_capacity(if has_slabs { list.len() } else { 0 });
        self.compiled.items.reserve(list.len());
        self.compiled.symbols.reserve(list.len());
        for instance in list {
            let bounds = self.box_of(instance)?.intersect(clip);
            if bounds.is_empty() {
                continue;
            }
            boxes.push(bounds);
            if has_slabs {
                reaches.push(self.states.slabs(instance)?);
            }
            self.add_item(instance);
        }
        let leads_on = self.leads_on(first);
        let Compiled { nodes, slabs, supers, .. } = &mut self.compiled;
        let ball = super_node(&mut boxes, first, leads_on, nodes);
        if has_slabs {
            reaches.iter_mut().for_each(|reach| *reach = reach.in_unit(ball.center, ball.to_unit));
            slabs::add(nodes, first_node, first, &reaches, slabs);
        }
        supers.push(ball);
        Ok(())
    }

    fn box_of(&self, instance: &Instance) -> Result<Aabb, EvalError> {
        let bounds = self.states.exact_box(instance)?;
        Ok(match self.granularity {
            Some(Granularity { ahead: ahead @ 1.., .. }) if self.states.is_worth_a_look(instance) => {
                bounds.intersect(self.states.box_ahead(instance, ahead).unwrap_or(Aabb::ALL))
            }
            _ => bounds,
        })
    }

    fn add_item(&mut self, instance: &Instance) {
        let Instance { target, target_from_above: item_from_super, depth, symbol, .. } = *instance;
        let Resolved { state, kind, .. } = self.states.get(instance);
        let content = match kind {
            Kind::Primitive(primitive) => Content::Shape(shape(&mut self.compiled.shapes, primitive)),
            _ => match (self.supers.get(&target), self.solids.get(&target)) {
                (Some(number), _) => Content::Super(*number),
                (_, Some(number)) => Content::Solid(*number),
                (None, None) => Content::Gate(self.gate(target, state)),
            },
        };
        let paint = (!instance.paint.is_empty()).then(|| self.paint(&instance.paint));
        self.compiled.items.push(Item { item_from_super, content, node: state.node(), depth, paint });
        self.compiled.symbols.push(symbol);
    }

    /// The gate to a state that the next item leads to, by way of the first item that does.
    fn gate(&mut self, target: u32, state: &State) -> u32 {
        let Compiled { gates, items, .. } = &mut self.compiled;
        *self.gates.entry(target).or_insert_with(|| {
            let (state, first) = (state.clone(), index(items.len()));
            gates.push(Gate { state, first, sample: OnceLock::new(), class: OnceLock::new() });
            index(gates.len() - 1)
        })
    }

    /// The index of a paint among all.
    fn paint(&mut self, paint: &Paint) -> u32 {
        let paints = &mut self.compiled.paints;
        let key = paint.iter().map(|(term, value)| (*term, value.to_bits())).collect();
        *self.paints.entry(key).or_insert_with(|| {
            paints.push(paint.clone());
            index(paints.len() - 1)
        })
    }

    /// Whether the items from the `first` on are one, which has to be judged by its box though it is alone. So has what leads
    /// on, and what may lead back to itself always does.
    fn leads_on(&self, first: usize) -> bool {
        match self.compiled.items[first..] {
            [Item { content: Content::Super(_) | Content::Gate(_), .. }] => true,
            [Item { content: Content::Solid(_), .. }] => self.granularity.is_some(),
            _ => false,
        }
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
