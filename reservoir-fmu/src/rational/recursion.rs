use super::advance::Advance;
use super::panels::Panels;
use super::partial_fractions::PartialFractions;
use super::ports::{Parts, Ports, parts};
use crate::time_domain::{Memory, TimeDomain};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::{Arc, OnceLock};

/// Time stepping of an impedance given by its poles: `p = D v + Σ_k c_k x_k`, `ẋ_k = λ_k x_k + b_kᵀ v`.
///
/// For v linear within a step of H this is exact:
///
/// ```text
/// x_{n+1} = e^z x_n + φ₀ b·v_n + φ₁ b·v_{n+1},  z = λH,  φ₁ = H (e^z − 1 − z)/z²,  φ₀ = H (e^z (z − 1) + 1)/z²
/// ```
///
/// The stored states are w, without the contribution of the last velocity, so that steps of the usual length need one
/// product:
///
/// ```text
/// x_n = w_n + φ₁ b·v_n,  w_{n+1} = e^z w_n + (φ₀ + e^z φ₁) b·v_n
/// ```
///
/// A step costs the same at any time of a run.
pub(crate) struct Recursion {
    poles: Vec<Complex64>,
    ports: Ports,
    direct: DMatrix<f64>,
    usual: Step,
}

/// A pole without input, 1/s.
pub(crate) const IDLE: Complex64 = Complex64::new(-1.0, 0.0);

/// State of the water after a step; the part of the next step that does not depend on its velocities is computed when
/// first needed.
struct State {
    /// Re w, then Im w.
    states: Arc<Vec<f64>>,
    velocity: Vec<f64>,
    /// b·v of the poles.
    driven: Vec<f64>,
    ahead: OnceLock<Ahead>,
}

/// The end of the next step of usual length, for zero velocity there.
struct Ahead {
    states: Arc<Vec<f64>>,
    pressure: Vec<f64>,
}

/// The step of usual length.
struct Step {
    length: f64,
    factors: Factors,
    /// `φ₀ + e^z φ₁`.
    both: Parts,
    /// ∂p/∂v at the step's end, as a matrix and in panels for products.
    instantaneous: DMatrix<f64>,
    panels: Panels,
}

/// e^z, φ₀ and φ₁ of every pole.
struct Factors {
    decay: Parts,
    start: Parts,
    end: Parts,
}

impl Recursion {
    /// The recursion of `fractions`; steps of `usual_length` (s) are prepared, other lengths take more time.
    pub fn of(fractions: &PartialFractions, usual_length: f64) -> Self {
        Self::new(fractions.poles.clone(), Ports::of(fractions), fractions.direct.clone(), usual_length)
    }

    /// The recursion of `poles` (1/s) with these ports and D; poles without input fill the last group.
    pub fn new(mut poles: Vec<Complex64>, ports: Ports, direct: DMatrix<f64>, usual_length: f64) -> Self {
        poles.resize(ports.groups.iter().map(|group| group.length).sum(), IDLE);
        let holds = poles.iter().map(|&pole| first_order_hold(pole, usual_length));
        let both = parts(holds.map(|[decay, start, end]| start + decay * end));
        let factors = Factors::of(&poles, usual_length);
        let instantaneous = response_within(&ports, &direct, &factors);
        let panels = Panels::of(&instantaneous);
        Self {
            poles,
            ports,
            direct,
            usual: Step { length: usual_length, factors, both, instantaneous, panels },
        }
    }

    /// Whether it is one of `points` points and `inputs` velocities.
    pub fn is_of(&self, points: usize, inputs: usize) -> bool {
        self.direct.shape() == (points, inputs) && self.ports.inputs.columns() == inputs
    }

