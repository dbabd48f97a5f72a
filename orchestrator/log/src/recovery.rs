//! Writes a sound log from what a damaged or cut one still holds.

use super::entry::LoggedDamage;
use super::index::Index;
use super::reader::Log;
use super::schema::Value;
use super::source::Source;
use super::stream::{Channel, Next, Raw, Stream};
use super::types::damage_type;
use super::writer::options;
use super::{LogError, LogReadError};
use mcap::records::MessageHeader;
use std::collections::{BTreeMap, HashMap};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What became of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovery {
    /// Messages that were saved.
    pub messages: u64,
    /// What is missing between them, in the damaged file.
    pub damage: Vec<LoggedDamage>,
    /// Damage that no message was lost by, and its place.
    pub mended: Vec<(u64, String)>,
    /// Messages that were left out because nothing says what they are.
    pub undeclared: u64,
}

/// Why a log cannot be recovered.
#[derive(Debug, thiserror::Error)]
pub enum RecoveryError {
    /// The damaged log.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// The new log.
    #[error(transparent)]
    Write(#[from] LogError),
    /// A file with the name of the new log.
    #[error("{}: is there already; choose another --output, nothing is overwritten", path.display())]
    Taken {
        /// The file.
        path: PathBuf,
    },
    /// No message is left.
    #[error("{}: no message in it is whole; run the scene again", path.display())]
    Nothing {
        /// The file.
        path: PathBuf,
    },
}

type Writer = mcap::Writer<BufWriter<std::fs::File>>;

/// Writes every whole message of `log`, or of the log in the folder `log`, to the new file `output`, as a finished log with
/// an index. Where something is missing, there is a message on `/damage`.
///
/// A chunk is read whole or not at all, because its checksum covers all of it.
///
/// **Errors**: [`RecoveryError`]; then there is no file `output`.
pub fn recover(log: &Path, output: &Path) -> Result<Recovery, RecoveryError> {
    let path = Log::file(log);
    if output.symlink_metadata().is_ok() {
        return Err(RecoveryError::Taken { path: output.to_owned() });
    }
    let mut stream = Stream::open_damaged(&path)?;
    let source = Source::open(&path, Default::default())?;
    if let Some(index) = Index::of_summary(&source)? {
        stream.know(&index.declared);
    }
    let created = |cause| LogError::Create { path: output.to_owned(), cause };
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = NamedTempFile::new_in(folder).map_err(created)?;
    let library = format!("cofferdam {}", env!("CARGO_PKG_VERSION"));
    let written = |error| LogError::of_writer(output, error);
    let handle = file.as_file().try_clone().map_err(created)?;
    let mut saving = Saving {
        writer: options(&library).create(BufWriter::new(handle)).map_err(written)?,
        channels: HashMap::new(),
        damage_channel: None,
        time: 0,
        ended: false,
        torn: false,
        recovery: Recovery { messages: 0, damage: Vec::new(), mended: Vec::new(), undeclared: 0 },
    };
    for (id, channel) in stream.declared().clone().channels() {
        saving.declare(*id, channel).map_err(written)?;
    }
    saving.save(&mut stream, output)?;
    if saving.recovery.messages == 0 {
        return Err(RecoveryError::Nothing { path });
    }
    let Saving { mut writer, recovery, .. } = saving;
    writer.finish().map_err(written)?;
    writer.into_inner().flush().map_err(|cause| LogError::Write { path: output.to_owned(), cause })?;
    file.persist_noclobber(output).map_err(|error| match error.error.kind() {
        std::io::ErrorKind::AlreadyExists => RecoveryError::Taken { path: output.to_owned() },
        _ => LogError::Create { path: output.to_owned(), cause: error.error }.into(),
    })?;
    Ok(recovery)
}

/// A log that is being recovered.
struct Saving {
    writer: Writer,
    /// Channels of the new file by those of the damaged one.
    channels: HashMap<u16, u16>,
    damage_channel: Option<u16>,
    /// Log time of the last message.
    time: u64,
    /// Whether the end of the run was read.
    ended: bool,
    /// Whether damage was the last that was read.
    torn: bool,
    recovery: Recovery,
}

impl Saving {
    fn save(&mut self, stream: &mut Stream, output: &Path) -> Result<(), RecoveryError> {
        let written = |error| LogError::of_writer(output, error);
        loop {
            let (place, cause) = match stream.next() {
                Ok(Next::Message(raw)) => {
                    self.message(stream, &raw).map_err(written)?;
                    continue;
                }
                Ok(Next::End) if !self.ended && !self.torn => {
                    let (first, what) = (stream.position(), "the end of the run is missing".to_owned());
                    self.damage(LoggedDamage { first, last: first, what }).map_err(written)?;
                    break;
                }
                Ok(Next::End) => break,
                Ok(Next::Cut) if self.ended => break,
                Ok(Next::Cut) => (stream.position(), "the log is cut short here".to_owned()),
                Err(LogReadError::Damaged { position, cause, .. }) => (position, cause),
                Err(error) => return Err(error.into()),
            };
            if stream.mend()? {
                self.recovery.mended.push((place, cause));
                continue;
            }
            let next = stream.pass()?;
            // Before the first chunk there is no message, nor behind the end of the run, nor at the end of the data.
            let before = place == mcap::MAGIC.len() as u64 && next.is_some();
            if before || self.ended || next == Some(place) {
                self.recovery.mended.push((place, cause));
            } else {
                let last = next.unwrap_or(stream.size()).saturating_sub(1).max(place);
                self.damage(LoggedDamage { first: place, last, what: cause }).map_err(written)?;
            }
            if next.is_none_or(|next| next == place) {
                break;
            }
        }
        if let Some(flaw) = stream.conclude()? {
            self.recovery.mended.push((flaw.place, flaw.cause));
        }
        Ok(())
    }

