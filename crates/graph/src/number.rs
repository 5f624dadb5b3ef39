//! Numbers as messages show them.

use std::fmt;

/// A number, briefly: with a power of ten where it would have very many digits.
///
/// ```
/// use csg_graph::Number;
///
/// let shown = [0.0, 0.5, -12.0, 2_000_000.0, 1e300, -1e-300, f64::INFINITY].map(|value| Number(value).to_string());
/// assert_eq!(shown, ["0", "0.5", "-12", "2000000", "1e300", "-1e-300", "inf"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = *self;
        let size = value.abs();
        if size.is_finite() && size > 0.0 && !(1e-4..1e16).contains(&size) {
            write!(f, "{value:e}")
        } else {
            write!(f, "{value}")
        }
    }
}
