//! Sixteen rays through super-nodes together: each box at once against all of them.
//!
//! Before that, all boxes of a node are tested at once against the *tube* of the packet: one line, with as much slack as the
//! rays are apart from it. Only what it may meet is tested against the rays, the nearest last, so that it is on top of the
//! stack. Both are tested against the [slabs](super::slabs) of boxes that they meet, where there are any.
//!
//! Neighbouring rays of a picture meet the same boxes. They share what is the same for all, memory, branches and the order
//! of the children, and the arithmetic is done in vectors. Where only a few are left, they go on [alone](super::single).
//!
//! The rays of a packet need not agree in the signs of their directions, but the test of a box has near and far planes;
//! so those that agree go together, and at each super-node, whose frame may be turned, they are sorted anew.

use csg_graph::Primitive;
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, f64x8, mask32x16};
use smallvec::SmallVec;

use super::compiled::{Compiled, Content, Item, SuperNode};
use super::cuts::{Cuts, Firsts};
use super::entry::{Entries, Entry};
use super::frame::NarrowRays;
use super::hits::{Place, START};
use super::inquiry::Inquiry;
use super::lanes::{HALF, LANES, Lanes, Mask, Rays, bits, each, transform};
use super::line::{Floats, Line, float_bits, load};
use super::shapes;
use super::single::{self, Single};
use super::tree::{Child, Node, Target, WIDTH};

/// All children of a node.
const ALL_SLOTS: u32 = (1 << WIDTH) - 1;

/// With fewer rays than this, each goes on alone.
const FEW: u32 = 4;

/// The rays of one sign of direction that meet a box.
#[derive(Clone, Copy, Debug)]
struct Open {
    /// Where each meets it; infinite for the others.
    near: Floats,
    child: Child,
    level: u32,
    /// Which coordinates fall.
    falling: [bool; 3],
}

/// The memory of packets.
#[derive(Debug, Default)]
pub(super) struct Packet {
    /// The rays on each way that they may begin with, which of these they have been moved to, and which are on the way.
    begin: Vec<Rays>,
    is_begun: Vec<bool>,
    due: Vec<u32>,
    levels: Vec<NarrowRays>,
    stack: Vec<Open>,
    single: Single,
    cuts: Cuts,
}

impl Packet {
    /// The rays of the next packet.
    pub(super) fn rays(&mut self) -> &mut Rays {
        if self.levels.is_empty() {
            self.levels.push(NarrowRays::EMPTY);
            self.begin.push(Rays::ZERO);
        }
        &mut self.begin[0]
    }

    /// Follows the rays of the set from where they begin.
    #[inline(always)]
    pub(super) fn trace<S: Simd, const DETAIL: bool>(
        &mut self,
        simd: S,
        inquiry: &mut Inquiry<'_>,
        lanes: Mask,
        entries: &Entries,
    ) {
        let count = inquiry.hits.way_count();
        if self.begin.len() < count {
            self.begin.resize(count, Rays::ZERO);
        }
        self.is_begun.clear();
        self.is_begun.resize(count, false);
        self.is_begun[START as usize] = true;
        let window = entries.window_of(&self.begin[START as usize]);
        for entry in entries.list.iter().filter(|entry| entry.is_seen(&window)) {
            let mut before = 0;
            for half in 0..2 {
                let is_before = inquiry.hits.t.half(simd, half).simd_ge(f64x8::splat(simd, entry.near()));
                before |= bits(is_before) << (half * HALF);
            }
            if lanes & before != 0 {
                self.begin_at(simd, inquiry, entry.way);
                self.trace_from::<S, DETAIL>(simd, inquiry, lanes & before, entry);
            }
        }
    }

