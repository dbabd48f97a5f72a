//! A step of the reservoir of `koyna-coarse` in this process, built in and as the FMU that `cofferdam export-fmu` packs of it, in turn:
//! `cargo bench -p cofferdam-assembly --bench fmu_step`. A step is as in an iteration: return to the saved state, inputs, step,
//! outputs. The program must have been built (`cargo build --release`).

use cofferdam_assembly::units::RESERVOIR;
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_coupling::participant::{Occasion, Participant};
use std::error::Error;
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const STEPS: u64 = 2_000;
const TRIES: usize = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).ok_or("no folder")?;
    let scene = root.join("scenes/koyna-coarse");
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("water.fmu");
    let mut export = Command::new(root.join("target/release/cofferdam"));
    let method = "reservoir.method=recursive";
    export.args(["export-fmu", "--unit", "reservoir", "--set", method, "--output"]).arg(&file).arg(&scene);
    if !export.output()?.status.success() {
        return Err("the FMU cannot be packed; build the program first".into());
    }
    let fmu = [
        method.to_owned(),
        "reservoir.fidelity=fmu".to_owned(),
        format!("reservoir.fmu.file={}", file.display()),
    ];
    let made = |set: &[String]| -> Result<Box<dyn Participant>, Box<dyn Error>> {
        let loaded = read_scene(&scene, set).map_err(|error| format!("{error:?}"))?;
        Ok(Assembly::with(&loaded.scene, NonZeroUsize::MIN).unit(RESERVOIR)?)
    };
    let mut units = [("built in", made(&fmu[..1])?), ("FMU", made(&fmu)?)];
    for (_, unit) in &mut units {
        let [inputs, mut outputs] =
            [&unit.description().inputs, &unit.description().outputs].map(|layout| vec![0.0; layout.size()]);
        unit.initialise(0.0, &inputs, &mut outputs)?;
    }
    let mut times: [Vec<Duration>; 2] = [Vec::new(), Vec::new()];
    let mut answers = [Vec::new(), Vec::new()];
    for step in 1..=STEPS {
        for (number, (_, unit)) in units.iter_mut().enumerate() {
            let mut inputs = vec![0.0; unit.description().inputs.size()];
            inputs.iter_mut().enumerate().for_each(|(i, a)| *a = (0.01 * (step as f64) + i as f64).sin());
            let mut outputs = vec![0.0; unit.description().outputs.size()];
            let (time, communication_step) = (0.0025 * (step - 1) as f64, 0.0025);
            let occasion = Occasion { step, iteration: 1, attempt: 1, time, communication_step };
            unit.save_state()?;
            for _ in 0..TRIES {
                let began = Instant::now();
                unit.restore_state()?;
                unit.step(&occasion, &inputs, &mut outputs)?;
                times[number].push(began.elapsed());
            }
            answers[number] = outputs;
        }
    }
    assert!(answers[0] == answers[1], "the two are the same unit");
    for ((name, _), times) in units.iter().zip(&mut times) {
        times.sort();
        let part = |share: f64| times[(share * times.len() as f64) as usize].as_secs_f64() * 1e6;
        println!(
            "{name:<10} median {:.2} µs, quartiles {:.2} and {:.2} µs",
            part(0.5),
            part(0.25),
            part(0.75)
        );
    }
    Ok(())
}
