use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

use crate::contact::{ContactLaw, Coulomb, Crack, Integration, JointState, Stencil};
use crate::damping::{DampingCoefficients, StiffnessDamping};
use crate::element::{CrossedCells, ViscousStress};
use crate::energy::{Losses, StoredEnergy};
use crate::loads::Wet;
use crate::{AddedMass, DamError, Kinematics, Material, Mesh};

/// Blocks, their masses, and the cracks between them.
///
/// Damping is not part of it: its coefficients follow from the frequencies of the structure
/// ([`DampingCoefficients`]).
#[derive(Clone, Debug)]
pub struct Structure<L: ContactLaw = Coulomb> {
    /// The mesh in the unloaded position.
    pub mesh: Mesh,
    /// The elements.
    pub cells: CrossedCells,
    /// The cracks, from the base up.
    pub cracks: Vec<Crack<L>>,
    /// Lumped masses of the nodes, kg/m.
    pub mass: Vec<f64>,
    /// 1/mass, and 0 for fixed nodes, m/kg.
    pub inverse_mass: Vec<f64>,
    /// Inertia of the water. `mass` and `inverse_mass` are those of the concrete alone.
    pub added_mass: Option<AddedMass>,
}

/// Motion of all nodes, relative to the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Displacements from the unloaded position, m.
    pub displacement: Vec<[f64; 2]>,
    /// Velocities, m/s.
    pub velocity: Vec<[f64; 2]>,
    /// Accelerations, m/s².
    pub acceleration: Vec<[f64; 2]>,
    /// Stresses of stiffness damping in each batch of cells, Pa.
    pub viscous: Vec<ViscousStress>,
    /// States of the contacts of each crack.
    pub joints: Vec<Vec<JointState>>,
}

impl<L: ContactLaw> Structure<L> {
    /// The blocks of `mesh`, without water, with the nodes `fixed` held by the ground. `cracks` gives the
    /// contact law of each crack and where its contacts are, from the base up.
    pub fn new(
        mesh: Mesh,
        material: &Material,
        kinematics: Kinematics,
        cracks: impl IntoIterator<Item = (L, Integration)>,
        fixed: &[usize],
    ) -> Self {
        let cells = CrossedCells::new(&mesh, material, kinematics);
        let mut mass = vec![0.0; mesh.nodes.len()];
        for (nodes, area, _) in cells.triangles() {
            nodes.iter().for_each(|&n| mass[n] += material.density * area / 3.0);
        }
        let mut inverse_mass: Vec<f64> = mass.iter().map(|m| 1.0 / m).collect();
        fixed.iter().for_each(|&n| inverse_mass[n] = 0.0);
        let cracks = mesh
            .blocks
            .windows(2)
            .zip(cracks)
            .map(|(pair, (law, contacts))| Crack::new(&mesh, &pair[0].top, &pair[1].bottom, law, contacts))
            .collect();
        Self { mesh, cells, cracks, mass, inverse_mass, added_mass: None }
    }

    /// The same structure with the added mass of `rows` (points × points, Pa per m/s²) on its `wet` face.
    ///
    /// **Errors**: as [`AddedMass::new`].
    pub(crate) fn in_water(self, wet: Option<&Wet>, rows: &[Vec<f64>]) -> Result<Self, DamError> {
        Ok(Self { added_mass: Some(AddedMass::new(wet, rows, &self.inverse_mass)?), ..self })
    }

    /// The same structure, whose elements are evaluated by `threads` ([`CrossedCells::on_threads`]).
    ///
    /// **Errors**: [`DamError::Threads`].
    pub fn on_threads(self, threads: NonZeroUsize) -> Result<Self, DamError> {
        Ok(Self { cells: self.cells.on_threads(threads)?, ..self })
    }

    /// Motion without displacement and velocity; all contacts are closed without force.
    pub fn at_rest(&self) -> Motion {
        let zero = vec![[0.0; 2]; self.mesh.nodes.len()];
        Motion {
            displacement: zero.clone(),
            velocity: zero.clone(),
            acceleration: zero,
            viscous: self.cells.viscous_at_rest(),
            joints: self.cracks.iter().map(|crack| crack.joints_at_rest()).collect(),
        }
    }