    /// Moves the rays to where a way leads, as far as they have not come yet.
    #[inline(always)]
    fn begin_at<S: Simd>(&mut self, simd: S, inquiry: &Inquiry<'_>, mut way: u32) {
        let Inquiry { held, hits, .. } = inquiry;
        while !self.is_begun[way as usize] {
            self.due.push(way);
            way = hits.step(way).0;
        }
        while let Some(way) = self.due.pop() {
            let (above, item) = hits.step(way);
            let item = held.item(hits.block(above), item);
            let (known, next) = self.begin.split_at_mut(way as usize);
            next[0].set_transformed(simd, &known[above as usize], &item.item_from_super);
            self.is_begun[way as usize] = true;
        }
    }

    /// Follows the rays of the set from an entry.
    #[inline(always)]
    fn trace_from<S: Simd, const DETAIL: bool>(
        &mut self,
        simd: S,
        inquiry: &mut Inquiry<'_>,
        lanes: Mask,
        entry: &Entry,
    ) {
        self.stack.clear();
        let number = inquiry.hits.block(entry.way);
        let first = &mut self.levels[0];
        first.rays = self.begin[entry.way as usize];
        (first.block, first.way) = (number, entry.way);
        let block = inquiry.held.block(number);
        let ball = &block.supers[entry.number as usize];
        let slot = entry.slot.zip(entry.child.as_node().map(|node| &block.nodes[node]));
        // The beam has met the box. Where each ray does is asked only to judge how small it is there.
        let child = slot.filter(|_| !DETAIL).map_or(entry.child, |(slot, node)| node.children[slot]);
        self.enter(simd, inquiry, (ball, child), 0, lanes);
        if let Some((slot, node)) = slot.filter(|_| DETAIL) {
            let rays = &self.levels[0];
            let opened: SmallVec<[Open; 1]> = self.stack.drain(..).collect();
            for open in opened {
                inquiry.work.boxes += u64::from(lanes.count_ones());
                push(simd, &mut self.stack, block, node, rays, &open, 1 << slot);
            }
        }
        while let Some(open) = self.stack.pop() {
            let level = open.level;
            let rays = &mut self.levels[level as usize];
            if rays.changes != inquiry.hits.changes {
                rays.changes = inquiry.hits.changes;
                rays.set_end(simd, &inquiry.hits.t);
            }
            let mut lanes = float_bits(open.near.load(simd).simd_le(rays.end.load(simd)));
            if lanes == 0 {
                continue;
            }
            let block = inquiry.held.block(rays.block);
            if DETAIL {
                // The rays of a packet are close to each other: one speaks for all.
                let lead = lanes.trailing_zeros() as usize % LANES;
                let t = rays.t(lead, open.near.0[lead]);
                if inquiry.is_small(block, rays.way, open.child, t) {
                    let at = (rays.way, open.child);
                    each(lanes, |lane| {
                        let t = rays.t(lane, open.near.0[lane]);
                        inquiry.meet_small(lane, at, &rays.rays.get(lane), t);
                    });
                    continue;
                }
            }
            if lanes.count_ones() < FEW || inquiry.held.goes_alone(level) {
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize % LANES;
                    lanes &= lanes - 1;
                    let start = (self.levels[level as usize].lane(lane), open.child);
                    self.single.trace::<S, DETAIL>(simd, inquiry, lane, start);
                }
                continue;
            }
            match open.child.target() {
                Target::Node(node) => {
                    let node = &block.nodes[node];
                    inquiry.work.boxes += u64::from(node.count * lanes.count_ones());
                    push(simd, &mut self.stack, block, node, rays, &open, ALL_SLOTS);
                }
                Target::Item(item) => self.ask(simd, inquiry, (block, item), level, lanes),
            }
        }
    }

    /// Asks an item of a block about rays of a level. What is below a super-node is to be looked at next.
    #[inline(always)]
    fn ask<S: Simd>(
        &mut self,
        simd: S,
        inquiry: &mut Inquiry<'_>,
        (block, at): (&Compiled, usize),
        level: u32,
        mut lanes: Mask,
    ) {
        let rays = &self.levels[level as usize];
        let item = &block.items[at];
        let place = Place::new(rays.way, at);
        match item.content {
            Content::Super(_) | Content::Gate(_) => {
                if !inquiry.held.is_crowded(0, inquiry.hits, rays.way)
                    && let Some((number, below)) = inquiry.held.inside(rays.block, item.content)
                    && let Some(child) = below.root
                {
                    let way = inquiry.hits.enter(place, block, number);
                    self.descend(simd, item, level as usize, number, way);
                    self.enter(simd, inquiry, (below, child), level + 1, lanes);
                }
            }
            Content::Solid(solid) => {
                let Inquiry { held, ask, hits, solids, .. } = inquiry;
                let at = (solid, place);
                let ways = hits.way_count();
                let firsts = self.cuts.first(simd, held, hits, solids, *ask, at, &rays.rays, lanes);
                if firsts.as_ref().is_none_or(|firsts| firsts.met == 0) {
                    hits.forget(ways, None);
                }
                if let Some(Firsts { t, faces, way, met, alone }) = &firsts {
                    each(*met, |lane| {
                        inquiry.answer(lane, t.0[lane], faces[lane], || (*way, self.cuts.ray(lane)));
                    });
                    lanes = *alone;
                }
                each(lanes, |lane| inquiry.ask_solid(simd, lane, &rays.rays.get(lane), solid, place));
            }
            Content::Shape(shape) => {
                inquiry.work.primitives += u64::from(lanes.count_ones());
                let at = (item, &block.shapes[shape as usize]);
                let (t, met) = first_of_shape(simd, &rays.rays, at, &inquiry.hits.t, lanes);
                each(met, |lane| inquiry.answer(lane, t.0[lane], place, || (rays.way, rays.rays.get(lane))));
            }
        }
    }

    /// Maps all rays of a level into the frame of an item, which leads to a block, for the next level.
    #[inline(always)]
    fn descend<S: Simd>(&mut self, simd: S, item: &Item, level: usize, block: u32, way: u32) {
        if self.levels.len() < level + 2 {
            self.levels.push(NarrowRays::EMPTY);
        }
        let [above, below] = &mut self.levels[level..level + 2] else {
            unreachable!("both levels are there")
        };
        below.rays.set_transformed(simd, &above.rays, &item.item_from_super);
        (below.block, below.way) = (block, way);
    }

    /// Opens a super-node, or a part of one, for rays that are in its frame already.
    #[inline(always)]
    fn enter<S: Simd>(
        &mut self,
        simd: S,
        Inquiry { held, hits, .. }: &Inquiry<'_>,
        (ball, child): (&SuperNode, Child),
        level: u32,
        lanes: Mask,
    ) {
        let rays = &mut self.levels[level as usize];
        let has_slabs = !held.block(rays.block).slabs.is_empty();
        let mut met = rays.narrow(simd, ball, lanes, has_slabs);
        if met == 0 {
            return;
        }
        rays.changes = hits.changes;
        rays.set_end(simd, &hits.t);
        let falling = rays.lines.falling(simd);
        while met != 0 {
            let lead = met.trailing_zeros();
            let mut alike = met;
            let signs = falling.map(|set| {
                let falls = set >> lead & 1 == 1;
                alike &= if falls { set } else { !set };
                falls
            });
            met &= !alike;
            let is_alike = mask32x16::from_bitmask(simd, u64::from(alike));
            let [on, off] = [f32::NEG_INFINITY, f32::INFINITY].map(|near| f32x16::splat(simd, near));
            let near = Floats::from_vector(is_alike.select(on, off));
            self.stack.push(Open { near, child, level, falling: signs });
        }
    }
}

