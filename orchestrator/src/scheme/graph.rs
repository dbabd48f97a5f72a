//! Who exchanges pressure and motion with whom.

use super::CouplingError;
use crate::participant::{Participant, ParticipantError};
use serde::{Deserialize, Serialize};
use std::ops::{Index, IndexMut};

/// Number of a unit in its graph, and of its place in a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct UnitId(pub usize);

impl UnitId {
    /// The dam of a [pair](Graph::pair), and of every scene.
    pub const DAM: Self = Self(0);
    /// The reservoir of a [pair](Graph::pair), and of every scene.
    pub const RESERVOIR: Self = Self(1);
    /// The tailwater of a scene that has one.
    pub const TAILWATER: Self = Self(2);
}

/// A face of a unit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    /// The unit.
    pub unit: UnitId,
    /// What the names of the face's variables begin with; nothing where the unit has only one face.
    pub prefix: String,
}

impl Port {
    /// The face of `unit` whose variables have plain names.
    pub fn of(unit: UnitId) -> Self {
        Self { unit, prefix: String::new() }
    }

    /// The face's variable `name`.
    pub(super) fn variable(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }
}

/// A wet face, at which two units exchange pressure and motion.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interface {
    /// Face of a unit whose input is pressure and whose output is motion.
    pub structure: Port,
    /// Face of a unit whose input is acceleration and whose output is pressure.
    pub fluid: Port,
}

/// Units, and the interfaces between them. The number of a unit is its place in the list of units.
///
/// A unit is a structure at all of its interfaces, or a fluid at all of them; each has an interface. A structure may have
/// several fluids, and a fluid several structures.
pub struct Graph {
    units: Vec<Box<dyn Participant>>,
    interfaces: Vec<Interface>,
}

impl Graph {
    /// A graph.
    ///
    /// **Errors**: [`CouplingError::Graph`]: an interface of a unit that is not there, a unit with no interface or of both
    /// kinds, or two units of one name.
    pub fn new(units: Vec<Box<dyn Participant>>, interfaces: Vec<Interface>) -> Result<Self, CouplingError> {
        let refused = |cause: String| Err(CouplingError::Graph { cause });
        for Interface { structure, fluid } in &interfaces {
            if let Some(UnitId(id)) = [structure.unit, fluid.unit].into_iter().find(|id| id.0 >= units.len())
            {
                return refused(format!("an interface names unit {id}, of {} units", units.len()));
            }
        }
        let graph = Self { units, interfaces };
        for id in graph.ids() {
            let name = &graph[id].description().name;
            match (graph.is_structure(id), graph.interfaces.iter().any(|i| i.fluid.unit == id)) {
                (true, true) => {
                    return refused(format!("{name} is the structure of an interface and the fluid of one"));
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

    /// A dam and a reservoir.
    pub fn pair(dam: Box<dyn Participant>, reservoir: Box<dyn Participant>) -> Self {
        let interface = Interface { structure: Port::of(UnitId::DAM), fluid: Port::of(UnitId::RESERVOIR) };
        Self { units: vec![dam, reservoir], interfaces: vec![interface] }
    }

    /// The numbers of all units.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = UnitId> + use<> {
        (0..self.units.len()).map(UnitId)
    }

    /// The interfaces.
    pub fn interfaces(&self) -> &[Interface] {
        &self.interfaces
    }

    /// Whether a unit is a structure; otherwise it is a fluid.
    pub fn is_structure(&self, id: UnitId) -> bool {
        self.interfaces.iter().any(|interface| interface.structure.unit == id)
    }

    /// What is known beforehand, then all structures, then all fluids: the order in which a serial scheme asks them.
    pub(super) fn order(&self) -> Vec<UnitId> {
        let mut order: Vec<UnitId> = self.ids().collect();
        order.sort_by_key(|&id| (!self[id].is_open_loop(), !self.is_structure(id)));
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

    /// The same; `None` for a unit that does not offer it.
    ///
    /// **Errors**: a unit fails.
    pub fn states(&mut self) -> Result<Vec<Option<Vec<u8>>>, ParticipantError> {
        self.units.iter_mut().map(|unit| unit.serialise()).collect()
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
