//! A run that was interrupted, however, and is resumed, is the run that was not: every exchange, iteration and step of the log,
//! every table and the summary, bit for bit but for wall times.

use crate::log::{cofferdam, records, rewrite, text};
use crate::processes::{Running, alone};
use cofferdam_log::{Entry, Log, compare};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use toml::{Table, Value};
use whole_chain::process::{signal, wait_until};
use whole_chain::python;
use whole_chain::scenario::{Scenario, binary, root};

/// Strong motion on a coarse mesh, with many checkpoints.
fn scene(duration: f64) -> Scenario {
    let mut scenario = Scenario::quick(duration);
    scenario.set("ground_motion.record.start", 4.0).set("dam.element_size", 16.0);
    scenario.set("log", Table::from_iter([("checkpoint_share".to_owned(), 1.0.into())]));
    scenario
}

const IN_PROCESS: [&str; 2] = ["--transport", "in-process"];

/// Runs the scene; the folder of its results.
fn run(scenario: &Scenario, output: &str, options: &[&str]) -> PathBuf {
    let done = scenario.command(output).args(options).output().expect("cofferdam runs");
    assert!(done.status.success(), "{output}: {}", String::from_utf8_lossy(&done.stderr));
    scenario.folder().join(output)
}

/// Exit status and words of `cofferdam resume`.
fn try_resume(run: &Path, options: &[&str]) -> (Option<i32>, String) {
    let (status, said) = cofferdam(&[&["resume", text(run), "--quiet"], options].concat());
    (status, said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" "))
}

/// Resumes a run; the step after which it went on, 0 for initialisation.
fn resume(run: &Path, options: &[&str]) -> u64 {
    let (status, said) = try_resume(run, options);
    assert_eq!(status, Some(0), "{}: {said}", run.display());
    let step = said.split("continues after step ").nth(1).and_then(|after| after.split(',').next());
    assert!(step.is_some() || said.contains("no checkpoint: the run starts again"), "{said}");
    step.map_or(0, |step| step.parse().expect("a number"))
}

/// The entries of the log of a run without wall times, and without the state of the run, which has some.
fn timeless(run: &Path) -> Vec<Entry> {
    let mut entries: Vec<Entry> = crate::log::entries(&run.join("log.mcap")).expect("a sound log");
    for entry in &mut entries {
        match entry {
            Entry::Exchange(exchange) => exchange.wall_time = [0.0; 2],
            Entry::Step(step) => step.unit_times.clear(),
            Entry::Checkpoint(checkpoint) => checkpoint.run.clear(),
            _ => {}
        }
    }
    entries
}

/// The summary in the manifest of a run, and what it was made from.
fn summary(run: &Path) -> Table {
    let text = fs::read_to_string(run.join("manifest.toml")).expect("a manifest");
    let mut table: Table = text.parse().expect("TOML");
    for key in ["started", "name", "build"] {
        table.remove(key);
    }
    table
}

/// All results are equal.
fn assert_equal(whole: &Path, resumed: &Path) {
    let shown = resumed.display();
    let logs = [whole, resumed].map(|run| Log::open(run).expect("a log"));
    let same = compare(logs.each_ref()).expect("logs");
    assert!(same.identical() && same.settings.is_empty(), "{shown}: {same:?}");
    assert!(same.endings.iter().all(|ending| ending.as_deref() == Some("completed")), "{shown}: {same:?}");
    let entries = [whole, resumed].map(timeless);
    let differing = entries[0].iter().zip(&entries[1]).find(|(a, b)| format!("{a:?}") != format!("{b:?}"));
    assert!(differing.is_none(), "{shown}: {differing:?}");
    assert_eq!(entries[0].len(), entries[1].len(), "{shown}");
    assert_eq!(summary(whole), summary(resumed), "{shown}");
    let files = |run: &Path| {
        let names = fs::read_dir(run).expect("a folder").map(|file| file.expect("a file").file_name());
        let mut names: Vec<_> = names.collect();
        names.sort();
        names
    };
    assert_eq!(files(whole), files(resumed), "{shown}");
    for name in files(whole) {
        let name = Path::new(&name);
        if name
            .extension()
            .is_some_and(|kind| ["csv", "svg", "vtm", "vtu"].iter().any(|wanted| kind == *wanted))
        {
            let bytes = [whole, resumed].map(|run| fs::read(run.join(name)).expect("a table"));
            assert!(bytes[0] == bytes[1], "{shown}: {} differs", name.display());
        }
    }
}

