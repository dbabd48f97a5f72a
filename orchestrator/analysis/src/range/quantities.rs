//! The quantities of a run.

use crate::study::{CREST, Outcome};
use cofferdam_assembly::observer::LastSecond;
use cofferdam_scene::{CrackScene, REST, Scene};

/// Energy balance error over the peak kinetic energy above which a run is doubtful.
const ENERGY_ALARM: f64 = 0.01;

/// A value of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Name of the quantity.
    pub name: String,
    /// Unit of the value.
    pub unit: &'static str,
    /// The value; magnitudes but for sliding, which is positive downstream.
    pub value: f64,
}

/// The values of a run, and what is doubtful about them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    /// The values.
    pub values: Vec<Measured>,
    /// Whether all blocks were at rest at the end.
    pub at_rest: bool,
    /// Labels of the joints that slide away.
    pub away: Vec<String>,
    /// What is doubtful.
    pub doubts: Vec<String>,
}

impl Results {
    /// The value of a quantity; NaN if the run has none.
    pub fn value(&self, name: &str) -> f64 {
        self.values.iter().find(|measured| measured.name == name).map_or(f64::NAN, |measured| measured.value)
    }
}

/// The sliding of a joint after the earthquake.
pub const SLIDING: &str = "residual sliding";

/// The quantities of a run of `scene` that has ended.
///
/// Sliding is the mean over the last second, whether the block is at rest or not, and infinite where it slides away; all else is
/// without meaning then, as motion and blocks never end, and left out.
pub fn of(scene: &Scene, outcome: &Outcome) -> Results {
    let mut results = Results { at_rest: true, ..Results::default() };
    let dam = scene.dam.as_ref();
    let intact = dam.is_none_or(|dam| dam.fidelity.is_intact());
    let cracks = dam.map_or(&[][..], |dam| if intact { &[] } else { &dam.cracks });
    let quiet = scene.time.quiet >= REST && outcome.failure.is_none();
    let peak = |column: &str| if outcome.column(column).is_empty() { f64::NAN } else { outcome.peak(column) };
    for (number, crack) in cracks.iter().enumerate() {
        let of = |what: &str| of_joint(what, crack, cracks);
        let column = |name: &str| format!("dam.crack_{name}.{number}");
        if let Some(last) = LastSecond::of(&outcome.histories, &column("sliding")) {
            let away = last.slides_away(quiet);
            if away {
                results.away.push(crack.label());
            }
            results.at_rest &= last.is_rest() || away;
            let sliding = if away { f64::INFINITY.copysign(last.sliding) } else { last.sliding };
            results.values.push(Measured { name: of(SLIDING), unit: "mm", value: 1e3 * sliding });
        }
    }
    if !results.away.is_empty() {
        return results;
    }
    let mut add = |name: String, unit, value: f64| {
        if value.is_finite() {
            results.values.push(Measured { name, unit, value });
        }
    };
    for (number, crack) in cracks.iter().enumerate() {
        let of = |what: &str| of_joint(what, crack, cracks);
        let column = |name: &str| format!("dam.crack_{name}.{number}");
        add(of("least factor against sliding"), "1", 1.0 / peak(&column("shear_utilisation")));
        add(of("peak opening"), "mm", 1e3 * peak(&column("opening")));
    }
    add("peak crest displacement".to_owned(), "mm", 1e3 * peak(CREST));
    add("peak base shear".to_owned(), "MN/m", 1e-6 * peak("dam.base_shear"));
    if dam.is_some_and(|dam| !dam.fidelity.is_rigid() && !dam.fidelity.is_foreign()) {
        // The first point is the heel.
        let stress = outcome.column("dam.major_principal_stress.0").iter().copied().reduce(f64::max);
        add("largest tension, heel".to_owned(), "MPa", 1e-6 * stress.unwrap_or(f64::NAN));
    }
    let error = peak("dam.energy_balance_error") / peak("dam.kinetic_energy");
    if error > ENERGY_ALARM {
        results.doubts.push(format!("energy balance error of {:.1} %", 100.0 * error));
    }
    if let count @ 1.. = outcome.ending.statistics.unconverged {
        results.doubts.push(format!("{count} communication steps did not converge"));
    }
    results
}

/// The name of a quantity of one of the joints: with the joint's where it has one, or where there are others.
fn of_joint(what: &str, joint: &CrackScene, joints: &[CrackScene]) -> String {
    match joints.len() > 1 || joint.name.is_some() {
        true => format!("{what}, {}", joint.label()),
        false => what.to_owned(),
    }
}
