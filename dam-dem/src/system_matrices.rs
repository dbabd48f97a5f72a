use crate::RayleighCoefficients;
use crate::modal::{self, DegreesOfFreedom};
use crate::model::Model;

/// Matrices of the intact, linear dam on its free degrees of freedom (dofs):
/// `(M + X) ü + (αM + βK) u̇ + K u = B p − (M ι + X ι) a_g`, `u` relative to the ground.
///
/// The two nodes of a crack share their dofs. SI units, per metre of dam.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemMatrices {
    /// Diagonal of M (concrete only), kg/m, one value for each dof.
    pub mass: Vec<f64>,
    /// X of the [`AddedMass`](crate::AddedMass) as (row, column, kg/m), every entry once; empty without added mass.
    pub added_mass: Vec<(usize, usize, f64)>,
    /// X ι for ground motion along x and along y, kg/m; fixed nodes contribute because they also move water.
    pub added_ground_inertia: [Vec<f64>; 2],
    /// K as (row, column, N/m per metre), every entry once, with both the upper and the lower triangle.
    pub stiffness: Vec<(usize, usize, f64)>,
    /// α and β.
    pub damping: RayleighCoefficients,
    /// B as (dof, interface point, m): nodal forces of a pressure that is linear along each panel.
    pub pressure_forces: Vec<(usize, usize, f64)>,
    /// Nᵀ as (interface point, dof, 1): motion of the interface points along n.
    pub interface_motion: Vec<(usize, usize, f64)>,
    /// dofs of the upstream crest corner: x, y.
    pub crest: [usize; 2],
    /// ι for ground motion along x and along y.
    pub ground_influence: [Vec<f64>; 2],
}

impl SystemMatrices {
    /// The matrices of a `model` whose upstream crest corner is the node `crest`.
    pub(crate) fn of(model: &Model, crest: usize) -> Self {
        let structure = &model.body().structure;
        let dofs = DegreesOfFreedom::intact(structure);
        let mut matrices = Self {
            mass: dofs.masses(structure),
            added_mass: dofs.added_mass(structure),
            added_ground_inertia: [0, 1].map(|_| vec![0.0; dofs.count]),
            stiffness: modal::stiffness(structure, &dofs),
            damping: model.damping().rayleigh,
            pressure_forces: Vec::new(),
            interface_motion: Vec::new(),
            crest: dofs.of(crest).map_or([0, 0], |dof| [dof, dof + 1]),
            ground_influence: [0, 1].map(|d| (0..dofs.count).map(|i| f64::from(i % 2 == d)).collect()),
        };
        if let Some(water) = &structure.added_mass {
            for (axis, inertia) in matrices.added_ground_inertia.iter_mut().enumerate() {
                for (node, values) in water.ground_inertia(axis) {
                    if let Some(dof) = dofs.of(node) {
                        (0..2).for_each(|d| inertia[dof + d] += values[d]);
                    }
                }
            }
        }
        let Some(wet) = &model.body().wet else { return matrices };
        for &(node, point, weight) in wet.load.entries() {
            if let Some(dof) = dofs.of(node) {
                matrices.pressure_forces.extend([0, 1].map(|d| (dof + d, point, weight[d])));
            }
        }
        for (point, (&node, normal)) in wet.nodes.iter().zip(&wet.normals).enumerate() {
            if let Some(dof) = dofs.of(node) {
                matrices.interface_motion.extend([0, 1].map(|d| (point, dof + d, normal[d])));
            }
        }
        matrices
    }
}
