//! Fuzzers: scenes, records, logs, the contents of FMUs and command lines, changed at random. Whatever comes in, the answer
//! is a result or an error: no panic, no signal, nothing that `check` calls fine and `run` cannot begin, no NaN in results.
//!
//! `COFFERDAM_FUZZ` gives the number of cases of each fuzzer (docs/measurements/reliability.md); a failure prints the number of its case,
//! and `COFFERDAM_FUZZ_FIRST` begins there.

use cofferdam_dam::{Dam, GivenMesh, Mesh};
use cofferdam_fmi::import::{self, FmuUnitError, Import};
use cofferdam_log::{Log, LogReadError, Overview, compare, recover};
use cofferdam_reservoir::Reservoir;
use cofferdam_scene::mesh_file::{DamMesh, MeshFile};
use cofferdam_unit::Packable;
use cofferdam_unit::Role;
use cofferdam_unit::export::Contents;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use whole_chain::fmu::{Fmu, export};
use whole_chain::scenario::{Histories, Scenario, binary, root};
use whole_chain::scene_text::{Desk, shipped};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Random numbers of one case (splitmix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Calls `case` with the dice of as many cases as are asked for, else of `few`.
fn cases(few: u64, mut case: impl FnMut(&mut Dice)) {
    let asked = |name: &str| std::env::var(name).ok().and_then(|n| n.parse::<u64>().ok());
    let (first, count) = (asked("COFFERDAM_FUZZ_FIRST").unwrap_or(0), asked("COFFERDAM_FUZZ").unwrap_or(few));
    for number in first..first + count {
        /// Says which case failed.
        struct Said(u64);
        impl Drop for Said {
            fn drop(&mut self) {
                if std::thread::panicking() {
                    eprintln!("case {}", self.0);
                }
            }
        }
        let said = Said(number);
        case(&mut Dice(number));
        drop(said);
    }
}

const NUMBERS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "0.0",
    "-0.0",
    "1e-300",
    "-1e-9",
    "1e-6",
    "0.5",
    "7",
    "30.0",
    "1e3",
    "1e9",
    "1e17",
    "1e41",
    "1e308",
    "-1e308",
    "inf",
    "-inf",
    "nan",
    "9223372036854775807",
    "99999999999999999999",
];
const WORDS: [&str; 14] = [
    "true",
    "\"\"",
    "\"word\"",
    "[]",
    "[1.0]",
    "{}",
    "{ a = 1 }",
    "[[1.0, 2.0], [3.0]]",
    "\"/dev/null\"",
    "\"..\"",
    "1979-05-27",
    "'''",
    "\"\\u0000\"",
    "\"西\"",
];

/// A text with one to four changes: of numbers, values, lines, bytes.
fn changed(text: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut text = text.to_vec();
    for _ in 0..1 + dice.below(4) {
        let mut lines: Vec<Vec<u8>> = text.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
        let index = dice.below(lines.len());
        let position =
            |separators: &[u8], line: &[u8]| line.iter().position(|byte| separators.contains(byte));
        match dice.below(9) {
            0 => drop(lines.remove(index)),
            1 => {
                let (line, to) = (lines[index].clone(), dice.below(lines.len() + 1));
                lines.insert(to, line);
            }
            2 => {
                let other = dice.below(lines.len());
                lines.swap(index, other);
            }
            kind @ 3..=6 => {
                // A value behind `=`, or between commas and blanks.
                let line = &mut lines[index];
                let from = position(b"=", line).or_else(|| position(b", \t", line)).map_or(0, |at| at + 1);
                let length = position(b",#]}", &line[from..]).unwrap_or(line.len() - from);
                let new = if kind == 6 { *dice.of(&WORDS) } else { *dice.of(&NUMBERS) };
                line.splice(from..from + length, format!(" {new} ").into_bytes());
            }
            7 => {
                let at = dice.below(lines[index].len() + 1);
                lines[index].insert(at, dice.next() as u8);
            }
            _ => {
                let line = &mut lines[index];
                if !line.is_empty() {
                    let at = dice.below(line.len());
                    line[at] = dice.next() as u8;
                }
            }
        }
        text = lines.join(&b'\n');
    }
    text
}

