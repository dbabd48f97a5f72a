//! Runs that are stopped between two windows and continued from bytes, with new units and observers, are those that were not
//! stopped, bit for bit.

use cofferdam_assembly::observer::{Histories, HistoriesWriter, Limits, Progress, Rest, Snapshots};
use cofferdam_assembly::participant::{Foreign, Place, Prescribed};
use cofferdam_assembly::simulation::{crest_at_rest, simulation_of};
use cofferdam_assembly::units::unit_name;
use cofferdam_assembly::units::{DAM, GROUND_ACCELERATION, RESERVOIR, TAILWATER, pair, wet_face_interface};
use cofferdam_assembly::{Assembly, Home, read_scene};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Past, Start, Status};
use cofferdam_coupling::participant::{AccelerationMeaning, Participant};
use cofferdam_coupling::run_state::{RunState, RunStateError};
use cofferdam_coupling::scheme::{
    Exchange, Graph, Port, Predictor, Scheme, SchemeKind, Settings, UnitId, WindowReport,
};
use cofferdam_coupling::signal::Signal;
use cofferdam_coupling::simulation::{Simulation, SimulationError};
use cofferdam_coupling::stepping::{Adaptive, Stepping};
use cofferdam_log::{Log, LogWriter, Preamble, compare};
use cofferdam_scene::{LoadedScene, Scene, Side};
use cofferdam_shared_memory::{Deadlines, Starting, UnitCommand};
use cofferdam_unit::Role;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use whole_chain::scenario::{Scenario, binary};
use whole_chain::small_unit::SmallUnit;

type Failure = Box<dyn std::error::Error>;

const POINTS: usize = 3;

/// Springs, masses and a spring between points that acts only when closed, on one face each: the units of the small runs.
fn structure(faces: &'static [(&'static str, usize)]) -> Box<dyn Participant> {
    let points: usize = faces.iter().map(|(_, points)| points).sum();
    let step = |state: &mut Vec<f64>, h: f64, force: &[f64]| -> Vec<f64> {
        let (u, v) = state.split_at_mut(force.len());
        let stretched: Vec<f64> = u.iter().zip(&*v).map(|(u, v)| u + h * v).collect();
        let around = |i: usize| {
            let below = i.checked_sub(1).map_or(0.0, |j| stretched[j]);
            let opened = stretched[i] - below;
            let contact = if opened < 0.0 { 300.0 * opened } else { 0.0 };
            200.0 * stretched[i] + 80.0 * opened + contact
        };
        let a: Vec<f64> =
            force.iter().enumerate().map(|(i, p)| (p - around(i)) / (2.0 + 0.3 * i as f64)).collect();
        for (i, a) in a.iter().enumerate() {
            u[i] += h * v[i] + h * h / 2.0 * a;
            v[i] += h * a;
        }
        a
    };
    let unit = SmallUnit::structure(
        "dam",
        faces,
        vec![0.0; 2 * points],
        vec![0.0; 2 * points],
        move |state, at, given, answer| {
            let ground = given[given.len() - 2];
            let (mut force, mut place) = (Vec::new(), 0);
            for (_, points) in faces {
                force.extend(given[place..place + points].iter().map(|p| p - 2.0 * ground));
                place += 2 * points;
            }
            let a = step(state, at.communication_step, &force);
            let (mut from, mut place) = (0, 0);
            for (_, points) in faces {
                answer[place..place + points].copy_from_slice(&state[from..from + points]);
                answer[place + points..place + 2 * points].copy_from_slice(&a[from..from + points]);
                (from, place) = (from + points, place + 2 * points);
            }
        },
    );
    Box::new(unit.in_bytes())
}

/// Water of `inertia` that resists, each point felt by its neighbour. In steps of 0.1 s that end soon after `hard_from` (s) its
/// answer changes with every iteration, so that only shorter ones converge.
fn fluid(name: &str, points: usize, inertia: f64, hard_from: f64) -> Box<dyn Participant> {
    let step = move |v: &mut Vec<f64>,
                     at: &cofferdam_coupling::participant::Occasion,
                     given: &[f64],
                     p: &mut [f64]| {
        let h = at.communication_step;
        for i in 0..points {
            v[i] += h * given[i];
            let beside = if i > 0 { given[i - 1] } else { 0.0 };
            p[i] = -(inertia * given[i] + 0.2 * inertia * beside + 0.7 * v[i]);
        }
        if h > 0.06 && at.end() > hard_from && at.end() < hard_from + 0.25 {
            p[0] += if at.iteration.is_multiple_of(2) { 0.5 } else { -0.5 };
        }
    };
    Box::new(SmallUnit::fluid(name, points, vec![0.0; points], vec![0.0; points], step).in_bytes())
}

