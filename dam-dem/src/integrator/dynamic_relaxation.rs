use faer::linalg::solvers::Solve;

use crate::DamError;
use crate::contact::ContactLaw;
use crate::modal::{self, DegreesOfFreedom};
use crate::structure::{Motion, Structure};

/// Dynamic relaxation: the static equilibrium as the final state of a fictitious, damped motion.
///
/// It starts from the linear solution with all contacts closed and sticking. Then it takes steps with Δt = 1.
/// Every degree of freedom has the fictitious mass `m = (1 + margin)/4 Σ_j |K_ij|`, for which the motion is
/// stable (Gershgorin). The damping is the critical damping `c = 2ω` at the current frequency of the motion,
/// `ω² = −v·Δr / v·M v`, estimated again after every step (r: residual forces). Contacts act with their
/// history, including friction; dashpots and stiffness damping do not act.
///
/// **Source**: P. Underwood, *Dynamic relaxation*, in Computational Methods for Transient Analysis,
/// 1983; tested in `tests/static_start.rs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicRelaxation {
    /// Norm of the residual forces over that of the loads, at free nodes.
    pub tolerance: f64,
    /// Largest number of iterations.
    pub max_iterations: usize,
}

/// Result of a static solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxed {
    /// Number of iterations.
    pub iterations: usize,
    /// Norm of the residual forces over that of the loads.
    pub residual: f64,
}

impl Default for DynamicRelaxation {
    fn default() -> Self {
        Self { tolerance: 1e-9, max_iterations: 100_000 }
    }
}

/// Residual over the loads above which no state of rest exists: a block slides away or falls.
pub(super) const RUNAWAY: f64 = 50.0;
/// Share by which the fictitious masses exceed Gershgorin's bound.
const MASS_MARGIN: f64 = 0.2;

impl DynamicRelaxation {
    /// Brings `motion` to rest under `loads` (N/m).
    ///
    /// **Errors**: [`DamError::Singular`], [`DamError::StaticNotConverged`].
    pub fn relax(
        &self,
        structure: &Structure<impl ContactLaw>,
        motion: &mut Motion,
        loads: &[[f64; 2]],
    ) -> Result<Relaxed, DamError> {
        let free = |i: usize| !structure.is_fixed(i);
        let norm = |forces: &[[f64; 2]]| {
            let squares = forces.iter().enumerate().filter(|&(i, _)| free(i));
            squares.map(|(_, f)| f[0] * f[0] + f[1] * f[1]).sum::<f64>().sqrt()
        };
        let scale = norm(loads);
        if scale == 0.0 {
            return Ok(Relaxed { iterations: 0, residual: 0.0 });
        }
        let inverse_mass = start_from_linear_solution(structure, motion, loads)?;
        motion.velocity.fill([0.0; 2]);
        let mut residual = loads.to_vec();
        structure.add_internal_forces(motion, 0.0, &mut residual);
        let mut before = residual.clone();
        let mut damping = 0.0;
        let (mut iterations, mut relative) = (0, norm(&residual) / scale);
        let extent = structure.mesh.nodes.as_flattened().iter().fold(0.0f64, |far, x| far.max(x.abs()));
        let is_away = |motion: &Motion| motion.displacement.as_flattened().iter().any(|u| u.abs() > extent);
        // not a number is no state of rest either, nor is a block that has slid away
        while iterations < self.max_iterations
            && relative <= RUNAWAY
            && !(iterations % 100 == 99 && is_away(motion))
        {
            if relative <= self.tolerance {
                motion.velocity.fill([0.0; 2]);
                return Ok(Relaxed { iterations, residual: relative });
            }
            iterations += 1;
            let (keep, push) = ((2.0 - damping) / (2.0 + damping), 2.0 / (2.0 + damping));
            for (i, inverse) in inverse_mass.iter().enumerate() {
                for d in 0..2 {
                    let v = &mut motion.velocity[i][d];
                    *v = keep * *v + push * inverse[d] * residual[i][d];
                    motion.displacement[i][d] += *v;
                }
            }
            std::mem::swap(&mut before, &mut residual);
            residual.copy_from_slice(loads);
            structure.add_internal_forces(motion, 0.0, &mut residual);
            let (mut work, mut kinetic) = (0.0, 0.0);
            for (i, inverse) in inverse_mass.iter().enumerate().filter(|&(i, _)| free(i)) {
                for d in 0..2 {
                    let v = motion.velocity[i][d];
                    work += v * (before[i][d] - residual[i][d]);
                    kinetic += v * v / inverse[d];
                }
            }
            damping = if work > 0.0 { 2.0 * (work / kinetic).sqrt().min(1.0) } else { 0.0 };
            relative = norm(&residual) / scale;
        }
        Err(DamError::StaticNotConverged { iterations, residual: relative, tolerance: self.tolerance })
    }
}

/// Sets the displacement to the linear one and returns the inverses of the fictitious masses.
fn start_from_linear_solution(
    structure: &Structure<impl ContactLaw>,
    motion: &mut Motion,
    loads: &[[f64; 2]],
) -> Result<Vec<[f64; 2]>, DamError> {
    let dofs = DegreesOfFreedom::free(structure);
    let stiffness = modal::stiffness(structure, &dofs);
    let mut solution = faer::Mat::zeros(dofs.count, 1);
    let mut row_sums = vec![0.0; dofs.count];
    for &(row, _, value) in &stiffness {
        row_sums[row] += value.abs();
    }
    for (node, dof) in dofs.nodes() {
        for d in 0..2 {
            solution[(dof + d, 0)] = loads[node][d];
        }
    }
    modal::factor(&stiffness, dofs.count)?.solve_in_place(solution.as_mut());
    let mut inverse_mass = vec![[0.0; 2]; loads.len()];
    for (node, dof) in dofs.nodes() {
        for d in 0..2 {
            motion.displacement[node][d] = solution[(dof + d, 0)];
            inverse_mass[node][d] = 4.0 / ((1.0 + MASS_MARGIN) * row_sums[dof + d]);
        }
    }
    Ok(inverse_mass)
}
