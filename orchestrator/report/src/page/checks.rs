//! Self-checks of a run: values, references and limits.

use super::super::summary::{CAVITATION, ENERGY_ALARM, ENERGY_BALANCE, LOWEST_PRESSURE};
use super::data::Check;
use super::folder::RunFolder;
use super::number::{plain, shown};
use super::westergaard::static_force;
use cofferdam_assembly::observer::{AVERAGED, LastSecond, STILL_MOVES, STILL_SLIDES};
use cofferdam_scene::{DamScene, REST, Scene, Side};

/// Tolerance of static forces against their closed forms, because the static state is iterated.
const STATIC: f64 = 1e-3;
/// Share of the thrust above which the inertia at time 0 prevents a judgement.
const SHAKEN: f64 = 1e-2;

/// The checks that the run has numbers for.
pub fn of(run: &RunFolder) -> Vec<Check> {
    let mut checks = statics(run);
    checks.extend(frequency(run));
    checks.extend(energy(run));
    checks.extend(rest(run));
    checks.extend(convergence(run));
    checks.extend(cavitation(run));
    checks
}

/// Thrust and weight at the beginning, which the dam's base carries before the ground moves.
fn statics(run: &RunFolder) -> Vec<Check> {
    let scene = &run.loaded.scene;
    let Some(dam) = scene.dam.as_ref().filter(|dam| !dam.fidelity.is_foreign()) else { return Vec::new() };
    let first = |name: &str| run.histories.column(name).and_then(|column| column.first()).copied();
    let [water_x, water_y] = water_force(scene, dam);
    let mut checks = Vec::new();
    let mut add = |name: &str, found: Option<f64>, expected: f64, shaken: f64, remark: String| {
        let Some(found) = found else { return };
        let within = STATIC + shaken;
        checks.push(Check {
            name: name.to_owned(),
            found: 1e-6 * found,
            expected: Some(1e-6 * expected),
            unit: "MN/m",
            limit: format!("within {:.2} %", 100.0 * within),
            kept: (shaken <= SHAKEN).then_some((found - expected).abs() <= within * expected.abs()),
            remark,
        });
    };
    let mass = dam.material.density * area(dam);
    if scene.has_water() {
        let of = if scene.tailwater.is_some() {
            "ρgh²/2 of the reservoir minus that of the tailwater"
        } else {
            "ρgh²/2"
        };
        // The part of the dam's mass that already moves with the ground at time 0 is unknown here.
        let acceleration = first("ground_acceleration.x").unwrap_or(0.0);
        let shaken = (mass * acceleration / water_x).abs();
        let remark = match shaken {
            0.0 => of.to_owned(),
            SHAKEN.. => format!(
                "{of}; not judged: the ground acceleration is {} m/s² at time 0, so the force includes inertia",
                shown(acceleration)
            ),
            _ => format!("{of}; the force may include inertia of the dam at time 0"),
        };
        add("static thrust on the base", first("dam.base_shear"), water_x, shaken, remark);
    }
    // Zones overlap and may be cut off: their weight needs the mesh.
    if dam.zones.is_empty() {
        let weight = scene.gravity * mass - water_y;
        let of = if water_y == 0.0 {
            "ρg × area of the section"
        } else {
            "ρg × area of the section, plus the weight of water on its batters"
        };
        let acceleration = first("ground_acceleration.y").unwrap_or(0.0);
        let shaken = (mass * acceleration / weight).abs();
        let remark = match shaken {
            0.0 => of.to_owned(),
            _ => format!("{of}; the force may include inertia of the dam at time 0"),
        };
        add("weight on the base", first("dam.base_normal_force"), weight, shaken, remark);
    }
    checks
}

/// The force of all still waters on the dam, N/m.
fn water_force(scene: &Scene, dam: &DamScene) -> [f64; 2] {
    let mut force = [0.0; 2];
    for (side, water) in scene.waters().filter(|(side, _)| scene.hydrostatic_base_pressure(*side) > 0.0) {
        let (face, sign) = match side {
            Side::Upstream => (&dam.section.upstream, 1.0),
            Side::Downstream => (&dam.section.downstream, -1.0),
        };
        let foot = face.first().map_or(0.0, |foot| foot[1]);
        let mirrored: Vec<[f64; 2]> = face.iter().map(|[x, y]| [sign * x, y - foot]).collect();
        let [x, y] = static_force(&mirrored, water.density * scene.gravity, scene.depth_of(side));
        force = [force[0] + sign * x, force[1] + y];
    }
    force
}

/// Area of the section without its galleries, m².
fn area(dam: &DamScene) -> f64 {
    let of = |outline: &[[f64; 2]]| {
        let next = outline.iter().cycle().skip(1);
        let twice: f64 = outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        twice.abs() / 2.0
    };
    let section = &dam.section;
    let outline: Vec<[f64; 2]> =
        section.upstream.iter().chain(section.downstream.iter().rev()).copied().collect();
    of(&outline) - section.galleries.iter().map(|gallery| of(gallery)).sum::<f64>()
}