/// A copy of the run's folder with `bytes` as its log.
fn with_log(run: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let folder = run.with_file_name(name);
    fs::create_dir(&folder).expect("a folder");
    for file in fs::read_dir(run).expect("a folder").flatten() {
        fs::copy(file.path(), folder.join(file.file_name())).expect("a copy");
    }
    fs::write(folder.join("log.mcap"), bytes).expect("written");
    folder
}

/// Numbers from 0 to 1 (Knuth's generator).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The run up to a time is the beginning of the run, and continued it is the run.
fn until_and_on(scenario: &Scenario, until: f64, options: &[&str]) -> u64 {
    let whole = run(scenario, "whole", options);
    let until = until.to_string();
    let part = run(scenario, "part", &[options, &["--until", &until]].concat());
    let (all, first) = (timeless(&whole), timeless(&part));
    let (Some(Entry::End(end)), before) = (first.last(), &first[..first.len() - 1]) else {
        panic!("{:?}", first.last())
    };
    assert!(end.status.contains("--until") && before.len() > 20, "{end:?}");
    let differing = before.iter().zip(&all).find(|(a, b)| format!("{a:?}") != format!("{b:?}"));
    assert!(differing.is_none(), "{differing:?}");
    let step = resume(&part, options);
    assert_equal(&whole, &part);
    step
}

#[test]
fn a_run_up_to_a_time_is_its_beginning_and_goes_on_to_the_same_end() {
    let step = until_and_on(&scene(1.0), 0.5, &IN_PROCESS);
    assert!((150..=200).contains(&step), "{step}");
    assert!(until_and_on(&scene(0.3), 0.2, &["--transport", "shared-memory"]) > 40);
    let mut none = scene(0.2);
    none.set("log.checkpoint_share", 0.0);
    assert_eq!(until_and_on(&none, 0.1, &IN_PROCESS), 0, "it starts again");
}

