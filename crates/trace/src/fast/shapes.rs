//! The first boundary of a primitive on eight rays: [`crate::shapes`], operation by operation, with choices in place of
//! branches.

use csg_graph::{Hull, Primitive};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f64x8, mask64x8};

use super::lanes::Vec3x8;
use super::lanes::bits;

/// Where eight lines are inside of a convex solid: from the first to the second, if that is greater.
pub(super) type Span<S> = [f64x8<S>; 2];

/// The first boundary in front of the origin, and for which rays there is one.
#[inline(always)]
pub(super) fn first<S: Simd>(simd: S, [enter, exit]: Span<S>) -> (f64x8<S>, u32) {
    let zero = f64x8::splat(simd, 0.0);
    let t = enter.simd_gt(zero).select(enter, exit);
    let valid = enter.simd_lt(exit) & t.simd_gt(zero);
    (t, bits(valid))
}

/// The span of a primitive, if its kind is one that is computed side by side.
#[inline(always)]
pub(super) fn span<S: Simd>(simd: S, primitive: &Primitive, ray: [Vec3x8<S>; 2]) -> Option<Span<S>> {
    Some(match primitive {
        Primitive::Sphere => sphere(simd, ray),
        Primitive::Cylinder => cylinder(simd, ray),
        Primitive::Cone => cone(simd, ray),
        Primitive::Cube => cube(simd, ray),
        Primitive::Hull(solid) => hull(simd, solid, ray),
        _ => return None,
    })
}

/// The outward normals of a primitive where lines have a boundary at t, as [`crate::shapes::normal_at`], if its kind is one of
/// which these are computed side by side.
#[inline(always)]
pub(super) fn normals_at<S: Simd>(
    simd: S,
    primitive: &Primitive,
    ray: [Vec3x8<S>; 2],
    t: f64x8<S>,
) -> Option<Vec3x8<S>> {
    let [origin, direction] = ray;
    let point = origin.at(direction, t);
    Some(match primitive {
        Primitive::Sphere => point,
        Primitive::Cylinder => caps_or(simd, ray, t, Vec3x8 { z: f64x8::splat(simd, 0.0), ..point }),
        Primitive::Cone => caps_or(simd, ray, t, side_of_cone(simd, point, SLOPE)),
        Primitive::Frustum { top } => caps_or(simd, ray, t, side_of_cone(simd, point, top - 1.0)),
        Primitive::Cube => face_of_cube(simd, ray, t),
        _ => return None,
    })
}

#[inline(always)]
fn caps_or<S: Simd>(simd: S, [origin, direction]: [Vec3x8<S>; 2], t: f64x8<S>, side: Vec3x8<S>) -> Vec3x8<S> {
    let [zero, one] = [f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0)];
    let is_low = ((zero - origin.z) / direction.z).simd_eq(t);
    let is_high = ((one - origin.z) / direction.z).simd_eq(t);
    let is_cap = is_low | is_high;
    Vec3x8 {
        x: is_cap.select(zero, side.x),
        y: is_cap.select(zero, side.y),
        z: is_low.select(-one, is_high.select(one, side.z)),
    }
}

#[inline(always)]
fn side_of_cone<S: Simd>(simd: S, point: Vec3x8<S>, slope: f64) -> Vec3x8<S> {
    let radius = (point.x * point.x + point.y * point.y).sqrt();
    let zero = f64x8::splat(simd, 0.0);
    let is_apex = radius.simd_eq(zero);
    Vec3x8 {
        x: is_apex.select(zero, point.x),
        y: is_apex.select(zero, point.y),
        z: is_apex.select(f64x8::splat(simd, (-slope).signum()), radius * -slope),
    }
}

#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "iterators would be compiled without the vector instructions")]
fn face_of_cube<S: Simd>(simd: S, [origin, direction]: [Vec3x8<S>; 2], t: f64x8<S>) -> Vec3x8<S> {
    let [zero, one] = [f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0)];
    let (origin, direction) = ([origin.x, origin.y, origin.z], [direction.x, direction.y, direction.z]);
    let mut closest = f64x8::splat(simd, f64::INFINITY);
    let mut normal = [zero; 3];
    for axis in 0..3 {
        let low = ((-one - origin[axis]) / direction[axis] - t).abs();
        let high = ((one - origin[axis]) / direction[axis] - t).abs();
        let is_low = low.simd_lt(closest);
        closest = is_low.select(low, closest);
        let is_high = high.simd_lt(closest);
        closest = is_high.select(high, closest);
        for other in 0..axis {
            normal[other] = (is_low | is_high).select(zero, normal[other]);
        }
        normal[axis] = is_high.select(one, is_low.select(-one, zero));
    }
    let [x, y, z] = normal;
    Vec3x8 { x, y, z }
}

