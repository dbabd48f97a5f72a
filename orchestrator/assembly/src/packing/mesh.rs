//! The meshes of the units as CSV files, for the reader; the FMU does not use them.

use cofferdam_dam::{DamError, DamParameters};
use cofferdam_reservoir::{BoundaryCondition, BoundaryMesh, Outline, ReservoirError, ReservoirParameters};

/// Name and text of a file.
pub type File = (&'static str, String);

/// A file of `header` and `rows`.
fn file<const N: usize>(
    name: &'static str,
    header: [&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> File {
    let lines = std::iter::once(header.map(str::to_owned)).chain(rows);
    (name, lines.map(|row| row.join(",") + "\n").collect())
}

/// Nodes and triangles of the dam. The triangles of a cell are (corner k, corner k + 1, centre).
///
/// **Errors**: a section that cannot be meshed.
pub fn dam(parameters: &DamParameters) -> Result<Vec<File>, DamError> {
    let mesh = parameters.mesh()?;
    let nodes = mesh.nodes.iter().map(|point| point.map(|x| x.to_string()));
    let triangles = mesh.blocks.iter().enumerate().flat_map(|(block, part)| {
        mesh.cells[part.cells.clone()].iter().flat_map(move |cell| {
            (0..4).map(move |k| [cell[k], cell[(k + 1) % 4], cell[4], block].map(|index| index.to_string()))
        })
    });
    Ok(vec![
        file("nodes.csv", ["x", "y"], nodes),
        file("triangles.csv", ["node_1", "node_2", "node_3", "block"], triangles),
    ])
}

/// The boundary elements of the reservoir, of a tailwater in the mirror; Westergaard's added mass has none.
///
/// **Errors**: an outline that cannot be meshed.
pub fn reservoir(parameters: &ReservoirParameters) -> Result<Vec<File>, ReservoirError> {
    if !parameters.fidelity.is_solved() {
        return Ok(Vec::new());
    }
    let mesh = BoundaryMesh::new(&Outline::new(parameters)?, parameters);
    let rows = mesh.elements().iter().map(|element| {
        let part = match element.condition {
            BoundaryCondition::Radiation => "far_end",
            BoundaryCondition::AbsorbingBed => "bed",
            BoundaryCondition::WetFace => "wet_face",
            BoundaryCondition::SurfaceWaves => "surface",
        };
        let ([x1, y1], [x2, y2]) = (element.start, element.end);
        [x1.to_string(), y1.to_string(), x2.to_string(), y2.to_string(), part.to_owned()]
    });
    Ok(vec![file("boundary.csv", ["x1", "y1", "x2", "y2", "part"], rows)])
}
