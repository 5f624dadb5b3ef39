//! Points whose convex hull encloses a primitive: what the chain algorithm sends through the transformations.
//!
//! An affine map takes hulls to hulls, so the box of the mapped points encloses the mapped primitive, however long the
//! chain is. The paper asks for points "that approximate its convex hull sufficiently" ([TRAX95] §3). Points *on* the
//! hull would give boxes that are too small; here they *circumscribe* it.
//!
//! **Containment.** All round primitives are bodies of revolution about z, and one lemma serves them all. Let a convex
//! polygon in the (ρ, z) half-plane, with vertices (ρⱼ, zⱼ) and closed by the axis, contain the half-profile of the
//! body; its sides at the top and the bottom go straight to the axis. Then the body lies in the hull of the circles of
//! radius ρⱼ at height zⱼ: a point of the body at angle φ has (ρ, z) in the polygon, hence is a convex combination of
//! the vertices, all turned by φ, and of the two ends of the axis. Turned vertices are points of the circles, and the
//! ends of the axis are the centres of the top and the bottom circle (an apex is a circle of radius 0). And
//! each circle lies in the hull of a regular n-gon circumscribed about it, whose vertices have the radius
//! ρⱼ / cos(π/n). So the body lies in the hull of all n-gons, whatever the n of each. ∎
//!
//! **Excess.** Each n-gon has the fewest vertices that keep the set within [`EXCESS`]:
//!
//! - Cylinder, cone and frustum have circles of their own as rings, and vertices of radius at most (1 + x) ρ. Let the
//!   support in direction d be reached at ring j, and s be the length of d across the axis. It exceeds that of the
//!   circle by at most x ρⱼ s, and the circle's width, hence the body's, is at least 2 ρⱼ s.
//! - Ball and torus hull, K, are symmetric about the origin, and all vertices lie in (1 + x) K. So their support is at
//!   most (1 + x) h = h + x/2 · 2h, and 2h is the width of K.
//!
//! Both say x/2 times the width; neither changes under affine maps, since they map supports and widths alike.
//!
//! **Axes.** Along x, y and z there is no excess. Where n is a multiple of 4 and the vertices stand at (k + ½)·2π/n,
//! two sides of the n-gon touch the circle on the x axis and two on the y axis. The profile of ball and torus, a
//! circumscribed polygon with such corners too, touches in the same way on the z axis and at the equator. So boxes
//! through translations, scalings and mirrors alone are exact.
//!
//! **Rounding.** Computed vertices miss their exact places by some ulps; all polygons are made larger by [`SLACK`]
//! about their own centres, which is more.

use std::borrow::Cow;
use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use crate::Aabb;

/// How much larger the point sets of this crate are than their primitives.
///
/// In every direction, the support of a point set exceeds that of its primitive by at most half of this times the
/// width of the primitive in that direction, and so does each face of a box under any chain of transformations. The
/// boxes of a union therefore exceed the exact ones by at most this part of their extent along each axis.
pub const EXCESS: f64 = 0.01;

/// By how much polygons are made larger so that rounded vertices still circumscribe.
const SLACK: f64 = 1.0 + 8.0 * f64::EPSILON;

/// The sides of the polygon about a ball's profile. With 28 or 36, the rings that [`EXCESS`] allows have more vertices.
const BALL_SIDES: u32 = 32;

/// The sides of the polygon about a torus's profile: fewer do, as the major radius adds to the width.
const TORUS_SIDES: u32 = 24;

/// Points whose convex hull encloses a shape.
#[derive(Clone, Debug, PartialEq)]
pub enum PointSet<'a> {
    /// Finitely many points; of none, the shape is empty.
    Points(Cow<'a, [DVec3]>),
    /// No finite set of points encloses the shape.
    Unbounded,
}

impl<'a> From<&'a [DVec3]> for PointSet<'a> {
    fn from(points: &'a [DVec3]) -> Self {
        Self::Points(Cow::Borrowed(points))
    }
}

impl From<Vec<DVec3>> for PointSet<'_> {
    fn from(points: Vec<DVec3>) -> Self {
        Self::Points(Cow::Owned(points))
    }
}

