//! What rays cost below taper, twist and bend: the measurements of docs/nonlinear.md.
//!
//! `cargo run --release -p csg-graph-trace --example deformed` takes a minute, prints tables by CPU time, and fails if an
//! error bound does not hold.
#![expect(clippy::print_stdout, reason = "tables")]

mod column;
mod curve;
mod deformation;
mod projective;

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use cpu_time::ThreadTime;
use csg_graph_bounds::Aabb;
use csg_graph_trace::{Accelerated, Ray, Tracer};
use glam::DVec3;

use column::Column;
use curve::{Piece, first_root, march, pieces};
use deformation::{Deformation, WIDTH};
use projective::{Straight, tapered_box};

const DEFORMATIONS: [(&str, Deformation); 4] = [
    ("taper to 1/2", Deformation::Taper(-0.5)),
    ("twist by 90°", Deformation::Twist(FRAC_PI_2)),
    ("twist by 360°", Deformation::Twist(4.0 * FRAC_PI_2)),
    ("bend by 90°", Deformation::Bend(FRAC_PI_2)),
];

/// In heights of the column.
const TOLERANCES: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];

const SCENES: [(&str, &str); 3] =
    [("peers/sympodial", "cnt = 12"), ("peers/sierpinski", "n = 8"), ("peers/cheese", "n = 3")];

const RAYS: usize = 20_000;

fn main() -> Result<(), Box<dyn Error>> {
    balls();
    for (name, set) in SCENES {
        scene(name, set)?;
    }
    joints();
    Ok(())
}

/// The t at which a ray first meets the ball about a point, and how many points of the curve that took.
type Find<'a> = &'a dyn Fn(&Ray, DVec3) -> (Option<f64>, u32);

/// Numbers that are as good as random, and the same everywhere.
struct Chance(u64);

