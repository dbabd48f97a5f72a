//! The results against the limits of the scene.

use super::super::Summary;
use super::data::Check;
use cofferdam_scene::LimitsScene;

/// Each limit against the quantities of the summary; nothing without limits.
pub fn criteria(limits: &LimitsScene, summary: &Summary) -> Vec<Check> {
    let LimitsScene { crest_displacement, residual_sliding, tension, freeboard } = *limits;
    let mut criteria = Vec::new();
    let largest = [
        (
            crest_displacement,
            1e3,
            "mm",
            "peak crest displacement",
            "peak crest displacement, both directions",
        ),
        (residual_sliding, 1e3, "mm", "residual sliding", "residual sliding of any crack"),
        (tension, 1e-6, "MPa", "largest tension in the dam", "largest tension in the dam"),
    ];
    for (limit, factor, unit, prefix, name) in largest {
        let Some(limit) = limit.map(|limit| factor * limit) else { continue };
        let found = summary.quantities.iter().filter(|quantity| quantity.name.starts_with(prefix));
        let largest = found.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        criteria.push(Check {
            name: name.to_owned(),
            found: largest.map_or(f64::NAN, |quantity| quantity.value.abs()),
            expected: None,
            unit,
            limit: format!("at most {limit} {unit}"),
            kept: largest.map(|quantity| quantity.value.abs() <= limit),
            remark: largest.map_or_else(|| ABSENT.to_owned(), |quantity| quantity.name.clone()),
        });
    }
    if let Some(limit) = freeboard {
        let found = summary.value("freeboard at the end");
        criteria.push(Check {
            name: "freeboard after the earthquake".to_owned(),
            found: found.unwrap_or(f64::NAN),
            expected: None,
            unit: "m",
            limit: format!("at least {limit} m"),
            kept: found.map(|found| found >= limit),
            remark: if found.is_none() { ABSENT.to_owned() } else { String::new() },
        });
    }
    criteria
}

const ABSENT: &str = "the run has no such result: it needs the part of the dam, and rest at the end";

/// The conclusion from the `criteria`; `complete` says whether the run reached its end.
pub fn conclusion(criteria: &[Check], complete: bool) -> String {
    let named = |kept: Option<bool>| {
        let of = criteria.iter().filter(|check| check.kept == kept);
        of.map(|check| check.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    let (exceeded, open) = (named(Some(false)), named(None));
    if !exceeded.is_empty() {
        return format!("Not accepted. Exceeded: {exceeded}.");
    }
    if !complete {
        return "No conclusion: the run did not reach its planned end.".to_owned();
    }
    if !open.is_empty() {
        return format!("No conclusion. Not determined: {open}.");
    }
    "All limits are kept by this run, a single realisation of one ground motion: compare them with the range of the results.".to_owned()
}

#[cfg(test)]
mod tests {
    use super::super::super::Quantity;
    use super::*;

    fn summary(of: &[(&str, f64)]) -> Summary {
        let quantity = |(name, value): &(&str, f64)| Quantity {
            name: (*name).to_owned(),
            value: *value,
            ..Quantity::default()
        };
        let quantities = of.iter().map(quantity).collect();
        Summary { status: String::new(), simulated_time: 1.0, notes: Vec::new(), quantities }
    }

    #[test]
    fn worst_joint_and_direction_decide() {
        let limits = LimitsScene {
            crest_displacement: Some(0.2),
            residual_sliding: Some(0.1),
            freeboard: Some(2.0),
            ..LimitsScene::default()
        };
        let results = [
            ("peak crest displacement downstream", 150.0),
            ("peak crest displacement upstream", -190.0),
            ("residual sliding, neck", 20.0),
            ("residual sliding, base", -101.0),
            ("freeboard at the end", 2.0),
        ];
        let judged = criteria(&limits, &summary(&results));
        let kept: Vec<_> = judged.iter().map(|check| (check.found, check.kept)).collect();
        assert_eq!(kept, [(190.0, Some(true)), (101.0, Some(false)), (2.0, Some(true))]);
        assert_eq!(judged[1].remark, "residual sliding, base");
        assert_eq!(conclusion(&judged, true), "Not accepted. Exceeded: residual sliding of any crack.");
        let shorter = criteria(&limits, &summary(&results[..2]));
        assert_eq!(
            conclusion(&shorter, true),
            "No conclusion. Not determined: residual sliding of any crack, freeboard after the earthquake."
        );
        let kept = criteria(&limits, &summary(&[results[0], results[2], results[4]]));
        assert!(conclusion(&kept, true).starts_with("All limits are kept"));
        assert!(conclusion(&kept, false).starts_with("No conclusion"));
        assert!(criteria(&LimitsScene::default(), &summary(&results)).is_empty());
    }
}
