//! `cofferdam-lab fidelity`.

mod figure;

use crate::context::making;
use crate::study::{Arguments, CREST, Outcome, SLIDING, StudyError, quoted, relative, run_units, unfit};
use crate::terminal::print;
use cofferdam_analysis::closed_form::Exact;
use cofferdam_analysis::closed_form::Motion;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::table::Table;
use cofferdam_assembly::units::{DAM, RESERVOIR};
use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_coupling::participant::{InProcess, Messages, Participant, ParticipantError};
use cofferdam_coupling::scheme::{CouplingError, Graph};
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{FidelityScene, Method, Profile, Scene, Side};
use cofferdam_unit::CoSimulation;
use cofferdam_unit::variables::reservoir as variables;
use std::time::Instant;

pub const HELP: &str = "\
Runs the scene with every model of the water and, for compressible water, with
every time integration method. In addition, a rigid dam moves each water under
the same record. All runs are executed one after the other in one process, with
the default scheme of the water.

The reference is compressible water with three-stage Radau IIA at half the
communication step. Crest displacement and base pressure are compared with it
by their relative root-mean-square difference over time. With a vertical face
and a level bed there is a closed form for a rigid dam; its base pressure is
compared with that of compressible water over the bed of the scene.

The times of setup and of a step are wall times; the time of a step is the mean
over a run of the rigid dam. The size of a saved state is that of a file with
the state at the end of the run.

Writes fidelity.md, fidelity.csv and fidelity.svg. With --coarse, the variants
with gravity waves, with a rigid bed and with a distant Sommerfeld far end are
omitted.

Example:
  cofferdam-lab fidelity scenes/koyna-coarse --output studies/fidelity

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// Distance of the Sommerfeld end over the depth in the row with a distant one, whose error is small below the first
/// cut-off.
const DISTANT: f64 = 4.0;

/// A model of the water, its cost and its results.
pub struct Row {
    pub name: String,
    /// Whether this is one of the models, from none to compressible water; other rows are methods and options of the last model.
    pub level: bool,
    /// Its cost, or the reason why it cannot be computed.
    pub cost: Result<Cost, String>,
    /// Result of the coupled run; `None` if it could not be computed.
    outcome: Option<Outcome>,
    /// Relative error of the rigid dam's base pressure.
    rigid: Option<f64>,
}

/// Seconds and bytes.
#[derive(Clone, Copy, Default)]
pub struct Cost {
    set_up: f64,
    step: f64,
    /// Length of a saved state in a file.
    written: usize,
    /// Setup and all steps in the coupled run.
    pub reservoir: f64,
}

const BASE: &str = "reservoir.base_pressure";

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let (scene, motion) = (&loaded.scene, &loaded.ground_motion);
    if scene.dam.is_none() {
        return Err(unfit("the study needs a dam that is computed"));
    }
    if !scene.reservoir.fidelity.has_memory() || scene.time.adaptive.is_some() {
        return Err(unfit("the study needs compressible water and constant communication steps"));
    }
    let mut best = scene.clone();
    (best.reservoir.method, best.coupling.scheme) = (Method::Radau3, None);
    best.time.communication_step /= 2.0;
    let best = measured("the reference", false, &best, motion, None)?;
    let Some(reference) = &best.outcome else {
        return Err(unfit(format!(
            "the reference water cannot be computed: {}",
            best.cost.err().unwrap_or_default()
        )));
    };
    let exact = closed_form(scene, motion)?;
    let mut rows = Vec::new();
    for (name, level, other) in waters(scene, arguments.coarse) {
        let same =
            |water: &Scene| (water.reservoir.wave_reflection_coefficient, water.reservoir.surface_waves);
        let own = if same(&other) == same(scene) { exact.clone() } else { closed_form(&other, motion)? };
        let row = measured(&name, level, &other, motion, own.as_deref())?;
        print(format!(
            "{name}: {}",
            row.cost.as_ref().map_or_else(Clone::clone, |cost| format!("{:.1} s", cost.set_up))
        ));
        rows.push(row);
    }
    let table = table(&rows, reference);
    let refused: String = rows
        .iter()
        .filter_map(|row| Some(format!("- {}: {}\n", row.name, row.cost.as_ref().err()?)))
        .collect();
    let rigid = Exact::of(&Assembly::of(scene).water_parameters(Side::Upstream)?, Motion::Horizontal);
    let text = format!(
        "`cofferdam-lab fidelity {}{}`, H = {} s, {} steps; reference: three-stage Radau IIA at H/2, crest {:.2} mm, \
         residual sliding {:.2} mm\n\n{}\n{}{}",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        scene.time.communication_step,
        scene.steps(),
        1e3 * reference.peak(CREST),
        1e3 * reference.last(SLIDING),
        table.markdown(),
        rigid.err().map_or_else(String::new, |why| format!("A rigid dam has no closed form: {why}.\n")),
        if refused.is_empty() { refused } else { format!("\nRefused:\n{refused}") },
    );
    print(&text);
    arguments.write("fidelity.md", &text)?;
    arguments.write_table("fidelity.csv", &table)?;
    let points: Vec<figure::Priced> = rows
        .iter()
        .filter_map(|row| {
            let (cost, outcome) = (row.cost.as_ref().ok()?.reservoir, row.outcome.as_ref()?);
            Some(figure::Priced { name: row.name.clone(), cost, error: apart(outcome, reference, CREST)? })
        })
        .collect();
    arguments.write("fidelity.svg", &figure::picture(&points)?)
}

