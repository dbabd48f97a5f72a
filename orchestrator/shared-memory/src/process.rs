use super::words::{END, Task, Word};
use crate::transport::{Folder, ServiceKind};
use cofferdam_coupling::participant::{Level, Message, Occasion, ParticipantError};
use cofferdam_coupling::temporary::TemporaryFolder;
use rustix::process::{Pid, Signal, kill_process_group};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A unit's process: start, end, and what it writes to its standard output.
pub struct UnitProcess {
    pub name: String,
    /// The service that it makes.
    pub service: ServiceKind,
    child: Mutex<Child>,
    /// Sends lines to its standard input, which stays open.
    input: Mutex<Option<Sender<&'static str>>>,
    received: Mutex<(Receiver<Result<Word, String>>, Heard)>,
    /// Bytes of lines in no form that were kept since the messages were taken.
    printed: Arc<AtomicU64>,
    /// For its temporary files.
    _temporary: TemporaryFolder,
}

/// What a unit has written so far.
#[derive(Default)]
pub struct Heard {
    /// Number of lines in the form of a [`Word`].
    pub words: u64,
    /// The current call.
    pub occasion: Occasion,
    pub messages: Vec<Message>,
    pub failure: Option<String>,
    pub ready: Option<(u32, serde_json::Value)>,
}

/// Result of waiting for a line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Listening {
    /// A line came and was kept.
    Said,
    /// No line came.
    Silent,
    /// The output is closed.
    Closed,
}

/// Time for processes to end by themselves; their own limit is shorter.
const GRACE: Duration = Duration::from_millis(700);
/// Interval between two checks of a process that is ending.
const LOOK: Duration = Duration::from_millis(1);
/// Longest line that is kept, bytes.
const LONGEST_LINE: u64 = 1 << 24;
/// Most bytes of other lines that are kept until the messages are taken: a library may print more than fits into the memory.
const MOST_PRINTED: u64 = 1 << 24;
const SIGBUS: i32 = 7;

impl UnitProcess {
    /// Starts `command` and gives it its task.
    ///
    /// The process gets a process group of its own, so that Ctrl-C in a terminal reaches only the orchestrator.
    pub fn start(mut command: Command, task: &Task) -> Result<Self, ParticipantError> {
        let name = task.unit.clone();
        let remedy = if task.brief.is_some() { "correct the command" } else { "use --transport in-process" };
        let program = command.get_program().to_string_lossy().into_owned();
        let failed = |cause| ParticipantError::NotStarted {
            participant: name.clone(),
            program: program.clone(),
            cause,
            remedy,
        };
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).process_group(0);
        // What a unit that crashes leaves behind, such as an unpacked FMU, goes with the run.
        let temporary = TemporaryFolder::create("cofferdam-unit-").map_err(failed)?;
        if task.brief.is_none() {
            command.env("TMPDIR", temporary.path());
        }
        let mut child = command.spawn().map_err(failed)?;
        let (heard, lines) = channel();
        let (input, said) = channel();
        let (output, pipe) = (child.stdout.take(), child.stdin.take());
        let received = (lines, Heard::default()).into();
        let (child, input, service) = (child.into(), Some(input).into(), task.service.clone());
        let printed = Arc::new(AtomicU64::new(0));
        let counter = printed.clone();
        let started =
            Self { child, input, received, printed, name: name.clone(), service, _temporary: temporary };
        let threads = || -> std::io::Result<()> {
            let thread = std::thread::Builder::new;
            if let Some(output) = output {
                thread().spawn(move || listen(output, &heard, &counter))?;
            }
            if let (Some(pipe), Ok(line)) = (pipe, serde_json::to_string(task)) {
                thread().spawn(move || speak(pipe, &line, &said))?;
            }
            Ok(())
        };
        threads().map_err(|cause| {
            started.kill();
            failed(cause)
        })?;
        Ok(started)
    }

    /// Its process id.
    pub fn id(&self) -> u32 {
        locked(&self.child).id()
    }

    /// Receives and keeps its next line, if one comes within `patience`.
    pub fn listen(&self, patience: Duration) -> Listening {
        let mut received = locked(&self.received);
        let line = match received.0.recv_timeout(patience) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => return Listening::Silent,
            Err(RecvTimeoutError::Disconnected) => return Listening::Closed,
        };
        let heard = &mut received.1;
        heard.words += u64::from(line.is_ok());
        match line {
            Ok(Word::Message(message)) => heard.messages.push(message),
            Ok(Word::Failed { text }) if text.starts_with(&self.name) => heard.failure = Some(text),
            // A library that prints such a line does not name the unit.
            Ok(Word::Failed { text }) => heard.failure = Some(format!("{}: {text}", self.name)),
            Ok(Word::Ready { protocol, description }) => heard.ready = Some((protocol, description)),
            Err(text) => {
                let message = self.message(&heard.occasion, Level::Information, text);
                heard.messages.push(message);
            }
        }
        Listening::Said
    }

    /// Reads or changes what was received.
    pub fn heard<T>(&self, look: impl FnOnce(&mut Heard) -> T) -> T {
        look(&mut locked(&self.received).1)
    }

    /// Takes the messages.
    pub fn take_messages(&self) -> Vec<Message> {
        self.printed.store(0, Ordering::Relaxed);
        self.heard(|heard| std::mem::take(&mut heard.messages))
    }

    /// A message to be logged under the name of the unit.
    pub fn message(&self, occasion: &Occasion, level: Level, text: String) -> Message {
        let Occasion { step, iteration, time, .. } = *occasion;
        let (unit, source) = (self.name.clone(), "standard output".to_owned());
        Message { unit, level, step, iteration, time, source, text }
    }

    /// How the process ended; `None` while it runs.
    pub fn ending(&self) -> Option<String> {
        match locked(&self.child).try_wait() {
            Ok(status) => status.map(describe),
            // The status was collected elsewhere, or not at all if the parent process ignores SIGCHLD.
            Err(_) => Some("ended; its exit status is not known".to_owned()),
        }
    }

    /// Tells it that the run is over.
    pub fn tell_end(&self) {
        if let Some(input) = locked(&self.input).take() {
            // The process may have ended already.
            let _ = input.send(END);
        }
    }

    /// Kills it, and the processes that it has started.
    pub fn kill(&self) {
        self.kill_group();
        let mut child = locked(&self.child);
        // The process may have ended already.
        let _ = child.kill();
        let _ = child.wait();
    }

    /// Kills what it has started and left behind, such as the tool that computes for an FMU: its process group.
    fn kill_group(&self) {
        if let Some(group) = i32::try_from(self.id()).ok().and_then(Pid::from_raw) {
            // Mostly there is nobody.
            let _ = kill_process_group(group, Signal::KILL);
        }
    }
}

