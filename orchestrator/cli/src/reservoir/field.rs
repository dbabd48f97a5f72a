//! `cofferdam reservoir field`.

use super::grid::Grid;
use super::{Common, Failure, unfit};
use crate::terminal::print;
use cofferdam_analysis::closed_form::Motion;
use cofferdam_assembly::vtk::{self, Field};
use cofferdam_reservoir::{Complex64, field_response};

/// Arguments of `cofferdam reservoir field`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,

    /// Frequency, rad/s
    #[arg(long, visible_alias = "frequency", value_name = "RAD/S")]
    omega: f64,

    /// Motion of the rigid dam and the ground
    #[arg(short, long, value_enum, default_value_t = super::Motion::Horizontal)]
    motion: super::Motion,

    /// Growth rate σ of the motion e^{(σ + iω)t}, 1/s; resonances are finite if it is above 0
    #[arg(long, value_name = "1/S", default_value_t = 0.0)]
    sigma: f64,

    /// Cell size, m (default: 1/40 of the depth, and at most 1/20 of the acoustic wavelength)
    #[arg(long, value_name = "M")]
    size: Option<f64>,
}

pub const HELP: &str = "\
A rigid dam moves with the ground as e^{iωt}, with an acceleration of 1 m/s²
downstream or up. field.vtu contains the complex amplitude of the pressure
between the far end and the wet face as point data, in Pa: pressure_real,
pressure_imaginary and pressure_modulus. The grid of quadrilaterals follows the
bed and the face at a distance of a thousandth of the depth. ParaView, PyVista
and meshio read the file.

Examples:
  cofferdam reservoir field scenes/koyna-intact --omega 20 --output field
      Below the first cut-off frequency: no wave travels upstream.
  cofferdam reservoir field scenes/koyna-intact --omega 40 --motion vertical \\
    --set 'reservoir.bed=[[-80, 20]]' --output field
      A bed that rises upstream, in vertical motion.

Exit status: 0 completed, 1 results could not be written, 2 the scene or an
option is invalid, 4 the water cannot be computed.";

/// Cells per depth and per sound wave.
const A_DEPTH: f64 = 40.0;
const A_WAVE: f64 = 20.0;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { common, motion, omega, sigma, .. } = arguments;
    let motion = Motion::from(*motion);
    let water = common.load()?;
    let parameters = &water.parameters;
    if !(*omega > 0.0 && omega.is_finite() && *sigma >= 0.0 && sigma.is_finite()) {
        return Err(unfit(format!(
            "--omega {omega} rad/s and --sigma {sigma} 1/s are no valid frequency; the first must be above 0, the second 0 or more"
        )));
    }
    if !parameters.fidelity.is_solved() {
        return Err(unfit(
            "an added mass by a formula has no field; choose `reservoir.fidelity` = \"compressible\" or \"incompressible\"",
        ));
    }
    water.warn_of_coarse_elements(*omega);
    let wave = std::f64::consts::TAU * parameters.sound_speed / omega / A_WAVE;
    let short = if parameters.fidelity.has_memory() { wave } else { f64::INFINITY };
    let size = arguments.size.unwrap_or(short.min(parameters.wet_face.depth() / A_DEPTH));
    if !(size > 0.0 && size.is_finite()) {
        return Err(unfit(format!("--size is {size} m; it must be greater than 0")));
    }
    let grid = Grid::of(parameters, size)?;
    let s = Complex64::new(*sigma, *omega);
    let response = field_response(parameters, s, &grid.points, common.threads())?;
    let pressure = motion.of_rigid_dam(&response, &parameters.wet_face.normals());
    // Per unit acceleration, not velocity.
    let pressure: Vec<Complex64> = pressure.into_iter().map(|p| p / s).collect();
    let peak = pressure.iter().fold(0.0f64, |most, p| most.max(p.norm()));
    print(&water.title);
    print(format!("{} points, pressure at most {peak:.4e} Pa per m/s²", grid.points.len()));
    let part = |part: &str, of: fn(&Complex64) -> f64| {
        Field::scalar(&format!("pressure_{part}"), pressure.iter().map(of).collect())
    };
    let field = vtk::Grid {
        cells: grid.cells.iter().map(|cell| cell.to_vec()).collect(),
        point_data: vec![part("modulus", |z| z.norm()), part("real", |z| z.re), part("imaginary", |z| z.im)],
        points: grid.points,
        cell_data: Vec::new(),
        field_data: Vec::new(),
    };
    common.write(&[("field.vtu", field.vtu())])
}
