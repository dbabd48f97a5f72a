//! Histories of the results, in the units of the field.

use super::data::{Abscissa, Chart, Mark, Row, Series};
use super::folder::RunFolder;
use super::thinning::{PARTS, differences, kept, rounded, rounded_each};
use cofferdam_assembly::observer::Histories;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::Scene;

/// Largest factor of safety that is drawn.
const SAFE: f64 = 10.0;
/// Share of the shear strength in use from which a joint counts as sliding: 1 but for rounding.
const SLIDES: f64 = 1.0 - 1e-9;

/// A line: its name, a column, and what its values are multiplied by.
type Line = (String, String, f64);

/// The charts of what the run recorded.
pub fn of(run: &RunFolder) -> Vec<Chart> {
    let (histories, scene) = (&run.histories, &run.loaded.scene);
    let one = |name: &str, column: &str, factor: f64| vec![(name.to_owned(), column.to_owned(), factor)];
    let cracks = |what: &str, factor: f64| -> Vec<Line> {
        let names = crack_names(scene).into_iter().enumerate();
        names.map(|(crack, name)| (name, format!("dam.crack_{what}.{crack}"), factor)).collect()
    };
    let waters = |column: &str, factor: f64| -> Vec<Line> {
        ["reservoir", "tailwater"].map(|water| (water.to_owned(), format!("{water}.{column}"), factor)).into()
    };
    let energies =
        ["kinetic energy", "strain energy", "contact energy", "friction work", "damping work", "input work"];
    let mut ledger: Vec<Line> =
        energies.map(|name| (name.to_owned(), format!("dam.{}", name.replace(' ', "_")), 1e-6)).into();
    ledger.push(("error".to_owned(), "dam.energy_balance_error".to_owned(), 1e-6));
    let crest = ["x", "y"].map(|axis| format!("dam.crest_displacement.{axis}"));
    let crest: Vec<Line> = ["horizontal, positive downstream", "vertical, positive upwards"]
        .into_iter()
        .zip(crest)
        .map(|(name, column)| (name.to_owned(), column, 1e3))
        .collect();
    let mut base = one("shear, positive downstream", "dam.base_shear", 1e-6);
    base.extend(one("normal force, positive downwards", "dam.base_normal_force", 1e-6));
    let mut charts = Vec::new();
    let mut add = |title: &str, about: &str, lines: &[Line]| {
        charts.extend(chart(histories, title, about, false, lines));
    };
    add(
        "Ground acceleration, g",
        "",
        &one("ground, positive downstream", "ground_acceleration.x", 1.0 / STANDARD_GRAVITY),
    );
    let relative = "Of the upstream crest corner, relative to the ground, from the state of rest; sliding and rocking below it included.";
    add("Crest displacement, mm", relative, &crest);
    add(
        "Sliding of each crack, mm",
        "Mean slip along the crack, positive where the upper side goes downstream.",
        &cracks("sliding", 1e3),
    );
    add("Opening of each crack, mm", "Largest gap of any contact.", &cracks("opening", 1e3));
    add(
        "Rotation above each crack, mrad",
        "Of the block above against the block below, positive counter-clockwise.",
        &cracks("rotation", 1e3),
    );
    add(
        "Base pressure, kPa",
        "Hydrodynamic: excess over hydrostatic, at the foot of the wet face.",
        &waters("base_pressure", 1e-3),
    );
    if scene.has_water() {
        let about = "The least on any wet face, hydrostatic included, against the atmosphere; near −100 kPa real water cavitates.";
        add("Lowest pressure on the wet face, kPa", about, &one("lowest", "lowest_pressure", 1e-3));
    }
    add(
        "Force on the base, MN/m",
        "Total force on the ground: weight and hydrostatic water are in it.",
        &base,
    );
    if shears(scene) {
        charts.extend(utilisation(histories, &cracks("shear_utilisation", 1.0)));
    }
    let mut add = |title: &str, about: &str, logarithmic: bool, lines: &[Line]| {
        charts.extend(chart(histories, title, about, logarithmic, lines));
    };
    let stress = |which: &str, factor: f64| -> Vec<Line> {
        let names = stress_names(run);
        let columns = histories.names().iter().filter_map(|name| {
            let column = name.split(" [").next()?;
            let point: usize =
                column.strip_prefix(&format!("dam.{which}_principal_stress."))?.parse().ok()?;
            let name = names.get(point).cloned().unwrap_or_else(|| format!("point {point}"));
            Some((name, column.to_owned(), factor))
        });
        columns.collect()
    };
    let watched =
        "At the watched points, tension positive; at heel, toe and neck it grows as the mesh is refined.";
    add("Major principal stress, MPa", watched, false, &stress("major", 1e-6));
    add("Minor principal stress, MPa", watched, false, &stress("minor", 1e-6));
    add(
        "Energy ledger, MJ/m",
        "Since time 0, in the frame of the ground; the input is the sum of all others but for the error.",
        false,
        &ledger,
    );
    let iterations = "How often the dam took the same communication step until both units agreed.";
    add("Dam steps per communication step", iterations, false, &one("dam steps", "iterations", 1.0));
    let mut residuals = one("residual of the pressure", "residual.pressure", 1.0);
    residuals.extend(one("error of its interpolation, estimate", "interpolation_error", 1.0));
    add(
        "Residuals of the coupling, Pa",
        "2-norms over the wet face, logarithmic; zeros are left out.",
        true,
        &residuals,
    );
    charts
}

