//! Small units whose plain coupling iteration diverges, or which give wrong answers: which schemes converge, and the
//! messages of those that do not.
//!
//! A body of unit mass on a spring, and a fluid that answers its acceleration with the inertia of `ratio` masses:
//! `p = −ratio (a + coupling of neighbours)`. Gauss–Seidel multiplies an error by some 1.5 ratio in every iteration.

use cofferdam_assembly::units::pair;
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, IterationFailure, Measure, Scales};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::scheme::{CouplingError, Predictor, Scheme, Settings, StepFailure};
use whole_chain::small_unit::SmallUnit;
use whole_chain::small_unit::interval;

const POINTS: usize = 6;
const STEP: f64 = 0.01;

/// Displacement and velocity of the bodies.
type Bodies = [[f64; 2]; POINTS];

/// Bodies on springs of different stiffness, pushed by p and a load; implicit Euler.
fn bodies() -> SmallUnit<Bodies> {
    SmallUnit::dam(
        POINTS,
        [[0.0; 2]; POINTS],
        vec![0.0; 2 * POINTS],
        |state: &mut Bodies, at, inputs, outputs| {
            for (i, [u, v]) in state.iter_mut().enumerate() {
                let stiffness = 100.0 * (i + 1) as f64;
                let load = (7.0 * at.end() + i as f64).sin();
                let v_end =
                    (*v + STEP * (load + inputs[i] - stiffness * *u)) / (1.0 + STEP * STEP * stiffness);
                let acceleration = (v_end - *v) / STEP;
                (*u, *v) = (*u + STEP * v_end, v_end);
                (outputs[i], outputs[POINTS + i]) = (*u, acceleration);
            }
        },
    )
}

/// A fluid of `ratio` times the bodies' mass; `spoil` may change its answers.
fn fluid(ratio: f64, mut spoil: impl FnMut(u64, u32, &mut [f64]) + Send + 'static) -> SmallUnit<()> {
    SmallUnit::reservoir(POINTS, (), vec![0.0; POINTS], move |(), at, inputs, outputs| {
        for i in 0..POINTS {
            let beside = [i.wrapping_sub(1), i + 1].map(|j| if j < POINTS { inputs[j] } else { 0.0 });
            outputs[i] = -ratio * (inputs[i] + 0.3 * (beside[0] + beside[1]));
        }
        spoil(at.step, at.iteration, outputs);
    })
}

/// Iterations of 40 steps, up to the first failure.
fn run(kind: AccelerationKind, relaxation: f64, fluid: SmallUnit<()>) -> Result<Vec<u32>, StepFailure> {
    let mut graph = pair(Box::new(bodies()), Box::new(fluid)).expect("two units");
    let measure = ConvergenceMeasure::new(
        &[Measure::Relative],
        1e-9,
        Scales { typical: 0.1, bound: 1e12, ..Scales::default() },
    );
    let acceleration = Acceleration::new(kind, relaxation, 1e-3);
    let mut scheme =
        Scheme::new(&mut graph, Settings::default(), acceleration, Predictor::new(2), measure, Vec::new())
            .expect("the units fit");
    scheme.initialise(&mut graph, 0.0)?;
    (1..=40).map(|step| Ok(scheme.advance(&mut graph, &[interval(step, STEP)])?.iterations())).collect()
}

fn mean(counts: &[u32]) -> f64 {
    f64::from(counts.iter().sum::<u32>()) / counts.len() as f64
}

#[test]
fn a_heavy_fluid_takes_two_iterations_with_a_measured_jacobian_and_few_with_iqn_ils()
-> Result<(), StepFailure> {
    for ratio in [0.01, 0.5, 5.0, 26.0, 1000.0] {
        let sound = || fluid(ratio, |_, _, _| {});
        let newton = run(AccelerationKind::InterfaceJacobian, 0.5, sound())?;
        let iqn = run(AccelerationKind::IqnIls, 0.1 / ratio.max(1.0), sound())?;
        println!(
            "ratio {ratio}: interface Jacobian {:.2} ({} in the first step), IQN-ILS {:.2} dam steps per communication step",
            mean(&newton[1..]),
            newton[0],
            mean(&iqn)
        );
        // Two, one per point for the Jacobian, one for the states, one for the rounding floor.
        assert_eq!(newton[0], POINTS as u32 + 4);
        assert!(mean(&newton[1..]) <= 2.1, "{newton:?}");
        assert!(mean(&iqn) <= 5.0, "{iqn:?}");
    }
    Ok(())
}

