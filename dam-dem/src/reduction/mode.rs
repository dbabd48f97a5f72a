use nalgebra::{DMatrix, DVector};

use super::basis::HIGHEST_EXCITATION;
use crate::contact::ContactLaw;
use crate::structure::Structure;
use crate::{DamError, RayleighCoefficients, modal};

/// Circular frequency to which the frequency of faster modes is reduced, rad/s.
pub(super) const SLOWED_TO: f64 = 5.0 * HIGHEST_EXCITATION;
/// Circular frequency up to which vibrations are those of the dam: half of that to which fast modes are slowed, rad/s.
pub(crate) const HIGHEST_REPRESENTED: f64 = SLOWED_TO / 2.0;
/// Share of the largest ω², or of that to which fast modes are slowed if it is larger, below which a mode counts as a rigid-body mode: of rigid
/// blocks all ω² are rounding errors.
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
        let largest = squares.iter().copied().fold(SLOWED_TO * SLOWED_TO, f64::max);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Coulomb, Integration};
    use crate::{Kinematics, Material, Mesh, Section};

    /// Of a rigid block alone, whose ω² are rounding errors of either sign, and beside a deformation: the drag of the whole mass.
    #[test]
    fn rigid_motions_have_no_stiffness_and_all_mass_damping() -> Result<(), DamError> {
        let mesh = Mesh::mapped(&Section::rectangle(8.0, 20.0), &[vec![0.0, 5.0, 10.0, 15.0, 20.0]], 6);
        let material = Material::default();
        let none: [(Coulomb, Integration); 0] = [];
        let structure = Structure::new(mesh, &material, Kinematics::Small, none, &[]);
        let nodes = &structure.mesh.nodes;
        let column = |of: fn([f64; 2]) -> [f64; 2]| {
            DVector::from_iterator(2 * nodes.len(), nodes.iter().flat_map(|&place| of(place)))
        };
        let rigid = [column(|_| [1.0, 0.0]), column(|_| [0.0, 1.0]), column(|[x, y]| [0.3 - y, x - 7.7])];
        let bent = [&rigid[..], &[column(|[_, y]| [y * y, 0.0])]].concat();
        let rayleigh = RayleighCoefficients { mass: 0.7, stiffness: 1e-3 };
        for shapes in [&rigid[..], &bent] {
            let modes = Mode::all(&structure, &DMatrix::from_columns(shapes))?;
            for mode in &modes[..3] {
                assert!(mode.square == 0.0 && (mode.damping(rayleigh) / 0.7 - 1.0).abs() < 1e-12);
            }
            assert!(modes[3..].iter().all(|mode| mode.square > 1.0), "the deformation has stiffness");
        }
        Ok(())
    }
}