/// Lengths of steps, windows, halved steps, states of water and dam of every kind.
#[test]
fn every_way_of_stepping_and_every_fidelity_goes_on() {
    let adaptive = [("tolerance", 1e-2), ("shortest", 0.000_625), ("longest", 0.01)];
    let adaptive: Table = adaptive.map(|(key, value)| (key.to_owned(), value.into())).into_iter().collect();
    type Sets = Vec<(&'static str, Value)>;
    let cases: Vec<(&str, Sets)> = vec![
        ("adaptive", vec![("time.adaptive", adaptive.into())]),
        ("windows of 3", vec![("coupling.window", 3.into())]),
        (
            "halved",
            vec![
                ("reservoir.fidelity", "compressible".into()),
                ("reservoir.method", "recursive".into()),
                ("coupling.acceleration", "constant".into()),
                ("coupling.on_failure", "halve".into()),
                ("coupling.tolerance", 1e-6.into()),
                ("coupling.iteration_limit", 6.into()),
                ("time.communication_step", 0.01.into()),
            ],
        ),
        ("parallel", vec![("coupling.scheme", "parallel-implicit".into())]),
        ("added mass", vec![("coupling.scheme", "added-mass".into())]),
        ("Aitken", vec![("coupling.acceleration", "aitken".into())]),
        ("incompressible", vec![("reservoir.fidelity", "incompressible".into())]),
        (
            "convolution",
            vec![("reservoir.fidelity", "compressible".into()), ("reservoir.method", "radau2".into())],
        ),
        (
            "recursion",
            vec![("reservoir.fidelity", "compressible".into()), ("reservoir.method", "recursive".into())],
        ),
        (
            "finite elements",
            vec![
                ("reservoir.fidelity", "compressible".into()),
                ("reservoir.method", "finite-elements".into()),
            ],
        ),
        ("no water", vec![("reservoir.fidelity", "none".into())]),
        ("reduced blocks", vec![("dam.fidelity", "reduced".into())]),
        ("rigid blocks", vec![("dam.fidelity", "rigid-blocks".into())]),
        ("intact", vec![("dam.fidelity", "intact".into())]),
        ("uplift that leaves what opens", vec![("dam.uplift", "zero-where-open".into())]),
        (
            "uplift in what opens, silt",
            vec![
                ("dam.uplift", "full-where-open".into()),
                ("dam.fidelity", "reduced".into()),
                (
                    "loads",
                    table(&[("silt", table(&[("depth", 20.0.into()), ("submerged_density", 900.0.into())]))]),
                ),
            ],
        ),
    ];
    for (name, sets) in cases {
        let mut scenario = scene(0.6);
        for (key, value) in sets {
            scenario.set(key, value);
        }
        let step = until_and_on(&scenario, 0.4, &IN_PROCESS);
        let whole = scenario.folder().join("whole");
        let rejected = timeless(&whole)
            .iter()
            .filter(|entry| matches!(entry, Entry::Step(step) if !step.accepted))
            .count();
        println!("{name}: went on after step {step}, {rejected} steps started again");
        assert!(step > 10, "{name}");
        assert_eq!(rejected > 0, matches!(name, "adaptive" | "halved"), "{name}: {rejected}");
    }
    let mut tailwater = Scenario::shipped("koyna-tailwater");
    tailwater.set("dam.element_size", 16.0).set("time.duration", 0.3);
    tailwater.set("log", Table::from_iter([("checkpoint_share".to_owned(), 1.0.into())]));
    assert!(until_and_on(&tailwater, 0.2, &IN_PROCESS) > 10);
}

/// The state of a convolution holds its whole past: checkpoints without it bring the water on by what it was asked.
#[test]
fn water_whose_state_grows_goes_on_from_checkpoints_without_it() {
    let mut scenario = scene(1.0);
    scenario.set("reservoir.fidelity", "compressible").set("log.checkpoint_share", 0.3);
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let without: Vec<u64> = timeless(&whole)
        .into_iter()
        .filter_map(|entry| match entry {
            Entry::Checkpoint(checkpoint) if checkpoint.units[1].is_none() => Some(checkpoint.step),
            _ => None,
        })
        .collect();
    println!("checkpoints without the water: {without:?}");
    let step = *without.last().expect("one that lacks it");
    let part = run(
        &scenario,
        "part",
        &["--transport", "in-process", "--until", &(step as f64 * 0.0025).to_string()],
    );
    assert_eq!(resume(&part, &IN_PROCESS), step);
    assert_equal(&whole, &part);
}

/// Waits until the log at `path` has `size` bytes.
fn grown(path: &Path, size: u64) {
    let began = Instant::now();
    while !fs::metadata(path).is_ok_and(|file| file.len() >= size) {
        assert!(began.elapsed() < Duration::from_secs(100), "{} does not grow", path.display());
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Kills processes of a run at a random moment, which the length of its log tells: ones of all chunks are as likely. Six times, or as
/// often as `COFFERDAM_KILLS` says.
#[test]
fn killed_runs_go_on_whoever_was_killed() {
    let _alone = alone();
    let mut scenario = scene(2.0);
    scenario.set("coupling.tolerance", 1e-6);
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let size = fs::metadata(whole.join("log.mcap")).expect("a log").len() as f64;
    let mut random = Random(20_261);
    let victims = ["orchestrator", "dam", "reservoir", "all", "orchestrator", "all"];
    let kills =
        std::env::var("COFFERDAM_KILLS").map_or(victims.len(), |kills| kills.parse().expect("a number"));
    for (round, victim) in victims.into_iter().cycle().enumerate().take(kills) {
        let share = 0.9 * random.next();
        let folder = scenario.folder().join(format!("{victim}-{round}"));
        let mut running = Running::start(scenario.command(&format!("{victim}-{round}")));
        running.prepared();
        grown(&folder.join("log.mcap"), (share * size) as u64);
        let units = [running.dam, running.reservoir];
        match victim {
            "dam" => signal(units[0], "-KILL"),
            "reservoir" => signal(units[1], "-KILL"),
            "orchestrator" => signal(running.orchestrator.id(), "-KILL"),
            _ => {
                signal(running.orchestrator.id(), "-KILL");
                // They may have noticed already.
                for unit in units {
                    let _ = Command::new("kill").args(["-KILL", &unit.to_string()]).status();
                }
            }
        }
        let (status, said) = running.end();
        let by_itself = ["dam", "reservoir"].contains(&victim);
        assert_eq!(status.code(), by_itself.then_some(4), "{victim}: {said}");
        let step = resume(&folder, &IN_PROCESS);
        println!("seed 20261, {victim} killed at {share:.2} of the log: went on after step {step}");
        assert_equal(&whole, &folder);
    }
}

/// Resuming is killed while it retells what was, and afterwards; nothing is lost.
#[test]
fn a_resumed_run_that_is_killed_goes_on_too() {
    let _alone = alone();
    let scenario = scene(2.0);
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let bytes = fs::read(whole.join("log.mcap")).expect("a log");
    let folder = with_log(&whole, "cut", &bytes[..bytes.len() * 3 / 4]);
    let (log, aside) = (folder.join("log.mcap"), folder.join("log.mcap.new"));
    let before = fs::read(&log).expect("a log");
    let resumed = || {
        let mut command = Command::new(binary());
        command.args(["resume", text(&folder), "--quiet", "--transport", "in-process"]);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("cofferdam runs")
    };
    // What is written first is flushed at once: then it retells.
    let mut first = resumed();
    assert!(
        wait_until(|| fs::metadata(&aside).is_ok_and(|file| file.len() > 3000)),
        "no {}",
        aside.display()
    );
    first.kill().expect("killed");
    first.wait().expect("an ending");
    let retelling = fs::read(&log).expect("a log") == before;
    println!("killed while it retells: {retelling}");
    // What is left of it is replaced.
    if retelling {
        assert!(aside.exists());
    }
    let mut second = resumed();
    let new = |path: &Path| fs::metadata(path).is_ok_and(|file| file.len() != before.len() as u64);
    assert!(wait_until(|| new(&log)), "it does not come as far");
    second.kill().expect("killed");
    second.wait().expect("an ending");
    let step = resume(&folder, &IN_PROCESS);
    println!("went on after step {step}");
    assert!(step > 100);
    assert_equal(&whole, &folder);
}

#[test]
fn a_log_that_was_cut_or_damaged_anywhere_goes_on() {
    let scenario = scene(1.0);
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let bytes = fs::read(whole.join("log.mcap")).expect("a log");
    let mut random = Random(7);
    for round in 0..4 {
        let cut = bytes.len() / 8 + (random.next() * (bytes.len() * 7 / 8) as f64) as usize;
        let folder = with_log(&whole, &format!("cut-{round}"), &bytes[..cut]);
        let step = resume(&folder, &IN_PROCESS);
        println!("cut at byte {cut} of {}: went on after step {step}", bytes.len());
        assert_equal(&whole, &folder);
    }
    // Chunks of 64 KiB, so that a checkpoint lies before the damage.
    let small = scenario.folder().join("small.mcap");
    rewrite(&whole.join("log.mcap"), &small, |_, _, _| ());
    let bytes = fs::read(&small).expect("a log");
    for (round, part) in [0.35, 0.6, 0.85].into_iter().enumerate() {
        let mut damaged = bytes.clone();
        // Inside a chunk: what lies between them can be damaged and nothing lost.
        let aim = (part * bytes.len() as f64) as usize;
        let all = records(&bytes);
        let chunk = all.windows(2).find(|pair| pair[0].1 == mcap::records::op::CHUNK && pair[0].0 >= aim);
        let [(begin, _), (end, _)] = chunk.expect("a chunk")[..] else { panic!("two places") };
        let place = usize::midpoint(begin, end);
        damaged[place..place + 64].iter_mut().for_each(|byte| *byte ^= 0x55);
        // Finished, or cut behind the damage.
        for (kind, end) in [("whole", damaged.len()), ("cut", damaged.len() * 19 / 20)] {
            let folder = with_log(&whole, &format!("damaged-{kind}-{round}"), &damaged[..end]);
            let (status, said) = try_resume(&folder, &IN_PROCESS);
            assert_eq!(status, Some(0), "{said}");
            assert!(said.contains("damaged here") && said.contains("continues after step"), "{said}");
            assert_equal(&whole, &folder);
        }
    }
}

#[test]
fn a_limit_of_file_sizes_and_ctrl_c_end_a_run_that_goes_on() {
    let scenario = scene(2.0);
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let limited = scenario.folder().join("limited");
    // sh counts in blocks of 512 bytes.
    let size = fs::metadata(whole.join("log.mcap")).expect("a log").len() / 512;
    let script = format!("ulimit -f {}; exec \"$@\"", size * 2 / 3);
    let limit = |arguments: &[&str]| {
        let mut command = Command::new("sh");
        command.args(["-c", &script, "sh"]).arg(binary()).args(arguments).args(IN_PROCESS).arg("--quiet");
        command.stdin(Stdio::null()).output().expect("sh runs").status.code()
    };
    let scene = scenario.write();
    assert_eq!(limit(&["run", text(&scene), "--output", text(&limited)]), Some(1));
    // As long as there is no space, nothing is lost.
    assert_eq!(limit(&["resume", text(&limited)]), Some(1));
    let step = resume(&limited, &IN_PROCESS);
    println!("limited to two thirds of the log: went on after step {step}");
    assert!(step > 100);
    assert_equal(&whole, &limited);

    let stopped = scenario.folder().join("stopped");
    let mut command = scenario.command("stopped");
    let mut running = command.args(IN_PROCESS).stdout(Stdio::null()).spawn().expect("cofferdam runs");
    grown(&stopped.join("log.mcap"), 256 * size);
    signal(running.id(), "-INT");
    assert_eq!(running.wait().expect("an ending").code(), Some(130));
    assert!(resume(&stopped, &IN_PROCESS) > 100);
    assert_equal(&whole, &stopped);
}

fn table(pairs: &[(&str, Value)]) -> Value {
    Value::Table(pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect())
}

#[test]
fn water_of_another_program_goes_on_from_its_state_or_is_asked_again() {
    let mut scenario = scene(0.3);
    scenario.set("reservoir.fidelity", "compressible");
    let file = scenario.folder().join("reservoir.fmu");
    let (status, said) =
        cofferdam(&["export-fmu", "--unit", "reservoir", "--output", text(&file), text(&scenario.write())]);
    assert_eq!(status, Some(0), "{said}");
    scenario
        .set("reservoir.fidelity", "fmu")
        .set("reservoir.fmu", table(&[("file", "reservoir.fmu".into())]));
    let step = until_and_on(&scenario, 0.2, &IN_PROCESS);
    println!("water as an FMU: went on after step {step}");
    assert!(step > 10);

    // With a state as bytes, and without.
    let python = |program: PathBuf, more: &[Value]| {
        let argv = [python::interpreter().to_owned(), program];
        let argv = argv.into_iter().map(|path| Value::from(text(&path))).chain(more.to_vec());
        table(&[("argv", Value::Array(argv.collect()))])
    };
    let with = scenario.folder().join("with_state.py");
    let example = fs::read_to_string(root().join("examples/python/westergaard.py")).expect("the example");
    let methods = "    def save(self):";
    let given = "    def serialise(self):
        return np.append(*self.before).tobytes()

    def deserialise(self, state):
        *before, length = np.frombuffer(state)
        self.before = np.array(before), float(length)

";
    fs::write(&with, example.replace(methods, &format!("{given}{methods}"))).expect("written");
    for (name, command, repeated) in [
        ("without a state", python(root().join("examples/python/westergaard.py"), &[]), true),
        ("with a state", python(with, &[]), false),
    ] {
        let mut scenario = scene(0.3);
        scenario.set("reservoir.fidelity", "command").set("reservoir.command", command);
        let whole = run(&scenario, "whole", &[]);
        let part = run(&scenario, "part", &["--until", "0.2"]);
        let (status, said) = try_resume(&part, &[]);
        assert_eq!(status, Some(0), "{name}: {said}");
        assert_eq!(said.contains("reservoir cannot save its state: its"), repeated, "{name}: {said}");
        assert!(said.contains("continues after step"), "{name}: {said}");
        assert_equal(&whole, &part);
    }
}

#[test]
fn what_cannot_be_resumed_is_named_and_left_alone() {
    let scenario = scene(0.3);
    let part = run(&scenario, "part", &["--transport", "in-process", "--until", "0.2"]);
    let bytes = fs::read(part.join("log.mcap")).expect("a log");
    let refused = |path: &Path, status: i32, words: &[&str]| {
        let (found, said) = try_resume(path, &IN_PROCESS);
        assert_eq!(found, Some(status), "{said}");
        assert!(words.iter().all(|word| said.contains(word)) && !said.contains("panicked"), "{said}");
    };
    let empty = scenario.folder().join("empty");
    fs::create_dir(&empty).expect("a folder");
    refused(&empty, 1, &["log.mcap: No such file", "give the log.mcap of a run, or the run's folder"]);
    refused(&part.join("log.mcap"), 2, &["give the folder of the run"]);
    let headless = with_log(&part, "headless", &bytes[..300]);
    refused(&headless, 1, &["cut short before it says what was run", "run the scene again"]);

    let other = with_log(&part, "other", &[]);
    rewrite(&part.join("log.mcap"), &other.join("log.mcap"), |topic, _, data| {
        if topic == "/build" {
            let place = data.windows(7).position(|part| part == b"release").expect("the profile");
            data[place..place + 7].copy_from_slice(b"replica");
        }
    });
    let before = fs::read(other.join("log.mcap")).expect("a log");
    refused(&other, 2, &["another profile (\"replica\", here \"release\")", "--other-build"]);
    assert!(fs::read(other.join("log.mcap")).expect("a log") == before, "it was left alone");
    let (status, said) = try_resume(&other, &["--other-build", "--transport", "in-process"]);
    assert!(status == Some(0) && said.contains("warning: the run was made by another profile"), "{said}");

    resume(&part, &IN_PROCESS);
    let whole = fs::read(part.join("log.mcap")).expect("a log");
    refused(&part, 0, &["nothing to do: the run completed"]);
    assert!(fs::read(part.join("log.mcap")).expect("a log") == whole);

    let long = scene(20.0);
    let mut command = long.command("long");
    let mut running = command.args(IN_PROCESS).stdout(Stdio::null()).spawn().expect("cofferdam runs");
    grown(&long.folder().join("long/log.mcap"), 100_000);
    refused(&long.folder().join("long"), 2, &["the run is still running", "wait for its end, or stop it"]);
    assert!(running.try_wait().expect("a run").is_none(), "it was left alone");
    running.kill().expect("killed");
    running.wait().expect("an ending");
}

/// A run with both components of the ground's motion: killed and resumed, or replayed, it has the same bits.
#[test]
fn a_killed_run_with_vertical_motion_goes_on_and_is_replayed() {
    let _alone = alone();
    let mut scenario = scene(1.0);
    let file = root().join("scenes/records/northridge-1994-canyon-country-270.csv");
    let vertical = [
        ("file", Value::from(file.to_string_lossy().into_owned())),
        ("scale", 0.6.into()),
        ("polarity", (-1).into()),
    ];
    let level = run(&scenario, "level", &IN_PROCESS);
    scenario.set("ground_motion.vertical", table(&vertical)).set("coupling.tolerance", 1e-6);
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let histories = |run: &Path| fs::read(run.join("histories.csv")).expect("histories");
    assert!(histories(&whole) != histories(&level));
    let size = fs::metadata(whole.join("log.mcap")).expect("a log").len();
    let folder = scenario.folder().join("killed");
    let mut running = Running::start(scenario.command("killed"));
    running.prepared();
    grown(&folder.join("log.mcap"), size / 2);
    signal(running.orchestrator.id(), "-KILL");
    running.end();
    let step = resume(&folder, &IN_PROCESS);
    println!("with vertical motion: went on after step {step}");
    assert_equal(&whole, &folder);
    let (status, said) = cofferdam(&["replay", text(&folder), "--quiet"]);
    assert!(status == Some(0) && said.matches("identical").count() == 2, "{said}");
}

/// A run whose second shock was interrupted: resumed, or replayed, it has the same bits.
#[test]
fn a_run_killed_in_its_second_shock_goes_on_and_is_replayed() {
    let _alone = alone();
    let mut scenario = scene(2.0);
    let file = root().join("scenes/records/northridge-1994-canyon-country-270.csv");
    let shock = |start: f64, end: f64, rest: f64| {
        let file = Value::from(file.to_string_lossy().into_owned());
        table(&[("file", file), ("start", start.into()), ("end", end.into()), ("rest", rest.into())])
    };
    scenario.set("ground_motion.record.end", 4.4).set("coupling.tolerance", 1e-6);
    scenario.set("ground_motion.sequence", Value::Array(vec![shock(4.5, 6.0, 0.2)]));
    let whole = run(&scenario, "whole", &IN_PROCESS);
    let begins = Log::open(&whole).expect("a log").head().signals[0].parts.clone();
    assert!(begins.len() == 1 && (begins[0] - 0.61).abs() < 1e-9, "{begins:?}");
    let size = fs::metadata(whole.join("log.mcap")).expect("a log").len();
    let folder = scenario.folder().join("killed");
    let mut running = Running::start(scenario.command("killed"));
    running.prepared();
    grown(&folder.join("log.mcap"), size * 3 / 4);
    signal(running.orchestrator.id(), "-KILL");
    running.end();
    let step = resume(&folder, &IN_PROCESS);
    println!("in a sequence: went on after step {step}");
    assert!(step as f64 * 0.0025 > begins[0], "the second shock was interrupted, not step {step}");
    assert_equal(&whole, &folder);
    let (status, said) = cofferdam(&["replay", text(&folder), "--quiet"]);
    assert!(status == Some(0) && said.matches("identical").count() == 2, "{said}");
}
