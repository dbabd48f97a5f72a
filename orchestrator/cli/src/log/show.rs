//! `cofferdam log show`.

use super::{Failure, contacts, messages};
use crate::terminal::print;
use cofferdam_assembly::log::scene_of;
use cofferdam_assembly::units::DAM;
use cofferdam_coupling::convergence::Measure;
use cofferdam_coupling::participant::{Layout, Message};
use cofferdam_coupling::scheme::{IterationReport, Purpose};
use cofferdam_log::{Entry, Log, LoggedExchange, LoggedIteration, LoggedStep, LoggedUnit};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Arguments of `cofferdam log show`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Number of the communication step; 0 is initialisation
    #[arg(short, long, value_name = "N")]
    step: u64,
    /// Show this iteration only
    #[arg(short, long, value_name = "K")]
    iteration: Option<u32>,
    /// Show this attempt only; each attempt has a different step length
    #[arg(short, long, value_name = "A")]
    attempt: Option<u32>,
    /// Show all values of arrays, one per line
    #[arg(long)]
    values: bool,
    /// Show the contacts of the dam at the end of the step instead of the iterations
    #[arg(long, conflicts_with_all = ["iteration", "attempt", "values"])]
    contacts: bool,
}

pub const HELP: &str = "\
Shows, for every iteration of the step, how the guess was obtained, its
residual and the point with the largest residual (counted from 0 at the base);
the request and the response of each unit, with arrays of more than four values
as norm (√Σx²), minimum and maximum; the messages of the units; and how each
attempt ended. A convergence measure is satisfied if its ratio is at most 1;
coupling.measures of the scene selects the required measures.
`cofferdam log worst` finds the steps to look at.

With --contacts, shows opening, slip and stresses of each contact of the cracks
at the end of the step. Compression and the downstream direction are positive.
The log does not contain these values: the dam is created again from the scene
in the log and brought to the step from the last checkpoint by repeating the
logged requests. The numbers of sticking, slipping and open contacts of each
crack are those of the run.

Examples:
  cofferdam log show runs/koyna --step 812
  cofferdam log show runs/koyna --step 812 --contacts
  cofferdam log show runs/koyna --step 812 --iteration 3 --values

Exit status: 0; 1 if the log cannot be read or is damaged before the end of the
step; 2 there is no such step, attempt, iteration or contact; 4 the dam cannot
be brought to the step.";

/// Arrays of up to this many values are printed whole.
const FEW: usize = 4;

/// Contents of the log for a step.
#[derive(Default)]
struct Story {
    exchanges: Vec<LoggedExchange>,
    iterations: Vec<LoggedIteration>,
    messages: Vec<Message>,
    steps: Vec<LoggedStep>,
    cut: bool,
}

impl Story {
    /// Reads until the step is accepted, or to the end of the log.
    fn read(log: &Log, step: u64) -> Result<Self, Failure> {
        let mut story = Self::default();
        for entry in log.entries_from(step)? {
            match entry? {
                Entry::Exchange(exchange) if exchange.occasion.step == step => {
                    story.exchanges.push(exchange);
                }
                Entry::Iteration(iteration) => {
                    let [first, count] = iteration.steps;
                    if (first..first + count).contains(&step) {
                        story.iterations.push(iteration);
                    }
                }
                Entry::Message(message) if message.step == step => story.messages.push(message),
                Entry::Step(end) if end.occasion.step == step => {
                    let accepted = end.accepted;
                    story.steps.push(end);
                    if accepted {
                        break;
                    }
                }
                Entry::Cut(_) => story.cut = true,
                _ => {}
            }
        }
        Ok(story)
    }

    fn attempts(&self) -> BTreeSet<u32> {
        self.exchanges.iter().map(|exchange| exchange.occasion.attempt).collect()
    }
}

