//! Broken and hostile units of other programs: each is refused or survived, with a word on what is wrong and what would help,
//! and with nothing left behind. `-- hostile_units:: --nocapture` prints what was said of each.

use cofferdam_log::{Entry, Log, LogReadError};
use std::collections::BTreeSet;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use whole_chain::process::wait_until;
use whole_chain::scenario::{Scenario, binary};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const LIBRARY: &str = "binaries/x86_64-linux/water.so";
/// The beginning of a step in the template's source.
const STEP: &str = "    (void)time;\n    const double before";

/// A quick scene, and the template of an FMU for it.
struct Site {
    scenario: Scenario,
    scene: PathBuf,
    template: PathBuf,
    source: String,
    description: String,
}

/// What a command said and left.
struct Said {
    status: Option<i32>,
    /// Without blanks, so that it does not matter where lines were broken.
    text: String,
    /// Exchanges in the log, if there is one.
    exchanges: Option<usize>,
}

fn squeezed(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace() && *c != '│').collect()
}

impl Site {
    fn new() -> Self {
        let mut scenario = Scenario::quick(0.05);
        let scene = scenario.write();
        let template = scenario.folder().join("template");
        let mut command = Command::new(binary());
        command.args(["template", "c"]).arg(&template).arg("--scene").arg(&scene);
        let output = command.output().expect("cofferdam runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let read = |name: &str| std::fs::read_to_string(template.join(name)).expect("a file of the template");
        let (source, description) = (read("water.c"), read("fmu/modelDescription.xml"));
        scenario.set("reservoir.fidelity", "fmu");
        let scene = scenario.write();
        Self { scenario, scene, template, source, description }
    }

    /// A folder of a case.
    fn case(&self, name: &str) -> PathBuf {
        let folder = self.scenario.folder().join(name);
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    }

    /// The source with `code` at the beginning of each step.
    fn in_step(&self, code: &str) -> String {
        replaced(&self.source, STEP, &format!("    static int calls;\n    calls++;\n    {code}\n{STEP}"))
    }

    /// The source with `code` where an instance is made.
    fn in_making(&self, code: &str) -> String {
        let place = "    unit->environment = environment;";
        replaced(&self.source, place, &format!("{place}\n    {code}"))
    }

    /// The folder of an FMU with this library and this description.
    fn unpacked(&self, name: &str, source: &str, description: &str) -> PathBuf {
        let folder = self.case(name);
        let fmu = folder.join("fmu");
        std::fs::create_dir_all(fmu.join(LIBRARY).parent().expect("a folder")).expect("a folder");
        for header in ["fmi3.h", "wet_face.h"] {
            std::fs::copy(self.template.join(header), folder.join(header)).expect("a header");
        }
        std::fs::write(folder.join("water.c"), source).expect("a source");
        std::fs::write(fmu.join("modelDescription.xml"), description).expect("a description");
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-O0", "-w", "-o"]).arg(fmu.join(LIBRARY));
        let output = compiler.arg(folder.join("water.c")).arg("-lm").output().expect("a C compiler, cc");
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        fmu
    }

    /// The FMU of this source as an archive.
    fn library(&self, name: &str, source: &str) -> PathBuf {
        let fmu = self.unpacked(name, source, &self.description);
        let path = fmu.with_file_name("water.fmu");
        std::fs::write(&path, packed(&fmu)).expect("an archive");
        path
    }

    /// The FMU with another description, and a file in place of its library.
    fn described(&self, name: &str, description: &str) -> PathBuf {
        let fmu = self.case(name).join("fmu");
        std::fs::create_dir_all(fmu.join(LIBRARY).parent().expect("a folder")).expect("a folder");
        std::fs::write(fmu.join(LIBRARY), "no library").expect("a file");
        std::fs::write(fmu.join("modelDescription.xml"), description).expect("a description");
        fmu
    }

    /// Runs a command on the scene with `sets`; whatever it is, nothing may panic, run on or be left.
    fn call(&self, case: &str, words: &[&str], sets: &[&str]) -> Said {
        let temporary = tempfile::tempdir().expect("a folder");
        let output = self.case(case).join(format!("{}-{}", words[0], words.len()));
        let mut command = Command::new(binary());
        command.arg(words[0]).arg(&self.scene).current_dir(self.scenario.folder());
        command.args(sets.iter().flat_map(|set| ["--set", set])).args(&words[1..]);
        if words[0] == "run" {
            command.arg("--quiet").arg("--output").arg(&output);
        }
        let began = Instant::now();
        let Output { status, stderr, .. } =
            command.env("TMPDIR", temporary.path()).output().expect("cofferdam runs");
        let text = String::from_utf8_lossy(&stderr).into_owned();
        assert!(!text.contains("panicked"), "{case}: {text}");
        assert!(began.elapsed() < Duration::from_secs(30), "{case}: it took {:?}", began.elapsed());
        let left = processes_of(temporary.path());
        assert!(left.is_empty(), "{case}: processes {left:?} go on");
        let left: Vec<_> = std::fs::read_dir(temporary.path()).expect("a folder").flatten().collect();
        assert!(left.is_empty(), "{case}: {left:?} is left");
        let exchanges = output.join("log.mcap").exists().then(|| exchanges(case, &output)).flatten();
        if let Some(said) = text.rsplit("  × ").next().filter(|said| *said != text) {
            let said = said.replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ");
            println!("{case} ({}): {said}", words[0]);
        }
        Said { status: status.code(), text: squeezed(&text), exchanges }
    }

    /// Both commands refuse it, with these words.
    fn refused(&self, case: &str, sets: &[&str], words: &[&str]) {
        for (command, status) in [("check", 2), ("run", 4)] {
            let said = self.call(case, &[command], sets);
            said.expect(case, status, words);
        }
    }

    /// Both commands refuse this FMU, with these words.
    fn refused_fmu(&self, case: &str, fmu: &Path, words: &[&str]) {
        self.refused(case, &[&of(fmu)], words);
    }
}

impl Said {
    fn expect(&self, case: &str, status: i32, words: &[&str]) {
        assert_eq!(self.status, Some(status), "{case}: {}", self.text);
        for word in words {
            assert!(self.text.contains(&squeezed(word)), "{case}: {word:?} is not said: {}", self.text);
        }
    }
}

/// Number of exchanges in the log of a run. That of one whose units cannot be made ends with its scene; the manifest has the
/// reason.
fn exchanges(case: &str, run: &Path) -> Option<usize> {
    let failed = |error: LogReadError| -> Entry { panic!("{case}: {error}") };
    match Log::open(&run.join("log.mcap")) {
        Ok(log) => {
            let entries = log.entries().unwrap_or_else(|error| panic!("{case}: {error}"));
            let entries = entries.map(|entry| entry.unwrap_or_else(failed));
            Some(entries.filter(|entry| matches!(entry, Entry::Exchange(_))).count())
        }
        Err(error) => {
            assert!(
                error.to_string().contains("the log is cut short before it says what was run"),
                "{case}: {error}"
            );
            let manifest = std::fs::read_to_string(run.join("manifest.toml")).expect("a manifest");
            assert!(manifest.contains("status = ") && manifest.contains("failed: "), "{case}: {manifest}");
            None
        }
    }
}

fn of(fmu: &Path) -> String {
    format!("reservoir.fmu={{ file = \"{}\", acceleration = \"end\" }}", fmu.display())
}

fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "the template has no {from:?} any more");
    text.replace(from, to)
}

