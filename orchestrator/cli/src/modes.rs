//! The mode shapes of a scene's dam, for ParaView.

use cofferdam_assembly::vtk::{Field, Grid};
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_scene::Scene;

/// How many.
pub const COUNT: usize = 4;

/// The text of a `.vtu` file with the lowest modes of the intact dam, empty and, if this program computes its water, full: point
/// data `mode_1_empty` and so on, (kg/m)^(−½); cell data `zone` of a dam with zones; field data, whose names end in the unit. Empty
/// for a dam that this program does not compute.
///
/// **Errors**: those of dam and water.
pub fn vtu(scene: &Scene) -> Result<String, AssemblyError> {
    let mut grid = Grid::default();
    if let Some(mesh) = Assembly::of(scene).dam_mesh()? {
        grid.cells = mesh.triangles().map(|triangle| triangle.to_vec()).collect();
        if !mesh.zones.is_empty() {
            let zone = |cell: usize| mesh.zone_of(cell).map_or(0.0, |zone| (zone + 1) as f64);
            let zones = (0..4 * mesh.cells.len()).map(|triangle| zone(triangle / 4)).collect();
            grid.cell_data.push(Field::scalar("zone", zones));
        }
        grid.points = mesh.nodes;
    }
    grid.field_data.push(("unit of the modes [(kg/m)^(-1/2)]".to_owned(), vec![1.0]));
    let found = [
        ("empty", Assembly::of(scene).natural_modes(COUNT)?),
        ("full", Assembly::of(scene).natural_modes_in_water(COUNT)?),
    ];
    for (water, modes) in found.into_iter().filter_map(|(water, modes)| Some((water, modes?))) {
        for (index, shape) in modes.shapes.into_iter().enumerate() {
            let name = format!("mode_{}_{water}", index + 1);
            grid.point_data.push(Field::vector(&name, shape.into_iter()));
        }
        grid.field_data.push((format!("natural_frequency_{water} [rad/s]"), modes.frequencies));
    }
    Ok(grid.vtu())
}
