//! Norms in which maps that shrink in the long run shrink at once.
//!
//! A map may enlarge some distances each time and shrink all of them in the end: a shear that also halves, or a stretch
//! along x that a stretch along y undoes on the way back. The Euclidean norm does not see it. The norm ‖x‖ = |W x| with a
//! regular matrix W may, and each frame has its own: its unit ball is the ellipsoid V·(ball), V = W⁻¹. A map M from the
//! frame t into the frame s then enlarges at most |Wₛ M Vₜ| times.
//!
//! **Finding them.** If ‖M x‖ₛ ≤ λ ‖x‖ₜ fails for some x, the norm of t is replaced by the least ellipsoidal one, with the
//! axes of this map, that is nowhere less and mends it: in coordinates where the norm of t is Euclidean, that is a
//! stretch along the principal axes of N = Wₛ M Vₜ by σ/λ where their singular values σ are above λ. Going round
//! until nothing changes is the value iteration of a joint spectral radius with quadratic norms. It need not end; when it
//! does, all maps shrink by λ.
//!
//! That does not come to an end where a map leads back into its own frame: what mends the one end spoils the other. But for the
//! maps of one round there is a formula. If Pₜ = I + Mᵀ Pₛ M / λ² for each map M from t into s, then the norms ‖x‖² = xᵀ P x
//! shrink by λ with each of them: P sums up what becomes of x in all rounds to come, as Lyapunov's functions do.
//!
//! **Trusting them.** V is what defines a norm, as the `f64` numbers in it. What is computed from it is bounded from
//! above, with all rounding; how V was found plays no part.

use glam::{DMat3, DVec3};

use crate::rounding::EVALUATION;

/// A norm of a frame.
#[derive(Clone, Copy)]
pub(super) struct Norm {
    /// What takes the Euclidean unit ball to that of the norm. This one is exact.
    ball: DMat3,
    /// About its inverse.
    inverse: DMat3,
    /// By how much more the exact inverse may enlarge.
    slack: f64,
}

impl Norm {
    pub(super) const EUCLIDEAN: Self = Self { ball: DMat3::IDENTITY, inverse: DMat3::IDENTITY, slack: 1.0 };

    /// How many times longer than in this norm a vector may be in the Euclidean one, at most.
    pub(super) fn euclidean(&self) -> f64 {
        spectral_norm_above(&self.ball)
    }

    /// How many times longer in this norm than in the Euclidean one, at most.
    pub(super) fn of_euclidean(&self) -> f64 {
        self.slack * spectral_norm_above(&self.inverse)
    }

    /// How many times longer a vector gets in this norm by a map than it was in the norm `below`, at most.
    pub(super) fn enlargement(&self, map: &DMat3, below: &Self) -> f64 {
        let rounding = EVALUATION * frobenius(&self.inverse) * frobenius(map) * frobenius(&below.ball);
        self.slack * (spectral_norm_above(&self.seen(map, below)) + rounding)
    }

