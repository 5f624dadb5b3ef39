//! The operators of expressions: how they are written, how tightly they bind, and what they give.

/// Defines an enumeration of operators, each with its sign, how tightly it binds, and its meaning.
macro_rules! operators {
    (
        $(#[$attribute:meta])*
        pub enum $Operators:ident {
            $($Operator:ident: $symbol:literal, $strength:literal, $meaning:literal;)*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $Operators {
            $(
                #[doc = $meaning]
                $Operator,
            )*
        }

        impl $Operators {
            /// Every one of them.
            pub const ALL: &[Self] = &[$(Self::$Operator),*];

            /// The operator as it is written.
            pub fn symbol(self) -> &'static str {
                match self {
                    $(Self::$Operator => $symbol,)*
                }
            }

            /// How tightly it binds, beside all other operators: the larger, the tighter.
            pub fn strength(self) -> u8 {
                match self {
                    $(Self::$Operator => $strength,)*
                }
            }

            /// The one that is written so.
            pub fn of_symbol(symbol: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|operator| operator.symbol() == symbol)
            }
        }
    };
}

operators! {
    /// An operator with one operand.
    pub enum Unary {
        Negate: "-", 6, "`-a`";
        Not: "!", 6, "`!a`";
    }
}

operators! {
    /// An operator with two operands. Those that bind equally tightly group to the left, but for the power.
    pub enum Binary {
        Or: "||", 1, "`a || b`";
        And: "&&", 2, "`a && b`";
        Less: "<", 3, "`a < b`";
        LessEqual: "<=", 3, "`a <= b`";
        Greater: ">", 3, "`a > b`";
        GreaterEqual: ">=", 3, "`a >= b`";
        Equal: "==", 3, "`a == b`";
        NotEqual: "!=", 3, "`a != b`";
        Add: "+", 4, "`a + b`";
        Subtract: "-", 4, "`a - b`";
        Multiply: "*", 5, "`a * b`";
        Divide: "/", 5, "`a / b`";
        Remainder: "%", 5, "`a % b`, the remainder with the sign of `b`: `-1 % 8` is 7.";
        Power: "^", 7, "`a ^ b`, tighter than the sign before it.";
    }
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
