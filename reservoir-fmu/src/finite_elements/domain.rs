use super::FarEnd;
use super::assembly::{assemble, first_decay};
use super::element::{EDGE_MASS, EDGE_MEAN};
use super::interface_load::InterfaceLoad;
use super::matrices::Matrices;
use super::mesh::TriangleMesh;
use crate::condition::BoundaryCondition;
use crate::{ReservoirError, ReservoirParameters};

/// The near field in finite elements, whatever steps it in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Domain {
    /// Its triangles.
    pub mesh: TriangleMesh,
    /// The unknown of every node; none at a surface with p = 0.
    pub unknowns: Vec<Option<usize>>,
    /// M, C and K.
    pub matrices: Matrices,
    /// Loads of the wet face.
    pub load: InterfaceLoad,
    /// `∫ N n ds` on the bed, x and y; of still water less the load of the column at the far end.
    pub ground: [Vec<f64>; 2],
}

impl Domain {
    /// Triangulates and assembles.
    ///
    /// **Errors**: those of [`TriangleMesh::new`].
    pub fn new(parameters: &ReservoirParameters, far_end: FarEnd) -> Result<Self, ReservoirError> {
        let mesh = TriangleMesh::new(parameters)?;
        let mut unknowns = vec![Some(0); mesh.nodes.len()];
        if !parameters.surface_waves {
            mesh.edges(BoundaryCondition::SurfaceWaves)
                .flat_map(|e| e.nodes)
                .for_each(|node| unknowns[node] = None);
        }
        let mut count = 0;
        for unknown in unknowns.iter_mut().flatten() {
            *unknown = count;
            count += 1;
        }
        let matrices = assemble(parameters, &mesh, &unknowns, count, far_end);
        let load =
            InterfaceLoad::new(&parameters.wet_face, mesh.edges(BoundaryCondition::WetFace), &unknowns);
        let mut ground = [vec![0.0; count], vec![0.0; count]];
        for edge in mesh.edges(BoundaryCondition::AbsorbingBed) {
            for (node, mean) in edge.nodes.into_iter().zip(EDGE_MEAN) {
                for (load, n) in ground.iter_mut().zip(edge.normal) {
                    unknowns[node].iter().for_each(|&unknown| load[unknown] += mean * edge.length * n);
                }
            }
        }
        if far_end == FarEnd::Decay {
            // The column's pressure is ρ a_y (h − y).
            let (decay, level) = (first_decay(parameters), parameters.wet_face.depth());
            for edge in mesh.edges(BoundaryCondition::Radiation) {
                for (row, integrals) in edge.nodes.into_iter().zip(EDGE_MASS) {
                    let nodes = edge.nodes.iter().zip(integrals);
                    let integral: f64 = nodes.map(|(node, i)| i * (level - mesh.nodes[*node][1])).sum();
                    unknowns[row].iter().for_each(|&row| ground[1][row] -= decay * edge.length * integral);
                }
            }
        }
        Ok(Self { mesh, unknowns, matrices, load, ground })
    }

    /// L or L_g for a unit value of one input: the interface points, then the ground along x and y.
    pub fn unit_load(&self, input: usize) -> Vec<f64> {
        let mut unit = vec![0.0; self.load.points() + 2];
        unit[input] = 1.0;
        let mut result = vec![0.0; self.matrices.size()];
        self.add(1.0, &unit, &mut result);
        result
    }

    /// Adds `f (L v + L_g v_g)` to the load on the unknowns; velocities of the interface points, then of the ground.
    pub fn add(&self, factor: f64, velocity: &[f64], load: &mut [f64]) {
        let (face, of_ground) = velocity.split_at(self.load.points());
        self.load.add(factor, face, load);
        for (unit, velocity) in self.ground.iter().zip(of_ground).filter(|(_, velocity)| **velocity != 0.0) {
            load.iter_mut().zip(unit).for_each(|(l, unit)| *l += factor * velocity * unit);
        }
    }

    /// Values at all nodes from those at the unknowns.
    pub fn at_nodes(&self, values: &[f64]) -> Vec<f64> {
        self.unknowns.iter().map(|unknown| unknown.map_or(0.0, |unknown| values[unknown])).collect()
    }
}
