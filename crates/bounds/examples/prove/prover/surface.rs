//! Points on the surfaces of primitives, in twice the precision: an `f64` would be off the surface by as much as the
//! boxes round.
//!
//! A third of them is anywhere, a third where solids touch their boxes (rims, poles, apices, corners and edges), and a
//! third is the furthest in a direction that matters further up: the primitive's point on a face of the box of some node
//! above. All round primitives are bodies of revolution, made of a point (ρ, z) of the profile and a turn about z.

use csg_graph::Primitive;
use glam::{DVec2, DVec3};

use super::cloud::{Cloud, Point};
use super::double::Double;
use super::random::Random;

/// Fills a cloud with `count` points of the surface. `directions` are those that matter, in the primitive's frame.
pub(crate) fn sample(
    cloud: &mut Cloud,
    primitive: &Primitive,
    directions: &[DVec3],
    count: usize,
    random: &mut Random,
) {
    let points: Vec<Point> = (0..count)
        .map(|i| match (i % 3, directions) {
            (0, _) | (2, []) => anywhere(primitive, random),
            (1, _) => extreme(primitive, random),
            _ => furthest(primitive, random.pick(directions)),
        })
        .collect();
    cloud.refill(&points, size(primitive));
}

/// The largest number in the making of a point.
fn size(primitive: &Primitive) -> f64 {
    match primitive {
        Primitive::Frustum { top } => 1.0 + top,
        Primitive::Hull(hull) => hull.points().iter().fold(1.0, |size, p| p.abs().max_element().max(size)),
        Primitive::HalfSpace => PLANE,
        _ => 2.0,
    }
}

/// How far from the origin points of the plane of a half-space are taken.
const PLANE: f64 = 4.0;

fn anywhere(primitive: &Primitive, random: &mut Random) -> Point {
    let ends = random.below(3);
    match primitive {
        // The height of a uniform point of the sphere is uniform.
        Primitive::Sphere => furthest(primitive, direction(random)),
        Primitive::Torus { .. } => furthest(primitive, direction(random)),
        Primitive::Cylinder | Primitive::Cone | Primitive::Frustum { .. } => {
            let z = if ends < 2 { ends as f64 } else { random.unit() };
            let inward = if ends < 2 { random.unit().sqrt() } else { 1.0 };
            revolve(radius(primitive, z) * inward, z.into(), turn(random))
        }
        Primitive::Cube => {
            let mut point = [0; 3].map(|_| Double::from(random.between(-1.0, 1.0)));
            point[ends] = random.sign().into();
            point
        }
        Primitive::Hull(hull) => {
            let face = hull.faces()[random.below(hull.faces().len())];
            let height = |p: &DVec3| face.normal.dot(*p);
            let mut corners = hull.points().to_vec();
            corners.sort_by(|a, b| height(b).total_cmp(&height(a)));
            mix([corners[0], corners[1], corners[2]], [random.unit(), random.unit()])
        }
        _ => {
            let [x, y] = [0; 2].map(|_| random.between(-PLANE, PLANE).into());
            [x, y, Double::default()]
        }
    }
}

/// A corner, or a point of a rim or of an edge.
fn extreme(primitive: &Primitive, random: &mut Random) -> Point {
    match primitive {
        Primitive::Cylinder | Primitive::Cone | Primitive::Frustum { .. } => {
            let z = f64::from(u8::from(random.chance(0.5)));
            revolve(radius(primitive, z), z.into(), turn(random))
        }
        Primitive::Cube => {
            let mut point = [0; 3].map(|_| Double::from(random.sign()));
            if random.chance(0.5) {
                point[random.below(3)] = random.between(-1.0, 1.0).into();
            }
            point
        }
        Primitive::Hull(hull) => exact(random.pick(hull.points())),
        Primitive::HalfSpace => anywhere(primitive, random),
        _ => furthest(primitive, random.sign() * random.pick(&DVec3::AXES)),
    }
}

/// The point that is furthest in a direction, which is not zero; of a half-space, any.
fn furthest(primitive: &Primitive, direction: DVec3) -> Point {
    let across = direction.truncate();
    match primitive {
        Primitive::Sphere => unit(direction.to_array()),
        Primitive::Torus { minor } => {
            let [rho, z] = unit([across.length(), direction.z]);
            revolve(rho * *minor + 1.0.into(), z * *minor, across)
        }
        Primitive::Cylinder | Primitive::Cone | Primitive::Frustum { .. } => {
            let reach = |z: f64| radius(primitive, z).high * across.length() + z * direction.z;
            let z = if reach(1.0) > reach(0.0) { 1.0 } else { 0.0 };
            revolve(radius(primitive, z), z.into(), across)
        }
        Primitive::Hull(hull) => {
            let reach = |p: &&DVec3| p.dot(direction);
            let corner = hull.points().iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
            exact(*corner.expect("a hull has points"))
        }
        Primitive::Cube => exact(DVec3::ONE.copysign(direction)),
        _ => exact((PLANE * direction.truncate().normalize_or_zero()).extend(0.0)),
    }
}

/// The radius of a cylinder, cone or frustum at a height.
fn radius(primitive: &Primitive, z: f64) -> Double {
    match primitive {
        Primitive::Cone => Double::sum(1.0, -z),
        Primitive::Frustum { top } => Double::sum(*top, -1.0) * z + 1.0.into(),
        _ => 1.0.into(),
    }
}

/// The point (ρ, z) of a profile, turned about z into a direction.
fn revolve(rho: Double, z: Double, towards: DVec2) -> Point {
    let towards = if towards == DVec2::ZERO { DVec2::X } else { towards };
    let [x, y] = unit(towards.to_array());
    [rho * x, rho * y, z]
}

/// A vector at length 1. The power of two by which it is scaled first keeps its square in range.
fn unit<const N: usize>(vector: [f64; N]) -> [Double; N] {
    let largest = vector.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let vector = vector.map(|x| libm::ldexp(x, -libm::ilogb(largest)));
    let square = vector.iter().fold(Double::default(), |sum, x| sum + Double::from(*x) * *x);
    let per_length = square.sqrt().recip();
    vector.map(|x| per_length * x)
}

fn exact(point: DVec3) -> Point {
    point.to_array().map(Double::from)
}

/// A point of a triangle, by two weights.
fn mix([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> Point {
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    let rest = Double::from(1.0) - Double::sum(u, v);
    [0, 1, 2].map(|axis| rest * a[axis] + Double::from(u) * b[axis] + Double::from(v) * c[axis])
}

fn turn(random: &mut Random) -> DVec2 {
    let axes = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let angle = random.between(0.0, std::f64::consts::TAU);
    if random.chance(0.25) { random.pick(&axes) } else { DVec2::new(libm::cos(angle), libm::sin(angle)) }
}

fn direction(random: &mut Random) -> DVec3 {
    let z = random.between(-1.0, 1.0);
    (turn(random) * (1.0 - z * z).sqrt()).extend(z)
}
