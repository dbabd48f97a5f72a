use nalgebra::{DMatrix, DVector, SymmetricEigen};
use pulp::Simd;
use std::ops::Range;

use super::motion::ModalMotion;
use super::product::{LANES, used};
use super::release::ModalRelease;
use crate::Kinematics;
use crate::contact::{ContactBatches, ContactLaw, Crack, MohrCoulomb, NodalFields, Parting, Stencil};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;
use crate::release::Release;
use crate::structure::Structure;

/// Cracks, with a numbering of the nodes on their sides only.
///
/// A block that the ground does not hold can rotate by a finite angle. With the mean rotation θ and the mean displacement t
/// of its modes, and the position r of a node relative to the centre of mass of the block,
///
/// ```text
/// u = t + (R(θ) − 1) r + R(θ) u_e,   u_e = φ q − t − θ × r
/// ```
///
/// Contact forces act on the coordinates through the exact derivative of u, so that their work is exact.
/// Weight, water and inertia act on the linear shapes: the moment of the weight follows from the motion of
/// the supports.
#[derive(Clone, Debug)]
pub(super) struct CrackSides {
    pub cracks: Vec<Crack<MohrCoulomb>>,
    /// Unloaded positions, m.
    pub rest: Vec<[f64; 2]>,
    /// Frames of the blocks that the ground does not hold; none with small-strain kinematics.
    frames: Vec<Frame>,
    /// One row for each mode: its shape at x, then y of each node, then t and θ of each frame.
    by_mode: Rows,
    /// The transpose of `by_mode`.
    by_value: Rows,
}

/// The nodes of a block among those of the sides, and their positions relative to its centre of mass, m.
#[derive(Clone, Debug)]
struct Frame {
    nodes: Range<usize>,
    places: Vec<[f64; 2]>,
}

/// Rows of equal length, a multiple of [`LANES`]. Of each four only the columns are kept in which one of them is not zero: modes of one block are zero on the others.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    values: Vec<f64>,
    /// The columns of each four rows.
    columns: Vec<Range<usize>>,
    count: usize,
    width: usize,
}

impl Rows {
    /// The columns of `matrix` as rows.
    pub fn of_columns(matrix: &DMatrix<f64>) -> Self {
        let (count, width) = (matrix.ncols(), matrix.nrows().next_multiple_of(LANES));
        let (mut values, mut columns) = (Vec::new(), Vec::new());
        for first in (0..count).step_by(4) {
            let rows = first..count.min(first + 4);
            let own = used(matrix.nrows(), |i| rows.clone().any(|row| matrix[(i, row)] != 0.0));
            let value = |i: usize, row: usize| if i < matrix.nrows() { matrix[(i, row)] } else { 0.0 };
            values.extend(rows.flat_map(|row| own.clone().map(move |i| value(i, row))));
            columns.push(own);
        }
        Self { values, columns, count, width }
    }

    /// Writes `Σ coefficient × row` to `sum`; coefficients beyond the last row are ignored.
    #[inline(always)]
    pub fn combine(&self, coefficients: &[f64], sum: &mut [f64]) {
        sum.fill(0.0);
        let mut values = &self.values[..];
        let (fours, rest) = coefficients[..self.count].as_chunks::<4>();
        for (columns, &[a, b, c, d]) in self.columns.iter().zip(fours) {
            let (rows, others) = values.split_at(4 * columns.len());
            values = others;
            let (first, second) = rows.split_at(2 * columns.len());
            let ((p, q), (r, s)) = (first.split_at(columns.len()), second.split_at(columns.len()));
            for ((((sum, p), q), r), s) in sum[columns.start..].iter_mut().zip(p).zip(q).zip(r).zip(s) {
                *sum += (a * p + b * q) + (c * r + d * s);
            }
        }
        let Some(columns) = self.columns.last().filter(|columns| !columns.is_empty()) else { return };
        for (row, coefficient) in values.chunks_exact(columns.len()).zip(rest) {
            sum[columns.start..].iter_mut().zip(row).for_each(|(sum, value)| *sum += coefficient * value);
        }
    }
}

/// Motion of the sides, and the contact forces on them.
pub(super) struct Pressing {
    displacement: Vec<[f64; 2]>,
    velocity: Vec<[f64; 2]>,
    forces: Vec<[f64; 2]>,
    values: Vec<f64>,
    /// Mean displacement (m) of each frame, rotation θ (rad), sin θ and 1 − cos θ.
    means: Vec<Turn>,
}

