//! Points on their way up a chain of transformations, in twice the precision of the boxes that must hold them.
//!
//! All points of a cloud go the same way, and are kept coordinate by coordinate, so that a map is one loop.
//!
//! **Error.** The points are off by rounding too, and by how much follows from the rule of the crate's module
//! `rounding`, with 2⁻⁹⁸ for its c: under a map x ↦ M x + t of enlargement σ, e becomes σ e + c (σ √3 |p| + |t|). It is
//! the same rule that decides how far boxes are rounded outward, so that this error is less than 2⁻⁴⁰ of that rounding,
//! however long and ill-conditioned a chain is. A point that is further out of a box than its error has escaped.

use csg_graph::Transform;
use glam::{DAffine3, DVec3};

use super::double::{Double, PRECISION, two_product, two_sum};

/// A point in twice the precision.
pub(crate) type Point = [Double; 3];

/// Points that are mapped together.
#[derive(Default)]
pub(crate) struct Cloud {
    high: [Vec<f64>; 3],
    low: [Vec<f64>; 3],
    /// How far each may be from where it should be.
    pub(crate) error: f64,
}

impl Cloud {
    /// The points of a surface, each made of numbers up to `magnitude`.
    pub(crate) fn refill(&mut self, points: &[Point], magnitude: f64) {
        for axis in 0..3 {
            self.high[axis].clear();
            self.low[axis].clear();
            self.high[axis].extend(points.iter().map(|point| point[axis].high));
            self.low[axis].extend(points.iter().map(|point| point[axis].low));
        }
        self.error = PRECISION * magnitude;
    }

    pub(crate) fn len(&self) -> usize {
        self.high[0].len()
    }

    pub(crate) fn point(&self, i: usize) -> Point {
        [0, 1, 2].map(|axis| Double { high: self.high[axis][i], low: self.low[axis][i] })
    }

    /// A point, rounded.
    pub(crate) fn rounded(&self, i: usize) -> DVec3 {
        DVec3::new(self.high[0][i], self.high[1][i], self.high[2][i])
    }

    /// The least and the largest of one coordinate, rounded.
    pub(crate) fn range(&self, axis: usize) -> [f64; 2] {
        let numbers = self.high[axis].iter();
        numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], &x| [min.min(x), max.max(x)])
    }

    /// The largest coordinate in absolute value.
    pub(crate) fn magnitude(&self) -> f64 {
        (0..3).flat_map(|axis| self.range(axis)).fold(0.0, |magnitude, x| magnitude.max(x.abs()))
    }

    /// Keeps the points that `keep` says, given their place.
    pub(crate) fn retain(&mut self, mut keep: impl FnMut(&Self, usize) -> bool) {
        let mut kept = 0;
        for i in 0..self.len() {
            if keep(self, i) {
                for axis in 0..3 {
                    self.high[axis][kept] = self.high[axis][i];
                    self.low[axis][kept] = self.low[axis][i];
                }
                kept += 1;
            }
        }
        for axis in 0..3 {
            self.high[axis].truncate(kept);
            self.low[axis].truncate(kept);
        }
    }

    /// Maps all points into the frame above.
    pub(crate) fn map(&mut self, parent_from_child: &Transform) {
        let affine = parent_from_child.to_affine();
        let reach = 3_f64.sqrt() * self.magnitude();
        let enlargement = enlargement(&affine);
        let offset = affine.translation.abs().max_element();
        self.error = enlargement * self.error + PRECISION * (enlargement * reach + offset);
        match *parent_from_child {
            Transform::Translate(offset) => {
                for axis in 0..3 {
                    for (high, low) in self.high[axis].iter_mut().zip(&mut self.low[axis]) {
                        let (sum, lost) = two_sum(*high, offset[axis]);
                        (*high, *low) = two_sum(sum, lost + *low);
                    }
                }
            }
            Transform::Scale(factors) => {
                for axis in 0..3 {
                    for (high, low) in self.high[axis].iter_mut().zip(&mut self.low[axis]) {
                        let (product, lost) = two_product(*high, factors[axis]);
                        (*high, *low) = two_sum(product, lost + *low * factors[axis]);
                    }
                }
            }
            _ => self.affine(&affine),
        }
    }

    fn affine(&mut self, affine: &DAffine3) {
        let rows = affine.matrix3.transpose();
        let rows = [0, 1, 2].map(|axis| (rows.col(axis).to_array(), affine.translation[axis]));
        let [x, y, z] = &mut self.high;
        let [x_low, y_low, z_low] = &mut self.low;
        let points = x.iter_mut().zip(y).zip(z).zip(x_low).zip(y_low).zip(z_low);
        for (((((x, y), z), x_low), y_low), z_low) in points {
            let (high, low) = ([*x, *y, *z], [*x_low, *y_low, *z_low]);
            [(*x, *x_low), (*y, *y_low), (*z, *z_low)] =
                rows.map(|(row, offset)| product(row, offset, high, low));
        }
    }
}

/// row · (high + low) + offset.
#[inline(always)]
fn product(row: [f64; 3], offset: f64, high: [f64; 3], low: [f64; 3]) -> (f64, f64) {
    let (mut sum, mut rest) = (offset, 0.0);
    for i in 0..3 {
        let (term, lost) = two_product(row[i], high[i]);
        let (next, carry) = two_sum(sum, term);
        rest += (lost + row[i] * low[i]) + carry;
        sum = next;
    }
    two_sum(sum, rest)
}

/// How much a map enlarges a distance at most: σ² is the largest eigenvalue of MᵀM, hence at most its largest sum of
/// absolute values in a row.
fn enlargement(affine: &DAffine3) -> f64 {
    let m = affine.matrix3;
    let square = m.transpose() * m;
    let row_sums = square.x_axis.abs() + square.y_axis.abs() + square.z_axis.abs();
    row_sums.max_element().sqrt() * (1.0 + 1e-12)
}

/// direction · point.
pub(crate) fn along(direction: DVec3, point: &Point) -> Double {
    let terms = [0, 1, 2].map(|axis| point[axis] * direction[axis]);
    terms[0] + terms[1] + terms[2]
}
