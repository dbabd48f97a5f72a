//! Water as a recursion with constant cost per step: a rational function fitted to its frequency response.
//!
//! `fit` chooses the samples, and `loewner` finds poles from them. `residues` fits the residues and makes the function
//! passive, with the violations found by `passivity`. All this happens within the `range` of the velocities that the
//! elements represent. `recursion` steps the result, with `ports`, `panels`, `lanes` and `advance`; `product` multiplies complex matrices. The response over a
//! level bed before a vertical face has a closed form, in `channel` and, for a rigid bed, in `modal`; in all other cases
//! it comes from the boundary elements.

mod advance;
mod channel;
mod coordinates;
mod fit;
mod lanes;
mod loewner;
mod modal;
mod panels;
mod partial_fractions;
mod passivity;
mod ports;
mod product;
mod range;
mod recursion;
mod residues;

use crate::system::boundary_system;
use crate::{ReservoirError, ReservoirParameters};
use channel::Channel;
use coordinates::Coordinates;
use fit::{Fit, Target};
use num_complex::Complex64;
use range::Range;
pub(crate) use recursion::Recursion;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Relative error that the fit aims at, and the largest that is accepted.
const TOLERANCE: f64 = 6e-4;
const LARGEST_ERROR: f64 = 1e-2;
/// Losses δ that are tried, divided by ρc, and their ω₀, divided by the highest fitted frequency: a lower one adds more mass to
/// short waves, which have little; a higher one leaves less loss to low frequencies, where the fit then has to be passive alone.
const LOSSES: [f64; 5] = [5e-4, 1e-3, 2e-3, 5e-3, 1e-2];
const CORNER: f64 = 0.5;
/// Highest fitted frequency, rad/s, or this number of cut-off frequencies if that is higher: ground motion and a dam's
/// response lie below. Above, the response is extrapolated as a constant.
const ENOUGH: f64 = 2.0 * PI * 30.0;
const ENOUGH_MODES: f64 = 8.0;
/// Smallest distance between a branch point and the line on which the response is fitted, divided by c/h: a decay that
/// is added for a nearly rigid bed.
const LEAST_DAMPING: f64 = 1e-4;
/// Frequency that stands for infinity, divided by the highest frequency: for the closed form, and for elements, which
/// do not represent short waves.
const INFINITE: [f64; 2] = [1e4, 30.0];
/// Lowest frequency of the fit, divided by c/h.
const LOWEST: f64 = 0.02;
/// Initial number of samples on either side of a branch point.
const BESIDE: usize = 6;
/// Panels per wavelength at the highest frequency of the fit.
const PER_WAVE: f64 = 4.0;

/// Error of a recursion's fit, and loss over ρc, above which it is doubtful.
pub(crate) const DOUBTFUL: f64 = 1e-3;

/// Size and quality of a recursion.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Quality {
    /// Number of states.
    pub states: usize,
    /// Largest relative error of the fit, its loss included.
    pub error: f64,
    /// Number of frequencies at which the response was computed.
    pub solved: usize,
    /// Loss added for passivity: δ of `δ s/(s + ω₀)`, divided by ρc.
    pub loss: f64,
}

impl Quality {
    /// Whether the water is better stepped in another way.
    pub fn is_doubtful(&self) -> bool {
        self.error.max(self.loss) > DOUBTFUL
    }
}

impl std::fmt::Display for Quality {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { states, error, loss, solved } = self;
        write!(
            f,
            "{states} states fitted to {solved} frequencies within {error:.1e}, passive with a loss of {loss:.1e} ρc"
        )
    }
}

