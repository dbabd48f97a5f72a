//! Where the parts of a crack lie along it.

use crate::Mesh;

/// The parts of a crack, downstream, or upwards where it is vertical. Galleries in between count as part of the crack.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CrackPath {
    /// Each seam of the crack with the distance at which it begins, m.
    pub parts: Vec<(usize, f64)>,
    /// The first and the last node.
    pub ends: [usize; 2],
    /// Length of the crack, m.
    pub length: f64,
}

impl CrackPath {
    /// `None` of a crack that does not cut the mesh.
    pub fn of(mesh: &Mesh, crack: usize) -> Option<Self> {
        let mut parts: Vec<usize> =
            (0..mesh.seams.len()).filter(|&seam| mesh.seams[seam].crack == crack).collect();
        let first = |part: usize| mesh.seams[part].upper[0];
        let last = |part: usize| mesh.seams[part].upper[mesh.seams[part].upper.len() - 1];
        parts.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|part| mesh.nodes[first(part)]);
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
        });
        let start = *parts.first()?;
        let mut path = Self { parts: Vec::new(), ends: [first(start), last(start)], length: 0.0 };
        for (i, &part) in parts.iter().enumerate() {
            if i > 0 {
                path.length += mesh.length(&[path.ends[1], first(part)]);
            }
            path.parts.push((part, path.length));
            path.length += mesh.length(&mesh.seams[part].upper);
            path.ends[1] = last(part);
        }
        Some(path)
    }
}
