use nalgebra::{DMatrix, DVector};
use pulp::Arch;
use std::ops::Range;

use super::basis::Basis;
use super::mode::{Mode, SLOWED_TO, concrete_mass};
use super::motion::ModalMotion;
use super::product::{Dots, dot, used};
use super::release::ModalRelease;
use super::sides::{CrackSides, Mean, Rows};
use crate::contact::MohrCoulomb;
use crate::damping::{DAMPED_SHARE, StiffnessDamping};
use crate::energy::StoredEnergy;
use crate::loads::{Acting, Inertia, Load, Loads};
use crate::structure::Structure;
use crate::time_step::{CALM_DAMPED_SHARE, CriticalTimeStep};
use crate::{DamError, DampingCoefficients, Fidelity, Kinematics, RayleighCoefficients};

/// Modes between contacts: the model at all levels except [`Fidelity::Dem`].
#[derive(Clone, Debug)]
pub struct Superposition {
    /// Squares ω² of the modes' circular frequencies, (rad/s)².
    pub(super) stiffness: Vec<f64>,
    /// Damping `2ξω` of the modes, 1/s.
    pub(super) damping: Vec<f64>,
    /// Coefficients of mass damping between modes that added mass couples, 1/s; no rows without added mass.
    pub(super) damping_between: Rows,
    /// What releases blocks from mass damping.
    pub(super) release: ModalRelease,
    /// Stiffness damping of the contacts' dashpots.
    pub(super) dashpots: StiffnessDamping,
    pub(super) sides: CrackSides,
    /// One row for each mode; columns: x, then y of each node.
    shapes: DMatrix<f64>,
    /// The modes that move each node, as [`used`] has them.
    moving: Vec<Range<usize>>,
    /// The widest registers.
    arch: Arch,
    /// Modal forces of unit amplitudes of each load.
    loads: Vec<DMatrix<f64>>,
    /// For a unit acceleration of the ground along x and along y: `−Φᵀ (M + X) ι`.
    ground: [DVector<f64>; 2],
    /// Mean rotation of each block, with one value for each mode.
    rotations: Vec<DVector<f64>>,
    critical: CriticalTimeStep,
    /// Stiffness damping of the dashpots in a calm step; none without contacts.
    pub(super) calm: Option<StiffnessDamping>,
    truncation: f64,
}

impl Superposition {
    /// The dam of `structure` with this `damping` at a level of `fidelity`, under these `loads`.
    ///
    /// **Errors**: [`DamError::Singular`], [`DamError::FrequenciesNotConverged`], [`DamError::TooManyFrequencies`],
    /// [`DamError::RigidWithoutCrack`].
    pub(crate) fn new(
        structure: &Structure<MohrCoulomb>,
        damping: DampingCoefficients,
        fidelity: Fidelity,
        kinematics: Kinematics,
        loads: &Loads,
    ) -> Result<Self, DamError> {
        let rayleigh = damping.rayleigh;
        let basis = Basis::new(structure, fidelity, &loads.at_rest(structure.mesh.nodes.len()))?;
        if basis.parts.is_empty() {
            // the ground holds all blocks
            return Err(DamError::RigidWithoutCrack);
        }
        let coupled = structure.added_mass.is_some();
        let mut modes = Vec::new();
        for part in joined(basis.parts, coupled) {
            modes.extend(Mode::all(structure, &part)?);
        }
        let by_mode: Vec<DVector<f64>> = modes.iter().map(|mode| mode.shape.clone()).collect();
        let shapes = DMatrix::from_columns(&by_mode);
        let stiffness: Vec<f64> = modes.iter().map(|mode| mode.square).collect();
        let damping_between = match coupled {
            true => damping_between(structure, rayleigh.mass, &shapes, &stiffness),
            false => DMatrix::zeros(0, 0),
        };
        let shapes = shapes.transpose();
        let cracked = fidelity.is_cracked();
        let sides = CrackSides::of(structure, &shapes, cracked, kinematics);
        let highest = sides.highest_frequency(&stiffness);
        let felt =
            RayleighCoefficients { mass: 0.0, stiffness: if cracked { rayleigh.stiffness } else { 0.0 } };
        let memory = felt.memory_reaching(DAMPED_SHARE, highest);
        let ratio = felt.limiting_ratio(highest, memory);
        let calm = (!sides.cracks.is_empty()).then(|| StiffnessDamping {
            coefficient: rayleigh.stiffness,
            memory: felt.memory_reaching(CALM_DAMPED_SHARE, highest),
        });
        let blocks = structure.mesh.blocks.iter();
        let release = match cracked && rayleigh.mass > 0.0 && !damping.drags_blocks {
            true => ModalRelease::new(structure, rayleigh.mass, &shapes, &stiffness),
            false => ModalRelease::none(),
        };
        Ok(Self {
            release,
            damping: modes.iter().map(|mode| mode.damping(rayleigh)).collect(),
            damping_between: Rows::of_columns(&damping_between),
            dashpots: StiffnessDamping { coefficient: rayleigh.stiffness, memory },
            loads: loads.projected(&shapes),
            ground: {
                let inertia = Inertia::new(&structure.mass, structure.added_mass.as_ref());
                let inertia = inertia.basis().matrix(structure.mesh.nodes.len());
                [0, 1].map(|axis| &shapes * inertia.column(axis))
            },
            rotations: blocks
                .map(|block| Mean::of(structure, block.nodes.clone(), &shapes).rotation)
                .collect(),
            critical: CriticalTimeStep {
                highest_frequency: highest,
                limit: 2.0 / highest * ((1.0 + ratio * ratio).sqrt() - ratio),
            },
            calm,
            truncation: basis.truncation,
            moving: moving(&shapes),
            arch: Arch::new(),
            stiffness,
            sides,
            shapes,
        })
    }

