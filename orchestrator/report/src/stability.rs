//! The stability of joints: of a scene, and of a run with what it did to them.

use crate::resultant::{self, Resultant};
use crate::text::{COLUMNS, heading, wrapped};
use cofferdam_assembly::observer::Histories;
use cofferdam_assembly::{
    Assembly, AssemblyError, Authority, JointStability, LoadCombination, Status, UpliftRule, Verdict, Zone,
};
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::{LoadedScene, Scene};
use serde::Serialize;
use std::collections::BTreeSet;
use std::ops::Range;

/// What a shock did to a joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shaken {
    /// In a run with a sequence, what the shock is called, and when it began and the next one began or the run ended, s.
    pub shock: Option<(String, [f64; 2])>,
    /// Least factor of the sum of shear strengths to the shear force; `None` without a shear force.
    pub least_factor: Option<f64>,
    /// Time at which it was least, s.
    pub time: f64,
    /// Time during which the whole joint slid, the factor being 1, s.
    pub sliding_time: f64,
    /// Largest length that was open at one time, during this shock or one before, m.
    pub opened: f64,
    /// Sliding from its begin to its end, m.
    pub slid: f64,
    /// Sliding at its end, m.
    pub residual: f64,
    /// The resultant in the joint; `None` if the run recorded none.
    pub resultant: Option<Resultant>,
    /// Newmark's block on the joint; `None` without equilibrium at rest, or if it slides without an earthquake.
    pub block: Option<BlockSlip>,
}

/// How Newmark's block slides on a joint under the motion of a shock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockSlip {
    /// Inertia downstream at which it slides, with the peak strength, as a share of g.
    pub yields: f64,
    /// Its slip during the shock, m, positive downstream.
    pub slip: f64,
}

/// Share of the shear strength from which a joint slides as a whole.
const SLIDES: f64 = 1.0 - 1e-6;

/// The joints of a scene, without a run.
///
/// **Errors**: those of the dam.
pub fn of_scene(
    loaded: &LoadedScene,
    rules: &[Option<UpliftRule>],
) -> Result<Vec<JointStability>, AssemblyError> {
    Assembly::of(&loaded.scene).stability(peak(loaded), &[], rules)
}

/// The joints of a run with these `histories`: their stability with the cracks that each shock left, and what happened to each crack in
/// each shock that began.
///
/// **Errors**: those of the dam.
pub fn of_run(
    loaded: &LoadedScene,
    histories: &Histories,
    rules: &[Option<UpliftRule>],
) -> Result<(Vec<JointStability>, Vec<Vec<Shaken>>), AssemblyError> {
    let before = of_scene(loaded, rules)?;
    let has_contacts = histories.column("dam.crack_open_share.0").is_some();
    if !has_contacts || loaded.scene.dam.as_ref().is_some_and(|dam| dam.fidelity.is_intact()) {
        // nothing could open in the run
        return Ok((before, Vec::new()));
    }
    let count = loaded.scene.dam.as_ref().map_or(0, |dam| dam.cracks.len());
    let length =
        |crack: usize| before.iter().find(|joint| joint.crack == crack).map_or(0.0, |joint| joint.length);
    let time = histories.column("time").unwrap_or(&[]);
    let end = time.last().copied().unwrap_or(0.0);
    let begins = loaded.ground_motion.begins();
    let labels = loaded.scene.ground_motion.shocks().into_iter().map(|shock| shock.label);
    let names: Vec<Option<String>> = match begins.len() {
        1 => vec![None],
        _ => labels.map(Some).collect(),
    };
    let mut blocks = Assembly::of(&loaded.scene).sliding_blocks()?;
    let mut shocks = Vec::new();
    for (number, name) in names.into_iter().enumerate() {
        let (Some(&begin), next) = (begins.get(number), begins.get(number + 1)) else { break };
        if number > 0 && begin >= end - ROUNDING {
            break;
        }
        // what was reached when a shock begins belongs to the one before
        let until = |limit: f64| time.partition_point(|time| *time <= limit + ROUNDING);
        let rows = if number > 0 { until(begin) } else { 0 }..next.map_or(time.len(), |next| until(*next));
        let shock = name.map(|name| (name, [begin, next.map_or(end, |next| next.min(end))]));
        let of = |crack| shaken(histories, crack, length(crack), rows.clone(), shock.clone());
        let mut of_shock: Vec<Shaken> = (0..count).map(of).collect();
        let until = shock.map_or(end, |(_, [_, until])| until);
        for (crack, block) in &mut blocks {
            let before = block.slip();
            block.advance(until, |time| loaded.ground_motion.at(time));
            if let (Some(of_crack), [Some(yields), _]) =
                (of_shock.get_mut(*crack), block.yield_accelerations())
            {
                of_crack.block =
                    Some(BlockSlip { yields: yields / STANDARD_GRAVITY, slip: block.slip() - before });
            }
        }
        shocks.push(of_shock);
    }
    let opened: Vec<Vec<f64>> =
        shocks.iter().map(|shock| shock.iter().map(|shaken| shaken.opened).collect()).collect();
    Ok((Assembly::of(&loaded.scene).stability(peak(loaded), &opened, rules)?, shocks))
}

