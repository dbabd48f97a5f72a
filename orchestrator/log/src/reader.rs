//! Reads the log of a run as typed entries in the order of the file, values bit for bit.

use super::LogReadError;
use super::content::LoggedExchanges;
use super::decode::Mismatch;
use super::entry::{Entry, LoggedDamage, LoggedExchange};
use super::head::Head;
use super::stream::{Declared, Next, Raw, Stream};
use super::topic::{Part, Topic};
use std::collections::{BTreeMap, HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The log of a run, complete or cut short.
///
/// ```no_run
/// # use cofferdam_log::{Entry, Log, LogReadError};
/// let log = Log::open("runs/koyna/log.mcap".as_ref())?;
/// println!("{}", log.head().scene_text);
/// for entry in log.entries()? {
///     if let Entry::Exchange(exchange) = entry? {
///         println!("{:?} {}: {:?}", exchange.unit, exchange.occasion, exchange.outputs);
///     }
/// }
/// # Ok::<(), LogReadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Log {
    path: PathBuf,
    pub(super) head: Arc<Head>,
    /// The channels that the head declares.
    pub(super) declared: Arc<Declared>,
    running: bool,
    /// Bytes read of the file.
    pub(super) read: Arc<AtomicU64>,
}

/// Most entries that can follow a request without an answer: the steps of its window, and what units said.
const MOST_HELD: usize = 1 << 17;

/// Messages of a topic, and their bytes before compression.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Number of messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

impl Log {
    /// Opens the log `path`, or the log in the folder `path`, and reads its head.
    ///
    /// **Errors**: the file is not a log, or is cut off before the first exchange.
    pub fn open(path: &Path) -> Result<Self, LogReadError> {
        let path = Self::file(path);
        let read = Arc::default();
        let mut stream = Stream::open(&path, &read)?;
        let head = Arc::new(Head::read(&mut stream, &path)?);
        let (declared, running) = (Arc::new(stream.declared().clone()), stream.source().running());
        Ok(Self { path, head, declared, running, read })
    }

    /// The same, of a log that exchanges are to be read of.
    ///
    /// **Errors**: its run logged none.
    pub fn of_exchanges(path: &Path) -> Result<Self, LogReadError> {
        let log = Self::open(path)?;
        match log.head.exchanges {
            LoggedExchanges::None => Err(LogReadError::NoExchanges { path: log.path }),
            LoggedExchanges::Every | LoggedExchanges::Accepted => Ok(log),
        }
    }

    /// The log that `path` is, or that is in the folder `path`.
    pub fn file(path: &Path) -> PathBuf {
        if path.is_dir() { path.join("log.mcap") } else { path.to_owned() }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The head.
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// Whether its run was writing it when it was opened.
    pub fn is_running(&self) -> bool {
        self.running
    }

    /// Bytes read of the file since it was opened, by all that reads this log.
    pub fn bytes_read(&self) -> u64 {
        self.read.load(Ordering::Relaxed)
    }

    /// The entries from the first exchange on; each call reads the file again.
    pub fn entries(&self) -> Result<Entries, LogReadError> {
        Ok(Entries {
            path: self.path.clone(),
            head: Arc::clone(&self.head),
            stream: Stream::open(&self.path, &self.read)?,
            topics: HashMap::new(),
            request: None,
            silent: Vec::new(),
            held: Vec::new(),
            waiting: VecDeque::new(),
            sequence: 0,
            skipping: None,
            gap: None,
            torn: false,
            damage: Vec::new(),
            done: false,
        })
    }
}

/// Reads a log entry by entry; an error is the last entry.
pub struct Entries {
    path: PathBuf,
    head: Arc<Head>,
    pub(super) stream: Stream,
    topics: HashMap<u16, (Topic, Traffic)>,
    request: Option<LoggedExchange>,
    /// Earlier requests to other units without an answer: several units failed at once.
    silent: Vec<LoggedExchange>,
    /// Entries after a request without an answer, until it is certain that the run ended there, or gave up the window.
    held: Vec<Entry>,
    waiting: VecDeque<Entry>,
    sequence: u32,
    /// Whatever comes before the first request in this step, or in a later one, is passed over.
    pub(super) skipping: Option<u64>,
    /// Damage behind which nothing has been read yet.
    gap: Option<LoggedDamage>,
    /// Whether no request has been read since the last damage.
    torn: bool,
    damage: Vec<LoggedDamage>,
    done: bool,
}

impl Entries {
    /// Messages and bytes read so far, by topic.
    pub fn traffic(&self) -> BTreeMap<&str, Traffic> {
        let named = |(number, (_, traffic)): (&u16, &(Topic, Traffic))| {
            Some((self.stream.channel(*number)?.topic.as_str(), *traffic))
        };
        self.topics.iter().filter_map(named).collect()
    }

