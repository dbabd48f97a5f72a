//! `cofferdam-lab windows`: the errors of the paper's method for the water.

use cofferdam_assembly::{Assembly, AssemblyError, FarEndCondition, ShortWindows};
mod coupled;
mod far_end;
mod figure;

use crate::study::{Arguments, CREST, SLIDING, StudyError, quoted, relative, run_scene};
use crate::terminal::print;
use cofferdam_analysis::context::threads;
use cofferdam_analysis::table::Table;
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{LoadedScene, OnFailure, Scene, Side};
use coupled::{Coupled, End};
use nalgebra::DMatrix;

pub const HELP: &str = "\
The paper computes compressible water in short windows, each with its own
forward and inverse Fourier transform, and without a condition at the far end.
This study measures the errors of this method; it is not a way to run a scene.
It has three parts:

  (a) A rigid dam under the ground motion of the scene, with windows of 0.1 s
      and of 64 to 1024 communication steps: errors of base pressure and force
      against the transform of the whole record.
  (b) The deformable dam, with the same windows: dam and water are iterated in
      every window, with Aitken's relaxation, until the pressure residual is
      below the tolerance of the scene. Errors of crest displacement and
      sliding against a step-by-step run, dam steps per communication step, and
      where a window diverges. Omitted for a rigid dam, [prescribed].
  (c) The far end at h/2 to 4h, left out of the boundary integrals as in the
      paper, as a wall, or at p = 0: errors on the face under uniform motion at
      four frequencies above the first cut-off, and of the base pressure under
      the record, against a far end that transmits waves.

Writes windows.md, windows.csv, windows.svg and far-end.csv. With --coarse, two
windows and one distance.

Example:
  cofferdam-lab windows scenes/koyna-coarse --output studies/windows

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 3 a run failed, 4 a unit cannot be created.";

/// The paper's window, s.
const OF_THE_PAPER: f64 = 0.1;

/// One length of a window.
pub struct Row {
    /// s.
    pub length: f64,
    /// Relative L2 error of the base pressure on a rigid dam.
    pub base: f64,
    /// The same of the crest displacement, of a coupled run that came to its end.
    pub crest: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let scene = fit(&loaded)?;
    let (motion, step) = (&loaded.ground_motion, scene.time.communication_step);
    let steps = scene.steps() as usize;
    let mut lengths = vec![(OF_THE_PAPER / step).round().max(2.0) as usize];
    lengths.extend(if arguments.coarse { vec![128] } else { vec![64, 128, 256, 512, 1024] });
    lengths.retain(|length| *length <= steps);
    let rigid = Rigid::new(&scene, motion)?;
    let reference = match scene.dam {
        Some(_) => Some(run_scene(&scene, motion, threads(None))?.completed("step by step")?),
        None => None,
    };
    let mut table = Table::new([
        "steps per window",
        "s",
        "base pressure, rigid dam",
        "force, rigid dam",
        "dam steps per communication step",
        "maximum",
        "crest",
        "largest sliding, mm",
        "ends",
    ]);
    let nothing = || "–".to_owned();
    let mut rows = Vec::new();
    for length in lengths {
        let water = Assembly::with(&scene, threads(None)).short_windows(length)?;
        let [base, force] = rigid.errors(&rigid.in_windows(&water)?);
        let mut cells = vec![length.to_string(), format!("{:.3}", length as f64 * step)];
        cells.extend([base, force].map(percent));
        let mut crest = None;
        if let Some(reference) = &reference {
            let Coupled { histories: [moved, slid], iterations, end } = coupled::run(&scene, motion, &water)?;
            let mean = iterations.iter().sum::<usize>() as f64 / iterations.len().max(1) as f64;
            cells.extend([format!("{mean:.1}"), iterations.iter().max().unwrap_or(&0).to_string()]);
            crest = matches!(end, End::Reached).then(|| relative(&moved, reference.column(CREST)));
            cells.push(crest.map_or_else(nothing, percent));
            let slides = crest.is_some() && !slid.is_empty();
            cells.push(if slides { millimetres(&slid) } else { nothing() });
            cells.push(end.to_string());
        } else {
            cells.extend(std::iter::repeat_with(nothing).take(5));
        }
        print(cells.join(", "));
        table.row(cells);
        rows.push(Row { length: length as f64 * step, base, crest });
    }
    let whole = Assembly::with(&scene, threads(None)).short_windows(steps)?;
    let [base, force] = rigid.errors(&rigid.in_windows(&whole)?);
    let mut cells =
        vec![steps.to_string(), format!("{:.3}", steps as f64 * step), percent(base), percent(force)];
    cells.extend(std::iter::repeat_with(nothing).take(5));
    table.row(cells);
    let mut text = format!(
        "`cofferdam-lab windows {}{}`: relative L2 errors\n\n{}\n",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        table.markdown(),
    );
    if let Some(reference) = &reference {
        let slid = reference.column(SLIDING);
        let sliding =
            if slid.is_empty() { String::new() } else { format!(", {} mm of sliding", millimetres(slid)) };
        text += &format!(
            "Step by step: {:.2} dam steps per communication step{sliding}.\n",
            reference.iterations(1)
        );
    }
    let far_end = far_end::table(&scene, motion, arguments.coarse)?;
    text += &format!("\nThe far end:\n\n{}", far_end.markdown());
    print(&text);
    arguments.write("windows.md", &text)?;
    arguments.write_table("windows.csv", &table)?;
    arguments.write_table("far-end.csv", &far_end)?;
    arguments.write("windows.svg", &figure::picture(&rows)?)
}

