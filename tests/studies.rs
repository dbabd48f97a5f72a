//! The coarse twins of `cofferdam study`: what docs/stability.md and docs/tradeoff.md show, small.

use std::path::Path;
use std::process::Command;
use whole_chain::scenario::{binary, root};

/// Rows of the table that the study leaves, by heading.
fn study(name: &str, scene: &str, settings: &[&str], output: &Path) -> Vec<Vec<String>> {
    let mut command = Command::new(binary());
    command.args(["study", name, "--coarse", "--output"]).arg(output).arg(root().join("scenes").join(scene));
    for setting in settings {
        command.args(["--set", setting]);
    }
    let done = command.output().expect("cofferdam runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    println!("{}", String::from_utf8_lossy(&done.stdout));
    let picture = std::fs::read_to_string(output.join(format!("{name}.svg"))).expect("a picture");
    assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"), "{picture}");
    assert!(output.join(format!("{name}.md")).is_file());
    let mut table = csv::Reader::from_path(output.join(format!("{name}.csv"))).expect("a table");
    table.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect()).collect()
}

#[test]
fn quasi_newton_converges_where_plain_iteration_diverges_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = study("stability", "koyna-intact", &[], &folder.path().join("s"));
    assert_eq!(rows.len(), 2 * 4 * 3 * 3);
    for row in rows {
        let [water, _, acceleration, density, step, verdict, mean, _] = &row[..] else { panic!("{row:?}") };
        let (density, step): (f64, f64) =
            (density.parse().expect("a number"), step.parse().expect("a number"));
        match &**acceleration {
            "interface-jacobian" | "iqn-ils" => {
                let most = if acceleration == "iqn-ils" { 12.0 } else { 4.0 };
                assert_eq!(verdict, "converges", "{row:?}");
                assert!(mean.parse::<f64>().is_ok_and(|mean| mean <= most), "{row:?}");
            }
            // Water of the concrete's weight or a third of it, on which short steps cannot lean.
            "constant" if water == "incompressible" && density > 0.3 && step < 0.01 => {
                assert_eq!(verdict, "diverges", "{row:?}");
            }
            _ if density < 0.1 => assert_eq!(verdict, "converges", "{row:?}"),
            _ => {}
        }
    }
}

#[test]
fn a_tighter_tolerance_brings_the_error_down_and_costs_iterations() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings =
        ["dam.element_size=20", "ground_motion.record.start=4", "ground_motion.record.end=5", "time.quiet=0"];
    let rows = study("tolerance", "koyna-intact", &settings, &folder.path().join("t"));
    let column =
        |index: usize| -> Vec<f64> { rows.iter().map(|row| row[index].parse().expect("a number")).collect() };
    let (tolerance, iterations, crest) = (column(0), column(1), column(4));
    assert_eq!(tolerance, [1e-2, 1e-4, 1e-6, 1e-8]);
    assert!(iterations.windows(2).all(|pair| pair[0] <= pair[1]), "{iterations:?}");
    assert!(crest[1] < crest[0] && crest.windows(2).all(|pair| pair[1] <= pair[0]), "{crest:?}");
    for (tolerance, crest) in tolerance.iter().zip(&crest) {
        assert!(*crest < *tolerance, "{crest} at {tolerance}");
    }
}

#[test]
fn ambient_vibration_makes_no_energy() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = ["dam.element_size=10", "reservoir.element_size=10"];
    let rows = study("ambient", "koyna-northridge-1994", &settings, &folder.path().join("a"));
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let values: Vec<f64> = row.iter().map(|cell| cell.parse().expect("a number")).collect();
        let [_, stored, _, damped, _, missed, work, produced] = values[..] else { panic!("{row:?}") };
        assert!(damped > 0.0 && stored > 0.0, "{row:?}");
        assert!(missed.abs() < 2e-3 * stored.max(damped), "{row:?}");
        assert!(produced.abs() < 2e-3 * work.abs(), "{row:?}");
    }
}
