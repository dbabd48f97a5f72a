//! Vertical ground motion, from the scene to the log, the tables and the reports.

use crate::log::{cofferdam, text};
use cofferdam_assembly::log::ground_motion_of;
use cofferdam_assembly::packing::{Coupled, CoupledParameters};
use cofferdam_assembly::read_scene;
use cofferdam_log::{Entry, Log};
use cofferdam_unit::variables::coupled as variables;
use cofferdam_unit::{CoSimulation, Packable};
use std::num::NonZeroUsize;
use std::path::Path;
use toml::{Table, Value};
use whole_chain::peak;
use whole_chain::scenario::{Histories, Scenario, root};

const DEPTH: f64 = 100.0;
const SOUND_SPEED: f64 = 1440.0;
const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.80665;
/// Factor on the shipped record.
const SHARE: f64 = 2.0 / 3.0;

fn table(pairs: &[(&str, Value)]) -> Value {
    Value::Table(pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect::<Table>())
}

/// The shipped record: interval (s) and accelerations (g).
fn record() -> (f64, Vec<f64>) {
    let path = root().join("scenes/records/northridge-1994-canyon-country-270.csv");
    let content = std::fs::read_to_string(path).expect("a shipped record");
    let rows = content.lines().filter_map(|line| {
        let (time, value) = line.split_once(',')?;
        Some((time.parse::<f64>().ok()?, value.parse::<f64>().ok()?))
    });
    let (times, values): (Vec<f64>, Vec<f64>) = rows.unzip();
    (times[1] - times[0], values)
}

/// An acceleration that is linear between its samples, with its integrals from rest.
struct Motion {
    interval: f64,
    /// Acceleration, velocity and displacement at the samples.
    samples: Vec<[f64; 3]>,
}

impl Motion {
    /// The share of the record in m/s², which ends at zero.
    fn of_record() -> Self {
        let (interval, values) = record();
        let mut samples: Vec<[f64; 3]> = Vec::new();
        for a in values.iter().map(|g| SHARE * GRAVITY * g).chain([0.0]) {
            let next = match samples.last() {
                Some(&last) => {
                    [a, after(last, a, interval, interval)[0], after(last, a, interval, interval)[1]]
                }
                None => [a, 0.0, 0.0],
            };
            samples.push(next);
        }
        Self { interval, samples }
    }

    /// Velocity and displacement; zero before time 0.
    fn at(&self, time: f64) -> [f64; 2] {
        if time <= 0.0 {
            return [0.0; 2];
        }
        let index = ((time / self.interval).floor() as usize).min(self.samples.len() - 1);
        let next = self.samples.get(index + 1).map_or(0.0, |next| next[0]);
        after(self.samples[index], next, self.interval, time - index as f64 * self.interval)
    }
}

/// Velocity and displacement `dt` after a sample, when the acceleration goes to `next` in `interval`.
fn after([a, v, u]: [f64; 3], next: f64, interval: f64, dt: f64) -> [f64; 2] {
    let slope = (next - a) / interval;
    let velocity = v + a * dt + slope * dt * dt / 2.0;
    [velocity, u + v * dt + a * dt * dt / 2.0 + slope * dt.powi(3) / 6.0]
}

/// Pressure at the bed and force on the face: plane waves between the bed, whose reflections have the factor α, and the surface.
///
/// ```text
/// p(ξ, t) = ρc (1 + α)/2 Σ (−α)ⁿ [v(t − (h − ξ + 2nh)/c) − v(t − (h + ξ + 2nh)/c)]
/// F(t)    = ρc² (1 + α)/2 Σ (−α)ⁿ [u(t − 2nh/c) − 2u(t − (2n + 1)h/c) + u(t − (2n + 2)h/c)]
/// ```
fn closed_form(motion: &Motion, alpha: f64, time: f64) -> [f64; 2] {
    let crossing = DEPTH / SOUND_SPEED;
    let (mut pressure, mut force, mut factor) = (0.0, 0.0, (1.0 + alpha) / 2.0);
    for n in (0..).map(|n| 2.0 * f64::from(n)).take_while(|n| n * crossing < time) {
        let [now, one, two] = [n, n + 1.0, n + 2.0].map(|n| motion.at(time - n * crossing));
        pressure += factor * (now[0] - two[0]);
        force += factor * (now[1] - 2.0 * one[1] + two[1]);
        factor *= -alpha;
    }
    [DENSITY * SOUND_SPEED * pressure, DENSITY * SOUND_SPEED.powi(2) * force]
}

