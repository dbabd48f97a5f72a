//! The part of a log before its first exchange.

use super::LogReadError;
use super::decode::{Mismatch, Schema, Wanted};
use super::stream::{Channel, Next, Stream};
use super::types::BUILD;
use super::writer::Parent;
use crate::ground_motion::GroundMotion;
use crate::participant::{self, ChannelShape, Layout};
use crate::scene::Scene;
use crate::scheme::UnitId;

/// The run and the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// The scene with all defaults.
    pub scene: Scene,
    /// The same as text in the log, TOML.
    pub scene_text: String,
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
    /// The units by their numbers: the dam, the reservoir, others.
    pub units: Vec<LoggedUnit>,
    /// The ground motion.
    pub ground_motion: LoggedGroundMotion,
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

/// The ground motion.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedGroundMotion {
    /// Its source.
    pub source: String,
    /// Time between two samples, s.
    pub interval: f64,
    /// The samples, m/s².
    pub acceleration: Vec<f64>,
}

impl Head {
    /// The unit of an exchange in this log.
    pub fn unit(&self, id: UnitId) -> &LoggedUnit {
        &self.units[id.0]
    }

    /// The ground motion, as the run had it.
    pub fn ground_motion(&self) -> GroundMotion {
        let LoggedGroundMotion { source, interval, acceleration } = &self.ground_motion;
        let motion = GroundMotion::of_samples(source, *interval, acceleration.clone());
        if self.scene.ground_motion.record.is_none() { motion.held() } else { motion }
    }

    /// Reads until everything is known.
    pub(super) fn read(stream: &mut Stream, path: &std::path::Path) -> Result<Self, LogReadError> {
        let mut parts = Parts::default();
        loop {
            let missing = match parts {
                Parts { scene: None, .. } => "/scene",
                Parts { build: None, .. } => "/build",
                Parts { ref units, .. } if units.len() < 2 => "/unit",
                Parts { ground_motion: None, .. } => "/ground_motion",
                _ => break,
            };
            let (path, position) = (path.to_owned(), stream.position());
            let raw = match stream.next()? {
                Next::Message(raw) => raw,
                Next::Cut => return Err(LogReadError::Headless { path, position: stream.position() }),
                // The units were never made.
                Next::End if parts.scene.is_some() && parts.units.is_empty() => {
                    return Err(LogReadError::Headless { path, position: stream.position() });
                }
                Next::End => {
                    let library = stream.library().to_owned();
                    return Err(LogReadError::Foreign { path, position, library, topic: missing });
                }
            };
            let known = match stream.channel(raw.channel) {
                None => Ok(false),
                Some(channel) => parts.take(channel, &raw.data).map_err(|mismatch| {
                    let (topic, path, position) = (channel.topic.clone(), path.clone(), stream.position());
                    LogReadError::Topic { path, position, topic, mismatch }
                }),
            };
            if !known? {
                let (position, library) = (stream.position(), stream.library().to_owned());
                return Err(LogReadError::Foreign { path, position, library, topic: missing });
            }
        }
        let Parts { scene, build, units, ground_motion } = parts;
        let twice = |i: usize| units[..i].iter().any(|unit| unit.name == units[i].name);
        if let Some(i) = (1..units.len()).find(|&i| twice(i)) {
            let (path, position) = (path.to_owned(), stream.position());
            let cause = format!("two `/unit` of the name {}", units[i].name);
            return Err(LogReadError::Damaged { path, position, cause });
        }
        let scene_text = scene.unwrap_or_default();
        let [version, commit, profile, processor, features, system, started, parent, step, settings] =
            build.unwrap_or_default();
        let Some(ground_motion) = ground_motion else {
            return Err(LogReadError::Headless { path: path.to_owned(), position: stream.position() });
        };
        let scene = toml::from_str(&scene_text).map_err(|e| LogReadError::Scene {
            path: path.to_owned(),
            message: e.message().to_owned(),
            version: version.clone(),
            commit: commit.clone(),
        })?;
        let branch = step.parse().ok();
        let parent = branch.map(|step| Parent { log: parent, step, settings });
        Ok(Self {
            scene,
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
            ground_motion,
        })
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
    ground_motion: Option<LoggedGroundMotion>,
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
            "/ground_motion" => {
                let wanted = [
                    ("source", Wanted::Text),
                    ("interval", Wanted::Double),
                    ("acceleration", Wanted::Doubles),
                ];
                let mut decoder = schema()?.decoder(wanted)?;
                decoder.read(data)?;
                self.ground_motion = Some(LoggedGroundMotion {
                    source: decoder.text(0),
                    interval: decoder.double(1),
                    acceleration: decoder.doubles(2).to_vec(),
                });
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
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
