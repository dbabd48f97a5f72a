//! The resultant of the effective normal forces in a joint over time.

use cofferdam_assembly::observer::Histories;
use std::ops::Range;

/// Share of the normal force at time 0 below which a joint has no resultant: where little presses, little decides where it acts.
const LEAST: f64 = 0.1;
/// Distance from the downstream end over the length below which the linear distribution says nothing about the stress there: it is that
/// of a block that rocks on its edge.
const ON_EDGE: f64 = 0.05;

/// Where the resultant acted in a run, as distances from the downstream end over the length of the joint, and the stress there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resultant {
    /// Smallest and largest distance.
    pub range: [f64; 2],
    /// Distance in the last row; `None` if the joint carries too little then.
    pub last: Option<f64>,
    /// How long it acted outside the middle third, s.
    pub outside_third: f64,
    /// How long the joint carried too little to have a resultant, s.
    pub without: f64,
    /// Largest stress at the downstream end by a linear distribution without tension, while the resultant is farther than
    /// [`ON_EDGE`] from it, Pa.
    pub toe_stress: f64,
}

/// Distance of the resultant from the downstream end over the `length` (m) of a crack, row by row: `1/2 − M/(N L)` with the normal
/// force N and its moment M about the middle; NaN where the joint carries less than [`LEAST`] of its normal force at time 0. `None` if
/// the run recorded neither.
pub(crate) fn shares(histories: &Histories, crack: usize, length: f64) -> Option<Vec<f64>> {
    let column = |name: &str| histories.column(&format!("dam.crack_{name}.{crack}"));
    let (normal, moment) = (column("normal_force")?, column("moment")?);
    let least = LEAST * normal.first().copied().unwrap_or(0.0).max(0.0);
    let share = |(normal, moment): (&f64, &f64)| {
        if *normal > least { 0.5 - moment / (normal * length) } else { f64::NAN }
    };
    (length > 0.0).then(|| normal.iter().zip(moment).map(share).collect())
}

/// The resultant of a crack of this `length` (m) in these `rows` of the histories. `None` if the run recorded none, or the joint
/// carried too little throughout.
pub(crate) fn of(histories: &Histories, crack: usize, length: f64, rows: Range<usize>) -> Option<Resultant> {
    let shares = shares(histories, crack, length)?;
    let normal = histories.column(&format!("dam.crack_normal_force.{crack}"))?;
    let time = histories.column("time")?;
    let in_rows = || rows.clone().filter_map(|row| Some((row, *shares.get(row)?)));
    let known = || in_rows().filter(|(_, share)| share.is_finite());
    known().next()?;
    // the value at the end of a step applies to the whole step
    let step = |row: usize| if row > 0 { time[row] - time[row - 1] } else { 0.0 };
    let third = 1.0 / 3.0;
    let outside = known().filter(|(_, share)| *share < third || *share > 2.0 * third);
    Some(Resultant {
        range: known()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (_, share)| [a.min(share), b.max(share)]),
        last: in_rows().next_back().map(|(_, share)| share).filter(|share| share.is_finite()),
        outside_third: outside.map(|(row, _)| step(row)).sum(),
        without: in_rows().filter(|(_, share)| !share.is_finite()).map(|(row, _)| step(row)).sum(),
        toe_stress: known()
            .filter(|(_, share)| *share >= ON_EDGE)
            .map(|(row, share)| toe_stress(normal[row] / length, share))
            .fold(0.0, f64::max),
    })
}

/// Stress at the downstream end of a joint with the `mean` stress (Pa) whose resultant acts at this `share` of its length from there:
/// `(N/L)(4 − 6 s)` in the middle third, `2N/(3 s L)` closer to the end, where the joint opens from upstream; 0 farther from it.
fn toe_stress(mean: f64, share: f64) -> f64 {
    let third = 1.0 / 3.0;
    if share >= third { mean * (4.0 - 6.0 * share).max(0.0) } else { 2.0 * mean / (3.0 * share) }
}

impl Resultant {
    /// What it was, in a sentence.
    pub fn sentence(&self) -> String {
        let Self { range: [low, high], last, outside_third, without, toe_stress } = *self;
        let last = last.map_or_else(String::new, |last| format!(", {:.0} % at the end", 100.0 * last));
        let without = match without {
            0.0 => String::new(),
            _ => format!(
                "; for {without:.2} s the joint carried less than a tenth of its normal force at rest"
            ),
        };
        format!(
            "The effective resultant acts {:.0} to {:.0} % of the joint from the toe{last}, outside the middle third for \
             {outside_third:.2} s{without}. Largest stress at the toe {:.2} MPa, by a linear distribution without tension \
             (not counted: a resultant within {} % of the toe, where the block rocks on its edge).",
            100.0 * low,
            100.0 * high,
            1e-6 * toe_stress,
            100.0 * ON_EDGE
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint of 6 m whose middle third is from 2 to 4 m.
    #[test]
    fn resultant_leaves_the_middle_third_and_the_toe_is_pressed() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("histories.csv");
        let text = "time [s],dam.crack_normal_force.0 [N/m],dam.crack_moment.0 [N.m/m]\n\
                    0,12,0\n1,12,12\n3,12,24\n4,1,5\n5,12,-6\n";
        std::fs::write(&path, text)?;
        let histories = Histories::read(&path).map_err(std::io::Error::other)?;
        let found = of(&histories, 0, 6.0, 0..5).expect("a resultant");
        // e = 0, 1, 2, none, −0.5 m: 3, 2, 1 and 3.5 m from the toe
        assert!((found.range[0] - 1.0 / 6.0).abs() < 1e-15 && (found.range[1] - 3.5 / 6.0).abs() < 1e-15);
        assert_eq!((found.last, found.outside_third, found.without), (Some(3.5 / 6.0), 2.0, 1.0));
        // 2N/(3 · 1 m)
        assert!((found.toe_stress - 8.0).abs() < 1e-12, "{}", found.toe_stress);
        // at the edge of the middle third both formulas give twice the mean stress, 4
        assert!(
            (toe_stress(2.0, 1.0 / 3.0) - 4.0).abs() < 1e-12 && (toe_stress(2.0, 0.5) - 2.0).abs() < 1e-12
        );
        assert_eq!(of(&histories, 1, 6.0, 0..5), None);
        assert_eq!(of(&histories, 0, 6.0, 3..4), None);
        Ok(())
    }
}
