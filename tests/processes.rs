//! Units as processes: killed, hung, doubled, run by another user; nothing is left in shared memory.

use cofferdam_assembly::units::DAM;
use cofferdam_log::{Entry, Log};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use whole_chain::process::{is_gone, signal, wait_until};
use whole_chain::scenario::{Histories, Scenario, binary, is_root};

/// Tests that check shared memory must run alone.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A run whose processes are known.
pub(crate) struct Running {
    pub(crate) orchestrator: Child,
    output: BufReader<ChildStdout>,
    pub(crate) dam: u32,
    pub(crate) reservoir: u32,
}

impl Running {
    pub(crate) fn start(mut command: Command) -> Self {
        let mut orchestrator =
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("cofferdam runs");
        let mut output = BufReader::new(orchestrator.stdout.take().expect("its output"));
        let line = line_with(&mut output, "processes");
        let number = |name: &str| -> u32 {
            let after = line.split(name).nth(1).expect("a process").trim_start();
            after.split(|c: char| !c.is_ascii_digit()).next().and_then(|n| n.parse().ok()).expect("a number")
        };
        let (dam, reservoir) = (number("dam"), number("reservoir"));
        Self { orchestrator, output, dam, reservoir }
    }

    /// Waits until the first step is near.
    pub(crate) fn prepared(&mut self) {
        line_with(&mut self.output, "prepared");
    }

    /// Waits for all three processes; returns the exit of the orchestrator and the output of all of them.
    pub(crate) fn end(self) -> (ExitStatus, String) {
        let (status, said, _) = self.end_with_summary();
        (status, said)
    }

    /// The same with the standard output.
    fn end_with_summary(mut self) -> (ExitStatus, String, String) {
        let mut summary = String::new();
        self.output.read_to_string(&mut summary).expect("text");
        let status = self.orchestrator.wait().expect("it ends");
        let mut said = String::new();
        // Ends when the last process that writes there has ended.
        self.orchestrator.stderr.take().expect("its errors").read_to_string(&mut said).expect("text");
        for process in [self.dam, self.reservoir] {
            assert!(wait_until(|| is_gone(process)), "process {process} is still there");
        }
        (status, said.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" "), summary)
    }
}

fn line_with(output: &mut impl BufRead, word: &str) -> String {
    let found = output.lines().map_while(Result::ok).find(|line| line.contains(word));
    found.unwrap_or_else(|| panic!("no line with `{word}`"))
}

/// The folders of this user's runs in shared memory.
fn leftovers() -> Vec<PathBuf> {
    let user = std::os::unix::fs::MetadataExt::uid(&Path::new("/proc/self").metadata().expect("proc"));
    let mine = format!("cofferdam-{user}-");
    let mut found: Vec<_> =
        std::fs::read_dir("/dev/shm").into_iter().flatten().flatten().map(|e| e.path()).collect();
    found.retain(|path| path.file_name().unwrap_or_default().to_string_lossy().starts_with(&mine));
    found
}

/// Runs of other tests, which may go on at the same time, come and go.
fn assert_nothing_left() {
    assert!(wait_until(|| leftovers().is_empty()), "{:?}", leftovers());
}

/// A following run succeeds, and then nothing is left of the earlier ones.
fn the_next_run_succeeds() {
    let output = Scenario::quick(0.1).try_run("after");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_nothing_left();
}

/// Arbitrary times after the preparation, ms.
fn moments() -> Vec<u64> {
    let count = std::env::var("COFFERDAM_FAULTS").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    (1..=count).map(|i: u64| i * 7919 % 400).collect()
}

