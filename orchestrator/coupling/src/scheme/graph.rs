//! Units and the interfaces between them, as data.

use super::CouplingError;
use crate::participant::{Participant, ParticipantError};
use serde::{Deserialize, Serialize};
use std::ops::{Index, IndexMut};

/// Number of a unit in its graph, and of its place in a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct UnitId(pub usize);

/// One end of an interface.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    /// The unit.
    pub unit: UnitId,
    /// Prefix of the names of the port's variables; empty if the unit has a single port.
    pub prefix: String,
}

impl Port {
    /// The port of `unit` whose variables have plain names.
    pub fn of(unit: UnitId) -> Self {
        Self { unit, prefix: String::new() }
    }

    /// The port's variable `name`.
    pub fn variable(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }
}

/// Which way a field passes an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// From the first unit to the second, by the consistent mapping.
    Forward,
    /// From the second unit to the first, by its adjoint, the conservative mapping.
    Backward,
}

/// A field that one unit of an interface gives the other in every step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// Output of the giving unit.
    pub output: String,
    /// Input of the receiving unit.
    pub input: String,
    /// Which way it goes.
    pub direction: Direction,
    /// Whether the acceleration corrects it. A field that is not relaxed is passed on as it was answered last.
    pub relaxed: bool,
    /// Factor on the field among the unknowns of a parallel scheme, which brings fields of different units to one scale.
    pub weight: f64,
    /// A variable of both units with the part of the field that is constant in a run: the second unit tells it after
    /// initialisation, the first receives it with every request. Only for fields that go backward.
    pub constant_part: Option<String>,
}

impl Field {
    /// The relaxed field `output` → `input`, of weight 1 and without a constant part.
    pub fn new(direction: Direction, output: &str, input: &str) -> Self {
        let (output, input) = (output.to_owned(), input.to_owned());
        Self { output, input, direction, relaxed: true, weight: 1.0, constant_part: None }
    }
}

/// A connection of two units at which they exchange fields.
///
/// Without `coordinates` a field's output and input have the same number of values, which differs from field to field. With
/// coordinates all fields of a unit have one value for each of its points, and are mapped if the points of the two units differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// The unit that steps first in a serial scheme.
    pub first: Port,
    /// The unit that answers it.
    pub second: Port,
    /// What they exchange; at least one field each way.
    pub fields: Vec<Field>,
    /// Variables of both units with the coordinates (x, y) of their points, m, by which fields are mapped; without them the
    /// values are exchanged in their order.
    pub coordinates: Option<[String; 2]>,
    /// Output of the first unit whose change between iterations is a measure of convergence.
    pub monitored: Option<String>,
    /// Variable of the first unit that is not zero if it includes the response of the second already. A one-way scheme
    /// demands this, and the others refuse it.
    pub included: Option<String>,
}

impl Interface {
    /// The interface between `first` and `second` with these `fields`, exchanged value by value.
    pub fn new(first: Port, second: Port, fields: Vec<Field>) -> Self {
        Self { first, second, fields, coordinates: None, monitored: None, included: None }
    }
}

/// Units, and the interfaces between them. The number of a unit is its place in the list of units.
///
/// A unit is the first at all of its interfaces, or the second at all of them; each has an interface. A first unit may have
/// several seconds, and a second several firsts.
pub struct Graph {
    units: Vec<Box<dyn Participant>>,
    interfaces: Vec<Interface>,
}

