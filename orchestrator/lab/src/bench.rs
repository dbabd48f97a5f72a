//! `cofferdam-lab bench`.

use crate::context::context;
use crate::terminal::{print, warn};
use cofferdam_analysis::study::StudyFolder;
use cofferdam_analysis::table::Table;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

/// Arguments of `cofferdam-lab bench`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders with a scene.toml, or .toml files
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    /// Another build of `cofferdam`, whose runs alternate with those of this build
    #[arg(short, long, value_name = "PROGRAM")]
    against: Option<PathBuf>,

    /// Scene for the other build if it cannot read the first (repeatable; one for each SCENE)
    #[arg(long, value_name = "SCENE", requires = "against")]
    its: Vec<PathBuf>,

    /// Number of turns of each scene
    #[arg(short = 'n', long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..))]
    turns: u8,

    /// Folder for bench.md and bench.csv; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Further arguments of every `run`
    #[arg(last = true, value_name = "ARGUMENT")]
    further: Vec<String>,
}

pub const HELP: &str = "\
Runs scenes and reports where their time goes, in seconds: the fastest turn and
the median of all. Every turn runs each scene twice, first with an empty cache
of prepared water operators, then with the cache filled by the first run.
`whole process` is the total time that a user waits.

With another build, each of its runs follows one of this build, so that both
experience the same machine load. The ratio is the median over the turns of its
time divided by the time of this build: 2 if this build is twice as fast.

The program is the `cofferdam` in the folder of `cofferdam-lab`. `cargo bench`
times the solvers and the exchange alone.

Examples:
  cofferdam-lab bench scenes/koyna-coarse
  cofferdam-lab bench scenes/koyna-coarse --against old/cofferdam \\
    -- --set dam.fidelity=reduced
      Is the reduced dam faster than it was?

Exit status: 0 completed, 1 a run failed or could not be started, 2 the
arguments do not fit together.";

/// Times of a run by their names, s.
type Times = Vec<(String, f64)>;

/// The runs of a program in one turn: with an empty cache, and again.
const RUNS: [&str; 2] = ["first", "again"];

pub fn run(arguments: &Arguments) -> ExitCode {
    let Arguments { scenes, against, its, .. } = arguments;
    if !its.is_empty() && its.len() != scenes.len() {
        warn(format!("{} scenes, but {} for the other build; give one for each", scenes.len(), its.len()));
        return ExitCode::from(2);
    }
    let folder = arguments.output.as_deref().map(|path| StudyFolder { path });
    if let Some(Err(error)) = folder.map(|folder| folder.claim()) {
        return failed(&error.to_string());
    }
    let here = match std::env::current_exe() {
        Ok(path) => path.with_file_name("cofferdam"),
        Err(error) => return failed(&error.to_string()),
    };
    if !here.is_file() {
        return failed(&format!(
            "{}: there is no such program; build it: `cargo build --release`",
            here.display()
        ));
    }
    let programs: Vec<&Path> = std::iter::once(here.as_path()).chain(against.as_deref()).collect();
    let mut headings = vec!["scene", "run", "time, s", "fastest", "median"];
    if against.is_some() {
        headings.extend(["other: fastest", "median", "ratio"]);
    }
    let mut table = Table::new(headings);
    for (index, scene) in scenes.iter().enumerate() {
        let scenes = [scene, its.get(index).unwrap_or(scene)];
        // Of each turn, of each program, of each run.
        let mut turns: Vec<Vec<[Times; 2]>> = Vec::new();
        for turn in 1..=arguments.turns {
            let mut of_turn = Vec::new();
            for (program, scene) in programs.iter().zip(scenes) {
                match both_runs(program, scene, &arguments.further) {
                    Ok(times) => of_turn.push(times),
                    Err(why) => return failed(&why),
                }
            }
            let whole = |times: &[Times; 2]| {
                times.each_ref().map(|times| format!("{:.2}", times[0].1)).join(", then ")
            };
            let said: Vec<String> = of_turn.iter().map(whole).collect();
            print(format!("{}, turn {turn}: {} s", scene.display(), said.join(" against ")));
            turns.push(of_turn);
        }
        for (run, name) in RUNS.iter().enumerate() {
            for (what, _) in &turns[0][0][run] {
                let of = |program: usize| -> Vec<f64> {
                    let times = turns.iter().map(|turn| time(&turn[program][run], what));
                    times.collect::<Option<_>>().unwrap_or_default()
                };
                let mut row = vec![scene.display().to_string(), (*name).to_owned(), what.clone()];
                row.extend(fastest_and_median(&of(0)));
                if against.is_some() {
                    let other = of(1);
                    row.extend(fastest_and_median(&other));
                    let ratios: Vec<f64> =
                        other.iter().zip(of(0)).map(|(other, this)| other / this).collect();
                    row.push(median(&ratios).map_or_else(String::new, |ratio| format!("{ratio:.2}")));
                }
                table.row(row);
            }
        }
    }
    print(format!("\n{}", table.markdown()));
    let written = folder.map_or(Ok(()), |folder| {
        folder.write("bench.md", &table.markdown(), &context())?;
        folder.write_table("bench.csv", &table, &context())
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(&error.to_string()),
    }
}

fn failed(why: &str) -> ExitCode {
    warn(why);
    ExitCode::FAILURE
}

/// Runs `scene` twice, with a cache that is empty at first.
fn both_runs(program: &Path, scene: &Path, further: &[String]) -> Result<[Times; 2], String> {
    let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    let [first, again] = RUNS.map(|name| one_run(program, scene, further, folder.path(), name));
    Ok([first?, again?])
}

fn one_run(
    program: &Path,
    scene: &Path,
    further: &[String],
    folder: &Path,
    name: &str,
) -> Result<Times, String> {
    let results = folder.join(name);
    let mut command = Command::new(program);
    command.arg("run").arg(scene).arg("--quiet").args(further).arg("--output").arg(&results);
    command.env("COFFERDAM_CACHE", folder.join("cache"));
    let began = Instant::now();
    let output = command.output().map_err(|error| format!("{}: {error}", program.display()))?;
    let whole = began.elapsed().as_secs_f64();
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{} run {}: {}\n{said}", program.display(), scene.display(), output.status));
    }
    // A log may be as large as the disk is.
    std::fs::remove_dir_all(&results).map_err(|error| format!("{}: {error}", results.display()))?;
    let mut times = vec![("whole process".to_owned(), whole)];
    times.extend(told(&String::from_utf8_lossy(&output.stdout)));
    Ok(times)
}

