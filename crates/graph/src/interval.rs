//! Ranges of expressions: interval arithmetic [MOOR66] over the operations of the language.
//!
//! The range of an expression holds every number that [`Expr::evaluate`](crate::Expr::evaluate) can give while each
//! parameter is anywhere in its interval. Not what exact arithmetic gives, but those very `f64`: IEEE 754 rounds sums,
//! products, quotients and roots, and rounding is monotone, so that the rounded ends of a range enclose all rounded
//! numbers between them. They need no margin, and points stay points. Only what comes from `libm` gets one, of some ulps.
//!
//! A value that is not a number is an error wherever it is used, and is reported there. The range is that of the values
//! that are numbers; where there is none it is empty.

use crate::function::HIDDEN;
use crate::{Binary, Function, NORMAL_REACH, Unary, angle};

/// A closed interval of numbers: all x with `min` ≤ x ≤ `max`, infinities included.
///
/// ```
/// use csg_graph::{Expr, GraphBuilder, Interval};
///
/// let mut builder = GraphBuilder::new();
/// let x = builder.param("x", 0.0);
/// let expr = Expr::choose(Expr::from(x).gt(0.0), Expr::from(x) * 2.0, -1.0);
/// assert_eq!(expr.range(&[Interval::new(1.0, 3.0)]), Interval::new(2.0, 6.0));
/// assert_eq!(expr.range(&[Interval::new(-3.0, 3.0)]), Interval::new(-6.0, 6.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The least number.
    pub min: f64,
    /// The greatest number.
    pub max: f64,
}

/// More than `libm` errs, relative to the result.
const MARGIN: f64 = 8.0 * f64::EPSILON;

/// All derived seeds are below 2^53.
const SEEDS: f64 = 2.0 / f64::EPSILON;

/// Of angles beyond this, in degrees, nobody asks where the waves have their tops.
const FAR: f64 = 1e9;

impl Interval {
    /// No number at all.
    pub const EMPTY: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// All numbers.
    pub const ALL: Self = Self { min: f64::NEG_INFINITY, max: f64::INFINITY };

    const TRUTH: Self = Self { min: 0.0, max: 1.0 };

    /// The interval from `min` to `max`, or [`EMPTY`](Self::EMPTY) where they are not in order or one is no number.
    pub const fn new(min: f64, max: f64) -> Self {
        if min <= max { Self { min, max } } else { Self::EMPTY }
    }

    /// The interval that holds one number; none if it is not a number.
    pub const fn point(value: f64) -> Self {
        Self::new(value, value)
    }

    /// Whether no number is in it.
    pub const fn is_empty(self) -> bool {
        self.min > self.max
    }

    /// Its number, if it holds no other.
    #[expect(clippy::float_cmp, reason = "a point is one number")]
    pub fn value(self) -> Option<f64> {
        (self.min == self.max).then_some(self.min + 0.0)
    }

    /// Its number, if that is known with the sign of a zero: infinities are the inverses of zeros.
    fn signed(self) -> Option<f64> {
        (self.min.to_bits() == self.max.to_bits()).then_some(self.min)
    }

    /// The same numbers, with zeros of either sign.
    fn unsigned(self) -> Self {
        let zero = |end: f64, zero: f64| if end == 0.0 { zero } else { end };
        Self { min: zero(self.min, -0.0), max: zero(self.max, 0.0) }
    }

    /// Whether `value` is in it.
    pub fn contains(self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }

    /// Whether all of `other` is in it.
    pub fn encloses(self, other: Self) -> bool {
        other.is_empty() || self.min <= other.min && other.max <= self.max
    }

