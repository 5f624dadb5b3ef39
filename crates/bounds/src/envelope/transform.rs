//! Slabs under transformations whose arguments are intervals.
//!
//! The image of a solid with support h under x ↦ A x + t has the support t·d + h(Aᵀd). Where the arguments vary, Aᵀd is any
//! vector of a set, and since h is convex it is nowhere larger on that set than at the corners of a polytope about it:
//!
//! - entries in intervals of their own (scale, shear, matrix) make each coordinate of Aᵀd an interval: a box;
//! - one factor for all coordinates makes a segment;
//! - an angle makes an arc. It is cut into pieces, and the tangents at their ends meet in a polygon about it, whose corners
//!   are the middles of the pieces, further out by the cosine of half a piece.

use csg_graph::{Interval, Transform, TransformKind};
use glam::{DMat3, DVec3};

use super::support::support;
use crate::{Slabs, Volume};

/// The most degrees of a piece of an arc: its corner is 1.5 % further out than it is.
const PIECE: f64 = 20.0;

/// The corners of the polygon about a full turn and its two ends.
const CORNERS: usize = 20;

/// More than the entries of a rotation err, with the angles at the corners.
const TURNED: f64 = 128.0 * f64::EPSILON;

/// Angles beyond this are any.
const FAR: f64 = 720.0;

/// All maps x ↦ A x + t that a transformation may be.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapRange {
    linear: Linear,
    offset: [Interval; 3],
}

/// What A may be.
#[derive(Clone, Debug, PartialEq)]
enum Linear {
    Identity,
    One(DMat3),
    /// A multiple of the identity.
    Factor(Interval),
    /// A rotation about an axis of length 1, by so many degrees.
    Turn(DVec3, Interval),
    /// By rows, each entry in its own interval.
    Entries([[Interval; 3]; 3]),
}

impl MapRange {
    /// The transformations of a kind for arguments in these intervals. `None` if there is none.
    pub(super) fn new(kind: TransformKind, args: &[Interval]) -> Option<Self> {
        if args.iter().any(|arg| arg.is_empty()) {
            return None;
        }
        let mut points = [0.0; 12];
        let all_points = points.iter_mut().zip(args).all(|(point, arg)| {
            *point = arg.value().unwrap_or(f64::NAN);
            !point.is_nan()
        });
        if all_points {
            return kind.evaluate(&points[..args.len()]).map(|map| Self::one(&map));
        }
        const ZERO: Interval = Interval::point(0.0);
        const ONE: Interval = Interval::point(1.0);
        let still = |linear| Self { linear, offset: [ZERO; 3] };
        Some(match kind {
            TransformKind::Move => Self { linear: Linear::Identity, offset: [args[0], args[1], args[2]] },
            TransformKind::UScale => still(Linear::Factor(args[0])),
            TransformKind::Scale => {
                still(Linear::Entries([[args[0], ZERO, ZERO], [ZERO, args[1], ZERO], [ZERO, ZERO, args[2]]]))
            }
            TransformKind::RotX => still(Linear::Turn(DVec3::X, args[0])),
            TransformKind::RotY => still(Linear::Turn(DVec3::Y, args[0])),
            TransformKind::RotZ => still(Linear::Turn(DVec3::Z, args[0])),
            TransformKind::Rot => {
                let axis = [args[0].value(), args[1].value(), args[2].value()];
                match axis {
                    [Some(x), Some(y), Some(z)] => {
                        let axis = DVec3::new(x, y, z);
                        let axis = (axis / axis.abs().max_element()).try_normalize()?;
                        still(Linear::Turn(axis, args[3]))
                    }
                    // Whatever the axis and the angle, no entry of a rotation is beyond 1.
                    _ => still(Linear::Entries([[Interval::new(-1.0, 1.0); 3]; 3])),
                }
            }
            TransformKind::Shear => still(Linear::Entries([
                [ONE, args[0], args[1]],
                [args[2], ONE, args[3]],
                [args[4], args[5], ONE],
            ])),
            TransformKind::Matrix => Self {
                linear: Linear::Entries([0, 4, 8].map(|row| [args[row], args[row + 1], args[row + 2]])),
                offset: [args[3], args[7], args[11]],
            },
            // A transformation that this version does not know may do anything.
            _ => Self { linear: Linear::Entries([[Interval::ALL; 3]; 3]), offset: [Interval::ALL; 3] },
        })
    }

    fn one(map: &Transform) -> Self {
        let affine = map.to_affine();
        let linear = match map {
            Transform::Translate(_) => Linear::Identity,
            _ => Linear::One(affine.matrix3),
        };
        Self { linear, offset: affine.translation.to_array().map(Interval::point) }
    }