#[test]
fn a_killed_unit_ends_the_run_with_its_name_and_the_step() {
    let _alone = alone();
    let scenario = Scenario::quick(20.0);
    for (round, moment) in moments().into_iter().enumerate() {
        for victim in ["dam", "reservoir"] {
            let folder = format!("{victim}-{round}");
            let mut running = Running::start(scenario.command(&folder));
            running.prepared();
            std::thread::sleep(Duration::from_millis(moment));
            signal(if victim == "dam" { running.dam } else { running.reservoir }, "-KILL");
            let killed = Instant::now();
            let (status, said, summary) = running.end_with_summary();
            println!(
                "{victim} killed after {moment} ms: all ended {:.0} ms later",
                1e3 * killed.elapsed().as_secs_f64()
            );
            assert_eq!(status.code(), Some(4), "{said}");
            assert!(said.contains(&format!("{victim}: its process was killed by signal 9")), "{said}");
            assert!(said.contains("in step") || said.contains("at initialisation"), "{said}");
            let manifest = std::fs::read_to_string(scenario.folder().join(&folder).join("manifest.toml"));
            assert!(manifest.expect("a manifest").contains("killed by signal 9"));
            assert!(summary.contains("Rayleigh, 5 % at") && !summary.contains("NaN"), "{summary}");
            the_next_run_succeeds();
        }
    }
}

/// As job schedulers end a run: the units leave it to the orchestrator, which sums up what there is.
#[test]
fn a_signal_to_all_processes_interrupts_the_run() {
    let _alone = alone();
    let scenario = Scenario::quick(20.0);
    for name in ["-TERM", "-INT", "-HUP"] {
        let mut running = Running::start(scenario.command(name));
        running.prepared();
        for unit in [running.dam, running.reservoir] {
            signal(unit, name);
        }
        std::thread::sleep(Duration::from_millis(300));
        assert!(!is_gone(running.dam) && !is_gone(running.reservoir), "{name} ended a unit");
        signal(running.orchestrator.id(), name);
        let (status, said, summary) = running.end_with_summary();
        assert_eq!(status.code(), Some(130), "{name}: {said}");
        assert!(summary.contains("PARTIAL RESULT") && summary.contains("interrupted"), "{name}: {summary}");
    }
    the_next_run_succeeds();
}

#[test]
fn units_end_when_the_orchestrator_is_killed() {
    let _alone = alone();
    let scenario = Scenario::quick(20.0);
    for (round, moment) in moments().into_iter().enumerate() {
        let mut running = Running::start(scenario.command(&format!("run-{round}")));
        running.prepared();
        std::thread::sleep(Duration::from_millis(moment));
        signal(running.orchestrator.id(), "-KILL");
        let killed = Instant::now();
        let (_, said) = running.end();
        println!(
            "orchestrator killed after {moment} ms: all ended {:.0} ms later",
            1e3 * killed.elapsed().as_secs_f64()
        );
        for unit in ["dam", "reservoir"] {
            assert!(said.contains(&format!("{unit}: the orchestrator died")), "{said}");
        }
        the_next_run_succeeds();
    }
}

#[test]
fn units_that_are_still_being_made_can_be_killed_too() {
    let _alone = alone();
    let mut scenario = Scenario::quick(20.0);
    scenario.set("reservoir.fidelity", "compressible");
    let running = Running::start(scenario.command("unit"));
    signal(running.reservoir, "-KILL");
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(4), "{said}");
    assert!(
        said.contains("reservoir: its process was killed by signal 9 while the units were made"),
        "{said}"
    );
    // What was to be run is on the disk, and how it ended.
    let folder = scenario.folder().join("unit");
    let manifest = std::fs::read_to_string(folder.join("manifest.toml")).expect("a manifest");
    assert!(manifest.contains("status = \"failed: reservoir: its process was killed"), "{manifest}");
    let log = std::fs::read(folder.join("log.mcap")).expect("a log");
    let message = mcap::MessageStream::new(&log).expect("MCAP").next().expect("a message").expect("readable");
    assert_eq!(message.channel.topic, "/scene");
    let headless = cofferdam_log::Log::open(&folder.join("log.mcap")).map(drop);
    assert!(matches!(headless, Err(cofferdam_log::LogReadError::Headless { .. })), "{headless:?}");
    let running = Running::start(scenario.command("orchestrator"));
    signal(running.orchestrator.id(), "-KILL");
    running.end();
    the_next_run_succeeds();
}

#[test]
fn a_unit_that_hangs_is_ended_by_its_deadline() {
    let _alone = alone();
    let scenario = Scenario::quick(20.0);
    // Where it stops while the outline is read from it, no request stands.
    assert!(
        (0..4).any(|attempt| a_request_stands(&scenario, &format!("run-{attempt}"))),
        "its answer does not"
    );
    the_next_run_succeeds();
}

