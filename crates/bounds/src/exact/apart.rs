//! Whether the operands of an intersection are apart, so that nothing is left of it.
//!
//! Two solids are apart if there is a direction d in which all of the left one is before all of the right one,
//!
//! > f(d) = h_L(d) + h_R(−d) < 0
//!
//! and supports that are rounded up prove that with a single such direction, wherever it comes from. Boxes try those
//! along the axes. The others are the supports of L − R, the differences of the points of both: f is negative somewhere
//! unless the origin is in the hull of L − R, and there towards the point of it that is the nearest to the origin. The
//! search for that point is [GILB88]'s: the nearest of the hull of some points of L − R, at most four, says which way
//! to go for another one.
//!
//! It finds a direction wherever the hulls of two unions are apart, unless by less than some 10⁻⁶ of their extent.
//! Below an intersection, supports are the least of its operands', and no longer those of a hull: the operands of
//! operands are therefore compared two by two, and where intersections are further down, under unions, the search may
//! end too early. What has no end, such as a half-space, is left to the boxes.
//!
//! The chain algorithm compares operands too, along the axes of every frame above them. Where it finds them apart, there is
//! a direction, for which nobody has to look down from above.

use glam::DVec3;

use super::StateBox;
use super::bottom_up::{Known, support};
use super::furthest::{Place, furthest};
use super::query::Search;
use super::solids::{Image, Kind, Solids};
use crate::Shape;

/// The most points of the difference that one search asks for. Overlaps mostly need four.
const ROUNDS: usize = 32;

/// An operand that is an intersection itself is looked at as its own operands, up to so many.
const PIECES: usize = 4;

/// The most directions that are put to the proof, by two supports each. The first mostly passes.
const PROOFS: usize = 8;

/// By how much the direction for a furthest point differs from the one that is asked for: it should be nothing special.
const ASIDE: DVec3 = DVec3::new(0.61e-5, -0.43e-5, 0.29e-5);

/// A point is the origin if it is nearer than this, relative to the extent of the operands.
const TOUCHING: f64 = 1e-12;

/// Whether two solids, given with their boxes in the same frame, have certainly no point in common.
pub(super) fn are_apart<S: Shape>(
    solids: &Solids<S>,
    search: &mut Search,
    images: [Image; 2],
    boxes: [StateBox; 2],
) -> bool {
    let [left, right] = boxes.map(|found| found.aabb);
    if !left.is_bounded() || !right.is_bounded() {
        return false;
    }
    let size = left.join(right).size().max_element();
    let mut proofs = 0;
    let mut separates = |direction: DVec3| {
        let mut reach = |image, below, direction| {
            support(solids, search, image, direction, &Known { below, direction, offset: 0.0 }).upper
        };
        proofs += 1;
        proofs <= PROOFS
            && reach(images[0], boxes[0], direction) + reach(images[1], boxes[1], -direction) < 0.0
    };
    let [left, right] = images.map(|image| pieces(solids, image));
    left.iter().any(|left| {
        right.iter().any(|right| {
            let difference = |direction: DVec3| {
                let aside = direction + ASIDE;
                (furthest(solids, left, aside) - furthest(solids, right, -aside)) / size
            };
            let between = right.middle(solids) - left.middle(solids);
            finds(between, difference, &mut separates)
        })
    })
}

/// Whether the search finds a direction that separates, given one to begin with and the points of the difference that
/// are about the furthest.
fn finds(start: DVec3, furthest: impl Fn(DVec3) -> DVec3, separates: &mut impl FnMut(DVec3) -> bool) -> bool {
    let mut direction = start.try_normalize().unwrap_or(DVec3::X);
    let mut simplex: Vec<DVec3> = Vec::with_capacity(4);
    for _ in 0..ROUNDS {
        let point = furthest(direction);
        if !point.is_finite() {
            return false;
        }
        if point.dot(direction) < 0.0 && separates(direction) {
            return true;
        }
        simplex.push(point);
        let nearest = reduce(&mut simplex);
        if simplex.len() == 4 || nearest.length() < TOUCHING {
            return false;
        }
        direction = -nearest.normalize();
    }
    false
}

