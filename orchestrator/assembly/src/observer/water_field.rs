use crate::units::TAILWATER;
use crate::vtk::{Field, Grid};
use cofferdam_coupling::observer::ObserverError;
use cofferdam_coupling::participant::Description;
use cofferdam_coupling::scheme::{UnitId, WindowReport};
use std::error::Error;
use std::ops::Range;

/// The pressure inside a water, found from the motion that its unit is given.
///
/// **Call order**: [`advance`](Self::advance) for every accepted step, from the water at rest on; the rest at any time.
/// Coordinates are the dam's.
pub trait WaterField {
    /// The unit whose water it is.
    fn unit(&self) -> UnitId;

    /// Nodes, m.
    fn nodes(&self) -> Vec<[f64; 2]>;

    /// The nodes of each triangle: corners counterclockwise, then the middles of the sides, the first between the first two corners.
    fn triangles(&self) -> Vec<[usize; 6]>;

    /// Hydrostatic pressure at every node, Pa.
    fn hydrostatic_pressure(&self) -> Vec<f64>;

    /// Goes on by `length` (s): mean acceleration of the unit's points along n, acceleration (x, y) of the ground at the begin and the end,
    /// all in m/s².
    ///
    /// **Errors**: those of the solver.
    fn advance(
        &mut self,
        face: &[f64],
        ground: [[f64; 2]; 2],
        length: f64,
    ) -> Result<(), Box<dyn Error + Send + Sync>>;

    /// Hydrodynamic pressure at every node, Pa.
    fn pressure(&self) -> Vec<f64>;
}

/// The names of the parts.
pub(super) const PARTS: [&str; 2] = ["reservoir", "tailwater"];

/// A water of the pictures.
pub(super) struct Water {
    field: Box<dyn WaterField>,
    /// The points' acceleration and the ground's in the unit's inputs.
    ranges: [Range<usize>; 2],
    /// The ground's acceleration at the end of the last step, m/s².
    ground: [f64; 2],
}

impl Water {
    pub(super) fn new(field: Box<dyn WaterField>) -> Self {
        Self { field, ranges: Default::default(), ground: [0.0; 2] }
    }

    /// Finds its inputs among those of the units.
    pub(super) fn begin(&mut self, units: &[Description]) {
        let Description { inputs, .. } = &units[self.field.unit().0];
        self.ranges = ["interface_acceleration", "ground_acceleration"]
            .map(|name| inputs.range(name).unwrap_or_default());
    }

    /// Follows the accepted steps of a window.
    pub(super) fn follow(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        for step in &report.steps {
            let Some(exchange) = report.accepted(self.field.unit(), step.step) else { continue };
            let [face, ground] = self.ranges.each_ref().map(|range| &exchange.inputs[range.clone()]);
            let begin = self.ground;
            self.ground = [0, 1].map(|axis| ground.get(axis).copied().unwrap_or_default());
            if step.communication_step > 0.0 {
                let advanced = self.field.advance(face, [begin, self.ground], step.communication_step);
                advanced.map_err(ObserverError::Other)?;
            }
        }
        Ok(())
    }

    /// Its picture.
    pub(super) fn grid(&self) -> Grid {
        Grid {
            points: self.field.nodes(),
            cells: self.field.triangles().into_iter().map(Vec::from).collect(),
            point_data: vec![
                Field::scalar("hydrodynamic_pressure [Pa]", self.field.pressure()),
                Field::scalar("hydrostatic_pressure [Pa]", self.field.hydrostatic_pressure()),
            ],
            cell_data: Vec::new(),
            field_data: Vec::new(),
        }
    }

    /// The name of its part.
    pub(super) fn part(&self) -> &'static str {
        if self.field.unit() == TAILWATER { PARTS[1] } else { PARTS[0] }
    }
}
