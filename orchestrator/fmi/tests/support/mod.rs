//! A reservoir of FMI 2.0 in C, `water.c`, as other tools may have made it.

use cofferdam_coupling::participant::{
    Level, Message, Occasion, Participant, ParticipantError, VariableNames,
};
use cofferdam_fmi::import::{Fmu, FmuUnitError, Import};
use cofferdam_unit::Role;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// Length of a step, s.
pub const H: f64 = 0.01;
/// Points of its face.
pub const POINTS: usize = 3;

/// The folder of an FMU.
pub struct Foreign {
    folder: TempDir,
    /// Its names for the variables of the contract.
    pub variables: BTreeMap<String, VariableNames>,
    /// The end of the run that it is told, s.
    pub stop_time: Option<f64>,
}

impl Foreign {
    /// One whose source has `macros` defined, and whose description is that of [`description`] with `changed` texts.
    pub fn new(macros: &[&str], changed: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let library = folder.path().join("binaries/linux64/water.so");
        std::fs::create_dir_all(library.parent().expect("a folder")).expect("a folder");
        let source = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/support/water.c");
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-D_GNU_SOURCE", "-w", "-o"]).arg(library);
        compiler.args(macros.iter().map(|name| format!("-D{name}"))).arg(source).arg("-lm");
        let output = compiler.output().expect("a C compiler, cc");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let foreign = Self { folder, variables: BTreeMap::new(), stop_time: None };
        let text = changed.iter().fold(
            description("interface_acceleration[#]", "interface_pressure[#]"),
            |text, (from, to)| {
                assert!(text.contains(from), "{from} is not in the description");
                text.replace(from, to)
            },
        );
        foreign.describe(text.as_bytes());
        foreign
    }

    /// Gives it a description of these bytes.
    pub fn describe(&self, description: &[u8]) {
        std::fs::write(self.folder.path().join("modelDescription.xml"), description).expect("written");
    }

    /// The unit.
    pub fn unit(&self) -> Result<Fmu, FmuUnitError> {
        let parameters = BTreeMap::new();
        let import = Import {
            file: self.folder.path(),
            variables: &self.variables,
            parameters: &parameters,
            stop_time: self.stop_time,
        };
        Fmu::new("reservoir", Role::Fluid, import, Some(H))
    }
}

/// The description of `water.c`, with `#` for the numbers of its scalars, from 1.
pub fn description(acceleration: &str, pressure: &str) -> String {
    let scalar = |name: &str, causality: &str, place: usize, reference: usize| {
        let (name, start) = (
            name.replace('#', &(place + 1).to_string()),
            if causality == "input" { " start=\"0\"" } else { "" },
        );
        format!(
            "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" causality=\"{causality}\"><Real{start}/></ScalarVariable>\n"
        )
    };
    let inputs: String = (0..POINTS).map(|i| scalar(acceleration, "input", i, i)).collect();
    let outputs: String = (0..POINTS).map(|i| scalar(pressure, "output", i, POINTS + i)).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"2.0\" modelName=\"water\" guid=\"{{water}}\">\n\
         <CoSimulation modelIdentifier=\"water\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\" \
         canHandleVariableCommunicationStepSize=\"true\"/>\n\
         <DefaultExperiment startTime=\"0\"/>\n\
         <ModelVariables>\n{inputs}{outputs}</ModelVariables>\n<ModelStructure/>\n</fmiModelDescription>\n"
    )
}

/// Takes step number `step` (from 1) with accelerations 1, 2, 3 m/s²; the pressures, Pa.
pub fn step(unit: &mut Fmu, step: u64) -> Result<Vec<f64>, ParticipantError> {
    let time = (step - 1) as f64 * H;
    let occasion = Occasion { step, iteration: 1, attempt: 1, time, communication_step: H };
    let mut outputs = vec![0.0; POINTS];
    unit.step(&occasion, &[1.0, 2.0, 3.0], &mut outputs)?;
    Ok(outputs)
}

/// Initialises it at rest.
pub fn initialise(unit: &mut Fmu) -> Result<(), ParticipantError> {
    unit.initialise(0.0, &[0.0; POINTS], &mut [0.0; POINTS])
}

/// The texts of this level.
pub fn texts(messages: &[Message], level: Level) -> Vec<&str> {
    messages.iter().filter(|message| message.level == level).map(|message| message.text.as_str()).collect()
}
