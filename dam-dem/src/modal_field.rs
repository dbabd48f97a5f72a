//! Fields at nodes that are linear in the coordinates of modes.

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};
use std::ops::Range;

use crate::Mesh;
use crate::reduction::Superposition;

/// Number of instants at which [`ModalField::at_instants`] gives a field: few, so that no step takes much longer than others.
/// Those who wait for a step prepare for one like the last.
pub(crate) const INSTANTS: usize = 8;
/// One value for each instant.
pub(crate) type Instants = [f64; INSTANTS];

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
    /// Of each [`TILE`] rows, one tile for each of `modes`; 0 beyond the last row.
    tiles: Vec<[f64; TILE]>,
}

/// Rows of a tile: the numbers of a cache line, and sums that registers hold.
const TILE: usize = 8;

impl<const N: usize> ModalField<N> {
    /// The field at `nodes` of `mesh`, block after block, that `of_shape` gives for the displacement of all nodes in a mode.
    pub fn new(
        mesh: &Mesh,
        modes: &Superposition,
        nodes: &[usize],
        of_shape: impl Fn(&[[f64; 2]]) -> Vec<[f64; N]>,
    ) -> Self {
        let columns: Vec<Vec<[f64; N]>> =
            (0..modes.mode_count()).map(|mode| of_shape(&modes.shape(mode))).collect();
        let mut first = 0;
        let chunks = nodes.chunk_by(|a, b| mesh.block_of(*a) == mesh.block_of(*b));
        let blocks = chunks.map(|chunk| {
            let rows = first..first + N * chunk.len();
            first = rows.end;
            let column = |mode: usize| &columns[mode].as_flattened()[rows.clone()];
            let modes: Vec<usize> =
                (0..columns.len()).filter(|&mode| column(mode).iter().any(|value| *value != 0.0)).collect();
            let value = |mode: usize, row: usize| column(mode).get(row).copied().unwrap_or(0.0);
            let tile = |first: usize, mode: usize| std::array::from_fn(|row| value(mode, first + row));
            let firsts = (0..rows.len()).step_by(TILE);
            let tiles = firsts.flat_map(|first| modes.iter().map(move |&mode| tile(first, mode))).collect();
            OfBlock { rows, modes, tiles }
        });
        Self { blocks: blocks.collect(), nodes: nodes.len() }
    }

    /// The values for the `coordinates` of the modes.
    pub fn at(&self, coordinates: &[f64]) -> Vec<[f64; N]> {
        let mut values = vec![[0.0; N]; self.nodes];
        let flat = values.as_flattened_mut();
        for OfBlock { rows, modes, tiles } in &self.blocks {
            let own: Vec<f64> = modes.iter().map(|&mode| coordinates[mode]).collect();
            Arch::new().dispatch(AtOneInstant { tiles, coordinates: &own, values: &mut flat[rows.clone()] });
        }
        values
    }

    /// The same at a number of instants at once, with the same bits: each tile is read once for all of them.
    pub fn at_instants(&self, coordinates: &[Instants]) -> Vec<[Instants; N]> {
        let mut values = vec![[[0.0; INSTANTS]; N]; self.nodes];
        let flat = values.as_flattened_mut();
        for OfBlock { rows, modes, tiles } in &self.blocks {
            let own: Vec<Instants> = modes.iter().map(|&mode| coordinates[mode]).collect();
            Arch::new().dispatch(Product { tiles, coordinates: &own, values: &mut flat[rows.clone()] });
        }
        values
    }
}

/// The product of the `tiles` of a block with the `coordinates` of its modes at one instant.
struct AtOneInstant<'a> {
    tiles: &'a [[f64; TILE]],
    coordinates: &'a [f64],
    values: &'a mut [f64],
}

impl NullaryFnOnce for AtOneInstant<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let tiles = self.tiles.chunks_exact(self.coordinates.len().max(1));
        for (values, tiles) in self.values.chunks_mut(TILE).zip(tiles) {
            let mut sums = [0.0; TILE];
            for (tile, q) in tiles.iter().zip(self.coordinates) {
                for row in 0..TILE {
                    sums[row] += tile[row] * q;
                }
            }
            values.copy_from_slice(&sums[..values.len()]);
        }
    }
}

/// The same at a number of instants.
struct Product<'a> {
    tiles: &'a [[f64; TILE]],
    coordinates: &'a [Instants],
    values: &'a mut [Instants],
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let tiles = self.tiles.chunks_exact(self.coordinates.len().max(1));
        for (values, tiles) in self.values.chunks_mut(TILE).zip(tiles) {
            for register in 0..INSTANTS / S::F64_LANES {
                let mut sums = [simd.splat_f64s(0.0); TILE];
                for (tile, coordinates) in tiles.iter().zip(self.coordinates) {
                    let coordinates = S::as_simd_f64s(coordinates).0[register];
                    for (sum, value) in sums.iter_mut().zip(tile) {
                        *sum = simd.add_f64s(*sum, simd.mul_f64s(simd.splat_f64s(*value), coordinates));
                    }
                }
                for (values, sum) in values.iter_mut().zip(sums) {
                    S::as_mut_simd_f64s(values).0[register] = sum;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block of eleven rows, which no tile divides, that two of four modes move, and one that none does: the same bits for each
    /// instant as alone, whatever the registers.
    #[test]
    fn many_instants_have_the_bits_of_each() {
        let number = |i: usize, j: usize| ((1 + i * 7 + j * 13) as f64).sin();
        let tiles = (0..4)
            .map(|tile| std::array::from_fn(|row| if tile < 2 || row < 3 { number(tile, row) } else { 0.0 }));
        let field = ModalField::<1> {
            blocks: vec![
                OfBlock { rows: 0..11, modes: vec![1, 3], tiles: tiles.collect() },
                OfBlock { rows: 11..13, modes: Vec::new(), tiles: Vec::new() },
            ],
            nodes: 13,
        };
        let coordinates: Vec<Instants> =
            (0..4).map(|mode| std::array::from_fn(|i| number(mode + 5, i))).collect();
        let all = field.at_instants(&coordinates);
        let OfBlock { tiles, modes, .. } = &field.blocks[0];
        let own: Vec<Instants> = modes.iter().map(|&mode| coordinates[mode]).collect();
        let mut narrow = [[0.0; INSTANTS]; 11];
        Product { tiles, coordinates: &own, values: &mut narrow }.with_simd(pulp::Scalar::new());
        for i in 0..INSTANTS {
            let one: Vec<f64> = coordinates.iter().map(|values| values[i]).collect();
            let alone = field.at(&one);
            assert_eq!(alone, all.iter().map(|[values]| [values[i]]).collect::<Vec<_>>());
            assert_eq!(alone[..11], narrow.map(|values| [values[i]]));
            assert_eq!(alone[2][0], tiles[0][2] * one[1] + tiles[1][2] * one[3]);
            assert_eq!([alone[10][0], alone[12][0]], [tiles[2][2] * one[1] + tiles[3][2] * one[3], 0.0]);
        }
    }
}
