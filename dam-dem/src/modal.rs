//! Matrices of the linear dam, and its natural frequencies.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::{DMatrix, SymmetricEigen};
use std::collections::BTreeMap;

use crate::contact::{ContactLaw, Stencil};
use crate::structure::Structure;
use crate::{AddedMass, DamError};

/// Numbering of the free degrees of freedom: x, then y of each node.
#[derive(Clone, Debug, PartialEq)]
pub struct DegreesOfFreedom {
    /// Number of degrees of freedom.
    pub count: usize,
    of_node: Vec<Option<usize>>,
}

/// Whose degrees of freedom a node has.
enum Twin {
    Fixed,
    /// Those of this node, which is itself or one before it.
    Of(usize),
}

impl DegreesOfFreedom {
    /// Every free node has its own degrees of freedom.
    pub fn free(structure: &Structure<impl ContactLaw>) -> Self {
        Self::number(structure, |node| if structure.is_fixed(node) { Twin::Fixed } else { Twin::Of(node) })
    }

    /// The intact dam: the nodes at one place of a crack share their degrees of freedom.
    pub fn intact(structure: &Structure<impl ContactLaw>) -> Self {
        // of each node the first one that is one with it
        let mut first: Vec<usize> = (0..structure.mesh.nodes.len()).collect();
        let mut pairs: Vec<[usize; 2]> =
            structure.mesh.doubled_nodes().map(|(a, b)| [a.min(b), a.max(b)]).collect();
        pairs.sort_unstable();
        let root = |first: &[usize], mut node: usize| {
            while first[node] != node {
                node = first[node];
            }
            node
        };
        for [a, b] in pairs {
            let [a, b] = [root(&first, a), root(&first, b)];
            first[a.max(b)] = a.min(b);
        }
        let roots: Vec<usize> = (0..first.len()).map(|node| root(&first, node)).collect();
        let mut fixed = vec![false; first.len()];
        for (node, &root) in roots.iter().enumerate() {
            fixed[root] |= structure.is_fixed(node);
        }
        Self::number(structure, |node| if fixed[roots[node]] { Twin::Fixed } else { Twin::Of(roots[node]) })
    }

    /// The degrees of freedom of the free nodes among `nodes` (ascending).
    pub fn of_nodes(structure: &Structure<impl ContactLaw>, nodes: impl IntoIterator<Item = usize>) -> Self {
        let mut of_node = vec![None; structure.mesh.nodes.len()];
        let free = nodes.into_iter().filter(|&node| !structure.is_fixed(node));
        let count = free.zip((0..).step_by(2)).map(|(node, dof)| of_node[node] = Some(dof)).count();
        Self { count: 2 * count, of_node }
    }

    fn number(structure: &Structure<impl ContactLaw>, twin: impl Fn(usize) -> Twin) -> Self {
        let mut count = 0;
        let mut of_node: Vec<Option<usize>> = Vec::with_capacity(structure.mesh.nodes.len());
        for node in 0..structure.mesh.nodes.len() {
            let dof = match twin(node) {
                Twin::Fixed => None,
                Twin::Of(first) if first < node => of_node[first],
                Twin::Of(_) => {
                    count += 2;
                    Some(count - 2)
                }
            };
            of_node.push(dof);
        }
        Self { count, of_node }
    }

    /// First degree of freedom of `node`, or `None` if it is fixed.
    pub fn of(&self, node: usize) -> Option<usize> {
        self.of_node[node]
    }

    /// Free nodes, each with the first of its degrees of freedom.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.of_node.iter().enumerate().filter_map(|(node, dof)| Some((node, (*dof)?)))
    }

    /// Lumped mass of each degree of freedom, kg/m.
    pub fn masses(&self, structure: &Structure<impl ContactLaw>) -> Vec<f64> {
        let mut masses = vec![0.0; self.count];
        for (node, dof) in self.nodes() {
            masses[dof] += structure.mass[node];
            masses[dof + 1] += structure.mass[node];
        }
        masses
    }

    /// Entries (row, column, kg/m) of the water's [`AddedMass`], each once; none without it.
    pub fn added_mass(&self, structure: &Structure<impl ContactLaw>) -> Vec<(usize, usize, f64)> {
        let mut entries = BTreeMap::new();
        for ([a, p], [b, q], value) in structure.added_mass.iter().flat_map(AddedMass::entries) {
            if let (Some(i), Some(j)) = (self.of(a), self.of(b)) {
                *entries.entry((i + p, j + q)).or_insert(0.0) += value;
            }
        }
        entries.into_iter().map(|((i, j), value)| (i, j, value)).collect()
    }
}

