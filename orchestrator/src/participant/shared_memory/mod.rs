//! Units that are processes of their own, reached over shared memory.

mod host;
mod process;
mod words;

pub use host::host;
pub use words::{Task, Word};

use super::{Description, Level, Message, Occasion, Participant, ParticipantError, check_finite};
use crate::transport::{
    Client, Command, Header, PROTOCOL_VERSION, Status, TransportError, layout_hash, new_run, probe,
    shorten_naps,
};
use process::UnitProcess;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a unit may take before it counts as hung.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadlines {
    /// To be made, and to initialise.
    pub preparation: Duration,
    /// For a step, states included.
    pub step: Duration,
}

/// A unit that is a process of its own.
///
/// Saving and restoring travel with the next step: one request an iteration. A unit that ends, or does not
/// answer in time, is an error that names it and the step; so is one whose neighbour ends meanwhile.
pub struct SharedMemory {
    process: Arc<UnitProcess>,
    /// All units of the run: when one ends, waiting for another is in vain.
    run_mates: Arc<[Arc<UnitProcess>]>,
    client: Client,
    run: u64,
    description: Description,
    deadlines: Deadlines,
    pending: Option<Pending>,
    busy: Duration,
    /// Words that the unit had said at its last answer, and those heard of them.
    said: u64,
    heard: Heard,
}

/// What was heard from a unit.
#[derive(Default)]
struct Heard {
    words: u64,
    /// Of the last call.
    occasion: Occasion,
    messages: Vec<Message>,
    failure: Option<String>,
    ready: Option<(u32, serde_json::Value)>,
}

/// What must be done before the next step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pending {
    Save,
    Restore,
}

/// How often a process is looked at while it is made.
const LOOK: Duration = Duration::from_millis(10);
/// How long words may take to arrive after the answer that counts them.
const WORDS: Duration = Duration::from_secs(1);

/// Units whose processes run and are not ready yet.
pub struct Starting {
    run: u64,
    processes: Arc<[Arc<UnitProcess>]>,
    deadlines: Deadlines,
    began: Instant,
}

impl Starting {
    /// Starts a process for each unit: a name, and the command that runs it.
    ///
    /// All units are made at the same time, each with up to `threads` threads, from `scene` (TOML, with all
    /// defaults). A command must run [`host`] or keep the protocol itself.
    ///
    /// **Errors**: shared memory cannot be had; a process cannot be started.
    pub fn new(
        units: impl IntoIterator<Item = (String, std::process::Command)>,
        scene: &str,
        threads: usize,
        deadlines: Deadlines,
    ) -> Result<Self, ParticipantError> {
        shorten_naps();
        let run = new_run();
        probe(run)?;
        let start = |(unit, command)| {
            let task = Task { protocol: PROTOCOL_VERSION, run, unit, threads, scene: scene.to_owned() };
            UnitProcess::start(command, &task).map(Arc::new)
        };
        let processes = units.into_iter().map(start).collect::<Result<_, _>>()?;
        Ok(Self { run, processes, deadlines, began: Instant::now() })
    }

    /// Name and number of each process.
    pub fn processes(&self) -> impl Iterator<Item = (&str, u32)> {
        self.processes.iter().map(|process| (process.name.as_str(), process.id()))
    }

    /// Waits until all units are ready; they come in the order in which they were named.
    ///
    /// **Errors**: a process ends, takes too long, cannot make its unit, or is of another version.
    pub fn wait(self) -> Result<Vec<SharedMemory>, ParticipantError> {
        self.processes.iter().map(|process| SharedMemory::when_ready(process, &self)).collect()
    }
}

impl SharedMemory {
    fn when_ready(process: &Arc<UnitProcess>, starting: &Starting) -> Result<Self, ParticipantError> {
        let Starting { run, deadlines, began, .. } = *starting;
        let (process, run_mates) = (process.clone(), starting.processes.clone());
        let unit = process.name.clone();
        let mut heard = Heard::default();
        let (protocol, description) = loop {
            if !heard.listen(&process, LOOK) {
                look(&run_mates, "while the units were made", deadlines.preparation, &unit, began)?;
            }
            if let Some(text) = heard.failure.take() {
                return Err(ParticipantError::Reported { text });
            }
            if let Some(ready) = heard.ready.take() {
                break ready;
            }
        };
        if protocol != PROTOCOL_VERSION {
            let (expected, found) = (PROTOCOL_VERSION, protocol);
            return Err(TransportError::Protocol { unit, expected, found }.into());
        }
        let description: Description = serde_json::from_value(description).map_err(|cause| {
            ParticipantError::Unintelligible { participant: unit.clone(), cause: cause.to_string() }
        })?;
        let layout = layout_hash(&description);
        let client = Client::open(run, &unit, &layout, description.inputs.size())?;
        let (pending, busy, said) = (None, Duration::ZERO, heard.words);
        Ok(Self { process, run_mates, client, run, description, deadlines, pending, busy, said, heard })
    }

