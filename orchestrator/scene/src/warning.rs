//! What may be run, but is doubtful.

use super::shape::{Shape, word};
use super::{
    CrackScene, DamScene, FidelityScene, MaterialScene, ReservoirScene, Scene, Shock, Side, Source,
    UpliftRuleScene, UpliftScene,
};
use cofferdam_coupling::convergence::Tolerance;
use cofferdam_coupling::scheme::SchemeKind;
use cofferdam_motion::{Component, GroundMotion, STANDARD_GRAVITY};
use cofferdam_reservoir::Method;
use cofferdam_unit::number::plain;
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::sync::Arc;

/// A doubtful choice, at its place in the file.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("{warning}")]
#[diagnostic(severity(Warning))]
pub struct SceneWarning {
    /// What is doubtful.
    pub warning: Warning,
    /// The file.
    #[source_code]
    pub source_code: NamedSource<Arc<String>>,
    /// The place.
    #[label("here")]
    pub span: SourceSpan,
}

/// What can be doubtful about a scene; every message has the numbers and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The dam's mesh is too coarse for the record.
    #[error(
        "`dam.element_size` is {size} m: {elements:.1} elements per shear wavelength ({wavelength:.0} m) at {frequency:.1} Hz, \
         below which {percent} % of the record's energy lies; {ELEMENTS_OF_THE_DAM} are recommended: use {least} m or less",
        elements = wavelength / size, percent = 100.0 * ENERGY, least = down(wavelength / ELEMENTS_OF_THE_DAM)
    )]
    CoarseDam {
        /// Element size, m.
        size: f64,
        /// Length of a shear wave at that frequency, m.
        wavelength: f64,
        /// Highest frequency of the record, Hz.
        frequency: f64,
    },
    /// The reservoir's mesh is too coarse for the record.
    #[error(
        "`{table}.element_size` is {size} m: {elements:.1} elements per acoustic wavelength ({wavelength:.0} m) at \
         {frequency:.1} Hz, below which {percent} % of the record's energy lies; {ELEMENTS_OF_THE_RESERVOIR} are \
         recommended: use {least} m or less",
        elements = wavelength / size, percent = 100.0 * ENERGY, least = down(wavelength / ELEMENTS_OF_THE_RESERVOIR)
    )]
    CoarseReservoir {
        /// The water's table.
        table: &'static str,
        /// Element size, m.
        size: f64,
        /// Length of a sound wave at that frequency, m.
        wavelength: f64,
        /// Highest frequency of the record, Hz.
        frequency: f64,
    },
    /// The reservoir's mesh is too coarse for any motion.
    #[error(
        "`{table}.element_size` is {size} m: {elements:.1} elements over a depth of {depth} m; {ELEMENTS_OF_THE_DEPTH} are \
         recommended: use {least} m or less",
        elements = depth / size, least = down(depth / ELEMENTS_OF_THE_DEPTH)
    )]
    CoarseFace {
        /// The water's table.
        table: &'static str,
        /// Element size, m.
        size: f64,
        /// Depth of the water, m.
        depth: f64,
    },
    /// The communication step is too long for the record.
    #[error(
        "`{key}` is {step} s: {steps:.1} steps per period at {frequency:.1} Hz, below which {percent} % \
         of the record's energy lies; {STEPS_A_PERIOD} are recommended: use {better} s",
        steps = 1.0 / (step * frequency), percent = 100.0 * ENERGY
    )]
    CoarseStep {
        /// The key.
        key: &'static str,
        /// Communication step, s.
        step: f64,
        /// Highest frequency of the record, Hz.
        frequency: f64,
        /// A whole fraction of the record's interval that is short enough, s.
        better: f64,
    },
    /// The communication step is not an integer fraction of the record's interval.
    #[error(
        "`time.communication_step` is {step} s, which is not an integer fraction of the record's interval of {interval} s: peaks \
         between communication points are cut off; use {better} s"
    )]
    ClippedSamples {
        /// Communication step, s.
        step: f64,
        /// Interval of the record, s.
        interval: f64,
        /// A smaller whole fraction, s.
        better: f64,
    },
    /// The record does not come to rest.
    #[error(
        "{} drifts: the ground ends at {velocity:.0} % of its peak velocity and {displacement:.0} % of its peak \
         displacement; correct the record's baseline, or crop it where the ground is at rest",
        of_component(table)
    )]
    Drift {
        /// Key of the component's table, such as `ground_motion.record`.
        table: String,
        /// Velocity at the end over the peak, %.
        velocity: f64,
        /// Displacement at the end over the peak, %.
        displacement: f64,
    },
    /// An acceleration that no ground has.
    #[error(
        "{}'s peak is {peak:.1} g, more than {LARGEST_PEAK} g; check the unit of the file, `{table}.units`, and `{table}.scale`",
        of_component(table)
    )]
    Peak {
        /// Key of the component's table, such as `ground_motion.record`.
        table: String,
        /// Peak acceleration, g.
        peak: f64,
    },
    /// A shock that moves the ground horizontally only, while others do not.
    #[error(
        "`{table}` has no vertical component, but other shocks have one: the ground moves only horizontally in it; give \
         {} unless that is meant",
        Shape::header(vertical_table)
    )]
    LevelShock {
        /// Key of the record's table.
        table: String,
        /// Key of the table of its vertical component.
        vertical_table: String,
    },
    /// Too short a rest for the residual sliding.
    #[error(
        "`{key}` is {rest} s: no residual sliding is given after the shock before, which needs {REST} s of rest; the dam may still move \
         when the next shock begins"
    )]
    ShortRest {
        /// The key.
        key: String,
        /// Its value, s.
        rest: f64,
    },
    /// Too short a rest for the residual sliding.
    #[error(
        "the run ends {}: no residual sliding is given, which needs {REST} s of rest; lengthen `{key}`", at_end(*rest)
    )]
    NoResidual {
        /// The key that decides over it.
        key: &'static str,
        /// Time without ground motion, s; negative before the ground comes to rest.
        rest: f64,
    },
    /// Tolerance too loose.
    #[error(
        "`coupling.tolerance` is {tolerance}; above {LOOSEST_TOLERANCE} the two units agree to fewer than three \
         digits; use 1e-6"
    )]
    LooseTolerance {
        /// Tolerance.
        tolerance: f64,
    },
    /// A crack without damping.
    #[error(
        "`dam.damping.ratio` is 0 with a crack: vibrations after an impact are not damped, and the sliding depends on them; \
         give a ratio, such as 0.05"
    )]
    UndampedCrack,
    /// Uplift in a crack, which the scene leaves out.
    #[error(
        "{crack} is {below} m below the reservoir level; its uplift, {uplift:.2} MN/m for a pressure that falls \
         linearly to {} downstream, is left out by `uplift` = \"none\", and would increase the sliding; set `dam.uplift` to \
         \"unchanged\", or keep \"none\" if no water can enter",
        if *downstream > 0.0 { "that of the tailwater" } else { "zero" },
        below = plain(*below), uplift = 1e-6 * uplift
    )]
    NoUplift {
        /// What the lowest crack is called.
        crack: String,
        /// Depth of its mean elevation, m.
        below: f64,
        /// Mean of the pressures at both ends × length of the crack, N/m.
        uplift: f64,
        /// Pressure at its downstream end, Pa.
        downstream: f64,
    },
    /// A bond that the first opening breaks.
    #[error(
        "{crack} has a cohesion of {cohesion} kPa without `tensile_strength`: each contact loses it when the crack first opens there, \
         and keeps only its residual friction; set a tensile strength, or check the bonded share after the run"
    )]
    BrittleBond {
        /// What the crack is called.
        crack: String,
        /// Cohesion, kPa.
        cohesion: f64,
    },
    /// A description of water in a crack that has no effect.
    #[error("`uplift` of {crack} has no effect {because}; leave it out, or set {remedy}")]
    UpliftWithoutEffect {
        /// What the crack is called.
        crack: String,
        /// Why.
        because: &'static str,
        /// What lets it act.
        remedy: &'static str,
    },
    /// A crest that is not level.
    #[error(
        "the crest slopes from {} m upstream to {} m downstream; if it is level, the {lower} side lacks its last point",
        plain(*upstream), plain(*downstream)
    )]
    SlopingCrest {
        /// Elevation of its upstream end, m.
        upstream: f64,
        /// Elevation of its downstream end, m.
        downstream: f64,
        /// The side that ends lower.
        lower: &'static str,
    },
    /// Blocks that do not deform.
    #[error(
        "`dam.fidelity` = \"rigid-blocks\" is unsafe: the amplification of the ground motion by the dam is not modelled, and \
         sliding is underestimated; choose \"reduced\" or \"dem\" for reliable results"
    )]
    RigidBlocks,
    /// A unit that returns its outputs of a recorded run.
    #[error(
        "`{table}.fidelity` = \"log\" opens the loop: the {table} returns its outputs of the recorded run, whatever the other side \
         does now; nothing is iterated, and the result is a coupled solution only if the other side is that of the recorded run"
    )]
    OpenLoop {
        /// The unit's table.
        table: &'static str,
    },
    /// Keys that have no effect on the chosen water.
    #[error(
        "{} no effect with `{table}.fidelity` = \"{}\"{}; leave {} out, or choose other water",
        listed(keys), word(fidelity),
        method.map_or_else(String::new, |method| format!(" and `{table}.method` = \"{}\"", word(&method))),
        if keys.len() == 1 { "it" } else { "them" }
    )]
    WithoutEffect {
        /// The water's table.
        table: &'static str,
        /// The keys.
        keys: Vec<String>,
        /// Model of the water.
        fidelity: FidelityScene,
        /// How it is stepped, where that is why.
        method: Option<Method>,
    },
    /// Separate panels of the reservoir where the water is an added mass of the dam.
    #[error(
        "`{table}.interface_size` has no effect on the dam: with `coupling.scheme` = \"added-mass\" the mass of the water is \
         computed at the points of the dam, and those of the {table} only report the pressure; leave the key out, or choose an \
         iterated scheme, such as \"serial-implicit\""
    )]
    PanelsOfTheReport {
        /// The water's table.
        table: &'static str,
    },
    /// A value outside its usual range, which suggests a wrong unit.
    #[error(
        "`{key}` is {}{unit}; the usual range of {what} is {} to {}{unit}; check the unit",
        plain(*value), plain(*least), plain(*most)
    )]
    Unusual {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// Its unit, with a space before it.
        unit: String,
        /// Whose value it is.
        what: &'static str,
        /// Least usual value.
        least: f64,
        /// Largest usual value.
        most: f64,
    },
}

