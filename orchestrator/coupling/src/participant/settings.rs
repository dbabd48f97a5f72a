//! What a user says of a unit of another program.

use serde::{Deserialize, Serialize};

/// What a unit takes the acceleration of a step to mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationMeaning {
    /// The mean over the step, as the built-in units do.
    #[default]
    Mean,
    /// The value at the step's end, as most programs do.
    End,
}

/// The names that a variable of the contract has in another program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum VariableNames {
    /// Its name, or a pattern for those of its values, `p_{i}` or `p[1,{i=0}]`.
    One(String),
    /// A name for each of its values.
    Several(Vec<String>),
}

impl From<&str> for VariableNames {
    fn from(name: &str) -> Self {
        Self::One(name.to_owned())
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for VariableNames {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "VariableNames".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" }, "minItems": 1 }]
        })
    }
}

/// The value of a parameter of another program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// `true` or `false`.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Several numbers.
    Numbers(Vec<f64>),
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for ParameterValue {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ParameterValue".into()
    }

    fn inline_schema() -> bool {
        true
    }

    /// Whatever its program makes of it.
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::Schema::default()
    }
}

impl From<f64> for ParameterValue {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for ParameterValue {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}
