//! Features of the schemes: units at once, repeated steps, accepted failures, frozen units.

use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::observer::{Limits, Rest, Snapshots};
use cofferdam_assembly::units::{DAM, GROUND_ACCELERATION, RESERVOIR, pair};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, IterationFailure, Measure, Scales};
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start, Status};
use cofferdam_coupling::participant::{Description, Occasion, Participant, ParticipantError};
use cofferdam_coupling::scheme::{
    CouplingError, Interval, Predictor, Scheme, SchemeKind, Settings, WindowReport,
};
use cofferdam_coupling::signal::Signal;
use cofferdam_coupling::simulation::{Simulation, SimulationError};
use cofferdam_coupling::stepping::{Adaptive, Stepping};
use cofferdam_log::replay::{Unanswered, replay};
use cofferdam_log::{Entry, Log, LogWriter, LoggedExchange, Preamble};
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{StopAction, StopQuantity, StopScene, Time};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;
use std::time::Duration;
use whole_chain::scenario::root;
use whole_chain::small_unit::{SmallUnit, interval};

const MASS: f64 = 2.0;

/// A mass, pushed by p and by `load(t)`, its acceleration constant in a step.
fn mass(load: impl Fn(f64) -> f64 + Send + 'static) -> SmallUnit<[f64; 2]> {
    SmallUnit::dam(1, [0.0; 2], vec![0.0; 2], move |[u, v], at, given, answer| {
        let h = at.communication_step;
        let acceleration = (given[0] + load(at.end())) / MASS;
        *u += h * *v + h * h * acceleration / 2.0;
        *v += h * acceleration;
        (answer[0], answer[1]) = (*u, acceleration);
    })
}

/// Water of `added` mass that answers `p = −added a`; its answers may be changed.
fn water(added: f64, mut spoil: impl FnMut(&Occasion, &mut f64) + Send + 'static) -> SmallUnit<()> {
    SmallUnit::reservoir(1, (), vec![0.0], move |(), at, given, answer| {
        answer[0] = -added * given[0];
        spoil(at, &mut answer[0]);
    })
}

fn measure(tolerance: f64) -> ConvergenceMeasure {
    ConvergenceMeasure::new(
        &[Measure::Relative],
        tolerance,
        Scales { typical: 1e-12 / tolerance, bound: 1e9, ..Scales::default() },
    )
}

#[derive(Default)]
struct Kept(Vec<WindowReport>);

