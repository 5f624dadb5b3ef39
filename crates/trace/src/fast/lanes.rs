//! Sixteen rays side by side, in double precision.
//!
//! Arithmetic on them is that of single rays, operation by operation and in the same order, without contraction: a ray has
//! the same hit in a packet as alone, on every machine.

use fearless_simd::{Simd, SimdBase, SimdMask, f64x8, mask64x8};
use glam::{DAffine3, DVec3};

use crate::Ray;

/// Rays of a packet.
pub(crate) const LANES: usize = 16;

/// Lanes that are computed at once.
pub(crate) const HALF: usize = LANES / 2;

/// A set of lanes.
pub(crate) type Mask = u32;

/// One number for each ray.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

/// Rays in one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    pub(crate) origin: [Lanes; 3],
    pub(crate) direction: [Lanes; 3],
}

/// A vector for each of eight rays.
#[derive(Clone, Copy)]
pub(crate) struct Vec3x8<S: Simd> {
    pub(crate) x: f64x8<S>,
    pub(crate) y: f64x8<S>,
    pub(crate) z: f64x8<S>,
}

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(crate) fn half<S: Simd>(&self, simd: S, half: usize) -> f64x8<S> {
        f64x8::from_slice(simd, &self.0[half * HALF..(half + 1) * HALF])
    }

    #[inline(always)]
    pub(crate) fn set_half<S: Simd>(&mut self, half: usize, value: f64x8<S>) {
        value.store_slice(&mut self.0[half * HALF..(half + 1) * HALF]);
    }
}

impl Rays {
    pub(crate) const ZERO: Self = Self { origin: [Lanes::ZERO; 3], direction: [Lanes::ZERO; 3] };

    pub(crate) fn set(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis].0[lane] = ray.origin[axis];
            self.direction[axis].0[lane] = ray.direction[axis];
        }
    }

    pub(crate) fn get(&self, lane: usize) -> Ray {
        let vector = |lanes: &[Lanes; 3]| DVec3::from(std::array::from_fn(|axis| lanes[axis].0[lane]));
        Ray { origin: vector(&self.origin), direction: vector(&self.direction) }
    }

    #[inline(always)]
    pub(crate) fn set_half<S: Simd>(&mut self, half: usize, origin: Vec3x8<S>, direction: Vec3x8<S>) {
        origin.store(&mut self.origin, half);
        direction.store(&mut self.direction, half);
    }

    /// The rays of another frame in this one.
    #[inline(always)]
    pub(super) fn set_transformed<S: Simd>(&mut self, simd: S, from: &Self, map: &DAffine3) {
        for half in 0..2 {
            let [origin, direction] = from.half(simd, half);
            self.set_half(half, origin.transform_point(map), direction.transform_vector(map));
        }
    }

    #[inline(always)]
    pub(crate) fn half<S: Simd>(&self, simd: S, half: usize) -> [Vec3x8<S>; 2] {
        [Vec3x8::load(simd, &self.origin, half), Vec3x8::load(simd, &self.direction, half)]
    }
}

// No closures here and in what is called for each box: they would be compiled without the vector instructions.
impl<S: Simd> Vec3x8<S> {
    #[inline(always)]
    pub(crate) fn load(simd: S, lanes: &[Lanes; 3], half: usize) -> Self {
        Self { x: lanes[0].half(simd, half), y: lanes[1].half(simd, half), z: lanes[2].half(simd, half) }
    }

    #[inline(always)]
    pub(crate) fn store(self, lanes: &mut [Lanes; 3], half: usize) {
        lanes[0].set_half(half, self.x);
        lanes[1].set_half(half, self.y);
        lanes[2].set_half(half, self.z);
    }

    /// Into another frame, as a direction: the order of operations is glam's.
    #[inline(always)]
    pub(crate) fn transform_vector(self, map: &DAffine3) -> Self {
        let m = &map.matrix3;
        Self {
            x: self.x * m.x_axis.x + self.y * m.y_axis.x + self.z * m.z_axis.x,
            y: self.x * m.x_axis.y + self.y * m.y_axis.y + self.z * m.z_axis.y,
            z: self.x * m.x_axis.z + self.y * m.y_axis.z + self.z * m.z_axis.z,
        }
    }

    #[inline(always)]
    pub(crate) fn transform_point(self, map: &DAffine3) -> Self {
        self.transform_vector(map).offset(map.translation)
    }

    /// By the transpose of the matrix, as normals go out of a frame.
    #[inline(always)]
    pub(crate) fn transform_normal(self, map: &DAffine3) -> Self {
        let m = &map.matrix3;
        Self {
            x: self.x * m.x_axis.x + self.y * m.x_axis.y + self.z * m.x_axis.z,
            y: self.x * m.y_axis.x + self.y * m.y_axis.y + self.z * m.y_axis.z,
            z: self.x * m.z_axis.x + self.y * m.z_axis.y + self.z * m.z_axis.z,
        }
    }

    #[inline(always)]
    pub(crate) fn offset(self, by: DVec3) -> Self {
        Self { x: self.x + by.x, y: self.y + by.y, z: self.z + by.z }
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn dot_constant(self, other: DVec3) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn scale(self, by: f64x8<S>) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    #[inline(always)]
    pub(crate) fn divide(self, by: f64x8<S>) -> Self {
        Self { x: self.x / by, y: self.y / by, z: self.z / by }
    }

    /// The points at t.
    #[inline(always)]
    pub(crate) fn at(self, direction: Self, t: f64x8<S>) -> Self {
        Self { x: self.x + direction.x * t, y: self.y + direction.y * t, z: self.z + direction.z * t }
    }
}

/// A ray into another frame; the same operations as for eight.
pub(crate) fn transform(ray: &Ray, map: &DAffine3) -> Ray {
    Ray { origin: map.transform_point3(ray.origin), direction: map.transform_vector3(ray.direction) }
}

/// The set of lanes of a mask.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "eight bits")]
pub(crate) fn bits<S: Simd>(mask: mask64x8<S>) -> u32 {
    mask.to_bitmask() as u32
}

/// For each lane of a set.
#[inline(always)]
pub(crate) fn each(mut lanes: Mask, mut action: impl FnMut(usize)) {
    while lanes != 0 {
        action(lanes.trailing_zeros() as usize % LANES);
        lanes &= lanes - 1;
    }
}
