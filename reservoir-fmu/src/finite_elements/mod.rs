//! Finite elements of the near field, for comparison with the boundary elements: Newmark's method, a Sommerfeld end.
//!
//! The models with which the paper compares its own work in this way. Quadratic triangles fill the water between face,
//! bed, surface and a vertical far end, where
//!
//! ```text
//! ∂p/∂n = −ṗ/c
//! ```
//!
//! is exact for plane waves only. A mode that decays upstream, `e^{κx}`, is reflected with the ratio
//! `(κ − s/c)/(κ + s/c)`, of modulus 1 for every κ below its cut-off frequency. The end must therefore lie where
//! `e^{−2κL}` is small; at a cut-off frequency no distance is large enough (`tests/sommerfeld.rs`).
//!
//! ```text
//!    far end  level: p = 0, or ∂p/∂n = −p̈/g
//!    ┌────────────────────────┐
//!    │ column                 │ → n   wet face: ∂p/∂n = −ρ v̇
//!    │    near field           ╲
//!    └────────────╮             │
//!                  ╰────────────┘ heel
//!      bed: ∂p/∂n = −ρ v̇_g·n − q ṗ
//! ```
//!
//! **Equations** by Galerkin's method, with p at the unknown nodes, v at the interface points (out of the water), `v_g`
//! the velocity of the ground, n out of the water:
//!
//! ```text
//! M p̈ + C ṗ + K p = −ρ (L v̇ + L_g v̇_g) + B ṗ_column
//! M = ∫ N N /c² dA (+ ∫ N N /g ds on a level with gravity waves),   K = ∫ ∇N · ∇N dA
//! C = q ∫ N N ds on the bed + ∫ N N ds /c on the far end,           L_g = ∫ N n ds on the bed
//! ```
//!
//! Vertical motion of the ground lifts all water upstream, and this pressure does not radiate. It is computed in a
//! column at the far end with the same elements and steps; the far end radiates only the difference from it (B).
//!
//! **Time.** Velocities are linear within a step, and accelerations jump at its ends. The equations are therefore
//! integrated once, ψ = ∫ p dt (−∇ψ/ρ is the water's velocity), and stepped by Newmark's average acceleration, the
//! trapezoidal rule:
//!
//! ```text
//! (M + H/2 C + H²/4 K) p̄ = M p₀ − H/2 (K ψ₀ + ρ L v̄ + … − B p̄_column),   p₁ = 2 p̄ − p₀,  ψ₁ = ψ₀ + H p̄
//! ```
//!
//! where the bar is the mean of both ends of the step.
//!
//! **Energy.** Let `E = (pᵀ M p + ψᵀ K ψ)/2ρ`, the energy of compression (and of surface waves) and of motion. With the
//! ground at rest, the scheme multiplied by H p̄/ρ gives for every step, to rounding,
//!
//! ```text
//! E₁ − E₀ + H p̄ᵀ C p̄/ρ = −H p̄ᵀ L v̄ = −H v̄ᵀ M_Γ p̄_Γ,   p_Γ = M_Γ⁻¹ Lᵀ p
//! ```
//!
//! because pressure at the points is work-conjugate to the load (`interface_load`). E and C are not negative: from
//! rest, the mid-step work `W_mid = −Σ H v̄ᵀ M_Γ p̄_Γ` is the energy stored and lost in the water, and never negative. The
//! work of pressure and velocity that are both linear within a step is
//!
//! ```text
//! W = −Σ ∫ v_linᵀ M_Γ p_lin dt = W_mid − H/12 Σ Δvᵀ M_Γ Δp_Γ
//! ```
//!
//! and the second sum is not positive either: the scheme is linear and the same for every step, so that the response
//! to the velocities Δv is Δp. Let w be the velocities with w₀ = 0 and means w̄ = Δv; their response r has the means Δp,
//! since both follow by the same recursion. Then `−H Σ Δvᵀ M_Γ Δp = −H Σ w̄ᵀ M_Γ r̄` is the mid-step work of w and
//! r, and not negative. Hence W ≥ W_mid ≥ 0 after any number of steps: the water cannot feed energy into a dam,
//! on any mesh and with steps of any length. The proof needs an exchange after every step of the water; therefore a
//! communication step is one step.

mod assembly;
mod domain;
mod element;
mod far_field;
mod free_field;
mod interface_load;
mod matrices;
mod mesh;
mod pressure_field;
mod stepped;
mod time_step;