/// Bytes with one to three changes: of bits, of ranges, of the length.
fn damaged(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + dice.below(3) {
        let (at, length) = (dice.below(bytes.len()), dice.below(40));
        let end = (at + length).min(bytes.len());
        match dice.below(6) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let (copy, to) = (bytes[at..end].to_vec(), dice.below(bytes.len()));
                bytes.splice(to..to, copy);
            }
            3 => bytes[at..end].fill(dice.next() as u8),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << dice.below(8);
                }
            }
        }
    }
    bytes
}

#[test]
fn scenes() {
    let desk = Desk::default();
    let texts = ["koyna-coarse", "koyna-intact", "rigid-dam-ramp"].map(shipped);
    let (mut fine, mut refused) = (0, 0);
    cases(1500, |dice| {
        let text = changed(dice.of(&texts).as_bytes(), dice);
        let key = *dice.of(&[
            "dam.element_size",
            "time.communication_step",
            "reservoir.depth",
            "x",
            "dam.cracks.7.elevation",
        ]);
        let set = format!("{key}={}", if dice.below(2) == 0 { dice.of(&NUMBERS) } else { dice.of(&WORDS) });
        let set = if dice.below(4) == 0 { vec![&*set] } else { Vec::new() };
        match desk.read(text, &set) {
            Ok(_) => fine += 1,
            Err(error) => {
                refused += 1;
                assert!(!desk.shown(&error).is_empty() && !error.problems.is_empty());
            }
        }
    });
    println!("{fine} scenes are fine, {refused} are refused");
    assert!(fine > 0 && refused > 0);
}

#[test]
fn records() {
    let desk = Desk::default();
    let text = std::fs::read_to_string(root().join("scenes/records/northridge-1994-canyon-country-270.csv"));
    let csv: Vec<String> = text.expect("a record").lines().take(300).map(str::to_owned).collect();
    let numbers: Vec<_> = (0..60).map(|i| format!("  {:.7E}", 0.1 * f64::from(i * 17 % 23 - 11))).collect();
    let at2 = [
        "PEER NGA STRONG MOTION DATABASE RECORD",
        "SOMEWHERE, 1/17/94",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        "NPTS=  60, DT=   .0100 SEC",
    ];
    let at2 = at2.iter().map(|line| (*line).to_owned()).chain(numbers.chunks(5).map(<[String]>::concat));
    let records = [("r.csv", csv.join("\n")), ("r.at2", at2.collect::<Vec<_>>().join("\n"))];
    let scene = shipped("rigid-dam-ramp");
    let ground = scene.find("[ground_motion").expect("a ground motion");
    let after = scene[ground + 1..].find("\n[").map_or(scene.len(), |at| ground + 2 + at);
    let (mut fine, mut refused) = (0, 0);
    cases(1500, |dice| {
        let (name, text) = dice.of(&records);
        std::fs::write(desk.file(name), changed(text.as_bytes(), dice)).expect("written");
        let record = format!("[ground_motion.record]\nfile = \"{name}\"\n\n");
        let read = desk.read([&scene[..ground], &record, &scene[after..]].concat(), &[]);
        match read {
            Ok(loaded) => {
                fine += 1;
                assert!(loaded.ground_motion.acceleration().iter().all(|a| a.is_finite()));
            }
            Err(error) => {
                refused += 1;
                assert!(!desk.shown(&error).is_empty());
            }
        }
    });
    println!("{fine} records are read, {refused} are refused");
    assert!(fine > 0 && refused > 0);
}

