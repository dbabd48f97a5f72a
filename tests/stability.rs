//! `cofferdam stability` against the gravity method by hand.

use cofferdam_assembly::{Assembly, JointStability, LoadCombination, Verdict};
use cofferdam_scene::Scene;
use std::path::Path;
use std::process::Command;
use whole_chain::scenario::{Scenario, binary};

/// The joints of a shipped scene with changed values, from the base up.
fn joints(shipped: &str, overrides: &[&str], opened: Option<&[f64]>) -> Vec<JointStability> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(shipped).join("scene.toml");
    let text = std::fs::read_to_string(&file).expect("a shipped scene");
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let scene = Scene::resolved(&text, &overrides, &file).expect("a scene");
    let opened: Vec<Vec<f64>> = opened.map(<[f64]>::to_vec).into_iter().collect();
    Assembly::of(&scene).stability(0.0, &opened, &[]).expect("joints")
}

/// A case: scene, changed values, combination, length that an earthquake opened; expected: shear force, uplift and effective normal
/// force (kN/m), resultant (share of the length from the toe), open length (m), effective stress at heel or tip and at the toe
/// (kPa), and factor against sliding.
type Case = (&'static str, &'static str, &'static [&'static str], LoadCombination, Option<f64>, [f64; 8]);

const TRIANGLE: &[&str] = &[
    "dam.section.upstream=[[0, 0], [0, 100]]",
    "dam.section.downstream=[[90, 0], [0.001, 100]]",
    "dam.material.density=2400",
    "reservoir.depth=100",
    "dam.uplift=unchanged",
];
const WITH_DRAINS: &[&str] = &[
    "dam.section.upstream=[[0, 0], [0, 100]]",
    "dam.section.downstream=[[80, 0], [0.001, 100]]",
    "dam.material.density=2400",
    "reservoir.depth=100",
    "dam.uplift=unchanged",
    "dam.cracks.0.uplift={drains={position=8, efficiency=0.67}}",
];
const HALF_DRAINED: &[&str] = &[
    "dam.section.upstream=[[0, 0], [0, 100]]",
    "dam.section.downstream=[[80, 0], [0.001, 100]]",
    "dam.material.density=2400",
    "reservoir.depth=100",
    "dam.uplift=unchanged",
    "dam.cracks.0.uplift={drains={position=8, efficiency=0.5}}",
];
const TAILWATER: &[&str] = &["dam.uplift=unchanged", "loads.tailwater={depth=20}"];
const TAILWATER_AND_DRAINS: &[&str] = &[
    "dam.uplift=unchanged",
    "loads.tailwater={depth=20}",
    "dam.cracks.0.uplift={drains={position=7, efficiency=0.67}}",
];
const COHESION: &[&str] = &["dam.uplift=unchanged", "dam.cracks.0.cohesion=1e6"];
const LIFT_DRAINS: &[&str] = &[
    "dam.uplift=unchanged",
    "dam.cracks.0.friction_coefficient=0.7",
    "dam.cracks.0.uplift={drains={position=2.5, efficiency=0.5}}",
];
const FULL: &[&str] = &[
    "dam.uplift=full-where-open",
    "dam.cracks.0.friction_coefficient=0.7",
    "stability.seismic_coefficients=[0.2, 0]",
];
const FROZEN: &[&str] = &["dam.uplift=unchanged", "stability.seismic_coefficients=[0.1, 0]"];
const RESIDUAL: &[&str] =
    &["dam.uplift=unchanged", "dam.cracks.0.residual_friction_coefficient=0.7002075382"];

