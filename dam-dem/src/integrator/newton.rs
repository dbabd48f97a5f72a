use nalgebra::DVector;

use super::{Relaxed, dynamic_relaxation::RUNAWAY};
use crate::DamError;
use crate::contact::ContactLaw;
use crate::modal::{self, DegreesOfFreedom};
use crate::structure::{Motion, Structure};

/// Modified Newton iteration for the static equilibrium with one sparse factorisation: that of the unstrained
/// structure with all contacts closed and sticking.
///
/// Contacts that open or slip only make the structure softer, so that no step overshoots. The more contacts
/// do so, the slower the convergence; for a crack that opens widely use
/// [`DynamicRelaxation`](super::DynamicRelaxation). Friction acts with its history; dashpots and stiffness
/// damping do not act. Tested in `tests/static_start.rs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SparseNewton {
    /// Norm of the residual forces over that of the loads, at free nodes.
    pub tolerance: f64,
    /// Largest number of iterations.
    pub max_iterations: usize,
}

impl Default for SparseNewton {
    fn default() -> Self {
        Self { tolerance: 1e-9, max_iterations: 300 }
    }
}

impl SparseNewton {
    /// Brings `motion` to rest under `loads` (N/m).
    ///
    /// **Errors**: [`DamError::StaticNotConverged`], [`DamError::Singular`].
    pub fn relax(
        &self,
        structure: &Structure<impl ContactLaw>,
        motion: &mut Motion,
        loads: &[[f64; 2]],
    ) -> Result<Relaxed, DamError> {
        let dofs = DegreesOfFreedom::free(structure);
        let factors = modal::factor(&modal::stiffness(structure, &dofs), dofs.count)?;
        let free = |forces: &[[f64; 2]]| {
            let mut values = DVector::zeros(dofs.count);
            dofs.nodes().for_each(|(node, dof)| (0..2).for_each(|d| values[dof + d] = forces[node][d]));
            values
        };
        let scale = free(loads).norm();
        motion.velocity.fill([0.0; 2]);
        let (mut iterations, mut residual) = (0, 0.0);
        while iterations < self.max_iterations && residual <= RUNAWAY {
            let mut forces = loads.to_vec();
            structure.add_internal_forces(motion, 0.0, &mut forces);
            let forces = free(&forces);
            residual = if scale == 0.0 { 0.0 } else { forces.norm() / scale };
            if residual <= self.tolerance {
                return Ok(Relaxed { iterations, residual });
            }
            let change = modal::solve(&factors, &nalgebra::DMatrix::from_columns(&[forces]));
            for (node, dof) in dofs.nodes() {
                (0..2).for_each(|d| motion.displacement[node][d] += change[dof + d]);
            }
            iterations += 1;
        }
        Err(DamError::StaticNotConverged { iterations, residual, tolerance: self.tolerance })
    }
}