/// Stops the dam of a run, and tells whether the log ends with a request to it.
fn a_request_stands(scenario: &Scenario, folder: &str) -> bool {
    let mut command = scenario.command(folder);
    command.args(["--deadline", "0.5"]);
    let mut running = Running::start(command);
    running.prepared();
    std::thread::sleep(Duration::from_millis(100));
    signal(running.dam, "-STOP");
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(4), "{said}");
    assert!(said.contains("dam: no answer for 0.5 s in step") && said.contains("--deadline"), "{said}");
    let log = Log::open(&scenario.folder().join(folder).join("log.mcap")).expect("a log");
    let entries: Vec<Entry> =
        log.entries().expect("entries").collect::<Result<_, _>>().expect("an intact log");
    assert!(
        matches!(entries.last(), Some(Entry::End(end)) if end.status.contains("no answer")),
        "{:?}",
        entries.last()
    );
    let last = entries.iter().rev().find_map(|e| if let Entry::Exchange(e) = e { Some(e) } else { None });
    last.is_some_and(|e| e.unit == DAM && e.outputs.is_none())
}

#[test]
fn an_orchestrator_that_was_stopped_goes_on() {
    let _alone = alone();
    let scenario = Scenario::quick(2.0);
    let mut command = scenario.command("run");
    command.args(["--deadline", "0.5"]);
    let mut running = Running::start(command);
    running.prepared();
    std::thread::sleep(Duration::from_millis(50));
    signal(running.orchestrator.id(), "-STOP");
    std::thread::sleep(Duration::from_millis(1500));
    signal(running.orchestrator.id(), "-CONT");
    let (status, said) = running.end();
    assert!(status.success(), "{said}");
}

#[test]
fn ctrl_c_ends_the_preparation() {
    let _alone = alone();
    let mut scenario = Scenario::quick(20.0);
    scenario.set("reservoir.fidelity", "compressible");
    let running = Running::start(scenario.command("run"));
    signal(running.orchestrator.id(), "-INT");
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(130), "{said}");
    assert!(!said.contains("died"), "{said}");
    the_next_run_succeeds();
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    let _alone = alone();
    let scenario = Scenario::quick(1.0);
    let runs = ["one", "two"].map(|folder| scenario.command(folder).stdout(Stdio::null()).spawn());
    for run in runs {
        assert!(run.expect("cofferdam runs").wait().expect("it ends").success());
    }
    let crest = ["one", "two"].map(|folder| {
        let histories = Histories::read(&scenario.folder().join(folder).join("histories.csv"));
        histories.column("dam.crest_displacement.x").iter().map(|u| u.to_bits()).collect::<Vec<_>>()
    });
    assert_eq!(crest[0], crest[1]);
    assert_nothing_left();
}