    /// Length of the file, bytes.
    pub fn size(&self) -> u64 {
        self.stream.size()
    }

    /// Whether its run was writing the file when it was opened.
    pub fn running(&self) -> bool {
        self.stream.source().running()
    }

    /// What is missing, so far, in a log that was recovered.
    pub fn damage(&self) -> &[LoggedDamage] {
        &self.damage
    }

    /// Reads on behind the end of the run, and compares the index and the checksums of the file with what was read.
    ///
    /// **Errors**: [`LogReadError::Index`]; those of reading. Nothing is found out about a log that was not read from its
    /// beginning to its end.
    pub fn check_index(&mut self) -> Result<(), LogReadError> {
        while let Next::Message(_) = self.stream.next()? {}
        let flaw = self.stream.conclude()?;
        flaw.map_or(Ok(()), |flaw| {
            Err(LogReadError::Index { path: self.path.clone(), position: flaw.place, cause: flaw.cause })
        })
    }

    /// The next entry; must not be called after an error, the end or the cut.
    pub(super) fn read(&mut self) -> Result<Entry, LogReadError> {
        loop {
            if let Some(entry) = self.waiting.pop_front() {
                return Ok(entry);
            }
            self.advance()?;
        }
    }

    fn advance(&mut self) -> Result<(), LogReadError> {
        match self.stream.next()? {
            Next::Message(raw) => return self.take(&raw),
            Next::End if self.stream.finished() && self.gap.is_none() => {
                return Err(self.damaged("the file is complete but has no `/end`".to_owned()));
            }
            Next::End | Next::Cut => {}
        }
        if !self.held.is_empty() {
            self.release();
        }
        self.waiting.push_back(Entry::Cut(self.stream.position()));
        Ok(())
    }

    /// Releases the requests that have no answer, and the entries after them.
    fn release(&mut self) {
        self.waiting.extend(self.silent.drain(..).map(Entry::Exchange));
        self.waiting.extend(self.request.take().map(Entry::Exchange));
        self.waiting.extend(self.held.drain(..));
    }

    fn take(&mut self, raw: &Raw) -> Result<(), LogReadError> {
        let Some(channel) = self.stream.channel(raw.channel) else {
            return Err(self.damaged(format!("a message of channel {}, which is not declared", raw.channel)));
        };
        if !self.topics.contains_key(&raw.channel) {
            let topic = Topic::of(channel, &self.head.units).map_err(|e| self.mismatch(raw, e))?;
            self.topics.insert(raw.channel, (topic, Traffic::default()));
        }
        let Some((topic, traffic)) = self.topics.get_mut(&raw.channel) else { return Ok(()) };
        traffic.messages += 1;
        traffic.bytes += raw.data.len() as u64;
        let part = topic.read(raw, &self.head.units).map_err(|mismatch| self.mismatch(raw, mismatch))?;
        if let Some(step) = self.skipping {
            match &part {
                Part::Request(request) if request.occasion.step >= step => {
                    self.sequence = request.sequence.wrapping_sub(1);
                }
                Part::Entry(Entry::End(_)) => {}
                _ => return Ok(()),
            }
            self.skipping = None;
        }
        self.place(part)
    }