/// The scene for the comparison: compressible water at the dam's own points, a run that stops at a failure.
fn fit(loaded: &LoadedScene) -> Result<Scene, StudyError> {
    let mut scene = loaded.scene.clone();
    if loaded.scene.tailwater.is_some() {
        let what = "the study couples the dam only with the reservoir of the paper; leave [tailwater] out";
        return Err(StudyError::Unfit { what: what.to_owned() });
    }
    if !scene.reservoir.fidelity.is_compressible() || scene.reservoir.surface_waves {
        return Err(StudyError::Unfit {
            what: "the study needs compressible water without gravity waves".to_owned(),
        });
    }
    if !scene.scheme().is_implicit() || scene.coupling.window != 1 {
        return Err(StudyError::Unfit {
            what: "the study compares with an implicit scheme, step by step".to_owned(),
        });
    }
    scene.reservoir.interface_size = None;
    scene.coupling.on_failure = OnFailure::Stop;
    Ok(scene)
}

/// The dam held rigid under the scene's ground motion.
struct Rigid {
    /// Mean accelerations over the steps, points and ground × steps.
    means: DMatrix<f64>,
    /// Force along x (N/m) of 1 Pa at a point.
    forces: Vec<f64>,
    /// Base pressure and force at the steps' ends, from the whole record at once.
    exact: [Vec<f64>; 2],
}

impl Rigid {
    fn new(scene: &Scene, motion: &GroundMotion) -> Result<Self, StudyError> {
        let record = record(scene, motion, scene.time.communication_step)?;
        let pressure =
            Assembly::with(scene, threads(None)).pressure_of_record(FarEndCondition::Outgoing, &record)?;
        let means = DMatrix::from_fn(record.nrows(), record.ncols() - 1, |i, n| {
            0.5 * (record[(i, n)] + record[(i, n + 1)])
        });
        let face = Assembly::of(scene).dam_face(Side::Upstream)?;
        let unit = |point: usize| {
            let mut pressure = vec![0.0; face.len()];
            pressure[point] = 1.0;
            face.nodal_forces(&pressure).iter().map(|force| force[0]).sum()
        };
        let forces: Vec<f64> = (0..face.len()).map(unit).collect();
        let mut rigid = Self { means, forces, exact: Default::default() };
        rigid.exact = rigid.histories(&pressure.columns(1, pressure.ncols() - 1).into_owned());
        Ok(rigid)
    }

    /// Base pressure and force.
    fn histories(&self, pressure: &DMatrix<f64>) -> [Vec<f64>; 2] {
        let force = |p: nalgebra::DVectorView<'_, f64>| p.iter().zip(&self.forces).map(|(p, f)| p * f).sum();
        [pressure.row(0).iter().copied().collect(), pressure.column_iter().map(force).collect()]
    }

    /// Pressures at the ends of all steps, window after window; the last one is filled with zero acceleration.
    fn in_windows(&self, water: &ShortWindows) -> Result<DMatrix<f64>, StudyError> {
        let (rows, steps) = self.means.shape();
        let mut all = DMatrix::zeros(self.forces.len(), steps);
        for first in (0..steps).step_by(water.steps()) {
            let count = water.steps().min(steps - first);
            let mut window = DMatrix::zeros(rows, water.steps());
            window.columns_mut(0, count).copy_from(&self.means.columns(first, count));
            let pressure = water.pressure(&window).map_err(AssemblyError::from)?;
            all.columns_mut(first, count).copy_from(&pressure.columns(0, count));
        }
        Ok(all)
    }

    fn errors(&self, pressure: &DMatrix<f64>) -> [f64; 2] {
        let [base, force] = self.histories(pressure);
        [relative(&base, &self.exact[0]), relative(&force, &self.exact[1])]
    }
}

/// Accelerations of a rigid dam and the ground, points and ground × instants `step` (s) apart.
fn record(scene: &Scene, motion: &GroundMotion, step: f64) -> Result<DMatrix<f64>, StudyError> {
    let normals = Assembly::of(scene).dam_face(Side::Upstream)?.normals();
    let steps = (scene.time.communication_step * scene.steps() as f64 / step).round() as usize;
    let at: Vec<[f64; 2]> = (0..=steps).map(|n| motion.at(n as f64 * step)).collect();
    Ok(DMatrix::from_fn(normals.len() + 2, steps + 1, |row, n| match normals.get(row) {
        Some(normal) => normal[0] * at[n][0] + normal[1] * at[n][1],
        None => at[n][row - normals.len()],
    }))
}

fn percent(share: f64) -> String {
    if share < 1e-3 { format!("{:.0e} %", 100.0 * share) } else { format!("{:.1} %", 100.0 * share) }
}

/// Largest absolute value of a history in m.
fn millimetres(history: &[f64]) -> String {
    format!("{:.1}", 1000.0 * history.iter().fold(0.0, |most: f64, v| most.max(v.abs())))
}