impl PointSet<'static> {
    /// No points.
    pub const EMPTY: Self = Self::Points(Cow::Borrowed(&[]));

    /// About the unit ball at the origin: 344 points.
    pub fn sphere() -> Self {
        static POINTS: LazyLock<Vec<DVec3>> = LazyLock::new(|| revolved_circle(0.0, 1.0, BALL_SIDES));
        Self::from(POINTS.as_slice())
    }

    /// About the cylinder of radius 1 about the z axis, z from 0 to 1: 48 points.
    pub fn cylinder() -> Self {
        static POINTS: LazyLock<Vec<DVec3>> = LazyLock::new(|| frustum(1.0));
        Self::from(POINTS.as_slice())
    }

    /// About the cone with base radius 1 at z = 0 and its apex at z = 1: 25 points.
    pub fn cone() -> Self {
        static POINTS: LazyLock<Vec<DVec3>> = LazyLock::new(|| {
            let mut points = Vec::new();
            ring(&mut points, 1.0, 0.0, |radius| radius <= 1.0 + EXCESS);
            points.push(DVec3::Z);
            points
        });
        Self::from(POINTS.as_slice())
    }

    /// About the frustum of a cone with radius 1 at z = 0 and radius `top` at z = 1: 48 points.
    pub fn frustum(top: f64) -> Self {
        Self::from(frustum(top))
    }

    /// About the cube [−1, 1]³: its 8 corners.
    pub fn cube() -> Self {
        static POINTS: LazyLock<[DVec3; 8]> =
            LazyLock::new(|| Aabb::new(DVec3::NEG_ONE, DVec3::ONE).corners());
        Self::from(POINTS.as_slice())
    }

    /// About the torus with major radius 1 about the z axis and a minor radius above 0 and at most 1: about 300 points.
    pub fn torus(minor: f64) -> Self {
        Self::from(revolved_circle(1.0, minor, TORUS_SIDES))
    }
}

/// Two rings, of radius 1 at z = 0 and of radius `top` at z = 1.
fn frustum(top: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    for (rho, z) in [(1.0, 0.0), (top, 1.0)] {
        ring(&mut points, rho, z, |radius| radius <= (1.0 + EXCESS) * rho);
    }
    points
}

/// About what a circle of radius `minor` sweeps whose centre turns on a circle of radius `major`, 0 for a ball, with a
/// polygon of so many sides about the profile.
///
/// The hull is that of the outer half of the profile alone: the topmost side of the polygon touches above the centre
/// of the profile, so the ring at its outer end covers the flat top of the hull, and so below.
fn revolved_circle(major: f64, minor: f64, sides: u32) -> Vec<DVec3> {
    // A ball rolled over a disc: a point is in it within `minor` of the disc. This is it, larger by the excess.
    let (disc, ball) = ((1.0 + EXCESS) * major, (1.0 + EXCESS) * minor);
    let mut points = Vec::new();
    for DVec2 { x, y } in circumscribed(sides).into_iter().filter(|vertex| vertex.x > 0.0) {
        let (rho, z) = (major + minor * x, minor * y);
        ring(&mut points, rho, z, |radius| DVec2::new((radius - disc).max(0.0), z).length() <= ball);
    }
    points
}

/// Adds the n-gon about the circle of radius `rho` at height `z` with the fewest vertices whose radius is `allowed`.
fn ring(points: &mut Vec<DVec3>, rho: f64, z: f64, allowed: impl Fn(f64) -> bool) {
    static POLYGONS: LazyLock<[Vec<DVec2>; 8]> =
        LazyLock::new(|| [4, 8, 12, 16, 20, 24, 28, 32].map(circumscribed));
    let fits = |polygon: &&Vec<DVec2>| allowed(rho * polygon[0].length());
    // 32 vertices are enough for every ring of this module, which a test shows.
    let polygon = POLYGONS.iter().find(fits).unwrap_or(&POLYGONS[7]);
    points.extend(polygon.iter().map(|vertex| (rho * *vertex).extend(z)));
}

