//! Reads the messages of a topic by the schema in the file.

use super::decode::{Decoder, Mismatch, Schema, Wanted};
use super::entry::{Entry, LoggedDamage, LoggedEnd, LoggedExchange, LoggedIteration, LoggedStep};
use super::foxglove;
use super::head::LoggedUnit;
use super::stream::{Channel, Raw};
use cofferdam_coupling::acceleration::{AccelerationKind, Correction, JacobianState, SecantCounts};
use cofferdam_coupling::convergence::Residuals;
use cofferdam_coupling::observer::Checkpoint;
use cofferdam_coupling::participant::{Layout, Message, Occasion};
use cofferdam_coupling::scheme::{
    InterfaceReport, InterfaceWork, IterationReport, Purpose, UnitId, WorstPoint,
};

/// A topic, with the decoder of its messages.
pub enum Topic {
    Request(UnitId, Decoder),
    Answer(UnitId, Decoder),
    Iteration(Decoder),
    Step(Decoder),
    Checkpoint(Decoder),
    Message(Decoder, Decoder),
    End(Decoder),
    Damage(Decoder),
    Other,
}

/// Fields that every request and answer begins with.
const OCCASION: [(&str, Wanted); 7] = [
    ("step", Wanted::Unsigned),
    ("iteration", Wanted::Unsigned),
    ("attempt", Wanted::Unsigned),
    ("start_time", Wanted::Double),
    ("communication_step", Wanted::Double),
    ("accepted", Wanted::Bool),
    ("wall_time", Wanted::Double),
];

/// The name of a field in messages of `schema`: the start of a step was called `time`.
fn known<'a>(schema: &Schema, (name, wanted): (&'a str, Wanted)) -> (&'a str, Wanted) {
    match name {
        "start_time" if !schema.has(name) => ("time", wanted),
        _ => (name, wanted),
    }
}

/// What `/step` tells besides the occasion, in every version.
const STEP: [(&str, Wanted); 4] = [
    ("iterations", Wanted::Unsigned),
    ("converged", Wanted::Bool),
    ("residual_pressure", Wanted::Double),
    ("fallbacks", Wanted::Unsigned),
];
/// What it tells since there is `/iteration`.
const STEP_SINCE: [(&str, Wanted); 8] = [
    ("outcome", Wanted::Text),
    ("interpolation_error", Wanted::Double),
    ("largest_pressure", Wanted::Double),
    ("rounding_floor", Wanted::Double),
    ("work_on_structure", Wanted::Doubles),
    ("work_by_fluid", Wanted::Doubles),
    ("lowest_pressure", Wanted::Doubles),
    ("mapping_error", Wanted::Doubles),
];

const ITERATION: [(&str, Wanted); 21] = [
    ("step", Wanted::Unsigned),
    ("steps", Wanted::Unsigned),
    ("attempt", Wanted::Unsigned),
    ("iteration", Wanted::Unsigned),
    ("purpose", Wanted::Text),
    ("compared", Wanted::Bool),
    ("residual_pressure", Wanted::Double),
    ("pressure_ratio", Wanted::Double),
    ("residual_ratio", Wanted::Double),
    ("residual_displacement", Wanted::Double),
    ("worst_step", Wanted::Unsigned),
    ("worst_interface", Wanted::Unsigned),
    ("worst_point", Wanted::Unsigned),
    ("worst_given", Wanted::Double),
    ("worst_answered", Wanted::Double),
    ("acceleration", Wanted::Text),
    ("relaxation", Wanted::Double),
    ("secants_known", Wanted::Unsigned),
    ("secants_independent", Wanted::Unsigned),
    ("secants", Wanted::Unsigned),
    ("jacobian", Wanted::Text),
];

