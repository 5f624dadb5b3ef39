//! The smallest ball about finitely many points.
//!
//! At most four of the points, the *basis*, decide it: it is the smallest ball about them, with all of them on its
//! sphere and its centre in their hull, c = Σ λⱼ pⱼ with λⱼ ≥ 0 and Σ λⱼ = 1. The search goes from basis to basis, as
//! Gärtner does it ([GAER99]): the farthest of all points joins the basis, and of the five at most, those that decide
//! *their* ball stay. The ball grows with each step, so no basis comes twice, and a dozen steps do for hundreds of points.
//!
//! **Certificate.** The weights prove a lower bound, whatever the search did. For any centre x,
//!
//! > max |pⱼ − x|² ≥ Σ λⱼ |pⱼ − x|² = Σ λⱼ |pⱼ − c|² + |c − x|² ≥ Σ λⱼ |pⱼ − c|² (1)
//!
//! so no ball about the points has a smaller squared radius than the right-hand side. ∎
//!
//! ## Changes versus the paper
//! The basis of five points is found by trying all sets of one to four of them. By (1) the right one is that whose
//! right-hand side is largest: no other exceeds the squared radius of the smallest ball, and it attains it. That needs no
//! tolerance where many points are on one sphere or in one plane, and weights that rounding spoiled do no harm.

use glam::{DMat3, DVec3};

/// Far more steps than any point set needs; rounding might go in circles.
const STEPS: usize = 1000;

/// Points within this of the sphere count as on it: a few roundings of a squared distance.
const ON_SPHERE: f64 = 1.0 + 32.0 * f64::EPSILON;

/// The smallest ball about its basis.
pub(super) struct Ball {
    pub(super) center: DVec3,
    /// Σ λⱼ |pⱼ − c|²
    pub(super) squared_radius: f64,
    /// The points pⱼ with their weights λⱼ.
    pub(super) basis: Vec<(DVec3, f64)>,
}

/// The smallest ball about `points`, which are finite and at least one.
///
/// The squared radius is never more than that of the smallest ball, up to rounding, and the same where the search came
/// to its end: the distances of the points from the centre tell how near it came.
pub(super) fn smallest_ball(points: &[DVec3]) -> Ball {
    let mut ball = Ball { center: points[0], squared_radius: 0.0, basis: vec![(points[0], 1.0)] };
    for _ in 0..STEPS {
        let farthest = farthest(points, ball.center);
        if farthest.distance_squared(ball.center) <= ball.squared_radius * ON_SPHERE {
            break;
        }
        match ball.about_another(farthest) {
            Some(larger) if larger.squared_radius > ball.squared_radius => ball = larger,
            _ => break,
        }
    }
    ball
}

fn farthest(points: &[DVec3], center: DVec3) -> DVec3 {
    let distance = |point: &DVec3| point.distance_squared(center);
    let farther = |a: &DVec3, b: &DVec3| distance(a).total_cmp(&distance(b));
    points.iter().copied().max_by(farther).expect("there is a point")
}

impl Ball {
    /// The smallest ball about the basis and another point.
    fn about_another(&self, point: DVec3) -> Option<Self> {
        let members: Vec<DVec3> = self.basis.iter().map(|(member, _)| *member).chain([point]).collect();
        let subsets = (1_u32..1 << members.len()).filter(|subset| subset.count_ones() <= 4);
        let balls = subsets.filter_map(|subset| {
            let chosen = (0..members.len()).filter(|i| subset & (1 << i) != 0);
            Self::through(&chosen.map(|i| members[i]).collect::<Vec<_>>())
        });
        balls.max_by(|a, b| a.squared_radius.total_cmp(&b.squared_radius))
    }

    /// The ball with one to four points on its sphere and its centre in their hull, if there is one.
    ///
    /// From p₀ the others are at q₁ … qₖ and the centre at Σ μᵢ qᵢ, as far from each of them: 2 qᵢ·Σ μⱼ qⱼ = |qᵢ|².
    fn through(points: &[DVec3]) -> Option<Self> {
        let (&origin, others) = points.split_first()?;
        let size = others.iter().map(|point| (point - origin).abs().max_element()).fold(0.0, f64::max);
        let mut edges = [DVec3::ZERO; 3];
        for (edge, point) in edges.iter_mut().zip(others) {
            *edge = (point - origin) / size;
        }
        // Rows of the unit matrix stand for the points that are not there.
        let (mut gram, mut squares) = (DMat3::IDENTITY, DVec3::ZERO);
        for i in 0..others.len() {
            for j in 0..others.len() {
                gram.col_mut(j)[i] = 2.0 * edges[i].dot(edges[j]);
            }
            squares[i] = edges[i].length_squared();
        }
        let mu = if others.is_empty() { DVec3::ZERO } else { gram.inverse() * squares };
        let weights = [1.0 - mu.element_sum(), mu.x, mu.y, mu.z];
        // Not so either if the points are in a line or a plane, and the weights not numbers.
        if !weights.iter().all(|weight| *weight >= 0.0) {
            return None;
        }
        let center =
            others.iter().zip(&weights[1..]).fold(origin, |sum, (p, weight)| sum + (p - origin) * *weight);
        let basis: Vec<(DVec3, f64)> = points.iter().copied().zip(weights).collect();
        let squared_radius = basis.iter().map(|(p, weight)| weight * p.distance_squared(center)).sum();
        Some(Self { center, squared_radius, basis })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_is_smallest(
            points in prop::collection::vec(prop::array::uniform3(-4_i8..=4), 1..40),
            stretch in prop::array::uniform3(prop::sample::select(vec![0.0, 1e-9, 1.0, 1.7])),
            offset in prop::sample::select(vec![0.0, 1e3]),
        ) {
            // Small integers have many points on one sphere, in one plane, and in one place.
            let place = |p: [i8; 3]| DVec3::from_array(p.map(f64::from)) * DVec3::from_array(stretch) + offset;
            let points: Vec<DVec3> = points.into_iter().map(place).collect();
            let ball = smallest_ball(&points);
            let reach = farthest(&points, ball.center).distance(ball.center);
            prop_assert!(reach <= ball.squared_radius.sqrt() * (1.0 + 1e-12) + 1e-12 * offset);
            prop_assert!(ball.basis.len() <= 4);
            prop_assert!((ball.basis.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
