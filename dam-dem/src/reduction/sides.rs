use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::motion::ModalMotion;
use crate::Kinematics;
use crate::contact::{ContactLaw, Crack, MohrCoulomb};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;
use crate::structure::Structure;

/// Cracks, with the nodes of their sides numbered among themselves.
///
/// A block that stands free turns by a finite angle: with the mean θ of its modes' rotations, t that of their
/// displacements, and a node's place r from the block's centre of mass,
///
/// ```text
/// u = t + (R(θ) − 1) r + R(θ) u_e,   u_e = φ q − t − θ × r
/// ```
///
/// and contact forces act on the coordinates through the exact derivative of u, so that none of them works twice.
/// Weight, water and inertia act on the linear shapes: the moment of the weight comes from where its support moves.
#[derive(Clone, Debug)]
pub(super) struct CrackSides {
    pub cracks: Vec<Crack<MohrCoulomb>>,
    /// Positions without load, m.
    pub rest: Vec<[f64; 2]>,
    /// Frames of the blocks that stand free; none where strains are small.
    frames: Vec<Frame>,
    /// Rows of one mode each: its shape at x, then y of each node, then t and θ of each frame.
    by_mode: Rows,
    /// The same transposed.
    by_value: Rows,
}

/// A block's nodes among those of the sides, and their places from its centre of mass, m.
#[derive(Clone, Debug)]
struct Frame {
    nodes: std::ops::Range<usize>,
    places: Vec<[f64; 2]>,
}

/// Rows of equal length, padded with zeros.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    values: Vec<f64>,
    count: usize,
    width: usize,
}

/// Values a row is padded to a multiple of.
const LANES: usize = 8;

impl Rows {
    /// Rows of the columns of `matrix`.
    pub fn of_columns(matrix: &DMatrix<f64>) -> Self {
        let width = matrix.nrows().next_multiple_of(LANES);
        let mut values = vec![0.0; width * matrix.ncols()];
        for (row, column) in values.chunks_exact_mut(width.max(1)).zip(matrix.column_iter()) {
            row.iter_mut().zip(column.iter()).for_each(|(to, from)| *to = *from);
        }
        Self { values, count: matrix.ncols(), width }
    }

    /// Length of a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Writes `Σ coefficient × row` to `sum`; coefficients beyond the last row are left.
    #[inline(always)]
    pub fn combine(&self, coefficients: &[f64], sum: &mut [f64]) {
        sum.fill(0.0);
        let width = self.width;
        let (fours, rest) = coefficients[..self.count].as_chunks::<4>();
        let (values, last) = self.values.split_at(4 * fours.len() * width);
        for (rows, &[a, b, c, d]) in values.chunks_exact(4 * width.max(1)).zip(fours) {
            let (first, second) = rows.split_at(2 * width);
            let ((p, q), (r, s)) = (first.split_at(width), second.split_at(width));
            for ((((sum, p), q), r), s) in sum.iter_mut().zip(p).zip(q).zip(r).zip(s) {
                *sum += (a * p + b * q) + (c * r + d * s);
            }
        }
        for (row, coefficient) in last.chunks_exact(width.max(1)).zip(rest) {
            sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += coefficient * value);
        }
    }
}

/// Where the sides are, and what the contacts do to them.
pub(super) struct Pressing {
    displacement: Vec<[f64; 2]>,
    velocity: Vec<[f64; 2]>,
    forces: Vec<[f64; 2]>,
    values: Vec<f64>,
}