/// Processes whose temporary folder this is: those of a command, and what they have started.
fn processes_of(temporary: &Path) -> Vec<String> {
    let variable = format!("TMPDIR={}", temporary.display());
    let going = |entry: &std::fs::DirEntry| {
        let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
        environment.split(|byte| *byte == 0).any(|pair| pair == variable.as_bytes())
    };
    let entries = std::fs::read_dir("/proc").expect("processes").flatten();
    entries.filter(going).map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

/// An archive of a folder.
fn packed(folder: &Path) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("a folder").flatten() {
            if entry.path().is_dir() {
                folders.push(entry.path());
            } else {
                let path = entry.path();
                let name = path.strip_prefix(folder).expect("inside").to_string_lossy();
                add(&mut archive, &name, &std::fs::read(&path).expect("a file"));
            }
        }
    }
    archive.finish().expect("an archive").into_inner()
}

fn add(archive: &mut ZipWriter<Cursor<Vec<u8>>>, name: &str, bytes: &[u8]) {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    archive.start_file(name, options).expect("an entry");
    archive.write_all(bytes).expect("its bytes");
}

#[test]
fn archives_that_are_none_are_refused() {
    let site = Site::new();
    let whole = {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        add(&mut archive, "modelDescription.xml", site.description.as_bytes());
        add(&mut archive, LIBRARY, b"no library");
        archive.finish().expect("an archive").into_inner()
    };
    let mut encrypted = whole.clone();
    // Bit 0 of the flags, 6 bytes into a local header and 8 into an entry of the directory.
    let central = encrypted.windows(4).position(|at| at == b"PK\x01\x02").expect("a directory");
    encrypted[6] |= 1;
    encrypted[central + 8] |= 1;
    let mut flipped = whole.clone();
    let end = "modelDescription.xml".len() + 30;
    flipped[end + 40..end + 60].iter_mut().for_each(|byte| *byte ^= 0x55);
    let mut linked = ZipWriter::new(Cursor::new(Vec::new()));
    add(&mut linked, "modelDescription.xml", site.description.as_bytes());
    linked.add_symlink("resources", "/etc", SimpleFileOptions::default()).expect("a link");
    let linked = linked.finish().expect("an archive").into_inner();
    // Names of equal length, so that they can be put in place of an honest one.
    let named = |name: &str| {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        add(&mut archive, "modelDescription.xml", site.description.as_bytes());
        let honest = "n".repeat(name.len());
        add(&mut archive, &honest, b"evil");
        let mut bytes = archive.finish().expect("an archive").into_inner();
        while let Some(at) = bytes.windows(honest.len()).position(|w| w == honest.as_bytes()) {
            bytes[at..at + name.len()].copy_from_slice(name.as_bytes());
        }
        bytes
    };
    let empty = {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        add(&mut archive, "readme.txt", b"nothing else");
        archive.finish().expect("an archive").into_inner()
    };
    let no_fmu = "it is no FMU, that is, no zip archive that can be read";
    let outside = "would be written outside the FMU's folder; an honest FMU has none of these";
    let cases: [(&str, Vec<u8>, &[&str]); 12] = [
        ("no archive", b"this is text".to_vec(), &[no_fmu]),
        ("nothing", Vec::new(), &[no_fmu]),
        ("cut short", whole[..whole.len() - 40].to_vec(), &[no_fmu]),
        ("flipped bits", flipped, &["flipped bits.fmu: "]),
        ("encrypted", encrypted, &[no_fmu, "assword"]),
        ("a path out of it", named("../../evil.txt"), &["its entry \"../../evil.txt\"", outside]),
        ("an absolute path", named("/tmp/evil"), &["its entry \"/tmp/evil\"", outside]),
        ("backslashes", named("..\\..\\evil"), &[outside]),
        ("a link", linked, &["its entry \"resources\" is a link"]),
        (
            "an entry twice",
            named("modelDescription.xml"),
            &["it has 2 entries, but 1 names: an entry is there twice; pack it again"],
        ),
        (
            "another name of it",
            named("./modelDescription.xml"),
            &["its entry \"./modelDescription.xml\" is there twice"],
        ),
        ("no description", empty, &["there is no modelDescription.xml at its top"]),
    ];
    for (case, bytes, words) in cases {
        let path = site.scenario.folder().join(format!("{case}.fmu"));
        std::fs::write(&path, bytes).expect("an archive");
        let file = path.display().to_string();
        site.refused_fmu(case, &path, &[&["reservoir: ", &file][..], words].concat());
    }
    assert!(!Path::new("/tmp/evil").exists());

    let many = site.scenario.folder().join("many.fmu");
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    (0..20_001).for_each(|i| archive.start_file(format!("{i}"), stored).expect("an entry"));
    std::fs::write(&many, archive.finish().expect("an archive").into_inner()).expect("an archive");
    site.refused_fmu("20 001 entries", &many, &["it holds more than 20000 files; unpack it by hand"]);
}