#[derive(Clone, Copy, Default)]
struct Turn {
    displacement: [f64; 2],
    angle: f64,
    sin: f64,
    versine: f64,
}

impl Turn {
    #[inline(always)]
    fn of(&[x, y, angle]: &[f64; 3]) -> Self {
        let (half_sin, half_cos) = (angle / 2.0).sin_cos();
        Self {
            displacement: [x, y],
            angle,
            sin: 2.0 * half_sin * half_cos,
            versine: 2.0 * half_sin * half_sin,
        }
    }
}

impl CrackSides {
    /// The sides of the cracks of `structure` for modes with `shapes` (rows: modes; columns: x, then y of each node).
    pub fn of(
        structure: &Structure<MohrCoulomb>,
        shapes: &DMatrix<f64>,
        cracked: bool,
        kinematics: Kinematics,
    ) -> Self {
        let mesh = &structure.mesh;
        let cracks = if cracked { &structure.cracks[..] } else { &[] };
        let mut nodes: Vec<usize> = cracks.iter().flat_map(|crack| crack.sides().concat()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |node: usize| nodes.partition_point(|&other| other < node);
        let rest: Vec<[f64; 2]> = nodes.iter().map(|&node| mesh.nodes[node]).collect();
        let mut columns: Vec<DVector<f64>> =
            nodes.iter().flat_map(|&node| [0, 1].map(|d| shapes.column(2 * node + d).into())).collect();
        let mut frames = Vec::new();
        if kinematics.has_finite_rotations() && cracked {
            for block in mesh.blocks.iter().filter(|block| !structure.is_held(block)) {
                let mean = Mean::of(structure, block.nodes.clone(), shapes);
                let nodes = number(block.nodes.start)..number(block.nodes.end);
                let places =
                    rest[nodes.clone()].iter().map(|x| [x[0] - mean.centre[0], x[1] - mean.centre[1]]);
                frames.push(Frame { places: places.collect(), nodes });
                columns.extend(mean.displacement.into_iter().chain([mean.rotation]));
            }
        }
        let matrix = if columns.is_empty() {
            DMatrix::zeros(shapes.nrows(), 0)
        } else {
            DMatrix::from_columns(&columns)
        };
        Self {
            cracks: cracks.iter().map(|crack| crack.renumbered(number)).collect(),
            rest,
            frames,
            by_mode: Rows::of_columns(&matrix.transpose()),
            by_value: Rows::of_columns(&matrix),
        }
    }

    /// Modal stiffness matrix with all contacts closed and sticking; `stiffness`, (rad/s)², is that of the
    /// modes alone.
    pub fn closed_stiffness(&self, stiffness: &[f64]) -> DMatrix<f64> {
        let contacts = self.of_contacts(stiffness.len(), self.cracks.iter().flat_map(Crack::stencils));
        DMatrix::from_diagonal(&DVector::from_row_slice(stiffness)) + contacts
    }

    /// Matrix of linearised contacts between this number of modes; displacements are linear in their coordinates.
    pub fn of_contacts(&self, modes: usize, stencils: impl Iterator<Item = Stencil>) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(modes, modes);
        let shape = |dof: usize| {
            let mut unit = vec![0.0; self.by_value.count];
            unit[dof] = 1.0;
            let mut row = DVector::zeros(self.by_value.width);
            self.by_value.combine(&unit, row.as_mut_slice());
            row.rows(0, modes).into_owned()
        };
        for stencil in stencils {
            let relative = [0, 1].map(|d| {
                let parts = stencil.nodes.iter().zip(stencil.weights);
                let part = |(&node, weight)| shape(2 * node + d) * weight;
                parts.map(part).sum::<DVector<f64>>()
            });
            for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                matrix.ger(stencil.stiffness[p][q], &relative[p], &relative[q], 1.0);
            }
        }
        matrix
    }

    /// Velocities of the sides for these rates, linear in them.
    pub fn velocity(&self, rates: &[f64]) -> Vec<[f64; 2]> {
        let mut values = vec![0.0; self.by_mode.width];
        self.by_mode.combine(rates, &mut values);
        values.as_chunks().0[..self.rest.len()].to_vec()
    }

    /// Modal forces of forces on the sides in the unloaded position.
    pub fn forces(&self, forces: &[[f64; 2]]) -> Vec<f64> {
        let mut values = vec![0.0; self.by_mode.width.max(self.by_value.count)];
        values[..2 * forces.len()].copy_from_slice(forces.as_flattened());
        let mut mapped = vec![0.0; self.by_value.width];
        self.by_value.combine(&values, &mut mapped);
        mapped
    }

    /// Padded length of a list with one value for each mode.
    pub fn modes_width(&self) -> usize {
        self.by_value.width
    }

    /// Highest circular frequency with all contacts closed and sticking, rad/s.
    pub fn highest_frequency(&self, stiffness: &[f64]) -> f64 {
        SymmetricEigen::new(self.closed_stiffness(stiffness)).eigenvalues.max().sqrt()
    }
}

