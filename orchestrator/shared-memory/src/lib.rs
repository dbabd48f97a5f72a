//! Units in processes of their own, connected by shared memory (iceoryx2).
//!
//! [`Starting`] starts commands as units and waits until they are ready; each is then a [`SharedMemory`] participant. In its own
//! process a unit is served by [`host()`]. Requests and answers are slices of numbers behind a header that is echoed and checked;
//! saving and restoring a state travel with the next step. `docs/reference/protocol.md` describes the protocol for other languages.
//!
//! ```
//! use cofferdam_coupling::participant::{FunctionUnit, Participant};
//! use cofferdam_shared_memory::{Starting, layout_hash};
//!
//! // Whether processes can exchange on this machine at all, before anything is started.
//! Starting::check()?;
//! // Both sides compare the layout of a unit before the first exchange.
//! let unit = |input| FunctionUnit::new("unit", &[(input, "m")], &[("force", "N")], 0.0, |_, _, x, f| f[0] = -x[0]);
//! assert_ne!(layout_hash(unit("position")?.description()), layout_hash(unit("speed")?.description()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod brief;
mod calls;
mod host;
mod process;
mod state_file;
pub mod transport;
mod watch;
mod words;

pub use brief::{Brief, BriefPoints};
pub use calls::layout_hash;
pub use host::host;
pub use words::{Task, Word};

use crate::transport::{
    Client, Command, Folder, Header, PROTOCOL_VERSION, ServiceKind, Status, TransportError, probe,
    shorten_naps, usual_services,
};
use cofferdam_coupling::participant::{
    Description, Level, Message, Occasion, Participant, ParticipantError, check_finite,
};
use cofferdam_unit::at_places;
use process::{Listening, RunMates, UnitProcess};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use watch::{Watch, explained};

/// Time limits after which a unit counts as hung.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadlines {
    /// For preparation, and for initialisation.
    pub preparation: Duration,
    /// For a step, including saving and restoring states; states as bytes may take as long as preparation.
    pub step: Duration,
}

/// A unit in a process of its own.
///
/// Saving and restoring are sent with the next step, so that an iteration needs one request. If a unit ends or does
/// not answer in time, the error names the unit and the step. The same holds if another unit of the run ends
/// meanwhile.
pub struct SharedMemory {
    // Closed before the run's folder is left.
    client: Client,
    run_mates: Arc<RunMates>,
    /// Index of this unit.
    index: usize,
    description: Description,
    deadlines: Deadlines,
    /// Occasion of the last call.
    occasion: Occasion,
    pending: Option<Pending>,
    busy: Duration,
    /// Number of lines that the unit had written up to its last answer.
    said: u64,
}

/// Action before the next step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pending {
    Save,
    Restore,
}

/// Interval between two checks of the processes of a run.
const LOOK: Duration = Duration::from_millis(10);
/// Time that lines may take to arrive after the answer that counts them, or after the end of their process.
const WORDS: Duration = Duration::from_millis(200);
/// Largest number of values of a variable.
const MOST_VALUES: usize = 1 << 24;

/// A unit that is started as a process.
#[derive(Debug)]
pub struct UnitCommand {
    /// Name of the unit.
    pub name: String,
    /// The command; it must run [`host`] or implement the protocol itself.
    pub command: std::process::Command,
    /// What a unit that is not ours is made from. It is reached over iceoryx2's usual service, which exists in many languages, a
    /// built-in one over files that no other user can see.
    pub brief: Option<Brief>,
}

/// Units whose processes have been started and are not ready yet.
pub struct Starting {
    run_mates: Arc<RunMates>,
    deadlines: Deadlines,
}

impl Starting {
    /// Checks that shared memory is available, before any work is done.
    ///
    /// **Errors**: why it is not available.
    pub fn check() -> Result<(), ParticipantError> {
        Ok(probe()?)
    }

    /// Starts a process for each unit.
    ///
    /// All units are made at the same time, each with up to `threads` threads, from `scene` (TOML, with all
    /// defaults) or their briefs. Also makes sleeps of the calling thread precise; the same thread should step the units.
    ///
    /// **Errors**: a process cannot be started; no shared memory.
    pub fn new(
        units: impl IntoIterator<Item = UnitCommand>,
        scene: &str,
        threads: usize,
        deadlines: Deadlines,
    ) -> Result<Self, ParticipantError> {
        shorten_naps();
        let folder = Folder::create()?;
        let (run, path, scene) = (folder.run(), folder.path().to_owned(), scene.to_owned());
        let mut run_mates = RunMates { processes: Vec::new(), folder };
        let units: Vec<UnitCommand> = units.into_iter().collect();
        let usual = units.iter().any(|unit| unit.brief.is_some()).then(|| usual_services(&run_mates.folder));
        let usual = usual.transpose()?;
        for UnitCommand { name: unit, command, brief } in units {
            let service = usual.clone().filter(|_| brief.is_some()).unwrap_or(ServiceKind::PrivateFiles);
            let (protocol, folder, scene) = (PROTOCOL_VERSION, path.clone(), scene.clone());
            let task = Task { protocol, run, folder, service, unit, threads, scene, brief };
            run_mates.processes.push(UnitProcess::start(command, &task)?);
        }
        Ok(Self { run_mates: Arc::new(run_mates), deadlines })
    }

