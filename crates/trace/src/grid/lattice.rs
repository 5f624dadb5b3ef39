//! Where voxels are, and which of them a ray passes: 3DDDA \[FUJI86\].
//!
//! A ray goes from voxel to voxel, each time across the face that it meets first. \[FUJI86\] steps in integers and adds up
//! increments. Here the parameter of a crossing is computed from the number of its plane, so that no error adds up on a
//! long way, and the ray keeps its direction's length: the crossings are on the scale of the hits.
//!
//! Which voxel a point belongs to is decided by rounding where it is within some ulps of a face. A ray in a face, or
//! through a corner, passes some of the voxels there and not others. So that nothing is missed, what is put into voxels
//! is put into all that are within a [margin](Lattice::margin) of it. The margin is a millionfold of what is rounded on a
//! ray from nearby; rays from [far away](Lattice::sees) do not use the voxels.

use csg_graph_bounds::Aabb;
use glam::DVec3;

use crate::{Ray, slab};

/// The margin, relative to the coordinates of the box.
const MARGIN: f64 = 1e-9;

/// How far away rays may start, relative to the coordinates of the box.
const FAR: f64 = 1e4;

/// A box cut into equal voxels.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    bounds: Aabb,
    /// The extent of a voxel.
    size: DVec3,
    /// Voxels along each axis.
    counts: [usize; 3],
    /// What is this close to a voxel counts as in it.
    margin: f64,
    /// The largest coordinate.
    reach: f64,
}

/// A ray on its way through the voxels: of each the index, and the parameter where the ray leaves it.
#[derive(Debug)]
pub(super) struct March<'a> {
    lattice: &'a Lattice,
    ray: Ray,
    voxel: Option<[usize; 3]>,
    /// Where the ray crosses the next plane across each axis.
    crossings: [f64; 3],
}

impl Lattice {
    /// Cuts a box, its longest side into `resolution` voxels and the others so that voxels are about cubes. If it is empty
    /// or has no end, there are voxels somewhere, which no ray sees.
    pub(super) fn new(solid: &Aabb, resolution: u32) -> Self {
        let (solid, reach) = if solid.is_bounded() && !solid.is_empty() {
            (*solid, solid.min.abs().max(solid.max.abs()).max_element())
        } else {
            (Aabb::from_points([DVec3::ZERO]), f64::NEG_INFINITY)
        };
        let margin = (MARGIN * reach).max(f64::MIN_POSITIVE);
        let bounds = Aabb { min: solid.min - margin, max: solid.max + margin };
        let extent = bounds.size();
        let side = extent.max_element() / f64::from(resolution);
        let counts = extent.to_array().map(|extent| floor(extent / side + 0.999, resolution as usize).max(1));
        let size = extent / DVec3::from(counts.map(|count| count as f64));
        Self { bounds, size, counts, margin, reach }
    }

    /// How many voxels there are.
    pub(super) fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// How many there are along the longest side.
    pub(super) fn resolution(&self) -> usize {
        self.counts.into_iter().fold(0, usize::max)
    }

    /// The longest side of a voxel.
    pub(super) fn voxel_extent(&self) -> f64 {
        self.size.max_element()
    }

    /// All voxels that a box touches, each with its own box; both with their margins.
    pub(super) fn touched(&self, bounds: &Aabb) -> impl Iterator<Item = (usize, Aabb)> + '_ {
        let [first, last] = [bounds.min - self.margin, bounds.max + self.margin].map(|at| self.voxel(at));
        let range = move |axis: usize| first[axis]..=last[axis];
        range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| [x, y, z]))).map(
            move |voxel| {
                let min = self.bounds.min + self.size * DVec3::from(voxel.map(|at| at as f64));
                (self.index(voxel), Aabb { min: min - self.margin, max: min + self.size + self.margin })
            },
        )
    }

    /// Whether the ray starts near enough for the margin to cover its rounding.
    pub(super) fn sees(&self, ray: &Ray) -> bool {
        ray.origin.is_finite()
            && ray.direction.is_finite()
            && ray.origin.abs().max_element() <= FAR * self.reach
    }

    /// The voxels that a ray passes from t = 0 on, if it does.
    pub(super) fn march(&self, ray: &Ray) -> March<'_> {
        let mut march = March { lattice: self, ray: *ray, voxel: None, crossings: [f64::INFINITY; 3] };
        if let Some((near, far)) = slab::interval(&self.bounds, ray)
            && far >= 0.0
        {
            let start = self.voxel(ray.at(near.max(0.0)));
            march.voxel = Some(start);
            march.crossings = [0, 1, 2].map(|axis| march.crossing(axis, start[axis]));
        }
        march
    }

    /// The voxel that holds a point, or is nearest to it.
    fn voxel(&self, point: DVec3) -> [usize; 3] {
        let at = (point - self.bounds.min) / self.size;
        [0, 1, 2].map(|axis| floor(at[axis], self.counts[axis] - 1))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }
}