#[test]
fn files_that_are_none_are_refused_and_folders_are_as_good_as_archives() {
    let site = Site::new();
    site.refused_fmu(
        "a device",
        Path::new("/dev/zero"),
        &["/dev/zero", "it is a device or a pipe, not a file"],
    );
    let pipe = site.scenario.folder().join("pipe.fmu");
    let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs");
    assert!(made.success());
    site.refused_fmu("a pipe", &pipe, &["pipe.fmu", "it is a device or a pipe, not a file"]);
    let none = Path::new("none.fmu");
    let said = site.call("no file", &["check"], &[&of(none)]);
    said.expect("no file", 2, &["none.fmu"]);

    let folder = site.unpacked("folder", &site.source, &site.description);
    let archive = site.library("archive", &site.source);
    let relative = folder.strip_prefix(site.scenario.folder()).expect("below the scene");
    for (case, path) in [("a folder", &*folder), ("a relative folder", relative), ("an archive", &archive)] {
        let set = of(path);
        site.call(case, &["check"], &[&set]).expect(case, 0, &[]);
        let said = site.call(case, &["run"], &[&set]);
        said.expect(case, 0, &[]);
        assert!(said.exchanges.is_some_and(|count| count > 80), "{case}: {:?}", said.exchanges);
    }
}

