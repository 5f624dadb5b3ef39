//! Spheres that are as small as asked for, with a proof of how small a sphere can be.
//!
//! **From points**, the smallest sphere is found to rounding, see [`miniball`](super::miniball).
//!
//! **From supports**, it is approached between two bounds. Above: [`cone`](super::cone) turns supports in finitely many
//! directions into points c + y whose hull encloses the solid, with c the current centre, and into a radius about c.
//! The smallest ball about *those points* encloses the solid, so its centre is a better one; about that, shorter y do,
//! and the radius falls until the centre settles. Below: let that ball have the basis vⱼ with the weights λⱼ, the centre
//! c = Σ λⱼ vⱼ, and wⱼ = vⱼ − c, none longer than r. A ball with any centre x and radius R about the solid has
//! h(wⱼ) ≤ wⱼ·x + |wⱼ| R for each j. The weighted sum of these, with Σ λⱼ wⱼ = 0, is
//!
//! > r R ≥ Σ λⱼ |wⱼ| R ≥ Σ λⱼ (h(wⱼ) − wⱼ·x) = Σ λⱼ (h(wⱼ) − wⱼ·c),
//!
//! so four more supports say how small R can be. ∎ While the two bounds are further apart than the tolerance, all cones
//! are split that reach beyond it.
//!
//! ## Changes versus the literature
//! Bădoiu and Clarkson ([BADO03]) approach the smallest ball by a core-set of *points*, in 2/ε steps. A support query
//! gives no point, only a plane; hence the cones. A ball takes some 6/ε supports, and any polytope that is as near to it
//! has that many faces up to a factor; polytopes take dozens, whatever ε is.

use std::f64::consts::PI;

use glam::DVec3;

use super::Volume;
use super::cone::Cones;
use super::miniball::{Ball, smallest_ball};
use crate::{Aabb, PointSet};

/// So many cones are split no further, so that there are at most some 30,000 queries whatever the tolerance is.
const CONES: usize = 1 << 14;

/// Tolerances below this are beyond what can be told apart.
const FINEST: f64 = 1e-9;

/// The centre has settled once the radius falls by less than this part of the tolerance.
const SETTLED: f64 = 1.0 / 16.0;

/// A ball: all points within `radius` of `center`.
///
/// ```
/// use csg_graph_bounds::{PointSet, Sphere, Volume};
/// use glam::DVec3;
///
/// let cube = Sphere::from_point_set(&PointSet::cube());
/// assert!(cube.center.length() < 1e-15 && (cube.radius - 3_f64.sqrt()).abs() < 1e-14);
/// assert!(cube.contains(DVec3::ONE));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub center: DVec3,
    /// The radius: zero or more, infinite for the whole space, −∞ for no point at all.
    pub radius: f64,
}

/// A sphere, and how small a sphere about the same solid can be at best.
///
/// Up to rounding, no sphere that encloses the solid has a radius below `at_least`. With supports that are larger than
/// the solid's, that holds for what has these supports, and the solid itself may have a smaller sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CertifiedSphere {
    /// A sphere that encloses the solid.
    pub sphere: Sphere,
    /// A lower bound of the radius of all spheres that do: 0 where none is known.
    pub at_least: f64,
}

impl CertifiedSphere {
    /// A sphere whose radius is at most 1 + `tolerance` times [`at_least`](Self::at_least).
    ///
    /// The search ends before if it takes more than some 30,000 queries, which a ball, the worst case that we know, does
    /// for a tolerance below 10⁻³, or if the supports are not those of any solid. Then, too, the sphere encloses the solid
    /// and is no larger than the one about the axis-aligned box, up to rounding, and `at_least` tells how good it is.
    ///
    /// Coordinates above some 10¹⁵⁰ give [`ALL`](Volume::ALL).
    ///
    /// # Cost
    /// Support queries: some 6/`tolerance` for a ball, fewer for other smooth solids, dozens for polytopes. Besides, a
    /// microsecond or so for each query.
    pub fn from_support(mut support: impl FnMut(DVec3) -> f64, tolerance: f64) -> Self {
        let bounds = Aabb::from_support(&mut support);
        if bounds.is_empty() {
            return Self::EMPTY;
        }
        if !bounds.is_bounded() {
            return Self::ALL;
        }
        let tolerance = tolerance.max(FINEST);
        let mut cones = Cones::octants(bounds, support);
        let mut found =
            Self { sphere: Sphere { center: bounds.center(), radius: f64::INFINITY }, at_least: 0.0 };
        loop {
            let Some((sphere, reaches, ball)) = settle(&cones, found.sphere.center, tolerance) else {
                return Self::ALL;
            };
            found.sphere = sphere;
            let lower = lower_bound(&ball, |direction| cones.ask(direction));
            found.at_least = found.at_least.max(lower).min(sphere.radius);
            let enough = (1.0 + tolerance) * found.at_least;
            if sphere.radius <= enough || cones.len() >= CONES {
                return found;
            }
            if !cones.split(&reaches, |reach| length_up(reach) > enough) {
                return Self::EMPTY;
            }
        }
    }

