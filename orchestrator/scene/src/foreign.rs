//! `[reservoir.fmu]`, `[reservoir.command]`, `[reservoir.log]`, and the same of `[dam]`: units of other programs.

use cofferdam_coupling::participant::{AccelerationMeaning, ParameterValue};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Who computes a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source<'a> {
    /// This program.
    BuiltIn,
    /// An FMU.
    Fmu(&'a FmuScene),
    /// A process of another program.
    Command(&'a CommandScene),
    /// An earlier run.
    Log(&'a LogScene),
    /// Another program, but the table that says which is missing.
    Untold(&'static str),
}

impl<'a> Source<'a> {
    /// The table that goes with the word of a fidelity.
    pub(super) fn of(
        word: &str,
        tables: (&'a Option<FmuScene>, &'a Option<CommandScene>, &'a Option<LogScene>),
    ) -> Self {
        let (fmu, command, log) = tables;
        match word {
            "fmu" => fmu.as_ref().map_or(Self::Untold("fmu"), Self::Fmu),
            "command" => command.as_ref().map_or(Self::Untold("command"), Self::Command),
            "log" => log.as_ref().map_or(Self::Untold("log"), Self::Log),
            _ => Self::BuiltIn,
        }
    }

    /// What the unit takes accelerations to mean.
    pub fn acceleration(self) -> AccelerationMeaning {
        match self {
            Self::Fmu(fmu) => fmu.acceleration,
            Self::Command(command) => command.acceleration,
            _ => AccelerationMeaning::Mean,
        }
    }

    /// Whether another program computes it, now.
    pub fn is_foreign(self) -> bool {
        matches!(self, Self::Fmu(_) | Self::Command(_))
    }

    /// The file or folder that it rests on.
    pub fn file(self) -> Option<&'a Path> {
        match self {
            Self::Fmu(fmu) => Some(&fmu.file),
            Self::Log(log) => Some(&log.file),
            _ => None,
        }
    }
}

/// An FMU in place of this unit, FMI 3.0 or 2.0 for co-simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FmuScene {
    /// The FMU, or the folder of an unpacked one; from the scene's folder.
    pub file: PathBuf,
    /// What the accelerations of its interface mean.
    #[serde(default)]
    pub acceleration: AccelerationMeaning,
    /// Its names for the variables of the contract: `{ interface_pressure = "p" }`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("otherwise" = "the members of its terminal `wet_face`, then equal names"))]
    pub variables: BTreeMap<String, String>,
    /// Values of its parameters by their names, set before initialisation.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("otherwise" = "its own start values"))]
    pub parameters: BTreeMap<String, ParameterValue>,
}

/// A process in place of this unit, which keeps the protocol of `docs/reference/protocol.md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CommandScene {
    /// Program and arguments, such as `["python3", "water.py"]`.
    pub argv: Vec<String>,
    /// Folder in which it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the scene's"))]
    pub folder: Option<PathBuf>,
    /// What the accelerations of its interface mean.
    #[serde(default)]
    pub acceleration: AccelerationMeaning,
    /// Values that are handed to it as they are.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, ParameterValue>,
}

/// An earlier run in place of this unit. It returns the recorded outputs whatever its inputs: the loop is open, and nothing
/// is iterated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LogScene {
    /// The log, or the folder of its run; from the scene's folder.
    pub file: PathBuf,
}

/// Makes the paths of a unit stand for themselves.
pub(super) fn resolve(
    folder: &Path,
    (fmu, command, log): (&mut Option<FmuScene>, &mut Option<CommandScene>, &mut Option<LogScene>),
) {
    let absolute = |path: &Path| {
        let path = folder.join(path);
        path.canonicalize().unwrap_or(path)
    };
    if let Some(fmu) = fmu {
        fmu.file = absolute(&fmu.file);
    }
    if let Some(command) = command {
        command.folder = Some(absolute(command.folder.as_deref().unwrap_or(Path::new("."))));
    }
    if let Some(log) = log {
        log.file = absolute(&log.file);
        if log.file.is_dir() {
            log.file.push("log.mcap");
        }
    }
}