    fn ahead<'a>(&self, state: &'a State) -> &'a Ahead {
        state.ahead.get_or_init(|| {
            let Step { factors: Factors { decay, .. }, both, .. } = &self.usual;
            let (groups, states) = (&self.ports.groups, &state.states);
            let states = Advance { groups, states, decay, driven: &state.driven, factor: both }.states();
            Ahead { pressure: self.ports.collected(&states), states: Arc::new(states) }
        })
    }

    /// Re x, then Im x at the end of a step of any length (s) after `state`; `driven` is b·v there.
    fn stepped(&self, state: &State, driven: &[f64], length: f64) -> Vec<f64> {
        let Factors { decay, start, end } = Factors::of(&self.poles, length);
        let groups = &self.ports.groups;
        let states = self.driven(&state.states, &state.driven, &self.usual.factors.end);
        let states =
            Advance { groups, states: &states, decay: &decay, driven: &state.driven, factor: &start };
        self.driven(&states.states(), driven, &end)
    }

    /// The states and `factor b·v`.
    fn driven(&self, states: &[f64], driven: &[f64], factor: &Parts) -> Vec<f64> {
        let order = self.poles.len();
        let decay = [vec![1.0; order], vec![0.0; order]];
        Advance { groups: &self.ports.groups, states, decay: &decay, driven, factor }.states()
    }

    fn memory(states: Arc<Vec<f64>>, velocity: &[f64], driven: Vec<f64>) -> Memory {
        Memory::of(State { states, velocity: velocity.to_vec(), driven, ahead: OnceLock::new() })
    }
}

/// Poles, ports, D and the usual length, from which the rest follows.
impl Serialize for Recursion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (&self.poles, &self.ports, &self.direct, self.usual.length).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Recursion {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (poles, ports, direct, length) = Deserialize::deserialize(deserializer)?;
        Ok(Self::new(poles, ports, direct, length))
    }
}

impl TimeDomain for Recursion {
    fn at_rest(&self) -> Memory {
        let velocity = vec![0.0; self.ports.inputs.columns()];
        let states = Arc::new(vec![0.0; 2 * self.poles.len()]);
        Self::memory(states, &velocity, self.ports.inputs.product(&velocity))
    }

    fn pressure(&self, memory: &Memory, velocity: &[f64], length: f64) -> Option<Vec<f64>> {
        let state = memory.get()?;
        if length == self.usual.length {
            let mut pressure = self.usual.panels.product(velocity);
            pressure.iter_mut().zip(&self.ahead(state).pressure).for_each(|(p, free)| *p += free);
            return Some(pressure);
        }
        let states = self.stepped(state, &self.ports.inputs.product(velocity), length);
        let direct = &self.direct * DVector::from_column_slice(velocity);
        Some(self.ports.collected(&states).iter().zip(&direct).map(|(p, within)| p + within).collect())
    }

    fn push(&self, memory: &Memory, velocity: &[f64], length: f64) -> Option<Memory> {
        let state = memory.get()?;
        let driven = self.ports.inputs.product(velocity);
        let states = if length == self.usual.length {
            self.ahead(state).states.clone()
        } else {
            let left_out = self.usual.factors.end.each_ref().map(|part| part.iter().map(|f| -f).collect());
            Arc::new(self.driven(&self.stepped(state, &driven, length), &driven, &left_out))
        };
        Some(Self::memory(states, velocity, driven))
    }

    fn instantaneous(&self, length: f64) -> DMatrix<f64> {
        if length == self.usual.length {
            return self.usual.instantaneous.clone();
        }
        response_within(&self.ports, &self.direct, &Factors::of(&self.poles, length))
    }

    fn values(&self, memory: &Memory) -> Option<Vec<f64>> {
        memory.get().map(|state: &State| [&state.states[..], &state.velocity].concat())
    }

    fn resume(&self, values: &[f64], _steps: usize) -> Option<Memory> {
        let (states, velocity) = values.split_at_checked(2 * self.poles.len())?;
        let whole = velocity.len() == self.ports.inputs.columns();
        whole.then(|| Self::memory(Arc::new(states.to_vec()), velocity, self.ports.inputs.product(velocity)))
    }
}

impl Factors {
    fn of(poles: &[Complex64], length: f64) -> Self {
        let all: Vec<[Complex64; 3]> = poles.iter().map(|&pole| first_order_hold(pole, length)).collect();
        let [decay, start, end] = [0, 1, 2].map(|i| parts(all.iter().map(|factors| factors[i])));
        Self { decay, start, end }
    }
}