#[test]
fn descriptions_that_cannot_be_used_are_refused() {
    let site = Site::new();
    let xml = &site.description;
    let entities: String = ('b'..='m')
        .zip('a'..='l')
        .map(|(new, old)| format!("<!ENTITY {new} \"{}\">", format!("&{old};").repeat(10)))
        .collect();
    let laughs = format!("<?xml version=\"1.0\"?><!DOCTYPE l [<!ENTITY a \"ha\">{entities}]>");
    let body = xml.split_once("?>").expect("a declaration").1;
    let laughs = laughs + &replaced(body, "modelName=\"water\"", "modelName=\"&m;\"");
    let kind = xml.lines().find(|line| line.contains("<CoSimulation ")).expect("a kind");
    let pressure = xml.lines().find(|line| line.contains("\"interface_pressure\"")).expect("a pressure");
    let sized = |size: &str| {
        let at = pressure.find("<Dimension").expect("a dimension");
        replaced(xml, pressure, &format!("{}<Dimension start=\"{size}\"/></Float64>", &pressure[..at]))
    };
    let unusable = "its modelDescription.xml cannot be used: ";
    let cases: [(&str, String, &[&str]); 11] = [
        ("garbage", "<fmi <<< &&&".to_owned(), &[unusable, "correct it, or export the FMU again"]),
        ("an empty description", String::new(), &["correct it, or export the FMU again"]),
        ("another document", "<?xml version=\"1.0\"?><html/>".to_owned(), &["correct it"]),
        ("a billion laughs", laughs, &[unusable, "correct it, or export the FMU again"]),
        (
            "FMI 1.0",
            replaced(xml, "fmiVersion=\"3.0\"", "fmiVersion=\"1.0\""),
            &["it is of FMI 1.0; versions 2.0 and 3.0 can be used: export it again"],
        ),
        (
            "model exchange",
            replaced(xml, kind, "<ModelExchange modelIdentifier=\"water\"/>"),
            &["it is for model exchange alone, not for co-simulation; export it again for co-simulation"],
        ),
        (
            "a library elsewhere",
            replaced(xml, "modelIdentifier=\"water\"", "modelIdentifier=\"../water\""),
            &[unusable, "its modelIdentifier \"../water\" is no name of a library"],
        ),
        (
            "a huge variable",
            sized("99999999999"),
            &[unusable, "variable \"interface_pressure\" has too many values: [99999999999]"],
        ),
        (
            "no pressure",
            replaced(xml, "\"interface_pressure\"", "\"p\""),
            &["it has no output `interface_pressure` of real numbers", "it has `p`[12]", "in `variables`"],
        ),
        (
            "a fixed step",
            replaced(
                xml,
                "canHandleVariableCommunicationStepSize=\"true\"",
                "canHandleVariableCommunicationStepSize=\"false\" fixedInternalStepSize=\"0.001\"",
            ),
            &[
                "it takes steps of 0.001 s alone, and the scene's are 0.0025 s",
                "set `time.communication_step` to a whole multiple of 0.001",
            ],
        ),
        ("no library", xml.clone(), &["its library cannot be loaded", "export it again for this machine"]),
    ];
    for (case, description, words) in cases {
        let fmu = site.described(case, &description);
        let file = fmu.display().to_string();
        site.refused_fmu(case, &fmu, &[&["reservoir: ", &file][..], words].concat());
    }
    let darwin = site.described("darwin", xml);
    std::fs::rename(darwin.join("binaries/x86_64-linux"), darwin.join("binaries/x86_64-darwin"))
        .expect("moved");
    let words =
        ["it has no library binaries/x86_64-linux/water.so", "but for x86_64-darwin; export it again"];
    site.refused_fmu("another platform", &darwin, &words);
    let short = site.unpacked("11 of 12 points", &site.source, &sized("11"));
    let words =
        ["reservoir: `interface_pressure` has 11 values, 12 are needed; both units need the same points"];
    site.refused_fmu("11 of 12 points", &short, &words);

    let file = site.library("honest", &site.source).display().to_string();
    let table = |more: &str| format!("reservoir.fmu={{ file = \"{file}\", acceleration = \"end\", {more} }}");
    let parameter = "it has `water_density`, `gravity`";
    for (case, more, words) in [
        (
            "a name that is not there",
            "variables = { interface_pressure = \"q\" }",
            ["`variables` gives \"q\" for `interface_pressure`", "it has `"],
        ),
        (
            "no variable of the contract",
            "variables = { pressure = \"interface_pressure\" }",
            [
                "`variables` names `pressure`, which is no variable of a reservoir",
                "modelDescription/README.md",
            ],
        ),
        (
            "no such parameter",
            "parameters = { depth = 3.0 }",
            ["parameter \"depth\" is not there", parameter],
        ),
        (
            "a parameter of another type",
            "parameters = { gravity = \"strong\" }",
            ["parameter \"gravity\" is a Float64, and the value given is none", parameter],
        ),
        (
            "an output as parameter",
            "parameters = { interface_pressure = 1.0 }",
            ["is neither a parameter nor an input that nobody drives", parameter],
        ),
        (
            "a value that it refuses",
            "parameters = { gravity = -1.0 }",
            ["fmi3Error", "water_density and gravity must be above 0"],
        ),
    ] {
        site.refused(case, &[&table(more)], &words);
    }
}