/// Difference of times that is rounding, s.
const ROUNDING: f64 = 1e-9;

fn peak(loaded: &LoadedScene) -> f64 {
    loaded.ground_motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()))
}

/// What happened to a crack in these `rows` of the histories.
fn shaken(
    histories: &Histories,
    crack: usize,
    length: f64,
    rows: Range<usize>,
    shock: Option<(String, [f64; 2])>,
) -> Shaken {
    let column = |name: &str| histories.column(&format!("dam.crack_{name}.{crack}")).unwrap_or(&[]);
    let time = histories.column("time").unwrap_or(&[]);
    let (utilisation, sliding) = (column("shear_utilisation"), column("sliding"));
    let in_rows = utilisation.iter().zip(time).take(rows.end).skip(rows.start);
    let largest = in_rows.max_by(|(a, _), (b, _)| a.total_cmp(b));
    let steps = time.windows(2).zip(utilisation.iter().skip(1));
    let steps = steps.take(rows.end.saturating_sub(1)).skip(rows.start.saturating_sub(1));
    let open = column("open_share").iter().take(rows.end);
    let at_end = |rows: usize| rows.checked_sub(1).and_then(|row| sliding.get(row)).copied().unwrap_or(0.0);
    Shaken {
        resultant: resultant::of(histories, crack, length, rows.clone()),
        shock,
        least_factor: largest.filter(|(share, _)| **share > 0.0).map(|(share, _)| 1.0 / share),
        time: largest.map_or(0.0, |(_, time)| *time),
        sliding_time: steps.filter(|(_, share)| **share >= SLIDES).map(|(pair, _)| pair[1] - pair[0]).sum(),
        opened: length * open.fold(0.0, |most: f64, share| most.max(*share)),
        slid: at_end(rows.end) - at_end(rows.start),
        residual: at_end(rows.end),
        block: None,
    }
}

/// The stability of one joint: its combinations side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StabilityTable {
    /// The joint and its strength.
    pub title: String,
    /// The combinations.
    pub columns: Vec<String>,
    /// Labels with units, and a value for each combination.
    pub rows: Vec<(String, Vec<String>)>,
    /// What happened in the run, in each of its shocks.
    pub run: Vec<String>,
}

/// A row of the table: label, unit, and the value of a joint.
type Row = (&'static str, &'static str, fn(&JointStability) -> String);

const ROWS: [Row; 18] = [
    ("inertia downstream", "g", |joint| number(joint.seismic[0], 3)),
    ("inertia downwards", "g", |joint| number(joint.seismic[1], 3)),
    ("uplift rule", "", |joint| short_rule(joint).to_owned()),
    ("normal force without uplift", "MN/m", |joint| number(1e-6 * joint.load.normal, 3)),
    ("uplift", "MN/m", |joint| number(1e-6 * joint.state.uplift, 3)),
    ("effective normal force", "MN/m", |joint| number(1e-6 * joint.state.normal, 3)),
    ("shear force", "MN/m", |joint| number(1e-6 * joint.load.shear, 3)),
    ("resultant from the toe", "%", |joint| optional(joint.state.share().map(|share| 100.0 * share), 1)),
    ("open length", "m", |joint| number(joint.state.open[0] + joint.state.open[1], 2)),
    ("unbonded length", "m", |joint| number(joint.state.cracks[0] + joint.state.cracks[1], 2)),
    ("stress at heel or tip", "MPa", |joint| optional(joint.state.stresses.map(|[heel, _]| 1e-6 * heel), 3)),
    ("stress at toe", "MPa", |joint| optional(joint.state.stresses.map(|[_, toe]| 1e-6 * toe), 3)),
    ("factor, overturning", "", |joint| optional(joint.overturning, 2)),
    ("factor, sliding, peak", "", |joint| optional(joint.sliding[0], 2)),
    ("factor, sliding, residual", "", |joint| optional(joint.sliding[1], 2)),
    ("required, sliding", "", |joint| optional(joint.required, 2)),
    ("required, resultant", "", |joint| {
        joint.requirement.map_or("-", |found| short_zone(found.resultant)).to_owned()
    }),
    ("verdict", "", |joint| short_verdict(joint.verdict()).to_owned()),
];

