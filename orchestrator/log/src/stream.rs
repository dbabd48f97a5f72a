//! The messages of an MCAP file in the order in which they were written, from its beginning or from any chunk on.

use super::LogReadError;
use super::check::{Check, Flaw, ends};
use super::chunk::{self, Header};
use super::source::{FRAME, Frame, LONGEST, Source, u32_at, u64_at};
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// A message as stored in the file.
pub struct Raw {
    /// Number of its channel.
    pub channel: u16,
    /// Sequence number.
    pub sequence: u32,
    /// Log time and publish time, ns.
    pub times: [u64; 2],
    /// The encoded message.
    pub data: Vec<u8>,
}

/// What comes next in a file.
pub enum Next {
    /// A message.
    Message(Raw),
    /// The end that the writer has written.
    End,
    /// The file ends without one; its writer has not finished it.
    Cut,
}

/// A schema.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SchemaRecord {
    /// Its name.
    pub name: String,
    /// What it is written in.
    pub encoding: String,
    /// The encoded schema.
    pub descriptor: Vec<u8>,
}

/// A topic, and the schema of its messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name of the topic.
    pub topic: String,
    /// The schema; without a name if there is none.
    pub schema: Arc<SchemaRecord>,
    /// What the messages are written in.
    pub encoding: String,
    /// What else is said about the channel.
    pub metadata: BTreeMap<String, String>,
}

/// The channels of a file that are known.
#[derive(Clone, Debug, Default)]
pub struct Declared {
    schemas: HashMap<u16, Arc<SchemaRecord>>,
    channels: BTreeMap<u16, Channel>,
    /// Bytes of the records that declared them.
    size: usize,
}

/// Longest declarations of a file altogether, bytes: read as descriptors, they can take hundreds of times as much.
const LONGEST_DECLARATIONS: usize = 1 << 20;

impl Declared {
    /// Takes a record of `length` bytes if it declares something; the first declaration of a number counts. False if all
    /// declarations are longer than any that are written.
    pub fn take(&mut self, record: Record<'_>, length: usize) -> bool {
        let new = match &record {
            Record::Schema { header, .. } => !self.schemas.contains_key(&header.id),
            Record::Channel(channel) => !self.channels.contains_key(&channel.id),
            _ => false,
        };
        self.size += if new { length } else { 0 };
        if self.size > LONGEST_DECLARATIONS {
            return false;
        }
        match record {
            Record::Schema { header, data } if new => {
                let (name, encoding, descriptor) = (header.name, header.encoding, data.into_owned());
                self.schemas.insert(header.id, Arc::new(SchemaRecord { name, encoding, descriptor }));
            }
            Record::Channel(channel) if new => {
                let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let (topic, encoding, metadata) = (channel.topic, channel.message_encoding, channel.metadata);
                self.channels.insert(channel.id, Channel { topic, schema, encoding, metadata });
            }
            _ => {}
        }
        true
    }

    /// Takes all declarations of `other` that are not known.
    pub fn merge(&mut self, other: &Self) {
        for (id, schema) in &other.schemas {
            self.schemas.entry(*id).or_insert_with(|| schema.clone());
        }
        for (id, channel) in &other.channels {
            self.channels.entry(*id).or_insert_with(|| channel.clone());
        }
    }

    /// The channels by their numbers.
    pub fn channels(&self) -> &BTreeMap<u16, Channel> {
        &self.channels
    }

    /// Numbers of the channels of a topic.
    pub fn of_topic(&self, topic: &str) -> Vec<u16> {
        self.channels.iter().filter(|(_, channel)| channel.topic == topic).map(|(id, _)| *id).collect()
    }
}

/// Reads a file record by record; holds no more than one chunk.
pub struct Stream {
    source: Source,
    /// Place of the last record read.
    position: u64,
    /// Place of the next record.
    next_record: u64,
    records: LinearReader,
    /// Place of the end of the data, once it is reached.
    data_end: Option<u64>,
    /// Whether the writer finished the file, so that nothing may be missing.
    finished: bool,
    library: String,
    declared: Declared,
    /// None if records were passed over.
    check: Option<Check>,
}

/// What is said about declarations beyond that.
const TOO_LONG: &str = "schemas and channels are longer than any that are written";

fn reader() -> LinearReader {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LONGEST as usize);
    LinearReader::new_with_options(options)
}