impl Observer for Kept {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.0.push(report.clone());
        Ok(())
    }
    fn end(&mut self, _: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

struct Case {
    settings: Settings,
    acceleration: AccelerationKind,
    relaxation: f64,
    tolerance: f64,
    stepping: Stepping,
}

impl Case {
    fn new(stepping: Stepping) -> Self {
        let (acceleration, tolerance) = (AccelerationKind::Constant, 1e-9);
        Self { settings: Settings::default(), acceleration, relaxation: 1.0, tolerance, stepping }
    }

    fn run(
        self,
        dam: impl Participant + 'static,
        reservoir: impl Participant + 'static,
    ) -> (Vec<WindowReport>, Ending, Option<SimulationError>) {
        self.run_with(dam, reservoir, &mut [])
    }

    fn run_with(
        self,
        dam: impl Participant + 'static,
        reservoir: impl Participant + 'static,
        others: &mut [&mut dyn Observer],
    ) -> (Vec<WindowReport>, Ending, Option<SimulationError>) {
        let mut graph = pair(Box::new(dam), Box::new(reservoir)).expect("two units");
        let acceleration = Acceleration::new(self.acceleration, self.relaxation, 1e-3);
        let (predictor, measure) = (Predictor::new(1), measure(self.tolerance));
        let scheme = Scheme::new(&mut graph, self.settings, acceleration, predictor, measure, Vec::new())
            .expect("the units fit");
        let mut simulation = Simulation::new(graph, scheme, self.stepping);
        let mut kept = Kept::default();
        let mut observers: Vec<&mut dyn Observer> = vec![&mut kept];
        observers.extend(others.iter_mut().map(|o| &mut **o as &mut dyn Observer));
        let (ending, failure) = simulation.run(&mut observers, &AtomicBool::new(false));
        drop(observers);
        (kept.0, ending, failure)
    }
}

#[test]
fn parallel_schemes_run_both_units_at_once() {
    for kind in [SchemeKind::ParallelExplicit, SchemeKind::ParallelImplicit] {
        // Each waits for the other in the middle of its step.
        let ((to_dam, from_reservoir), (to_reservoir, from_dam)) = (channel::<()>(), channel::<()>());
        let patience = Duration::from_secs(60);
        let dam = SmallUnit::dam(1, (), vec![0.0; 2], move |(), at, given, answer| {
            to_reservoir.send(()).expect("the reservoir is there");
            from_reservoir.recv_timeout(patience).expect("the reservoir steps at the same time");
            (answer[0], answer[1]) = (0.0, (at.end().sin() + given[0]) / MASS);
        });
        let reservoir = SmallUnit::reservoir(1, (), vec![0.0], move |(), _, given, answer| {
            to_dam.send(()).expect("the dam is there");
            from_dam.recv_timeout(patience).expect("the dam steps at the same time");
            answer[0] = -0.5 * given[0];
        });
        let case =
            Case { settings: Settings { kind, ..Settings::default() }, ..Case::new(Stepping::equal(0.1, 5)) };
        let (reports, ending, failure) = case.run(dam, reservoir);
        assert!(failure.is_none() && ending.status == Status::Completed, "{failure:?}");
        assert_eq!(reports.len(), 6);
    }
}

#[test]
fn a_parallel_run_whose_units_fail_leaves_a_log_that_can_be_read() {
    for (failing, unanswered) in [([true, false], 1), ([false, true], 1), ([true, true], 2)] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.mcap");
        let mut log = log_of_a_scene(&path);
        let settings = Settings { kind: SchemeKind::ParallelImplicit, ..Settings::default() };
        let case = Case { settings, ..Case::new(Stepping::equal(0.1, 5)) };
        let [dam, reservoir] = pair_failing(failing, |at| at.step == 3);
        let (_, _, failure) = case.run_with(dam, reservoir, &mut [&mut log]);
        assert!(failure.is_some());
        let exchanges = logged_exchanges(&path);
        let silent: Vec<_> = exchanges.iter().rev().take_while(|e| e.outputs.is_none()).collect();
        assert_eq!(silent.len(), unanswered, "{failing:?}");
        assert!(silent.iter().all(|e| e.occasion.step == 3), "{failing:?}");
        assert_eq!(exchanges.iter().filter(|e| e.outputs.is_none()).count(), unanswered);
    }
}

/// A mass and water, of which some fail `when` they are asked so.
fn pair_failing(failing: [bool; 2], when: fn(&Occasion) -> bool) -> [Failing; 2] {
    let units: [Box<dyn Participant>; 2] = [Box::new(mass(f64::cos)), Box::new(water(0.3 * MASS, |_, _| ()))];
    let mut failing = failing.into_iter();
    units.map(|unit| Failing { unit, fails: if failing.next() == Some(true) { when } else { |_| false } })
}