/// All that two equal runs share.
#[derive(Clone, Copy)]
struct Case {
    kind: SchemeKind,
    acceleration: AccelerationKind,
    stepping: Stepping,
    /// Two fluids.
    three: bool,
    /// The steps around this time (s) do not converge unless halved.
    hard_from: f64,
    inertia: f64,
}

impl Case {
    fn new(kind: SchemeKind, acceleration: AccelerationKind) -> Self {
        let stepping = Stepping::equal(0.05, 30);
        Self { kind, acceleration, stepping, three: false, hard_from: f64::INFINITY, inertia: 0.6 }
    }

    fn simulation(&self) -> Result<Simulation, Failure> {
        let one = || fluid("reservoir", POINTS, self.inertia, self.hard_from);
        let interface = |prefix: &str, fluid| {
            wet_face_interface(Port { unit: DAM, prefix: prefix.to_owned() }, Port::of(fluid), 0.7)
        };
        let mut graph = if self.three {
            let faces = &[("", POINTS), ("tailwater_", 2)];
            let units =
                vec![structure(faces), one(), fluid("tailwater", 2, 0.7 * self.inertia, f64::INFINITY)];
            Graph::new(units, vec![interface("", RESERVOIR), interface("tailwater_", TAILWATER)])?
        } else {
            Graph::new(vec![structure(&[("", POINTS)]), one()], vec![interface("", RESERVOIR)])?
        };
        let measure = ConvergenceMeasure::new(
            &[Measure::Relative, Measure::Change],
            1e-8,
            Scales { change: 1e-3, typical: 0.01, bound: 1e9, ..Scales::default() },
        );
        let settings = Settings { kind: self.kind, ..Settings::default() };
        let acceleration = Acceleration::new(self.acceleration, 0.6, 1e-3);
        let samples = (0..200).map(|i| (0.4 * f64::from(i)).sin() + (0.07 * f64::from(i * i)).cos());
        let shaking = Signal::new("ground_motion", GROUND_ACCELERATION, 0.02, samples.collect());
        let scheme =
            Scheme::new(&mut graph, settings, acceleration, Predictor::new(2), measure, vec![shaking])?;
        Ok(Simulation::new(graph, scheme, self.stepping))
    }
}

/// Keeps the reports; it needs nothing to go on.
#[derive(Default)]
struct Kept(Vec<WindowReport>);