    /// Whether `node` is held by the ground.
    pub fn is_fixed(&self, node: usize) -> bool {
        self.inverse_mass[node] == 0.0
    }

    /// Adds the forces of elements and contacts, including stiffness damping, to `forces` (N/m), and updates
    /// the damping stresses and contacts of `motion`. `damping` is β (s), with or without memory.
    pub fn add_internal_forces(
        &self,
        motion: &mut Motion,
        damping: impl Into<StiffnessDamping>,
        forces: &mut [[f64; 2]],
    ) -> Losses {
        let damping = damping.into();
        let (u, v) = (&motion.displacement, &motion.velocity);
        let damping_power = self.cells.add_forces(u, v, damping, &mut motion.viscous, forces);
        let mut losses = Losses { friction: 0.0, damping_power };
        for (crack, joints) in self.cracks.iter().zip(&mut motion.joints) {
            let lost = crack.add_forces(u, v, damping, joints, forces);
            losses.friction += lost.friction;
            losses.damping_power += lost.damping_power;
        }
        losses
    }

    /// Sets the acceleration of `motion` to that under `forces` (N/m).
    ///
    /// **Call order**: once, at the start, because each call takes one step of the damping's memory.
    pub fn accelerate(
        &self,
        damping: impl Into<DampingCoefficients>,
        motion: &mut Motion,
        forces: &[[f64; 2]],
    ) {
        let damping = damping.into();
        let alpha = damping.rayleigh.mass;
        let mut total = forces.to_vec();
        self.add_internal_forces(motion, damping.stiffness(), &mut total);
        if let Some(water) = &self.added_mass {
            water.take_share(&mut total, &motion.velocity, &self.mass, alpha);
        }
        for (i, force) in total.iter().enumerate() {
            let v = motion.velocity[i];
            motion.acceleration[i] = [0, 1].map(|d| force[d] * self.inverse_mass[i] - alpha * v[d]);
        }
    }

    /// `K u` of the elements in the unstrained position, N/m; `displacement` (m) holds x, then y of each node.
    pub(crate) fn stiffness_times(&self, displacement: &DVector<f64>) -> DVector<f64> {
        let mut forces = vec![[0.0; 2]; displacement.len() / 2];
        self.cells.add_linear_forces(displacement.as_slice().as_chunks().0, &mut forces);
        -DVector::from_row_slice(forces.as_flattened())
    }

    /// Springs of all contacts, closed, in the unloaded position.
    pub fn stencils(&self) -> Vec<Stencil> {
        self.cracks.iter().flat_map(Crack::stencils).collect()
    }

    /// Weight of each node, N/m, under the acceleration vector `gravity` (m/s²).
    pub fn weight(&self, gravity: [f64; 2]) -> Vec<[f64; 2]> {
        self.mass.iter().map(|m| [m * gravity[0], m * gravity[1]]).collect()
    }

    /// Energies stored in a motion, J/m.
    pub fn stored_energy(&self, motion: &Motion) -> StoredEnergy {
        StoredEnergy {
            kinetic: self.kinetic_energy(motion),
            strain: self.strain_energy(motion),
            contact: self.contact_energy(motion),
        }
    }

    /// Energy in the contact springs, J/m.
    pub fn contact_energy(&self, motion: &Motion) -> f64 {
        self.cracks.iter().zip(&motion.joints).map(|(crack, joints)| crack.energy(joints)).sum()
    }

    /// Kinetic energy relative to the ground, including that of the added mass, J/m.
    pub fn kinetic_energy(&self, motion: &Motion) -> f64 {
        let square = |(m, v): (&f64, &[f64; 2])| m * (v[0] * v[0] + v[1] * v[1]);
        let concrete = 0.5 * self.mass.iter().zip(&motion.velocity).map(square).sum::<f64>();
        match &self.added_mass {
            Some(water) => concrete + water.kinetic_energy(&motion.velocity),
            None => concrete,
        }
    }

    /// Strain energy, J/m.
    pub fn strain_energy(&self, motion: &Motion) -> f64 {
        self.cells.strain_energy(&motion.displacement)
    }
}