/// All units of a run. If one ends, the others are not waited for.
pub struct RunMates {
    pub processes: Vec<UnitProcess>,
    /// Left when all have ended.
    pub folder: Folder,
}

impl Drop for RunMates {
    /// Asks all processes to end, and kills those that do not end in time.
    fn drop(&mut self) {
        self.processes.iter().for_each(UnitProcess::tell_end);
        let began = Instant::now();
        for process in &self.processes {
            while process.ending().is_none() {
                if began.elapsed() > GRACE {
                    process.kill();
                    break;
                }
                std::thread::sleep(LOOK);
            }
            process.kill_group();
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes the task and later lines; runs on a thread of its own, so that a process that does not read blocks nobody.
fn speak(mut pipe: ChildStdin, task: &str, said: &Receiver<&'static str>) {
    // An ended process is noticed where its answer is awaited.
    let mut write = |line: &str| writeln!(pipe, "{line}").and_then(|()| pipe.flush()).is_ok();
    let _ = write(task) && said.iter().all(write);
}

/// Passes on every line of a process that is not blank, whether it is a [`Word`] or not.
fn listen(output: ChildStdout, heard: &Sender<Result<Word, String>>, printed: &AtomicU64) {
    let mut output = BufReader::new(output);
    let mut line = Vec::new();
    while output.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
        let text = || String::from_utf8_lossy(&line).trim_end().to_owned();
        let mut said = serde_json::from_slice(&line).map_err(|_| text());
        if let Err(text) = &mut said {
            let before = printed.fetch_add(text.len() as u64, Ordering::Relaxed);
            if before > MOST_PRINTED {
                text.clear();
            } else if before + text.len() as u64 > MOST_PRINTED {
                "it prints more than is kept: what follows in this step is left out".clone_into(text);
            }
        }
        if said != Err(String::new()) && heard.send(said).is_err() {
            return;
        }
        line.clear();
    }
}

fn describe(status: ExitStatus) -> String {
    match (status.signal(), status.code()) {
        (Some(SIGBUS), _) => {
            format!("was killed by signal {SIGBUS}, as when /dev/shm is full: see `df /dev/shm`")
        }
        (Some(signal), _) => format!("was killed by signal {signal}"),
        (None, Some(code)) => format!("ended with exit status {code}"),
        (None, None) => "ended".to_owned(),
    }
}
