use nalgebra::{DMatrix, DVector};
use std::collections::HashSet;

use crate::contact::ContactLaw;
use crate::modal::{self, DegreesOfFreedom};
use crate::structure::Structure;
use crate::{DamError, Fidelity, Mesh};

/// Shapes that span the displacements at a level of fidelity: columns, with x, then y of each node.
pub(super) struct Basis {
    /// Parts without common inertia or stiffness: one for each block, or one for the whole dam.
    pub parts: Vec<DMatrix<f64>>,
    /// Largest [estimate](truncation) of all parts; 0 if no mode is omitted.
    pub truncation: f64,
}

/// Highest circular frequency of the ground motion, rad/s: records are resolved up to 25–33 Hz.
pub(super) const HIGHEST_EXCITATION: f64 = 200.0;
/// Truncation estimate at which the number of modes is sufficient.
const TRUNCATION: f64 = 0.02;
/// Numbers of modes to try, ascending.
const COUNTS: [usize; 5] = [8, 16, 24, 36, 54];
/// Relative change of the squared frequencies at which the modes have converged. The static shapes make up for the
/// remaining error.
const TOLERANCE: f64 = 1e-6;
/// Smallest share of the strain energy of a static shape that the shapes before it do not contain.
const NEW: f64 = 1e-12;

impl Basis {
    /// The basis of a level of fidelity other than [`Fidelity::Dem`]; `loads` are the static loads (nodal forces as
    /// columns).
    pub fn new(
        structure: &Structure<impl ContactLaw>,
        fidelity: Fidelity,
        loads: &DMatrix<f64>,
    ) -> Result<Self, DamError> {
        let mesh = &structure.mesh;
        let mut basis = Self { parts: Vec::new(), truncation: 0.0 };
        match fidelity {
            Fidelity::Dem => {}
            Fidelity::Intact { modes } => {
                let dofs = DegreesOfFreedom::intact(structure);
                let held = Held::new(structure, &dofs)?;
                basis.add(held.modes_and_static_shapes(modes, loads)?);
            }
            Fidelity::Reduced { modes } => {
                for (index, block) in mesh.blocks.iter().enumerate() {
                    let sides = sides_of(mesh, index);
                    let inside = block.nodes.clone().filter(|node| !sides.contains(node));
                    let dofs = DegreesOfFreedom::of_nodes(structure, inside);
                    let held = Held::new(structure, &dofs)?;
                    let (inner, truncation) = held.modes_and_static_shapes(modes, loads)?;
                    let free: Vec<usize> =
                        sides.iter().copied().filter(|&node| !structure.is_fixed(node)).collect();
                    let constraint = held.constraint_shapes(&free);
                    let columns: Vec<_> =
                        constraint.iter().cloned().chain(inner.column_iter().map(Into::into)).collect();
                    basis.add((DMatrix::from_columns(&columns), truncation));
                }
            }
            Fidelity::RigidBlocks => {
                let blocks = mesh.blocks.iter().enumerate();
                for (index, block) in blocks.filter(|(_, block)| !structure.is_held(block)) {
                    let pivot = sides_of(mesh, index).first().copied().unwrap_or(block.nodes.start);
                    let [x, y] = mesh.nodes[pivot];
                    let mut shapes = DMatrix::zeros(2 * mesh.nodes.len(), 3);
                    for node in block.nodes.clone() {
                        let [px, py] = mesh.nodes[node];
                        shapes[(2 * node, 0)] = 1.0;
                        shapes[(2 * node + 1, 1)] = 1.0;
                        shapes[(2 * node, 2)] = y - py;
                        shapes[(2 * node + 1, 2)] = px - x;
                    }
                    basis.add((shapes, 0.0));
                }
            }
        }
        Ok(basis)
    }

    fn add(&mut self, (shapes, truncation): (DMatrix<f64>, f64)) {
        self.parts.push(shapes);
        self.truncation = self.truncation.max(truncation);
    }
}

/// Nodes of a block on cracks, each once: first those whose lower side is another body.
fn sides_of(mesh: &Mesh, block: usize) -> Vec<usize> {
    let above = mesh.seams.iter().filter(|seam| seam.above == block).flat_map(|seam| &seam.upper);
    let below = mesh.seams.iter().filter(|seam| seam.below == block).flat_map(|seam| &seam.lower);
    let mut seen = HashSet::new();
    above.chain(below).copied().filter(|&node| seen.insert(node)).collect()
}

/// A part of the dam, with all other nodes held.
struct Held<'a, L: ContactLaw> {
    structure: &'a Structure<L>,
    dofs: &'a DegreesOfFreedom,
    factors: faer::sparse::linalg::solvers::Llt<usize, f64>,
    masses: Vec<f64>,
}

impl<'a, L: ContactLaw> Held<'a, L> {
    fn new(structure: &'a Structure<L>, dofs: &'a DegreesOfFreedom) -> Result<Self, DamError> {
        let stiffness = modal::element_stiffness(structure, dofs);
        let factors = modal::factor(&stiffness, dofs.count)?;
        Ok(Self { structure, dofs, factors, masses: dofs.masses(structure) })
    }

    /// Values at the degrees of freedom as values at all nodes.
    fn at_nodes(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        let mut nodes = DMatrix::zeros(2 * self.structure.mesh.nodes.len(), values.ncols());
        for (node, dof) in self.dofs.nodes() {
            nodes.rows_mut(2 * node, 2).copy_from(&values.rows(dof, 2));
        }
        nodes
    }

