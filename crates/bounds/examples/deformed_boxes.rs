//! Boxes of what taper, twist and bend [BARR84] make of a column: the measurements of docs/nonlinear.md about bounds.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example deformed_boxes
//! ```
//!
//! The column reaches 1/4 from the z axis, and from 0 to 1 along it. It is cut into slices, whose images are bounded by
//! interval arithmetic [MOOR66], by the mean-value form, or by the points at their ends. The maps are linear in x and y for each
//! z; where they are linear in z, too, a slice is mapped into the hull of those points, and where not, the second derivative
//! says how far beyond.

#![expect(clippy::print_stdout, reason = "tables")]

use std::f64::consts::{FRAC_PI_2, TAU};

use csg_graph::{Env, Expr, Function, GraphBuilder, Interval, ParamId};
use csg_graph_bounds::Aabb;
use glam::{DMat3, DVec3};

const WIDTH: f64 = 0.25;

/// A map of (x, y, z) with its derivatives, as expressions of the language: their ranges are its interval arithmetic.
struct Map {
    params: [ParamId; 3],
    env: Env,
    image: [Expr; 3],
    /// By rows.
    jacobian: [[Expr; 3]; 3],
    /// At least the length of its second derivative by z, in the column.
    second: f64,
}

/// A solid in the column by the points of its surface, for two numbers from 0 to 1.
type Surface = fn(f64, f64) -> DVec3;

fn main() {
    let maps = [
        ("taper to 1/2", taper(-0.5)),
        ("twist by 90°", twist(FRAC_PI_2)),
        ("twist by 360°", twist(4.0 * FRAC_PI_2)),
        ("bend by 90°", bend(FRAC_PI_2)),
    ];
    let column = Aabb::new(DVec3::new(-WIDTH, -WIDTH, 0.0), DVec3::new(WIDTH, WIDTH, 1.0));
    println!("| image of the column | slices | intervals | mean value | points |\n|---|---:|---:|---:|---:|");
    for (name, map) in &maps {
        let exact = map.sampled(|side, z| {
            let corner = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]][quarter(side)];
            DVec3::new(corner[0] * WIDTH, corner[1] * WIDTH, z)
        });
        for slices in [1, 4, 16, 64] {
            let ways: [fn(&Map, &Aabb) -> Aabb; 3] = [Map::by_intervals, Map::by_mean_value, Map::by_points];
            let [intervals, mean_value, points] =
                ways.map(|way| map.in_slices(&column, slices, way).surface_area() / exact.surface_area());
            println!("| {name} | {slices} | {intervals:.3} | {mean_value:.3} | {points:.3} |");
        }
    }

    let ball: Surface = |a, b| {
        let (sin, cos) = libm::sincos(a * TAU);
        let out = (4.0 * b * (1.0 - b)).sqrt();
        DVec3::new(out * cos, out * sin, 2.0 * b - 1.0) * WIDTH + DVec3::Z / 2.0
    };
    let cone: Surface = |a, z| {
        let (sin, cos) = libm::sincos(a * TAU);
        (DVec3::new(cos, sin, 0.0) * WIDTH * (1.0 - z)).with_z(z)
    };
    let rod: Surface = |_, z| DVec3::new(2.0 * z - 1.0, 1.0 - 2.0 * z, 0.0).with_z(z / WIDTH) * WIDTH;
    println!("\n| images of boxes | ball | cone | rod | rod, 4 parts | 16 |\n|---|---:|---:|---:|---:|---:|");
    for (name, map) in &maps {
        let ratios = [(ball, 1), (cone, 1), (rod, 1), (rod, 4), (rod, 16)].map(|(surface, parts)| {
            let of_boxes = (0..parts).map(|part| {
                let points = grid().map(|(a, b)| surface(a, (f64::from(part) + b) / f64::from(parts)));
                map.in_slices(&Aabb::from_points(points), 64, Map::by_points)
            });
            let area = of_boxes.fold(Aabb::EMPTY, Aabb::join).surface_area();
            format!("{:.2}", area / map.sampled(surface).surface_area())
        });
        println!("| {name} | {} |", ratios.join(" | "));
    }

    println!("\n| affine frames along the axis | 10 | 100 | 1,000 | 10,000 |\n|---|---:|---:|---:|---:|");
    for (name, map) in &maps {
        let errors = [10, 100, 1000, 10_000].map(|slices| format!("{:.1e}", map.error_of_frames(slices)));
        println!("| {name} | {} |", errors.join(" | "));
    }
}

/// Which of four a number from 0 to 1 is in.
fn quarter(a: f64) -> usize {
    [0.25, 0.5, 0.75].into_iter().filter(|bound| a >= *bound).count()
}

impl Map {
    fn new(
        image: impl Fn(&[Expr; 3]) -> [Expr; 3],
        jacobian: impl Fn(&[Expr; 3]) -> [[Expr; 3]; 3],
        second: f64,
    ) -> Self {
        let mut builder = GraphBuilder::new();
        let params = ["x", "y", "z"].map(|name| builder.param(name, 0.0));
        let xyz = params.map(Expr::from);
        let (image, jacobian) = (image(&xyz), jacobian(&xyz));
        Self { params, env: builder.initial().clone(), image, jacobian, second }
    }

    fn evaluate<const N: usize>(&self, exprs: &[Expr; N], at: DVec3) -> [f64; N] {
        let mut env = self.env.clone();
        for (param, value) in self.params.into_iter().zip(at.to_array()) {
            env.set(param, value);
        }
        std::array::from_fn(|i| exprs[i].evaluate(&env))
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.evaluate(&self.image, p).into()
    }

