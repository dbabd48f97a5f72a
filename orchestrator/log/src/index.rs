//! Where the chunks of a file are, without reading them.

use super::LogReadError;
use super::check::{FOOTER, chunk_indices, ends, split};
use super::chunk;
use super::source::{LONGEST, Source, u32_at, u64_at};
use super::stream::Declared;
use mcap::records::op;

/// The chunks of a file, by its summary or, if it has none, by the frames of its records.
#[derive(Debug, Default)]
pub struct Index {
    /// The chunks in the order of the file.
    pub chunks: Vec<Chunk>,
    /// The channels that the summary lists.
    pub declared: Declared,
}

/// A chunk of a file.
#[derive(Debug)]
pub struct Chunk {
    /// Place of its record.
    pub place: u64,
    /// Channels with messages in it; none if that is not known.
    pub channels: Option<Vec<u16>>,
}

impl Chunk {
    /// Whether one of `channels` may have a message in it.
    pub fn may_have(&self, channels: &[u16]) -> bool {
        self.channels.as_ref().is_none_or(|own| own.iter().any(|channel| channels.contains(channel)))
    }
}

impl Index {
    /// Reads the summary of a finished file, else the frames up to the first record that does not fit.
    pub fn read(source: &Source) -> Result<Self, LogReadError> {
        match Self::of_summary(source)? {
            Some(index) => Ok(index),
            None => Self::of_frames(source),
        }
    }

    /// What the summary says, if there is one and its checksum fits.
    pub fn of_summary(source: &Source) -> Result<Option<Self>, LogReadError> {
        let magic = mcap::MAGIC.len() as u64;
        let Some(footer) = source.size().checked_sub(magic + FOOTER).filter(|place| *place >= magic) else {
            return Ok(None);
        };
        let frame = source.frame(footer)?.filter(|frame| frame.opcode == op::FOOTER && frame.length == 20);
        let Some(frame) = frame else { return Ok(None) };
        let [start, checksum] = [u64_at(&frame.first, 0), u64::from(u32_at(&frame.first, 16))];
        if !ends(source)? || start < magic || start > footer || footer - start > LONGEST || checksum == 0 {
            return Ok(None);
        }
        let bytes = source.bytes(start, footer + FOOTER - 4 - start)?;
        if u64::from(crc32fast::hash(&bytes)) != checksum {
            return Ok(None);
        }
        let summary = &bytes[..(footer - start) as usize];
        let mut index = Self::default();
        for (opcode, content) in
            split(summary).filter(|(opcode, _)| matches!(*opcode, op::SCHEMA | op::CHANNEL))
        {
            let declared = mcap::parse_record(opcode, content);
            if !declared.is_ok_and(|record| index.declared.take(record, content.len())) {
                return Ok(None);
            }
        }
        let indices = chunk_indices(summary);
        // One that lists channels nowhere was written without them.
        let listed = indices.iter().any(|chunk| !chunk.message_index_offsets.is_empty());
        index.chunks.extend(indices.into_iter().map(|chunk| Chunk {
            place: chunk.chunk_start_offset,
            channels: listed.then(|| chunk.message_index_offsets.into_keys().collect()),
        }));
        let inside = index.chunks.iter().all(|chunk| (magic..start).contains(&chunk.place));
        Ok((inside && !index.chunks.is_empty()).then_some(index))
    }

    /// What the frames say: a chunk's own, and those of the indices of messages behind it.
    fn of_frames(source: &Source) -> Result<Self, LogReadError> {
        let mut index = Self::default();
        let mut place = mcap::MAGIC.len() as u64;
        while let Some(frame) = source.frame(place)? {
            match frame.opcode {
                op::CHUNK => {
                    let fits = chunk::header(source, place)?.filter(|header| header.record() == frame.length);
                    if fits.is_none() {
                        break;
                    }
                    index.chunks.push(Chunk { place, channels: None });
                }
                op::MESSAGE_INDEX => {
                    let channel = u16::from_le_bytes([frame.first[0], frame.first[1]]);
                    if let Some(chunk) = index.chunks.last_mut() {
                        chunk.channels.get_or_insert_default().push(channel);
                    }
                }
                op::DATA_END => break,
                _ => {}
            }
            place = frame.end();
        }
        // A chunk at the end of a file that was cut off may have lost some of its indices.
        if let Some(last) = index.chunks.last_mut() {
            last.channels = None;
        }
        Ok(index)
    }
}
