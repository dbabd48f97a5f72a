use super::lanes::{LANES, blocks, blocks_mut};
use super::panels::Panels;
use super::partial_fractions::PartialFractions;
use nalgebra::DMatrix;
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Real and imaginary parts of one number per pole.
pub(crate) type Parts = [Vec<f64>; 2];

/// Inputs of the poles from velocities, and pressures from their states.
#[derive(Serialize, Deserialize)]
pub(crate) struct Ports {
    /// All poles, in groups.
    pub groups: Vec<Group>,
    /// b·v of the groups from the velocities v.
    pub inputs: Panels,
    /// Pressures from the states.
    pub outputs: Outputs,
}

/// Consecutive poles with consecutive inputs.
#[derive(Serialize, Deserialize)]
pub(crate) struct Group {
    /// Index of the first pole, a multiple of [`LANES`].
    pub first: usize,
    /// Number of poles, a multiple of [`LANES`]; poles without input fill the last block.
    pub length: usize,
    /// Indices of Re b·v and Im b·v of the first pole.
    pub driven: [usize; 2],
}

/// Pressure from states.
#[derive(Serialize, Deserialize)]
pub(crate) enum Outputs {
    /// From Re x, then Im x: points × (2 × order).
    Dense(Panels),
    /// Several poles contribute to the same channel.
    Channels {
        /// The channel of each group's first pole, a multiple of [`LANES`]; the others follow.
        channels: Vec<usize>,
        /// c of every pole within its channel; doubled for a conjugate pair.
        residues: Parts,
        /// Pressure at the points from that of the channels: points × channels.
        spread: Panels,
    },
}

impl Ports {
    /// The ports of `fractions`; a pole with Im λ > 0 stands for a conjugate pair.
    pub fn of(fractions: &PartialFractions) -> Self {
        let order = fractions.poles.len();
        let length = order.next_multiple_of(LANES);
        let mut inputs = DMatrix::zeros(2 * length, fractions.inputs.nrows());
        let mut outputs = DMatrix::zeros(fractions.outputs.nrows(), 2 * length);
        for (k, pole) in fractions.poles.iter().enumerate() {
            let pair = if pole.im > 0.0 { 2.0 } else { 1.0 };
            for (j, b) in fractions.inputs.column(k).iter().enumerate() {
                (inputs[(k, j)], inputs[(length + k, j)]) = (b.re, b.im);
            }
            for (i, c) in fractions.outputs.column(k).iter().enumerate() {
                (outputs[(i, k)], outputs[(i, length + k)]) = (pair * c.re, -pair * c.im);
            }
        }
        Self {
            groups: vec![Group { first: 0, length, driven: [0, length] }],
            inputs: Panels::of(&inputs),
            outputs: Outputs::Dense(Panels::of(&outputs)),
        }
    }

    /// `Σ_k c_k x_k` (Pa) of the states, Re x, then Im x.
    pub fn collected(&self, states: &[f64]) -> Vec<f64> {
        match &self.outputs {
            Outputs::Dense(outputs) => outputs.product(states),
            Outputs::Channels { channels, residues, spread } => {
                let (groups, columns) = (&self.groups, spread.columns());
                let shared = Arch::new().dispatch(Shared { groups, channels, residues, states, columns });
                spread.product(&shared)
            }
        }
    }
}

/// Pressures of the channels, with the processor's widest registers.
struct Shared<'a> {
    groups: &'a [Group],
    channels: &'a [usize],
    residues: &'a Parts,
    states: &'a [f64],
    columns: usize,
}

impl WithSimd for Shared<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let mut shared = vec![0.0; self.columns];
        let (re, im) = self.states.split_at(self.residues[0].len());
        let (re, im, shared_blocks) = (blocks(re), blocks(im), blocks_mut(&mut shared));
        let (of_re, of_im) = (blocks(&self.residues[0]), blocks(&self.residues[1]));
        for (Group { first, length, .. }, to) in self.groups.iter().zip(self.channels) {
            for n in 0..length / LANES {
                let own = first / LANES + n;
                let (re, im, of_re, of_im) = (&re[own], &im[own], &of_re[own], &of_im[own]);
                let mut sums = shared_blocks[to / LANES + n];
                for k in 0..LANES {
                    sums[k] += of_re[k] * re[k] - of_im[k] * im[k];
                }
                shared_blocks[to / LANES + n] = sums;
            }
        }
        shared
    }
}

/// Real parts, then imaginary parts.
pub(crate) fn parts(numbers: impl Iterator<Item = Complex64>) -> Parts {
    let (re, im) = numbers.map(|z| (z.re, z.im)).unzip();
    [re, im]
}
