//! The messages of an MCAP file in the order in which they were written, up to the end or the cut of the file.

use super::LogReadError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A message as stored in the file.
pub struct Raw {
    /// Number of its channel.
    pub channel: u16,
    /// Sequence number.
    pub sequence: u32,
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

/// A topic, and the schema of its messages.
pub struct Channel {
    /// Name of the topic.
    pub topic: String,
    /// Name of the schema.
    pub schema: String,
    /// The encoded schema.
    pub descriptor: Vec<u8>,
}

/// Reads a file record by record; holds no more than one chunk.
pub struct Stream {
    path: PathBuf,
    file: BufReader<File>,
    size: u64,
    /// Place of the last record read.
    position: u64,
    /// Place of the next record.
    next_record: u64,
    records: LinearReader,
    waiting: VecDeque<Raw>,
    ended: bool,
    /// Whether the writer finished the file, so that nothing may be missing.
    finished: bool,
    library: String,
    schemas: HashMap<u16, (String, Vec<u8>)>,
    channels: HashMap<u16, Channel>,
}

/// Opcode and length of a record.
const FRAME: u64 = 9;
/// Longest record and chunk, bytes; a longer one has a damaged length.
const LONGEST: usize = 1 << 28;

/// Largest ratio of a chunk's content to its compressed bytes: that of LZ4.
const MOST_COMPRESSED: u64 = 255;

/// What a record outside the chunks says that cannot be, or would take memory without end to read: no checksum covers it.
fn impossible(opcode: u8, record: &[u8]) -> Option<&'static str> {
    // A chunk: first and last time, size of its content, checksum, name of its compression.
    let (strings, count) = match opcode {
        op::HEADER => (0, 2),
        op::CHUNK => (28, 1),
        _ => return None,
    };
    let mut place = strings;
    for _ in 0..count {
        let length = record.get(place..place + 4).and_then(|bytes| bytes.try_into().ok());
        place = length.map_or(usize::MAX, |length| place + 4 + u32::from_le_bytes(length) as usize);
        if place > record.len() {
            return Some("a text is longer than its record");
        }
    }
    if opcode == op::CHUNK {
        let size = record[16..24].try_into().map_or(u64::MAX, u64::from_le_bytes);
        if size > LONGEST as u64 || size > MOST_COMPRESSED * record.len() as u64 {
            return Some("a chunk says that it holds more than it can");
        }
        if record[24..28] == [0; 4] {
            return Some("a chunk has no checksum");
        }
    }
    None
}

