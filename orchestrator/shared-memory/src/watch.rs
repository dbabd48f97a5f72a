use super::process::{Listening, RunMates, UnitProcess};
use super::{LOOK, WORDS};
use crate::transport::TransportError;
use cofferdam_coupling::participant::ParticipantError;
use std::fmt::Display;
use std::time::{Duration, Instant};

/// Longest interval between two checks that counts as waiting: time in which this process was suspended does not
/// count.
const LONGEST_LOOK: Duration = Duration::from_millis(100);
/// Time after a broken connection in which the end of a process explains it.
const LAST_BREATH: Duration = Duration::from_millis(300);

/// Checks all units of a run while one of them is awaited.
pub struct Watch<'a> {
    run_mates: &'a RunMates,
    limit: Duration,
    waited: Duration,
    looked: Instant,
}

impl<'a> Watch<'a> {
    pub fn new(run_mates: &'a RunMates, limit: Duration) -> Self {
        Self { run_mates, limit, waited: Duration::ZERO, looked: Instant::now() }
    }

    /// Fails if a unit has ended, or if the `awaited` one has taken too long; checks only every few milliseconds.
    pub fn look(&mut self, awaited: &str, when: &dyn Display) -> Result<(), ParticipantError> {
        let since = self.looked.elapsed();
        if since < LOOK {
            return Ok(());
        }
        self.looked = Instant::now();
        self.waited += since.min(LONGEST_LOOK);
        self.run_mates.processes.iter().try_for_each(|process| alive(process, when))?;
        if self.waited < self.limit {
            return Ok(());
        }
        self.run_mates
            .processes
            .iter()
            .filter(|process| process.name == awaited)
            .for_each(|process| process.kill());
        let (participant, seconds, when) = (awaited.to_owned(), self.limit.as_secs_f64(), when.to_string());
        Err(ParticipantError::Hung { participant, seconds, when })
    }
}

/// Fails if a process has ended, with its last message.
fn alive(process: &UnitProcess, when: &dyn Display) -> Result<(), ParticipantError> {
    let Some(how) = process.ending() else { return Ok(()) };
    let began = Instant::now();
    while process.listen(LOOK) != Listening::Closed && began.elapsed() < WORDS {}
    Err(match process.heard(|heard| heard.failure.take()) {
        Some(text) => ParticipantError::Reported { text },
        None => ParticipantError::Ended { participant: process.name.clone(), how, when: when.to_string() },
    })
}

/// The end of a process that explains a broken connection, else the error itself.
pub fn explained(run_mates: &RunMates, error: TransportError, when: &dyn Display) -> ParticipantError {
    let began = Instant::now();
    while matches!(error, TransportError::NotConnected { .. } | TransportError::SharedMemory { .. })
        && began.elapsed() < LAST_BREATH
    {
        if let Err(ended) = run_mates.processes.iter().try_for_each(|process| alive(process, when)) {
            return ended;
        }
        std::thread::sleep(LOOK);
    }
    error.into()
}
