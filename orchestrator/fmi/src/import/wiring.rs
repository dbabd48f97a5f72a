//! Which variables of an FMU are those of the contract.

use super::error::FmuUnitError;
use super::instance::Value;
use super::model::{Causality, Kind, Model, ModelVariable};
use super::naming;
use cofferdam_coupling::participant::{Channel, ChannelShape, Layout, ParameterValue, VariableNames};
use cofferdam_unit::{DataType, Role, Variable};
use std::collections::BTreeMap;
use std::ops::Range;

/// The wires of a unit.
#[derive(Debug)]
pub struct Wiring {
    pub inputs: Wires,
    pub outputs: Wires,
    pub readable: Wires,
    /// Inputs that nobody drives; they keep their start values.
    pub idle: Vec<String>,
}

/// Variables in the order of a layout.
#[derive(Debug, Default)]
pub struct Wires(Vec<Wire>);

/// A variable of a layout, and its references in the FMU: one of an array of FMI 3.0, else one for each value.
#[derive(Debug)]
pub struct Wire {
    pub channel: Channel,
    pub references: Vec<u32>,
    pub kind: Kind,
    /// An input that the FMU takes as a parameter: it is set during initialisation alone.
    fixed: bool,
}

/// References of one kind that follow each other, and where their values are among all.
pub struct Run {
    pub kind: Kind,
    pub references: Vec<u32>,
    pub values: Range<usize>,
}

impl Wiring {
    /// Finds the variables of `role` in `model`: by `variables`, else in the terminal `wet_face`, else by equal
    /// names. All other real outputs are taken under their own names.
    ///
    /// Scalars that are values of one variable become an array of `model`.
    ///
    /// **Errors**: one that the interface needs is not there; names that do not fit.
    pub fn find(
        model: &mut Model,
        role: Role,
        variables: &BTreeMap<String, VariableNames>,
    ) -> Result<Self, FmuUnitError> {
        let contract = role.variables();
        if let Some(variable) = variables.keys().find(|name| !contract.iter().any(|v| v.name == **name)) {
            return Err(FmuUnitError::Unknown { variable: variable.clone(), unit: role.name() });
        }
        let variables = naming::join(model, variables)?;
        let model = &*model;
        let mut found: Vec<(&Variable, &ModelVariable)> = Vec::new();
        for variable in contract {
            let given = variables.get(variable.name);
            let member = variable.name.strip_prefix("interface_").unwrap_or(variable.name);
            let name = given.or_else(|| model.terminal.get(member)).map_or(variable.name, String::as_str);
            let fits = |kind: Kind| match variable.causality {
                cofferdam_unit::Causality::Input => kind == Kind::Float64,
                _ => variable.data_type != DataType::Real && kind.is_number() || kind == Kind::Float64,
            };
            let wanted = |v: &&ModelVariable| v.name == name && fits(v.kind);
            match (model.variables.iter().find(wanted), given) {
                (Some(theirs), Some(name)) if is_one_of_several(model, variable, theirs) => {
                    let (pattern, size) = naming::pattern_of(model, name).unwrap_or_default();
                    let (variable, given) = (variable.name.to_owned(), format!("{name:?}"));
                    let why = format!(
                        "that is a single value; for all {size} of them give the pattern {pattern:?}"
                    );
                    return Err(FmuUnitError::Names { variable, given, why });
                }
                (Some(theirs), _) => found.push((variable, theirs)),
                (None, Some(name)) => return Err(naming::missing(model, variable.name, name)),
                (None, None) => (),
            }
        }
        let (inputs, outputs) = role.needed();
        let needed = inputs.iter().map(|name| (*name, Causality::Input, "input"));
        for (variable, is, causality) in
            needed.chain(outputs.iter().map(|name| (*name, Causality::Output, "output")))
        {
            let theirs = found.iter().find(|(ours, _)| ours.name == variable).map(|(_, theirs)| *theirs);
            if let Some(theirs) = theirs.filter(|theirs| theirs.causality != is) {
                let (name, found) = (theirs.name.clone(), naming::names(model, &[is]));
                return Err(FmuUnitError::NotThat { variable, name, causality, found });
            }
            if theirs.is_none() {
                return Err(FmuUnitError::NoVariable {
                    variable,
                    causality,
                    found: naming::names(model, &[is]),
                });
            }
        }
        let mut wiring = Self {
            inputs: Wires::default(),
            outputs: Wires::default(),
            readable: Wires::default(),
            idle: Vec::new(),
        };
        let all = [
            Causality::Input,
            Causality::Output,
            Causality::Parameter,
            Causality::CalculatedParameter,
            Causality::Local,
        ];
        // In their order, which is that of this program's own units too.
        for theirs in model.variables.iter().filter(|v| v.size > 0 && all.contains(&v.causality)) {
            let ours = found.iter().find(|(_, v)| v.name == theirs.name).map(|(ours, _)| *ours);
            if ours.is_none() && theirs.kind != Kind::Float64 {
                continue;
            }
            match (theirs.causality, ours) {
                (Causality::Input, Some(ours)) => wiring.inputs.add(theirs, Some(ours), contract),
                (Causality::Parameter, Some(ours)) if ours.is_fixed_input() => {
                    wiring.inputs.add(theirs, Some(ours), contract);
                }
                (Causality::Output, ours) => wiring.outputs.add(theirs, ours, contract),
                (_, Some(ours)) => wiring.readable.add(theirs, Some(ours), contract),
                (_, None) => (),
            }
        }
        let driven = |name: &str| found.iter().any(|(_, variable)| variable.name == name);
        let inputs = model.variables.iter().filter(|variable| variable.causality == Causality::Input);
        let idle = inputs.filter(|variable| variable.size > 0 && !driven(&variable.name));
        wiring.idle = idle.map(|variable| variable.name.clone()).collect();
        Ok(wiring)
    }
}

