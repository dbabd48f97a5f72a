use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Number of partial sums of a product.
pub(super) const LANES: usize = 8;

/// Scalar product, with [`LANES`] partial sums.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|i| sums[i] += a[i] * b[i]);
    }
    sums.iter().sum::<f64>() + rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum::<f64>()
}

/// Scalar products of two `rows` with the same numbers, by the widest registers.
pub(super) struct Dots<'a> {
    pub rows: [&'a [f64]; 2],
    pub with: &'a [f64],
}

impl WithSimd for Dots<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; 2] {
        // Not by `map`, whose calls have registers of any processor.
        let [a, b] = self.rows;
        [dot(a, self.with), dot(b, self.with)]
    }
}

/// From the first to the last of `count` numbers that are not zero, beginning and ending at a multiple of [`LANES`], which may lie
/// beyond `count`: the product with these alone has the bits of the whole product.
pub(super) fn used(count: usize, is_not_zero: impl Fn(usize) -> bool) -> Range<usize> {
    let start = (0..count).find(|&i| is_not_zero(i)).unwrap_or(0) / LANES * LANES;
    let end = (0..count).rfind(|&i| is_not_zero(i)).map_or(start, |last| (last + 1).next_multiple_of(LANES));
    start..end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_without_zeros_have_the_bits_of_the_whole_whatever_the_registers() {
        let number = |i: usize| (1.0 + 7.0 * i as f64).sin();
        let with: Vec<f64> = (0..40).map(|i| number(i + 100)).collect();
        for (count, from, to) in [(40, 0, 40), (40, 17, 30), (39, 35, 39), (39, 8, 9), (7, 3, 4), (20, 5, 5)]
        {
            let value = |i: usize| if (from..to).contains(&i) { number(i) } else { 0.0 };
            let row: Vec<f64> = (0..count).map(value).collect();
            let Range { start, end } = used(count, |i| row[i] != 0.0);
            assert!(start % LANES == 0 && end % LANES == 0 && (from == to || start <= from && to <= end));
            assert!(from < to || start == end, "nothing is used");
            let range = start..end.min(count);
            let dots = || Dots { rows: [&row[range.clone()]; 2], with: &with[range.clone()] };
            let whole = dot(&row, &with[..count]);
            for [a, b] in [pulp::Arch::new().dispatch(dots()), dots().with_simd(pulp::Scalar::new())] {
                assert_eq!([a.to_bits(), b.to_bits()], [whole.to_bits(); 2], "{count}, {from} to {to}");
            }
        }
    }
}