    /// Slabs about the images of what is between slabs.
    pub(super) fn image(&self, below: &Slabs<13>) -> Slabs<13> {
        if below.is_empty() {
            return Slabs::EMPTY;
        }
        let moved = |direction: DVec3, support: f64| {
            let (shift, size) = self.shift(direction);
            let sum = shift + support;
            let above = sum + 8.0 * f64::EPSILON * (size + support.abs());
            if above.is_nan() { f64::INFINITY } else { above }
        };
        match &self.linear {
            // Nothing is turned, so each plane stays its own.
            Linear::Identity => {
                let mut image = *below;
                for (i, direction) in Slabs::<13>::DIRECTIONS.into_iter().enumerate() {
                    image.max[i] = moved(direction, below.max[i]);
                    image.min[i] = -moved(-direction, -below.min[i]);
                }
                image
            }
            Linear::One(matrix) => {
                let rows = matrix.transpose();
                Slabs::from_support(|d| moved(d, support(below, rows * d, rounding(&rows, d))))
            }
            Linear::Factor(factor) => {
                let ends = [factor.min, factor.max];
                Slabs::from_support(|d| {
                    let far = ends.map(|factor| at(below, factor * d, DVec3::ZERO));
                    moved(d, far[0].max(far[1]))
                })
            }
            Linear::Turn(axis, angle) => {
                let (turns, count) = about_arc(*axis, *angle);
                Slabs::from_support(|d| {
                    let error = DVec3::splat(TURNED * d.length());
                    let far = turns[..count].iter().map(|rows| support(below, *rows * d, error));
                    moved(d, far.fold(f64::NEG_INFINITY, f64::max))
                })
            }
            Linear::Entries(rows) => Slabs::from_support(|d| moved(d, farthest(below, rows, d))),
        }
    }

    /// The largest t·d, and the sum of the sizes in it.
    fn shift(&self, direction: DVec3) -> (f64, f64) {
        let (mut sum, mut sizes) = (0.0, 0.0);
        for (d, t) in direction.to_array().into_iter().zip(self.offset) {
            if d != 0.0 {
                let most = if d > 0.0 { t.max } else { -t.min };
                sum += most;
                sizes += most.abs();
            }
        }
        (sum, sizes)
    }
}

/// A support, of which nothing is known in a direction that is not finite.
fn at(slabs: &Slabs<13>, q: DVec3, error: DVec3) -> f64 {
    if q.is_finite() { support(slabs, q, error) } else { f64::INFINITY }
}

/// What the coordinates of a product Aᵀd err: nothing where it is a single entry.
fn rounding(transposed: &DMat3, direction: DVec3) -> DVec3 {
    if direction.abs().element_sum() <= 1.0 {
        return DVec3::ZERO;
    }
    let rows = transposed.transpose();
    let error = |column: DVec3| {
        let terms = column * direction;
        let sizes = terms.abs();
        if sizes.element_sum() > sizes.max_element() { 4.0 * f64::EPSILON * sizes.element_sum() } else { 0.0 }
    };
    DVec3::new(error(rows.x_axis), error(rows.y_axis), error(rows.z_axis))
}

/// The largest support of all Aᵀd, for the rows of A in intervals: at the corners of a box.
fn farthest(slabs: &Slabs<13>, rows: &[[Interval; 3]; 3], direction: DVec3) -> f64 {
    let mut corners = [DVec3::ZERO; 2];
    let mut error = DVec3::ZERO;
    for column in 0..3 {
        let (mut terms, mut size) = (0, 0.0);
        for (row, d) in rows.iter().zip(direction.to_array()) {
            let entry = row[column];
            let largest = entry.min.abs().max(entry.max.abs());
            if d == 0.0 || largest == 0.0 {
                continue;
            }
            let [least, most] = if d > 0.0 { [entry.min, entry.max] } else { [-entry.max, -entry.min] };
            corners[0][column] += least;
            corners[1][column] += most;
            terms += 1;
            size += largest;
        }
        error[column] = if terms > 1 { 4.0 * f64::EPSILON * size } else { 0.0 };
    }
    let mut farthest = f64::NEG_INFINITY;
    for corner in 0..8_usize {
        let upper = [corner & 1, corner >> 1 & 1, corner >> 2];
        // Where both are one corner, once is enough.
        if (0..3).any(|axis| upper[axis] == 1 && corners[0][axis] >= corners[1][axis]) {
            continue;
        }
        let q = DVec3::new(corners[upper[0]].x, corners[upper[1]].y, corners[upper[2]].z);
        farthest = farthest.max(at(slabs, q, error));
    }
    farthest
}

/// The transposed matrices at the corners of a polygon about an arc of rotations.
fn about_arc(axis: DVec3, angle: Interval) -> ([DMat3; CORNERS], usize) {
    let span = angle.max - angle.min;
    let full = !(span < 360.0 - PIECE) || angle.min.abs().max(angle.max.abs()) > FAR;
    let (start, span) = if full { (0.0, 360.0) } else { (angle.min, span) };
    let pieces = (span / PIECE).ceil().max(1.0);
    let piece = span / pieces;
    let out = rotation(DVec3::Z, 0.5 * piece, 1.0).x_axis.x.recip();
    let mut corners = [DMat3::IDENTITY; CORNERS];
    let mut count = 0;
    let mut push = |degrees: f64, out: f64| {
        corners[count] = rotation(axis, degrees, out).transpose();
        count += 1;
    };
    let mut middle = 0.5;
    while middle < pieces {
        push(start + middle * piece, out);
        middle += 1.0;
    }
    if !full {
        push(angle.min, 1.0);
        push(angle.max, 1.0);
    }
    (corners, count)
}

/// The rotation about an axis of length 1, which takes what is across the axis further out.
fn rotation(axis: DVec3, degrees: f64, out: f64) -> DMat3 {
    let Some(Transform::Rotate { sin, cos, .. }) = TransformKind::RotZ.evaluate(&[degrees]) else {
        unreachable!("every finite angle is a rotation")
    };
    let (sin, cos) = (out * sin, out * cos);
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}
