//! Whether the index and the checksums of a file agree with its messages, found out while these are read.

use super::LogReadError;
use super::chunk::Header;
use super::source::{FRAME, Frame, LONGEST, Source, u32_at, u64_at};
use mcap::records::{self, Record, op};
use std::collections::BTreeMap;

/// What a file's index must say, by the records read from its beginning on.
#[derive(Default)]
pub struct Check {
    /// Of all bytes up to the end of the data.
    checksum: crc32fast::Hasher,
    chunks: Vec<records::ChunkIndex>,
    /// Log times and places of the messages of the last chunk by channel, until they are found in an index.
    messages: BTreeMap<u16, Vec<(u64, u64)>>,
    /// Place of the next record in that chunk.
    inside: u64,
    flaw: Option<Flaw>,
}

/// Where an index is wrong, and what is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flaw {
    /// Bytes from the beginning of the file.
    pub place: u64,
    /// What is wrong.
    pub cause: String,
}

/// Length of the record at the end of the data.
const DATA_END: u64 = FRAME + 4;
/// Length of the footer.
pub const FOOTER: u64 = FRAME + 20;

impl Check {
    /// Takes bytes of the file in their order.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.checksum.update(bytes);
    }

    /// A chunk begins.
    pub fn chunk(&mut self, frame: &Frame, header: &Header) {
        self.indexed(frame.place);
        self.messages.clear();
        self.inside = 0;
        self.chunks.push(records::ChunkIndex {
            message_start_time: header.times[0],
            message_end_time: header.times[1],
            chunk_start_offset: frame.place,
            chunk_length: FRAME + frame.length,
            message_index_offsets: BTreeMap::new(),
            message_index_length: 0,
            compression: String::from_utf8_lossy(&header.compression).into_owned(),
            compressed_size: header.compressed,
            uncompressed_size: header.size,
        });
    }

    /// A record in the chunk; of a message, its channel and log time.
    pub fn record(&mut self, length: usize, message: Option<(u16, u64)>) {
        if let Some((channel, time)) = message {
            self.messages.entry(channel).or_default().push((time, self.inside));
        }
        self.inside += FRAME + length as u64;
    }

    /// The index of the messages of a channel in the last chunk.
    pub fn message_index(&mut self, frame: &Frame, content: &[u8]) {
        let channel = u16::from_le_bytes([frame.first[0], frame.first[1]]);
        let entry = |bytes: &[u8]| (u64_at(bytes, 0), u64_at(bytes, 8));
        let mut found: Vec<_> = content.get(6..).unwrap_or_default().chunks(16).map(entry).collect();
        let mut expected = self.messages.remove(&channel).unwrap_or_default();
        found.sort_unstable();
        expected.sort_unstable();
        if found != expected {
            self.note(frame.place, format!("the messages of channel {channel} are not where it says"));
        }
        if let Some(chunk) = self.chunks.last_mut() {
            chunk.message_index_offsets.insert(channel, frame.place);
            chunk.message_index_length += FRAME + frame.length;
        }
    }

    /// The indices of the last chunk are complete.
    fn indexed(&mut self, place: u64) {
        let some = self.chunks.last().is_some_and(|chunk| !chunk.message_index_offsets.is_empty());
        if some && let Some(channel) = self.messages.keys().next() {
            self.note(place, format!("the messages of channel {channel} before this place have none"));
        }
    }

    fn note(&mut self, place: u64, cause: String) {
        self.flaw.get_or_insert(Flaw { place, cause });
    }

    /// Compares with the summary, once the data have been read up to their end at `data_end`: the first flaw of all.
    pub fn conclude(mut self, source: &Source, data_end: u64) -> Result<Option<Flaw>, LogReadError> {
        self.indexed(data_end);
        let summary = data_end + DATA_END;
        let end = source.size().saturating_sub(mcap::MAGIC.len() as u64);
        let Some(footer) = end.checked_sub(FOOTER).filter(|place| *place >= summary) else {
            // Cut off behind the last message: nothing says that more was written.
            return Ok(self.flaw);
        };
        if let Err(flaw) = self.agrees(source, [data_end, summary, footer])? {
            self.note(flaw.place, flaw.cause);
        }
        Ok(self.flaw)
    }

    /// Compares the end of the data, the summary and the footer, which are at these places.
    fn agrees(
        &self,
        source: &Source,
        [data_end, summary, footer]: [u64; 3],
    ) -> Result<Result<(), Flaw>, LogReadError> {
        let flaw = |place, cause: &str| Ok(Err(Flaw { place, cause: cause.to_owned() }));
        let frame = source.frame(footer)?;
        let Some(frame) = frame.filter(|f| f.opcode == op::FOOTER && FRAME + f.length == FOOTER) else {
            return match unfinished(source, summary)? {
                true => Ok(Ok(())),
                false => flaw(footer, "this should be the footer"),
            };
        };
        if source.bytes(footer + FOOTER, mcap::MAGIC.len() as u64)? != mcap::MAGIC {
            return flaw(footer + FOOTER, "the file does not end as MCAP does");
        }
        if footer - summary > LONGEST {
            return flaw(summary, "the summary is longer than any that is written");
        }
        let [start, checksum] = [u64_at(&frame.first, 0), u64::from(u32_at(&frame.first, 16))];
        if start != summary && (start != 0 || footer != summary) {
            return flaw(footer, "the footer does not say where the summary begins");
        }
        let bytes = source.bytes(summary, footer + FOOTER - 4 - summary)?;
        if checksum != 0 && u64::from(crc32fast::hash(&bytes)) != checksum {
            return flaw(summary, "the checksum of the summary, which ends the file, does not fit");
        }
        let chunks = chunk_indices(&bytes[..(footer - summary) as usize]);
        for (index, found) in chunks.iter().enumerate() {
            if self.chunks.get(index) != Some(found) {
                let cause = format!("the summary does not say what the chunk {} is", index + 1);
                return Ok(Err(Flaw { place: summary, cause }));
            }
        }
        if !chunks.is_empty() && chunks.len() != self.chunks.len() {
            return flaw(summary, "the summary does not list all chunks");
        }
        let checksum = u32_at(&source.bytes(data_end + FRAME, 4)?, 0);
        if checksum != 0 && self.checksum.clone().finalize() != checksum {
            return flaw(
                data_end,
                "the checksum of the data does not fit, though all messages are whole: a byte outside them was changed",
            );
        }
        Ok(Ok(()))
    }
}

