//! Two masses on springs, joined by a stiff one, as two units: what the scheme and the inputs within a step cost.
//!
//! ```text
//! wall ─k─ m ──κ── m ─k─ wall      m = 1 kg, k = 10 N/m, κ = 200 N/m; the left mass starts with 1 m/s
//! ```
//!
//! The left mass takes the force of the joining spring and answers with its motion; the right one takes the motion of
//! the left, has the joining spring, and answers with the force. Either solves its own part exactly. Modes:
//! both masses together, ω₁² = k/m, and against each other, ω₂² = (k + 2κ)/m.

use cofferdam_assembly::units::{DAM, pair};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
use cofferdam_coupling::scheme::{Predictor, Scheme, SchemeKind, Settings, StepFailure};
use whole_chain::small_unit::{SmallUnit, interval};

const WALL: f64 = 10.0;
const JOINT: f64 = 200.0;
const END: f64 = 2.0;

/// How an input varies over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Inputs {
    /// Its value at the step's end all the time.
    Held,
    /// Linear from start to end: the force, and the velocity.
    Linear,
}

/// Displacement of the left mass.
fn exact(time: f64) -> f64 {
    let [together, against] = [WALL, WALL + 2.0 * JOINT].map(f64::sqrt);
    0.5 * ((together * time).sin() / together + (against * time).sin() / against)
}

/// `u″ = −stiffness u + f₀ + f₁ s + f₂ s²` over `h`, in closed form: a free vibration, and the responses to the powers of s. (A
/// parabola and a vibration about it would lose digits of the velocity, and the iteration its floor.)
fn integrate([u, v]: &mut [f64; 2], stiffness: f64, h: f64, [f0, f1, f2]: [f64; 3]) {
    let omega = stiffness.sqrt();
    let (sin, cos) = (omega * h).sin_cos();
    let step = 2.0 * (omega * h / 2.0).sin().powi(2) / stiffness;
    let ramp = (h - sin / omega) / stiffness;
    let parabola = (h * h - 2.0 * step) / stiffness;
    let (before, rate) = (*u, *v);
    *u = before * cos + rate * sin / omega + f0 * step + f1 * ramp + f2 * parabola;
    *v = rate * cos - before * omega * sin + f0 * sin / omega + f1 * step + f2 * 2.0 * ramp;
}

/// Force, displacement and velocity.
fn left(inputs: Inputs) -> SmallUnit<(f64, [f64; 2])> {
    SmallUnit::dam(1, (0.0, [0.0, 1.0]), vec![0.0; 2], move |(before, motion), at, given, answer| {
        let (h, from, to) = (at.communication_step, *before, given[0]);
        let velocity = motion[1];
        let force = if inputs == Inputs::Held { [to, 0.0, 0.0] } else { [from, (to - from) / h, 0.0] };
        integrate(motion, WALL, h, force);
        *before = to;
        (answer[0], answer[1]) = (motion[0], (motion[1] - velocity) / h);
    })
}

/// Motion of the left mass as it is told, and of the right one.
fn right(inputs: Inputs) -> SmallUnit<([f64; 2], [f64; 2])> {
    SmallUnit::reservoir(1, ([0.0, 1.0], [0.0; 2]), vec![0.0], move |(told, own), at, given, answer| {
        let (h, [u, v], a) = (at.communication_step, *told, given[0]);
        let to = u + h * (v + h * a / 2.0);
        let place = if inputs == Inputs::Held { [to, 0.0, 0.0] } else { [u, v, a / 2.0] };
        integrate(own, WALL + JOINT, h, place.map(|of_power| JOINT * of_power));
        *told = [to, v + a * h];
        answer[0] = JOINT * (own[0] - to);
    })
}