#[test]
fn libraries_that_break_the_contract_are_refused() {
    let site = Site::new();
    let source = &site.source;
    let higher = "static const double WATER_DEPTH[1]";
    let moved = replaced(source, "CONSTANT(21, Y)", "CONSTANT(21, HIGHER)");
    let raise = format!("static double HIGHER[POINTS];\n{higher}");
    let lift = "for (int i = 0; i < POINTS; i++) HIGHER[i] = Y[i] + 1.75;";
    let place = "    unit->environment = environment;";
    let lifted = replaced(&replaced(&moved, higher, &raise), place, &format!("{place}\n    {lift}"));
    let deep = replaced(source, "-7.0 / 8.0", "7.0 / 8.0");
    let turned = replaced(source, "CONSTANT(22, NORMAL_X)", "CONSTANT(22, AGAINST)");
    let against = format!("static double AGAINST[POINTS];\n{higher}");
    let turn = "for (int i = 0; i < POINTS; i++) AGAINST[i] = -NORMAL_X[i];";
    let turned = replaced(&replaced(&turned, higher, &against), place, &format!("{place}\n    {turn}"));
    let forgetful =
        replaced(&site.in_step(""), "(DEPTH - Y[i])) * a;", "(DEPTH - Y[i])) * a * (1.0 + 1e-9 * calls);");
    let cases: [(&str, String, &[&str]); 6] = [
        (
            "a function is missing",
            replaced(source, "fmi3Status fmi3DoStep", "fmi3Status fmi3DoOther"),
            &["its library cannot be loaded: it lacks the function fmi3DoStep; FMI asks for all functions"],
        ),
        (
            "the wrong sign",
            deep,
            &["when its face moves into the water by 1 m/s², it answers with -", "turn the sign"],
        ),
        ("normals turned round", turned, &["its normal at point 0 is (-1.000, ", "turn its normals"]),
        (
            "a state that is not restored",
            forgetful,
            &[
                "the same step from its saved state gives `interface_pressure`[0]",
                "save all that its steps change",
            ],
        ),
        (
            "points 1.75 m higher",
            lifted,
            &["at (0, 0) in the dam and at (0, 1.75) in the reservoir", "give both units the same points"],
        ),
        (
            "not finite at the start",
            replaced(
                &site.in_step("s->interface_pressure[3] = 1.0 / 0.0; return NULL;"),
                "!isfinite(values_in",
                "0 && !isfinite(values_in",
            ),
            &["`interface_pressure`[3] became inf"],
        ),
    ];
    for (case, source, words) in cases {
        let fmu = site.library(case, &source);
        site.refused_fmu(case, &fmu, &[&["reservoir"][..], words].concat());
    }
    let honest = site.library("honest", source);
    let sets = [&*of(&honest), "reservoir.depth=90"];
    let words = [
        "ends at (0, 90) in the dam and at (0, 91.75) in the reservoir; both need the same end, at one level",
    ];
    site.refused("91.75 m of water against 90 m", &sets, &words);

    let no_state =
        replaced(&site.description, "canGetAndSetFMUState=\"true\"", "canGetAndSetFMUState=\"false\"");
    let no_state = site.unpacked("no state", source, &no_state);
    let words = ["reservoir cannot save its state", "set coupling.scheme to \"serial-explicit\""];
    site.refused_fmu("no state", &no_state, &words);
    // Light water, with which explicit schemes are stable.
    let light = of(&no_state).replace(" }", ", parameters = { water_density = 50.0 } }");
    let sets = [&*light, "coupling.scheme=\"serial-explicit\"", "reservoir.density=100"];
    for command in ["check", "run"] {
        site.call("no state, explicit", &[command], &sets).expect("no state, explicit", 0, &[]);
    }
}

