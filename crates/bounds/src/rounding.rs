//! How far the boxes must be rounded outward so that they enclose the solid in exact arithmetic.
//!
//! The solid is what its maps make of its shapes, where the maps are those that the `f64` numbers in them define. A
//! computed image of a point misses the exact one by a rounding error, which the maps further up enlarge. The rule that
//! follows the error up a transform chain: let a point p be off by at most e in every coordinate, and let the map be
//! x ↦ M x + t, whose linear part enlarges the largest coordinate of anything at most ‖M‖ times. The image is then off
//! by at most
//!
//! > ‖M‖ e + c (‖M‖ |p| + |t|), c = 8 ε
//!
//! where the second part is the rounding of the map's own evaluation. [`Map`] promises half of it; the other half
//! covers the rounding of this rule itself and of adding the margin to the box. The margin is thus some ulps of the
//! magnitudes that were met on the way, each enlarged as the chain enlarges it: 10⁻¹⁴ of the box where nothing cancels,
//! and as much as it has to be where something does.

use glam::DVec3;

use crate::scene::Map;

/// c of the rule above: twice what [`Map::point`] may err.
const EVALUATION: f64 = 8.0 * f64::EPSILON;

/// Coordinates beyond this may overflow within the evaluation of a map.
const LARGEST: f64 = 1e300;

/// What a map does to errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// ‖M‖, the largest sum of absolute values in a row, rounded up.
    gain: f64,
    /// |t|, the largest coordinate of the image of the origin.
    offset: f64,
}

impl Rounding {
    /// Probes a map at the origin and at the end of each axis.
    pub(crate) fn of<M: Map>(map: &M) -> Self {
        let origin = map.point(DVec3::ZERO);
        let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| map.point(axis) - origin);
        if !(origin.is_finite() && columns.iter().all(|column| column.is_finite())) {
            return Self { gain: f64::INFINITY, offset: f64::INFINITY };
        }
        let row_sums = columns[0].abs() + columns[1].abs() + columns[2].abs();
        let (gain, offset) = (row_sums.max_element(), origin.abs().max_element());
        // Each of the three columns is off by two evaluations at points of magnitude 1.
        Self { gain: gain + 6.0 * EVALUATION * (gain + offset), offset }
    }

    /// How far the image of a point is off that has no coordinate above `magnitude` and is itself off by at most
    /// `error`. Infinite if the evaluation may overflow.
    pub(crate) fn error_above(&self, magnitude: f64, error: f64) -> f64 {
        let reach = self.gain * magnitude + self.offset;
        if reach < LARGEST {
            // The smallest normal number stands for underflow, which errs absolutely.
            self.gain * error + EVALUATION * reach + f64::MIN_POSITIVE
        } else {
            f64::INFINITY
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "infinity is exact")]
mod tests {
    use glam::DAffine3;

    use super::*;

    #[test]
    fn cancellation_is_paid_for() {
        // There and back leaves 1e-10 of error at a magnitude of 1, and enlarging shows it.
        let there = Rounding::of(&DAffine3::from_translation(DVec3::splat(1e6)));
        let back = Rounding::of(&DAffine3::from_translation(DVec3::splat(-1e6)));
        let enlarge = Rounding::of(&DAffine3::from_scale(DVec3::splat(1e6)));
        let error = there.error_above(1.0, 0.0);
        let error = back.error_above(1e6, error);
        let error = enlarge.error_above(1.0, error);
        assert!(error > 1e-4 && error < 1e-2, "{error}");
    }

    #[test]
    fn a_contraction_forgets_errors() {
        let half = Rounding::of(&DAffine3::from_scale(DVec3::splat(0.5)));
        let error = (0..1000).fold(0.0, |error, _| half.error_above(1.0, error));
        assert!(error < 1e-14, "{error}");
    }

    #[test]
    fn overflow_has_no_bound() {
        let huge = Rounding::of(&DAffine3::from_scale(DVec3::splat(1e200)));
        assert_eq!(huge.error_above(1e200, 0.0), f64::INFINITY);
        assert_eq!(huge.error_above(1.0, f64::INFINITY), f64::INFINITY);
    }
}