/// The scene with each water, its name, and whether it is one of the models.
fn waters(scene: &Scene, coarse: bool) -> Vec<(String, bool, Scene)> {
    let with = |name: &str, level: bool, change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        // The default scheme of the water.
        scene.coupling.scheme = None;
        change(&mut scene);
        (name.to_owned(), level, scene)
    };
    let level = |fidelity, profile| {
        move |scene: &mut Scene| (scene.reservoir.fidelity, scene.reservoir.profile) = (fidelity, profile)
    };
    let method = |method| move |scene: &mut Scene| scene.reservoir.method = method;
    let (default, parabola) = (scene.reservoir.method, Profile::Parabola);
    let mut waters = vec![
        with("none", true, &level(FidelityScene::Empty, parabola)),
        with("Westergaard, parabola", true, &level(FidelityScene::Westergaard, parabola)),
        with("Westergaard, exact", true, &level(FidelityScene::Westergaard, Profile::Exact)),
        with("incompressible", true, &level(FidelityScene::Incompressible, parabola)),
        with("finite elements", false, &method(Method::FiniteElements)),
        with("recursion", false, &method(Method::Recursive)),
        with("BDF2", false, &method(Method::Bdf2)),
        with("trapezoidal rule", false, &method(Method::Trapezoid)),
        with("Radau, 2 stages", false, &method(Method::Radau2)),
        with("Radau, 3 stages", false, &method(Method::Radau3)),
    ];
    if !coarse {
        let distant = with("finite elements, end at 4 h", false, &|scene| {
            method(Method::FiniteElements)(scene);
            scene.reservoir.far_end_distance = Some(DISTANT * scene.depth());
        });
        waters.insert(5, distant);
        waters.push(with("rigid bed, scene's method", false, &|scene| {
            (scene.reservoir.method, scene.reservoir.wave_reflection_coefficient) = (default, 1.0);
        }));
        waters.push(with("waves, scene's method", false, &|scene| {
            (scene.reservoir.method, scene.reservoir.surface_waves) = (default, true);
        }));
    }
    waters
}

/// Makes the water, moves it by a rigid dam, and runs the scene with it; `exact` is the base pressure of the rigid
/// dam by the closed form.
///
/// **Errors**: the dam cannot be made, or a run fails. A water that cannot be made gives a row.
fn measured(
    name: &str,
    level: bool,
    scene: &Scene,
    motion: &GroundMotion,
    exact: Option<&[f64]>,
) -> Result<Row, StudyError> {
    let refused =
        |cost: String| Row { name: name.to_owned(), level, cost: Err(cost), outcome: None, rigid: None };
    let (mut cost, mut rigid) = (Cost::default(), None);
    let reservoir: Box<dyn Participant> = if scene.reservoir.is_empty() {
        Assembly::with(scene, making(threads(None))).unit(RESERVOIR)?
    } else {
        let began = Instant::now();
        let mut unit = match Assembly::with(scene, making(threads(None))).reservoir() {
            Ok(unit) => unit,
            Err(error) => return Ok(refused(error.to_string())),
        };
        cost.set_up = began.elapsed().as_secs_f64();
        let start = unit.save_state();
        let failed = |error| {
            let cause =
                ParticipantError::Unit { participant: "reservoir".to_owned(), cause: Box::new(error) };
            let what = format!("{name}, rigid dam");
            StudyError::Run { what, cause: Box::new(CouplingError::from(cause).into()) }
        };
        let normals: Vec<f64> = unit.parameters().wet_face.normals().iter().map(|n| n[0]).collect();
        let began = Instant::now();
        let pressures = rigid_dam(&mut unit, &normals, scene, motion).map_err(failed)?;
        cost.step = began.elapsed().as_secs_f64() / pressures.len() as f64;
        let state = unit.save_state();
        cost.written = unit.serialise_state(&state).map_err(failed)?.len();
        rigid = exact.map(|exact| relative(&pressures, exact));
        unit.restore_state(&start).map_err(failed)?;
        Box::new(InProcess::new(unit, name, Messages::default()))
    };
    let mut units = vec![Assembly::with(scene, making(threads(None))).unit(DAM)?, reservoir];
    for id in Assembly::of(scene).units().into_iter().skip(units.len()) {
        units.push(Assembly::with(scene, making(threads(None))).unit(id)?);
    }
    let graph = Graph::new(units, Assembly::of(scene).interfaces()).map_err(AssemblyError::from)?;
    let outcome = run_units(scene, motion, graph)?.completed(name)?;
    cost.reservoir = cost.set_up + outcome.ending.wall.of("reservoir").as_secs_f64();
    Ok(Row { name: name.to_owned(), level, cost: Ok(cost), outcome: Some(outcome), rigid })
}