impl March<'_> {
    /// Where the ray leaves what is between the planes of that number and the next, across an axis.
    fn crossing(&self, axis: usize, number: usize) -> f64 {
        let direction = self.ray.direction[axis];
        if direction == 0.0 {
            return f64::INFINITY;
        }
        let number = if direction > 0.0 { number + 1 } else { number };
        let plane = self.lattice.bounds.min[axis] + self.lattice.size[axis] * number as f64;
        (plane - self.ray.origin[axis]) / direction
    }

    /// The number of the next voxel along an axis, if there is one.
    fn beside(&self, axis: usize, number: usize) -> Option<usize> {
        let direction = self.ray.direction[axis];
        if direction > 0.0 {
            Some(number + 1).filter(|number| *number < self.lattice.counts[axis])
        } else if direction < 0.0 {
            number.checked_sub(1)
        } else {
            None
        }
    }
}

impl Iterator for March<'_> {
    type Item = (usize, f64);

    fn next(&mut self) -> Option<Self::Item> {
        let mut voxel = self.voxel?;
        let passed = self.lattice.index(voxel);
        let [x, y, z] = self.crossings;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        let leaves = self.crossings[axis];
        self.voxel = self.beside(axis, voxel[axis]).map(|number| {
            voxel[axis] = number;
            self.crossings[axis] = self.crossing(axis, number);
            voxel
        });
        Some((passed, leaves))
    }
}

/// The whole number below, from 0 to `most`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "casts saturate")]
fn floor(number: f64, most: usize) -> usize {
    (number as usize).min(most)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn lattice() -> Lattice {
        Lattice::new(&Aabb::new(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 2.0, 3.0)), 8)
    }

    fn passed(lattice: &Lattice, ray: &Ray) -> Vec<usize> {
        lattice.march(ray).map(|(voxel, _)| voxel).collect()
    }

    #[test]
    fn voxels_are_about_cubes() {
        assert_eq!(lattice().counts, [8, 4, 2]);
        let flat = Lattice::new(&Aabb::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 0.3)), 10);
        assert_eq!(flat.counts, [10, 1, 3]);
        let point = Lattice::new(&Aabb::new(DVec3::ZERO, DVec3::ZERO), 4);
        assert_eq!(point.counts, [4; 3]);
        assert_eq!(lattice().touched(&lattice().bounds).count(), lattice().len());
    }

    #[test]
    fn a_ray_along_an_axis_passes_one_row() {
        let along = Ray { origin: DVec3::new(-9.0, 0.3, 2.7), direction: DVec3::X };
        let row: Vec<usize> = (0..8).map(|x| 4 * 8 + x).collect();
        assert_eq!(passed(&lattice(), &along), row);
        let back = Ray { origin: DVec3::new(1.1, 0.3, 2.7), direction: -3.0 * DVec3::X };
        assert_eq!(passed(&lattice(), &back), row[..5].iter().rev().copied().collect::<Vec<_>>());
        assert!(passed(&lattice(), &Ray { origin: DVec3::new(4.0, 0.3, 2.7), ..along }).is_empty());
        assert!(passed(&lattice(), &Ray { origin: DVec3::new(-9.0, 2.1, 2.7), ..along }).is_empty());
    }

    #[test]
    fn a_ray_that_goes_nowhere_stays() {
        let still = Ray { origin: DVec3::new(0.1, 0.3, 2.7), direction: DVec3::ZERO };
        assert_eq!(lattice().march(&still).collect::<Vec<_>>(), [(34, f64::INFINITY)]);
    }

    proptest! {
        #[test]
        fn what_is_at_a_point_of_a_ray_is_met_before_the_ray_is_past(
            // In halves of voxels, so that many points are in faces, edges and corners.
            place in (0..=16_i32, 0..=8_i32, 0..=4_i32),
            direction in prop::array::uniform3(-3..=3_i32),
            way in prop_oneof![Just(0.0), Just(0.3), Just(1.0), 0.0..20.0],
            aside in prop_oneof![Just(0.0), -1e-16..1e-16, -1e-12..1e-12],
        ) {
            let lattice = Lattice::new(&Aabb::new(DVec3::new(-0.7, 0.1, 0.3), DVec3::new(2.1, 1.5, 1.0)), 8);
            let place = DVec3::new(place.0.into(), place.1.into(), place.2.into());
            let there = lattice.bounds.min + lattice.size * 0.5 * place;
            let direction = lattice.size * DVec3::from(direction.map(f64::from));
            let ray = Ray { origin: there - direction * way + aside, direction };
            let dot = Aabb::new(there, there);
            if direction != DVec3::ZERO {
                let touched: Vec<usize> = lattice.touched(&dot).map(|(voxel, _)| voxel).collect();
                let mut past = 0.0;
                let met = lattice.march(&ray).any(|(voxel, leaves)| {
                    let met = touched.contains(&voxel) && past <= way + 1e-12;
                    past = leaves;
                    met
                });
                prop_assert!(met, "{ray:?} at {there}");
            }
        }
    }
}
