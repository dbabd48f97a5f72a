//! A unit's process that breaks the protocol is refused or ended, with a message that says how.

use orchestrator::participant::{
    Deadlines, Level, Occasion, Participant, ParticipantError, SharedMemory, Starting,
};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Starts a unit with a fault.
fn start(fault: &str) -> Result<SharedMemory, ParticipantError> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_misbehaving_unit"));
    command.arg(fault);
    let deadlines = Deadlines { preparation: Duration::from_secs(1), step: Duration::from_millis(200) };
    let starting = Starting::new([("dam".to_owned(), command)], "", 1, deadlines)?;
    let process = starting.processes().map(|(_, id)| id).next().expect("a process");
    let mut units = starting.wait(&AtomicBool::new(false)).inspect_err(|_| assert_gone(process))?;
    Ok(units.pop().expect("a unit"))
}

fn assert_gone(process: u32) {
    // Its orchestrator, this test, has waited for it.
    assert!(!std::path::Path::new(&format!("/proc/{process}")).exists(), "process {process} is still there");
}

/// The error of such a unit when it is started and takes a step.
fn message(fault: &str) -> String {
    let step = || -> Result<(), ParticipantError> {
        let mut unit = start(fault)?;
        let mut outputs = [0.0; 3];
        unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut outputs)?;
        assert_eq!(outputs, [1.0, 2.0, 3.0], "{fault}: initialisation is without fault");
        let occasion = Occasion { step: 1, iteration: 2, attempt: 1, time: 0.25, communication_step: 0.25 };
        unit.save_state()?;
        unit.step(&occasion, &[4.0, 5.0, 6.0], &mut outputs)
    };
    step().expect_err(fault).to_string()
}

#[test]
fn every_breach_is_named() {
    for (fault, words) in [
        ("old-version", ["dam speaks version 5 of the exchange protocol", "this program version 4"]),
        ("no-description", ["dam: its description cannot be read", "the same build"]),
        ("no-service", ["dam is not connected", "must serve `cofferdam/"]),
        ("other-layout", ["dam lays out requests and answers as 0123", "the same build"]),
        ("silent", ["dam: no answer for 1 s while the units were made", "--deadline"]),
        ("chatters", ["dam: no answer for 1 s while the units were made", "was killed"]),
        ("other-name", ["dam: its description cannot be read", "it is that of `dyke`"]),
        ("warns-and-dies", ["dam: it is too much", ""]),
        ("exits", ["dam: its process ended with exit status 7", "while the units were made"]),
        ("panics", ["dam: its process ended with exit status 101", "while the units were made"]),
        ("short-answer", ["dam answered with 2 values", "3 were expected"]),
        ("wrong-echo", ["dam answered with time 0.75 where 0.25 was asked for", "must echo"]),
        ("not-finite", ["dam: `y`[2] became inf", "t = 0.5 s"]),
        ("fails-silently", ["dam: failed in step 1 from t = 0.25 s, iteration 2", "did not say why"]),
        ("promises-words", ["dam: failed in step 1 from t = 0.25 s, iteration 2", "did not say why"]),
        ("hangs", ["dam: no answer for 0.2 s in step 1 from t = 0.25 s, iteration 2", "was killed"]),
        ("dies", ["dam: its process was killed by signal 6 in step 1", "iteration 2"]),
    ] {
        let message = message(fault);
        assert!(words.iter().all(|word| message.contains(word)), "{fault}: {message}");
    }
}

/// As when a snapshot is taken after a step.
#[test]
fn a_unit_that_dies_while_it_is_read_is_named_with_its_step() -> Result<(), ParticipantError> {
    let mut unit = start("dies-when-read")?;
    let mut outputs = [0.0; 3];
    unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut outputs)?;
    let occasion = Occasion { step: 7, iteration: 2, attempt: 1, time: 1.5, communication_step: 0.25 };
    unit.step(&occasion, &[4.0, 5.0, 6.0], &mut outputs)?;
    let message = unit.read("z").expect_err("it dies").to_string();
    assert!(message.contains("killed by signal 6 in step 7 from t = 1.5 s, iteration 2"), "{message}");
    Ok(())
}

#[test]
fn what_is_no_json_is_kept_as_a_message() -> Result<(), ParticipantError> {
    let mut unit = start("none")?;
    let mut texts: Vec<String> = Vec::new();
    for _ in 0..1000 {
        texts.extend(unit.messages().into_iter().map(|m| m.text));
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(texts, ["this line is no JSON", "caf\u{fffd}", "nor is this one"]);
    Ok(())
}

#[test]
fn words_that_never_come_are_waited_for_once() -> Result<(), ParticipantError> {
    let mut unit = start("miscounts-words")?;
    let mut outputs = [0.0; 3];
    unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut outputs)?;
    let warnings = |unit: &mut SharedMemory| {
        unit.messages().into_iter().filter(|m| m.level == Level::Warning).map(|m| m.text).collect::<Vec<_>>()
    };
    assert_eq!(warnings(&mut unit), ["98 of the messages that its answer counts did not arrive"]);
    let occasion = Occasion { step: 1, iteration: 1, attempt: 1, time: 0.0, communication_step: 0.25 };
    unit.step(&occasion, &[4.0, 5.0, 6.0], &mut outputs)?;
    assert!(warnings(&mut unit).is_empty());
    Ok(())
}

#[test]
fn a_unit_that_does_not_read_a_long_task_is_ended_too() {
    let mut command = Command::new("sleep");
    command.arg("60");
    let deadlines = Deadlines { preparation: Duration::from_millis(200), step: Duration::from_millis(200) };
    let units = [("dam".to_owned(), command)];
    let started = Starting::new(units, &"x".repeat(1 << 20), 1, deadlines);
    let message = started.and_then(|s| s.wait(&AtomicBool::new(false))).err().expect("no answer").to_string();
    assert!(message.contains("dam: no answer for 0.2 s while the units were made"), "{message}");
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let deadlines = Deadlines { preparation: Duration::from_secs(1), step: Duration::from_secs(1) };
    let units = [("dam".to_owned(), Command::new("no-such-program"))];
    let message = Starting::new(units, "", 1, deadlines).err().expect("no such program").to_string();
    assert!(message.contains("dam: its process cannot be started"), "{message}");
}