/// Share of a record's Fourier energy that lies below its highest frequency of interest. What is above (a hundredth of
/// the energy, a tenth of the amplitude) is mostly noise; 99 % of the shipped records lies below 9 to 11 Hz.
const ENERGY: f64 = 0.99;
/// Constant-strain triangles a shear wave: the velocity of a wave in linear elements of length h errs by about
/// (kh)²/24, here 1.6 %.
const ELEMENTS_OF_THE_DAM: f64 = 10.0;
/// Linear boundary elements a wave. Six err by 0.2 % (by 1.5 % close to a cut-off frequency).
pub const ELEMENTS_OF_THE_RESERVOIR: f64 = 6.0;
/// Linear boundary elements a depth: with eight the static base pressure errs by 0.1 %, with four by 0.7 %.
const ELEMENTS_OF_THE_DEPTH: f64 = 8.0;
/// Communication steps a period: the peak of a sine is missed by at most 1 − cos(π/20) = 1.2 %.
const STEPS_A_PERIOD: f64 = 20.0;
/// Part of a step by which samples and communication points may run apart: times in files are rounded.
const UNEVEN: f64 = 1e-4;
/// Slope of the crest up to which it drains.
const LEVEL: f64 = 0.05;
/// Velocity at the end over the peak. The shipped records, processed with care, end below 0.01 %.
const VELOCITY_AT_END: f64 = 0.1;
/// Displacement at the end over the peak. The shipped records end below 0.2 %; that of a drift is its peak, but ground
/// beside a fault may stay displaced in earnest.
const DISPLACEMENT_AT_END: f64 = 0.5;
/// Peak acceleration, g: hardly any record is stronger; in m/s² most are.
const LARGEST_PEAK: f64 = 2.0;
/// Rest that the residual sliding asks for, s.
pub const REST: f64 = 5.0;
const LOOSEST_TOLERANCE: f64 = 1e-3;

