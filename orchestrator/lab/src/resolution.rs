//! `cofferdam-lab resolution`.

use cofferdam_assembly::{Assembly, AssemblyError};
use cofferdam_scene::Side;
mod figure;

use crate::study::{Arguments, StudyError, quoted, unfit};
use crate::terminal::print;
use cofferdam_analysis::closed_form::{Exact, Motion};
use cofferdam_analysis::context::threads;
use cofferdam_analysis::parallel;
use cofferdam_analysis::table::Table;
use cofferdam_reservoir::analytical::nodal_forces;
use cofferdam_reservoir::{Complex64, ElementOrder, ReservoirError, ReservoirParameters, boundary_system};
use cofferdam_unit::WetFace;
use std::f64::consts::TAU;
use std::num::NonZeroUsize;
use std::time::Instant;

pub const HELP: &str = "\
Simulates the water of the scene with a rigid dam that moves horizontally. The
wet face has 4, 8, 16, … 1000 equal elements, constant and linear, and as many
panels of the interface. The elements of the bed and of the far end have the
same size, and the far end is at a quarter of the depth. At wavenumbers
kh = ωh/c with at least six elements per wave, the nodal forces on the face are
compared with those of the closed form by their relative root-mean-square
difference. The face must be vertical and the bed level.

The time of a frequency is that of assembly and solution on one core.
Everything that does not depend on the frequency is computed beforehand.

Writes resolution.md, resolution.csv and resolution.svg. With --coarse, only up
to 32 elements and low frequencies.

Example:
  cofferdam-lab resolution scenes/koyna-intact --output studies/resolution

Exit status: 0 completed, 1 results could not be written, 2 the scene is
invalid or not suitable, 4 the water cannot be computed.";

/// Minimum number of elements per wavelength.
const PER_WAVE: f64 = 6.0;
/// Distance of the far end over the depth.
const FAR_END: f64 = 0.25;

/// The elements that are compared.
pub const SHAPES: [ElementOrder; 2] = [ElementOrder::Constant, ElementOrder::Linear];

/// One mesh at one frequency.
pub struct Point {
    pub elements: usize,
    pub order: ElementOrder,
    /// ωh/c.
    pub wavenumber: f64,
    pub error: f64,
    /// Observed order of convergence from the previous mesh, if there is one.
    observed: Option<f64>,
    seconds: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), StudyError> {
    let loaded = arguments.load()?;
    let parameters = Assembly::of(&loaded.scene).water_parameters(Side::Upstream)?;
    if !parameters.fidelity.has_memory() {
        return Err(unfit("the study needs compressible water"));
    }
    let exact = Exact::of(&parameters, Motion::Horizontal)
        .map_err(|why| unfit(format!("the study compares with a closed form, and {why}")))?;
    let (meshes, wavenumbers) = if arguments.coarse {
        (vec![4, 8, 16, 32], vec![0.8, 2.4, 4.0])
    } else {
        (vec![4, 8, 16, 32, 64, 128, 256, 512, 1000], vec![0.8, 2.4, 4.0, 20.0, 100.0, 1000.0])
    };
    // Work that is done only once does not count as time per frequency.
    measured(&parameters, Complex64::new(0.0, parameters.sound_speed / parameters.wet_face.depth()))
        .map_err(AssemblyError::from)?;
    let mut points: Vec<Point> = Vec::new();
    for elements in meshes {
        let asked: Vec<f64> =
            wavenumbers.iter().copied().filter(|kh| elements as f64 >= PER_WAVE * kh / TAU).collect();
        let face =
            WetFace::straight([0.0, parameters.wet_face.depth()], elements).map_err(AssemblyError::from)?;
        let s = |kh: f64| Complex64::new(0.0, kh * parameters.sound_speed / face.depth());
        let closed: Vec<Vec<Complex64>> =
            asked.iter().map(|kh| exact_forces(&exact, &face, s(*kh), threads(None))).collect();
        for order in SHAPES {
            let mesh = ReservoirParameters {
                element_size: face.depth() / elements as f64,
                bed_element_size: None,
                corner_element_size: None,
                element_order: order,
                far_end_distance: FAR_END * face.depth(),
                // No convolution is needed here.
                horizon: parameters.communication_step,
                wet_face: face.clone(),
                ..parameters.clone()
            };
            for (kh, closed) in asked.iter().zip(&closed) {
                let measured = measured(&mesh, s(*kh)).map_err(AssemblyError::from)?;
                let error = relative(&measured.forces, closed);
                let before = points.iter().rfind(|p| p.order == order && p.wavenumber == *kh);
                let observed =
                    before.map(|p| (p.error / error).ln() / (elements as f64 / p.elements as f64).ln());
                let Measured { seconds, .. } = measured;
                points.push(Point { elements, order, wavenumber: *kh, error, observed, seconds });
            }
        }
        print(format!("{elements} elements"));
    }
    let text = format!(
        "`cofferdam-lab resolution {}{}`: against {}; relative error of the nodal forces (observed order), time \
         per frequency\n\n{}",
        quoted(&arguments.scene),
        if arguments.coarse { " --coarse" } else { "" },
        exact.source(),
        shown(&points, &wavenumbers).markdown(),
    );
    print(&text);
    arguments.write("resolution.md", &text)?;
    arguments.write_table("resolution.csv", &listed(&points))?;
    arguments.write("resolution.svg", &figure::picture(&points)?)
}