    /// Name and process id of each unit.
    pub fn processes(&self) -> impl Iterator<Item = (&str, u32)> {
        self.run_mates.processes.iter().map(|process| (process.name.as_str(), process.id()))
    }

    /// Waits until all units are ready, or until `interrupted`; they are returned in the order in which they were
    /// named.
    ///
    /// **Errors**: a process ends, takes too long, cannot make its unit, or is of another version.
    pub fn wait(self, interrupted: &AtomicBool) -> Result<Vec<SharedMemory>, ParticipantError> {
        let mut watch = Watch::new(&self.run_mates, self.deadlines.preparation);
        let ready = |index| SharedMemory::when_ready(index, &self, &mut watch, interrupted);
        (0..self.run_mates.processes.len()).map(ready).collect()
    }
}

impl SharedMemory {
    fn when_ready(
        index: usize,
        starting: &Starting,
        watch: &mut Watch<'_>,
        interrupted: &AtomicBool,
    ) -> Result<Self, ParticipantError> {
        let (run_mates, deadlines) = (starting.run_mates.clone(), starting.deadlines);
        let process = &run_mates.processes[index];
        let unit = process.name.clone();
        let (protocol, description) = loop {
            let listening = process.listen(LOOK);
            if let Some(text) = process.heard(|heard| heard.failure.take()) {
                return Err(ParticipantError::Reported { text });
            }
            if let Some(ready) = process.heard(|heard| heard.ready.take()) {
                break ready;
            }
            if interrupted.load(Ordering::Relaxed) {
                return Err(ParticipantError::Interrupted);
            }
            if listening == Listening::Closed {
                std::thread::sleep(LOOK);
            }
            watch.look(&unit, &MAKING)?;
        };
        if protocol != PROTOCOL_VERSION {
            let (expected, found) = (PROTOCOL_VERSION, protocol);
            return Err(TransportError::Protocol { unit, expected, found }.into());
        }
        let unintelligible =
            |cause: String| ParticipantError::Unintelligible { participant: unit.clone(), cause };
        let description: Description =
            serde_json::from_value(description).map_err(|e| unintelligible(e.to_string()))?;
        if description.name != unit {
            return Err(unintelligible(format!("it is that of `{}`", description.name)));
        }
        for layout in [&description.inputs, &description.outputs, &description.readable] {
            let longest = layout.longest();
            if longest > MOST_VALUES {
                return Err(unintelligible(format!("a variable has {longest} values")));
            }
        }
        let layout = layout_hash(&description);
        let client =
            Client::open(&run_mates.folder, &process.service, &unit, &layout, description.inputs.size())
                .map_err(|e| explained(&run_mates, e, &MAKING))?;
        let (pending, busy, said) = (None, Duration::ZERO, process.heard(|heard| heard.words));
        let occasion = Occasion::initialisation(0.0);
        Ok(Self { client, run_mates, index, description, deadlines, occasion, pending, busy, said })
    }

    fn process(&self) -> &UnitProcess {
        &self.run_mates.processes[self.index]
    }

    /// The header of a request for `command` on the present occasion.
    fn request(&self, command: Command) -> Header {
        calls::request(self.run_mates.folder.run(), command, &self.occasion)
    }

    /// Sends a command that every unit knows.
    fn call(&mut self, header: Header, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        let offered = self.ask(header, inputs, outputs)?;
        let unknown = || ParticipantError::Command {
            participant: self.description.name.clone(),
            command: header.command,
        };
        offered.then_some(()).ok_or_else(unknown)
    }

