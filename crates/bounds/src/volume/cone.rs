//! How far a solid reaches from a point, from its supports alone: directions in cones that are split where it matters.
//!
//! A ball about c with radius r encloses the solid if and only if h(u) − u·c ≤ r for *every* unit vector u. Supports are
//! known for finitely many directions; what they say about all others is this. Let directions a₁, a₂, a₃ span a cone,
//! and let y be any vector with
//!
//! > aᵢ·y ≥ h(aᵢ) − aᵢ·c for i = 1, 2, 3.
//!
//! A unit vector of the cone is u = Σ λᵢ aᵢ with λᵢ ≥ 0. The support of any solid is subadditive, so
//!
//! > h(u) − u·c ≤ Σ λᵢ (h(aᵢ) − aᵢ·c) ≤ Σ λᵢ aᵢ·y = u·y ≤ |y|. (1)
//!
//! With cones that cover all directions, the longest of their y is a radius about c. ∎ And as the supports of the solid
//! never exceed those of the points c + y, *the hull of the points c + y encloses the solid* (2).
//!
//! The shortest such y is the least bound that follows from (1): it is the length of the cone's best direction, and
//! goes to what it bounds as the cone gets narrow. (The corner where the three planes meet does not: above a face of a
//! polytope it may stay out however narrow the cone.) It lies along one aᵢ, or in the span of two, or is the corner.
//!
//! **Covering.** The eight cones between the axes cover everything. A cone is split into four by the midpoints of its
//! three edges, which are *exact*: all directions are points of the octahedron |x| + |y| + |z| = 1 with coordinates
//! n/2ᵏ, where k is the depth of the split. No direction gets lost between a cone that is split and one that is not.
//!
//! **Rounding.** Since Σ|aᵢ| = 1, a computed aᵢ·v is off by less than 2 ε times the largest coordinate of v. Both sides
//! of the conditions on y are taken with twice that as a margin, and a y that does not pass is moved inward, along the
//! sum of the three directions, until it does: (1) holds whatever rounding did to y.

use std::collections::BTreeMap;

use glam::DVec3;

use super::support::ask;
use crate::Aabb;

/// What a computed product with a direction may err, relative to the largest coordinate of the other vector.
const PRODUCT: f64 = 4.0 * f64::EPSILON;

/// By how much, relative to the largest bound, a vector may miss a condition and still be moved to pass.
const MISS: f64 = 1e-12;

/// Cones of directions that cover all, with the supports along their edges.
pub(super) struct Cones<F> {
    support: F,
    /// The directions with their supports, rounded up.
    directions: Vec<(DVec3, f64)>,
    /// The direction between two others, by their indices, the smaller first.
    midpoints: BTreeMap<[usize; 2], usize>,
    /// The cones as indices of three directions.
    cones: Vec<[usize; 3]>,
}

impl<F: FnMut(DVec3) -> f64> Cones<F> {
    /// The octants, for a solid with this box, which is neither empty nor without end, and further supports.
    pub(super) fn octants(bounds: Aabb, support: F) -> Self {
        let directions = (0..3).flat_map(|axis| {
            let direction = DVec3::AXES[axis];
            [(direction, bounds.max[axis]), (-direction, -bounds.min[axis])]
        });
        let cones = (0..8).map(|octant| [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2 & 1)]);
        Self { support, directions: directions.collect(), midpoints: BTreeMap::new(), cones: cones.collect() }
    }

    pub(super) fn len(&self) -> usize {
        self.cones.len()
    }

    /// The support in a direction, which is none of the cones'.
    pub(super) fn ask(&mut self, direction: DVec3) -> f64 {
        ask(&mut self.support, direction)
    }

    /// For each cone a vector that is longer than the solid reaches from `center` in any direction of the cone.
    pub(super) fn reaches(&self, center: DVec3) -> Vec<DVec3> {
        let center_margin = PRODUCT * center.abs().max_element() + f64::MIN_POSITIVE;
        let above: Vec<f64> = self
            .directions
            .iter()
            .map(|(direction, support)| {
                support - direction.dot(center) + (PRODUCT * support.abs() + center_margin)
            })
            .collect();
        self.cones
            .iter()
            .map(|cone| shortest(cone.map(|i| self.directions[i].0), cone.map(|i| above[i])))
            .collect()
    }

    /// Splits each cone, given with its vector of [`reaches`](Self::reaches), that is `chosen`. False if a support shows
    /// that the solid is empty.
    pub(super) fn split(&mut self, reaches: &[DVec3], chosen: impl Fn(DVec3) -> bool) -> bool {
        let mut cones = Vec::with_capacity(2 * self.cones.len());
        for (cone, reach) in std::mem::take(&mut self.cones).into_iter().zip(reaches) {
            if !chosen(*reach) {
                cones.push(cone);
                continue;
            }
            let [a, b, c] = cone;
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|edge| self.midpoint(edge));
            cones.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        self.cones = cones;
        self.directions.iter().all(|(_, support)| *support > f64::NEG_INFINITY)
    }

    /// The direction between two others, by index.
    fn midpoint(&mut self, [a, b]: [usize; 2]) -> usize {
        let edge = [a.min(b), a.max(b)];
        if let Some(&known) = self.midpoints.get(&edge) {
            return known;
        }
        let [(from, from_support), (to, to_support)] = edge.map(|i| self.directions[i]);
        let direction = 0.5 * (from + to);
        // Subadditivity bounds the support where the answer does not.
        let between = (0.5 * from_support + 0.5 * to_support).next_up();
        let support = self.ask(direction).min(between);
        self.directions.push((direction, support));
        self.midpoints.insert(edge, self.directions.len() - 1);
        self.directions.len() - 1
    }
}

/// The shortest y with aᵢ·y ≥ gᵢ, or one that is longer by some 10⁻¹² of the largest gᵢ.
fn shortest(a: [DVec3; 3], g: [f64; 3]) -> DVec3 {
    let corner = {
        let normals = [a[1].cross(a[2]), a[2].cross(a[0]), a[0].cross(a[1])];
        (g[0] * normals[0] + g[1] * normals[1] + g[2] * normals[2]) / a[0].dot(normals[0])
    };
    let along = |i: usize| a[i] * (g[i] / a[i].length_squared());
    let between = |i: usize, j: usize| {
        let (ii, ij, jj) = (a[i].length_squared(), a[i].dot(a[j]), a[j].length_squared());
        (a[i] * (g[i] * jj - g[j] * ij) + a[j] * (g[j] * ii - g[i] * ij)) / (ii * jj - ij * ij)
    };
    let candidates =
        [DVec3::ZERO, along(0), along(1), along(2), between(0, 1), between(1, 2), between(2, 0), corner];
    let size = g.iter().fold(0.0_f64, |size, g| size.max(g.abs()));
    let passes = |y: &DVec3, miss: f64| a.iter().zip(g).all(|(a, g)| a.dot(*y) >= g + miss);
    let best = candidates
        .into_iter()
        .filter(|y| passes(y, -MISS * size))
        .min_by(|x, y| x.length_squared().total_cmp(&y.length_squared()))
        .unwrap_or(corner);
    let inward = a[0] + a[1] + a[2];
    let mut y = best;
    let mut step = PRODUCT * size + f64::MIN_POSITIVE;
    while !passes(&y, PRODUCT * y.abs().max_element() + f64::MIN_POSITIVE) && y.is_finite() {
        y = best + step * inward;
        step *= 2.0;
    }
    y
}