/// A key, and what is doubtful about its value.
type Doubt = (String, Warning);

/// What is doubtful about a scene that was read, each with its key.
pub fn doubts(scene: &Scene, motion: &GroundMotion) -> Vec<Doubt> {
    let mut doubts = unusual(scene);
    let at = |key: &str, warning: Warning| (key.to_owned(), warning);
    for (side, water) in scene.waters() {
        doubts.extend(without_effect(side, water));
        if scene.scheme() == SchemeKind::OneWay && water.interface_size.is_some() {
            let warning = Warning::PanelsOfTheReport { table: side.table() };
            doubts.push((side.key("interface_size"), warning));
        }
    }
    if let Tolerance::Relative(tolerance) = scene.coupling.tolerance
        && tolerance > LOOSEST_TOLERANCE
    {
        doubts.push(at("coupling.tolerance", Warning::LooseTolerance { tolerance }));
    }
    let dam = scene.dam.iter().map(|dam| ("dam", dam.source()));
    for (table, source) in dam.chain(scene.waters().map(|(side, water)| (side.table(), water.source()))) {
        if matches!(source, Source::Log(_)) {
            doubts.push((format!("{table}.fidelity"), Warning::OpenLoop { table }));
        }
    }
    let computed = |dam: &&DamScene| !dam.fidelity.is_foreign();
    let cracked = scene.dam.as_ref().filter(computed).filter(|dam| !dam.cracks.is_empty());
    if let Some(dam) = cracked {
        if dam.fidelity.is_rigid() {
            doubts.push(at("dam.fidelity", Warning::RigidBlocks));
        }
        if dam.damping.ratio == 0.0 {
            doubts.push(at("dam.damping.ratio", Warning::UndampedCrack));
        }
        doubts.extend(dry_cracks(scene, dam));
        doubts.extend(uplift_without_effect(dam));
        doubts.extend(dam.cracks.iter().filter_map(brittle_bond));
        if let (Some(begin), Some(end)) = (motion.rest_from(), scene.time.duration)
            && end - begin < REST - 1e-9
        {
            // The duration, if it is written, decides.
            let quiet = (end - begin - scene.time.quiet).abs() < 1e-9;
            let key = if quiet { "time.quiet" } else { "time.duration" };
            doubts.push(at(key, Warning::NoResidual { key, rest: end - begin }));
        }
    }
    doubts.extend(scene.dam.as_ref().and_then(sloping_crest));
    doubts.extend(scene.waters().filter_map(|(side, water)| coarse_face(scene, side, water)));
    if scene.ground_motion.record.is_some() {
        let shocks = scene.ground_motion.shocks();
        for (shock, motion) in shocks.iter().zip(motion.shocks()) {
            doubts.extend(of_record(motion.horizontal(), &shock.table));
            if let Some(vertical) = motion.vertical().filter(|_| shock.vertical.is_some()) {
                doubts.extend(of_record(vertical, &shock.vertical_table));
            }
        }
        doubts.extend(sequence(&shocks, cracked.is_some()));
        doubts.extend(resolution(scene, motion));
    }
    doubts
}

