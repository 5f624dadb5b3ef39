//! One ray through super-nodes: the boxes of all children of a node at once.
//!
//! For rays that go their own way, and for the few of a packet that are left in some corner of the scene.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::compiled::{Compiled, Content};
use super::frame::Narrow;
use super::held::Held;
use super::hits::{Place, ROOT, START};
use super::inquiry::Inquiry;
use super::lanes::transform;
use super::line::Line;
use super::tree::{Child, Node, Target, WIDTH};
use crate::Ray;
use crate::shapes::{self, Extents};

/// What is left to do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub(super) near: f32,
    pub(super) child: Child,
    pub(super) level: u32,
}

/// The memory of single rays.
#[derive(Debug, Default)]
pub(super) struct Single {
    /// The ray in the super-nodes that it is in, one inside of the other.
    levels: Vec<Narrow>,
    stack: Vec<Open>,
}

impl Single {
    /// Follows a ray of a packet from a child of the super-node that it is in.
    #[inline(always)]
    pub(super) fn trace<S: Simd, const DETAIL: bool>(
        &mut self,
        simd: S,
        inquiry: &mut Inquiry<'_>,
        lane: usize,
        (narrow, child): (Narrow, Child),
    ) {
        self.stack.clear();
        self.set_level(0, narrow);
        let mut block = inquiry.held.block(narrow.block);
        let (mut level, mut changes) = (0, inquiry.hits.changes);
        let mut end = narrow.end(inquiry.hits.t.0[lane]);
        let mut open = Open { near: f32::NEG_INFINITY, child, level };
        loop {
            if open.level != level || inquiry.hits.changes != changes {
                (level, changes) = (open.level, inquiry.hits.changes);
                let narrow = &self.levels[level as usize];
                (block, end) = (inquiry.held.block(narrow.block), narrow.end(inquiry.hits.t.0[lane]));
            }
            if open.near <= end {
                let narrow = &self.levels[level as usize];
                let t = narrow.t(open.near);
                let next = match open.child.target() {
                    _ if DETAIL && inquiry.is_small(block, narrow.way, open.child, t) => {
                        inquiry.meet_small(lane, (narrow.way, open.child), &narrow.ray, t);
                        None
                    }
                    Target::Node(node) => {
                        let node = &block.nodes[node];
                        inquiry.work.boxes += u64::from(node.count);
                        let (near, met) = met_in_slabs(simd, block, node, &narrow.line, narrow.start, end);
                        nearest(&mut self.stack, node, near, met, level)
                    }
                    Target::Item(at) => {
                        let below = self.ask(simd, inquiry, block, lane, level, at);
                        below.map(|child| Open { near: f32::NEG_INFINITY, child, level: level + 1 })
                    }
                };
                if let Some(next) = next {
                    open = next;
                    continue;
                }
            }
            let Some(next) = self.stack.pop() else { break };
            open = next;
        }
    }

    /// Asks an item about the ray. What is below a super-node is to be looked at next, at the next level.
    #[inline(always)]
    fn ask<S: Simd>(
        &mut self,
        simd: S,
        inquiry: &mut Inquiry<'_>,
        block: &Compiled,
        lane: usize,
        level: u32,
        at: usize,
    ) -> Option<Child> {
        let narrow = &self.levels[level as usize];
        let item = &block.items[at];
        let place = Place::new(narrow.way, at);
        match item.content {
            Content::Super(_) | Content::Gate(_) => {
                if inquiry.held.is_too_long(level, inquiry.hits, narrow.way) {
                    return None;
                }
                let (number, below) = inquiry.held.inside(narrow.block, item.content)?;
                let ray = transform(&narrow.ray, &item.item_from_super);
                let root = below.root?;
                let way = inquiry.hits.enter(place, block, number);
                let has_slabs = !inquiry.held.block(number).slabs.is_empty();
                let narrow = Narrow::new(ray, below, number, way, has_slabs)?;
                self.set_level(level as usize + 1, narrow);
                return Some(root);
            }
            Content::Solid(solid) => inquiry.ask_solid(simd, lane, &narrow.ray, solid, place),
            Content::Shape(shape) => {
                inquiry.work.primitives += 1;
                let ray = transform(&narrow.ray, &item.item_from_super);
                if let Some(t) = first(&shapes::extents(&block.shapes[shape as usize], &ray)) {
                    inquiry.answer(lane, t, place, || (narrow.way, narrow.ray));
                }
            }
        }
        None
    }