    /// Sends a command and waits for its answer, which has as many values as `outputs`.
    fn call(&mut self, header: Header, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        let occasion = header.occasion();
        self.heard.occasion = occasion;
        let limit = if occasion.step == 0 { self.deadlines.preparation } else { self.deadlines.step };
        let unit = &self.process.name;
        let began = Instant::now();
        let answer = self.client.call(
            header,
            inputs,
            |header, values| {
                if header.status != Status::Done as u32 {
                    return Ok(());
                }
                let (expected, found) = (outputs.len(), values.len());
                if expected != found {
                    return Err(TransportError::Length { unit: unit.clone(), expected, found });
                }
                outputs.copy_from_slice(values);
                Ok(())
            },
            |_| look(&self.run_mates, &occasion.to_string(), limit, unit, began),
        )?;
        self.busy += Duration::from_nanos(answer.busy);
        self.said = answer.words;
        if answer.status == Status::Done as u32 {
            return Ok(());
        }
        self.hear();
        let silent = || format!("{}: failed {occasion} and did not say why", self.process.name);
        let text = self.heard.failure.take().unwrap_or_else(silent);
        Err(ParticipantError::Reported { text })
    }

    /// Hears all words that the unit had said at its last answer, and whatever else there is.
    fn hear(&mut self) {
        let began = Instant::now();
        while self.heard.words < self.said && began.elapsed() < WORDS {
            self.heard.listen(&self.process, LOOK);
        }
        while self.heard.listen(&self.process, Duration::ZERO) {}
    }
}

impl Heard {
    /// Keeps what the unit says next; `false` if that is nothing within `patience`.
    fn listen(&mut self, process: &UnitProcess, patience: Duration) -> bool {
        let Some(line) = process.line(patience) else { return false };
        self.words += u64::from(line.is_ok());
        match line {
            Ok(Word::Message(message)) => self.messages.push(message),
            Ok(Word::Failed { text }) => self.failure = Some(text),
            Ok(Word::Ready { protocol, description }) => self.ready = Some((protocol, description)),
            Err(text) => self.messages.push(Message {
                unit: process.name.clone(),
                level: Level::Information,
                step: self.occasion.step,
                iteration: self.occasion.iteration,
                time: self.occasion.time,
                source: "standard output".to_owned(),
                text,
            }),
        }
        true
    }
}

/// Looks at all units of a run while one of them is waited for since `began`.
fn look(
    run_mates: &[Arc<UnitProcess>],
    when: &str,
    limit: Duration,
    awaited: &str,
    began: Instant,
) -> Result<(), ParticipantError> {
    for process in run_mates {
        if let Some(how) = process.ending() {
            // What it could still say matters more than how it ended.
            while let Some(line) = process.line(LOOK) {
                if let Ok(Word::Failed { text }) = line {
                    return Err(ParticipantError::Reported { text });
                }
            }
            let (participant, when) = (process.name.clone(), when.to_owned());
            return Err(ParticipantError::Ended { participant, how, when });
        }
    }
    if began.elapsed() < limit {
        return Ok(());
    }
    run_mates.iter().filter(|process| process.name == awaited).for_each(|process| process.kill());
    let (participant, when) = (awaited.to_owned(), when.to_owned());
    Err(ParticipantError::Hung { participant, seconds: limit.as_secs_f64(), when })
}

impl Participant for SharedMemory {
    fn description(&self) -> &Description {
        &self.description
    }

    fn fixed(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let found = self.description.fixed.channels().find(|(channel, _)| channel.name == variable);
        let Some((channel, range)) = found else {
            let participant = self.description.name.clone();
            return Err(ParticipantError::Missing { participant, variable: variable.to_owned() });
        };
        let request = Header::request(self.run, Command::Fixed, &Occasion::initialisation(0.0));
        let header = Header { variable: channel.value_reference, ..request };
        let mut values = vec![0.0; range.len()];
        self.call(header, &[], &mut values)?;
        Ok(values)
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        let occasion = Occasion::initialisation(start_time);
        self.call(Header::request(self.run, Command::Initialise, &occasion), inputs, outputs)?;
        check_finite(&self.description, outputs, start_time)
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        let command = match self.pending.take() {
            None => Command::Step,
            Some(Pending::Save) => Command::SaveAndStep,
            Some(Pending::Restore) => Command::RestoreAndStep,
        };
        self.call(Header::request(self.run, command, occasion), inputs, outputs)?;
        check_finite(&self.description, outputs, occasion.end())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        // After a restore the state is the saved one.
        self.pending.get_or_insert(Pending::Save);
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        // After a save the state is the saved one.
        self.pending.get_or_insert(Pending::Restore);
        Ok(())
    }

    fn busy(&self) -> Duration {
        self.busy
    }

    fn messages(&mut self) -> Vec<Message> {
        self.hear();
        std::mem::take(&mut self.heard.messages)
    }
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        self.process.end();
    }
}