/// A crest that is not level: mostly a side without its last point.
fn sloping_crest(dam: &DamScene) -> Option<Doubt> {
    let [upstream, downstream] =
        [&dam.section.upstream, &dam.section.downstream].map(|side| side.last().copied());
    let ([x, upstream], [other, downstream]) = (upstream?, downstream?);
    let lower = if upstream < downstream { "upstream" } else { "downstream" };
    ((upstream - downstream).abs() > LEVEL * (x - other).abs())
        .then(|| (format!("dam.section.{lower}"), Warning::SlopingCrest { upstream, downstream, lower }))
}

/// Water pressure in a crack, uncracked and without drains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uplift {
    /// Depth of the crack's mean elevation below the reservoir's level, m.
    pub below: f64,
    /// Mean of the pressures at both ends × length, N/m.
    pub force: f64,
    /// Pressure at the downstream end, Pa.
    pub downstream: f64,
}

/// The uplift of a crack for a pressure that varies linearly between its ends; `None` above the reservoir's level.
pub fn uplift(scene: &Scene, crack: &CrackScene) -> Option<Uplift> {
    let section = &scene.dam.as_ref()?.section;
    let elevation = crack.mean_elevation();
    let water = |side| scene.water(side).filter(|water| !water.is_empty());
    let pressure = |side| {
        let (water, below) = (water(side)?, scene.depth_of(side) - elevation);
        (below > 0.0).then_some(water.density * scene.gravity * below)
    };
    let [upstream, downstream] = Side::BOTH.map(pressure);
    let (upstream, downstream) = (upstream?, downstream.unwrap_or(0.0));
    let length = x_at(&section.downstream, elevation)? - x_at(&section.upstream, elevation)?;
    let below = scene.depth() - elevation;
    Some(Uplift { below, force: 0.5 * (upstream + downstream) * length, downstream })
}

