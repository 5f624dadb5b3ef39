//! Lines in the unit ball of a super-node, in the form that boxes are tested with.
//!
//! A line enters a box at the last of its near planes and leaves it at the first of its far ones \[KAY86\], and meets a plane
//! at s = plane / direction − origin / direction. The inverse of the direction and that offset are computed once for all
//! boxes of a super-node; and as a line stands for all that are close to it, what they are apart is taken from the offset of
//! near planes and added to that of far ones.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, mask32x16};
use glam::Vec3A;

use super::lanes::{LANES, Mask};
use super::slabs::Diagonals;

/// Components of directions are at least this, so that none has an infinite inverse.
pub(super) const LEAST: f32 = 1e-18;

/// The line of a ray, or of all rays that are close to one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) inverse: Vec3A,
    /// What is added to plane · inverse for the s of a near plane and of a far one.
    pub(super) near_offset: Vec3A,
    pub(super) far_offset: Vec3A,
    /// The same along the diagonals of space, for boxes with slabs.
    pub(super) diagonals: Option<Diagonals>,
}

/// The lines of the rays of a packet, in N coordinates.
#[derive(Clone, Debug)]
pub(super) struct Lines<const N: usize> {
    pub(super) inverse: [Floats; N],
    pub(super) near_offset: [Floats; N],
    pub(super) far_offset: [Floats; N],
}

/// A single-precision number for each ray.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Floats(pub(super) [f32; LANES]);

impl Line {
    pub(super) const ZERO: Self =
        Self { inverse: Vec3A::ZERO, near_offset: Vec3A::ZERO, far_offset: Vec3A::ZERO, diagonals: None };

    /// The line through a point, and all that are no farther from it than `slack` along each axis; for boxes with slabs, too,
    /// or for boxes alone.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A, slack: Vec3A, has_slabs: bool) -> Self {
        let diagonals = if has_slabs { Some(Diagonals::new(origin, direction, slack)) } else { None };
        let least = Vec3A::splat(LEAST);
        let direction = Vec3A::select(direction.abs().cmplt(least), least.copysign(direction), direction);
        let inverse = Vec3A::ONE / direction;
        let (offset, slack) = (-origin * inverse, slack * inverse.abs());
        Self { inverse, near_offset: offset - slack, far_offset: offset + slack, diagonals }
    }

    /// Which coordinates fall along it.
    #[inline(always)]
    pub(super) fn falling(&self) -> [bool; 3] {
        let [x, y, z] = self.inverse.to_array();
        [x < 0.0, y < 0.0, z < 0.0]
    }
}

impl<const N: usize> Lines<N> {
    pub(super) const ZERO: Self =
        Self { inverse: [Floats::ZERO; N], near_offset: [Floats::ZERO; N], far_offset: [Floats::ZERO; N] };

    /// The lines through points, and all that are no farther from these than `slack` along each coordinate.
    #[inline(always)]
    pub(super) fn set<S: Simd>(
        &mut self,
        simd: S,
        origins: [f32x16<S>; N],
        directions: [f32x16<S>; N],
        slack: f32x16<S>,
    ) {
        let least = f32x16::splat(simd, LEAST);
        for at in 0..N {
            let direction = directions[at];
            let direction = direction.abs().simd_lt(least).select(least.copysign(direction), direction);
            let inverse = f32x16::splat(simd, 1.0) / direction;
            let (offset, slack) = (-(origins[at] * inverse), slack * inverse.abs());
            self.inverse[at] = Floats::from_vector(inverse);
            self.near_offset[at] = Floats::from_vector(offset - slack);
            self.far_offset[at] = Floats::from_vector(offset + slack);
        }
    }

    /// One of them: its inverse, and the offsets of near and far planes.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> [[f32; N]; 3] {
        [&self.inverse, &self.near_offset, &self.far_offset]
            .map(|floats| std::array::from_fn(|at| floats[at].0[lane]))
    }
}

impl Lines<3> {
    /// The lines along which each coordinate falls.
    #[inline(always)]
    pub(super) fn falling<S: Simd>(&self, simd: S) -> [Mask; 3] {
        let zero = f32x16::splat(simd, 0.0);
        [
            float_bits(self.inverse[0].load(simd).simd_lt(zero)),
            float_bits(self.inverse[1].load(simd).simd_lt(zero)),
            float_bits(self.inverse[2].load(simd).simd_lt(zero)),
        ]
    }
}

impl Floats {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::from_slice(simd, &self.0)
    }

    #[inline(always)]
    pub(super) fn from_vector<S: Simd>(vector: f32x16<S>) -> Self {
        Self(*vector)
    }
}

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, floats: &[Floats; 3]) -> [f32x16<S>; 3] {
    [floats[0].load(simd), floats[1].load(simd), floats[2].load(simd)]
}

/// The set of lanes of a mask.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "sixteen bits")]
pub(super) fn float_bits<S: Simd>(mask: mask32x16<S>) -> Mask {
    mask.to_bitmask() as Mask
}