/// What the cracks are called.
pub fn crack_names(scene: &Scene) -> Vec<String> {
    let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    cracks
        .iter()
        .map(|crack| if crack.name.is_some() { crack.label() } else { format!("crack at {}", crack.label()) })
        .collect()
}

/// Whether the run has joints whose strength is used.
fn shears(scene: &Scene) -> bool {
    scene.dam.as_ref().is_some_and(|dam| !dam.fidelity.is_intact())
}

/// What the summary calls the points where stress is watched.
fn stress_names(run: &RunFolder) -> Vec<String> {
    let of = |name: &str| name.strip_prefix("largest tension, ").map(str::to_owned);
    run.summary.quantities.iter().filter_map(|quantity| of(&quantity.name)).collect()
}

/// The lines whose columns were recorded; none if all are missing or zero.
fn chart(
    histories: &Histories,
    title: &str,
    about: &str,
    logarithmic: bool,
    lines: &[Line],
) -> Option<Chart> {
    let scaled = |(name, column, factor): &Line| {
        let values: Vec<f64> = histories.column(column)?.iter().map(|value| factor * value).collect();
        Some((name.clone(), values))
    };
    let lines: Vec<(String, Vec<f64>)> = lines.iter().filter_map(scaled).collect();
    let moves = lines.iter().any(|(_, values)| values.iter().any(|value| *value != 0.0));
    moves.then(|| drawn(histories.rows(), title, about, logarithmic, &lines))
}

fn drawn(rows: usize, title: &str, about: &str, logarithmic: bool, lines: &[(String, Vec<f64>)]) -> Chart {
    let values: Vec<&[f64]> = lines.iter().map(|(_, values)| values.as_slice()).collect();
    let rows = kept(rows, &values, PARTS);
    let line = |(name, values): &(String, Vec<f64>)| {
        let values: Vec<f64> = rows.iter().map(|row| values[*row]).collect();
        let values = if logarithmic { rounded_each(&values) } else { rounded(&values) };
        Series { name: name.clone(), values }
    };
    Chart {
        title: title.to_owned(),
        about: about.to_owned(),
        abscissa: Abscissa::Rows(differences(&rows)),
        logarithmic,
        range: None,
        series: lines.iter().map(line).collect(),
        marks: Vec::new(),
    }
}

