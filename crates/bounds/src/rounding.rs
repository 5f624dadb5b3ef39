//! How far the boxes must be rounded outward so that they enclose the solid in exact arithmetic.
//!
//! The solid is what its maps make of its shapes, where the maps are those that the `f64` numbers in them define. A
//! computed image of a point misses the exact one by a rounding error, which the maps further up enlarge. The rule that
//! follows the error up a transform chain: let a point p be off by at most the distance e, and let the map be
//! x ↦ M x + t, whose linear part enlarges distances at most σ times. The image is then off by at most
//!
//! > σ e + c (σ √3 |p| + |t|), c = 16 ε
//!
//! where |·| is the largest coordinate, and the second part is the rounding of the map's own evaluation. [`Map`]
//! promises half of it: its 4 ε in every coordinate are 4 √3 ε of distance, and its ‖M‖ is at most √3 σ. The other half
//! covers the rounding of this rule itself and of adding the margin to the box. The margin is thus some ulps of the
//! magnitudes that were met on the way, each enlarged as the chain enlarges it: 10⁻¹⁴ of the box where nothing cancels,
//! and as much as it has to be where something does. Distances and not coordinates, because turning does not enlarge
//! them: errors would double with every second turn by 45°.
//!
//! **Products.** A chain may also be one matrix, the computed product of its maps. That drifts away from the exact
//! product, by δ in what it does to distances and by τ in where it puts the origin. A product of two matrices errs by at
//! most 9 ε times the product of their enlargements, so for the map (M, t) after the chain (M′, t′)
//!
//! > δ″ = σ δ′ + δ (σ′ + δ′) + c σ σ′, τ″ = σ τ′ + δ √3 |t′| + τ + c (σ √3 |t′| + |t|)
//!
//! and the image of a point is off by √3 δ |p| + τ more than by the rule above.

use glam::DAffine3;

/// c of the rule above: twice what [`Map::point`](crate::Map::point) may err.
pub(crate) const EVALUATION: f64 = 16.0 * f64::EPSILON;

/// Coordinates beyond this may overflow within the evaluation of a map.
pub(crate) const LARGEST: f64 = 1e300;

/// The length of a diagonal of the unit cube, rounded up.
const DIAGONAL: f64 = 1.732_050_807_568_878;

/// What a map, or a chain of maps as one matrix, does to errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rounding {
    /// σ: how much it enlarges a distance at most, rounded up; δ included.
    gain: f64,
    /// |t|: the largest coordinate of the image of the origin.
    offset: f64,
    /// c, or nothing for a map that is not even evaluated.
    evaluation: f64,
    /// δ and τ: how far it is from what it stands for.
    linear_drift: f64,
    offset_drift: f64,
}

impl Rounding {
    /// Of no map at all.
    pub(crate) const NONE: Self =
        Self { gain: 1.0, offset: 0.0, evaluation: 0.0, linear_drift: 0.0, offset_drift: 0.0 };

    /// Of a map that changes nothing, evaluated.
    pub(crate) const ONE: Self = Self { evaluation: EVALUATION, ..Self::NONE };

    /// Of one map.
    pub(crate) fn of(affine: &DAffine3) -> Self {
        let m = affine.matrix3;
        // σ² is the largest eigenvalue of MᵀM, hence at most its largest sum of absolute values in a row: all of it
        // where the axes that M scales along are those of the frame below, however it turns them.
        let square = m.transpose() * m;
        let row_sums = square.x_axis.abs() + square.y_axis.abs() + square.z_axis.abs();
        // Squares may underflow: at most so much of σ is lost.
        let gain = row_sums.max_element().sqrt() * (1.0 + EVALUATION) + 1e-150;
        let offset = affine.translation.abs().max_element();
        let [gain, offset] = if affine.is_finite() { [gain, offset] } else { [f64::INFINITY; 2] };
        Self { gain, offset, ..Self::ONE }
    }

    /// Of a computed product: that of `outer` and `inner`, which is applied first.
    pub(crate) fn of_product(product: &DAffine3, outer: Self, inner: Self) -> Self {
        let rounded = Self::of(product);
        let linear_drift = outer.gain * inner.linear_drift
            + outer.linear_drift * inner.gain
            + EVALUATION * outer.gain * inner.gain;
        let reach = DIAGONAL * inner.offset;
        let offset_drift = outer.gain * inner.offset_drift
            + outer.linear_drift * reach
            + outer.offset_drift
            + EVALUATION * (outer.gain * reach + outer.offset);
        let gain = (rounded.gain + linear_drift) * (1.0 + EVALUATION);
        Self { gain, linear_drift, offset_drift, ..rounded }
    }

    /// How much it enlarges a distance at most.
    pub(crate) fn gain(&self) -> f64 {
        self.gain
    }

