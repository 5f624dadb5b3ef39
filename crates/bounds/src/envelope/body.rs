//! What an envelope is: slabs in 13 directions [KAY86], within a ball about the origin.
//!
//! The 26 directions of the slabs cut space into 48 cones, one for each order and each choice of signs of the coordinates.
//! A direction q whose coordinates have the sizes x ≥ y ≥ z is in the cone of an axis, of the diagonal of a face and of
//! that of the cube,
//!
//! > q = (x − y)·(1, 0, 0) + (y − z)·(1, 1, 0) + z·(1, 1, 1)
//!
//! but for order and signs, and supports of sums are at most the sums of the supports. A box knows the support of the
//! axes alone; turned by 45° it grows by √2, and these slabs do not grow at all. Of a ball, in the worst direction, by 13 %.
//! The radius does not grow under any rotation: recursion that turns as it likes and shrinks a little shrinks here, too.

use glam::DVec3;

use crate::{Slabs, Volume};

/// What is between 26 planes and no further from the origin than a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    pub(super) slabs: Slabs<13>,
    pub(super) radius: f64,
}

/// More than some products and sums of them err, relative to the sizes in them.
pub(super) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The first of the directions that are diagonals of the cube, and of its faces.
const CORNERS: usize = 3;
const EDGES: usize = 7;

impl Body {
    pub(super) const EMPTY: Self = Self { slabs: Slabs::EMPTY, radius: 0.0 };

    pub(super) const ALL: Self = Self { slabs: Slabs::ALL, radius: f64::INFINITY };

    /// The origin.
    pub(super) const POINT: Self = Self { slabs: Slabs { min: [0.0; 13], max: [0.0; 13] }, radius: 0.0 };

    /// From supports, and from a radius.
    pub(super) fn new(mut support: impl FnMut(DVec3) -> f64, radius: f64) -> Self {
        let slabs = Slabs::<13>::from_support(|d| support(d).min(reach(radius, d)));
        if slabs.is_empty() {
            return Self::EMPTY;
        }
        let bounds = slabs.aabb();
        let corner = bounds.min.abs().max(bounds.max.abs()).length() * (1.0 + ROUNDING);
        Self { slabs, radius: radius.min(corner) }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.slabs.is_empty()
    }

    /// About both.
    pub(super) fn join(self, other: Self) -> Self {
        Self { slabs: self.slabs.join(other.slabs), radius: self.radius.max(other.radius) }
    }

    /// About what is in both.
    pub(super) fn intersect(self, other: Self) -> Self {
        let slabs = self.slabs.intersect(other.slabs);
        if slabs.is_empty() { Self::EMPTY } else { Self { slabs, radius: self.radius.min(other.radius) } }
    }

    /// At least the support, if this is not empty, in all directions that differ from `q` by no more than `error` in each
    /// coordinate.
    pub(super) fn support(&self, q: DVec3, error: DVec3) -> f64 {
        if !(q.is_finite() && error.is_finite()) {
            return f64::INFINITY;
        }
        self.between_planes(q, error).min(reach(self.radius, q.abs() + error))
    }

    fn between_planes(&self, q: DVec3, mut error: DVec3) -> f64 {
        let Slabs { min, max } = &self.slabs;
        let plane = |index: usize, negative: bool| if negative { -min[index] } else { max[index] };
        let size = q.abs();
        let negative = [q.x < 0.0, q.y < 0.0, q.z < 0.0];
        let [first, second, last] = by_size(size);
        let [x, y, z] = [size[first], size[second], size[last]];

        let axis = plane(first, negative[first]);
        let [a, b] = [negative[(last + 1) % 3], negative[(last + 2) % 3]];
        let edge = plane(if a == b { EDGES + last } else { EDGES + 3 + last }, a);
        // The first of these diagonals has all signs alike, and each of the others one that differs.
        let corner = match negative {
            [x, y, z] if x == y && y == z => plane(CORNERS, x),
            [x, y, _] if x == y => plane(CORNERS + 1, x),
            [x, _, z] if x == z => plane(CORNERS + 2, x),
            [_, y, _] => plane(CORNERS + 3, y),
        };
        let (mut sum, mut sizes) = (0.0, 0.0);
        for (share, support) in [(x - y, axis), (y - z, edge), (z, corner)] {
            // A share of nothing reaches nowhere, even without end.
            if share > 0.0 {
                sum += share * support;
                sizes += share * support.abs();
            }
        }
        // What the differences lose is a direction, too.
        if y > 0.0 {
            error += DVec3::splat(x * f64::EPSILON);
        }
        for axis in 0..3 {
            if error[axis] > 0.0 {
                sizes += error[axis] / ROUNDING * max[axis].max(-min[axis]).max(0.0);
            }
        }
        let above = sum + sizes * ROUNDING + f64::MIN_POSITIVE;
        if above.is_nan() { f64::INFINITY } else { above }
    }
}

/// How far a ball reaches in a direction.
fn reach(radius: f64, direction: DVec3) -> f64 {
    let length = direction.length() * (1.0 + ROUNDING) + f64::MIN_POSITIVE;
    if radius.is_finite() { radius * length } else { f64::INFINITY }
}

/// The axes, the one with the largest coordinate first.
fn by_size(size: DVec3) -> [usize; 3] {
    let mut order = [0, 1, 2];
    for [a, b] in [[0, 1], [1, 2], [0, 1]] {
        if size[order[a]] < size[order[b]] {
            order.swap(a, b);
        }
    }
    order
}