#[test]
fn meshes() {
    let read =
        |path: &str| std::fs::read_to_string(root().join("scenes/koyna-gmsh").join(path)).expect("a file");
    let text = read("koyna.msh");
    let (path, names) = (Path::new("koyna.msh"), [Some("neck".to_owned())]);
    let (mut fine, mut refused) = (0, 0);
    cases(3000, |dice| {
        let changed = String::from_utf8_lossy(&changed(text.as_bytes(), dice)).into_owned();
        let file = MeshFile::parse(path, &changed).and_then(|file| DamMesh::new(path, file, &names));
        let given = match file {
            Ok(mesh) => {
                drop((
                    mesh.galleries(),
                    mesh.polyline(0),
                    mesh.element_size(),
                    mesh.vertices(&mesh.upstream),
                ));
                let DamMesh { points, triangles, quadrilaterals, upstream, downstream, base, cracks } = mesh;
                GivenMesh { points, triangles, quadrilaterals, upstream, downstream, base, cracks }
            }
            Err(error) => {
                refused += 1;
                return assert!(error.to_string().contains("koyna.msh"), "{error}");
            }
        };
        match Mesh::of_given(&given, &[], [91.75, 0.0], 5.0) {
            Ok(mesh) => {
                fine += 1;
                assert!(mesh.quality().smallest_angle.0 > 0.0);
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
    });
    println!("{fine} meshes are taken, {refused} are refused");
    assert!(fine > 0 && refused > 0);
}

#[test]
fn logs() {
    let scenario = Scenario::quick(0.05);
    let run = scenario.try_run("whole");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let whole = Log::open(&scenario.folder().join("whole/log.mcap")).expect("a log");
    let bytes = std::fs::read(whole.path()).expect("a log");
    let (path, saved) = (scenario.folder().join("damaged.mcap"), scenario.folder().join("saved.mcap"));
    let (mut read, mut refused, mut recovered) = (0, 0, 0);
    cases(1500, |dice| {
        std::fs::write(&path, damaged(&bytes, dice)).expect("written");
        if let Ok(log) = Log::open(&path) {
            let step = dice.below(30) as u64;
            let from = log.entries_from(step).and_then(Iterator::collect::<Result<Vec<_>, _>>);
            drop((from, log.last_before("/step", step), log.entries_at(0.0025 * step as f64)));
        }
        if recover(&path, &saved).is_ok() {
            // What was saved is sound, if its beginning is left.
            if let Ok(log) = Log::open(&saved) {
                let overview = Overview::of(&log).expect("a log");
                assert!(overview.error.is_none(), "{:?}", overview.error);
                recovered += 1;
            }
            std::fs::remove_file(&saved).expect("removed");
        }
        let entries = |log: &Log| log.entries()?.collect::<Result<Vec<_>, LogReadError>>();
        match Log::open(&path).and_then(|log| Ok((entries(&log)?, log))) {
            Ok((_, log)) => {
                read += 1;
                // What is read to its end can be compared.
                compare([&whole, &log]).expect("a comparison");
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("damaged.mcap"), "{error}");
            }
        }
    });
    println!("{read} logs are read to their end, {refused} are not; {recovered} are recovered");
    assert!(refused > 0 && recovered > refused / 2);
}

#[test]
fn contents_of_fmus() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |unit: &str| {
        let more = [
            "--set",
            "dam.element_size=15",
            "--set",
            "reservoir.fidelity=westergaard",
            "-o",
            "x.fmu",
            "--force",
        ];
        let output = export(folder.path(), &root().join("scenes/koyna-coarse"), unit, &more);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Fmu::open(&folder.path().join("x.fmu")).bytes("resources/unit.toml")
    };
    /// Reads contents, and makes the unit that they describe: whether that is possible.
    fn made<U: Packable>(folder: &Path) -> bool {
        let Ok(contents) = Contents::<U::Parameters>::read(folder) else { return false };
        U::from_parameters(contents.parameters, NonZeroUsize::MIN).is_ok()
    }
    let texts = ["dam", "reservoir"].map(text);
    let (mut fine, mut refused) = (0, 0);
    cases(60, |dice| {
        let unit = dice.below(2);
        std::fs::write(folder.path().join("unit.toml"), changed(&texts[unit], dice)).expect("written");
        let made = if unit == 0 { made::<Dam>(folder.path()) } else { made::<Reservoir>(folder.path()) };
        *(if made { &mut fine } else { &mut refused }) += 1;
    });
    println!("{fine} units are made, {refused} are refused");
    assert!(refused > 0);
}