/// Whether the dam has uplift in a crack: it lies below water that the scene lets enter.
pub fn takes_water(scene: &Scene, crack: &CrackScene) -> bool {
    let rule = scene.dam.as_ref().map_or(UpliftRuleScene::None, |dam| crack.uplift_rule(dam.uplift));
    let reaches = uplift(scene, crack).is_some() || scene.loads.tailwater.is_some() || crack.uplift.is_some();
    reaches && rule != UpliftRuleScene::None
}

/// The lowest crack without uplift, if water would enter it.
fn dry_cracks(scene: &Scene, dam: &DamScene) -> Option<Doubt> {
    let by_elevation = |a: &&CrackScene, b: &&CrackScene| a.mean_elevation().total_cmp(&b.mean_elevation());
    let is_dry = |crack: &&CrackScene| crack.uplift_rule(dam.uplift) == UpliftRuleScene::None;
    let crack = dam.cracks.iter().filter(is_dry).min_by(by_elevation)?;
    let Uplift { below, force: uplift, downstream } = uplift(scene, crack)?;
    Some(("dam.cracks".to_owned(), Warning::NoUplift { crack: crack.phrase(), below, uplift, downstream }))
}

/// A cohesion that is lost at the first opening.
fn brittle_bond(crack: &CrackScene) -> Option<Doubt> {
    let is_brittle = crack.cohesion > 0.0 && crack.tensile_strength == 0.0;
    let warning = Warning::BrittleBond { crack: crack.phrase(), cohesion: 1e-3 * crack.cohesion };
    is_brittle.then(|| (format!("dam.cracks.{}.cohesion", crack.number), warning))
}

/// The cracks whose water is described, but does not act.
fn uplift_without_effect(dam: &DamScene) -> Vec<Doubt> {
    let of_crack = |crack: &CrackScene| {
        let UpliftScene { rule, drains, profile, factor } = crack.uplift.as_ref()?;
        let describes = drains.is_some() || profile.is_some() || factor.is_some();
        let (because, remedy) = if dam.fidelity.is_intact() {
            let acts = rule.is_some_and(|rule| rule != UpliftRuleScene::None);
            (describes || acts).then_some(("on an intact dam", "`dam.fidelity` to one with cracks"))?
        } else if describes && crack.uplift_rule(dam.uplift) == UpliftRuleScene::None {
            ("with the rule \"none\"", "its `rule` to \"unchanged\"")
        } else {
            return None;
        };
        let warning = Warning::UpliftWithoutEffect { crack: crack.phrase(), because, remedy };
        Some((format!("dam.cracks.{}.uplift", crack.number), warning))
    };
    dam.cracks.iter().filter_map(of_crack).collect()
}