/// Prints what happened in a step.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::of_exchanges(&arguments.log)?;
    let story = Story::read(&log, arguments.step)?;
    let (path, step) = (log.path().to_owned(), arguments.step);
    if story.exchanges.is_empty() {
        let last = log.last_before("/step", u64::MAX)?.and_then(|end| end.step()).unwrap_or(0);
        return Err(Failure::Step { path, step, last });
    }
    if arguments.contacts {
        let accepted = story.exchanges.iter().rfind(|exchange| exchange.unit == DAM && exchange.accepted);
        let Some(accepted) = accepted else {
            let why = format!("step {step} was not accepted; choose an earlier step");
            return Err(Failure::NoContacts { path, why });
        };
        return contacts::show(&log, accepted);
    }
    let wanted = |exchange: &&LoggedExchange| {
        let at = exchange.occasion;
        arguments.attempt.is_none_or(|attempt| at.attempt == attempt)
            && arguments.iteration.is_none_or(|iteration| at.iteration == iteration)
    };
    let exchanges: Vec<&LoggedExchange> = story.exchanges.iter().filter(wanted).collect();
    if exchanges.is_empty() {
        return Err(missing(path, &story, arguments));
    }
    let coupling = scene_of(&log).map(|scene| scene.coupling).unwrap_or_default();
    let limit = DisplacementLimit {
        tolerance: coupling.tolerance.relative(),
        required: coupling.measures.contains(&Measure::Change),
    };
    let mut at = None;
    for exchange in &exchanges {
        let occasion = exchange.occasion;
        if at.is_none_or(|(attempt, _)| attempt != occasion.attempt) {
            print(heading(&story, exchange));
        }
        if at != Some((occasion.attempt, occasion.iteration)) {
            at = Some((occasion.attempt, occasion.iteration));
            print(format!("  iteration {}", occasion.iteration));
            let iterations = story.iterations.iter().filter(|i| i.attempt == occasion.attempt);
            let report = iterations.map(|i| i.report).find(|report| report.iteration == occasion.iteration);
            report.iter().flat_map(|report| did(report, limit)).for_each(|line| print(format!("    {line}")));
        }
        show_exchange(log.head().unit(exchange.unit), exchange, arguments.values);
    }
    if !story.messages.is_empty() {
        print("  messages");
    }
    for message in &story.messages {
        print(
            messages::lines(message).lines().map(|line| format!("    {line}")).collect::<Vec<_>>().join("\n"),
        );
    }
    Ok(())
}

fn missing(path: PathBuf, story: &Story, arguments: &Arguments) -> Failure {
    let Arguments { step, iteration, attempt, .. } = *arguments;
    let attempts = story.attempts();
    let known_attempt = attempt.filter(|attempt| attempts.contains(attempt));
    let (what, known) = match (attempt, iteration) {
        (Some(attempt), _) if known_attempt.is_none() => {
            (format!("attempt {attempt}"), format!("attempts 1 to {}", attempts.last().unwrap_or(&0)))
        }
        _ => {
            let of_attempt =
                story.exchanges.iter().filter(|e| attempt.is_none_or(|a| e.occasion.attempt == a));
            let most = of_attempt.map(|e| e.occasion.iteration).max().unwrap_or(0);
            (format!("iteration {}", iteration.unwrap_or(0)), format!("iterations 1 to {most}"))
        }
    };
    Failure::Iteration { path, step, what, known }
}

/// The step, its length, and how this attempt ended.
fn heading(story: &Story, exchange: &LoggedExchange) -> String {
    let at = exchange.occasion;
    if at.step == 0 {
        return "step 0: initialisation".to_owned();
    }
    let when = format!("from t = {:.6} s to {:.6} s, H = {:.4e} s", at.time, at.end(), at.communication_step);
    let end = story.steps.iter().find(|step| step.occasion.attempt == at.attempt);
    let how = match end {
        None if story.cut => "the log is cut short here".to_owned(),
        None => "the run ended here".to_owned(),
        // The outcome has the residual, if there is one.
        Some(step) if !step.accepted && !["", "converged"].contains(&step.outcome.as_str()) => {
            format!("not accepted, iteration {}: {}", step.occasion.iteration, step.outcome)
        }
        Some(step) => {
            let iterations = step.occasion.iteration;
            let how = match (step.accepted, step.converged) {
                _ if !["", "converged"].contains(&step.outcome.as_str()) => &step.outcome,
                (true, true) => "converged, accepted",
                (true, false) => "NOT CONVERGED, accepted",
                (false, true) => "converged, repeated with another length: its error was too large",
                (false, false) => "did not converge; repeated with another length, or the run ended",
            };
            let plural = if iterations == 1 { "" } else { "s" };
            format!("{iterations} iteration{plural}, {how}; pressure residual {:.3e} Pa", step.residual)
        }
    };
    format!("step {}, attempt {}: {when}\n  {how}", at.step, at.attempt)
}

