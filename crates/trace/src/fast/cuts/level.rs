//! The points of a packet's rays in a super-node, against the boxes of its nodes.
//!
//! They are computed in the super-node's frame in double precision, and kept in its unit ball in single precision, with as
//! much drift to both sides as that may be off. All boxes of a node are tested at once against the box around the points;
//! only what overlaps that is tested against the points themselves.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, SimdNarrow, f32x8, f32x16, f64x8, mask32x16};
use glam::DVec3;

use super::Open;
use super::front::Front;
use crate::fast::compiled::{Item, SuperNode};
use crate::fast::frame::DRIFT;
use crate::fast::hits::{ROOT, START};
use crate::fast::lanes::{HALF, Mask, Rays, Vec3x8};
use crate::fast::line::{Floats, float_bits, load};
use crate::fast::tree::{Node, WIDTH};

/// Rays in a super-node.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// What it was entered by, unless it is B.
    pub(super) entered: Option<(u32, u32)>,
    pub(super) rays: Rays,
    pub(super) ball: SuperNode,
    pub(super) block: u32,
    pub(super) way: u32,
    /// The rays whose points may be in it.
    pub(super) lanes: Mask,
    /// How far off points may be, in units of the super-node's radius.
    drift: Floats,
    /// The points in the unit ball, less the drift and more.
    points: [[Floats; 3]; 2],
    /// A box around them.
    bounds: [[f32; 3]; 2],
    /// How often t had changed when they were computed.
    pub(super) changes: u32,
}

impl Level {
    pub(super) const EMPTY: Self = Self {
        entered: None,
        rays: Rays::ZERO,
        ball: SuperNode { center: DVec3::ZERO, radius: 1.0, to_unit: 1.0, reach: 1.0, root: None },
        block: ROOT,
        way: START,
        lanes: 0,
        drift: Floats::ZERO,
        points: [[Floats::ZERO; 3]; 2],
        bounds: [[0.0; 3]; 2],
        changes: u32::MAX,
    };

    /// Makes it that of a super-node for rays that are in its frame already.
    #[inline(always)]
    pub(super) fn set<S: Simd>(
        &mut self,
        simd: S,
        entered: Option<(u32, u32)>,
        ball: &SuperNode,
        (block, way): (u32, u32),
        lanes: Mask,
    ) {
        let mut drifts = [f64x8::splat(simd, 0.0); 2];
        for (half, drift) in drifts.iter_mut().enumerate() {
            let from_center = self.rays.half(simd, half)[0].offset(-ball.center);
            let sum = from_center.x.abs() + from_center.y.abs() + from_center.z.abs();
            *drift = sum * (DRIFT * ball.to_unit);
        }
        self.drift = Floats::from_vector(drifts[0].narrow(drifts[1]));
        self.ball.clone_from(ball);
        (self.entered, self.block, self.way) = (entered, block, way);
        (self.lanes, self.changes) = (lanes, u32::MAX);
    }

    /// Computes where the points are.
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators would be compiled without the vector instructions"
    )]
    pub(super) fn set_points<S: Simd>(&mut self, simd: S, front: &Front) {
        let mut points = [[f64x8::splat(simd, 0.0); 2]; 3];
        for half in 0..2 {
            if self.lanes >> (half * HALF) & 0xff == 0 {
                continue;
            }
            let [origin, direction] = self.rays.half(simd, half);
            let from_center = origin.at(direction, front.t.half(simd, half)).offset(-self.ball.center);
            points[0][half] = from_center.x * self.ball.to_unit;
            points[1][half] = from_center.y * self.ball.to_unit;
            points[2][half] = from_center.z * self.ball.to_unit;
        }
        let is_in = mask32x16::from_bitmask(simd, u64::from(self.lanes));
        let [least, most] = [f32::MIN, f32::MAX].map(|limit| f32x16::splat(simd, limit));
        let drift = self.drift.load(simd);
        for axis in 0..3 {
            let point = points[axis][0].narrow(points[axis][1]);
            let (low, high) = (point - drift, point + drift);
            self.points[0][axis] = Floats::from_vector(low);
            self.points[1][axis] = Floats::from_vector(high);
            self.bounds[0][axis] = is_in.select(low, most).reduce_min();
            self.bounds[1][axis] = is_in.select(high, least).reduce_max();
        }
        self.changes = front.changes;
    }
}

/// Half of the rays in the frame of an item of their super-node.
#[inline(always)]
pub(super) fn inside<S: Simd>(simd: S, rays: &Rays, item: &Item, half: usize) -> [Vec3x8<S>; 2] {
    let [origin, direction] = rays.half(simd, half);
    let map = &item.item_from_super;
    [origin.transform_point(map), direction.transform_vector(map)]
}

/// Puts the children of a node that hold points of the set on the stack, the largest last.
#[inline(always)]
pub(super) fn push<S: Simd>(
    simd: S,
    stack: &mut Vec<Open>,
    node: &Node,
    here: &Level,
    level: u32,
    lanes: Mask,
) {
    let [low, high] = [load(simd, &here.points[0]), load(simd, &here.points[1])];
    let mut candidates = overlapping(simd, node, &here.bounds);
    while candidates != 0 {
        let slot = candidates.trailing_zeros() as usize % WIDTH;
        candidates &= candidates - 1;
        let mut held = lanes;
        for axis in 0..3 {
            let is_above = high[axis].simd_ge(f32x16::splat(simd, node.planes[axis][slot]));
            let is_below = low[axis].simd_le(f32x16::splat(simd, node.planes[axis + 3][slot]));
            held &= float_bits(is_above & is_below);
        }
        if held != 0 {
            stack.push(Open { child: node.children[slot], level, lanes: held });
        }
    }
}

/// The children of a node whose boxes overlap a box.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "eight bits")]
fn overlapping<S: Simd>(simd: S, node: &Node, [low, high]: &[[f32; 3]; 2]) -> u32 {
    let mut overlap = node.all_slots();
    for axis in 0..3 {
        let begins = f32x8::from_slice(simd, &node.planes[axis]).simd_le(f32x8::splat(simd, high[axis]));
        let ends = f32x8::from_slice(simd, &node.planes[axis + 3]).simd_ge(f32x8::splat(simd, low[axis]));
        overlap &= (begins & ends).to_bitmask() as u32;
    }
    overlap
}
