//! `[report]`: what the report says about the project, and the limits that it judges the results by.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the report says about the project, and the limits that it judges the results by. Nothing here changes a result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReportScene {
    /// The project.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub project: Option<String>,
    /// The client.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub client: Option<String>,
    /// The dam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dam: Option<String>,
    /// The load case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_case: Option<String>,
    /// Number and revision of the document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub revision: Option<String>,
    /// Who prepared it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prepared_by: Option<String>,
    /// Who checked it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checked_by: Option<String>,
    /// Who approved it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub approved_by: Option<String>,
    /// The limits.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub limits: LimitsScene,
}

/// Acceptance criteria. The report compares each with the results and draws the conclusion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitsScene {
    /// Largest displacement of the crest during the run, in either direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0))]
    pub crest_displacement: Option<f64>,
    /// Largest residual sliding of any crack, in either direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "m", "exclusiveMinimum" = 0))]
    pub residual_sliding: Option<f64>,
    /// Largest principal stress in the dam, tension positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "Pa", "exclusiveMinimum" = 0))]
    pub tension: Option<f64>,
    /// Least freeboard after the earthquake.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1000), extend("unit" = "m"))]
    pub freeboard: Option<f64>,
}

impl ReportScene {
    /// The given texts, each with its key and its name on the page.
    pub fn texts(&self) -> Vec<(&'static str, &'static str, &str)> {
        let of = [
            ("project", "project", &self.project),
            ("client", "client", &self.client),
            ("dam", "dam", &self.dam),
            ("load_case", "load case", &self.load_case),
            ("revision", "revision", &self.revision),
            ("prepared_by", "prepared by", &self.prepared_by),
            ("checked_by", "checked by", &self.checked_by),
            ("approved_by", "approved by", &self.approved_by),
        ];
        of.into_iter().filter_map(|(key, name, text)| Some((key, name, text.as_deref()?))).collect()
    }
}
