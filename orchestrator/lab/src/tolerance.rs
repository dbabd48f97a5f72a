//! `cofferdam-lab tolerance`.

mod figure;

use crate::study::{Arguments, CREST, Outcome, SLIDING, StudyError, quoted, run_scene, unfit};
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::table::Table;
use cofferdam_coupling::convergence::Tolerance;
use cofferdam_scene::OnFailure;

pub const HELP: &str = "\
Runs the scene with tolerances from 1e-2 to 1e-12 and with the balanced
tolerance, and compares crest displacement and sliding with those of the
tightest tolerance. A run with half the communication step shows the error that
does not depend on the tolerance.

Writes tolerance.md, tolerance.csv and tolerance.svg.

Example:
  cofferdam-lab tolerance scenes/koyna-coarse --output studies/tolerance

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// The tightest tolerance: the others are compared with it.
const TIGHTEST: f64 = 1e-13;

/// A tolerance that is a number.
pub struct Point {
    pub tolerance: f64,
    /// Largest differences from the tightest over the largest value.
    pub crest: f64,
    pub sliding: f64,
    pub iterations: f64,
}

/// Points, and the errors of the communication step.
pub struct Series {
    pub points: Vec<Point>,
    pub of_step: [f64; 2],
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    if loaded.scene.dam.is_none() {
        return Err(unfit("the study needs a dam that is computed"));
    }
    if !loaded.scene.scheme().is_implicit() || loaded.scene.time.adaptive.is_some() {
        return Err(unfit("a tolerance matters to implicit schemes, and is compared at equal steps"));
    }
    let motion = &loaded.ground_motion;
    let solve = |tolerance: Tolerance, halvings: i32| -> Result<Outcome, StudyError> {
        let mut scene = loaded.scene.clone();
        scene.coupling.tolerance = tolerance;
        // The run continues where only rounding is left; the table gives the number of these steps.
        scene.coupling.on_failure = OnFailure::Continue;
        scene.time.communication_step /= 2f64.powi(halvings);
        let what = format!("ε = {tolerance}, H = {} s", scene.time.communication_step);
        let outcome = run_scene(&scene, motion, threads(None))?.completed(&what)?;
        print(format!(
            "{what}: {:.2} iterations, {:.1} s",
            outcome.iterations(1),
            outcome.ending.wall.total.as_secs_f64()
        ));
        Ok(outcome)
    };
    let reference = solve(TIGHTEST.into(), 0)?;
    let halved = solve(TIGHTEST.into(), 1)?;
    // Second order: half the step has a quarter of the error, so that the difference is three quarters of it.
    let of_step = [CREST, SLIDING].map(|name| {
        let every_second: Vec<f64> = halved.column(name).iter().copied().step_by(2).collect();
        4.0 / 3.0 * difference(reference.column(name), &every_second)
    });
    let exponents: Vec<i32> = if arguments.coarse { vec![2, 4, 6, 8] } else { (2..=12).collect() };
    let mut points = Vec::new();
    let mut table = Table::new([
        "ε",
        "dam steps per communication step",
        "steps remaining above ε",
        "wall time, s",
        "crest",
        "sliding",
    ]);
    let numbers = exponents.into_iter().map(|exponent| Tolerance::Relative(10f64.powi(-exponent)));
    for tolerance in std::iter::once(Tolerance::Balanced).chain(numbers) {
        let outcome = solve(tolerance, 0)?;
        let [crest, sliding] =
            [CREST, SLIDING].map(|name| difference(outcome.column(name), reference.column(name)));
        let iterations = outcome.iterations(1);
        table.row([
            tolerance.to_string(),
            format!("{iterations:.2}"),
            outcome.ending.statistics.unconverged.to_string(),
            format!("{:.1}", outcome.ending.wall.total.as_secs_f64()),
            format!("{crest:.1e}"),
            format!("{sliding:.1e}"),
        ]);
        if let Tolerance::Relative(tolerance) = tolerance {
            points.push(Point { tolerance, crest, sliding, iterations });
        }
    }
    let step = loaded.scene.time.communication_step;
    let text = format!(
        "`cofferdam-lab tolerance {}{}`: largest difference from ε = {TIGHTEST:e} over the largest value\n\n{}\n\
         The communication step itself, H = {step} s: crest {:.1e}, sliding {:.1e} (4/3 of the difference from H/2), for every ε. \
         The run's own estimate of its coupling error: {:.1e} at most. {} steps of the reference remain above its tolerance.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
        of_step[0],
        of_step[1],
        reference.peak("interpolation_error") / reference.ending.statistics.largest.max(f64::MIN_POSITIVE),
        reference.ending.statistics.unconverged,
    );
    print(&text);
    arguments.write("tolerance.md", &text)?;
    arguments.write_table("tolerance.csv", &table)?;
    arguments.write("tolerance.svg", &figure::picture(&Series { points, of_step })?)
}

/// Largest difference over the largest value; 0 without values.
fn difference(values: &[f64], reference: &[f64]) -> f64 {
    let largest = reference.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let apart = values.iter().zip(reference).fold(0.0, |a: f64, (x, y)| a.max((x - y).abs()));
    if largest > 0.0 { apart / largest } else { 0.0 }
}