/// The tables of all joints; `shaken` says what each shock of a run did to each crack.
pub fn tables(scene: &Scene, joints: &[JointStability], shaken: &[Vec<Shaken>]) -> Vec<StabilityTable> {
    let of_joint = |joints: &[JointStability]| StabilityTable {
        title: title(scene, &joints[0]),
        columns: joints.iter().map(short_name).collect(),
        rows: ROWS
            .iter()
            .map(|(label, unit, value)| {
                let label = if unit.is_empty() { (*label).to_owned() } else { format!("{label}, {unit}") };
                (label, joints.iter().map(value).collect())
            })
            .collect(),
        run: shaken.iter().filter_map(|shock| shock.get(joints[0].crack)).map(sentence_of_run).collect(),
    };
    joints.chunk_by(|a, b| a.crack == b.crack).map(of_joint).collect()
}

/// The tables as text of at most 80 columns, with the rules and documents behind their numbers.
pub fn text(scene: &Scene, joints: &[JointStability], shaken: &[Vec<Shaken>]) -> String {
    let mut text = String::new();
    for StabilityTable { title, columns, rows, run } in tables(scene, joints, shaken) {
        text += &heading(&wrapped(&title, "  "));
        for first in (0..columns.len()).step_by(COMBINATIONS) {
            let some = first..columns.len().min(first + COMBINATIONS);
            let mut line = |label: &str, values: &[&str]| {
                let values: String = values.iter().map(|value| format!("{value:>VALUE$}")).collect();
                text += &format!("{label:<LABEL$}{values}\n");
            };
            let heads: Vec<&str> = columns[some.clone()].iter().map(String::as_str).collect();
            line("", &heads);
            for (label, values) in &rows {
                let values: Vec<&str> = values[some.clone()].iter().map(String::as_str).collect();
                line(label, &values);
            }
        }
        for run in run {
            text += &(wrapped(&run, "  ") + "\n");
        }
    }
    text += "\n";
    for note in notes(scene, joints) {
        text += &(wrapped(&note, "  ") + "\n");
    }
    text
}

/// Combinations side by side in 80 columns.
const COMBINATIONS: usize = 4;
/// Columns of a label with its unit, and of a value.
const LABEL: usize = COLUMNS - COMBINATIONS * VALUE;
const VALUE: usize = 11;

fn title(scene: &Scene, joint: &JointStability) -> String {
    let crack = scene.dam.as_ref().and_then(|dam| dam.cracks.get(joint.crack));
    let joint_at = crack.map_or_else(String::new, |crack| crack.phrase().replacen("the crack", "Joint", 1));
    let peak = crack.map_or(0.0, |crack| crack.friction_coefficient);
    let residual = crack.and_then(|crack| crack.residual_friction_coefficient).unwrap_or(peak);
    let cohesion = crack.map_or(0.0, |crack| crack.cohesion);
    format!(
        "{joint_at}: {:.2} m long; friction {peak}, cohesion {} kPa, residual friction {residual}",
        joint.length,
        cohesion / 1e3
    )
}

/// Slip that is compared with that of Newmark's block, m.
const SLIP: f64 = 1e-3;

impl BlockSlip {
    /// The block compared with the dam, which `slid` this far (m) in the same time.
    fn sentence(&self, slid: f64) -> String {
        let Self { yields, slip } = *self;
        let block = format!(
            "Newmark's rigid block on this joint (yield acceleration {yields:.2} g, Westergaard's added mass, uplift at rest) slides {:.0} mm \
             under the same motion",
            1e3 * slip
        );
        let [dam, rigid] = [slid.abs(), slip.abs()];
        if dam > rigid + SLIP {
            let times =
                if rigid > SLIP { format!(", {:.1} times as far", dam / rigid) } else { String::new() };
            format!(
                "{block}, the deformable dam {:.0} mm{times}: the block is unconservative here, because it moves with the ground and \
                 leaves out that the dam amplifies the acceleration above the joint and rocks.",
                1e3 * slid
            )
        } else if rigid > dam + SLIP {
            format!(
                "{block}, the deformable dam {:.0} mm: the block is conservative here; with another record or another height it need not be.",
                1e3 * slid
            )
        } else {
            format!("{block}, as the deformable dam does within {:.0} mm.", 1e3 * SLIP)
        }
    }
}

