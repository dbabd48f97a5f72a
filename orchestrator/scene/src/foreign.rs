//! `[reservoir.fmu]`, `[reservoir.command]`, `[reservoir.log]`, and the same of `[dam]`: units of other programs.

use cofferdam_coupling::participant::{AccelerationMeaning, ParameterValue, VariableNames};
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
    /// Its names for the variables of the contract: `{ interface_pressure = "p" }`. Scalars are named by a pattern with the
    /// placeholder `{i}`, `"p_{i}"`, or one by one, `["p_heel", "p_1"]`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("otherwise" = "the members of its terminal `wet_face`, then equal names"))]
    pub variables: BTreeMap<String, VariableNames>,
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

#[cfg(test)]
mod tests {
    use crate::Scene;
    use cofferdam_coupling::participant::VariableNames;
    use std::path::Path;

    /// The coarse scene with an FMU that has these names for the pressure.
    fn scene(names: &str) -> Result<Scene, String> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/koyna-coarse/scene.toml");
        let source = std::fs::read_to_string(&file).expect("a shipped scene");
        let set = [
            "reservoir.fidelity=fmu".to_owned(),
            "reservoir.fmu.file=water.fmu".to_owned(),
            format!("reservoir.fmu.variables.interface_pressure={names}"),
        ];
        Scene::resolved(&source, &set, &file).map_err(|error| format!("{error:?}"))
    }

    #[test]
    fn a_variable_has_one_name_or_a_list_and_keeps_it_in_a_manifest() {
        let several =
            |names: &[&str]| VariableNames::Several(names.iter().map(|n| (*n).to_owned()).collect());
        for (text, expected) in [
            ("\"p_{i}\"", VariableNames::One("p_{i}".to_owned())),
            ("[\"p_heel\", \"p_1\"]", several(&["p_heel", "p_1"])),
        ] {
            let given = scene(text).expect("a scene");
            let again = toml::to_string(&given).expect("TOML");
            for scene in [given, toml::from_str(&again).expect("the scene")] {
                let fmu = scene.reservoir.fmu.expect("an FMU");
                assert_eq!(fmu.variables["interface_pressure"], expected);
            }
        }
    }

    #[test]
    fn names_that_are_no_texts_are_refused_with_their_place() {
        let one = scene("3").expect_err("a number");
        assert!(one.contains("reservoir.fmu.variables.interface_pressure"), "{one}");
        assert!(one.contains("one text or several"), "{one}");
        let second = scene("[\"p_1\", 2]").expect_err("a number");
        assert!(second.contains("reservoir.fmu.variables.interface_pressure.1"), "{second}");
    }
}
