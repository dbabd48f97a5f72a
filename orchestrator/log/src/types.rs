//! The message types of a log except `foxglove.Log`.

use super::schema::{Kind, MessageType};
use cofferdam_coupling::participant::{Description, Layout};
use cofferdam_coupling::signal::Signal;

fn message_type(name: &str, fields: &[(&str, Kind)]) -> MessageType {
    MessageType::new(name, fields.iter().map(|(n, k)| ((*n).to_owned(), k.clone())).collect())
}

/// `/scene`.
pub fn scene_type() -> MessageType {
    message_type("Scene", &[("toml", Kind::Text)])
}

/// `/build`.
pub fn build_type() -> MessageType {
    message_type("Build", &BUILD.map(|name| (name, Kind::Text)))
}

/// Fields of `/build`, all texts; the first two are those of the first version.
pub const BUILD: [&str; 12] = [
    "version",
    "commit",
    "profile",
    "processor",
    "features",
    "system",
    "started",
    "parent",
    "parent_step",
    "settings",
    "exchanges",
    "window",
];

/// An external signal, with the samples in a field of the name of what they measure.
pub fn signal_type(signal: &Signal) -> MessageType {
    let fields =
        [("interval", Kind::Double), (signal.quantity.as_str(), Kind::Doubles), ("source", Kind::Text)];
    message_type(&camel_case(&signal.name), &fields)
}

/// `/step`.
pub fn step_type(units: &[Description]) -> MessageType {
    let fields = [
        ("step", Kind::Unsigned),
        ("attempt", Kind::Unsigned),
        ("start_time", Kind::Double),
        ("end_time", Kind::Double),
        ("communication_step", Kind::Double),
        ("iterations", Kind::Unsigned),
        ("converged", Kind::Bool),
        ("accepted", Kind::Bool),
        ("outcome", Kind::Text),
        ("residual_pressure", Kind::Double),
        ("pressure_ratio", Kind::Double),
        ("residual_ratio", Kind::Double),
        ("residual_displacement", Kind::Double),
        ("relaxation", Kind::Double),
        ("secants", Kind::Unsigned),
        ("fallbacks", Kind::Unsigned),
        ("interpolation_error", Kind::Double),
        ("largest_pressure", Kind::Double),
        ("rounding_floor", Kind::Double),
        ("interface_work", Kind::Double),
        ("interface_energy_produced", Kind::Double),
        ("work_on_structure", Kind::Doubles),
        ("work_by_fluid", Kind::Doubles),
        ("lowest_pressure", Kind::Doubles),
        ("mapping_error", Kind::Doubles),
    ];
    let of_units = [("calls", Kind::Unsigned), ("restores", Kind::Unsigned), ("time", Kind::Double)];
    let names: Vec<(String, Kind)> = units
        .iter()
        .flat_map(|unit| of_units.clone().map(|(what, kind)| (format!("{}_{what}", unit.name), kind)))
        .collect();
    let of_units = names.iter().map(|(name, kind)| (name.as_str(), kind.clone()));
    message_type("Step", &fields.into_iter().chain(of_units).collect::<Vec<_>>())
}

/// `/iteration`.
pub fn iteration_type() -> MessageType {
    let fields = [
        ("step", Kind::Unsigned),
        ("steps", Kind::Unsigned),
        ("attempt", Kind::Unsigned),
        ("iteration", Kind::Unsigned),
        ("start_time", Kind::Double),
        ("end_time", Kind::Double),
        ("purpose", Kind::Text),
        ("compared", Kind::Bool),
        ("residual_pressure", Kind::Double),
        ("pressure_ratio", Kind::Double),
        ("residual_ratio", Kind::Double),
        ("residual_displacement", Kind::Double),
        ("worst_step", Kind::Unsigned),
        ("worst_interface", Kind::Unsigned),
        ("worst_point", Kind::Unsigned),
        ("worst_given", Kind::Double),
        ("worst_answered", Kind::Double),
        ("acceleration", Kind::Text),
        ("relaxation", Kind::Double),
        ("secants_known", Kind::Unsigned),
        ("secants_independent", Kind::Unsigned),
        ("secants", Kind::Unsigned),
        ("jacobian", Kind::Text),
    ];
    message_type("Iteration", &fields)
}

/// `/checkpoint`.
pub fn checkpoint_type() -> MessageType {
    let fields = [
        ("step", Kind::Unsigned),
        ("end_time", Kind::Double),
        ("run", Kind::ByteStrings),
        ("units", Kind::ByteStrings),
    ];
    message_type("Checkpoint", &fields)
}

/// `/end`.
pub fn end_type() -> MessageType {
    let fields = [
        ("status", Kind::Text),
        ("time", Kind::Double),
        ("wall_time", Kind::Double),
        ("unconverged", Kind::Unsigned),
        ("rejected", Kind::Unsigned),
        ("rounding_floor", Kind::Double),
    ];
    message_type("End", &fields)
}

/// `/damage`.
pub fn damage_type() -> MessageType {
    let fields = [("first_byte", Kind::Unsigned), ("last_byte", Kind::Unsigned), ("what", Kind::Text)];
    message_type("Damage", &fields)
}

/// `/unit`.
pub fn unit_type() -> MessageType {
    let list = || Kind::Messages(variable_type());
    message_type(
        "Unit",
        &[
            ("name", Kind::Text),
            ("solver", Kind::Text),
            ("fingerprint", Kind::Text),
            ("inputs", list()),
            ("outputs", list()),
        ],
    )
}

/// One exchanged variable of a unit.
pub fn variable_type() -> MessageType {
    message_type(
        "Variable",
        &[
            ("name", Kind::Text),
            ("value_reference", Kind::Unsigned),
            ("unit", Kind::Text),
            ("size", Kind::Unsigned),
            ("array", Kind::Bool),
        ],
    )
}

/// Message type of a request or an answer: header, then one field for each variable, for an array also its norm.
pub fn exchange_type(name: &str, layout: &Layout) -> MessageType {
    let header = [
        ("step", Kind::Unsigned),
        ("iteration", Kind::Unsigned),
        ("attempt", Kind::Unsigned),
        ("accepted", Kind::Bool),
        ("start_time", Kind::Double),
        ("end_time", Kind::Double),
        ("communication_step", Kind::Double),
        ("wall_time", Kind::Double),
    ];
    let header = header.map(|(n, k)| (n.to_owned(), k));
    let fields = layout.channels().flat_map(|(channel, _)| {
        let kind = if channel.shape.is_array() { Kind::Doubles } else { Kind::Double };
        let norm = channel.shape.is_array().then(|| (format!("{}_norm", channel.name), Kind::Double));
        std::iter::once((channel.name.clone(), kind)).chain(norm)
    });
    MessageType::new(name, header.into_iter().chain(fields).collect())
}

/// A unit, and a variable of it whose name another field of its request or answer has.
pub fn repeated_name(units: &[Description]) -> Option<(String, String)> {
    units.iter().find_map(|Description { name, inputs, outputs, .. }| {
        let repeated =
            [inputs, outputs].into_iter().find_map(|layout| exchange_type(name, layout).repeated_field());
        Some((name.clone(), repeated?))
    })
}

/// A name in the form of message types.
pub fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A name in snake case as that of a message type.
fn camel_case(name: &str) -> String {
    name.split('_').map(capitalised).collect()
}
