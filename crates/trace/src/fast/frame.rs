//! Rays in the unit ball of a super-node, where single precision is enough to test boxes.
//!
//! Deep in a recursion a ray comes from 10¹⁰ sizes of the part away, and its direction is as long; in single precision it
//! would miss the part. So it is *re-based* where it enters a super-node: moved, in double precision, to its point
//! closest to the middle, and its parameter scaled, so that origin, direction and boxes are all about 1:
//!
//! > at s along the narrowed ray is what is at t = base + s · rate.
//!
//! What is left are errors of a few 2⁻²⁴ of a unit, which the padding of the [boxes](super::tree) covers many times, and
//! what the ray itself has lost on its way through the transformations, which is relative to where it comes from and
//! is added to each box as [`DRIFT`] times that distance. Rays that miss the ball are turned away.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, SimdNarrow, f32x16, f64x8, mask32x16};
use glam::{DVec3, Vec3A, Vec4};

use super::compiled::SuperNode;
use super::hits::{ROOT, START};
use super::lanes::{HALF, LANES, Lanes, Mask, Rays, bits};
use super::line::{Floats, LEAST, Line, Lines};
use super::slabs::Diagonals;
use crate::Ray;
use crate::narrow::narrow;

/// How far off a ray may be, relative to the way it came: 64 transformations with an error of 2⁻⁵² each.
pub(super) const DRIFT: f64 = 1.0 / (1_u64 << 46) as f64;

/// Errors of parameters in single precision.
const FUDGE: f32 = 1.0 / (1 << 20) as f32;

/// A narrowed ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Narrow {
    pub(super) ray: Ray,
    base: f64,
    /// The t that one s is, and the s that one t is: powers of two.
    rate: f64,
    by_rate: f64,
    pub(super) line: Line,
    /// The s of t = 0.
    pub(super) start: f32,
    /// The block of the super-node.
    pub(super) block: u32,
    pub(super) way: u32,
}

/// Narrowed rays side by side.
#[derive(Clone, Debug)]
pub(super) struct NarrowRays {
    pub(super) rays: Rays,
    base: Lanes,
    rate: f64,
    by_rate: f64,
    pub(super) lines: Lines<3>,
    /// The same along the diagonals of space, for boxes with slabs.
    pub(super) diagonals: Option<Lines<4>>,
    pub(super) start: Floats,
    /// A line that all of them are close to, unless the super-node is unbounded.
    pub(super) tube: Option<Line>,
    /// The s of each ray's first hit so far.
    pub(super) end: Floats,
    /// How often that has changed when `end` was computed.
    pub(super) changes: u32,
    /// The block of the super-node.
    pub(super) block: u32,
    pub(super) way: u32,
}

impl Narrow {
    pub(super) const EMPTY: Self = Self {
        ray: Ray { origin: DVec3::ZERO, direction: DVec3::ZERO },
        base: 0.0,
        rate: 1.0,
        by_rate: 1.0,
        line: Line::ZERO,
        start: 0.0,
        block: ROOT,
        way: START,
    };

    /// The ray in the frame of a super-node of a block, unless it misses its ball; for boxes with slabs, too, or for boxes
    /// alone.
    #[inline(always)]
    pub(super) fn new(ray: Ray, ball: &SuperNode, block: u32, way: u32, has_slabs: bool) -> Option<Self> {
        let from_center = ray.origin - ball.center;
        let by_squared_length = 1.0 / ray.direction.length_squared();
        let base = -from_center.dot(ray.direction) * by_squared_length;
        let closest = from_center + ray.direction * base;
        let drift = DRIFT * from_center.abs().element_sum();
        let reach = (ball.reach + drift) * (1.0 + 1e-9);
        if closest.length_squared() > reach * reach {
            return None;
        }
        let [rate, by_rate] = power_below_root(ball.radius * ball.radius * by_squared_length);
        let origin = (closest * ball.to_unit).as_vec3a();
        let direction = (ray.direction * (rate * ball.to_unit)).as_vec3a();
        let slack = narrow(drift * ball.to_unit);
        let line = Line::new(origin, direction, Vec3A::splat(slack), has_slabs);
        let start = narrow(-base * by_rate);
        let start = start - start.abs() * FUDGE;
        Some(Self { ray, base, rate, by_rate, line, start, block, way })
    }