/// The regular polygon about the unit circle with `sides` sides, a multiple of 4, of which four touch it on the axes.
fn circumscribed(sides: u32) -> Vec<DVec2> {
    let half = PI / f64::from(sides);
    let radius = SLACK / libm::cos(half);
    let corner = |k: u32| {
        let (sin, cos) = libm::sincos(f64::from(2 * k + 1) * half);
        radius * DVec2::new(cos, sin)
    };
    // Quarter turns are exact, so that the polygon is as symmetric as the circle about the axes.
    let turns: [fn(DVec2) -> DVec2; 4] = [|v| v, DVec2::perp, |v| -v, |v| -v.perp()];
    turns.iter().flat_map(|turn| (0..sides / 4).map(corner).map(turn)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    type Support = fn(f64, f64, f64) -> f64;

    /// The round point sets with the measure it depends on and the support of its primitive, as a function of the measure
    /// and of a direction's parts across and along the axis.
    fn cases() -> impl Iterator<Item = (PointSet<'static>, f64, Support)> {
        let fixed: [(PointSet<'static>, f64, Support); 3] = [
            (PointSet::sphere(), 0.0, |_, s, z| libm::hypot(s, z)),
            (PointSet::cylinder(), 1.0, |_, s, z| s + z.max(0.0)),
            (PointSet::cone(), 0.0, |_, s, z| s.max(z)),
        ];
        let frustums = [1e-9, 0.2, 1.0, 3.0, 1e9].map(|top| -> (PointSet<'static>, f64, Support) {
            (PointSet::frustum(top), top, |top, s, z| s.max(top * s + z))
        });
        let tori = (1..=200).map(|i| 0.005 * f64::from(i)).chain([1e-12, 1e-300]);
        let tori = tori.map(|minor| -> (PointSet<'static>, f64, Support) {
            (PointSet::torus(minor), minor, |minor, s, z| s + minor * libm::hypot(s, z))
        });
        fixed.into_iter().chain(frustums).chain(tori)
    }

    #[test]
    fn they_circumscribe_and_exceed_by_no_more_than_they_say() {
        for (set, measure, support) in cases() {
            let PointSet::Points(points) = set else { panic!("bounded") };
            for step in 0..2_000 {
                // Directions that turn about the axis while they go from pole to pole, the poles and equator included.
                let (along, about) = (PI * f64::from(step) / 1_999.0, f64::from(step) * 0.731);
                let (across, z) = (libm::sin(along), libm::cos(along));
                let d = DVec3::new(across * libm::cos(about), across * libm::sin(about), z);
                let exact = support(measure, across, z);
                let width = exact + support(measure, across, -z);
                let found = points.iter().map(|p| p.dot(d)).fold(f64::NEG_INFINITY, f64::max);
                assert!(found >= exact - 1e-15 * width, "{measure} {d}: {found} < {exact}");
                assert!(found <= exact + (EXCESS / 2.0 + 1e-15) * width, "{measure} {d}: {found} > {exact}");
            }
        }
    }

    #[test]
    fn they_are_exact_along_the_axes() {
        for (set, measure, support) in cases() {
            let PointSet::Points(points) = set else { panic!("bounded") };
            let bounds = Aabb::from_points(points.iter().copied());
            let radius = support(measure, 1.0, 0.0);
            let exact = Aabb::new(
                DVec3::new(-radius, -radius, -support(measure, 0.0, -1.0)),
                DVec3::new(radius, radius, support(measure, 0.0, 1.0)),
            );
            assert!(bounds.encloses(exact), "{measure}: {bounds:?} {exact:?}");
            assert!(exact.grown(1e-14 * radius).encloses(bounds), "{measure}: {bounds:?} {exact:?}");
        }
    }

    #[test]
    fn they_are_as_small_as_documented() {
        let count = |set: PointSet<'_>| if let PointSet::Points(points) = set { points.len() } else { 0 };
        assert_eq!(count(PointSet::sphere()), 344);
        assert_eq!(count(PointSet::cylinder()), 48);
        assert_eq!(count(PointSet::cone()), 25);
        assert_eq!(count(PointSet::frustum(0.5)), 48);
        assert_eq!(count(PointSet::cube()), 8);
        for i in 1..=100 {
            let points = count(PointSet::torus(0.01 * f64::from(i)));
            assert!((280..=340).contains(&points), "{points}");
        }
    }
}