/// The recursion of compressible water, on the current rayon pool.
///
/// **Errors**: [`ReservoirError::NotFitted`], [`ReservoirError::Recursion`], and those of the frequency response.
pub(crate) fn recursion(parameters: &ReservoirParameters) -> Result<(Recursion, Quality), ReservoirError> {
    let impedance = parameters.density * parameters.sound_speed;
    let coordinates = Coordinates::new(&parameters.wet_face, impedance).ok_or(ReservoirError::NotFitted)?;
    let level = parameters.is_channel();
    if level && parameters.wave_reflection_coefficient == 1.0 {
        return modal::recursion(parameters, &coordinates).ok_or(ReservoirError::NotFitted);
    }
    let (damping, frequencies) = grid(parameters);
    let highest = frequencies.last().copied().unwrap_or(1.0);
    let (mut left, mut right) = coordinates.restoring();
    let corner = CORNER * highest;
    let target = |slope, infinite| Target { frequencies: &frequencies, damping, slope, infinite, corner };
    let fitted = if level {
        let channel = Channel::new(parameters, &coordinates.of_integrals())?;
        let symbol = |s| Ok::<_, ReservoirError>(channel.symbol(s, coordinates.ground_scale()));
        let slope = channel.slope(coordinates.ground_scale());
        fit::fit(symbol, &target(&slope, INFINITE[0]), TOLERANCE, &LOSSES, LARGEST_ERROR)?
    } else {
        let system = boundary_system(parameters)?;
        let symbol = |s| system.symbol(s).map(|k| coordinates.normalised(&k));
        let range = Range::of(&symbol(Complex64::from(INFINITE[1] * highest))?);
        let (basis, inputs) = range.restoring();
        (left, right) = (left * basis, inputs * right);
        let symbol = |s| symbol(s).map(|g| range.within(&g));
        let added_mass = system.added_mass()?.map(|a| Complex64::from(-a));
        let slope = range.within(&coordinates.normalised(&added_mass)).map(|z| z.re);
        fit::fit(symbol, &target(&slope, INFINITE[1]), TOLERANCE, &LOSSES, LARGEST_ERROR)?
    };
    let Fit { fractions, error, solved, loss, needed } = fitted.ok_or(ReservoirError::NotFitted)?;
    if error > LARGEST_ERROR || needed > loss {
        return Err(ReservoirError::Recursion { error, loss: needed });
    }
    let states = fractions.poles.iter().map(|pole| if pole.im > 0.0 { 2 } else { 1 }).sum();
    let recursion = Recursion::of(&fractions.transformed(&left, &right), parameters.communication_step);
    Ok((recursion, Quality { states, error, solved, loss }))
}

/// Damping and initial sample frequencies: close to the channel's cut-off frequencies, between them, and below.
fn grid(parameters: &ReservoirParameters) -> (f64, Vec<f64>) {
    let depth = parameters.channel_depth();
    let rate = parameters.sound_speed / depth;
    let alpha = parameters.wave_reflection_coefficient;
    let decay = -0.5 * rate * alpha.max(1e-20).ln();
    let damping = f64::max(0.0, LEAST_DAMPING * rate - decay);
    let longest_panel = parameters.wet_face.panels().map(|panel| panel.length).fold(0.0, f64::max);
    let shortest_wave = PER_WAVE * longest_panel.max(parameters.element_size);
    let spacing = PI * rate;
    let resolved = 2.0 * PI * parameters.sound_speed / shortest_wave;
    let highest = resolved.min(PI / parameters.communication_step).min(ENOUGH.max(ENOUGH_MODES * spacing));
    let mut frequencies = vec![LOWEST * rate];
    let mut low = LOWEST * rate;
    while low * 2.0 < 0.25 * spacing {
        low *= 2.0;
        frequencies.push(low);
    }
    let mut cut_off = 0.5 * spacing;
    let nearest = f64::min(0.5 * f64::max(decay, damping), 0.1 * spacing);
    loop {
        let ratio = (0.5 * spacing / nearest).powf(1.0 / (BESIDE - 1) as f64);
        for k in (0..BESIDE).rev() {
            frequencies.push(cut_off - nearest * ratio.powi(k as i32));
        }
        frequencies.push(cut_off);
        for k in 0..BESIDE - 1 {
            frequencies.push(cut_off + nearest * ratio.powi(k as i32));
        }
        cut_off += spacing;
        if cut_off > highest {
            break;
        }
    }
    frequencies.retain(|&omega| omega >= LOWEST * rate);
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * rate);
    (damping, frequencies)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::WetFace;

    /// Error and loss below a thousandth, from a rigid to an absorbing bed.
    #[test]
    fn a_level_bed_is_fitted() -> Result<(), Box<dyn std::error::Error>> {
        for alpha in [1.0, 0.97, 0.9, 0.5, 0.0] {
            let parameters = ReservoirParameters {
                wave_reflection_coefficient: alpha,
                ..ReservoirParameters::before(WetFace::straight([0.0, 91.75], 20)?)
            };
            let (_, quality) = recursion(&parameters)?;
            println!("α = {alpha}: {quality}");
            assert!(quality.error < 1e-3 && quality.loss < 1e-3);
        }
        Ok(())
    }
}
