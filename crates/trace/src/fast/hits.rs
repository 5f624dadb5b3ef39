//! What the rays of a packet have hit so far.
//!
//! A hit is an item and the way to it: the items that were entered, one inside of the other. The ways of a packet are kept
//! as a tree, so that noting a hit costs nothing in proportion to its depth; normals and surfaces are found afterwards,
//! for the hits that remain.

use glam::DVec3;
use smallvec::SmallVec;

use super::compiled::Compiled;
use super::detail::{Detail, Stretch};
use super::lanes::{LANES, Lanes};
use super::tree::{Child, Target};
use crate::Ray;
use crate::narrow::index;

/// Where a way begins: at the root.
pub(super) const START: u32 = 0;

/// The block of the root.
pub(super) const ROOT: u32 = 0;

/// The hits of a packet.
#[derive(Debug)]
pub(super) struct Hits {
    /// The parameter of each ray's first hit so far, or of its end.
    pub(super) t: Lanes,
    /// The item that is hit, and the way to it.
    found: [Option<Place>; LANES],
    /// Each ray as it was when it last hit something, and the way it was on.
    seen: [(u32, Ray); LANES],
    ways: Vec<Way>,
    /// How large things are along the ways, if that matters.
    pub(super) detail: Option<Detail>,
    /// Counts all changes of t.
    pub(super) changes: u32,
}

/// What was entered, and from where.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// The way that it goes on from.
    above: u32,
    /// The item that it enters.
    item: u32,
    /// The block that it comes to.
    block: u32,
}

/// Ways that many packets begin with.
#[derive(Debug, Default)]
pub(super) struct Trail {
    ways: Vec<Way>,
    stretches: Vec<Stretch>,
}

/// An item of a super-node that was come to on some way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) way: u32,
    pub(super) item: u32,
    /// Whether the solid is on the outer side of what is hit there: it is the face of something subtracted.
    pub(super) turned: bool,
    /// Whether the item was too small to be looked into, so that its box is met.
    pub(super) is_small: bool,
    /// Whether that was a node above items: then `item` is its index.
    pub(super) is_node: bool,
}

impl Place {
    pub(super) const NONE: Self =
        Self { way: START, item: 0, turned: false, is_small: false, is_node: false };

    #[inline(always)]
    pub(super) fn new(way: u32, item: usize) -> Self {
        let item = u32::try_from(item).expect("items are numbered in 31 bits");
        Self { way, item, turned: false, is_small: false, is_node: false }
    }

    /// Whether it is on the same item, come to by the same way.
    #[inline(always)]
    pub(super) fn is_one_with(self, other: Self) -> bool {
        (self.way, self.item, self.is_small, self.is_node)
            == (other.way, other.item, other.is_small, other.is_node)
    }

    /// The box of the item.
    pub(super) fn as_box(self) -> Self {
        Self { is_small: true, ..self }
    }

    /// The box of a child of a super-node that a way leads to.
    pub(super) fn box_of(way: u32, child: Child) -> Self {
        match child.target() {
            Target::Item(item) => Self::new(way, item).as_box(),
            Target::Node(node) => Self { is_node: true, ..Self::new(way, node) }.as_box(),
        }
    }
}

impl Trail {
    /// None.
    pub(super) fn clear(&mut self) {
        self.ways.clear();
        self.stretches.clear();
    }

    /// Those that there are now.
    pub(super) fn keep(&mut self, hits: &Hits) {
        self.ways.clone_from(&hits.ways);
        self.stretches.clear();
        self.stretches.extend(hits.detail.iter().flat_map(Detail::stretches));
    }

    /// Whether it can be followed by hits as they are.
    pub(super) fn is_for(&self, hits: &Hits) -> bool {
        hits.detail.is_some() != self.stretches.is_empty()
    }
}

impl Hits {
    pub(super) fn new() -> Self {
        let nowhere = Ray { origin: DVec3::ZERO, direction: DVec3::ZERO };
        let seen = [(START, nowhere); LANES];
        Self { t: Lanes::ZERO, found: [None; LANES], seen, ways: Vec::new(), detail: None, changes: 0 }
    }

    /// Starts over.
    pub(super) fn clear(&mut self, ends: [f64; LANES]) {
        self.t = Lanes(ends);
        self.found = [None; LANES];
        self.ways.clear();
        self.ways.push(Way { above: START, item: 0, block: ROOT });
        self.changes = 0;
        if let Some(detail) = &mut self.detail {
            detail.clear();
        }
    }

    /// Goes on from some ways.
    pub(super) fn follow(&mut self, trail: &Trail) {
        if !trail.ways.is_empty() {
            self.ways.clone_from(&trail.ways);
            if let Some(detail) = &mut self.detail {
                detail.follow(&trail.stretches);
            }
        }
    }

    /// The way that one goes on from, and the item that it enters.
    #[inline(always)]
    pub(super) fn step(&self, way: u32) -> (u32, u32) {
        let Way { above, item, .. } = self.ways[way as usize];
        (above, item)
    }