/// Water lowers the natural frequencies of a dam.
fn frequency(run: &RunFolder) -> Option<Check> {
    let of = |water: &str| run.summary.value(&format!("natural frequency 1 (intact, {water})"));
    let (empty, full) = (of("empty")?, of("full")?);
    Some(Check {
        name: "ω₁ of the intact dam, full".to_owned(),
        found: full,
        expected: Some(empty),
        unit: "rad/s",
        limit: "below ω₁ empty".to_owned(),
        kept: Some(full < empty),
        remark: "the mass of the water lowers the frequency".to_owned(),
    })
}

fn energy(run: &RunFolder) -> Option<Check> {
    let found = run.summary.value(ENERGY_BALANCE)?;
    Some(Check {
        name: "energy balance error over the peak kinetic energy".to_owned(),
        found,
        expected: None,
        unit: "%",
        limit: format!("at most {ENERGY_ALARM} %"),
        kept: Some(found <= ENERGY_ALARM),
        remark: "input work minus all other energies".to_owned(),
    })
}

/// Whether every block is at rest at the end, once the ground has been for long enough.
fn rest(run: &RunFolder) -> Vec<Check> {
    let scene = &run.loaded.scene;
    let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    let end = run.histories.column("time").and_then(|time| time.last()).copied().unwrap_or(0.0);
    let judged = run.loaded.ground_motion.rest_from().is_some_and(|rest| end + 1e-9 >= rest + REST);
    let remark = match judged {
        true => format!("mean of the last {AVERAGED} s"),
        false => format!("not judged: the ground has not been at rest for {REST} s"),
    };
    let mut checks = Vec::new();
    let mut share = None;
    for (index, crack) in cracks.iter().enumerate() {
        let Some(last) = LastSecond::of(&run.histories, &format!("dam.crack_sliding.{index}")) else {
            continue;
        };
        share = Some(last.kinetic_share);
        checks.push(Check {
            name: format!("rest at the end: sliding speed, {}", crack.phrase()),
            found: 1e3 * last.speed.abs(),
            expected: None,
            unit: "mm/s",
            limit: format!("at most {} mm/s", 1e3 * STILL_SLIDES),
            kept: judged.then_some(last.speed.abs() <= STILL_SLIDES),
            remark: remark.clone(),
        });
    }
    checks.extend(share.map(|share| Check {
        name: "rest at the end: kinetic energy over its peak".to_owned(),
        found: 100.0 * share,
        expected: None,
        unit: "%",
        limit: format!("at most {} %", 100.0 * STILL_MOVES),
        kept: judged.then_some(share <= STILL_MOVES),
        remark,
    }));
    checks
}

fn convergence(run: &RunFolder) -> Option<Check> {
    let converged = run.histories.column("converged")?;
    let failed = converged.iter().filter(|converged| **converged == 0.0).count();
    Some(Check {
        name: "steps without convergence".to_owned(),
        found: failed as f64,
        expected: None,
        unit: "1",
        limit: "none".to_owned(),
        kept: Some(failed == 0),
        remark: format!("of {} communication steps", converged.len().saturating_sub(1)),
    })
}

fn cavitation(run: &RunFolder) -> Option<Check> {
    let found = run.summary.value(LOWEST_PRESSURE)?;
    Some(Check {
        name: "lowest pressure on a wet face".to_owned(),
        found,
        expected: None,
        unit: "kPa",
        limit: format!("at least {} kPa", plain(CAVITATION)),
        kept: Some(found >= CAVITATION),
        remark: "real water cavitates below this pressure; the linear model does not".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scene(shipped: &str, overrides: &[&str]) -> Scene {
        let file =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(shipped).join("scene.toml");
        let text = std::fs::read_to_string(&file).expect("a shipped scene");
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        Scene::resolved(&text, &overrides, &file).expect("a scene")
    }

    #[test]
    fn statics_of_the_main_scene() {
        let of = scene("koyna-coarse", &[]);
        let dam = of.dam.as_ref().expect("a dam");
        // Trapezoids below and above the neck.
        let by_hand = (70.0 + 19.25) / 2.0 * 66.5 + (19.25 + 14.8) / 2.0 * 36.5;
        assert!((area(dam) - by_hand).abs() < 1e-9, "{}", area(dam));
        let [x, y] = water_force(&of, dam);
        assert!((x / (1000.0 * 9.81 * 91.75 * 91.75 / 2.0) - 1.0).abs() < 1e-12 && y == 0.0, "{x}, {y}");
    }

    #[test]
    fn a_tailwater_pushes_back_and_stands_on_its_face() {
        let both = scene("koyna-tailwater", &[]);
        let dam = both.dam.as_ref().expect("a dam");
        let depth = both.depth_of(Side::Downstream);
        let [x, y] = water_force(&both, dam);
        let thrust = |depth: f64| 1000.0 * 9.81 * depth * depth / 2.0;
        assert!((x - thrust(both.depth()) + thrust(depth)).abs() < 1e-3, "{x}");
        // The lower part of the face leans by 50.75 m over 66.5 m.
        assert!(depth < 66.5 && (y + thrust(depth) * 50.75 / 66.5).abs() < 1e-3, "{y}");
    }
}
