//! A quantity over time, chosen by its name as in `histories.csv`.

use super::{AcceptedStep, Head, LoggedStep};
use cofferdam_coupling::difference::Half;
use cofferdam_coupling::scheme::UnitId;
use std::ops::Range;

/// A quantity that has one value at each end of an accepted step.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    Step(fn(&LoggedStep) -> f64),
    /// Of a unit's answer or request; of several values the norm.
    Exchange(UnitId, Half, Range<usize>),
}

/// There is no quantity of this name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("there is no `{name}` in the log; {}", remedy(near))]
pub struct UnknownQuantity {
    /// The name.
    pub name: String,
    /// Names that are like it, the nearest first.
    pub near: Vec<String>,
}

fn remedy(near: &[String]) -> String {
    match near {
        [] => "`cofferdam log show LOG --step 0` lists what is exchanged".to_owned(),
        near => format!("near to it are {}", near.join(", ")),
    }
}

/// Name, unit and value.
type OfStep = (&'static str, &'static str, fn(&LoggedStep) -> f64);

/// The quantities of the coupling.
const OF_STEPS: &[OfStep] = &[
    ("iterations", "1", |step| f64::from(step.occasion.iteration)),
    ("converged", "1", |step| f64::from(u8::from(step.converged))),
    ("residual.pressure", "Pa", |step| step.residual),
    ("interpolation_error", "Pa", |step| step.interpolation_error.unwrap_or(0.0)),
    ("lowest_pressure", "Pa", |step| lowest_pressure(step)),
    ("communication_step", "s", |step| step.occasion.communication_step),
    ("attempt", "1", |step| f64::from(step.occasion.attempt)),
];

/// Lowest pressure of all interfaces, Pa; 0 where it is unknown.
fn lowest_pressure(step: &LoggedStep) -> f64 {
    step.interfaces.iter().map(|interface| interface.lowest).reduce(f64::min).unwrap_or(0.0)
}

/// Names that an unknown one is compared with are this much like it at least.
const LIKE: f64 = 0.6;

impl Quantity {
    /// The quantity `name`: of the coupling, such as `iterations`; of a unit, such as `reservoir.total_force`; of an array
    /// one value, such as `dam.crest_displacement.x`, `dam.crack_sliding.0` or `reservoir.interface_pressure[3]`, or
    /// without an index the norm √Σxᵢ².
    ///
    /// **Errors**: the units of the log have no such variable, or the array no such index.
    pub fn named(head: &Head, name: &str) -> Result<Self, UnknownQuantity> {
        if let Some((_, unit, value)) = OF_STEPS.iter().find(|(of_step, _, _)| *of_step == name) {
            let (name, unit) = (name.to_owned(), (*unit).to_owned());
            return Ok(Self { name, unit, source: Source::Step(*value) });
        }
        Self::of_unit(head, name)
            .ok_or_else(|| UnknownQuantity { name: name.to_owned(), near: near(head, name) })
    }

    fn of_unit(head: &Head, name: &str) -> Option<Self> {
        let (unit, rest) = name.split_once('.')?;
        let id = head.units.iter().position(|u| u.name == unit)?;
        let (variable, index) = match rest.strip_suffix(']').and_then(|rest| rest.split_once('[')) {
            Some((variable, index)) => (variable, Some(index)),
            None => rest.split_once('.').map_or((rest, None), |(variable, index)| (variable, Some(index))),
        };
        let index = match index {
            None => None,
            Some("x") => Some(0),
            Some("y") => Some(1),
            Some(number) => Some(number.parse::<usize>().ok()?),
        };
        let unit = &head.units[id];
        for (half, layout) in [(Half::Answer, &unit.outputs), (Half::Request, &unit.inputs)] {
            let mut channels = layout.channels();
            let Some((channel, range)) = channels.find(|(channel, _)| channel.name == variable) else {
                continue;
            };
            let range = match index {
                None => range,
                Some(index) if index < range.len() => range.start + index..range.start + index + 1,
                Some(_) => return None,
            };
            let source = Source::Exchange(UnitId(id), half, range);
            return Some(Self { name: name.to_owned(), unit: channel.unit.clone(), source });
        }
        None
    }

    /// Whether its value is the norm of several.
    pub fn is_norm(&self) -> bool {
        matches!(&self.source, Source::Exchange(_, _, range) if range.len() > 1)
    }

    /// Its value in a step.
    pub fn value(&self, step: &AcceptedStep) -> f64 {
        match &self.source {
            Source::Step(value) => value(&step.step),
            Source::Exchange(unit, half, range) => {
                let exchange = &step.exchanges[unit.0];
                let values = match half {
                    Half::Request => &exchange.inputs,
                    Half::Answer => exchange.outputs.as_ref().unwrap_or(&exchange.inputs),
                };
                match &values[range.clone()] {
                    [value] => *value,
                    values => values.iter().map(|x| x * x).sum::<f64>().sqrt(),
                }
            }
        }
    }
}

/// All names without indices.
fn names(head: &Head) -> Vec<String> {
    let of_units = head.units.iter().flat_map(|unit| {
        let channels = unit.outputs.channels().chain(unit.inputs.channels());
        channels.map(|(channel, _)| format!("{}.{}", unit.name, channel.name))
    });
    OF_STEPS.iter().map(|(name, _, _)| (*name).to_owned()).chain(of_units).collect()
}

/// The names nearest to `name`, at most four. An array of this very name is given with its last index.
fn near(head: &Head, name: &str) -> Vec<String> {
    let bare = |name: &str| name.split('[').next().unwrap_or(name).to_owned();
    let mut ranked: Vec<(f64, String)> = names(head)
        .into_iter()
        .map(|known| {
            let whole = strsim::normalized_damerau_levenshtein(&bare(name), &known);
            // Without the unit, or a part of the name.
            let short = known.rsplit('.').next().unwrap_or(&known);
            let part = strsim::normalized_damerau_levenshtein(&bare(name), short);
            let contained = if name.len() > 3 && known.contains(&bare(name)) { LIKE } else { 0.0 };
            (whole.max(part).max(contained), known)
        })
        .collect();
    ranked.retain(|(like, _)| *like >= LIKE);
    ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    ranked.dedup();
    ranked.truncate(4);
    ranked.into_iter().map(|(_, known)| with_indices(head, known)).collect()
}

/// A name, with the range of its indices if it is an array.
fn with_indices(head: &Head, name: String) -> String {
    match Quantity::of_unit(head, &name).map(|quantity| quantity.source) {
        Some(Source::Exchange(_, _, range)) if range.len() > 1 => {
            format!("{name} (with [0] to [{}])", range.len() - 1)
        }
        _ => name,
    }
}