    /// Sends a command and waits for its answer, which has as many values as `outputs`; whether the unit offers it.
    fn ask(&mut self, header: Header, inputs: &[f64], outputs: &mut [f64]) -> Result<bool, ParticipantError> {
        let occasion = self.occasion;
        let limit = match header.command() {
            Some(
                Command::Step
                | Command::SaveAndStep
                | Command::RestoreAndStep
                | Command::Read
                | Command::ReadAt,
            ) => self.deadlines.step,
            _ => self.deadlines.preparation,
        };
        let process = &self.run_mates.processes[self.index];
        process.heard(|heard| heard.occasion = occasion);
        let mut watch = Watch::new(&self.run_mates, limit);
        let take = |header: &Header, values: &[f64]| {
            if header.status != Status::Done as u32 {
                return Ok(());
            }
            let (expected, found) = (outputs.len(), values.len());
            if expected != found {
                return Err(TransportError::Length { unit: process.name.clone(), expected, found });
            }
            outputs.copy_from_slice(values);
            Ok(())
        };
        let answer = self.client.call(header, inputs, take, || watch.look(&process.name, &occasion));
        let answer = answer.map_err(|error| match error {
            ParticipantError::Communication(error) => match error.downcast::<TransportError>() {
                Ok(error) => explained(&self.run_mates, *error, &occasion),
                Err(error) => ParticipantError::Communication(error),
            },
            error => error,
        })?;
        self.busy += Duration::from_nanos(answer.busy);
        self.said = answer.words;
        if [Status::Done, Status::NotOffered].iter().any(|status| answer.status == *status as u32) {
            return Ok(answer.status == Status::Done as u32);
        }
        self.receive_messages();
        let process = self.process();
        let silent = || format!("{}: failed {occasion} and did not say why", process.name);
        let text = process.heard(|heard| heard.failure.take()).unwrap_or_else(silent);
        Err(ParticipantError::Reported { text })
    }

    /// Receives all lines that the unit had written up to its last answer, and any others that are there.
    fn receive_messages(&self) {
        let process = self.process();
        let began = Instant::now();
        let heard = || process.heard(|heard| heard.words);
        while heard() < self.said && began.elapsed() < WORDS {
            process.listen(LOOK);
        }
        while process.listen(Duration::ZERO) == Listening::Said && began.elapsed() < WORDS {}
        let missing = self.said.saturating_sub(heard());
        if missing > 0 {
            process.heard(|heard| {
                let text = format!("{missing} of the messages that its answer counts did not arrive");
                heard.messages.push(process.message(&heard.occasion, Level::Warning, text));
                // Do not wait for them again.
                heard.words = self.said;
            });
        }
    }
}

/// The activity before the first call.
const MAKING: &str = "while the units were made";

impl Participant for SharedMemory {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let (variable, size) = self.description.find_readable(variable)?;
        let header = Header { variable, ..self.request(Command::Read) };
        let mut values = vec![0.0; size];
        self.call(header, &[], &mut values)?;
        Ok(values)
    }

    fn read_at(&mut self, variable: &str, places: &[usize]) -> Result<Vec<f64>, ParticipantError> {
        let (reference, _) = self.description.find_readable(variable)?;
        let header = Header { variable: reference, ..self.request(Command::ReadAt) };
        let asked: Vec<f64> = places.iter().map(|place| *place as f64).collect();
        let mut values = vec![0.0; places.len()];
        if !self.ask(header, &asked, &mut values)? {
            values = at_places(&self.read(variable)?, places).collect();
        }
        Ok(values)
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.occasion = Occasion::initialisation(start_time);
        self.call(self.request(Command::Initialise), inputs, outputs)?;
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
        self.occasion = *occasion;
        self.call(self.request(command), inputs, outputs)?;
        check_finite(&self.description, outputs, occasion.end())
    }

    /// Saves nothing where the unit cannot: a scheme that never returns saves all the same.
    fn save_state(&mut self) -> Result<(), ParticipantError> {
        if self.description.capabilities.saved_state {
            // After a restore the state is the saved one.
            self.pending.get_or_insert(Pending::Save);
        }
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        if !self.description.capabilities.saved_state {
            return Err(ParticipantError::NoSavedState { participant: self.description.name.clone() });
        }
        // After a save the state is the saved one.
        self.pending.get_or_insert(Pending::Restore);
        Ok(())
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        // A return to the saved state is still to be made; the state after a save is the present one.
        let restore = self.pending == Some(Pending::Restore);
        let command = if restore { Command::RestoreAndSerialise } else { Command::Serialise };
        if !self.ask(self.request(command), &[], &mut [])? {
            return Ok(None);
        }
        if restore {
            self.pending = None;
        }
        state_file::take(&self.run_mates.folder, &self.description.name).map(Some)
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        (self.occasion, self.pending) = (Occasion::initialisation(0.0), None);
        let participant = self.description.name.clone();
        state_file::put(&self.run_mates.folder, &participant, state)?;
        let offered = self.ask(self.request(Command::Deserialise), &[], &mut []);
        state_file::discard(&self.run_mates.folder, &participant);
        if offered? { Ok(()) } else { Err(ParticipantError::NotSerialised { participant }) }
    }

    fn busy(&self) -> Duration {
        self.busy
    }

    fn messages(&mut self) -> Vec<Message> {
        self.receive_messages();
        self.process().take_messages()
    }
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        self.process().tell_end();
    }
}
