//! The part of a log before its first exchange.

use super::LogReadError;
use super::content::LoggedExchanges;
use super::decode::{Mismatch, Schema, Wanted};
use super::stream::{Channel, Next, Stream};
use super::types::BUILD;
use super::writer::Parent;
use cofferdam_coupling::participant::{self, ChannelShape, Layout};
use cofferdam_coupling::scheme::UnitId;
use cofferdam_coupling::signal::Signal;
use std::collections::BTreeMap;

/// The run and the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// What the run computed, as text; of a scene of a dam, TOML with all defaults.
    pub scene_text: String,
    /// Which exchanges are logged.
    pub exchanges: LoggedExchanges,
    /// Communication steps that were iterated together, at least 1.
    pub window: u64,
    /// Version of the program.
    pub version: String,
    /// Git commit of the program.
    pub commit: String,
    /// Optimised or not; this and what follows is empty in logs of earlier versions.
    pub profile: String,
    /// The processor.
    pub processor: String,
    /// What the processor offers to the program beyond its architecture.
    pub features: String,
    /// Operating system and architecture.
    pub system: String,
    /// When the run began, in UTC.
    pub started: String,
    /// The run that this one branched off from.
    pub parent: Option<Parent>,
    /// The units by their numbers.
    pub units: Vec<LoggedUnit>,
    /// The external signals. Of logs before version 0.1 whether the last sample is held is not known, and taken to be false.
    pub signals: Vec<Signal>,
}

/// A unit that took part.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedUnit {
    /// Name in topics and messages.
    pub name: String,
    /// Solver and version.
    pub solver: String,
    /// Hash of everything that the unit was made from, in hexadecimal digits.
    pub fingerprint: String,
    /// Layout of a request.
    pub inputs: Layout,
    /// Layout of an answer.
    pub outputs: Layout,
}

impl Head {
    /// The unit of an exchange in this log.
    pub fn unit(&self, id: UnitId) -> &LoggedUnit {
        &self.units[id.0]
    }

    /// The title in the text of the scene, if that is TOML and has one.
    pub fn title(&self) -> Option<String> {
        let scene: toml::Table = self.scene_text.parse().ok()?;
        Some(scene.get("title")?.as_str()?.to_owned())
    }

    /// The external signal that units receive as a component of `input`, counted from 0.
    pub fn signal(&self, input: &str, component: usize) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.input == input && signal.component == component)
    }

    /// Reads up to the first message that does not belong to it.
    pub(super) fn read(stream: &mut Stream, path: &std::path::Path) -> Result<Self, LogReadError> {
        let mut parts = Parts::default();
        loop {
            let missing = match parts {
                Parts { scene: None, .. } => Some("/scene"),
                Parts { build: None, .. } => Some("/build"),
                Parts { ref units, .. } if units.len() < 2 => Some("/unit"),
                _ => None,
            };
            let (path, position) = (path.to_owned(), stream.position());
            let raw = match (stream.next(), missing) {
                (Ok(Next::Message(raw)), _) => raw,
                // What follows, damaged or not, is not the head.
                (_, None) => break,
                (Err(error), _) => return Err(error),
                (Ok(Next::Cut), _) => {
                    return Err(LogReadError::Headless { path, position: stream.position() });
                }
                // The units were never made.
                (Ok(Next::End), _) if parts.scene.is_some() && parts.units.is_empty() => {
                    return Err(LogReadError::Headless { path, position: stream.position() });
                }
                (Ok(Next::End), Some(topic)) => {
                    let library = stream.library().to_owned();
                    return Err(LogReadError::Foreign { path, position, library, topic });
                }
            };
            let known = match stream.channel(raw.channel) {
                None => Ok(false),
                Some(channel) => parts.take(channel, &raw.data).map_err(|mismatch| {
                    let (topic, path, position) = (channel.topic.clone(), path.clone(), stream.position());
                    LogReadError::Topic { path, position, topic, mismatch }
                }),
            };
            match (known?, missing) {
                (true, _) => {}
                (false, None) => break,
                (false, Some(topic)) => {
                    let (position, library) = (stream.position(), stream.library().to_owned());
                    return Err(LogReadError::Foreign { path, position, library, topic });
                }
            }
        }
        let Parts { scene, build, units, signals } = parts;
        let twice = |i: usize| units[..i].iter().any(|unit| unit.name == units[i].name);
        if let Some(i) = (1..units.len()).find(|&i| twice(i)) {
            let (path, position) = (path.to_owned(), stream.position());
            let cause = format!("two `/unit` of the name {}", units[i].name);
            return Err(LogReadError::Damaged { path, position, cause });
        }
        let scene_text = scene.unwrap_or_default();
        let [
            version,
            commit,
            profile,
            processor,
            features,
            system,
            started,
            parent,
            step,
            settings,
            exchanges,
            window,
        ] = build.unwrap_or_default();
        let before = Earlier::of(&scene_text);
        let parent = step.parse().ok().map(|step| Parent { log: parent, step, settings });
        Ok(Self {
            exchanges: LoggedExchanges::of_word(&exchanges).unwrap_or(before.exchanges),
            window: window.parse().unwrap_or(before.window).max(1),
            scene_text,
            version,
            commit,
            profile,
            processor,
            features,
            system,
            started,
            parent,
            units,
            signals,
        })
    }
}

/// What logs of earlier versions tell only in their scene.
struct Earlier {
    exchanges: LoggedExchanges,
    window: u64,
}

