use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

use crate::contact::{
    ContactBatches, ContactLaw, Coulomb, Crack, Integration, JointState, Meeting, NodalFields, Outlines,
    Parting, Stencil,
};
use crate::damping::{DampingCoefficients, StiffnessDamping};
use crate::element::{CrossedCells, ViscousStress};
use crate::energy::{Losses, StoredEnergy};
use crate::release::{Carried, Release, plus};
use crate::wet::Wet;
use crate::{AddedMass, Block, DamError, Kinematics, Materials, Mesh, Seam};

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
    /// The cracks, one for each seam of the mesh.
    pub cracks: Vec<Crack<L>>,
    /// Lumped masses of the nodes, kg/m.
    pub mass: Vec<f64>,
    /// 1/mass, and 0 for fixed nodes, m/kg.
    pub inverse_mass: Vec<f64>,
    /// Inertia of the water. `mass` and `inverse_mass` are those of the concrete alone.
    pub added_mass: Option<AddedMass>,
    /// How blocks move with the jumps of cracks.
    pub(crate) carried: Carried,
    /// What may meet where no crack is; none without cracks.
    outlines: Option<Outlines<L>>,
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
    /// States of the contacts of each crack, one list for each seam.
    pub joints: Vec<Vec<JointState>>,
    /// Contacts where no crack was.
    pub meetings: Vec<Meeting>,
}