impl Topic {
    /// The topic of a channel; an unknown one is skipped.
    pub fn of(channel: &Channel, units: &[LoggedUnit]) -> Result<Self, Mismatch> {
        let schema = || Schema::find(&channel.schema.name, &channel.schema.descriptor);
        let exchange = |layout: &Layout| {
            let schema = schema()?;
            let variables = layout.channels().map(|(c, _)| {
                (c.name.as_str(), if c.shape.is_array() { Wanted::Doubles } else { Wanted::Double })
            });
            schema.decoder(OCCASION.map(|field| known(&schema, field)).into_iter().chain(variables))
        };
        for (number, unit) in units.iter().enumerate() {
            let id = UnitId(number);
            let half = channel.topic.strip_prefix('/').and_then(|t| t.strip_prefix(unit.name.as_str()));
            match half {
                Some("/request") => return Ok(Self::Request(id, exchange(&unit.inputs)?)),
                Some("/answer") => return Ok(Self::Answer(id, exchange(&unit.outputs)?)),
                _ => {}
            }
        }
        Ok(match &*channel.topic {
            "/iteration" => Self::Iteration(schema()?.decoder(ITERATION)?),
            "/step" => {
                let schema = schema()?;
                let [step, _, attempt, time, length, accepted, _] =
                    OCCASION.map(|field| known(&schema, field));
                // In the places of an exchange.
                let wanted = [step, STEP[0], attempt, time, length, accepted, STEP[1], STEP[2], STEP[3]];
                let times: Vec<String> = units.iter().map(|unit| format!("{}_time", unit.name)).collect();
                let times = times.iter().map(|name| (name.as_str(), Wanted::Double));
                Self::Step(schema.decoder_with(wanted, STEP_SINCE.into_iter().chain(times))?)
            }
            "/checkpoint" => Self::Checkpoint(schema()?.decoder([
                ("step", Wanted::Unsigned),
                ("end_time", Wanted::Double),
                ("run", Wanted::Messages),
                ("units", Wanted::Messages),
            ])?),
            "/log" => {
                let message = schema()?.decoder([
                    ("step", Wanted::Unsigned),
                    ("iteration", Wanted::Unsigned),
                    ("level", Wanted::Unsigned),
                    ("name", Wanted::Text),
                    ("file", Wanted::Text),
                    ("message", Wanted::Text),
                    ("timestamp", Wanted::Messages),
                ])?;
                let timestamp = Schema::find(foxglove::TIMESTAMP, &channel.schema.descriptor)?;
                Self::Message(
                    message,
                    timestamp.decoder(["seconds", "nanos"].map(|n| (n, Wanted::Unsigned)))?,
                )
            }
            "/end" => Self::End(schema()?.decoder([("status", Wanted::Text), ("time", Wanted::Double)])?),
            "/damage" => {
                let wanted = [
                    ("first_byte", Wanted::Unsigned),
                    ("last_byte", Wanted::Unsigned),
                    ("what", Wanted::Text),
                ];
                Self::Damage(schema()?.decoder(wanted)?)
            }
            _ => Self::Other,
        })
    }
}

/// Content of a message: half an exchange, or a whole entry.
pub enum Part {
    Request(LoggedExchange),
    Answer(LoggedExchange),
    Entry(Entry),
    Damage(LoggedDamage),
    Nothing,
}

impl Topic {
    /// Reads a message of the topic.
    pub fn read(&mut self, raw: &Raw, units: &[LoggedUnit]) -> Result<Part, Mismatch> {
        Ok(match self {
            Self::Request(id, decoder) => {
                let (exchange, inputs) = exchange(*id, decoder, raw, &units[id.0].inputs)?;
                Part::Request(LoggedExchange { inputs, ..exchange })
            }
            Self::Answer(id, decoder) => {
                let (exchange, outputs) = exchange(*id, decoder, raw, &units[id.0].outputs)?;
                Part::Answer(LoggedExchange { outputs: Some(outputs), ..exchange })
            }
            Self::Iteration(decoder) => {
                decoder.read(&raw.data)?;
                Part::Entry(Entry::Iteration(iteration(decoder)?))
            }
            Self::Step(decoder) => {
                decoder.read(&raw.data)?;
                Part::Entry(Entry::Step(step(decoder, units.len())?))
            }
            Self::Checkpoint(decoder) => {
                decoder.read(&raw.data)?;
                let bytes = |state: &Vec<u8>| (!state.is_empty()).then(|| state.clone());
                Part::Entry(Entry::Checkpoint(Checkpoint {
                    step: decoder.unsigned(0),
                    time: decoder.double(1),
                    run: decoder.messages(2).concat(),
                    units: decoder.messages(3).iter().map(bytes).collect(),
                }))
            }
            Self::Message(decoder, timestamp) => {
                decoder.read(&raw.data)?;
                timestamp.read(decoder.messages(6).last().map_or(&[][..], Vec::as_slice))?;
                Part::Entry(Entry::Message(Message {
                    unit: decoder.text(3),
                    level: foxglove::level(decoder.unsigned(2)),
                    step: decoder.unsigned(0),
                    iteration: small(decoder.unsigned(1), "iteration")?,
                    time: timestamp.unsigned(0) as f64 + 1e-9 * timestamp.unsigned(1) as f64,
                    source: decoder.text(4),
                    text: decoder.text(5),
                }))
            }
            Self::End(decoder) => {
                decoder.read(&raw.data)?;
                Part::Entry(Entry::End(LoggedEnd { status: decoder.text(0), time: decoder.double(1) }))
            }
            Self::Damage(decoder) => {
                decoder.read(&raw.data)?;
                let (first, last, what) = (decoder.unsigned(0), decoder.unsigned(1), decoder.text(2));
                Part::Damage(LoggedDamage { first, last, what })
            }
            Self::Other => Part::Nothing,
        })
    }
}

fn occasion(decoder: &Decoder) -> Result<Occasion, Mismatch> {
    Ok(Occasion {
        step: decoder.unsigned(0),
        iteration: small(decoder.unsigned(1), "iteration")?,
        attempt: small(decoder.unsigned(2), "attempt")?,
        time: decoder.double(3),
        communication_step: decoder.double(4),
    })
}

