//! Numbers in the size that they are kept in.

/// An index. Memory runs out before such indices do.
///
/// # Panics
/// If it has more than 32 bits.
#[inline(always)]
pub(crate) fn index(index: usize) -> u32 {
    u32::try_from(index).expect("2³² of anything outgrow memory")
}

/// The nearest `f32`. Infinity stays what it is.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}