fn sentence_of_run(shaken: &Shaken) -> String {
    let Shaken { shock, least_factor, time, sliding_time, opened, slid, residual, resultant, block } = shaken;
    let resultant = resultant.map_or_else(String::new, |resultant| format!(" {}", resultant.sentence()));
    let block = block.map_or_else(String::new, |block| format!(" {}", block.sentence(*slid)));
    let factor = least_factor.map_or_else(
        || "no shear force".to_owned(),
        |factor| format!("least factor against sliding {factor:.2} at {time:.3} s"),
    );
    let whole = format!("{factor}; at factor 1, sliding as a whole, for {sliding_time:.3} s");
    match shock {
        None => format!(
            "In the run: {whole}; residual sliding {:.1} mm; open over at most {opened:.2} m at one time, which counts as a crack from \
             the upstream end after the earthquake.{resultant}{block}",
            1e3 * residual
        ),
        Some((name, [begin, end])) => format!(
            "In {name}, from {begin:.2} to {end:.2} s: {whole}; sliding {:.1} mm more, {:.1} mm in total; so far open over at most \
             {opened:.2} m at one time, which counts as a crack from the upstream end after it.{resultant}{block}",
            1e3 * slid,
            1e3 * residual
        ),
    }
}

/// What the numbers rest on.
pub fn notes(scene: &Scene, joints: &[JointStability]) -> Vec<String> {
    let mut notes = vec![
        "Gravity method: rigid bodies above the joints, linear effective stress without tension beyond the strength of the bond, \
         pressure on the whole area. Factor against sliding: (friction × effective normal force + cohesion × bonded length in \
         compression) / shear force. A joint without equilibrium fails."
            .to_owned(),
    ];
    if joints.iter().any(|joint| joint.combination == LoadCombination::Seismic) {
        notes.push(
            "Earthquake: constant inertia, by default two thirds of the record's peak, a sustained acceleration chosen by this \
             program; water as Westergaard's added mass (1933)."
                .to_owned(),
        );
    }
    notes.push(
        "Uplift \"static\": USACE EM 1110-2-2200, 1995, section 3-3: linear between the water levels and the drains, full pressure in \
         what is open."
            .to_owned(),
    );
    let seismic = joints.iter().filter(|joint| joint.combination == LoadCombination::Seismic);
    let rules: BTreeSet<_> = seismic.filter_map(|joint| joint.rule).map(|rule| rule.word()).collect();
    for rule in UpliftRule::ALL.into_iter().filter(|rule| rules.contains(rule.word())) {
        notes.push(format!("Uplift \"{}\": {} ({}).", rule.word(), rule.label(), rule.source()));
    }
    if joints.iter().any(|joint| joint.rule.is_none()) {
        notes.push("Uplift \"none\": no water in the joint.".to_owned());
    }
    let kinds = |which: &dyn Fn(&JointStability) -> bool| {
        let found: BTreeSet<_> =
            joints.iter().filter(|joint| which(joint)).map(|joint| joint.combination.word()).collect();
        found.into_iter().collect::<Vec<_>>().join(", ")
    };
    let own = kinds(&|joint| joint.is_own);
    if !own.is_empty() {
        notes.push(format!("Required factors of the scene ([stability.required]): {own}."));
    }
    let status =
        |joint: &JointStability| joint.requirement.filter(|_| !joint.is_own).map(|found| found.status);
    let authority = scene.stability.authority;
    if joints.iter().any(|joint| status(joint).is_some()) {
        let which = if own.is_empty() { "Required factors" } else { "Other required factors" };
        notes.push(format!("{which}: {}.", authority.document()));
    }
    let (rule, source) = authority.uplift_rule();
    if !rules.is_empty() && (rules.len() > 1 || !rules.contains(rule.word())) {
        let high = match authority {
            Authority::Cda => " in areas of low seismicity, \"zero-where-open\" in areas of high seismicity",
            _ => "",
        };
        notes.push(format!(
            "Uplift during an earthquake by the {}: \"{}\"{high} ({}).",
            authority.label(),
            rule.word(),
            source.sentence(),
        ));
    }
    let open = kinds(&|joint| status(joint).is_some_and(|status| !status.is_checked()));
    if !open.is_empty() {
        notes.push(format!("To be confirmed in the document before use: the required factors for {open}."));
    }
    let mut sources: Vec<&str> = Vec::new();
    for joint in joints {
        if let Some(Status::Checked(source)) = status(joint)
            && !sources.contains(&source)
        {
            sources.push(source);
            let compared = kinds(&|joint| status(joint) == Some(Status::Checked(source)));
            notes.push(format!("Compared with a citation of the document ({source}): {compared}."));
        }
    }
    let zones = kinds(&|joint| {
        let zone = joint.requirement.filter(|found| found.resultant != Zone::NotPrescribed);
        zone.is_some_and(|found| !found.resultant_status.is_checked())
    });
    if !zones.is_empty() {
        notes.push(format!("To be confirmed too: the required place of the resultant for {zones}."));
    }
    notes
}