#[inline(always)]
fn sphere<S: Simd>(simd: S, [origin, direction]: [Vec3x8<S>; 2]) -> Span<S> {
    let squared_length = direction.dot(direction);
    let middle = -origin.dot(direction) / squared_length;
    let closest = origin.at(direction, middle);
    let half = ((f64x8::splat(simd, 1.0) - closest.dot(closest)) / squared_length).sqrt();
    [middle + -half, middle + half]
}

#[inline(always)]
fn cube<S: Simd>(simd: S, [origin, direction]: [Vec3x8<S>; 2]) -> Span<S> {
    let x = slab(simd, origin.x, direction.x, -1.0, 1.0);
    let y = slab(simd, origin.y, direction.y, -1.0, 1.0);
    let z = slab(simd, origin.z, direction.z, -1.0, 1.0);
    clip(clip(x, y), z)
}

#[inline(always)]
fn cylinder<S: Simd>(simd: S, [origin, direction]: [Vec3x8<S>; 2]) -> Span<S> {
    let caps = slab(simd, origin.z, direction.z, 0.0, 1.0);
    let (one, zero) = (f64x8::splat(simd, 1.0), f64x8::splat(simd, 0.0));
    let squared_length = direction.x * direction.x + direction.y * direction.y;
    let middle = -(origin.x * direction.x + origin.y * direction.y) / squared_length;
    let (x, y) = (origin.x + direction.x * middle, origin.y + direction.y * middle);
    let squared_half = (one - (x * x + y * y)) / squared_length;
    let half = squared_half.sqrt();
    let is_met = squared_half.simd_gt(zero);
    let is_along = squared_length.simd_eq(zero);
    let is_within = (origin.x * origin.x + origin.y * origin.y).simd_lt(one);
    let side = choose_line(simd, is_along, is_within, keep(simd, is_met, [middle + -half, middle + half]));
    clip(caps, side)
}

/// How the radius of a cone grows with its height.
const SLOPE: f64 = -1.0;

#[inline(always)]
fn cone<S: Simd>(simd: S, [origin, direction]: [Vec3x8<S>; 2]) -> Span<S> {
    let splat = |value| f64x8::splat(simd, value);
    let (zero, infinity) = (splat(0.0), splat(f64::INFINITY));
    let caps = slab(simd, origin.z, direction.z, 0.0, 1.0);
    let to_middle = Vec3x8 { x: zero - origin.x, y: zero - origin.y, z: splat(0.5) - origin.z };
    let middle = to_middle.dot(direction) / direction.dot(direction);
    let p = origin.at(direction, middle);
    let (radius, growth) = (p.z * SLOPE + 1.0, direction.z * SLOPE);
    let a = (direction.x * direction.x + direction.y * direction.y) - growth * growth;
    let b = (p.x * direction.x + p.y * direction.y) - radius * growth;
    let c = (p.x * p.x + p.y * p.y) - radius * radius;
    let discriminant = b * b - a * c;
    let is_flat = a.simd_ge(zero);
    let is_met = discriminant.simd_gt(zero) | a.simd_lt(zero);
    let root = discriminant.simd_gt(zero).select(discriminant, zero).sqrt().copysign(b);
    let q = -(b + root);
    let is_zero = q.simd_eq(zero);
    let one_root = is_zero.select(zero, q / a);
    let other_root = is_zero.select(zero, c / q);
    let swapped = other_root.simd_lt(one_root);
    let first = swapped.select(other_root, one_root);
    let second = swapped.select(one_root, other_root);
    let shrinks = growth.simd_lt(zero);
    let enter = is_flat.select(middle + first, shrinks.select(-infinity, middle + second));
    let exit = is_flat.select(middle + second, shrinks.select(middle + first, infinity));
    let is_tangent = a.simd_eq(zero) & b.simd_eq(zero);
    let side = choose_line(simd, is_tangent, c.simd_lt(zero), keep(simd, is_met, [enter, exit]));
    clip(caps, side)
}

#[inline(always)]
fn hull<S: Simd>(simd: S, hull: &Hull, [origin, direction]: [Vec3x8<S>; 2]) -> Span<S> {
    let zero = f64x8::splat(simd, 0.0);
    let infinity = f64x8::splat(simd, f64::INFINITY);
    let mut span = [-infinity, infinity];
    for face in hull.faces() {
        let distance = f64x8::splat(simd, face.offset) - origin.dot_constant(face.normal);
        let approach = direction.dot_constant(face.normal);
        let t = distance / approach;
        let enters = approach.simd_lt(zero);
        let exits = approach.simd_gt(zero);
        let along = !(enters | exits) & !(approach.simd_eq(zero) & distance.simd_gt(zero));
        span[0] = (enters & t.simd_gt(span[0])).select(t, span[0]);
        span[1] = (exits & t.simd_lt(span[1])).select(t, span[1]);
        span[1] = along.select(-infinity, span[1]);
    }
    span
}