    /// The least interval that encloses both.
    #[must_use]
    pub const fn join(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What is in both.
    #[must_use]
    pub const fn intersect(self, other: Self) -> Self {
        Self::new(self.min.max(other.min), self.max.min(other.max))
    }

    /// Whether its numbers count as true, if all or none of them do.
    fn truth(self) -> Option<bool> {
        if self.contains(0.0) { self.value().map(|_| false) } else { Some(true) }
    }

    fn of_truth(truth: Option<bool>) -> Self {
        truth.map_or(Self::TRUTH, |truth| Self::point(f64::from(u8::from(truth))))
    }

    /// The least interval that holds these numbers, of which those that are none do not count.
    fn about<const N: usize>(values: [f64; N]) -> Self {
        values.into_iter().fold(Self::EMPTY, |all, value| all.join(Self::point(value)))
    }

    /// With room for what `libm` errs. What overflowed may also just not have.
    fn loosened(self) -> Self {
        let below = |value: f64| {
            let value = value.min(f64::MAX);
            value - value.abs() * MARGIN - f64::MIN_POSITIVE
        };
        if self.is_empty() {
            return self;
        }
        let min = if self.min == f64::NEG_INFINITY { self.min } else { below(self.min) };
        let max = if self.max == f64::INFINITY { self.max } else { -below(-self.max) };
        Self { min, max }
    }

    /// The range of a function that never decreases, but for what `libm` errs.
    fn increasing(self, function: impl Fn(f64) -> f64) -> Self {
        if self.is_empty() { self } else { Self::new(function(self.min), function(self.max)).loosened() }
    }

    fn magnitude(self) -> f64 {
        self.min.abs().max(self.max.abs())
    }

    fn abs(self) -> Self {
        let least = if self.contains(0.0) { 0.0 } else { self.min.abs().min(self.max.abs()) };
        Self::new(least, self.magnitude())
    }

    fn negate(self) -> Self {
        Self { min: -self.max, max: -self.min }
    }

    /// −∞ + ∞ is no number; next to it may be any.
    fn add(self, other: Self) -> Self {
        let [min, max] = [self.min + other.min, self.max + other.max];
        Self {
            min: if min.is_nan() { f64::NEG_INFINITY } else { min },
            max: if max.is_nan() { f64::INFINITY } else { max },
        }
    }

    /// 0 · ∞ is no number; next to it, 0 times any other is 0.
    fn multiply(self, other: Self) -> Self {
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        Self::about([
            product(self.min, other.min),
            product(self.min, other.max),
            product(self.max, other.min),
            product(self.max, other.max),
        ])
    }

    /// Both zeros pass for 0, and their quotients differ in sign.
    fn divide(self, other: Self) -> Self {
        let infinite = |interval: Self| interval.magnitude() == f64::INFINITY;
        if other.contains(0.0) || infinite(self) && infinite(other) {
            return Self::ALL;
        }
        if let Some(divisor) = other.value() {
            return Self::about([self.min / divisor, self.max / divisor]);
        }
        Self::about([self.min / other.min, self.min / other.max, self.max / other.min, self.max / other.max])
    }

    /// The sawtooth rises from 0 to the divisor, over and over.
    fn remainder(self, divisor: Self) -> Self {
        let all = Self::new(divisor.min.min(0.0), divisor.max.max(0.0));
        let least = if divisor.contains(0.0) { 0.0 } else { divisor.min.abs().min(divisor.max.abs()) };
        let first_tooth = if divisor.min > 0.0 {
            self.min >= 0.0 && self.max < least
        } else {
            self.max <= 0.0 && self.min > -least
        };
        if first_tooth {
            return self;
        }
        // With no more than half a tooth between them, ends on two teeth are far apart and not in order.
        if let Some(divisor) = divisor.value()
            && self.max - self.min <= 0.5 * divisor.abs()
        {
            let [min, max] = [self.min, self.max].map(|end| Binary::Remainder.apply(end, divisor));
            if min <= max {
                return Self { min, max };
            }
        }
        all
    }

    #[expect(clippy::float_cmp, reason = "an exponent is odd or it is not")]
    fn power(self, exponent: Self) -> Self {
        let of_size = |base: Self| {
            Self::about([
                libm::pow(base.min, exponent.min),
                libm::pow(base.min, exponent.max),
                libm::pow(base.max, exponent.min),
                libm::pow(base.max, exponent.max),
            ])
            .loosened()
        };
        if self.min >= 0.0 {
            // A zero may be negative, and then so may be the infinity that is its inverse.
            let inverse = self.contains(0.0) && exponent.min < 0.0;
            return if inverse { Self::ALL } else { of_size(self) };
        }
        // Of a negative base there are only integer powers, whose sizes are those of its size.
        let size = of_size(self.abs());
        match exponent.value() {
            Some(power) if power % 2.0 == 0.0 => size,
            Some(power) if power > 0.0 && power % 2.0 == 1.0 => {
                Self::new(libm::pow(self.min, power), libm::pow(self.max, power)).loosened()
            }
            _ => Self::new(-size.max, size.max),
        }
    }

    /// `!a`
    fn not(self) -> Self {
        if self.is_empty() { self } else { Self::of_truth(self.truth().map(|truth| !truth)) }
    }

    /// `a && b`, where `b` may have no value if it is not needed.
    fn and(self, other: Self) -> Self {
        match (self.truth(), other.truth()) {
            _ if self.is_empty() => self,
            _ if other.is_empty() => self.intersect(Self::point(0.0)),
            (Some(false), _) | (_, Some(false)) => Self::point(0.0),
            (Some(true), Some(true)) => Self::point(1.0),
            _ => Self::TRUTH,
        }
    }

    /// `a < b`
    fn less(self, other: Self) -> Self {
        let never = self.min >= other.max;
        Self::of_truth(if never { Some(false) } else { (self.max < other.min).then_some(true) })
    }

    /// `a == b`, of which at least one is not a point.
    fn equal(self, other: Self) -> Self {
        Self::of_truth(self.intersect(other).is_empty().then_some(false))
    }

    /// Whether an angle of this interval is `at` but for full periods, or might be, but for rounding.
    fn meets(self, at: f64, period: f64) -> bool {
        let slack = 1e-9 + 1e-12 * self.magnitude();
        let turns = ((self.min - slack - at) / period).ceil();
        at + turns * period <= self.max + slack
    }

    /// The range of a sine or cosine that has its top at some angle.
    fn wave(self, top: f64, function: impl Fn(f64) -> f64) -> Self {
        if self.magnitude() > FAR {
            return Self::new(-1.0, 1.0);
        }
        let ends = Self::about([function(self.min), function(self.max)]);
        let min = if self.meets(top - 180.0, 360.0) { -1.0 } else { (ends.min - MARGIN).max(-1.0) };
        let max = if self.meets(top, 360.0) { 1.0 } else { (ends.max + MARGIN).min(1.0) };
        Self { min, max }
    }

    fn sin(self) -> Self {
        self.wave(90.0, |angle| angle::sin_cos(angle).0)
    }

    fn cos(self) -> Self {
        self.wave(0.0, |angle| angle::sin_cos(angle).1)
    }

    fn atan2(y: Self, x: Self) -> Self {
        // Across the negative axis the angle jumps; and a zero may have either sign.
        if x.min <= 0.0 && y.contains(0.0) {
            return Self::new(-180.0, 180.0);
        }
        let corner = |y, x| libm::atan2(y, x).to_degrees();
        let corners =
            [corner(y.min, x.min), corner(y.min, x.max), corner(y.max, x.min), corner(y.max, x.max)];
        Self::about(corners).loosened()
    }

    /// a + (b − a) t, which is straight in each of the three, so that the corners are the farthest.
    fn mix(a: Self, b: Self, t: Self) -> Self {
        let loose = a.add(b.add(a.negate()).multiply(t));
        let magnitude = a.magnitude() + (a.magnitude() + b.magnitude()) * t.magnitude();
        let slack = MARGIN * magnitude + f64::MIN_POSITIVE;
        if !slack.is_finite() {
            return loose;
        }
        let mut corners = Self::EMPTY;
        for a in [a.min, a.max] {
            for b in [b.min, b.max] {
                for t in [t.min, t.max] {
                    corners = corners.join(Self::point(a + (b - a) * t));
                }
            }
        }
        loose.intersect(Self::new(corners.min - slack, corners.max + slack))
    }
}

impl Unary {
    pub(crate) fn range(self, a: Interval) -> Interval {
        match self {
            Self::Negate => a.negate(),
            Self::Not => a.not(),
        }
    }
}

impl Binary {
    pub(crate) fn range(self, a: Interval, b: Interval) -> Interval {
        if let (Some(a), Some(b)) = (a.signed(), b.signed()) {
            return Interval::point(self.apply(a, b));
        }
        match self {
            Self::And => return a.and(b),
            Self::Or => return a.not().and(b.not()).not(),
            _ if a.is_empty() || b.is_empty() => return Interval::EMPTY,
            _ => {}
        }
        let range = match self {
            Self::Add => a.add(b),
            Self::Subtract => a.add(b.negate()),
            Self::Multiply => a.multiply(b),
            Self::Divide => a.divide(b),
            Self::Remainder => a.remainder(b),
            Self::Power => a.power(b),
            Self::Less => a.less(b),
            Self::LessEqual => b.less(a).not(),
            Self::Greater => b.less(a),
            Self::GreaterEqual => a.less(b).not(),
            Self::Equal => a.equal(b),
            Self::NotEqual => a.equal(b).not(),
            Self::And | Self::Or => unreachable!("decided above"),
        };
        range.unsigned()
    }
}

impl Function {
    pub(crate) fn range(self, args: &[Interval]) -> Interval {
        let a = args[0];
        if self == Self::If {
            return match a.truth() {
                _ if a.is_empty() => a,
                Some(truth) => args[if truth { 1 } else { 2 }],
                None => args[1].join(args[2]).unsigned(),
            };
        }
        if args.iter().any(|arg| arg.is_empty()) {
            return Interval::EMPTY;
        }
        if let Some(value) = self.at_points(args) {
            return Interval::point(value);
        }
        let range = match self {
            Self::If => unreachable!("decided above"),
            Self::Abs => a.abs(),
            Self::Min => Interval::new(a.min.min(args[1].min), a.max.min(args[1].max)),
            Self::Max => Interval::new(a.min.max(args[1].min), a.max.max(args[1].max)),
            Self::Clamp => {
                let [low, high] = [args[1], args[2]];
                Interval::new(a.min.max(low.min).min(high.min), a.max.max(low.max).min(high.max))
            }
            Self::Mix => Interval::mix(a, args[1], args[2]),
            // These never decrease, and are exact.
            Self::Sign | Self::Floor | Self::Ceil | Self::Round => {
                Interval { min: self.apply(&[a.min]), max: self.apply(&[a.max]) }
            }
            Self::Sqrt => {
                let a = a.intersect(Interval { min: 0.0, ..Interval::ALL });
                Interval::new(a.min.sqrt(), a.max.sqrt())
            }
            Self::Pow => a.power(args[1]),
            Self::Exp => a.increasing(libm::exp).intersect(Interval { min: 0.0, ..Interval::ALL }),
            Self::Ln => a.intersect(Interval { min: 0.0, ..Interval::ALL }).increasing(libm::log),
            Self::Sin => a.sin(),
            Self::Cos => a.cos(),
            // It rises between the angles where it has no value, which are half a turn apart.
            Self::Tan if a.magnitude() > FAR || a.meets(90.0, 180.0) => Interval::ALL,
            Self::Tan => a.increasing(|angle| self.apply(&[angle])),
            Self::Asin | Self::Atan => {
                let a = if self == Self::Asin { a.intersect(Interval::new(-1.0, 1.0)) } else { a };
                a.increasing(|x| self.apply(&[x]))
            }
            Self::Acos => {
                let a = a.intersect(Interval::new(-1.0, 1.0));
                a.negate().increasing(|x| self.apply(&[-x]))
            }
            Self::Atan2 => Interval::atan2(a, args[1]),
            Self::Rand => args[HIDDEN].join(args[HIDDEN + 1]),
            Self::Normal => {
                let reach = args[HIDDEN + 1].magnitude() * NORMAL_REACH;
                args[HIDDEN].add(Interval { min: -reach, max: reach })
            }
            Self::Pick => {
                // Those that may have a weight.
                let numbers = (1_u32..).zip(&args[HIDDEN..]).filter(|(_, weight)| weight.max > 0.0);
                numbers.fold(Interval::EMPTY, |all, (number, _)| all.join(Interval::point(number.into())))
            }
            Self::Hash => Interval::TRUTH,
            Self::Noise => Interval::new(-1.0, 1.0),
            Self::Derive => Interval::new(0.0, SEEDS),
        };
        range.unsigned()
    }

    /// The value, if all arguments are points; it may be no number.
    fn at_points(self, args: &[Interval]) -> Option<f64> {
        const FEW: usize = 8;
        let mut few = [0.0; FEW];
        if args.len() > FEW {
            let values: Option<Vec<f64>> = args.iter().map(|arg| arg.signed()).collect();
            return values.map(|values| self.apply(&values));
        }
        for (value, arg) in few.iter_mut().zip(args) {
            *value = arg.signed()?;
        }
        Some(self.apply(&few[..args.len()]))
    }
}
