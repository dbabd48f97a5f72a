//! The boundary element system: interface velocity in, interface pressure out.
//!
//! Depends on `boundary`, `condition`, `kernel`, `operator` and `radiation`.

use crate::ReservoirError;
use crate::boundary::{BoundaryMesh, shape};
use crate::condition::BoundaryCondition;
use crate::kernel::HelmholtzKernel;
use crate::operator::{LayerOperators, Layers};
use crate::quadrature::gauss_legendre;
use crate::radiation::Radiation;
use faer::{Mat, linalg::solvers::Solve};
use interface::WetFace;
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::PI;

/// The water's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Density, kg/m³.
    pub density: f64,
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Admittance of the bed `q = (1 − α)/((1 + α) c)`, s/m.
    pub bed_admittance: f64,
}

/// Boundary integral equation at the nodes and at the interface points.
///
/// With the layers S, D and the free term γ (½ at nodes, the water's angle over 2π at the
/// interface points)
///
/// ```text
/// γ p + D p + q s S_bed p_bed + S_far T p_far = −ρ s S_face E v
/// ```
///
/// The rows of the nodes give p; those of the interface points, where p is then evaluated
/// by the representation formula, give the pressure to be exchanged. At s = 0, with `−ρ s v` replaced by
/// `−ρ a`, it is that of incompressible water. E is the element-wise
/// L² projection of the piecewise linear interface velocity onto the face's nodes.
pub struct BoundarySystem {
    mesh: BoundaryMesh,
    layers: LayerOperators,
    radiation: Radiation,
    /// E: face nodes × interface points.
    projection: Mat<Complex64>,
    /// γ at the interface points below the water level.
    free_terms: Vec<f64>,
    water: Water,
}

impl BoundarySystem {
    /// Prepares everything that does not depend on the frequency.
    ///
    /// `kernel` must vanish at the water level, the face's highest point.
    ///
    /// **Errors**: [`ReservoirError::FarEnd`].
    pub fn new(
        face: &WetFace,
        mesh: BoundaryMesh,
        kernel: &dyn HelmholtzKernel,
        water: Water,
    ) -> Result<Self, ReservoirError> {
        let mut points = mesh.nodes();
        points.extend(&face.points()[..face.len() - 1]);
        Ok(Self {
            layers: LayerOperators::new(&mesh, kernel, &points),
            radiation: Radiation::new(&mesh, face.depth(), water.sound_speed, water.bed_admittance)?,
            projection: velocity_projection(face, &mesh),
            free_terms: free_terms(face),
            water,
            mesh,
        })
    }

    /// K(s): interface pressure (Pa) for a unit interface velocity (m/s), points × points.
    ///
    /// **Errors**: [`ReservoirError::Kernel`], [`ReservoirError::FarEnd`].
    pub fn symbol(&self, s: Complex64) -> Result<DMatrix<Complex64>, ReservoirError> {
        let Water { density, sound_speed, .. } = self.water;
        let layers = self
            .layers
            .assemble(s / sound_speed)
            .map_err(|source| ReservoirError::Kernel { frequency: s, source })?;
        let response = self.response(layers, s)?;
        Ok(DMatrix::from_fn(self.outputs() + 1, self.outputs() + 1, |i, j| {
            if i == self.outputs() {
                return Complex64::ZERO; // the water level
            }
            -density * s * response[(i, j)] / self.free_terms[i]
        }))
    }

    /// A of incompressible water, `p = −A a`: interface pressure (Pa) for a unit interface acceleration
    /// (m/s²) into the water, points × points. It solves Laplace's equation, the limit s → 0 of `−K(s)/s`.
    ///
    /// **Errors**: [`ReservoirError::FarEnd`].
    pub fn added_mass(&self) -> Result<DMatrix<f64>, ReservoirError> {
        let response = self.response(self.layers.assemble_static(), Complex64::ZERO)?;
        Ok(DMatrix::from_fn(self.outputs() + 1, self.outputs() + 1, |i, j| {
            if i == self.outputs() {
                return 0.0; // the water level
            }
            self.water.density * response[(i, j)].re / self.free_terms[i]
        }))
    }

