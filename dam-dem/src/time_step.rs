use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::contact::{ContactLaw, Stencil};
use crate::structure::Structure;
use crate::{AddedMass, DamError, DampingCoefficients, RayleighCoefficients};

/// The longest stable time step of central differences with lagged damping of memory m
/// ([`StiffnessDamping`](crate::StiffnessDamping)).
///
/// ```text
/// Δt = (2/ω) (√(1 + ξ²) − ξ),   ξ = α/2ω + (1 − m)/(1 + m) βω/2
/// ```
///
/// with the highest frequency ω of elements and contacts (all closed and sticking, unstrained). In every time step a
/// mode is multiplied by z, a root of
///
/// ```text
/// (z − 1)² (z − m) + (ωΔt)² z (z − m) + αΔt (z − 1)(z − m) + (1 − m) βω²Δt z (z − 1) = 0
/// ```
///
/// with |z| < 1 below the limit and z = −1 at the limit; lower modes allow longer time steps.
///
/// Local damping κ multiplies forces against the motion by up to 1 + κ, and therefore divides the limit by the same
/// factor.
///
/// Added mass X would never reduce the limit if it were positive semidefinite, but it is so only approximately. With
/// `M + X ≥ μ M` ([`AddedMass::least_share`](crate::AddedMass::least_share)) the limit is that of the mass μ M.
///
/// **Source**: for m = 0 T. Belytschko, W.K. Liu, B. Moran, *Nonlinear Finite Elements for Continua and
/// Structures*, 2000, section 6.2; tested in `tests/time_step.rs` and `tests/damping_memory.rs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalTimeStep {
    /// Highest frequency ω, rad/s; with added mass an upper bound of it.
    pub highest_frequency: f64,
    /// Longest stable time step, s.
    pub limit: f64,
}

/// Largest time step of a dam with cracks, as a share of the undamped limit 2/ω: with dashpots in the contacts, and without. This limit
/// is that of linear stability; nearer to it contacts that open and close within a time step make the energy wrong
/// (docs/decisions/time-step-with-contacts.md).
pub(crate) const SHARE_WITH_DASHPOTS: f64 = 0.25;
pub(crate) const SHARE_WITHOUT_DASHPOTS: f64 = 0.18;
/// Length of a time step of modes in a calm communication step, in which every contact sticks, over that of the others: with 0.72 of
/// 2/ω as long as those of a dam without cracks. Contacts that remain open count as others.
pub(crate) const CALM: f64 = 2.88;
/// Share of 2/ω to which stiffness damping may reduce the time step in a calm communication step: with the usual safety factor
/// of 0.9 just what [`CALM`] steps take.
pub(crate) const CALM_DAMPED_SHARE: f64 = CALM * SHARE_WITH_DASHPOTS / 0.9;
/// Relative change of the largest Ritz value over ten iterations at which the Lanczos iteration has converged.
const TOLERANCE: f64 = 1e-10;
/// Largest number of Lanczos iterations.
const MAX_ITERATIONS: usize = 400;

impl CriticalTimeStep {
    /// The critical time step of a `structure` with `damping`.
    ///
    /// **Errors**: [`DamError::FrequenciesNotConverged`].
    pub fn of(
        structure: &Structure<impl ContactLaw>,
        damping: impl Into<DampingCoefficients>,
    ) -> Result<Self, DamError> {
        Ok(Self::of_frequency(structure, damping, highest_frequency(structure)?))
    }

    /// The same, if the highest frequency without added mass is known: `frequency` (rad/s).
    pub(crate) fn of_frequency(
        structure: &Structure<impl ContactLaw>,
        damping: impl Into<DampingCoefficients>,
        frequency: f64,
    ) -> Self {
        let least = structure.added_mass.as_ref().map_or(1.0, AddedMass::least_share);
        let DampingCoefficients { rayleigh: RayleighCoefficients { mass, stiffness }, memory, local, .. } =
            damping.into();
        let damping = RayleighCoefficients { mass: mass / least, stiffness };
        let frequency = frequency / least.sqrt();
        let ratio = damping.limiting_ratio(frequency, memory);
        let local = 1.0 + local;
        Self {
            highest_frequency: frequency,
            limit: 2.0 / frequency * ((1.0 + ratio * ratio).sqrt() - ratio) / local,
        }
    }

    /// Longest time step to use, s: `safety` times the limit, and at most the `share` of 2/ω.
    pub fn with_safety(&self, safety: f64, share: f64) -> f64 {
        (safety * self.limit).min(share * 2.0 / self.highest_frequency)
    }
}

/// Highest frequency without added mass, rad/s: square root of the largest eigenvalue of `M^(−½) K M^(−½)`,
/// by Lanczos iteration with full reorthogonalisation. K is applied element by element and is never
/// assembled.
///
/// **Errors**: [`DamError::FrequenciesNotConverged`]: a Ritz value that still grows is below the highest frequency, and
/// a time step from it too long.
pub(crate) fn highest_frequency(structure: &Structure<impl ContactLaw>) -> Result<f64, DamError> {
    Ok(highest_mode(structure)?.frequency)
}