    fn place(&mut self, part: Part) -> Result<(), LogReadError> {
        self.waiting.extend(self.gap.take().map(Entry::Damage));
        match part {
            Part::Request(request) => {
                if self.was_given_up() {
                    self.release();
                }
                if let Some(before) = self.request.take() {
                    let asked_again =
                        self.silent.iter().chain([&before]).any(|silent| silent.unit == request.unit);
                    self.silent.push(before);
                    if asked_again || !self.held.is_empty() {
                        self.answered()?;
                    }
                }
                let expected = self.sequence.wrapping_add(1);
                if request.sequence != expected && !(self.torn && request.sequence > expected) {
                    let found = request.sequence;
                    return Err(self.damaged(format!("exchange {found} stands where {expected} should")));
                }
                (self.sequence, self.torn) = (request.sequence, false);
                self.request = Some(request);
            }
            Part::Answer(answer) => match self.request.take() {
                Some(_) if !self.silent.is_empty() => return self.answered(),
                Some(request)
                    if (request.unit, request.sequence) == (answer.unit, answer.sequence)
                        && self.held.is_empty() =>
                {
                    let LoggedExchange { outputs, wall_time: [_, answered], .. } = answer;
                    let wall_time = [request.wall_time[0], answered];
                    let exchange = LoggedExchange { outputs, wall_time, ..request };
                    self.waiting.push_back(Entry::Exchange(exchange));
                }
                // The request is among what is missing.
                None if self.torn && self.held.is_empty() => {}
                _ => {
                    let sequence = answer.sequence;
                    return Err(self.damaged(format!("the answer of exchange {sequence} has no request")));
                }
            },
            Part::Entry(Entry::End(end)) => {
                // No run completes with a window that it has given up.
                let early = end.status != "completed" && self.was_given_up();
                if !end.status.starts_with("failed") && !early {
                    self.answered()?;
                }
                self.release();
                self.waiting.push_back(Entry::End(end));
            }
            Part::Damage(damage) => {
                // The answer is among what is missing, and the run went on.
                (self.request, self.silent) = (None, Vec::new());
                self.waiting.extend(self.held.drain(..));
                self.damage.push(damage.clone());
                (self.gap, self.torn) = (Some(damage), true);
            }
            Part::Entry(_) if self.held.len() >= MOST_HELD => self.answered()?,
            Part::Entry(entry) if self.request.is_some() => self.held.push(entry),
            Part::Entry(entry) => self.waiting.push_back(entry),
            Part::Nothing => {}
        }
        Ok(())
    }

    /// Whether the window was given up in which a request has no answer, and the run began it again in shorter steps.
    fn was_given_up(&self) -> bool {
        self.held.iter().any(|entry| matches!(entry, Entry::Step(step) if !step.accepted))
    }

    /// Only the last request of a failed run, or of a window that was given up, may have no answer, or the last one to each unit.
    fn answered(&self) -> Result<(), LogReadError> {
        let missing =
            |r: &LoggedExchange| Err(self.damaged(format!("exchange {} has no answer", r.sequence)));
        self.silent.first().or(self.request.as_ref()).map_or(Ok(()), missing)
    }

    /// What is missing here, for those who need every exchange.
    pub(super) fn missing(&self, damage: LoggedDamage) -> LogReadError {
        LogReadError::Missing { path: self.path.clone(), damage }
    }

    fn damaged(&self, cause: String) -> LogReadError {
        self.stream.source().damaged(self.stream.position(), cause)
    }

    fn mismatch(&self, raw: &Raw, mismatch: Mismatch) -> LogReadError {
        let topic = self.stream.channel(raw.channel).map_or_else(String::new, |c| c.topic.clone());
        LogReadError::Topic { path: self.path.clone(), position: self.stream.position(), topic, mismatch }
    }
}

impl Iterator for Entries {
    type Item = Result<Entry, LogReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let entry = self.read();
        self.done = matches!(entry, Err(_) | Ok(Entry::End(_) | Entry::Cut(_)));
        Some(entry)
    }
}