    /// The ray for a super-node of one item, which has no boxes to test.
    #[inline(always)]
    pub(super) fn alone(ray: Ray, block: u32, way: u32) -> Self {
        Self { ray, block, way, ..Self::EMPTY }
    }

    /// The s of a t, not before it.
    #[inline(always)]
    pub(super) fn end(&self, t: f64) -> f32 {
        let s = self.s(t);
        s + s.abs() * FUDGE
    }

    /// The s of a t, not behind it.
    #[inline(always)]
    pub(super) fn start(&self, t: f64) -> f32 {
        let s = self.s(t);
        s - s.abs() * FUDGE
    }

    /// The t of an s.
    #[inline(always)]
    pub(super) fn t(&self, s: f32) -> f64 {
        self.base + f64::from(s) * self.rate
    }

    /// Finite, also for a ray that has ended.
    #[inline(always)]
    fn s(&self, t: f64) -> f32 {
        narrow((t - self.base) * self.by_rate).clamp(f32::MIN, f32::MAX)
    }
}

impl NarrowRays {
    pub(super) const EMPTY: Self = Self {
        rays: Rays::ZERO,
        base: Lanes::ZERO,
        rate: 1.0,
        by_rate: 1.0,
        lines: Lines::ZERO,
        diagonals: None,
        start: Floats::ZERO,
        tube: None,
        end: Floats::ZERO,
        changes: 0,
        block: ROOT,
        way: START,
    };

    /// Narrows the rays that are here, for boxes with slabs or for boxes alone, and says which of a set meet the ball.
    #[inline(always)]
    pub(super) fn narrow<S: Simd>(
        &mut self,
        simd: S,
        ball: &SuperNode,
        lanes: Mask,
        has_slabs: bool,
    ) -> Mask {
        let lead = middle(lanes);
        let by_squared_length = 1.0 / self.rays.get(lead).direction.length_squared();
        let [rate, by_rate] = power_below_root(ball.radius * ball.radius * by_squared_length);
        (self.rate, self.by_rate) = (rate, by_rate);
        let to_unit = ball.to_unit;
        let mut met = 0;
        let mut origins = [[f64x8::splat(simd, 0.0); 2]; 3];
        let mut directions = origins;
        let mut drifts = origins[0];
        let mut starts = origins[0];
        for half in 0..2 {
            let [origin, direction] = self.rays.half(simd, half);
            let from_center = origin.offset(-ball.center);
            let squared_length = direction.dot(direction);
            let base = -from_center.dot(direction) / squared_length;
            let closest = from_center.at(direction, base);
            let drift = (from_center.x.abs() + from_center.y.abs() + from_center.z.abs()) * DRIFT;
            let reach = (drift + ball.reach) * (1.0 + 1e-9);
            met |= bits(closest.dot(closest).simd_le(reach * reach)) << (half * HALF);
            self.base.set_half(half, base);
            origins[0][half] = closest.x * to_unit;
            origins[1][half] = closest.y * to_unit;
            origins[2][half] = closest.z * to_unit;
            directions[0][half] = direction.x * (rate * to_unit);
            directions[1][half] = direction.y * (rate * to_unit);
            directions[2][half] = direction.z * (rate * to_unit);
            drifts[half] = drift * to_unit;
            starts[half] = -base * by_rate;
        }
        let met = met & lanes;
        let drift = drifts[0].narrow(drifts[1]);
        let start = starts[0].narrow(starts[1]);
        self.start = Floats::from_vector(start - start.abs() * FUDGE);
        let origins = [
            origins[0][0].narrow(origins[0][1]),
            origins[1][0].narrow(origins[1][1]),
            origins[2][0].narrow(origins[2][1]),
        ];
        let directions = [
            directions[0][0].narrow(directions[0][1]),
            directions[1][0].narrow(directions[1][1]),
            directions[2][0].narrow(directions[2][1]),
        ];
        self.lines.set(simd, origins, directions, drift);
        self.tube = if met != 0 && ball.reach.is_finite() {
            Some(tube(simd, origins, directions, met, drift, has_slabs))
        } else {
            None
        };
        if has_slabs && met != 0 {
            self.diagonals.get_or_insert(Lines::ZERO).set_diagonals(simd, origins, directions, drift);
        } else {
            self.diagonals = None;
        }
        met
    }

