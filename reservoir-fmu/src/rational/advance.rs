//! The loop over all poles, with the processor's widest registers. No operations are fused, so the results do not depend on
//! the registers, bit for bit.

use super::lanes::{LANES, blocks, blocks_mut};
use super::ports::{Group, Parts};
use pulp::{Arch, Simd, WithSimd};

/// `a x + f b·v` of every pole.
///
/// **Shapes**: states are Re x, then Im x; b·v is the product of the [`inputs`](super::ports::Ports::inputs) with v.
pub(crate) struct Advance<'a> {
    pub groups: &'a [Group],
    /// x.
    pub states: &'a [f64],
    /// a.
    pub decay: &'a Parts,
    /// b·v of the groups.
    pub driven: &'a [f64],
    /// f.
    pub factor: &'a Parts,
}

impl Advance<'_> {
    /// The new states.
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