/// The times that a run tells at its begin and its end: `prepared in 0.98 s; …`, `wall time  2.29 s` and in the lines below it,
/// which are indented further, `dam  1.99 s  87 %`; earlier builds tell these on the same line, shares in parentheses.
fn told(output: &str) -> Times {
    let mut times = Times::new();
    let mut parts_below = None;
    for line in output.lines() {
        let text = line.trim_start();
        let indent = line.len() - text.len();
        let (text, name) = match (text.strip_prefix("prepared in "), text.strip_prefix("wall time ")) {
            (Some(rest), _) => (rest, Some("preparing")),
            (_, Some(rest)) => {
                parts_below = Some(indent);
                (rest, Some("run"))
            }
            _ if parts_below.is_some_and(|whole| indent > whole) => (text, None),
            _ => {
                parts_below = None;
                continue;
            }
        };
        let mut words = Vec::from_iter(name);
        for word in text.split_whitespace().take_while(|word| !word.ends_with(';')) {
            match word.parse() {
                Ok(seconds) if !words.is_empty() => {
                    times.push((words.join(" "), seconds));
                    words.clear();
                }
                // Units and shares.
                Err(_) if !["s", "%)", "%"].contains(&word) => words.push(word),
                _ => (),
            }
            words.retain(|word| !word.starts_with('('));
        }
    }
    times
}

fn time(times: &Times, what: &str) -> Option<f64> {
    times.iter().find(|(name, _)| name == what).map(|(_, seconds)| *seconds)
}

fn fastest_and_median(times: &[f64]) -> [String; 2] {
    let fastest = times.iter().copied().min_by(f64::total_cmp);
    [fastest, median(times)].map(|time| time.map_or_else(String::new, |time| format!("{time:.2}")))
}

/// The lower one of two in the middle.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len().saturating_sub(1) / 2).copied().filter(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_times_of_a_run_are_read_from_what_it_says() {
        let begin = "dam  560 elements\nprepared in 0.98 s; results go to runs/x\npeak sliding  12 mm\n";
        let now = "Time\n  wall time   2.29 s\n    dam   1.99 s   87 %\n    log and histories  0.10 s  5 %\nlog and 3 s\n";
        let earlier = "wall time                  2.29 s  dam 1.99 s (87 %)  log and histories 0.10 s (5 %)\nlog and 3 s\n";
        let expected = [("preparing", 0.98), ("run", 2.29), ("dam", 1.99), ("log and histories", 0.1)];
        for end in [now, earlier] {
            assert_eq!(
                told(&format!("{begin}{end}")),
                expected.map(|(name, seconds)| (name.to_owned(), seconds))
            );
        }
    }

    #[test]
    fn a_median_is_the_value_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0]), Some(1.0));
        assert_eq!(median(&[]), None);
    }
}
