//! `cofferdam-lab seek`.

use crate::context::making;
use crate::study::{Arguments, StudyError, quoted};
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::Assembly;
use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::participant::Description;
use cofferdam_coupling::scheme::WindowReport;
use cofferdam_log::{Entry, Log, LogReadError, LogWriter, Preamble};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

pub const HELP: &str = "\
Measures how long it takes to find a step in a long log, and how much of the
log is read. The exchanges of a run of the scene are repeated until the log has
the given size. Then steps at random places are looked up: by the summary of
the finished log, and, with the summary cut off, by the frames of the log's
records. The log is removed afterwards.

Writes seek.md and seek.csv.

Example:
  cofferdam-lab seek scenes/koyna-coarse --output studies/seek --size 1GB \\
    --set ground_motion.record.start=4 --set ground_motion.record.end=5 \\
    --set time.quiet=0

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid, 3 a run failed, 4 a unit cannot be created.";

/// Arguments of the study.
#[derive(clap::Args)]
pub struct SeekArguments {
    #[command(flatten)]
    arguments: Arguments,

    /// Size of the log, with the unit kB, MB or GB
    #[arg(long, default_value = "1GB", value_parser = size)]
    size: u64,
}

/// Bytes of a text such as `1GB`.
fn size(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let unit = match text[digits.len()..].trim() {
        "kB" => 1_000,
        "MB" => 1_000_000,
        "GB" => 1_000_000_000,
        _ => return Err("give a whole number with kB, MB or GB, such as 200MB".to_owned()),
    };
    let number = digits.parse::<u64>().ok().filter(|number| (1..=1000).contains(number));
    number.map(|number| number * unit).ok_or_else(|| "give a whole number from 1 to 1000".to_owned())
}

/// Steps that are looked for in each way.
const SOUGHT: u64 = 50;
const COARSE: u64 = 8;

/// Keeps what a log is written from.
#[derive(Default)]
struct Kept {
    units: Vec<Description>,
    reports: Vec<WindowReport>,
    ending: Option<Ending>,
}

impl Observer for Kept {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        self.units.clone_from(&start.units);
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.reports.push(report.clone());
        Ok(())
    }

    fn end(&mut self, ending: &Ending) -> Result<(), ObserverError> {
        self.ending = Some(ending.clone());
        Ok(())
    }
}

pub fn run(SeekArguments { arguments, size }: &SeekArguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let failed = |what: &str, cause| StudyError::Run { what: what.to_owned(), cause: Box::new(cause) };
    let graph = Assembly::with(&loaded.scene, making(threads(None))).graph()?;
    let title = &loaded.scene.title;
    let mut simulation =
        simulation_of(&loaded.scene, &loaded.ground_motion, graph).map_err(|cause| failed(title, cause))?;
    let mut kept = Kept::default();
    if let (_, Some(cause)) = simulation.run(&mut [&mut kept], &AtomicBool::new(false)) {
        return Err(failed(title, cause));
    }
    let path = arguments.output.join("log.mcap");
    let wrong =
        |cause: Box<dyn std::error::Error + Send + Sync>| StudyError::File { path: path.clone(), cause };
    let scene = toml::to_string(&loaded.scene).map_err(|cause| wrong(cause.into()))?;
    let preamble = Preamble { scene, version: env!("CARGO_PKG_VERSION").to_owned(), ..Preamble::default() };
    let start = Start {
        units: kept.units.clone(),
        signals: &ground_signals(&loaded.ground_motion),
        stepping: loaded.scene.stepping(),
    };
    let steps = repeat(&path, &preamble, &start, &kept, *size).map_err(|cause| wrong(cause.into()))?;
    let sought = if arguments.coarse { COARSE } else { SOUGHT };
    let table = measure(&path, steps, sought).map_err(|cause| wrong(cause.into()));
    std::fs::remove_file(&path).map_err(|cause| wrong(cause.into()))?;
    let (table, bytes) = table?;
    let text = format!(
        "`cofferdam-lab seek {}{}`: {sought} steps at random places of a log of {:.0} MB with {steps} steps\n\n{}",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        1e-6 * bytes as f64,
        table.markdown(),
    );
    print(&text);
    arguments.write("seek.md", &text)?;
    arguments.write_table("seek.csv", &table)
}

/// Writes the log `path` of at least `size` bytes: the kept windows again and again, each time later. Returns the last step.
fn repeat(
    path: &Path,
    preamble: &Preamble,
    start: &Start<'_>,
    kept: &Kept,
    size: u64,
) -> Result<u64, ObserverError> {
    let mut log = LogWriter::create(path, preamble)?;
    log.begin(start)?;
    let (mut step, mut time) = (0, 0.0);
    loop {
        let mut end = (step, time);
        for report in kept.reports.iter().filter(|report| step == 0 || report.step() > 0) {
            let mut report = report.clone();
            for interval in &mut report.steps {
                interval.step += step;
                interval.time += time;
            }
            for exchange in &mut report.exchanges {
                exchange.occasion.step += step;
                exchange.occasion.time += time;
            }
            end = report.steps.last().map_or(end, |last| (last.step, last.end()));
            log.window(&report)?;
        }
        let there = std::fs::metadata(path).map_or(u64::MAX, |metadata| metadata.len());
        // A run without steps never grows.
        if there >= size || end.0 == step {
            if let Some(ending) = &kept.ending {
                log.end(&Ending { time: end.1, ..ending.clone() })?;
            }
            return Ok(end.0);
        }
        (step, time) = end;
    }
}

/// Looks for steps in both ways; the table, and the length of the log (bytes).
fn measure(path: &Path, steps: u64, sought: u64) -> Result<(Table, u64), LogReadError> {
    let headings = ["by", "target", "median, ms", "longest, ms", "mean read, MB", "largest read, MB"];
    let mut table = Table::new(headings);
    let open = |cause| LogReadError::Open { path: path.to_owned(), cause };
    let bytes = std::fs::metadata(path).map_err(open)?.len();
    for cut in [false, true] {
        if cut {
            let file = std::fs::OpenOptions::new().write(true).open(path).map_err(open)?;
            file.set_len(bytes - 16).map_err(open)?;
        }
        let by = if cut { "frames of the records" } else { "summary" };
        for what in ["first exchange of a step", "last `/step` before it"] {
            let (mut times, mut read) = (Vec::new(), Vec::new());
            let mut number = 0_u64;
            for _ in 0..sought {
                // A linear congruential generator (Knuth), so that everyone looks for the same steps.
                number =
                    number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let step = 1 + (number >> 33) % steps.max(1);
                let began = Instant::now();
                let log = Log::open(path)?;
                let found = match what {
                    "first exchange of a step" => log.entries_from(step)?.next().transpose()?,
                    _ => log.last_before("/step", step)?,
                };
                times.push(1e3 * began.elapsed().as_secs_f64());
                read.push(1e-6 * log.bytes_read() as f64);
                debug_assert!(found.as_ref().and_then(Entry::step).is_some_and(|found| found <= step));
            }
            times.sort_by(f64::total_cmp);
            let most = |values: &[f64]| values.iter().fold(0.0_f64, |a, b| a.max(*b));
            table.row([
                by.to_owned(),
                what.to_owned(),
                format!("{:.1}", times[times.len() / 2]),
                format!("{:.1}", most(&times)),
                format!("{:.2}", read.iter().sum::<f64>() / read.len() as f64),
                format!("{:.2}", most(&read)),
            ]);
        }
    }
    Ok((table, bytes))
}
