//! Rays, which go down the graph from frame to frame (\[TRAX95\] §1).

use csg_graph::Transform;
use glam::DVec3;

/// A ray: the points `origin + t · direction`.
///
/// The direction has any length. It is never normalised again when the ray is mapped into another frame, so that one `t`
/// names the same point of the ray in all frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at t = 0.
    pub origin: DVec3,
    /// How far one unit of t leads.
    pub direction: DVec3,
}

impl Ray {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The same ray in the frame that `parent_from_child` maps from.
    ///
    /// Mapping the ray down is cheaper than mapping the solid up, and exact for any solid.
    pub fn into_child(&self, parent_from_child: &Transform) -> Self {
        Self {
            origin: parent_from_child.inverse_point(self.origin),
            direction: parent_from_child.inverse_vector(self.direction),
        }
    }
}
