//! Bounding volumes other than the axis-aligned box, and what they have in common with it.
//!
//! All are made from *supports*, see [`support`]: bounds of d·x over the solid, for directions d that the volume chooses.
//! No volume sees the solid itself, so one algorithm that answers support queries serves them all. A
//! [point set](PointSet) answers them too, by the largest product over its points; where the points themselves tell
//! more (a smallest sphere, the axes of a box), a volume looks at them instead.

mod cone;
mod miniball;
mod obb;
mod slab;
mod sphere;
mod support;

use glam::DVec3;

pub use obb::Obb;
pub use slab::Slabs;
pub use sphere::{CertifiedSphere, Sphere};

use crate::{Aabb, PointSet};
use support::ask;

/// A bounding volume: box, sphere, slabs or oriented box.
///
/// **What encloses what.** A volume made from a support function encloses every solid whose support is at most what
/// that function returned, in exact arithmetic. The function may be asked in any direction but zero and of any length,
/// and may return more than it has to; the more, the looser is the volume. −∞ says that there is no point; infinity,
/// or what is not a number, that no bound is known.
///
/// **No volume at all.** A solid without points has [`EMPTY`](Self::EMPTY), which has one form in each type. A solid
/// without end has a volume without end along the same axes, as far as the type can say it, and otherwise
/// [`ALL`](Self::ALL). Nothing here returns numbers that are none.
///
/// ```
/// use csg_graph_bounds::{Aabb, Obb, Slabs, Sphere, Volume};
/// use glam::DVec3;
///
/// // A rod with round ends, of radius 0.1, from the origin to (1, 2, 3): supports of its axis and of a ball add up.
/// // The factor covers what these few operations round.
/// let rod = |d: DVec3| (d.dot(DVec3::new(1.0, 2.0, 3.0)).max(0.0) + 0.1 * d.length()) * (1.0 + 1e-14);
///
/// let areas = [
///     Aabb::from_support(rod).surface_area(),
///     Slabs::<13>::from_support(rod).surface_area(),
///     Sphere::from_support(rod).surface_area(),
///     Obb::from_support(rod).surface_area(),
/// ];
/// assert_eq!(areas.map(|area| area.round()), [27.0, 7.0, 50.0, 3.0]);
/// ```
pub trait Volume: Sized {
    /// No point at all.
    const EMPTY: Self;

    /// The whole space.
    const ALL: Self;

    /// A volume about all that is in the half-spaces d·x ≤ `support(d)`.
    fn from_support(support: impl FnMut(DVec3) -> f64) -> Self;

    /// A volume about the hull of a point set: [`ALL`](Self::ALL) if that is unbounded or has a point that is not finite.
    fn from_point_set(points: &PointSet<'_>) -> Self {
        Self::from_support(|direction| points.support(direction))
    }

    /// Whether `point` is in it. So is every point of it; a point outside may pass for one of it if it is off by less
    /// than the rounding of a few operations.
    fn contains(&self, point: DVec3) -> bool;

    /// Whether no point is in it.
    fn is_empty(&self) -> bool;

    /// An axis-aligned box that encloses it.
    fn aabb(&self) -> Aabb;

    /// Its volume, rounded to nearest: zero if it is flat or empty, infinite if it has no end.
    fn volume(&self) -> f64;

    /// The area of its surface, rounded to nearest: a flat volume has two sides; infinite if it has no end.
    fn surface_area(&self) -> f64;
}

/// The axis-aligned box: six supports.
impl Volume for Aabb {
    const EMPTY: Self = Self::EMPTY;
    const ALL: Self = Self::ALL;

    fn from_support(mut support: impl FnMut(DVec3) -> f64) -> Self {
        let mut faces = |axes: [DVec3; 3]| DVec3::from_array(axes.map(|axis| ask(&mut support, axis)));
        let max = faces([DVec3::X, DVec3::Y, DVec3::Z]);
        let min = -faces([DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z]);
        let nowhere = max.min_element() == f64::NEG_INFINITY || min.max_element() == f64::INFINITY;
        if nowhere { Self::EMPTY } else { Self::new(min, max) }
    }

    fn contains(&self, point: DVec3) -> bool {
        self.contains(point)
    }

    fn is_empty(&self) -> bool {
        self.is_empty()
    }

    fn aabb(&self) -> Aabb {
        *self
    }

    fn volume(&self) -> f64 {
        self.volume()
    }

    fn surface_area(&self) -> f64 {
        self.surface_area()
    }
}
