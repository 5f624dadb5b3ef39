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

/// One vector for each ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors([Lanes; 3]);

/// Rays in one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    pub(crate) origin: Vectors,
    pub(crate) direction: Vectors,
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

impl Vectors {
    pub(crate) const ZERO: Self = Self([Lanes::ZERO; 3]);

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, vector: DVec3) {
        for axis in 0..3 {
            self.0[axis].0[lane] = vector[axis];
        }
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> DVec3 {
        DVec3::new(self.0[0].0[lane], self.0[1].0[lane], self.0[2].0[lane])
    }

    #[inline(always)]
    pub(crate) fn half<S: Simd>(&self, simd: S, half: usize) -> Vec3x8<S> {
        let [x, y, z] = &self.0;
        Vec3x8 { x: x.half(simd, half), y: y.half(simd, half), z: z.half(simd, half) }
    }

    #[inline(always)]
    pub(crate) fn set_half<S: Simd>(&mut self, half: usize, value: Vec3x8<S>) {
        self.0[0].set_half(half, value.x);
        self.0[1].set_half(half, value.y);
        self.0[2].set_half(half, value.z);
    }
}

impl Rays {
    pub(crate) const ZERO: Self = Self { origin: Vectors::ZERO, direction: Vectors::ZERO };

    pub(crate) fn set(&mut self, lane: usize, ray: &Ray) {
        self.origin.set(lane, ray.origin);
        self.direction.set(lane, ray.direction);
    }

    pub(crate) fn get(&self, lane: usize) -> Ray {
        Ray { origin: self.origin.get(lane), direction: self.direction.get(lane) }
    }

    #[inline(always)]
    pub(crate) fn set_half<S: Simd>(&mut self, half: usize, origin: Vec3x8<S>, direction: Vec3x8<S>) {
        self.origin.set_half(half, origin);
        self.direction.set_half(half, direction);
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
        [self.origin.half(simd, half), self.direction.half(simd, half)]
    }
}

// No closures here and in what is called for each box: they would be compiled without the vector instructions.
impl<S: Simd> Vec3x8<S> {
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