impl Wires {
    fn add(&mut self, theirs: &ModelVariable, ours: Option<&Variable>, contract: &[Variable]) {
        // A name of the contract belongs to the variable that was chosen for it.
        let taken = contract.iter().any(|variable| variable.name == theirs.name);
        let own = if taken { format!("own_{}", theirs.name) } else { theirs.name.clone() };
        let array = if theirs.array { ChannelShape::List } else { ChannelShape::Scalar };
        let unit = if theirs.unit.is_empty() { ours.map_or("", |ours| ours.unit) } else { &theirs.unit };
        let channel = Channel {
            name: ours.map_or(own, |ours| ours.name.to_owned()),
            value_reference: theirs.references[0],
            unit: unit.to_owned(),
            size: theirs.size,
            shape: ours.map_or(array, |ours| ours.shape.into()),
        };
        let (references, kind) = (theirs.references.clone(), theirs.kind);
        let fixed = theirs.causality == Causality::Parameter;
        self.0.push(Wire { channel, references, kind, fixed });
    }

    /// The layout.
    pub fn layout(&self) -> Layout {
        Layout::new(self.0.iter().map(|wire| wire.channel.clone()).collect())
    }

    /// All variables as runs of one kind.
    pub fn runs(&self) -> Vec<Run> {
        self.runs_of(|_| true)
    }

    /// The same of those that may change in every step.
    pub fn changing_runs(&self) -> Vec<Run> {
        self.runs_of(|wire| !wire.fixed)
    }

    fn runs_of(&self, wanted: impl Fn(&Wire) -> bool) -> Vec<Run> {
        let (mut runs, mut end) = (Vec::<Run>::new(), 0);
        for wire in &self.0 {
            let begin = end;
            end += wire.channel.size;
            if !wanted(wire) {
                continue;
            }
            match runs.last_mut().filter(|run| run.kind == wire.kind && run.values.end == begin) {
                Some(run) => {
                    run.references.extend(&wire.references);
                    run.values.end = end;
                }
                None => {
                    let (kind, references) = (wire.kind, wire.references.clone());
                    runs.push(Run { kind, references, values: begin..end });
                }
            }
        }
        runs
    }

