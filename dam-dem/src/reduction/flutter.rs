use faer::Mat;
use nalgebra::{Complex, DMatrix, DVector};

use super::superposition::Superposition;
use crate::DamError;
use crate::contact::{Crack, Parting};

/// Unit of rates in the eigenvalue problem, 1/s: that of the frequencies of interest, so that its matrix is balanced.
const UNIT: f64 = 100.0;
/// Largest number of sets of closed contacts that are tried.
const MAX_SETS: usize = 50;

/// Steady sliding along one seam of a modal model; the contacts of the other seams are closed and stick.
pub(crate) struct Sliding<'a> {
    model: &'a Superposition,
    crack: usize,
    /// The contacts of the crack that are closed.
    closed: Vec<bool>,
    /// Stiffness of all contacts.
    contacts: DMatrix<f64>,
}

impl<'a> Sliding<'a> {
    /// The state in which the blocks above `crack` slide in `direction` (1 for downstream, −1 for upstream) under constant
    /// modal `loads`, without vibration: with their rigid motion r along the crack and its acceleration a,
    ///
    /// ```text
    /// K q + a r = F,   K = ω² + Σ w B (k_n n nᵀ ∓ μ k_n t nᵀ) Bᵀ,   K r = 0
    /// ```
    ///
    /// over the contacts that are closed in it, which are found by trial. None if there is no such state: blocks tip over.
    pub fn steady(model: &'a Superposition, crack: usize, direction: f64, loads: &[f64]) -> Option<Self> {
        let count = model.mode_count();
        let cracks = model.sides.cracks.iter().enumerate();
        let sticking = cracks.filter(|(index, _)| *index != crack).flat_map(|(_, crack)| crack.stencils());
        let sticking = model.sides.of_contacts(count, sticking);
        let side = &model.sides.cracks[crack];
        let friction = side.law().residual.friction;
        let mut closed = vec![true; side.closed(&vec![[0.0; 2]; model.sides.rest.len()]).len()];
        for _ in 0..MAX_SETS {
            let sliding = side.sliding_stencils(direction, friction, &closed);
            let contacts = &sticking + model.sides.of_contacts(count, sliding);
            let displacement = equilibrium(model, &contacts, loads)?;
            let moved = model.sides.velocity(&displacement);
            let next = side.closed(&moved);
            if next == closed {
                // A block on one contact can turn: the equations have no solution but by rounding errors.
                let most = moved.as_flattened().iter().fold(0.0f64, |most, u| most.max(u.abs()));
                // half the length of the crack, or all of it on the ground
                let absurd = side.weights()[1].iter().sum::<f64>();
                return (most < absurd).then_some(Self { model, crack, closed, contacts });
            }
            closed = next;
        }
        None
    }

    /// Eigenvalues λ (1/s) of small motion beside the steady sliding: `(λ² + λ C + K) q = 0`.
    ///
    /// K is not symmetric, because friction follows the normal stress. C is the damping of the modes less what sliding
    /// releases, and β times the contacts' part of K.
    ///
    /// **Errors**: [`DamError::Singular`] if they are not found.
    pub fn eigenvalues(&self) -> Result<Vec<Complex<f64>>, DamError> {
        let count = self.model.mode_count();
        let damping = self.damping() + &self.contacts * self.model.dashpots.coefficient;
        let stiffness = with_modes(self.model, &self.contacts);
        let state = Mat::from_fn(2 * count, 2 * count, |i, j| match (i < count, j < count) {
            (true, true) => 0.0,
            (true, false) => f64::from(u8::from(i + count == j)) * UNIT,
            (false, true) => -stiffness[(i - count, j)] / UNIT,
            (false, false) => -damping[(i - count, j - count)],
        });
        let eigenvalues = state.eigenvalues().map_err(|_| DamError::Singular)?;
        Ok(eigenvalues.into_iter().map(|value| Complex::new(value.re, value.im)).collect())
    }

    /// Damping of the modes and between them, less what the sliding releases, 1/s.
    fn damping(&self) -> DMatrix<f64> {
        let model = self.model;
        let count = model.mode_count();
        let mut matrix = DMatrix::from_diagonal(&DVector::from_column_slice(&model.damping));
        let mut between = vec![0.0; count];
        for (mode, mut column) in matrix.column_iter_mut().enumerate() {
            let mut rates = vec![0.0; count];
            rates[mode] = 1.0;
            model.damping_between.combine(&rates, &mut between);
            column.iter_mut().zip(&between).for_each(|(entry, value)| *entry += value);
            if model.release.is_none() {
                continue;
            }
            let velocity = model.sides.velocity(&rates);
            let parting = |(index, side): (usize, &Crack<_>)| {
                if index == self.crack { side.sliding(&velocity, &self.closed) } else { Parting::default() }
            };
            let mut release = model.release.start(0.0);
            release.partings = model.sides.cracks.iter().enumerate().map(parting).collect();
            release.find_rates(model.release.carried());
            let mut forces = vec![[0.0; 2]; model.sides.rest.len()];
            model.release.add_dual(&mut release, &rates, &mut forces);
            let mut released = model.sides.forces(&forces);
            model.release.add_rigid(&release.rates, &mut released);
            column.iter_mut().zip(&released).for_each(|(entry, value)| *entry -= value);
        }
        matrix
    }
}

/// Stiffness of the modes and of the `contacts`.
fn with_modes(model: &Superposition, contacts: &DMatrix<f64>) -> DMatrix<f64> {
    contacts + DMatrix::from_diagonal(&DVector::from_column_slice(&model.stiffness))
}

/// The coordinates q of `K q + a r = F`, `K r = 0`; none if blocks can move in another way, too.
fn equilibrium(model: &Superposition, contacts: &DMatrix<f64>, loads: &[f64]) -> Option<Vec<f64>> {
    let force = DVector::from_column_slice(loads);
    let count = force.len();
    let mut bordered = with_modes(model, contacts).resize(count + 1, count + 1, 0.0);
    // no vector that pushes the blocks is orthogonal to r, nor to the left null vector
    let border = model.inertia(0).normalize();
    bordered.view_mut((0, count), (count, 1)).copy_from(&border);
    bordered.view_mut((count, 0), (1, count)).copy_from(&border.transpose());
    let mut right = DVector::zeros(count + 1);
    right[count] = 1.0;
    let rigid = bordered.clone().lu().solve(&right)?.rows(0, count).into_owned();
    bordered.view_mut((0, count), (count, 1)).copy_from(&rigid);
    right.rows_mut(0, count).copy_from(&force);
    right[count] = 0.0;
    let found = bordered.lu().solve(&right)?;
    found.iter().all(|value| value.is_finite()).then(|| found.rows(0, count).iter().copied().collect())
}
