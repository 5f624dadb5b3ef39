//! Three ways to find where a curved ray meets something: by pieces, by its roots, and by marching.

use csg_graph_trace::Ray;
use glam::DVec3;

use crate::deformation::{Deformation, WIDTH};

/// A straight piece of a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) range: [f64; 2],
    ends: [DVec3; 2],
}

impl Piece {
    /// The ray of the piece, with the parameter of the whole: t stays one parameter in all frames.
    pub(crate) fn ray(&self) -> Ray {
        let direction = (self.ends[1] - self.ends[0]) / (self.range[1] - self.range[0]);
        Ray { origin: self.ends[0] - direction * self.range[0], direction }
    }

    /// The same from its beginning, at t = 0.
    pub(crate) fn own_ray(&self) -> Ray {
        Ray { origin: self.ends[0], direction: (self.ends[1] - self.ends[0]) / self.length() }
    }

    /// Whether a parameter of the whole is in it.
    pub(crate) fn holds(&self, t: f64) -> bool {
        self.range[0] <= t && t <= self.range[1]
    }

    pub(crate) fn length(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    /// Whether nothing within `slack` of it is in the column.
    fn misses(&self, slack: f64) -> bool {
        let (low, high) = (self.ends[0].min(self.ends[1]) - slack, self.ends[0].max(self.ends[1]) + slack);
        let (least, greatest) = (DVec3::new(-WIDTH, -WIDTH, 0.0), DVec3::new(WIDTH, WIDTH, 1.0));
        low.cmpgt(greatest).any() || high.cmplt(least).any()
    }
}

/// The curve of a ray as pieces that are no further from it than `tolerance`, in order; only those that may be in the
/// column. Neighbours end in the same point.
pub(crate) fn pieces(deformation: Deformation, ray: &Ray, tolerance: f64) -> impl Iterator<Item = Piece> {
    let at = move |t: f64| deformation.along(ray, t).0;
    let whole = |range: [f64; 2]| Piece { range, ends: range.map(at) };
    let mut open: Vec<Piece> = deformation.domain(ray).into_iter().rev().map(whole).collect();
    std::iter::from_fn(move || {
        while let Some(piece) = open.pop() {
            let length = piece.length();
            let error = deformation.second(ray, piece.range) * length * length / 8.0;
            if piece.misses(error) {
                continue;
            }
            if error <= tolerance {
                return Some(piece);
            }
            let ([from, to], [start, end]) = (piece.range, piece.ends);
            let middle = from + length / 2.0;
            let point = at(middle);
            open.push(Piece { range: [middle, to], ends: [point, end] });
            open.push(Piece { range: [from, middle], ends: [start, point] });
        }
        None
    })
}

/// Where the curve of a ray first meets a ball, and at how many points it was evaluated: roots are isolated by bounds of
/// the second derivative, as [KALR89] does by Lipschitz bounds, and then found by Newton's method.
pub(crate) fn first_root(
    deformation: Deformation,
    ray: &Ray,
    center: DVec3,
    radius: f64,
) -> (Option<f64>, u32) {
    let mut evaluations = 0;
    let mut open = deformation.domain(ray);
    open.reverse();
    while let Some([from, to]) = open.pop() {
        let (middle, half) = ((from + to) / 2.0, (to - from) / 2.0);
        let mut distance = |t: f64| {
            evaluations += 1;
            let (at, velocity) = deformation.along(ray, t);
            let out = at - center;
            (out.length_squared() - radius * radius, 2.0 * out.dot(velocity), out.length(), velocity.length())
        };
        let (value, slope, out, speed) = distance(middle);
        let second = deformation.second(ray, [from, to]);
        let speed = speed + second * half;
        let second = 2.0 * (speed * speed + (out + speed * half) * second);
        if value.abs() > slope.abs() * half + second * half * half / 2.0 || half < 1e-12 {
            continue;
        }
        if slope.abs() > second * half {
            let (first, last) = (distance(from).0, distance(to).0);
            if (first > 0.0) == (last > 0.0) {
                continue;
            }
            let mut t = (from * last - to * first) / (last - first);
            for _ in 0..20 {
                let (value, slope, ..) = distance(t);
                t = (t - value / slope).clamp(from, to);
                if value.abs() < 1e-14 {
                    break;
                }
            }
            return (Some(t), evaluations);
        }
        open.push([middle, to]);
        open.push([from, middle]);
    }
    (None, evaluations)
}

/// The same to a tolerance by marching [HART96]: the curve is nowhere faster than `speed`, and so many steps.
pub(crate) fn march(
    deformation: Deformation,
    ray: &Ray,
    (center, radius): (DVec3, f64),
    tolerance: f64,
) -> (Option<f64>, u32) {
    let mut steps = 0;
    for range in deformation.domain(ray) {
        let [mut t, end] = range;
        let speed = deformation.along(ray, t).1.length() + deformation.second(ray, range) * (end - t);
        while t < end {
            steps += 1;
            let distance = (deformation.along(ray, t).0 - center).length() - radius;
            if distance < tolerance {
                return (Some(t), steps);
            }
            t += distance / speed;
        }
    }
    (None, steps)
}