/// Where a side of the section, from the base up, has the elevation `y`.
fn x_at(side: &[[f64; 2]], y: f64) -> Option<f64> {
    let [[x0, y0], [x1, y1]] =
        side.windows(2).map(|pair| [pair[0], pair[1]]).find(|[low, high]| (low[1]..=high[1]).contains(&y))?;
    Some(x0 + (x1 - x0) * (y - y0) / (y1 - y0))
}

/// The record of the component at the key `table`; those of a sequence are counted with the first.
fn of_component(table: &str) -> String {
    let index = table.strip_prefix("ground_motion.sequence.").and_then(|rest| rest.split('.').next());
    let number = index.and_then(|index| index.parse::<usize>().ok()).map(|index| index + 2);
    let record = if table.ends_with(".vertical") { "vertical record" } else { "record" };
    number.map_or_else(|| format!("the {record}"), |number| format!("the {record} of shock {number}"))
}

/// Doubts about the record of a component itself.
fn of_record(motion: &Component, table: &str) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    let key = format!("{table}.file");
    let [velocity, displacement] = motion.drift().map(|drift| drift.share());
    if velocity > VELOCITY_AT_END || displacement > DISPLACEMENT_AT_END {
        let (velocity, displacement) = (100.0 * velocity, 100.0 * displacement);
        doubts.push((key.clone(), Warning::Drift { table: table.to_owned(), velocity, displacement }));
    }
    let peak = motion.largest() / STANDARD_GRAVITY;
    if peak > LARGEST_PEAK {
        doubts.push((key, Warning::Peak { table: table.to_owned(), peak }));
    }
    doubts
}

