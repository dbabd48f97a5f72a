use super::calls::{layout_hash, occasion};
use super::words::{END, Task, Word};
use crate::participant::{Occasion, Participant, ParticipantError};
use crate::transport::{
    Command, Header, PROTOCOL_VERSION, Server, Status, TransportError, shorten_naps, tidy,
};
use std::io::{BufRead, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Exit status of a unit that fails, or whose orchestrator dies.
const FAILED: u8 = 4;
/// How long a computation may go on after the run is over.
const GRACE: Duration = Duration::from_millis(500);

/// Makes the unit that standard input asks for and serves it over shared memory until the run is over: the
/// whole of a unit's process.
///
/// `make` makes it from the task. What the unit says goes to standard output, one [`Word`] a line.
///
/// **Errors**: whatever fails is said on standard output, and the process's exit status is not zero.
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
    let lifeline = Lifeline::watch(task.unit.clone());
    let mut participant = match make(&task) {
        Ok(participant) => participant,
        Err(error) => return fail(&error),
    };
    let named = &participant.description().name;
    if *named != task.unit {
        return fail(&format!("{}: the unit that was made is called `{named}`", task.unit));
    }
    let served = serve(&mut *participant, task.run, &lifeline);
    if lifeline.over.load(Ordering::Acquire) && lifeline.orphaned.load(Ordering::Relaxed) {
        // What the orchestrator left behind goes with this process.
        tidy();
        return lifeline.mourn();
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
    Voice::default().say(&Word::Failed { text: error.to_string() });
    ExitCode::from(FAILED)
}

/// Says words on standard output and counts them.
#[derive(Default)]
struct Voice {
    words: u64,
}

impl Voice {
    fn say(&mut self, word: &Word) {
        let mut output = std::io::stdout().lock();
        if let Ok(line) = serde_json::to_string(word) {
            self.words += 1;
            // Nobody is left to be told.
            let _ = writeln!(output, "{line}").and_then(|()| output.flush());
        }
    }
}

/// Whether the run goes on, and where it stands.
struct Lifeline {
    unit: String,
    over: AtomicBool,
    orphaned: AtomicBool,
    /// Of the last request.
    occasion: Mutex<Option<Occasion>>,
}

impl Lifeline {
    /// Watches standard input on a thread of its own; ends the process if it is still there some time later.
    fn watch(unit: String) -> Arc<Self> {
        let lifeline =
            Arc::new(Self { unit, over: false.into(), orphaned: false.into(), occasion: Mutex::default() });
        let watched = lifeline.clone();
        std::thread::spawn(move || {
            let ended = std::io::stdin().lock().lines().map_while(Result::ok).any(|line| line == END);
            watched.orphaned.store(!ended, Ordering::Relaxed);
            watched.over.store(true, Ordering::Release);
            std::thread::sleep(GRACE);
            if ended {
                std::process::exit(0);
            }
            watched.mourn();
            std::process::exit(FAILED.into());
        });
        lifeline
    }

    /// Says on standard error that the orchestrator has died.
    fn mourn(&self) -> ExitCode {
        let occasion = *self.occasion.lock().unwrap_or_else(PoisonError::into_inner);
        let when = occasion.map_or("while the units were made".to_owned(), |o| o.to_string());
        let text = format!("{}: the orchestrator died {when}; this unit ends\n", self.unit);
        // In one piece, since the other unit says the same. Nobody may be left to be told.
        let _ = std::io::stderr().write_all(text.as_bytes());
        ExitCode::from(FAILED)
    }
}

fn serve(participant: &mut dyn Participant, run: u64, lifeline: &Lifeline) -> Result<(), TransportError> {
    let description = participant.description().clone();
    let values = description.readable.longest().max(description.outputs.size());
    let server = Server::create(run, &description.name, &layout_hash(&description), values)?;
    let mut voice = Voice::default();
    for message in participant.messages() {
        voice.say(&Word::Message(message));
    }
    let described = serde_json::to_value(&description).unwrap_or_default();
    voice.say(&Word::Ready { protocol: PROTOCOL_VERSION, description: described });
    server.serve(&lifeline.over, |header, inputs, outputs| {
        *lifeline.occasion.lock().unwrap_or_else(PoisonError::into_inner) = Some(occasion(header));
        let before = participant.busy();
        let result = answer(participant, header, inputs, outputs);
        header.busy = participant.busy().saturating_sub(before).as_nanos() as u64;
        for message in participant.messages() {
            voice.say(&Word::Message(message));
        }
        // What is not finite is an answer all the same: the client says so.
        if let Err(error) =
            result.or_else(|e| if matches!(e, ParticipantError::NonFinite { .. }) { Ok(()) } else { Err(e) })
        {
            outputs.clear();
            header.status = Status::Failed as u32;
            voice.say(&Word::Failed { text: error.to_string() });
        }
        header.words = voice.words;
    })
}

fn answer(
    participant: &mut dyn Participant,
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
    if command == Command::Read {
        let named = description.readable.channels().find(|(c, _)| c.value_reference == header.variable);
        let variable = named.map_or(format!("#{}", header.variable), |(c, _)| c.name.clone());
        *outputs = participant.read(&variable)?;
        return Ok(());
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
        Command::Step | Command::Read => {}
    }
    participant.step(&occasion(header), inputs, outputs)
}
