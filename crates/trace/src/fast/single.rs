//! One ray through super-nodes: the boxes of all children of a node at once.
//!
//! For rays that go their own way, and for the few of a packet that are left in some corner of the scene.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::Inquiry;
use super::compile::{Compiled, Content};
use super::frame::{Line, Narrow};
use super::hits::{Place, START};
use super::lanes::transform;
use super::tree::{Child, Node, WIDTH};
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
    pub(super) fn trace<S: Simd>(
        &mut self,
        simd: S,
        inquiry: &mut Inquiry<'_>,
        lane: usize,
        (narrow, child): (Narrow, Child),
    ) {
        let compiled = inquiry.compiled;
        self.levels.clear();
        self.stack.clear();
        self.levels.push(narrow);
        self.stack.push(Open { near: f32::NEG_INFINITY, child, level: 0 });
        let (mut level, mut changes) = (0, inquiry.hits.changes);
        let mut end = narrow.end(inquiry.hits.t.0[lane]);
        while let Some(open) = self.stack.pop() {
            if open.level != level || inquiry.hits.changes != changes {
                (level, changes) = (open.level, inquiry.hits.changes);
                self.levels.truncate(level as usize + 1);
                end = self.levels[level as usize].end(inquiry.hits.t.0[lane]);
            }
            if open.near > end {
                continue;
            }
            let narrow = &self.levels[level as usize];
            let at = match open.child.get() {
                Err(node) => {
                    let node = &compiled.nodes[node];
                    inquiry.work.boxes += u64::from(node.count);
                    let (near, met) = met(simd, node, &narrow.line, narrow.start, end);
                    push(&mut self.stack, node, near, met, level);
                    continue;
                }
                Ok(at) => at,
            };
            let item = &compiled.items[at];
            let place = Place::new(narrow.way, at);
            let into_item = || transform(&narrow.ray, &item.item_from_super);
            let hit = match item.content {
                Content::Super(number) => {
                    let below = &compiled.supers[number as usize];
                    if let Some(root) = below.root
                        && let Some(narrow) = Narrow::new(into_item(), below, inquiry.hits.enter(place))
                    {
                        self.levels.push(narrow);
                        self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level: level + 1 });
                    }
                    continue;
                }
                Content::Solid(solid) => {
                    inquiry.ask_solid(simd, lane, &narrow.ray, solid, place);
                    continue;
                }
                Content::Shape(shape) => {
                    inquiry.work.primitives += 1;
                    first(&shapes::extents(&compiled.shapes[shape as usize], &into_item()))
                }
            };
            if let Some(t) = hit {
                inquiry.answer(lane, t, place, || narrow.ray);
            }
        }
    }

    /// A ray at the root.
    #[inline(always)]
    pub(super) fn start(compiled: &Compiled, ray: &Ray) -> Option<(Narrow, Child)> {
        let root = &compiled.supers[0];
        let child = root.root?;
        let narrow = match child.get() {
            Ok(_) => Narrow::alone(*ray, START),
            Err(_) => Narrow::new(*ray, root, START)?,
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
#[expect(clippy::cast_possible_truncation, reason = "eight bits")]
pub(super) fn met<S: Simd>(simd: S, node: &Node, line: &Line, start: f32, end: f32) -> ([f32; WIDTH], u32) {
    let mut near = f32x8::splat(simd, start);
    let mut far = f32x8::splat(simd, end);
    let near_planes = node.near_planes(line.falling());
    let far_planes = node.far_planes(line.falling());
    for axis in 0..3 {
        let inverse = f32x8::splat(simd, line.inverse[axis]);
        let near_plane = f32x8::from_slice(simd, near_planes[axis]);
        let far_plane = f32x8::from_slice(simd, far_planes[axis]);
        near = near_plane.mul_add(inverse, f32x8::splat(simd, line.near_offset[axis])).max(near);
        far = far_plane.mul_add(inverse, f32x8::splat(simd, line.far_offset[axis])).min(far);
    }
    let met = near.simd_le(far).to_bitmask() as u32 & ((1 << node.count) - 1);
    (*near, met)
}

/// Puts children on the stack, the nearest last.
#[inline(always)]
pub(super) fn push(stack: &mut Vec<Open>, node: &Node, near: [f32; WIDTH], mut met: u32, level: u32) {
    let first = stack.len();
    while met != 0 {
        let slot = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        let open = Open { near: near[slot], child: node.children[slot], level };
        stack.push(open);
        let mut at = stack.len() - 1;
        while at > first && stack[at - 1].near < open.near {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = open;
    }
}
