//! Envelopes under transformations whose arguments are intervals.
//!
//! The image of a solid with support h under x ↦ A x + t has the support t·d + h(Aᵀd). Where the arguments vary, Aᵀd is any
//! vector of a set, and since h is convex it is nowhere larger on that set than at the corners of a polytope about it:
//!
//! - entries in intervals of their own (scale, shear, matrix) make each coordinate of Aᵀd an interval: a box;
//! - one factor for all coordinates makes a segment;
//! - an angle makes an arc. It is cut into pieces, and the tangents at their ends meet in a polygon about it, whose corners
//!   are the middles of the pieces, further out by the cosine of half a piece.
//!
//! Every corner goes through a whole chain of transformations before an envelope is asked, as points do in [TRAX95] §3: the
//! looseness of the envelope enters once for the chain, and not with each of its links.

use csg_graph::{Interval, Transform, TransformKind};
use glam::{DMat3, DVec3};

use super::body::{Body, ROUNDING};
use super::straight::Straight;
use crate::Aabb;
use crate::rounding::Rounding;

/// The most degrees of a piece of an arc: its corner is 1.5 % further out than it is.
const PIECE: f64 = 20.0;

/// More than the entries of a rotation err, with the angles at the corners.
const TURNED: f64 = 128.0 * f64::EPSILON;

/// Angles beyond this are any.
const FAR: f64 = 720.0;

/// All maps x ↦ A x + t that a transformation may be.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapRange {
    linear: Linear,
    offset: [Interval; 3],
    /// The most that any of them enlarges a distance.
    gain: f64,
    /// What A does to boxes, if they stay boxes.
    straight: Option<Straight>,
}

/// What A may be.
#[derive(Clone, Debug, PartialEq)]
enum Linear {
    Identity,
    One(DMat3),
    /// A multiple of the identity.
    Factor(Interval),
    /// Anything in the hull of these, but for rounding.
    Turns(Vec<DMat3>),
    /// By rows, each entry in its own interval.
    Entries([[Interval; 3]; 3]),
}

const ZERO: Interval = Interval::point(0.0);
const ONE: Interval = Interval::point(1.0);

impl MapRange {
    /// The transformations of a kind for arguments in these intervals. `None` if there is none.
    pub(super) fn new(kind: TransformKind, args: &[Interval]) -> Option<Self> {
        if args.iter().any(|arg| arg.is_empty()) {
            return None;
        }
        let points: Option<Vec<f64>> = args.iter().map(|arg| arg.value()).collect();
        if let Some(points) = points {
            return kind.evaluate(&points).map(|map| Self::one(&map));
        }
        Some(match kind {
            TransformKind::Move => Self::moves([args[0], args[1], args[2]]),
            TransformKind::UScale => Self::linear(Linear::Factor(args[0]), size(args[0])),
            TransformKind::Scale => Self::linear(
                Linear::Entries([[args[0], ZERO, ZERO], [ZERO, args[1], ZERO], [ZERO, ZERO, args[2]]]),
                args.iter().copied().map(size).fold(0.0, f64::max),
            ),
            TransformKind::RotX => Self::turns(DVec3::X, args[0]),
            TransformKind::RotY => Self::turns(DVec3::Y, args[0]),
            TransformKind::RotZ => Self::turns(DVec3::Z, args[0]),
            TransformKind::Rot => match [args[0].value(), args[1].value(), args[2].value()] {
                [Some(x), Some(y), Some(z)] => {
                    let axis = DVec3::new(x, y, z);
                    Self::turns((axis / axis.abs().max_element()).try_normalize()?, args[3])
                }
                // Whatever the axis and the angle, no entry of a rotation is beyond 1.
                _ => Self::linear(
                    Linear::Entries([[Interval::new(-1.0 - TURNED, 1.0 + TURNED); 3]; 3]),
                    1.0 + TURNED,
                ),
            },
            TransformKind::Shear => {
                Self::entries([[ONE, args[0], args[1]], [args[2], ONE, args[3]], [args[4], args[5], ONE]])
            }
            TransformKind::Matrix => Self {
                offset: [args[3], args[7], args[11]],
                ..Self::entries([0, 4, 8].map(|row| [args[row], args[row + 1], args[row + 2]]))
            },
            // A transformation that this version does not know may do anything.
            _ => Self { offset: [Interval::ALL; 3], ..Self::entries([[Interval::ALL; 3]; 3]) },
        })
    }

    /// x ↦ A x, which enlarges no distance more than that.
    fn linear(linear: Linear, gain: f64) -> Self {
        let straight = match &linear {
            Linear::Identity => Some(Straight::IDENTITY),
            Linear::One(matrix) => {
                Straight::new([0, 1, 2].map(|row| matrix.row(row).to_array().map(Interval::point)))
            }
            Linear::Factor(factor) => Some(Straight::scaled([*factor; 3])),
            Linear::Turns(_) => None,
            Linear::Entries(rows) => Straight::new(*rows),
        };
        Self { linear, offset: [ZERO; 3], gain, straight }
    }

    fn moves(offset: [Interval; 3]) -> Self {
        Self { offset, ..Self::linear(Linear::Identity, 1.0) }
    }

