//! `cofferdam-lab stability`.

mod figure;

use crate::study::{Arguments, StudyError, quoted, run_scene, unfit};
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::parallel;
use cofferdam_analysis::table::Table;
use cofferdam_coupling::acceleration::AccelerationKind;
use cofferdam_coupling::convergence::IterationFailure;
use cofferdam_coupling::scheme::{CouplingError, SchemeKind};
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{FidelityScene, OnFailure, Scene};
use std::num::NonZeroUsize;

pub const HELP: &str = "\
Simulates the dam of the scene without cracks under a ground acceleration that
is random in every communication step, with water whose density is a multiple
of the density of the concrete. The scheme is serial implicit (Gauss-Seidel)
for every water. The added-mass scheme needs no iterations and is not shown.

Writes stability.md (a summary, and a map per water and acceleration for the
finest mesh), stability.csv (all runs) and stability.svg. Each cell has the mean number of dam steps per communication
step needed for the tolerance of the scene, without the first step, or the
reason for failure: D divergence, S stagnation, L more than 100 iterations, R a
unit cannot be created, such as a dam with too many time steps.

Example:
  cofferdam-lab stability scenes/koyna-intact --output studies/stability

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// One run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    pub water: FidelityScene,
    pub mesh: f64,
    pub acceleration: AccelerationKind,
    pub density_ratio: f64,
    pub communication_step: f64,
}

/// Its result.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Mean and largest number of iterations.
    Converges(f64, f64),
    Diverges,
    Stagnates,
    Limit,
    Refused(String),
}

impl Verdict {
    /// A cell of the table.
    pub fn cell(&self) -> String {
        match self {
            Self::Converges(mean, _) => format!("{mean:.1}"),
            Self::Diverges => "D".to_owned(),
            Self::Stagnates => "S".to_owned(),
            Self::Limit => "L".to_owned(),
            Self::Refused(_) => "R".to_owned(),
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Converges(..) => "converges",
            Self::Diverges => "diverges",
            Self::Stagnates => "stagnates",
            Self::Limit => "iteration limit",
            Self::Refused(_) => "refused",
        }
    }
}

const ACCELERATIONS: [AccelerationKind; 4] = [
    AccelerationKind::Constant,
    AccelerationKind::Aitken,
    AccelerationKind::IqnIls,
    AccelerationKind::InterfaceJacobian,
];

/// The varied parameters.
pub struct Grid {
    pub waters: Vec<FidelityScene>,
    pub meshes: Vec<f64>,
    pub density_ratios: Vec<f64>,
    pub communication_steps: Vec<f64>,
    /// Communication steps of a run.
    steps: u32,
}

impl Grid {
    fn of(coarse: bool) -> Self {
        let waters = vec![FidelityScene::Compressible, FidelityScene::Incompressible];
        if coarse {
            let (meshes, steps) = (vec![20.0], 6);
            let (density_ratios, communication_steps) = (vec![0.01, 0.38, 10.0], vec![1e-5, 1e-3, 0.1]);
            Self { waters, meshes, density_ratios, communication_steps, steps }
        } else {
            let (meshes, steps) = (vec![20.0, 10.0, 5.0], 10);
            let density_ratios = vec![0.01, 0.1, 0.38, 1.0, 3.0, 10.0];
            let communication_steps = vec![1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0];
            Self { waters, meshes, density_ratios, communication_steps, steps }
        }
    }

    fn cases(&self) -> Vec<Case> {
        let mut cases = Vec::new();
        for &water in &self.waters {
            for &mesh in &self.meshes {
                for acceleration in ACCELERATIONS {
                    for &density_ratio in &self.density_ratios {
                        for &communication_step in &self.communication_steps {
                            cases.push(Case { water, mesh, acceleration, density_ratio, communication_step });
                        }
                    }
                }
            }
        }
        cases
    }
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let grid = Grid::of(arguments.coarse);
    let cases = grid.cases();
    print(format!("{} runs of {} communication steps", cases.len(), grid.steps));
    let judged = judge_all(&loaded.scene, &cases, grid.steps)?;
    let tolerance = loaded.scene.coupling.tolerance;
    let mut text = format!(
        "`cofferdam-lab stability {}{}`, ε = {tolerance}\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" }
    );
    let mut list =
        Table::new(["water", "mesh", "acceleration", "density ratio", "H", "verdict", "mean", "most"]);
    for (case, verdict) in &judged {
        let (mean, most) = match verdict {
            Verdict::Converges(mean, most) => (format!("{mean:.3}"), most.to_string()),
            _ => (String::new(), String::new()),
        };
        list.row([
            water(case.water).to_owned(),
            case.mesh.to_string(),
            name(case.acceleration).to_owned(),
            case.density_ratio.to_string(),
            case.communication_step.to_string(),
            verdict.name().to_owned(),
            mean,
            most,
        ]);
    }
    text += &format!("\n{}", summary(&grid, &judged).markdown());
    let finest = grid.meshes.iter().copied().fold(f64::INFINITY, f64::min);
    for panel in judged.chunks(grid.density_ratios.len() * grid.communication_steps.len()) {
        let (Case { water: of, mesh, acceleration, .. }, _) = panel[0];
        if mesh > finest {
            continue;
        }
        text += &format!("\n**{} water, {mesh} m mesh, {}**\n\n", water(of), name(acceleration));
        let steps = grid.communication_steps.iter().map(|h| format!("H = {h} s"));
        let mut table = Table::new(std::iter::once("ρ_w/ρ_s".to_owned()).chain(steps));
        for row in panel.chunks(grid.communication_steps.len()) {
            let ratio = row[0].0.density_ratio.to_string();
            table.row(std::iter::once(ratio).chain(row.iter().map(|(_, verdict)| verdict.cell())));
        }
        text += &table.markdown();
    }
    print(&text);
    arguments.write("stability.md", &text)?;
    arguments.write_table("stability.csv", &list)?;
    arguments.write("stability.svg", &figure::picture(&grid, &judged)?)
}

