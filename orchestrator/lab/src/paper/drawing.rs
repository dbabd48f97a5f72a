//! Contents of each picture.

use super::document::All;
use super::figure::{self, Panel};
use super::response::{Quantity, levels};
use super::runs::{ADDED_MASS, FINITE_ELEMENTS, RIGID_DAM, Run, Series};
use super::statements::{EARTHQUAKES, Earthquake, Figure};
use crate::study::StudyError;
use cofferdam_analysis::picture::History;

/// All numbers at a glance.
pub fn overview(all: &All) -> Result<String, StudyError> {
    figure::ratios("The paper's numbers and ours", &all.numbers)
}

/// A figure of the paper from our runs.
pub fn picture(figure: &Figure, all: &All) -> Result<String, StudyError> {
    let panels = match figure.number {
        3 => vec![rigid_dam(all)],
        4 => vec![flexible_dam(&all.flexible)],
        7 => both(all, |_, series| pressure(series)),
        8 => accelerations(&EARTHQUAKES[0], &all.cracked[0]),
        9 => accelerations(&EARTHQUAKES[1], &all.cracked[1]),
        10 => crest(&EARTHQUAKES[0], &all.cracked[0]),
        11 => crest(&EARTHQUAKES[1], &all.cracked[1]),
        12 => both(all, sliding),
        _ => both(all, rotation),
    };
    let title = format!("Figure {}: {}", figure.number, figure.title);
    let mut notes = vec![format!("The paper: {}.", figure.says), format!("It leaves open: {}.", figure.open)];
    notes.extend(all.sources(figure.number).into_iter().map(|source| format!("Record: {source}.")));
    figure::histories(&title, &notes, &panels)
}

/// A panel for each earthquake.
fn both(all: &All, lines: fn(&Earthquake, &Series) -> (Quantity, Vec<History>)) -> Vec<Panel> {
    let of = |(earthquake, series): (&Earthquake, &Series)| {
        let (quantity, lines) = lines(earthquake, series);
        (format!("{}: {}", earthquake.name, quantity.axis()), lines)
    };
    EARTHQUAKES.iter().zip(&all.cracked).map(of).collect()
}

fn rigid_dam(all: &All) -> Panel {
    let factor = all.coefficient();
    let time = all.rigid.base().response.time();
    let mut lines: Vec<History> = ["constant", "linear"]
        .iter()
        .enumerate()
        .map(|(colour, order)| {
            let label = format!("{order} elements");
            all.rigid.run(order).response.line(&label, colour, Quantity::BasePressure, factor)
        })
        .collect();
    let points = time.iter().zip(&all.exact).map(|(time, value)| (*time, factor * value)).collect();
    lines.push(History { label: "closed form".to_owned(), colour: 0, dashed: true, points });
    ("C_p = p / ρah".to_owned(), lines)
}

fn flexible_dam(series: &Series) -> Panel {
    let quantity = Quantity::BasePressure;
    let runs = [
        ("boundary elements", series.base()),
        ("finite elements", series.run(FINITE_ELEMENTS)),
        ("rigid dam", series.run(RIGID_DAM)),
    ];
    (quantity.axis().to_owned(), lines(&runs, quantity))
}

/// A line of each run, by its label.
fn lines(runs: &[(&str, &Run)], quantity: Quantity) -> Vec<History> {
    let of = |(colour, (label, run)): (usize, &(&str, &Run))| run.response.line(label, colour, quantity, 1.0);
    runs.iter().enumerate().map(of).collect()
}

fn pressure(series: &Series) -> (Quantity, Vec<History>) {
    let runs = [("flexible dam", series.base()), (RIGID_DAM, series.run(RIGID_DAM))];
    (Quantity::BasePressure, lines(&runs, Quantity::BasePressure))
}

fn accelerations(earthquake: &Earthquake, series: &Series) -> Vec<Panel> {
    let [below, above] = earthquake.accelerations;
    [(Quantity::Below, Some(below)), (Quantity::Above, Some(above)), (Quantity::Crest, None)]
        .map(|(quantity, stated)| {
            let mut lines = vec![series.base().response.line("ours", 0, quantity, 1.0)];
            if let Some(stated) = stated {
                lines.extend(levels(&format!("paper: {stated} g"), &[stated, -stated], &lines));
            }
            (quantity.axis().to_owned(), lines)
        })
        .into()
}

fn crest(earthquake: &Earthquake, series: &Series) -> Vec<Panel> {
    [Quantity::Downstream, Quantity::Upwards]
        .map(|quantity| {
            let mut lines = lines(&waters(series), quantity);
            if quantity == Quantity::Downstream {
                let [swing, time] = earthquake.first_swing;
                let label = format!("paper, first large one: {swing} mm at {time} s");
                lines.extend(levels(&label, &[swing], &lines));
            }
            (quantity.axis().to_owned(), lines)
        })
        .into()
}

/// Of boundary elements and of finite ones.
fn waters(series: &Series) -> [(&str, &Run); 2] {
    [("water of boundary elements", series.base()), (FINITE_ELEMENTS, series.run(FINITE_ELEMENTS))]
}

fn sliding(earthquake: &Earthquake, series: &Series) -> (Quantity, Vec<History>) {
    let [boundary, finite] = waters(series);
    let runs = [boundary, finite, (ADDED_MASS, series.run(ADDED_MASS))];
    let mut lines = lines(&runs, Quantity::Sliding);
    let [residual, _] = earthquake.sliding;
    lines.extend(levels(&format!("paper, residual: {residual} mm"), &[residual], &lines));
    (Quantity::Sliding, lines)
}

fn rotation(earthquake: &Earthquake, series: &Series) -> (Quantity, Vec<History>) {
    let quantity = Quantity::Rotation;
    let mut lines = vec![series.base().response.line("ours", 0, quantity, 1.0)];
    let stated = earthquake.rotation;
    lines.extend(levels(&format!("paper, largest: {stated} mrad"), &[stated, -stated], &lines));
    (quantity, lines)
}
