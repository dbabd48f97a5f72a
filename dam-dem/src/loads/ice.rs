use serde::{Deserialize, Serialize};

use super::fixed::{Fixed, check_level};
use super::{LoadBasis, face};
use crate::error::{DamError, require};
use crate::{Mesh, Section};

/// Thrust of an ice sheet on the upstream side, horizontal and downstream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ice {
    /// Where it acts: elevation above the heel, m.
    pub elevation: f64,
    /// Thrust, N/m.
    pub force: f64,
    /// Factor on it.
    pub factor: f64,
}

impl Fixed for Ice {
    fn forces(&self, mesh: &Mesh, _: f64) -> Option<LoadBasis> {
        let chain = mesh.upstream.windows(2);
        let mut panels = chain.map(|pair| [pair[0], pair[1]].map(|node| mesh.nodes[node]));
        let [lower, upper] = panels.find(|[a, b]| a[1] < b[1] && (a[1]..=b[1]).contains(&self.elevation))?;
        let share = (self.elevation - lower[1]) / (upper[1] - lower[1]);
        let x = lower[0] + share * (upper[0] - lower[0]);
        face::at_point(mesh, [x, self.elevation], [self.factor * self.force, 0.0])
    }

    fn check(&self, section: &Section) -> Result<(), DamError> {
        check_level("elevation", self.elevation, &section.upstream)?;
        require(self.force >= 0.0, "force", self.force, "zero or positive")?;
        require(self.factor >= 0.0, "factor", self.factor, "zero or positive")
    }
}
