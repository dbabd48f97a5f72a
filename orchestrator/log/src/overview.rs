use super::{Entry, Log, LogReadError, LoggedDamage, LoggedEnd, Traffic};
use cofferdam_coupling::participant::Level;
use std::collections::BTreeMap;
use std::fmt;

/// Summary of a log.
#[derive(Debug, Default)]
pub struct Overview {
    /// Communication steps that were taken.
    pub steps: u64,
    /// Number of them that did not converge.
    pub unconverged: u64,
    /// Time reached, s.
    pub time: f64,
    /// Iterations of all steps, and the largest number of one step.
    pub iterations: [u64; 2],
    /// Exchanges.
    pub exchanges: u64,
    /// Number of them without an answer.
    pub unanswered: u64,
    /// Checkpoints.
    pub checkpoints: u64,
    /// Messages of the units by level: debug, information, warning, error.
    pub messages: [u64; 4],
    /// Messages and bytes by topic.
    pub traffic: BTreeMap<String, Traffic>,
    /// Length of the file, bytes.
    pub size: u64,
    /// How the run ended; `None` if the log is cut short or damaged.
    pub end: Option<LoggedEnd>,
    /// Where it is cut off, bytes from the beginning.
    pub cut: Option<u64>,
    /// Whether the run was writing it when it was opened.
    pub running: bool,
    /// What is missing, if it was recovered.
    pub damage: Vec<LoggedDamage>,
    /// Why it could not be read to its end, or what is wrong with its index; entries before the error are counted.
    pub error: Option<LogReadError>,
}

impl Overview {
    /// Reads a log from beginning to end, or to where it is cut short or damaged.
    ///
    /// **Errors**: the log can no longer be opened.
    pub fn of(log: &Log) -> Result<Self, LogReadError> {
        let mut entries = log.entries()?;
        let mut overview = Self { size: entries.size(), running: entries.running(), ..Self::default() };
        for entry in entries.by_ref() {
            match entry {
                Err(error) => overview.error = Some(error),
                Ok(Entry::Exchange(exchange)) => {
                    overview.exchanges += 1;
                    overview.unanswered += u64::from(exchange.outputs.is_none());
                }
                Ok(Entry::Step(step)) => {
                    if step.accepted && step.occasion.step > 0 {
                        overview.unconverged += u64::from(!step.converged);
                        let iterations = u64::from(step.occasion.iteration);
                        overview.steps += 1;
                        overview.time = step.occasion.end();
                        overview.iterations[0] += iterations;
                        overview.iterations[1] = overview.iterations[1].max(iterations);
                    }
                }
                Ok(Entry::Message(message)) => {
                    overview.messages[match message.level {
                        Level::Debug => 0,
                        Level::Information => 1,
                        Level::Warning => 2,
                        Level::Error => 3,
                    }] += 1;
                }
                Ok(Entry::Iteration(_)) => {}
                Ok(Entry::Checkpoint(_)) => overview.checkpoints += 1,
                Ok(Entry::Damage(_)) => {}
                Ok(Entry::End(end)) => overview.end = Some(end),
                Ok(Entry::Cut(position)) => overview.cut = Some(position),
            }
        }
        if overview.error.is_none() {
            overview.error = entries.check_index().err();
        }
        overview.damage = entries.damage().to_vec();
        overview.traffic = entries.traffic().into_iter().map(|(t, n)| (t.to_owned(), n)).collect();
        Ok(overview)
    }

    /// How the run ended, or where its log is cut short.
    pub fn ending(&self) -> String {
        let Self { steps, time, size, .. } = self;
        match (&self.end, self.cut) {
            (Some(end), _) => end.status.clone(),
            (None, Some(_)) if self.running => format!("running: so far step {steps}, t = {time:.4} s"),
            (None, Some(position)) => {
                format!("cut short at byte {position} of {size}, after step {steps}, t = {time:.4} s")
            }
            (None, None) => format!("unknown: damaged after step {steps}, t = {time:.4} s"),
        }
    }
}

impl fmt::Display for Overview {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |name: &str, text: String| writeln!(f, "{name:<12} {text}");
        let unconverged = match self.unconverged {
            0 => String::new(),
            count => format!(", {count} of them NOT CONVERGED"),
        };
        line("steps", format!("{}, to t = {:.4} s{unconverged}", self.steps, self.time))?;
        let [all, most] = self.iterations;
        let mean = all as f64 / self.steps.max(1) as f64;
        line("iterations", format!("mean {mean:.2} a step, most {most}"))?;
        let without = match self.unanswered {
            0 => String::new(),
            n => format!(", {n} without an answer"),
        };
        line("exchanges", format!("{}{without}", self.exchanges))?;
        line("checkpoints", self.checkpoints.to_string())?;
        let [debug, information, warning, error] = self.messages;
        let messages = format!("{error} errors, {warning} warnings, {information} others");
        line("messages", if debug > 0 { format!("{messages}, {debug} for debugging") } else { messages })?;
        line("size", format!("{:.1} MB", 1e-6 * self.size as f64))?;
        for (topic, Traffic { messages, bytes }) in &self.traffic {
            line("", format!("{topic:<20} {messages:>9} messages {:>9.1} MB", 1e-6 * *bytes as f64))?;
        }
        for damage in &self.damage {
            line("missing", damage.to_string())?;
        }
        line("ended", self.ending())
    }
}
