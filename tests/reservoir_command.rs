//! `cofferdam reservoir`: comparison with closed forms, and refusal of wrong options.

use cofferdam_reservoir::analytical::chopra_1967;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;
use whole_chain::koyna::DEPTH;
use whole_chain::scenario::{Histories, binary, root};

const SCENE: &str = "koyna-intact";

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Runs the command for a scene, with results in `out` in `folder`.
fn ask(folder: &Path, scene: &str, what: &str, more: &[&str]) -> Output {
    let mut command = Command::new(binary());
    command.args(["reservoir", what]).arg(root().join("scenes").join(scene)).args(more);
    command.arg("--output").arg(folder.join("out")).output().expect("cofferdam runs")
}

/// The output of a successful command.
fn answered(folder: &Path, scene: &str, what: &str, more: &[&str]) -> String {
    let output = ask(folder, scene, what, more);
    assert!(output.status.success(), "{more:?}: {}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    println!("{said}");
    said
}

/// The status and the message, on one line, of a refused command; it must leave no files.
fn refused(scene: &str, what: &str, more: &[&str]) -> (Option<i32>, String) {
    let folder = folder();
    let output = ask(folder.path(), scene, what, more);
    assert!(!folder.path().join("out").exists(), "{more:?} leaves something behind");
    let said = String::from_utf8_lossy(&output.stderr).replace('│', " ");
    (output.status.code(), said.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn picture(path: &Path) {
    let text = std::fs::read_to_string(path).expect("a picture");
    assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
    assert!(text.contains("closed form"));
}

/// Largest deviation of a complex column from the exact one, over the size of that or, where it is small, a tenth of its
/// largest below resonances: amplitudes have zeros.
fn deviation(table: &Histories, name: &str) -> f64 {
    let column = |of: &str, part: &str| table.column(&format!("{name}{of} {part}"));
    let parts = ["real", "imaginary"].map(|part| (column("", part), column(" exact", part)));
    let [re, im] = &parts;
    let small = 0.1 * re.1[0].hypot(im.1[0]);
    let rows = 0..re.0.len();
    rows.map(|i| (re.0[i] - re.1[i]).hypot(im.0[i] - im.1[i]) / re.1[i].hypot(im.1[i]).max(small))
        .fold(0.0, f64::max)
}

/// Koyna's face over a bed that is rigid and one that absorbs, up to 7 ω₁. Interpolation linear along panels of
/// length ℓ has an error of some (kℓ)²/12 for a wave of wavenumber k: 3 % at 7 ω₁ on the dam's own panels of 4.8 m,
/// less than 1 % on the 50 of 1.8 m that are taken here, with a point at mid-height.
fn response_meets_the_closed_form(more: &[&str]) {
    for alpha in ["1", "0.5"] {
        let folder = folder();
        let alpha = format!("reservoir.wave_reflection_coefficient={alpha}");
        let panels = "reservoir.interface_size=1.85";
        let arguments = [&["--set", &alpha, "--set", panels, "--count", "80"][..], more].concat();
        let said = answered(folder.path(), SCENE, "response", &arguments);
        assert!(said.contains("80 frequencies") && said.contains("from the closed form"), "{said}");
        let out = folder.path().join("out");
        let table = Histories::read(&out.join("response.csv"));
        assert_eq!(table.column("omega").len(), 80);
        for name in ["pressure at 0 m", &format!("pressure at {} m", DEPTH / 2.0), "force"] {
            let off = deviation(&table, name);
            println!("{alpha}, {name}: at most {:.3} %", 100.0 * off);
            assert!(off < 0.01, "{name}: {off}");
        }
        // A dam that moves away from the water causes tension at low frequencies.
        assert!(table.column("force real")[0] < 0.0);
        picture(&out.join("response.svg"));
    }
}

#[test]
fn response_meets_the_closed_form_off_the_imaginary_axis() {
    response_meets_the_closed_form(&["--sigma", "0.1"]);
}

#[test]
fn response_meets_the_closed_form_at_real_frequencies() {
    response_meets_the_closed_form(&[]);
}

/// Over a rigid bed the response is infinite at ω₁, which is left out; a range of only this frequency is refused.
#[test]
fn a_cut_off_is_left_out_and_named() {
    let first = std::f64::consts::PI * 1440.0 / (2.0 * DEPTH);
    let (omega, last) = (first.to_string(), (1.5 * first).to_string());
    let rigid = ["--set", "reservoir.wave_reflection_coefficient=1", "--from-omega", &omega];
    let folder = folder();
    let range = [&rigid[..], &["--to-omega", &last, "--count", "3"]].concat();
    let output = ask(folder.path(), SCENE, "response", &range);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && complaint.contains("left out ω = 24.6"), "{complaint}");
    assert_eq!(Histories::read(&folder.path().join("out/response.csv")).column("omega").len(), 2);
    let (status, _) =
        refused(SCENE, "response", &[&rigid[..], &["--to-omega", &omega, "--count", "1"]].concat());
    assert_eq!(status, Some(4));
}

/// Base and mid-height of a column of water over an absorbing bed.
#[test]
fn vertical_motion_meets_the_column_of_water() {
    let folder = folder();
    let more = ["--set", "reservoir.interface_size=1.85", "--count", "40", "--sigma", "0.1"];
    answered(folder.path(), SCENE, "response", &[&["--motion", "vertical"][..], &more].concat());
    let table = Histories::read(&folder.path().join("out/response.csv"));
    for name in ["pressure at 0 m", &format!("pressure at {} m", DEPTH / 2.0), "force"] {
        let off = deviation(&table, name);
        println!("{name}: at most {:.3} %", 100.0 * off);
        assert!(off < 0.01, "{name}: {off}");
    }
    assert!(table.column("force real")[0] > 0.0, "what rises is pressed upon");
}

/// Water without memory: one line, that of ⅞ ρh at the base, and of the series.
#[test]
fn an_added_mass_is_the_same_at_every_frequency() {
    for (settings, base) in [
        (&["reservoir.fidelity=westergaard"][..], 0.875),
        (&["reservoir.fidelity=westergaard", "reservoir.profile=exact"][..], 0.742_454),
        (&["reservoir.fidelity=incompressible"][..], 0.742_454),
    ] {
        let folder = folder();
        let sets = settings.iter().flat_map(|set| ["--set", set]);
        let sets: Vec<&str> = sets.chain(["--sigma", "0.1", "--count", "5", "--at", "0"]).collect();
        let said = answered(folder.path(), SCENE, "response", &sets);
        assert!(said.contains("Westergaard's series"), "{said}");
        let table = Histories::read(&folder.path().join("out/response.csv"));
        let (real, imaginary) =
            (table.column("pressure at 0 m real"), table.column("pressure at 0 m imaginary"));
        for (p, q) in real.iter().zip(imaginary) {
            let coefficient = -p / (1000.0 * DEPTH);
            // Incompressible water is computed, on 16 elements: second order, 1e-3.
            assert!((coefficient / base - 1.0).abs() < 1e-3, "{coefficient} against {base}");
            assert!((p / real[0] - 1.0).abs() < 1e-12 && q.abs() < 1e-9 * p.abs());
        }
        let exact = table.column("pressure at 0 m exact real")[0];
        assert!((exact / (-1000.0 * DEPTH * 0.742_453_7) - 1.0).abs() < 1e-6, "{exact}");
    }
}

/// A ramp of 0.1 s is resolved by steps of 2.5 ms and 16 elements a depth; an impulse that lasts two steps has waves
/// shorter than the elements. Both hats have the velocity of 1 m/s, after which early pressure is −ρc.
#[test]
fn impulse_and_ramp_meet_the_closed_form_at_the_base() {
    let folder = folder();
    let arguments = ["--set", "reservoir.wave_reflection_coefficient=1", "--ramp", "0.1", "--duration", "1"];
    answered(folder.path(), SCENE, "impulse", &arguments);
    let out = folder.path().join("out");
    for (name, most) in [("impulse", 0.05), ("ramp", 1e-3)] {
        let table = Histories::read(&out.join(format!("{name}.csv")));
        let (base, exact) = (table.column("pressure at 0 m"), table.column("pressure at 0 m exact"));
        assert_eq!((base.len(), table.column("time")[400]), (401, 1.0));
        let off = whole_chain::relative_l2(base, exact);
        println!("{name}: base off by {off:.1e}");
        assert!(off < most, "{name}: {off}");
        picture(&out.join(format!("{name}.svg")));
    }
    let impulse = Histories::read(&out.join("impulse.csv"));
    let early = impulse.column("pressure at 0 m")[10];
    assert!((early / -1.44e6 - 1.0).abs() < 0.02, "{early}");
    let sum: f64 = impulse.column("acceleration").iter().sum();
    assert!((sum * 0.0025 - 1.0).abs() < 1e-12);
}

/// The ramp of the scene with its rigid dam in one computation, and the same for water without memory.
#[test]
fn a_record_at_once_meets_the_closed_form_at_the_base() {
    let (depth, sound_speed, density) = (180.0, 1440.0, 1000.0);
    let folder = folder();
    let said = answered(folder.path(), "rigid-dam-ramp", "record", &["--at", "90"]);
    assert!(said.contains("of the hydrostatic") && said.contains("rigid dam on rigid rock"), "{said}");
    let table = Histories::read(&folder.path().join("out/record.csv"));
    let exact: Vec<f64> = table
        .column("time")
        .iter()
        .map(|t| chopra_1967::base_pressure(&[(0.0, 0.0), (0.1, 1.0)], depth, sound_speed, *t))
        .map(|p| density * sound_speed * p)
        .collect();
    let base = table.column("base pressure");
    let off = whole_chain::relative_l2(base, &exact);
    println!("ramp at once: base off by {off:.1e}");
    assert!(off < 1e-3 && base.len() == 801);
    let svg = std::fs::read_to_string(folder.path().join("out/record.svg")).expect("a picture");
    assert!(svg.starts_with("<svg") && svg.contains("90 m"));
    let still = self::folder();
    let settings = ["--set", "reservoir.fidelity=westergaard", "--set", "time.duration=0.5"];
    answered(still.path(), "rigid-dam-ramp", "record", &settings);
    let table = Histories::read(&still.path().join("out/record.csv"));
    let last = |name: &str| *table.column(name).last().expect("a row");
    // ⅞ ρah at the base, but for ℓ²p″/12 of 16 panels, 8e-5 of it; the force of the parabola.
    assert!((last("base pressure") / (0.875 * density * depth) - 1.0).abs() < 2e-4);
    assert!((last("force") / (7.0 / 12.0 * density * depth * depth) - 1.0).abs() < 1e-12);
    assert!(last("overturning moment") > 0.0);
}

#[test]
fn no_closed_form_is_no_column() {
    let folder = folder();
    // A battered face.
    let said = answered(
        folder.path(),
        "rigid-dam-ramp",
        "impulse",
        &["--set", "prescribed.batter=20", "--duration", "0.2", "--at", "10"],
    );
    assert!(said.contains("no closed form: the face is not vertical"), "{said}");
    let text = std::fs::read_to_string(folder.path().join("out/impulse.csv")).expect("a table");
    assert_eq!(text.lines().next(), Some("time [s],acceleration [m/s2],pressure at 10 m [Pa],force [N/m]"));
    assert!(!folder.path().join("out/ramp.csv").exists());
}

#[test]
fn nonsense_is_refused_and_leaves_nothing() {
    for (what, more, status, word) in [
        ("response", &["--at", "200"][..], 2, "from 0 to 91.75 m"),
        ("response", &["--from-omega", "0"][..], 2, "--from-omega 0"),
        ("response", &["--from-omega", "5", "--to-omega", "4"][..], 2, "are no valid range"),
        ("response", &["--sigma=-1"][..], 2, "0 or more"),
        ("response", &["--count", "0"][..], 2, "1..=1000000"),
        ("response", &["--set", "reservoir.fidelity=none"][..], 2, "the reservoir is empty"),
        ("response", &["--set", "reservoir.depth=0"][..], 2, "reservoir.depth"),
        ("impulse", &["--set", "reservoir.fidelity=incompressible"][..], 2, "cofferdam reservoir response"),
        ("impulse", &["--duration", "0"][..], 2, "communication steps"),
        ("impulse", &["--duration", "1e9"][..], 2, "communication steps"),
        ("impulse", &["--ramp=-1"][..], 2, "greater than 0"),
        ("record", &["--at=-1"][..], 2, "from 0 to 91.75 m"),
        ("record", &["--set", "reservoir.fidelity=none"][..], 2, "the reservoir is empty"),
        ("field", &["--omega", "nan"][..], 2, "are no valid frequency"),
        ("field", &["--omega", "20", "--size", "1e-3"][..], 2, "raise --size"),
        ("field", &["--omega", "20", "--set", "reservoir.fidelity=westergaard"][..], 2, "has no field"),
    ] {
        let (found, said) = refused(SCENE, what, more);
        assert!(found == Some(status) && said.contains(word), "{what} {more:?}: {found:?} {said}");
    }
}

#[test]
fn a_folder_with_something_in_it_stays_as_it_is() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("out")).expect("a folder");
    std::fs::write(folder.path().join("out/response.csv"), "precious").expect("a file");
    let output = ask(folder.path(), SCENE, "response", &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("is not empty"), "{said}");
    assert_eq!(std::fs::read(folder.path().join("out/response.csv")).expect("a file"), b"precious");
}

/// Six elements a wave are the least that are not warned of, on the panels of the prescribed dam where these are finer than a
/// sixteenth of the depth.
#[test]
fn frequencies_that_the_elements_do_not_resolve_are_warned_of() {
    let (depth, sound_speed) = (180.0, 1440.0);
    let resolved = |elements: f64| std::f64::consts::TAU * sound_speed * elements / (6.0 * depth);
    for (setting, elements) in
        [("prescribed.batter=20", 16.0), ("prescribed.panels=40", 40.0), ("reservoir.element_size=45", 4.0)]
    {
        for (share, warned) in [(0.99, false), (1.01, true)] {
            let folder = folder();
            let omega = (share * resolved(elements)).to_string();
            let arguments =
                ["--count", "1", "--sigma", "1", "--from", &omega, "--to", &omega, "--set", setting];
            let output = ask(folder.path(), "rigid-dam-ramp", "response", &arguments);
            let complaint = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{complaint}");
            let named =
                complaint.contains("resolve the water up to") && complaint.contains("reservoir.element_size");
            assert_eq!(named, warned, "{setting}, {omega} rad/s: {complaint}");
        }
    }
}
