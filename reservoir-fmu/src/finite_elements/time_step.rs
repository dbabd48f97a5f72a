use super::domain::Domain;
use super::free_field::FreeField;
use super::matrices::solve;
use crate::ReservoirError;
use faer::sparse::linalg::solvers::Llt;
use nalgebra::DMatrix;

/// The part of a step that does not depend on the inputs at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// p̄ of the water, then of the column, without motion at the end.
    means: Vec<f64>,
    /// Pressure at the interface points at the end, in the same way.
    pressure: Vec<f64>,
}

/// Newmark's average acceleration method with steps of one length.
pub struct TimeStep {
    length: f64,
    factors: Llt<usize, f64>,
    column: Option<Llt<usize, f64>>,
    /// p̄ of water and column for a unit value of each input at the end.
    means: DMatrix<f64>,
    /// Pressure at the interface points at the end, in the same way.
    instantaneous: DMatrix<f64>,
}

impl TimeStep {
    /// Factors for steps of `length` (s).
    ///
    /// **Errors**: [`ReservoirError::FiniteElementSystem`].
    pub fn new(
        length: f64,
        density: f64,
        domain: &Domain,
        column: Option<&FreeField>,
    ) -> Result<Self, ReservoirError> {
        let Domain { matrices, load, .. } = domain;
        let (size, points) = (matrices.size(), load.points());
        let columns = column.map_or(0, FreeField::size);
        let mut step = Self {
            length,
            factors: matrices.factor(length)?,
            column: column.map(|column| column.matrices.factor(length)).transpose()?,
            means: DMatrix::zeros(size + columns, points + 2),
            instantaneous: DMatrix::zeros(points, points + 2),
        };
        for input in 0..points + 2 {
            let mut right: Vec<f64> = domain.unit_load(input);
            right.iter_mut().for_each(|l| *l *= -0.25 * length * density);
            let mut foot = vec![0.0; columns];
            if let (Some(column), true) = (column, input == points + 1) {
                foot[column.foot] = 0.25 * length * density;
            }
            let means = step.means(right, foot, column);
            let pressure = load.pressure(&means[..size]);
            step.means.column_mut(input).copy_from_slice(&means);
            step.instantaneous.column_mut(input).iter_mut().zip(pressure).for_each(|(i, p)| *i = 2.0 * p);
        }
        Ok(step)
    }

    /// Length of a step, s.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// ∂p/∂(inputs at the end).
    pub fn instantaneous(&self) -> &DMatrix<f64> {
        &self.instantaneous
    }

    /// p̄ of water and column from the right-hand sides of both.
    fn means(&self, mut right: Vec<f64>, foot: Vec<f64>, column: Option<&FreeField>) -> Vec<f64> {
        let (Some(column), Some(factors)) = (column, &self.column) else {
            return solve(&self.factors, &right);
        };
        let of_column = solve(factors, &foot);
        column.add(0.5 * self.length, &of_column, &mut right);
        let mut means = solve(&self.factors, &right);
        means.extend(of_column);
        means
    }

    /// The step from `state`, without motion at its end.
    pub fn prepare(
        &self,
        state: &[f64],
        density: f64,
        domain: &Domain,
        column: Option<&FreeField>,
    ) -> Prepared {
        let Domain { matrices, load, .. } = domain;
        let (size, columns) = (matrices.size(), column.map_or(0, FreeField::size));
        let (psi, rest) = state.split_at(size);
        let (p, rest) = rest.split_at(size);
        let (column_psi, rest) = rest.split_at(columns);
        let (column_p, inputs) = rest.split_at(columns);

        let (half, of_means) = (0.5 * self.length, -0.25 * self.length * density);
        let mut right = matrices.mass_and_stiffness(p, -half, psi);
        domain.add(of_means, inputs, &mut right);
        let foot = column.map_or_else(Vec::new, |column| {
            let mut foot = column.matrices.mass_and_stiffness(column_p, -half, column_psi);
            foot[column.foot] -= of_means * inputs[load.points() + 1];
            foot
        });
        let means = self.means(right, foot, column);
        let at_end: Vec<f64> = means.iter().zip(p).map(|(mean, start)| 2.0 * mean - start).collect();
        Prepared { pressure: load.pressure(&at_end), means }
    }

    /// Pressure at the interface points at the step's end.
    pub fn pressure(&self, prepared: &Prepared, inputs: &[f64]) -> Vec<f64> {
        plus_product(&prepared.pressure, &self.instantaneous, inputs)
    }

    /// Writes the state at the step's end; `sizes` are the unknowns of water and column.
    pub fn advance(
        &self,
        state: &[f64],
        prepared: &Prepared,
        inputs: &[f64],
        sizes: [usize; 2],
        next: &mut [f64],
    ) {
        let means = plus_product(&prepared.means, &self.means, inputs);
        let mut first = 0;
        let mut first_mean = 0;
        for size in sizes {
            for (i, mean) in means[first_mean..first_mean + size].iter().enumerate() {
                let (psi, p) = (first + i, first + size + i);
                next[psi] = state[psi] + self.length * mean;
                next[p] = 2.0 * mean - state[p];
            }
            first += 2 * size;
            first_mean += size;
        }
        next[first..].copy_from_slice(inputs);
    }
}

/// `a + B x`, column by column.
fn plus_product(a: &[f64], b: &DMatrix<f64>, x: &[f64]) -> Vec<f64> {
    let mut sum = a.to_vec();
    for (column, x) in b.column_iter().zip(x).filter(|(_, x)| **x != 0.0) {
        sum.iter_mut().zip(column.iter()).for_each(|(s, b)| *s += b * x);
    }
    sum
}