    /// The variable of the contract's `name`.
    pub fn find(&self, name: &str) -> Option<&Wire> {
        self.0.iter().find(|wire| wire.channel.name == name)
    }
}

/// References, types and values of parameters.
///
/// **Errors**: [`FmuUnitError::Parameter`].
pub fn parameters(
    model: &Model,
    wiring: &Wiring,
    given: &BTreeMap<String, ParameterValue>,
) -> Result<Vec<(u32, Kind, Value)>, FmuUnitError> {
    let mut set = Vec::new();
    for (name, value) in given {
        let refused = |why: String| {
            let may = |v: &&ModelVariable| v.causality == Causality::Parameter;
            let found = naming::plain_names(model.variables.iter().filter(may));
            FmuUnitError::Parameter { name: name.clone(), why, found }
        };
        let Some(variable) = model.variables.iter().find(|v| v.name == *name) else {
            return Err(refused("is not there".to_owned()));
        };
        if wiring.inputs.0.iter().any(|wire| wire.references == variable.references) {
            return Err(refused("is set by the other unit".to_owned()));
        }
        if variable.causality != Causality::Parameter && !wiring.idle.contains(name) {
            return Err(refused("is neither a parameter nor an input that nobody drives".to_owned()));
        }
        let (kind, size) = (variable.kind, variable.size);
        let value = value_of(kind, value).map_err(refused)?;
        match value {
            Value::Numbers(numbers) => {
                let found = numbers.len();
                if found != size {
                    return Err(refused(format!("has {size} values, {found} are given")));
                }
                if variable.references.len() == 1 {
                    set.push((variable.references[0], kind, Value::Numbers(numbers)));
                } else {
                    let each = variable.references.iter().zip(numbers);
                    set.extend(
                        each.map(|(reference, number)| (*reference, kind, Value::Numbers(vec![number]))),
                    );
                }
            }
            single if size == 1 => set.push((variable.references[0], kind, single)),
            _ => {
                return Err(refused(format!(
                    "has {size} values that are no real numbers; only one can be set"
                )));
            }
        }
    }
    Ok(set)
}

/// A value as that of a variable of `kind`, or why it is none.
fn value_of(kind: Kind, value: &ParameterValue) -> Result<Value, String> {
    let bounds = match kind {
        Kind::Int8 => (i64::from(i8::MIN), i64::from(i8::MAX)),
        Kind::UInt8 => (0, i64::from(u8::MAX)),
        Kind::Int16 => (i64::from(i16::MIN), i64::from(i16::MAX)),
        Kind::UInt16 => (0, i64::from(u16::MAX)),
        Kind::Int32 => (i64::from(i32::MIN), i64::from(i32::MAX)),
        Kind::UInt32 => (0, i64::from(u32::MAX)),
        Kind::UInt64 => (0, i64::MAX),
        _ => (i64::MIN, i64::MAX),
    };
    let (real, whole) = (
        matches!(kind, Kind::Float32 | Kind::Float64),
        !matches!(kind, Kind::Float32 | Kind::Float64 | Kind::Boolean | Kind::String | Kind::Other),
    );
    match value {
        ParameterValue::Number(number) if real => Ok(Value::Numbers(vec![*number])),
        ParameterValue::Whole(number) if real => Ok(Value::Numbers(vec![*number as f64])),
        ParameterValue::Numbers(numbers) if real => Ok(Value::Numbers(numbers.clone())),
        ParameterValue::Whole(number) if whole && (bounds.0..=bounds.1).contains(number) => {
            Ok(Value::Whole(*number))
        }
        ParameterValue::Whole(number) if whole => Err(format!("is a {kind:?}, and {number} is none")),
        ParameterValue::Flag(flag) if kind == Kind::Boolean => Ok(Value::Flag(*flag)),
        ParameterValue::Text(text) if kind == Kind::String => Ok(Value::Text(text.clone())),
        _ if kind == Kind::Other => Err("is a binary or a clock, which cannot be set".to_owned()),
        _ => Err(format!("is a {kind:?}, and the value given is none")),
    }
}

