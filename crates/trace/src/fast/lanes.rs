//! Sixteen rays side by side, in double precision.
//!
//! Arithmetic on them is that of single rays, operation by operation and in the same order, without contraction: a ray has
//! the same hit in a packet as alone, on every machine.

use fearless_simd::{Simd, SimdBase, f64x8};
use glam::{DAffine3, DVec3};

use crate::Ray;

/// Rays of a packet.
pub(super) const LANES: usize = 16;

/// Lanes that are computed at once.
pub(super) const HALF: usize = LANES / 2;

/// A set of lanes.
pub(super) type Mask = u32;

/// One number for each ray.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub(super) [f64; LANES]);

/// Rays in one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    pub(super) origin: [Lanes; 3],
    pub(super) direction: [Lanes; 3],
}

/// A vector for each of eight rays.
#[derive(Clone, Copy)]
pub(super) struct Vec3x8<S: Simd> {
    pub(super) x: f64x8<S>,
    pub(super) y: f64x8<S>,
    pub(super) z: f64x8<S>,
}

impl Lanes {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn half<S: Simd>(&self, simd: S, half: usize) -> f64x8<S> {
        f64x8::from_slice(simd, &self.0[half * HALF..(half + 1) * HALF])
    }

    #[inline(always)]
    pub(super) fn set_half<S: Simd>(&mut self, half: usize, value: f64x8<S>) {
        value.store_slice(&mut self.0[half * HALF..(half + 1) * HALF]);
    }
}

impl Rays {
    pub(super) const ZERO: Self = Self { origin: [Lanes::ZERO; 3], direction: [Lanes::ZERO; 3] };

    pub(super) fn set(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis].0[lane] = ray.origin[axis];
            self.direction[axis].0[lane] = ray.direction[axis];
        }
    }

    pub(super) fn get(&self, lane: usize) -> Ray {
        let vector = |lanes: &[Lanes; 3]| DVec3::from(std::array::from_fn(|axis| lanes[axis].0[lane]));
        Ray { origin: vector(&self.origin), direction: vector(&self.direction) }
    }

    #[inline(always)]
    pub(super) fn set_half<S: Simd>(&mut self, half: usize, origin: Vec3x8<S>, direction: Vec3x8<S>) {
        origin.store(&mut self.origin, half);
        direction.store(&mut self.direction, half);
    }

    #[inline(always)]
    pub(super) fn half<S: Simd>(&self, simd: S, half: usize) -> [Vec3x8<S>; 2] {
        [Vec3x8::load(simd, &self.origin, half), Vec3x8::load(simd, &self.direction, half)]
    }
}

// No closures here and in what is called for each box: they would be compiled without the vector instructions.
impl<S: Simd> Vec3x8<S> {
    #[inline(always)]
    fn load(simd: S, lanes: &[Lanes; 3], half: usize) -> Self {
        Self { x: lanes[0].half(simd, half), y: lanes[1].half(simd, half), z: lanes[2].half(simd, half) }
    }

    #[inline(always)]
    fn store(self, lanes: &mut [Lanes; 3], half: usize) {
        lanes[0].set_half(half, self.x);
        lanes[1].set_half(half, self.y);
        lanes[2].set_half(half, self.z);
    }

    /// Into another frame, as a direction: the order of operations is glam's.
    #[inline(always)]
    pub(super) fn transform_vector(self, map: &DAffine3) -> Self {
        let m = &map.matrix3;
        Self {
            x: self.x * m.x_axis.x + self.y * m.y_axis.x + self.z * m.z_axis.x,
            y: self.x * m.x_axis.y + self.y * m.y_axis.y + self.z * m.z_axis.y,
            z: self.x * m.x_axis.z + self.y * m.y_axis.z + self.z * m.z_axis.z,
        }
    }

    #[inline(always)]
    pub(super) fn transform_point(self, map: &DAffine3) -> Self {
        self.transform_vector(map).offset(map.translation)
    }

    #[inline(always)]
    pub(super) fn offset(self, by: DVec3) -> Self {
        Self { x: self.x + by.x, y: self.y + by.y, z: self.z + by.z }
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(super) fn dot_constant(self, other: DVec3) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The points at t.
    #[inline(always)]
    pub(super) fn at(self, direction: Self, t: f64x8<S>) -> Self {
        Self { x: self.x + direction.x * t, y: self.y + direction.y * t, z: self.z + direction.z * t }
    }
}

/// A ray into another frame; the same operations as for eight.
pub(crate) fn transform(ray: &Ray, map: &DAffine3) -> Ray {
    Ray { origin: map.transform_point3(ray.origin), direction: map.transform_vector3(ray.direction) }
}
