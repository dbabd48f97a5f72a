//! A unit's process that breaks the protocol is refused or ended, with a message that says how.

use cofferdam_coupling::participant::{AccelerationMeaning, Level, Occasion, Participant, ParticipantError};
use cofferdam_shared_memory::{Brief, BriefPoints, Deadlines, SharedMemory, Starting, UnitCommand};
use cofferdam_unit::Role;
use cofferdam_unit::WetFace;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A brief, with which a unit is reached over iceoryx2's usual service.
fn brief() -> Brief {
    let face = WetFace::straight([0.0, 10.0], 2).expect("a face");
    Brief {
        role: Role::Structure,
        points: BriefPoints::from(&face),
        depth: 10.0,
        density: 1000.0,
        gravity: 9.81,
        communication_step: 0.25,
        duration: 1.0,
        acceleration: AccelerationMeaning::Mean,
        parameters: std::collections::BTreeMap::default(),
    }
}

/// Starts a built-in unit with a fault.
fn start(fault: &str) -> Result<SharedMemory, ParticipantError> {
    start_of(fault, None)
}

/// Starts a unit with a fault.
fn start_of(fault: &str, brief: Option<Brief>) -> Result<SharedMemory, ParticipantError> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_misbehaving_unit"));
    command.arg(fault);
    let deadlines = Deadlines { preparation: Duration::from_secs(1), step: Duration::from_millis(200) };
    let unit = UnitCommand { name: "dam".to_owned(), command, brief };
    let starting = Starting::new([unit], "", 1, deadlines)?;
    let process = starting.processes().map(|(_, id)| id).next().expect("a process");
    let mut units = starting.wait(&AtomicBool::new(false)).inspect_err(|_| assert_gone(process))?;
    Ok(units.pop().expect("a unit"))
}

fn assert_gone(process: u32) {
    // Its orchestrator, this test, has waited for it.
    assert!(!std::path::Path::new(&format!("/proc/{process}")).exists(), "process {process} is still there");
}

/// The error of such a unit when it is started and takes a step.
fn message(fault: &str, brief: Option<Brief>) -> String {
    let step = || -> Result<(), ParticipantError> {
        let mut unit = start_of(fault, brief)?;
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
        ("old-version", ["dam speaks version 7 of the exchange protocol", "this program version 6"]),
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
        let message = message(fault, None);
        assert!(words.iter().all(|word| message.contains(word)), "{fault}: {message}");
    }
}

#[test]
fn breaches_over_the_usual_service_are_named_too() {
    for (fault, words) in [
        ("no-service", ["dam is not connected", "must serve `cofferdam/"]),
        ("other-layout", ["dam lays out requests and answers as 0123", "the same build"]),
        ("short-answer", ["dam answered with 2 values", "3 were expected"]),
        ("wrong-echo", ["dam answered with time 0.75 where 0.25 was asked for", "must echo"]),
        ("not-finite", ["dam: `y`[2] became inf", "t = 0.5 s"]),
        ("fails-silently", ["dam: failed in step 1 from t = 0.25 s, iteration 2", "did not say why"]),
        ("hangs", ["dam: no answer for 0.2 s in step 1 from t = 0.25 s, iteration 2", "was killed"]),
        ("dies", ["dam: its process was killed by signal 6 in step 1", "iteration 2"]),
    ] {
        let message = message(fault, Some(brief()));
        assert!(words.iter().all(|word| message.contains(word)), "{fault}: {message}");
    }
}

#[test]
fn a_unit_that_cannot_save_states_steps_and_is_never_sent_back() -> Result<(), ParticipantError> {
    let mut unit = start("without-states")?;
    let mut outputs = [0.0; 3];
    unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut outputs)?;
    let occasion = Occasion { step: 1, iteration: 1, attempt: 1, time: 0.0, communication_step: 0.25 };
    unit.save_state()?;
    unit.step(&occasion, &[4.0, 5.0, 6.0], &mut outputs)?;
    assert_eq!(outputs, [4.0, 5.0, 6.0]);
    let refused = unit.restore_state().expect_err("it has no state").to_string();
    assert!(
        refused.contains("dam: it cannot return to a saved state") && refused.contains("explicit"),
        "{refused}"
    );
    Ok(())
}

#[test]
fn of_a_unit_that_knows_no_places_all_is_read() -> Result<(), ParticipantError> {
    let mut unit = start("knows-no-places")?;
    unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut [0.0; 3])?;
    let values = unit.read_at("z", &[2, 0, 3])?;
    assert!(values[..2] == [7.0, 5.0] && values[2].is_nan(), "{values:?}");
    Ok(())
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
fn a_unit_that_gives_no_state_as_bytes_says_so_and_goes_on() -> Result<(), ParticipantError> {
    for brief in [None, Some(brief())] {
        let mut unit = start_of("none", brief)?;
        let mut outputs = [0.0; 3];
        unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut outputs)?;
        assert_eq!(unit.serialise()?, None);
        let refused = unit.deserialise(b"a state").expect_err("it takes none").to_string();
        assert!(refused.starts_with("dam: it neither gives nor takes its state as bytes"), "{refused}");
        let occasion = Occasion { step: 1, iteration: 1, attempt: 1, time: 0.0, communication_step: 0.25 };
        unit.step(&occasion, &[4.0, 5.0, 6.0], &mut outputs)?;
        assert_eq!(outputs, [4.0, 5.0, 6.0]);
    }
    Ok(())
}

#[test]
fn a_unit_that_fails_while_it_gives_its_state_is_named() -> Result<(), ParticipantError> {
    for (fault, words) in [
        ("dies-when-serialised", ["dam: its process was killed by signal 6 in step 7", "iteration 2"]),
        ("hangs-when-serialised", ["dam: no answer for 1 s in step 7", "was killed"]),
        (
            "writes-no-state",
            ["dam: its state cannot be read in /dev/shm/cofferdam-", "dam.state: No such file"],
        ),
    ] {
        let mut unit = start(fault)?;
        let mut outputs = [0.0; 3];
        unit.initialise(0.0, &[1.0, 2.0, 3.0], &mut outputs)?;
        let occasion = Occasion { step: 7, iteration: 2, attempt: 1, time: 1.5, communication_step: 0.25 };
        unit.step(&occasion, &[4.0, 5.0, 6.0], &mut outputs)?;
        let message = unit.serialise().expect_err(fault).to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{fault}: {message}");
    }
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
    let units = [UnitCommand { name: "dam".to_owned(), command, brief: None }];
    let started = Starting::new(units, &"x".repeat(1 << 20), 1, deadlines);
    let message = started.and_then(|s| s.wait(&AtomicBool::new(false))).err().expect("no answer").to_string();
    assert!(message.contains("dam: no answer for 0.2 s while the units were made"), "{message}");
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let deadlines = Deadlines { preparation: Duration::from_secs(1), step: Duration::from_secs(1) };
    for (brief, remedy) in [(None, "use --transport in-process"), (Some(brief()), "correct the command")] {
        let command = Command::new("no-such-program");
        let units = [UnitCommand { name: "dam".to_owned(), command, brief }];
        let message = Starting::new(units, "", 1, deadlines).err().expect("no such program").to_string();
        assert!(message.contains("dam: its process, `no-such-program`, cannot be started"), "{message}");
        assert!(message.ends_with(remedy), "{message}");
    }
}
