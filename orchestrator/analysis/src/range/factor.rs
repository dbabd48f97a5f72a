//! What is varied, how far and why.

use super::setting::{Between, Choice, Factor, Values};
use crate::run::NOISE;
use cofferdam_report::{FactorKind, LeftOut, RangeFactor};
use cofferdam_scene::{
    CrackScene, DamFidelityScene, DamScene, DampingModel, Integration, LoadedScene, Plane, ReservoirScene,
    Side, UpliftRuleScene, uplift,
};
use cofferdam_unit::number::plain;

/// Factors on the damping ratio.
const DAMPING_RATIO: [f64; 2] = [0.6, 2.0];
/// Factors on the normal and shear stiffness of all joints.
const JOINT_STIFFNESS: [f64; 2] = [0.5, 2.0];
/// Factors on the friction coefficients of all joints.
const FRICTION: [f64; 2] = [0.9, 1.1];
/// Change of the wave reflection coefficient in both directions.
const REFLECTION: f64 = 0.1;
/// Wave reflection coefficient above which a bed is as good as rigid, and no recursion fits.
const ALMOST_RIGID: f64 = 0.99;
/// Factor on the length of the elements.
const ELEMENT_SIZE: f64 = 0.7;
/// Factor on time steps.
const STEP: f64 = 0.5;

/// The scene that is varied, and what the caller adds.
pub struct Subject<'a> {
    /// The scene, as its runs have it.
    pub loaded: &'a LoadedScene,
    /// `dam.time_step_safety` for half the time step of the dam, if it has one of its own.
    pub half_step: Option<f64>,
    /// Number of perturbed replicates.
    pub replicates: usize,
    /// Other records.
    pub records: &'a [Choice],
}

/// A row of the table of factors.
struct Row {
    name: &'static str,
    kind: FactorKind,
    /// The reason for its range.
    reason: &'static str,
    /// Whether it varies in the joint sample.
    joint: bool,
    /// Its range in words and its settings, or why the scene does not have it.
    of: fn(&Subject<'_>) -> Result<(String, Values), String>,
}

/// The factors, in the order of the tables.
const TABLE: [Row; 14] = [
    Row {
        name: "damping ratio",
        kind: FactorKind::Model,
        reason: "5 % is customary; 3 to 10 % have been identified in dams, more in strong shaking",
        joint: true,
        of: damping_ratio,
    },
    Row {
        name: "damping model",
        kind: FactorKind::Model,
        reason: "no model follows from measurements; they differ most in fast vibration and in sliding",
        joint: true,
        of: damping_model,
    },
    Row {
        name: "joint stiffness",
        kind: FactorKind::Model,
        reason: "a numerical stiffness, or one that is measured within a factor of two",
        joint: true,
        of: joint_stiffness,
    },
    Row {
        name: "friction coefficient",
        kind: FactorKind::Model,
        reason: "scatter between samples of one joint; 45° then lies between 42° and 48°",
        joint: true,
        of: friction,
    },
    Row {
        name: "polarity",
        kind: FactorKind::Model,
        reason: "the direction of a future earthquake is unknown",
        joint: true,
        of: polarity,
    },
    Row {
        name: "wave reflection coefficient",
        kind: FactorKind::Model,
        reason: "it follows from sediments that are seldom measured",
        joint: true,
        of: reflection,
    },
    Row {
        name: "plane condition",
        kind: FactorKind::Model,
        reason: "monoliths with open contraction joints are in plane stress, with closed ones nearer to plane strain",
        joint: true,
        of: plane,
    },
    Row {
        name: "uplift rule",
        kind: FactorKind::Model,
        reason: "authorities differ in the pressure in a crack that opens and closes",
        joint: true,
        of: uplift_rule,
    },
    Row {
        name: "element size",
        kind: FactorKind::Numerics,
        reason: "1.4 times as many elements along each line: what the mesh leaves open",
        joint: true,
        of: element_size,
    },
    Row {
        name: "contact points",
        kind: FactorKind::Numerics,
        reason: "both integrate the same stresses and differ in where a block rocks",
        joint: true,
        of: contact_points,
    },
    Row {
        name: "time step of the dam",
        kind: FactorKind::Numerics,
        reason: "the error of the explicit steps falls to a quarter",
        joint: false,
        of: dam_step,
    },
    Row {
        name: "communication step",
        kind: FactorKind::Numerics,
        reason: "the error of the coupling falls to a quarter",
        joint: false,
        of: communication_step,
    },
    Row {
        name: "model of the dam",
        kind: FactorKind::Numerics,
        reason: "what the reduction of the blocks to modes leaves open",
        joint: false,
        of: dam_model,
    },
    Row {
        name: "perturbed motion",
        kind: FactorKind::Motion,
        reason: "nobody knows a motion better; sliding amplifies the difference",
        joint: true,
        of: noise,
    },
];

/// The factors of a scene, and those that it does not have, with the reasons. Records come last.
pub fn of(subject: &Subject<'_>) -> (Vec<Factor>, Vec<LeftOut>) {
    let (mut factors, mut left_out) = (Vec::new(), Vec::new());
    let last = Row {
        name: "record",
        kind: FactorKind::Records,
        reason: "records of equal peak differ in duration, frequencies and pulses",
        joint: true,
        of: record,
    };
    for Row { name, kind, reason, joint, of } in TABLE.into_iter().chain([last]) {
        match of(subject) {
            Ok((range, values)) => {
                let (name, reason) = (name.to_owned(), reason.to_owned());
                factors.push(Factor { about: RangeFactor { name, kind, range, reason, joint }, values });
            }
            Err(reason) => left_out.push(LeftOut { what: name.to_owned(), reason }),
        }
    }
    (factors, left_out)
}

/// The dam, if this program computes it.
fn computed<'a>(subject: &Subject<'a>) -> Result<&'a DamScene, String> {
    subject.loaded.scene.computed_dam().ok_or_else(|| "another program computes the dam".to_owned())
}