impl Pressing {
    pub fn at(sides: &CrackSides, coordinates: &[f64]) -> Self {
        let zero = vec![[0.0; 2]; sides.rest.len()];
        let values = vec![0.0; sides.by_mode.width];
        let means = vec![Turn::default(); sides.frames.len()];
        let mut pressing =
            Self { displacement: zero.clone(), velocity: zero.clone(), forces: zero, values, means };
        pressing.follow(sides, coordinates, None);
        pressing
    }

    /// Computes the displacement from the coordinates, and the velocity as its change over `time_step` (s), if given.
    #[inline(always)]
    pub fn follow(&mut self, sides: &CrackSides, coordinates: &[f64], time_step: Option<f64>) {
        std::mem::swap(&mut self.velocity, &mut self.displacement);
        sides.by_mode.combine(coordinates, &mut self.values);
        let (nodes, means) = self.values.split_at(2 * sides.rest.len());
        for (turn, mean) in self.means.iter_mut().zip(means.as_chunks().0) {
            *turn = Turn::of(mean);
        }
        for (u, linear) in self.displacement.iter_mut().zip(nodes.as_chunks().0) {
            *u = *linear;
        }
        for (frame, turn) in sides.frames.iter().zip(&self.means) {
            let Turn { displacement: [tx, ty], angle, sin, versine } = *turn;
            for (u, [x, y]) in self.displacement[frame.nodes.clone()].iter_mut().zip(&frame.places) {
                let (p, q) = (u[0] - tx + angle * y, u[1] - ty - angle * x);
                let (x, y) = (x + p, y + q);
                *u = [tx + p - versine * x - sin * y, ty + q + sin * x - versine * y];
            }
        }
        let Some(dt) = time_step else { return self.velocity.fill([0.0; 2]) };
        for (v, u) in self.velocity.as_flattened_mut().iter_mut().zip(self.displacement.as_flattened()) {
            *v = (u - *v) / dt;
        }
    }

    /// Updates the `contacts` of `motion`, whose joints are up to date after [`ContactBatches::write`], and their modal forces; also
    /// finds how the sides of cracks part if `partings` is not empty.
    #[inline(always)]
    pub fn press<S: Simd>(
        &mut self,
        simd: S,
        sides: &CrackSides,
        contacts: &mut ContactBatches,
        motion: &mut ModalMotion,
        damping: StiffnessDamping,
        partings: &mut [Parting],
    ) -> Losses {
        self.forces.fill([0.0; 2]);
        let (u, v, forces) = (&self.displacement, &self.velocity, &mut self.forces);
        let fields = NodalFields { u, v, damping, forces, partings };
        let losses = contacts.add_forces(simd, &sides.cracks, &mut motion.joints, fields);
        self.map_forces(sides, &mut motion.contact_forces);
        losses
    }

    /// Updates the contacts of `motion` and their modal forces, once.
    pub fn press_once(&mut self, sides: &CrackSides, motion: &mut ModalMotion, damping: StiffnessDamping) {
        let mut contacts = ContactBatches::new(&sides.cracks, &motion.joints);
        self.forces.fill([0.0; 2]);
        let (u, v, forces) = (&self.displacement, &self.velocity, &mut self.forces);
        let fields = NodalFields { u, v, damping, forces, partings: &mut [] };
        contacts.add_forces_widely(&sides.cracks, &mut motion.joints, fields);
        contacts.write(&mut motion.joints);
        self.map_forces(sides, &mut motion.contact_forces);
    }

    /// Sets `mapped` to the modal forces that release blocks from mass damping, if a crack parts; returns the sum of the
    /// nodal forces, N/m.
    #[inline(always)]
    pub fn release(
        &mut self,
        sides: &CrackSides,
        blocks: &ModalRelease,
        rates: &[f64],
        release: &mut Release,
        mapped: &mut [f64],
    ) -> Option<[f64; 2]> {
        if !release.find_rates(blocks.carried()) {
            return None;
        }
        self.forces.fill([0.0; 2]);
        blocks.add_dual(release, rates, &mut self.forces);
        self.map_forces(sides, mapped);
        Some(blocks.add_rigid(&release.rates, mapped))
    }