/// What goes wrong in a run is named with its step, and the log holds what was exchanged before.
#[test]
fn libraries_that_fail_in_a_run_are_named_with_their_step() {
    let site = Site::new();
    // In the first iteration of the sixth step.
    let late = |code: &str| site.in_step(&format!("if (time > 0.0124) {{ {code} }}"));
    let quiet = |source: String| replaced(&source, "!isfinite(values_in", "0 && !isfinite(values_in");
    let cases: [(&str, String, &[&str]); 7] = [
        ("exit(0)", late("exit(0);"), &["reservoir: its process ended with exit status 0 in step "]),
        ("abort()", late("abort();"), &["reservoir: its process was killed by signal 6 in step "]),
        (
            "a null pointer",
            late("volatile int *nowhere = 0; *nowhere = 1;"),
            &["reservoir: its process was killed by signal 11 in step "],
        ),
        (
            "an endless loop",
            late("for (volatile int i = 0;; i++);"),
            &["reservoir: no answer for 1 s in step ", "raise --deadline"],
        ),
        (
            "fmi3Error",
            late("return \"the gate is shut\";"),
            &["reservoir: fmi3DoStep returned fmi3Error: ", "the gate is shut"],
        ),
        (
            "not a number",
            quiet(late("s->interface_pressure[3] = 0.0 / 0.0; return NULL;")),
            &["reservoir: `interface_pressure`[3] became NaN in the step to t = "],
        ),
        (
            "printed words of failure",
            late("puts(\"{\\\"failed\\\":{\\\"text\\\":\\\"printed\\\"}}\"); fflush(stdout); abort();"),
            &["reservoir: printed"],
        ),
    ];
    for (case, source, words) in cases {
        let fmu = site.library(case, &source);
        let said = site.call(case, &["run", "--deadline", "1", "--transport", "shared-memory"], &[&of(&fmu)]);
        said.expect(case, 4, words);
        assert!(said.exchanges.is_some_and(|count| count > 10), "{case}: {:?} exchanges", said.exchanges);
    }
    let early = site.library("exit while it is made", &site.in_making("exit(0);"));
    site.refused_fmu("exit while it is made", &early, &["reservoir: its process ended with exit status 0"]);
}

