//! Spheres, slabs and oriented boxes: what they enclose, how tight they are, and what they make of nothing and all.

#![expect(clippy::float_cmp, reason = "what is exact is compared exactly")]

use std::f64::consts::PI;

use csg_graph_bounds::{Aabb, CertifiedSphere, Obb, PointSet, Slabs, Sphere, Volume};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use proptest::prelude::*;

/// A convex body with its support and points of its surface, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Ball,
    Cylinder,
    Cone,
    Cube,
    Tetrahedron,
    TorusHull,
}

const BODIES: [Body; 6] =
    [Body::Ball, Body::Cylinder, Body::Cone, Body::Cube, Body::Tetrahedron, Body::TorusHull];

const TETRAHEDRON: [DVec3; 4] = [
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
    DVec3::new(-1.0, -1.0, 1.0),
];

impl Body {
    fn support(self, d: DVec3) -> f64 {
        let across = d.truncate().length();
        match self {
            Self::Ball => d.length(),
            Self::Cylinder => across + d.z.max(0.0),
            Self::Cone => across.max(d.z),
            Self::Cube => d.abs().element_sum(),
            Self::Tetrahedron => TETRAHEDRON.map(|p| p.dot(d)).into_iter().fold(f64::NEG_INFINITY, f64::max),
            Self::TorusHull => across + 0.5 * d.length(),
        }
    }

    fn points(self) -> PointSet<'static> {
        match self {
            Self::Ball => PointSet::sphere(),
            Self::Cylinder => PointSet::cylinder(),
            Self::Cone => PointSet::cone(),
            Self::Cube => PointSet::cube(),
            Self::Tetrahedron => PointSet::from(TETRAHEDRON.to_vec()),
            Self::TorusHull => PointSet::torus(0.5),
        }
    }

    /// Points within 10⁻¹¹ of the surface, inside, so that rounding puts none of them outside.
    fn sample(self) -> Vec<DVec3> {
        let steps =
            (0..24_u32).flat_map(|i| (0..13_u32).map(move |j| (f64::from(i) / 24.0, f64::from(j) / 12.0)));
        let inside =
            DVec3::new(0.0, 0.0, if matches!(self, Self::Cylinder | Self::Cone) { 0.3 } else { 0.0 });
        let surface = steps.map(|(u, v)| {
            let (sin, cos) = libm::sincos(2.0 * PI * u);
            let (profile_sin, profile_cos) = libm::sincos(PI * v);
            let turned = |rho: f64, z: f64| DVec3::new(rho * cos, rho * sin, z);
            match self {
                Self::Ball => turned(profile_sin, profile_cos),
                Self::Cylinder if v < 0.25 => turned(4.0 * v, 0.0),
                Self::Cylinder => turned(1.0, (v - 0.25) / 0.75),
                Self::Cone => turned(1.0 - v, v),
                Self::Cube => {
                    let toward = turned(profile_sin, profile_cos);
                    toward / toward.abs().max_element()
                }
                Self::Tetrahedron => {
                    let [a, b, c, d] = TETRAHEDRON;
                    a.lerp(b, u).lerp(c.lerp(d, u), v)
                }
                Self::TorusHull => turned(1.0 + 0.5 * profile_sin, 0.5 * profile_cos),
            }
        });
        surface.map(|point| point.lerp(inside, 1e-11)).collect()
    }
}

/// The support of a transformed solid, raised by more than these lines round.
fn moved(support: impl Fn(DVec3) -> f64, world_from_body: DAffine3) -> impl Fn(DVec3) -> f64 {
    move |d| {
        let offset = d.dot(world_from_body.translation);
        let body = support(world_from_body.matrix3.transpose() * d);
        offset + body + 1e-13 * (offset.abs() + body.abs())
    }
}