/// Where the rays of a set meet the shape of an item first, and which of them do so before their ends.
#[inline(always)]
fn first_of_shape<S: Simd>(
    simd: S,
    rays: &Rays,
    (item, shape): (&Item, &Primitive),
    end: &Lanes,
    lanes: Mask,
) -> (Lanes, Mask) {
    let (mut t, mut met) = (Lanes::ZERO, 0);
    for half in 0..2 {
        if lanes >> (half * HALF) & 0xff == 0 {
            continue;
        }
        let [origin, direction] = rays.half(simd, half);
        let inside = [
            origin.transform_point(&item.item_from_super),
            direction.transform_vector(&item.item_from_super),
        ];
        let Some(span) = shapes::span(simd, shape, inside) else {
            each(lanes & 0xff << (half * HALF), |lane| {
                let inside = transform(&rays.get(lane), &item.item_from_super);
                if let Some(first) = single::first(&crate::shapes::extents(shape, &inside)) {
                    t.0[lane] = first;
                    met |= 1 << lane;
                }
            });
            continue;
        };
        let (first, valid) = shapes::first(simd, span);
        t.set_half(half, first);
        let before = bits(first.simd_le(end.half(simd, half)));
        met |= (valid & before) << (half * HALF);
    }
    (t, met & lanes)
}

