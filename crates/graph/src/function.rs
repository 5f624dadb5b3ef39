//! The functions of expressions: how they are written, and what they give.

use std::ops::RangeInclusive;

use crate::vocabulary::vocabulary;
use crate::{angle, random};

vocabulary! {
    /// A named function. Angles are degrees.
    pub enum Function {
        If: "if(condition, then, else)", "`then` where the condition is not 0, otherwise `else`";
        Abs: "abs(x)", "the distance from 0";
        Sign: "sign(x)", "−1, 0 or 1";
        Min: "min(a, b)", "the smaller";
        Max: "max(a, b)", "the larger";
        Clamp: "clamp(x, low, high)", "`x`, but at least `low` and at most `high`";
        Mix: "mix(a, b, t)", "`a` at t = 0, `b` at t = 1, straight between and beyond";
        Floor: "floor(x)", "the largest integer not above `x`";
        Ceil: "ceil(x)", "the smallest integer not below `x`";
        Round: "round(x)", "the nearest integer, halves away from 0";
        Sqrt: "sqrt(x)", "the square root";
        Pow: "pow(x, y)", "`x ^ y`";
        Exp: "exp(x)", "e to the power of `x`";
        Ln: "ln(x)", "the natural logarithm";
        Sin: "sin(angle)", "the sine";
        Cos: "cos(angle)", "the cosine";
        Tan: "tan(angle)", "the tangent";
        Asin: "asin(x)", "the angle with that sine, −90 to 90";
        Acos: "acos(x)", "the angle with that cosine, 0 to 180";
        Atan: "atan(x)", "the angle with that tangent, −90 to 90";
        Atan2: "atan2(y, x)", "the angle of the point (x, y), −180 to 180";
        Rand: "rand(low, high)", "a random number, uniform, at least `low` and less than `high`";
        Normal: "normal(mean, deviation)", "a random number, normally distributed";
        Pick: "pick(weight, …)", "the number of one of the weights, from 1, at random in proportion to them";
        Hash: "hash(x, …)", "from 0 to less than 1, as if random, but always the same for the same arguments";
        Noise: "noise(x, y, z)", "smooth noise from −1 to 1, 0 where all three are integers";
        Derive: "derive(seed, position)", "the seed that the reference at that position hands down";
    }
}

/// The arguments of a [random function](Function::is_random) before those that are written: the seed and the site.
pub(crate) const HIDDEN: usize = 2;

impl Function {
    /// How many arguments it takes, at least and at most.
    pub fn arity(self) -> RangeInclusive<usize> {
        let listed = self.signature().matches(',').count() + 1;
        if self.signature().ends_with("…)") { listed - 1..=usize::MAX } else { listed..=listed }
    }

    /// Whether it draws from a seed: `rand`, `normal` and `pick`. [`Expr::draw`](crate::Expr::draw) makes such calls.
    pub fn is_random(self) -> bool {
        matches!(self, Self::Rand | Self::Normal | Self::Pick)
    }

    /// Whether nothing but the range of its value is foreseen: it is random, or hashes its arguments.
    pub fn is_erratic(self) -> bool {
        self.is_random() || matches!(self, Self::Hash | Self::Noise | Self::Derive)
    }

    /// Whether its range depends on the argument of that index. What only feeds a hash gives any number of a range.
    pub(crate) fn ranges_over(self, index: usize) -> bool {
        !self.is_erratic() || self.is_random() && index >= HIDDEN
    }

    pub(crate) fn apply(self, args: &[f64]) -> f64 {
        let a = args[0];
        match self {
            Self::If if a.is_nan() => a,
            Self::If => args[if a == 0.0 { 2 } else { 1 }],
            _ if args.iter().any(|arg| arg.is_nan()) => f64::NAN,
            Self::Abs => a.abs(),
            Self::Sign => f64::from(i8::from(a > 0.0) - i8::from(a < 0.0)),
            Self::Min => a.min(args[1]),
            Self::Max => a.max(args[1]),
            Self::Clamp => a.max(args[1]).min(args[2]),
            Self::Mix => a + (args[1] - a) * args[2],
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Round => a.round(),
            Self::Sqrt => a.sqrt(),
            Self::Pow => libm::pow(a, args[1]),
            Self::Exp => libm::exp(a),
            Self::Ln => libm::log(a),
            Self::Sin => angle::sin_cos(a).0,
            Self::Cos => angle::sin_cos(a).1,
            Self::Tan => {
                let (sin, cos) = angle::sin_cos(a);
                sin / cos
            }
            Self::Asin => libm::asin(a).to_degrees(),
            Self::Acos => libm::acos(a).to_degrees(),
            Self::Atan => libm::atan(a).to_degrees(),
            Self::Atan2 => libm::atan2(a, args[1]).to_degrees(),
            Self::Rand => random::uniform(a, args[1], args[2], args[3]),
            Self::Normal => random::normal(a, args[1], args[2], args[3]),
            Self::Pick => random::pick(a, args[1], &args[HIDDEN..]),
            Self::Hash => random::hash(args),
            Self::Noise => random::noise([a, args[1], args[2]]),
            Self::Derive => random::derive(a, args[1]),
        }
    }
}
