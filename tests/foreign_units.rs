//! Units of the user's own, in Python over iceoryx2's usual service: the same bits both ways, coupled with built-in units,
//! their ends named, nothing left in shared memory.

use cofferdam_assembly::participant::{Foreign, Place};
use cofferdam_assembly::simulation::scales;
use cofferdam_assembly::units::{DAM, GROUND_ACCELERATION, pair};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure};
use cofferdam_coupling::participant::{
    AccelerationMeaning, InProcess, Level, Message, Messages, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{Predictor, Scheme, Settings};
use cofferdam_coupling::signal::Signal;
use cofferdam_dam::Dam;
use cofferdam_shared_memory::{Brief, BriefPoints, Deadlines, SharedMemory, Starting, UnitCommand};
use cofferdam_unit::Role;
use cofferdam_unit::{EndAcceleration, WetFace};
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use whole_chain::koyna;
use whole_chain::process::{is_gone, signal, wait_until};
use whole_chain::python::interpreter;
use whole_chain::scenario::{is_root, root};
use whole_chain::small_unit::{SmallUnit, interval};

type Failure = Box<dyn std::error::Error>;

const H: f64 = 0.0025;

fn brief(role: Role, face: &WetFace) -> Brief {
    Brief {
        role,
        points: BriefPoints::from(face),
        depth: face.depth(),
        density: 1000.0,
        gravity: 9.81,
        communication_step: H,
        duration: 1.0,
        acceleration: AccelerationMeaning::Mean,
        parameters: std::collections::BTreeMap::default(),
    }
}

fn face() -> WetFace {
    WetFace::new(vec![[0.0, 0.0], [1.0, 10.0], [1.5, 15.0], [3.0, 40.0]]).expect("a face")
}

/// The unit that `program`, below the project's root, serves with `arguments`.
fn unit(brief: Brief, program: &str, arguments: &[&str]) -> UnitCommand {
    let mut command = Command::new(interpreter());
    command.arg("-B").arg(root().join(program)).args(arguments);
    let name = if brief.role == Role::Fluid { "reservoir" } else { "dam" };
    UnitCommand { name: name.to_owned(), command, brief: Some(brief) }
}

fn start(unit: UnitCommand) -> Result<(SharedMemory, u32), ParticipantError> {
    let deadlines = Deadlines { preparation: Duration::from_secs(60), step: Duration::from_secs(1) };
    let starting = Starting::new([unit], "", 1, deadlines)?;
    let process = starting.processes().map(|(_, id)| id).next().expect("a process");
    Ok((starting.wait(&AtomicBool::new(false))?.remove(0), process))
}

/// A unit of `tests/python/units.py` in the reservoir's place.
fn small(arguments: &[&str]) -> Result<(SharedMemory, u32), ParticipantError> {
    start(unit(brief(Role::Fluid, &face()), "tests/python/units.py", arguments))
}

fn occasion(step: u64, iteration: u32) -> Occasion {
    let time = (step - 1) as f64 * H;
    Occasion { step, iteration, attempt: 1, time, communication_step: H }
}

/// Numbers of all magnitudes.
fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        f64::from_bits(state)
    };
    std::iter::repeat_with(&mut random).filter(|number| number.is_finite()).take(count).collect()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn every_bit_arrives_both_ways() -> Result<(), Failure> {
    let (mut reservoir, _) = small(&["Echo"])?;
    let n = face().len();
    let mut outputs = vec![1.0; n];
    reservoir.initialise(0.0, &numbers(n + 2, 1), &mut outputs)?;
    assert_eq!(outputs, vec![0.0; n], "at rest");
    let special = [-0.0, f64::MIN_POSITIVE / 8.0, f64::MAX, f64::EPSILON];
    for step in 1..=2000 {
        let mut inputs = numbers(n + 2, step);
        if step == 1 {
            inputs[..4].copy_from_slice(&special);
        }
        reservoir.step(&occasion(step, 1), &inputs, &mut outputs)?;
        assert_eq!(bits(&outputs), bits(&inputs[..n]), "step {step}");
    }
    let hydrostatic: Vec<f64> = face().points().iter().map(|p| 1000.0 * 9.81 * (40.0 - p[1])).collect();
    assert_eq!(reservoir.read("hydrostatic_pressure")?, hydrostatic);
    assert_eq!(reservoir.read("interface_length")?, face().tributary_lengths());
    // The package does not offer this command, whose request it cannot know the length of.
    assert_eq!(
        reservoir.read_at("interface_length", &[1, 0])?,
        [1, 0].map(|i| face().tributary_lengths()[i])
    );
    assert_eq!(
        reservoir.read("interface_normal_x")?,
        face().normals().iter().map(|n| n[0]).collect::<Vec<_>>()
    );
    assert!(!reservoir.description().capabilities.saved_state);
    assert!(reservoir.restore_state().is_err(), "it has no method to save");

    let (mut dam, _) = start(unit(brief(Role::Structure, &face()), "tests/python/units.py", &["EchoDam"]))?;
    let mut outputs = vec![1.0; 3 * n];
    for step in 1..=200 {
        let inputs = numbers(2 * n + 2, step);
        dam.step(&occasion(step, 1), &inputs, &mut outputs)?;
        assert_eq!(bits(&outputs[..2 * n]), bits(&inputs[..2 * n]));
        let ground: Vec<f64> = inputs[2 * n..].iter().copied().cycle().take(n).collect();
        assert_eq!(bits(&outputs[2 * n..]), bits(&ground), "step {step}");
    }
    Ok(())
}

