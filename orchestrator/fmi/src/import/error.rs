use super::unpacked::UnpackError;
use std::error::Error;
use std::path::PathBuf;

/// Why an FMU cannot take the place of a unit, or why it failed.
#[derive(Debug, thiserror::Error)]
pub enum FmuUnitError {
    /// Its archive.
    #[error(transparent)]
    Unpack(#[from] UnpackError),
    /// Its modelDescription.xml or its terminals cannot be read.
    #[error(
        "its {} cannot be used: {cause}; correct it, or export the FMU again",
        path.file_name().unwrap_or_default().display()
    )]
    Description {
        /// The file in the FMU.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// Another version of FMI.
    #[error("it is of FMI {version}; versions 2.0 and 3.0 can be used: export it again as one of these")]
    Version {
        /// Its version.
        version: String,
    },
    /// It offers no co-simulation.
    #[error("it is for {} alone, not for co-simulation; export it again for co-simulation", kinds.join(" and "))]
    NoCoSimulation {
        /// What it is for.
        kinds: Vec<&'static str>,
    },
    /// It has no library for this machine.
    #[error(
        "it has no library {library} for x86-64 Linux, but {}; export it again for this platform",
        if platforms.is_empty() { "none at all".to_owned() } else { format!("for {}", platforms.join(", ")) }
    )]
    Platform {
        /// The file that is sought.
        library: String,
        /// The platforms that it is for.
        platforms: Vec<String>,
    },
    /// Its library cannot be loaded.
    #[error("its library cannot be loaded: {cause}; {remedy}")]
    Library {
        /// What the system said.
        cause: String,
        /// What may help.
        remedy: &'static str,
    },
    /// No instance can be made.
    #[error("no instance can be made of it{}", said(message))]
    NoInstance {
        /// What it said last.
        message: String,
    },
    /// It lacks a variable that the interface needs.
    #[error(
        "it has no {causality} `{variable}` of real numbers, nor a member of a terminal `wet_face` for it; name its own in \
         `variables`, {{ {variable} = \"…\" }}, scalars by a pattern, \"p_{{i}}\"; it has {found}"
    )]
    NoVariable {
        /// The variable of the contract.
        variable: &'static str,
        /// Input or output.
        causality: &'static str,
        /// Those that it has.
        found: String,
    },
    /// A variable of the interface that is none of the kind that is needed.
    #[error("its `{name}`, which is to be `{variable}`, is no {causality}; of these it has {found}")]
    NotThat {
        /// The variable of the contract.
        variable: &'static str,
        /// Its name in the FMU.
        name: String,
        /// Input or output.
        causality: &'static str,
        /// Those that it has.
        found: String,
    },
    /// `variables` names what is not there.
    #[error(
        "`variables` gives {name:?} for `{variable}`, but it has no such variable of real numbers{}; it has {found}",
        meant(nearest)
    )]
    NoSuchVariable {
        /// The variable of the contract.
        variable: String,
        /// The name or pattern that is given for it.
        name: String,
        /// The names that are most like it.
        nearest: Vec<String>,
        /// Those that it has.
        found: String,
    },
    /// `variables` gives names or a pattern that do not make an array.
    #[error("`variables` gives {given} for `{variable}`, but {why}")]
    Names {
        /// The variable of the contract.
        variable: String,
        /// What is given.
        given: String,
        /// What is wrong with it, and what would help.
        why: String,
    },
    /// `variables` speaks of a variable that the contract does not have.
    #[error(
        "`variables` names `{variable}`, which is no variable of a {unit}; see modelDescription/README.md"
    )]
    Unknown {
        /// The key.
        variable: String,
        /// The unit's kind.
        unit: &'static str,
    },
    /// A parameter that cannot be set.
    #[error("parameter {name:?} {why}; it has {found}")]
    Parameter {
        /// Its name.
        name: String,
        /// What is wrong.
        why: String,
        /// The parameters that it has.
        found: String,
    },
    /// It cannot take the steps that the scene asks for.
    #[error(
        "it takes steps of {fixed} s alone, and the scene's are {asked} s; set `time.communication_step` to a whole multiple of \
         {fixed}"
    )]
    Step {
        /// Length of the scene's communication step, s.
        asked: f64,
        /// Its own, s.
        fixed: f64,
    },
    /// A call failed.
    #[error("{call} returned {status}{}", said(message))]
    Call {
        /// The function.
        call: &'static str,
        /// What it returned.
        status: &'static str,
        /// What it said last.
        message: String,
    },
    /// It does not accept the times of the run.
    #[error(
        "{call} returned {status}{}; it was told that the run begins at t = {start} s and ends at t = {stop} s: if it cannot go so far, \
         shorten `time.duration`",
        said(message)
    )]
    Setup {
        /// The function.
        call: &'static str,
        /// What it returned.
        status: &'static str,
        /// What it said last.
        message: String,
        /// Start of the run, s.
        start: f64,
        /// End of the run, s.
        stop: f64,
    },
    /// It ended the simulation.
    #[error("it asked to end the simulation at t = {time} s{}", said(message))]
    Terminated {
        /// End of the step, s.
        time: f64,
        /// What it said last.
        message: String,
    },
    /// It returned before the step's end.
    #[error(
        "it stopped at t = {reached} s in a step to t = {end} s, although an early return was not allowed"
    )]
    Early {
        /// Where it stopped, s.
        reached: f64,
        /// End of the step, s.
        end: f64,
    },
    /// It has no state to save.
    #[error(
        "it cannot save its state, so its steps cannot be repeated; choose an explicit [coupling] scheme"
    )]
    NoState,
    /// Its configuration cannot be hashed.
    #[error(transparent)]
    State(#[from] cofferdam_unit::StateError),
}

impl FmuUnitError {
    /// The library cannot be loaded.
    pub(super) fn of_loading(error: &libloading::Error) -> Self {
        // What the system said stands below "dlopen failed".
        let cause = error.source().map_or_else(|| error.to_string(), ToString::to_string);
        let remedy = if cause.contains("undefined symbol: Py") || cause.contains("undefined symbol: _Py") {
            "it runs in a Python process alone: set LD_PRELOAD to the library of that Python (libpython3.….so), or let its code \
             serve as a process, fidelity \"command\""
        } else if cause.contains("cannot open shared object file") {
            "install what it names, or export it again with that inside"
        } else if cause.contains("failed to map segment") {
            "set TMPDIR to a folder from which programs may run"
        } else {
            "export it again for this machine"
        };
        Self::Library { cause, remedy }
    }

    /// The library lacks a function that is needed.
    pub(super) fn without_function(name: &str) -> Self {
        let (cause, remedy) = (format!("it lacks the function {name}"), "FMI asks for all functions");
        Self::Library { cause, remedy }
    }
}

fn meant(nearest: &[String]) -> String {
    let names: Vec<String> = nearest.iter().map(|name| format!("`{name}`")).collect();
    if names.is_empty() { String::new() } else { format!("; the nearest: {}", names.join(", ")) }
}

fn said(message: &str) -> String {
    if message.is_empty() { " and did not say why".to_owned() } else { format!(": {message}") }
}