/// FMUs of other programs, with a file in place of their library, so that nothing of them is executed: their archives and
/// their descriptions.
#[test]
fn archives_and_descriptions_of_fmus() {
    let scenario = Scenario::quick(0.05);
    let template = scenario.folder().join("template");
    let mut command = Command::new(binary());
    command.args(["template", "c"]).arg(&template).arg("--scene").arg(scenario.write());
    assert!(command.output().expect("cofferdam runs").status.success());
    let read = |name: &str| std::fs::read(template.join("fmu").join(name)).expect("a file of the template");
    let names = ["modelDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml"];
    let [description, terminals] = names.map(read);
    let scalars = r#"<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="w" guid="g">
<CoSimulation modelIdentifier="water" canGetAndSetFMUstate="true"/>
<ModelVariables>
<ScalarVariable name="interface_acceleration[1]" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="interface_acceleration[2]" valueReference="2" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="interface_pressure[1]" valueReference="3" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="interface_pressure[2]" valueReference="4" causality="output"><Real/></ScalarVariable>
</ModelVariables><ModelStructure><Outputs><Unknown index="3"/></Outputs></ModelStructure></fmiModelDescription>"#;
    let descriptions = [description, scalars.as_bytes().to_vec()];
    let archive = |[description, terminals]: [&[u8]; 2]| {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let libraries = ["binaries/x86_64-linux/water.so", "binaries/linux64/water.so"];
        let libraries = libraries.map(|name| (name, &b"no library"[..]));
        for (name, bytes) in names.into_iter().zip([description, terminals]).chain(libraries) {
            archive.start_file(name, SimpleFileOptions::default()).expect("an entry");
            archive.write_all(bytes).expect("its bytes");
        }
        archive.finish().expect("an archive").into_inner()
    };
    let path = scenario.folder().join("changed.fmu");
    let (variables, parameters) = (BTreeMap::new(), BTreeMap::new());
    let import = Import { file: &path, variables: &variables, parameters: &parameters, stop_time: None };
    let (mut archives, mut read, mut refused) = (0, 0, 0);
    cases(600, |dice| {
        let description = dice.of(&descriptions);
        let bytes = match dice.below(4) {
            0 => damaged(&archive([description, &terminals]), dice),
            1 => archive([description, &changed(&terminals, dice)]),
            2 => archive([&damaged(description, dice), &terminals]),
            _ => archive([&changed(description, dice), &terminals]),
        };
        std::fs::write(&path, bytes).expect("written");
        let began = Instant::now();
        // The library comes last.
        match import::Fmu::new("reservoir", Role::Fluid, import, Some(0.0025)) {
            Ok(_) => panic!("there is no library"),
            Err(FmuUnitError::Unpack(error)) => {
                archives += 1;
                assert!(error.to_string().contains("changed.fmu"), "{error}");
            }
            Err(FmuUnitError::Library { .. }) => read += 1,
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
        assert!(began.elapsed() < Duration::from_secs(10), "{:?}", began.elapsed());
    });
    println!("{archives} are refused as archives, {refused} as descriptions, {read} for their library alone");
    assert!(archives > 0 && read > 0 && refused > 0);
}

/// Runs the program, for two minutes at most and with 1 GiB of address space at most.
fn limited(arguments: &[String], folder: &Path) -> (ExitStatus, String) {
    let mut command = Command::new("sh");
    command
        .args(["-c", r#"ulimit -v 1048576; exec "$0" "$@""#])
        .arg(binary())
        .args(arguments)
        .current_dir(folder);
    let said = folder.join("said");
    let file = std::fs::File::create(&said).expect("a file");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
    let mut child = command.spawn().expect("sh runs");
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if began.elapsed() > Duration::from_secs(120) {
            child.kill().expect("killed");
            panic!("hangs: cofferdam {arguments:?}");
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    let said = String::from_utf8_lossy(&std::fs::read(said).expect("what it said")).into_owned();
    assert!(
        status.code().is_some() && !said.contains("panicked"),
        "{status}, cofferdam {arguments:?}: {said}"
    );
    (status, said)
}

#[test]
fn command_lines() {
    let scenario = Scenario::quick(0.02);
    let scene = scenario.write().display().to_string();
    let words = [
        "run",
        "check",
        "replay",
        "export-fmu",
        "log",
        "reservoir",
        "range",
        "points",
        "template",
        "c",
        "python",
        "--scene",
        "--format",
        "json",
        "unit",
        "info",
        "recover",
        "diff",
        "impulse",
        "response",
        "field",
        "dam",
        "reservoir",
        "--help",
        "-h",
        "--version",
        "--set",
        "--output",
        "--quiet",
        "--unit",
        "--transport",
        "in-process",
        "--threads",
        "--deadline",
        "--at",
        "-o",
        "-",
        "--",
        "",
        "x",
        "=",
        "a=b",
        "dam.element_size=20",
        "time.duration=0.01",
        "reservoir.depth=nan",
        "0",
        "-1",
        "3",
        "1e999",
        "nan",
        "/dev/null",
        "/",
        "..",
        "log.mcap",
        "\u{1}",
        "西",
        &scene,
    ];
    let mut statuses = BTreeMap::new();
    cases(60, |dice| {
        let count = 1 + dice.below(6);
        let mut arguments: Vec<String> = (0..count).map(|_| (*dice.of(&words)).to_owned()).collect();
        // The range of a scene takes minutes.
        if arguments[0] == "range" {
            arguments.retain(|word| *word != scene);
        }
        let (status, _) = limited(&arguments, scenario.folder());
        *statuses.entry(status.code()).or_insert(0) += 1;
    });
    println!("exit statuses: {statuses:?}");
    assert!(statuses.keys().all(|code| code.is_some_and(|code| (0..=5).contains(&code))), "{statuses:?}");
}

/// Values of keys inside their ranges, and at their ends.
const VALUES: [(&str, &[&str]); 43] = [
    ("gravity", &["0.1", "1.62", "1e4"]),
    ("time.communication_step", &["1e-4", "0.001", "0.02", "0.1", "1.0"]),
    ("time.quiet", &["0.0", "1e6"]),
    ("ground_motion.record.scale", &["1e-6", "0.1", "3.0", "50.0", "1e6"]),
    ("ground_motion.record.polarity", &["-1"]),
    ("ground_motion.record.start", &["0.0", "4.0", "10.0"]),
    ("ground_motion.vertical", &["{column=1}", "{column=1, scale=20, polarity=-1}"]),
    ("reservoir.depth", &["1e-6", "0.5", "30.0", "60.0", "102.9"]),
    ("reservoir.density", &["100.0", "1200.0", "1e5"]),
    ("reservoir.sound_speed", &["1.0", "10.0", "500.0", "1e5"]),
    ("reservoir.fidelity", &["\"incompressible\"", "\"compressible\"", "\"compressible\""]),
    ("reservoir.profile", &["\"chopra\"", "\"exact\""]),
    ("reservoir.wave_reflection_coefficient", &["0.0", "0.5", "0.9", "1.0"]),
    ("reservoir.surface_waves", &["true"]),
    ("reservoir.method", &["\"recursive\"", "\"bdf2\""]),
    ("reservoir.element_order", &["\"quadratic\""]),
    ("reservoir.bed", &["[[-100.0, 10.0]]", "[[-40.0, -20.0], [-200.0, 0.0]]"]),
    ("dam.fidelity", &["\"reduced\"", "\"rigid-blocks\"", "\"intact\""]),
    ("dam.modes", &["1", "7", "1000"]),
    ("dam.element_size", &["10.0", "15.0", "40.0", "200.0", "1e4"]),
    ("dam.kinematics", &["\"small\""]),
    ("dam.time_step_safety", &["0.001", "0.1", "1.0"]),
    ("dam.material.young_modulus", &["1e6", "1e8", "3e12", "1e13"]),
    ("dam.material.poisson_ratio", &["0.0", "0.49", "0.499"]),
    ("dam.material.density", &["100.0", "500.0", "9000.0", "1e5"]),
    ("dam.material.plane", &["\"strain\""]),
    ("dam.damping.ratio", &["0.0", "1e-6", "0.5", "0.999"]),
    ("dam.damping.model", &["\"mass\"", "\"stiffness\"", "\"local\""]),
    ("dam.damping.drags_blocks", &["true"]),
    ("dam.cracks.0.elevation", &["1.0", "30.0", "66.0", "102.0", "102.999"]),
    ("dam.cracks.0.friction_coefficient", &["0.0", "0.1", "0.7", "5.0"]),
    ("dam.cracks.0.cohesion", &["1.0", "1e5", "1e12"]),
    ("dam.cracks.0.tensile_strength", &["1.0", "1e6"]),
    ("dam.cracks.0.dilation", &["0.1", "1.0"]),
    ("dam.cracks.0.integration", &["\"gauss\""]),
    ("dam.cracks.0.normal_stiffness", &["1e3", "1e8", "1e13", "1e15"]),
    ("dam.cracks.0.shear_stiffness", &["1e3", "1e8", "1e13", "1e15"]),
    (
        "coupling.scheme",
        &["\"serial-explicit\"", "\"parallel-implicit\"", "\"parallel-explicit\"", "\"added-mass\""],
    ),
    ("coupling.window", &["2", "5", "10000"]),
    ("coupling.tolerance", &["1e-14", "1e-3", "0.1"]),
    ("coupling.acceleration", &["\"aitken\"", "\"iqn-ils\"", "\"constant\""]),
    ("coupling.iteration_limit", &["2", "3"]),
    ("coupling.predictor_order", &["0", "1"]),
];

/// What `check` calls fine, `run` can begin: three steps of it end well, or do not converge (status 3).
#[test]
fn what_check_calls_fine_can_be_run() {
    let mut scenario = Scenario::quick(1.0);
    scenario.set("dam.element_size", 20.0).set("reservoir.element_size", 25.0);
    let scene = scenario.write().display().to_string();
    let (mut fine, mut refused, mut not_converged) = (0, 0, 0);
    cases(12, |dice| {
        let mut sets: BTreeMap<&str, &str> = BTreeMap::from([("time.communication_step", "0.0025")]);
        for _ in 0..1 + dice.below(4) {
            let (key, values) = *dice.of(&VALUES);
            sets.insert(key, *dice.of(values));
        }
        let step: f64 = sets["time.communication_step"].parse().expect("a number");
        let sets = sets.iter().map(|(key, value)| format!("{key}={value}"));
        let sets: Vec<String> = sets.chain([format!("time.duration={}", 3.0 * step)]).collect();
        let call = |command: &str, more: &[&str]| {
            let set = sets.iter().flat_map(|set| ["--set", set]);
            let words: Vec<_> =
                [command, &scene].into_iter().chain(set).chain(more.iter().copied()).collect();
            let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
            limited(&words, scenario.folder())
        };
        let (checked, said) = call("check", &[]);
        if checked.code() != Some(0) {
            assert_eq!(checked.code(), Some(2), "{sets:?}: {said}");
            refused += 1;
            return;
        }
        let results = scenario.folder().join("results");
        drop(std::fs::remove_dir_all(&results));
        let (ran, said) = call("run", &["--quiet", "--transport", "in-process", "--output", "results"]);
        match ran.code() {
            Some(0) => {
                fine += 1;
                let finite = Histories::read(&results.join("histories.csv")).values().all(f64::is_finite);
                assert!(finite, "{sets:?}: values that are not finite");
            }
            Some(3) => not_converged += 1,
            code => panic!("check finds nothing wrong with {sets:?}, run ends with {code:?}: {said}"),
        }
    });
    println!("{fine} run to their end, {not_converged} do not converge, {refused} are refused by check");
    assert!(fine > 0);
}