/// The mode of the highest frequency without added mass.
pub(crate) struct HighestMode {
    /// ω, rad/s.
    pub frequency: f64,
    /// φ at every node, with φᵀ M φ = 1.
    pub shape: Vec<[f64; 2]>,
}

/// As [`highest_frequency`], with the mode: the Ritz vector, which errs by less than 10⁻⁴ where the frequency is a single one.
pub(crate) fn highest_mode(structure: &Structure<impl ContactLaw>) -> Result<HighestMode, DamError> {
    highest_mode_in(structure, MAX_ITERATIONS)
}

fn highest_mode_in(structure: &Structure<impl ContactLaw>, most: usize) -> Result<HighestMode, DamError> {
    let stencils = structure.stencils();
    let root: Vec<f64> = structure.inverse_mass.iter().map(|m| m.sqrt()).collect();
    let scale = |x: &[[f64; 2]]| -> Vec<[f64; 2]> {
        x.iter().zip(&root).map(|(x, r)| [x[0] * r, x[1] * r]).collect()
    };
    let dot = |a: &[[f64; 2]], b: &[[f64; 2]]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
    };
    let mut seed = 7u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX) - 0.5
    };
    let mut next: Vec<[f64; 2]> =
        root.iter().map(|&r| if r > 0.0 { [random(), random()] } else { [0.0; 2] }).collect();
    let free = 2 * root.iter().filter(|&&r| r > 0.0).count();
    let mut basis: Vec<Vec<[f64; 2]>> = Vec::new();
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    let (mut norm, mut largest, mut change) = (dot(&next, &next).sqrt(), 0.0, f64::INFINITY);
    for iteration in 1..=most.min(free) {
        next.iter_mut().flatten().for_each(|x| *x /= norm);
        basis.push(next);
        let current = &basis[basis.len() - 1];
        let mut image = scale(&apply_stiffness(structure, &stencils, &scale(current)));
        diagonal.push(dot(&image, current));
        for _ in 0..2 {
            for vector in &basis {
                let share = dot(&image, vector);
                for (x, b) in image.iter_mut().zip(vector) {
                    x[0] -= share * b[0];
                    x[1] -= share * b[1];
                }
            }
        }
        norm = dot(&image, &image).sqrt();
        let exhausted = norm <= 1e-12 * diagonal[0].abs() || iteration == free;
        if iteration % 10 == 0 || exhausted {
            let (value, shares) = largest_eigenpair(&diagonal, &off_diagonal);
            change = (value - largest).abs() / value;
            if exhausted || change <= TOLERANCE {
                let mut vector = vec![[0.0; 2]; root.len()];
                for (share, of_basis) in shares.iter().zip(&basis) {
                    let flat = vector.as_flattened_mut().iter_mut().zip(of_basis.as_flattened());
                    flat.for_each(|(x, b)| *x += share * b);
                }
                return Ok(HighestMode { frequency: value.sqrt(), shape: scale(&vector) });
            }
            largest = value;
        }
        off_diagonal.push(norm);
        next = image;
    }
    Err(DamError::FrequenciesNotConverged { iterations: most, change, tolerance: TOLERANCE })
}

/// `K u`, N/m.
fn apply_stiffness(
    structure: &Structure<impl ContactLaw>,
    stencils: &[Stencil],
    u: &[[f64; 2]],
) -> Vec<[f64; 2]> {
    let mut forces = vec![[0.0; 2]; u.len()];
    structure.cells.add_linear_forces(u, &mut forces);
    forces.iter_mut().flatten().for_each(|f| *f = -*f);
    for stencil in stencils {
        let mut relative = [0.0; 2];
        for (&node, weight) in stencil.nodes.iter().zip(stencil.weights) {
            relative[0] += weight * u[node][0];
            relative[1] += weight * u[node][1];
        }
        let force = stencil.stiffness.map(|row| row[0] * relative[0] + row[1] * relative[1]);
        for (&node, weight) in stencil.nodes.iter().zip(stencil.weights) {
            forces[node][0] += weight * force[0];
            forces[node][1] += weight * force[1];
        }
    }
    forces
}

/// Largest eigenvalue of the tridiagonal matrix, and its vector.
fn largest_eigenpair(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, DVector<f64>) {
    let n = diagonal.len();
    let tridiagonal = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off_diagonal[i.min(j)],
        _ => 0.0,
    });
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(tridiagonal);
    let (index, value) = eigenvalues.argmax();
    (value, eigenvectors.column(index).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Coulomb, Integration};
    use crate::{Kinematics, Material, Mesh, Section};

    #[test]
    fn a_frequency_that_still_grows_is_an_error() {
        let mesh = Mesh::mapped(&Section::rectangle(8.0, 20.0), &[vec![0.0, 5.0, 10.0, 15.0, 20.0]], 6);
        let material = Material { young_modulus: 1e9, density: 2400.0, ..Default::default() };
        let none: [(Coulomb, Integration); 0] = [];
        let structure = Structure::new(mesh, &material, Kinematics::Small, none, &[]);
        let found = highest_frequency(&structure).expect("the iteration converges");
        let early = highest_mode_in(&structure, 10).map(|mode| mode.frequency);
        assert!(
            matches!(early, Err(DamError::FrequenciesNotConverged { iterations: 10, .. })),
            "{early:?} of {found}"
        );
    }
}