    fn one(map: &Transform) -> Self {
        let affine = map.to_affine();
        let offset = affine.translation.to_array().map(Interval::point);
        match map {
            Transform::Translate(_) => Self::moves(offset),
            _ => Self { offset, ..Self::linear(Linear::One(affine.matrix3), Rounding::of(&affine).gain()) },
        }
    }

    fn turns(axis: DVec3, angle: Interval) -> Self {
        Self::linear(Linear::Turns(about_arc(axis, angle)), 1.0 + TURNED)
    }

    /// The gain is at most the root of the sum of the squares of the entries.
    fn entries(rows: [[Interval; 3]; 3]) -> Self {
        let squares: f64 = rows.iter().flatten().map(|entry| size(*entry) * size(*entry)).sum();
        Self::linear(Linear::Entries(rows), squares.sqrt() * (1.0 + ROUNDING))
    }

    /// Whether the images of boxes are boxes.
    pub(super) fn is_straight(&self) -> bool {
        self.straight.is_some()
    }

    /// A box about all images of what is in another, if the images of boxes are boxes.
    pub(super) fn image_of_box(&self, below: &Aabb) -> Option<Aabb> {
        self.straight.as_ref().map(|straight| straight.image(&self.offset, below))
    }

    /// How many directions come of one, at most.
    pub(super) fn corner_count(&self) -> usize {
        match &self.linear {
            Linear::Identity | Linear::One(_) => 1,
            Linear::Factor(_) => 2,
            Linear::Turns(turns) => turns.len(),
            Linear::Entries(rows) => {
                let varies = |column: &usize| rows.iter().any(|row| row[*column].value().is_none());
                1 << (0..3).filter(varies).count()
            }
        }
    }

    /// Calls `see` with the corners of a polytope about all Aᵀd, and with what their coordinates err, for all d that differ
    /// from `d` by at most `error` in each coordinate.
    fn corners(&self, d: DVec3, error: DVec3, mut see: impl FnMut(DVec3, DVec3)) {
        match &self.linear {
            Linear::Identity => see(d, error),
            Linear::One(matrix) => {
                let q = matrix.transpose() * d;
                see(q, rounding(matrix, d, q) + matrix.abs().transpose() * error);
            }
            Linear::Factor(factor) => {
                for factor in [factor.min, factor.max] {
                    let q = factor * d;
                    // A single coordinate errs by a factor, and that is the support's to round.
                    let single = d.abs().element_sum() <= d.abs().max_element();
                    let rounding = if single { DVec3::ZERO } else { q.abs() * f64::EPSILON };
                    see(q, rounding + factor.abs() * error);
                }
            }
            Linear::Turns(turns) => {
                let error = DVec3::splat(TURNED * d.length() + 2.0 * error.length());
                turns.iter().for_each(|matrix| see(matrix.transpose() * d, error));
            }
            Linear::Entries(rows) => box_corners(rows, d, error, see),
        }
    }

    /// The largest t·d and the largest −t·d.
    fn shifts(&self, d: DVec3, error: DVec3) -> [f64; 2] {
        let (mut least, mut most, mut sizes) = (0.0, 0.0, 0.0);
        for axis in 0..3 {
            let (d, t) = (d[axis], self.offset[axis]);
            // 0 · ∞ is no way to go.
            if d != 0.0 {
                let [a, b] = [d * t.min, d * t.max];
                least += a.min(b);
                most += a.max(b);
                sizes += d.abs() * size(t);
            }
            if error[axis] > 0.0 {
                sizes += error[axis] / ROUNDING * size(t);
            }
        }
        // Nothing is not rounded; an infinite size is not worth a difference.
        let rounding = if sizes > 0.0 { sizes * ROUNDING } else { 0.0 };
        [most + rounding, rounding - least]
    }

    /// The farthest that any t is from the origin.
    fn reach(&self) -> f64 {
        let [x, y, z] = self.offset.map(size);
        DVec3::new(x, y, z).length() * (1.0 + ROUNDING)
    }
}

/// A chain of maps, the outermost first.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain<'a> {
    maps: Vec<&'a MapRange>,
    corners: usize,
}

impl<'a> Chain<'a> {
    /// The most directions that a chain makes of one, and the most maps in it.
    const CORNERS: usize = 100;
    const MAPS: usize = 8;

    /// Appends a map below, unless the chain has become too expensive.
    pub(super) fn push(&mut self, map: &'a MapRange) -> bool {
        let longer = Self::longer([self.maps.len(), self.corners], map);
        if let Some([_, corners]) = longer {
            self.maps.push(map);
            self.corners = corners;
        }
        longer.is_some()
    }

    /// The number of maps and that of directions with one map more; `None` if that is too expensive.
    pub(super) fn longer([maps, corners]: [usize; 2], map: &MapRange) -> Option<[usize; 2]> {
        let corners = corners.max(1) * map.corner_count();
        let fits = maps == 0 || corners <= Self::CORNERS && maps < Self::MAPS;
        fits.then_some([maps + 1, corners])
    }

