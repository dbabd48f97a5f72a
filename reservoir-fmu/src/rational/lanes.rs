//! Blocks of numbers that the registers take at once.

/// Number of poles that are computed together: as many as the registers hold with all their values.
pub(crate) const LANES: usize = 4;

/// The numbers in blocks of [`LANES`].
#[inline(always)]
pub(crate) fn blocks(numbers: &[f64]) -> &[[f64; LANES]] {
    numbers.as_chunks().0
}

/// The same, mutable.
#[inline(always)]
pub(crate) fn blocks_mut(numbers: &mut [f64]) -> &mut [[f64; LANES]] {
    numbers.as_chunks_mut().0
}