use crate::{ReservoirError, ReservoirParameters};
use domain::Domain;
use faer::Mat;
use free_field::FreeField;
use nalgebra::DMatrix;
use num_complex::Complex64;
pub use pressure_field::PressureField;
pub use time_step::Prepared;
use time_step::TimeStep;

/// Largest number of entries of the response of all nodes to all inputs, which is stored.
const MOST_ENTRIES: f64 = 1e8;

/// Condition at the upstream end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FarEnd {
    /// `∂p/∂n = −ṗ/c`: plane waves leave, other waves are partly reflected.
    Sommerfeld,
    /// `∂p/∂n = −(π/2d) (p − p_column)`: the first mode of incompressible water leaves no trace.
    Decay,
    /// `∂p/∂n = 0`: a closed tank.
    Rigid,
}

/// Compressible water by finite elements; pressure at the interface points for their velocities.
///
/// **Shapes and units**: inputs are the velocities of the interface points along n and of the ground along x
/// and y (m/s), points + 2; a state is ψ (Pa s) and p (Pa) at the unknown nodes, the same for the column at the far end, and
/// the inputs at the end of the last step. The state of rest is all zeros.
pub struct FiniteElements {
    domain: Domain,
    free_field: Option<FreeField>,
    density: f64,
    time_step: TimeStep,
}

impl FiniteElements {
    /// Triangulates the parameters' water, assembles, and factors for their communication step.
    ///
    /// **Errors**: parameters out of range, [`ReservoirError::TooMuch`],
    /// [`ReservoirError::Mesh`], [`ReservoirError::FiniteElementSystem`].
    pub fn new(parameters: &ReservoirParameters) -> Result<Self, ReservoirError> {
        Self::with_far_end(parameters, FarEnd::Sommerfeld)
    }

    /// The same with a given condition at the far end.
    ///
    /// **Errors**: as [`new`](Self::new).
    pub fn with_far_end(parameters: &ReservoirParameters, far_end: FarEnd) -> Result<Self, ReservoirError> {
        parameters.validate()?;
        let domain = Domain::new(parameters, far_end)?;
        let inputs = parameters.wet_face.len() + 2;
        let entries = domain.matrices.size() as f64 * inputs as f64;
        if entries > MOST_ENTRIES {
            let what = "entries of the nodes' answer to the inputs";
            let remedy = "raise `element_size`, or take fewer points";
            return Err(ReservoirError::TooMuch { what, value: entries, most: MOST_ENTRIES, remedy });
        }
        let free_field = (far_end == FarEnd::Sommerfeld).then(|| FreeField::new(parameters, &domain));
        let density = parameters.density;
        let time_step = TimeStep::new(parameters.communication_step, density, &domain, free_field.as_ref())?;
        Ok(Self { domain, free_field, density, time_step })
    }

    /// The same water with steps of another length (s): factors the matrix again and solves for the responses to unit
    /// inputs, which is most of the cost of [`new`](Self::new).
    ///
    /// **Errors**: [`ReservoirError::NotPositive`], [`ReservoirError::FiniteElementSystem`].
    pub fn set_communication_step(&mut self, step: f64) -> Result<(), ReservoirError> {
        if !(step > 0.0 && step.is_finite()) {
            let parameter = "communication_step";
            return Err(ReservoirError::NotPositive { parameter, value: step, unit: "s" });
        }
        self.time_step = TimeStep::new(step, self.density, &self.domain, self.free_field.as_ref())?;
        Ok(())
    }

    /// Number of inputs: interface points, then the ground along x and y.
    pub fn inputs(&self) -> usize {
        self.domain.load.points() + 2
    }

    /// Length of a state.
    pub fn state_len(&self) -> usize {
        2 * self.domain.matrices.size() + 2 * self.column_size() + self.inputs()
    }

    /// The part of the step from `state` (of length [`state_len`](Self::state_len)) that does not depend on the inputs at
    /// its end; it costs one solve. Repeating the step with other inputs then costs little.
    pub fn prepare(&self, state: &[f64]) -> Prepared {
        self.time_step.prepare(state, self.density, &self.domain, self.free_field.as_ref())
    }

    /// Pressure (Pa) at the interface points at the step's end: a product of points × inputs.
    pub fn pressure(&self, prepared: &Prepared, inputs_at_end: &[f64]) -> Vec<f64> {
        self.time_step.pressure(prepared, inputs_at_end)
    }

    /// Writes the state at the step's end: a product of nodes × inputs.
    pub fn advance(&self, state: &[f64], prepared: &Prepared, inputs_at_end: &[f64], next: &mut [f64]) {
        self.time_step.advance(state, prepared, inputs_at_end, self.sizes(), next);
    }