/// A unit may refuse a guess; the run continues in shorter steps, and its log tells of it.
#[test]
fn a_run_goes_on_behind_a_guess_that_was_refused_and_so_does_its_replay() {
    let refused = |at: &Occasion| (at.step, at.attempt, at.iteration) == (3, 1, 2);
    for kind in [SchemeKind::SerialImplicit, SchemeKind::ParallelImplicit] {
        for (failing, unanswered) in [([true, false], 1), ([false, true], 1), ([true, true], 2)] {
            // one after the other, the water is not asked any more once the dam has failed
            let unanswered = if kind == SchemeKind::SerialImplicit { 1 } else { unanswered };
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("log.mcap");
            let mut log = log_of_a_scene(&path);
            let case = Case {
                settings: Settings { kind, ..Settings::default() },
                ..Case::new(Stepping { halve: true, ..Stepping::equal(0.1, 5) })
            };
            let [dam, reservoir] = pair_failing(failing, refused);
            let (reports, ending, failure) = case.run_with(dam, reservoir, &mut [&mut log]);
            assert!(failure.is_none() && ending.status == Status::Completed, "{failure:?}");
            assert_eq!(ending.time, 0.5);
            assert!(reports.iter().any(|report| report.attempt == 2), "shorter steps");
            let exchanges = logged_exchanges(&path);
            let all: usize = reports.iter().map(|report| report.exchanges.len()).sum();
            assert_eq!(exchanges.len(), all);
            let silent: Vec<_> = exchanges.iter().filter(|e| e.outputs.is_none()).collect();
            assert_eq!(silent.len(), unanswered, "{failing:?}");
            assert!(silent.iter().all(|e| refused(&e.occasion)), "{silent:?}");
            let log = Log::open(&path).expect("a log");
            for (id, fails) in [(DAM, failing[0]), (RESERVOIR, failing[1])] {
                let of = |failing| {
                    let [dam, reservoir] = pair_failing(failing, refused);
                    if id == DAM { dam } else { reservoir }
                };
                let answered = exchanges.iter().filter(|e| e.unit == id && e.outputs.is_some()).count();
                let silent = silent.iter().find(|e| e.unit == id).map(|e| e.occasion);
                let other = silent.map(|occasion| Unanswered { occasion, failure: None });
                assert!(silent.is_none() || fails);
                // a unit that fails again, and one that does not
                for (mut unit, unanswered) in [(of(failing), None), (of([false; 2]), other)] {
                    let again = replay(&log, id, &mut unit, |_| ()).expect("a replay");
                    assert_eq!((again.identical as usize, again.divergence), (answered, None), "{kind:?}");
                    assert_eq!(again.unanswered, unanswered, "{kind:?}");
                    assert_eq!(again.ending, Some(Ok("completed".to_owned())));
                }
            }
        }
    }
}

/// What a dam does not tell is not watched: a limit would never be met, and the dam would seem to be at rest.
#[test]
fn what_is_to_be_watched_must_be_told() {
    let (dam, motion) = (mass(f64::cos), GroundMotion::of_samples("a push", 0.1, vec![0.0, 1.0, 0.0]));
    let start = Start {
        units: vec![dam.description().clone()],
        signals: &ground_signals(&motion),
        stepping: Stepping::equal(0.1, 200),
    };
    let limit = |quantity| StopScene { quantity, above: 1.0, action: StopAction::End };
    for (quantity, variable) in [
        (StopQuantity::Sliding, "crack_sliding"),
        (StopQuantity::CrestDisplacement, "crest_displacement"),
        (StopQuantity::EnergyError, "energy_balance_error"),
    ] {
        let refused = Limits::new(&[limit(quantity)]).begin(&start).expect_err("it is not told").to_string();
        assert!(refused.contains("`stop`") && refused.contains(&format!("`{variable}`")), "{refused}");
    }
    assert!(Limits::new(&[limit(StopQuantity::Iterations)]).begin(&start).is_ok());
    let time = |longest_quiet| Time { longest_quiet, ..Time::default() };
    let refused = Rest::new(&time(Some(10.0))).begin(&start).expect_err("no energy").to_string();
    assert!(refused.contains("`time.longest_quiet`") && refused.contains("`kinetic_energy`"), "{refused}");
    assert!(Rest::new(&time(None)).begin(&start).is_ok());
    let refused = Snapshots::check(&start).expect_err("no mesh").to_string();
    assert!(refused.contains("`snapshots`") && refused.contains("`node_x`"), "{refused}");
}

/// An observer that cannot finish what it keeps.
struct Unfinished;

impl Observer for Unfinished {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn window(&mut self, _: &WindowReport) -> Result<(), ObserverError> {
        Ok(())
    }
    fn end(&mut self, ending: &Ending) -> Result<(), ObserverError> {
        assert_eq!(ending.status, Status::Completed);
        Err(ObserverError::Other("its file is gone".into()))
    }
}

