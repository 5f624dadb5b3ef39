//! The torus: a quartic.
//!
//! With the parameter s counted in object units from the closest approach to the centre, the line is inside where
//! q(s) = (|x|² + 1 − r²)² − 4 (x² + y²) ≤ 0, a quartic with coefficients of moderate size. Its extrema, the roots of its
//! derivative, cut the line into pieces on which it is monotone, so that a piece holds a root exactly if its ends have
//! different signs. The roots of the derivative are found in the same way, down to degree 1. No closed formula is as
//! dependable: Ferrari's loses half the digits where roots are close, which on a torus is everywhere near its outline.
//!
//! The quartic only places the pieces. Signs and roots come from the solid's own f = (ρ − 1)² + z² − r², ρ² = x² + y²:
//! q = f · ((ρ + 1)² + z² − r²), whose second factor is positive, and f keeps its digits for a thin torus where q does not.

use glam::{DVec3, Vec3Swizzles};

use super::{End, Span, Spans};
use crate::Ray;

pub(super) fn spans(ray: &Ray, minor: f64) -> Spans {
    let squared_length = ray.direction.length_squared();
    let middle = -ray.origin.dot(ray.direction) / squared_length;
    let closest = ray.at(middle);
    let squared_reach = (1.0 + minor) * (1.0 + minor) - closest.length_squared();
    if squared_reach <= 0.0 || squared_reach.is_nan() {
        return Spans::NONE;
    }
    let length = squared_length.sqrt();
    let unit = ray.direction / length;
    let point = |s: f64| closest + unit * s;
    let field = |s: f64| {
        let p = point(s);
        let from_ring = p.xy().length() - 1.0;
        from_ring * from_ring + p.z * p.z - minor * minor
    };

    let reach = squared_reach.sqrt();
    let extrema = roots(&derivative(&quartic(closest, unit, minor)), -reach, reach);
    let end = |s: f64| End { t: middle + s / length, normal: normal(point(s), unit) };
    let mut spans = Spans::NONE;
    let mut entered = None;
    // The bounding sphere's surface is outside of the torus, whatever rounding says.
    let (mut before, mut outside_before) = (-reach, true);
    for s in extrema.iter().copied().chain([reach]) {
        let outside = s >= reach || field(s) >= 0.0;
        if outside != outside_before {
            let crossing = end(bisect(field, before, s, outside_before));
            match entered.take() {
                None => entered = Some(crossing),
                Some(enter) => spans.push(Span { enter, exit: crossing }),
            }
        }
        (before, outside_before) = (s, outside);
    }
    spans
}

/// The coefficients of q, constant first.
fn quartic(closest: DVec3, unit: DVec3, minor: f64) -> [f64; 5] {
    let linear = closest.dot(unit);
    let constant = closest.length_squared() + 1.0 - minor * minor;
    let (p, u) = (closest.xy(), unit.xy());
    [
        constant * constant - 4.0 * p.length_squared(),
        4.0 * linear * constant - 8.0 * p.dot(u),
        4.0 * linear * linear + 2.0 * constant - 4.0 * u.length_squared(),
        4.0 * linear,
        1.0,
    ]
}

fn derivative(quartic: &[f64; 5]) -> [f64; 4] {
    [quartic[1], 2.0 * quartic[2], 3.0 * quartic[3], 4.0 * quartic[4]]
}

/// The real roots of odd order of a cubic between `low` and `high`, in order.
fn roots(cubic: &[f64; 4], low: f64, high: f64) -> Roots {
    let [c0, c1, c2, c3] = *cubic;
    let quadratic = |s: f64| (3.0 * c3 * s + 2.0 * c2) * s + c1;
    let mut pieces = Roots::default();
    let vertex = (-c2 / (3.0 * c3)).clamp(low, high);
    collect(quadratic, &[low, vertex, high], &mut pieces);
    let mut ends = Roots::default();
    ends.push(low);
    pieces.iter().for_each(|extremum| ends.push(*extremum));
    ends.push(high);
    let mut roots = Roots::default();
    collect(|s| ((c3 * s + c2) * s + c1) * s + c0, &ends, &mut roots);
    roots
}

/// Adds the root of each piece between neighbours of `ends` on which `f` changes its sign.
fn collect(f: impl Fn(f64) -> f64, ends: &[f64], roots: &mut Roots) {
    for piece in ends.windows(2) {
        let positive = [f(piece[0]) >= 0.0, f(piece[1]) >= 0.0];
        if positive[0] != positive[1] {
            roots.push(bisect(&f, piece[0], piece[1], positive[0]));
        }
    }
}

/// Up to four numbers in order.
#[derive(Default)]
struct Roots {
    values: [f64; 4],
    count: usize,
}

impl Roots {
    fn push(&mut self, root: f64) {
        self.values[self.count] = root;
        self.count += 1;
    }
}

impl std::ops::Deref for Roots {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

/// The closest that two numbers of the size of a torus are worth telling apart.
const RESOLUTION: f64 = 2.0 * f64::EPSILON;

/// The root of a function that changes its sign once between `low` and `high`; `falling` says which way.
///
/// Regula falsi, Illinois variant, which keeps the root enclosed; every fourth step bisects, so that nothing is slow.
fn bisect(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64, falling: bool) -> f64 {
    let (mut f_low, mut f_high) = (f(low), f(high));
    let mut moved_low = None;
    for round in 1.. {
        let half = 0.5 * (low + high);
        if high - low <= RESOLUTION || half <= low || half >= high {
            break;
        }
        let secant = (low * f_high - high * f_low) / (f_high - f_low);
        let s = if round % 4 != 0 && low < secant && secant < high { secant } else { half };
        let value = f(s);
        if value == 0.0 {
            return s;
        }
        let moves_low = (value > 0.0) == falling;
        let again = moved_low.replace(moves_low) == Some(moves_low);
        if moves_low {
            (low, f_low) = (s, value);
            f_high *= if again { 0.5 } else { 1.0 };
        } else {
            (high, f_high) = (s, value);
            f_low *= if again { 0.5 } else { 1.0 };
        }
    }
    0.5 * (low + high)
}

/// Away from the nearest point of the ring. At the centre of a torus that touches itself there: against the line.
fn normal(point: DVec3, unit: DVec3) -> DVec3 {
    let ring = point.xy().normalize_or_zero();
    let normal = point - DVec3::from((ring, 0.0));
    if normal == DVec3::ZERO { -unit } else { normal }
}
