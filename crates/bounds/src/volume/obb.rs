//! Oriented boxes: three pairs of parallel planes along axes of their own.
//!
//! The axes are chosen in the manner of Larsson and Källberg's DiTO ([LARS11]): from a few *extremal points* of the
//! solid, one in each of a fixed set of directions, and from the triangles that these points form. A triangle with its
//! normal and one of its edges gives a frame. Each is judged by the surface area of its box about the extremal points
//! alone; the best gets a box about the solid by six supports, and competes with the axis-aligned one.
//!
//! ## Changes versus the paper
//! - DiTO looks at 7 triangles of 14 extremal points. Here all triangles of up to 26 points are tried, some 2,600.
//!   That costs a millisecond at most, and makes a promise possible: **the oriented box of a box is that box.** The
//!   corner of a box that is farthest in direction d has the signs of the coordinates of d in the box's own frame. The
//!   26 directions are nowhere more than 27.6° apart from any other (the middle between (1,0,0), (1,1,0) and (1,1,1) is
//!   that far from each), and every octant of every frame holds a cap of 35.2°, so all eight corners are extremal points.
//!   Three corners of one face form a triangle with a right angle, whose frame is the box's own. ∎ In floating point, up
//!   to rounding.
//! - Supports alone give no points. Where only they are known, the point where the plane touches is calculated as the
//!   gradient of the support, by differences. It is the corner of a polytope to 10⁻¹⁰, and of anything smooth as near
//!   to the surface as axes need. Where a direction is within the step of an edge's perpendicular plane, it is no point
//!   of the solid at all, and may spoil the axes. Axes are all that depends on it: extents are always supports.
//! - All directions are turned together out of the positions in which solids are modelled, where that would be the rule.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::support::{ask, dot_down, dot_up};
use super::{Slabs, Volume};
use crate::{Aabb, PointSet};

/// The step of differences. Longer ones meet more edges, shorter ones lose more digits.
const STEP: f64 = 1.0 / 262_144.0;

/// Points nearer to each other than this part of their box are one, and triangles flatter than this are none.
const SAME: f64 = 1e-8;

/// The axis-aligned box is preferred unless the other one is smaller by more than rounding.
const GAIN: f64 = 1.0 - 1e-12;

/// A box along orthonormal axes of its own.
///
/// It is kept as it is defined, by the coordinates aᵢ·p of its points p along its axes aᵢ. No rounding of the axes makes
/// it miss a point, as the supports are asked for along the axes as they are.
///
/// ```
/// use csg_graph_bounds::{Obb, PointSet, Volume};
/// use glam::{DMat3, DVec3};
///
/// let world_from_block = DMat3::from_rotation_y(0.3) * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0));
/// let PointSet::Points(corners) = PointSet::cube() else { unreachable!() };
/// let corners: Vec<DVec3> = corners.iter().map(|corner| world_from_block * *corner).collect();
///
/// let block = Obb::from_point_set(&PointSet::from(corners));
/// assert!((block.volume() - 2.0 * 4.0 * 6.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obb {
    world_from_box: DMat3,
    bounds: Aabb,
}

impl Obb {
    /// The axes as columns: maps from the frame of the box into the frame of the solid, up to rounding.
    pub fn world_from_box(&self) -> DMat3 {
        self.world_from_box
    }

    /// The box in its own frame: the least and greatest coordinates along its axes.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The smaller by surface area of the axis-aligned box and the box in the frame that is best about a few points.
    fn best(extremal: &[DVec3], mut support: impl FnMut(DVec3) -> f64) -> Self {
        let aligned = Self::from(Aabb::from_support(&mut support));
        let extremal = in_unit(extremal);
        let area = |frame: &DMat3| {
            let box_from_world = frame.transpose();
            Aabb::from_points(extremal.iter().map(|point| box_from_world * point)).surface_area()
        };
        let judged = frames(&extremal).into_iter().map(|frame| (area(&frame), frame));
        let oriented =
            judged.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, best)| Self::in_frame(best, support));
        oriented.filter(|found| found.surface_area() < GAIN * aligned.surface_area()).unwrap_or(aligned)
    }

    fn in_frame(world_from_box: DMat3, mut support: impl FnMut(DVec3) -> f64) -> Self {
        let bounds = Aabb::from_support(|direction| ask(&mut support, world_from_box * direction));
        if bounds.is_empty() { Self::EMPTY } else { Self { world_from_box, bounds } }
    }
}

/// Axis-aligned boxes are oriented ones.
impl From<Aabb> for Obb {
    fn from(bounds: Aabb) -> Self {
        Self { world_from_box: DMat3::IDENTITY, bounds }
    }
}