/// Whether the file ends before its footer is complete.
fn unfinished(source: &Source, summary: u64) -> Result<bool, LogReadError> {
    if ends(source)? {
        return Ok(false);
    }
    let mut place = summary;
    while let Some(frame) = source.frame(place)? {
        if frame.opcode == op::FOOTER {
            return Ok(source.size() < frame.end() + mcap::MAGIC.len() as u64);
        }
        place = frame.end();
    }
    Ok(true)
}

/// Whether the file ends with the mark of a finished one.
pub fn ends(source: &Source) -> Result<bool, LogReadError> {
    let length = mcap::MAGIC.len() as u64;
    let last = source.size().checked_sub(length).filter(|place| *place >= length);
    last.map_or(Ok(false), |place| Ok(source.bytes(place, length)? == mcap::MAGIC))
}

/// The indices of chunks among the records of a summary, in the order of the file.
pub fn chunk_indices(summary: &[u8]) -> Vec<records::ChunkIndex> {
    let index = |(opcode, content): (u8, &[u8])| match mcap::parse_record(opcode, content) {
        Ok(Record::ChunkIndex(index)) if opcode == op::CHUNK_INDEX => Some(index),
        _ => None,
    };
    let mut chunks: Vec<_> = split(summary).filter_map(index).collect();
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    chunks
}

/// Opcodes and contents of the records in `bytes`, up to the first that does not fit.
pub fn split(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let opcode = *rest.first()?;
        let end = usize::try_from(u64_at(rest, 1)).ok()?.checked_add(FRAME as usize)?;
        let content = rest.get(FRAME as usize..end)?;
        rest = &rest[end..];
        Some((opcode, content))
    })
}
