//! Rays against hyper boxes (\[TRAX95\] §2, by the slabs of \[KAY86\]), never missing what lies inside.
//!
//! A box may end a branch only if no primitive below it would be hit, and "hit" means by the arithmetic of the walk, not by
//! exact arithmetic. The ray that arrives at a primitive has gone through k more transformations; each rounds its
//! coordinates by some ulps of their size, so that seen from the frame of the box it is the original ray displaced by at
//! most about k·κ·ε·(|origin| + |box|), with ε = 2⁻⁵³ and κ the ratio of the largest to the smallest scale factor on the
//! way down; the displacement along the ray at distance t is of the same kind, t being at most the way from the origin to
//! the box. Boxes are therefore padded by [`PADDING`] times the size of the coordinates involved, which covers k·κ up to
//! some millions. The rounding of the test itself is a few ε of the same sizes and disappears in that.
//!
//! The padding also settles the comparison with the best hit so far: a primitive's hit is a point of the padded box up to
//! rounding, so its t is not before the padded interval.

use csg_graph_bounds::Aabb;
use glam::DVec3;

use crate::Ray;

/// How far boxes are padded, relative to the coordinates of the box and of the ray's origin in its frame.
const PADDING: f64 = 1e-9;

/// The interval of t in which the line of `ray` is in `bounds` or closer to it than its padding, or `None` if it never is.
///
/// What is not a number, because coordinates have left the range of `f64`, never rules a box out.
pub(crate) fn interval(bounds: &Aabb, ray: &Ray) -> Option<(f64, f64)> {
    if bounds.is_empty() {
        return None;
    }
    let reach = finite_magnitude(bounds.min).max(finite_magnitude(bounds.max));
    let padding = PADDING * (reach + ray.origin.abs().max_element());
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let low = bounds.min[axis] - padding - origin;
        let high = bounds.max[axis] + padding - origin;
        if direction == 0.0 {
            // The quotients would be ±∞, or 0/0 in a face.
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (first, last) = if direction > 0.0 { (low, high) } else { (high, low) };
        // `max` and `min` drop what is not a number.
        near = near.max(first / direction);
        far = far.min(last / direction);
    }
    (near <= far).then_some((near, far))
}

/// The largest finite coordinate: an unbounded box needs no padding where it does not end.
fn finite_magnitude(corner: DVec3) -> f64 {
    corner.to_array().into_iter().map(f64::abs).filter(|c| c.is_finite()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: direction.into() }
    }

    #[test]
    fn edges_and_faces_count_as_inside() {
        let unit = Aabb::new(DVec3::ZERO, DVec3::ONE);
        for (origin, direction) in [
            ([0.0, 0.0, -5.0], [0.0, 0.0, 1.0]),
            ([1.0, 1.0, 5.0], [0.0, -0.0, -1.0]),
            ([-1.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
            ([-1.0, 2.0, 1.0], [1.0, -1.0, 0.0]),
        ] {
            let (near, far) = interval(&unit, &ray(origin, direction)).unwrap();
            assert!(near < far && near > 0.9 && far < 6.1, "{origin:?} {direction:?}: {near} {far}");
        }
        assert_eq!(interval(&unit, &ray([0.0, 1.1, 0.0], [1.0, 0.0, 0.0])), None);
        assert_eq!(interval(&unit, &ray([0.0, 2.1, 0.0], [1.0, -1.0, 0.0])), None);
    }

    #[test]
    fn a_point_is_a_box() {
        let point = Aabb::new(DVec3::ONE, DVec3::ONE);
        assert!(interval(&point, &ray([-2.0, -2.0, -2.0], [0.3, 0.3, 0.3])).is_some());
        assert_eq!(interval(&point, &ray([-2.0, -2.0, -2.0], [0.3, 0.3, 0.31])), None);
    }

    #[test]
    fn nothing_is_missed_and_everything_is_hit() {
        let across = ray([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert_eq!(interval(&Aabb::EMPTY, &across), None);
        assert_eq!(interval(&Aabb::ALL, &across), Some((f64::NEG_INFINITY, f64::INFINITY)));
        let below = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::new(f64::INFINITY, -1.0, f64::INFINITY) };
        let (near, far) = interval(&below, &across).unwrap();
        assert!(near.is_infinite() && (far + 1.0).abs() < 1e-8);
    }

    #[test]
    fn beyond_the_range_of_numbers_nothing_is_ruled_out() {
        let unit = Aabb::new(DVec3::ZERO, DVec3::ONE);
        for wild in [f64::INFINITY, f64::NAN] {
            assert!(interval(&unit, &ray([wild, 0.0, 0.0], [1.0, 0.0, 0.0])).is_some());
            assert!(interval(&unit, &ray([wild, wild, wild], [wild, -wild, wild])).is_some());
        }
    }
}
