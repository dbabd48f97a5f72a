//! Which element or contact limits the time step.

use nalgebra::{Matrix3, SymmetricEigen};

use crate::contact::{ContactLaw, Stencil};
use crate::structure::Structure;
use crate::time_step::{HighestMode, highest_mode};
use crate::{DamError, Kinematics};

/// Where the mode of the highest frequency lies, which limits the time step ([`CriticalTimeStep`](crate::CriticalTimeStep)).
///
/// Its energy `½ φᵀ K φ` is the sum of those of all elements and contacts. Those of the kind, elements or contacts, that
/// hold more of it limit the time step; the place is that of the one with the most.
///
/// For comparison, an element of its own, free, with a third of its mass in each corner, has the highest frequency
///
/// ```text
/// ω_e² = (3/ρ) λ_max(D B Bᵀ)
/// ```
///
/// with its strain matrix B, the moduli D and the density ρ (of a dam with zones the mean one, which makes ω_e an estimate). No mesh of
/// one material without contacts has a higher frequency than its highest ω_e.
///
/// **Source**: B. Irons, G. Treharne, *A bound theorem in eigenvalues and its practical applications*, 1971; tested in
/// `tests/limiting_part.rs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitingPart {
    /// An element or a contact.
    pub kind: PartKind,
    /// Its unloaded place, m: the centroid of the element, or the contact.
    pub place: [f64; 2],
    /// Share of the mode's energy in all elements, or in all contacts, whichever is more.
    pub share: f64,
    /// Highest frequency of elements and contacts without added mass, rad/s.
    pub highest_frequency: f64,
    /// Median of ω_e, rad/s.
    pub median_frequency: f64,
}

/// What limits the time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartKind {
    /// An element.
    Element {
        /// Index of its block.
        block: usize,
    },
    /// A contact.
    Contact {
        /// Index of its crack, from the base up.
        crack: usize,
    },
}

impl LimitingPart {
    /// How many times as long the time step could be, had all parts the frequency of the median element.
    pub fn slowdown(&self) -> f64 {
        self.highest_frequency / self.median_frequency
    }

    /// What limits the time step of a `structure`.
    ///
    /// **Errors**: [`DamError::FrequenciesNotConverged`].
    pub fn new(structure: &Structure<impl ContactLaw>) -> Result<Self, DamError> {
        Ok(Self::of(structure, &highest_mode(structure)?))
    }

    pub(crate) fn of(structure: &Structure<impl ContactLaw>, mode: &HighestMode) -> Self {
        let (mesh, u) = (&structure.mesh, &mode.shape);
        let mut elements = Largest::default();
        for (index, (nodes, area, gradients)) in structure.cells.triangles().enumerate() {
            let mut h = [[0.0; 2]; 2];
            for (node, gradient) in nodes.into_iter().zip(gradients) {
                (0..2).for_each(|i| (0..2).for_each(|j| h[i][j] += u[node][i] * gradient[j]));
            }
            let [xx, yy, xy] = structure.cells.stress_of(index / 4, h, Kinematics::Small);
            let density = xx * h[0][0] + yy * h[1][1] + xy * (h[0][1] + h[1][0]);
            elements.add(0.5 * area * density, || {
                let mean = |axis: usize| nodes.iter().map(|&node| mesh.nodes[node][axis]).sum::<f64>() / 3.0;
                let block = mesh.blocks.partition_point(|block| block.cells.end <= index / 4);
                (PartKind::Element { block }, [mean(0), mean(1)])
            });
        }
        let mut contacts = Largest::default();
        // one crack of the structure for each seam that has contacts
        for (crack, seam) in structure.cracks.iter().zip(&mesh.seams) {
            for Stencil { nodes, weights, stiffness } in crack.stencils() {
                let mut jump = [0.0; 2];
                for (&node, weight) in nodes.iter().zip(weights) {
                    (0..2).for_each(|d| jump[d] += weight * u[node][d]);
                }
                let force = stiffness.map(|row| row[0] * jump[0] + row[1] * jump[1]);
                contacts.add(0.5 * (force[0] * jump[0] + force[1] * jump[1]), || {
                    // the first two nodes are those of its point, and all weights but theirs those of the other side
                    let own: f64 = weights[0] + weights[1];
                    let place = [0, 1].map(|axis| {
                        (weights[0] * mesh.nodes[nodes[0]][axis] + weights[1] * mesh.nodes[nodes[1]][axis])
                            / own
                    });
                    (PartKind::Contact { crack: seam.crack }, place)
                });
            }
        }
        let all = elements.sum + contacts.sum;
        let most = if contacts.sum > elements.sum { contacts } else { elements };
        let (kind, place) = most.part.unwrap_or((PartKind::Element { block: 0 }, [0.0; 2]));
        Self {
            kind,
            place,
            share: most.sum / all,
            highest_frequency: mode.frequency,
            median_frequency: median_frequency(structure),
        }
    }
}

/// The sum of energies, and the part with the largest.
#[derive(Default)]
struct Largest {
    sum: f64,
    most: f64,
    part: Option<(PartKind, [f64; 2])>,
}

impl Largest {
    fn add(&mut self, energy: f64, part: impl FnOnce() -> (PartKind, [f64; 2])) {
        self.sum += energy;
        if energy > self.most {
            (self.most, self.part) = (energy, Some(part()));
        }
    }
}

/// Median of ω_e, rad/s.
fn median_frequency(structure: &Structure<impl ContactLaw>) -> f64 {
    let cells = &structure.cells;
    let strains = [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]];
    let area: f64 = cells.triangles().map(|(_, area, _)| area).sum();
    let density = structure.mass.iter().sum::<f64>() / area;
    let square = |cell: usize, gradients: [[f64; 2]; 3]| {
        let columns = strains.map(|h| cells.stress_of(cell, h, Kinematics::Small));
        let moduli = Matrix3::from_fn(|i, j| columns[j][i]);
        let factor = moduli.cholesky().map_or(Matrix3::zeros(), |factor| factor.l());
        let mut product = Matrix3::zeros();
        for [x, y] in gradients {
            product += Matrix3::new(x * x, 0.0, x * y, 0.0, y * y, x * y, x * y, x * y, x * x + y * y);
        }
        let largest = SymmetricEigen::new(factor.transpose() * product * factor).eigenvalues.max();
        3.0 / density * largest
    };
    let triangles = cells.triangles().enumerate();
    let mut squares: Vec<f64> =
        triangles.map(|(index, (.., gradients))| square(index / 4, gradients)).collect();
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return f64::NAN;
    }
    squares.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt()
}