    /// An envelope about all images of what is in another.
    pub(super) fn image(&self, below: &Body) -> Body {
        image(&self.maps, below)
    }
}

/// An envelope about all images of what is in another, under a chain of maps, the outermost first.
pub(super) fn image(maps: &[&MapRange], below: &Body) -> Body {
    if below.is_empty() {
        return Body::EMPTY;
    }
    Body::new(|d| supports(maps, below, d, DVec3::ZERO), radius(maps, below))
}

/// The box of that envelope.
pub(super) fn image_box(maps: &[&MapRange], below: &Body) -> Aabb {
    if below.is_empty() {
        return Aabb::EMPTY;
    }
    let radius = radius(maps, below);
    let [mut min, mut max] = [DVec3::splat(-radius), DVec3::splat(radius)];
    for (axis, direction) in DVec3::AXES.into_iter().enumerate() {
        let [there, back] = supports(maps, below, direction, DVec3::ZERO);
        max[axis] = max[axis].min(there);
        min[axis] = min[axis].max(-back);
    }
    Aabb::new(min, max)
}

/// How far any image of what is in another is from the origin.
fn radius(maps: &[&MapRange], below: &Body) -> f64 {
    let radius = maps.iter().rev().fold(below.radius, |radius, map| {
        let radius = if radius > 0.0 { radius * map.gain } else { 0.0 };
        (radius + map.reach()) * (1.0 + ROUNDING)
    });
    if radius.is_nan() { f64::INFINITY } else { radius }
}

/// The supports of the image under a chain in opposite directions. The length of a chain is bounded.
fn supports(maps: &[&MapRange], below: &Body, d: DVec3, error: DVec3) -> [f64; 2] {
    let Some((map, rest)) = maps.split_first() else { return below.supports(d, error) };
    let shifts = map.shifts(d, error);
    let mut farthest = [f64::NEG_INFINITY; 2];
    // The corners in the opposite direction are opposite.
    map.corners(d, error, |q, error| {
        let [there, back] = supports(rest, below, q, error);
        farthest = [farthest[0].max(there), farthest[1].max(back)];
    });
    [0, 1].map(|side| {
        let (shift, farthest) = (shifts[side], farthest[side]);
        let above = shift + farthest + (shift.abs() + farthest.abs()) * f64::EPSILON;
        if above.is_nan() { f64::INFINITY } else { above }
    })
}

/// The largest absolute value.
fn size(interval: Interval) -> f64 {
    interval.min.abs().max(interval.max.abs())
}

/// What the coordinates of q = Aᵀd err. Where all is a single product it errs by a factor, and that is the support's to round.
fn rounding(matrix: &DMat3, d: DVec3, q: DVec3) -> DVec3 {
    let sizes = matrix.abs().transpose() * d.abs();
    let single = sizes.element_sum() <= q.abs().max_element();
    if single { DVec3::ZERO } else { sizes * (4.0 * f64::EPSILON) }
}

/// The corners of the box of all Aᵀd, for the rows of A in intervals.
fn box_corners(rows: &[[Interval; 3]; 3], d: DVec3, error: DVec3, mut see: impl FnMut(DVec3, DVec3)) {
    let (mut least, mut most, mut sizes, mut errors) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    let mut terms = 0;
    for column in 0..3 {
        for row in 0..3 {
            let (entry, d) = (rows[row][column], d[row]);
            let size = size(entry);
            if size > 0.0 {
                errors[column] += size * error[row];
            }
            if d != 0.0 && size > 0.0 {
                let [a, b] = [d * entry.min, d * entry.max];
                least[column] += a.min(b);
                most[column] += a.max(b);
                sizes[column] += size * d.abs();
                terms += 1;
            }
        }
    }
    if terms > 1 {
        errors += sizes * (4.0 * f64::EPSILON);
    }
    for corner in 0..8_u8 {
        let upper = [corner & 1, corner & 2, corner & 4].map(|bit| bit != 0);
        // Where both are one corner, once is enough.
        if (0..3).any(|axis| upper[axis] && least[axis] >= most[axis]) {
            continue;
        }
        let pick = |axis: usize| if upper[axis] { most[axis] } else { least[axis] };
        see(DVec3::new(pick(0), pick(1), pick(2)), errors);
    }
}

/// The matrices at the corners of a polygon about an arc of rotations.
fn about_arc(axis: DVec3, angle: Interval) -> Vec<DMat3> {
    let span = angle.max - angle.min;
    let any = span.is_nan() || span >= 360.0 - PIECE || size(angle) > FAR;
    let (start, span) = if any { (0.0, 360.0) } else { (angle.min, span) };
    let pieces = (span / PIECE).ceil().max(1.0);
    let piece = span / pieces;
    let out = rotation(DVec3::Z, 0.5 * piece, 1.0).x_axis.x.recip();
    let mut corners = Vec::new();
    let mut middle = 0.5;
    while middle < pieces {
        corners.push(rotation(axis, start + middle * piece, out));
        middle += 1.0;
    }
    if !any {
        corners.extend([angle.min, angle.max].map(|end| rotation(axis, end, 1.0)));
    }
    corners
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
