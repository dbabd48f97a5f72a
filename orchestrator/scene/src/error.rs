use super::shape::{Range, Shape};
use crate::mesh_file::MeshFileError;
use cofferdam_motion::{RecordError, SequenceError};
use cofferdam_unit::number::{exact, plain};
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene that cannot be run, with all its problems.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("the scene {} cannot be run", path.display())]
pub struct SceneError {
    /// The scene's file.
    pub path: PathBuf,
    /// Everything that is wrong with it.
    #[related]
    pub problems: Vec<SceneProblem>,
}

/// One problem of a scene, at its place in the file.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{invalid}")]
pub struct SceneProblem {
    /// What is wrong.
    pub invalid: Invalid,
    /// The file.
    #[source_code]
    pub source_code: NamedSource<Arc<String>>,
    /// The place.
    #[label("here")]
    pub span: Option<SourceSpan>,
}

/// What can be wrong with a scene; every message names the key, the value and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Invalid {
    /// The file cannot be read.
    #[error("{path}: {cause}; give a folder with scene.toml, or a .toml file", path = path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// A `--set` that cannot be carried out.
    #[error(
        "`--set {text}` is no key=value of this scene, such as dam.element_size=2.5 or dam.cracks.0.elevation=60"
    )]
    Override {
        /// The argument.
        text: String,
    },
    /// Not TOML.
    #[error("{message}; {remedy}")]
    Syntax {
        /// What the parser said.
        message: String,
        /// How it would be right.
        remedy: &'static str,
    },
    /// An unknown key that is much like another.
    #[error("`{key}` is no key of {table}; did you mean `{meant}`?")]
    Misspelt {
        /// The key.
        key: String,
        /// Its table.
        table: String,
        /// The key that was meant.
        meant: String,
    },
    /// A key of another table.
    #[error("`{key}` is no key of {table}; it belongs to {home}")]
    Misplaced {
        /// The key.
        key: String,
        /// Its table.
        table: String,
        /// Where it would be right.
        home: String,
    },
    /// A key of physics that is not there.
    #[error("`{key}` is no key of {table}: {what} not modelled; leave it out")]
    NotModelled {
        /// The key.
        key: String,
        /// Its table.
        table: String,
        /// What is missing, and its verb.
        what: &'static str,
    },
    /// An unknown key.
    #[error("`{key}` is no key of {table}; there are {keys}")]
    Unknown {
        /// The key.
        key: String,
        /// Its table.
        table: String,
        /// The keys that the table has.
        keys: String,
    },
    /// A key that must be given.
    #[error("{key} is missing in {table}; add it ({meaning})")]
    Missing {
        /// The key, or the header of the table.
        key: String,
        /// Its table.
        table: String,
        /// What it is.
        meaning: String,
    },
    /// A value of the wrong type.
    #[error("`{key}` must be {wanted}, but is {found}")]
    Type {
        /// The key.
        key: String,
        /// What it must be.
        wanted: String,
        /// What it is.
        found: String,
    },
    /// A word that is none of those allowed.
    #[error(
        "`{key}` is \"{word}\"; it must be {wanted}{}",
        meant.as_ref().map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"))
    )]
    Word {
        /// The key.
        key: String,
        /// Its value.
        word: String,
        /// The words allowed.
        wanted: String,
        /// The one that was meant.
        meant: Option<String>,
    },
    /// Must be greater than zero.
    #[error("`{key}` is {}; it must be greater than 0 and finite{}", exact(*value), meaning(key))]
    NotPositive {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
    },
    /// Outside its range.
    #[error(
        "`{key}` is {}; it must be between {} and {}{}{}", plain(*value), plain(*least), plain(*most), meaning(key),
        other_unit(key, *value, [*least, *most])
    )]
    OutOfRange {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Largest value allowed.
        most: f64,
    },
    /// Water so shallow that it has no row of elements of its own.
    #[error(
        "`{key}` is {} m, negligible compared with the crest at {} m; make it more than {} m",
        exact(*depth), exact(*crest), exact(*least)
    )]
    WaterTooShallow {
        /// The key.
        key: String,
        /// Depth of the water, m.
        depth: f64,
        /// Elevation of the crest, m.
        crest: f64,
        /// Least depth, m.
        least: f64,
    },
    /// Gravity waves, which have a memory, on water without.
    #[error(
        "`{table}.surface_waves` is true, but `{table}.fidelity` = \"incompressible\" is an added mass, and waves \
         have a memory; leave it out, or choose \"compressible\""
    )]
    WavesWithoutMemory {
        /// The water's table.
        table: &'static str,
    },
    /// A tailwater without water.
    #[error("`tailwater.fidelity` is \"none\"; leave [tailwater] out, or choose another fidelity")]
    EmptyTailwater,
    /// A tailwater behind a dam without a downstream face.
    #[error(
        "`tailwater`: a prescribed dam has an upstream face only; give a [dam], or leave [tailwater] out"
    )]
    NoDownstreamFace,
    /// A limit of something that the scene does not have.
    #[error(
        "`{key}`: this scene has no {quantity}; give a [dam], or [[dam.cracks]], or leave the [[stop]] out"
    )]
    NothingToWatch {
        /// The key.
        key: String,
        /// What it watches.
        quantity: &'static str,
    },
    /// Pictures of a dam that is not computed.
    #[error("`snapshots`: a prescribed dam has no fields to show; give a [dam], or leave [snapshots] out")]
    NothingToShow,
    /// A number of modes of a dam that has none.
    #[error(
        "`dam.modes` belongs to `dam.fidelity` = \"reduced\" and \"intact\"; leave it out, or choose one of these"
    )]
    NoModes,
    /// Neither a dam nor water.
    #[error(
        "`reservoir.fidelity` is \"none\" and the dam is [prescribed]: nothing is left to compute; give a [dam], or \
         choose another fidelity"
    )]
    NothingToCompute,
    /// Both units are runs of the past.
    #[error(
        "dam and reservoir are both taken from a log: nothing is left to compute; look at a run with `cofferdam log`, or give \
         one of them another fidelity"
    )]
    NothingButLogs,
    /// A unit's file that is not there.
    #[error("{path}: {cause}; paths are sought from the scene's folder", path = path.display())]
    NoFile {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// A command without a program.
    #[error("`argv` names no program; give program and arguments, such as [\"python3\", \"water.py\"]")]
    NoProgram,
    /// Panels of the reservoir longer than the wet face.
    #[error(
        "`{key}` is {} m, more than the depth of {} m; take a sixteenth of that or less",
        exact(*size), exact(*depth)
    )]
    PanelTooLong {
        /// The key.
        key: String,
        /// Largest length of a panel, m.
        size: f64,
        /// Depth of the water, m.
        depth: f64,
    },
    /// What a unit says against the values that it would be made from.
    #[error("{message}")]
    Unit {
        /// What it says, with the remedy.
        message: String,
    },
    /// More of something than can be computed.
    #[error("`{key}` leads to {} {what}; the limit is {most:e}; change it accordingly", count(*number))]
    TooMany {
        /// The key.
        key: String,
        /// What there are too many of.
        what: &'static str,
        /// How many.
        number: f64,
        /// Most allowed.
        most: f64,
    },
    /// A simulated time that ends before the first communication step.
    #[error(
        "`time.duration` is {} s, negligible compared with a communication step of {} s; make it that or longer",
        exact(*duration), exact(*communication_step)
    )]
    NoStep {
        /// Simulated time, s.
        duration: f64,
        /// Communication step, s.
        communication_step: f64,
    },
    /// Nothing that would have to be small.
    #[error("`coupling.measures` is empty; list one or more of pressure, residual and displacement")]
    NoMeasure,
    /// Steps that vary, for water that cannot.
    #[error(
        "`{key}` lets the communication step vary, and this `{table}.method` takes steps of one length only; leave it out, \
         or choose `{table}.method` = \"recursive\" or a `{table}.fidelity` without memory"
    )]
    FixedStep {
        /// The water's table.
        table: &'static str,
        /// The key.
        key: &'static str,
    },
    /// Several steps in a window, where they are taken one by one.
    #[error("`coupling.window` is {window}, but {why}; make it 1, or leave it out")]
    Window {
        /// Steps in a window.
        window: usize,
        /// Why there can be no window.
        why: &'static str,
    },
    /// The scheme with added mass where there is none.
    #[error(
        "`coupling.scheme` is \"added-mass\", but {why}; leave it out, and the scheme that fits is chosen"
    )]
    AddedMassScheme {
        /// What is missing.
        why: &'static str,
    },
    /// Steps that follow an error which the scheme does not have, or does not tell.
    #[error(
        "`time.adaptive` needs a scheme that exchanges pressures and takes them one after the other; leave it out, or \
         choose `coupling.scheme` = \"serial-implicit\""
    )]
    AdaptiveScheme,
    /// An explicit scheme with water that answers at once.
    #[error(
        "`coupling.scheme` is explicit, and water without memory answers an acceleration at once with its mass: the run would blow \
         up; leave it out, and that mass moves with the dam"
    )]
    ExplicitAtOnce,
    /// Steps to be halved when they do not converge, which they are not asked to.
    #[error(
        "`coupling.on_failure` is \"halve\", but only implicit schemes converge; leave it out, or choose one"
    )]
    NothingToHalve,
    /// Bounds of the communication step that do not hold it.
    #[error(
        "`time.adaptive` has `shortest` = {} s and `longest` = {} s; `time.communication_step` = {} s must be between \
         them", exact(*shortest), exact(*longest), exact(*communication_step)
    )]
    AdaptiveBounds {
        /// Shortest step, s.
        shortest: f64,
        /// Longest step, s.
        longest: f64,
        /// First step, s.
        communication_step: f64,
    },
    /// A title or name that cannot be shown.
    #[error("`{key}` has the unprintable character {character:?}; leave it out")]
    Unprintable {
        /// The key.
        key: String,
        /// The character.
        character: char,
    },
    /// Two cracks that results could not tell apart.
    #[error(
        "`dam.cracks.{first}` and `dam.cracks.{second}` are both called {label:?} in results; give them different names by `name`"
    )]
    SameCracks {
        /// The one number.
        first: usize,
        /// The other.
        second: usize,
        /// What both are called.
        label: String,
    },
    /// Communication points further apart than the samples of the ground motion.
    #[error(
        "`{key}` is {} s, longer than the ground motion's interval of {} s, whose peaks it would \
         miss; make it no longer, best a whole fraction of it", exact(*communication_step), plain(*interval)
    )]
    Undersampled {
        /// The key.
        key: &'static str,
        /// Communication step, s.
        communication_step: f64,
        /// Interval between two samples, or rise of a ramp, s.
        interval: f64,
    },
    /// None or both of two tables.
    #[error("exactly one of `{first}` and `{second}` must be given, {found} are")]
    ExactlyOne {
        /// First key.
        first: &'static str,
        /// Second key.
        second: &'static str,
        /// How many are given.
        found: usize,
    },
    /// Polarity other than 1 and −1.
    #[error("`{key}` is {value}; it must be 1 or -1")]
    Polarity {
        /// The key.
        key: String,
        /// The value.
        value: i64,
    },
    /// A vertical component of a record that is not there.
    #[error(
        "`[ground_motion.vertical]` is the vertical component of a record, and there is no `[ground_motion.record]`; give it, or give \
         a ramp its `vertical_acceleration`"
    )]
    VerticalAlone,
    /// A vertical component from nowhere.
    #[error(
        "{} names neither a `file` nor a `column`; give the column of the vertical acceleration in the file \
         of the record, or another file",
        Shape::header(table)
    )]
    VerticalUntold {
        /// Its table.
        table: String,
    },
    /// Shocks after no record.
    #[error("`[[ground_motion.sequence]]` follows a record, but {why}")]
    SequenceAlone {
        /// What is there instead, and the remedy.
        why: &'static str,
    },
    /// A name that says nothing.
    #[error("`{key}` is empty; give a name, or leave it out")]
    EmptyName {
        /// The key.
        key: String,
    },
    /// Two shocks that results could not tell apart.
    #[error(
        "`{first}` and `{second}` are both called {label:?} in results; give them different names by `name`"
    )]
    SameShocks {
        /// The table of the one.
        first: String,
        /// That of the other.
        second: String,
        /// What both are called.
        label: String,
    },
    /// Shocks that cannot be joined.
    #[error("`ground_motion.sequence`: {0}")]
    Sequence(#[from] SequenceError),
    /// A count that is too small or too large.
    #[error("`{key}` is {value}; it must be a whole number from {least} to {most}")]
    Count {
        /// The key.
        key: String,
        /// Its value.
        value: i64,
        /// Least value allowed.
        least: i64,
        /// Largest value allowed.
        most: i64,
    },
    /// A wait for rest that never comes or is none.
    #[error("`time.longest_quiet` is {longest_quiet} s, but {why}")]
    LongestQuiet {
        /// Its value.
        longest_quiet: f64,
        /// What forbids it, and the remedy.
        why: &'static str,
    },
    /// A time that needs a record.
    #[error("`time.duration` is missing; a ramp has no end of its own, so say how long to run, in s")]
    DurationMissing,
    /// The record cannot be used.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    /// A key that the mesh stands for.
    #[error(
        "`{key}` follows from the file of `[dam.mesh]` and is not given beside it; leave it out, or leave the mesh out"
    )]
    ReplacedByMesh {
        /// The key.
        key: String,
    },
}