impl Stream {
    /// Opens the file `path`, which must begin as MCAP does.
    pub fn open(path: &Path) -> Result<Self, LogReadError> {
        let failed = |cause| LogReadError::Open { path: path.to_owned(), cause };
        // Checked before opening, because opening a pipe waits for a writer.
        let metadata = std::fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            return Err(LogReadError::Irregular { path: path.to_owned() });
        }
        let (size, length) = (metadata.len(), mcap::MAGIC.len() as u64);
        let mut file = BufReader::with_capacity(1 << 16, File::open(path).map_err(failed)?);
        let mut magic = |place| {
            let mut magic = Vec::new();
            file.seek(SeekFrom::Start(place))?;
            file.by_ref().take(length).read_to_end(&mut magic).map(|_| magic)
        };
        let finished = size >= 2 * length && magic(size - length).map_err(failed)? == mcap::MAGIC;
        let magic = magic(0).map_err(failed)?;
        if magic.is_empty() {
            return Err(LogReadError::Empty { path: path.to_owned() });
        }
        if !mcap::MAGIC.starts_with(&magic) {
            return Err(LogReadError::NotMcap { path: path.to_owned() });
        }
        if magic != mcap::MAGIC {
            return Err(LogReadError::Headless { path: path.to_owned(), position: magic.len() as u64 });
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST);
        Ok(Self {
            path: path.to_owned(),
            file,
            size,
            position: magic.len() as u64,
            next_record: magic.len() as u64,
            records: LinearReader::new_with_options(options),
            waiting: VecDeque::new(),
            ended: false,
            finished,
            library: String::new(),
            schemas: HashMap::new(),
            channels: HashMap::new(),
        })
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
        self.size
    }

    /// Whether the writer finished the file.
    pub fn finished(&self) -> bool {
        self.finished
    }

    /// The channel `number`, if it was declared so far.
    pub fn channel(&self, number: u16) -> Option<&Channel> {
        self.channels.get(&number)
    }

    /// The next item.
    ///
    /// **Errors**: the file cannot be read; a record or a chunk is damaged.
    pub fn next(&mut self) -> Result<Next, LogReadError> {
        loop {
            if let Some(message) = self.waiting.pop_front() {
                return Ok(Next::Message(message));
            }
            if self.ended {
                return Ok(Next::End);
            }
            if !self.read_record()? {
                if self.finished {
                    return Err(self.damaged("the file was written to its end, but no record fits here"));
                }
                return Ok(Next::Cut);
            }
        }
    }

    /// Reads the next record of the file, a chunk as a whole; false if there is none or only a part of one.
    fn read_record(&mut self) -> Result<bool, LogReadError> {
        self.position = self.next_record;
        let remaining = self.size.saturating_sub(self.next_record);
        if remaining < FRAME {
            return Ok(false);
        }
        let mut frame = [0; FRAME as usize];
        self.read_exactly(&mut frame)?;
        let [opcode, length @ ..] = frame;
        let length = u64::from_le_bytes(length);
        // A chunk that was not finished has no length; a crash may leave zeros.
        if opcode == 0 || length > remaining - FRAME {
            return Ok(false);
        }
        // The writer puts every message into a chunk, whose checksum covers it.
        if matches!(opcode, op::MESSAGE | op::SCHEMA | op::CHANNEL) {
            return Err(self.damaged("a message, schema or channel outside the chunks"));
        }
        if opcode == op::DATA_END {
            self.ended = true;
            return Ok(true);
        }
        let length = usize::try_from(length).ok().filter(|l| *l <= LONGEST);
        let length = length.ok_or_else(|| self.damaged("a record is longer than any that is written"))?;
        let buffer = self.records.insert(frame.len() + length);
        buffer[..frame.len()].copy_from_slice(&frame);
        let read = self.file.read_exact(&mut buffer[frame.len()..]);
        let impossible = impossible(opcode, &buffer[frame.len()..]);
        read.map_err(|cause| self.unreadable(cause))?;
        if let Some(cause) = impossible {
            return Err(self.damaged(cause));
        }
        self.records.notify_read(frame.len() + length);
        while let Some(event) = self.records.next_event() {
            let record = match event {
                Ok(LinearReadEvent::Record { data, opcode }) => match opcode {
                    op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE => mcap::parse_record(opcode, data),
                    _ => continue,
                },
                Ok(LinearReadEvent::ReadRequest(_)) => break,
                Err(cause) => Err(cause),
            };
            match record {
                Ok(Record::Header(header)) => self.library = header.library,
                Ok(Record::Schema { header, data }) => {
                    self.schemas.entry(header.id).or_insert((header.name, data.into_owned()));
                }
                Ok(Record::Channel(channel)) => {
                    let (schema, descriptor) =
                        self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    let channel_of = Channel { topic: channel.topic, schema, descriptor };
                    self.channels.entry(channel.id).or_insert(channel_of);
                }
                Ok(Record::Message { header, data }) => self.waiting.push_back(Raw {
                    channel: header.channel_id,
                    sequence: header.sequence,
                    data: data.into_owned(),
                }),
                Ok(_) => {}
                Err(cause) => {
                    let cause = cause.to_string();
                    return Err(self.damaged(&cause));
                }
            }
        }
        self.next_record += FRAME + length as u64;
        Ok(true)
    }

    fn read_exactly(&mut self, buffer: &mut [u8]) -> Result<(), LogReadError> {
        self.file.read_exact(buffer).map_err(|cause| self.unreadable(cause))
    }

    fn unreadable(&self, cause: std::io::Error) -> LogReadError {
        LogReadError::Read { path: self.path.clone(), position: self.position, cause }
    }

    fn damaged(&self, cause: &str) -> LogReadError {
        LogReadError::Damaged { path: self.path.clone(), position: self.position, cause: cause.to_owned() }
    }
}