/// The name of a combination as the head of a column.
fn short_name(joint: &JointStability) -> String {
    let kind = match joint.combination {
        LoadCombination::Usual => "usual",
        LoadCombination::Unusual => "unusual",
        LoadCombination::Extreme => "extreme",
        LoadCombination::Seismic => "seismic",
        LoadCombination::PostEarthquake => "after",
    };
    if let Some(shock) = joint.shock {
        return format!("{kind} {}", shock + 1);
    }
    let given = (joint.name != joint.combination.label()).then_some(&joint.name);
    given.filter(|name| name.chars().count() < VALUE).map_or(kind, String::as_str).to_owned()
}

fn short_rule(joint: &JointStability) -> &'static str {
    use UpliftRule::{FullWhereOpen, Unchanged, ZeroWhereOpen};
    match (joint.rule, joint.combination) {
        (None, _) => "none",
        (Some(_), kind) if kind != LoadCombination::Seismic => "static",
        (Some(Unchanged), _) => "unchanged",
        (Some(ZeroWhereOpen), _) => "zero-open",
        (Some(FullWhereOpen), _) => "full-open",
    }
}

fn short_zone(zone: Zone) -> &'static str {
    match zone {
        Zone::MiddleThird => "mid. third",
        Zone::MiddleHalf => "mid. half",
        Zone::InsideBase => "inside",
        Zone::NotPrescribed => "-",
    }
}

fn short_verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Meets => "meets",
        Verdict::Fails => "FAILS",
        Verdict::NotRequired => "-",
    }
}

fn number(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| number(value, decimals))
}

/// The table as CSV, one row for each joint and combination; SI units in the header.
pub fn csv(scene: &Scene, joints: &[JointStability]) -> String {
    let mut text = String::from(
        "joint,elevation_m,length_m,combination,name,inertia_downstream_g,inertia_downwards_g,uplift_rule,drains,\
         normal_N_per_m,uplift_N_per_m,effective_normal_N_per_m,shear_N_per_m,moment_about_toe_N,resultant_share,\
         open_upstream_m,open_downstream_m,unbonded_m,stress_heel_or_tip_Pa,stress_toe_Pa,overturning_factor,\
         sliding_factor_peak,sliding_factor_residual,required_factor,verdict,authority,document,status\n",
    );
    let value = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value}"));
    for joint in joints {
        let crack = scene.dam.as_ref().and_then(|dam| dam.cracks.get(joint.crack));
        let state = &joint.state;
        let authority = scene.stability.authority;
        let status = joint.requirement.filter(|_| !joint.is_own).map_or("", |found| found.status.label());
        let cells = [
            quoted(&crack.map_or_else(String::new, |crack| crack.label())),
            value(crack.map(|crack| crack.mean_elevation())),
            joint.length.to_string(),
            joint.combination.word().to_owned(),
            quoted(&joint.name),
            joint.seismic[0].to_string(),
            joint.seismic[1].to_string(),
            joint.rule.map_or("none", |rule| rule.word()).to_owned(),
            joint.drained.to_string(),
            joint.load.normal.to_string(),
            state.uplift.to_string(),
            state.normal.to_string(),
            joint.load.shear.to_string(),
            joint.load.moment.to_string(),
            value(state.share()),
            state.open[0].to_string(),
            state.open[1].to_string(),
            (state.cracks[0] + state.cracks[1]).to_string(),
            value(state.stresses.map(|[heel, _]| heel)),
            value(state.stresses.map(|[_, toe]| toe)),
            value(joint.overturning),
            value(joint.sliding[0]),
            value(joint.sliding[1]),
            value(joint.required),
            joint.verdict().word().to_owned(),
            authority.word().to_owned(),
            quoted(if joint.is_own { "the scene" } else { authority.document() }),
            status.to_owned(),
        ];
        text += &(cells.join(",") + "\n");
    }
    text
}

/// A cell that may hold commas.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests;
