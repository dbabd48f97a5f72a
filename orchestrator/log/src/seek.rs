//! Finds a step, a time or a message in a log without reading what lies before it.

use super::LogReadError;
use super::entry::Entry;
use super::index::{Chunk, Index};
use super::reader::{Entries, Log};
use super::source::Source;
use super::stream::{Next, Stream};
use super::topic::{Part, Topic};
use cofferdam_coupling::participant::{Message, Occasion};
use std::collections::HashMap;
use std::collections::hash_map::Entry::{Occupied, Vacant};
use std::sync::Arc;

/// Steps by which the place of a chunk is guessed from the numbers at both ends; afterwards halves are taken.
const GUESSES: usize = 4;

impl Log {
    /// The entries from the first exchange of the window that `step` belongs to, without reading what lies before.
    ///
    /// Where steps were started again in other lengths, it begins with the first attempt. Where the run did not come as far,
    /// only its end follows.
    pub fn entries_from(&self, step: u64) -> Result<Entries, LogReadError> {
        let first = self.first_of_window(step);
        let finder = Finder::new(self)?;
        let chunk = finder.first_chunk(|occasion| occasion.step, first)?;
        // The window may begin at the end of the chunk before.
        finder.entries(chunk.saturating_sub(1), Some(first))
    }

    /// The same for the step that `time` (s) lies in; one that begins at `time` counts.
    pub fn entries_at(&self, time: f64) -> Result<Entries, LogReadError> {
        let finder = Finder::new(self)?;
        // Times order as their bits do, because none is negative.
        let after = |occasion: &Occasion| occasion.time.max(0.0).to_bits();
        let chunk = finder.first_chunk(after, time.max(0.0).next_up().to_bits())?;
        // The last exchange before is in a chunk that has one.
        let mut step = 0;
        for before in (0..chunk).rev() {
            if let Some(found) = finder.key(before, before + 1, |occasion| occasion.step)? {
                step = found;
                break;
            }
        }
        for entry in self.entries_from(step)? {
            if let Entry::Exchange(exchange) = entry? {
                step = exchange.occasion.step;
                if exchange.occasion.end() > time {
                    break;
                }
            }
        }
        self.entries_from(step)
    }

    /// The last entry of `topic` (such as `/step`) that belongs to `step` or to one before it, without reading other chunks
    /// than those that have messages of the topic.
    pub fn last_before(&self, topic: &str, step: u64) -> Result<Option<Entry>, LogReadError> {
        let finder = Finder::new(self)?;
        let channels = finder.stream()?.declared().of_topic(topic);
        let next = self.first_of_window(step).saturating_add(self.head().window);
        // What follows the last exchange of the window may stand at the beginning of the next chunk.
        let chunk = finder.first_chunk(|occasion| occasion.step, next)?;
        let chunks = finder.index.chunks.iter().take(chunk + 1).rev();
        for chunk in chunks.filter(|chunk| chunk.may_have(&channels)) {
            let mut found = None;
            finder.each(chunk, &channels, |part| {
                if let Part::Entry(entry) = part
                    && entry.step().is_some_and(|own| own <= step)
                {
                    found = Some(entry);
                }
                true
            })?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    /// What the units said, in its order, without reading chunks that hold none of it.
    ///
    /// **Errors**: those of reading; a log that is cut short gives what it holds whole.
    pub fn messages(&self) -> Result<Vec<Message>, LogReadError> {
        let finder = Finder::new(self)?;
        let channels = finder.stream()?.declared().of_topic("/log");
        let mut found = Vec::new();
        for chunk in finder.index.chunks.iter().filter(|chunk| chunk.may_have(&channels)) {
            finder.each(chunk, &channels, |part| {
                if let Part::Entry(Entry::Message(message)) = part {
                    found.push(message);
                }
                true
            })?;
        }
        Ok(found)
    }

    /// First step of the window of `step`, 0 for initialisation; windows are whole multiples of their length.
    pub fn first_of_window(&self, step: u64) -> u64 {
        let window = self.head().window;
        step.checked_sub(1).map_or(0, |before| step - before % window)
    }
}

/// Reads chunks of a log by their places.
struct Finder<'a> {
    log: &'a Log,
    index: Index,
}

impl<'a> Finder<'a> {
    fn new(log: &'a Log) -> Result<Self, LogReadError> {
        let source = Source::open(log.path(), Arc::clone(&log.read))?;
        let mut finder = Self { log, index: Index::read(&source)? };
        finder.declare()?;
        Ok(finder)
    }