    fn message(&mut self, stream: &Stream, raw: &Raw) -> Result<(), mcap::McapError> {
        let known = self.channels.get(&raw.channel).copied();
        let channel = match (known, stream.channel(raw.channel)) {
            (Some(channel), _) => channel,
            (None, Some(channel)) => self.declare(raw.channel, channel)?,
            (None, None) => {
                self.recovery.undeclared += 1;
                return Ok(());
            }
        };
        self.ended |= stream.channel(raw.channel).is_some_and(|channel| channel.topic == "/end");
        let [log_time, publish_time] = raw.times;
        self.time = self.time.max(log_time);
        self.recovery.messages += 1;
        self.torn = false;
        let header = MessageHeader { channel_id: channel, sequence: raw.sequence, log_time, publish_time };
        self.writer.write_to_known_channel(&header, &raw.data)
    }

    fn declare(&mut self, id: u16, channel: &Channel) -> Result<u16, mcap::McapError> {
        let schema = &channel.schema;
        let schema = match &*schema.name {
            "" => 0,
            name => self.writer.add_schema(name, &schema.encoding, &schema.descriptor)?,
        };
        let new = self.writer.add_channel(schema, &channel.topic, &channel.encoding, &channel.metadata)?;
        self.channels.insert(id, new);
        Ok(new)
    }

    /// Notes what is missing here.
    fn damage(&mut self, damage: LoggedDamage) -> Result<(), mcap::McapError> {
        let kind = damage_type();
        let channel = match self.damage_channel {
            Some(channel) => channel,
            None => {
                let schema = self.writer.add_schema(&kind.full_name(), "protobuf", &kind.descriptor_set())?;
                self.writer.add_channel(schema, "/damage", "protobuf", &BTreeMap::new())?
            }
        };
        self.damage_channel = Some(channel);
        let LoggedDamage { first, last, what } = &damage;
        let data = kind.encode([Value::Unsigned(*first), Value::Unsigned(*last), Value::Text(what)]);
        let header =
            MessageHeader { channel_id: channel, sequence: 0, log_time: self.time, publish_time: self.time };
        self.recovery.damage.push(damage);
        self.torn = true;
        self.writer.write_to_known_channel(&header, &data)
    }
}
