//! What the machine does to a run: full disks, limits, results that are removed. Whatever happens, the exit status is not
//! 0, the message names the file, and what was written before can be read.

use cofferdam_log::{Log, LogReadError};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use whole_chain::scenario::{Scenario, binary, is_root};

/// Runs a shell's `script` with the program as `$1`, the scene as `$2` and the folder of the results as `$3`.
fn shell(script: &str, scene: &Path, results: &Path) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", script, "sh"]).arg(binary()).arg(scene).arg(results);
    command.stdin(Stdio::null()).output().expect("sh runs")
}

/// What was written to standard error, on one line.
fn said(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// The number of entries of the log in `folder`; 0 if it has none, or not even a beginning.
fn entries_of_log(folder: &Path) -> usize {
    let log = match Log::open(&folder.join("log.mcap")) {
        Err(LogReadError::Open { .. } | LogReadError::Headless { .. } | LogReadError::Empty { .. }) => {
            return 0;
        }
        log => log.expect("a log that begins as one"),
    };
    // A log may end anywhere; nothing before is damaged.
    log.entries().expect("entries").take_while(Result::is_ok).count()
}

#[test]
fn output_to_a_full_device_is_no_success() {
    let scenario = Scenario::quick(0.05);
    let script = r#""$1" run "$2" --quiet --transport in-process --output "$3" > /dev/full"#;
    let output = shell(script, &scenario.write(), &scenario.folder().join("full"));
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("standard output: No space left on device"), "{}", said(&output));
    let manifest = std::fs::read_to_string(scenario.folder().join("full/manifest.toml")).expect("a manifest");
    assert!(manifest.contains("status = \"completed\""), "the results are whole: {manifest}");
}

#[test]
fn a_limit_of_file_sizes_is_an_error_and_no_signal() {
    let scenario = Scenario::quick(3.0);
    let scene = scenario.write();
    for (transport, blocks, status, words) in [
        ("in-process", 2000, 1, ["log.mcap: File too large", "raise the limit of file sizes (`ulimit -f`)"]),
        ("shared-memory", 16, 4, ["shared memory is not available", "files are limited to 8 KiB"]),
    ] {
        // sh counts in blocks of 512 bytes.
        let script = format!(
            r#"ulimit -f {blocks}; exec "$1" run "$2" --quiet --transport {transport} --output "$3""#
        );
        let folder = scenario.folder().join(transport);
        let output = shell(&script, &scene, &folder);
        assert_eq!(output.status.code(), Some(status), "{transport}: {}", said(&output));
        assert!(words.iter().all(|word| said(&output).contains(word)), "{transport}: {}", said(&output));
        assert!(status == 4 || entries_of_log(&folder) > 10, "{transport}: what was written can be read");
    }
}

/// With few processes and threads allowed a run ends with a message, whichever it is that cannot be made; with enough it
/// succeeds.
#[test]
fn processes_and_threads_that_cannot_be_made_are_named() {
    if !is_root() {
        println!("not tried: only root can run a program as another user, whom limits bind");
        return;
    }
    for (transport, scheme) in [("shared-memory", "serial-implicit"), ("in-process", "parallel-implicit")] {
        let folder = Scenario::quick(0.05).set("coupling.scheme", scheme).for_all_users();
        let run = |most: u32| {
            let (limit, output) = (format!("--nproc={most}:{most}"), most.to_string());
            let mut command = Command::new("prlimit");
            command.args([&limit, "./cofferdam", "run", "scene.toml", "--quiet", "--transport", transport]);
            command.args(["--output", &output]).current_dir(folder.path()).stdin(Stdio::null());
            // A user of its own, who has no other processes.
            std::os::unix::process::CommandExt::uid(&mut command, 54_321).output().expect("prlimit runs")
        };
        let mut refused = 0;
        let succeeds = (0..40).any(|most| {
            let output = run(most);
            let said = said(&output);
            assert!(!said.contains("panicked"), "{most}: {said}");
            match output.status.code() {
                Some(0) => return true,
                Some(1 | 4) => refused += 1,
                status => panic!("{most}: status {status:?}: {said}"),
            }
            let words = ["ulimit -u", "use --transport in-process", "ask for fewer"];
            assert!(words.iter().any(|word| said.contains(word)), "{most}: {said}");
            false
        });
        println!("{transport}: refused with fewer than {refused} processes and threads");
        assert!(succeeds && refused > 2);
    }
}

