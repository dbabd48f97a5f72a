//! The promised accuracy of a run.

use crate::context::Context;
use cofferdam_report::{Accuracy, PlanRow, Summary};
use std::collections::BTreeMap;

/// Word of a manifest for [`Verdict::Kept`].
pub const KEPT: &str = "kept";
/// Word of a manifest for [`Verdict::NotKept`].
pub const NOT_KEPT: &str = "not kept";
/// Word of a manifest for [`Verdict::Impossible`].
pub const CANNOT: &str = "cannot be kept";

/// Whether an accuracy is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Expected errors meet the request.
    Kept,
    /// They are larger.
    NotKept,
    /// 1 % of shaking changes the result by more than the request.
    Impossible,
}

/// The promised accuracy of a run.
#[derive(Clone, Debug)]
pub struct Promise {
    /// The record in the manifest.
    pub record: Accuracy,
    /// The plan in the manifest; empty in a study.
    pub plan: Vec<PlanRow>,
}

impl Promise {
    /// Whether the accuracy is kept.
    pub fn verdict(&self) -> Verdict {
        match &*self.record.verdict {
            KEPT => Verdict::Kept,
            NOT_KEPT => Verdict::NotKept,
            _ => Verdict::Impossible,
        }
    }

    /// Adds what is promised to the notes of a summary.
    pub fn note(&self, summary: &mut Summary) {
        summary.notes.push(self.sentence());
        for (quantity, [low, median, high]) in &self.record.band {
            summary.notes.push(format!(
                "{quantity}: {low:.3}, {median:.3}, {high:.3} mm are 16 %, median and 84 % of replicates with 1 % noise on the motion: quote this band"
            ));
        }
    }

    /// The promise in a sentence.
    pub fn sentence(&self) -> String {
        let Accuracy { verdict, asked, expected, sensitivity, .. } = &self.record;
        let each = asked.iter().map(|(quantity, asked)| {
            let of = |values: &BTreeMap<String, f64>| values.get(quantity).copied();
            let moved = of(sensitivity)
                .map_or_else(String::new, |s| format!(", 1 % of shaking changes it by {:.1} %", 100.0 * s));
            format!(
                "{quantity} {:.2} % of {:.1} % requested{moved}",
                100.0 * of(expected).unwrap_or(f64::NAN),
                100.0 * asked
            )
        });
        format!(
            "numerical accuracy: {verdict}; expected numerical error against the reference: {}; the range of models is not included",
            each.collect::<Vec<_>>().join("; ")
        )
    }
}

/// Reports what was chosen.
pub fn announce(promise: &Promise, context: &Context<'_>) {
    let Accuracy { chosen, pilot_runs, pilot_time, left_by_reference, .. } = &promise.record;
    context.line(format!("pilot: {pilot_runs} runs in {pilot_time:.1} s; chosen: {}", chosen.join(", ")));
    context.line(promise.sentence());
    for (quantity, error) in left_by_reference {
        context.line(format!(
            "the reference's own elements leave about {:.2} % of the {quantity}",
            100.0 * error
        ));
    }
}
