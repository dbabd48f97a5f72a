//! The rigid body above a straight crack.

use crate::Mesh;
use crate::contact::ContactLaw;
use crate::structure::Structure;

/// All blocks that the ground carries across one straight crack alone.
#[derive(Clone, Debug)]
pub(crate) struct Above {
    /// Its nodes.
    nodes: Vec<usize>,
    /// Upstream and downstream end of the crack, m.
    pub ends: [[f64; 2]; 2],
    /// Directions along the crack (downstream) and normal to it (upwards).
    pub tangent: [f64; 2],
    normal: [f64; 2],
    /// Length of the crack without galleries in between, m.
    pub length: f64,
}

/// Resultants of forces on the body, N/m and N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Resultants {
    /// Normal to the crack, positive in compression.
    pub normal: f64,
    /// Along the crack, positive downstream.
    pub shear: f64,
    /// Moments that hold the body and that turn it, about the upstream and about the downstream end of the crack.
    pub moments: [[f64; 2]; 2],
}

/// Distance from the straight line between its ends, as a share of its length, from which a crack has a kink.
const STRAIGHT: f64 = 1e-6;

impl Above {
    /// The body above a `crack`; `None` if the crack has a kink, or if the body rests on other cracks too, as where cracks cross.
    pub fn of(structure: &Structure<impl ContactLaw>, crack: usize) -> Option<Self> {
        let mesh = &structure.mesh;
        let seams = || mesh.seams.iter().filter(move |seam| seam.crack == crack);
        let chain: Vec<usize> = seams().flat_map(|seam| seam.upper.iter().copied()).collect();
        let blocks = beyond(structure, crack);
        let (&first, &last) = (chain.first()?, chain.last()?);
        let tangent = mesh.direction(&[first, last]);
        let normal = [-tangent[1], tangent[0]];
        // a gallery in between is no part of it
        let length: f64 =
            seams().map(|seam| mesh.length(&[seam.upper[0], seam.upper[seam.upper.len() - 1]])).sum();
        let off = |&node: &usize| dot(from(mesh, first, node), normal).abs() > STRAIGHT * length;
        // all of the upper side must be of the body that would move
        let carries = seams().all(|seam| blocks.contains(&seam.above));
        if !carries || chain.iter().any(off) {
            return None;
        }
        let nodes = blocks.iter().flat_map(|&block| mesh.blocks[block].nodes.clone()).collect();
        let ends = [first, last].map(|node| mesh.nodes[node]);
        Some(Self { nodes, ends, tangent, normal, length })
    }

    /// Resultants of nodal `forces` (N/m) on the body.
    pub fn resultants(&self, mesh: &Mesh, forces: &[[f64; 2]]) -> Resultants {
        let mut sum = Resultants::default();
        for &node in &self.nodes {
            let [across, along] = [self.normal, self.tangent].map(|axis| dot(forces[node], axis));
            sum.normal -= across;
            sum.shear += along;
            for (end, [holds, turns]) in sum.moments.iter_mut().enumerate() {
                let inwards = if end == 0 { 1.0 } else { -1.0 };
                let place = [0, 1].map(|d| mesh.nodes[node][d] - self.ends[end][d]);
                for moment in
                    [inwards * -across * dot(place, self.tangent), inwards * along * dot(place, self.normal)]
                {
                    *(if moment > 0.0 { &mut *holds } else { &mut *turns }) += moment.abs();
                }
            }
        }
        sum
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn from(mesh: &Mesh, end: usize, node: usize) -> [f64; 2] {
    [0, 1].map(|d| mesh.nodes[node][d] - mesh.nodes[end][d])
}

/// The blocks that nothing carries without this `crack`.
fn beyond(structure: &Structure<impl ContactLaw>, crack: usize) -> Vec<usize> {
    let mesh = &structure.mesh;
    let mut carried: Vec<bool> = mesh.blocks.iter().map(|block| structure.is_held(block)).collect();
    carried.push(true);
    loop {
        let next = mesh.seams.iter().find_map(|seam| match (seam.below, seam.above) {
            _ if seam.crack == crack => None,
            (below, above) if carried[below] && !carried[above] => Some(above),
            (below, above) if carried[above] && !carried[below] => Some(below),
            _ => None,
        });
        match next {
            Some(block) => carried[block] = true,
            None => return (0..mesh.blocks.len()).filter(|&block| !carried[block]).collect(),
        }
    }
}
