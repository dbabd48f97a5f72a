use super::calls::{layout_hash, occasion};
use super::state_file;
use super::words::{END, Task, Word};
use crate::transport::{
    Command, Folder, Header, PROTOCOL_VERSION, Server, ServiceKind, Status, TransportError, shorten_naps,
};
use cofferdam_coupling::participant::{Occasion, Participant, ParticipantError};
use std::io::{BufRead, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Exit status if the unit fails or the orchestrator dies.
const FAILED: u8 = 4;
/// Time for a computation to finish after the run is over.
const GRACE: Duration = Duration::from_millis(500);

/// Runs a unit's process: makes the unit that the task on standard input names, and serves it over shared memory
/// until the run is over.
///
/// `make` makes the unit from the task. Messages of the unit go to standard output, one [`Word`] a line.
///
/// **Errors**: they are written to standard output, and the exit status is not zero.
pub fn host<E: std::fmt::Display>(make: impl FnOnce(&Task) -> Result<Box<dyn Participant>, E>) -> ExitCode {
    let task = match task() {
        Ok(task) if task.protocol == PROTOCOL_VERSION => task,
        Ok(Task { unit, protocol: found, .. }) => {
            return fail(&TransportError::Protocol { unit, expected: PROTOCOL_VERSION, found });
        }
        Err(cause) => {
            let first = "the first line of standard input is not what an orchestrator writes there";
            return fail(&format!("{first} ({cause}); `cofferdam run` starts units by itself"));
        }
    };
    shorten_naps();
    let lifeline = match Lifeline::watch(task.unit.clone()) {
        Ok(lifeline) => lifeline,
        Err(cause) => {
            return fail(&format!("{}: no thread can be made: {cause}; allow more (`ulimit -u`)", task.unit));
        }
    };
    // Left last, after an orchestrator that died too: then this process or the other unit removes the folder.
    let folder = match Folder::join(&task.folder, task.run) {
        Ok(folder) => folder,
        Err(error) => return fail(&error),
    };
    let mut participant = match make(&task) {
        Ok(participant) => participant,
        Err(error) => return fail(&error),
    };
    let named = &participant.description().name;
    if *named != task.unit {
        return fail(&format!("{}: the unit that was made is called `{named}`", task.unit));
    }
    let served = serve(&mut *participant, &folder, &task.service, &lifeline);
    if lifeline.over.load(Ordering::Acquire) && lifeline.orphaned.load(Ordering::Relaxed) {
        let status = lifeline.report_orphaned();
        folder.outlive();
        return status;
    }
    match served {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error),
    }
}

/// The task: the first line of standard input.
fn task() -> Result<Task, String> {
    let input = std::io::stdin();
    if input.is_terminal() {
        return Err("it is a terminal".to_owned());
    }
    let mut line = String::new();
    input.lock().read_line(&mut line).map_err(|e| e.to_string())?;
    serde_json::from_str(&line).map_err(|e| e.to_string())
}

fn fail(error: &impl std::fmt::Display) -> ExitCode {
    Output::default().write(&Word::Failed { text: error.to_string() });
    ExitCode::from(FAILED)
}

/// Writes words to standard output and counts them.
#[derive(Default)]
struct Output {
    words: u64,
}

impl Output {
    fn write(&mut self, word: &Word) {
        let mut output = std::io::stdout().lock();
        if let Ok(line) = serde_json::to_string(word) {
            self.words += 1;
            // A library may have printed the beginning of a line; blank lines are skipped. If the output is closed, no reader
            // is left.
            let _ = output.write_all(format!("\n{line}\n").as_bytes()).and_then(|()| output.flush());
        }
    }
}

/// Watches whether the run continues, and keeps the current step.
struct Lifeline {
    unit: String,
    over: AtomicBool,
    orphaned: AtomicBool,
    /// Occasion of the last request.
    occasion: Mutex<Option<Occasion>>,
}

impl Lifeline {
    /// Watches standard input on a thread of its own; after its end, ends the process unless it ends in time by
    /// itself.
    fn watch(unit: String) -> std::io::Result<Arc<Self>> {
        let lifeline =
            Arc::new(Self { unit, over: false.into(), orphaned: false.into(), occasion: Mutex::default() });
        let watched = lifeline.clone();
        std::thread::Builder::new().spawn(move || {
            let ended = std::io::stdin().lock().lines().map_while(Result::ok).any(|line| line == END);
            watched.orphaned.store(!ended, Ordering::Relaxed);
            watched.over.store(true, Ordering::Release);
            std::thread::sleep(GRACE);
            if ended {
                std::process::exit(0);
            }
            watched.report_orphaned();
            std::process::exit(FAILED.into());
        })?;
        Ok(lifeline)
    }