/// Entries (row, column, N/m per metre) of the unstrained structure's stiffness matrix, each once.
///
/// It contains elements and closed, sticking contacts; contacts vanish where both sides have the same degrees
/// of freedom.
pub fn stiffness(
    structure: &Structure<impl ContactLaw>,
    dofs: &DegreesOfFreedom,
) -> Vec<(usize, usize, f64)> {
    assemble(structure, dofs, &structure.stencils())
}

/// The same for the elements alone.
pub fn element_stiffness(
    structure: &Structure<impl ContactLaw>,
    dofs: &DegreesOfFreedom,
) -> Vec<(usize, usize, f64)> {
    assemble(structure, dofs, &[])
}

fn assemble(
    structure: &Structure<impl ContactLaw>,
    dofs: &DegreesOfFreedom,
    stencils: &[Stencil],
) -> Vec<(usize, usize, f64)> {
    let mut parts = Vec::new();
    let mut add = |a: usize, b: usize, block: [[f64; 2]; 2], factor: f64| {
        if let (Some(i), Some(j)) = (dofs.of(a), dofs.of(b)) {
            for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                parts.push((i + p, j + q, factor * block[p][q]));
            }
        }
    };
    for (triangle, (nodes, area, gradients)) in structure.cells.triangles().enumerate() {
        for (a, &u) in gradients.iter().zip(&nodes) {
            for (b, &v) in gradients.iter().zip(&nodes) {
                add(u, v, structure.cells.stiffness_block(triangle, *a, *b), area);
            }
        }
    }
    for stencil in stencils {
        for (a, &u) in stencil.weights.iter().zip(&stencil.nodes) {
            for (b, &v) in stencil.weights.iter().zip(&stencil.nodes) {
                add(u, v, stencil.stiffness, a * b);
            }
        }
    }
    parts.sort_by_key(|&(row, column, _)| (column, row));
    let mut entries: Vec<(usize, usize, f64)> = Vec::new();
    for part in parts {
        match entries.last_mut() {
            Some(entry) if (entry.0, entry.1) == (part.0, part.1) => entry.2 += part.2,
            _ => entries.push(part),
        }
    }
    entries
}

/// Cholesky factors of the matrix with these `entries`.
///
/// **Errors**: [`DamError::Singular`].
pub fn factor(entries: &[(usize, usize, f64)], size: usize) -> Result<Llt<usize, f64>, DamError> {
    let triplets: Vec<_> = entries.iter().map(|&(row, col, val)| Triplet { row, col, val }).collect();
    SparseColMat::try_new_from_triplets(size, size, &triplets)
        .map_err(|_| DamError::Singular)?
        .sp_cholesky(Side::Lower)
        .map_err(|_| DamError::Singular)
}

/// Relative change of the eigenvalues at which the subspace iteration has converged.
pub(crate) const TOLERANCE: f64 = 1e-11;
/// Largest number of subspace iterations.
const MAX_ITERATIONS: usize = 200;

/// The `count` lowest natural frequencies of the intact structure without damping and added mass, rad/s,
/// ascending.
///
/// **Errors**: as [`natural_modes`].
pub fn natural_frequencies(
    structure: &Structure<impl ContactLaw>,
    count: usize,
) -> Result<Vec<f64>, DamError> {
    let dofs = DegreesOfFreedom::intact(structure);
    let factors = factor(&stiffness(structure, &dofs), dofs.count)?;
    Ok(natural_modes(&factors, &dofs.masses(structure), count, TOLERANCE)?.0)
}