/// How often each acceleration converges, and its largest mean number of dam steps, over all meshes.
fn summary(grid: &Grid, judged: &[(Case, Verdict)]) -> Table {
    let headings = grid.waters.iter().map(|of| format!("{}: converged, largest mean", water(*of)));
    let mut table = Table::new(std::iter::once("acceleration".to_owned()).chain(headings));
    for acceleration in ACCELERATIONS {
        let cell = |of: &FidelityScene| {
            let own =
                judged.iter().filter(|(case, _)| (case.acceleration, case.water) == (acceleration, *of));
            let means = own.clone().filter_map(|(_, verdict)| match verdict {
                Verdict::Converges(mean, _) => Some(*mean),
                _ => None,
            });
            let largest = means.clone().fold(0.0, f64::max);
            format!("{} of {}, {largest:.1}", means.count(), own.count())
        };
        table.row(std::iter::once(format!("`{}`", name(acceleration))).chain(grid.waters.iter().map(cell)));
    }
    table
}

/// Runs all cases, as many at once as there are cores. A thread pool is not used, because the threads of the units would
/// start cases inside cases.
fn judge_all(scene: &Scene, cases: &[Case], steps: u32) -> Result<Vec<(Case, Verdict)>, StudyError> {
    let verdicts = parallel::try_map(cases, threads(None), |case| judge(scene, case, steps))?;
    Ok(cases.iter().copied().zip(verdicts).collect())
}

/// Takes a few steps of a case.
fn judge(scene: &Scene, case: &Case, steps: u32) -> Result<Verdict, StudyError> {
    let Case { water, mesh, acceleration, density_ratio, communication_step } = *case;
    let mut scene = scene.clone();
    let Some(dam) = &mut scene.dam else {
        return Err(unfit("the study needs a dam that is computed"));
    };
    (dam.element_size, dam.mesh) = (mesh, None);
    dam.cracks.clear();
    scene.reservoir.density = density_ratio * dam.material.density;
    scene.reservoir.fidelity = water;
    scene.reservoir.element_size = Some(mesh.min(scene.depth() / 16.0));
    scene.time.communication_step = communication_step;
    scene.time.duration = Some(f64::from(steps) * communication_step);
    scene.coupling.scheme = Some(SchemeKind::SerialImplicit);
    scene.coupling.acceleration = acceleration;
    scene.coupling.iteration_limit = 100;
    (scene.coupling.on_failure, scene.coupling.window, scene.time.adaptive) = (OnFailure::Stop, 1, None);
    // Phases that grow with the square excite all frequencies.
    let samples = (0..=steps).map(|k| (1.7 * f64::from(k * k) + 0.4).sin()).collect();
    let motion = GroundMotion::of_samples("random steps", communication_step, samples);
    let outcome = match run_scene(&scene, &motion, NonZeroUsize::MIN) {
        Ok(outcome) => outcome,
        Err(StudyError::Unit(error)) => return Ok(Verdict::Refused(error.to_string())),
        Err(error) => return Err(error),
    };
    Ok(match outcome.failure {
        None => {
            // The first row is initialisation; in the first step Jacobian and rounding floor are measured.
            let counts = outcome.column("iterations").get(2..).unwrap_or(&[]);
            Verdict::Converges(outcome.iterations(2), counts.iter().copied().fold(0.0, f64::max))
        }
        Some(CouplingError::NotConverged { .. }) => Verdict::Limit,
        Some(CouplingError::Futile {
            why: IterationFailure::Stagnating { .. } | IterationFailure::RoundingFloor { .. },
            ..
        }) => Verdict::Stagnates,
        Some(CouplingError::Futile { .. } | CouplingError::Diverged { .. }) => Verdict::Diverges,
        // The guesses are too large for a unit.
        Some(CouplingError::GuessFailed { .. }) => Verdict::Diverges,
        Some(error) => {
            return Err(StudyError::Run { what: format!("{case:?}"), cause: Box::new(error.into()) });
        }
    })
}

pub fn water(water: FidelityScene) -> &'static str {
    match water {
        _ if water.is_compressible() => "compressible",
        _ if water.is_formula() => "Westergaard's",
        _ if water.is_solved() => "incompressible",
        _ if water.is_empty() => "no",
        _ => "another program's",
    }
}

pub fn name(acceleration: AccelerationKind) -> &'static str {
    match acceleration {
        AccelerationKind::Constant => "constant",
        AccelerationKind::Aitken => "aitken",
        AccelerationKind::IqnIls => "iqn-ils",
        AccelerationKind::InterfaceJacobian => "interface-jacobian",
    }
}