/// Whether a scalar is given for values along the face, and others have names as if they were the rest.
fn is_one_of_several(model: &Model, variable: &Variable, theirs: &ModelVariable) -> bool {
    let along_face = ChannelShape::from(variable.shape) == ChannelShape::WetFace;
    along_face && !theirs.array && naming::pattern_of(model, &theirs.name).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(kind: Kind, causality: Causality, name: &str, reference: u32, size: usize) -> ModelVariable {
        let (references, unit, array) = (vec![reference], String::new(), size > 1);
        ModelVariable { name: name.into(), references, kind, causality, unit, size, array }
    }

    /// Kind, references and places of values.
    fn told(runs: Vec<Run>) -> Vec<(Kind, Vec<u32>, Range<usize>)> {
        runs.into_iter().map(|run| (run.kind, run.references, run.values)).collect()
    }

    #[test]
    fn a_dam_of_this_and_of_an_earlier_version_has_the_same_wires() {
        use Causality::{Input, Output, Parameter};
        let real = Kind::Float64;
        let layouts = [(Input, real), (Parameter, Kind::Int32)].map(|(hydrostatic, counts)| {
            let mut model = Model::of_variables(vec![
                of(real, Input, "interface_pressure", 1, 3),
                of(real, hydrostatic, "hydrostatic_pressure", 2, 3),
                of(real, Input, "ground_acceleration", 3, 2),
                of(real, Output, "interface_displacement", 10, 3),
                of(real, Output, "interface_acceleration", 12, 3),
                of(counts, Output, "crack_sticking", 23, 1),
                of(counts, Output, "crack_open", 25, 1),
                // Of no contract.
                of(Kind::Int32, Output, "steps", 99, 1),
                of(real, Output, "kinetic_energy", 30, 1),
            ]);
            let wiring = Wiring::find(&mut model, Role::Structure, &BTreeMap::new()).expect("a dam");
            assert_eq!(told(wiring.inputs.runs()), [(real, vec![1, 2, 3], 0..8)]);
            let changing = match hydrostatic {
                Parameter => vec![(real, vec![1], 0..3), (real, vec![3], 6..8)],
                _ => vec![(real, vec![1, 2, 3], 0..8)],
            };
            assert_eq!(told(wiring.inputs.changing_runs()), changing);
            let outputs = match counts {
                Kind::Int32 => {
                    vec![(real, vec![10, 12], 0..6), (counts, vec![23, 25], 6..8), (real, vec![30], 8..9)]
                }
                _ => vec![(real, vec![10, 12, 23, 25, 30], 0..9)],
            };
            assert_eq!(told(wiring.outputs.runs()), outputs);
            let driven = BTreeMap::from([("hydrostatic_pressure".into(), ParameterValue::Number(1.0))]);
            let refused = parameters(&model, &wiring, &driven).err().map(|error| error.to_string());
            assert!(refused.is_some_and(|text| text.contains("is set by the other unit")));
            [wiring.inputs.layout(), wiring.outputs.layout()]
        });
        assert_eq!(layouts[0], layouts[1]);
    }

    #[test]
    fn inputs_of_any_type_that_nobody_drives_can_be_set() {
        let (real, input) = (Kind::Float64, Causality::Input);
        let mut model = Model::of_variables(vec![
            of(real, input, "interface_acceleration", 1, 2),
            of(real, Causality::Output, "interface_pressure", 2, 2),
            of(Kind::Boolean, input, "enable", 7, 1),
            of(Kind::Int32, input, "order", 8, 1),
        ]);
        let wiring = Wiring::find(&mut model, Role::Fluid, &BTreeMap::new()).expect("a water");
        assert_eq!(wiring.idle, ["enable", "order"]);
        let given = |name: &str, value| BTreeMap::from([(name.to_owned(), value)]);
        let set =
            parameters(&model, &wiring, &given("enable", ParameterValue::Flag(true))).expect("it is set");
        assert_eq!(set, [(7, Kind::Boolean, Value::Flag(true))]);
        let driven = given("interface_acceleration", ParameterValue::Number(1.0));
        assert!(
            parameters(&model, &wiring, &driven)
                .is_err_and(|error| error.to_string().contains("is set by the other unit"))
        );
    }

    /// One scalar where there are several of its kind was meant to be all of them.
    #[test]
    fn a_single_scalar_for_the_face_is_refused_with_its_pattern() {
        let scalar = |name: &str, reference, causality| ModelVariable {
            name: name.into(),
            references: vec![reference],
            kind: Kind::Float64,
            causality,
            unit: String::new(),
            size: 1,
            array: false,
        };
        let variables = || {
            let (input, output) = (Causality::Input, Causality::Output);
            vec![
                scalar("a_1", 1, input),
                scalar("a_2", 2, input),
                scalar("p(1)", 3, output),
                scalar("p(2)", 4, output),
            ]
        };
        let find = |pressure: &str| {
            let names = [("interface_acceleration", "a_{i}"), ("interface_pressure", pressure)];
            let names = names.map(|(variable, name)| (variable.to_owned(), name.into()));
            Wiring::find(&mut Model::of_variables(variables()), Role::Fluid, &BTreeMap::from(names))
        };
        let refused = find("p(1)").expect_err("one of two").to_string();
        assert!(refused.contains("\"p(1)\" for `interface_pressure`"), "{refused}");
        assert!(refused.contains("for all 2 of them give the pattern \"p({i})\""), "{refused}");
        let wiring = find("p({i})").expect("both");
        assert_eq!(told(wiring.inputs.runs()), [(Kind::Float64, vec![1, 2], 0..2)]);
        assert_eq!(told(wiring.outputs.runs()), [(Kind::Float64, vec![3, 4], 0..2)]);
        let pressure = wiring.outputs.find("interface_pressure").expect("the pressure");
        assert_eq!((pressure.channel.size, pressure.channel.unit.as_str()), (2, "Pa"));
        // Without names, the error shows the patterns to copy.
        let refused = Wiring::find(&mut Model::of_variables(variables()), Role::Fluid, &BTreeMap::new());
        let refused = refused.expect_err("nothing is named").to_string();
        assert!(refused.contains("it has `a_{i}`[2]") && refused.contains("\"p_{i}\""), "{refused}");
    }

    #[test]
    fn a_parameter_has_a_value_of_its_type() {
        use ParameterValue::{Flag, Number, Numbers, Text, Whole};
        assert_eq!(value_of(Kind::Float64, &Whole(3)), Ok(Value::Numbers(vec![3.0])));
        assert_eq!(value_of(Kind::Float64, &Numbers(vec![1.0, 2.0])), Ok(Value::Numbers(vec![1.0, 2.0])));
        assert_eq!(value_of(Kind::UInt8, &Whole(255)), Ok(Value::Whole(255)));
        assert_eq!(value_of(Kind::UInt8, &Whole(256)), Err("is a UInt8, and 256 is none".to_owned()));
        assert_eq!(value_of(Kind::Boolean, &Flag(true)), Ok(Value::Flag(true)));
        for (kind, value) in [
            (Kind::Boolean, Whole(1)),
            (Kind::Int32, Number(1.0)),
            (Kind::String, Number(1.0)),
            (Kind::Float64, Text("1".to_owned())),
            (Kind::Other, Text(String::new())),
        ] {
            assert!(value_of(kind, &value).is_err(), "{kind:?} {value:?}");
        }
    }
}
