//! Projections between interface points and the face's nodes: velocity to the nodes, pressure back.
//!
//! Depends on `boundary` and `condition`.

use crate::ReservoirError;
use crate::boundary::{BoundaryMesh, Element};
use crate::condition::BoundaryCondition;
use crate::quadrature::gauss_legendre;
use cofferdam_unit::WetFace;
use faer::{Mat, MatRef};
use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;

/// `∫ N_i N_j ds` (m) of the hat functions of the interface points, points × points.
pub(crate) fn consistent_mass(face: &WetFace) -> DMatrix<f64> {
    let mut mass = DMatrix::zeros(face.len(), face.len());
    for panel in face.panels() {
        for (i, j, share) in [(0, 0, 3.0), (0, 1, 6.0), (1, 0, 6.0), (1, 1, 3.0)] {
            mass[(panel.start + i, panel.start + j)] += panel.length / share;
        }
    }
    mass
}

/// The result of [`felt`].
type Felt = (Option<DMatrix<f64>>, DMatrix<f64>);

/// Smallest fraction of a velocity's square norm that must remain on the elements for it to count as represented.
const LEAST_FELT: f64 = 1e-2;

/// Work-conjugate projections: for every velocity v at the points and pressure P at the face's nodes,
/// `vᵀ M p = ∫ (E v) P ds` with `p = Q P`.
pub(crate) struct InterfaceProjection {
    /// E, the L² projection of velocities linear along panels onto every element: face nodes × points.
    pub to_nodes: Mat<Complex64>,
    /// Q, the L² projection of the elements' pressures onto the hat functions: points × (face nodes, then samples).
    pub to_points: Mat<Complex64>,
    /// Points (m) of the uppermost element at which Q takes the pressure from the representation formula instead of
    /// the nodes: otherwise the error of a linear element for p ~ r ln r would be the largest on the face.
    pub samples: Vec<[f64; 2]>,
    /// M and M⁻¹: points × points.
    mass: [Mat<Complex64>; 2],
}

