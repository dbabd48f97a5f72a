//! Fields at nodes that are linear in the coordinates of modes.

use nalgebra::{DMatrix, DVector, DVectorViewMut};
use std::ops::Range;

use crate::Mesh;
use crate::reduction::Superposition;

/// A field with `N` values at each of a number of nodes, as one matrix a block: most modes move one block alone.
#[derive(Clone, Debug)]
pub(crate) struct ModalField<const N: usize> {
    blocks: Vec<OfBlock>,
    nodes: usize,
}

/// The field at the nodes of one block.
#[derive(Clone, Debug)]
struct OfBlock {
    /// Its values among those of all nodes.
    rows: Range<usize>,
    /// The modes that give any.
    modes: Vec<usize>,
    /// One column for each of `modes`.
    operator: DMatrix<f64>,
}

impl<const N: usize> ModalField<N> {
    /// The field at `nodes` of `mesh`, block after block, that `of_shape` gives for the displacement of all nodes in a mode.
    pub fn new(
        mesh: &Mesh,
        modes: &Superposition,
        nodes: &[usize],
        of_shape: impl Fn(&[[f64; 2]]) -> Vec<[f64; N]>,
    ) -> Self {
        let column = |mode: usize| {
            let mut coordinates = vec![0.0; modes.mode_count()];
            coordinates[mode] = 1.0;
            let shape: Vec<[f64; 2]> =
                (0..mesh.nodes.len()).map(|node| modes.at_node(node, &coordinates)).collect();
            DVector::from_row_slice(of_shape(&shape).as_flattened())
        };
        let columns: Vec<DVector<f64>> = (0..modes.mode_count()).map(column).collect();
        let mut first = 0;
        let chunks = nodes.chunk_by(|a, b| mesh.block_of(*a) == mesh.block_of(*b));
        let blocks = chunks.map(|chunk| {
            let rows = first..first + N * chunk.len();
            first = rows.end;
            let moves =
                |mode: &usize| columns[*mode].rows_range(rows.clone()).iter().any(|value| *value != 0.0);
            let modes: Vec<usize> = (0..columns.len()).filter(moves).collect();
            let operator =
                DMatrix::from_fn(rows.len(), modes.len(), |i, k| columns[modes[k]][rows.start + i]);
            OfBlock { rows, modes, operator }
        });
        Self { blocks: blocks.collect(), nodes: nodes.len() }
    }

    /// The values for the `coordinates` of the modes.
    pub fn at(&self, coordinates: &[f64]) -> Vec<[f64; N]> {
        let mut values = vec![[0.0; N]; self.nodes];
        let flat = values.as_flattened_mut();
        for OfBlock { rows, modes, operator } in &self.blocks {
            let own = DVector::from_iterator(modes.len(), modes.iter().map(|&mode| coordinates[mode]));
            DVectorViewMut::from_slice(&mut flat[rows.clone()], rows.len()).gemv(1.0, operator, &own, 0.0);
        }
        values
    }
}
