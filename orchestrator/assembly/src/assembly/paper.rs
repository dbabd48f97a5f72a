//! The water of the paper that Cofferdam is compared with, at the dam's own points.

use super::{Assembly, AssemblyError};
use cofferdam_reservoir::paper::{self, FarEndCondition, ShortWindows};
use cofferdam_scene::Side;
use nalgebra::{Complex, DMatrix};

impl Assembly<'_> {
    /// The paper's water, `steps` communication steps a window, before the dam's own points.
    pub fn short_windows(&self, steps: usize) -> Result<ShortWindows, AssemblyError> {
        Ok(ShortWindows::new(
            &self.parameters_at(self.dam_face(Side::Upstream)?)?,
            steps,
            self.making.threads,
        )?)
    }

    /// Pressure (Pa) at the dam's points over the whole record of `acceleration` (m/s², points and ground × instants).
    pub fn pressure_of_record(
        &self,
        far_end: FarEndCondition,
        acceleration: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>, AssemblyError> {
        let parameters = self.parameters_at(self.dam_face(Side::Upstream)?)?;
        Ok(paper::pressure_before(far_end, &parameters, acceleration, self.making.threads)?)
    }

    /// K(s) of a scene's water at the dam's points.
    pub fn frequency_response(
        &self,
        far_end: FarEndCondition,
        s: &[Complex<f64>],
    ) -> Result<Vec<DMatrix<Complex<f64>>>, AssemblyError> {
        let parameters = self.parameters_at(self.dam_face(Side::Upstream)?)?;
        Ok(paper::response_before(far_end, &parameters, s, self.making.threads)?)
    }
}