#[test]
fn what_a_library_prints_or_starts_does_no_harm() {
    let site = Site::new();
    let cases = [
        (
            "prints in steps",
            site.in_step("for (int i = 0; i < 300; i++) { printf(\"noise %d\", i); fputs(\"!\", stderr); if (i % 7 == 0) puts(\"\"); }"),
        ),
        // A word of this program that came behind it on the line would be lost.
        ("prints no end of line", site.in_making("printf(\"begin\"); fflush(stdout);")),
        ("prints no end of line in steps", site.in_step("printf(\"begin\"); fflush(stdout);")),
        (
            "prints words",
            site.in_step(
                "puts(\"{\\\"failed\\\":{\\\"text\\\":\\\"x\\\"}}\"); puts(\"{\\\"ready\\\":{\\\"protocol\\\":6,\\\"description\\\":{}}}\"); fflush(stdout);",
            ),
        ),
        ("prints bytes", site.in_step("for (int i = 0; i < 256; i++) putchar(i); fflush(stdout);")),
        (
            "starts a child",
            format!(
                "#include <unistd.h>\n{}",
                site.in_step("if (calls == 3 && fork() == 0) { for (;;) sleep(100); }")
            ),
        ),
    ];
    for (case, source) in cases {
        let fmu = of(&site.library(case, &source));
        site.call(case, &["check"], &[&fmu]).expect(case, 0, &[]);
        let said = site.call(case, &["run", "--deadline", "5"], &[&fmu]);
        said.expect(case, 0, &[]);
        assert!(said.exchanges.is_some_and(|count| count > 80), "{case}: {:?}", said.exchanges);
    }
    let ready = site
        .in_making("puts(\"{\\\"ready\\\":{\\\"protocol\\\":6,\\\"description\\\":{}}}\"); fflush(stdout);");
    let ready = site.library("printed to be ready", &ready);
    site.refused_fmu("printed to be ready", &ready, &["reservoir: its description cannot be read"]);
}

/// A run that was killed and those that follow it, all with one temporary folder.
#[test]
fn folders_of_killed_runs_are_removed_by_the_next_run() {
    let site = Site::new();
    let endless = of(&site.library("endless", &site.in_step("if (calls > 20) for (;;);")));
    let honest = of(&site.library("honest", &site.source));
    let temporary = tempfile::tempdir().expect("a folder");
    let folders = || -> BTreeSet<String> {
        let entries = std::fs::read_dir(temporary.path()).expect("a folder").flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    };
    let start = |name: &str, fmu: &str, transport: &str| {
        let mut command = Command::new(binary());
        command.arg("run").arg(&site.scene).args(["--set", fmu, "--quiet", "--transport", transport]);
        command.arg("--output").arg(site.case("runs").join(name)).env("TMPDIR", temporary.path());
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("cofferdam runs")
    };
    for (transport, prefix) in [("in-process", "cofferdam-fmu-"), ("shared-memory", "cofferdam-unit-")] {
        let before = folders();
        assert_eq!(before, BTreeSet::new(), "{transport}");
        let mut live = start(&format!("{transport}-live"), &endless, transport);
        assert!(wait_until(|| !folders().is_empty()));
        // A unit's process each.
        let of_each = if transport == "in-process" { 1 } else { 2 };
        assert!(wait_until(|| folders().len() == of_each), "{transport}: {:?}", folders());
        let of_live = folders();
        let mut killed = start(&format!("{transport}-killed"), &endless, transport);
        assert!(wait_until(|| folders().len() == 2 * of_each), "{transport}: {:?}", folders());
        killed.kill().expect("killed");
        killed.wait().expect("ended");
        assert!(folders().len() == 2 * of_each, "nothing but a run removes it");
        for run in 0..2 {
            let status = start(&format!("{transport}-next-{run}"), &honest, transport).wait().expect("ended");
            assert!(status.success(), "{transport}: {status}");
            assert_eq!(folders(), of_live, "{transport}: the folder of the run that lives, and no other");
        }
        assert!(of_live.iter().all(|name| name.starts_with(prefix)), "{of_live:?}");
        live.kill().expect("killed");
        live.wait().expect("ended");
        assert_eq!(folders(), of_live);
        // Two that begin at the same time.
        let names = ["one", "other"].map(|name| format!("{transport}-{name}"));
        for mut run in names.map(|name| start(&name, &honest, transport)) {
            assert!(run.wait().expect("ended").success(), "{transport}");
        }
        assert_eq!(folders(), BTreeSet::new(), "{transport}");
    }
}