/// The share of the shear strength in use, and its inverse.
fn utilisation(histories: &Histories, lines: &[Line]) -> Vec<Chart> {
    let about = "Shear force over shear strength of the closed contacts; 1 while the joint slides, 0 while it is open.";
    let Some(mut shares) = chart(histories, "Share of the shear strength in use", about, false, lines) else {
        return Vec::new();
    };
    shares.range = Some([0.0, 1.05]);
    let inverse = |(name, column, _): &Line| {
        let safety = |share: &f64| if *share > 0.0 { (1.0 / share).min(SAFE) } else { f64::NAN };
        Some((name.clone(), histories.column(column)?.iter().map(safety).collect()))
    };
    let inverses: Vec<(String, Vec<f64>)> = lines.iter().filter_map(inverse).collect();
    let about = "Inverse of the share in use, drawn up to 10; at 1 the joint slides, and no value falls below. Gaps: the joint is open, or not sheared.";
    let mut safety = drawn(histories.rows(), "Safety against sliding", about, false, &inverses);
    safety.range = Some([0.0, SAFE]);
    safety.marks.push(Mark { horizontal: true, at: 1.0, name: "slides".to_owned() });
    vec![shares, safety]
}

/// For each joint the time, s, in which its safety is at or below 1.
pub fn sliding_times(run: &RunFolder) -> Vec<Row> {
    let time = run.histories.column("time").unwrap_or(&[]);
    if !shears(&run.loaded.scene) {
        return Vec::new();
    }
    let of = |(crack, name): (usize, String)| {
        let shares = run.histories.column(&format!("dam.crack_shear_utilisation.{crack}"))?;
        // The value at the end of a step stands for the step.
        let steps = time.windows(2).zip(shares.get(1..)?);
        let slid = steps
            .filter(|(_, share)| **share >= SLIDES)
            .fold(0.0, |sum, (pair, _)| sum + (pair[1] - pair[0]));
        let end = time.last().copied().unwrap_or(0.0);
        Some(Row::number(name, slid, "s").with(format!("of {end:.3} s")))
    };
    crack_names(&run.loaded.scene).into_iter().enumerate().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn histories(text: &str) -> std::io::Result<Histories> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("histories.csv");
        std::fs::write(&path, text)?;
        Histories::read(&path).map_err(std::io::Error::other)
    }

    #[test]
    fn safety_is_the_inverse_and_ends_at_ten() -> std::io::Result<()> {
        let histories = histories("time [s],u [1]\n0,0\n1,0.5\n2,1\n3,0.01\n")?;
        let charts = utilisation(&histories, &[("a".to_owned(), "u".to_owned(), 1.0)]);
        let values =
            |chart: usize| charts[chart].series[0].values.iter().map(|value| value.0).collect::<Vec<_>>();
        assert_eq!(values(0), [0.0, 0.5, 1.0, 0.01]);
        let safety = values(1);
        assert!(safety[0].is_nan());
        assert_eq!(safety[1..], [2.0, 1.0, 10.0]);
        Ok(())
    }

    #[test]
    fn what_was_not_recorded_or_is_zero_is_not_drawn() -> std::io::Result<()> {
        let histories = histories("time [s],a [Pa],b [Pa]\n0,0,1\n1,0,2\n")?;
        let line = |column: &str| (column.to_owned(), column.to_owned(), 10.0);
        assert_eq!(chart(&histories, "", "", false, &[line("c")]), None);
        assert_eq!(chart(&histories, "", "", false, &[line("a")]), None);
        let chart = chart(&histories, "", "", false, &[line("a"), line("b"), line("c")]).expect("a chart");
        assert_eq!(chart.series.iter().map(|line| &*line.name).collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!(chart.series[1].values.iter().map(|value| value.0).collect::<Vec<_>>(), [10.0, 20.0]);
        Ok(())
    }
}
