//! Taper, twist and bend [BARR84] of a column about the z axis, and what they make of a ray.
//!
//! Below a nonlinear T-node a straight ray is a curve. Here are its points, its velocity, and a bound of its second
//! derivative: between two points at t and t + h, the curve is no further from their chord than h²/8 times that bound.

use csg_graph_trace::Ray;
use glam::{DVec2, DVec3};

/// The column reaches so far from the z axis in x and in y, and from 0 to 1 in z.
pub(crate) const WIDTH: f64 = 0.25;

/// Domains are longer than the part by so much, so that none ends in a face.
const MARGIN: f64 = 1e-9;

/// A map from the frame of the column into the frame above.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Deformation {
    /// Scales x and y by 1 + k z.
    Taper(f64),
    /// Turns by so many radians at z = 1.
    Twist(f64),
    /// Bends the axis into an arc of this curvature, towards +x.
    Bend(f64),
}

impl Deformation {
    /// The image of a point of the column.
    pub(crate) fn point(self, p: DVec3) -> DVec3 {
        match self {
            Self::Taper(k) => DVec3::new(p.x * (1.0 + k * p.z), p.y * (1.0 + k * p.z), p.z),
            Self::Twist(rate) => DVec2::from_angle(rate * p.z).rotate(p.truncate()).extend(p.z),
            Self::Bend(curvature) => {
                let (sin, cos) = libm::sincos(curvature * p.z);
                let radius = 1.0 / curvature - p.x;
                DVec3::new(1.0 / curvature - radius * cos, p.y, radius * sin)
            }
        }
    }

    /// Where a ray is at t in the frame of the column, and its velocity there.
    pub(crate) fn along(self, ray: &Ray, t: f64) -> (DVec3, DVec3) {
        let (p, d) = (ray.at(t), ray.direction);
        match self {
            Self::Taper(k) => {
                let scale = 1.0 + k * p.z;
                let at = p.truncate() / scale;
                (at.extend(p.z), ((d.truncate() - at * (k * d.z)) / scale).extend(d.z))
            }
            Self::Twist(rate) => {
                let velocity = d.truncate() - p.truncate().perp() * (rate * d.z);
                let turn = DVec2::from_angle(-rate * p.z);
                (turn.rotate(p.truncate()).extend(p.z), turn.rotate(velocity).extend(d.z))
            }
            Self::Bend(curvature) => {
                let (from_middle, d_plane) = (DVec2::new(1.0 / curvature - p.x, p.z), DVec2::new(-d.x, d.z));
                let radius = from_middle.length();
                let angle = libm::atan2(from_middle.y, from_middle.x);
                let turning = from_middle.perp_dot(d_plane) / (radius * radius);
                let receding = from_middle.dot(d_plane) / radius;
                (
                    DVec3::new(1.0 / curvature - radius, p.y, angle / curvature),
                    DVec3::new(-receding, d.y, turning / curvature),
                )
            }
        }
    }

    /// At least the length of the second derivative of the curve between two parameters.
    pub(crate) fn second(self, ray: &Ray, [from, to]: [f64; 2]) -> f64 {
        let (ends, d) = ([ray.at(from), ray.at(to)], ray.direction);
        let across = d.truncate().length();
        // The distance from the axis is convex along the ray, so that it is greatest at an end.
        let reach = ends.map(|p| p.truncate().length_squared()).into_iter().fold(0.0, f64::max).sqrt();
        match self {
            Self::Taper(k) => {
                let scale = ends.map(|p| 1.0 + k * p.z).into_iter().fold(f64::INFINITY, f64::min);
                let rate = (k * d.z).abs() / scale;
                2.0 * rate * (across + reach * rate) / scale
            }
            Self::Twist(rate) => {
                let rate = (rate * d.z).abs();
                rate * (2.0 * across + rate * reach)
            }
            Self::Bend(curvature) => {
                let [a, b] = ends.map(|p| DVec2::new(1.0 / curvature - p.x, p.z));
                let nearest = (a.dot(a - b) / (a - b).length_squared()).clamp(0.0, 1.0);
                let radius = a.lerp(b, nearest).length();
                let squared = DVec2::new(d.x, d.z).length_squared();
                squared / radius * (1.0 + 1.0 / (curvature * radius * curvature * radius)).sqrt()
            }
        }
    }

    /// Where a ray may meet the image of the column: intervals of t, in order.
    pub(crate) fn domain(self, ray: &Ray) -> Vec<[f64; 2]> {
        let (o, d) = (ray.origin, ray.direction);
        let domain = match self {
            Self::Taper(_) | Self::Twist(_) => {
                let widest = if let Self::Taper(k) = self { k.max(0.0) + 1.0 } else { 1.0 };
                let round = within_circle(o.truncate(), d.truncate(), WIDTH * 2_f64.sqrt() * widest);
                vec![clip(round, slab(o.z, d.z, 0.0, 1.0))]
            }
            Self::Bend(curvature) => {
                let (o2, d2) = (DVec2::new(1.0 / curvature - o.x, o.z), DVec2::new(-d.x, d.z));
                let outer = within_circle(o2, d2, 1.0 / curvature + WIDTH);
                let inner = within_circle(o2, d2, 1.0 / curvature - WIDTH);
                // Half a turn about the middle of the arc: the angle jumps on the other side.
                let forwards = DVec2::from_angle(curvature / 2.0);
                let half = slab(o2.dot(forwards), d2.dot(forwards), 0.0, f64::INFINITY);
                let outer = clip(clip(outer, half), slab(o.y, d.y, -WIDTH, WIDTH));
                if inner[0] < inner[1] {
                    vec![clip(outer, [f64::NEG_INFINITY, inner[0]]), clip(outer, [inner[1], f64::INFINITY])]
                } else {
                    vec![outer]
                }
            }
        };
        domain.into_iter().filter(|[from, to]| from < to).map(|[a, b]| [a - MARGIN, b + MARGIN]).collect()
    }
}

fn clip(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].min(b[1])]
}

/// Where `low` ≤ o + t d ≤ `high`.
fn slab(o: f64, d: f64, low: f64, high: f64) -> [f64; 2] {
    let [a, b] = [(low - o) / d, (high - o) / d];
    [a.min(b), a.max(b)]
}

/// Where o + t d is within a circle about the origin.
fn within_circle(o: DVec2, d: DVec2, radius: f64) -> [f64; 2] {
    let middle = -o.dot(d) / d.length_squared();
    let half = (radius * radius - (o + d * middle).length_squared()) / d.length_squared();
    if half > 0.0 { [middle - half.sqrt(), middle + half.sqrt()] } else { [f64::INFINITY, f64::NEG_INFINITY] }
}
