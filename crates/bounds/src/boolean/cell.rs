//! Cells: pieces of space that shapes are asked about, and the three answers.
//!
//! Branch and bound cuts space into boxes of the solid's frame. In the frame of a shape further down, such a box is a
//! parallelepiped: affine maps keep it one, and nothing is lost as it would be by boxes of turned boxes. What maps and
//! tests round is in the cell as its *slack*: a cell is everything within that distance of the parallelepiped. A shape
//! that is sure about all of it is right in exact arithmetic.

use glam::{DAffine3, DMat3, DVec3};

use crate::rounding::Rounding;
use crate::{Aabb, Shape};

/// Where a cell lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// No point of the cell is in the solid.
    Outside,
    /// All points of the cell are in the solid.
    Inside,
    /// Neither, or it is not known.
    Mixed,
}

/// A parallelepiped with everything that is closer to it than the slack: center + Σ tᵢ·aᵢ + s for −1 ≤ tᵢ ≤ 1 and
/// |s| ≤ slack, where the aᵢ are the columns of `half_axes`.
///
/// ```
/// use csg_graph_bounds::{Aabb, Cell, Shape, Side};
/// use glam::DVec3;
///
/// let cell = Cell::from(Aabb::new(DVec3::ZERO, DVec3::ONE));
/// assert_eq!(cell.extent(DVec3::new(1.0, 1.0, 0.0)), 1.0);
/// assert_eq!(Aabb::new(DVec3::splat(-1.0), DVec3::splat(2.0)).classify(&cell), Side::Inside);
/// assert_eq!(Aabb::new(DVec3::splat(3.0), DVec3::splat(4.0)).classify(&cell), Side::Outside);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cell {
    /// The point in the middle.
    pub center: DVec3,
    /// From the center to the middles of three faces. All zero for a single point.
    pub half_axes: DMat3,
    /// How far the cell goes beyond its parallelepiped.
    pub slack: f64,
}

impl Cell {
    /// A parallelepiped without slack.
    pub fn new(center: DVec3, half_axes: DMat3) -> Self {
        Self { center, half_axes, slack: 0.0 }
    }

    /// A single point.
    pub fn point(point: DVec3) -> Self {
        Self::new(point, DMat3::ZERO)
    }

    /// The same with another slack.
    #[must_use]
    pub fn with_slack(self, slack: f64) -> Self {
        Self { slack, ..self }
    }

    /// How far it reaches from its center along a direction, times the length of that.
    pub fn extent(&self, direction: DVec3) -> f64 {
        let along = DVec3::from_array(self.axes().map(|axis| axis.dot(direction)));
        along.abs().element_sum() + self.slack * direction.length()
    }

    /// The least d·x over its points x.
    pub fn least(&self, direction: DVec3) -> f64 {
        self.center.dot(direction) - self.extent(direction)
    }

    /// The largest d·x over its points x.
    pub fn most(&self, direction: DVec3) -> f64 {
        self.center.dot(direction) + self.extent(direction)
    }

    /// The least box about it.
    pub fn bounds(&self) -> Aabb {
        let half = self.axes().iter().fold(DVec3::splat(self.slack), |sum, axis| sum + axis.abs());
        Aabb::new(self.center - half, self.center + half)
    }

    /// No point of it is further from its center.
    pub fn radius(&self) -> f64 {
        let [a, b, c] = self.axes();
        let diagonals = [a + b + c, a + b - c, a - b + c, b + c - a];
        diagonals.iter().fold(0.0, |most: f64, diagonal| most.max(diagonal.length())) + self.slack
    }

    /// The corners of the parallelepiped.
    pub fn corners(&self) -> [DVec3; 8] {
        let [a, b, c] = self.axes();
        let sign = |corner: usize, bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
        std::array::from_fn(|i| self.center + sign(i, 1) * a + sign(i, 2) * b + sign(i, 4) * c)
    }

