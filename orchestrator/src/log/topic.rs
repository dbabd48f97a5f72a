//! Reads the messages of a topic by the schema in the file.

use super::decode::{Decoder, Mismatch, Schema, Wanted};
use super::entry::{Entry, LoggedDamage, LoggedEnd, LoggedExchange, LoggedStep};
use super::foxglove;
use super::head::LoggedUnit;
use super::stream::{Channel, Raw};
use crate::participant::{Layout, Message, Occasion};
use crate::scheme::UnitId;

/// A topic, with the decoder of its messages.
pub enum Topic {
    Request(UnitId, Decoder),
    Answer(UnitId, Decoder),
    Step(Decoder),
    Message(Decoder, Decoder),
    End(Decoder),
    Damage(Decoder),
    Other,
}

/// Fields that every request and answer begins with.
const OCCASION: [(&str, Wanted); 6] = [
    ("step", Wanted::Unsigned),
    ("iteration", Wanted::Unsigned),
    ("attempt", Wanted::Unsigned),
    ("time", Wanted::Double),
    ("communication_step", Wanted::Double),
    ("accepted", Wanted::Bool),
];

impl Topic {
    /// The topic of a channel; an unknown one is skipped.
    pub fn of(channel: &Channel, units: &[LoggedUnit]) -> Result<Self, Mismatch> {
        let schema = || Schema::find(&channel.schema.name, &channel.schema.descriptor);
        let exchange = |layout: &Layout| {
            let variables = layout.channels().map(|(c, _)| {
                (c.name.as_str(), if c.shape.is_array() { Wanted::Doubles } else { Wanted::Double })
            });
            schema()?.decoder(OCCASION.into_iter().chain(variables))
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
            "/step" => {
                let iterations = ("iterations", Wanted::Unsigned);
                let converged = ("converged", Wanted::Bool);
                let residual = ("residual_pressure", Wanted::Double);
                let [step, _, attempt, time, length, accepted] = OCCASION;
                let wanted = [step, iterations, attempt, time, length, accepted, converged, residual];
                Self::Step(schema()?.decoder(wanted)?)
            }
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
            Self::Step(decoder) => {
                decoder.read(&raw.data)?;
                Part::Entry(Entry::Step(LoggedStep {
                    occasion: occasion(decoder)?,
                    accepted: decoder.bool(5),
                    converged: decoder.bool(6),
                    residual: decoder.double(7),
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
        inputs: Vec::new(),
        outputs: None,
    };
    Ok((exchange, values))
}