/// The solids that a solid is the intersection of, in the frame of its image: itself, if it is none.
fn pieces<S: Shape>(solids: &Solids<S>, image: Image) -> Vec<Place> {
    let mut pieces = vec![Place::of(&solids.part(image))];
    let mut at = 0;
    while let Some(piece) = pieces.get(at) {
        match &solids.solid(piece.solid).kind {
            Kind::Intersection(parts) if !parts.is_empty() && pieces.len() + parts.len() <= PIECES + 1 => {
                let piece = pieces.swap_remove(at);
                pieces.extend(solids.parts(parts).iter().map(|part| piece.below(part)));
            }
            _ => at += 1,
        }
    }
    pieces
}

/// Leaves of one to four points those that the point of their hull nearest to the origin is between. Returns that point.
fn reduce(simplex: &mut Vec<DVec3>) -> DVec3 {
    let points = std::mem::take(simplex);
    let mut nearest = DVec3::INFINITY;
    for (subset, cofactors) in cofactors(&points).iter().enumerate().take(1 << points.len()).skip(1) {
        let members = || (0..points.len()).filter(|at| subset >> at & 1 == 1);
        if !members().all(|at| cofactors[at] > 0.0) {
            continue;
        }
        let sum: f64 = members().map(|at| cofactors[at]).sum();
        let found: DVec3 = members().map(|at| points[at] * (cofactors[at] / sum)).sum();
        if found.length_squared() < nearest.length_squared() {
            nearest = found;
            *simplex = members().map(|at| points[at]).collect();
        }
    }
    nearest
}

/// For each set of points, by its bits, in which proportion they make up the nearest point to the origin of what they
/// span. If all are positive, it is between them.
fn cofactors(points: &[DVec3]) -> [[f64; 4]; 16] {
    let mut cofactors = [[0.0; 4]; 16];
    for subset in 1_usize..1 << points.len() {
        for member in (0..points.len()).filter(|at| subset >> at & 1 == 1) {
            let rest = subset & !(1 << member);
            let others = (0..points.len()).filter(|at| rest >> at & 1 == 1);
            // By the set without it, in which any other point is as good as the first.
            let along = |first: usize| points[first] - points[member];
            let first = others.clone().next();
            cofactors[subset][member] = first.map_or(1.0, |first| {
                others.map(|at| cofactors[rest][at] * points[at].dot(along(first))).sum()
            });
        }
    }
    cofactors
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn points() -> impl Strategy<Value = Vec<DVec3>> {
        prop::collection::vec(prop::array::uniform3(-1.0..1.0).prop_map(DVec3::from_array), 1..=4)
    }

    proptest! {
        /// What is nearest of a hull is as far along its own direction as any other point of it, or nearer.
        #[test]
        fn nothing_is_nearer(points in points()) {
            let mut simplex = points.clone();
            let nearest = reduce(&mut simplex);
            for point in &points {
                prop_assert!(point.dot(nearest) >= nearest.length_squared() - 1e-9, "{nearest} {simplex:?}");
            }
            for point in &simplex {
                prop_assert!((point.dot(nearest) - nearest.length_squared()).abs() < 1e-9);
            }
        }
    }

    /// The furthest points of a ball, as a difference.
    fn ball(center: DVec3) -> impl Fn(DVec3) -> DVec3 {
        move |direction| center + direction.normalize()
    }

    #[test]
    fn a_direction_is_found_from_anywhere() {
        for gap in [1.0, 1e-3, 1e-6] {
            let center = (1.0 + gap) * DVec3::new(0.6, 0.0, 0.8);
            for start in [DVec3::ZERO, DVec3::X, DVec3::Y, center] {
                let certain = |direction: DVec3| center.dot(direction) + direction.length() < 0.0;
                assert!(finds(start, ball(center), &mut { certain }), "{gap} {start}");
            }
        }
    }

    #[test]
    fn what_overlaps_is_left_soon() {
        for center in [DVec3::ZERO, DVec3::new(0.3, -0.2, 0.4), DVec3::new(0.0, 0.9, 0.0)] {
            let asked = std::cell::Cell::new(0);
            let furthest = |direction| {
                asked.set(asked.get() + 1);
                ball(center)(direction)
            };
            assert!(!finds(DVec3::Y, furthest, &mut |_| panic!("nothing is worth a certificate")));
            assert!(asked.get() < 6, "{center} {}", asked.get());
        }
    }
}