/// The unit continues to change the array that it saved.
#[test]
fn steps_are_repeated_from_saved_states() -> Result<(), Failure> {
    let (mut unit, _) = small(&["Sum"])?;
    let n = face().len();
    let (mut outputs, mut sum) = (vec![0.0; n], vec![0.0; n]);
    unit.initialise(0.0, &vec![0.0; n + 2], &mut outputs)?;
    for step in 1..=300_u64 {
        let inputs: Vec<f64> = (0..n + 2).map(|i| (step as f64 + i as f64).sin()).collect();
        unit.save_state()?;
        for iteration in 1..=4 {
            if iteration > 1 {
                unit.restore_state()?;
            }
            let tried: Vec<f64> = inputs.iter().map(|a| a * f64::from(iteration % 4)).collect();
            unit.step(&occasion(step, iteration), &tried, &mut outputs)?;
        }
        unit.restore_state()?;
        unit.step(&occasion(step, 5), &inputs, &mut outputs)?;
        sum.iter_mut().zip(&inputs).for_each(|(sum, a)| *sum += H * a);
        assert_eq!(bits(&outputs), bits(&sum), "step {step}");
    }
    assert!(unit.busy() > Duration::ZERO);
    Ok(())
}

#[test]
fn a_class_that_gives_its_state_as_bytes_goes_on_in_another_process() -> Result<(), Failure> {
    let place = Place {
        role: Role::Fluid,
        face: face(),
        specific_weight: 9810.0,
        acceleration: AccelerationMeaning::Mean,
    };
    let make = || -> Result<Foreign, Failure> { Ok(Foreign::new(Box::new(small(&["Sum"])?.0), &place)?) };
    let (mut first, mut second, mut third) = (make()?, make()?, make()?);
    let n = face().len();
    let (mut one, mut other) = (vec![0.0; n], vec![0.0; n]);
    let inputs = |step: u64| numbers(n + 2, step).into_iter().map(f64::sin).collect::<Vec<_>>();
    first.initialise(0.0, &vec![0.0; n + 2], &mut one)?;
    for step in 1..=5 {
        first.save_state()?;
        first.step(&occasion(step, 1), &inputs(step), &mut one)?;
    }
    second.deserialise(&first.serialise()?.ok_or("its bytes")?)?;
    first.step(&occasion(6, 1), &inputs(6), &mut one)?;
    second.step(&occasion(6, 1), &inputs(6), &mut other)?;
    assert_eq!(bits(&one), bits(&other));
    // A return to the saved state, which comes before its next request, comes before its bytes too.
    first.restore_state()?;
    let state = first.serialise()?.ok_or("its bytes")?;
    third.deserialise(&state)?;
    first.step(&occasion(5, 2), &inputs(7), &mut one)?;
    third.step(&occasion(5, 2), &inputs(7), &mut other)?;
    assert_eq!(bits(&one), bits(&other));
    let refused = third.deserialise(&state[..state.len() - 8]).expect_err("it is cut").to_string();
    assert!(refused.contains("is damaged"), "{refused}");
    let mut without = Foreign::new(Box::new(small(&["Echo"])?.0), &place)?;
    without.initialise(0.0, &vec![0.0; n + 2], &mut one)?;
    assert_eq!(without.serialise()?, None);
    Ok(())
}

