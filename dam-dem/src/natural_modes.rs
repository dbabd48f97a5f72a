//! Natural modes of the intact dam, empty or with its water.

use crate::modal::{self, DegreesOfFreedom};
use crate::model::Model;
use crate::{CrackParameters, DamError, DamParameters, Damping, Fidelity};

/// Natural modes of the intact dam without damping, with the added mass X of the water if the parameters give one:
///
/// ```text
/// K φ = ω² (M + X) φ,    φᵢᵀ (M + X) φⱼ = δᵢⱼ
/// ```
///
/// With X of incompressible water these are the modes of the full reservoir at frequencies far below the first cut-off frequency
/// of the water; compressible water lowers ω₁ further and radiates.
///
/// **Units**: per metre of dam; tested in `tests/natural_modes.rs`.
#[derive(Clone, Debug, PartialEq)]
pub struct NaturalModes {
    /// Frequencies ω, rad/s, ascending.
    pub frequencies: Vec<f64>,
    /// For each mode φ, x and y at every node of the [mesh](DamParameters::mesh), (kg/m)^(−½). The largest component is positive.
    pub shapes: Vec<Vec<[f64; 2]>>,
}

impl DamParameters {
    /// The `count` lowest natural modes of the dam that these parameters make, whatever its fidelity and damping.
    ///
    /// **Errors**: as [`check`](Self::check), [`DamError::AddedMassShape`], [`DamError::AddedMassNegative`], and as
    /// [`modal::natural_modes`].
    pub fn natural_modes(&self, count: usize) -> Result<NaturalModes, DamError> {
        self.check()?;
        let bare = Self { damping: Damping::None, fidelity: Fidelity::Dem, ..self.clone() };
        let mut cracks = self.cracks.clone();
        cracks.sort_by(CrackParameters::from_the_base_up);
        let (model, _) = Model::new(&bare, &cracks)?;
        let structure = &model.body().structure;
        let dofs = DegreesOfFreedom::intact(structure);
        let factors = modal::factor(&modal::stiffness(structure, &dofs), dofs.count)?;
        let (masses, water) = (dofs.masses(structure), dofs.added_mass(structure));
        let (frequencies, vectors) =
            modal::natural_modes_in_water(&factors, &masses, &water, count, modal::TOLERANCE)?;
        let shape = |mode: usize| {
            let vector = vectors.column(mode);
            let sign =
                vector.iter().fold(0.0f64, |most, v| if v.abs() > most.abs() { *v } else { most }).signum();
            let of_node = |node| dofs.of(node).map_or([0.0; 2], |dof| [0, 1].map(|d| sign * vector[dof + d]));
            (0..structure.mesh.nodes.len()).map(of_node).collect()
        };
        Ok(NaturalModes { frequencies, shapes: (0..count).map(shape).collect() })
    }
}
