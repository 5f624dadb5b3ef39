//! Every shape against its own definition: ends on the surface, inside between them, outside elsewhere.

use csg_graph::{Primitive, PrimitiveKind};
use csg_graph_trace::{Ray, brute::primitive_contains, shapes::spans};
use glam::{DVec3, Vec3Swizzles};
use proptest::prelude::*;

fn primitive() -> impl Strategy<Value = Primitive> {
    let plain = prop::sample::select(vec![
        PrimitiveKind::Sphere,
        PrimitiveKind::Cylinder,
        PrimitiveKind::Cone,
        PrimitiveKind::Cube,
        PrimitiveKind::Tetrahedron,
        PrimitiveKind::Octahedron,
        PrimitiveKind::Dodecahedron,
        PrimitiveKind::Icosahedron,
        PrimitiveKind::HalfSpace,
    ]);
    prop_oneof![
        9 => plain.prop_map(|kind| kind.evaluate(&[]).expect("a plain primitive")),
        2 => (0.01..3.0).prop_map(|top| Primitive::Frustum { top }),
        3 => prop_oneof![0.01..1.0, Just(1.0)].prop_map(|minor| Primitive::Torus { minor }),
        2 => prop::collection::vec(point(1.5), 5..12).prop_filter_map("flat", |points| {
            let args: Vec<f64> = points.iter().flat_map(|p| p.to_array()).collect();
            PrimitiveKind::Hull.evaluate(&args).ok()
        }),
    ]
}

fn point(size: f64) -> impl Strategy<Value = DVec3> {
    [-size..size, -size..size, -size..size].prop_map(DVec3::from_array)
}

/// Rays that pass near the origin, from far and near, with directions of all lengths, some along axes.
fn ray() -> impl Strategy<Value = Ray> {
    let direction = prop_oneof![
        4 => point(1.0),
        1 => prop::sample::select(vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z]),
        1 => (-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| DVec3::new(x, y, 0.0)),
    ];
    (point(1.6), direction, -5.0..5.0_f64, prop_oneof![Just(1.0), 1e-6..1e6]).prop_filter_map(
        "no direction",
        |(target, direction, back, length)| {
            let unit = direction.try_normalize()?;
            Some(Ray { origin: target - unit * back, direction: unit * length })
        },
    )
}

fn ends(primitive: &Primitive, ray: &Ray) -> Vec<(f64, DVec3)> {
    let found = spans(primitive, ray);
    found.iter().flat_map(|span| [span.enter, span.exit]).map(|end| (end.t, end.normal)).collect()
}

