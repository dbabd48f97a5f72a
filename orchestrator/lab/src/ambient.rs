//! `cofferdam-lab ambient`.

mod figure;

use crate::study::{Arguments, StudyError, quoted, run_scene, unfit};
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::table::Table;
use cofferdam_motion::GroundMotion;
use cofferdam_scene::OnFailure;
use std::f64::consts::TAU;

pub const HELP: &str = "\
Simulates ten minutes of ambient vibration instead of the ground motion of the
scene: 400 sines from 0.2 to 20 Hz, 0.001 g in total. Prints, for every minute,
the stored energy, the works, the error of the dam's energy balance, and the
energy produced by the coupling.

Writes ambient.md, ambient.csv and ambient.svg. With --coarse, twenty seconds
instead of ten minutes.

Example:
  cofferdam-lab ambient scenes/koyna-coarse --output studies/ambient

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// Root mean square of the acceleration, m/s².
const STRENGTH: f64 = 0.001 * 9.81;
const SINES: u32 = 400;
const LOWEST: f64 = 0.2;
const HIGHEST: f64 = 20.0;
/// Interval of the samples, s.
const INTERVAL: f64 = 0.0025;

/// Sines at frequencies that are not multiples of each other, with phases spread by the golden ratio.
fn ambient(duration: f64) -> GroundMotion {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let sines: Vec<(f64, f64)> = (0..SINES)
        .map(|k| {
            let share = (f64::from(k) + (f64::from(k) * golden).fract()) / f64::from(SINES);
            let phase = (f64::from(k * k) * golden).fract();
            (TAU * (LOWEST + share * (HIGHEST - LOWEST)), TAU * phase)
        })
        .collect();
    let amplitude = STRENGTH * (2.0 / f64::from(SINES)).sqrt();
    // The amplitude rises within the first second.
    let at = |t: f64| amplitude * t.min(1.0) * sines.iter().map(|(w, p)| (w * t + p).sin()).sum::<f64>();
    let samples = (0..=(duration / INTERVAL).round() as u32).map(|i| at(f64::from(i) * INTERVAL)).collect();
    GroundMotion::of_samples("ambient vibration", INTERVAL, samples)
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    if loaded.scene.computed_dam().is_none() {
        return Err(unfit("the study needs a dam that is computed"));
    }
    let (duration, rows) = if arguments.coarse { (20.0, 4) } else { (600.0, 10) };
    let mut scene = loaded.scene.clone();
    (scene.time.duration, scene.coupling.on_failure) = (Some(duration), OnFailure::Stop);
    let outcome = run_scene(&scene, &ambient(duration), threads(None))?.completed("ambient vibration")?;
    let stored: Vec<f64> = ["dam.kinetic_energy", "dam.strain_energy", "dam.contact_energy"]
        .map(|name| outcome.column(name))
        .iter()
        .fold(Vec::new(), |sum: Vec<f64>, column| match sum.is_empty() {
            true => column.to_vec(),
            false => sum.iter().zip(*column).map(|(a, b)| a + b).collect(),
        });
    let names = [
        "dam.input_work",
        "dam.damping_work",
        "dam.friction_work",
        "dam.energy_balance_error",
        "interface_work",
        "interface_energy_produced",
    ];
    let mut table = Table::new([
        "until, s",
        "maximum stored",
        "input",
        "damping",
        "friction",
        "balance error",
        "work of the water",
        "produced by the coupling",
    ]);
    let count = stored.len().saturating_sub(1);
    for row in 1..=rows {
        let (from, to) = ((row - 1) * count / rows, row * count / rows);
        let most = stored[from..=to].iter().copied().fold(f64::MIN, f64::max);
        let values = names.map(|name| outcome.column(name)[to]);
        let cells = std::iter::once(most).chain(values).map(|value| format!("{value:.3e}"));
        table.row(std::iter::once(format!("{:.0}", outcome.column("time")[to])).chain(cells));
    }
    let text = format!(
        "`cofferdam-lab ambient {}{}`, J per metre of dam since the start\n\n{}\n\
         At most {:.1e} of the largest stored energy is missed by the dam's balance; the coupling produced {:.1e} of the work \
         that the water did. {:.2} dam steps per communication step, {:.0} s of wall time.\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
        outcome.peak("dam.energy_balance_error") / stored.iter().copied().fold(f64::MIN_POSITIVE, f64::max),
        outcome.peak("interface_energy_produced") / outcome.peak("interface_work").max(f64::MIN_POSITIVE),
        outcome.iterations(1),
        outcome.ending.wall.total.as_secs_f64(),
    );
    print(&text);
    arguments.write("ambient.md", &text)?;
    arguments.write_table("ambient.csv", &table)?;
    arguments.write("ambient.svg", &figure::picture(&outcome, &stored)?)
}