/// Each was computed by iteration with exact integrals and by closed form or bisection on sampled pressures, which agree to 2e-4
/// (γ = 9.81 kN/m³; triangles of 2400 kg/m³, Koyna of 2640 kg/m³).
const CASES: &[Case] = &[
    (
        "triangle",
        "koyna-base-joint",
        TRIANGLE,
        LoadCombination::Usual,
        None,
        [49050.0, 44145.0, 61803.0, 0.3727219283, 0.0, 162.2888889, 1211.111111, 1.26],
    ),
    (
        "drains",
        "koyna-base-joint",
        WITH_DRAINS,
        LoadCombination::Usual,
        None,
        [49050.0, 15578.28, 78597.72, 0.3966050924, 0.0, 372.9762, 1591.9668, 1.6024],
    ),
    (
        "drains of half efficiency",
        "koyna-base-joint",
        HALF_DRAINED,
        LoadCombination::Usual,
        None,
        [49050.0, 21582.0, 72594.0, 0.377027027, 0.0, 237.8925, 1576.9575, 1.48],
    ),
    (
        "tailwater",
        "koyna-base-joint",
        TAILWATER,
        LoadCombination::Usual,
        None,
        [39328.59656, 38369.3625, 56076.66343, 0.4067222903, 0.0, 352.7492432, 1249.441141, 1.425849594],
    ),
    (
        "tailwater and drains",
        "koyna-base-joint",
        TAILWATER_AND_DRAINS,
        LoadCombination::Usual,
        None,
        [39328.59656, 23514.23891, 70931.78702, 0.4541810558, 0.0, 734.7381354, 1291.884351, 1.803567715],
    ),
    (
        "cohesion",
        "koyna-coarse",
        COHESION,
        LoadCombination::Usual,
        None,
        [3127.244063, 2384.136563, 13709.45293, 0.4361671976, 0.0, 439.4169418, 984.9418039, 10.53945655],
    ),
    (
        "drains in a lift joint",
        "koyna-coarse",
        LIFT_DRAINS,
        LoadCombination::Usual,
        None,
        [3127.244063, 1346.882344, 14746.70715, 0.4493351384, 0.0, 533.1879422, 998.9374756, 3.30089203],
    ),
    (
        "earthquake, full pressure in what opens",
        "koyna-coarse",
        FULL,
        LoadCombination::Seismic,
        None,
        [7736.910001, 3797.891742, 12295.69775, 0.1356719519, 11.41494478, 0.0, 3138.637163, 1.112458129],
    ),
    (
        "earthquake, uplift unchanged",
        "koyna-base-joint",
        FROZEN,
        LoadCombination::Seismic,
        None,
        [55402.70384, 31502.3625, 61446.34764, 0.2829536739, 10.57972848, 0.0, 2068.194778, 1.109085719],
    ),
    (
        "after an earthquake that opened 10 m",
        "koyna-coarse",
        RESIDUAL,
        LoadCombination::PostEarthquake,
        Some(10.0),
        [3127.244063, 3622.649063, 12470.94043, 0.4304727245, 0.0, 377.5853176, 918.0968048, 2.792313718],
    ),
    (
        "after an earthquake that opened all",
        "koyna-coarse",
        RESIDUAL,
        LoadCombination::PostEarthquake,
        Some(19.25),
        [3127.244063, 4768.273125, 11325.31637, 0.4578151558, 0.0, 439.4169418, 737.2393039, 2.535802046],
    ),
];

#[test]
fn joints_have_the_forces_and_factors_by_hand() {
    for &(name, scene, overrides, combination, opened, expected) in CASES {
        let found = joints(scene, overrides, opened.as_ref().map(std::slice::from_ref));
        let joint = found.iter().find(|joint| joint.combination == combination).expect("the combination");
        let [heel, toe] = joint.state.stresses.expect("equilibrium");
        let computed = [
            1e-3 * joint.load.shear,
            1e-3 * joint.state.uplift,
            1e-3 * joint.state.normal,
            joint.state.share().expect("compression"),
            joint.state.open[0],
            1e-3 * heel,
            1e-3 * toe,
            joint.decisive().expect("a shear force"),
        ];
        // no measure is relative to zero: lengths to that of the joint, stresses to the larger one
        let scales =
            [expected[0], expected[1], expected[2], 1.0, joint.length, expected[6], expected[6], expected[7]];
        for (i, scale) in scales.into_iter().enumerate() {
            let error = (computed[i] - expected[i]).abs() / scale;
            assert!(error < 1e-3, "{name}, value {i}: {} for {}", computed[i], expected[i]);
        }
    }
}

#[test]
fn verdicts_follow_the_authority_or_the_factors_of_the_scene() {
    let of = |overrides: &[&str]| joints("koyna-base-joint", overrides, None).remove(0);
    let usual = of(&["dam.uplift=unchanged"]);
    assert_eq!((usual.required, usual.verdict()), (Some(2.0), Verdict::Fails));
    let ferc = of(&["dam.uplift=unchanged", "stability.authority=ferc"]);
    assert_eq!(ferc.required, Some(1.5), "without cohesion");
    let own = of(&["dam.uplift=unchanged", "stability.required={usual=1.4}"]);
    assert_eq!((own.required, own.verdict()), (Some(1.4), Verdict::Meets));
    // an own factor does not excuse a resultant outside the zone that is required
    let pushed = of(&["dam.uplift=unchanged", "stability.required={usual=0.1}", "loads.ice={force=2e7}"]);
    assert_eq!(pushed.verdict(), Verdict::Fails);
}