#[test]
fn a_probe_never_counts_as_converged() -> Result<(), StepFailure> {
    let mut graph = pair(Box::new(bodies()), Box::new(fluid(5.0, |_, _, _| {}))).expect("two units");
    let measure = ConvergenceMeasure::new(
        &[Measure::Change],
        1.0,
        Scales { change: 1e9, bound: 1e12, ..Scales::default() },
    );
    let acceleration = Acceleration::new(AccelerationKind::InterfaceJacobian, 0.5, 1e-3);
    let settings = Settings { iteration_limit: 3, ..Settings::default() };
    let mut scheme = Scheme::new(&mut graph, settings, acceleration, Predictor::new(0), measure, Vec::new())
        .expect("the units fit");
    scheme.initialise(&mut graph, 0.0)?;
    let report = scheme.advance(&mut graph, &[interval(1, STEP)])?;
    assert_eq!(
        report.iterations(),
        POINTS as u32 + 4,
        "the measurement is finished; its iterations have no limit"
    );
    Ok(())
}

#[test]
fn what_diverges_stagnates_or_leaves_all_bounds_is_named_in_its_step() {
    let failure = |relaxation, spoiled: SmallUnit<()>| {
        let failure = run(AccelerationKind::Constant, relaxation, spoiled).expect_err("it cannot converge");
        println!("{failure}");
        (failure.report.step(), failure.error)
    };
    let (step, error) = failure(1.0, fluid(26.0, |_, _, _| {}));
    assert_eq!(step, 1);
    assert!(
        matches!(error, CouplingError::Futile { why: IterationFailure::Diverging { .. }, .. }),
        "{error}"
    );
    // Its answers alternate by 1e-3 from step 7 on.
    let noisy =
        fluid(0.1, |step, iteration, p| p[0] += if step > 6 { 1e-3 * f64::from(iteration % 2) } else { 0.0 });
    let (step, error) = failure(1.0, noisy);
    assert_eq!(step, 7);
    assert!(
        matches!(error, CouplingError::Futile { why: IterationFailure::Stagnating { .. }, .. }),
        "{error}"
    );
    let huge = fluid(0.1, |step, _, p| {
        if step > 3 {
            p[2] = -1e13
        }
    });
    let (step, error) = failure(0.5, huge);
    assert_eq!(step, 4);
    assert!(
        matches!(error, CouplingError::Futile { why: IterationFailure::Unbounded { .. }, .. }),
        "{error}"
    );
}

#[test]
fn a_unit_that_answers_nan_is_named_with_step_and_iteration_and_what_it_answered_before_is_kept() {
    for (iteration, blown_up) in [(1, false), (2, true)] {
        let spoiled = fluid(0.1, move |step, i, p| {
            if (step, i) == (5, iteration) {
                p[3] = f64::NAN
            }
        });
        let failure = run(AccelerationKind::Constant, 1.0, spoiled).expect_err("NaN is no answer");
        println!("{failure}");
        let report = &failure.report;
        assert_eq!((report.step(), report.iterations()), (5, iteration));
        assert_eq!(report.exchanges.len(), 2 * iteration as usize, "both sides are there");
        assert!(report.exchanges.last().is_some_and(|e| e.outputs[3].is_nan()), "what it answered is kept");
        assert_eq!(matches!(failure.error, CouplingError::Diverged { .. }), blown_up);
        let named = ParticipantError::NonFinite {
            participant: "reservoir".to_owned(),
            variable: "interface_pressure".to_owned(),
            index: 3,
            value: f64::NAN,
            time: 0.05,
        };
        assert!(failure.to_string().contains(&named.to_string()), "{failure}");
    }
}
