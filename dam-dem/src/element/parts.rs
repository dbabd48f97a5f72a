//! Division of large meshes into parts for threads.

use std::ops::Range;

use super::batch::Batch;

/// Consecutive batches as parts and seams: no node belongs to two parts, and a seam lies between two parts.
///
/// The parts depend on the mesh only, so that forces are summed in the same order with any number of threads.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    pub parts: Vec<Part>,
    /// Batches that share nodes with both neighbouring parts.
    pub seams: Vec<Range<usize>>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub batches: Range<usize>,
    /// First node of the part; its nodes end where those of the next part begin.
    pub first_node: usize,
}

/// Smallest number of batches for which a thread is faster: about ten thousand triangles.
const LEAST: usize = 312;

impl Parts {
    /// The parts of `batches`, whose node numbers must increase approximately with the batch, as in the rows
    /// of a mesh.
    pub fn of(batches: &[Batch]) -> Self {
        let count = (batches.len() / LEAST).max(1);
        let nodes = |batch: &Batch| batch.cells.iter().flatten().copied().collect::<Vec<_>>();
        let mut ends = vec![0];
        for batch in batches {
            let end = nodes(batch).into_iter().max().map_or(0, |node| node + 1);
            ends.push(end.max(ends[ends.len() - 1]));
        }
        let mut starts = vec![usize::MAX];
        for batch in batches.iter().rev() {
            let start = nodes(batch).into_iter().min().unwrap_or(usize::MAX);
            starts.push(start.min(starts[starts.len() - 1]));
        }
        starts.reverse();
        let mut found = Self { parts: vec![Part { batches: 0..0, first_node: 0 }], seams: Vec::new() };
        for cut in (1..count).map(|i| i * batches.len() / count) {
            let seam_end = (cut..batches.len()).find(|&batch| starts[batch] >= ends[cut]);
            let last = found.parts.len() - 1;
            let part = &mut found.parts[last];
            // there must be a part on each side of the seam
            let Some(end) = seam_end.filter(|_| cut > part.batches.start) else { continue };
            part.batches.end = cut;
            found.seams.push(cut..end);
            found.parts.push(Part { batches: end..end, first_node: ends[cut] });
        }
        if let Some(part) = found.parts.last_mut() {
            part.batches.end = batches.len();
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, Section};

    #[test]
    fn parts_share_no_node_and_every_batch_is_in_one_place() {
        let mesh = Mesh::new(&Section::rectangle(60.0, 100.0), &[30.0, 77.0], &[], 0.5);
        let batches = Batch::of(&mesh);
        let Parts { parts, seams } = Parts::of(&batches);
        assert_eq!((parts.len(), seams.len()), (batches.len() / LEAST, batches.len() / LEAST - 1));
        let mut order = Vec::new();
        for (i, part) in parts.iter().enumerate() {
            let end = parts.get(i + 1).map_or(mesh.nodes.len(), |next| next.first_node);
            for node in batches[part.batches.clone()].iter().flat_map(|batch| batch.cells.iter().flatten()) {
                assert!((part.first_node..end).contains(node));
            }
            order.extend(part.batches.clone());
            order.extend(seams.get(i).cloned().into_iter().flatten());
        }
        assert!(order.into_iter().eq(0..batches.len()));
        assert!(seams.iter().map(|seam| seam.len()).sum::<usize>() < batches.len() / 10);
    }
}
