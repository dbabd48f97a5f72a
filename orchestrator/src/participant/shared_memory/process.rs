use super::words::{END, Task, Word};
use crate::participant::ParticipantError;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A unit's process: its life and what it says.
pub struct UnitProcess {
    pub name: String,
    child: Mutex<Child>,
    input: Mutex<Option<ChildStdin>>,
    lines: Mutex<Receiver<Result<Word, String>>>,
}

/// How long a process may take to end by itself; its own limit is half of it.
const GRACE: Duration = Duration::from_secs(1);
/// Between two looks at a process that is ending.
const LOOK: Duration = Duration::from_millis(1);

impl UnitProcess {
    /// Starts `command` and gives it its task.
    ///
    /// It gets a process group of its own, so that Ctrl-C in a terminal reaches the orchestrator alone.
    pub fn start(mut command: Command, task: &Task) -> Result<Self, ParticipantError> {
        let name = task.unit.clone();
        let failed = |cause| ParticipantError::NotStarted { participant: name.clone(), cause };
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).process_group(0);
        let mut child = command.spawn().map_err(failed)?;
        let (sender, lines) = channel();
        if let Some(output) = child.stdout.take() {
            std::thread::spawn(move || listen(output, &sender));
        }
        let mut input = child.stdin.take();
        if let (Some(input), Ok(line)) = (&mut input, serde_json::to_string(task)) {
            // A process that has ended already is noticed by whoever waits for it to be ready.
            let _ = writeln!(input, "{line}").and_then(|()| input.flush());
        }
        Ok(Self { child: child.into(), input: input.into(), lines: lines.into(), name: name.clone() })
    }

    /// Its number in the system.
    pub fn id(&self) -> u32 {
        locked(&self.child).id()
    }

    /// What it says next, if it says something within `patience`: a word, or a line that is none.
    pub fn line(&self, patience: Duration) -> Option<Result<Word, String>> {
        match locked(&self.lines).recv_timeout(patience) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                // It has ended, or will: not at once again.
                std::thread::sleep(patience.min(LOOK));
                None
            }
        }
    }

    /// How it ended, if it has.
    pub fn ending(&self) -> Option<String> {
        locked(&self.child).try_wait().ok().flatten().map(describe)
    }

    /// Lets it end by itself, and kills it if it does not.
    pub fn end(&self) {
        if let Some(mut input) = locked(&self.input).take() {
            // It may have ended before.
            let _ = writeln!(input, "{END}");
        }
        let began = Instant::now();
        while self.ending().is_none() {
            if began.elapsed() > GRACE {
                return self.kill();
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Kills it.
    pub fn kill(&self) {
        let mut child = locked(&self.child);
        // It may have ended before.
        let _ = child.kill();
        let _ = child.wait();
    }
}

impl Drop for UnitProcess {
    fn drop(&mut self) {
        self.end();
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Passes on what a process says.
fn listen(output: ChildStdout, sender: &Sender<Result<Word, String>>) {
    // Whatever else a process writes there, the words behind it count.
    for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
        let text = || String::from_utf8_lossy(&line).into_owned();
        if sender.send(serde_json::from_slice(&line).map_err(|_| text())).is_err() {
            return;
        }
    }
}

fn describe(status: ExitStatus) -> String {
    match (status.signal(), status.code()) {
        (Some(signal), _) => format!("was killed by signal {signal}"),
        (None, Some(code)) => format!("ended with exit status {code}"),
        (None, None) => "ended".to_owned(),
    }
}
