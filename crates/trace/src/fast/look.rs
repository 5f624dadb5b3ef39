//! What is seen of all that is below a node of a tree.
//!
//! Where a node is too small to be looked into, its box is met in place of what is in it. Of the rays through that box only
//! some would have been stopped, and what they would have seen is a matter of chance: so for each node it is
//! [measured](super::survey) what its [cover](super::cover) is, and some of what lines meet there is remembered.

use csg_graph::{AttributeTerm, NodeId};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use super::compiled::{Compiled, Content};
use super::cover::{CELLS, Cover};
use super::hits::Place;
use super::sample::Dice;
use super::survey::Surveyed;
use super::tree::{Child, Target};
use crate::narrow::{index, narrow};

/// What is seen of all nodes and items.
#[derive(Debug, Default)]
pub(super) struct Looks {
    nodes: Vec<Look>,
    /// Each is there once.
    covers: Vec<Cover>,
    pub(super) paints: Vec<Vec<(AttributeTerm, f64)>>,
}

/// What lines meet below a node.
#[derive(Clone, Debug, Default)]
pub(super) struct Look {
    seen: Vec<Seen>,
}

/// A face of a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) normal: Vec3,
    pub(super) node: NodeId,
    /// S-nodes on the way to it.
    pub(super) depth: u32,
    /// What paints it: an index into the paints.
    pub(super) paint: u32,
    /// The part of the light to it that comes through what is around it.
    pub(super) open: f32,
}

impl Looks {
    pub(super) fn bytes(&self) -> usize {
        let seen = self.nodes.iter().map(|look| size_of_val(&*look.seen));
        size_of_val(&*self.nodes) + seen.sum::<usize>() + size_of_val(&*self.covers)
    }
}

impl Look {
    pub(super) fn new(seen: Vec<Seen>) -> Self {
        Self { seen }
    }

    /// Whether any line has met something.
    pub(super) fn is_seen(&self) -> bool {
        !self.seen.is_empty()
    }

    /// Draws one of the faces as a ray would meet them. Its normal is turned to the ray.
    pub(super) fn draw(&self, direction: DVec3, dice: &mut Dice) -> Option<Seen> {
        if self.seen.is_empty() {
            return None;
        }
        let direction = direction.as_vec3();
        let facing = |seen: &Seen| f64::from(-seen.normal.dot(direction)).max(0.0);
        let drawn = self.seen[dice.draw(self.seen.iter().map(facing))];
        let normal = if drawn.normal.dot(direction) > 0.0 { -drawn.normal } else { drawn.normal };
        Some(Seen { normal, ..drawn })
    }
}

impl Compiled {
    /// What is seen of an item or a node that is not looked into, if it was measured. It is in the frame of the item, and
    /// of one that leads to a super-node what is seen of the first node of its tree.
    pub(super) fn look(&self, place: Place) -> Option<&Look> {
        let at = place.item as usize;
        let node = match self.items.get(at).map(|item| item.content) {
            _ if place.is_node => at,
            Some(Content::Super(number)) => self.root_node(number)?,
            _ => return None,
        };
        self.looks.nodes.get(node)
    }

    /// How many of the rays that meet the box of a child of a node, and its slabs, are stopped, if it was measured.
    pub(super) fn cover(&self, child: Child) -> Option<&Cover> {
        self.looks.covers.get(self.place_of_cover(child) as usize)
    }

    /// The place of the cover of a child of a node among all, if it has one.
    pub(super) fn place_of_cover(&self, child: Child) -> u32 {
        match child.target() {
            Target::Item(item) => self.parts[item].cover,
            Target::Node(node) => self.nodes[node].cover,
        }
    }

    /// Keeps what was measured.
    pub(super) fn with_looks(mut self, found: Surveyed) -> Self {
        let Surveyed { bounds, looks, nodes, items, paints } = found;
        let mut covers = Vec::new();
        let mut numbers: FxHashMap<([u32; CELLS], u32), u32> = FxHashMap::default();
        let mut number = |cover: Cover| {
            let key = (cover.cells.map(f32::to_bits), cover.apart.to_bits());
            *numbers.entry(key).or_insert_with(|| {
                covers.push(cover);
                index(covers.len() - 1)
            })
        };
        // What no line has met is looked into, as far as there are digits.
        let is_unseen = |node: usize| bounds[node].is_bounded() && !looks[node].is_seen();
        for (at, cover) in items.into_iter().enumerate() {
            let is_unseen = match self.items[at].content {
                Content::Super(number) => self.root_node(number).is_none_or(is_unseen),
                _ => false,
            };
            match cover.filter(|_| !is_unseen) {
                Some(cover) => self.parts[at].cover = number(cover),
                None => self.parts[at].is_unseen = true,
            }
        }
        for (at, cover) in nodes.into_iter().enumerate() {
            if looks[at].is_seen() {
                self.nodes[at].size = narrow(bounds[at].size().length());
                self.nodes[at].cover = number(cover);
            }
        }
        self.looks = Looks { nodes: looks, covers, paints };
        self
    }

    /// The node at the root of the tree of a super-node, if it has one.
    pub(super) fn root_node(&self, number: u32) -> Option<usize> {
        self.supers[number as usize].root?.as_node()
    }

    /// The super-nodes, each behind those that its items lead to.
    pub(super) fn upwards(&self) -> Vec<u32> {
        let mut is_open = vec![false; self.supers.len()];
        let mut order = Vec::new();
        let mut open = Vec::new();
        // Those of operands are led to by no item.
        for first in 0..index(self.supers.len()) {
            if !std::mem::replace(&mut is_open[first as usize], true) {
                open.push((first, self.leads_to(first)));
            }
            while let Some((number, below)) = open.last_mut() {
                match below.pop() {
                    Some(next) if is_open[next as usize] => {}
                    Some(next) => {
                        is_open[next as usize] = true;
                        open.push((next, self.leads_to(next)));
                    }
                    None => {
                        order.push(*number);
                        open.pop();
                    }
                }
            }
        }
        order
    }

    fn leads_to(&self, number: u32) -> Vec<u32> {
        let mut found: Vec<u32> = self
            .items_of(number)
            .filter_map(|item| match self.items[item].content {
                Content::Super(number) => Some(number),
                _ => None,
            })
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The nodes of the tree of a super-node, each before those below it.
    pub(super) fn nodes_of(&self, number: u32) -> Vec<usize> {
        let mut nodes: Vec<usize> = self.root_node(number).into_iter().collect();
        let mut next = 0;
        while let Some(at) = nodes.get(next) {
            nodes.extend(self.children(*at).filter_map(Child::as_node));
            next += 1;
        }
        nodes
    }

    pub(super) fn items_of(&self, number: u32) -> impl Iterator<Item = usize> {
        let alone = self.supers[number as usize].root.and_then(Child::as_item);
        let nodes = self.nodes_of(number);
        let below = nodes.into_iter().flat_map(|node| self.children(node).filter_map(Child::as_item));
        alone.into_iter().chain(below)
    }

    pub(super) fn children(&self, node: usize) -> impl Iterator<Item = Child> + use<> {
        let node = &self.nodes[node];
        node.children.into_iter().take(node.slots().len())
    }
}