    /// How far its linear part and its offset are from those of what it stands for: δ and τ.
    pub(crate) fn drift(&self) -> [f64; 2] {
        [self.linear_drift, self.offset_drift]
    }

    /// How far the image of a point is off that has no coordinate above `magnitude` and is itself off by at most
    /// `error`. Infinite if the evaluation may overflow.
    pub(crate) fn error_above(&self, magnitude: f64, error: f64) -> f64 {
        let distance = DIAGONAL * magnitude;
        let reach = self.gain * distance + self.offset;
        if reach < LARGEST {
            let drift = self.linear_drift * distance + self.offset_drift;
            // The smallest normal number stands for underflow, which errs absolutely.
            self.gain * error + self.evaluation * reach + drift + f64::MIN_POSITIVE
        } else {
            f64::INFINITY
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "infinity is exact")]
mod tests {
    use glam::{DAffine3, DMat3, DVec3};

    use super::*;

    #[test]
    fn cancellation_is_paid_for() {
        // There and back leaves 1e-8 of error at a magnitude of 1, and enlarging shows it.
        let there = Rounding::of(&DAffine3::from_translation(DVec3::splat(1e6)));
        let back = Rounding::of(&DAffine3::from_translation(DVec3::splat(-1e6)));
        let enlarge = Rounding::of(&DAffine3::from_scale(DVec3::splat(1e6)));
        let error = there.error_above(1.0, 0.0);
        let error = back.error_above(1e6, error);
        let error = enlarge.error_above(1.0, error);
        assert!(error > 1e-4 && error < 1e-1, "{error}");
    }

    #[test]
    fn a_contraction_forgets_errors() {
        let half = Rounding::of(&DAffine3::from_scale(DVec3::splat(0.5)));
        let error = (0..1000).fold(0.0, |error, _| half.error_above(1.0, error));
        assert!(error < 1e-14, "{error}");
    }

    #[test]
    fn turning_does_not_enlarge_errors() {
        let turned = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7);
        let error = (0..100).fold(1e-10, |error, _| Rounding::of(&turned).error_above(1.0, error));
        assert!(error < 1.1e-10, "{error}");
        let mut chain = (turned, Rounding::of(&turned));
        for _ in 0..100 {
            let product = turned * chain.0;
            chain = (product, Rounding::of_product(&product, Rounding::of(&turned), chain.1));
        }
        assert!(chain.1.error_above(1.0, 1e-10) < 1.1e-10, "{chain:?}");
    }

    /// Maps that are as far from what they stand for as they may be, all in one direction: nothing of the rule can be left out.
    #[test]
    fn a_product_drifts_as_far_as_its_maps_together() {
        /// A map, what it stands for, and how far that is.
        fn drifting(scale: f64, offset: f64, [linear, moved]: [f64; 2]) -> (DAffine3, DAffine3, Rounding) {
            let affine = DAffine3 {
                matrix3: DMat3::from_diagonal(DVec3::splat(scale)),
                translation: DVec3::splat(offset),
            };
            let meant = DAffine3 {
                matrix3: affine.matrix3 * (1.0 + linear),
                translation: affine.translation + moved / DIAGONAL,
            };
            let drift =
                Rounding { linear_drift: scale * linear, offset_drift: moved, ..Rounding::of(&affine) };
            (affine, meant, Rounding { gain: scale * (1.0 + linear), ..drift })
        }
        let point = DVec3::splat(11.0);
        let drifts = [[0.0, 0.0], [1e-3, 0.0], [0.0, 0.1], [1e-3, 0.1]];
        for (outer, inner) in drifts.iter().flat_map(|outer| drifts.iter().map(move |inner| (outer, inner))) {
            let (outer, outer_meant, outer_rounding) = drifting(3.0, 5.0, *outer);
            let (inner, inner_meant, inner_rounding) = drifting(0.5, 70.0, *inner);
            let (product, meant) = (outer * inner, outer_meant * inner_meant);
            let rounding = Rounding::of_product(&product, outer_rounding, inner_rounding);
            let off = meant.transform_point3(point).distance(product.transform_point3(point));
            let bound = rounding.error_above(11.0, 0.0);
            assert!(off <= bound && bound <= 1.001 * off + 1e-9, "{off} {bound} {rounding:?}");
            assert!(rounding.gain() >= meant.matrix3.x_axis.x, "{rounding:?}");
        }
    }

    #[test]
    fn overflow_has_no_bound() {
        let huge = Rounding::of(&DAffine3::from_scale(DVec3::splat(1e200)));
        assert_eq!(huge.error_above(1e200, 0.0), f64::INFINITY);
        assert_eq!(huge.error_above(1.0, f64::INFINITY), f64::INFINITY);
    }
}
