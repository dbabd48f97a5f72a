use super::FarEnd;
use super::element::{EDGE_MASS, MASS, stiffness};
use super::matrices::Matrices;
use super::mesh::TriangleMesh;
use crate::ReservoirParameters;
use crate::condition::BoundaryCondition;

/// M, C and K of the water.
pub fn assemble(
    parameters: &ReservoirParameters,
    mesh: &TriangleMesh,
    unknowns: &[Option<usize>],
    count: usize,
    far_end: FarEnd,
) -> Matrices {
    let ReservoirParameters { sound_speed, gravity, .. } = *parameters;
    let mut entries = Vec::with_capacity(36 * mesh.triangles.len());
    for triangle in &mesh.triangles {
        let (area, stiffness) = stiffness([0, 1, 2].map(|i| mesh.nodes[triangle[i]]));
        for (i, a) in triangle.iter().enumerate() {
            for (j, b) in triangle.iter().enumerate() {
                if let (Some(row), Some(column)) = (unknowns[*a], unknowns[*b]) {
                    let mass = area * MASS[i][j] / (sound_speed * sound_speed);
                    entries.push((row, column, [mass, 0.0, stiffness[i][j]]));
                }
            }
        }
    }
    for edge in &mesh.boundary {
        let [mass, damping] = match edge.condition {
            BoundaryCondition::SurfaceWaves if parameters.surface_waves => [1.0 / gravity, 0.0],
            BoundaryCondition::Radiation if far_end == FarEnd::Sommerfeld => [0.0, 1.0 / sound_speed],
            BoundaryCondition::AbsorbingBed => [0.0, parameters.bed_admittance()],
            _ => continue,
        };
        for (i, a) in edge.nodes.into_iter().enumerate() {
            for (j, b) in edge.nodes.into_iter().enumerate() {
                if let (Some(row), Some(column)) = (unknowns[a], unknowns[b]) {
                    let integral = edge.length * EDGE_MASS[i][j];
                    entries.push((row, column, [mass * integral, damping * integral, 0.0]));
                }
            }
        }
    }
    Matrices::new(count, entries)
}
