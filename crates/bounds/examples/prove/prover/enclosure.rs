//! The bounding volumes as what they promise: inequalities, decided without any rounding of their own.

use csg_graph::State;
use csg_graph_bounds::{Aabb, CertifiedSphere, Envelopes, Obb, PointSet, Slabs, Sphere, Volume};
use glam::DVec3;

use super::cloud::{Cloud, Point, along};
use super::double::{Double, PRECISION};

/// What a volume or its maker is called in the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind(pub(crate) usize);

/// All volumes, in the order of the report.
pub(crate) const KINDS: [&str; 24] = [
    "box of the state",
    "box of the root alone",
    "hyper box, exact",
    "hyper box, chain",
    "hyper box, conventional",
    "S-bound of the root",
    "box of the solid",
    "planes of the envelope",
    "box of the envelope",
    "ball of the envelope",
    "refined box of the root",
    "box from supports",
    "sphere from supports",
    "certified sphere",
    "7 slabs from supports",
    "9 slabs from supports",
    "13 slabs from supports",
    "oriented box from supports",
    "box from points",
    "sphere from points",
    "7 slabs from points",
    "9 slabs from points",
    "13 slabs from points",
    "oriented box from points",
];

impl Kind {
    pub(crate) const STATE: Self = Self(0);
    pub(crate) const ROOT: Self = Self(1);
    pub(crate) const EXACT: Self = Self(2);
    pub(crate) const CHAIN: Self = Self(3);
    pub(crate) const CONVENTIONAL: Self = Self(4);
    pub(crate) const S_BOUND: Self = Self(5);
    pub(crate) const SOLID: Self = Self(6);
    pub(crate) const REFINED: Self = Self(10);
    const ENVELOPE: usize = 7;
    const FROM_SUPPORTS: usize = 11;
    const FROM_POINTS: usize = 18;
}

/// What encloses points.
#[derive(Clone, Debug)]
pub(crate) enum Enclosure {
    Box(Aabb),
    /// Directions, with the least and the largest product.
    Planes(Vec<(DVec3, [f64; 2])>),
    Ball(Sphere),
}

impl Enclosure {
    /// The parts of what is said of a state without a look at its random numbers.
    pub(crate) fn of_envelope(envelopes: &Envelopes, state: &State) -> Vec<(Kind, Self)> {
        const SAID: &str = "there is an end to the recursion";
        let envelope = envelopes.of(state).expect(SAID);
        let volumes = [
            (*envelope.slabs()).into(),
            Self::Box(envelopes.aabb(state).expect(SAID)),
            Self::Ball(Sphere { center: DVec3::ZERO, radius: envelope.radius() }),
        ];
        (Kind::ENVELOPE..).map(Kind).zip(volumes).collect()
    }

    /// All volumes from a support function.
    pub(crate) fn from_supports(mut support: impl FnMut(DVec3) -> f64, tolerance: f64) -> Vec<(Kind, Self)> {
        let volumes = [
            Self::Box(Volume::from_support(&mut support)),
            Self::Ball(Volume::from_support(&mut support)),
            Self::Ball(CertifiedSphere::from_support(&mut support, tolerance).sphere),
            Slabs::<7>::from_support(&mut support).into(),
            Slabs::<9>::from_support(&mut support).into(),
            Slabs::<13>::from_support(&mut support).into(),
            Obb::from_support(&mut support).into(),
        ];
        (Kind::FROM_SUPPORTS..).map(Kind).zip(volumes).collect()
    }

    /// All volumes from a point set.
    pub(crate) fn from_points(points: &PointSet<'_>) -> Vec<(Kind, Self)> {
        let volumes = [
            Self::Box(Volume::from_point_set(points)),
            Self::Ball(Volume::from_point_set(points)),
            Slabs::<7>::from_point_set(points).into(),
            Slabs::<9>::from_point_set(points).into(),
            Slabs::<13>::from_point_set(points).into(),
            Obb::from_point_set(points).into(),
        ];
        (Kind::FROM_POINTS..).map(Kind).zip(volumes).collect()
    }