/// p = −A a of the points, the end value from the means: `Sampled` of `tests/python/units.py` in Rust.
fn westergaard(face: &WetFace) -> SmallUnit<EndAcceleration> {
    let depth = face.depth();
    let mass = |p: &[f64; 2]| 7.0 / 8.0 * 1000.0 * (depth * (depth - p[1])).sqrt();
    let mass: Vec<f64> = face.points().iter().map(mass).collect();
    let n = mass.len();
    let state = EndAcceleration::at_rest(n);
    let unit = SmallUnit::reservoir(n, state, vec![0.0; n], move |state, at, inputs, outputs| {
        state.step(&inputs[..n], at.communication_step);
        let pressure = mass.iter().zip(&state.at_end).map(|(mass, a)| -mass * a);
        outputs.iter_mut().zip(pressure).for_each(|(p, value)| *p = value);
    });
    unit.at(face)
}

/// The ground's acceleration at the ends of all steps.
fn shaking(h: f64, steps: u32, acceleration: impl Fn(f64) -> f64) -> Signal {
    let samples = (0..=steps).map(|step| acceleration(f64::from(step) * h)).collect();
    Signal::new("ground_motion", GROUND_ACCELERATION, h, samples)
}

/// The dam's outputs in all steps of a run before `reservoir`, and the number of iterations.
fn run(dam: Box<dyn Participant>, reservoir: Box<dyn Participant>) -> Result<(Vec<u64>, u32), Failure> {
    let mut graph = pair(dam, reservoir)?;
    let measures = [Measure::Change, Measure::Relative];
    let measure =
        ConvergenceMeasure::new(&measures, 1e-8, scales(koyna::DEPTH, 1000.0 * 9.81 * koyna::DEPTH));
    let aitken = Acceleration::new(AccelerationKind::Aitken, 0.9, 1.0);
    let ground = shaking(H, 200, |t| 3.0 * (25.0 * t).sin());
    let mut scheme =
        Scheme::new(&mut graph, Settings::default(), aitken, Predictor::new(2), measure, vec![ground])?;
    scheme.initialise(&mut graph, 0.0)?;
    let (mut motion, mut iterations) = (Vec::new(), 0);
    for step in 1..=200 {
        let report = scheme.advance(&mut graph, &[interval(step, H)]).map_err(|failure| failure.error)?;
        iterations += report.iterations();
        motion.extend(bits(&report.accepted(DAM, step).expect("a step").outputs));
    }
    Ok((motion, iterations))
}

fn koyna_dam() -> Result<Box<dyn Participant>, Failure> {
    Ok(Box::new(InProcess::new(Dam::new(koyna::dam(10.0, true))?, "dam", Messages::default())))
}

#[test]
fn a_reservoir_in_python_before_the_built_in_dam_gives_the_bits_of_its_twin() -> Result<(), Failure> {
    let mut dam = koyna_dam()?;
    let (x, y) = (dam.read("interface_x")?, dam.read("interface_y")?);
    let face = WetFace::new(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())?;
    let (reservoir, _) = start(unit(brief(Role::Fluid, &face), "tests/python/units.py", &["Sampled"]))?;
    let in_python = run(dam, Box::new(reservoir))?;
    let in_rust = run(koyna_dam()?, Box::new(westergaard(&face)))?;
    println!("200 steps in {} iterations", in_python.1);
    assert!(in_python.1 > 400, "steps are repeated");
    assert!(in_python == in_rust);
    Ok(())
}

