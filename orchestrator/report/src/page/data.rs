//! Contents of a report, independent of their layout.

use super::super::Quantity;
use super::super::stability::StabilityTable;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// Contents of the report of a run. Items that the run lacks are empty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportData {
    /// Title of the scene.
    pub title: String,
    /// Name of the case.
    pub name: String,
    /// How the run ended.
    pub status: String,
    /// Whether the run reached its planned end.
    pub complete: bool,
    /// When it began, in UTC.
    pub started: String,
    /// Simulated time that was reached, s.
    pub simulated_time: f64,
    /// The project and who signs for the report.
    pub project: Vec<Row>,
    /// The results against the limits of the scene.
    pub acceptance: Vec<Check>,
    /// The key figures.
    pub key_figures: Vec<Quantity>,
    /// Ranges of key figures over models, numerics and motion, in words, by the names of the key figures.
    pub ranges: BTreeMap<String, String>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Notes.
    pub notes: Vec<String>,
    /// Limitations of the model, one sentence each.
    pub not_modelled: Vec<String>,
    /// The section as SVG.
    pub section: Option<String>,
    /// The envelope of the largest principal stress.
    pub envelope: Option<Envelope>,
    /// The animation of the dam.
    pub animation: Option<Animation>,
    /// Inputs of the run, by subject.
    pub inputs: Vec<Group>,
    /// Provenance: program, machine, hashes.
    pub provenance: Group,
    /// The scene with all defaults, TOML.
    pub scene: String,
    /// Intensity of the ground motion.
    pub ground: Vec<Row>,
    /// Times of all rows of the histories, s.
    pub time: Vec<f64>,
    /// The ground motion: history and response spectrum.
    pub ground_charts: Vec<Chart>,
    /// Histories of the results.
    pub histories: Vec<Chart>,
    /// For how long each joint slid.
    pub sliding_times: Vec<Row>,
    /// Response spectra of ground and crest.
    pub spectra: Vec<Chart>,
    /// Pressure over height at chosen instants.
    pub profiles: Vec<Profile>,
    /// Stability of the joints, and what its numbers rest on.
    pub stability: (Vec<StabilityTable>, Vec<String>),
    /// The resultant in the joints over time.
    pub resultants: Vec<Chart>,
    /// Self-checks of the run.
    pub checks: Vec<Check>,
    /// The whole table of the summary.
    pub quantities: Vec<Quantity>,
}

/// The envelope of the largest principal stress over the section.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Envelope {
    /// End time, s.
    pub end: f64,
    /// The section coloured by it, SVG.
    pub picture: String,
    /// Strength and overstress; empty without a tensile strength.
    pub rows: Vec<Row>,
    /// Verdict on the overstress; none without a tensile strength.
    pub performance: Option<Performance>,
}

/// Verdict of a criterion for linear analyses on the overstress.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Performance {
    /// The verdict, in words.
    pub verdict: String,
    /// What limits its validity.
    pub about: String,
    /// The parts of the criterion.
    pub criteria: Vec<Check>,
    /// Cumulative duration over the demand-capacity ratio; none if no stress point exceeds its strength.
    pub durations: Option<Chart>,
}

/// Rows under a heading.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Group {
    /// The heading.
    pub name: String,
    /// The rows.
    pub rows: Vec<Row>,
}

/// A line of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// Remark; may be empty.
    pub remark: String,
}

/// A value in a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Value {
    /// A number with its unit, `1` for none.
    Number(f64, &'static str),
    /// Words.
    Text(String),
    /// A hash or a path.
    Code(String),
}

impl Row {
    /// A number in `unit`.
    pub fn number(name: impl Into<String>, value: f64, unit: &'static str) -> Self {
        Self { name: name.into(), value: Value::Number(value, unit), remark: String::new() }
    }

    /// Words.
    pub fn text(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), value: Value::Text(text.into()), remark: String::new() }
    }

    /// A hash or a path.
    pub fn code(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), value: Value::Code(text.into()), remark: String::new() }
    }

    /// The same with a remark.
    pub fn with(self, remark: impl Into<String>) -> Self {
        Self { remark: remark.into(), ..self }
    }
}