fn moved_points(points: &PointSet<'_>, world_from_body: DAffine3) -> PointSet<'static> {
    let PointSet::Points(points) = points else { panic!("bounded") };
    PointSet::from(points.iter().map(|p| world_from_body.transform_point3(*p)).collect::<Vec<_>>())
}

fn ball(d: DVec3) -> f64 {
    Body::Ball.support(d)
}

/// Turns, mirrors, shears and scales by up to 1:100, then moves.
fn affine_maps() -> impl Strategy<Value = DAffine3> {
    let factor = || prop_oneof![0.1..10.0, -10.0..-0.1];
    let turn = || {
        ([-1.0..1.0, -1.0..1.0, -1.0..1.0], 0.0..6.3)
            .prop_filter("an axis", |(axis, _)| DVec3::from_array(*axis).length() > 0.1)
            .prop_map(|(axis, angle)| {
                DMat3::from_quat(DQuat::from_axis_angle(DVec3::from_array(axis).normalize(), angle))
            })
    };
    (turn(), [factor(), factor(), factor()], turn(), [-20.0..20.0, -20.0..20.0, -20.0..20.0]).prop_map(
        |(first, factors, second, offset)| DAffine3 {
            matrix3: second * DMat3::from_diagonal(DVec3::from_array(factors)) * first,
            translation: DVec3::from_array(offset),
        },
    )
}

fn bodies() -> impl Strategy<Value = Body> {
    prop::sample::select(BODIES.to_vec())
}

/// The volume, after it was seen to contain the points, to keep to its box, and to have sound measures.
fn checked<V: Volume + std::fmt::Debug>(volume: V, points: &[DVec3]) -> Result<V, TestCaseError> {
    let bounds = volume.aabb();
    for point in points {
        prop_assert!(volume.contains(*point), "{point} is not in {volume:?}");
        prop_assert!(bounds.contains(*point), "{point} is not in {bounds:?}");
    }
    let size = bounds.size();
    if size.min_element() > 0.0 {
        for axis in DVec3::AXES {
            let beyond = bounds.center() + axis * (0.5 * size.dot(axis) * (1.0 + 1e-9));
            prop_assert!(!volume.contains(beyond), "{beyond} is in {volume:?}");
        }
        prop_assert!(!volume.contains(bounds.max + 1e-9 * size), "{volume:?}");
    }
    prop_assert!(volume.volume() > 0.0 && volume.volume() <= bounds.volume() * (1.0 + 1e-12));
    // What is convex and within a box has no more surface.
    prop_assert!(
        volume.surface_area() > 0.0 && volume.surface_area() <= bounds.surface_area() * (1.0 + 1e-12)
    );
    Ok(volume)
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b} to {tolerance}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_comes_from_supports_encloses(body in bodies(), world_from_body in affine_maps()) {
        let support = moved(|d| body.support(d), world_from_body);
        let points: Vec<DVec3> =
            body.sample().into_iter().map(|p| world_from_body.transform_point3(p)).collect();
        let aligned = checked(Aabb::from_support(&support), &points)?;
        let [six, fourteen, eighteen, twenty_six] = [
            checked(Slabs::<3>::from_support(&support), &points)?.volume(),
            checked(Slabs::<7>::from_support(&support), &points)?.volume(),
            checked(Slabs::<9>::from_support(&support), &points)?.volume(),
            checked(Slabs::<13>::from_support(&support), &points)?.volume(),
        ];
        let more = 1.0 + 1e-12;
        prop_assert!((six / aligned.volume() - 1.0).abs() < 1e-12);
        prop_assert!(twenty_six <= fourteen * more && fourteen <= six * more);
        prop_assert!(twenty_six <= eighteen * more && eighteen <= six * more);
        let oriented = checked(Obb::from_support(&support), &points)?;
        prop_assert!(oriented.surface_area() <= aligned.surface_area());
        let certified = CertifiedSphere::from_support(&support, 0.02);
        let sphere = checked(certified.sphere, &points)?;
        prop_assert!(certified.at_least <= sphere.radius);
        prop_assert!(sphere.radius <= 1.02 * certified.at_least * more);
        prop_assert!(sphere.radius <= 0.5 * aligned.size().length() * more);
        // The corners of no body here stand out from its smallest sphere.
        prop_assert!(points.iter().all(|p| p.distance(sphere.center) <= sphere.radius));
    }

    #[test]
    fn what_comes_from_points_encloses(body in bodies(), world_from_body in affine_maps()) {
        let set = moved_points(&body.points(), world_from_body);
        let points: Vec<DVec3> =
            body.sample().into_iter().map(|p| world_from_body.transform_point3(p)).collect();
        let aligned = checked(Aabb::from_point_set(&set), &points)?;
        checked(Slabs::<3>::from_point_set(&set), &points)?;
        checked(Slabs::<7>::from_point_set(&set), &points)?;
        checked(Slabs::<9>::from_point_set(&set), &points)?;
        checked(Slabs::<13>::from_point_set(&set), &points)?;
        let oriented = checked(Obb::from_point_set(&set), &points)?;
        prop_assert!(oriented.surface_area() <= aligned.surface_area());
        let certified = CertifiedSphere::from_point_set(&set);
        let sphere = checked(certified.sphere, &points)?;
        prop_assert!(sphere.radius <= certified.at_least * (1.0 + 1e-11));
        // The same from the supports of the points, as near as they get.
        let approached = CertifiedSphere::from_support(|d| set.support(d), 0.02);
        prop_assert!(approached.sphere.radius >= certified.at_least * (1.0 - 1e-11));
        prop_assert!(approached.at_least <= sphere.radius * (1.0 + 1e-11));
        prop_assert!(approached.sphere.radius <= approached.at_least * 1.02);
    }

    #[test]
    fn the_oriented_box_of_a_box_is_that_box(world_from_cube in affine_maps(), sizes in [0.001..5.0, 0.1..5.0, 0.1..5.0]) {
        let sizes = DVec3::from_array(sizes);
        let turned = DMat3::from_quat(DQuat::from_mat3(&orthonormal(world_from_cube.matrix3)));
        let world_from_cube = DAffine3 { matrix3: turned * DMat3::from_diagonal(sizes), ..world_from_cube };
        let set = moved_points(&PointSet::cube(), world_from_cube);
        let area = 8.0 * (sizes.x * sizes.y + sizes.y * sizes.z + sizes.z * sizes.x);
        let found = Obb::from_point_set(&set);
        prop_assert!((found.surface_area() / area - 1.0).abs() < 1e-9, "{found:?}");
        prop_assert!((found.volume() / (8.0 * sizes.element_product()) - 1.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn what_is_seen_of_slabs_is_what_lines_meet(
        body in bodies(),
        world_from_body in affine_maps(),
        along in [-1.0..1.0, -1.0..1.0, 0.1..1.0],
    ) {
        const SIDE: i32 = 100;
        let slabs = Slabs::<13>::from_support(moved(|d| body.support(d), world_from_body));
        let areas = slabs.face_areas();
        prop_assert!((areas.iter().sum::<f64>() / slabs.surface_area() - 1.0).abs() < 1e-12);
        let along = DVec3::from_array(along).normalize();
        let faces = areas.iter().zip(Slabs::<13>::DIRECTIONS);
        let seen: f64 =
            faces.map(|(area, direction)| 0.5 * area * direction.normalize().dot(along).abs()).sum();
        let (u, v) = along.any_orthonormal_pair();
        let (center, reach) = (slabs.aabb().center(), 0.5 * slabs.aabb().size().length());
        let place = |at: i32| (f64::from(at) + 0.5) / f64::from(SIDE);
        let places = (-SIDE..SIDE).flat_map(|i| (-SIDE..SIDE).map(move |j| [place(i), place(j)]));
        let is_met = |[i, j]: &[f64; 2]| {
            let origin = center + reach * (*i * u + *j * v);
            let mut inside = [f64::NEG_INFINITY, f64::INFINITY];
            for (at, direction) in Slabs::<13>::DIRECTIONS.into_iter().enumerate() {
                let (from, rate) = (direction.dot(origin), direction.dot(along));
                let [one, other] = [slabs.min[at], slabs.max[at]].map(|plane| (plane - from) / rate);
                inside = [inside[0].max(one.min(other)), inside[1].min(one.max(other))];
            }
            inside[0] < inside[1]
        };
        let cell = reach / f64::from(SIDE);
        let met = places.filter(is_met).count() as f64 * cell * cell;
        // As far as cells at the silhouette tell, of which there are no more than around the square.
        prop_assert!((met - seen).abs() < 8.0 * reach * cell, "{met} for {seen}");
    }

    #[test]
    fn slabs_are_a_lattice(a in affine_maps(), b in affine_maps()) {
        let [a, b] = [a, b].map(|map| Slabs::<13>::from_support(moved(|d| Body::Ball.support(d), map)));
        let nothing = Slabs::<13>::EMPTY;
        prop_assert_eq!(a.join(b), b.join(a));
        prop_assert_eq!(a.intersect(b), b.intersect(a));
        prop_assert_eq!(a.join(a.intersect(b)), a);
        prop_assert_eq!(a.intersect(a.join(b)), a);
        prop_assert_eq!((a.join(nothing), a.intersect(nothing)), (a, nothing));
        prop_assert_eq!((a.join(Slabs::ALL), a.intersect(Slabs::ALL)), (Slabs::ALL, a));
        let both = a.intersect(b);
        prop_assert_eq!(both.is_empty(), both == nothing);
        prop_assert!(both.volume() <= a.volume() * (1.0 + 1e-12));
    }
}

/// The turn that comes nearest to a matrix along its columns.
fn orthonormal(matrix: DMat3) -> DMat3 {
    let x = matrix.x_axis.normalize();
    let y = matrix.y_axis.reject_from_normalized(x).normalize();
    DMat3::from_cols(x, y, x.cross(y))
}

#[test]
fn slabs_of_a_cube_are_the_cube() {
    let cube = Slabs::<13>::from_point_set(&PointSet::cube());
    assert_eq!(cube.aabb(), Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
    assert_eq!(cube, Slabs::from_support(|d| Body::Cube.support(d)));
    assert_eq!(cube.max, [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0]);
    assert_eq!(cube.min, cube.max.map(|m: f64| -m));
    close(cube.volume(), 8.0, 1e-13);
    close(cube.surface_area(), 24.0, 1e-13);
    let far = DAffine3::from_translation(DVec3::splat(1e6));
    let far = Slabs::<13>::from_point_set(&moved_points(&PointSet::cube(), far));
    assert!((far.volume() / 8.0 - 1.0).abs() < 1e-14 && far.contains(DVec3::splat(1e6 + 1.0)));
    assert!(!far.contains(DVec3::splat((1e6_f64 + 1.0).next_up())));
}

#[test]
fn slabs_of_known_measures() {
    // An octahedron whose corners are cut off by the axes.
    let root = 3_f64.sqrt();
    let fourteen = Slabs::<7>::from_support(ball);
    close(fourteen.volume(), 4.0 * root - 4.0 * (root - 1.0) * (root - 1.0) * (root - 1.0), 1e-13);
    let cut = (root - 1.0) * (root - 1.0);
    close(fourteen.surface_area(), 4.0 * root * 3.0 + 6.0 * (2.0 - 2.0 * root) * cut, 1e-13);
    // Kay and Kajiya's seven directions hold the faces of a regular tetrahedron.
    let tetrahedron = Slabs::<7>::from_point_set(&Body::Tetrahedron.points());
    close(tetrahedron.volume(), 8.0 / 3.0, 1e-13);
    close(tetrahedron.surface_area(), 8.0 * root, 1e-13);
    // The rhombic dodecahedron has the directions of the edges: here it is cut by the axes in its corners.
    let dodecahedron = Slabs::<9>::from_support(|d| {
        DVec3::AXES.map(|a| 2.0 * d.dot(a).abs()).into_iter().fold(d.abs().element_sum(), f64::max)
    });
    close(dodecahedron.volume(), 16.0, 1e-13);
    close(dodecahedron.surface_area(), 24.0 * 2_f64.sqrt(), 1e-13);
    let ball_volume = 4.0 / 3.0 * PI;
    close(Slabs::<13>::from_support(ball).volume() / ball_volume, 1.14, 0.005);
}

#[test]
fn spheres_of_known_radius() {
    let known = [
        (Body::Ball, DVec3::ZERO, 1.0),
        (Body::Cylinder, DVec3::new(0.0, 0.0, 0.5), 1.25_f64.sqrt()),
        (Body::Cone, DVec3::ZERO, 1.0),
        (Body::Cube, DVec3::ZERO, 3_f64.sqrt()),
        (Body::Tetrahedron, DVec3::ZERO, 3_f64.sqrt()),
        (Body::TorusHull, DVec3::ZERO, 1.5),
    ];
    for (body, center, radius) in known {
        for tolerance in [0.1, 0.01, 0.001] {
            let found = CertifiedSphere::from_support(|d| body.support(d), tolerance);
            let Sphere { center: found_center, radius: found_radius } = found.sphere;
            assert!(found_radius >= radius, "{body:?} {found:?}");
            assert!(found_radius <= radius * (1.0 + tolerance), "{body:?} {found:?}");
            assert!(found.at_least <= radius * (1.0 + 1e-12), "{body:?} {found:?}");
            // A centre that is off by δ costs at least about δ²/2.
            assert!(found_center.distance(center) <= radius * (2.0 * tolerance).sqrt(), "{body:?} {found:?}");
        }
    }
    for body in [Body::Cube, Body::Tetrahedron] {
        let from_points = CertifiedSphere::from_point_set(&body.points());
        let from_support = CertifiedSphere::from_support(|d| body.support(d), 0.0);
        for found in [from_points, from_support] {
            close(found.sphere.radius, 3_f64.sqrt(), 1e-12);
            close(found.at_least, 3_f64.sqrt(), 1e-12);
        }
    }
    // The longest side of an obtuse triangle is a diameter.
    let triangle = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(1.0, 0.5, 0.0)];
    let found = Sphere::from_point_set(&PointSet::from(triangle.as_slice()));
    assert_eq!(found.center, DVec3::new(2.0, 0.0, 0.0));
    close(found.radius, 2.0, 1e-14);
}

#[test]
fn queries_are_as_few_as_documented() {
    let mut queries = [0; 4];
    let mut spheres = queries.iter_mut();
    for (body, tolerance) in [(Body::Ball, 0.01), (Body::Ball, 0.001), (Body::Cube, 0.001)] {
        let count = spheres.next().expect("four");
        CertifiedSphere::from_support(|d| (*count += 1, body.support(d)).1, tolerance);
    }
    Obb::from_support(|d| (queries[3] += 1, Body::Ball.support(d)).1);
    let [coarse, fine, cube, oriented] = queries;
    assert!(coarse <= 700, "{coarse}");
    assert!(fine <= 6_000, "{fine}");
    assert!(cube <= 20, "{cube}");
    assert_eq!(oriented, 116);
}

#[test]
fn oriented_boxes_of_boxes_from_their_supports() {
    // Also turned by the angles that modellers use.
    let angles =
        (0..24_u32).map(|k| 15.0 * f64::from(k)).chain((0..40_u32).map(|k| 1.3 + 7.7 * f64::from(k)));
    for angle in angles.map(f64::to_radians) {
        for axis in [DVec3::X, DVec3::Z, DVec3::ONE.normalize(), DVec3::new(0.36, 0.48, 0.8)] {
            let world_from_cube = DAffine3::from_translation(DVec3::new(3.0, -1.0, 2.0))
                * DAffine3::from_quat(DQuat::from_axis_angle(axis, angle))
                * DAffine3::from_scale(DVec3::new(1.0, 0.7, 0.4));
            let found = Obb::from_support(moved(|d| Body::Cube.support(d), world_from_cube));
            close(found.surface_area() / (8.0 * (0.7 + 0.28 + 0.4)), 1.0, 1e-9);
            close(found.volume() / (8.0 * 0.28), 1.0, 1e-9);
        }
    }
}

#[test]
fn oriented_boxes_of_round_bodies() {
    let turn = DAffine3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7));
    // A rod about its own z axis.
    let rod = turn * DAffine3::from_scale(DVec3::new(0.1, 0.1, 5.0));
    let set = moved_points(&PointSet::cylinder(), rod);
    let area = 2.0 * (0.2 * 0.2 + 2.0 * 0.2 * 5.0);
    let from_support = Obb::from_support(moved(|d| Body::Cylinder.support(d), rod)).surface_area();
    let from_points = Obb::from_point_set(&set).surface_area();
    assert!(from_support >= area && from_support < 1.03 * area, "{from_support} {area}");
    assert!(from_points >= area && from_points < 1.03 * area, "{from_points} {area}");
    // Nothing is better than the axes for what has no others.
    assert_eq!(Obb::from_support(ball).world_from_box(), DMat3::IDENTITY);
    assert_eq!(Obb::from_point_set(&PointSet::cube()), Obb::from(Aabb::new(DVec3::NEG_ONE, DVec3::ONE)));
}

#[test]
fn oriented_boxes_whose_squares_are_no_numbers() {
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7);
    for size in [1e-160, 1e160] {
        let corner = |x, y, z| turn * DVec3::new(x, 2.0 * y, 3.0 * z) * size;
        let signs = [-1.0, 1.0];
        let points: Vec<DVec3> = signs
            .into_iter()
            .flat_map(|x| signs.into_iter().flat_map(move |y| signs.map(|z| corner(x, y, z))))
            .collect();
        let found = Obb::from_point_set(&PointSet::from(points.as_slice()));
        let frame = found.world_from_box();
        let off = (frame.transpose() * frame - DMat3::IDENTITY).to_cols_array();
        assert!(off.iter().all(|entry| entry.abs() < 1e-15), "{off:?}");
        assert!(
            points.iter().all(|point| found.contains(*point) && found.aabb().contains(*point)),
            "{found:?}"
        );
    }
}

