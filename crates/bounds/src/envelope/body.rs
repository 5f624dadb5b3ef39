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

    /// From supports in opposite directions, and from a radius.
    pub(super) fn new(mut supports: impl FnMut(DVec3) -> [f64; 2], radius: f64) -> Self {
        let mut slabs = Slabs::<13>::EMPTY;
        for (i, direction) in Slabs::<13>::DIRECTIONS.into_iter().enumerate() {
            let reach = reach(radius, direction);
            let [max, min] = supports(direction).map(|support| support.min(reach));
            (slabs.min[i], slabs.max[i]) = (-min, max);
            if -min > max || max == f64::NEG_INFINITY {
                return Self::EMPTY;
            }
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

    /// At least the supports in `q` and in the opposite direction, if this is not empty, and in all directions that differ
    /// from these by no more than `error` in each coordinate.
    pub(super) fn supports(&self, q: DVec3, error: DVec3) -> [f64; 2] {
        if !(q.is_finite() && error.is_finite()) {
            return [f64::INFINITY; 2];
        }
        let reach = reach(self.radius, q.abs() + error);
        self.between_planes(q, error).map(|support| support.min(reach))
    }

    fn between_planes(&self, q: DVec3, mut error: DVec3) -> [f64; 2] {
        let Slabs { min, max } = &self.slabs;
        let planes = |index: usize, negative: bool| {
            let [min, max] = [-min[index], max[index]];
            if negative { [min, max] } else { [max, min] }
        };
        let size = q.abs();
        let negative = [q.x < 0.0, q.y < 0.0, q.z < 0.0];
        let [first, second, last] = by_size(size);
        let [x, y, z] = [size[first], size[second], size[last]];

        let axis = planes(first, negative[first]);
        let [a, b] = [negative[(last + 1) % 3], negative[(last + 2) % 3]];
        let edge = planes(if a == b { EDGES + last } else { EDGES + 3 + last }, a);
        // The first of these diagonals has all signs alike, and each of the others one that differs.
        let corner = match negative {
            [x, y, z] if x == y && y == z => planes(CORNERS, x),
            [x, y, _] if x == y => planes(CORNERS + 1, x),
            [x, _, z] if x == z => planes(CORNERS + 2, x),
            [_, y, _] => planes(CORNERS + 3, y),
        };
        // What the differences lose is a direction, too.
        if y > 0.0 {
            error += DVec3::splat(x * f64::EPSILON);
        }
        let mut lost = 0.0;
        for axis in 0..3 {
            if error[axis] > 0.0 {
                lost += error[axis] * max[axis].max(-min[axis]).max(0.0);
            }
        }
        [0, 1].map(|side| {
            let (mut sum, mut sizes) = (0.0, 0.0);
            for (share, supports) in [(x - y, axis), (y - z, edge), (z, corner)] {
                // A share of nothing reaches nowhere, even without end.
                if share > 0.0 {
                    sum += share * supports[side];
                    sizes += share * supports[side].abs();
                }
            }
            let above = sum + (sizes * ROUNDING + lost * (1.0 + ROUNDING) + f64::MIN_POSITIVE);
            if above.is_nan() { f64::INFINITY } else { above }
        })
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