    /// Sets `mapped` to the modal forces of the forces on the sides.
    #[inline(always)]
    fn map_forces(&mut self, sides: &CrackSides, mapped: &mut [f64]) {
        let (nodes, means) = self.values.split_at_mut(2 * sides.rest.len());
        let means = means.as_chunks_mut::<3>().0.iter_mut();
        for ((frame, mean), turn) in sides.frames.iter().zip(means).zip(&self.means) {
            let Turn { displacement: [tx, ty], sin, versine, .. } = *turn;
            *mean = [0.0; 3];
            let places =
                self.forces[frame.nodes.clone()].iter_mut().zip(&self.displacement[frame.nodes.clone()]);
            for ((force, u), [x, y]) in places.zip(&frame.places) {
                let [fx, fy] = *force;
                // force in the frame of the block, and its difference from the force in the fixed frame
                let lack = [versine * fx - sin * fy, versine * fy + sin * fx];
                *force = [fx - lack[0], fy - lack[1]];
                let (px, py) = (u[0] - tx, u[1] - ty);
                // u_e = Rᵀ (r + p) − r
                let (p, q) = (px + x, py + y);
                let (ex, ey) = (p - versine * p + sin * q - x, q - versine * q - sin * p - y);
                mean[0] += lack[0];
                mean[1] += lack[1];
                mean[2] += ex * force[1] - ey * force[0];
            }
        }
        nodes.copy_from_slice(self.forces.as_flattened());
        sides.by_value.combine(&self.values, mapped);
    }
}

/// Mass-weighted mean motion of a block relative to the unloaded position, with one value for each mode.
pub(super) struct Mean {
    /// Centre of mass, m.
    pub centre: [f64; 2],
    /// Displacement of the centre.
    pub displacement: [DVector<f64>; 2],
    /// `Σ m r × φ / Σ m r²`.
    pub rotation: DVector<f64>,
}

impl Mean {
    pub fn of(structure: &Structure<impl ContactLaw>, nodes: Range<usize>, shapes: &DMatrix<f64>) -> Self {
        let place = |node: usize| (structure.mass[node], structure.mesh.nodes[node]);
        let whole: f64 = structure.mass[nodes.clone()].iter().sum();
        let centre = [0, 1].map(|d| nodes.clone().map(place).map(|(m, x)| m * x[d]).sum::<f64>() / whole);
        let zero = DVector::zeros(shapes.nrows());
        let (mut displacement, mut rotation, mut moment) = ([zero.clone(), zero.clone()], zero, 0.0);
        for node in nodes {
            let (mass, [x, y]) = place(node);
            let [x, y] = [x - centre[0], y - centre[1]];
            let [u, v] = [0, 1].map(|d| shapes.column(2 * node + d));
            displacement[0].axpy(mass / whole, &u, 1.0);
            displacement[1].axpy(mass / whole, &v, 1.0);
            rotation.axpy(-mass * y, &u, 1.0);
            rotation.axpy(mass * x, &v, 1.0);
            moment += mass * (x * x + y * y);
        }
        Self { centre, displacement, rotation: rotation / moment }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of blocks, a row of zeros, and numbers that no group of four or width of eight divides: as the product with the whole matrix.
    #[test]
    fn combinations_are_products() {
        let number = |i: usize, j: usize| ((1 + i * 7 + j * 13) as f64).sin();
        for (rows, columns) in [(1, 1), (4, 8), (7, 19), (10, 40), (13, 33)] {
            let matrix = DMatrix::from_fn(columns, rows, |i, j| {
                let is_of_its_block = (i < columns / 2) == (j < rows / 2) && j != 5;
                if is_of_its_block { number(i, j) } else { 0.0 }
            });
            let coefficients: Vec<f64> = (0..rows + 3).map(|i| number(i, 99)).collect();
            let exact = &matrix * DVector::from_row_slice(&coefficients[..rows]);
            for length in [columns, columns.next_multiple_of(LANES)] {
                let mut sum = vec![7.0; length];
                Rows::of_columns(&matrix).combine(&coefficients, &mut sum);
                let expected = exact.iter().copied().chain(std::iter::repeat(0.0));
                assert!(sum.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{rows}, {columns}");
            }
        }
        Rows::of_columns(&DMatrix::zeros(0, 0)).combine(&[1.0], &mut []);
    }
}