/// The part of the lines where `min` ≤ coordinate < `max`.
#[inline(always)]
fn slab<S: Simd>(simd: S, origin: f64x8<S>, direction: f64x8<S>, min: f64, max: f64) -> Span<S> {
    let (min, max) = (f64x8::splat(simd, min), f64x8::splat(simd, max));
    let zero = f64x8::splat(simd, 0.0);
    let low = (min - origin) / direction;
    let high = (max - origin) / direction;
    let forward = direction.simd_gt(zero);
    let span = [forward.select(low, high), forward.select(high, low)];
    let is_within = min.simd_le(origin) & origin.simd_lt(max);
    choose_line(simd, direction.simd_eq(zero), is_within, span)
}

/// Where `across`, the whole line or nothing; elsewhere the span.
#[inline(always)]
fn choose_line<S: Simd>(simd: S, across: mask64x8<S>, is_within: mask64x8<S>, span: Span<S>) -> Span<S> {
    let infinity = f64x8::splat(simd, f64::INFINITY);
    let exit = is_within.select(infinity, -infinity);
    [across.select(-infinity, span[0]), across.select(exit, span[1])]
}

/// The span where the condition holds, and nothing elsewhere.
#[inline(always)]
fn keep<S: Simd>(simd: S, condition: mask64x8<S>, [enter, exit]: Span<S>) -> Span<S> {
    [enter, condition.select(exit, f64x8::splat(simd, f64::NEG_INFINITY))]
}

/// What is in both.
#[inline(always)]
fn clip<S: Simd>(a: Span<S>, b: Span<S>) -> Span<S> {
    [b[0].simd_gt(a[0]).select(b[0], a[0]), b[1].simd_lt(a[1]).select(b[1], a[1])]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use glam::DVec3;

    use super::*;
    use crate::Ray;
    use crate::fast::lanes::{HALF, Lanes, Rays, Vectors};
    use crate::shapes::{extents, normal_at};

    /// Corners, edges, apexes and lines along faces among them.
    fn rays() -> impl Iterator<Item = Ray> {
        let coordinates = [-2.0, -1.0, 0.0, 0.5, 1.0, 0.3];
        let steps = [-1.0, 0.0, 0.5, 1.0, 0.7];
        let triples = |of: &[f64]| {
            let pairs = of.iter().flat_map(|x| of.iter().map(move |y| [*x, *y]));
            pairs.flat_map(|[x, y]| of.iter().map(move |z| DVec3::new(x, y, *z))).collect::<Vec<_>>()
        };
        let directions: Vec<_> = triples(&steps).into_iter().filter(|step| *step != DVec3::ZERO).collect();
        triples(&coordinates).into_iter().flat_map(move |origin| {
            directions.clone().into_iter().map(move |direction| Ray { origin, direction })
        })
    }

    #[test]
    fn normals_of_eight_are_those_of_one() {
        let frustums = [0.0, 0.25, 3.0].map(|top| Primitive::Frustum { top });
        let others = [Primitive::Sphere, Primitive::Cylinder, Primitive::Cone, Primitive::Cube];
        for primitive in frustums.into_iter().chain(others) {
            let met = rays().flat_map(|ray| {
                let ends = extents(&primitive, &ray).into_iter().filter(|[enter, exit]| enter < exit);
                ends.flatten().map(move |t| (ray, t))
            });
            let met: Vec<(Ray, f64)> = met.filter(|(_, t)| t.is_finite()).collect();
            assert!(met.len() > 5000, "{primitive:?} is met {} times", met.len());
            for eight in met.chunks_exact(HALF) {
                let (mut rays, mut normals, mut t) = (Rays::ZERO, Vectors::ZERO, Lanes::ZERO);
                for (lane, (ray, at)) in eight.iter().enumerate() {
                    t.0[lane] = *at;
                    rays.set(lane, ray);
                }
                dispatch!(Level::new(), simd => {
                    let found = normals_at(simd, &primitive, rays.half(simd, 0), t.half(simd, 0));
                    normals.set_half(0, found.expect("the kind is one of them"));
                });
                for (lane, (ray, at)) in eight.iter().enumerate() {
                    let alone = normal_at(&primitive, ray, *at).expect("it is a boundary");
                    assert_eq!(normals.get(lane), alone, "{primitive:?} {ray:?} at {at}");
                }
            }
        }
    }
}