/// A point, a segment and a triangle: what is left has no volume, but is there.
#[test]
fn flat_solids() {
    let [a, b, c] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.0, 4.0, 4.0), DVec3::new(0.3, 2.0, 3.1)];
    fn measured<V: Volume>(points: &[DVec3], within: f64) -> [f64; 2] {
        let set = PointSet::from(points);
        let found = [V::from_point_set(&set), V::from_support(|d| set.support(d))];
        for volume in &found {
            assert!(!volume.is_empty() && points.iter().all(|p| volume.contains(*p)));
            assert!(!volume.contains(points[0] + within));
        }
        found.map(|volume| volume.surface_area())
    }
    let zero = |areas: [f64; 2]| areas.iter().for_each(|area| close(*area, 0.0, 1e-14));
    zero(measured::<Sphere>(&[a], 1e-12));
    zero(measured::<Slabs<13>>(&[a], 1e-12));
    zero(measured::<Obb>(&[a, a], 1e-12));
    zero(measured::<Obb>(&[a, b], 1e-12));
    zero(measured::<Obb>(&[a, b, a.lerp(b, 0.3)], 1e-12));
    for area in measured::<Sphere>(&[a, b], 3.0) {
        close(area, PI * a.distance_squared(b), 0.02 * PI * 9.0);
    }
    let flat = Obb::from_point_set(&PointSet::from([a, b, c].as_slice()));
    close(flat.volume(), 0.0, 1e-14);
    // A triangle in a plane of the slabs keeps its two sides.
    let triangle = [DVec3::X, DVec3::Y, DVec3::Z];
    let slabs = Slabs::<13>::from_point_set(&PointSet::from(triangle.as_slice()));
    close(slabs.surface_area(), 3_f64.sqrt(), 1e-14);
    close(slabs.volume(), 0.0, 1e-14);
    let disc = CertifiedSphere::from_support(|d| DVec2::new(d.x, d.y).length(), 0.001);
    assert!(disc.sphere.radius >= 1.0 && disc.sphere.radius <= 1.001);
}

