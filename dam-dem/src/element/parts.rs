//! Large meshes in parts that threads can take.

use std::ops::Range;

use super::batch::Batch;

/// Batches in a row: of a part no other part touches a node, and seams lie between parts.
///
/// The parts follow from the mesh alone, so that forces are summed in the same order on any number of threads.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    pub parts: Vec<Part>,
    /// Batches that touch the nodes of both parts beside them.
    pub seams: Vec<Range<usize>>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub batches: Range<usize>,
    /// Its nodes are from here on, up to where the next part's begin.
    pub first_node: usize,
}

/// Batches that are worth a thread: some ten thousand triangles.
const LEAST: usize = 312;

impl Parts {
    /// Those of batches whose nodes are numbered nearly as they come, as rows of a mesh are.
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
            // a part must have batches of its own on either side of the seam
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
    use super::super::lanes::LANES;
    use super::*;
    use crate::{Mesh, Section};

    #[test]
    fn parts_share_no_node_and_every_batch_is_in_one_place() {
        let mesh = Mesh::new(&Section::rectangle(60.0, 100.0), &[30.0, 77.0], &[], 0.5);
        let batches: Vec<Batch> = mesh.cells.chunks(LANES).map(|cells| Batch::new(&mesh, cells)).collect();
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
