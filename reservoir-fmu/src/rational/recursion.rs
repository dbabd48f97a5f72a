use super::partial_fractions::PartialFractions;
use crate::time_domain::{Memory, State, TimeDomain};
use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};
use num_complex::Complex64;
use std::sync::Arc;

/// Steps an impedance given by its poles: `p = D v + Σ_k c_k x_k`, `ẋ_k = λ_k x_k + b_kᵀ v`.
///
/// For v linear within a step of H this is exact:
///
/// ```text
/// x_{n+1} = e^z x_n + φ₀ b·v_n + φ₁ b·v_{n+1},  z = λH,  φ₁ = H (e^z − 1 − z)/z²,  φ₀ = H (e^z (z − 1) + 1)/z²
/// ```
///
/// A step costs the same at any time of a run.
pub(crate) struct Recursion {
    poles: Vec<Complex64>,
    ports: Ports,
    direct: DMatrix<f64>,
    /// Of the step that is taken mostly.
    usual: Step,
}

/// How poles are driven, and what their states give.
pub(crate) enum Ports {
    /// Every pole has directions of its own.
    Dense {
        /// Re b, then Im b: 2 order × inputs.
        inputs: DMatrix<f64>,
        /// What Re x, then Im x give of the pressure: points × 2 order.
        outputs: DMatrix<f64>,
    },
    /// Poles share channels, in which b = 1.
    Channels {
        /// Velocities of the channels from those of the inputs: channels × inputs.
        project: DMatrix<f64>,
        /// The channel of every pole.
        channels: Vec<usize>,
        /// c of every pole within its channel, of a pair twice.
        residues: Vec<Complex64>,
        /// Pressure at the points from that of the channels: points × channels.
        spread: DMatrix<f64>,
    },
}

impl Ports {
    /// Re and Im of b·v of every pole.
    fn driven(&self, velocity: &[f64]) -> Vec<f64> {
        match self {
            Self::Dense { inputs, .. } => product(inputs, velocity),
            Self::Channels { project, channels, .. } => {
                let shared = product(project, velocity);
                let mut driven: Vec<f64> = channels.iter().map(|&channel| shared[channel]).collect();
                driven.resize(2 * channels.len(), 0.0);
                driven
            }
        }
    }

    /// `Σ_k c_k x_k` from Re and Im of x.
    fn collected(&self, states: &[f64]) -> Vec<f64> {
        match self {
            Self::Dense { outputs, .. } => product(outputs, states),
            Self::Channels { channels, residues, spread, .. } => {
                let mut shared = vec![0.0; spread.ncols()];
                let (re, im) = states.split_at(channels.len());
                for (k, &channel) in channels.iter().enumerate() {
                    shared[channel] += residues[k].re * re[k] - residues[k].im * im[k];
                }
                product(spread, &shared)
            }
        }
    }

    fn inputs(&self) -> usize {
        match self {
            Self::Dense { inputs, .. } => inputs.ncols(),
            Self::Channels { project, .. } => project.ncols(),
        }
    }
}

/// What depends on a step's length.
struct Step {
    length: f64,
    /// e^z, φ₀, φ₁ of every pole.
    factors: Vec<[Complex64; 3]>,
    /// ∂p/∂v at the step's end.
    instantaneous: DMatrix<f64>,
}

impl Recursion {
    /// Steps `fractions`; steps of `usual_length` (s) are prepared, others take longer.
    pub fn of(fractions: &PartialFractions, usual_length: f64) -> Self {
        let order = fractions.poles.len();
        let inputs = DMatrix::from_fn(2 * order, fractions.inputs.nrows(), |k, j| {
            let b = fractions.inputs[(j, k % order)];
            if k < order { b.re } else { b.im }
        });
        let outputs = DMatrix::from_fn(fractions.outputs.nrows(), 2 * order, |i, k| {
            let pair = if fractions.poles[k % order].im > 0.0 { 2.0 } else { 1.0 };
            let c = fractions.outputs[(i, k % order)];
            pair * if k < order { c.re } else { -c.im }
        });
        let ports = Ports::Dense { inputs, outputs };
        Self::new(fractions.poles.clone(), ports, fractions.direct.clone(), usual_length)
    }

    /// Steps `poles` (1/s) with these ports and D.
    pub fn new(poles: Vec<Complex64>, ports: Ports, direct: DMatrix<f64>, usual_length: f64) -> Self {
        let usual = Step { length: f64::NAN, factors: Vec::new(), instantaneous: DMatrix::zeros(0, 0) };
        let mut recursion = Self { poles, ports, direct, usual };
        recursion.usual = recursion.step(usual_length);
        recursion
    }

    /// Number of numbers that a state has.
    fn size(&self) -> usize {
        2 * self.poles.len() + self.ports.inputs()
    }

    fn factors(&self, length: f64) -> Vec<[Complex64; 3]> {
        self.poles.iter().map(|&pole| first_order_hold(pole, length)).collect()
    }

    fn step(&self, length: f64) -> Step {
        let factors = self.factors(length);
        let mut instantaneous = self.direct.clone();
        let mut unit = vec![0.0; self.ports.inputs()];
        let mut states = vec![0.0; 2 * self.poles.len()];
        for j in 0..unit.len() {
            unit[j] = 1.0;
            states.fill(0.0);
            drive(&mut states, &self.ports.driven(&unit), &factors);
            unit[j] = 0.0;
            let mut column = instantaneous.column_mut(j);
            column.iter_mut().zip(self.ports.collected(&states)).for_each(|(p, x)| *p += x);
        }
        Step { length, factors, instantaneous }
    }