    /// Replaces what was at a level. Written in place: copying what has just been written is slow.
    #[inline(always)]
    fn set_level(&mut self, at: usize, narrow: Narrow) {
        if self.levels.len() == at {
            self.levels.push(Narrow::EMPTY);
        }
        self.levels[at] = narrow;
    }

    /// A ray at the root, at a node of its tree, or in the super-node of an item at that.
    #[inline(always)]
    pub(super) fn start(held: &Held<'_>, ray: &Ray, child: Option<Child>) -> Option<(Narrow, Child)> {
        let block = held.block(ROOT);
        let root = &block.supers[0];
        let child = child.or(root.root)?;
        let narrow = match child.target() {
            Target::Item(_) => Narrow::alone(*ray, ROOT, START),
            Target::Node(_) => Narrow::new(*ray, root, ROOT, START, !block.slabs.is_empty())?,
        };
        Some((narrow, child))
    }
}

/// The first boundary in front of the origin.
#[inline(always)]
pub(super) fn first(extents: &Extents) -> Option<f64> {
    let first = extents.iter().find(|[enter, exit]| enter < exit && *exit > 0.0);
    first.map(|[enter, exit]| if *enter > 0.0 { *enter } else { *exit })
}

/// Which children of a node a line meets between `start` and `end`, and where.
#[inline(always)]
pub(super) fn met<S: Simd>(simd: S, node: &Node, line: &Line, start: f32, end: f32) -> ([f32; WIDTH], u32) {
    let ([near, _], met) = crossed(simd, node, line, start, end);
    (near, met)
}

/// Those whose slabs it meets, too, if they and the line have some.
#[inline(always)]
pub(super) fn met_in_slabs<S: Simd>(
    simd: S,
    block: &Compiled,
    node: &Node,
    line: &Line,
    start: f32,
    end: f32,
) -> ([f32; WIDTH], u32) {
    let (between, mut met) = crossed(simd, node, line, start, end);
    if met != 0
        && let Some(diagonals) = &line.diagonals
        && let Some(slabs) = block.slabs.get(node.slabs as usize)
    {
        met = slabs.met(simd, diagonals, between, met);
    }
    let [near, _] = between;
    (near, met)
}

/// Which children of a node a line meets between `start` and `end`, where it enters them and where it leaves.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "eight bits")]
pub(super) fn crossed<S: Simd>(
    simd: S,
    node: &Node,
    line: &Line,
    start: f32,
    end: f32,
) -> ([[f32; WIDTH]; 2], u32) {
    let mut near = f32x8::splat(simd, start);
    let mut far = f32x8::splat(simd, end);
    let near_planes = node.near_planes(line.falling());
    let far_planes = node.far_planes(line.falling());
    for axis in 0..3 {
        let inverse = f32x8::splat(simd, line.inverse[axis]);
        let near_plane = f32x8::from_slice(simd, near_planes[axis]);
        let far_plane = f32x8::from_slice(simd, far_planes[axis]);
        // Rounded once on any machine: on the last digits depends what is too small to be looked into.
        near = near_plane.mul_add_precise(inverse, f32x8::splat(simd, line.near_offset[axis])).max(near);
        far = far_plane.mul_add_precise(inverse, f32x8::splat(simd, line.far_offset[axis])).min(far);
    }
    let met = near.simd_le(far).to_bitmask() as u32 & node.all_slots();
    ([*near, *far], met)
}

/// The nearest of the children that are met. Puts the others on the stack, the nearer ones last.
#[inline(always)]
pub(super) fn nearest(
    stack: &mut Vec<Open>,
    node: &Node,
    near: [f32; WIDTH],
    mut met: u32,
    level: u32,
) -> Option<Open> {
    let first = stack.len();
    let mut nearest: Option<Open> = None;
    while met != 0 {
        let slot = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        let open = Open { near: near[slot], child: node.children[slot], level };
        let farther = match nearest {
            Some(nearest) if nearest.near <= open.near => open,
            Some(before) => {
                nearest = Some(open);
                before
            }
            None => {
                nearest = Some(open);
                continue;
            }
        };
        stack.push(farther);
        let mut at = stack.len() - 1;
        while at > first && stack[at - 1].near < farther.near {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = farther;
    }
    nearest
}