    /// Writes the state at the step's end and gives the pressure (Pa) at the interface points there;
    /// [`prepare`](Self::prepare), [`pressure`](Self::pressure) and [`advance`](Self::advance) in one.
    pub fn step(&self, state: &[f64], inputs_at_end: &[f64], next: &mut [f64]) -> Vec<f64> {
        let prepared = self.prepare(state);
        self.advance(state, &prepared, inputs_at_end, next);
        self.pressure(&prepared, inputs_at_end)
    }

    /// ∂p/∂(inputs at the step's end): Pa per m/s, points × inputs. Its square part, multiplied by M_Γ from the left, is symmetric.
    pub fn instantaneous(&self) -> &DMatrix<f64> {
        self.time_step.instantaneous()
    }

    /// Interface pressure (Pa) for a unit velocity (m/s) of each input, `P(s) = K(s) V(s)`, points × inputs.
    ///
    /// The steps have this symbol at `s = 2(1 − ζ)/(H(1 + ζ))`, ζ the shift by one step.
    ///
    /// **Errors**: [`ReservoirError::Frequency`], [`ReservoirError::FiniteElementSystem`].
    pub fn symbol(&self, s: Complex64) -> Result<DMatrix<Complex64>, ReservoirError> {
        if !(s.re >= 0.0 && s.is_finite() && s != Complex64::ZERO) {
            return Err(ReservoirError::Frequency { frequency: s });
        }
        let (inputs, points) = (self.inputs(), self.domain.load.points());
        let mut right = Mat::<Complex64>::zeros(self.domain.matrices.size(), inputs);
        for input in 0..inputs {
            let load = self.domain.unit_load(input);
            load.iter().enumerate().for_each(|(i, l)| right[(i, input)] = -self.density * s * l);
        }
        if let Some(column) = &self.free_field {
            let mut foot = Mat::zeros(column.size(), 1);
            foot[(column.foot, 0)] = self.density * s;
            let pressure = column.matrices.solve_at(s, foot)?;
            let mut passed = [vec![0.0; self.domain.matrices.size()], vec![0.0; self.domain.matrices.size()]];
            for (passed, part) in passed.iter_mut().zip([|z: Complex64| z.re, |z: Complex64| z.im]) {
                let pressure: Vec<f64> = (0..column.size()).map(|i| part(pressure[(i, 0)])).collect();
                column.add(1.0, &pressure, passed);
            }
            for (i, (re, im)) in passed[0].iter().zip(&passed[1]).enumerate() {
                right[(i, points + 1)] += s * Complex64::new(*re, *im);
            }
        }
        let solution = self.domain.matrices.solve_at(s, right)?;
        let mut symbol = DMatrix::zeros(points, inputs);
        for input in 0..inputs {
            let [re, im] = [|z: Complex64| z.re, |z: Complex64| z.im].map(|part| {
                let p: Vec<f64> =
                    (0..self.domain.matrices.size()).map(|i| part(solution[(i, input)])).collect();
                self.domain.load.pressure(&p)
            });
            (0..points).for_each(|i| symbol[(i, input)] = Complex64::new(re[i], im[i]));
        }
        Ok(symbol)
    }

    /// `E = (pᵀ M p + ψᵀ K ψ)/2ρ`: energy of a state, J per metre of dam.
    pub fn energy(&self, state: &[f64]) -> f64 {
        let (psi, p) = state[..2 * self.domain.matrices.size()].split_at(self.domain.matrices.size());
        (self.domain.matrices.forms(p)[0] + self.domain.matrices.forms(psi)[2]) / (2.0 * self.density)
    }

    /// `H p̄ᵀ C p̄/ρ`: energy lost through bed and far end in the step between two states, J per metre of dam.
    pub fn loss(&self, before: &[f64], after: &[f64]) -> f64 {
        let pressures = self.domain.matrices.size()..2 * self.domain.matrices.size();
        let mean: Vec<f64> = pressures.map(|i| 0.5 * (before[i] + after[i])).collect();
        self.time_step.length() * self.domain.matrices.forms(&mean)[1] / self.density
    }

    /// Coordinates of the nodes, m.
    pub fn nodes(&self) -> &[[f64; 2]] {
        &self.domain.mesh.nodes
    }

    /// Nodes of each triangle: corners counterclockwise, then the middles of the sides from the first corner to
    /// the second, the second to the third, the third to the first.
    pub fn triangles(&self) -> &[[usize; 6]] {
        &self.domain.mesh.triangles
    }

