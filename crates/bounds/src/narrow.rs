//! Numbers in the size that they are kept in.

/// An index. Memory runs out before such indices do.
///
/// # Panics
/// If it has more than 32 bits.
pub(crate) fn index(index: usize) -> u32 {
    u32::try_from(index).expect("2³² of anything outgrow memory")
}