#[test]
fn a_run_whose_results_cannot_be_finished_has_failed() {
    let (dam, reservoir) = (mass(f64::cos), water(0.3 * MASS, |_, _| ()));
    let case = Case::new(Stepping::equal(0.1, 5));
    let (reports, ending, failure) = case.run_with(dam, reservoir, &mut [&mut Unfinished]);
    assert_eq!((reports.len(), ending.time), (6, 0.5));
    let said = failure.expect("a failure").to_string();
    assert!(said.contains("its file is gone"), "{said}");
    assert_eq!(ending.status, Status::Failed(said));
}

#[test]
fn all_implicit_schemes_and_accelerations_find_the_same_and_explicit_ones_do_not_repeat() {
    // (m + 0.8 m) a = load
    let exact = |t: f64| t.sin() / (1.8 * MASS);
    for kind in [SchemeKind::SerialImplicit, SchemeKind::ParallelImplicit] {
        for window in [1, 4, 3] {
            for acceleration in [
                AccelerationKind::Constant,
                AccelerationKind::Aitken,
                AccelerationKind::IqnIls,
                AccelerationKind::InterfaceJacobian,
            ] {
                let case = Case {
                    settings: Settings { kind, iteration_limit: 400, ..Settings::default() },
                    acceleration,
                    relaxation: 0.4,
                    ..Case::new(Stepping { window, ..Stepping::equal(0.1, 20) })
                };
                let (reports, _, failure) = case.run(mass(f64::sin), water(0.8 * MASS, |_, _| ()));
                assert!(failure.is_none(), "{kind:?} {acceleration:?}: {failure:?}");
                let steps = reports.iter().skip(1).flat_map(|r| r.steps.iter().map(move |s| (r, s)));
                let mut count = 0;
                for (report, step) in steps {
                    let dam = report.accepted(DAM, step.step).expect("it was taken");
                    assert!(
                        (dam.outputs[1] - exact(step.end())).abs() < 1e-8,
                        "{kind:?} {acceleration:?} {step:?}"
                    );
                    assert!(report.converged);
                    count += 1;
                }
                assert_eq!(count, 20);
            }
        }
    }
    let explicit = Settings { kind: SchemeKind::SerialExplicit, ..Settings::default() };
    let case = Case { settings: explicit, ..Case::new(Stepping::equal(0.1, 20)) };
    let (reports, _, failure) = case.run(mass(f64::sin), water(0.8 * MASS, |_, _| ()));
    assert!(failure.is_none());
    assert!(reports.iter().skip(1).all(|r| r.exchanges.len() == 2 && r.residuals().is_some()));
}

#[test]
fn a_step_that_does_not_converge_stops_is_gone_on_with_or_is_halved_as_the_scene_says() {
    // Steps longer than 0.03 s meet water that is too heavy for a plain iteration.
    let light_when_short = || {
        SmallUnit::reservoir(1, (), vec![0.0], |(), at, given, answer| {
            let heavy = at.communication_step > 0.03 && (0.3..0.5).contains(&at.time);
            answer[0] = if heavy { -0.99 } else { -0.3 } * MASS * given[0];
        })
    };
    let case = |accept_unconverged, halve| Case {
        settings: Settings { iteration_limit: 25, accept_unconverged, ..Settings::default() },
        ..Case::new(Stepping { halve, ..Stepping::equal(0.1, 10) })
    };
    let (reports, ending, failure) = case(false, false).run(mass(f64::cos), light_when_short());
    let failed = reports.last().expect("the step that failed");
    assert!(
        matches!(failure, Some(SimulationError::Coupling(CouplingError::NotConverged { step: 4, .. }))),
        "{failure:?}"
    );
    assert!(!failed.converged && !failed.is_accepted() && ending.statistics.rejected == 0);

    let (reports, ending, failure) = case(true, false).run(mass(f64::cos), light_when_short());
    assert!(failure.is_none() && ending.status == Status::Completed);
    let unconverged: Vec<u64> = reports.iter().filter(|r| !r.converged).map(WindowReport::step).collect();
    assert_eq!((unconverged, ending.statistics.unconverged), (vec![4, 5], 2));
    assert!(reports.iter().all(WindowReport::is_accepted));

    let (reports, ending, failure) = case(false, true).run(mass(f64::cos), light_when_short());
    assert!(failure.is_none() && ending.status == Status::Completed, "{failure:?}");
    let taken: Vec<f64> = reports
        .iter()
        .filter(|r| r.is_accepted() && r.step() > 0)
        .map(|r| r.steps[0].communication_step)
        .collect();
    let quarters = taken.iter().filter(|h| (**h - 0.025).abs() < 1e-12).count();
    assert_eq!((taken.len(), quarters), (16, 8), "{taken:?}");
    let rejected: Vec<_> =
        reports.iter().filter(|r| !r.is_accepted()).map(|r| (r.step(), r.attempt)).collect();
    // Two quarters make a half, after which a half is tried again.
    assert_eq!(rejected, [(4, 1), (4, 2), (6, 1), (8, 1), (8, 2), (10, 1)]);
    assert_eq!(ending.statistics.rejected, 6);
    assert!((ending.time - 1.0).abs() < 1e-12);
    // States were restored: with every step converged the motion is that of one mass under one load.
    let last = reports.last().and_then(|r| r.accepted(DAM, r.step())).expect("the last step");
    assert!((last.outputs[1] - 1f64.cos() / (1.3 * MASS)).abs() < 1e-8);
}