/// The tolerance as a limit for changes of displacements, and whether the scene requires it.
#[derive(Clone, Copy)]
struct DisplacementLimit {
    tolerance: f64,
    required: bool,
}

/// Description of an iteration.
fn did(report: &IterationReport, limit: DisplacementLimit) -> Vec<String> {
    let IterationReport { iteration, purpose, correction, residuals, worst } = report;
    let acceleration = correction.acceleration.word();
    let mut lines = vec![match purpose {
        Purpose::Solution if *iteration == 1 => "guess: of the predictor".to_owned(),
        Purpose::Solution => {
            let secants = correction.secants;
            let of_secants = match secants.known {
                0 => String::new(),
                known => format!(
                    ", {} secants used of {} independent of {known} known",
                    secants.used, secants.independent
                ),
            };
            let jacobian = correction.jacobian.word();
            let relaxation = correction.relaxation;
            format!("guess: by {acceleration}, relaxation {relaxation:.4}{of_secants}; Jacobian: {jacobian}")
        }
        Purpose::Jacobian => "guess: one unknown is moved, to measure the Jacobian".to_owned(),
        Purpose::States => "guess: the one before, again: do the units return to their states?".to_owned(),
        Purpose::RoundingFloor => {
            "guess: the one before, moved by rounding, to measure the rounding floor".to_owned()
        }
    }];
    if let Some(residuals) = residuals {
        lines.push(format!(
            "residual: {:.3e} Pa; {:.3e} of its limit by the pressure, {:.3e} of that by the first residual",
            residuals.norm, residuals.relative_ratio, residuals.reduction_ratio
        ));
        if residuals.change.is_finite() {
            let displacement = residuals.change;
            let DisplacementLimit { tolerance, required } = limit;
            let required = if required { "" } else { " (not required)" };
            lines.push(format!(
                "displacement: changed by {displacement:.3e} of itself, limit {tolerance:e}{required}"
            ));
        }
    }
    if let Some(worst) = worst {
        lines.push(format!(
            "farthest: point {} of interface {} in step {}: given {:.6e} Pa, answered {:.6e} Pa",
            worst.point, worst.interface, worst.step, worst.given, worst.answered
        ));
    }
    lines
}

fn show_exchange(unit: &LoggedUnit, exchange: &LoggedExchange, values: bool) {
    let accepted = if exchange.accepted { ", accepted" } else { "" };
    print(format!("    {} (exchange {}{accepted})", unit.name, exchange.sequence));
    show_half("request", &unit.inputs, &exchange.inputs, values);
    match &exchange.outputs {
        Some(outputs) => show_half("answer", &unit.outputs, outputs, values),
        None => print("      answer   none: the unit failed"),
    }
}

fn show_half(half: &str, layout: &Layout, all: &[f64], whole: bool) {
    let mut half = half;
    for (channel, range) in layout.channels() {
        let values = &all[range];
        let unit = if channel.unit == "1" { "" } else { &channel.unit };
        let line = |text: String| format!("      {half:<8} {:<34} {text}", channel.name);
        match values {
            [value] if !channel.shape.is_array() => print(line(format!("{value:>14.6e} {unit}")).trim_end()),
            values if values.len() <= FEW => {
                let numbers: Vec<String> = values.iter().map(|value| format!("{value:>14.6e}")).collect();
                print(line(format!("{} {unit}", numbers.join(" "))).trim_end());
            }
            values => {
                let norm = values.iter().map(|x| x * x).sum::<f64>().sqrt();
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let count = values.len();
                print(line(format!(
                    "norm {norm:.6e}, from {least:.6e} to {most:.6e} {unit}, {count} values"
                )));
                let numbered = values.iter().enumerate().filter(|_| whole);
                numbered.for_each(|(i, value)| print(format!("{:>49} {value:>22e}", format!("[{i}]"))));
            }
        }
        half = "";
    }
}
