//! The operators of expressions: how they are written, and what they give.

/// An operator with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unary {
    /// `-a`
    Negate,
    /// `!a`
    Not,
}

/// An operator with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Binary {
    /// `a + b`
    Add,
    /// `a - b`
    Subtract,
    /// `a * b`
    Multiply,
    /// `a / b`
    Divide,
    /// `a % b`, the remainder with the sign of `b`: `-1 % 8` is 7.
    Remainder,
    /// `a ^ b`
    Power,
    /// `a < b`
    Less,
    /// `a <= b`
    LessEqual,
    /// `a > b`
    Greater,
    /// `a >= b`
    GreaterEqual,
    /// `a == b`
    Equal,
    /// `a != b`
    NotEqual,
    /// `a && b`
    And,
    /// `a || b`
    Or,
}

impl Unary {
    pub(crate) fn apply(self, a: f64) -> f64 {
        match self {
            Self::Negate => -a,
            Self::Not if a.is_nan() => a,
            Self::Not => truth(a == 0.0),
        }
    }
}

impl Binary {
    /// The operator as it is written.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Remainder => "%",
            Self::Power => "^",
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
            Self::And => "&&",
            Self::Or => "||",
        }
    }

    #[expect(clippy::float_cmp, reason = "the language's == and != compare exactly")]
    pub(crate) fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::And if a == 0.0 => return 0.0,
            Self::Or if a != 0.0 && !a.is_nan() => return 1.0,
            _ => {}
        }
        if a.is_nan() || b.is_nan() {
            return f64::NAN;
        }
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Remainder => floored_remainder(a, b),
            Self::Power => libm::pow(a, b),
            Self::Less => truth(a < b),
            Self::LessEqual => truth(a <= b),
            Self::Greater => truth(a > b),
            Self::GreaterEqual => truth(a >= b),
            Self::Equal => truth(a == b),
            Self::NotEqual => truth(a != b),
            Self::And | Self::Or => truth(b != 0.0),
        }
    }
}

fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

/// The remainder with the sign of the divisor, always smaller than it in size: where it would be rounded to the divisor, it is
/// the next number before that.
#[expect(clippy::float_cmp, reason = "rounded to the same number or not")]
fn floored_remainder(a: f64, b: f64) -> f64 {
    let remainder = a % b;
    if remainder == 0.0 || (remainder < 0.0) == (b < 0.0) {
        return remainder;
    }
    match remainder + b {
        sum if sum == b && b.is_finite() => b.signum() * b.abs().next_down(),
        sum => sum,
    }
}