/// A rigid vertical dam that the record lifts; its horizontal component is zero and in the same file.
fn lifted(alpha: f64, step: f64) -> Scenario {
    let mut scenario = Scenario::shipped("rigid-dam-ramp");
    let (interval, values) = record();
    let rows = values.iter().enumerate().map(|(i, g)| format!("{:.2},0,{g}\n", i as f64 * interval));
    let rows = "time_s,still [m/s2],up [g]\n".to_owned() + &rows.collect::<String>();
    std::fs::write(scenario.folder().join("both.csv"), rows).expect("the record is written");
    let motion = [
        ("record", table(&[("file", "both.csv".into())])),
        ("vertical", table(&[("column", 2.into()), ("scale", SHARE.into())])),
    ];
    scenario.set("ground_motion", table(&motion)).set("time.duration", 20.0);
    scenario.set("time.communication_step", step).set("prescribed.panels", 32);
    scenario.set("reservoir.depth", DEPTH).set("reservoir.wave_reflection_coefficient", alpha);
    scenario
}

/// Largest deviations of base pressure and force from the closed form over their peaks, and their extremes.
fn deviations(histories: &Histories, alpha: f64) -> ([f64; 2], [[f64; 2]; 2]) {
    let motion = Motion::of_record();
    let time = histories.column("time");
    let (mut errors, mut extremes) = ([0.0; 2], [[0.0; 2]; 2]);
    for (axis, name) in ["reservoir.base_pressure", "reservoir.total_force"].into_iter().enumerate() {
        let found = histories.column(name);
        let exact: Vec<f64> = time.iter().map(|time| closed_form(&motion, alpha, *time)[axis]).collect();
        let off: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| a - b).collect();
        errors[axis] = peak(&off) / peak(&exact);
        extremes[axis] = [f64::max, f64::min].map(|most| found.iter().copied().fold(0.0, most));
    }
    (errors, extremes)
}

#[test]
fn a_rigid_dam_that_is_lifted_follows_the_closed_form() -> Result<(), Box<dyn std::error::Error>> {
    // Extremes of base pressure (Pa) and force (N/m).
    let cases = [
        (0.75, [[5.75423e5, -3.64094e5], [3.28213e7, -2.32462e7]]),
        (0.5, [[4.83237e5, -2.67366e5], [2.79579e7, -1.44498e7]]),
        (0.0, [[2.39926e5, -2.28383e5], [1.41482e7, -1.19083e7]]),
    ];
    for (alpha, expected) in cases {
        let scenario = lifted(alpha, 0.0025);
        let histories = scenario.run();
        let (errors, extremes) = deviations(&histories, alpha);
        let [pressure, force] = errors;
        println!("α = {alpha}: off by {pressure:.2e} and {force:.2e} of the peaks; extremes {extremes:.6?}");
        assert!(errors.iter().all(|error| *error < 5e-3), "α = {alpha}: {errors:?}");
        for (found, expected) in extremes.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((found / expected - 1.0).abs() < 5e-3, "α = {alpha}: {found} instead of {expected}");
        }
        // What moved the ground is in the tables and in the log.
        assert!(histories.column("ground_acceleration.x").iter().all(|a| *a == 0.0));
        let (interval, values) = record();
        let up = histories.column("ground_acceleration.y");
        let every = (interval / 0.0025).round() as usize;
        for (row, g) in values.iter().enumerate() {
            assert!((up[row * every] - SHARE * GRAVITY * g).abs() < 1e-12, "sample {row}");
        }
        let log = Log::open(&scenario.folder().join("run"))?;
        let motion = ground_motion_of(&log);
        let loaded = read_scene(&scenario.write(), &[])?;
        let samples = motion.vertical().expect("a vertical component").acceleration();
        assert_eq!(Some(samples), loaded.ground_motion.vertical().map(|vertical| vertical.acceleration()));
        assert_eq!(motion.acceleration(), loaded.ground_motion.acceleration());
        let reservoir = &log.head().units[1].inputs;
        let place = reservoir.range("ground_acceleration").expect("an input");
        let mut checked = 0;
        for entry in log.entries_from(0)?.take(200) {
            if let Entry::Exchange(exchange) = entry?
                && exchange.unit.0 == 1
            {
                let step = usize::try_from(exchange.occasion.step)?;
                assert_eq!(exchange.inputs[place.clone()], [0.0, up[step]], "step {step}");
                checked += 1;
            }
        }
        assert!(checked > 10);
    }
    Ok(())
}

