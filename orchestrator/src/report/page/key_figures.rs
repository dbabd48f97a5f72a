//! The numbers that matter first, and what must be said with them.

use super::super::summary::LOWEST_PRESSURE;
use super::super::{Quantity, Summary};
use super::folder::RunFolder;
use crate::log::LogReadError;
use interface::Level;

/// How the names of the quantities begin, in their order.
const FIRST: [&str; 6] = [
    "peak crest displacement downstream",
    "peak crest displacement upstream",
    "residual sliding",
    "peak base shear",
    "largest tension in the dam",
    LOWEST_PRESSURE,
];

/// The quantities that matter first; where a run has no residual sliding, its peaks.
pub fn of(summary: &Summary) -> Vec<Quantity> {
    let figures = FIRST.iter().flat_map(|first| {
        let begin = |with: &str| {
            summary.quantities.iter().filter(|q| begins(&q.name, with)).cloned().collect::<Vec<_>>()
        };
        match begin(first) {
            found if found.is_empty() && *first == "residual sliding" => begin("peak sliding"),
            found => found,
        }
    });
    figures.collect()
}

/// Whether a quantity has this name, be it of one crack of several.
fn begins(name: &str, with: &str) -> bool {
    name.strip_prefix(with).is_some_and(|rest| rest.is_empty() || rest.starts_with(", "))
}

/// Warnings and notes: of the result, of the scene, and of the units.
///
/// **Errors**: the log cannot be read.
pub fn remarks(run: &RunFolder) -> Result<(Vec<String>, Vec<String>), LogReadError> {
    let (mut warnings, mut notes) = (Vec::<String>::new(), Vec::new());
    for note in &run.summary.notes {
        match note.strip_prefix("WARNING: ") {
            Some(warning) => warnings.push(warning.to_owned()),
            None => notes.push(note.clone()),
        }
    }
    let of_scene = run.loaded.warnings.iter().map(ToString::to_string);
    let said = run.log.messages()?.into_iter().filter(|message| message.level >= Level::Warning);
    let of_units = said
        .map(|message| format!("{} at t = {:.4} s: {}", message.unit, message.time, message.text.trim_end()));
    for warning in of_scene.chain(of_units) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    Ok((warnings, notes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(names: &[&str]) -> Summary {
        let quantity = |name: &&str| Quantity {
            name: (*name).to_owned(),
            value: 1.0,
            unit: "mm".into(),
            time: None,
            place: None,
            band: None,
        };
        Summary {
            status: "completed".to_owned(),
            simulated_time: 1.0,
            notes: Vec::new(),
            quantities: names.iter().map(quantity).collect(),
        }
    }

    #[test]
    fn every_crack_has_its_sliding() {
        let names = |of: &[&str]| of_names(&summary(of));
        assert_eq!(
            names(&[
                "peak sliding, neck",
                "residual sliding, lift",
                "peak base shear",
                "residual sliding, neck"
            ]),
            ["residual sliding, lift", "residual sliding, neck", "peak base shear"]
        );
        assert_eq!(names(&["peak opening", "peak sliding"]), ["peak sliding"]);
        assert!(names(&["peak crest displacement downstreamish"]).is_empty());
    }

    fn of_names(summary: &Summary) -> Vec<String> {
        of(summary).into_iter().map(|quantity| quantity.name).collect()
    }
}