impl Graph {
    /// A graph.
    ///
    /// **Errors**: [`CouplingError::Graph`]: an interface of a unit that is not there or without a field in each direction, a
    /// unit with no interface or on both sides, or two units of one name.
    pub fn new(units: Vec<Box<dyn Participant>>, interfaces: Vec<Interface>) -> Result<Self, CouplingError> {
        let refused = |cause: String| Err(CouplingError::Graph { cause });
        for Interface { first, second, fields, .. } in &interfaces {
            if let Some(UnitId(id)) = [first.unit, second.unit].into_iter().find(|id| id.0 >= units.len()) {
                return refused(format!("an interface names unit {id}, of {} units", units.len()));
            }
            for direction in [Direction::Forward, Direction::Backward] {
                if fields.iter().all(|field| field.direction != direction) {
                    let way = if direction == Direction::Forward { "forward" } else { "backward" };
                    return refused(format!(
                        "an interface has no field that goes {way}; give it one each way"
                    ));
                }
            }
            let constant =
                |field: &&Field| field.direction == Direction::Forward && field.constant_part.is_some();
            if let Some(field) = fields.iter().find(constant) {
                return refused(format!(
                    "the field `{}` goes forward and has a constant part; only a backward field may have one",
                    field.output
                ));
            }
        }
        let graph = Self { units, interfaces };
        for id in graph.ids() {
            let name = &graph[id].description().name;
            match (graph.is_first(id), graph.interfaces.iter().any(|i| i.second.unit == id)) {
                (true, true) => {
                    return refused(format!(
                        "{name} is the first unit of an interface and the second of another"
                    ));
                }
                (false, false) => return refused(format!("{name} has no interface")),
                _ => {}
            }
            if graph.ids().any(|other| other < id && graph[other].description().name == *name) {
                return refused(format!("two units are called {name}"));
            }
        }
        Ok(graph)
    }

    /// The numbers of all units.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = UnitId> + use<> {
        (0..self.units.len()).map(UnitId)
    }

    /// The interfaces.
    pub fn interfaces(&self) -> &[Interface] {
        &self.interfaces
    }

    /// Whether a unit is the first at its interfaces; otherwise it is the second.
    pub fn is_first(&self, id: UnitId) -> bool {
        self.interfaces.iter().any(|interface| interface.first.unit == id)
    }

    /// The order in which a serial scheme calls the units: those whose outputs are known in advance, then all first units, then
    /// all second ones.
    pub(super) fn order(&self) -> Vec<UnitId> {
        let mut order: Vec<UnitId> = self.ids().collect();
        order.sort_by_key(|&id| (!self[id].is_open_loop(), !self.is_first(id)));
        order
    }

    /// The states of all units at the end of the last step, as bytes, which [`deserialise`](Self::deserialise) reads.
    ///
    /// **Errors**: a unit does not offer it, or fails.
    pub fn serialise(&mut self) -> Result<Vec<Vec<u8>>, ParticipantError> {
        let bytes = |unit: &mut Box<dyn Participant>| {
            unit.serialise()?.ok_or_else(|| ParticipantError::NotSerialised {
                participant: unit.description().name.clone(),
            })
        };
        self.units.iter_mut().map(bytes).collect()
    }

    /// The same of the units that are `wanted`; `None` for others, and for a unit that does not offer it.
    ///
    /// **Errors**: a unit fails.
    pub fn states(&mut self, wanted: &[bool]) -> Result<Vec<Option<Vec<u8>>>, ParticipantError> {
        let state = |(unit, wanted): (&mut Box<dyn Participant>, &bool)| {
            if *wanted { unit.serialise() } else { Ok(None) }
        };
        self.units.iter_mut().zip(wanted).map(state).collect()
    }

    /// Puts the units, new or not, into states that equal ones have given: one for each unit, in their order.
    ///
    /// **Errors**: states of another number of units or of others; a unit does not offer it, or fails.
    pub fn deserialise(&mut self, states: &[Vec<u8>]) -> Result<(), CouplingError> {
        if states.len() != self.units.len() {
            let cause = format!(
                "there are {} saved states, but {} units; take those of one run",
                states.len(),
                self.units.len()
            );
            return Err(CouplingError::Graph { cause });
        }
        self.units.iter_mut().zip(states).try_for_each(|(unit, state)| Ok(unit.deserialise(state)?))
    }

    /// All units.
    pub fn units(&self) -> impl Iterator<Item = &dyn Participant> {
        self.units.iter().map(|unit| &**unit)
    }

    /// All units.
    pub(super) fn units_mut(&mut self) -> impl Iterator<Item = &mut Box<dyn Participant>> {
        self.units.iter_mut()
    }
}

impl Index<UnitId> for Graph {
    type Output = dyn Participant;

    fn index(&self, id: UnitId) -> &Self::Output {
        &*self.units[id.0]
    }
}

impl IndexMut<UnitId> for Graph {
    fn index_mut(&mut self, id: UnitId) -> &mut Self::Output {
        &mut *self.units[id.0]
    }
}