/// The record is linear between samples at 10 ms, so that steps of 10 ms and less see the same motion.
#[test]
fn the_error_falls_with_the_communication_step() {
    let found = [0.01, 0.005, 0.0025].map(|step| deviations(&lifted(0.5, step).run(), 0.5).0);
    for (step, [pressure, force]) in [10.0, 5.0, 2.5].into_iter().zip(found) {
        println!("H = {step} ms: base pressure off by {pressure:.2e} of its peak, force by {force:.2e}");
    }
    for axis in 0..2 {
        assert!(found[0][axis] > 2.0 * found[1][axis], "{found:?}");
        assert!(found[1][axis] > found[2][axis], "{found:?}");
    }
}

/// Incompressible water that is lifted weighs more: p = ρaξ at the depth ξ before a face of any slope. The face moves along its
/// normal, so that the dam's vertical motion is part of it.
#[test]
fn water_that_is_lifted_weighs_more() {
    for batter in [0.0, 25.0, 60.0] {
        let mut scenario = Scenario::shipped("rigid-dam-ramp");
        let ramp = [
            ("acceleration", Value::from(0.0)),
            ("vertical_acceleration", Value::from(-2.0)),
            ("rise", Value::from(0.1)),
        ];
        scenario.set("ground_motion", table(&[("ramp", table(&ramp))])).set("time.duration", 0.3);
        scenario.set("reservoir.depth", DEPTH).set("reservoir.fidelity", "incompressible");
        scenario.set("reservoir.element_size", 2.5);
        scenario.set("prescribed.batter", batter).set("prescribed.panels", 20);
        let histories = scenario.run();
        assert!(histories.column("ground_acceleration.x").iter().all(|a| *a == 0.0));
        let up = histories.column("ground_acceleration.y");
        assert_eq!(up.last(), Some(&-2.0));
        let folder = scenario.folder().join("run");
        let loaded = read_scene(&scenario.write(), &[]).expect("a scene");
        let log = Log::open(&folder).expect("a log");
        assert_eq!(ground_motion_of(&log), loaded.ground_motion, "a ramp is held");
        let manifest: Table =
            std::fs::read_to_string(folder.join("manifest.toml")).expect("a manifest").parse().expect("TOML");
        let face = manifest["wet_face"].as_array().expect("points");
        let mut rows =
            csv::Reader::from_path(folder.join("reservoir-interface_pressure.csv")).expect("a table");
        let last = rows.records().last().expect("a row").expect("a row");
        let mut largest = 0.0f64;
        for (point, pressure) in face.iter().zip(last.iter().skip(1)) {
            let depth = DEPTH - point[1].as_float().expect("y");
            let pressure: f64 = pressure.parse().expect("a number");
            largest = largest.max((pressure + 2.0 * DENSITY * depth).abs() / (2.0 * DENSITY * DEPTH));
        }
        // The face moves with the ground, and the work of the water with it.
        let [work, produced] =
            ["interface_work", "interface_energy_produced"].map(|name| peak(histories.column(name)));
        println!(
            "batter {batter} m: off by {largest:.1e} of the base pressure; produced {produced:.1e} of {work:.1e} J/m"
        );
        assert!(
            batter == 0.0 || work > 1e3 && produced < 0.01 * work,
            "batter {batter} m: {produced} of {work}"
        );
        assert!(largest < 1e-2, "batter {batter} m: {largest}");
    }
}

/// A dam whose ground rises with a constant acceleration stands on it with ρA(g + a).
#[test]
fn a_dam_that_is_lifted_weighs_more() {
    let mut scenario = Scenario::shipped("koyna-intact");
    let ramp = [
        ("acceleration", Value::from(0.0)),
        ("vertical_acceleration", Value::from(1.0)),
        ("rise", Value::from(0.5)),
    ];
    scenario.set("ground_motion", table(&[("ramp", table(&ramp))])).set("time.duration", 2.0);
    scenario.set("reservoir.fidelity", "none").set("dam.element_size", 15.0);
    let histories = scenario.run();
    let force = histories.column("dam.base_normal_force");
    let last = &force[force.len() - 400..];
    let more = last.iter().sum::<f64>() / last.len() as f64 / force[0] - 1.0;
    println!("lifted by 1 m/s²: the base carries {more:.5} more, {:.5} expected", 1.0 / 9.81);
    assert!((more * 9.81 - 1.0).abs() < 0.02, "{more}");
}

