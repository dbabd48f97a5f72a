//! The loop over all poles, with the processor's widest registers; every operation is one of IEEE 754, never fused, so that
//! the bits do not depend on them.

use super::ports::{Group, Parts};
use pulp::{Arch, Simd, WithSimd};

/// Poles that are computed together: what the registers hold at once of all that a pole needs.
pub(crate) const LANES: usize = 4;

/// `a x + f b·v` of every pole.
///
/// **Shapes**: states are Re x, then Im x; v drives by what the [`inputs`](super::ports::Ports::inputs) make of it.
pub(crate) struct Advance<'a> {
    pub groups: &'a [Group],
    /// x.
    pub states: &'a [f64],
    /// a.
    pub decay: &'a Parts,
    /// What drives the groups.
    pub driven: &'a [f64],
    /// f.
    pub factor: &'a Parts,
}

impl Advance<'_> {
    /// The states after it.
    pub fn states(self) -> Vec<f64> {
        Arch::new().dispatch(self)
    }
}

impl WithSimd for Advance<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let order = self.states.len() / 2;
        let mut result = vec![0.0; 2 * order];
        let (result_re, result_im) = result.split_at_mut(order);
        let (result_re, result_im) = (blocks_mut(result_re), blocks_mut(result_im));
        let (re, im) = self.states.split_at(order);
        let (re, im) = (blocks(re), blocks(im));
        let (a_re, a_im) = (blocks(&self.decay[0]), blocks(&self.decay[1]));
        let (f_re, f_im) = (blocks(&self.factor[0]), blocks(&self.factor[1]));
        for Group { first, length, driven: [of_re, of_im] } in self.groups {
            let (d_re, d_im) = (blocks(&self.driven[*of_re..]), blocks(&self.driven[*of_im..]));
            for n in 0..length / LANES {
                let own = first / LANES + n;
                let (re, im, a_re, a_im) = (&re[own], &im[own], &a_re[own], &a_im[own]);
                let (d_re, d_im, f_re, f_im) = (&d_re[n], &d_im[n], &f_re[own], &f_im[own]);
                let (mut next_re, mut next_im) = ([0.0; LANES], [0.0; LANES]);
                for k in 0..LANES {
                    next_re[k] =
                        (a_re[k] * re[k] - a_im[k] * im[k]) + (f_re[k] * d_re[k] - f_im[k] * d_im[k]);
                    next_im[k] =
                        (a_re[k] * im[k] + a_im[k] * re[k]) + (f_re[k] * d_im[k] + f_im[k] * d_re[k]);
                }
                (result_re[own], result_im[own]) = (next_re, next_im);
            }
        }
        result
    }
}

/// Whole blocks of numbers.
#[inline(always)]
pub(crate) fn blocks(numbers: &[f64]) -> &[[f64; LANES]] {
    numbers.as_chunks().0
}

/// The same, to be written.
#[inline(always)]
pub(crate) fn blocks_mut(numbers: &mut [f64]) -> &mut [[f64; LANES]] {
    numbers.as_chunks_mut().0
}
