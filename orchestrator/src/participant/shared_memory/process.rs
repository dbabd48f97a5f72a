use super::words::{END, Task, Word};
use crate::participant::{Level, Message, Occasion, ParticipantError};
use crate::transport::Folder;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A unit's process: start, end, and what it writes to its standard output.
pub struct UnitProcess {
    pub name: String,
    child: Mutex<Child>,
    /// Sends lines to its standard input, which stays open.
    input: Mutex<Option<Sender<&'static str>>>,
    received: Mutex<(Receiver<Result<Word, String>>, Heard)>,
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
const SIGBUS: i32 = 7;

impl UnitProcess {
    /// Starts `command` and gives it its task.
    ///
    /// The process gets a process group of its own, so that Ctrl-C in a terminal reaches only the orchestrator.
    pub fn start(mut command: Command, task: &Task) -> Result<Self, ParticipantError> {
        let name = task.unit.clone();
        let failed = |cause| ParticipantError::NotStarted { participant: name.clone(), cause };
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).process_group(0);
        let mut child = command.spawn().map_err(failed)?;
        let (heard, lines) = channel();
        let (input, said) = channel();
        let (output, pipe) = (child.stdout.take(), child.stdin.take());
        let received = (lines, Heard::default()).into();
        let started = Self { child: child.into(), input: Some(input).into(), received, name: name.clone() };
        let threads = || -> std::io::Result<()> {
            let thread = std::thread::Builder::new;
            if let Some(output) = output {
                thread().spawn(move || listen(output, &heard))?;
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
            Ok(Word::Failed { text }) => heard.failure = Some(text),
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

    /// Kills it.
    pub fn kill(&self) {
        let mut child = locked(&self.child);
        // The process may have ended already.
        let _ = child.kill();
        let _ = child.wait();
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

/// Passes on every line of a process, whether it is a [`Word`] or not.
fn listen(output: ChildStdout, heard: &Sender<Result<Word, String>>) {
    let mut output = BufReader::new(output);
    let mut line = Vec::new();
    while output.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
        let text = || String::from_utf8_lossy(&line).trim_end().to_owned();
        if heard.send(serde_json::from_slice(&line).map_err(|_| text())).is_err() {
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