impl Invalid {
    /// A number outside its range.
    pub(super) fn outside(key: &str, value: f64, range: Range) -> Self {
        let (key, Range { least, most, open }) = (key.to_owned(), range);
        if open && least == 0.0 && most == f64::MAX {
            Self::NotPositive { key, value }
        } else {
            Self::OutOfRange { key, value, least, most }
        }
    }
}

impl SceneError {
    /// A problem that has no place in the file.
    pub(super) fn without_place(path: &Path, invalid: Invalid) -> Self {
        let problem = SceneProblem {
            invalid,
            source_code: NamedSource::new(path.to_string_lossy(), Arc::default()),
            span: None,
        };
        Self { path: path.to_owned(), problems: vec![problem] }
    }
}

/// A number of things, which may be more than there are numbers for.
fn count(number: f64) -> String {
    if number.is_finite() { format!("{number:.3e}") } else { "more than 1e308".to_owned() }
}

/// What the key is, with its unit, in brackets behind a message; nothing of a key that no scene has.
/// The value that was meant, where it seems to be in another unit.
fn other_unit(key: &str, value: f64, [least, most]: [f64; 2]) -> String {
    if key.ends_with("friction_coefficient") && value > most && value < 90.0 {
        return format!("; tan {}° = {:.3}", plain(value), value.to_radians().tan());
    }
    let pascal = Shape::field(key).is_some_and(|field| field.unit == "Pa");
    let prefixes = [("GPa", 1e9), ("MPa", 1e6)].into_iter().filter(|_| pascal && value > 0.0);
    let fits = |(_, factor): &(&str, f64)| (least..=most).contains(&(value * factor));
    prefixes
        .filter(fits)
        .map(|(unit, factor)| format!("; {} {unit} is {:e}", plain(value), value * factor))
        .next()
        .unwrap_or_default()
}

fn meaning(key: &str) -> String {
    Shape::field(key).map_or_else(String::new, |field| format!(" ({})", field.summary()))
}
