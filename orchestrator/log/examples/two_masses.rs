//! Two masses joined by a spring, each a unit of its own: coupled, logged, replayed and compared.
//! ```text
//! left mass  ── position ──→  spring + right mass        m₁ ẍ₁ = f,   m₂ ẍ₂ = −f,   f = k (x₂ − x₁)
//!            ←─── force ────
//! ```
//! Where the right mass starts at 1 m/s, x₂ − x₁ = sin(ωt)/ω with ω² = k (1/m₁ + 1/m₂).
//! Run it with `cargo run --release -p cofferdam-log --example two_masses`.

use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
use cofferdam_coupling::participant::{FunctionUnit, Occasion, Participant};
use cofferdam_coupling::scheme::{
    Direction, Field, Graph, Interface, Port, Predictor, Scheme, Settings, UnitId,
};
use cofferdam_coupling::simulation::Simulation;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_log::replay::replay;
use cofferdam_log::{Entry, Log, LogWriter, Preamble, compare};
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const MASSES: [f64; 2] = [2.0, 3.0];
const STIFFNESS: f64 = 500.0;
const STEP: f64 = 1e-3;

type Unit = Result<Box<dyn Participant>, Box<dyn Error>>;

/// Position, velocity, force; the force is linear over a step.
fn left() -> Unit {
    let step = |[x, v, f]: &mut [f64; 3], occasion: &Occasion, u: &[f64], y: &mut [f64]| {
        let h = occasion.communication_step;
        *x += h * *v + h * h * (2.0 * *f + u[0]) / (6.0 * MASSES[0]);
        *v += h * (*f + u[0]) / (2.0 * MASSES[0]);
        (*f, y[0]) = (u[0], *x);
    };
    Ok(Box::new(FunctionUnit::new("left", &[("force", "N")], &[("position", "m")], [0.0; 3], step)?))
}

/// Position, velocity, acceleration by the trapezoidal rule; the force of the spring is implicit.
fn right() -> Unit {
    let step = |[x, v, a]: &mut [f64; 3], occasion: &Occasion, u: &[f64], y: &mut [f64]| {
        let h = occasion.communication_step;
        let free = *x + h * *v + h * h / 4.0 * *a;
        y[0] = STIFFNESS * (free - u[0]) / (1.0 + STIFFNESS * h * h / (4.0 * MASSES[1]));
        let after = -y[0] / MASSES[1];
        *x = free + h * h / 4.0 * after;
        *v += h / 2.0 * (*a + after);
        *a = after;
    };
    Ok(Box::new(FunctionUnit::new("right", &[("position", "m")], &[("force", "N")], [0.0, 1.0, 0.0], step)?))
}

/// Runs 2 s with this tolerance and logs every exchange.
fn run(path: &Path, tolerance: f64) -> Result<(), Box<dyn Error>> {
    let fields = vec![
        Field::new(Direction::Forward, "position", "position"),
        Field::new(Direction::Backward, "force", "force"),
    ];
    let interface = Interface::new(Port::of(UnitId(0)), Port::of(UnitId(1)), fields);
    let mut graph = Graph::new(vec![left()?, right()?], vec![interface])?;
    let scales = Scales { typical: STIFFNESS * 0.01, ..Scales::default() };
    let measure = ConvergenceMeasure::new(&[Measure::Relative], tolerance, scales);
    let acceleration = Acceleration::new(AccelerationKind::IqnIls, 0.5, 1.0);
    let settings = Settings::default();
    let scheme = Scheme::new(&mut graph, settings, acceleration, Predictor::new(2), measure, Vec::new())?;
    let scene = format!("title = \"two masses\"\ntolerance = {tolerance}\n");
    let mut log = LogWriter::create(path, &Preamble { scene, ..Preamble::default() })?;
    let mut simulation = Simulation::new(graph, scheme, Stepping::equal(STEP, 2000));
    let (ending, failure) = simulation.run(&mut [&mut log], &AtomicBool::new(false));
    println!("{}: {} at t = {} s", path.display(), ending.status, ending.time);
    failure.map_or(Ok(()), |error| Err(error.into()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let paths = ["tight.mcap", "loose.mcap"].map(|name| folder.path().join(name));
    run(&paths[0], 1e-10)?;
    run(&paths[1], 1e-3)?;
    let logs = [Log::open(&paths[0])?, Log::open(&paths[1])?];
    let (omega, mut error) = ((STIFFNESS * (1.0 / MASSES[0] + 1.0 / MASSES[1])).sqrt(), 0f64);
    for entry in logs[0].entries()? {
        let Entry::Exchange(exchange) = entry? else { continue };
        if exchange.accepted && exchange.unit == UnitId(0) {
            let exact = (omega * exchange.occasion.end()).sin();
            error = error.max((exchange.inputs[0] * omega / STIFFNESS - exact).abs());
        }
    }
    println!("largest error of the spring's force: {error:.1e} of its amplitude");
    for (id, mut unit) in [left()?, right()?].into_iter().enumerate() {
        let replayed = replay(&logs[0], UnitId(id), &mut *unit, |_| ())?;
        println!(
            "unit {id}: {} exchanges replayed identically, {:?}",
            replayed.identical, replayed.divergence
        );
    }
    println!("the two runs are identical: {}", compare([&logs[0], &logs[1]])?.identical());
    if error < 1e-3 { Ok(()) } else { Err("the spring is wrong".into()) }
}