#[test]
fn results_that_are_removed_during_a_run_end_it() {
    let scenario = Scenario::quick(60.0);
    let scene = scenario.write();
    for name in ["log.mcap", "histories.csv"] {
        let folder = scenario.folder().join(name.replace('.', "-"));
        let mut command = Command::new(binary());
        command
            .arg("run")
            .arg(&scene)
            .args(["--quiet", "--transport", "in-process", "--output"])
            .arg(&folder);
        let run = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("cofferdam runs");
        let began = Instant::now();
        while !std::fs::metadata(folder.join("histories.csv")).is_ok_and(|file| file.len() > 0) {
            assert!(began.elapsed() < Duration::from_secs(60), "no histories");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::fs::remove_file(folder.join(name)).expect("removed");
        let output = run.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let words = [name, "it was removed or replaced during the run", "leave the results alone"];
        assert!(words.iter().all(|word| said(&output).contains(word)), "{}", said(&output));
        let manifest = std::fs::read_to_string(folder.join("manifest.toml")).expect("a manifest");
        assert!(manifest.contains("removed or replaced"), "{manifest}");
    }
}

/// A disk that becomes full, at sizes from nothing to nearly enough (`COFFERDAM_FAULTS`: how many; docs/measurements/reliability.md).
#[test]
fn a_full_disk_ends_a_run_and_damages_nothing() {
    let count = std::env::var("COFFERDAM_FAULTS").ok().and_then(|n| n.parse().ok()).unwrap_or(3u64);
    let scenario = Scenario::quick(1.0);
    let (scene, folder) = (scenario.write(), scenario.folder().to_owned());
    let script = |size: u64| {
        format!(
            r#"mkdir -p "$3" && mount -t tmpfs -o size={size}k tmpfs "$3" || exit 77
            "$1" run "$2" --quiet --transport in-process --output "$3/run"
            status=$?; mkdir -p "$3-kept" && cp -r "$3/." "$3-kept"; exit $status"#
        )
    };
    let run = |size: u64| {
        let results = folder.join(format!("disk-{size}"));
        let mut command = Command::new("unshare");
        command.args(["--mount", "sh", "-c", &script(size), "sh"]).arg(binary()).arg(&scene).arg(&results);
        (command.stdin(Stdio::null()).output(), folder.join(format!("disk-{size}-kept")).join("run"))
    };
    let (enough, _) = run(1 << 16);
    if !enough.is_ok_and(|output| output.status.success()) {
        println!("not tried: mount namespaces are not allowed here");
        return;
    }
    let used: u64 = std::fs::read_dir(folder.join("disk-65536-kept/run"))
        .expect("results")
        .flatten()
        .map(|file| file.metadata().map_or(0, |metadata| metadata.len()) / 1024 + 4)
        .sum();
    let mut most = 0;
    for i in 1..=count {
        let size = (used * i / (count + 1)).max(4);
        let (output, results) = run(size);
        let output = output.expect("it ran before");
        let entries = entries_of_log(&results);
        let said = said(&output);
        let error = said.split(" × ").last().unwrap_or_default();
        let results = results.display().to_string();
        let error = error.replace(results.trim_end_matches("-kept/run"), "");
        println!(
            "{size} KiB of {used}: status {:?}, {entries} entries of the log: {error}",
            output.status.code()
        );
        assert_eq!(output.status.code(), Some(1), "{said}");
        let words = ["No space left on device", "free some space or choose another --output"];
        assert!(words.iter().all(|word| said.contains(word)) && !said.contains("panicked"), "{said}");
        most = most.max(entries);
    }
    assert!(most > 10, "a part of a log was written");
}
