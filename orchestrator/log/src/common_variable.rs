//! The variables that the units of two logs have in common.

use super::shapes::known_output;
use super::{Head, LoggedExchange};
use cofferdam_coupling::difference::Half;
use cofferdam_coupling::participant::Layout;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_unit::{Shape, Variability};
use std::ops::Range;

/// A variable that two logs have in common, by its name and that of its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonVariable {
    /// Its name, such as `dam.crest_displacement`.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// Whether it is an array.
    pub array: bool,
    /// What it is to a comparison.
    pub kind: Kind,
    half: Half,
    places: [(UnitId, Range<usize>); 2],
}

/// What a variable is to a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A quantity that changes gradually.
    Gradual,
    /// A number of contacts in a state.
    Contacts,
    /// Another output that jumps, such as the place of the largest stress.
    Jump,
}

impl Kind {
    /// The kind of an answer's variable `name`; one that the contract does not know is gradual.
    fn of_output(name: &str) -> Self {
        match known_output(name) {
            Some(v) if v.variability == Variability::Discrete && v.shape == Shape::Cracks => Self::Contacts,
            Some(v) if v.variability == Variability::Discrete => Self::Jump,
            _ => Self::Gradual,
        }
    }
}

impl CommonVariable {
    /// The values in the exchange of its unit: in log 0 or 1.
    pub fn values<'a>(&self, log: usize, exchanges: &'a [LoggedExchange]) -> &'a [f64] {
        let (unit, range) = &self.places[log];
        let exchange = &exchanges[unit.0];
        let values = match self.half {
            Half::Request => Some(&exchange.inputs),
            Half::Answer => exchange.outputs.as_ref(),
        };
        values.and_then(|values| values.get(range.clone())).unwrap_or_default()
    }
}

/// The variables that both logs have, and in words what only one has or what is of another size. Of requests those that are
/// no answer of another unit: what was asked besides follows from what was answered.
pub fn common_variables(heads: [&Head; 2]) -> (Vec<CommonVariable>, Vec<String>) {
    let (mut common, mut apart) = (Vec::new(), Vec::new());
    let [first, second] = heads;
    for (number, unit) in first.units.iter().enumerate() {
        let Some(other) = second.units.iter().position(|other| other.name == unit.name) else {
            apart.push(format!("unit {}: only in a", unit.name));
            continue;
        };
        let (ids, other) = ([UnitId(number), UnitId(other)], &second.units[other]);
        let halves =
            [(Half::Answer, &unit.outputs, &other.outputs), (Half::Request, &unit.inputs, &other.inputs)];
        for (half, layout, other) in halves {
            let skipped = |name: &str| half == Half::Request && is_answered(heads, name);
            match_layouts(&unit.name, half, ids, [layout, other], &skipped, &mut common, &mut apart);
        }
    }
    let lonely = second.units.iter().filter(|unit| first.units.iter().all(|other| other.name != unit.name));
    apart.extend(lonely.map(|unit| format!("unit {}: only in b", unit.name)));
    (common, apart)
}

/// Whether a unit of either log answers a variable of this name.
fn is_answered(heads: [&Head; 2], name: &str) -> bool {
    heads.iter().flat_map(|head| &head.units).any(|unit| unit.outputs.range(name).is_some())
}

fn match_layouts(
    name: &str,
    half: Half,
    ids: [UnitId; 2],
    layouts: [&Layout; 2],
    skipped: &dyn Fn(&str) -> bool,
    common: &mut Vec<CommonVariable>,
    apart: &mut Vec<String>,
) {
    for (channel, range) in layouts[0].channels().filter(|(channel, _)| !skipped(&channel.name)) {
        let full = format!("{name}.{}", channel.name);
        let other = layouts[1].channels().find(|(other, _)| other.name == channel.name);
        match other {
            None => apart.push(format!("{full}: only in a")),
            Some((other, _)) if other.size != channel.size => {
                apart.push(format!("{full}: {} values in a, {} in b", channel.size, other.size));
            }
            Some((other, _)) if other.unit != channel.unit => {
                apart.push(format!("{full}: in {} in a, in {} in b", channel.unit, other.unit));
            }
            Some((_, other)) => common.push(CommonVariable {
                name: full,
                unit: channel.unit.clone(),
                array: channel.shape.is_array(),
                kind: if half == Half::Answer { Kind::of_output(&channel.name) } else { Kind::Gradual },
                half,
                places: [(ids[0], range), (ids[1], other)],
            }),
        }
    }
    let lonely = layouts[1]
        .channels()
        .filter(|(channel, _)| layouts[0].range(&channel.name).is_none() && !skipped(&channel.name));
    apart.extend(lonely.map(|(channel, _)| format!("{name}.{}: only in b", channel.name)));
}