fn nothing_and_all<V: Volume + PartialEq + std::fmt::Debug>() {
    assert!(V::EMPTY.is_empty() && !V::ALL.is_empty());
    assert!(!V::EMPTY.contains(DVec3::ZERO) && V::ALL.contains(DVec3::splat(1e300)));
    assert!(!V::ALL.contains(DVec3::NAN));
    assert_eq!([V::EMPTY.volume(), V::EMPTY.surface_area()], [0.0; 2]);
    assert_eq!([V::ALL.volume(), V::ALL.surface_area()], [f64::INFINITY; 2]);
    assert_eq!((V::EMPTY.aabb(), V::ALL.aabb()), (Aabb::EMPTY, Aabb::ALL));
    assert_eq!(V::from_support(|_| f64::NEG_INFINITY), V::EMPTY);
    assert_eq!(V::from_support(|d| if d.x < 0.0 { f64::NEG_INFINITY } else { 1.0 }), V::EMPTY);
    assert_eq!(V::from_support(|_| f64::INFINITY), V::ALL);
    assert_eq!(V::from_support(|_| f64::NAN), V::ALL);
    // No point is both below −1 and above 1.
    assert_eq!(V::from_support(|_| -1.0), V::EMPTY);
    assert_eq!(V::from_point_set(&PointSet::EMPTY), V::EMPTY);
    assert_eq!(V::from_point_set(&PointSet::Unbounded), V::ALL);
    assert_eq!(V::from_point_set(&PointSet::from(vec![DVec3::ONE, DVec3::NAN])), V::ALL);
    // What has no end below: nothing above is let in that need not be.
    let column = |d: DVec3| if d.z < 0.0 { f64::INFINITY } else { ball(d) };
    let volume = V::from_support(column);
    assert!(volume.contains(DVec3::new(0.0, 0.0, -1e9)) && !volume.volume().is_nan());
    // Answers that are broken now and then make a volume larger, and never smaller.
    let mut asked = 0;
    let patchy = V::from_support(|d| {
        asked += 1;
        if asked > 6 && asked % 3 == 0 { f64::NAN } else { ball(d) }
    });
    assert!(patchy.contains(DVec3::new(0.6, 0.64, 0.48)) && patchy.contains(DVec3::NEG_Y));
    // Sizes near the ends of the range.
    for size in [1e-300, 1e-160, 1e-20, 1e20, 1e140, 1e160, 1e300] {
        let set = moved_points(&PointSet::cube(), DAffine3::from_scale(DVec3::splat(size)));
        for volume in [V::from_point_set(&set), V::from_support(|d| set.support(d))] {
            assert!(volume.contains(DVec3::splat(size)) && volume.contains(DVec3::new(size, -size, size)));
            assert!(!volume.volume().is_nan() && !volume.surface_area().is_nan());
        }
    }
}

#[test]
fn nothing_all_and_what_is_no_number() {
    nothing_and_all::<Aabb>();
    nothing_and_all::<Sphere>();
    nothing_and_all::<Slabs<3>>();
    nothing_and_all::<Slabs<7>>();
    nothing_and_all::<Slabs<9>>();
    nothing_and_all::<Slabs<13>>();
    nothing_and_all::<Obb>();
}
