//! FMUs with the habits of other tools: names of scalars, encodings, messages, stop times.

mod support;

use cofferdam_coupling::participant::{Level, Participant, VariableNames};
use std::error::Error;
use support::{Foreign, H, POINTS, description, initialise, step, texts};

type Result = std::result::Result<(), Box<dyn Error>>;

const PRESSURES: [f64; POINTS] = [-1000.0, -2000.0, -3000.0];

#[test]
fn scalars_are_named_by_patterns_and_lists() -> Result {
    let mut foreign = Foreign::new(&[], &[]);
    for (acceleration, pressure) in
        [("a_#", "p(#)"), ("a[1,#]", "pressure_0#"), ("in.a[#].x", "p#"), ("a#", "interface_pressure[#]")]
    {
        foreign.describe(description(acceleration, pressure).as_bytes());
        let name = |pattern: &str| VariableNames::from(&*pattern.replace('#', "{i}"));
        foreign.variables = [("interface_acceleration".to_owned(), name(acceleration))].into();
        if pressure != "interface_pressure[#]" {
            foreign.variables.insert("interface_pressure".to_owned(), name(pressure));
        }
        let mut unit = foreign.unit()?;
        assert!(!unit.description().solver.contains("left alone"), "{}", unit.description().solver);
        initialise(&mut unit)?;
        assert_eq!(step(&mut unit, 1)?, PRESSURES, "{acceleration} {pressure}");
    }
    // From the top down: the first value of the face is the third scalar.
    foreign.describe(description("a_#", "p_#").as_bytes());
    let list = |names: [&str; POINTS]| VariableNames::Several(names.map(str::to_owned).to_vec());
    foreign.variables.insert("interface_acceleration".to_owned(), list(["a_3", "a_2", "a_1"]));
    foreign.variables.insert("interface_pressure".to_owned(), list(["p_1", "p_2", "p_3"]));
    let mut unit = foreign.unit()?;
    initialise(&mut unit)?;
    assert_eq!(step(&mut unit, 1)?, [-3000.0, -2000.0, -1000.0]);
    // The scalars have their own names and no others.
    foreign.variables.insert("interface_pressure".to_owned(), "q_{i}".into());
    let refused = foreign.unit().err().ok_or("there is no q")?.to_string();
    assert!(refused.contains("\"q_{i}\"") && refused.contains("it has `a_{i}`[3], `p_{i}`[3]"), "{refused}");
    Ok(())
}

#[test]
fn descriptions_are_read_in_the_encoding_that_they_declare() -> Result {
    let foreign = Foreign::new(&[], &[]);
    let text = description("interface_acceleration[#]", "interface_pressure[#]")
        .replace("\"water\" guid", "\"Wasser für 20 °C\" guid");
    let declared = |encoding: &str| text.replace("UTF-8", encoding);
    let bytes_of = |text: &str| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    let utf16: Vec<u8> = declared("UTF-16").encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (case, bytes) in [
        ("UTF-8", text.as_bytes().to_vec()),
        ("a byte order mark", [b"\xEF\xBB\xBF", text.as_bytes()].concat()),
        ("ISO-8859-1", bytes_of(&declared("ISO-8859-1"))),
        ("windows-1252", bytes_of(&declared("windows-1252"))),
        ("UTF-16", [&b"\xFF\xFE"[..], &utf16].concat()),
    ] {
        foreign.describe(&bytes);
        let mut unit = foreign.unit().map_err(|error| format!("{case}: {error}"))?;
        assert!(
            unit.description().solver.contains("FMU Wasser für 20 °C of FMI 2.0"),
            "{case}: {}",
            unit.description().solver
        );
        initialise(&mut unit)?;
        assert_eq!(step(&mut unit, 1)?, PRESSURES, "{case}");
    }
    for (bytes, words) in [
        (bytes_of(&text), ["in line 2, byte ", "0xFC, is not UTF-8"]),
        (bytes_of(&declared("Shift_JIS")), ["\"shift_jis\" is not among", "save it in UTF-8"]),
    ] {
        foreign.describe(&bytes);
        let refused = foreign.unit().err().ok_or("it is refused")?.to_string();
        assert!(words.iter().all(|word| refused.contains(word)), "{refused}");
        assert!(refused.contains("modelDescription.xml"), "{refused}");
    }
    Ok(())
}

