//! Histories of the results, in the units of the field.

use super::data::{Abscissa, Chart, Mark, Row, Series};
use super::folder::RunFolder;
use super::thinning::{PARTS, differences, kept, rounded, rounded_each};
use cofferdam_assembly::observer::Histories;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::Scene;

/// Largest factor of safety that is drawn.
const SAFE: f64 = 10.0;
/// Utilisation from which a joint counts as sliding: 1 except for rounding.
const SLIDES: f64 = 1.0 - 1e-9;

/// A line: name, column, and factor on the values.
type Line = (String, String, f64);

/// Charts of the recorded histories.
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
    let mut ground = one("ground, positive downstream", "ground_acceleration.x", 1.0 / STANDARD_GRAVITY);
    ground.extend(one("ground, positive upwards", "ground_acceleration.y", 1.0 / STANDARD_GRAVITY));
    add("Ground acceleration, g", "", &ground);
    add(
        "Sliding of each crack, mm",
        "Mean slip along the crack; positive if the upper side moves downstream.",
        &cracks("sliding", 1e3),
    );
    if shears(scene) {
        charts.extend(utilisation(histories, &cracks("shear_utilisation", 1.0)));
    }
    let mut add = |title: &str, about: &str, lines: &[Line]| {
        charts.extend(chart(histories, title, about, false, lines));
    };
    add("Opening of each crack, mm", "Maximum gap over all contacts.", &cracks("opening", 1e3));
    add(
        "Rotation above each crack, mrad",
        "Block above relative to the block below; positive counter-clockwise.",
        &cracks("rotation", 1e3),
    );
    let relative = "Upstream crest corner relative to the ground, from the static state; includes sliding and rocking of the blocks.";
    add("Crest displacement, mm", relative, &crest);
    add(
        "Force on the base, MN/m",
        "Total force on the ground, including weight and hydrostatic pressure.",
        &base,
    );
    add(
        "Base pressure, kPa",
        "Hydrodynamic pressure (excess over hydrostatic) at the foot of the wet face.",
        &waters("base_pressure", 1e-3),
    );
    if scene.has_water() {
        let about = "Minimum over the wet faces, including hydrostatic pressure, relative to the atmosphere; water cavitates near −100 kPa.";
        add("Lowest pressure on the wet face, kPa", about, &one("lowest", "lowest_pressure", 1e-3));
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
    let monitored = "At the monitored points; tension is positive. At heel, toe and neck the stress grows as the mesh is refined.";
    add("Major principal stress, MPa", monitored, false, &stress("major", 1e-6));
    add("Minor principal stress, MPa", "At the monitored points.", false, &stress("minor", 1e-6));
    add(
        "Energy balance, MJ/m",
        "From time 0, in the frame of the ground; the input work is the sum of the other terms, except for the error.",
        false,
        &ledger,
    );
    let iterations = "Number of dam steps until the iteration of a communication step converged.";
    add("Dam steps per communication step", iterations, false, &one("dam steps", "iterations", 1.0));
    let mut residuals = one("pressure residual", "residual.pressure", 1.0);
    residuals.extend(one("estimated interpolation error", "interpolation_error", 1.0));
    add(
        "Coupling residuals, Pa",
        "2-norms over the wet face on a logarithmic scale; zeros are omitted.",
        true,
        &residuals,
    );
    charts
}

/// Names of the cracks.
pub fn crack_names(scene: &Scene) -> Vec<String> {
    let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    cracks
        .iter()
        .map(|crack| if crack.name.is_some() { crack.label() } else { format!("crack at {}", crack.label()) })
        .collect()
}

/// Whether the run has joints that carry shear.
fn shears(scene: &Scene) -> bool {
    scene.dam.as_ref().is_some_and(|dam| !dam.fidelity.is_intact())
}

/// Names of the stress points in the summary.
pub fn stress_names(run: &RunFolder) -> Vec<String> {
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

/// The utilisation of the shear strength, and its inverse.
fn utilisation(histories: &Histories, lines: &[Line]) -> Vec<Chart> {
    let about = "Shear force divided by shear strength of the closed contacts: 1 while the joint slides, 0 while it is open.";
    let Some(mut shares) = chart(histories, "Utilisation of the shear strength", about, false, lines) else {
        return Vec::new();
    };
    shares.range = Some([0.0, 1.05]);
    let inverse = |(name, column, _): &Line| {
        let safety = |share: &f64| if *share > 0.0 { (1.0 / share).min(SAFE) } else { f64::NAN };
        Some((name.clone(), histories.column(column)?.iter().map(safety).collect()))
    };
    let inverses: Vec<(String, Vec<f64>)> = lines.iter().filter_map(inverse).collect();
    let about = "Inverse of the utilisation, drawn up to 10. At 1 the joint slides; no value is lower. Gaps: the joint is open or carries no shear.";
    let mut safety = drawn(histories.rows(), "Factor of safety against sliding", about, false, &inverses);
    safety.range = Some([0.0, SAFE]);
    safety.marks.push(Mark { horizontal: true, at: 1.0, name: "slides".to_owned() });
    vec![shares, safety]
}

/// Time, s, during which the factor of safety of each joint is at or below 1.
pub fn sliding_times(run: &RunFolder) -> Vec<Row> {
    let time = run.histories.column("time").unwrap_or(&[]);
    if !shears(&run.loaded.scene) {
        return Vec::new();
    }
    let of = |(crack, name): (usize, String)| {
        let shares = run.histories.column(&format!("dam.crack_shear_utilisation.{crack}"))?;
        // The value at the end of a step applies to the whole step.
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