/// What a record outside the chunks says that cannot be; most have no checksum of their own.
fn impossible(frame: &Frame, content: &[u8]) -> Option<&'static str> {
    let text = "a text is longer than its record";
    match frame.opcode {
        op::HEADER => {
            let first = 4 + u64::from(u32_at(content, 0));
            let second = usize::try_from(first).map_or(u64::MAX, |at| 4 + u64::from(u32_at(content, at)));
            (first + 4 > frame.length || first.saturating_add(second) > frame.length).then_some(text)
        }
        op::MESSAGE_INDEX => {
            let entries = u64::from(u32_at(content, 2));
            (frame.length != 6 + entries || entries % 16 != 0)
                .then_some("an index of messages has not the length that it says")
        }
        op::CHUNK => match Header::read(content) {
            None if 32 + u64::from(u32_at(content, 28)) > frame.length => Some(text),
            None => Some("the compression of a chunk is none that is known"),
            Some(header) => header.impossible().or_else(|| {
                (header.record() != frame.length).then_some("a chunk has not the length that it says")
            }),
        },
        // The writer puts every message into a chunk, whose checksum covers it.
        op::MESSAGE => Some("a message outside the chunks"),
        // Other programs put declarations between the chunks.
        op::SCHEMA | op::CHANNEL | op::ATTACHMENT | op::METADATA | 0x80.. => {
            let chunk = Header::read(content).is_some_and(|header| header.record() == frame.length);
            chunk.then_some("a chunk that says to be something else")
        }
        _ => Some("a record that does not belong here"),
    }
}

impl Stream {
    /// Opens the file `path`, which must begin as MCAP does; `read` counts the bytes read of it.
    pub fn open(path: &Path, read: &Arc<AtomicU64>) -> Result<Self, LogReadError> {
        let source = Source::open(path, Arc::clone(read))?;
        let magic = source.bytes(0, mcap::MAGIC.len() as u64)?;
        Self::begin(source, &magic)
    }

    /// Opens the file `path`, whatever its first bytes are, if a chunk is in it.
    pub fn open_damaged(path: &Path) -> Result<Self, LogReadError> {
        match Self::open(path, &Arc::default()) {
            Err(LogReadError::NotMcap { path }) => {
                let source = Source::open(&path, Arc::default())?;
                match chunk::find(&source, 0)? {
                    Some(_) => Self::begin(source, mcap::MAGIC),
                    None => Err(LogReadError::NotMcap { path }),
                }
            }
            opened => opened,
        }
    }

    fn begin(source: Source, magic: &[u8]) -> Result<Self, LogReadError> {
        let path = source.path();
        if magic.is_empty() {
            return Err(LogReadError::Empty { path: path.to_owned() });
        }
        if !mcap::MAGIC.starts_with(magic) {
            return Err(LogReadError::NotMcap { path: path.to_owned() });
        }
        let begin = magic.len() as u64;
        if magic != mcap::MAGIC {
            return Err(LogReadError::Headless { path: path.to_owned(), position: begin });
        }
        let mut check = Check::default();
        check.bytes(magic);
        Ok(Self {
            finished: ends(&source)?,
            source,
            position: begin,
            next_record: begin,
            records: reader(),
            data_end: None,
            library: String::new(),
            declared: Declared::default(),
            check: Some(check),
        })
    }

    /// Goes on with the record at `place`.
    pub fn move_to(&mut self, place: u64) {
        self.records = reader();
        (self.position, self.next_record, self.data_end, self.check) = (place, place, None, None);
    }

    /// Knows `declared` from now on, as if it had been read.
    pub fn know(&mut self, declared: &Declared) {
        self.declared.merge(declared);
    }

    /// What has been declared so far.
    pub fn declared(&self) -> &Declared {
        &self.declared
    }

    /// The bytes of the file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The program that wrote the file, as the file says.
    pub fn library(&self) -> &str {
        &self.library
    }

    /// Place of the record with the last message, or of the cut, bytes from the beginning.
    pub fn position(&self) -> u64 {
        self.position
    }

    /// Length of the file, bytes.
    pub fn size(&self) -> u64 {
        self.source.size()
    }

    /// Whether the writer finished the file.
    pub fn finished(&self) -> bool {
        self.finished
    }

