use nalgebra::{DMatrix, DVector};

use super::basis::HIGHEST_EXCITATION;
use crate::contact::ContactLaw;
use crate::structure::Structure;
use crate::{DamError, RayleighCoefficients, modal};

/// Circular frequency to which the frequency of faster modes is reduced, rad/s.
pub(super) const SLOWED_TO: f64 = 5.0 * HIGHEST_EXCITATION;
/// Circular frequency up to which vibrations are those of the dam: half of that to which fast modes are slowed, rad/s.
pub(crate) const HIGHEST_REPRESENTED: f64 = SLOWED_TO / 2.0;
/// Share of the largest ω² below which a mode counts as a rigid-body mode.
const RIGID: f64 = 1e-10;

/// A mode with unit modal mass; the frequency of fast modes is reduced to [`SLOWED_TO`].
pub(super) struct Mode {
    /// ω², (rad/s)².
    pub square: f64,
    /// x, then y of each node.
    pub shape: DVector<f64>,
    /// `φᵀ M φ` with the mass of the concrete.
    concrete: f64,
}

impl Mode {
    /// All modes in the span of `shapes`, slow ones first.
    ///
    /// **Errors**: [`DamError::Singular`].
    pub fn all(structure: &Structure<impl ContactLaw>, shapes: &DMatrix<f64>) -> Result<Vec<Self>, DamError> {
        let mut forces = DMatrix::zeros(shapes.nrows(), shapes.ncols());
        for (shape, mut force) in shapes.column_iter().zip(forces.column_iter_mut()) {
            force.copy_from(&structure.stiffness_times(&shape.into()));
        }
        let stiffness = shapes.transpose() * forces;
        let concrete = concrete_mass(structure, shapes);
        let mut mass = concrete.clone();
        if let Some(water) = &structure.added_mass {
            for ([a, p], [b, q], value) in water.entries() {
                let [row, column] = [2 * a + p, 2 * b + q].map(|dof| shapes.row(dof).transpose());
                mass.ger(value, &row, &column, 1.0);
            }
        }
        let (squares, vectors) = modal::generalised_eigen(&stiffness, &mass)?;
        let largest = squares.iter().copied().fold(0.0, f64::max);
        let all = shapes * &vectors;
        let mode = |(column, square): (usize, f64)| {
            let vector = vectors.column(column);
            let concrete = vector.dot(&(&concrete * vector));
            let square = if square > RIGID * largest { square } else { 0.0 };
            let slower = (SLOWED_TO / square.sqrt()).min(1.0);
            Self {
                square: square * slower * slower,
                shape: all.column(column) * slower,
                concrete: concrete * slower * slower,
            }
        };
        Ok(squares.into_iter().enumerate().map(mode).collect())
    }

    /// `2ξω` for `C = αM + βK`, at most critical, 1/s.
    pub fn damping(&self, rayleigh: RayleighCoefficients) -> f64 {
        let damping = rayleigh.mass * self.concrete + rayleigh.stiffness * self.square;
        if self.square == 0.0 { damping } else { damping.min(2.0 * self.square.sqrt()) }
    }
}

/// `Φᵀ M Φ` with the mass of the concrete.
pub(super) fn concrete_mass(structure: &Structure<impl ContactLaw>, shapes: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, columns) = shapes.shape();
    shapes.transpose() * DMatrix::from_fn(rows, columns, |i, j| structure.mass[i / 2] * shapes[(i, j)])
}