    /// What the ways take, in bytes.
    #[inline(always)]
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.ways) + self.detail.as_ref().map_or(0, |detail| size_of_val(detail.stretches()))
    }

    /// How many ways there are.
    pub(super) fn way_count(&self) -> usize {
        self.ways.len()
    }

    /// Forgets the ways from one on, but for those to a place if there is one, which is the same place then. Nobody else must
    /// know of them.
    pub(super) fn forget(&mut self, first: usize, place: Option<Place>) -> Option<Place> {
        let mut kept: SmallVec<[u32; 32]> = SmallVec::new();
        let mut way = place.map_or(START, |place| place.way);
        while way as usize >= first {
            kept.push(way);
            way = self.ways[way as usize].above;
        }
        // Each is behind the one that it goes on from, and none of them moves back.
        let mut end = first;
        for from in kept.into_iter().rev() {
            self.ways[end] = Way { above: way, ..self.ways[from as usize] };
            if let Some(detail) = &mut self.detail {
                detail.move_way(from, end);
            }
            way = index(end);
            end += 1;
        }
        self.ways.truncate(end);
        if let Some(detail) = &mut self.detail {
            detail.forget(end);
        }
        place.map(|place| Place { way, ..place })
    }

    /// The way that enters the item of a place, which is in `from`, and is in a block then.
    #[inline(always)]
    pub(super) fn enter(&mut self, place: Place, from: &Compiled, block: u32) -> u32 {
        if let Some(detail) = &mut self.detail {
            detail.enter(place.way, &from.parts[place.item as usize]);
        }
        self.ways.push(Way { above: place.way, item: place.item, block });
        u32::try_from(self.ways.len() - 1).expect("2³² super-nodes on the way of one packet outgrow memory")
    }

    /// Takes a hit if it is before the one that is known, or at the same t and left of it in the graph. `seen` gives the way
    /// that the ray is on, and the ray there.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "what differs by an ulp is not at the same t")]
    pub(super) fn offer(&mut self, lane: usize, t: f64, place: Place, seen: impl FnOnce() -> (u32, Ray)) {
        let best = self.t.0[lane];
        if t < best || t == best && self.is_left(place, self.found[lane]) {
            self.t.0[lane] = t;
            self.found[lane] = Some(place);
            self.seen[lane] = seen();
            self.changes += 1;
        }
    }

    /// Ends a ray, which has hit something.
    #[inline(always)]
    pub(super) fn stop(&mut self, lane: usize, place: Place) {
        self.t.0[lane] = f64::NEG_INFINITY;
        self.found[lane] = Some(place);
        self.changes += 1;
    }

    pub(super) fn found(&self, lane: usize) -> Option<Place> {
        self.found[lane]
    }

    /// The ray of a lane in the super-node of a place, if the ray was there when it last hit something.
    #[inline(always)]
    pub(super) fn ray_at(&self, lane: usize, place: Place) -> Option<&Ray> {
        let (way, ray) = &self.seen[lane];
        (*way == place.way).then_some(ray)
    }

    /// The block that a way has come to.
    #[inline(always)]
    pub(super) fn block(&self, way: u32) -> u32 {
        self.ways[way as usize].block
    }

    /// The items that a place was come to by, with their blocks, its own first if it is one, the first one last.
    #[inline(always)]
    pub(super) fn upwards(&self, place: Place) -> impl Iterator<Item = (u32, u32)> {
        let above = |(way, _): &(u32, u32)| {
            (*way != START).then(|| self.ways[*way as usize]).map(|Way { above, item, .. }| (above, item))
        };
        let items = std::iter::successors(Some((place.way, place.item)), above).skip(place.is_node.into());
        items.map(|(way, item)| (self.block(way), item))
    }

    /// The same items, the first one first.
    pub(super) fn items(&self, place: Place, items: &mut Vec<(u32, u32)>) {
        items.clear();
        items.extend(self.upwards(place));
        items.reverse();
    }

    /// Whether two places are the same in the graph, where it may have been come to more than once.
    #[inline(always)]
    pub(super) fn is_same(&self, mut place: Place, mut other: Place) -> bool {
        while place.item == other.item {
            if place.way == other.way {
                return true;
            }
            let [Way { above, item, block }, other_way] =
                [place.way, other.way].map(|way| self.ways[way as usize]);
            if block != other_way.block || place.way == START || other.way == START {
                return false;
            }
            (place.way, place.item) = (above, item);
            (other.way, other.item) = (other_way.above, other_way.item);
        }
        false
    }

    /// Whether a place is left of another one in the graph. The items of a super-node are in the order of the graph.
    #[cold]
    pub(super) fn is_left(&self, place: Place, of: Option<Place>) -> bool {
        let Some(of) = of else { return false };
        let (mut one, mut other) = (Vec::new(), Vec::new());
        self.items(place, &mut one);
        self.items(of, &mut other);
        one < other
    }
}