    /// The channel `number`, if it was declared so far.
    pub fn channel(&self, number: u16) -> Option<&Channel> {
        self.declared.channels.get(&number)
    }

    /// The next item.
    ///
    /// **Errors**: the file cannot be read; a record or a chunk is damaged.
    pub fn next(&mut self) -> Result<Next, LogReadError> {
        loop {
            match self.records.next_event() {
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    let length = data.len();
                    let record = match opcode {
                        op::SCHEMA | op::CHANNEL | op::MESSAGE => mcap::parse_record(opcode, data),
                        _ => Ok(Record::Unknown { opcode, data: data.into() }),
                    };
                    let raw = match record {
                        Ok(Record::Message { header, data }) => Some(Raw {
                            channel: header.channel_id,
                            sequence: header.sequence,
                            times: [header.log_time, header.publish_time],
                            data: data.into_owned(),
                        }),
                        Ok(record) => {
                            if !self.declared.take(record, length) {
                                return Err(
                                    self.damaged("schemas and channels are longer than any that are written")
                                );
                            }
                            None
                        }
                        Err(cause) => {
                            let cause = cause.to_string();
                            return Err(self.damaged(cause));
                        }
                    };
                    if let Some(check) = &mut self.check {
                        check.record(length, raw.as_ref().map(|raw| (raw.channel, raw.times[0])));
                    }
                    if let Some(raw) = raw {
                        return Ok(Next::Message(raw));
                    }
                }
                Some(Err(cause)) => {
                    let cause = cause.to_string();
                    return Err(self.damaged(cause));
                }
                Some(Ok(LinearReadEvent::ReadRequest(_))) | None => {
                    if self.data_end.is_some() {
                        return Ok(Next::End);
                    }
                    if !self.read_record()? {
                        return self.cut();
                    }
                }
            }
        }
    }

    /// No record fits here.
    fn cut(&mut self) -> Result<Next, LogReadError> {
        if self.finished {
            return Err(self.damaged("the file was written to its end, but no record fits here"));
        }
        match chunk::find(&self.source, self.position + 1)? {
            None => Ok(Next::Cut),
            Some(place) => {
                Err(self.damaged(format!("no record fits here, but a chunk follows at byte {place}")))
            }
        }
    }

    /// Reads the next record of the file, a chunk as a whole; false if there is none or only a part of one.
    fn read_record(&mut self) -> Result<bool, LogReadError> {
        self.position = self.next_record;
        let Some(frame) = self.source.frame(self.position)? else { return Ok(false) };
        if frame.opcode == op::DATA_END && frame.length == 4 {
            self.data_end = Some(frame.place);
            return Ok(true);
        }
        if frame.length > LONGEST {
            return Err(self.damaged("a record is longer than any that is written"));
        }
        let content = self.source.bytes(frame.content(), frame.length)?;
        if let Some(cause) = impossible(&frame, &content) {
            return Err(self.damaged(cause));
        }
        if let Some(check) = &mut self.check {
            check.bytes(&frame.bytes());
            check.bytes(&content);
        }
        match frame.opcode {
            op::HEADER => {
                if let Ok(Record::Header(header)) = mcap::parse_record(frame.opcode, &content) {
                    self.library = header.library;
                }
            }
            op::SCHEMA | op::CHANNEL => {
                let record = mcap::parse_record(frame.opcode, &content);
                let record = record.map_err(|cause| self.damaged(cause.to_string()))?;
                self.declare(record, content.len())?;
            }
            op::CHUNK => {
                let header = Header::read(&content).unwrap_or_default();
                if let Some(check) = &mut self.check {
                    check.chunk(&frame, &header);
                }
                self.feed(&header, content)?;
            }
            op::MESSAGE_INDEX => {
                if let Some(check) = &mut self.check {
                    check.message_index(&frame, &content);
                }
            }
            _ => {}
        }
        self.next_record = frame.end();
        Ok(true)
    }

    fn declare(&mut self, record: Record<'_>, length: usize) -> Result<(), LogReadError> {
        let fits = self.declared.take(record, length);
        if fits { Ok(()) } else { Err(self.damaged(TOO_LONG)) }
    }

    /// Gives a chunk to the reader of records.
    fn feed(&mut self, header: &Header, content: Vec<u8>) -> Result<(), LogReadError> {
        let record = chunk::record(header, content).map_err(|cause| self.damaged(cause))?;
        self.records.insert(record.len()).copy_from_slice(&record);
        self.records.notify_read(record.len());
        Ok(())
    }

    /// Compares what was read with the index and the checksums of the file, once the end was reached: what is wrong with
    /// them, if anything is. Nothing is known if records were passed over.
    pub fn conclude(&mut self) -> Result<Option<Flaw>, LogReadError> {
        match (self.check.take(), self.data_end) {
            (Some(check), Some(data_end)) => check.conclude(&self.source, data_end),
            _ => Ok(None),
        }
    }

    /// After damage: reads the record there as what it would be if only its opcode or length were wrong. True if the reader
    /// can go on without a loss.
    pub fn mend(&mut self) -> Result<bool, LogReadError> {
        let place = self.position;
        self.move_to(place);
        let framed = self.source.frame(place)?;
        if let Some(header) = chunk::header(&self.source, place)? {
            let ends = [Some(place + FRAME + header.record()), framed.map(|frame| frame.end())];
            for end in ends.into_iter().flatten() {
                if self.follows(end)? && self.chunk_up_to(place, end, &header)? {
                    self.next_record = end;
                    return Ok(true);
                }
            }
            return Ok(false);
        }
        let content = self.source.bytes(place + FRAME, 6)?;
        let entries = u64::from(u32_at(&content, 2));
        let indexed = (entries % 16 == 0).then_some(place + FRAME + 6 + entries);
        let framed =
            self.source.frame(place)?.filter(|frame| frame.opcode != op::CHUNK).map(|frame| frame.end());
        for end in indexed.into_iter().chain(framed) {
            if self.follows(end)? {
                self.next_record = end;
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Gives the chunk between `place` and `end` to the reader of records, if its checksum fits.
    fn chunk_up_to(&mut self, place: u64, end: u64, header: &Header) -> Result<bool, LogReadError> {
        let length = end - place - FRAME;
        // Twice, because the reader must be asked for a record to compare the checksum.
        for asked in [true, false] {
            self.move_to(place);
            let mut content = self.source.bytes(place + FRAME, length)?;
            let Some(header) = header.clone().of_length(length, &mut content) else { return Ok(false) };
            if header.impossible().is_some() || self.feed(&header, content).is_err() {
                return Ok(false);
            }
            if asked && !matches!(self.records.next_event(), Some(Ok(LinearReadEvent::Record { .. }))) {
                self.move_to(place);
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a record that the writer puts between or behind chunks is at `place`.
    fn follows(&self, place: u64) -> Result<bool, LogReadError> {
        let Some(frame) = self.source.frame(place)? else { return Ok(false) };
        Ok(match frame.opcode {
            op::CHUNK => {
                let header = Header::read(&self.source.bytes(frame.content(), chunk::LONGEST_HEADER)?);
                header.is_some_and(|header| header.record() == frame.length)
            }
            op::MESSAGE_INDEX => frame.length == 6 + u64::from(u32_at(&frame.first, 2)),
            op::DATA_END => frame.length == 4,
            _ => false,
        })
    }

    /// After damage that cannot be mended: continues behind it, and returns the place; none if nothing follows.
    pub fn pass(&mut self) -> Result<Option<u64>, LogReadError> {
        let place = self.position;
        self.move_to(place);
        if let Some(frame) = self.source.frame(place)?
            && frame.opcode == op::CHUNK
            && self.follows(place)?
            && self.follows(frame.end())?
        {
            self.next_record = frame.end();
            return Ok(Some(frame.end()));
        }
        if let Some(next) = chunk::find(&self.source, place + 1)? {
            self.next_record = next;
            return Ok(Some(next));
        }
        let footer = self.source.size().saturating_sub(mcap::MAGIC.len() as u64 + super::check::FOOTER);
        let start = self.source.frame(footer)?.map_or(0, |frame| u64_at(&frame.first, 0));
        let data_end = start.checked_sub(FRAME + 4).filter(|end| *end >= place);
        if let Some(end) = data_end.filter(|_| self.finished) {
            self.next_record = end;
        }
        Ok(data_end.filter(|_| self.finished))
    }

    fn damaged(&self, cause: impl Into<String>) -> LogReadError {
        self.source.damaged(self.position, cause)
    }
}