    /// Number of interface points below the water level.
    fn outputs(&self) -> usize {
        self.free_terms.len()
    }

    /// γ times the pressure at the points below the water level for `∂p/∂n` on the face of 1 at each
    /// interface point and 0 at the others.
    fn response(&self, layers: Layers, s: Complex64) -> Result<Mat<Complex64>, ReservoirError> {
        let bed_admittance = self.water.bed_admittance;
        let Layers { single, double: mut matrix } = layers;
        let nodes = matrix.ncols();

        let far = self.mesh.part(BoundaryCondition::Radiation);
        let bed = self.mesh.part(BoundaryCondition::AbsorbingBed);
        let wet = self.mesh.part(BoundaryCondition::WetFace);
        let columns = |part: &std::ops::Range<usize>| single.as_ref().subcols(part.start, part.len());
        let radiated = columns(&far) * self.radiation.dirichlet_to_neumann(s)?;
        let forcing = columns(&wet) * &self.projection;
        for (offset, column) in far.enumerate() {
            for row in 0..matrix.nrows() {
                matrix[(row, column)] += radiated[(row, offset)];
            }
        }
        for column in bed {
            for row in 0..matrix.nrows() {
                matrix[(row, column)] += bed_admittance * s * single[(row, column)];
            }
        }
        for node in 0..nodes {
            matrix[(node, node)] += 0.5;
        }
        let solution =
            matrix.as_ref().subrows(0, nodes).partial_piv_lu().solve(forcing.as_ref().subrows(0, nodes));
        let evaluated = matrix.as_ref().subrows(nodes, self.outputs()) * solution;
        Ok(forcing.as_ref().subrows(nodes, self.outputs()) - evaluated)
    }
}

/// E: the L² projection of interface velocities, linear along panels, onto each face element.
///
/// The nodes are Gauss points, so the element's mass matrix is half its length times one.
fn velocity_projection(face: &WetFace, mesh: &BoundaryMesh) -> Mat<Complex64> {
    let wet = mesh.part(BoundaryCondition::WetFace);
    let mut projection = Mat::zeros(wet.len(), face.len());
    let rule = gauss_legendre(2);
    let mut element_start = 0.0;
    for (index, element) in mesh.elements()[wet.start / 2..wet.end / 2].iter().enumerate() {
        let length = element.length();
        let mut panel_start = 0.0;
        for panel in face.panels() {
            let start = f64::max(element_start, panel_start);
            let end = f64::min(element_start + length, panel_start + panel.length);
            for q in rule.iter().filter(|_| end > start) {
                let arc = 0.5 * (start + end) + 0.5 * (end - start) * q.position;
                let weight = 0.5 * (end - start) * q.weight * 2.0 / length;
                let along = (arc - panel_start) / panel.length;
                for (node, n) in shape(2.0 * (arc - element_start) / length - 1.0).into_iter().enumerate() {
                    projection[(2 * index + node, panel.start)] +=
                        Complex64::from(weight * n * (1.0 - along));
                    projection[(2 * index + node, panel.start + 1)] += Complex64::from(weight * n * along);
                }
            }
            panel_start += panel.length;
        }
        element_start += length;
    }
    projection
}

/// The water's angle over 2π at every interface point below the water level.
fn free_terms(face: &WetFace) -> Vec<f64> {
    let panels: Vec<_> = face.panels().collect();
    (0..face.len() - 1)
        .map(|point| {
            let above = panels.iter().find(|p| p.start >= point).map_or([1.0, 0.0], |p| p.normal);
            let bed = [0.0, -1.0];
            let below = panels.iter().rev().find(|p| p.start < point).map_or(bed, |p| p.normal);
            let turn =
                (below[0] * above[1] - below[1] * above[0]).atan2(below[0] * above[0] + below[1] * above[1]);
            0.5 * (1.0 - turn / PI)
        })
        .collect()
}