/// In step 4 the second answer leaves the residual as it was but for 1e-11 of it: the secant through both points far beyond
/// all bounds. The step continues without its past.
#[test]
fn a_misled_quasi_newton_step_forgets_its_past_and_converges() {
    for kind in [AccelerationKind::IqnIls, AccelerationKind::InterfaceJacobian] {
        let mut first = None;
        let misleading = water(0.3 * MASS, move |at, p| {
            let a = -*p / (0.3 * MASS);
            let residual = *p - (MASS * a - at.end().cos());
            match (at.step, first) {
                (4, None) => first = Some((at.iteration, residual)),
                (4, Some((iteration, before))) if at.iteration == iteration + 1 => {
                    *p += before * (1.0 + 1e-11) - residual;
                }
                _ => {}
            }
        });
        let case = Case { acceleration: kind, relaxation: 0.9, ..Case::new(Stepping::equal(0.1, 8)) };
        let (reports, ending, failure) = case.run(mass(f64::cos), misleading);
        assert!(failure.is_none() && reports.iter().all(|report| report.converged), "{kind:?} {failure:?}");
        let given_up: Vec<u32> = reports.iter().map(|report| report.fallbacks).collect();
        assert_eq!((given_up[4], given_up.iter().sum::<u32>()), (1, 1), "{kind:?} {given_up:?}");
        assert_eq!(ending.statistics.fallbacks, 1);
        let last = reports.last().and_then(|r| r.accepted(DAM, r.step())).expect("the last step");
        assert!((last.outputs[1] - 0.8f64.cos() / (1.3 * MASS)).abs() < 1e-8);
    }
}

/// Water whose answer jumps across the fixed point: there is none, and a step ends when all have failed.
#[test]
fn a_step_without_a_fixed_point_tries_every_acceleration() {
    for (kind, expected) in [
        (AccelerationKind::InterfaceJacobian, 3),
        (AccelerationKind::IqnIls, 2),
        (AccelerationKind::Aitken, 0),
        (AccelerationKind::Constant, 0),
    ] {
        let jumping = water(0.3 * MASS, |at, p| {
            let solution = -0.3 / 1.3 * at.end().cos();
            if at.step == 4 {
                *p += if *p < solution { -1e-3 } else { 1e-3 };
            }
        });
        let case = Case { acceleration: kind, relaxation: 0.9, ..Case::new(Stepping::equal(0.1, 8)) };
        let (reports, _, failure) = case.run(mass(f64::cos), jumping);
        let failed = reports.last().expect("the step that failed");
        assert!(matches!(failure, Some(SimulationError::Coupling(_))), "{kind:?} {failure:?}");
        assert_eq!((failed.step(), failed.fallbacks), (4, expected), "{kind:?}");
    }
}