    /// The smallest sphere about points, to rounding: some 10⁻¹² of the radius and 10⁻¹⁵ of the largest coordinate.
    ///
    /// [`ALL`](Volume::ALL) for an unbounded set, and for points that are not finite or have coordinates above some
    /// 10¹⁵⁰.
    ///
    /// # Cost
    /// About a dozen passes over the points.
    pub fn from_point_set(points: &PointSet<'_>) -> Self {
        let PointSet::Points(points) = points else { return Self::ALL };
        if points.is_empty() {
            return Self::EMPTY;
        }
        if !points.iter().all(|point| point.is_finite()) {
            return Self::ALL;
        }
        let ball = smallest_ball(points);
        let reaches: Vec<DVec3> = points.iter().map(|point| point - ball.center).collect();
        let sphere = Sphere::reaching(ball.center, &reaches);
        if !sphere.is_bounded() {
            return Self::ALL;
        }
        Self { sphere, at_least: ball.squared_radius.sqrt().min(sphere.radius) }
    }

    const EMPTY: Self = Self { sphere: Sphere::EMPTY, at_least: 0.0 };
    const ALL: Self = Self { sphere: Sphere::ALL, at_least: 0.0 };
}

/// Moves the centre until the radius about it settles: the sphere, the vectors that it is the longest of, and the ball
/// about the points at their ends that was found last. `None` if coordinates overflow.
fn settle<F: FnMut(DVec3) -> f64>(
    cones: &Cones<F>,
    center: DVec3,
    tolerance: f64,
) -> Option<(Sphere, Vec<DVec3>, Ball)> {
    let mut reaches = cones.reaches(center);
    let mut sphere = Sphere::reaching(center, &reaches);
    loop {
        if !sphere.is_bounded() {
            return None;
        }
        let ends: Vec<DVec3> = reaches.iter().map(|reach| sphere.center + reach).collect();
        let ball = smallest_ball(&ends);
        let moved_reaches = cones.reaches(ball.center);
        let moved = Sphere::reaching(ball.center, &moved_reaches);
        let settled = moved.radius >= sphere.radius * (1.0 - SETTLED * tolerance);
        if moved.radius < sphere.radius {
            (sphere, reaches) = (moved, moved_reaches);
        }
        if settled {
            return Some((sphere, reaches, ball));
        }
    }
}

/// What no sphere about the solid is smaller than, from the supports towards the basis of a ball; see the module.
fn lower_bound(ball: &Ball, mut support: impl FnMut(DVec3) -> f64) -> f64 {
    let spokes = ball.basis.iter().map(|(point, weight)| (point - ball.center, weight));
    let (mut sum, mut longest) = (0.0, 0.0_f64);
    for (spoke, weight) in spokes.filter(|(spoke, _)| *spoke != DVec3::ZERO) {
        sum += weight * (support(spoke) - spoke.dot(ball.center));
        longest = longest.max(length_up(spoke));
    }
    let lower = sum / longest;
    if lower.is_finite() { lower } else { 0.0 }
}

fn length(v: DVec3) -> f64 {
    libm::hypot(libm::hypot(v.x, v.y), v.z)
}

/// The length, rounded up, of a vector whose coordinates may be rounded differences.
fn length_up(v: DVec3) -> f64 {
    length(v) * (1.0 + 8.0 * f64::EPSILON)
}

impl Sphere {
    /// How far above the smallest radius [`from_support`](Volume::from_support) may end: by one part in a hundred.
    pub const TOLERANCE: f64 = 0.01;

    /// About a centre with the length of the longest of some vectors as the radius.
    fn reaching(center: DVec3, reaches: &[DVec3]) -> Self {
        let longer = |radius: f64, reach: &DVec3| {
            let length = length_up(*reach);
            if length.is_nan() { f64::INFINITY } else { radius.max(length) }
        };
        Self { center, radius: reaches.iter().fold(0.0, longer) }
    }

    fn is_bounded(&self) -> bool {
        self.center.is_finite() && self.radius < f64::INFINITY
    }
}

impl Volume for Sphere {
    const EMPTY: Self = Self { center: DVec3::ZERO, radius: f64::NEG_INFINITY };
    const ALL: Self = Self { center: DVec3::ZERO, radius: f64::INFINITY };

    /// As [`CertifiedSphere::from_support`] to a tolerance of [`TOLERANCE`](Self::TOLERANCE).
    fn from_support(support: impl FnMut(DVec3) -> f64) -> Self {
        CertifiedSphere::from_support(support, Self::TOLERANCE).sphere
    }

    /// As [`CertifiedSphere::from_point_set`].
    fn from_point_set(points: &PointSet<'_>) -> Self {
        CertifiedSphere::from_point_set(points).sphere
    }

    fn contains(&self, point: DVec3) -> bool {
        length(point - self.center) * (1.0 - 8.0 * f64::EPSILON) <= self.radius
    }

    fn is_empty(&self) -> bool {
        self.radius < 0.0
    }

    fn aabb(&self) -> Aabb {
        if self.is_empty() {
            return Aabb::EMPTY;
        }
        let [min, max] =
            [self.center - self.radius, self.center + self.radius].map(|corner| corner.to_array());
        Aabb { min: min.map(f64::next_down).into(), max: max.map(f64::next_up).into() }
    }

    fn volume(&self) -> f64 {
        let radius = self.radius.max(0.0);
        4.0 / 3.0 * PI * radius * radius * radius
    }

    fn surface_area(&self) -> f64 {
        let radius = self.radius.max(0.0);
        4.0 * PI * radius * radius
    }
}