    /// A point of the cloud that is outside, with by how much: at least that, whatever the errors of its coordinates.
    pub(crate) fn escape(&self, cloud: &Cloud) -> Option<(usize, f64)> {
        match self {
            Self::Box(bounds) => {
                // Rounding a coordinate never takes it past a face, so that the range settles nearly all.
                let near = (0..3).any(|axis| {
                    let [min, max] = cloud.range(axis);
                    !(bounds.min[axis] < min && max < bounds.max[axis])
                });
                let excess = |point: &Point| {
                    let faces = (0..3).map(|axis| beyond(point[axis], [bounds.min[axis], bounds.max[axis]]));
                    faces.fold(f64::NEG_INFINITY, f64::max) - cloud.error
                };
                if near { first(cloud, excess) } else { None }
            }
            Self::Planes(planes) => {
                let magnitude = cloud.magnitude();
                planes.iter().find_map(|(direction, range)| {
                    let length = direction.abs().element_sum();
                    let error = length * (cloud.error + PRECISION * magnitude);
                    first(cloud, |point| beyond(along(*direction, point), *range) - error)
                })
            }
            Self::Ball(Sphere { center, radius }) => {
                if *radius == f64::INFINITY {
                    return None;
                }
                let error = cloud.error + PRECISION * (cloud.magnitude() + center.abs().max_element());
                first(cloud, |point| {
                    let reach = [0, 1, 2].map(|axis| point[axis] - center[axis].into());
                    let square = reach.iter().fold(Double::default(), |sum, x| sum + *x * *x);
                    (square.sqrt() - (*radius).into()).high - error
                })
            }
        }
    }
}

/// The first point whose excess is above zero, or no number.
fn first(cloud: &Cloud, excess: impl Fn(&Point) -> f64) -> Option<(usize, f64)> {
    (0..cloud.len())
        .map(|i| (i, excess(&cloud.point(i))))
        .find(|(_, excess)| *excess > 0.0 || excess.is_nan())
}

/// How far a number is outside of a range; not above zero if it is inside.
fn beyond(number: Double, [min, max]: [f64; 2]) -> f64 {
    above(number, max).max(above(-number, -min))
}

/// How far a number is above a limit. Nothing is above infinity, and everything above what is no number.
fn above(number: Double, limit: f64) -> f64 {
    if limit.is_finite() {
        (number - limit.into()).high
    } else if limit == f64::INFINITY {
        f64::NEG_INFINITY
    } else {
        f64::INFINITY
    }
}

impl<const N: usize> From<Slabs<N>> for Enclosure {
    fn from(slabs: Slabs<N>) -> Self {
        let ranges = slabs.min.into_iter().zip(slabs.max).map(|(min, max)| [min, max]);
        Self::Planes(Slabs::<N>::DIRECTIONS.into_iter().zip(ranges).collect())
    }
}

impl From<Obb> for Enclosure {
    fn from(oriented: Obb) -> Self {
        let (axes, bounds) = (oriented.world_from_box(), oriented.bounds());
        Self::Planes((0..3).map(|i| (axes.col(i), [bounds.min[i], bounds.max[i]])).collect())
    }
}

#[cfg(test)]
mod tests {
    use csg_graph::Primitive;

    use super::super::random::Random;
    use super::super::surface;
    use super::*;

    /// One ulp decides.
    #[test]
    fn nothing_is_tolerated() {
        let mut cloud = Cloud::default();
        surface::sample(&mut cloud, &Primitive::Sphere, &[DVec3::X, DVec3::ONE], 96, &mut Random::new(0, 0));
        let ball = |radius: f64| Enclosure::Ball(Sphere { center: DVec3::ZERO, radius });
        assert!(ball(1.0).escape(&cloud).is_none());
        assert!(ball(1_f64.next_down()).escape(&cloud).is_some());
        let unit = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        assert!(Enclosure::Box(unit).escape(&cloud).is_none());
        let cut = Aabb { max: unit.max.with_x(1_f64.next_down()), ..unit };
        assert!(Enclosure::Box(cut).escape(&cloud).is_some());
        let diagonal = |most: f64| Enclosure::Planes(vec![(DVec3::ONE, [-2.0, most])]);
        assert!(diagonal(3_f64.sqrt().next_up()).escape(&cloud).is_none());
        assert!(diagonal(3_f64.sqrt().next_down()).escape(&cloud).is_some());
        for nothing in [Enclosure::Box(Aabb::EMPTY), Enclosure::Ball(Sphere::EMPTY)] {
            assert!(nothing.escape(&cloud).is_some());
        }
        assert!(Enclosure::Box(Aabb::ALL).escape(&cloud).is_none());
    }
}