    /// Declares the channels of a file without a summary whose writer declared them just before their first message.
    fn declare(&mut self) -> Result<(), LogReadError> {
        let mut known = self.stream()?;
        for chunk in &self.index.chunks {
            let unknown = |channel: &u16| known.channel(*channel).is_none();
            if chunk.channels.iter().flatten().any(unknown) {
                known.move_to(chunk.place);
                // A damaged chunk declares what stands before the damage.
                while let Ok(Next::Message(_)) = known.next()
                    && known.position() == chunk.place
                {}
            }
        }
        self.index.declared = known.declared().clone();
        Ok(())
    }

    fn stream(&self) -> Result<Stream, LogReadError> {
        let mut stream = Stream::open(self.log.path(), &self.log.read)?;
        stream.know(&self.log.declared);
        stream.know(&self.index.declared);
        Ok(stream)
    }

    /// The entries from chunk number `chunk` on and, if asked for, from the first request in a step.
    fn entries(&self, chunk: usize, step: Option<u64>) -> Result<Entries, LogReadError> {
        let mut entries = self.log.entries()?;
        if let Some(chunk) = self.index.chunks.get(chunk) {
            entries.stream = self.stream()?;
            entries.stream.move_to(chunk.place);
            entries.skipping = step;
        }
        Ok(entries)
    }

    /// Gives what the messages of `channels` in a chunk contain to `take`, until it returns false.
    fn each(
        &self,
        chunk: &Chunk,
        channels: &[u16],
        mut take: impl FnMut(Part) -> bool,
    ) -> Result<(), LogReadError> {
        let mut stream = self.stream()?;
        stream.move_to(chunk.place);
        let mut topics: HashMap<u16, Topic> = HashMap::new();
        let units = &self.log.head().units;
        loop {
            let Next::Message(raw) = stream.next()? else { return Ok(()) };
            if stream.position() != chunk.place {
                return Ok(());
            }
            if !channels.contains(&raw.channel) {
                continue;
            }
            let Some(channel) = stream.channel(raw.channel) else { continue };
            let mismatch = |mismatch| LogReadError::Topic {
                path: self.log.path().to_owned(),
                position: chunk.place,
                topic: channel.topic.clone(),
                mismatch,
            };
            let topic = match topics.entry(raw.channel) {
                Occupied(known) => known.into_mut(),
                Vacant(new) => new.insert(Topic::of(channel, units).map_err(mismatch)?),
            };
            if !take(topic.read(&raw, units).map_err(mismatch)?) {
                return Ok(());
            }
        }
    }

    /// The first chunk whose first exchange has a `key` of `least` or more; keys never decrease from window to window.
    fn first_chunk(&self, key: impl Fn(&Occasion) -> u64, least: u64) -> Result<usize, LogReadError> {
        let (mut low, mut high) = (0, self.index.chunks.len());
        // Keys of the chunk before `low`, and of `high`.
        let (mut below, mut above) = (0, None);
        let mut guesses = 0;
        while low < high {
            let middle = match above {
                // The last chunk tells how far the run came.
                None if guesses == 0 => high - 1,
                Some(above) if guesses <= GUESSES && above > below => {
                    let share = (least.saturating_sub(below)) as f64 / (above - below) as f64;
                    (low + (share * (high - low) as f64) as usize).clamp(low, high - 1)
                }
                _ => low + (high - low) / 2,
            };
            guesses += 1;
            match self.key(middle, high, &key)? {
                Some(found) if found >= least => (high, above) = (middle, Some(found)),
                Some(found) => (low, below) = (middle + 1, found),
                // Nothing but other messages up to `high`.
                None => high = middle,
            }
        }
        Ok(low)
    }

    /// The key of the first exchange in chunk number `chunk`, or in one after it before number `end`.
    fn key(
        &self,
        chunk: usize,
        end: usize,
        key: impl Fn(&Occasion) -> u64,
    ) -> Result<Option<u64>, LogReadError> {
        let stream = self.stream()?;
        let of_steps =
            |topic: &str| topic == "/step" || topic.ends_with("/request") || topic.ends_with("/answer");
        let channels = stream.declared().channels().iter().filter(|(_, channel)| of_steps(&channel.topic));
        let channels: Vec<u16> = channels.map(|(id, _)| *id).collect();
        for chunk in self.index.chunks[chunk..end].iter().filter(|chunk| chunk.may_have(&channels)) {
            let mut found = None;
            self.each(chunk, &channels, |part| {
                found = match part {
                    Part::Request(exchange) | Part::Answer(exchange) => Some(key(&exchange.occasion)),
                    Part::Entry(Entry::Step(step)) => Some(key(&step.occasion)),
                    _ => None,
                };
                found.is_none()
            })?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }
}