    /// Number of modes.
    pub fn mode_count(&self) -> usize {
        self.stiffness.len()
    }

    /// Estimate of the contribution of the omitted modes to the response at the highest excitation frequency,
    /// as a share.
    pub fn truncation(&self) -> f64 {
        self.truncation
    }

    /// Stiffness damping of the contacts' dashpots.
    pub(crate) fn dashpots(&self) -> StiffnessDamping {
        self.dashpots
    }

    pub(crate) fn critical_time_step(&self) -> CriticalTimeStep {
        self.critical
    }

    /// Whether there are contacts, so that calm communication steps take fewer time steps.
    pub(crate) fn has_calm_steps(&self) -> bool {
        self.calm.is_some()
    }

    /// Motion without displacement and velocity; all contacts are closed without force.
    pub(crate) fn at_rest(&self) -> ModalMotion {
        let zero = vec![0.0; self.mode_count()];
        let joints = self.sides.cracks.iter().map(|crack| crack.joints_at_rest()).collect();
        let contact_forces = vec![0.0; self.sides.modes_width()];
        ModalMotion { coordinates: zero.clone(), rates: zero, contact_forces, joints }
    }

    /// Modal forces of the `loads` from which it was made.
    pub(crate) fn forces(&self, loads: &Loads, acting: &Acting) -> Vec<f64> {
        let mut forces = DVector::zeros(self.mode_count());
        for (load, basis) in loads.0.iter().zip(&self.loads) {
            for (column, &amplitude) in basis.column_iter().zip(load.amplitudes(acting).iter()) {
                forces.axpy(amplitude, &column, 1.0);
            }
        }
        forces.data.into()
    }

    /// Modal forces for a unit acceleration of the ground along `axis`.
    pub(super) fn inertia(&self, axis: usize) -> &DVector<f64> {
        &self.ground[axis]
    }

    /// Modal forces of nodal forces.
    pub(crate) fn force_of(&self, nodal: &DVector<f64>) -> Vec<f64> {
        (&self.shapes * nodal).data.into()
    }

    /// Displacement or velocity of `node` from modal coordinates or their rates.
    pub(crate) fn at_node(&self, node: usize, coordinates: &[f64]) -> [f64; 2] {
        let (count, moving) = (self.shapes.nrows(), &self.moving[node]);
        let row = |i: usize| &self.shapes.as_slice()[i * count..][moving.clone()];
        let rows = [row(2 * node), row(2 * node + 1)];
        self.arch.dispatch(Dots { rows, with: &coordinates[moving.clone()] })
    }

    /// The displacement of all nodes in a mode.
    pub(crate) fn shape(&self, mode: usize) -> Vec<[f64; 2]> {
        let values: Vec<f64> = self.shapes.row(mode).iter().copied().collect();
        values.as_chunks().0.to_vec()
    }

    /// Mean rotation of `block` for the given coordinates, rad.
    pub(crate) fn rotation(&self, block: usize, coordinates: &[f64]) -> f64 {
        dot(self.rotations[block].as_slice(), coordinates)
    }

    pub(crate) fn stored_energy(&self, motion: &ModalMotion) -> StoredEnergy {
        let squares = motion.coordinates.iter().zip(&self.stiffness).map(|(q, square)| square * q * q);
        let joints = self.sides.cracks.iter().zip(&motion.joints);
        StoredEnergy {
            kinetic: dot(&motion.rates, &motion.rates) / 2.0,
            strain: squares.sum::<f64>() / 2.0,
            contact: joints.map(|(crack, joints)| crack.energy(joints)).sum(),
        }
    }
}

/// The modes that move each node: those of one block are zero on the others.
fn moving(shapes: &DMatrix<f64>) -> Vec<Range<usize>> {
    let moves = |node: usize, mode: usize| [0, 1].iter().any(|axis| shapes[(mode, 2 * node + axis)] != 0.0);
    let of_node = |node| {
        let Range { start, end } = used(shapes.nrows(), |mode| moves(node, mode));
        start..end.min(shapes.nrows())
    };
    (0..shapes.ncols() / 2).map(of_node).collect()
}

/// The parts unchanged, or joined to one if added mass couples them.
fn joined(parts: Vec<DMatrix<f64>>, coupled: bool) -> Vec<DMatrix<f64>> {
    if !coupled {
        return parts;
    }
    let columns: Vec<DVector<f64>> =
        parts.iter().flat_map(|part| part.column_iter().map(Into::into)).collect();
    vec![DMatrix::from_columns(&columns)]
}

/// Mass damping between the modes whose frequency was not reduced: α (`alpha`, 1/s) times the off-diagonal terms of
/// `Φᵀ M Φ`. The modes must be sorted by frequency.
fn damping_between(
    structure: &Structure<MohrCoulomb>,
    alpha: f64,
    shapes: &DMatrix<f64>,
    stiffness: &[f64],
) -> DMatrix<f64> {
    let slow = stiffness.partition_point(|&square| square < SLOWED_TO * SLOWED_TO * (1.0 - 1e-9));
    let mut between = concrete_mass(structure, &shapes.columns(0, slow).into_owned()) * alpha;
    between.fill_diagonal(0.0);
    between
}
