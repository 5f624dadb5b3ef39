//! What messages say about numbers.

use csg_graph::Number;

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
