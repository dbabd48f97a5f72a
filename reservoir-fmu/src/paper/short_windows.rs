//! Short time windows, each with its own Fourier transform.
//!
//! Depends on `added_mass`, `frequency_response` and `whole_record`.

use crate::added_mass::whole_added_mass;
use crate::frequency_response::frequency_response;
use crate::whole_record::check_record;
use crate::{Fidelity, ReservoirError, ReservoirParameters};
use nalgebra::DMatrix;
use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// Re s/ω. Over a rigid bed the response is infinite at a cut-off frequency, and a frequency of the window may coincide
/// with one: with h = 180 m and c = 1440 m/s a window of 0.1 s meets the third.
const DAMPING: f64 = 1e-3;

/// The water with the paper's windows: in each the motion is taken as periodic, and earlier motion has no effect.
///
/// In a window of N steps of H, with ω_k = 2πk/NH and the mean accelerations ā_n over its steps,
///
/// ```text
/// p_n = (1/N) Σ_k K(iω_k)/(iω_k) e^{iω_k H/2} Σ_m ā_m e^{2πik(n − m)/N},   K(s)/s → −A as s → 0
/// ```
///
/// The factor `e^{iω_k H/2}` is there because ā belongs to the middle of a step and p to its end. Two errors follow: an
/// acceleration at the end of a window causes pressure at its beginning, and waves from one window are missing in the next.
/// Frequencies are damped by a thousandth, because over a rigid bed the response at some of them is unbounded.
pub struct ShortWindows {
    /// `K(s)/s e^{iω H/2}` at ω_k, k from 0 to N/2.
    response: Vec<DMatrix<Complex64>>,
    forward: Arc<dyn Fft<f64>>,
    back: Arc<dyn Fft<f64>>,
}

impl ShortWindows {
    /// Windows of this number of communication `steps`.
    ///
    /// **Errors**: [`ReservoirError::WindowTooShort`], [`ReservoirError::GravityWaves`], which have no limit at rest, and
    /// those of [`frequency_response`].
    pub fn new(
        parameters: &ReservoirParameters,
        steps: usize,
        threads: NonZeroUsize,
    ) -> Result<Self, ReservoirError> {
        if steps < 2 {
            return Err(ReservoirError::WindowTooShort { steps });
        }
        // In the limit of zero frequency, compressible water is incompressible.
        let still = match parameters.fidelity {
            Fidelity::Compressible => {
                &ReservoirParameters { fidelity: Fidelity::Incompressible, ..parameters.clone() }
            }
            _ => parameters,
        };
        let mass = whole_added_mass(still)?;
        let step = parameters.communication_step;
        let frequency = |k: usize| 2.0 * PI * k as f64 / (steps as f64 * step);
        let s: Vec<Complex64> =
            (1..=steps / 2).map(|k| frequency(k) * Complex64::new(DAMPING, 1.0)).collect();
        let mut response = vec![mass.map(|a| Complex64::from(-a))];
        for (symbol, s) in frequency_response(parameters, &s, threads)?.into_iter().zip(s) {
            response.push(symbol * (Complex64::from_polar(1.0, 0.5 * s.im * step) / s));
        }
        let mut planner = FftPlanner::new();
        let (forward, back) = (planner.plan_fft_forward(steps), planner.plan_fft_inverse(steps));
        Ok(Self { response, forward, back })
    }

    /// Steps of a window.
    pub fn steps(&self) -> usize {
        self.forward.len()
    }

    /// Pressures (Pa) at the ends of the window's steps, points × steps, for mean accelerations (m/s²) over them: one row per
    /// interface point, along n, then the ground along x and y; one column per step.
    ///
    /// **Errors**: [`ReservoirError::RecordShape`], also if the number of columns is not that of the steps,
    /// [`ReservoirError::NonFiniteRecord`].
    pub fn pressure(&self, acceleration: &DMatrix<f64>) -> Result<DMatrix<f64>, ReservoirError> {
        let (rows, steps) = acceleration.shape();
        let (points, expected) = self.response[0].shape();
        check_record(acceleration, expected)?;
        if steps != self.steps() {
            return Err(ReservoirError::RecordShape { rows, instants: steps, expected });
        }
        let mut spectra = DMatrix::from_element(rows, steps, Complex64::ZERO);
        for row in 0..rows {
            let mut values: Vec<Complex64> = acceleration.row(row).iter().map(|a| (*a).into()).collect();
            self.forward.process(&mut values);
            spectra.row_mut(row).iter_mut().zip(values).for_each(|(to, value)| *to = value);
        }
        let answers: Vec<_> = self.response.iter().zip(spectra.column_iter()).map(|(k, a)| k * a).collect();
        let mut pressure = DMatrix::zeros(points, steps);
        for point in 0..points {
            let mut values = vec![Complex64::ZERO; steps];
            for (k, answer) in answers.iter().enumerate() {
                values[k] = answer[point];
                values[(steps - k) % steps] = answer[point].conj();
            }
            self.back.process(&mut values);
            let scaled = values.iter().map(|p| p.re / steps as f64);
            pressure.row_mut(point).iter_mut().zip(scaled).for_each(|(to, p)| *to = p);
        }
        Ok(pressure)
    }
}
