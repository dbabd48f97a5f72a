//! The elastic tube in one dimension, a hard test for the coupling: incompressible flow in a soft tube.
//!
//! ```text
//! ∂a/∂t + ∂(au)/∂x = 0,  ∂(au)/∂t + ∂(au²)/∂x + a ∂p/∂x = 0,  a = a₀ ((p₀ − 2c²)/(p − 2c²))²,  c² = E/2r₀
//! ```
//!
//! L = 10 in 100 cells, E = 10 000, a₀ = 1, ρ = 1, velocity at the inlet 10 + 3 sin(10πt), a non-reflecting outlet,
//! 100 steps of 0.01 by the implicit Euler method.
//!
//! **Source**: Degroote, Bruggeman, Haelterman and Vierendeels (2008); the numbers are those of the tutorial
//! `elastic-tube-1d` of preCICE.

use cofferdam_assembly::units::pair;
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
use cofferdam_coupling::scheme::{CouplingError, Predictor, Scheme, Settings, StepFailure};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use whole_chain::small_unit::{SmallUnit, interval};

const CELLS: usize = 100;
const POINTS: usize = CELLS + 1;
const LENGTH: f64 = 10.0;
const STEP: f64 = 0.01;

/// c²: half of Young's modulus over the radius 1/√π of a tube of unit area.
fn wave_speed_squared() -> f64 {
    10_000.0 / 2.0 * PI.sqrt()
}

fn area(pressure: f64) -> f64 {
    let twice = 2.0 * wave_speed_squared();
    (twice / (pressure - twice)).powi(2)
}

/// Velocity, pressure and area at the points.
#[derive(Clone)]
struct Flow {
    velocity: Vec<f64>,
    pressure: Vec<f64>,
    area: Vec<f64>,
}

impl Flow {
    /// The flow in a tube of area `area` one step later, at `time`: Newton's method on all velocities and pressures.
    fn after(&self, area: &[f64], time: f64) -> Self {
        let inlet = 10.0 + 3.0 * (10.0 * PI * time).sin();
        let mut unknowns: Vec<f64> = self.velocity.iter().chain(&self.pressure).copied().collect();
        for _ in 0..20 {
            let residual = DVector::from_vec(self.residual(&unknowns, area, inlet));
            let size = DVector::from_column_slice(&unknowns).norm();
            if residual.norm() < 1e-11 * size {
                break;
            }
            let Some(update) = self.jacobian(&unknowns, area).lu().solve(&residual) else {
                unknowns.fill(f64::NAN);
                break;
            };
            unknowns.iter_mut().zip(update.iter()).for_each(|(x, d)| *x -= d);
        }
        let (velocity, pressure) = unknowns.split_at(POINTS);
        Self { velocity: velocity.to_vec(), pressure: pressure.to_vec(), area: area.to_vec() }
    }

    /// Momentum and continuity in the cells about the points, by means on their faces, and the boundaries.
    fn residual(&self, unknowns: &[f64], area: &[f64], inlet: f64) -> Vec<f64> {
        let (u, p) = unknowns.split_at(POINTS);
        let storage = LENGTH / CELLS as f64 / STEP;
        let face = |i: usize| ((area[i] + area[i + 1]) / 2.0, (u[i] + u[i + 1]) / 2.0);
        let mut residual = vec![0.0; 2 * POINTS];
        for i in 1..CELLS {
            let ((a_in, u_in), (a_out, u_out)) = (face(i - 1), face(i));
            residual[i] = storage * (area[i] * u[i] - self.area[i] * self.velocity[i]) + a_out * u_out * u[i]
                - a_in * u_in * u[i - 1]
                + (a_out * (p[i + 1] - p[i]) + a_in * (p[i] - p[i - 1])) / 2.0;
            residual[POINTS + i] = storage * (area[i] - self.area[i]) + a_out * u_out - a_in * u_in;
        }
        residual[0] = u[0] - inlet;
        residual[CELLS] = u[CELLS] - 2.0 * u[CELLS - 1] + u[CELLS - 2];
        residual[POINTS] = p[0] - 2.0 * p[1] + p[2];
        let (c2, end) = (wave_speed_squared(), CELLS);
        let root = (c2 - self.pressure[end] / 2.0).sqrt() - (u[end] - self.velocity[end]) / 4.0;
        residual[POINTS + end] = p[end] - 2.0 * (c2 - root * root);
        residual
    }

