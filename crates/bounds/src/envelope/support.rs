//! Supports of slabs in any direction, from above, in some ten operations.
//!
//! The 26 directions of the slabs cut space into 48 cones, one for each order and each choice of signs of the coordinates.
//! A direction q whose coordinates have the sizes x ≥ y ≥ z is in the cone of an axis, of the diagonal of a face and of
//! that of the cube,
//!
//! > q = (x − y)·(1, 0, 0) + (y − z)·(1, 1, 0) + z·(1, 1, 1)
//!
//! but for order and signs, and supports of sums are at most the sums of the supports. A box knows the support of the
//! axes alone; turned by 45° it grows by √2, and these slabs do not grow at all.

use glam::DVec3;

use crate::Slabs;

/// More than the sum of three products errs, relative to the sizes in it.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The first of the directions that are diagonals of the cube, and of its faces.
const CORNERS: usize = 3;
const EDGES: usize = 7;

/// At least the support of what is between the slabs, which are not empty, in all directions that differ from `q` by no
/// more than `error` in each coordinate.
pub(super) fn support(slabs: &Slabs<13>, q: DVec3, error: DVec3) -> f64 {
    let plane = |index: usize, negative: bool| if negative { -slabs.min[index] } else { slabs.max[index] };
    let size = q.abs();
    let negative = [q.x < 0.0, q.y < 0.0, q.z < 0.0];
    let [first, second, last] = by_size(size);
    let [x, y, z] = [size[first], size[second], size[last]];

    let axis = plane(first, negative[first]);
    let edge = {
        let [a, b] = [negative[(last + 1) % 3], negative[(last + 2) % 3]];
        plane(if a == b { EDGES + last } else { EDGES + 3 + last }, a)
    };
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
    // What differences lose is a direction, too.
    let lost = [if y > 0.0 { x } else { 0.0 }, if z > 0.0 { y } else { 0.0 }];
    let mut error = error;
    error[first] += (lost[0] + lost[1]) * f64::EPSILON;
    error[second] += lost[1] * f64::EPSILON;
    for axis in 0..3 {
        if error[axis] > 0.0 {
            sizes += error[axis] / ROUNDING * slabs.max[axis].max(-slabs.min[axis]).max(0.0);
        }
    }
    let above = sum + sizes * ROUNDING + f64::MIN_POSITIVE;
    if above.is_nan() { f64::INFINITY } else { above }
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