#[test]
fn commands_that_are_no_units_are_refused() {
    let mut site = Site::new();
    site.scenario.set("reservoir.fidelity", "command");
    site.scene = site.scenario.write();
    let command = |argv: &str| format!("reservoir.command={{ argv = [{argv}] }}");
    for (case, argv, words) in [
        (
            "no program",
            "\"no-such-program\"",
            ["its process, `no-such-program`, cannot be started", "correct the command"],
        ),
        (
            "garbage",
            "\"sh\", \"-c\", \"echo garbage; echo '{\\\"ready\\\":3}'; exit 3\"",
            ["its process ended with exit status 3", "while the units were made"],
        ),
        ("true", "\"true\"", ["its process ended with exit status 0", "while the units were made"]),
    ] {
        site.refused(case, &[&command(argv)], &[&["reservoir: "][..], &words].concat());
    }
    let sleeps = command("\"sleep\", \"1000\"");
    let said = site.call("sleeps", &["run", "--deadline", "0.1"], &[&sleeps]);
    said.expect("sleeps", 4, &["reservoir: no answer for 6 s while the units were made", "--deadline"]);
    let said = site.call("no argument", &["check"], &["reservoir.command={ argv = [] }"]);
    said.expect("no argument", 2, &["argv"]);
}

#[test]
fn logs_that_cannot_stand_for_a_unit_are_refused() {
    let mut site = Site::new();
    site.scenario.set("reservoir.fidelity", "westergaard");
    site.scene = site.scenario.write();
    let record = |name: &str, sets: &[&str]| {
        let said = site.call(name, &["run"], sets);
        said.expect(name, 0, &[]);
        site.scenario.folder().join(name).join("run-1")
    };
    let whole = record("whole", &[]);
    let in_mass = record("in mass", &["coupling.scheme=\"added-mass\""]);
    site.scenario.set("reservoir.fidelity", "log");
    site.scene = site.scenario.write();
    let log = |path: &Path| format!("reservoir.log={{ file = \"{}\" }}", path.display());
    let text = site.scenario.folder().join("text.mcap");
    std::fs::write(&text, "this is no log").expect("a file");
    let cut = site.scenario.folder().join("cut.mcap");
    let bytes = std::fs::read(whole.join("log.mcap")).expect("a log");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).expect("a file");
    let longer = [log(&whole), "time.duration=0.1".to_owned()];
    let other = [log(&whole), "time.communication_step=0.005".to_owned()];
    let cases: [(&str, &[String], &[&str]); 5] = [
        ("no log", &[log(&text)], &["text.mcap"]),
        ("half a log", &[log(&cut)], &["cut.mcap"]),
        (
            "a shorter run",
            &longer,
            &["it ends at t = 0.05 s, and the run is to last 0.1 s; set `time.duration` to 0.05"],
        ),
        ("another step", &other, &["set `time.communication_step` to that of the log"]),
        (
            "the water in the dam's mass",
            &[log(&in_mass)],
            &["the water's mass was in the dam's mass matrix", "serial-implicit"],
        ),
    ];
    for (case, sets, words) in cases {
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        site.refused(case, &sets, words);
    }
    site.call("an honest log", &["check"], &[&log(&whole)]).expect("an honest log", 0, &[]);
}
