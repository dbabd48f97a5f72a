//! Histories of the results, in the units of the field.

use super::super::resultant;
use super::data::{Abscissa, Chart, Mark, Row, Series};
use super::folder::RunFolder;
use super::thinning::{PARTS, differences, kept, rounded, rounded_each};
use cofferdam_assembly::observer::Histories;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::Scene;
use std::collections::BTreeMap;

/// Rate of the mean slip of a joint above which it counts as slipping, m/s.
const SLIP_RATE: f64 = 5e-3;
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

/// Demand over capacity of each joint in shear.
fn utilisation(histories: &Histories, lines: &[Line]) -> Option<Chart> {
    let about = "Shear force over the shear strength of the closed contacts. At 1 all of them slip and the joint slides as a whole; parts \
                 of it slip before. 0 while the joint is open.";
    let mut shares = chart(histories, "Shear demand over capacity", about, false, lines)?;
    shares.range = Some([0.0, 1.05]);
    shares.marks.push(Mark { horizontal: true, at: 1.0, name: "slides".to_owned() });
    Some(shares)
}

/// The resultant of joints over time, by the lengths (m) of their cracks.
pub fn resultants(run: &RunFolder, lengths: &BTreeMap<usize, f64>) -> Option<Chart> {
    let names = crack_names(&run.loaded.scene);
    let line = |(crack, length): (&usize, &f64)| {
        let shares = resultant::shares(&run.histories, *crack, *length)?;
        Some((names.get(*crack)?.clone(), shares.into_iter().map(|share| 100.0 * share).collect()))
    };
    let lines: Vec<(String, Vec<f64>)> = lengths.iter().filter_map(line).collect();
    let about = "Where the effective normal forces act. Gaps: the joint carries less than a tenth of its normal force at rest.";
    let title = "Resultant in the joint, % of its length from the toe";
    let mut chart = drawn(run.histories.rows(), title, about, false, &lines);
    chart.range = Some([0.0, 100.0]);
    let third = |at: f64, name: &str| Mark { horizontal: true, at, name: name.to_owned() };
    chart.marks = vec![third(100.0 / 3.0, "middle third"), third(200.0 / 3.0, "")];
    (!lines.is_empty()).then_some(chart)
}

/// For how long (s) each joint was at its shear strength, and for how long its mean slip grew faster than [`SLIP_RATE`].
pub fn sliding_times(run: &RunFolder) -> Vec<Row> {
    if !shears(&run.loaded.scene) {
        return Vec::new();
    }
    let names = crack_names(&run.loaded.scene).into_iter().enumerate();
    names.flat_map(|(crack, name)| times_of(&run.histories, crack, &name)).collect()
}

fn times_of(histories: &Histories, crack: usize, name: &str) -> Vec<Row> {
    let time = histories.column("time").unwrap_or(&[]);
    let steps = || time.windows(2).map(|pair| pair[1] - pair[0]);
    let column = |name: &str| histories.column(&format!("dam.crack_{name}.{crack}"));
    let (Some(shares), Some(sliding)) = (column("shear_utilisation"), column("sliding")) else {
        return Vec::new();
    };
    let end = time.last().copied().unwrap_or(0.0);
    // the value at the end of a step applies to the whole step
    let whole = steps().zip(shares.iter().skip(1)).filter(|(_, share)| **share >= SLIDES);
    let slips = steps().zip(sliding.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
    let fast = slips.filter(|(step, slip)| *slip > SLIP_RATE * step);
    vec![
        Row::number(format!("{name}: slides as a whole"), whole.map(|(step, _)| step).sum(), "s")
            .with(format!("of {end:.3} s; all closed contacts at their shear strength")),
        Row::number(format!("{name}: mean slip"), fast.map(|(step, _)| step).sum(), "s").with(format!(
            "of {end:.3} s; faster than {} mm/s, also where only a part of the contacts slips; elastic shear of the joint included",
            1e3 * SLIP_RATE
        )),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::data::Value;
    use super::*;

    fn histories(text: &str) -> std::io::Result<Histories> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("histories.csv");
        std::fs::write(&path, text)?;
        Histories::read(&path).map_err(std::io::Error::other)
    }

    #[test]
    fn joint_slides_as_a_whole_for_less_time_than_parts_of_it_slip() -> std::io::Result<()> {
        let histories = histories(
            "time [s],dam.crack_shear_utilisation.0 [1],dam.crack_sliding.0 [m]\n0,0.5,0\n1,0.9,0.01\n3,1,0.05\n3.5,0.2,0.05\n",
        )?;
        let values: Vec<_> = times_of(&histories, 0, "neck").into_iter().map(|row| row.value).collect();
        assert_eq!(values, [Value::Number(2.0, "s"), Value::Number(3.0, "s")]);
        let chart =
            utilisation(&histories, &[("a".to_owned(), "dam.crack_shear_utilisation.0".to_owned(), 1.0)]);
        let values =
            chart.map(|chart| chart.series[0].values.iter().map(|value| value.0).collect::<Vec<_>>());
        assert_eq!(values, Some(vec![0.5, 0.9, 1.0, 0.2]));
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