    /// The largest coordinates of what is at most 1 long.
    pub(super) fn extents(&self) -> DVec3 {
        let rows = self.ball.transpose();
        DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()) * (1.0 + EVALUATION)
    }

    /// A map between two frames, in coordinates where their norms are Euclidean.
    fn seen(&self, map: &DMat3, below: &Self) -> DMat3 {
        self.inverse * *map * below.ball
    }

    /// Enlarges this norm until a map from its frame shrinks by `factor` into a frame with the norm `above`. `None` if it
    /// does so already.
    pub(super) fn mended(&self, map: &DMat3, above: &Self, factor: f64) -> Option<Self> {
        let seen = above.seen(map, self);
        let (axes, squares) = principal_axes(seen.transpose() * seen);
        let stretch = |square: f64| (square.sqrt() / factor).max(1.0);
        let stretch = DVec3::new(stretch(squares.x), stretch(squares.y), stretch(squares.z));
        // A little more, so that rounding does not ask for it again and again.
        let stretch = stretch * (1.0 + 1e-9);
        if stretch.max_element() <= 1.0 + 2e-9 {
            return None;
        }
        let ball = self.ball * axes * DMat3::from_diagonal(stretch.recip());
        let inverse = DMat3::from_diagonal(stretch) * axes.transpose() * self.inverse;
        Some(Self { ball, inverse, slack: f64::INFINITY })
    }

    /// Norms of the frames on a round of maps, each from the frame of the next one into its own, in which every map shrinks by
    /// `factor`. The round has to shrink by more in the long run than by that for each of its maps. `None` if numbers do not
    /// suffice.
    pub(super) fn of_round(maps: &[DMat3], factor: f64) -> Option<Vec<Self>> {
        /// How often the number of rounds that are summed up is doubled.
        const DOUBLINGS: usize = 40;
        let maps: Vec<DMat3> = maps.iter().map(|map| *map * factor.recip()).collect();
        let square = |map: DMat3| map.transpose() * map;
        // The parts of one round in P of the first frame, and then of two, of four, ….
        let (mut sum, mut round) = (DMat3::IDENTITY, DMat3::IDENTITY);
        for (number, map) in maps.iter().enumerate().rev() {
            round = *map * round;
            if number > 0 {
                sum += square(round);
            }
        }
        for _ in 0..DOUBLINGS {
            sum += round.transpose() * sum * round;
            round = round * round;
        }
        let mut squares = sum;
        let norms = maps.iter().map(|map| {
            let norm = Self::of_squares(squares);
            squares = DMat3::IDENTITY + map.transpose() * squares * *map;
            norm
        });
        norms.collect()
    }

    /// ‖x‖² = xᵀ P x for a symmetric P; `None` if it is not positive.
    fn of_squares(squares: DMat3) -> Option<Self> {
        let (axes, squares) = principal_axes(squares);
        if !(squares.min_element() > 0.0 && squares.is_finite()) {
            return None;
        }
        let stretch = DVec3::new(squares.x.sqrt(), squares.y.sqrt(), squares.z.sqrt());
        let ball = axes * DMat3::from_diagonal(stretch.recip());
        Some(Self { ball, ..Self::EUCLIDEAN }.checked())
    }

    /// With the slack of its inverse: if W V = I − E, then V⁻¹ = (I − E)⁻¹ W.
    pub(super) fn checked(self) -> Self {
        let inverse = self.ball.inverse();
        let rest = DMat3::IDENTITY - inverse * self.ball;
        let off = frobenius(&rest) + EVALUATION * frobenius(&inverse) * frobenius(&self.ball);
        let slack = if off < 0.5 { (1.0 + EVALUATION) / (1.0 - off) } else { f64::INFINITY };
        Self { inverse, slack, ..self }
    }
}

/// The norm of a matrix as a map of Euclidean spaces, from above, and hardly more: that of AᵀA to the power of 2¹⁶, by
/// squaring, between its largest sum of absolute values in a row and a third of that.
fn spectral_norm_above(matrix: &DMat3) -> f64 {
    const SQUARINGS: usize = 16;
    let size = frobenius(matrix);
    if !size.is_finite() {
        return f64::INFINITY;
    }
    // Smaller ones are nothing: their squares may underflow.
    if size < 1e-150 {
        return 1e-150;
    }
    let unit = *matrix * size.recip();
    let mut power = unit.transpose() * unit;
    let mut sums = [0.0; SQUARINGS];
    for sum in &mut sums {
        *sum = row_sum(&power);
        power *= sum.recip();
        power = power * power;
    }
    let norm = sums.iter().rev().fold(row_sum(&power), |norm, sum| norm.sqrt() * sum);
    // Each squaring errs by less than 100 ε of what it finds, and half of that is left after the root.
    size * norm.sqrt() * (1.0 + 16.0 * EVALUATION)
}