/// What a decoder of [`STEP`] and [`STEP_SINCE`] has read.
fn step(decoder: &Decoder, units: usize) -> Result<LoggedStep, Mismatch> {
    let since = |field: usize| OCCASION.len() + 2 + field;
    let known = |place: usize| Some(decoder.double(place)).filter(|value| *value != 0.0);
    let [on_first, by_second, lowest, mapping] = [4, 5, 6, 7].map(|field| decoder.doubles(since(field)));
    let interface =
        |(((on_first, by_second), lowest), mapping): (((&f64, &f64), &f64), &f64)| InterfaceReport {
            work: (!on_first.is_nan())
                .then_some(InterfaceWork { on_first: *on_first, by_second: *by_second }),
            lowest: *lowest,
            mapping_error: *mapping,
        };
    Ok(LoggedStep {
        occasion: occasion(decoder)?,
        accepted: decoder.bool(5),
        converged: decoder.bool(6),
        residual: decoder.double(7),
        fallbacks: small(decoder.unsigned(8), "fallbacks")?,
        outcome: decoder.text(since(0)),
        interpolation_error: known(since(1)),
        largest: decoder.double(since(2)),
        rounding_floor: known(since(3)),
        interfaces: on_first.iter().zip(by_second).zip(lowest).zip(mapping).map(interface).collect(),
        unit_times: (0..units).map(|unit| decoder.double(since(STEP_SINCE.len() + unit))).collect(),
    })
}

/// What a decoder of [`ITERATION`] has read.
fn iteration(decoder: &Decoder) -> Result<LoggedIteration, Mismatch> {
    let count = |place: usize| usize::try_from(decoder.unsigned(place)).unwrap_or(usize::MAX);
    let compared = decoder.bool(5);
    let residuals = Residuals {
        norm: decoder.double(6),
        relative_ratio: decoder.double(7),
        reduction_ratio: decoder.double(8),
        change: decoder.double(9),
    };
    let worst = WorstPoint {
        step: decoder.unsigned(10),
        interface: count(11),
        point: count(12),
        given: decoder.double(13),
        answered: decoder.double(14),
    };
    let (purpose, acceleration, jacobian) = (decoder.text(4), decoder.text(15), decoder.text(20));
    let unknown = |field, value: &str| Mismatch::Value { field, value: value.to_owned() };
    Ok(LoggedIteration {
        steps: [decoder.unsigned(0), decoder.unsigned(1)],
        attempt: small(decoder.unsigned(2), "attempt")?,
        report: IterationReport {
            iteration: small(decoder.unsigned(3), "iteration")?,
            purpose: Purpose::ALL
                .into_iter()
                .find(|p| p.word() == purpose)
                .ok_or_else(|| unknown("purpose", &purpose))?,
            correction: Correction {
                acceleration: AccelerationKind::ALL
                    .into_iter()
                    .find(|a| a.word() == acceleration)
                    .ok_or_else(|| unknown("acceleration", &acceleration))?,
                relaxation: decoder.double(16),
                secants: SecantCounts { known: count(17), independent: count(18), used: count(19) },
                jacobian: JacobianState::ALL
                    .into_iter()
                    .find(|j| j.word() == jacobian)
                    .ok_or_else(|| unknown("jacobian", &jacobian))?,
            },
            residuals: compared.then_some(residuals),
            worst: compared.then_some(worst),
        },
    })
}

fn small(value: u64, field: &'static str) -> Result<u32, Mismatch> {
    u32::try_from(value).map_err(|_| Mismatch::Value { field, value: value.to_string() })
}

/// An exchange without its values, and the values.
fn exchange(
    unit: UnitId,
    decoder: &mut Decoder,
    raw: &Raw,
    layout: &Layout,
) -> Result<(LoggedExchange, Vec<f64>), Mismatch> {
    decoder.read(&raw.data)?;
    let mut values = Vec::new();
    for (index, (channel, _)) in layout.channels().enumerate() {
        let found = decoder.doubles(OCCASION.len() + index);
        match (channel.shape.is_array(), found) {
            // Protobuf does not write a zero.
            (false, []) => values.push(0.0),
            (false, [.., value]) => values.push(*value),
            (true, _) if found.len() == channel.size => values.extend_from_slice(found),
            (true, _) => {
                let (variable, expected, found) = (channel.name.clone(), channel.size, found.len());
                return Err(Mismatch::Length { variable, expected, found });
            }
        }
    }
    let exchange = LoggedExchange {
        unit,
        occasion: occasion(decoder)?,
        accepted: decoder.bool(5),
        sequence: raw.sequence,
        wall_time: [decoder.double(6); 2],
        inputs: Vec::new(),
        outputs: None,
    };
    Ok((exchange, values))
}
