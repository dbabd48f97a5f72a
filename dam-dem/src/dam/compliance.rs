//! How the wet face yields to pressure within a step.

use cofferdam_unit::{CoSimulation, variables::dam as variable};
use nalgebra::DMatrix;

use super::Dam;
use crate::DamError;
use crate::error::require;

/// Response of the upstream wet face of a dam to the pressure on it within one communication step.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceCompliance {
    /// `∂(interface_displacement)/∂(interface_pressure)`, both at the end of the step, m/Pa; one column for
    /// each point under pressure.
    pub displacement: DMatrix<f64>,
    /// `∂(interface_acceleration)/∂(interface_pressure)`: mean acceleration over the step, pressure at its
    /// end, m/s² per Pa.
    pub acceleration: DMatrix<f64>,
}

impl Dam {
    /// The compliance of the upstream wet face in a step of `communication_step` (s) from the current state, by finite
    /// differences: one step for each interface point with its pressure increased by `probe` (Pa), minus one
    /// step without.
    ///
    /// Quasi-Newton schemes can use it as an initial Jacobian. From the state of rest it is the compliance of
    /// an elastic dam with sticking contacts, damping included. Where contacts slip or open within the step,
    /// no derivative exists and the result depends on the probe. The dam itself does not change.
    ///
    /// **Errors**: as [`step`](CoSimulation::step), and [`DamError::OutOfRange`] for a probe of 0.
    pub fn interface_compliance(
        &self,
        communication_step: f64,
        probe: f64,
    ) -> Result<InterfaceCompliance, DamError> {
        require(probe != 0.0 && probe.is_finite(), "probe", probe, "finite and not 0")?;
        let mut dam = self.clone();
        let (state, time) = (self.save_state(), self.state().time());
        let points = self.size(&variable::INTERFACE_PRESSURE);
        let mut pressure = vec![0.0; points];
        self.get(variable::INTERFACE_PRESSURE.value_reference, &mut pressure)?;
        let mut answer = |pressure: &[f64]| -> Result<[Vec<f64>; 2], DamError> {
            dam.restore_state(&state)?;
            dam.set(variable::INTERFACE_PRESSURE.value_reference, pressure)?;
            dam.step(time, communication_step)?;
            let mut found = [vec![0.0; points], vec![0.0; points]];
            dam.get(variable::INTERFACE_DISPLACEMENT.value_reference, &mut found[0])?;
            dam.get(variable::INTERFACE_ACCELERATION.value_reference, &mut found[1])?;
            Ok(found)
        };
        let without = answer(&pressure)?;
        let [mut displacement, mut acceleration] = [0, 1].map(|_| DMatrix::zeros(points, points));
        for point in 0..points {
            pressure[point] += probe;
            let with = answer(&pressure)?;
            pressure[point] -= probe;
            for i in 0..points {
                displacement[(i, point)] = (with[0][i] - without[0][i]) / probe;
                acceleration[(i, point)] = (with[1][i] - without[1][i]) / probe;
            }
        }
        Ok(InterfaceCompliance { displacement, acceleration })
    }
}