/// The `count` lowest natural frequencies (rad/s, ascending), and their modes as columns with `φᵀ M φ = 1`,
/// for the stiffness matrix with the Cholesky factors `factors` and the lumped `masses` (kg/m).
///
/// Solves `K φ = ω² M φ` by inverse subspace iteration until the squared frequencies change by less than `tolerance`
/// (relative).
///
/// **Errors**: [`DamError::TooManyFrequencies`], [`DamError::Singular`],
/// [`DamError::FrequenciesNotConverged`].
/// **Source**: K.-J. Bathe, *Finite Element Procedures*, 1996, section 11.6.
pub fn natural_modes(
    factors: &Llt<usize, f64>,
    masses: &[f64],
    count: usize,
    tolerance: f64,
) -> Result<(Vec<f64>, DMatrix<f64>), DamError> {
    natural_modes_in_water(factors, masses, &[], count, tolerance)
}

/// The same with the water's inertia: `K φ = ω² (M + X) φ` and `φᵀ (M + X) φ = 1`, for the entries (row, column, kg/m) of X, which is
/// symmetric.
///
/// **Errors**: as [`natural_modes`], and [`DamError::Singular`] if M + X is not positive definite.
pub fn natural_modes_in_water(
    factors: &Llt<usize, f64>,
    masses: &[f64],
    added_mass: &[(usize, usize, f64)],
    count: usize,
    tolerance: f64,
) -> Result<(Vec<f64>, DMatrix<f64>), DamError> {
    let n = masses.len();
    let momenta_of = |vectors: &DMatrix<f64>| {
        let mut momenta = DMatrix::from_fn(n, vectors.ncols(), |i, j| masses[i] * vectors[(i, j)]);
        for &(row, column, value) in added_mass {
            (0..vectors.ncols()).for_each(|j| momenta[(row, j)] += value * vectors[(column, j)]);
        }
        momenta
    };
    if count > n {
        return Err(DamError::TooManyFrequencies { asked: count, available: n });
    }
    let size = (2 * count).min(count + 8).min(n);
    let mut seed = 1u32;
    let mut vectors = DMatrix::from_fn(n, size, |_, _| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX) - 0.5
    });
    let (mut eigenvalues, mut change) = (vec![0.0; count], f64::INFINITY);
    for _ in 0..MAX_ITERATIONS {
        let momenta = momenta_of(&vectors);
        let moved = solve(factors, &momenta);
        // Not by `tr_mul`, which takes one scalar product after the other.
        let rows = moved.transpose();
        let projected = &rows * momenta;
        let mass = rows * momenta_of(&moved);
        let (values, modes) = generalised_eigen(&projected, &mass)?;
        vectors = moved * modes;
        change = 0.0f64;
        for (value, &new) in eigenvalues.iter_mut().zip(&values) {
            change = change.max((new - *value).abs() / new);
            *value = new;
        }
        if change < tolerance {
            let frequencies = eigenvalues.iter().map(|v| v.sqrt()).collect();
            return Ok((frequencies, vectors.columns(0, count).into_owned()));
        }
    }
    Err(DamError::FrequenciesNotConverged { iterations: MAX_ITERATIONS, change, tolerance })
}

/// `K⁻¹` times the columns of `loads`.
pub fn solve(factors: &Llt<usize, f64>, loads: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, columns) = loads.shape();
    let mut solution = faer::Mat::from_fn(n, columns, |i, j| loads[(i, j)]);
    factors.solve_in_place(solution.as_mut());
    DMatrix::from_fn(n, columns, |i, j| solution[(i, j)])
}

/// Eigenvalues λ, ascending, and eigenvectors v as columns of `K v = λ M v`, `vᵀ M v = 1`, for symmetric matrices.
///
/// **Errors**: [`DamError::Singular`] if M is not positive definite.
pub fn generalised_eigen(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
) -> Result<(Vec<f64>, DMatrix<f64>), DamError> {
    let size = mass.nrows();
    let lower = mass.clone().cholesky().ok_or(DamError::Singular)?.unpack();
    let half = lower.solve_lower_triangular(stiffness).ok_or(DamError::Singular)?;
    let reduced = lower.solve_lower_triangular(&half.transpose()).ok_or(DamError::Singular)?;
    let eigen = SymmetricEigen::new((&reduced + reduced.transpose()) / 2.0);
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let sorted = DMatrix::from_fn(size, size, |i, j| eigen.eigenvectors[(i, order[j])]);
    let vectors = lower.transpose().solve_upper_triangular(&sorted).ok_or(DamError::Singular)?;
    Ok((order.iter().map(|&i| eigen.eigenvalues[i]).collect(), vectors))
}