/// The factor by which repeated application enlarges in the long run: the spectral radius, by squaring.
pub(super) fn growth(matrix: &DMat3) -> f64 {
    const SQUARINGS: i32 = 30;
    let (mut power, mut logarithm) = (*matrix, 0.0);
    for squared in 0..SQUARINGS {
        let size = frobenius(&power);
        if !(size > 0.0 && size.is_finite()) {
            return size;
        }
        logarithm += libm::ldexp(libm::log(size), -squared);
        power *= size.recip();
        power = power * power;
    }
    libm::exp(logarithm)
}

/// The largest sum of absolute values in a row, of a symmetric matrix.
fn row_sum(matrix: &DMat3) -> f64 {
    (matrix.x_axis.abs() + matrix.y_axis.abs() + matrix.z_axis.abs()).max_element()
}

fn frobenius(matrix: &DMat3) -> f64 {
    let columns = matrix.to_cols_array();
    let largest = columns.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    if largest > 0.0 && largest.is_finite() {
        let squares = columns.map(|entry| (entry / largest) * (entry / largest));
        largest * squares.iter().sum::<f64>().sqrt() * (1.0 + EVALUATION)
    } else {
        largest
    }
}

/// An orthogonal matrix and the eigenvalues of its columns, for a symmetric matrix: Jacobi's rotations.
fn principal_axes(mut matrix: DMat3) -> (DMat3, DVec3) {
    let mut axes = DMat3::IDENTITY;
    for _ in 0..8 {
        for [p, q] in [[0, 1], [0, 2], [1, 2]] {
            let off = matrix.col(p)[q];
            if off.abs() <= f64::MIN_POSITIVE {
                continue;
            }
            let ratio = 0.5 * (matrix.col(q)[q] - matrix.col(p)[p]) / off;
            let tangent = ratio.signum() / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
            let cosine = (1.0 + tangent * tangent).sqrt().recip();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cosine;
            turn.col_mut(q)[q] = cosine;
            turn.col_mut(p)[q] = -tangent * cosine;
            turn.col_mut(q)[p] = tangent * cosine;
            matrix = turn.transpose() * matrix * turn;
            axes *= turn;
        }
    }
    (axes, DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z).max(DVec3::ZERO))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn matrices() -> impl Strategy<Value = DMat3> {
        prop::array::uniform9(-2.0..2.0_f64).prop_map(|entries| DMat3::from_cols_array(&entries))
    }

    proptest! {
        #[test]
        fn principal_axes_are_eigenvectors(matrix in matrices()) {
            let square = matrix.transpose() * matrix;
            let (axes, values) = principal_axes(square);
            for axis in 0..3 {
                let off = square * axes.col(axis) - values[axis] * axes.col(axis);
                prop_assert!(off.length() < 1e-12, "{off}");
            }
            let norm = spectral_norm_above(&matrix);
            let largest = values.max_element().sqrt();
            prop_assert!(norm >= largest * (1.0 - 1e-14) && norm <= 1.000_1 * largest, "{norm} {largest}");
            prop_assert!(growth(&square) <= largest * largest * 1.000_001);
        }

        #[test]
        fn a_mended_norm_shrinks(map in matrices(), other in matrices()) {
            let above = Norm::EUCLIDEAN.mended(&other, &Norm::EUCLIDEAN, 0.5);
            let above = above.unwrap_or(Norm::EUCLIDEAN).checked();
            let mended = Norm::EUCLIDEAN.mended(&map, &above, 0.9);
            let mended = mended.unwrap_or(Norm::EUCLIDEAN).checked();
            let factor = above.enlargement(&map, &mended);
            prop_assert!(factor <= 0.900_1, "{factor}");
            // And is nowhere less than it was.
            prop_assert!(mended.euclidean() <= 1.000_1);
        }
    }

    #[test]
    fn growth_is_that_of_the_long_run() {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(100.0, 1.0, 0.0), DVec3::Z);
        assert!((growth(&shear) - 1.0).abs() < 1e-6);
        assert!((growth(&(0.7 * shear)) - 0.7).abs() < 1e-6);
        assert!((growth(&DMat3::from_rotation_y(1.0)) - 1.0).abs() < 1e-6);
        let nilpotent = DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::Y);
        assert!(growth(&nilpotent) <= 0.0);
    }
}
