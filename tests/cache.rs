//! Operators of the water that are kept on disk.

use std::path::Path;
use std::process::{Command, Output};
use whole_chain::scenario::{Scenario, binary};

fn cofferdam(arguments: &[&str], cache: &Path) -> Output {
    let mut command = Command::new(binary());
    let output = command.args(arguments).arg("--cache").arg(cache).output().expect("cofferdam runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn said(arguments: &[&str], cache: &Path) -> String {
    String::from_utf8(cofferdam(arguments, cache).stdout).expect("text")
}

/// First, second time, from a damaged entry, without a cache, for a recursion and a convolution: the same bits. Only the second
/// time nothing is written.
#[test]
fn what_was_kept_gives_the_same_bits() {
    for (method, transport) in [("recursive", "in-process"), ("radau2", "shared-memory")] {
        let mut scenario = Scenario::shipped("koyna-coarse");
        scenario.set("dam.element_size", 10.0).set("reservoir.method", method);
        scenario.set("time.duration", if method == "radau2" { 2.0 } else { 0.1 });
        let cache = scenario.folder().join("cache");
        let run = |name: &str| {
            let mut command = scenario.command(name);
            command.args(["--until", "0.05", "--transport", transport]);
            let done = match name {
                "without" => command.arg("--no-cache"),
                _ => command.arg("--cache").arg(&cache),
            };
            let output = done.output().expect("cofferdam runs");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        };
        let entry = || {
            let all = std::fs::read_dir(&cache).expect("a cache").map(|entry| entry.expect("a file").path());
            let all: Vec<_> = all.collect();
            let [entry] = &all[..] else { panic!("{all:?}") };
            (entry.clone(), std::fs::read(entry).expect("an entry"))
        };
        run("first");
        let (path, bytes) = entry();
        run("second");
        let mut damaged = bytes.clone();
        *damaged.last_mut().expect("bytes") ^= 1;
        std::fs::write(&path, damaged).expect("it is damaged");
        run("third");
        assert!(entry() == (path, bytes), "the damaged entry is made again");
        run("without");
        for other in ["second", "third", "without"] {
            let of = |run: &str| scenario.folder().join(run).to_string_lossy().into_owned();
            said(&["log", "diff", &of("first"), &of(other)], &cache);
        }
        let content = said(&["cache"], &cache);
        assert!(content.contains("1 entries"), "{content}");
        let cleared = said(&["cache", "clear"], &cache);
        assert!(cleared.contains("1 entries") && cleared.contains("removed"), "{cleared}");
        assert!(said(&["cache"], &cache).contains("0 entries"));
    }
}

/// `check` knows that there is nothing to prepare, and a folder that is none does no harm.
#[test]
fn a_cache_is_told_of_and_is_never_needed() {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0).set("time.duration", 20.0).set("reservoir.method", "radau2");
    let path = scenario.write();
    let path = path.to_str().expect("a path");
    let cache = scenario.folder().join("cache");
    let prepares = |cache: &Path| !said(&["check", path], cache).contains(", 0 s of it to prepare");
    assert!(prepares(&cache));
    let mut command = scenario.command("run");
    let done = command.args(["--until", "0.01", "--cache"]).arg(&cache).status().expect("it runs");
    assert!(done.success());
    assert!(!prepares(&cache));
    assert!(prepares(Path::new("/dev/null/none")));
    let mut command = scenario.command("nowhere");
    let done = command.args(["--until", "0.01", "--cache", "/dev/null/none"]).status().expect("it runs");
    assert!(done.success());
}