    /// Derivatives of the residual, by central differences: it is a polynomial of the second degree, so they are exact
    /// to rounding.
    fn jacobian(&self, unknowns: &[f64], area: &[f64]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(2 * POINTS, 2 * POINTS);
        let mut moved = unknowns.to_vec();
        // A residual depends on points at most two apart: every fifth unknown of a kind is moved at once.
        for kind in [0, POINTS] {
            for first in 0..5 {
                let moving: Vec<usize> = (first..POINTS).step_by(5).collect();
                let mut sides = [1.0, -1.0].map(|change| {
                    moving.iter().for_each(|i| moved[kind + i] = unknowns[kind + i] + change);
                    self.residual(&moved, area, 0.0)
                });
                moving.iter().for_each(|i| moved[kind + i] = unknowns[kind + i]);
                let [above, below] = &mut sides;
                for &i in &moving {
                    for row in i.saturating_sub(2)..(i + 3).min(POINTS) {
                        for equation in [row, POINTS + row] {
                            matrix[(equation, kind + i)] = (above[equation] - below[equation]) / 2.0;
                        }
                    }
                }
            }
        }
        matrix
    }
}

/// Iterations of every step, up to the first failure.
fn iterations(acceleration: Acceleration) -> Result<Vec<u32>, StepFailure> {
    let solid = SmallUnit::dam(POINTS, (), vec![1.0; 2 * POINTS], |(), _, inputs, outputs| {
        let (displacement, acceleration) = outputs.split_at_mut(POINTS);
        for ((pressure, u), a) in inputs.iter().zip(displacement).zip(acceleration) {
            (*u, *a) = (area(*pressure), area(*pressure));
        }
    });
    let flow = Flow { velocity: vec![10.0; POINTS], pressure: vec![0.0; POINTS], area: vec![1.0; POINTS] };
    let fluid = SmallUnit::reservoir(POINTS, flow, vec![0.0; POINTS], |flow, at, inputs, outputs| {
        *flow = flow.after(&inputs[..POINTS], at.end());
        outputs.copy_from_slice(&flow.pressure);
    });
    let mut graph = pair(Box::new(solid), Box::new(fluid)).expect("two units");
    let measure = ConvergenceMeasure::new(
        &[Measure::Relative, Measure::Change],
        1e-5,
        Scales { typical: 0.01, bound: 1e12, ..Scales::default() },
    );
    let mut scheme =
        Scheme::new(&mut graph, Settings::default(), acceleration, Predictor::new(0), measure, Vec::new())
            .expect("the units fit");
    scheme.initialise(&mut graph, 0.0)?;
    (1..=100).map(|step| Ok(scheme.advance(&mut graph, &[interval(step, STEP)])?.iterations())).collect()
}

#[test]
fn iqn_ils_converges_in_every_step() -> Result<(), StepFailure> {
    let counts = iterations(Acceleration::new(AccelerationKind::IqnIls, 0.01, 1.0))?;
    let mean = f64::from(counts.iter().sum::<u32>()) / counts.len() as f64;
    let most = counts.iter().max().copied().unwrap_or(0);
    println!("elastic tube, IQN-ILS: {mean:.2} iterations a step on the mean, {most} at most");
    assert_eq!(counts.len(), 100);
    assert!(mean <= 6.5, "{mean}");
    Ok(())
}

#[test]
fn without_acceleration_it_diverges_and_that_is_said_in_the_step_where_it_happens() {
    let failure =
        iterations(Acceleration::new(AccelerationKind::Constant, 1.0, 1.0)).expect_err("it diverges");
    println!("elastic tube, no acceleration: {failure}");
    assert_eq!(failure.report.step(), 1);
    assert!(matches!(failure.error, CouplingError::Diverged { .. }), "{failure}");
}