/// Puts the children of a node in some slots that rays of the set meet on the stack, the nearest last.
#[inline(always)]
fn push<S: Simd>(
    simd: S,
    stack: &mut Vec<Open>,
    block: &Compiled,
    node: &Node,
    rays: &NarrowRays,
    open: &Open,
    slots: u32,
) {
    let inverse = load(simd, &rays.lines.inverse);
    let near_offset = load(simd, &rays.lines.near_offset);
    let far_offset = load(simd, &rays.lines.far_offset);
    let slabs = rays.diagonals.as_ref().zip(block.slabs.get(node.slabs as usize));
    // Rays that are not of the set have met the node nowhere.
    let start = rays.start.load(simd).max(open.near.load(simd));
    let end = rays.end.load(simd);
    let near_planes = node.near_planes(open.falling);
    let far_planes = node.far_planes(open.falling);
    let (slots, count) = candidates(simd, block, node, rays.tube.as_ref(), slots);
    for slot in &slots[..count] {
        let slot = usize::from(*slot) % WIDTH;
        let mut near = start;
        let mut far = end;
        for axis in 0..3 {
            let near_plane = f32x16::splat(simd, near_planes[axis][slot]);
            let far_plane = f32x16::splat(simd, far_planes[axis][slot]);
            // Rounded once on any machine: on the last digits depends what is too small to be looked into.
            near = near_plane.mul_add_precise(inverse[axis], near_offset[axis]).max(near);
            far = far_plane.mul_add_precise(inverse[axis], far_offset[axis]).min(far);
        }
        let mut met = near.simd_le(far);
        if let Some((lines, slabs)) = slabs
            && float_bits(met) != 0
        {
            met = slabs.met_by(simd, slot, lines, [near, far]);
        }
        if float_bits(met) != 0 {
            let near = Floats::from_vector(met.select(near, f32x16::splat(simd, f32::INFINITY)));
            stack.push(Open { near, child: node.children[slot], ..*open });
        }
    }
}

/// Of some slots of a node, those that rays of a tube may meet, the nearest last, and how many these are.
#[inline(always)]
fn candidates<S: Simd>(
    simd: S,
    block: &Compiled,
    node: &Node,
    tube: Option<&Line>,
    of: u32,
) -> ([u8; WIDTH], usize) {
    let (near, met) = match tube {
        Some(tube) => single::met_in_slabs(simd, block, node, tube, f32::MIN, f32::MAX),
        None => ([0.0; WIDTH], node.all_slots()),
    };
    let (mut met, mut slots, mut count) = (met & of, [0; WIDTH], 0);
    for slot in 0..8_u8 {
        if met & 1 != 0 {
            let mut at = count;
            while at > 0 && near[usize::from(slots[at - 1])] < near[usize::from(slot)] {
                slots[at] = slots[at - 1];
                at -= 1;
            }
            slots[at] = slot;
            count += 1;
        }
        met >>= 1;
    }
    (slots, count)
}