/// Largest error of the left mass's displacement over its largest displacement, and the largest of the estimates.
fn error(
    kind: SchemeKind,
    inputs: Inputs,
    order: usize,
    window: usize,
    h: f64,
) -> Result<[f64; 2], StepFailure> {
    let mut graph = pair(Box::new(left(inputs)), Box::new(right(inputs))).expect("two units");
    let measure = ConvergenceMeasure::new(
        &[Measure::Relative],
        1e-12,
        Scales { typical: 1000.0, bound: 1e9, ..Scales::default() },
    );
    let acceleration = Acceleration::new(AccelerationKind::IqnIls, 0.1, 1.0);
    let settings = Settings { kind, ..Settings::default() };
    let mut scheme =
        Scheme::new(&mut graph, settings, acceleration, Predictor::new(order), measure, Vec::new())
            .expect("the units fit");
    scheme.initialise(&mut graph, 0.0)?;
    let steps: Vec<_> = (1..=(END / h).round() as u64).map(|step| interval(step, h)).collect();
    let mut worst = [0.0f64; 2];
    for steps in steps.chunks(window) {
        let report = scheme.advance(&mut graph, steps)?;
        for step in steps {
            let u = report.accepted(DAM, step.step).expect("it was taken").outputs[0];
            worst[0] = worst[0].max((u - exact(step.end())).abs());
        }
        worst[1] = worst[1].max(report.relative_interpolation_error().unwrap_or(0.0));
    }
    let largest = (0..2000).map(|i| exact(END * f64::from(i) / 2000.0).abs()).fold(0.0, f64::max);
    Ok([worst[0] / largest, worst[1]])
}

/// The observed order between steps of 1 and 0.5 ms.
fn order(errors: impl Fn(f64) -> f64) -> f64 {
    (errors(0.001) / errors(0.0005)).log2()
}

#[test]
fn what_is_converged_with_linear_inputs_is_of_second_order_and_the_rest_of_first() {
    use SchemeKind::{ParallelExplicit, ParallelImplicit, SerialExplicit, SerialImplicit};
    let ways = [
        ("explicit, held, serial", SerialExplicit, Inputs::Held, 0, 1.0),
        ("explicit, held, parallel", ParallelExplicit, Inputs::Held, 0, 1.0),
        ("explicit, linear, extrapolated by order 1, serial", SerialExplicit, Inputs::Linear, 1, 2.0),
        ("explicit, linear, extrapolated by order 2, serial", SerialExplicit, Inputs::Linear, 2, 2.0),
        ("converged, held", SerialImplicit, Inputs::Held, 2, 1.0),
        ("converged, linear", SerialImplicit, Inputs::Linear, 2, 2.0),
        ("converged, linear, parallel", ParallelImplicit, Inputs::Linear, 2, 2.0),
    ];
    let lengths = [1e-4, 1e-3, 2e-3, 4e-3, 1e-2, 2e-2, 5e-2, 1e-1];
    println!("| way | {} | order |", lengths.map(|h| format!("H = {h} s")).join(" | "));
    let mut at_a_millisecond = Vec::new();
    for (name, kind, inputs, extrapolation, expected) in ways {
        let of = |h: f64| match error(kind, inputs, extrapolation, 1, h) {
            Ok([error, _]) => error,
            Err(failure) => panic!("{name}, H = {h}: {failure}"),
        };
        let errors = lengths.map(|h| format!("{:.1e}", of(h)));
        let order = order(of);
        println!("| {name} | {} | {order:.2} |", errors.join(" | "));
        assert!((order - expected).abs() < 0.15, "{name}: {order}");
        at_a_millisecond.push(of(1e-3));
    }
    let [.., held, linear, parallel] = at_a_millisecond[..] else { unreachable!("seven ways") };
    println!("converged at 1 ms: held inputs are {:.0} times less accurate than linear ones", held / linear);
    assert!(held > 100.0 * linear);
    assert!((linear / parallel - 1.0).abs() < 1e-4, "Jacobi's fixed point is Gauss and Seidel's");
}

#[test]
fn windows_of_several_steps_converge_to_the_same() -> Result<(), StepFailure> {
    let [alone, _] = error(SchemeKind::SerialImplicit, Inputs::Linear, 1, 1, 0.004)?;
    for kind in [SchemeKind::SerialImplicit, SchemeKind::ParallelImplicit] {
        for window in [2, 5, 20] {
            let [together, _] = error(kind, Inputs::Linear, 1, window, 0.004)?;
            println!("{kind:?}, windows of {window}: error {together:.6e}, step by step {alone:.6e}");
            assert!((together / alone - 1.0).abs() < 1e-6);
        }
    }
    Ok(())
}

#[test]
fn the_estimate_of_the_coupling_error_falls_as_the_error_does() -> Result<(), StepFailure> {
    let of = |h: f64| error(SchemeKind::SerialImplicit, Inputs::Linear, 2, 1, h);
    for h in [0.02, 0.01, 0.005, 0.0025] {
        let [error, estimate] = of(h)?;
        println!("H = {h} s: error {error:.2e}, estimate {estimate:.2e}, ratio {:.2}", error / estimate);
        assert!((1.7..1.85).contains(&(error / estimate)), "the same share of it at every H");
    }
    Ok(())
}
