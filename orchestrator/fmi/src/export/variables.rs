use super::FmuError;
use cofferdam_unit::export::Contents;
use cofferdam_unit::{Capabilities, Causality, DataType, Packable, Variability, Variable};

/// Smallest and largest value of a parameter, by the names of the unit and of the parameter; `None` where there is no bound.
pub type Bounds = fn(&str, &str) -> [Option<f64>; 2];

/// A variable with its number of values.
pub struct SizedVariable {
    /// The unit's variable.
    pub variable: &'static Variable,
    /// Number of values.
    pub size: usize,
    /// Values before initialisation, of inputs and parameters.
    pub start: Option<Vec<f64>>,
    /// Smallest and largest value of a parameter.
    pub bounds: [Option<f64>; 2],
}

impl SizedVariable {
    /// The start values as XML writes them; none for a variable without start values.
    pub fn start_text(&self) -> Option<String> {
        let text = |value: &f64| value_text(self.variable.data_type, *value);
        Some(self.start.as_ref()?.iter().map(text).collect::<Vec<_>>().join(" "))
    }

    /// Smallest and largest value as XML writes them; none of flags.
    pub fn bound_texts(&self) -> Vec<(&'static str, String)> {
        let data_type = self.variable.data_type;
        let bounds = ["min", "max"].into_iter().zip(self.bounds).filter(|_| data_type != DataType::Boolean);
        bounds.filter_map(|(name, bound)| Some((name, value_text(data_type, bound?)))).collect()
    }
}

/// Causality and variability to importers, to whom an input that is fixed when initialisation ends is a parameter.
pub fn role(variable: &Variable) -> (&'static str, &'static str) {
    if variable.is_fixed_input() {
        return (Causality::Parameter.name(), Variability::Fixed.name());
    }
    (variable.causality.name(), variable.variability.name())
}

/// The references of the inputs on which an output depends: those with respect to which its derivative is offered. Other outputs follow
/// from a step alone, so that they stay what they are while inputs are set.
pub fn dependencies(variable: &Variable, capabilities: Capabilities) -> &[u32] {
    if capabilities.directional_derivative { variable.dependencies } else { &[] }
}

/// The variables of a unit made from `contents`, without those that have no values there, without parameters that
/// stand for no number of `contents` and without inputs that records drive.
///
/// **Errors**: [`FmuError::Start`].
pub fn of<U: Packable>(
    contents: &Contents<U::Parameters>,
    bounds: Bounds,
) -> Result<Vec<SizedVariable>, FmuError> {
    let mut parameters = contents.parameters.clone();
    let mut found = Vec::new();
    let seen =
        |variable: &&Variable| variable.causality != Causality::Input || !contents.drives(variable.name);
    for variable in U::VARIABLES.iter().filter(seen) {
        let size = U::size_for(&parameters, variable);
        let start = match variable.causality {
            Causality::Input => {
                Some(contents.start.get(variable.name).cloned().unwrap_or_else(|| vec![0.0; size]))
            }
            Causality::Parameter => Some(U::numbers(&mut parameters, variable).iter().map(|v| **v).collect()),
            Causality::CalculatedParameter | Causality::Output | Causality::Local => None,
        };
        if size > 0 && start.as_ref().is_none_or(|values| !values.is_empty()) {
            let bounds = bounds(U::NAME, variable.name);
            found.push(SizedVariable { variable, size, start, bounds });
        }
    }
    for (name, values) in &contents.start {
        let input =
            found.iter().find(|v| v.variable.name == name && v.variable.causality == Causality::Input);
        let expected = input.map_or(0, |v| v.size);
        if values.len() != expected {
            return Err(FmuError::Start { name: name.clone(), expected, found: values.len() });
        }
    }
    Ok(found)
}

/// The variables of the contract in the sizes of the smallest unit that makes sense; all start values are 0, or the
/// least that is allowed.
pub fn of_contract<U: Packable>(bounds: Bounds) -> Vec<SizedVariable> {
    let sized = |variable: &'static Variable| {
        let size = variable.shape.least_size();
        let settable = matches!(variable.causality, Causality::Input | Causality::Parameter);
        let bounds = bounds(U::NAME, variable.name);
        let least = bounds[0].unwrap_or(0.0).max(0.0);
        SizedVariable { variable, size, start: settable.then(|| vec![least; size]), bounds }
    };
    U::VARIABLES.iter().map(sized).collect()
}

/// A number that reads back bit for bit.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A value of this type as XML writes it.
pub fn value_text(data_type: DataType, value: f64) -> String {
    match data_type {
        DataType::Real => number(value),
        DataType::Integer => format!("{value:.0}"),
        DataType::Boolean => (value != 0.0).to_string(),
    }
}