#[test]
fn steps_that_never_converge_are_not_halved_for_ever_and_divergence_is_never_gone_on_with() {
    let heavy = || water(40.0 * MASS, |_, _| ());
    let case = Case {
        stepping: Stepping { halve: true, ..Stepping::equal(0.1, 3) },
        ..Case::new(Stepping::equal(0.1, 3))
    };
    let (reports, _, failure) = case.run(mass(f64::cos), heavy());
    assert!(matches!(
        failure,
        Some(SimulationError::Coupling(CouplingError::Futile {
            why: IterationFailure::Diverging { .. },
            ..
        }))
    ));
    assert_eq!(reports.last().map(|r| (r.step(), r.attempt)), Some((1, 11)));
    let settings = Settings { accept_unconverged: true, ..Settings::default() };
    let (_, _, failure) =
        Case { settings, ..Case::new(Stepping::equal(0.1, 3)) }.run(mass(f64::cos), heavy());
    assert!(matches!(failure, Some(SimulationError::Coupling(CouplingError::Futile { .. }))));
}

#[test]
fn steps_follow_the_estimate_of_their_error() {
    // Slow at first, then ten times as fast.
    let load = |t: f64| if t < 5.0 { t.sin() } else { 5f64.sin() + (10.0 * (t - 5.0)).sin() };
    let adaptive = Adaptive { tolerance: 1e-3, shortest: 1e-4, longest: 1.0 };
    let case = Case::new(Stepping { adaptive: Some(adaptive), ..Stepping::equal(0.01, 1000) });
    let (reports, ending, failure) = case.run(mass(load), water(0.3 * MASS, |_, _| ()));
    assert!(failure.is_none(), "{failure:?}");
    assert!((ending.time - 10.0).abs() < 1e-9);
    let taken: Vec<_> = reports.iter().filter(|r| r.is_accepted() && r.step() > 0).collect();
    for report in &taken {
        let h = report.steps[0].communication_step;
        assert!(
            report.relative_interpolation_error().is_none_or(|e| e <= 1e-3) || h < 1.01e-4,
            "{:?}",
            report.steps
        );
    }
    let mean = |from: f64, to: f64| {
        let lengths: Vec<f64> = taken
            .iter()
            .map(|r| r.steps[0])
            .filter(|s| s.time > from && s.end() < to)
            .map(|s| s.communication_step)
            .collect();
        lengths.iter().sum::<f64>() / lengths.len() as f64
    };
    let (slow, fast) = (mean(1.0, 4.9), mean(6.0, 9.9));
    println!("{} steps in place of 1000, {:.3e} s long on the mean, then {:.3e} s", taken.len(), slow, fast);
    assert!((5.0..20.0).contains(&(slow / fast)) && taken.len() < 500, "{slow} {fast}");
    assert!(reports.iter().any(|r| !r.is_accepted()), "a step was started again when the load became fast");
}

#[test]
fn units_with_steps_of_one_length_are_not_asked_for_others() {
    let fixed = water(0.3 * MASS, |_, _| ()).of_one_length();
    let case = Case::new(Stepping { halve: true, ..Stepping::equal(0.1, 3) });
    let (reports, _, failure) = case.run(mass(f64::cos), fixed);
    let failure = failure.expect("it cannot be").to_string();
    assert!(failure.starts_with("reservoir takes communication steps of one length only"), "{failure}");
    assert!(reports.is_empty(), "nothing was asked of any unit");
}

#[test]
fn a_unit_that_freezes_is_named_and_one_that_never_answers_to_changes_is_let_be() {
    let mut last = 0.0;
    let freezing = water(0.3 * MASS, move |at, p| {
        if at.step < 30 {
            last = *p;
        }
        *p = last;
    });
    let (reports, _, failure) = Case::new(Stepping::equal(0.1, 100)).run(mass(f64::cos), freezing);
    let Some(SimulationError::Coupling(error)) = failure else { panic!("{failure:?}") };
    println!("{error}");
    assert!(
        matches!(&error, CouplingError::Frozen { participant, step: 49, steps: 20, .. } if participant == "reservoir")
    );
    assert_eq!(reports.last().map(WindowReport::step), Some(49));
    let still = SmallUnit::reservoir(1, (), vec![0.0], |(), _, _, answer| answer[0] = 3.0);
    let (_, ending, failure) = Case::new(Stepping::equal(0.1, 100)).run(mass(f64::cos), still);
    assert!(failure.is_none() && ending.status == Status::Completed, "{failure:?}");
}