/// ∂p/∂v at the end of a step: `D + Σ_k c_k φ₁ b_kᵀ`, column after column.
fn response_within(
    ports: &Ports,
    direct: &DMatrix<f64>,
    Factors { decay, end, .. }: &Factors,
) -> DMatrix<f64> {
    let mut response = direct.clone();
    let mut unit = vec![0.0; ports.inputs.columns()];
    let rest = vec![0.0; 2 * end[0].len()];
    for j in 0..unit.len() {
        unit[j] = 1.0;
        let (groups, driven) = (&ports.groups, ports.inputs.product(&unit));
        let driven = Advance { groups, states: &rest, decay, driven: &driven, factor: end };
        unit[j] = 0.0;
        let mut column = response.column_mut(j);
        column.iter_mut().zip(ports.collected(&driven.states())).for_each(|(p, x)| *p += x);
    }
    response
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The recursion against the formula in complex numbers. The number of poles is not a multiple of the block, one pole is
    /// real, a third of the steps has another length, and a serialised memory continues with the same bits.
    #[test]
    fn steps_are_those_of_the_formula() {
        let poles: Vec<Complex64> = [(-1.0, 20.0), (-3.0, 7.0), (-0.5, 0.0), (-40.0, 90.0), (-9.0, 2.0)]
            .map(|(re, im)| Complex64::new(re, im))
            .into();
        let number = |i: usize, k: usize| Complex64::from_polar(1.0 + i as f64, (3 * i + 5 * k) as f64);
        let real = |k: usize, z: Complex64| if poles[k].im > 0.0 { z } else { z.re.into() };
        let fractions = PartialFractions {
            outputs: DMatrix::from_fn(3, 5, |i, k| real(k, number(i, k))),
            inputs: DMatrix::from_fn(2, 5, |i, k| real(k, number(i, k + 7))),
            direct: DMatrix::from_fn(3, 2, |i, j| (i + 2 * j) as f64),
            poles: poles.clone(),
        };
        let recursion = Recursion::of(&fractions, 0.01);
        let mut memory = recursion.at_rest();
        let (mut x, mut before, mut worst) = (vec![Complex64::ZERO; 5], [0.0; 2], 0.0f64);
        for n in 1..=60 {
            let length = if n % 3 == 0 { 0.025 } else { 0.01 };
            let v = [(0.7 * f64::from(n)).sin(), (0.3 * f64::from(n)).cos() - 1.0];
            let along =
                |k: usize, v: [f64; 2]| fractions.inputs[(0, k)] * v[0] + fractions.inputs[(1, k)] * v[1];
            for (k, x) in x.iter_mut().enumerate() {
                let [decay, start, end] = first_order_hold(poles[k], length);
                *x = decay * *x + start * along(k, before) + end * along(k, v);
            }
            let pressure = recursion.pressure(&memory, &v, length).expect("its memory");
            for (i, p) in pressure.iter().enumerate() {
                let pair = |k: usize| if poles[k].im > 0.0 { 2.0 } else { 1.0 };
                let states: f64 = (0..5).map(|k| pair(k) * (fractions.outputs[(i, k)] * x[k]).re).sum();
                let direct = fractions.direct[(i, 0)] * v[0] + fractions.direct[(i, 1)] * v[1];
                worst = worst.max((p - states - direct).abs());
            }
            let resumed = recursion.values(&memory).and_then(|values| recursion.resume(&values, n as usize));
            let resumed = resumed.expect("a memory");
            assert_eq!(recursion.pressure(&resumed, &v, length).as_ref(), Some(&pressure));
            memory = recursion.push(&resumed, &v, length).expect("its memory");
            before = v;
        }
        println!("steps off the formula by {worst:.1e}, of values up to some 10");
        assert!(worst < 1e-12);
        let foreign = Memory::of(0.0);
        assert!(recursion.pressure(&foreign, &before, 0.01).is_none());
        assert!(recursion.push(&foreign, &before, 0.01).is_none() && recursion.values(&foreign).is_none());
    }
}