/// Koyna, intact and coarse, under the record and another one upwards.
fn intact(polarities: [i64; 2], scales: [f64; 2]) -> Scenario {
    let mut scenario = Scenario::shipped("koyna-intact");
    let up = root().join("scenes/records/northridge-1994-canyon-country-270.csv");
    let vertical = [
        ("file", Value::from(up.to_string_lossy().into_owned())),
        ("polarity", polarities[1].into()),
        ("scale", scales[1].into()),
    ];
    scenario.set("ground_motion.vertical", table(&vertical));
    scenario.set("ground_motion.record.polarity", polarities[0]);
    scenario.set("ground_motion.record.scale", scales[0]);
    scenario.set("ground_motion.record.start", 4.0).set("time.duration", 1.0);
    scenario.set("dam.element_size", 15.0).set("reservoir.element_size", 15.0);
    scenario.set("coupling.tolerance", 1e-10);
    scenario
}

/// A linear dam: the opposite motion gives the opposite, half the motion a half; and no component is forgotten.
#[test]
fn polarity_and_scale_apply_to_both_components() {
    let of = |polarities: [i64; 2], scales: [f64; 2]| intact(polarities, scales).run();
    let whole = of([1, 1], [1.0, 0.5]);
    let parts = [of([1, 1], [1.0, 1e-6]), of([1, 1], [1e-6, 5e5])];
    let names = [
        "ground_acceleration.x",
        "ground_acceleration.y",
        "dam.crest_displacement.x",
        "dam.crest_displacement.y",
        "dam.crest_acceleration.y",
        "reservoir.base_pressure",
        "reservoir.total_force",
    ];
    let apart = |name: &str, found: Vec<f64>| {
        let wanted = whole.column(name);
        let off: Vec<f64> = found.iter().zip(wanted).map(|(a, b)| a - b).collect();
        let error = peak(&off) / peak(wanted);
        assert!(peak(wanted) > 0.0 && error < 1e-4, "{name}: {error}");
        error
    };
    for (case, factor, other) in [
        ("mirrored", -1.0, of([-1, -1], [1.0, 0.5])),
        // The scale of the record is that of both.
        ("twice", 2.0, of([1, 1], [0.5, 0.5])),
    ] {
        for name in names {
            let error = apart(name, other.column(name).iter().map(|value| factor * value).collect());
            println!("{case}, {name}: {error:.1e}");
        }
    }
    for name in names {
        let [x, y] = parts.each_ref().map(|part| part.column(name));
        let error = apart(name, x.iter().zip(y).map(|(x, y)| x + y).collect());
        println!(
            "superposed, {name}: {error:.1e}, the vertical part {:.2e}",
            peak(y) / peak(whole.column(name))
        );
    }
    // Both are needed: the vertical part alone moves the crest and the water.
    for name in ["dam.crest_displacement.x", "dam.crest_displacement.y", "reservoir.base_pressure"] {
        assert!(parts.iter().all(|part| peak(part.column(name)) > 0.01 * peak(whole.column(name))), "{name}");
    }
    // Reversed alone, it is another motion.
    let reversed = of([1, -1], [1.0, 0.5]);
    let error = whole_chain::relative_l2(
        reversed.column("reservoir.base_pressure"),
        whole.column("reservoir.base_pressure"),
    );
    assert!(error > 0.1, "{error}");
}