#[test]
fn a_tolerance_beneath_the_rounding_floor_is_said_to_be_so() {
    // A pressure as if computed with few digits: its error changes with the last bits of the input.
    let coarse = water(0.3 * MASS, |_, p| *p += 1e-5 * f64::from((p.to_bits() % 7) as u8));
    let case = Case { tolerance: 1e-12, ..Case::new(Stepping::equal(0.1, 100)) };
    let (reports, _, failure) = case.run(mass(f64::cos), coarse);
    let failure = failure.expect("it cannot converge").to_string();
    println!("{failure}");
    assert!(failure.contains("stagnates at"), "{failure}");
    let floor = reports.last().and_then(|r| r.rounding_floor);
    assert!(floor.is_some_and(|floor| (1e-6..1e-4).contains(&floor)), "{floor:?}");
}

fn log_of_a_scene(path: &Path) -> LogWriter {
    let scene = cofferdam_assembly::read_scene(&root().join("scenes/rigid-dam-ramp"), &[])
        .expect("a shipped scene")
        .scene;
    let preamble = Preamble { scene: toml::to_string(&scene).expect("TOML"), ..Preamble::default() };
    LogWriter::create(path, &preamble).expect("a log")
}

/// The exchanges of an intact log.
fn logged_exchanges(path: &Path) -> Vec<LoggedExchange> {
    let entries: Result<Vec<Entry>, _> =
        Log::open(path).expect("a log").entries().expect("entries").collect();
    let exchange = |entry| if let Entry::Exchange(exchange) = entry { Some(exchange) } else { None };
    entries.expect("an intact log").into_iter().filter_map(exchange).collect()
}

/// A unit that fails where it is told to.
struct Failing {
    unit: Box<dyn Participant>,
    fails: fn(&Occasion) -> bool,
}

impl Participant for Failing {
    fn description(&self) -> &Description {
        self.unit.description()
    }
    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        self.unit.read(variable)
    }
    fn initialise(
        &mut self,
        start: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.unit.initialise(start, inputs, outputs)
    }
    fn step(&mut self, at: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        if (self.fails)(at) {
            let participant = self.description().name.clone();
            return Err(ParticipantError::Unit { participant, cause: "dry".into() });
        }
        self.unit.step(at, inputs, outputs)
    }
    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.unit.save_state()
    }
    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.unit.restore_state()
    }
}

/// A unit that ignores the request to restore its state.
struct Forgetful(SmallUnit<[f64; 2]>);

impl Participant for Forgetful {
    fn description(&self) -> &Description {
        self.0.description()
    }
    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        self.0.read(variable)
    }
    fn initialise(
        &mut self,
        start: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.0.initialise(start, inputs, outputs)
    }
    fn step(&mut self, at: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        self.0.step(at, inputs, outputs)
    }
    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.0.save_state()
    }
    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }
}

#[test]
fn a_unit_that_does_not_return_to_its_state_is_named_and_the_log_holds_both_answers() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.mcap");
    let mut log = log_of_a_scene(&path);
    let case = Case::new(Stepping::equal(0.1, 5));
    let (reports, _, failure) =
        case.run_with(Forgetful(mass(f64::cos)), water(0.3 * MASS, |_, _| ()), &mut [&mut log]);
    let failure = failure.expect("it cannot be coupled").to_string();
    println!("{failure}");
    assert!(
        failure.starts_with(
            "dam does not return to its saved state: restored and called with the same inputs in step 1"
        ),
        "{failure}"
    );
    let seen = reports.last().map_or(0, |r| r.exchanges.len());
    let logged = logged_exchanges(&path);
    assert_eq!(
        (logged.len(), seen),
        (2 + 6, 6),
        "initialisation, and the first step's first two iterations, and the last of them again"
    );
    assert!(logged.iter().all(|exchange| exchange.outputs.is_some()));
    let dam: Vec<_> = logged.iter().filter(|e| e.unit == DAM && e.occasion.step == 1).collect();
    assert!(dam[1].inputs == dam[2].inputs && dam[1].outputs != dam[2].outputs);
}