impl Chance {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Each coordinate from 0 to 1.
    fn point(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.number()))
    }

    /// Of length 1, in any direction alike.
    fn direction(&mut self) -> DVec3 {
        loop {
            let v = 2.0 * self.point() - 1.0;
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// What a piece of work gives, and the seconds of this thread that it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = ThreadTime::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// One ball in the column: the three ways to find where a ray meets it.
fn balls() {
    const RADIUS: f64 = 0.1;
    println!(
        "| one ball | way | tolerance | points a ray | µs a ray | farthest from the surface | disagree |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|");
    for (name, deformation) in DEFORMATIONS {
        let mut chance = Chance(1);
        let case = |_| {
            let side = 2.0 * (WIDTH - RADIUS);
            let center = DVec3::new(side, side, 1.0 - 2.0 * RADIUS) * chance.point()
                + DVec3::new(-side / 2.0, -side / 2.0, RADIUS);
            let near = deformation.point(center + chance.direction() * (1.2 * RADIUS * chance.number()));
            let direction = chance.direction();
            (Ray { origin: near - 3.0 * direction, direction }, center)
        };
        let cases: Vec<(Ray, DVec3)> = (0..RAYS).map(case).collect();
        let roots = cases.iter().map(|(ray, center)| first_root(deformation, ray, *center, RADIUS).0);
        let roots: Vec<_> = roots.collect();
        let report = |way: &str, tolerance: f64, find: Find<'_>| {
            let (found, seconds) =
                timed(|| cases.iter().map(|(ray, center)| find(ray, *center)).collect::<Vec<_>>());
            let points: u32 = found.iter().map(|(_, points)| points).sum();
            let disagree = found.iter().zip(&roots).filter(|((a, _), b)| a.is_some() != b.is_some()).count();
            let off = |((ray, center), (t, _)): (&(Ray, DVec3), &(Option<f64>, u32))| {
                t.map_or(0.0, |t| ((deformation.along(ray, t).0 - center).length() - RADIUS).abs())
            };
            let farthest = cases.iter().zip(&found).map(off).fold(0.0, f64::max);
            assert!(way == "roots" || farthest <= tolerance, "{way} promised {tolerance}");
            let (points, each) = (f64::from(points) / RAYS as f64, seconds * 1e6 / RAYS as f64);
            let share = 1e2 * disagree as f64 / RAYS as f64;
            println!(
                "| {name} | {way} | {tolerance:.0e} | {points:.1} | {each:.2} | {farthest:.1e} | {share:.2} % |"
            );
        };
        report("roots", 0.0, &|ray, center| first_root(deformation, ray, center, RADIUS));
        for tolerance in TOLERANCES {
            report("pieces", tolerance, &|ray, center| {
                let mut points = 1;
                let first = pieces(deformation, ray, tolerance).find_map(|piece| {
                    points += 1;
                    let ray = piece.ray();
                    let (from_center, squared) = (ray.origin - center, ray.direction.length_squared());
                    let middle = -from_center.dot(ray.direction) / squared;
                    let off = from_center + ray.direction * middle;
                    let half = ((RADIUS * RADIUS - off.length_squared()) / squared).sqrt();
                    [middle - half, middle + half].into_iter().find(|t| piece.holds(*t))
                });
                (first, points)
            });
        }
        for tolerance in TOLERANCES {
            report("march", tolerance, &|ray, center| march(deformation, ray, (center, RADIUS), tolerance));
        }
    }
}

/// A scene in the column, below the fast engine as it is.
fn scene(name: &str, set: &str) -> Result<(), Box<dyn Error>> {
    let column = Column::load(name, set)?;
    let accelerated = Accelerated::new(&column.graph, &column.boxes, Accelerated::DEFAULT_BUDGET)?;
    let mut tracer = accelerated.tracer();
    println!(
        "\n| `{name}` {set} | tolerance | pieces a ray | Mray/s | times as long | other hits | half within |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for (what, deformation) in DEFORMATIONS {
        let rays = chords(deformation.point(DVec3::Z / 2.0));
        let straight: Vec<Ray> = chords(DVec3::Z / 2.0).into_iter().map(|ray| column.ray(ray)).collect();
        let (_, base) = timed(|| straight.iter().filter_map(|ray| tracer.nearest(ray)).count());
        let row = |what: &str, tolerance: &str, pieces: f64, seconds: f64| {
            let rate = RAYS as f64 / seconds * 1e-6;
            print!("| {what} | {tolerance} | {pieces:.1} | {rate:.2} | {:.1} |", seconds / base);
        };
        row("straight", "", 1.0, base);
        println!(" | |");
        if let Deformation::Taper(k) = deformation {
            let (seconds, off, its_box) = straightened(k, &column, &mut tracer, &rays);
            row("the same, projective", "0", 1.0, seconds);
            println!(" | {off:.1e} |\n| {its_box} | | | | | | |");
        }
        let mut trace = |tolerance: f64| {
            let mut count = 0;
            let ask = |ray| {
                pieces(deformation, ray, tolerance).find_map(|piece| {
                    count += 1;
                    let own = column.ray(piece.own_ray());
                    let hit = tracer.occluded(&own, piece.length()).then(|| tracer.nearest(&own))?;
                    Some(piece.range[0] + hit?.t)
                })
            };
            let (found, seconds) = timed(|| rays.iter().map(ask).collect::<Vec<_>>());
            (found, seconds, f64::from(count) / RAYS as f64)
        };
        let (truth, ..) = trace(1e-8);
        for tolerance in TOLERANCES {
            let (found, seconds, count) = trace(tolerance);
            let pairs = || found.iter().zip(&truth);
            let other = pairs().filter(|(a, b)| a.is_some() != b.is_some()).count();
            let mut off: Vec<f64> = pairs().filter_map(|(a, b)| Some(((*a)? - (*b)?).abs())).collect();
            off.sort_by(f64::total_cmp);
            row(what, &format!("{tolerance:.0e}"), count, seconds);
            println!(" {:.2} % | {:.1e} |", 1e2 * other as f64 / RAYS as f64, off[off.len() / 2]);
        }
    }
    Ok(())
}

/// The projective taper: the seconds that rays take, how far any hit is from where it should be, and what its box is.
fn straightened(k: f64, column: &Column, tracer: &mut Tracer<'_>, rays: &[Ray]) -> (f64, f64, String) {
    let below = |ray| {
        let own = Straight::new(k, ray)?;
        let hit = tracer.nearest(&column.ray(own.ray)).filter(|hit| hit.t < own.end)?;
        Some((own.t(hit.t), own.ray.at(hit.t)))
    };
    let (found, seconds) = timed(|| rays.iter().map(below).collect::<Vec<_>>());
    let (bounds, queries) = tapered_box(k, column);
    let off = rays.iter().zip(&found).filter_map(|(ray, hit)| {
        let (t, point) = (*hit)?;
        let image = ray.at(t);
        assert!(bounds.contains(image), "{image} is in the solid and outside of its box");
        let exact = DVec3::new(image.x, image.y, (1.0 + k) * image.z) / (1.0 + k * image.z);
        Some(exact.distance(point))
    });
    let off = off.fold(0.0, f64::max);
    let of_box = column.boxes.root.corners().map(|corner| {
        let p = (corner - column.foot) / column.scale;
        DVec3::new(p.x, p.y, p.z / (1.0 + k)) / (1.0 - k / (1.0 + k) * p.z)
    });
    let share = bounds.surface_area() / Aabb::from_points(of_box).surface_area();
    (seconds, off, format!("its box: {queries} supports, {share:.3} of the surface of the image of the box"))
}

/// Lines between points of a sphere about the column.
fn chords(middle: DVec3) -> Vec<Ray> {
    let mut chance = Chance(2);
    let mut chord = || {
        let [a, b] = [0; 2].map(|_| middle + 0.7 * chance.direction());
        let direction = (b - a).normalize();
        Ray { origin: a - direction, direction }
    };
    (0..RAYS).map(|_| chord()).collect()
}

/// Faces exactly at the joints of pieces: the plane x = 0, and rays through the middle of the axis. Each must cross it an odd
/// number of times.
fn joints() {
    let rule_counts = |ray: &Ray| {
        let near_middle = |piece: &Piece| piece.range[0] < 3.0 + 1e-6 && piece.range[1] > 3.0 - 1e-6;
        let pieces = pieces(Deformation::Twist(FRAC_PI_2), ray, 1e-4).filter(near_middle);
        let met: Vec<([f64; 2], f64)> =
            pieces.map(|piece| (piece.range, -piece.ray().origin.x / piece.ray().direction.x)).collect();
        let within = |margin: f64| {
            met.iter().filter(|([from, to], t)| from - margin <= *t && *t < to + margin).count()
        };
        // Which side a joint is on, by the piece before it and by the one after it.
        let torn =
            met.windows(2).filter(|pair| (pair[0].1 < pair[0].0[1]) != (pair[1].1 < pair[1].0[0])).count();
        [within(0.0), within(1e-9), within(0.0) + torn]
    };
    let mut chance = Chance(3);
    let mut counts = [[0; 3]; 4];
    for _ in 0..RAYS {
        let direction = chance.direction();
        let ray = Ray { origin: DVec3::Z / 2.0 - 3.0 * direction, direction };
        for (rule, crossings) in rule_counts(&ray).into_iter().enumerate() {
            counts[crossings.min(3)][rule] += 1;
        }
    }
    assert_eq!([counts[0][2], counts[2][2]], [0, 0]);
    println!(
        "\n| crossings | each piece in its range | with a margin of 1e-9 | and where the sides of a joint differ |"
    );
    println!("|---|---:|---:|---:|");
    for (crossings, [alone, margin, sides]) in counts.into_iter().enumerate() {
        println!("| {crossings} | {alone} | {margin} | {sides} |");
    }
}