    fn derivative(&self, p: DVec3) -> DMat3 {
        DMat3::from_cols_array_2d(&[0, 1, 2].map(|row| self.evaluate(&self.jacobian[row], p))).transpose()
    }

    fn in_slices(&self, part: &Aabb, slices: u32, way: fn(&Self, &Aabb) -> Aabb) -> Aabb {
        let height = part.size().z / f64::from(slices);
        let slice = |index: u32| {
            let from = part.min.z + f64::from(index) * height;
            Aabb::new(part.min.with_z(from), part.max.with_z(from + height))
        };
        (0..slices).map(|index| way(self, &slice(index))).fold(Aabb::EMPTY, Aabb::join)
    }

    fn by_intervals(&self, part: &Aabb) -> Aabb {
        let ranges = self.image.each_ref().map(|expr| expr.range(&intervals(part)));
        Aabb::new(ranges.map(|range| range.min).into(), ranges.map(|range| range.max).into())
    }

    fn by_mean_value(&self, part: &Aabb) -> Aabb {
        let (middle, half) = (self.point(part.center()), part.size() / 2.0);
        let reach = self.jacobian.each_ref().map(|row| {
            let steepest = row.each_ref().map(|entry| {
                let range = entry.range(&intervals(part));
                range.min.abs().max(range.max.abs())
            });
            DVec3::from(steepest).dot(half)
        });
        Aabb::new(middle - DVec3::from(reach), middle + DVec3::from(reach))
    }

    fn by_points(&self, part: &Aabb) -> Aabb {
        let hull = Aabb::from_points(part.corners().map(|corner| self.point(corner)));
        let beyond = self.second * part.size().z * part.size().z / 8.0;
        Aabb::new(hull.min - beyond, hull.max + beyond)
    }

    fn sampled(&self, surface: impl Fn(f64, f64) -> DVec3) -> Aabb {
        Aabb::from_points(grid().map(|(a, b)| self.point(surface(a, b))))
    }

    /// How far the image of the column is from that of its slices, each moved as the middle of its axis is.
    fn error_of_frames(&self, slices: u32) -> f64 {
        let half = DVec3::new(WIDTH, WIDTH, 0.5 / f64::from(slices));
        let errors = [0, slices / 3, slices - 1].into_iter().flat_map(|slice| {
            let middle = DVec3::Z * (f64::from(slice) + 0.5) / f64::from(slices);
            let (image, derivative) = (self.point(middle), self.derivative(middle));
            let corners = Aabb::new(-half, half).corners();
            corners.map(|corner| self.point(middle + corner).distance(image + derivative * corner))
        });
        errors.fold(0.0, f64::max)
    }
}

/// Pairs of numbers from 0 to 1.
fn grid() -> impl Iterator<Item = (f64, f64)> {
    let steps = || (0..=400).map(|step| f64::from(step) / 400.0);
    steps().flat_map(move |a| steps().map(move |b| (a, b)))
}

fn intervals(part: &Aabb) -> [Interval; 3] {
    [0, 1, 2].map(|axis| Interval::new(part.min[axis], part.max[axis]))
}

/// Sine and cosine of an angle in radians.
fn sin_cos(angle: Expr) -> [Expr; 2] {
    let degrees = angle * 1_f64.to_degrees();
    [Function::Sin, Function::Cos].map(|function| Expr::call(function, [degrees.clone()]))
}

/// (x, y) scaled by 1 + k z.
fn taper(k: f64) -> Map {
    let scale = |z: &Expr| Expr::from(1.0) + z.clone() * k;
    let zero = || Expr::from(0.0);
    Map::new(
        |[x, y, z]| [x.clone() * scale(z), y.clone() * scale(z), z.clone()],
        |[x, y, z]| {
            [
                [scale(z), zero(), x.clone() * k],
                [zero(), scale(z), y.clone() * k],
                [zero(), zero(), 1.0.into()],
            ]
        },
        0.0,
    )
}

/// (x, y) turned by rate · z.
fn twist(rate: f64) -> Map {
    let turned = move |[x, y, z]: &[Expr; 3]| {
        let [sin, cos] = sin_cos(z.clone() * rate);
        [x.clone() * cos.clone() - y.clone() * sin.clone(), x.clone() * sin + y.clone() * cos]
    };
    Map::new(
        move |p| {
            let [x, y] = turned(p);
            [x, y, p[2].clone()]
        },
        move |p| {
            let [sin, cos] = sin_cos(p[2].clone() * rate);
            let [x, y] = turned(p);
            [
                [cos.clone(), -sin.clone(), y * -rate],
                [sin, cos, x * rate],
                [0.0.into(), 0.0.into(), 1.0.into()],
            ]
        },
        rate * rate * WIDTH * 2_f64.sqrt(),
    )
}

/// The axis as an arc towards +x.
fn bend(curvature: f64) -> Map {
    let radius = move |x: &Expr| Expr::from(1.0 / curvature) - x.clone();
    Map::new(
        move |[x, y, z]| {
            let [sin, cos] = sin_cos(z.clone() * curvature);
            [Expr::from(1.0 / curvature) - radius(x) * cos, y.clone(), radius(x) * sin]
        },
        move |[x, _, z]| {
            let [sin, cos] = sin_cos(z.clone() * curvature);
            let turning = [sin.clone(), cos.clone()].map(|part| radius(x) * curvature * part);
            let [turn_x, turn_z] = turning;
            [[cos, 0.0.into(), turn_x], [0.0.into(), 1.0.into(), 0.0.into()], [-sin, 0.0.into(), turn_z]]
        },
        curvature * (1.0 + curvature * WIDTH),
    )
}