    /// Pressure (Pa) at every node in a state.
    pub fn pressures(&self, state: &[f64]) -> Vec<f64> {
        self.domain.at_nodes(&state[self.domain.matrices.size()..])
    }

    fn column_size(&self) -> usize {
        self.free_field.as_ref().map_or(0, FreeField::size)
    }

    /// Unknowns of water and column.
    fn sizes(&self) -> [usize; 2] {
        [self.domain.matrices.size(), self.column_size()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::BoundaryCondition;
    use element::EDGE_MEAN;
    use mesh::rugged;

    /// The pressure is `p = ρ(h − y)` if ground and dam accelerate upwards by 1 m/s²: linear, so exact to rounding.
    #[test]
    fn linear_pressure_is_exact() -> Result<(), ReservoirError> {
        for surface_waves in [false, true] {
            let parameters = ReservoirParameters { surface_waves, ..rugged(6.0) };
            let water = FiniteElements::with_far_end(&parameters, FarEnd::Rigid)?;
            let (face, density) = (&parameters.wet_face, parameters.density);
            // With waves p at the surface is unknown, and its load is the traction −∂p/∂n = ρ.
            let mut residual = vec![0.0; water.domain.matrices.size()];
            let mut p = vec![0.0; water.domain.matrices.size()];
            for (node, unknown) in water.nodes().iter().zip(&water.domain.unknowns) {
                unknown.iter().for_each(|&u| p[u] = density * (face.depth() - node[1]));
            }
            let zeros = vec![0.0; p.len()];
            for (r, k) in residual.iter_mut().zip(water.domain.matrices.mass_and_stiffness(&zeros, 1.0, &p)) {
                *r += k;
            }
            let mut velocity = vec![0.0; face.len()];
            face.panels().for_each(|panel| velocity[panel.start..panel.start + 2].fill(panel.normal[1]));
            water.domain.load.add(density, &velocity, &mut residual);
            residual.iter_mut().zip(&water.domain.ground[1]).for_each(|(r, l)| *r += density * l);
            for edge in water.domain.mesh.edges(BoundaryCondition::SurfaceWaves) {
                for (node, mean) in edge.nodes.into_iter().zip(EDGE_MEAN) {
                    water.domain.unknowns[node]
                        .iter()
                        .for_each(|&u| residual[u] += density * edge.length * mean);
                }
            }
            let largest = residual.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
            println!(
                "patch, waves {surface_waves}: residual {largest:.1e} of a load of {:.1e}",
                density * 6.0
            );
            // Rounding of some ten additions of numbers of ρh.
            assert!(largest < 1e-12 * density * face.depth());
            // A linear field is reproduced at the points.
            let at_points = water.domain.load.pressure(&p);
            let exact = face.points().iter().map(|q| density * (face.depth() - q[1]));
            let error = at_points.iter().zip(exact).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            assert!(error < 1e-12 * density * face.depth(), "{error}");
        }
        Ok(())
    }

    /// Results are equal bit for bit for any number of threads.
    #[test]
    fn made_twice_it_is_the_same() -> Result<(), ReservoirError> {
        let parameters = rugged(4.0);
        let first = FiniteElements::new(&parameters)?;
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            let again = pool.install(|| FiniteElements::new(&parameters))?;
            assert!(first.domain == again.domain);
            assert_eq!(first.instantaneous(), again.instantaneous());
        }
        Ok(())
    }

    /// `M_Γ ∂p/∂v` is symmetric and negative, as is `−Lᵀ A⁻¹ L`, to the rounding of the solves.
    #[test]
    fn instantaneous_answer_is_symmetric_and_negative() -> Result<(), ReservoirError> {
        let parameters = rugged(5.0);
        let water = FiniteElements::new(&parameters)?;
        let points = parameters.wet_face.len();
        let mut mass = DMatrix::zeros(points, points);
        for panel in parameters.wet_face.panels() {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                mass[(panel.start + i, panel.start + j)] += panel.length / if i == j { 3.0 } else { 6.0 };
            }
        }
        let form = mass * water.instantaneous().columns(0, points);
        let asymmetry = (&form - form.transpose()).amax() / form.amax();
        let largest = nalgebra::SymmetricEigen::new(0.5 * (&form + form.transpose())).eigenvalues.max();
        println!(
            "instantaneous: asymmetry {asymmetry:.1e}, largest eigenvalue {:.2e}",
            largest / form.amax()
        );
        assert!(asymmetry < 1e-12 && largest < 0.0);
        Ok(())
    }
}
