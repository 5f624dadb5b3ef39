//! Numbers as messages show them.

use std::fmt;

/// A number, briefly: `0.5`, `12`, and `1e300` instead of three hundred digits.
pub(crate) struct Number(pub(crate) f64);

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

/// Where what is not a number may have come from.
pub(crate) const NOT_A_NUMBER: &str = "0/0 is none, nor is the root or the logarithm of a negative number, or a pick whose \
                                       weights are negative or all 0";

/// `where a = 1, b = 2`, if there are any.
pub(crate) fn values(values: &[(String, f64)]) -> Option<String> {
    const SHOWN: usize = 8;
    let shown = values.iter().take(SHOWN).map(|(name, value)| format!("{name} = {}", Number(*value)));
    let more = if values.len() > SHOWN { ", …" } else { "" };
    (!values.is_empty()).then(|| format!("where {}{more}", shown.collect::<Vec<_>>().join(", ")))
}

#[cfg(test)]
mod tests {
    use super::Number;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 0.5, -12.0, 2_000_000.0, 1e300, -1e-300, f64::INFINITY]
            .map(|value| Number(value).to_string());
        assert_eq!(shown, ["0", "0.5", "-12", "2000000", "1e300", "-1e-300", "inf"]);
    }
}