/// Doubts about shocks next to each other; `is_cracked` is whether cracks can slide.
fn sequence(shocks: &[Shock<'_>], is_cracked: bool) -> Vec<Doubt> {
    let is_level = |shock: &&Shock<'_>| shock.vertical.is_none();
    let level = shocks.iter().filter(is_level).filter(|_| !shocks.iter().all(|shock| is_level(&shock)));
    let level = level.map(|Shock { table, vertical_table, .. }| {
        let [table, vertical_table] = [table, vertical_table].map(Clone::clone);
        (table.clone(), Warning::LevelShock { table, vertical_table })
    });
    let short = shocks.iter().skip(1).filter(|shock| is_cracked && shock.rest < REST);
    let short = short.map(|shock| {
        let key = format!("{}.rest", shock.table);
        (key.clone(), Warning::ShortRest { key, rest: shock.rest })
    });
    level.chain(short).collect()
}

/// Whether time and space are fine enough for the record, for both of its components.
fn resolution(scene: &Scene, motion: &GroundMotion) -> Vec<Doubt> {
    let mut doubts: Vec<Doubt> = Vec::new();
    let frequency = motion.components().map(|component| component.frequency_below_which(ENERGY));
    let frequency = frequency.fold(0.0, f64::max);
    let step = scene.time.communication_step;
    let interval = motion.components().map(Component::interval).fold(f64::INFINITY, f64::min);
    let (key, longest) = match scene.time.adaptive {
        Some(adaptive) => ("time.adaptive.longest", adaptive.longest),
        None => ("time.communication_step", step),
    };
    if longest * frequency * STEPS_A_PERIOD > 1.0 {
        let better = whole_fraction(interval, interval * frequency * STEPS_A_PERIOD);
        doubts.push((key.to_owned(), Warning::CoarseStep { key, step: longest, frequency, better }));
    }
    let uneven = |interval: &f64| {
        let fraction = interval / step;
        (fraction - fraction.round()).abs() > UNEVEN * fraction
    };
    if let Some(interval) = motion.components().map(Component::interval).find(uneven) {
        let better = whole_fraction(interval, interval / step);
        let warning = Warning::ClippedSamples { step, interval, better };
        doubts.push(("time.communication_step".to_owned(), warning));
    }
    if let Some(dam) = &scene.dam {
        let (size, wavelength) = (dam.element_size, shear_wave_velocity(dam) / frequency);
        if size * ELEMENTS_OF_THE_DAM > wavelength {
            let warning = Warning::CoarseDam { size, wavelength, frequency };
            doubts.push(("dam.element_size".to_owned(), warning));
        }
    }
    for (side, water) in scene.waters().filter(|(_, water)| water.fidelity.is_compressible()) {
        let (size, wavelength) = (scene.boundary_element_size(side), water.sound_speed / frequency);
        if size * ELEMENTS_OF_THE_RESERVOIR > wavelength {
            let table = side.table();
            let warning = Warning::CoarseReservoir { table, size, wavelength, frequency };
            doubts.push((side.key("element_size"), warning));
        }
    }
    doubts
}

/// Whether the water's elements are fine enough for the pressure that changes over the depth in any motion.
fn coarse_face(scene: &Scene, side: Side, water: &ReservoirScene) -> Option<Doubt> {
    let (size, depth, table) = (scene.boundary_element_size(side), scene.depth_of(side), side.table());
    let coarse = water.fidelity.is_solved() && size * ELEMENTS_OF_THE_DEPTH > depth * (1.0 + 1e-9);
    coarse.then(|| (side.key("element_size"), Warning::CoarseFace { table, size, depth }))
}

/// Velocity of shear waves, c_s = √(G/ρ) with G = E/(2(1 + ν)), m/s; the least of dam and zones.
pub fn shear_wave_velocity(dam: &DamScene) -> f64 {
    let velocity = |material: &MaterialScene| {
        (material.young_modulus / (2.0 * (1.0 + material.poisson_ratio)) / material.density).sqrt()
    };
    let of_zones = dam.zones.iter().map(|zone| velocity(&zone.material(&dam.material)));
    of_zones.fold(velocity(&dam.material), f64::min)
}

/// Values that smell of another unit.
fn unusual(scene: &Scene) -> Vec<Doubt> {
    let mut values = vec![("gravity".to_owned(), scene.gravity, "the Earth", 9.7, 9.9)];
    for (side, water) in scene.waters() {
        values.push((side.key("density"), water.density, "water", 950.0, 1200.0));
        values.push((side.key("sound_speed"), water.sound_speed, "water", 1300.0, 1600.0));
    }
    if let Some(DamScene { material, zones, cracks, .. }) = &scene.dam {
        values.push(("dam.material.young_modulus".to_owned(), material.young_modulus, "concrete", 5e9, 8e10));
        values.push(("dam.material.density".to_owned(), material.density, "concrete", 1800.0, 3200.0));
        let strength = material.tensile_strength;
        values
            .extend(strength.map(|f| ("dam.material.tensile_strength".to_owned(), f, "concrete", 2e5, 1e7)));
        for crack in cracks {
            let key = |name: &str| format!("dam.cracks.{}.{name}", crack.number);
            values.push((key("friction_coefficient"), crack.friction_coefficient, "a joint", 0.0, 2.0));
            for (name, value) in [("cohesion", crack.cohesion), ("tensile_strength", crack.tensile_strength)]
            {
                values.extend((value > 0.0).then(|| (key(name), value, "a joint", 1e3, 1e7)));
            }
        }
        for (index, zone) in zones.iter().enumerate() {
            let key = |name: &str| format!("dam.zones.{index}.{name}");
            values.extend(zone.young_modulus.map(|e| (key("young_modulus"), e, "concrete", 5e9, 8e10)));
            values.extend(zone.density.map(|rho| (key("density"), rho, "concrete", 1800.0, 3200.0)));
        }
    }
    let odd = |&(_, value, _, least, most): &(_, f64, _, f64, f64)| !(least..=most).contains(&value);
    let warn = |(key, value, what, least, most): (String, _, _, _, _)| {
        let unit = Shape::field(&key).map_or("", |field| &field.unit);
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        (key.clone(), Warning::Unusual { key, value, unit, what, least, most })
    };
    values.into_iter().filter(odd).map(warn).collect()
}

/// Keys that were given another value than their default, and that the chosen water does not look at.
fn without_effect(side: Side, water: &ReservoirScene) -> Option<Doubt> {
    let fidelity = water.fidelity;
    let (solved, compressible, filled) =
        (fidelity.is_solved(), fidelity.is_compressible(), !fidelity.is_empty());
    let without_boundary_elements = compressible && !water.method.has_boundary_elements();
    let table_of = |table: &str| fidelity.is_foreign() && fidelity.word() == table;
    let matters = [
        ("profile", fidelity.is_formula()),
        ("density", filled),
        ("sound_speed", compressible),
        ("wave_reflection_coefficient", compressible),
        ("bed", solved),
        ("surface_waves", solved),
        ("method", compressible),
        ("interface_size", filled),
        ("element_size", solved),
        ("element_order", solved && !without_boundary_elements),
        ("bed_element_size", solved),
        ("corner_element_size", solved),
        ("far_end_distance", solved),
        ("fmu", table_of("fmu")),
        ("command", table_of("command")),
        ("log", table_of("log")),
    ];
    let values = serde_json::to_value(water).unwrap_or_default();
    let given = |name: &str| {
        let value = values.get(name).filter(|value| !value.is_null());
        value.is_some() && value != Shape::field(&side.key(name)).and_then(|field| field.default.as_ref())
    };
    let without = matters.into_iter().filter(|(name, matters)| !matters && given(name));
    let keys: Vec<String> = without.map(|(name, _)| side.key(name)).collect();
    let (first, method) = (keys.first()?.clone(), without_boundary_elements.then_some(water.method));
    Some((first, Warning::WithoutEffect { table: side.table(), keys, fidelity, method }))
}

/// Keys in a row, and what they do.
fn listed(keys: &[String]) -> String {
    let quoted: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
    match quoted.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} and {last} have", first.join(", ")),
        _ => quoted.concat() + " has",
    }
}