/// How far a step goes that leaves rounding behind.
const STEP: f64 = 1e-7;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn spans_are_what_the_definition_says(primitive in primitive(), ray in ray()) {
        let length = ray.direction.length();
        let ends = ends(&primitive, &ray);
        prop_assert!(ends.is_sorted_by(|a, b| a.0 < b.0), "{ends:?}");
        // Between, before and after the ends.
        let mut cuts: Vec<f64> = ends.iter().map(|(t, _)| *t).filter(|t| t.is_finite()).collect();
        let inside_first = ends.first().is_some_and(|(t, _)| t.is_infinite());
        cuts.insert(0, -20.0 / length);
        cuts.push(20.0 / length);
        for (index, pair) in cuts.windows(2).enumerate() {
            let expected = (index % 2 == 1) != inside_first;
            let margin = STEP / length;
            for part in 0..=8 {
                let t = pair[0] + (pair[1] - pair[0]) * f64::from(part) / 8.0;
                if t - pair[0] < margin || pair[1] - t < margin {
                    continue;
                }
                // Where the line runs closely along the surface, a point of it may be on either side by rounding.
                let point = ray.at(t);
                let clear = primitive_contains(&primitive, point * (1.0 - 1e-9))
                    == primitive_contains(&primitive, point * (1.0 + 1e-9));
                if clear {
                    prop_assert_eq!(primitive_contains(&primitive, point), expected, "t = {} of {:?}", t, cuts);
                }
            }
        }
    }

    #[test]
    fn ends_are_on_the_surface_and_normals_point_outward(primitive in primitive(), ray in ray()) {
        for (index, (t, normal)) in ends(&primitive, &ray).into_iter().enumerate() {
            if t.is_infinite() {
                continue;
            }
            let (point, normal) = (ray.at(t), normal.normalize());
            let outward = normal.dot(ray.direction.normalize()) * if index % 2 == 0 { -1.0 } else { 1.0 };
            prop_assert!(outward > -1e-6, "{normal} at end {index}");
            // A step along the normal leaves the solid, one against it goes in. Next to an edge the solid is thin.
            let step = STEP * 1e-2;
            prop_assert!(!primitive_contains(&primitive, point + normal * step), "{point} is too deep");
            let edge = (0..6).any(|side| {
                let aside = DVec3::AXES[side / 2] * if side % 2 == 0 { 1.0 } else { -1.0 } * step;
                !primitive_contains(&primitive, point - normal * (2.0 * step) + aside)
            });
            if !edge {
                prop_assert!(primitive_contains(&primitive, point - normal * step), "{point} is too high");
            }
        }
    }

    #[test]
    fn normals_are_the_gradients_of_smooth_shapes(minor in 0.05..1.0_f64, top in 0.05..3.0_f64, ray in ray()) {
        type Field = Box<dyn Fn(DVec3) -> f64>;
        let fields: [(Primitive, Field); 4] = [
            (Primitive::Sphere, Box::new(|p| p.length())),
            (Primitive::Cylinder, Box::new(|p| p.xy().length())),
            (Primitive::Frustum { top }, Box::new(move |p| p.xy().length() - (1.0 + (top - 1.0) * p.z))),
            (Primitive::Torus { minor }, Box::new(|p| libm::hypot(p.xy().length() - 1.0, p.z))),
        ];
        for (primitive, field) in &fields {
            for (t, normal) in ends(primitive, &ray) {
                let point = ray.at(t);
                let on_cap = !matches!(primitive, Primitive::Sphere | Primitive::Torus { .. })
                    && (point.z.abs() < 1e-9 || (point.z - 1.0).abs() < 1e-9);
                if on_cap {
                    continue;
                }
                let slope = |axis: DVec3| (field(point + axis * 1e-6) - field(point - axis * 1e-6)) / 2e-6;
                let gradient = DVec3::from(DVec3::AXES.map(slope)).normalize();
                prop_assert!(gradient.distance(normal.normalize()) < 1e-5, "{primitive:?}: {gradient} {normal}");
            }
        }
    }

    #[test]
    fn distance_costs_no_more_digits_than_the_origin_has(near in ray(), exponent in 0..10_i32) {
        let unit = near.direction.normalize();
        let distance = (0..exponent).fold(1.0, |distance, _| distance * 10.0);
        let far = Ray { origin: near.origin - unit * distance, direction: unit };
        let step = 2e-13 * (10.0 + distance);
        for primitive in [
            Primitive::Sphere,
            Primitive::Cylinder,
            Primitive::Frustum { top: 0.5 },
            Primitive::Cube,
            Primitive::Torus { minor: 0.25 },
        ] {
            for (t, _) in ends(&primitive, &far) {
                // Some point that close is inside and some is outside.
                let offsets = [-step, 0.0, step];
                let around: Vec<bool> = offsets
                    .into_iter()
                    .flat_map(|x| offsets.into_iter().flat_map(move |y| offsets.map(|z| DVec3::new(x, y, z))))
                    .map(|offset| primitive_contains(&primitive, far.at(t) + offset))
                    .collect();
                prop_assert!(around.contains(&false), "{primitive:?}: too deep from {distance}");
                prop_assert!(around.contains(&true), "{primitive:?}: too high from {distance}");
            }
        }
    }
}

fn ts(primitive: &Primitive, origin: [f64; 3], direction: [f64; 3]) -> Vec<f64> {
    let ray = Ray { origin: origin.into(), direction: direction.into() };
    ends(primitive, &ray).into_iter().map(|(t, _)| t).collect()
}

#[test]
fn rays_in_the_faces_of_a_cube() {
    let cube = Primitive::Cube;
    assert_eq!(ts(&cube, [-1.0, 0.0, -5.0], [0.0, 0.0, 1.0]), [4.0, 6.0], "a minimum is inside");
    assert_eq!(ts(&cube, [1.0, 0.0, -5.0], [0.0, 0.0, 1.0]), [], "a maximum is outside");
    assert_eq!(ts(&cube, [-1.0, 0.0, -5.0], [-0.0, -0.0, 1.0]), [4.0, 6.0], "signs of zeros do not matter");
    assert_eq!(ts(&cube, [-1.0, -1.0, 0.0], [0.0, 0.0, 2.0]), [-0.5, 0.5]);
    assert_eq!(ts(&cube, [-2.0, 0.0, 0.0], [1.0, 1.0, 0.0]), [], "touches an edge");
}

