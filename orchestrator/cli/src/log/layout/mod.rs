//! `cofferdam log layout`.

mod foxglove;
mod plotjuggler;

use super::Failure;
use super::error::write_new;
use crate::terminal::print;
use clap::ValueEnum;
use cofferdam_log::{Head, Log};
use std::path::PathBuf;

/// Arguments of `cofferdam log layout`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Log (log.mcap) or folder of a run
    log: PathBuf,
    /// Program to write the layout for
    #[arg(long = "for", value_enum, value_name = "PROGRAM", default_value_t = Viewer::Foxglove)]
    viewer: Viewer,
    /// File to write (default: standard output)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A program that shows logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Viewer {
    /// Foxglove: JSON, to be imported as a layout
    Foxglove,
    /// PlotJuggler: XML, which also names the log
    Plotjuggler,
}

pub const HELP: &str = "\
The layout plots crest displacement, sliding, norm of the pressure, iterations
and residual, as far as the units in the log have them. In Foxglove, choose
Layouts, Import from file, and open the log; values of the units are the
accepted ones. PlotJuggler loads the log with the layout and plots the values
of every iteration at the end of its step.

Examples:
  cofferdam log layout runs/koyna --output koyna.json
  cofferdam log layout runs/koyna --for plotjuggler --output koyna.xml \\
    && plotjuggler --layout koyna.xml

Exit status: 0; 1 if the log cannot be read or the file cannot be written.";

/// A plot of one or several curves.
struct Plot {
    title: &'static str,
    curves: Vec<Curve>,
}

/// A field of a topic over time.
struct Curve {
    /// Name in the legend.
    label: String,
    topic: String,
    field: String,
    index: Option<usize>,
    /// Whether messages of iterations that were not accepted are in the topic too.
    iterates: bool,
}

impl Curve {
    fn of_step(field: &str) -> Self {
        let (label, topic, field) = (field.replace('_', " "), "/step".to_owned(), field.to_owned());
        Self { label, topic, field, index: None, iterates: false }
    }
}

/// Colours of curves, one after another.
const COLOURS: [&str; 4] = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728"];

/// Prints or writes a layout.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = Log::open(&arguments.log)?;
    let plots = plots(log.head());
    let text = match arguments.viewer {
        Viewer::Foxglove => foxglove::layout(&plots),
        Viewer::Plotjuggler => plotjuggler::layout(&plots, log.path(), log.head()),
    };
    match &arguments.output {
        None => print(text.trim_end()),
        Some(path) => {
            write_new(path, &text)?;
            print(format!("{}: {} plots", path.display(), plots.len()));
        }
    }
    Ok(())
}

/// The plots of what the units of a log have.
fn plots(head: &Head) -> Vec<Plot> {
    let titled = |title, curves: Vec<Curve>| Plot { title, curves };
    let mut plots = vec![
        titled("Crest displacement, m", answers(head, "crest_displacement", &["x", "y"])),
        titled("Sliding, m", answers(head, "crack_sliding", &[])),
        titled("Norm of the pressure on the wet face, Pa", norms(head, "interface_pressure")),
        titled("Iterations", vec![Curve::of_step("iterations")]),
        titled("Residual, Pa", vec![Curve::of_step("residual_pressure")]),
    ];
    plots.retain(|plot| !plot.curves.is_empty());
    plots
}

/// Every value of an output variable, named by `axes` or numbered.
fn answers(head: &Head, variable: &str, axes: &[&str]) -> Vec<Curve> {
    let of_unit = head.units.iter().flat_map(|unit| {
        let channel = unit.outputs.channels().map(|(channel, _)| channel).find(|c| c.name == variable);
        let indices = channel.into_iter().flat_map(|channel| {
            let array = channel.shape.is_array();
            (0..channel.size).map(move |index| array.then_some(index))
        });
        indices.map(|index| {
            let suffix = index.map(|index| match axes.get(index) {
                Some(axis) => format!(".{axis}"),
                None => format!(".{index}"),
            });
            Curve {
                label: format!("{}.{variable}{}", unit.name, suffix.unwrap_or_default()),
                topic: format!("/{}/answer", unit.name),
                field: variable.to_owned(),
                index,
                iterates: true,
            }
        })
    });
    of_unit.collect()
}

/// The norm of an output array in each unit that has it.
fn norms(head: &Head, variable: &str) -> Vec<Curve> {
    let has = |layout: &cofferdam_coupling::participant::Layout| {
        layout.channels().any(|(channel, _)| channel.name == variable && channel.shape.is_array())
    };
    let units = head.units.iter().filter(|unit| has(&unit.outputs));
    let curve = |name: &String| Curve {
        label: format!("{name}.{variable}"),
        topic: format!("/{name}/answer"),
        field: format!("{variable}_norm"),
        index: None,
        iterates: true,
    };
    units.map(|unit| curve(&unit.name)).collect()
}