#[test]
fn combinations_of_the_scene_change_levels_drains_and_ice() {
    let drains = "dam.cracks.0.uplift={drains={position=7, efficiency=0.67}}";
    let by_default = joints("koyna-base-joint", &["dam.uplift=unchanged", drains], None);
    let kinds: Vec<_> = by_default.iter().map(|joint| joint.combination).collect();
    use LoadCombination::{Extreme, PostEarthquake, Seismic, Unusual, Usual};
    assert_eq!(kinds, [Usual, Unusual, Seismic, PostEarthquake]);
    assert!(by_default[1].state.uplift > 1.5 * by_default[0].state.uplift, "drains out of service");
    let flood = "stability.combinations=[{name=\"flood\", kind=\"extreme\", water_level=95.0, drains=false, ice=false}]";
    let flood =
        joints("koyna-base-joint", &["dam.uplift=unchanged", drains, "loads.ice={force=1e5}", flood], None);
    let [flood] = &flood[..] else { panic!("one combination: {flood:?}") };
    assert_eq!((flood.combination, &*flood.name), (Extreme, "flood"));
    let thrust = 9810.0 * 95.0 * 95.0 / 2.0;
    assert!((flood.load.shear / thrust - 1.0).abs() < 1e-6, "{} N/m", flood.load.shear);
    assert!((flood.state.uplift / (9810.0 * 95.0 * 70.0 / 2.0) - 1.0).abs() < 1e-6);
}

/// The command on a scene and on a run: the run adds what happened, and both write the table.
#[test]
fn the_command_prints_and_writes_the_table_of_scenes_and_runs() {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.uplift", "unchanged").set("dam.element_size", 10.0);
    scenario
        .set("ground_motion.record.start", 4.4)
        .set("ground_motion.record.end", 6.0)
        .set("time.quiet", 0.0);
    let output = scenario.try_run("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let folder = scenario.folder().to_owned();
    let said = |subject: &Path, options: &[&str]| {
        let output =
            Command::new(binary()).arg("stability").arg(subject).args(options).output().expect("the command");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let csv = folder.join("stability.csv");
    let of_run = said(&folder.join("run"), &["--csv", csv.to_str().expect("a path")]);
    assert!(of_run.contains("In the run: least factor against sliding"), "{of_run}");
    assert!(of_run.contains("EM 1110-2-2200") && of_run.contains("To be confirmed"), "{of_run}");
    assert!(of_run.lines().all(|line| line.chars().count() <= 80), "{of_run}");
    let rows = std::fs::read_to_string(&csv).expect("the table");
    assert_eq!(rows.lines().count(), 1 + 3, "{rows}");
    let page = std::fs::read_to_string(folder.join("run/report.html")).expect("the page");
    assert!(page.contains("Stability of the joints") && page.contains("factor, sliding, peak"));
    let rules = said(&scenario.write(), &["--rules"]);
    for word in ["none", "unchanged", "zero-open", "full-open"] {
        assert!(rules.contains(word), "{word}: {rules}");
    }
    let both =
        Command::new(binary()).arg("stability").arg(folder.join("run")).args(["--set", "gravity=9"]).output();
    let both = both.expect("the command");
    assert_eq!(both.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&both.stderr).contains("--set"));
}

/// A flood reaches a crack above the water of the run, and its uplift counts.
#[test]
fn a_flood_enters_cracks_that_are_dry_in_the_run() {
    let flood = "stability.combinations=[{kind=\"extreme\", water_level=100.0}]";
    let of = |depth: &str| joints("koyna-coarse", &["dam.uplift=unchanged", depth, flood], None).remove(0);
    let [dry, wet] = ["reservoir.depth=60", "reservoir.depth=91.75"].map(of);
    assert!(wet.state.uplift > 3e6, "{} N/m", wet.state.uplift);
    assert!((dry.state.uplift / wet.state.uplift - 1.0).abs() < 1e-9, "{} N/m", dry.state.uplift);
}

/// The factors of the Canadian guidelines without cohesion are for the residual strength.
#[test]
fn residual_strength_is_compared_where_the_authority_says_so() {
    let residual = "dam.cracks.0.residual_friction_coefficient=0.5";
    let of = |authority: &str| {
        joints("koyna-base-joint", &["dam.uplift=unchanged", residual, authority], None).remove(0)
    };
    let (cda, usace) = (of("stability.authority=cda"), of("stability.authority=usace"));
    assert_eq!(cda.decisive(), cda.sliding[1]);
    assert_eq!(usace.decisive(), usace.sliding[0]);
    assert!(cda.sliding[1] < cda.sliding[0]);
}