impl Earlier {
    fn of(scene: &str) -> Self {
        let scene: toml::Table = scene.parse().unwrap_or_default();
        let value = |table: &str, key: &str| scene.get(table).and_then(|table| table.get(key));
        let exchanges = value("log", "exchanges").and_then(toml::Value::as_str);
        let window = value("coupling", "window").and_then(toml::Value::as_integer);
        Self {
            exchanges: exchanges.and_then(LoggedExchanges::of_word).unwrap_or_default(),
            window: window.and_then(|window| window.try_into().ok()).unwrap_or(1),
        }
    }
}

/// Most units of a run, and longest scene (bytes): what claims to be more would take memory without end.
const MOST_UNITS: usize = 64;
const LONGEST_SCENE: usize = 1 << 22;

#[derive(Default)]
struct Parts {
    scene: Option<String>,
    build: Option<[String; BUILD.len()]>,
    units: Vec<LoggedUnit>,
    signals: Vec<Signal>,
}

impl Parts {
    /// Takes a message if it belongs to the head; returns whether it does.
    fn take(&mut self, channel: &Channel, data: &[u8]) -> Result<bool, Mismatch> {
        let schema = || Schema::find(&channel.schema.name, &channel.schema.descriptor);
        match &*channel.topic {
            "/scene" => {
                let mut decoder = schema()?.decoder([("toml", Wanted::Text)])?;
                decoder.read(data)?;
                let text = decoder.text(0);
                if text.len() > LONGEST_SCENE {
                    return Err(Mismatch::Value {
                        field: "toml",
                        value: format!("a text of {} bytes", text.len()),
                    });
                }
                self.scene = Some(text);
            }
            "/build" => {
                let (always, since) = BUILD.split_at(2);
                let texts = |names: &'static [&'static str]| names.iter().map(|name| (*name, Wanted::Text));
                let mut decoder = schema()?.decoder_with(texts(always), texts(since))?;
                decoder.read(data)?;
                self.build = Some(std::array::from_fn(|field| decoder.text(field)));
            }
            "/unit" if self.units.len() >= MOST_UNITS => {
                return Err(Mismatch::Value {
                    field: "name",
                    value: format!("that of unit {}", MOST_UNITS + 1),
                });
            }
            "/unit" => self.units.push(unit(&schema()?, data)?),
            topic => {
                let Some(signal) = signal(topic, &channel.metadata, schema, data)? else { return Ok(false) };
                self.signals.push(signal);
            }
        }
        Ok(true)
    }
}

/// Name, input, quantity and unit of the signal in logs that do not tell them.
const EARLIER_SIGNAL: [&str; 4] = ["ground_motion", "ground_acceleration", "acceleration", "m/s2"];

/// The external signal in a message; `None` where the channel holds none.
fn signal(
    topic: &str,
    metadata: &BTreeMap<String, String>,
    schema: impl Fn() -> Result<Schema, Mismatch>,
    data: &[u8],
) -> Result<Option<Signal>, Mismatch> {
    let name = topic.trim_start_matches('/');
    let [earlier, earlier_input, earlier_quantity, earlier_unit] = EARLIER_SIGNAL;
    let input = metadata.get("input").map(String::as_str).or((name == earlier).then_some(earlier_input));
    let Some(input) = input else { return Ok(None) };
    let quantity = metadata.get("quantity").map_or(earlier_quantity, String::as_str);
    let wanted = [("source", Wanted::Text), ("interval", Wanted::Double), (quantity, Wanted::Doubles)];
    let mut decoder = schema()?.decoder(wanted)?;
    decoder.read(data)?;
    Ok(Some(Signal {
        name: name.to_owned(),
        input: input.to_owned(),
        quantity: quantity.to_owned(),
        unit: metadata.get("unit").map_or(earlier_unit, String::as_str).to_owned(),
        source: decoder.text(0),
        interval: decoder.double(1),
        samples: decoder.doubles(2).to_vec(),
        held: metadata.get("held").is_some_and(|held| held == "true"),
        component: metadata.get("component").and_then(|component| component.parse().ok()).unwrap_or(0),
        parts: metadata
            .get("parts")
            .into_iter()
            .flat_map(|parts| parts.split(','))
            .flat_map(str::parse)
            .collect(),
    }))
}

fn unit(schema: &Schema, data: &[u8]) -> Result<LoggedUnit, Mismatch> {
    let texts = ["name", "solver", "fingerprint"].map(|name| (name, Wanted::Text));
    let lists = ["inputs", "outputs"].map(|name| (name, Wanted::Messages));
    let mut decoder = schema.decoder(texts.into_iter().chain(lists))?;
    decoder.read(data)?;
    let mut variable = schema.nested("Variable")?.decoder([
        ("name", Wanted::Text),
        ("value_reference", Wanted::Unsigned),
        ("unit", Wanted::Text),
        ("size", Wanted::Unsigned),
        ("array", Wanted::Bool),
    ])?;
    let mut layout = |messages: &[Vec<u8>]| -> Result<Layout, Mismatch> {
        let mut channels = Vec::new();
        for message in messages {
            variable.read(message)?;
            let number = |place, field| {
                let value: u64 = variable.unsigned(place);
                u32::try_from(value).map_err(|_| Mismatch::Value { field, value: value.to_string() })
            };
            let (size, array) = (number(3, "size")?, variable.bool(4));
            if !array && size != 1 {
                return Err(Mismatch::Value { field: "size", value: size.to_string() });
            }
            channels.push(participant::Channel {
                name: variable.text(0),
                value_reference: number(1, "value_reference")?,
                unit: variable.text(2),
                size: size as usize,
                shape: if array { ChannelShape::List } else { ChannelShape::Scalar },
            });
        }
        Ok(Layout::new(channels))
    };
    Ok(LoggedUnit {
        name: decoder.text(0),
        solver: decoder.text(1),
        fingerprint: decoder.text(2),
        inputs: layout(decoder.messages(3))?,
        outputs: layout(decoder.messages(4))?,
    })
}