/// Lines over one abscissa.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chart {
    /// What it shows, with its unit.
    pub title: String,
    /// Explanation; may be empty.
    pub about: String,
    /// The abscissa.
    pub abscissa: Abscissa,
    /// Whether the ordinate is logarithmic.
    pub logarithmic: bool,
    /// Minimum and maximum ordinate, unless they follow from the values.
    pub range: Option<[f64; 2]>,
    /// The lines.
    pub series: Vec<Series>,
    /// Abscissae and ordinates with a name.
    pub marks: Vec<Mark>,
}

/// The abscissa of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Abscissa {
    /// Rows of the histories: the first, then the differences from one to the next.
    Rows(Vec<usize>),
    /// Times, s.
    Times(Vec<Rounded>),
    /// Periods, s, at equal ratios.
    Periods(Vec<Rounded>),
    /// Numbers without a unit.
    Numbers {
        /// What they are.
        name: &'static str,
        /// The numbers.
        values: Vec<Rounded>,
    },
}

/// A line of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// One value for each abscissa.
    pub values: Vec<Rounded>,
}

/// A line across a chart that has a name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// Whether the line is at an ordinate; otherwise at an abscissa.
    pub horizontal: bool,
    /// Where.
    pub at: f64,
    /// Its name.
    pub name: String,
}

/// A number that is written with few digits, and as `null` if it is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded(pub f64);

impl Serialize for Rounded {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(value) = *self;
        // Whole numbers without `.0`.
        if value.fract() == 0.0 && value.abs() < 1e9 {
            serializer.serialize_i64(value as i64)
        } else {
            serializer.serialize_f64(value)
        }
    }
}

/// The hydrodynamic pressure on a wet face at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Profile {
    /// What the instant is.
    pub instant: String,
    /// Name of the water: `reservoir` or `tailwater`.
    pub water: String,
    /// The instant, s.
    pub time: f64,
    /// Acceleration of the ground, m/s².
    pub ground_acceleration: f64,
    /// Heights above the base of the face, m, and pressures, Pa.
    pub computed: Vec<[f64; 2]>,
    /// Acceleration of Westergaard's parabola, m/s².
    pub parabola_acceleration: f64,
    /// The same of Westergaard's parabola; nothing where none compares.
    pub westergaard: Vec<[f64; 2]>,
}

/// A self-check of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What is checked.
    pub name: String,
    /// What was found.
    pub found: f64,
    /// Reference value in the same unit, if any.
    pub expected: Option<f64>,
    /// Unit of both.
    pub unit: &'static str,
    /// The limit, in words.
    pub limit: String,
    /// Whether the limit is kept; `None` if this cannot be judged.
    pub kept: Option<bool>,
    /// Basis of the verdict, or the reason why there is none.
    pub remark: String,
}

/// Pictures of a run: the motion of the dam's outline, and the pressures on it, at instants a fortieth of a second apart or more.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Animation {
    /// Points around each block and gallery in the unloaded position (x, y), m.
    pub outline: Vec<Vec<[Rounded; 2]>>,
    /// The instants, s.
    pub times: Vec<f64>,
    /// The instant that is shown first, with the largest crest displacement.
    pub first: usize,
    /// Displacements of all points (x, y), m.
    pub motion: Counted,
    /// The waters at the dam.
    pub waters: Vec<MovingWater>,
    /// Histories at the instants, with units in the names.
    pub readings: Vec<Series>,
}

/// Rows of numbers as multiples of a unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Counted {
    /// Value of one count.
    pub unit: f64,
    /// One row per instant: integers; after the first row, differences from the previous row.
    pub rows: Vec<Vec<i32>>,
}

/// A water and its hydrodynamic pressure on the dam.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MovingWater {
    /// Name of the water: `reservoir` or `tailwater`.
    pub name: String,
    /// Whether the water is downstream.
    pub downstream: bool,
    /// Its level, m.
    pub level: f64,
    /// The points of the outline on the wet face from the bed up, by their numbers.
    pub face: Vec<usize>,
    /// Points of the face at which the pressure is drawn (x, y), m.
    pub points: Vec<[Rounded; 2]>,
    /// The pressure there, Pa.
    pub pressure: Counted,
}