/// The dam and its cracks, if it has any that can open.
fn cracked<'a>(subject: &Subject<'a>) -> Result<(&'a DamScene, &'a [CrackScene]), String> {
    let dam = computed(subject)?;
    match dam.cracks.is_empty() || dam.fidelity.is_intact() {
        true => Err("the dam has no crack".to_owned()),
        false => Ok((dam, &dam.cracks)),
    }
}

/// A key with a number.
fn set(key: &str, value: f64) -> String {
    format!("{key}={value:e}")
}

/// The settings with one for the scene as it is, where none of them has the number `base`.
fn choices(mut choices: Vec<Choice>, base: Option<usize>) -> Values {
    let base = base.unwrap_or(choices.len());
    match choices.get_mut(base) {
        // whatever it says in the scene
        Some(same) => same.sets.clear(),
        None => choices.push(Choice { name: "as in the scene".to_owned(), sets: Vec::new() }),
    }
    Values::Choices { choices, base }
}

fn named(choices: &[Choice]) -> String {
    choices.iter().map(|choice| &*choice.name).collect::<Vec<_>>().join(", ")
}

fn damping_ratio(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let ratio = computed(subject)?.damping.ratio;
    if ratio == 0.0 {
        return Err("the dam has no damping".to_owned());
    }
    let [low, high] = DAMPING_RATIO.map(|factor| (factor * ratio).min(0.9));
    let sets = Box::new(|ratio| vec![set("dam.damping.ratio", ratio)]);
    let values = Between { low, high, base: ratio, logarithmic: true, sets, before: "", after: "" };
    Ok((format!("{} to {}", plain(low), plain(high)), Values::Between(values)))
}

fn damping_model(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let damping = &computed(subject)?.damping;
    if damping.ratio == 0.0 {
        return Err("the dam has no damping".to_owned());
    }
    if damping.multiples_of_first.is_none() && damping.radians_per_second.is_none() {
        return Err("the scene gives no frequencies at which the damping ratio holds".to_owned());
    }
    let linear =
        DampingModel::ALL.into_iter().filter(|model| model.supports_modes() || *model == damping.model);
    let models: Vec<DampingModel> = linear.collect();
    let all = models.iter().map(|model| {
        let sets = vec![format!("dam.damping.model=\"{}\"", model.word())];
        Choice { name: model.word().to_owned(), sets }
    });
    let all: Vec<Choice> = all.collect();
    let base = models.iter().position(|model| *model == damping.model);
    Ok((named(&all), choices(all, base)))
}

