use super::FarEnd;
use super::element::{EDGE_MASS, MASS, stiffness};
use super::matrices::Matrices;
use super::mesh::TriangleMesh;
use crate::ReservoirParameters;
use crate::condition::BoundaryCondition;
use std::f64::consts::PI;

/// λ₁ = π/2d of the channel (1/m), with which the first mode of still water decays upstream.
pub fn first_decay(parameters: &ReservoirParameters) -> f64 {
    PI / (2.0 * parameters.channel_depth())
}

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
        let values = match edge.condition {
            BoundaryCondition::SurfaceWaves if parameters.surface_waves => [1.0 / gravity, 0.0, 0.0],
            BoundaryCondition::Radiation => match far_end {
                FarEnd::Sommerfeld => [0.0, 1.0 / sound_speed, 0.0],
                FarEnd::Decay => [0.0, 0.0, first_decay(parameters)],
                FarEnd::Rigid => continue,
            },
            BoundaryCondition::AbsorbingBed => [0.0, parameters.bed_admittance(), 0.0],
            _ => continue,
        };
        for (i, a) in edge.nodes.into_iter().enumerate() {
            for (j, b) in edge.nodes.into_iter().enumerate() {
                if let (Some(row), Some(column)) = (unknowns[a], unknowns[b]) {
                    entries.push((row, column, values.map(|value| value * edge.length * EDGE_MASS[i][j])));
                }
            }
        }
    }
    Matrices::new(count, entries)
}
