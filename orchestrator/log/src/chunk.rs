//! What the header of a chunk says, and whether it can be.

use super::LogReadError;
use super::source::{FRAME, Frame, LONGEST, Source, u32_at, u64_at};
use mcap::records::op;
use ruzstd::decoding::FrameDecoder;

/// The header of a chunk; no checksum covers it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Least and largest log time of its messages, ns.
    pub times: [u64; 2],
    /// Bytes of its content.
    pub size: u64,
    /// Their checksum; 0 if there is none.
    pub checksum: u32,
    /// Name of the compression.
    pub compression: Vec<u8>,
    /// Bytes of the compressed content.
    pub compressed: u64,
}

/// Fields before the name of the compression, and the lengths before and after it.
const FIXED: u64 = 28 + 4 + 8;
/// Longest header: the names of compressions have four letters.
pub const LONGEST_HEADER: u64 = FIXED + 4;
/// Largest ratio of a chunk's content to its compressed bytes: that of LZ4; Zstandard has none.
const MOST_COMPRESSED: u64 = 255;

impl Header {
    /// Reads the header at the beginning of `content`; none if no chunk begins like that.
    pub fn read(content: &[u8]) -> Option<Self> {
        let name = u32_at(content, 28) as usize;
        let compression = content.get(32..32 + name.min(5))?.to_vec();
        let end = content.get(32 + compression.len()..40 + compression.len())?;
        matches!(&*compression, b"" | b"lz4" | b"zstd").then(|| Self {
            times: [u64_at(content, 0), u64_at(content, 8)],
            size: u64_at(content, 16),
            checksum: u32_at(content, 24),
            compressed: u64_at(end, 0),
            compression,
        })
    }

    /// Length of the record that it says.
    pub fn record(&self) -> u64 {
        (FIXED + self.compression.len() as u64).saturating_add(self.compressed)
    }

    /// The chunk in a record whose content has `length` bytes, with that length in its header.
    pub fn of_length(mut self, length: u64, content: &mut [u8]) -> Option<Self> {
        let name = self.compression.len();
        self.compressed = length.checked_sub(FIXED + name as u64)?;
        content.get_mut(32 + name..40 + name)?.copy_from_slice(&self.compressed.to_le_bytes());
        Some(self)
    }

    /// What it says that cannot be, or would take memory without end.
    pub fn impossible(&self) -> Option<&'static str> {
        let ratio = match &*self.compression {
            b"" => 1,
            b"lz4" => MOST_COMPRESSED,
            _ => LONGEST,
        };
        if self.size > LONGEST || self.size > ratio.saturating_mul(self.compressed) {
            return Some("a chunk says that it holds more than it can");
        }
        (self.checksum == 0 && self.size > 0).then_some("a chunk has no checksum")
    }
}

/// The record of a chunk as it is in the file, or without the compression that the reader of records does not know.
///
/// **Errors**: what is wrong with it.
pub fn record(header: &Header, mut content: Vec<u8>) -> Result<Vec<u8>, String> {
    if header.compression == b"zstd" {
        let compressed = content.split_off(FIXED as usize + 4);
        content.truncate(28);
        content.extend_from_slice(&0_u32.to_le_bytes());
        content.extend_from_slice(&header.size.to_le_bytes());
        let begin = content.len();
        content.resize(begin + header.size as usize, 0);
        let written = FrameDecoder::new().decode_all(&compressed, &mut content[begin..]);
        if written.map_err(|cause| cause.to_string())? as u64 != header.size {
            return Err("a chunk holds less than it says".to_owned());
        }
    }
    let length = content.len() as u64;
    let frame = Frame { place: 0, opcode: op::CHUNK, length, first: [0; 28] }.bytes();
    content.splice(0..0, frame);
    Ok(content)
}

/// The header of a chunk at `place`, whatever its opcode and its length are: none if what stands there is no chunk.
pub fn header(source: &Source, place: u64) -> Result<Option<Header>, LogReadError> {
    let content = source.bytes(place + FRAME, LONGEST_HEADER)?;
    let fits = |h: &Header| {
        h.impossible().is_none()
            && h.times[0] <= h.times[1]
            && h.record() <= source.size().saturating_sub(place + FRAME)
    };
    Ok(Header::read(&content).filter(fits))
}

/// Place of the first chunk in the bytes from `from` on, found by the structure of its header: both lengths agree.
pub fn find(source: &Source, from: u64) -> Result<Option<u64>, LogReadError> {
    const BLOCK: u64 = 1 << 20;
    let reach = FRAME + LONGEST_HEADER;
    let mut block = from;
    while block < source.size() {
        let bytes = source.bytes(block, BLOCK + reach)?;
        for index in (0..bytes.len().min(BLOCK as usize)).filter(|i| bytes[*i] == op::CHUNK) {
            let content = bytes.get(index + FRAME as usize..).unwrap_or_default();
            let (place, length) = (block + index as u64, u64_at(&bytes, index + 1));
            let believable = |h: Header| {
                h.record() == length
                    && h.impossible().is_none()
                    && length <= source.size().saturating_sub(place + FRAME)
            };
            if Header::read(content).is_some_and(believable) {
                return Ok(Some(place));
            }
        }
        block += BLOCK;
    }
    Ok(None)
}