/// The same factor on keys of all cracks.
fn of_joints(
    subject: &Subject<'_>,
    [low, high]: [f64; 2],
    logarithmic: bool,
    keys: fn(&CrackScene) -> Vec<(&'static str, f64)>,
) -> Result<Between, String> {
    let (_, cracks) = cracked(subject)?;
    let given: Vec<(String, f64)> = cracks
        .iter()
        .flat_map(|crack| {
            let key = |name: &str| format!("dam.cracks.{}.{name}", crack.number);
            keys(crack).into_iter().map(move |(name, value)| (key(name), value))
        })
        .collect();
    let sets = Box::new(move |factor| given.iter().map(|(key, value)| set(key, factor * value)).collect());
    Ok(Between { low, high, base: 1.0, logarithmic, sets, before: "× ", after: "" })
}

fn joint_stiffness(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let values = of_joints(subject, JOINT_STIFFNESS, true, |crack| {
        vec![("normal_stiffness", crack.normal_stiffness), ("shear_stiffness", crack.shear_stiffness)]
    })?;
    let [low, high] = JOINT_STIFFNESS.map(plain);
    Ok((format!("× {low} to × {high}, normal and shear, all joints"), Values::Between(values)))
}

fn friction(subject: &Subject<'_>) -> Result<(String, Values), String> {
    if cracked(subject)?.1.iter().all(|crack| crack.friction_coefficient == 0.0) {
        return Err("the joints have no friction".to_owned());
    }
    let values = of_joints(subject, FRICTION, false, |crack| {
        let residual = crack.residual_friction_coefficient.map(|mu| ("residual_friction_coefficient", mu));
        [("friction_coefficient", crack.friction_coefficient)].into_iter().chain(residual).collect()
    })?;
    let [low, high] = FRICTION.map(plain);
    Ok((format!("× {low} to × {high}, peak and residual, all joints"), Values::Between(values)))
}

fn polarity(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let shocks = subject.loaded.scene.ground_motion.shocks();
    if shocks.is_empty() {
        return Err("the ground moves in a ramp".to_owned());
    }
    let all = [("as in the scene", 1), ("reversed", -1)].map(|(name, sign)| Choice {
        name: name.to_owned(),
        sets: shocks
            .iter()
            .map(|shock| format!("{}.polarity={}", shock.table, sign * shock.record.polarity))
            .collect(),
    });
    Ok(("both, of the horizontal component".to_owned(), choices(all.into(), Some(0))))
}

fn reflection(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let compressible = |(_, water): &(Side, &ReservoirScene)| water.fidelity.is_compressible();
    let beds: Vec<(String, f64)> = subject
        .loaded
        .scene
        .waters()
        .filter(compressible)
        .map(|(side, water)| (side.key("wave_reflection_coefficient"), water.wave_reflection_coefficient))
        .collect();
    let Some((_, base)) = beds.first().cloned() else {
        return Err("there is no compressible water of this program".to_owned());
    };
    let limited =
        |value: f64, own: f64| value.clamp(0.0, if own > ALMOST_RIGID { own } else { ALMOST_RIGID });
    let [low, high] = [base - REFLECTION, base + REFLECTION].map(|value| limited(round(value), base));
    // Between an almost rigid and a rigid bed is nothing that the water can be stepped with.
    let sound = |value: f64, own: f64| if value < own { value.min(ALMOST_RIGID) } else { value };
    let sets = Box::new(move |value: f64| {
        let of_bed = |(key, own): &(String, f64)| {
            let moved = limited(round(own + value - base), *own);
            set(key, sound(moved, *own))
        };
        beds.iter().map(of_bed).collect()
    });
    let values = Between { low, high, base, logarithmic: false, sets, before: "", after: "" };
    Ok((format!("{} to {}", plain(low), plain(high)), Values::Between(values)))
}

/// Without the error of a sum of decimal numbers.
fn round(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

fn plane(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let dam = computed(subject)?;
    if dam.fidelity.is_rigid() {
        return Err("rigid blocks do not deform".to_owned());
    }
    let all = ["stress", "strain"].map(|plane| Choice {
        name: format!("plane {plane}"),
        sets: vec![format!("dam.material.plane=\"{plane}\"")],
    });
    let base = usize::from(dam.material.plane == Plane::Strain);
    Ok((named(&all), choices(all.into(), Some(base))))
}

fn uplift_rule(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let (dam, cracks) = cracked(subject)?;
    let scene = &subject.loaded.scene;
    let wet: Vec<&CrackScene> = cracks.iter().filter(|crack| uplift(scene, crack).is_some()).collect();
    let Some(first) = wet.first().map(|crack| crack.uplift_rule(dam.uplift)) else {
        return Err("no crack lies below the reservoir level".to_owned());
    };
    let rules = [
        (UpliftRuleScene::None, "none"),
        (UpliftRuleScene::Unchanged, "unchanged"),
        (UpliftRuleScene::ZeroWhereOpen, "zero-where-open"),
        (UpliftRuleScene::FullWhereOpen, "full-where-open"),
    ];
    let own = |crack: &&CrackScene| crack.uplift.as_ref().is_some_and(|uplift| uplift.rule.is_some());
    let own: Vec<usize> = cracks.iter().filter(own).map(|crack| crack.number).collect();
    let all = rules.map(|(_, word)| {
        let of_cracks = own.iter().map(|number| format!("dam.cracks.{number}.uplift.rule=\"{word}\""));
        let sets = std::iter::once(format!("dam.uplift=\"{word}\"")).chain(of_cracks).collect();
        Choice { name: word.to_owned(), sets }
    });
    let equal = wet.iter().all(|crack| crack.uplift_rule(dam.uplift) == first);
    let base = rules.iter().position(|(rule, _)| equal && *rule == first);
    Ok((named(&all), choices(all.into(), base)))
}

fn element_size(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let dam = computed(subject)?;
    if dam.mesh.is_some() {
        return Err("the mesh is that of a file".to_owned());
    }
    let own = dam
        .cracks
        .iter()
        .filter_map(|crack| Some((format!("dam.cracks.{}.element_size", crack.number), crack.element_size?)));
    let base = dam.element_size;
    let sizes: Vec<(String, f64)> =
        std::iter::once(("dam.element_size".to_owned(), base)).chain(own).collect();
    let sets =
        Box::new(move |size: f64| sizes.iter().map(|(key, own)| set(key, size / base * own)).collect());
    let low = ELEMENT_SIZE * base;
    let values = Between { low, high: base, base, logarithmic: true, sets, before: "", after: " m" };
    Ok((format!("× {ELEMENT_SIZE} to × 1, of all elements of the dam"), Values::Between(values)))
}

fn contact_points(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let (_, cracks) = cracked(subject)?;
    let kinds = [(Integration::Nodal, "nodal", "nodes"), (Integration::Gauss, "gauss", "Gauss points")];
    let all = kinds.map(|(_, word, name)| {
        let sets = cracks.iter().map(|crack| format!("dam.cracks.{}.integration=\"{word}\"", crack.number));
        Choice { name: name.to_owned(), sets: sets.collect() }
    });
    let base = kinds.iter().position(|(kind, ..)| cracks.iter().all(|crack| crack.integration == *kind));
    Ok((named(&all), choices(all.into(), base)))
}

/// Two settings: as it is, and another.
fn other(name: &str, sets: Vec<String>) -> Values {
    let as_it_is = Choice { name: "as in the scene".to_owned(), sets: Vec::new() };
    choices(vec![as_it_is, Choice { name: name.to_owned(), sets }], Some(0))
}

fn dam_step(subject: &Subject<'_>) -> Result<(String, Values), String> {
    cracked(subject)?;
    let Some(safety) = subject.half_step else {
        return Err("the dam has no time step of its own".to_owned());
    };
    Ok((format!("× {STEP}"), other("half", vec![set("dam.time_step_safety", safety)])))
}

fn communication_step(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let time = &subject.loaded.scene.time;
    if time.adaptive.is_some() {
        return Err("steps follow the estimate of the coupling error".to_owned());
    }
    let half = vec![set("time.communication_step", STEP * time.communication_step)];
    Ok((format!("× {STEP}"), other("half", half)))
}

fn dam_model(subject: &Subject<'_>) -> Result<(String, Values), String> {
    let (dam, _) = cracked(subject)?;
    let model = match dam.fidelity {
        DamFidelityScene::Reduced if dam.modes.is_some() => {
            return Err("a given number of modes needs a model with modes".to_owned());
        }
        DamFidelityScene::Reduced => "dem",
        DamFidelityScene::Dem if !dam.damping.model.supports_modes() => {
            return Err("local damping is not available with modes".to_owned());
        }
        DamFidelityScene::Dem => "reduced",
        _ => return Err("the model of the dam has no counterpart of the same physics".to_owned()),
    };
    let name = if model == "dem" { "every element" } else { "reduced blocks" };
    Ok((name.to_owned(), other(name, vec![format!("dam.fidelity=\"{model}\"")])))
}

fn noise(subject: &Subject<'_>) -> Result<(String, Values), String> {
    if subject.loaded.scene.ground_motion.record.is_none() {
        return Err("the ground moves in a ramp".to_owned());
    }
    if subject.replicates == 0 {
        return Err("no replicates are asked for".to_owned());
    }
    let range = format!("noise of {} % in {} replicates", 100.0 * NOISE, subject.replicates);
    Ok((range, Values::Noise(subject.replicates)))
}

fn record(subject: &Subject<'_>) -> Result<(String, Values), String> {
    if subject.records.is_empty() {
        return Err("not covered: give other records with --record".to_owned());
    }
    let of_scene = Choice { name: "as in the scene".to_owned(), sets: Vec::new() };
    let others = subject.records.iter().cloned();
    let all: Vec<Choice> = std::iter::once(of_scene).chain(others).collect();
    Ok((format!("{} of the same peak acceleration", all.len()), choices(all, Some(0))))
}