    /// The factors of a step, those at hand if they are.
    fn with_factors<T>(&self, length: f64, then: impl FnOnce(&[[Complex64; 3]]) -> T) -> T {
        if length == self.usual.length { then(&self.usual.factors) } else { then(&self.factors(length)) }
    }

    /// The states at the end of a step from `values`, if velocity there is 0; `driven` is b·v_n.
    fn free(&self, values: &[f64], driven: &[f64], factors: &[[Complex64; 3]]) -> Vec<f64> {
        let order = self.poles.len();
        let mut next = vec![0.0; 2 * order];
        let (next_re, next_im) = next.split_at_mut(order);
        let (re, im) = values[..2 * order].split_at(order);
        let (driven_re, driven_im) = driven.split_at(order);
        for k in 0..order {
            let [decay, start, _] = factors[k];
            next_re[k] =
                decay.re * re[k] - decay.im * im[k] + start.re * driven_re[k] - start.im * driven_im[k];
            next_im[k] =
                decay.re * im[k] + decay.im * re[k] + start.re * driven_im[k] + start.im * driven_re[k];
        }
        next
    }

    /// The state with these numbers, and what its next usual step starts from: states, then pressures.
    fn state(&self, values: Vec<f64>, driven: &[f64]) -> Memory {
        let mut ahead = self.free(&values, driven, &self.usual.factors);
        ahead.extend(self.ports.collected(&ahead));
        Memory::State(Arc::new(State { values, ahead }))
    }

    fn parts<'a>(&self, memory: &'a Memory) -> Option<&'a State> {
        match memory {
            Memory::State(state) => Some(state),
            _ => None,
        }
    }
}

impl TimeDomain for Recursion {
    fn at_rest(&self) -> Memory {
        let values = vec![0.0; self.size()];
        self.state(values, &vec![0.0; 2 * self.poles.len()])
    }

    fn pressure(&self, memory: &Memory, velocity: &[f64], length: f64) -> Vec<f64> {
        let Some(state) = self.parts(memory) else { return Vec::new() };
        let states = 2 * self.poles.len();
        if length == self.usual.length {
            let mut pressure = product(&self.usual.instantaneous, velocity);
            pressure.iter_mut().zip(&state.ahead[states..]).for_each(|(p, free)| *p += free);
            return pressure;
        }
        let Some(after) =
            self.parts(&self.push(memory, velocity, length)).map(|s| s.values[..states].to_vec())
        else {
            return Vec::new();
        };
        let mut pressure = product(&self.direct, velocity);
        pressure.iter_mut().zip(self.ports.collected(&after)).for_each(|(p, x)| *p += x);
        pressure
    }

    fn push(&self, memory: &Memory, velocity: &[f64], length: f64) -> Memory {
        let Some(state) = self.parts(memory) else { return Memory::None };
        let order = self.poles.len();
        let mut values = if length == self.usual.length {
            state.ahead[..2 * order].to_vec()
        } else {
            let driven = self.ports.driven(&state.values[2 * order..]);
            self.with_factors(length, |factors| self.free(&state.values, &driven, factors))
        };
        let driven = self.ports.driven(velocity);
        self.with_factors(length, |factors| drive(&mut values, &driven, factors));
        values.extend_from_slice(velocity);
        self.state(values, &driven)
    }

    fn instantaneous(&self, length: f64) -> DMatrix<f64> {
        if length == self.usual.length {
            self.usual.instantaneous.clone()
        } else {
            self.step(length).instantaneous
        }
    }

    fn values(&self, memory: &Memory) -> Vec<f64> {
        self.parts(memory).map(|state| state.values.clone()).unwrap_or_default()
    }

    fn resume(&self, values: &[f64], _steps: usize) -> Option<Memory> {
        let velocity = values.get(2 * self.poles.len()..)?;
        (values.len() == self.size()).then(|| self.state(values.to_vec(), &self.ports.driven(velocity)))
    }
}

/// Adds `φ₁ b·v_{n+1}` to the states.
fn drive(states: &mut [f64], driven: &[f64], factors: &[[Complex64; 3]]) {
    let order = factors.len();
    let (re, im) = states.split_at_mut(order);
    let (driven_re, driven_im) = driven.split_at(order);
    for (k, [_, _, end]) in factors.iter().enumerate() {
        re[k] += end.re * driven_re[k] - end.im * driven_im[k];
        im[k] += end.re * driven_im[k] + end.im * driven_re[k];
    }
}

/// `[e^z, φ₀, φ₁]` of a pole and a step of H, z = λH.
fn first_order_hold(pole: Complex64, length: f64) -> [Complex64; 3] {
    let z = pole * length;
    let exp = z.exp();
    if z.norm() < 0.3 {
        // Σ z^j/(j + 2)! and Σ (j + 1) z^j/(j + 2)!: the closed forms lose digits here.
        let (mut end, mut start, mut power, mut factorial) =
            (Complex64::ZERO, Complex64::ZERO, Complex64::ONE, 1.0);
        for j in 0..14 {
            factorial *= f64::from(j) + 2.0;
            end += power / factorial;
            start += power * (f64::from(j) + 1.0) / factorial;
            power *= z;
        }
        return [exp, start * length, end * length];
    }
    let square = z * z;
    [exp, length * (exp * (z - 1.0) + 1.0) / square, length * (exp - 1.0 - z) / square]
}

/// `matrix × vector`.
fn product(matrix: &DMatrix<f64>, vector: &[f64]) -> Vec<f64> {
    let mut result = DVector::zeros(matrix.nrows());
    let (matrix, vector): (DMatrixView<'_, f64>, DVectorView<'_, f64>) =
        (matrix.as_view(), DVectorView::from_slice(vector, vector.len()));
    result.gemv(1.0, &matrix, &vector, 0.0);
    result.data.into()
}
