//! Statements of the paper in words, compared with our runs.

use super::response::Quantity;
use super::runs::{ADDED_MASS, FINITE_ELEMENTS, RIGID_DAM, Run, Series};
use super::statements::{AGREEMENT, Earthquake, FLEXIBLE, LITTLE};
use cofferdam_analysis::table::Table;
use cofferdam_scene::DamScene;

/// A statement and the numbers that decide it.
pub struct Claim {
    pub figure: u8,
    /// Earthquake or dam.
    pub name: &'static str,
    pub says: &'static str,
    pub ours: String,
    /// Criterion.
    pub criterion: String,
    pub holds: bool,
}

/// Of figure 3: largest differences from the closed form over its peak.
pub fn of_elements([constant, linear]: [f64; 2]) -> Claim {
    Claim {
        figure: 3,
        name: "rigid dam",
        says: "constant and linear elements agree with the exact solution",
        ours: format!("off by {:.2} and {:.2} % of its peak at most", 100.0 * constant, 100.0 * linear),
        criterion: format!("both at most {:.0} %", 100.0 * AGREEMENT),
        holds: constant.max(linear) <= AGREEMENT,
    }
}

/// Of figure 4.
pub fn of_flexible_dam(series: &Series) -> Claim {
    let [boundary, finite] = [series.base(), series.run(FINITE_ELEMENTS)];
    let peak = ratio(finite, boundary, |run| run.response.peak(Quantity::BasePressure)) - 1.0;
    Claim {
        figure: 4,
        name: FLEXIBLE[1],
        says: "boundary elements agree with finite elements",
        ours: format!(
            "peak {:+.1} %; {:.0} % in the mean square over time",
            100.0 * peak,
            100.0 * finite.response.apart(&boundary.response, Quantity::BasePressure)
        ),
        criterion: format!("peaks within {:.0} %", 100.0 * AGREEMENT),
        holds: peak.abs() <= AGREEMENT,
    }
}

/// Of figures 7 to 13; the cracked dam of `series`, which has run.
pub fn of_cracked_dam(earthquake: &Earthquake, series: &Series) -> Vec<Claim> {
    let claim = |figure, says, ours, criterion, holds| Claim {
        figure,
        name: earthquake.name,
        says,
        ours,
        criterion,
        holds,
    };
    let base = series.base();
    let [rigid, finite, added] = [RIGID_DAM, FINITE_ELEMENTS, ADDED_MASS].map(|what| series.run(what));
    let peaks = |run: &Run, quantity| run.response.peak(quantity);
    let pressures = [rigid, base].map(|run| peaks(run, Quantity::BasePressure));
    let [below, above, crest] =
        [Quantity::Below, Quantity::Above, Quantity::Crest].map(|quantity| peaks(base, quantity));
    let slid = |run: &Run| run.response.residual.abs();
    let turned = |run: &Run| peaks(run, Quantity::Rotation);
    let of_finite = ratio(finite, base, slid) - 1.0;
    let [of_sliding, of_rotation] = [ratio(added, base, slid), ratio(added, base, turned)].map(|r| r - 1.0);
    let topples = base.loaded.scene.dam.as_ref().map_or(0.0, |dam| 1e3 * least_toppling_angle(dam));
    let percent = |share: f64| format!("{:+.0} %", 100.0 * share);
    let within = |share: f64| format!("within {:.0} %", 100.0 * share);
    vec![
        claim(
            7,
            "the dam's flexibility changes the pressure considerably",
            format!("rigid {:.3}, flexible {:.3} of the hydrostatic pressure", pressures[0], pressures[1]),
            format!("peaks more than {:.0} % apart", 100.0 * AGREEMENT),
            (pressures[1] / pressures[0] - 1.0).abs() > AGREEMENT,
        ),
        claim(
            earthquake.of_accelerations,
            "the acceleration above the crack is a little smaller than below",
            format!("above {above:.2} g, below {below:.2} g"),
            format!("smaller, {}", within(LITTLE)),
            above < below && above >= (1.0 - LITTLE) * below,
        ),
        claim(
            earthquake.of_accelerations,
            "the peak at the crest is about that at the crack",
            format!("crest {crest:.2} g, below {below:.2} g"),
            within(LITTLE),
            (crest / below - 1.0).abs() <= LITTLE,
        ),
        claim(
            12,
            "water of finite elements gives about the same sliding",
            format!(
                "{} where the paper has {}",
                percent(of_finite),
                percent(earthquake.sliding[1] / earthquake.sliding[0] - 1.0)
            ),
            within(AGREEMENT),
            of_finite.abs() <= AGREEMENT,
        ),
        claim(
            12,
            "sliding and rotation with an added mass are significantly different",
            format!("sliding {}, rotation {}", percent(of_sliding), percent(of_rotation)),
            format!("each more than {:.0} % apart", 100.0 * AGREEMENT),
            of_sliding.abs().min(of_rotation.abs()) > AGREEMENT,
        ),
        claim(
            13,
            "the block is safe against overturning",
            format!("{:.1} mrad at most; it topples beyond {topples:.0} mrad at the least", turned(base)),
            "less than that".to_owned(),
            turned(base) < topples,
        ),
    ]
}

/// A measure of a run over that of another.
fn ratio(run: &Run, other: &Run, measure: impl Fn(&Run) -> f64) -> f64 {
    measure(run) / measure(other)
}

/// A lower bound of the angle (rad) from which on a block that narrows upwards topples over a corner of its base, atan(b/2h), b its
/// width at the crest and h its height above the crack: its centre lies no higher than h, and no closer to a corner than b/2.
fn least_toppling_angle(dam: &DamScene) -> f64 {
    let (Some([left, top]), Some([right, _])) = (dam.section.upstream.last(), dam.section.downstream.last())
    else {
        return 0.0;
    };
    let crack = dam.cracks.first().map_or(0.0, |crack| crack.mean_elevation());
    (0.5 * (right - left) / (top - crack)).atan()
}

pub fn table(claims: &[Claim]) -> Table {
    let mut table = Table::new(["figure", "", "the paper says", "ours", "counts as so", "verdict"]);
    for Claim { figure, name, says, ours, criterion, holds } in claims {
        let verdict = if *holds { "holds" } else { "does not hold" };
        table.row([&figure.to_string(), *name, says, ours, criterion, verdict]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_agree_if_both_do() {
        let holds = |errors| of_elements(errors).holds;
        assert!(holds([0.05, 0.01]) && !holds([0.2, 0.01]) && !holds([0.01, 0.2]));
    }
}