#[test]
fn rays_along_the_axis() {
    let cases: [(Primitive, &[f64]); 6] = [
        (Primitive::Sphere, &[4.0, 6.0]),
        (Primitive::Cylinder, &[5.0, 6.0]),
        (Primitive::Cone, &[5.0, 6.0]),
        (Primitive::Frustum { top: 1.0 }, &[5.0, 6.0]),
        (Primitive::Torus { minor: 0.25 }, &[]),
        (Primitive::HalfSpace, &[f64::NEG_INFINITY, 5.0]),
    ];
    for (primitive, expected) in cases {
        assert_eq!(ts(&primitive, [0.0, 0.0, -5.0], [0.0, 0.0, 1.0]), expected, "{primitive:?}");
    }
    assert_eq!(ts(&Primitive::Cylinder, [1.0, 0.0, -5.0], [0.0, 0.0, 1.0]), [], "in the mantle");
    assert_eq!(ts(&Primitive::HalfSpace, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [], "in the plane");
    assert_eq!(
        ts(&Primitive::HalfSpace, [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]),
        [f64::NEG_INFINITY, f64::INFINITY]
    );
}

#[test]
fn a_torus_is_met_twice() {
    let found = ts(&Primitive::Torus { minor: 0.25 }, [-5.0, 0.0, 0.0], [2.0, 0.0, 0.0]);
    let expected = [1.875, 2.125, 2.875, 3.125];
    assert!(found.iter().zip(expected).all(|(t, e)| (t - e).abs() < 1e-14), "{found:?}");
    assert_eq!(found.len(), 4);
    let grazing = ts(&Primitive::Torus { minor: 0.25 }, [-5.0, 0.0, 0.25], [1.0, 0.0, 0.0]);
    assert!(grazing.windows(2).all(|pair| pair[1] - pair[0] < 1.9), "touches at most: {grazing:?}");
    let inner = ts(&Primitive::Torus { minor: 0.25 }, [0.75, -5.0, 0.0], [0.0, 1.0, 0.0]);
    let [first, .., last] = inner[..] else { panic!("through the ring, past the hole: {inner:?}") };
    assert!((first - 4.0).abs() < 1e-7 && (last - 6.0).abs() < 1e-7, "{inner:?}");
}

#[test]
fn the_steep_the_parallel_and_the_flat_line_of_a_cone() {
    let close = |found: Vec<f64>, expected: &[f64]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        assert!(found.iter().zip(expected).all(|(t, e)| (t - e).abs() < 1e-12), "{found:?}");
    };
    let cone = Primitive::Cone;
    close(ts(&cone, [0.5, 0.0, -1.0], [0.0, 0.0, 1.0]), &[1.0, 1.5]);
    close(ts(&cone, [0.5, 0.0, 2.0], [0.0, 0.0, -1.0]), &[1.5, 2.0]);
    close(ts(&cone, [-2.0, 0.0, 0.5], [1.0, 0.0, 0.0]), &[1.5, 2.5]);
    // Parallel to the mantle's line from (1, 0, 0) to the apex.
    close(ts(&cone, [0.5, 0.0, 0.0], [-1.0, 0.0, 1.0]), &[0.0, 0.75]);
    // Through the apex.
    close(ts(&cone, [-0.5, 0.0, 2.0], [0.5, 0.0, -1.0]), &[1.0, 2.0]);
    close(ts(&cone, [-1.0, 0.0, 1.0], [1.0, 0.0, 0.0]), &[]);
    // The nappe beyond the apex is no part of it.
    close(ts(&cone, [-5.0, 0.0, 1.5], [1.0, 0.0, 0.0]), &[]);
}

#[test]
fn what_leaves_the_range_of_numbers_is_met_at_numbers() {
    let primitives = [
        Primitive::Sphere,
        Primitive::Cylinder,
        Primitive::Cone,
        Primitive::Cube,
        Primitive::Torus { minor: 0.5 },
        Primitive::HalfSpace,
        PrimitiveKind::Tetrahedron.evaluate(&[]).unwrap(),
    ];
    for primitive in primitives {
        for wild in [f64::NAN, f64::INFINITY, 1e200] {
            let ray = Ray { origin: DVec3::splat(wild), direction: DVec3::new(wild, -wild, wild) };
            for (t, _) in ends(&primitive, &ray) {
                assert!(!t.is_nan(), "{primitive:?} {wild}");
            }
        }
    }
}

#[test]
fn a_frustum_flat_as_a_sheet_has_no_holes() {
    for top in [1e3, 1e6, 1e9, 1e12] {
        for (x, y) in (-9..=9).flat_map(|x| (-9..=9).map(move |y| (f64::from(x), f64::from(y)))) {
            // Within the disc at z = 1, seen from outside of its rim and above.
            let target = DVec3::new(0.07 * top * x, 0.07 * top * y, 1.0);
            let origin = DVec3::new(3.0, 1.0, 2.0) * top;
            let ray = Ray { origin, direction: target - origin };
            let found = ends(&Primitive::Frustum { top }, &ray);
            assert!(found.first().is_some_and(|(t, _)| (t - 1.0).abs() < 1e-9), "{top} {x} {y}: {found:?}");
        }
    }
}
