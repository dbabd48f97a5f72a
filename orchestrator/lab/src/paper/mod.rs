//! `cofferdam-lab paper`: the quantities of the paper's figures from our runs, compared with the statements of its text.

mod claims;
mod document;
mod drawing;
mod figure;
mod numbers;
mod response;
mod runs;
mod statements;

use crate::study::{Arguments, StudyError};
use crate::terminal::print;
use numbers::Number;
use statements::{EARTHQUAKES, FIGURES, RIGID};
use std::path::PathBuf;

pub const HELP: &str = "\
Runs the scenes of the paper's figures 3, 4 and 7 to 13, and plots the quantity
of each figure together with the statements in the paper's text and the choices
it leaves open. The cracked dam also runs with alternatives of the open
choices: direction of the record, damping, plane condition, contact points,
stiffness of the crack, and mesh. No values are read off the paper's figures.

The paper's records are not distributed. Other records replace them, which
every figure states. Your own records are used unmodified, in the unit given in
their headers, or g.

Writes paper.md; paper.csv (numbers), claims.csv (statements in words),
open.csv (alternatives); paper.svg and figure-3.svg to figure-13.svg. With
--coarse, a part of each record, 10 m elements and few choices.

Example:
  cofferdam-lab paper --output studies/paper

Exit status: 0 completed, 1 results could not be written, 2 a scene or a record
is invalid, 3 a run failed, 4 a unit cannot be created.";

/// Arguments of the study.
#[derive(clap::Args)]
pub struct PaperArguments {
    /// Record of Koyna 1967, stream component, .csv or .at2
    #[arg(long, value_name = "FILE")]
    koyna_record: Option<PathBuf>,

    /// Record of Newhall 1994, .csv or .at2
    #[arg(long, value_name = "FILE")]
    newhall_record: Option<PathBuf>,

    /// Record of El Centro 1940, .csv or .at2
    #[arg(long, value_name = "FILE")]
    el_centro_record: Option<PathBuf>,

    /// Folder with the scenes rigid-dam-ramp, paper-figure-4, paper-koyna-1967 and paper-newhall-1994
    #[arg(long, value_name = "DIR", default_value = "scenes")]
    scenes: PathBuf,

    /// Folder for tables and figures; created if necessary, and must be empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Use parts of the records, coarse meshes and few choices
    #[arg(long)]
    coarse: bool,
}

pub fn run(arguments: &PaperArguments) -> Result<(), StudyError> {
    let PaperArguments { koyna_record, newhall_record, el_centro_record, scenes, output, coarse } = arguments;
    // All scenes and records are checked before anything is computed.
    let output =
        Arguments { scene: scenes.join(RIGID), set: Vec::new(), output: output.clone(), coarse: *coarse };
    let mut rigid = runs::rigid_dam(scenes, *coarse)?;
    let mut flexible = runs::flexible_dam(scenes, el_centro_record.as_ref(), *coarse)?;
    let [koyna, newhall] = &EARTHQUAKES;
    let mut cracked = [
        runs::cracked_dam(scenes, koyna, koyna_record.as_ref(), *coarse)?,
        runs::cracked_dam(scenes, newhall, newhall_record.as_ref(), *coarse)?,
    ];
    output.load()?;

    let [first, second] = &mut cracked;
    runs::solve(&mut [first, second, &mut flexible, &mut rigid])?;
    for series in &mut cracked {
        series.add_together()?;
    }
    let [first, second] = &mut cracked;
    runs::solve(&mut [first, second])?;

    let exact = document::closed_form(&rigid)?;
    let errors = ["constant", "linear"].map(|order| document::error(rigid.run(order), &exact));
    let mut statements = vec![claims::of_elements(errors), claims::of_flexible_dam(&flexible)];
    let mut stated: Vec<Number> = Vec::new();
    for (earthquake, series) in EARTHQUAKES.iter().zip(&cracked) {
        statements.extend(claims::of_cracked_dam(earthquake, series));
        stated.extend(numbers::of(earthquake, series));
    }
    statements.sort_by_key(|claim| claim.figure);
    stated.sort_by_key(|number| number.figure);
    let all = document::All { rigid, exact, flexible, cracked, numbers: stated, claims: statements };

    let text = document::text(arguments, &all);
    print(&text);
    output.write("paper.md", &text)?;
    output.write_table("paper.csv", &numbers::table(&all.numbers))?;
    output.write_table("claims.csv", &claims::table(&all.claims))?;
    output.write_table("open.csv", &document::open_choices(&all.cracked))?;
    output.write("paper.svg", &drawing::overview(&all)?)?;
    for figure in &FIGURES {
        output.write(&format!("figure-{}.svg", figure.number), &drawing::picture(figure, &all)?)?;
    }
    Ok(())
}
