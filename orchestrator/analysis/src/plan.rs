//! What a run models and what it neglects, with the criteria.

use crate::accuracy::table::{self, Expected};
use crate::context::{Context, threads};
use crate::estimate;
use crate::variables::known;
use cofferdam_assembly::units::DAM;
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_report::PlanRow;
use cofferdam_report::text::wrapped;
use cofferdam_scene::{DampingModel, LoadedScene, SceneError, Source, Warning, shear_wave_velocity};
use miette::Diagnostic;
use std::f64::consts::{PI, TAU};

/// Reason why no plan can be made.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum PlanError {
    /// The scene.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A unit.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// The dam.
    #[error(transparent)]
    Dam(#[from] ParticipantError),
    /// The estimate of time and disk.
    #[error(transparent)]
    Estimate(#[from] estimate::EstimateError),
}

/// A row as text of at most 80 columns: subject and verdict, then the criterion.
pub fn text(PlanRow { what, verdict, criterion }: &PlanRow) -> String {
    format!("{what:<34} {verdict}\n{}", wrapped(&format!("        {criterion}"), "        "))
}

/// Shares of the record's Fourier energy between which its frequencies of interest lie.
const ENERGY: [f64; 2] = [0.01, 0.99];
/// ω_c over ω₁ from which compressibility changes the response little.
///
/// **Source**: A.K. Chopra, Earthquake behavior of reservoir-dam systems, Journal of the Engineering Mechanics Division 94 (1968).
const INCOMPRESSIBLE: f64 = 2.0;
/// ω²h/g above which gravity waves change the pressure by less than 5 %: they need the surface to move during a period.
///
/// **Source**: A.K. Chopra, Hydrodynamic pressures on dams during earthquakes, Journal of the Engineering Mechanics Division 93 (1967).
const NO_WAVES: f64 = 17.6;
/// Elements per shear wavelength, steps per period.
const ELEMENTS: f64 = 10.0;
const STEPS: f64 = 20.0;
/// Demand over strength of a crack below which it holds, and above which it slides, from the response spectrum alone.
const HOLDS: f64 = 0.5;
const SLIDES: f64 = 1.0;

fn row(what: impl Into<String>, verdict: impl Into<String>, criterion: impl Into<String>) -> PlanRow {
    PlanRow { what: what.into(), verdict: verdict.into(), criterion: criterion.into() }
}

/// The plan of a scene. Creates the dam and its lowest modes, and runs some steps for the estimate of time.
///
/// **Errors**: those of the units.
pub fn rows(loaded: &LoadedScene, context: &Context<'_>) -> Result<Vec<PlanRow>, PlanError> {
    let (scene, motion) = (&loaded.scene, &loaded.ground_motion);
    let [low, high] = ENERGY.map(|share| motion.frequency_below_which(share));
    let mut rows = Vec::new();
    let has_record = scene.ground_motion.record.is_some();
    let verdict = match motion.vertical() {
        Some(_) if has_record => "horizontal and vertical, on rigid ground",
        None if has_record => "horizontal, on rigid ground",
        _ => "ramp",
    };
    let left_out = match motion.vertical() {
        Some(vertical) => format!(
            "vertically at most {:.3} g; the deformation of the ground is not modelled",
            vertical.largest() / STANDARD_GRAVITY
        ),
        None => "vertical motion and the deformation of the ground are not modelled".to_owned(),
    };
    let shocks = match motion.begins().len() {
        1 => String::new(),
        count => format!("{count} shocks in sequence; "),
    };
    rows.push(row(
        "ground motion",
        verdict,
        format!(
            "{shocks}98 % of its energy lies from {low:.2} to {high:.1} Hz, at most {:.3} g; {left_out}",
            motion.peak().0.abs() / STANDARD_GRAVITY
        ),
    ));
    let full = Assembly::of(scene).natural_modes_in_water(4)?.map(|modes| modes.frequencies);
    let empty = match &full {
        Some(_) => None,
        None => Assembly::of(scene).natural_modes(4)?.map(|modes| modes.frequencies),
    };
    let modes = full.as_ref().or(empty.as_ref());
    let first = modes.and_then(|frequencies| frequencies.first().copied());
    for (side, water) in scene.waters() {
        let (table, depth) = (side.table(), scene.depth_of(side));
        if water.is_empty() {
            rows.push(row(table, "left out", "`fidelity` is \"none\": the reservoir is empty"));
            continue;
        }
        if water.source() != Source::BuiltIn {
            rows.push(row(
                table,
                "not known here",
                "the water is simulated by another program or replayed from a log",
            ));
            continue;
        }
        let cut_off = PI * water.sound_speed / (2.0 * depth);
        let compressible = water.fidelity.is_compressible();
        let of_dam = first.map_or_else(String::new, |first| {
            format!(
                "; cut-off over ω₁ of the full dam is {:.2}, and above {INCOMPRESSIBLE} compressibility would change the response \
                 little",
                cut_off / first
            )
        });
        let needed = TAU * high > cut_off || first.is_some_and(|first| cut_off < INCOMPRESSIBLE * first);
        let verdict = match (compressible, needed) {
            (true, true) => "modelled, needed",
            (true, false) => "modelled; added mass would suffice",
            (false, true) => "left out, although needed",
            (false, false) => "left out",
        };
        rows.push(row(
            format!("{table}: compressibility"),
            verdict,
            format!(
                "the record reaches ω = {:.1} rad/s, {:.2} of the cut-off πc/2h = {cut_off:.1} rad/s{of_dam}",
                TAU * high,
                TAU * high / cut_off
            ),
        ));
        let number = (TAU * low).powi(2) * depth / scene.gravity;
        rows.push(row(
            format!("{table}: gravity waves"),
            match (water.surface_waves, number < NO_WAVES) {
                (true, _) => "modelled",
                (false, false) => "left out",
                (false, true) => "left out, may be relevant",
            },
            format!("ω²h/g is {number:.0} at {low:.2} Hz, below which 1 % of the record's energy lies; gravity waves are relevant below {NO_WAVES}"),
        ));
        if compressible {
            let alpha = water.wave_reflection_coefficient;
            let crossing = 2.0 * depth / water.sound_speed;
            let decay = match alpha {
                a if a <= 0.0 => "a wave is absorbed completely".to_owned(),
                a if a >= 1.0 => {
                    "a vertical wave keeps its amplitude: resonance at the cut-off is undamped".to_owned()
                }
                a => format!(
                    "a vertical wave decays to 1 % in {:.1} s, {crossing:.3} s per reflection",
                    crossing * 0.01_f64.ln() / a.ln()
                ),
            };
            let absorbs = if alpha < 1.0 { "modelled" } else { "left out" };
            rows.push(row(
                format!("{table}: absorption at the bed"),
                absorbs,
                format!("α = {alpha}: {decay}"),
            ));
        }
    }
    let computed = scene.computed_dam().is_some();
    if let Some(dam) = scene.dam.as_ref().filter(|_| computed) {
        let spectral =
            first.map(|first| motion.response_spectrum(&[TAU / first], 0.05)[0] / STANDARD_GRAVITY);
        for equilibrium in Assembly::of(scene).limit_equilibria()? {
            let crack = &dam.cracks[equilibrium.crack];
            // k_y = V_max/W − V/W with W = N: of a crack that is level.
            let capacity = crack.friction_coefficient * (1.0 - 1.0 / equilibrium.sliding);
            let (verdict, of_demand) = match spectral {
                Some(demand) => {
                    let ratio = demand / capacity;
                    let verdict = match ratio {
                        r if r < HOLDS => "modelled; expected to hold",
                        r if r < SLIDES => "modelled; may slide",
                        _ => "modelled; expected to slide",
                    };
                    (verdict, format!("S_a(T₁, 5 %) = {demand:.2} g, {ratio:.2} of the capacity"))
                }
                None => ("modelled", "without modes the demand is unknown".to_owned()),
            };
            rows.push(row(
                format!("contact: {}", crack.phrase()),
                verdict,
                format!(
                    "capacity {capacity:.2} g without cohesion, {of_demand}; factors of safety at rest: sliding {:.2}, \
                     overturning {:.2}",
                    equilibrium.sliding, equilibrium.overturning
                ),
            ));
        }
        if dam.cracks.is_empty() || dam.fidelity.is_intact() {
            rows.push(row(
                "contact",
                "left out",
                "the dam has no cracks, or is computed without them; it is linear",
            ));
        }
        for warning in &loaded.warnings {
            if let Warning::NoUplift { crack, uplift, below, .. } = &warning.warning {
                let text = format!(
                    "{crack} is {below:.2} m below the reservoir level; uplift of {:.2} MN/m is left out by `uplift` = \"none\"",
                    1e-6 * uplift
                );
                rows.push(row("uplift", "left out, although relevant", text));
            }
        }
        if has_record {
            let wave = shear_wave_velocity(dam) / high;
            let elements = wave / dam.element_size;
            rows.push(row(
                "elements",
                if elements < ELEMENTS { "too coarse for the record" } else { "fine enough for the record" },
                format!(
                    "{elements:.1} of {} m per shear wavelength ({wave:.0} m) at {high:.1} Hz; {ELEMENTS} are recommended. Error of waves \
                     (kh)²/24 = {:.2} %; corners of the section and contacts converge more slowly",
                    dam.element_size,
                    100.0 * (TAU / elements).powi(2) / 24.0
                ),
            ));
        }
        if let Some(modes) = modes {
            let listed: Vec<String> = modes.iter().map(|frequency| format!("{frequency:.1}")).collect();
            let within = modes.iter().filter(|frequency| **frequency < TAU * high).count();
            let verdict = match dam.fidelity {
                level if level.has_elements() => "all, by time integration",
                _ if dam.modes.is_some() => "number given in the scene",
                _ => "number for an error of 2 % at 200 rad/s",
            };
            rows.push(row(
                "modes",
                verdict,
                format!(
                    "ω {} rad/s; {within} of these four within the record's {:.0} rad/s",
                    listed.join(", "),
                    TAU * high
                ),
            ));
        }
        if let Some(row) = damping(loaded, high)? {
            rows.push(row);
        }
    }
    if has_record {
        let steps = 1.0 / (scene.time.communication_step * high);
        rows.push(row(
            "communication step",
            if steps < STEPS { "too long for the record" } else { "short enough for the record" },
            format!(
                "{steps:.0} steps of {} s per period at {high:.1} Hz; {STEPS} are recommended",
                scene.time.communication_step
            ),
        ));
    }
    if computed {
        rows.extend(numerical_errors(loaded));
        let mut dam = Assembly::with(scene, threads(None)).unit(DAM)?;
        let inputs = Assembly::of(scene).inputs_at_rest(&mut *dam)?;
        let mut outputs = vec![0.0; dam.description().outputs.size()];
        dam.initialise(0.0, &inputs, &mut outputs)?;
        let estimate = estimate::of(loaded, &mut *dam, &inputs, threads(None), context)?;
        rows.push(row("time and disk", "within a factor of two", estimate.to_string()));
    }
    Ok(rows)
}

/// The numerical errors that the table of measured errors lets expect.
fn numerical_errors(loaded: &LoadedScene) -> Vec<PlanRow> {
    let peak = loaded.ground_motion.peak().0.abs() / STANDARD_GRAVITY;
    let of = |Expected { quantity, error, cases, size }: Expected| {
        let verdict = match error {
            Some([bias, spread]) => format!("bias {:+.0} %, spread {:.0} %", 100.0 * bias, 100.0 * spread),
            None => "not known".to_owned(),
        };
        let counted = if cases == 1 { "1 case".to_owned() } else { format!("{cases} cases") };
        let criterion = format!(
            "{counted} in table {} near this scene (elements of {size:.2} m, peak of about {peak:.2} g){}, against the reference \
             numerics. Sensitivity to the exact motion and the range of models are not included: `cofferdam range`. `cofferdam run \
             --accuracy` measures the error for this record",
            table::TABLE.version,
            if error.is_none() { ", too few" } else { "" },
        );
        row(format!("numerical error of {quantity}"), verdict, criterion)
    };
    table::expected(&loaded.scene, peak).into_iter().map(of).collect()
}

/// The share of critical damping at the record's highest frequency.
fn damping(loaded: &LoadedScene, high: f64) -> Result<Option<PlanRow>, PlanError> {
    let Some(dam) = &loaded.scene.dam else { return Ok(None) };
    let ratio = dam.damping.ratio;
    if ratio == 0.0 {
        return Ok(Some(row("damping", "left out", "`dam.damping.ratio` is 0")));
    }
    let mut unit = Assembly::with(&loaded.scene, threads(None)).unit(DAM)?;
    let [first, second] =
        ["damping_frequency_low", "damping_frequency_high"].map(|name| known(unit.read(name)));
    let (first, second) = (first?.first().copied().unwrap_or(f64::NAN), second?.first().copied());
    let omega = TAU * high;
    let at_high = match (dam.damping.model, second) {
        (DampingModel::Rayleigh, Some(second)) => ratio * (first * second / omega + omega) / (first + second),
        (DampingModel::Mass, _) => ratio * first / omega,
        (DampingModel::Stiffness, _) => ratio * omega / first,
        _ => ratio,
    };
    let criterion = format!(
        "{:.1} % of critical at {first:.1} rad/s, {:.1} % at the record's {omega:.0} rad/s; sliding depends more on damping than on \
         any refinement",
        100.0 * ratio,
        100.0 * at_high
    );
    Ok(Some(row("damping", dam.damping.model.word(), criterion)))
}
