//! What holds a point of a ray: the items of a super-node in whose boxes it is.
//!
//! For a point there is nothing to divide, and no order to keep; where a [narrowed](super::frame) ray is only asked about
//! one t, this is the cheaper question. Boxes are tested in single precision in the frame of the unit ball, with the
//! same padding, and the same allowance for what the ray has lost on its way.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};
use glam::DVec3;

use super::compiled::{Content, SuperNode};
use super::frame::DRIFT;
use super::held::Held;
use super::hits::{Hits, Place};
use super::lanes::transform;
use super::tree::{Child, Node, Target, WIDTH};
use crate::Ray;
use crate::narrow::narrow;

/// The memory of points in super-nodes, one inside of the other.
#[derive(Debug, Default)]
pub(super) struct Points {
    levels: Vec<Level>,
    stack: Vec<(Child, u32)>,
}

/// A ray in a super-node.
#[derive(Clone, Copy, Debug)]
struct Level {
    ray: Ray,
    center: DVec3,
    to_unit: f64,
    block: u32,
    way: u32,
    /// How far off it may be, in units of the super-node's radius.
    drift: f32,
}

/// How much memory was in use before some super-node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    levels: usize,
    stack: usize,
}

/// An item that may hold the point, with the ray in its frame; of a box, in that of the super-node.
pub(super) struct Holder {
    pub(super) place: Place,
    pub(super) ray: Ray,
}

impl Points {
    pub(super) fn clear(&mut self) {
        self.levels.clear();
        self.stack.clear();
    }

    pub(super) fn mark(&self) -> Mark {
        Mark { levels: self.levels.len(), stack: self.stack.len() }
    }

    /// Forgets what came after the mark.
    #[inline(always)]
    pub(super) fn rewind(&mut self, mark: Mark) {
        self.levels.truncate(mark.levels);
        self.stack.truncate(mark.stack);
    }

    /// Comes to a super-node of a block on a ray in its frame.
    #[inline(always)]
    pub(super) fn enter(&mut self, ball: &SuperNode, block: u32, ray: Ray, way: u32) {
        let Some(root) = ball.root else { return };
        let drift = narrow(DRIFT * (ray.origin - ball.center).abs().element_sum() / ball.radius);
        let level = u32::try_from(self.levels.len()).expect("2³² levels outgrow memory");
        let SuperNode { center, to_unit, .. } = *ball;
        self.levels.push(Level { ray, center, to_unit, block, way, drift });
        self.stack.push((root, level));
    }

    /// The next item behind the mark that may hold the point at t.
    #[inline(always)]
    pub(super) fn next<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        mark: Mark,
        t: f64,
    ) -> Option<Holder> {
        while self.stack.len() > mark.stack {
            let (child, level) = self.stack.pop()?;
            self.levels.truncate(level as usize + 1);
            let Level { ray, center, to_unit, block: number, way, drift } = self.levels[level as usize];
            let block = held.block(number);
            let at = match child.target() {
                Target::Item(at) => at,
                Target::Node(node) => {
                    let node = &block.nodes[node];
                    let point = (ray.at(t) - center) * to_unit;
                    let mut met = holds(simd, node, point.to_array().map(narrow), drift);
                    while met != 0 {
                        self.stack.push((node.children[met.trailing_zeros() as usize % WIDTH], level));
                        met &= met - 1;
                    }
                    continue;
                }
            };
            let item = &block.items[at];
            let place = Place::new(way, at);
            if hits.detail.as_ref().is_some_and(|detail| detail.is_small(block, place, &ray)) {
                return Some(Holder { place: place.as_box(), ray });
            }
            let ray = transform(&ray, &item.item_from_super);
            match item.content {
                Content::Super(_) | Content::Gate(_) => {
                    if !held.is_crowded(0, hits, way)
                        && let Some((number, below)) = held.inside(number, item.content)
                    {
                        self.enter(below, number, ray, hits.enter(place, block, number));
                    }
                }
                _ => return Some(Holder { place, ray }),
            }
        }
        None
    }
}

/// Which children of a node hold a point.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "eight bits")]
fn holds<S: Simd>(simd: S, node: &Node, point: [f32; 3], drift: f32) -> u32 {
    let mut over = f32x8::splat(simd, 0.0);
    for (axis, coordinate) in point.into_iter().enumerate() {
        let coordinate = f32x8::splat(simd, coordinate);
        let low = f32x8::from_slice(simd, &node.planes[axis]) - coordinate;
        let high = coordinate - f32x8::from_slice(simd, &node.planes[axis + 3]);
        over = over.max(low).max(high);
    }
    over.simd_le(f32x8::splat(simd, drift)).to_bitmask() as u32 & node.all_slots()
}