/// With the value at the step's end as input, p = −A a at once.
#[test]
fn a_reservoir_may_take_the_acceleration_at_the_end() -> Result<(), Failure> {
    let face = WetFace::straight([0.0, 40.0], 4)?;
    let brief = Brief { acceleration: AccelerationMeaning::End, ..brief(Role::Fluid, &face) };
    let (mut reservoir, _) = start(unit(brief, "tests/python/units.py", &["Sampled"]))?;
    let mut outputs = vec![0.0; 5];
    for (step, a) in [(1, 2.0), (2, -3.0)] {
        reservoir.step(&occasion(step, 1), &[a, a, a, a, a, 0.0, 0.0], &mut outputs)?;
        let expected: Vec<f64> =
            (0..5).map(|i| -875.0 * (40.0 * f64::from(40 - 10 * i)).sqrt() * a).collect();
        assert_eq!(outputs, expected);
    }
    Ok(())
}

/// Both units in Python: an oscillator before Westergaard's water, of which the exact solution is that of an oscillator of
/// mass m + m_w, m_w = Σ A n_x² ℓ. The Runge–Kutta method of fourth order with steps of 10 µs gives it to 1e-12.
#[test]
fn an_oscillator_in_python_is_of_second_order() -> Result<(), Failure> {
    let face = face();
    let (mass, frequency, ratio) = (4e6, 20.0, 0.05);
    let ground = |t: f64| 2.0 * (11.0 * t).sin() - 1.5 * (17.0 * t).sin();
    let weights = face.normals().into_iter().zip(face.tributary_lengths()).zip(face.points());
    let water = weights
        .map(|((n, length), p)| 7.0 / 8.0 * 1000.0 * (40.0 * (40.0 - p[1])).sqrt() * n[0] * n[0] * length);
    let total = mass + water.sum::<f64>();
    assert!(total > 1.2 * mass, "the water counts");
    let rate = |t: f64, [u, v]: [f64; 2]| {
        let spring = mass * (frequency * frequency * u + 2.0 * ratio * frequency * v) / total;
        [v, -spring - ground(t)]
    };
    let (small, mut state) = (1e-5, [0.0; 2]);
    for step in 0..100_000 {
        let t = f64::from(step) * small;
        let after = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
        let a = rate(t, state);
        let b = rate(t + small / 2.0, after(a, small / 2.0));
        let c = rate(t + small / 2.0, after(b, small / 2.0));
        let d = rate(t + small, after(c, small));
        state = [0, 1].map(|i| state[i] + small / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    let mut errors = Vec::new();
    for steps in [100_u32, 200, 400] {
        let h = 1.0 / f64::from(steps);
        let with = |role| {
            let mut brief = Brief { communication_step: h, ..brief(role, &face) };
            if role == Role::Structure {
                brief.parameters.extend([
                    ("mass".to_owned(), mass.into()),
                    ("frequency".to_owned(), frequency.into()),
                    ("damping_ratio".to_owned(), ratio.into()),
                ]);
            }
            brief
        };
        let units = [
            unit(with(Role::Structure), "examples/python/oscillator_dam.py", &[]),
            unit(with(Role::Fluid), "tests/python/units.py", &["Sampled"]),
        ];
        let minute = Duration::from_secs(60);
        let starting = Starting::new(units, "", 1, Deadlines { preparation: minute, step: minute })?;
        let mut units =
            starting.wait(&AtomicBool::new(false))?.into_iter().map(|unit| Box::new(unit) as Box<_>);
        let (dam, reservoir) = units.next().zip(units.next()).ok_or("two units")?;
        let mut graph = pair(dam, reservoir)?;
        let measure = ConvergenceMeasure::new(&[Measure::Change, Measure::Relative], 1e-10, scales(1.0, 1e5));
        let aitken = Acceleration::new(AccelerationKind::Aitken, 0.9, 1.0);
        let signals = vec![shaking(h, steps, ground)];
        let mut scheme =
            Scheme::new(&mut graph, Settings::default(), aitken, Predictor::new(2), measure, signals)?;
        scheme.initialise(&mut graph, 0.0)?;
        let mut last = 0.0;
        for step in 1..=u64::from(steps) {
            let report = scheme.advance(&mut graph, &[interval(step, h)]).map_err(|failure| failure.error)?;
            last = report.accepted(DAM, step).ok_or("accepted")?.outputs[0];
        }
        errors.push((last / face.normals()[0][0] - state[0]).abs() / 0.01);
    }
    println!("errors of the displacement after 1 s, in units of 1 cm: {errors:?}");
    let order = whole_chain::order(errors[1], errors[2], 2.0);
    assert!((order - 2.0).abs() < 0.2 && errors[2] < 1e-2, "order {order}");
    Ok(())
}

/// The error of a step of a unit with a fault; how it ended.
fn fault(fault: &str) -> String {
    let step = || -> Result<(), ParticipantError> {
        let (mut unit, _) = small(&["Faulty", fault])?;
        let n = face().len();
        let mut outputs = vec![0.0; n];
        unit.initialise(0.0, &vec![0.0; n + 2], &mut outputs)?;
        unit.save_state()?;
        unit.step(&occasion(7, 2), &vec![1.0; n + 2], &mut outputs)
    };
    step().expect_err(fault).to_string()
}

#[test]
fn what_goes_wrong_is_named() {
    let step = "in step 7 from t = 0.015 s, iteration 2";
    for (what, words) in [
        (
            "divides",
            vec!["reservoir: ZeroDivisionError: division by zero (units.py, line ", "in <lambda>)", step],
        ),
        ("exits", vec!["reservoir: its process ended with exit status 7", step]),
        ("aborts", vec!["reservoir: its process was killed by signal 6", step]),
        (
            "nothing",
            vec!["reservoir: ", "`step` returned nothing as interface_pressure, 4 numbers are needed", step],
        ),
        ("a word", vec!["`step` returned a value of type str as interface_pressure", step]),
        ("short", vec!["`step` returned values of shape (3,) as interface_pressure, (4,) is needed", step]),
        ("infinite", vec!["reservoir: `interface_pressure`[2] became inf", "in the step to t = 0.0174"]),
        ("hangs", vec!["reservoir: no answer for 1 s", step, "--deadline"]),
        ("spins", vec!["reservoir: no answer for 1 s", step]),
        ("exits early", vec!["reservoir: its process ended with exit status 7 while the units were made"]),
    ] {
        let message = fault(what);
        assert!(words.iter().all(|word| message.contains(word)), "{what}: {message}");
    }
    let mut painted = brief(Role::Fluid, &face());
    painted.parameters.insert("colour".to_owned(), "sharp".into());
    for (brief, words) in [
        (painted, ["reservoir: ValueError: sharp is no colour (units.py, line ", "in __init__)"]),
        (
            brief(Role::Structure, &face()),
            ["dam: TypeError: Faulty is a fluid, but a structure", "cofferdam.Dam"],
        ),
    ] {
        let made = start(unit(brief, "tests/python/units.py", &["Faulty", "cannot be made"]));
        let message = made.err().expect("it is not made").to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    let missing = start(unit(brief(Role::Fluid, &face()), "tests/python/no_such_file.py", &[]));
    let message = missing.err().expect("no program").to_string();
    assert!(message.contains("reservoir: its process ended with exit status 2"), "{message}");
}

#[test]
fn a_killed_unit_is_named_at_once() -> Result<(), Failure> {
    let (mut unit, process) = small(&["Echo"])?;
    let n = face().len();
    let mut outputs = vec![0.0; n];
    unit.step(&occasion(1, 1), &vec![1.0; n + 2], &mut outputs)?;
    let folder = folder_of(process);
    signal(process, "-KILL");
    let killed = Instant::now();
    let message =
        unit.step(&occasion(2, 1), &vec![1.0; n + 2], &mut outputs).expect_err("it is dead").to_string();
    assert!(message.contains("reservoir: its process was killed by signal 9 in step 2"), "{message}");
    assert!(killed.elapsed() < Duration::from_millis(900), "{:?}", killed.elapsed());
    drop(unit);
    assert_eq!(belongings(&folder), BTreeSet::new());
    Ok(())
}

/// What a unit prints, logs and warns of is kept; words cannot be printed.
#[test]
fn what_a_unit_says_is_kept() -> Result<(), Failure> {
    let (mut unit, _) = small(&["Faulty", "says"])?;
    let n = face().len();
    let mut outputs = vec![0.0; n];
    unit.step(&occasion(7, 2), &vec![1.0; n + 2], &mut outputs)?;
    let messages = unit.messages();
    let said: Vec<_> =
        messages.iter().map(|m| (m.level, m.step, m.source.as_str(), m.text.as_str())).collect();
    let information = Level::Information;
    assert_eq!(
        said[..7],
        [
            (information, 0, "standard output", "a line before it serves"),
            (information, 0, "standard output", "and the beginning of one"),
            (information, 7, "print", "two lines"),
            (information, 7, "print", "of text"),
            (information, 7, "print", r#"no end of line{"failed":{"text":"printed"}}"#),
            (information, 7, "mine", "logged"),
            (information, 7, "print", "no Unicode: ?"),
        ]
    );
    let [Message { level: Level::Warning, step: 7, source, text, .. }] = &messages[7..] else {
        panic!("{messages:?}")
    };
    assert!(source == "py.warnings" && text.contains("take care"), "{messages:?}");
    assert!(messages.iter().all(|m| m.unit == "reservoir"));
    // The traceback of an exception is a message.
    let (mut unit, _) = small(&["Faulty", "divides"])?;
    unit.step(&occasion(1, 1), &vec![1.0; n + 2], &mut outputs).expect_err("it divides by zero");
    let messages = unit.messages();
    let last = messages.last().ok_or("messages")?;
    assert!(last.level == Level::Error && last.text.contains("1 / 0"), "{messages:?}");
    Ok(())
}

/// The folder of the run to which a process belongs, by the memory that it has mapped.
fn folder_of(process: u32) -> PathBuf {
    let maps = std::fs::read_to_string(format!("/proc/{process}/maps")).expect("its memory");
    let name = maps.lines().find_map(|line| line.split("/dev/shm/").nth(1)).expect("shared memory");
    let parts: Vec<&str> = name.split('-').collect();
    Path::new("/dev/shm").join(parts[..3].join("-"))
}

/// The folder of a run and its segments, as far as they exist.
fn belongings(folder: &Path) -> BTreeSet<PathBuf> {
    let begin = folder.to_string_lossy().into_owned();
    let entries = std::fs::read_dir("/dev/shm").expect("shared memory").flatten().map(|entry| entry.path());
    entries.filter(|path| path.to_string_lossy().starts_with(&begin)).collect()
}

#[test]
fn nobody_else_can_open_what_belongs_to_a_run_and_nothing_is_left_of_it() -> Result<(), Failure> {
    let (mut unit, process) = small(&["Echo"])?;
    let n = face().len();
    unit.step(&occasion(1, 1), &vec![1.0; n + 2], &mut vec![0.0; n])?;
    let folder = folder_of(process);
    let segments = belongings(&folder);
    assert!(segments.len() > 5, "{segments:?}");
    for path in &segments {
        let mode = std::fs::metadata(path)?.mode() & 0o777;
        assert_eq!(mode & 0o077, 0, "{} has mode {mode:o}", path.display());
    }
    if is_root() {
        let script = r#"
            for name in "$@"; do
                cat "$name" "$name/lock" && echo "read $name"
                echo x >> "$name" && echo "changed $name"
                truncate -s 0 "$name" && echo "cut $name"
                mv "$name" "$name-moved" && echo "moved $name"
                chmod 666 "$name" && echo "opened $name"
                rm -rf "$name" && echo "removed $name"
            done 2> /dev/null
        "#;
        let mut other = Command::new("sh");
        other.args(["-c", script, "sh"]).args(&segments);
        let other = std::os::unix::process::CommandExt::uid(&mut other, 65534).output()?;
        assert_eq!(String::from_utf8_lossy(&other.stdout), "");
    } else {
        println!("not tried as another user: only root can run a program as one");
    }
    unit.step(&occasion(2, 1), &vec![1.0; n + 2], &mut vec![0.0; n])?;
    assert_eq!(belongings(&folder), segments);
    drop(unit);
    assert_eq!(belongings(&folder), BTreeSet::new());
    Ok(())
}

/// Started by the next tests, which kill it.
#[test]
#[ignore = "it is the orchestrator of other tests"]
fn an_orchestrator_to_be_killed() {
    if std::env::var_os("COFFERDAM_TO_BE_KILLED").is_none() {
        return;
    }
    let (mut unit, process) = small(&["Echo"]).expect("a unit");
    println!("\nunit {process}");
    let n = face().len();
    let mut outputs = vec![0.0; n];
    for step in 1.. {
        unit.step(&occasion(step, 1), &vec![1.0; n + 2], &mut outputs).expect("an answer");
        std::thread::sleep(Duration::from_millis(1));
    }
}

struct Orchestrator {
    process: std::process::Child,
    unit: u32,
    folder: PathBuf,
}

impl Orchestrator {
    fn start() -> Self {
        // Made before, because two processes would make it at once.
        interpreter();
        let mut command = Command::new(std::env::current_exe().expect("this program"));
        command.args(["--ignored", "--exact", "--nocapture", "foreign_units::an_orchestrator_to_be_killed"]);
        command.env("COFFERDAM_TO_BE_KILLED", "1").stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().expect("it starts");
        let output = BufReader::new(process.stdout.take().expect("its output"));
        let mut lines = output.lines().map_while(Result::ok);
        let unit = lines.find_map(|line| line.strip_prefix("unit ")?.parse().ok()).expect("a unit");
        // Steps are on their way.
        std::thread::sleep(Duration::from_millis(50));
        Self { process, unit, folder: folder_of(unit) }
    }

    fn kill(&mut self) -> Instant {
        self.process.kill().expect("killed");
        self.process.wait().expect("ended");
        Instant::now()
    }
}

#[test]
fn a_unit_whose_orchestrator_dies_ends_and_removes_the_rest() {
    let mut orchestrator = Orchestrator::start();
    let killed = orchestrator.kill();
    assert!(wait_until(|| is_gone(orchestrator.unit)), "the unit continues");
    println!("the unit ended {:.0} ms after its orchestrator", 1e3 * killed.elapsed().as_secs_f64());
    let mut said = String::new();
    orchestrator.process.stderr.take().expect("errors").read_to_string(&mut said).expect("text");
    assert!(said.contains("reservoir: the orchestrator died in step "), "{said}");
    assert_eq!(belongings(&orchestrator.folder), BTreeSet::new());
}

#[test]
fn what_killed_processes_leave_is_removed_by_the_next_run() -> Result<(), Failure> {
    let mut orchestrator = Orchestrator::start();
    // It does not notice the end of the orchestrator.
    signal(orchestrator.unit, "-STOP");
    orchestrator.kill();
    signal(orchestrator.unit, "-KILL");
    assert!(wait_until(|| is_gone(orchestrator.unit)));
    // A run of another test may have started since and removed it already.
    println!("left: {:?}", belongings(&orchestrator.folder));
    drop(small(&["Echo"])?);
    assert_eq!(belongings(&orchestrator.folder), BTreeSet::new());
    Ok(())
}
