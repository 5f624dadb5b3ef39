//! Numbers of twice the precision: an unevaluated sum of two `f64`, the second at most half an ulp of the first
//! ([DEKK71]).
//!
//! Sums and products of two `f64` are held *exactly*, by two-sum and by splitting the factors into halves whose products
//! are exact. So a point of a surface is known to some 30 digits, where the boxes to be proved round in the sixteenth.
//! Operations on such numbers err by some 2⁻¹⁰⁴ of their operands. Splitting and not fused multiplication, because that
//! is a library call where the compiler must not assume it of the machine.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

/// What an operation may err, relative to its operands; with room for the handful that evaluate a map or a plane.
pub(crate) const PRECISION: f64 = f64::EPSILON * f64::EPSILON * 64.0;

/// `high` + `low`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Double {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

/// The rounded sum, and what it lost.
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_in_sum = sum - a;
    (sum, (a - (sum - b_in_sum)) + (b - b_in_sum))
}

/// A number as two of half the digits.
#[inline(always)]
pub(crate) fn split(a: f64) -> (f64, f64) {
    const UPPER: f64 = 134_217_729.0;
    let shifted = UPPER * a;
    let upper = shifted - (shifted - a);
    (upper, a - upper)
}

/// The rounded product, and what it lost.
#[inline(always)]
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a, a_rest), (b, b_rest)) = (split(a), split(b));
    (product, ((a * b - product) + a * b_rest + a_rest * b) + a_rest * b_rest)
}

impl Double {
    /// The exact sum of two numbers.
    #[inline(always)]
    pub(crate) fn sum(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self { high, low }
    }

    /// The root of a number that is not negative.
    pub(crate) fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 {
            return Self::default();
        }
        // One step of Newton's doubles the digits.
        let rest = self - Self::from(root) * root;
        Self::sum(root, rest.high / (2.0 * root))
    }

    pub(crate) fn recip(self) -> Self {
        let guess = self.high.recip();
        let rest = Self::from(1.0) - self * guess;
        Self::from(guess) + rest * guess
    }
}

impl From<f64> for Double {
    #[inline(always)]
    fn from(number: f64) -> Self {
        Self { high: number, low: 0.0 }
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Add for Double {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, lost) = two_sum(self.high, other.high);
        let (low, lost_low) = two_sum(self.low, other.low);
        let (high, low) = two_sum(high, lost + low);
        Self::sum(high, low + lost_low)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul<f64> for Double {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let (high, low) = two_product(self.high, factor);
        Self::sum(high, low + self.low * factor)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (high, low) = two_product(self.high, other.high);
        Self::sum(high, low + (self.high * other.low + self.low * other.high))
    }
}

impl PartialOrd for Double {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let high = self.high.partial_cmp(&other.high)?;
        Some(high.then(self.low.partial_cmp(&other.low)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_digits() {
        let third = Double::from(3.0).recip();
        assert!((third * 3.0 - Double::from(1.0)).high.abs() < 1e-31);
        let root = Double::from(2.0).sqrt();
        assert!((root * root - Double::from(2.0)).high.abs() < 1e-31);
        let (product, lost) = two_product(1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        assert_eq!((product, lost), (1.0, -f64::EPSILON * f64::EPSILON));
        let tiny = Double::sum(1.0, 1e-30);
        assert!(tiny > Double::from(1.0) && tiny - Double::from(1.0) == Double::from(1e-30));
    }
}