/// Pressures (Pa) at the base at the ends of all steps, with a rigid dam that moves with the ground; `along` is the x
/// component of the face's normals.
fn rigid_dam<U: CoSimulation>(
    unit: &mut U,
    along: &[f64],
    scene: &Scene,
    motion: &GroundMotion,
) -> Result<Vec<f64>, U::Error> {
    let step = scene.time.communication_step;
    unit.initialise(0.0)?;
    (0..scene.steps())
        .map(|n| {
            let [from, to] = [n, n + 1].map(|n| motion.at(n as f64 * step));
            let moved: Vec<f64> = along.iter().map(|along| 0.5 * (from[0] + to[0]) * along).collect();
            unit.set(variables::INTERFACE_ACCELERATION.value_reference, &moved)?;
            unit.set(variables::GROUND_ACCELERATION.value_reference, &to)?;
            unit.step(n as f64 * step, step)?;
            let mut pressure = [0.0];
            unit.get(variables::BASE_PRESSURE.value_reference, &mut pressure)?;
            Ok(pressure[0])
        })
        .collect()
}

/// The base pressure of compressible water on a rigid dam, if there is a closed form.
pub(super) fn closed_form(scene: &Scene, motion: &GroundMotion) -> Result<Option<Vec<f64>>, StudyError> {
    if motion.vertical().is_some() {
        return Ok(None);
    }
    let mut compressible = scene.clone();
    compressible.reservoir.fidelity = FidelityScene::Compressible;
    let exact = Exact::of(&Assembly::of(&compressible).water_parameters(Side::Upstream)?, Motion::Horizontal);
    let step = scene.time.communication_step;
    let samples: Vec<f64> = (0..=scene.steps()).map(|n| motion.at(n as f64 * step)[0]).collect();
    Ok(exact.ok().and_then(|exact| Some(exact.base_pressures(&samples, step, threads(None))?.split_off(1))))
}

fn table(rows: &[Row], reference: &Outcome) -> Table {
    let mut table = Table::new([
        "water",
        "setup, s",
        "saved state, kB",
        "step, µs",
        "run, s",
        "dam steps per communication step",
        "crest, error against reference",
        "crest, error against level above",
        "crest peak, mm",
        "residual sliding, mm",
        "base pressure, error against reference",
        "rigid dam, error against closed form",
    ]);
    let shown = |error: Option<f64>| error.map_or_else(|| "–".to_owned(), |error| format!("{error:.1e}"));
    for (index, row) in rows.iter().enumerate() {
        let Ok(cost) = &row.cost else {
            table.row(
                [&row.name, "refused"].into_iter().map(str::to_owned).chain((0..10).map(|_| "–".to_owned())),
            );
            continue;
        };
        let Some(outcome) = &row.outcome else { continue };
        let above = rows
            .get(index + 1)
            .filter(|next| next.level)
            .map_or(Some(reference), |next| next.outcome.as_ref());
        let above = above.filter(|_| row.level).and_then(|above| apart(outcome, above, CREST));
        table.row([
            row.name.clone(),
            format!("{:.3}", cost.set_up),
            format!("{:.1}", cost.written as f64 / 1e3),
            format!("{:.1}", 1e6 * cost.step),
            format!("{:.1}", outcome.ending.wall.total.as_secs_f64()),
            format!("{:.2}", outcome.iterations(1)),
            shown(apart(outcome, reference, CREST)),
            shown(above),
            format!("{:.2}", 1e3 * outcome.peak(CREST)),
            format!("{:.2}", 1e3 * outcome.last(SLIDING)),
            shown(apart(outcome, reference, BASE)),
            shown(row.rigid),
        ]);
    }
    table
}

/// Relative difference of a column in the mean square over time; the rows of `other` may be denser.
fn apart(outcome: &Outcome, other: &Outcome, column: &str) -> Option<f64> {
    let (values, reference) = (outcome.column(column), other.column(column));
    let denser = (reference.len().max(1) - 1) / (values.len().max(2) - 1);
    let reference: Vec<f64> = reference.iter().copied().step_by(denser.max(1)).collect();
    (!values.is_empty() && values.len() == reference.len()).then(|| relative(values, &reference))
}