#[test]
fn an_attempt_that_is_not_accepted_leaves_no_trace() {
    let run = |twice: bool| {
        let mut graph =
            pair(Box::new(mass(f64::cos)), Box::new(water(0.3 * MASS, |_, _| ()))).expect("two units");
        let acceleration = Acceleration::new(AccelerationKind::Constant, 1.0, 1.0);
        let mut scheme = Scheme::new(
            &mut graph,
            Settings::default(),
            acceleration,
            Predictor::new(2),
            measure(1e-9),
            Vec::new(),
        )
        .expect("the units fit");
        scheme.initialise(&mut graph, 0.0).expect("they initialise");
        (1..20)
            .map(|step| {
                if twice {
                    let longer = Interval { communication_step: 0.13, ..interval(step, 0.1) };
                    scheme.attempt(&mut graph, &[longer], 1).expect("it converges");
                }
                let attempt = if twice { 2 } else { 1 };
                let mut report =
                    scheme.attempt(&mut graph, &[interval(step, 0.1)], attempt).expect("it converges");
                scheme.accept(&mut report);
                let bits = |side| {
                    let outputs =
                        report.accepted(side, step).map(|e| e.outputs.clone()).expect("it was taken");
                    outputs.into_iter().map(f64::to_bits).collect::<Vec<_>>()
                };
                (bits(DAM), bits(RESERVOIR))
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(run(false), run(true));
}

#[test]
fn an_implicit_scheme_that_may_not_iterate_is_refused() {
    let scheme = |kind| {
        let mut graph = pair(Box::new(mass(|_| 1.0)), Box::new(water(0.5, |_, _| ()))).expect("two units");
        let settings = Settings { kind, iteration_limit: 0, ..Settings::default() };
        let acceleration = Acceleration::new(AccelerationKind::Constant, 1.0, 1e-3);
        Scheme::new(&mut graph, settings, acceleration, Predictor::new(1), measure(1e-9), Vec::new()).err()
    };
    assert!(matches!(scheme(SchemeKind::SerialImplicit), Some(CouplingError::NoIteration)));
    assert!(scheme(SchemeKind::SerialExplicit).is_none(), "which never asks how often");
}

/// A unit without an input for a signal takes part as before; who has one receives it, with as many components as it has.
#[test]
fn a_unit_receives_the_signals_for_which_it_has_an_input_and_no_others() {
    let samples = vec![0.0, 1.0, -2.0, 4.0];
    let named = |input| Signal::new("a push", input, 0.1, samples.clone());
    for knows in [false, true] {
        let dam = if knows { mass(f64::cos) } else { mass(f64::cos).without_ground() };
        let reservoir = water(0.3 * MASS, |_, _| ());
        let mut graph = pair(Box::new(dam), Box::new(reservoir)).expect("two units");
        let acceleration = Acceleration::new(AccelerationKind::Constant, 1.0, 1e-3);
        let signals = vec![named(GROUND_ACCELERATION), named("wind")];
        let settings = Settings::default();
        let mut scheme =
            Scheme::new(&mut graph, settings, acceleration, Predictor::new(1), measure(1e-9), signals)
                .expect("no unit needs a signal");
        scheme.initialise(&mut graph, 0.0).expect("they initialise");
        for (step, sample) in (1..).zip(&samples[1..]) {
            let report = scheme.advance(&mut graph, &[interval(step, 0.1)]).expect("it converges");
            let received = |unit, known: usize| {
                let inputs = &report.accepted(unit, step).expect("it was taken").inputs;
                inputs[known..].to_vec()
            };
            let given = |values: Vec<f64>| match values[..] {
                [x, y] => (x - sample).abs() < 1e-12 && y == 0.0,
                _ => false,
            };
            let of_dam = received(DAM, 2);
            assert!(if knows { given(of_dam) } else { of_dam.is_empty() }, "step {step}");
            assert!(given(received(RESERVOIR, 1)), "step {step}");
        }
    }
}