/// The 26 directions in which points are extremal, turned by some odd angle about some odd axis.
fn directions() -> impl Iterator<Item = DVec3> {
    let turn = DQuat::from_xyzw(0.11, 0.23, 0.37, 1.0).normalize();
    Slabs::<13>::DIRECTIONS.into_iter().flat_map(move |direction| [turn * direction, turn * -direction])
}

/// The point that is farthest in a direction, of at least one.
fn farthest(points: &[DVec3], direction: DVec3) -> DVec3 {
    let farther = |a: &&DVec3, b: &&DVec3| direction.dot(**a).total_cmp(&direction.dot(**b));
    *points.iter().max_by(farther).expect("there is a point")
}

/// Points moved to the origin and made a unit large, so that squares of their distances are numbers; none if they are nowhere
/// or in one place.
fn in_unit(points: &[DVec3]) -> Vec<DVec3> {
    let all = Aabb::from_points(points.iter().copied());
    let size = all.size().max_element();
    if !size.is_normal() {
        return Vec::new();
    }
    points.iter().map(|point| (point - all.min) / size).collect()
}

/// The frames of all edges and triangles of points that are a unit large.
fn frames(points: &[DVec3]) -> Vec<DMat3> {
    let mut apart: Vec<DVec3> = Vec::new();
    for point in points {
        if apart.iter().all(|other| (point - other).abs().max_element() > SAME) {
            apart.push(*point);
        }
    }
    let mut frames = Vec::new();
    for (j, to) in apart.iter().enumerate() {
        for from in &apart[..j] {
            let edge = (to - from).normalize();
            // For points in a line, which form no triangle.
            let (side, normal) = edge.any_orthonormal_pair();
            frames.push(DMat3::from_cols(edge, side, normal));
            for point in &apart {
                let across = (point - from).normalize_or_zero().reject_from_normalized(edge);
                if across.length() > SAME {
                    // Once more, so that what rounding left along the edge is not enlarged.
                    let side = across.normalize().reject_from_normalized(edge).normalize();
                    frames.push(DMat3::from_cols(edge, side, edge.cross(side)));
                }
            }
        }
    }
    frames
}

impl Volume for Obb {
    const EMPTY: Self = Self { world_from_box: DMat3::IDENTITY, bounds: Aabb::EMPTY };
    const ALL: Self = Self { world_from_box: DMat3::IDENTITY, bounds: Aabb::ALL };

    /// Never of larger surface area than the axis-aligned box. 116 queries, and up to a millisecond for solids without
    /// corners.
    ///
    /// The box of a box is that box to some 10⁻¹⁰ if the supports are exact to rounding, for all but about one in a
    /// thousand ways to turn it. Supports that are looser by δ of the extent move the axes by some 10⁵ δ; what they
    /// enclose they enclose nevertheless.
    fn from_support(mut support: impl FnMut(DVec3) -> f64) -> Self {
        let mut touching = |direction: DVec3| {
            let at = ask(&mut support, direction);
            let ahead = DVec3::AXES.map(|axis| (ask(&mut support, direction + STEP * axis) - at) / STEP);
            DVec3::from_array(ahead)
        };
        let extremal: Vec<DVec3> =
            directions().map(&mut touching).filter(|point| point.is_finite()).collect();
        Self::best(&extremal, support)
    }

    /// Never of larger surface area than the axis-aligned box; the box of a box is that box. 32 passes over the points,
    /// and up to a millisecond for solids without corners.
    fn from_point_set(points: &PointSet<'_>) -> Self {
        let extremal = match points {
            PointSet::Points(points) if !points.is_empty() => {
                directions().map(|direction| farthest(points, direction)).collect()
            }
            _ => Vec::new(),
        };
        Self::best(&extremal, |direction| points.support(direction))
    }

    fn contains(&self, point: DVec3) -> bool {
        (0..3).all(|i| {
            let axis = self.world_from_box.col(i);
            self.bounds.min[i] <= dot_up(axis, point) && dot_down(axis, point) <= self.bounds.max[i]
        }) && point.is_finite()
    }

    fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// The box of its corners, rounded outward by what the axes miss of being orthonormal.
    fn aabb(&self) -> Aabb {
        if self.world_from_box == DMat3::IDENTITY {
            return self.bounds;
        }
        // With Q for the axes, a point p has the coordinates q = Qᵀp, and is off its image Q q by (I − QQᵀ) p. No
        // entry of I − QQᵀ is above 4 ε and no coordinate of p above 2 times the largest of q.
        let margin = 32.0 * f64::EPSILON * self.bounds.magnitude();
        self.bounds.image(&DAffine3::from_mat3(self.world_from_box)).grown(margin)
    }

    fn volume(&self) -> f64 {
        self.bounds.volume()
    }

    fn surface_area(&self) -> f64 {
        self.bounds.surface_area()
    }
}