/// The FMU keeps the pointer to the functions that it may call back, and calls them in every step.
#[test]
fn messages_of_all_levels_are_kept_and_bounded() -> Result {
    let foreign = Foreign::new(&["SAYS"], &[]);
    let mut unit = foreign.unit()?;
    initialise(&mut unit)?;
    let messages = unit.messages();
    assert_eq!(texts(&messages, Level::Information), ["initialised with 3 points, 91.75 m, 100%"]);
    assert_eq!(texts(&messages, Level::Warning), ["the depth is large"]);
    assert!(messages.iter().all(|message| message.source == "own" && message.unit == "reservoir"));
    let mut count = 1;
    for number in 1..=10 {
        step(&mut unit, number)?;
        let messages = unit.messages();
        assert!(texts(&messages, Level::Warning).is_empty());
        let said = texts(&messages, Level::Information);
        assert!(
            said.iter().all(|text| text.starts_with("step ") || text.contains("are left out")),
            "{said:?}"
        );
        assert!(messages.iter().all(|message| message.step == number));
        count += said.len();
    }
    // One of them says that more are left out.
    assert_eq!(count, 1001);
    Ok(())
}

#[test]
fn end_of_the_run_is_told_and_no_step_goes_beyond_it() -> Result {
    let mut foreign = Foreign::new(&["NEEDS_STOP"], &[]);
    let mut unit = foreign.unit()?;
    let untold = initialise(&mut unit).expect_err("it needs to know").to_string();
    assert!(untold.contains("fmi2SetupExperiment returned fmi2Error: a stop time is needed"), "{untold}");
    // Ends that are no multiple of the step in binary numbers.
    for steps in [1, 3, 7, 57, 115, 200] {
        foreign.stop_time = Some(steps as f64 * H);
        let mut unit = foreign.unit()?;
        initialise(&mut unit)?;
        for number in 1..=steps {
            step(&mut unit, number)?;
        }
        let beyond = step(&mut unit, steps + 1).expect_err("the run has ended").to_string();
        assert!(beyond.contains("is beyond the stop time"), "{beyond}");
    }
    foreign.stop_time = Some(3.0);
    let refused = initialise(&mut foreign.unit()?).expect_err("it does not go so far").to_string();
    for words in ["the table of the inflow ends at t = 2 s", "ends at t = 3", "shorten `time.duration`"] {
        assert!(refused.contains(words), "{refused}");
    }
    Ok(())
}

#[test]
fn default_experiment_that_ends_before_the_run_is_warned_of() -> Result {
    let change =
        ("<DefaultExperiment startTime=\"0\"/>", "<DefaultExperiment startTime=\"0\" stopTime=\"1.5\"/>");
    let mut foreign = Foreign::new(&[], &[change]);
    for (stop, warned) in [(None, false), (Some(1.5), false), (Some(1.0), false), (Some(2.0), true)] {
        foreign.stop_time = stop;
        let messages = foreign.unit()?.messages();
        let warnings = texts(&messages, Level::Warning);
        assert_eq!(warnings.len(), usize::from(warned), "{stop:?}: {warnings:?}");
        assert!(
            warnings.iter().all(|text| text.contains("stops at t = 1.5 s, and the run ends at t = 2 s")),
            "{warnings:?}"
        );
    }
    Ok(())
}

#[test]
fn states_are_saved_restored_and_carried_over() -> Result {
    let foreign = Foreign::new(&["SAYS"], &[]);
    let mut unit = foreign.unit()?;
    initialise(&mut unit)?;
    unit.save_state()?;
    step(&mut unit, 1)?;
    unit.restore_state()?;
    step(&mut unit, 1)?;
    let state = unit.serialise()?.ok_or("its bytes")?;
    let mut other = foreign.unit()?;
    other.deserialise(&state)?;
    other.messages();
    // It counts its steps in its state.
    step(&mut other, 2)?;
    assert_eq!(texts(&other.messages(), Level::Information)[0], "step 2, line 0");
    // One that cannot save its state needs no functions for it.
    let without = Foreign::new(
        &["WITHOUT_STATES"],
        &[("canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\" ", "")],
    );
    let mut unit = without.unit()?;
    initialise(&mut unit)?;
    assert_eq!(step(&mut unit, 1)?, PRESSURES);
    assert!(unit.restore_state().is_err() && unit.serialise()?.is_none());
    let refused = Foreign::new(&["WITHOUT_STATES"], &[]).unit().err().ok_or("it is refused")?.to_string();
    assert!(refused.contains("it lacks the function fmi2GetFMUstate"), "{refused}");
    Ok(())
}

#[test]
fn status_that_the_standard_does_not_have_is_an_error() -> Result {
    let mut unit = Foreign::new(&["UNKNOWN_STATUS"], &[]).unit()?;
    initialise(&mut unit)?;
    let refused = step(&mut unit, 1).expect_err("17 is no status").to_string();
    assert!(refused.contains("fmi2DoStep returned a status that FMI 2.0 does not have"), "{refused}");
    Ok(())
}
