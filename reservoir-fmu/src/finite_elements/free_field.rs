use super::domain::Domain;
use super::element::{EDGE_MASS, EDGE_STIFFNESS};
use super::matrices::Matrices;
use super::mesh::BoundaryEdge;
use crate::ReservoirParameters;
use crate::condition::BoundaryCondition;

/// The column of water at the far end: it moves vertically with the ground and is not affected by the dam.
///
/// ```text
/// p̈/c² = p″,  p = 0 (or −p̈/g = p′) at the level,  p′ = q ṗ − ρ a_y on the bed
/// ```
///
/// on the edges of the far end. Its pressure is the same everywhere upstream, so it does not radiate. Only the difference
/// p − p_column does: `∂(p − p_column)/∂n = −(ṗ − ṗ_column)/c`.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeField {
    /// Mass, damping and stiffness of the column, per metre of width.
    pub matrices: Matrices,
    /// Unknown of the water, unknown of the column, `∫ N_i N_j ds / c` (s).
    transfer: Vec<(usize, usize, f64)>,
    /// The unknown on the bed, where the ground's velocity enters as ρ v_y.
    pub foot: usize,
}

impl FreeField {
    /// The column on the far end's edges.
    pub fn new(parameters: &ReservoirParameters, Domain { mesh, unknowns, .. }: &Domain) -> Self {
        let ReservoirParameters { sound_speed, gravity, surface_waves, .. } = *parameters;
        let edges: Vec<&BoundaryEdge> = mesh.edges(BoundaryCondition::Radiation).collect();
        // From the water level down, each node once.
        let mut own = vec![None; mesh.nodes.len()];
        let mut size = 0;
        let nodes = edges.iter().flat_map(|edge| edge.nodes);
        for node in nodes.filter(|node| unknowns[*node].is_some()) {
            own[node].get_or_insert_with(|| {
                size += 1;
                size - 1
            });
        }
        let foot = size - 1;
        let (mut entries, mut transfer) = (Vec::new(), Vec::new());
        for edge in &edges {
            for (i, a) in edge.nodes.into_iter().enumerate() {
                for (j, b) in edge.nodes.into_iter().enumerate() {
                    let (Some(row), Some(column), Some(unknown)) = (own[a], own[b], unknowns[a]) else {
                        continue;
                    };
                    let mass = edge.length * EDGE_MASS[i][j];
                    let stiffness = EDGE_STIFFNESS[i][j] / edge.length;
                    entries.push((row, column, [mass / (sound_speed * sound_speed), 0.0, stiffness]));
                    transfer.push((unknown, column, mass / sound_speed));
                }
            }
        }
        entries.push((foot, foot, [0.0, parameters.bed_admittance(), 0.0]));
        if surface_waves {
            entries.push((0, 0, [1.0 / gravity, 0.0, 0.0]));
        }
        Self { matrices: Matrices::new(size, entries), transfer, foot }
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.matrices.size()
    }

    /// Adds f times the far end's load from the column's pressure to the load on the water.
    pub fn add(&self, factor: f64, pressure: &[f64], load: &mut [f64]) {
        for &(unknown, column, value) in &self.transfer {
            load[unknown] += factor * value * pressure[column];
        }
    }
}