    /// A point of the parallelepiped that is close to `point`: the closest, if the parallelepiped is rectangular.
    pub fn near(&self, point: DVec3) -> DVec3 {
        let axes = self.axes();
        let mut t = [0.0_f64; 3];
        let mut found = self.center;
        // One pass is exact for axes that are orthogonal; others come close in a few.
        for _ in 0..3 {
            for (axis, t) in axes.iter().zip(&mut t) {
                let square = axis.length_squared();
                if square > 0.0 {
                    let moved = (*t + (point - found).dot(*axis) / square).clamp(-1.0, 1.0);
                    found += (moved - *t) * axis;
                    *t = moved;
                }
            }
        }
        found
    }

    /// Whether a plane across `direction` is between it and the shape, seen from the shape.
    pub fn is_beyond(&self, shape: &(impl Shape + ?Sized), direction: DVec3) -> bool {
        self.least(direction) > shape.support(direction)
    }

    /// Whether one of a few planes is between it and the shape: those across the axes, across its own faces, and across
    /// the line to the middle of the shape. If so, no point of it is in the shape.
    pub fn misses(&self, shape: &(impl Shape + ?Sized)) -> bool {
        let [a, b, c] = self.axes();
        let planes = [DVec3::X, DVec3::Y, DVec3::Z, b.cross(c), c.cross(a), a.cross(b)];
        let apart = |direction: DVec3| self.is_beyond(shape, direction);
        if planes.iter().any(|normal| apart(*normal) || apart(-*normal)) {
            return true;
        }
        let middle = shape.bounds().center();
        apart(self.near(middle) - middle)
    }

    /// The image of it under a map, computed as it is; the slack grows as the map enlarges distances.
    pub(super) fn image(&self, map: &DAffine3) -> Self {
        let gain = if self.slack > 0.0 { Rounding::of(map).gain() } else { 0.0 };
        Self {
            center: map.transform_point3(self.center),
            half_axes: map.matrix3 * self.half_axes,
            slack: gain * self.slack,
        }
    }

    fn axes(&self) -> [DVec3; 3] {
        [self.half_axes.x_axis, self.half_axes.y_axis, self.half_axes.z_axis]
    }
}

/// The box itself, which must have an end on all sides. Of the empty box, a point at the origin.
impl From<Aabb> for Cell {
    fn from(bounds: Aabb) -> Self {
        Self::new(bounds.center(), DMat3::from_diagonal(0.5 * bounds.size()))
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    #[test]
    fn near_is_nearest_in_a_rectangular_cell() {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7);
        let cell =
            Cell::new(DVec3::new(3.0, 1.0, -2.0), turn * DMat3::from_diagonal(DVec3::new(1.0, 0.2, 0.5)));
        let found = cell.near(DVec3::ZERO);
        // The plane through it, across the line from the origin, has the whole cell behind it.
        assert!((cell.least(found) - found.length_squared()).abs() < 1e-12);
    }

    #[test]
    fn measures_enclose_the_corners() {
        let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::new(0.1, 0.2, 0.3));
        let cell = Cell::new(DVec3::ONE, sheared).with_slack(0.01);
        for corner in cell.corners() {
            assert!(cell.bounds().contains(corner));
            assert!((corner - cell.center).length() < cell.radius());
            let d = DVec3::new(0.3, -0.4, 0.5);
            assert!(cell.least(d) < corner.dot(d) && corner.dot(d) < cell.most(d));
        }
    }

    #[test]
    fn a_turned_cell_misses_what_its_box_meets() {
        let turn = DMat3::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let cell = Cell::new(DVec3::ZERO, turn);
        let corner = Aabb::new(DVec3::new(0.9, 0.9, -1.0), DVec3::ONE);
        assert!(cell.bounds().encloses(corner));
        assert!(cell.misses(&corner));
        assert!(!cell.misses(&Aabb::new(DVec3::splat(0.6), DVec3::ONE)));
    }
}