    /// Sums of nodal forces at the degrees of freedom.
    fn of_nodes(&self, nodes: &DMatrix<f64>) -> DMatrix<f64> {
        let mut values = DMatrix::zeros(self.dofs.count, nodes.ncols());
        for (node, dof) in self.dofs.nodes() {
            let mut rows = values.rows_mut(dof, 2);
            rows += nodes.rows(2 * node, 2);
        }
        values
    }

    /// The lowest modes (`count`, or as many as the truncation estimate requires), and the static correction
    /// for ground accelerations and `loads`. Also returns the estimate.
    fn modes_and_static_shapes(
        &self,
        count: Option<usize>,
        loads: &DMatrix<f64>,
    ) -> Result<(DMatrix<f64>, f64), DamError> {
        let available = self.dofs.count;
        let counts = count.map_or(COUNTS.to_vec(), |count| vec![count]);
        let mut found = (DMatrix::zeros(available, 0), Vec::new(), 0.0);
        for count in counts {
            let count = count.min(available);
            // one more mode for the estimate
            let more = (count + 1).min(available);
            let (frequencies, modes) = modal::natural_modes(&self.factors, &self.masses, more, TOLERANCE)?;
            let modes = modes.columns(0, count).into_owned();
            let next = frequencies.get(count).copied();
            found.2 = next.map_or(0.0, |next| truncation(&modes, &self.masses, next));
            (found.0, found.1) = (modes, frequencies);
            if found.2 <= TRUNCATION {
                break;
            }
        }
        let (modes, frequencies, truncation) = found;
        let mut statics = self.of_nodes(loads);
        for direction in 0..2 {
            let inertia =
                DVector::from_fn(available, |i, _| if i % 2 == direction { self.masses[i] } else { 0.0 });
            let at = statics.ncols();
            statics = statics.insert_column(at, 0.0);
            statics.set_column(at, &inertia);
        }
        let mut columns: Vec<DVector<f64>> = modes.column_iter().map(Into::into).collect();
        let mut stiff: Vec<f64> = frequencies.iter().take(modes.ncols()).map(|w| w * w).collect();
        let mut forces: Vec<DVector<f64>> = columns
            .iter()
            .zip(&stiff)
            .map(|(mode, square)| DVector::from_fn(available, |i, _| square * self.masses[i] * mode[i]))
            .collect();
        // make each shape K-orthogonal to all previous ones, with their forces K φ
        for load in statics.column_iter() {
            let mut load: DVector<f64> = load.into();
            let mut shape: DVector<f64> =
                modal::solve(&self.factors, &DMatrix::from_columns(&[load.clone()])).column(0).into();
            let whole = shape.dot(&load);
            for _ in 0..2 {
                for ((column, force), energy) in columns.iter().zip(&forces).zip(&stiff) {
                    let share = column.dot(&load) / energy;
                    shape -= column * share;
                    load -= force * share;
                }
            }
            let left = shape.dot(&load);
            if left > NEW * whole {
                columns.push(shape);
                forces.push(load);
                stiff.push(left);
            }
        }
        let shapes =
            if columns.is_empty() { DMatrix::zeros(available, 0) } else { DMatrix::from_columns(&columns) };
        Ok((self.at_nodes(&shapes), truncation))
    }

    /// Static shapes for unit displacements of the nodes `sides`: x, then y of each node.
    fn constraint_shapes(&self, sides: &[usize]) -> Vec<DVector<f64>> {
        let units = units(self.structure, sides);
        if units.is_empty() {
            return units;
        }
        let mut forces = DMatrix::zeros(units[0].len(), units.len());
        for (unit, mut force) in units.iter().zip(forces.column_iter_mut()) {
            force.copy_from(&-self.structure.stiffness_times(unit));
        }
        let inside = self.at_nodes(&modal::solve(&self.factors, &self.of_nodes(&forces)));
        units.iter().zip(inside.column_iter()).map(|(unit, inside)| unit + inside).collect()
    }
}

/// Unit displacements along x, then y, of each of `nodes`.
fn units(structure: &Structure<impl ContactLaw>, nodes: &[usize]) -> Vec<DVector<f64>> {
    let size = 2 * structure.mesh.nodes.len();
    let unit = |dof: usize| DVector::from_fn(size, |i, _| if i == dof { 1.0 } else { 0.0 });
    nodes.iter().flat_map(|&node| [unit(2 * node), unit(2 * node + 1)]).collect()
}

/// Estimate of the dynamic response of the omitted modes, from the circular frequency `next` (rad/s) on, at
/// the highest excitation frequency ω_e, in addition to their static response:
///
/// ```text
/// (1 − Σ Γ²/m) (ω_e/ω_next)²,   Γ = φᵀ M ι
/// ```
///
/// in the direction where it is larger. It is an upper bound of `Σ Γ²/m (ω_e/ω)²` over the omitted modes,
/// with the total mass m.
fn truncation(modes: &DMatrix<f64>, masses: &[f64], next: f64) -> f64 {
    let left_out = |direction: usize| {
        let along = || masses.iter().enumerate().filter(move |(i, _)| i % 2 == direction);
        let whole: f64 = along().map(|(_, mass)| mass).sum();
        let factor = |mode: usize| along().map(|(i, mass)| mass * modes[(i, mode)]).sum::<f64>();
        1.0 - (0..modes.ncols()).map(|mode| factor(mode).powi(2)).sum::<f64>() / whole
    };
    left_out(0).max(left_out(1)).max(0.0) * (HIGHEST_EXCITATION / next).powi(2)
}
