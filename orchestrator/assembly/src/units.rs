//! The built-in graph: a dam, its reservoir, and where a scene has one the tailwater.

use cofferdam_coupling::participant::Participant;
use cofferdam_coupling::scheme::{CouplingError, Direction, Field, Graph, Interface, Port, UnitId};
use cofferdam_scene::Side;
use cofferdam_unit::Role;

/// The input of all units that receives the acceleration of the ground (x, y), m/s².
pub const GROUND_ACCELERATION: &str = "ground_acceleration";

/// The dam of a [`pair`], and of every scene.
pub const DAM: UnitId = UnitId(0);
/// The reservoir of a [`pair`], and of every scene.
pub const RESERVOIR: UnitId = UnitId(1);
/// The tailwater of a scene that has one.
pub const TAILWATER: UnitId = UnitId(2);

/// The name of a unit, in logs and as argument of `cofferdam unit`.
pub fn unit_name(id: UnitId) -> &'static str {
    match id {
        DAM => "dam",
        TAILWATER => Side::Downstream.table(),
        _ => Side::Upstream.table(),
    }
}

/// What a unit is at its interface.
pub fn unit_role(id: UnitId) -> Role {
    if id == DAM { Role::Structure } else { Role::Fluid }
}

/// The unit of the water on a side.
pub fn water_unit(side: Side) -> UnitId {
    match side {
        Side::Upstream => RESERVOIR,
        Side::Downstream => TAILWATER,
    }
}

/// The side of the water of a unit; `None` for the dam.
pub fn water_side(id: UnitId) -> Option<Side> {
    Side::BOTH.into_iter().find(|&side| water_unit(side) == id)
}

/// The prefix of the names of the dam's variables of the face on a side.
pub fn variable_prefix(side: Side) -> &'static str {
    match side {
        Side::Upstream => "",
        Side::Downstream => "tailwater_",
    }
}

/// The wet face between a structure and a fluid: acceleration goes forward, pressure comes back.
///
/// `inertia` is the weight of acceleration against pressure in the parallel schemes, Pa/(m/s²): the mass of the water column
/// ρh. The hydrostatic pressure is the constant part of the pressure.
pub fn wet_face_interface(structure: Port, fluid: Port, inertia: f64) -> Interface {
    let name = "interface_acceleration";
    let acceleration = Field { weight: inertia, ..Field::new(Direction::Forward, name, name) };
    let name = "interface_pressure";
    let constant_part = Some("hydrostatic_pressure".to_owned());
    let pressure = Field { constant_part, ..Field::new(Direction::Backward, name, name) };
    Interface {
        coordinates: Some(["interface_x", "interface_y"].map(str::to_owned)),
        monitored: Some("interface_displacement".to_owned()),
        included: Some("added_mass_included".to_owned()),
        ..Interface::new(structure, fluid, vec![acceleration, pressure])
    }
}

/// A dam and its reservoir, with acceleration and pressure of weight 1.
///
/// **Errors**: [`CouplingError::Graph`]: both have the same name.
pub fn pair(dam: Box<dyn Participant>, reservoir: Box<dyn Participant>) -> Result<Graph, CouplingError> {
    Graph::new(vec![dam, reservoir], vec![wet_face_interface(Port::of(DAM), Port::of(RESERVOIR), 1.0)])
}