impl<L: ContactLaw> Structure<L> {
    /// The blocks of `mesh`, without water, with the nodes `fixed` held by the ground. `cracks` gives the
    /// contact law of each crack and where its contacts are; the last cracks may have none, and then no contacts. `materials` are
    /// those of the whole dam ([`Material`](crate::Material)) or of its zones ([`Materials`]).
    pub fn new(
        mesh: Mesh,
        materials: impl Into<Materials>,
        kinematics: Kinematics,
        cracks: impl IntoIterator<Item = (L, Integration)>,
        fixed: &[usize],
    ) -> Self {
        let materials = materials.into();
        let cells = CrossedCells::new(&mesh, &materials, kinematics);
        let mut mass = vec![0.0; mesh.nodes.len()];
        for (triangle, (nodes, area, _)) in cells.triangles().enumerate() {
            let density = materials.of_cell(&mesh, triangle / 4).density;
            nodes.iter().for_each(|&n| mass[n] += density * area / 3.0);
        }
        let mut inverse_mass: Vec<f64> = mass.iter().map(|m| 1.0 / m).collect();
        fixed.iter().copied().chain(mesh.ground.clone()).for_each(|n| inverse_mass[n] = 0.0);
        let laws: Vec<(L, Integration)> = cracks.into_iter().collect();
        let of_seam = |seam: &Seam| {
            let (law, contacts) = laws.get(seam.crack)?.clone();
            Some(Crack::new(&mesh, seam, law, contacts))
        };
        let cracks: Vec<Crack<L>> = mesh.seams.iter().filter_map(of_seam).collect();
        let is_held = |node: usize| inverse_mass[node] == 0.0;
        let carried = Carried::of(&mesh, cracks.len(), is_held);
        let integrations: Vec<Integration> =
            mesh.seams.iter().filter_map(|seam| Some(laws.get(seam.crack)?.1)).collect();
        let outlines = Outlines::of(&mesh, &cracks, &integrations, is_held);
        Self { mesh, cells, cracks, mass, inverse_mass, added_mass: None, carried, outlines }
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
            meetings: Vec::new(),
        }
    }

    /// Whether `node` is held by the ground.
    pub fn is_fixed(&self, node: usize) -> bool {
        self.inverse_mass[node] == 0.0
    }

    /// Whether the ground holds a node of `block`.
    pub(crate) fn is_held(&self, block: &Block) -> bool {
        block.nodes.clone().any(|node| self.is_fixed(node))
    }

    /// Adds the forces of elements and contacts, including stiffness damping, to `forces` (N/m), and updates
    /// the damping stresses and contacts of `motion`. `damping` is β (s), with or without memory.
    pub fn add_internal_forces(
        &self,
        motion: &mut Motion,
        damping: impl Into<StiffnessDamping>,
        forces: &mut [[f64; 2]],
    ) -> Losses {
        self.add_internal_forces_and_part(motion, damping.into(), forces, &mut [])
    }

    /// The same; also finds how the sides of cracks part, if there is a place for it.
    fn add_internal_forces_and_part(
        &self,
        motion: &mut Motion,
        damping: StiffnessDamping,
        forces: &mut [[f64; 2]],
        partings: &mut [Parting],
    ) -> Losses {
        let mut batches = ContactBatches::new(&self.cracks, &motion.joints);
        let losses = self.add_forces_with(&mut batches, motion, damping, forces, partings);
        batches.write(&mut motion.joints);
        losses
    }

    /// The same with the contacts in `batches`, made from those of `motion`. The contacts of `motion` are up to date after
    /// [`ContactBatches::write`], except that they always tell whether they are lost.
    pub(crate) fn add_forces_with(
        &self,
        batches: &mut ContactBatches,
        motion: &mut Motion,
        damping: StiffnessDamping,
        forces: &mut [[f64; 2]],
        partings: &mut [Parting],
    ) -> Losses {
        let (u, v) = (&motion.displacement, &motion.velocity);
        let damping_power = self.cells.add_forces(u, v, damping, &mut motion.viscous, forces);
        let fields = NodalFields { u, v, damping, forces, partings };
        let mut losses = batches.add_forces_widely(&self.cracks, &mut motion.joints, fields);
        losses.damping_power += damping_power;
        if let Some(outlines) = self.outlines.as_ref().filter(|_| !motion.meetings.is_empty()) {
            let met = outlines.add_forces(u, v, damping, &motion.joints, &mut motion.meetings, forces);
            losses.friction += met.friction;
            losses.damping_power += met.damping_power;
        }
        losses
    }

    /// Finds where blocks may meet within the next `duration` (s) without a crack there.
    pub(crate) fn find_meetings(&self, motion: &mut Motion, duration: f64) {
        if let Some(outlines) = &self.outlines {
            let Motion { displacement: u, velocity: v, joints, meetings, .. } = motion;
            outlines.search(u, v, joints, duration, meetings);
        }
    }

    /// Whether the meetings of a motion can be those of this structure.
    pub(crate) fn knows(&self, meetings: &[Meeting]) -> bool {
        meetings.is_empty() || self.outlines.as_ref().is_some_and(|outlines| outlines.know(meetings))
    }

    /// Where blocks meet without a crack there: unloaded place of one such point (m), and whether it is on the ground.
    pub fn meeting_place(&self, motion: &Motion) -> Option<([f64; 2], bool)> {
        self.outlines.as_ref()?.first_closed(&motion.meetings)
    }

    /// What releases blocks from mass damping, for evaluations that are a `time_step` (s) apart.
    pub(crate) fn release(&self, damping: DampingCoefficients, time_step: f64) -> Release {
        let applies = damping.rayleigh.mass > 0.0 && !damping.drags_blocks;
        if applies { self.carried.release(self.cracks.len(), time_step) } else { Release::default() }
    }

    /// Sets `released` to the nodal forces q (N/m) of [`Release`] for mass damping `alpha` (1/s) if a crack parts; returns
    /// their sum.
    pub(crate) fn released(
        &self,
        release: &mut Release,
        alpha: f64,
        motion: &Motion,
        released: &mut [[f64; 2]],
    ) -> Option<[f64; 2]> {
        if !release.find_rates(&self.carried) {
            return None;
        }
        released.fill([0.0; 2]);
        let Release { partings, rates, momenta } = release;
        let mut sum = [0.0; 2];
        for (link, rate) in self.carried.links.iter().zip(&*rates).rev() {
            let mut momentum = momenta[link.block];
            for node in self.mesh.blocks[link.block].nodes.clone() {
                let (mass, v) = (self.mass[node], motion.velocity[node]);
                let (rest, u) = (self.mesh.nodes[node], motion.displacement[node]);
                let [x, y] = [rest[0] + u[0], rest[1] + u[1]];
                let rigid = [rate[0] - rate[2] * y, rate[1] + rate[2] * x];
                for d in 0..2 {
                    released[node][d] += alpha * mass * rigid[d];
                    sum[d] += alpha * mass * rigid[d];
                }
                let [p, q] = [mass * (v[0] - rigid[0]), mass * (v[1] - rigid[1])];
                momentum = plus(momentum, [p, q, x * q - y * p]);
            }
            let parting = &partings[link.seam];
            if !parting.is_closed() {
                parting.add_dual(momentum.map(|momentum| link.sign * alpha * momentum), released);
            }
            if let Some(carrier) = link.carrier {
                momenta[carrier] = plus(momenta[carrier], momentum);
            }
        }
        Some(sum)
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
        let mut release = self.release(damping, 0.0);
        self.add_internal_forces_and_part(motion, damping.stiffness(), &mut total, &mut release.partings);
        let mut released = vec![[0.0; 2]; total.len()];
        if self.released(&mut release, alpha, motion, &mut released).is_some() {
            let flat = total.as_flattened_mut().iter_mut().zip(released.as_flattened());
            flat.for_each(|(force, released)| *force += released);
        }
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
        let of_cracks: f64 =
            self.cracks.iter().zip(&motion.joints).map(|(crack, joints)| crack.energy(joints)).sum();
        match &self.outlines {
            Some(outlines) if !motion.meetings.is_empty() => of_cracks + outlines.energy(&motion.meetings),
            _ => of_cracks,
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Section};

    /// Three blocks, of which the upper two have slid, with cracks that are closed in places.
    fn slid() -> (Structure, Motion) {
        let rows = [vec![0.0, 1.0], vec![1.0, 2.0, 3.0], vec![3.0, 4.0]];
        let mesh = Mesh::mapped(&Section::rectangle(6.0, 4.0), &rows, 5);
        let material = Material { young_modulus: 1e9, density: 2400.0, ..Default::default() };
        let law = Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 1e9 };
        let cracks = [(law, Integration::Nodal), (law, Integration::Gauss)];
        let structure = Structure::new(mesh, &material, Kinematics::Corotational, cracks, &[]);
        let mut motion = structure.at_rest();
        for (block, [slip, press, turn]) in [(1, [0.1, 1e-4, 1e-4]), (2, [0.3, -1e-4, 3e-4])] {
            for node in structure.mesh.blocks[block].nodes.clone() {
                let [x, y] = structure.mesh.nodes[node];
                motion.displacement[node] = [slip - turn * y, turn * (x - 3.0) - press];
            }
        }
        (structure, motion)
    }

    /// `C v` with the contacts of `motion`.
    fn damping_force(structure: &Structure, motion: &Motion, velocity: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let there = motion.displacement.clone();
        let mut motion = Motion { velocity: velocity.to_vec(), ..motion.clone() };
        let mut release = structure.carried.release(2, 0.0);
        let mut forces = vec![[0.0; 2]; velocity.len()];
        let (none, partings) = (StiffnessDamping::default(), &mut release.partings);
        // each block above slips over the one below a little, which its contacts do all the time
        for (block, back) in [(1, 1e-3), (2, 2e-3)] {
            structure.mesh.blocks[block].nodes.clone().for_each(|n| motion.displacement[n][0] -= back);
        }
        structure.add_internal_forces_and_part(&mut motion, none, &mut forces, partings);
        motion.displacement.copy_from_slice(&there);
        structure.add_internal_forces_and_part(&mut motion, none, &mut forces, partings);
        assert!(structure.released(&mut release, 2.0, &motion, &mut forces).is_some());
        let nodes = forces.iter().zip(velocity).zip(&structure.mass);
        nodes.map(|((q, v), m)| [0, 1].map(|d| 2.0 * m * v[d] - q[d])).collect()
    }

    fn power(force: &[[f64; 2]], velocity: &[[f64; 2]]) -> f64 {
        force.as_flattened().iter().zip(velocity.as_flattened()).map(|(f, v)| f * v).sum()
    }

    fn random(seed: &mut u32, count: usize) -> Vec<[f64; 2]> {
        let mut next = || {
            *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(*seed) / f64::from(u32::MAX) - 0.5
        };
        (0..count).map(|_| [next(), next()]).collect()
    }

    #[test]
    fn the_damping_is_symmetric_and_never_gives_energy() {
        let (structure, motion) = slid();
        let mut seed = 3;
        for _ in 0..200 {
            let [v, w] = [0, 1].map(|_| random(&mut seed, structure.mass.len()));
            let [of_v, of_w] = [&v, &w].map(|v| damping_force(&structure, &motion, v));
            assert!(power(&of_v, &v) > 0.0);
            assert!((power(&of_v, &w) - power(&of_w, &v)).abs() < 1e-9 * power(&of_v, &v));
        }
    }

    /// The middle block slides and the upper one is in the air and turns: only the lower one could be damped.
    #[test]
    fn blocks_that_slide_or_turn_feel_nothing() {
        let (structure, mut motion) = slid();
        let (slides, flies) =
            (structure.mesh.blocks[1].nodes.clone(), structure.mesh.blocks[2].nodes.clone());
        slides.clone().chain(flies.clone()).for_each(|node| {
            let [x, y] = structure.mesh.nodes[node];
            let [slip, up, turn] = if flies.contains(&node) { [0.3, 0.8, 0.2] } else { [0.1, -1e-4, 0.0] };
            motion.displacement[node] = [slip - turn * y, up + turn * (x - 3.0)];
        });
        let velocity: Vec<[f64; 2]> = structure
            .mesh
            .nodes
            .iter()
            .zip(&motion.displacement)
            .enumerate()
            .map(|(node, (x, u))| {
                let [x, y] = [x[0] + u[0], x[1] + u[1]];
                match node {
                    node if flies.contains(&node) => [0.7 - 3.0 * y, 3.0 * x - 5.0],
                    node if slides.contains(&node) => [1.5, 0.0],
                    _ => [0.0; 2],
                }
            })
            .collect();
        let force = damping_force(&structure, &motion, &velocity);
        let largest = force.as_flattened().iter().fold(0.0f64, |a, f| a.max(f.abs()));
        let undiminished = 2.0 * structure.mass.iter().fold(0.0f64, |a, m| a.max(*m));
        assert!(largest < 1e-11 * undiminished, "{largest:e} of {undiminished:e} N/m");
    }

    /// The upper block rises from the middle one. Whether its contacts are closed or open by less than an atom makes no difference;
    /// open by a millimetre, they release it.
    #[test]
    fn a_gap_changes_the_damping_no_faster_than_its_contact_would_press() {
        let (structure, motion) = slid();
        let rises = structure.mesh.blocks[2].nodes.clone();
        let velocity: Vec<[f64; 2]> =
            (0..structure.mass.len()).map(|node| [0.0, f64::from(u8::from(rises.contains(&node)))]).collect();
        let force = |gap: f64| {
            let mut motion = motion.clone();
            structure.mesh.blocks[1].nodes.clone().for_each(|node| motion.displacement[node] = [0.1, 0.0]);
            rises.clone().for_each(|node| motion.displacement[node] = [0.3, gap]);
            damping_force(&structure, &motion, &velocity)
        };
        let difference = |gaps: [f64; 2]| {
            let [a, b] = gaps.map(force);
            a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (touching, released) = (difference([-1e-12, 1e-12]), difference([-1e-12, 1e-3]));
        let stiffness = 1e9 * 0.3; // k_n ℓ, N/m a metre of dam
        assert!(touching < 2e-12 * stiffness, "{touching:e} N/m");
        assert!(released > 100.0, "{released:e} N/m");
    }

    #[test]
    fn the_work_of_a_block_does_not_grow_with_their_number() {
        use crate::contact::effort::{self, Effort};
        use crate::energy::Work;
        use crate::integrator::CentralDifference;
        use crate::loads::LoadPath;
        use crate::{Geometry, Section};

        let material = Material { young_modulus: 1e9, density: 2500.0, ..Default::default() };
        let law = Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 0.5e9 };
        for (what, sizes) in [("wall", [[5, 2], [10, 5], [20, 10]]), ("stack", [[1, 10], [1, 50], [1, 200]])]
        {
            let spent = sizes.map(|[columns, rows]: [usize; 2]| {
                let [width, height] = [columns, rows].map(|count| count as f64);
                let upright = (1..columns).map(|i| vec![[i as f64, -1.0], [i as f64, height + 1.0]]);
                let level = (1..rows).map(|i| vec![[-1.0, i as f64], [width + 1.0, i as f64]]);
                let section = Section::rectangle(width, height);
                let mesh = Mesh::of_section(&Geometry {
                    upstream: &section.upstream,
                    downstream: &section.downstream,
                    galleries: &[],
                    cracks: &upright.chain(level).collect::<Vec<_>>(),
                    upstream_levels: &[],
                    downstream_levels: &[],
                    element_size: 0.6,
                    crack_sizes: &[],
                    zones: &[],
                })
                .expect("a mesh");
                let blocks = mesh.blocks.len();
                assert_eq!(blocks, columns * rows);
                let laws = vec![(law, Integration::Nodal); columns + rows - 2];
                let structure = Structure::new(mesh, &material, Kinematics::Corotational, laws, &[]);
                let mut motion = structure.at_rest();
                // the blocks part and come together again
                for (index, block) in structure.mesh.blocks.iter().enumerate() {
                    let v = [0.01, -0.02, 0.015, -0.005][index % 4];
                    block.nodes.clone().for_each(|node| motion.velocity[node] = [v, -v]);
                }
                let (steps, none) = (CentralDifference { time_step: 1e-4, steps: 10 }, structure.weight([0.0; 2]));
                structure.accelerate(DampingCoefficients::NONE, &mut motion, &none);
                effort::take();
                let loads = LoadPath::constant(none);
                for _ in 0..20 {
                    steps.advance(&structure, DampingCoefficients::NONE, &mut motion, &loads, &mut Work::default());
                }
                let contacts: usize = motion.joints.iter().map(Vec::len).sum();
                let Effort { segments, boxes, edges } = effort::take();
                let each = |count: usize, of: usize| count as f64 / of as f64;
                let found = [each(segments, 200 * contacts), each(edges, 20 * blocks), each(boxes, 20 * blocks)];
                println!(
                    "{what} of {blocks} blocks, {contacts} contacts: {:.3} segments a contact and time step; a block and \
                     communication step {:.1} edges, {:.1} pairs of boxes",
                    found[0], found[1], found[2]
                );
                found
            });
            let [few, _, many] = spent;
            // every contact is visited once a time step, and hardly looks farther than its own segment
            assert!(spent.iter().all(|[segments, ..]| (1.0..1.1).contains(segments)));
            // inner blocks have more neighbours than those on the outside: 3 a block in a small wall, 4 in a large one
            assert!(many[1] < 2.0 * few[1].max(1.0));
            // the boxes in a column of a wall overlap along it
            let neighbours = if what == "wall" { 30.0 } else { 3.0 };
            assert!(many[2] <= neighbours);
        }
    }
}