/// When a run ends that has so much rest, s.
fn at_end(rest: f64) -> String {
    let side = if rest < 0.0 { "before" } else { "after" };
    format!("{:.2} s {side} the ground comes to rest", rest.abs())
}

/// A whole fraction of `interval`, at least `parts` of them: the largest that is a short number, if there is one not much smaller.
fn whole_fraction(interval: f64, parts: f64) -> f64 {
    let least = parts.ceil().max(1.0);
    let fractions = (0..).map(|more| least + f64::from(more)).take_while(|parts| *parts <= 2.0 * least);
    let mut short = fractions.filter_map(|parts| {
        let rounded: f64 = format!("{:.3e}", interval / parts).parse().ok()?;
        ((rounded * parts / interval - 1.0).abs() < 1e-9).then_some(rounded)
    });
    short.next().unwrap_or(interval / least)
}

/// `value` with two digits, rounded down.
pub fn down(value: f64) -> String {
    let digits = 1 - value.log10().floor() as i32;
    let unit = 10.0_f64.powi(-digits);
    format!("{:.*}", digits.max(0) as usize, (value / unit).floor() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_are_advised_are_short_numbers() {
        let found = [(0.01, 2.4), (0.02, 3.0), (0.005, 1.5), (0.01, 0.3), (1.0 / 3.0, 2.0)];
        let found = found.map(|(interval, parts)| whole_fraction(interval, parts));
        assert_eq!(found, [0.0025, 0.005, 0.0025, 0.01, 1.0 / 6.0]);
    }
}
