//! Which joint governs the sliding.

use super::runs::{Runs, digits};
use crate::statistics::quantile;
use crate::table::Table;

/// Quantities that each joint has.
const OF_JOINTS: [&str; 2] = ["residual sliding", "peak sliding"];

/// Which joint governs, for dams with several: a row for each quantity, level and joint, and a short table for each quantity and level. In a run
/// the joint governs whose sliding is the largest share of its lowest limit, or is the largest if not every joint has a limit for the quantity.
pub fn governing(runs: &Runs<'_>) -> Option<(Table, Table)> {
    let mut table = Table::new([
        "quantity",
        "level",
        "joint",
        "runs",
        "governs",
        "median [mm]",
        "lowest limit [mm]",
        "by",
    ]);
    let mut short = Table::new(["quantity", "level", "governing joint", "in", "its median, mm"]);
    let mut has_joints = false;
    for quantity in OF_JOINTS {
        let prefix = format!("{quantity}, ");
        let joints: Vec<&str> =
            runs.quantities.iter().filter_map(|(name, _)| name.strip_prefix(&prefix)).collect();
        if joints.len() < 2 {
            continue;
        }
        has_joints = true;
        let name = |joint: &str| format!("{prefix}{joint}");
        let limits: Vec<Option<f64>> = joints
            .iter()
            .map(|joint| {
                let of_joint = runs.ensemble.plan.limits.iter().filter(|limit| limit.quantity == name(joint));
                of_joint.map(|limit| limit.above).min_by(f64::total_cmp)
            })
            .collect();
        let by_limit = limits.iter().all(Option::is_some);
        for (level, of_level) in runs.levels() {
            let slidings: Vec<Vec<f64>> = of_level
                .iter()
                .map(|run| {
                    joints.iter().map(|joint| runs.kept[*run].value(&name(joint)).abs()).collect::<Vec<_>>()
                })
                .filter(|values| values.iter().all(|value| !value.is_nan()))
                .collect();
            let mut counts = vec![0usize; joints.len()];
            for values in &slidings {
                let demand = |joint: usize| match limits[joint] {
                    Some(limit) if by_limit => values[joint] / limit,
                    _ => values[joint],
                };
                let largest = (0..joints.len()).max_by(|a, b| demand(*a).total_cmp(&demand(*b)));
                if let Some(joint) = largest.filter(|joint| demand(*joint) > 0.0) {
                    counts[joint] += 1;
                }
            }
            let median = |joint: usize| {
                let mut values: Vec<f64> = slidings.iter().map(|values| values[joint]).collect();
                values.sort_by(f64::total_cmp);
                quantile(&values, 0.5)
            };
            for (number, joint) in joints.iter().enumerate() {
                let shown = |value: f64| if value.is_finite() { value.to_string() } else { String::new() };
                table.row([
                    quantity.to_owned(),
                    level.clone(),
                    (*joint).to_owned(),
                    slidings.len().to_string(),
                    counts[number].to_string(),
                    shown(median(number)),
                    limits[number].map_or_else(String::new, |limit| limit.to_string()),
                    if by_limit { "share of its lowest limit" } else { "sliding" }.to_owned(),
                ]);
            }
            let most = (0..joints.len()).max_by_key(|joint| (counts[*joint], std::cmp::Reverse(*joint)));
            if let Some(joint) = most.filter(|joint| counts[*joint] > 0) {
                short.row([
                    quantity.to_owned(),
                    level,
                    joints[joint].to_owned(),
                    format!("{} of {} runs", counts[joint], slidings.len()),
                    digits(median(joint)),
                ]);
            }
        }
    }
    has_joints.then_some((table, short))
}