#[test]
fn a_second_user_can_run() {
    let _alone = alone();
    if !is_root() {
        println!("not tried: only root can run a program as another user");
        return;
    }
    let folder = Scenario::quick(0.2).for_all_users();
    let run = |user: u32| {
        let mut command = Command::new(folder.path().join("cofferdam"));
        command.arg("run").arg(folder.path()).arg("--output").arg(folder.path().join(user.to_string()));
        command.arg("--quiet").current_dir(folder.path());
        std::os::unix::process::CommandExt::uid(&mut command, user).output().expect("cofferdam runs")
    };
    // The files of the first user exist already, and those of the third do not disturb the first.
    for user in [0, 65534, 12345, 0] {
        let target = folder.path().join(user.to_string());
        drop(std::fs::remove_dir_all(&target));
        let output = run(user);
        assert!(output.status.success(), "user {user}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

/// While root's run continues, another user takes the names that could be its, and tries to enter, read, change, move and
/// remove what belongs to it.
#[test]
fn another_user_can_neither_stop_nor_read_nor_alter_a_run() {
    let _alone = alone();
    if !is_root() {
        println!("not tried: only root can run a program as another user");
        return;
    }
    let script = r#"
        cd /dev/shm
        mkdir -m 777 cofferdam-0 cofferdam-0-0123456789abcdef 2> /dev/null
        tries=0
        while [ ! -e "$1" ]; do
            for run in cofferdam-0-*; do
                [ -d "$run" ] && [ ! -O "$run" ] || continue
                tries=$((tries + 1))
                ls "$run" && echo "entered $run"
                cat "$run/lock" "$run"/*.data && echo "read $run"
                echo x >> "$run/lock" && echo "changed $run/lock"
                mv "$run" "$run-moved" && echo "moved $run"
                chmod 777 "$run" && echo "opened $run"
                rm -r "$run" < /dev/null && echo "removed $run"
            done 2> /dev/null
        done
        rmdir cofferdam-0 cofferdam-0-0123456789abcdef 2> /dev/null
        echo "tried: $tries"
    "#;
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::set_permissions(folder.path(), PermissionsExt::from_mode(0o755)).expect("permissions");
    let over = folder.path().join("over");
    let mut other = Command::new("sh");
    other.args(["-c", script, "sh"]).arg(&over).stdout(std::process::Stdio::piped());
    let other = std::os::unix::process::CommandExt::uid(&mut other, 65534).spawn().expect("sh runs");
    let output = Scenario::quick(0.5).try_run("disturbed");
    std::fs::write(&over, "").expect("written");
    let said = other.wait_with_output().expect("it ends").stdout;
    let said = String::from_utf8_lossy(&said).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let tries = said.strip_prefix("tried: ").and_then(|tries| tries.trim().parse::<u32>().ok());
    assert!(tries.is_some_and(|tries| tries > 0), "{said}");
}

/// Runs a script as root in a mount namespace of its own; `None` where that is not allowed.
fn with_other_mounts(script: &str) -> Option<std::process::Output> {
    let allowed =
        Command::new("unshare").args(["--mount", "true"]).output().is_ok_and(|o| o.status.success());
    if !allowed {
        println!("not tried: mount namespaces are not allowed here");
        return None;
    }
    Some(Command::new("unshare").args(["--mount", "sh", "-c", script]).output().expect("unshare runs"))
}

#[test]
fn a_machine_without_shared_memory_is_told_how_to_go_on() {
    let _alone = alone();
    let scenario = Scenario::quick(0.2);
    let scene = scenario.write();
    let (program, scene, folder) = (binary().display(), scene.display(), scenario.folder().display());
    let run = format!("exec {program} run {scene} --quiet --output {folder}");
    for (name, mount, why) in [
        ("missing", "mkdir -p DIR && mount --bind DIR /dev", "/dev/shm: No such file or directory"),
        (
            "full",
            "mount -t tmpfs -o size=4k tmpfs /dev/shm && head -c 4096 /dev/zero > /dev/shm/x",
            "/dev/shm has 0 KiB free",
        ),
        (
            "read-only",
            "mount -t tmpfs -o ro tmpfs /dev/shm",
            "/dev/shm cannot be written to: Read-only file system",
        ),
    ] {
        let mount = mount.replace("DIR", &format!("{folder}/empty"));
        let Some(output) = with_other_mounts(&format!("{mount}; {run}/{name}")) else { return };
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let said = said.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(4), "{name}: {said}");
        assert!(said.contains(why), "{name}: {said}");
        assert!(said.contains("--transport in-process"), "{name}: {said}");
        let Some(output) = with_other_mounts(&format!("{mount}; {run}/{name} --transport in-process")) else {
            return;
        };
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_environment_can_ask_for_one_process_and_an_option_for_more() {
    let scenario = Scenario::quick(0.1);
    let said = |output: &str, transport: &str, options: &[&str]| {
        let mut command = scenario.command(output);
        let done = command.args(options).env("COFFERDAM_TRANSPORT", transport).output().expect("it runs");
        let said = [&done.stdout, &done.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
        (done.status.code(), said.concat())
    };
    for (output, transport, options, processes) in [
        ("here", "in-process", &[][..], false),
        ("apart", "shared-memory", &[], true),
        ("asked", "in-process", &["--transport", "shared-memory"], true),
    ] {
        let (status, said) = said(output, transport, options);
        assert_eq!((status, said.contains("processes")), (Some(0), processes), "{said}");
    }
    let (status, said) = said("nowhere", "pigeons", &[]);
    assert!(status == Some(2) && said.contains("pigeons") && said.contains("in-process"), "{said}");
}