    /// Reports on standard error that the orchestrator has died.
    fn report_orphaned(&self) -> ExitCode {
        let occasion = *self.occasion.lock().unwrap_or_else(PoisonError::into_inner);
        let when = occasion.map_or("while the units were made".to_owned(), |o| o.to_string());
        let text = format!("{}: the orchestrator died {when}; this unit ends\n", self.unit);
        // Written in one piece, because the other unit writes the same. The output may be closed.
        let _ = std::io::stderr().write_all(text.as_bytes());
        ExitCode::from(FAILED)
    }
}

fn serve(
    participant: &mut dyn Participant,
    folder: &Folder,
    kind: &ServiceKind,
    lifeline: &Lifeline,
) -> Result<(), TransportError> {
    let description = participant.description().clone();
    let values = description.readable.longest().max(description.outputs.size());
    let server = Server::create(folder, kind, &description.name, &layout_hash(&description), values)?;
    let mut output = Output::default();
    for message in participant.messages() {
        output.write(&Word::Message(message));
    }
    let described = serde_json::to_value(&description).unwrap_or_default();
    output.write(&Word::Ready { protocol: PROTOCOL_VERSION, description: described });
    server.serve(&lifeline.over, |header, inputs, outputs| {
        *lifeline.occasion.lock().unwrap_or_else(PoisonError::into_inner) = Some(occasion(header));
        let before = participant.busy();
        let result = answer(participant, folder, header, inputs, outputs);
        header.busy = participant.busy().saturating_sub(before).as_nanos() as u64;
        for message in participant.messages() {
            output.write(&Word::Message(message));
        }
        let status = match result {
            // An answer that is not finite is sent too; the client reports it.
            Ok(()) | Err(ParticipantError::NonFinite { .. }) => Status::Done,
            Err(ParticipantError::NotSerialised { .. }) => Status::NotOffered,
            Err(error) => {
                output.write(&Word::Failed { text: error.to_string() });
                Status::Failed
            }
        };
        if status != Status::Done {
            outputs.clear();
        }
        header.status = status as u32;
        header.words = output.words;
    })
}

fn answer(
    participant: &mut dyn Participant,
    folder: &Folder,
    header: &Header,
    inputs: &[f64],
    outputs: &mut Vec<f64>,
) -> Result<(), ParticipantError> {
    let description = participant.description();
    let name = || description.name.clone();
    if header.protocol_version != PROTOCOL_VERSION {
        let (expected, found) = (PROTOCOL_VERSION, header.protocol_version);
        return Err(TransportError::Protocol { unit: name(), expected, found }.into());
    }
    let Some(command) = header.command() else {
        return Err(ParticipantError::Command { participant: name(), command: header.command });
    };
    match command {
        Command::Read | Command::ReadAt => {
            let named = description.readable.channels().find(|(c, _)| c.value_reference == header.variable);
            let variable = named.map_or(format!("#{}", header.variable), |(c, _)| c.name.clone());
            *outputs = match command {
                Command::Read => participant.read(&variable)?,
                _ => {
                    // What is no place lies beyond all.
                    let place = |number: &f64| if *number >= 0.0 { *number as usize } else { usize::MAX };
                    participant.read_at(&variable, &inputs.iter().map(place).collect::<Vec<_>>())?
                }
            };
            return Ok(());
        }
        Command::Serialise | Command::RestoreAndSerialise => {
            let name = name();
            if command == Command::RestoreAndSerialise {
                participant.restore_state()?;
            }
            let state = participant.serialise()?;
            let state = state.ok_or_else(|| ParticipantError::NotSerialised { participant: name.clone() })?;
            return state_file::put(folder, &name, &state);
        }
        Command::Deserialise => {
            let state = state_file::take(folder, &name())?;
            return participant.deserialise(&state);
        }
        _ => (),
    }
    let (expected, found) = (description.inputs.size(), inputs.len());
    if expected != found {
        return Err(ParticipantError::Length { participant: name(), expected, found });
    }
    outputs.resize(description.outputs.size(), 0.0);
    match command {
        Command::Initialise => return participant.initialise(header.time, inputs, outputs),
        Command::SaveAndStep => participant.save_state()?,
        Command::RestoreAndStep => participant.restore_state()?,
        _ => {}
    }
    participant.step(&occasion(header), inputs, outputs)
}