impl Observer for Kept {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        let mut report = report.clone();
        // Wall times are those of the machine.
        report.exchanges.iter_mut().for_each(|e| (e.sent, e.answered) = (Duration::ZERO, Duration::ZERO));
        report.unit_time = Duration::ZERO;
        report.solver_time.clear();
        self.0.push(report);
        Ok(())
    }
    fn end(&mut self, _: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// What a run gives that is continued or not.
struct Outcome {
    reports: Vec<WindowReport>,
    histories: Histories,
    status: Status,
    statistics: cofferdam_coupling::observer::Statistics,
    crest: Option<[f64; 2]>,
    flags: Vec<String>,
}

/// A run's states after its windows: of the run, and of the units.
type Saved = (Vec<u8>, Vec<Vec<u8>>);

/// The limits and the clock of a scene, if the run has one.
type OfScene<'a> = Option<&'a LoadedScene>;

/// A run from its start or from `saved`; with the states after each accepted window, and at the beginning.
fn run(
    simulation: &mut Simulation,
    scene: OfScene<'_>,
    saved: Option<(&Saved, &[WindowReport])>,
) -> Result<(Outcome, Vec<(usize, Saved)>), Failure> {
    let (mut kept, mut histories) = (Kept::default(), HistoriesWriter::in_memory());
    let mut limits = scene.map_or_else(Limits::default, |loaded| Limits::new(&loaded.scene.stop));
    let mut rest = scene.map_or_else(Rest::default, |loaded| Rest::new(&loaded.scene.time));
    let mut progress = Progress::new(true);
    let mut observers: Vec<&mut dyn Observer> =
        vec![&mut kept, &mut histories, &mut limits, &mut rest, &mut progress];
    let mut course = simulation.course();
    let mut states = Vec::new();
    match saved {
        None => simulation.begin(&mut course, &mut observers)?,
        Some(((bytes, units), past)) => {
            simulation.graph.deserialise(units)?;
            let past = past.iter().cloned().map(|report| Ok::<_, SimulationError>(Past::Window(report)));
            simulation.retell(past, &mut observers)?;
            let state = RunState::from_bytes(simulation.fingerprint()?, bytes)?;
            simulation.resume(&mut course, &state)?;
        }
    }
    // Windows, those included that were not accepted.
    let mut attempts = 0;
    let status = loop {
        match simulation.state(&course) {
            Ok(state) => states.push((attempts, (state.to_bytes()?, simulation.graph.serialise()?))),
            Err(RunStateError::InsideWindow { .. }) => (),
            Err(error) => return Err(error.into()),
        }
        attempts += 1;
        if let Some(status) = simulation.advance(&mut course, &mut observers)? {
            break status;
        }
    };
    drop(observers);
    let outcome = Outcome {
        reports: kept.0,
        histories: histories.histories,
        status,
        statistics: course.statistics().clone(),
        crest: crest_at_rest(simulation),
        flags: limits.flags(),
    };
    Ok((outcome, states))
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Runs, and continues from states after each of `stops` windows with what `make` makes again; the uninterrupted run.
fn continued(
    what: &str,
    make: &dyn Fn() -> Result<Simulation, Failure>,
    scene: OfScene<'_>,
    stops: &dyn Fn(usize) -> Vec<usize>,
) -> Result<Outcome, Failure> {
    let (whole, states) = run(&mut make()?, scene, None)?;
    for stop in stops(states.len()) {
        let (attempts, saved) = &states[stop];
        // The run's own first report is that of initialisation.
        let past = &whole.reports[..1 + attempts];
        let (rest, later) = run(&mut make()?, scene, Some((saved, past)))?;
        let at = format!("{what}, continued after {stop} of {} states", states.len());
        assert_eq!(rest.reports.len(), whole.reports.len(), "{at}");
        for (found, expected) in rest.reports.iter().zip(&whole.reports) {
            let of = |exchange: &Exchange| (bits(&exchange.inputs), bits(&exchange.outputs));
            let exchanges = |report: &WindowReport| report.exchanges.iter().map(of).collect::<Vec<_>>();
            assert!(exchanges(found) == exchanges(expected), "{at}: exchanges of step {}", expected.step());
            assert!(found == expected, "{at}: report of step {}", expected.step());
        }
        for name in whole.histories.names() {
            let name = name.split(" [").next().ok_or("a name")?;
            let column = |histories: &Histories| histories.column(name).map(bits).unwrap_or_default();
            assert_eq!(column(&rest.histories), column(&whole.histories), "{at}: {name}");
        }
        assert_eq!((&rest.status, &rest.statistics), (&whole.status, &whole.statistics), "{at}");
        assert_eq!((rest.crest, &rest.flags), (whole.crest, &whole.flags), "{at}");
        // The states that follow are the same too, but for wall times.
        let units = |(_, (_, units)): &(usize, Saved)| units.clone();
        assert!(later.iter().map(units).eq(states[stop..].iter().map(units)), "{at}: states of the units");
    }
    Ok(whole)
}

/// The beginning, every window in which an acceleration learns, and some later ones.
fn early_and_some(states: usize) -> Vec<usize> {
    (0..states).filter(|stop| *stop < 7 || stop % 5 == 0 || *stop + 1 == states).collect()
}

const KINDS: [AccelerationKind; 4] = [
    AccelerationKind::Constant,
    AccelerationKind::Aitken,
    AccelerationKind::IqnIls,
    AccelerationKind::InterfaceJacobian,
];

#[test]
fn every_scheme_and_acceleration_goes_on_where_it_was_stopped() -> Result<(), Failure> {
    use SchemeKind::{ParallelExplicit, ParallelImplicit, SerialExplicit, SerialImplicit};
    for kind in [SerialImplicit, ParallelImplicit, SerialExplicit, ParallelExplicit] {
        for acceleration in KINDS.into_iter().take(if kind.is_implicit() { 4 } else { 1 }) {
            for three in [false, true] {
                for window in [1, 3] {
                    // Explicit schemes diverge with much water.
                    let inertia = if kind.is_implicit() { 0.6 } else { 0.1 };
                    let mut case = Case { three, inertia, ..Case::new(kind, acceleration) };
                    case.stepping.window = window;
                    let what = format!("{kind:?} {acceleration:?}, three units {three}, windows of {window}");
                    let whole = continued(&what, &|| case.simulation(), None, &early_and_some)?;
                    let iterated = whole.reports.iter().any(|report| report.iterations() > 2);
                    assert_eq!(iterated, kind.is_implicit(), "{what}");
                }
            }
        }
    }
    Ok(())
}

#[test]
fn halved_and_adaptive_steps_go_on_and_no_state_is_given_inside_a_window() -> Result<(), Failure> {
    for acceleration in KINDS {
        for three in [false, true] {
            let mut halved =
                Case { three, hard_from: 0.9, ..Case::new(SchemeKind::SerialImplicit, acceleration) };
            halved.stepping = Stepping { halve: true, ..Stepping::equal(0.1, 20) };
            let all = |states| (0..states).collect();
            let whole = continued(&format!("{acceleration:?}, halved"), &|| halved.simulation(), None, &all)?;
            assert!(whole.statistics.rejected > 0, "{acceleration:?}");
            let adaptive = Adaptive { tolerance: 0.02, shortest: 1e-3, longest: 0.2 };
            let mut adapted = Case { hard_from: f64::INFINITY, ..halved };
            adapted.stepping = Stepping { adaptive: Some(adaptive), ..Stepping::equal(0.02, 50) };
            let some = |states| (0..states).filter(|stop| *stop < 7 || stop % 16 == 0).collect();
            let whole =
                continued(&format!("{acceleration:?}, adaptive"), &|| adapted.simulation(), None, &some)?;
            let lengths = whole.reports.iter().map(|report| report.steps[0].communication_step.to_bits());
            assert!(lengths.collect::<std::collections::BTreeSet<_>>().len() > 4, "{acceleration:?}");
        }
    }
    let mut case =
        Case { hard_from: 0.25, ..Case::new(SchemeKind::SerialImplicit, AccelerationKind::Constant) };
    case.stepping = Stepping { halve: true, ..Stepping::equal(0.1, 20) };
    let mut simulation = case.simulation()?;
    let mut course = simulation.course();
    simulation.begin(&mut course, &mut [])?;
    let refused = loop {
        match simulation.state(&course) {
            Ok(_) => assert_eq!(simulation.advance(&mut course, &mut [])?, None),
            Err(error) => break error.to_string(),
        }
    };
    assert!(refused.starts_with("at t = 0.2 s the run is inside a window"), "{refused}");
    Ok(())
}

/// A short, coarse scene with cracks, with `settings`.
fn coarse(case: &str, settings: &[(&str, &str)]) -> Result<LoadedScene, Failure> {
    let mut scenario = Scenario::shipped(case);
    scenario.set("dam.element_size", 20.0).set("reservoir.element_size", 20.0);
    scenario.set("ground_motion.record.start", 5.0).set("ground_motion.record.end", 5.1);
    scenario.set("time.quiet", 0.0);
    if case == "koyna-tailwater" {
        scenario.set("dam.element_size", 15.0).set("reservoir.element_size", 12.0);
        scenario.set("tailwater.element_size", 7.5);
    }
    for (key, value) in settings {
        let value: toml::Table = format!("value = {value}").parse()?;
        scenario.set(key, value["value"].clone());
    }
    Ok(read_scene(&scenario.write(), &[])?)
}

#[test]
fn cracked_dams_and_their_waters_go_on() -> Result<(), Failure> {
    let adaptive = ("time.adaptive", "{ tolerance = 3e-3, shortest = 5e-4, longest = 0.01 }");
    let recursive = ("reservoir.method", "\"recursive\"");
    let acceleration = |name| ("coupling.acceleration", name);
    for (case, settings) in [
        ("koyna-coarse", &[acceleration("\"interface-jacobian\"")][..]),
        ("koyna-coarse", &[acceleration("\"iqn-ils\""), ("coupling.window", "3")]),
        ("koyna-coarse", &[acceleration("\"iqn-ils\""), recursive, adaptive]),
        ("koyna-coarse", &[("coupling.scheme", "\"parallel-implicit\""), acceleration("\"iqn-ils\"")]),
        (
            "koyna-coarse",
            &[("reservoir.fidelity", "\"incompressible\""), ("coupling.scheme", "\"added-mass\"")],
        ),
        (
            "koyna-coarse",
            &[
                acceleration("\"aitken\""),
                ("stop", "[{ quantity = \"iterations\", above = 2, action = \"flag\" }]"),
            ],
        ),
        ("koyna-tailwater", &[acceleration("\"iqn-ils\"")]),
    ] {
        let loaded = coarse(case, settings)?;
        let make = || -> Result<Simulation, Failure> {
            let graph = Assembly::with(&loaded.scene, NonZeroUsize::MIN).graph()?;
            Ok(simulation_of(&loaded.scene, &loaded.ground_motion, graph)?)
        };
        let stops = |states: usize| vec![0, 1, states / 2, states - 1];
        let whole = continued(&format!("{case} {settings:?}"), &make, Some(&loaded), &stops)?;
        assert!(whole.reports.len() > 10 && whole.crest.is_some(), "{case} {settings:?}");
    }
    Ok(())
}

/// The units of a scene, each in a process of its own where it may be.
fn in_processes(scene: &Scene) -> Result<Vec<Box<dyn Participant>>, Failure> {
    let command = |id: UnitId| -> Result<Option<UnitCommand>, Failure> {
        let name = unit_name(id).to_owned();
        Ok(match Assembly::of(scene).home(id) {
            Home::Here => None,
            Home::Process => {
                let mut command = Command::new(binary());
                command.args(["unit", &name]);
                Some(UnitCommand { name, command, brief: None })
            }
            Home::Command(of_scene) => {
                let command = Command::new(&of_scene.argv[0]);
                Some(UnitCommand { name, command, brief: Some(Assembly::of(scene).brief(id, of_scene)?) })
            }
        })
    };
    let ids = Assembly::of(scene).units();
    let commands = ids.iter().map(|&id| command(id)).collect::<Result<Vec<_>, _>>()?;
    let minute = Duration::from_secs(60);
    let deadlines = Deadlines { preparation: minute, step: minute };
    let starting = Starting::new(commands.into_iter().flatten(), &toml::to_string(scene)?, 1, deadlines)?;
    let mut started = starting.wait(&AtomicBool::new(false))?.into_iter();
    let unit = |id: UnitId| -> Result<Box<dyn Participant>, Failure> {
        Ok(match Assembly::of(scene).home(id) {
            Home::Here => Assembly::with(scene, NonZeroUsize::MIN).unit(id)?,
            Home::Process => Box::new(started.next().ok_or("a process")?),
            Home::Command(_) => {
                Assembly::of(scene).adapted(id, Box::new(started.next().ok_or("a process")?))?
            }
        })
    };
    ids.into_iter().map(unit).collect()
}

/// The coarse main scene with what takes the place of its units, as pairs of keys and values.
fn swapped(settings: &[(&str, String)]) -> Result<LoadedScene, Failure> {
    let settings: Vec<(&str, &str)> = settings.iter().map(|(key, value)| (*key, value.as_str())).collect();
    coarse("koyna-coarse", &settings)
}

/// What takes a unit's place: its fidelity, and the table of that name.
fn of(unit: &str, fidelity: &str, table: &str) -> [(&'static str, String); 2] {
    let keys = match unit {
        "dam" => ["dam.fidelity", "dam"],
        _ => ["reservoir.fidelity", "reservoir"],
    };
    let place: &'static str = Box::leak(format!("{}.{fidelity}", keys[1]).into_boxed_str());
    [(keys[0], format!("{fidelity:?}")), (place, table.to_owned())]
}

/// The coarse main scene's unit as FMU.
fn packed(folder: &Path, unit: &str) -> Result<PathBuf, Failure> {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 20.0).set("reservoir.element_size", 20.0);
    let file = folder.join(format!("{unit}.fmu"));
    let mut export = Command::new(binary());
    export.args(["export-fmu", "--unit", unit]).arg("--output").arg(&file).arg(scenario.write());
    let done = export.output()?;
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    Ok(file)
}

#[test]
fn units_in_processes_fmus_and_logs_go_on() -> Result<(), Failure> {
    let place = tempfile::tempdir()?;
    let file =
        |unit| -> Result<String, Failure> { Ok(format!("{{ file = {:?} }}", packed(place.path(), unit)?)) };
    let fmus = [of("dam", "fmu", &file("dam")?), of("reservoir", "fmu", &file("reservoir")?)];
    // A run of the past.
    let loaded = swapped(&[])?;
    let past = place.path().join("log.mcap");
    let preamble = Preamble { scene: toml::to_string(&loaded.scene)?, ..Preamble::default() };
    let mut log = LogWriter::create(&past, &preamble)?;
    let graph = Assembly::with(&loaded.scene, NonZeroUsize::MIN).graph()?;
    let mut simulation = simulation_of(&loaded.scene, &loaded.ground_motion, graph)?;
    let (_, failure) = simulation.run(&mut [&mut log], &AtomicBool::new(false));
    assert!(failure.is_none(), "{failure:?}");
    let recorded = |unit| of(unit, "log", &format!("{{ file = {past:?} }}"));
    let argv = format!("{{ argv = [{:?}], acceleration = \"end\" }}", env!("CARGO_BIN_EXE_built_in_unit"));
    let iqn = ("coupling.acceleration", "\"iqn-ils\"".to_owned());
    let cases = [
        ("built-in units", coarse("koyna-coarse", &[("coupling.acceleration", "\"iqn-ils\"")])?, true),
        ("built-in units, tailwater", coarse("koyna-tailwater", &[])?, true),
        ("FMUs", swapped(&[fmus[0].as_slice(), &fmus[1]].concat())?, false),
        ("FMUs", swapped(&[fmus[0].as_slice(), &fmus[1], &[iqn]].concat())?, true),
        ("a log as reservoir", swapped(&recorded("reservoir"))?, true),
        ("a log as dam", swapped(&recorded("dam"))?, false),
        (
            "an FMU, another program",
            swapped(&[fmus[0].as_slice(), &of("reservoir", "command", &argv)].concat())?,
            true,
        ),
    ];
    for (what, loaded, processes) in cases {
        let what = format!("{what}, in processes {processes}");
        let make = || -> Result<Simulation, Failure> {
            let graph = if processes {
                Graph::new(in_processes(&loaded.scene)?, Assembly::of(&loaded.scene).interfaces())?
            } else {
                Assembly::with(&loaded.scene, NonZeroUsize::MIN).graph()?
            };
            Ok(simulation_of(&loaded.scene, &loaded.ground_motion, graph)?)
        };
        let stops = |states: usize| vec![0, 1, states / 2, states - 1];
        let whole = continued(&what, &make, Some(&loaded), &stops)?;
        assert!(whole.reports.len() > 10, "{what}");
    }
    Ok(())
}

/// Bytes that are none of a unit are refused wherever it runs, which then takes those that are.
#[test]
fn bytes_that_are_no_state_of_a_unit_are_refused_wherever_it_runs() -> Result<(), Failure> {
    let place = tempfile::tempdir()?;
    let fmu = packed(place.path(), "dam")?;
    let built_in = swapped(&[])?;
    let packed = swapped(&of("dam", "fmu", &format!("{{ file = {fmu:?} }}")))?;
    let other = coarse("koyna-coarse", &[("dam.material.density", "2500.0")])?;
    for (scene, processes) in
        [(&built_in.scene, false), (&built_in.scene, true), (&packed.scene, false), (&packed.scene, true)]
    {
        let make = |scene: &Scene| -> Result<Vec<Box<dyn Participant>>, Failure> {
            if processes {
                return in_processes(scene);
            }
            let units = Assembly::of(scene).units().into_iter();
            Ok(units.map(|id| Assembly::with(scene, NonZeroUsize::MIN).unit(id)).collect::<Result<_, _>>()?)
        };
        let at_start = |units: &mut Vec<Box<dyn Participant>>| -> Result<Vec<u8>, Failure> {
            let size = [&units[0].description().inputs, &units[0].description().outputs].map(|l| l.size());
            units[0].initialise(0.0, &vec![0.0; size[0]], &mut vec![0.0; size[1]])?;
            Ok(units[0].serialise()?.ok_or("its bytes")?)
        };
        let state = at_start(&mut make(scene)?)?;
        let foreign = at_start(&mut make(&other.scene)?)?;
        let mut damaged = state.clone();
        damaged[state.len() / 2] ^= 1;
        let mut units = make(scene)?;
        for (bytes, reason) in [
            (&foreign[..], "belongs to another unit or scene"),
            (&state[..state.len() - 1], "is damaged"),
            (&state[..20], "these 20 bytes are not a serialised state"),
            (&[], "these 0 bytes are not a serialised state"),
            (&damaged, "is damaged"),
        ] {
            let refused = units[0].deserialise(bytes).expect_err(reason).to_string();
            assert!(refused.starts_with("dam: ") && refused.contains(reason), "{reason}: {refused}");
        }
        units[0].deserialise(&state)?;
        assert_eq!(units[0].serialise()?.ok_or("its bytes")?, state);
    }
    Ok(())
}

#[test]
fn states_are_refused_elsewhere_and_where_a_unit_gives_none() -> Result<(), Failure> {
    let case = Case::new(SchemeKind::SerialImplicit, AccelerationKind::IqnIls);
    let (_, states) = run(&mut case.simulation()?, None, None)?;
    let (_, (bytes, units)) = &states[4];
    let others = [
        Case { kind: SchemeKind::ParallelImplicit, ..case },
        Case { acceleration: AccelerationKind::Aitken, ..case },
        Case { stepping: Stepping::equal(0.05, 31), ..case },
        Case { three: true, ..case },
    ];
    for other in others {
        let refused =
            RunState::from_bytes(other.simulation()?.fingerprint()?, bytes).expect_err("another run");
        assert!(refused.to_string().contains("belongs to another unit or scene"), "{refused}");
    }
    let mut again = case.simulation()?;
    let state = RunState::from_bytes(again.fingerprint()?, bytes)?;
    assert!((state.time() - 0.2).abs() < 1e-12);
    let mut course = again.course();
    again.resume(&mut course, &state)?;
    let mut other = others[1].simulation()?;
    let mut course = other.course();
    let refused = other.resume(&mut course, &state).expect_err("another run").to_string();
    assert!(refused.contains("belongs to another unit or scene"), "{refused}");
    let refused = again.graph.deserialise(&units[..1]).expect_err("one state").to_string();
    assert!(refused.contains("1 saved states, but 2 units"), "{refused}");
    let swapped = [units[1].clone(), units[0].clone()];
    assert!(again.graph.deserialise(&swapped).is_err());
    let silent = SmallUnit::dam(1, (), vec![0.0; 2], |(), _, _, _| ());
    let mut graph = pair(Box::new(silent), fluid("reservoir", 1, 1.0, 0.0))?;
    let refused = graph.serialise().expect_err("it gives none").to_string();
    assert!(refused.starts_with("dam: it neither gives nor takes its state as bytes"), "{refused}");
    Ok(())
}

/// A unit of another program takes accelerations to be those at the end of a step: the conversion continues too.
#[test]
fn converted_accelerations_go_on() -> Result<(), Failure> {
    let face = cofferdam_unit::WetFace::straight([0.0, 2.0], 2)?;
    let place = |role| Place {
        role,
        face: face.clone(),
        specific_weight: 0.0,
        acceleration: AccelerationMeaning::End,
    };
    let make = || -> Result<[Foreign; 2], Failure> {
        let dam = Foreign::new(structure(&[("", POINTS)]), &place(Role::Structure))?;
        Ok([dam, Foreign::new(fluid("reservoir", POINTS, 0.6, f64::INFINITY), &place(Role::Fluid))?])
    };
    let ask = |unit: &mut Foreign, step: u64| -> Result<Vec<u64>, Failure> {
        let inputs: Vec<f64> =
            (0..unit.description().inputs.size()).map(|i| (step as f64 + 0.3 * i as f64).sin()).collect();
        let mut outputs = vec![0.0; unit.description().outputs.size()];
        let interval = whole_chain::small_unit::interval(step, 0.1 + 0.02 * (step % 3) as f64);
        let occasion = cofferdam_coupling::participant::Occasion {
            step,
            iteration: 1,
            attempt: 1,
            time: interval.time,
            communication_step: interval.communication_step,
        };
        unit.step(&occasion, &inputs, &mut outputs)?;
        Ok(bits(&outputs))
    };
    for (mut unit, mut other) in make()?.into_iter().zip(make()?) {
        let zeros = vec![0.0; unit.description().inputs.size()];
        unit.initialise(0.0, &zeros, &mut vec![0.0; unit.description().outputs.size()])?;
        for step in 1..5 {
            ask(&mut unit, step)?;
        }
        other.deserialise(&unit.serialise()?.ok_or("its bytes")?)?;
        for step in 5..9 {
            assert_eq!(ask(&mut unit, step)?, ask(&mut other, step)?, "step {step}");
        }
    }
    let mut rigid = Prescribed::new(face.clone())?;
    let size = [rigid.description().inputs.size(), rigid.description().outputs.size()];
    let (inputs, mut first, mut second) = (vec![0.7; size[0]], vec![0.0; size[1]], vec![0.0; size[1]]);
    let occasion =
        cofferdam_coupling::participant::Occasion { communication_step: 0.1, ..Default::default() };
    rigid.step(&occasion, &inputs, &mut first)?;
    let mut again = Prescribed::new(face)?;
    again.deserialise(&rigid.serialise()?.ok_or("its bytes")?)?;
    rigid.step(&occasion, &inputs, &mut first)?;
    again.step(&occasion, &inputs, &mut second)?;
    assert_eq!(bits(&first), bits(&second));
    Ok(())
}

/// Log times and numbers of all messages.
fn messages(path: &Path) -> Result<Vec<(u64, u32)>, Failure> {
    let file = std::fs::read(path)?;
    let mut found = Vec::new();
    for message in mcap::MessageStream::new(&file)? {
        let message = message?;
        found.push((message.log_time, message.sequence));
    }
    Ok(found)
}

#[test]
fn a_run_told_from_its_log_goes_on_with_the_same_log_and_pictures() -> Result<(), Failure> {
    let loaded = coarse("koyna-coarse", &[("snapshots", "{ interval = 0.02 }")])?;
    let plan = loaded.scene.snapshots.ok_or("a plan")?;
    let make = || -> Result<Simulation, Failure> {
        let graph = Assembly::with(&loaded.scene, NonZeroUsize::MIN).graph()?;
        Ok(simulation_of(&loaded.scene, &loaded.ground_motion, graph)?)
    };
    let preamble = Preamble { scene: toml::to_string(&loaded.scene)?, ..Preamble::default() };
    let folder = tempfile::tempdir()?;
    let [whole, first, second] = ["whole", "first", "second"].map(|name| folder.path().join(name));
    let go = |path: &Path, from: Option<(&Saved, &Path)>, windows: usize| -> Result<Saved, Failure> {
        std::fs::create_dir_all(path)?;
        let mut simulation = make()?;
        let mut log = LogWriter::create(&path.join("log.mcap"), &preamble)?;
        let water = Assembly::of(&loaded.scene).water_field(Side::Upstream)?;
        let mut snapshots = Snapshots::new(path, plan, water.into_iter().collect());
        let mut observers: Vec<&mut dyn Observer> = vec![&mut log, &mut snapshots];
        let mut course = simulation.course();
        match from {
            None => simulation.begin(&mut course, &mut observers)?,
            Some(((bytes, units), before)) => {
                simulation.graph.deserialise(units)?;
                simulation.retell(
                    Log::open(before)?.reports()?.map(|past| Ok::<_, Failure>(past?)),
                    &mut observers,
                )?;
                let state = RunState::from_bytes(simulation.fingerprint()?, bytes)?;
                simulation.resume(&mut course, &state)?;
            }
        }
        for _ in 0..windows {
            if simulation.advance(&mut course, &mut observers)?.is_some() {
                break;
            }
        }
        let saved = (simulation.state(&course)?.to_bytes()?, simulation.graph.serialise()?);
        let ending = Ending {
            status: Status::Completed,
            time: course.time(),
            wall: Default::default(),
            statistics: course.statistics().clone(),
        };
        observers.iter_mut().try_for_each(|observer| observer.end(&ending))?;
        Ok(saved)
    };
    go(&whole, None, usize::MAX)?;
    let saved = go(&first, None, 17)?;
    // The pictures so far, as in a run that continues in its folder.
    std::fs::create_dir_all(second.join("snapshots"))?;
    for picture in std::fs::read_dir(first.join("snapshots"))? {
        let picture = picture?;
        std::fs::copy(picture.path(), second.join("snapshots").join(picture.file_name()))?;
    }
    go(&second, Some((&saved, &first)), usize::MAX)?;
    let [all, later] = [&whole, &second].map(|path| messages(&path.join("log.mcap")));
    let all = all?;
    assert!(all.len() > 100 && all == later?, "the same messages with the same times and numbers");
    let logs = [Log::open(&whole)?, Log::open(&second)?];
    assert!(compare(logs.each_ref())?.identical());
    let series = |path: &Path| std::fs::read_to_string(path.join("snapshots.pvd"));
    assert_eq!(series(&second)?, series(&whole)?);
    let mut pictures = 0;
    for picture in std::fs::read_dir(whole.join("snapshots"))? {
        let picture = picture?;
        let other = second.join("snapshots").join(picture.file_name());
        assert!(std::fs::read(picture.path())? == std::fs::read(other)?, "{:?} differs", picture.file_name());
        pictures += 1;
    }
    assert!(pictures > 20 && whole.join("snapshots/reservoir-000001.vtu").is_file(), "{pictures}");
    Ok(())
}