    /// The s of each ray's t, not before it.
    #[inline(always)]
    pub(super) fn set_end<S: Simd>(&mut self, simd: S, t: &Lanes) {
        let by_rate = self.by_rate;
        let low = (t.half(simd, 0) - self.base.half(simd, 0)) * by_rate;
        let high = (t.half(simd, 1) - self.base.half(simd, 1)) * by_rate;
        // Finite, so that what is met nowhere, at infinity, is behind the end of every ray, and a ray that has ended
        // meets nothing.
        let s = low.narrow(high).max(f32x16::splat(simd, f32::MIN));
        self.end = Floats::from_vector((s + s.abs() * FUDGE).min(f32x16::splat(simd, f32::MAX)));
    }

    /// The t of an s of one of them.
    #[inline(always)]
    pub(super) fn t(&self, lane: usize, s: f32) -> f64 {
        self.base.0[lane] + f64::from(s) * self.rate
    }

    /// One of them.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> Narrow {
        let [inverse, near_offset, far_offset] = self.lines.lane(lane).map(Vec3A::from);
        let diagonals = self.diagonals.as_ref().map(|diagonals| {
            let [inverse, near_offset, far_offset] = diagonals.lane(lane).map(Vec4::from);
            Diagonals { inverse, near_offset, far_offset }
        });
        Narrow {
            ray: self.rays.get(lane),
            base: self.base.0[lane],
            rate: self.rate,
            by_rate: self.by_rate,
            line: Line { inverse, near_offset, far_offset, diagonals },
            start: self.start.0[lane],
            block: self.block,
            way: self.way,
        }
    }
}

/// A line with slack for those of a set and their drift: wherever one of them meets a box in the ball, that line does.
#[inline(always)]
fn tube<S: Simd>(
    simd: S,
    origins: [f32x16<S>; 3],
    directions: [f32x16<S>; 3],
    lanes: Mask,
    drift: f32x16<S>,
    has_slabs: bool,
) -> Line {
    let lead = middle(lanes);
    let is_in = mask32x16::from_bitmask(simd, u64::from(lanes));
    let zero = f32x16::splat(simd, 0.0);
    let [x, y, z] = directions;
    let squared_length = is_in.select(x * x + y * y + z * z, f32x16::splat(simd, f32::MAX));
    let drift = is_in.select(drift, zero).reduce_max();
    // The s where the last of them leaves the ball and what the drift adds to its boxes, √3 times as far at corners.
    let last = (1.0 + 1e-3 + 2.0 * drift) / squared_length.reduce_min().max(LEAST).sqrt();
    let (mut origin, mut direction, mut slack) = (Vec3A::ZERO, Vec3A::ZERO, Vec3A::ZERO);
    for axis in 0..3 {
        origin[axis] = origins[axis][lead];
        direction[axis] = directions[axis][lead];
        let aside = (origins[axis] - origin[axis]).abs();
        let apart = (directions[axis] - direction[axis]).abs();
        slack[axis] = is_in.select(aside + apart * last, zero).reduce_max();
    }
    Line::new(origin, direction, slack * (1.0 + FUDGE) + (drift + FUDGE), has_slabs)
}

/// A lane in the middle of a square of rays, if the set has one, or its first.
#[inline(always)]
fn middle(lanes: Mask) -> usize {
    const INNER: Mask = 0x0660;
    let inner = if lanes & INNER == 0 { lanes } else { lanes & INNER };
    inner.trailing_zeros() as usize % LANES
}

/// The power of two at or below the root of a positive number, and above a half of it; and one by it. Multiplying by
/// either is exact.
#[inline(always)]
fn power_below_root(square: f64) -> [f64; 2] {
    const BIAS: u64 = 1023;
    const DIGITS: u32 = f64::MANTISSA_DIGITS - 1;
    if !square.is_normal() {
        return [1.0; 2];
    }
    // The exponent that is stored is BIAS more than the real one, and BIAS is odd.
    let exponent = ((square.to_bits() >> DIGITS) + BIAS) / 2;
    [f64::from_bits(exponent << DIGITS), f64::from_bits((2 * BIAS - exponent) << DIGITS)]
}
