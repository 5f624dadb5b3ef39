//! A question about rays, and what becomes of what they meet.

use fearless_simd::Simd;

use super::compiled::Compiled;
use super::held::Held;
use super::hits::{Hits, Place};
use super::lanes::transform;
use super::solid::Solids;
use super::tree::{Child, Target};
use crate::Ray;

/// What rays ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ask {
    /// The first hit.
    Nearest,
    /// Any hit.
    Any,
}

/// What rays cost.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Work {
    pub(super) boxes: u64,
    pub(super) primitives: u64,
}

/// A question about the rays of a packet, and where answers go.
pub(super) struct Inquiry<'t> {
    pub(super) held: &'t Held<'t>,
    pub(super) ask: Ask,
    pub(super) hits: &'t mut Hits,
    pub(super) solids: &'t mut Solids,
    pub(super) work: Work,
}

impl Inquiry<'_> {
    /// Notes that a ray meets an item at t. `seen` gives the way that it is on, and the ray there.
    #[inline(always)]
    pub(super) fn answer(&mut self, lane: usize, t: f64, place: Place, seen: impl FnOnce() -> (u32, Ray)) {
        match self.ask {
            Ask::Nearest => self.hits.offer(lane, t, place, seen),
            Ask::Any if t < self.hits.t.0[lane] => self.hits.stop(lane, place),
            Ask::Any => {}
        }
    }

    /// Whether a child of a super-node, whose box a ray meets at t, is too small to be looked into.
    #[inline(always)]
    pub(super) fn is_small(&self, block: &Compiled, way: u32, child: Child, t: f64) -> bool {
        let Some(detail) = &self.hits.detail else { return false };
        match child.target() {
            Target::Item(item) => detail.hides_part(way, &block.parts[item], t),
            Target::Node(node) => detail.hides(way, block.nodes[node].size, t),
        }
    }

    /// Lets a ray in a super-node meet the box of a child at t, if what is in there stops it.
    #[inline(never)]
    pub(super) fn meet_small(&mut self, lane: usize, (way, child): (u32, Child), ray: &Ray, t: f64) {
        let number = self.hits.block(way);
        let Some(detail) = &mut self.hits.detail else { return };
        if detail.leaves(way, ray, t) {
            return;
        }
        let cover = self.held.cover(number, child, ray.direction);
        if cover.is_none_or(|[cover, apart]| detail.stops(lane, ray, cover, apart)) {
            self.answer(lane, t, Place::box_of(way, child), || (way, *ray));
        }
    }

    /// Asks a solid, an item of a super-node, about a ray in the frame of that.
    #[inline(always)]
    pub(super) fn ask_solid<S: Simd>(&mut self, simd: S, lane: usize, ray: &Ray, solid: u32, place: Place) {
        let end = self.hits.t.0[lane];
        let item = self.held.item(self.hits.block(place.way), place.item);
        let inside = transform(ray, &item.item_from_super);
        let ways = self.hits.way_count();
        let first = self.solids.first(simd, self.held, self.hits, (solid, place), &inside, end);
        // Which of several faces it is, is asked once it is known that it is seen.
        let face = first.map(|(_, face)| if self.solids.tied { place } else { face });
        let face = self.hits.forget(ways, face);
        if let (Some((t, _)), Some(face)) = (first, face) {
            self.answer(lane, t, face, || (place.way, *ray));
        }
    }
}