impl CrackSides {
    /// Those of the cracks of `structure` between modes with `shapes` (modes × x, then y of each node).
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
        let number = |node: usize| nodes.partition_point(|&other| other < node);
        let rest: Vec<[f64; 2]> = nodes.iter().map(|&node| mesh.nodes[node]).collect();
        let mut columns: Vec<DVector<f64>> =
            nodes.iter().flat_map(|&node| [0, 1].map(|d| shapes.column(2 * node + d).into())).collect();
        let mut frames = Vec::new();
        if kinematics == Kinematics::Corotational && cracked {
            for block in &mesh.blocks[1..] {
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

    /// Stiffness of modes that alone have `stiffness`, (rad/s)², with all contacts closed and sticking.
    pub fn closed_stiffness(&self, stiffness: &[f64]) -> DMatrix<f64> {
        let mut matrix = DMatrix::from_diagonal(&DVector::from_row_slice(stiffness));
        let width = self.by_value.width;
        let shape = |dof: usize| &self.by_value.values[dof * width..][..stiffness.len()];
        for stencil in self.cracks.iter().flat_map(Crack::stencils) {
            let relative = [0, 1].map(|d| {
                let parts = stencil.nodes.iter().zip(stencil.weights);
                let part = |(&node, weight)| DVector::from_row_slice(shape(2 * node + d)) * weight;
                parts.map(part).sum::<DVector<f64>>()
            });
            for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                matrix.ger(stencil.stiffness[p][q], &relative[p], &relative[q], 1.0);
            }
        }
        matrix
    }

    /// Length of a list of one value a mode, padded.
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
        let mut pressing = Self { displacement: zero.clone(), velocity: zero.clone(), forces: zero, values };
        pressing.follow(sides, coordinates, None);
        pressing
    }

    /// Displacement from the coordinates; velocity as its change over a `time_step` (s), if that is given.
    #[inline(always)]
    pub fn follow(&mut self, sides: &CrackSides, coordinates: &[f64], time_step: Option<f64>) {
        std::mem::swap(&mut self.velocity, &mut self.displacement);
        sides.by_mode.combine(coordinates, &mut self.values);
        let (nodes, means) = self.values.split_at(2 * sides.rest.len());
        for (u, linear) in self.displacement.iter_mut().zip(nodes.as_chunks().0) {
            *u = *linear;
        }
        for (frame, &[tx, ty, angle]) in sides.frames.iter().zip(means.as_chunks().0) {
            let (sin, versine) = (angle.sin(), 2.0 * (angle / 2.0).sin().powi(2));
            for (u, [x, y]) in self.displacement[frame.nodes.clone()].iter_mut().zip(&frame.places) {
                let (p, q) = (u[0] - tx + angle * y, u[1] - ty - angle * x);
                let (x, y) = (x + p, y + q);
                *u = [tx + p - versine * x - sin * y, ty + q + sin * x - versine * y];
            }
        }
        for (v, u) in self.velocity.iter_mut().zip(&self.displacement) {
            *v = time_step.map_or([0.0; 2], |dt| [(u[0] - v[0]) / dt, (u[1] - v[1]) / dt]);
        }
    }

    /// Brings the contacts of `motion` up to date and finds their modal forces.
    #[inline(always)]
    pub fn press(
        &mut self,
        sides: &CrackSides,
        motion: &mut ModalMotion,
        damping: StiffnessDamping,
    ) -> Losses {
        let mut losses = Losses::default();
        self.forces.fill([0.0; 2]);
        let (u, v) = (&self.displacement, &self.velocity);
        for (crack, joints) in sides.cracks.iter().zip(&mut motion.joints) {
            let lost = crack.add_forces(u, v, damping, joints, &mut self.forces);
            losses.friction += lost.friction;
            losses.damping_power += lost.damping_power;
        }
        let (nodes, means) = self.values.split_at_mut(2 * sides.rest.len());
        for (frame, mean) in sides.frames.iter().zip(means.as_chunks_mut::<3>().0) {
            let [tx, ty, angle] = *mean;
            let (sin, versine) = (angle.sin(), 2.0 * (angle / 2.0).sin().powi(2));
            *mean = [0.0; 3];
            let places =
                self.forces[frame.nodes.clone()].iter_mut().zip(&self.displacement[frame.nodes.clone()]);
            for ((force, u), [x, y]) in places.zip(&frame.places) {
                let [fx, fy] = *force;
                // forces in the block's frame, and what they lack against those outside
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
        sides.by_value.combine(&self.values, &mut motion.contact_forces);
        losses
    }
}

/// Mass-weighted mean motion of a block, from its places without load: one value a mode.
pub(super) struct Mean {
    /// Centre of mass, m.
    pub centre: [f64; 2],
    /// Displacement of the centre.
    pub displacement: [DVector<f64>; 2],
    /// `Σ m r × φ / Σ m r²`.
    pub rotation: DVector<f64>,
}

impl Mean {
    pub fn of(
        structure: &Structure<impl ContactLaw>,
        nodes: std::ops::Range<usize>,
        shapes: &DMatrix<f64>,
    ) -> Self {
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