/// Outputs name the vertical component of a run that has one, and only of such a run.
#[test]
fn reports_tables_and_commands_show_the_vertical_component() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = lifted(0.5, 0.005);
    let output = scenario.folder().join("run");
    let scene = scenario.write();
    let short = ["--set", "time.duration=1.0"];
    let (status, said) =
        cofferdam(&[&["run", text(&scene), "--output", text(&output), "--quiet"], &short[..]].concat());
    assert_eq!(status, Some(0), "{said}");
    let page = std::fs::read_to_string(output.join("report.html"))?;
    for wanted in [
        "peak vertical ground acceleration",
        "Vertical ground acceleration as recorded, g",
        "ground, positive upwards",
        "positive vertical accelerations point",
        "The ground is rigid and moves as a whole",
    ] {
        assert!(page.contains(wanted), "no `{wanted}` on the page");
    }
    assert!(!page.contains("vertical motion and radiation damping"));
    let manifest: Table = std::fs::read_to_string(output.join("manifest.toml"))?.parse()?;
    let motion = &manifest["scene"]["ground_motion"];
    let vertical = &motion["vertical"];
    assert_eq!(
        (&vertical["sha256"], &vertical["file"]),
        (&motion["record"]["sha256"], &motion["record"]["file"])
    );
    assert_eq!((vertical["polarity"].as_integer(), vertical["scale"].as_float()), (Some(1), Some(SHARE)));
    assert_eq!(
        (vertical["column"].as_integer(), motion["record"]["column"].as_integer()),
        (Some(2), Some(1))
    );
    // A manifest is a scene.
    let again = read_scene(&output.join("manifest.toml"), &[])?;
    assert_eq!(again.ground_motion, read_scene(&scene, &[])?.ground_motion);
    let (_, said) = cofferdam(&["log", "info", text(&output)]);
    assert!(said.contains("vertical     both.csv, column 2: 1999 samples, 0.01 s apart"), "{said}");
    let (status, said) = cofferdam(&["check", text(&scene)]);
    assert!(status == Some(0) && said.contains("vertical: both.csv, column 2, 19.98 s: at most"), "{said}");
    let tables = scenario.folder().join("tables");
    let (status, said) = cofferdam(&["log", "export", text(&output), "--output", text(&tables)]);
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(std::fs::read(tables.join("histories.csv"))?, std::fs::read(output.join("histories.csv"))?);
    let (_, said) = cofferdam(&[&["fmu-input", text(&scene)], &short[..]].concat());
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[0], "time,ground_acceleration,ground_acceleration_vertical");
    let value: f64 = lines[4].split(',').nth(2).ok_or("a column")?.parse()?;
    assert!((value - SHARE * GRAVITY * record().1[1]).abs() < 1e-9, "{said}");
    let water = scenario.folder().join("water");
    let of_water = ["reservoir", "record", text(&scene), "--output", text(&water)];
    let (status, said) = cofferdam(&[&of_water, &short[..]].concat());
    assert_eq!(status, Some(0), "{said}");
    let csv = std::fs::read_to_string(water.join("record.csv"))?;
    assert!(csv.starts_with("time [s],acceleration [m/s2],vertical acceleration [m/s2],base pressure [Pa]"));

    let mut without = lifted(0.5, 0.005);
    without.remove("ground_motion.vertical").set("ground_motion.record.column", 2);
    let scene = without.write();
    let output = without.folder().join("run");
    cofferdam(&[&["run", text(&scene), "--output", text(&output), "--quiet"], &short[..]].concat());
    let header = std::fs::read_to_string(output.join("histories.csv"))?;
    assert!(header.starts_with("time [s],ground_acceleration.x [m/s2],iterations [1]"));
    let page = std::fs::read_to_string(output.join("report.html"))?;
    assert!(!page.contains("peak vertical") && page.contains("vertical motion and radiation damping"));
    assert_eq!(Log::open(&output)?.head().signals.len(), 1);
    let (_, said) = cofferdam(&[&["fmu-input", text(&scene)], &short[..]].concat());
    assert!(said.starts_with("time,ground_acceleration\n"), "{said}");
    Ok(())
}

/// The crest's displacement after each step of the coupled unit.
fn crest(
    unit: &mut Coupled,
    from: u32,
    steps: u32,
    mut before: impl FnMut(&mut Coupled, u32),
) -> Vec<[f64; 2]> {
    let h = 0.0025;
    let after = |step: u32| {
        before(unit, step);
        unit.step(f64::from(step) * h, h).expect("a step");
        let mut crest = [0.0; 2];
        unit.get(variables::CREST_DISPLACEMENT.value_reference, &mut crest).expect("a crest");
        crest
    };
    (from..from + steps).map(after).collect()
}