impl InterfaceProjection {
    /// The projections between the points of `face` and the nodes of `mesh` on it.
    ///
    /// The nodes are Gauss points, so the elements' mass M_e is diagonal: an element's length, divided equally.
    ///
    /// **Errors**: [`ReservoirError::InterfaceMass`].
    pub fn new(face: &WetFace, mesh: &BoundaryMesh) -> Result<Self, ReservoirError> {
        let order = mesh.order();
        let nodes_per_element = order.nodes().len();
        let elements = &mesh.elements()[mesh.elements_of(BoundaryCondition::WetFace)];
        // ∫ N_node N_point ds
        let mut overlap = DMatrix::<f64>::zeros(nodes_per_element * elements.len(), face.len());
        let (mut node_mass, mut kept) = (Vec::new(), Vec::new());
        let rule = gauss_legendre(2);
        let mut element_start = 0.0;
        let (mut samples, mut of_samples) = (Vec::new(), Vec::new());
        let face_length: f64 = elements.iter().map(Element::length).sum();
        for (index, element) in elements.iter().enumerate() {
            let length = element.length();
            let sampled = index + 1 == elements.len();
            let mut panel_start = 0.0;
            for panel in face.panels() {
                let start = f64::max(element_start, panel_start);
                let end = f64::min(element_start + length, panel_start + panel.length);
                let hats = |arc: f64| {
                    let along = (arc - panel_start) / panel.length;
                    [(panel.start, 1.0 - along), (panel.start + 1, along)]
                };
                for q in rule.iter().filter(|_| end > start) {
                    let arc = 0.5 * (start + end) + 0.5 * (end - start) * q.position;
                    let weight = 0.5 * (end - start) * q.weight;
                    let shape = order.shape(2.0 * (arc - element_start) / length - 1.0);
                    for (local, shape) in shape[..nodes_per_element].iter().enumerate() {
                        for (point, hat) in hats(arc) {
                            overlap[(nodes_per_element * index + local, point)] += weight * shape * hat;
                        }
                    }
                }
                // Points graded towards the surface by r = ℓu², as p ~ r ln r there.
                let at_surface = panel_start + panel.length > face_length * (1.0 - 1e-9);
                let several = gauss_legendre(if at_surface { 6 } else { 3 });
                for q in several.iter().filter(|_| sampled && end - start > 1e-9 * length) {
                    let u = 0.5 * (1.0 + q.position);
                    let (below, weight) =
                        if at_surface { (u * u, u * q.weight) } else { (u, 0.5 * q.weight) };
                    let arc = end - below * (end - start);
                    of_samples.push(hats(arc).map(|(point, hat)| (point, weight * (end - start) * hat)));
                    samples.push(element.at(2.0 * (arc - element_start) / length - 1.0));
                }
                panel_start += panel.length;
            }
            element_start += length;
            node_mass.extend((0..nodes_per_element).map(|_| length / nodes_per_element as f64));
            kept.extend((0..nodes_per_element).map(|_| !sampled));
        }
        let mass = consistent_mass(face);
        let [nodes, points] = [overlap.nrows(), overlap.ncols()];
        let mut loads = DMatrix::<f64>::zeros(points, nodes + samples.len());
        for node in (0..nodes).filter(|&node| kept[node]) {
            loads.set_column(node, &overlap.row(node).transpose());
        }
        for (index, sample) in of_samples.iter().enumerate() {
            for &(point, load) in sample {
                loads[(point, nodes + index)] += load;
            }
        }
        let complex = |matrix: &DMatrix<f64>| {
            Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| Complex64::from(matrix[(i, j)]))
        };
        let (felt, inverse) = felt(&overlap, &node_mass, &mass)?;
        let to_points = &inverse * loads;
        Ok(Self {
            to_nodes: Mat::from_fn(nodes, points, |i, j| (overlap[(i, j)] / node_mass[i]).into()),
            to_points: complex(&felt.map_or_else(|| to_points.clone(), |felt| felt * &to_points)),
            samples,
            mass: [complex(&mass), complex(&inverse)],
        })
    }

    /// `½ (K + M⁻¹ Kᵀ M)`: the part of an operator from velocity to pressure that obeys reciprocity.
    pub fn reciprocal_part(&self, operator: MatRef<'_, Complex64>) -> Mat<Complex64> {
        let [mass, inverse] = &self.mass;
        let reversed = inverse * (operator.transpose() * mass);
        Mat::from_fn(operator.nrows(), operator.ncols(), |i, j| 0.5 * (operator[(i, j)] + reversed[(i, j)]))
    }
}

/// The M-orthogonal projection of pressures onto those that do work on velocities that the elements represent, none if
/// the elements represent all velocities; and M⁻¹.
///
/// Where panels are finer than elements, some velocities cause no pressure; a pressure that does work on them would
/// produce energy.
fn felt(overlap: &DMatrix<f64>, node_mass: &[f64], mass: &DMatrix<f64>) -> Result<Felt, ReservoirError> {
    let factors = mass.clone().cholesky().ok_or(ReservoirError::InterfaceMass)?;
    let upper = factors.l().transpose();
    let inverse = upper.clone().try_inverse().ok_or(ReservoirError::InterfaceMass)?;
    let scaled =
        DMatrix::from_fn(overlap.nrows(), overlap.ncols(), |i, j| overlap[(i, j)] / node_mass[i].sqrt());
    let seen = scaled * &inverse;
    let eigen = SymmetricEigen::new(seen.transpose() * &seen);
    let kept: Vec<usize> = (0..mass.nrows()).filter(|&k| eigen.eigenvalues[k] > LEAST_FELT).collect();
    if kept.len() == mass.nrows() {
        return Ok((None, factors.inverse()));
    }
    let basis = eigen.eigenvectors.select_columns(&kept);
    Ok((Some(inverse * &basis * basis.transpose() * upper), factors.inverse()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that cannot be told apart are an error.
    #[test]
    fn a_singular_mass_is_an_error() {
        let overlap = DMatrix::from_element(2, 2, 0.5);
        let found = felt(&overlap, &[1.0, 1.0], &DMatrix::from_element(2, 2, 1.0));
        assert!(matches!(found, Err(ReservoirError::InterfaceMass)));
    }
}