/// Nodal forces per unit acceleration, and the time to compute them.
struct Measured {
    forces: Vec<Complex64>,
    seconds: f64,
}

fn measured(parameters: &ReservoirParameters, s: Complex64) -> Result<Measured, ReservoirError> {
    parameters.validate()?;
    let system = boundary_system(parameters)?;
    let began = Instant::now();
    let symbol = system.symbol(s)?;
    let seconds = began.elapsed().as_secs_f64();
    let points = parameters.wet_face.len();
    let pressure: Vec<Complex64> = symbol.columns(0, points).row_iter().map(|row| row.sum() / s).collect();
    let of = |part: fn(&Complex64) -> f64| {
        parameters.wet_face.nodal_forces(&pressure.iter().map(part).collect::<Vec<_>>())
    };
    let forces = of(|p| p.re).iter().zip(of(|p| p.im)).map(|(re, im)| Complex64::new(re[0], im[0])).collect();
    Ok(Measured { forces, seconds })
}

/// Nodal forces of the closed form (N/m per m/s²), on `threads`.
fn exact_forces(exact: &Exact, face: &WetFace, s: Complex64, threads: NonZeroUsize) -> Vec<Complex64> {
    nodal_forces(face, |elevations| {
        let parts: Vec<_> = elevations.chunks(elevations.len().div_ceil(threads.get())).collect();
        parallel::map(&parts, threads, |part| exact.at(s, part).0).concat()
    })
}

fn relative(values: &[Complex64], exact: &[Complex64]) -> f64 {
    let apart: f64 = values.iter().zip(exact).map(|(x, y)| (x - y).norm_sqr()).sum();
    (apart / exact.iter().map(|y| y.norm_sqr()).sum::<f64>()).sqrt()
}

/// One row per mesh, one column per wavenumber.
fn shown(points: &[Point], wavenumbers: &[f64]) -> Table {
    let headings = ["elements", "shape"].map(str::to_owned).into_iter();
    let headings = headings.chain(wavenumbers.iter().map(|kh| format!("kh = {kh}")));
    let mut table = Table::new(headings.chain(["time, s".to_owned()]));
    for order in SHAPES {
        for mesh in points.chunk_by(|a, b| a.elements == b.elements) {
            let of_order: Vec<&Point> = mesh.iter().filter(|point| point.order == order).collect();
            let cell = |kh: &f64| {
                let point = of_order.iter().find(|point| point.wavenumber == *kh);
                point.map_or_else(String::new, |Point { error, observed, .. }| {
                    let observed = observed.map_or_else(String::new, |order| format!(" ({order:.1})"));
                    format!("{error:.1e}{observed}")
                })
            };
            let count = of_order.len().max(1) as f64;
            let seconds = of_order.iter().map(|point| point.seconds).sum::<f64>() / count;
            let first = [mesh[0].elements.to_string(), name(order).to_owned()].into_iter();
            let cells = first.chain(wavenumbers.iter().map(cell));
            table.row(cells.chain([format!("{seconds:.2e}")]));
        }
    }
    table
}

/// One row per mesh and wavenumber.
fn listed(points: &[Point]) -> Table {
    let mut table =
        Table::new(["elements", "shape", "kh [1]", "error [1]", "observed order [1]", "time [s]"]);
    for Point { elements, order, wavenumber, error, observed, seconds } in points {
        table.row([
            elements.to_string(),
            name(*order).to_owned(),
            wavenumber.to_string(),
            error.to_string(),
            observed.map_or_else(String::new, |order| order.to_string()),
            seconds.to_string(),
        ]);
    }
    table
}

pub fn name(order: ElementOrder) -> &'static str {
    match order {
        ElementOrder::Constant => "constant",
        ElementOrder::Linear => "linear",
    }
}