/// The ground of the scene, scaled, and the same ground by inputs are one; a state has both inputs.
#[test]
fn the_coupled_unit_takes_both_components() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = intact([1, -1], [1.0, 0.7]);
    scenario.set("reservoir.fidelity", "westergaard").set("coupling.scheme", "serial-implicit");
    let loaded = read_scene(&scenario.write(), &[])?;
    let parameters = CoupledParameters::of(&loaded.scene, &loaded.ground_motion)?;
    let up = &variables::GROUND_ACCELERATION_VERTICAL;
    assert_eq!(Coupled::size_for(&parameters, up), 1);
    let make = |parameters: CoupledParameters| Coupled::from_parameters(parameters, NonZeroUsize::MIN);
    let motion = &loaded.ground_motion;
    let set = |unit: &mut Coupled, step: u32| {
        let [x, y] = motion.at(f64::from(step) * 0.0025);
        for (variable, value) in [(&variables::GROUND_ACCELERATION, x), (up, y)] {
            unit.set(variable.value_reference, &[-1.5 * value]).expect("an input");
        }
    };
    let mut recorded = make(CoupledParameters { use_record: 1.0, record_scale: -1.5, ..parameters.clone() })?;
    recorded.initialise(0.0)?;
    let wanted = crest(&mut recorded, 0, 60, |_, _| ());
    let mut driven = make(parameters.clone())?;
    set(&mut driven, 0);
    driven.initialise(0.0)?;
    let mut found = crest(&mut driven, 0, 30, |unit, step| set(unit, step + 1));
    let state = driven.serialise_state(&driven.save_state())?;
    found.extend(crest(&mut driven, 30, 30, |unit, step| set(unit, step + 1)));
    let both = peak(wanted.as_flattened());
    let off = found.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| a - b);
    let off = peak(&off.collect::<Vec<_>>());
    println!("by inputs or as in the scene: apart by {:.1e} of the crest's {both:.2e} m", off / both);
    assert!(both > 1e-4 && off < 1e-9 * both);
    let mut restored = make(parameters.clone())?;
    restored.restore_state(&restored.deserialise_state(&state)?)?;
    assert_eq!(crest(&mut restored, 30, 30, |unit, step| set(unit, step + 1)), found[30..]);
    // Without the vertical input it is another motion.
    let mut level = make(parameters.clone())?;
    let set = |unit: &mut Coupled, step: u32| {
        let x = motion.at(f64::from(step) * 0.0025)[0];
        unit.set(variables::GROUND_ACCELERATION.value_reference, &[-1.5 * x]).expect("an input");
    };
    set(&mut level, 0);
    level.initialise(0.0)?;
    let other = crest(&mut level, 0, 60, |unit, step| set(unit, step + 1));
    assert!((0..60).any(|i| (other[i][1] - wanted[i][1]).abs() > 1e-2 * both));

    scenario.remove("ground_motion.vertical");
    let loaded = read_scene(&scenario.write(), &[])?;
    let parameters = CoupledParameters::of(&loaded.scene, &loaded.ground_motion)?;
    assert_eq!(Coupled::size_for(&parameters, up), 0);
    Ok(())
}

/// The records of an ensemble bring their vertical components, and a scene's own one is no other record's.
#[test]
fn an_ensemble_varies_both_components() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = intact([1, 1], [1.0, 1.0]);
    scenario.set("reservoir.fidelity", "westergaard").set("time.duration", 0.2);
    scenario.set("coupling.scheme", "serial-implicit");
    let file = root().join("scenes/records/northridge-1994-canyon-country-270.csv");
    let place = scenario.folder().to_owned();
    let plan = |vertical: &str| {
        let text = format!(
            "scene = \"scene.toml\"\nrecords = [{{ file = {file:?}, name = \"a\", start = 4.0{vertical} }}]\n\
             [intensity]\nscales = [1.0, 2.0]\n"
        );
        let path = place.join("plan.toml");
        std::fs::write(&path, text).expect("a plan");
        path
    };
    let run = |plan: &Path, name: &str| {
        let folder = place.join(name);
        let (status, said) = cofferdam(&["ensemble", text(plan), "--output", text(&folder)]);
        (folder, status, said)
    };
    scenario.write();
    let (_, status, said) = run(&plan(""), "refused");
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("give `vertical` in each"), "{said}");
    let vertical = format!(", vertical = {{ file = {file:?}, scale = 0.5, polarity = -1 }}");
    let (both, status, said) = run(&plan(&vertical), "both");
    assert_eq!(status, Some(0), "{said}");
    let manifest = std::fs::read_to_string(both.join("ensemble.toml"))?;
    let manifest: Table = manifest.parse()?;
    let of_record = &manifest["records"][0];
    assert_eq!(of_record["vertical"]["polarity"].as_integer(), Some(-1));
    assert_eq!(of_record["vertical"]["sha256"], of_record["sha256"]);
    scenario.remove("ground_motion.vertical").write();
    let (level, status, said) = run(&plan(""), "level");
    assert_eq!(status, Some(0), "{said}");
    let results = |folder: &Path| std::fs::read_to_string(folder.join("results.csv"));
    assert_ne!(results(&both)?, results(&level)?);
    Ok(())
}
