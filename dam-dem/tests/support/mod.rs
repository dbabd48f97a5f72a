//! Dams and helper functions that the tests share.

pub mod assembly;

use cofferdam_dam::contact::{ContactLaw, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    Block, CrackParameters, CriticalTimeStep, Dam, DamError, DamParameters, DampingCoefficients, Kinematics,
    Material, Mesh, Motion, Seam, Section, Structure,
};
use cofferdam_unit::{CoSimulation, Variable, variables::dam as variable};
use nalgebra::{DMatrix, Matrix4, SymmetricEigen, Vector4};

/// The cracked Koyna dam of the main scene.
pub fn koyna(element_size: f64) -> DamParameters {
    DamParameters { element_size, ..Default::default() }
}

pub fn crack_at(elevation: f64) -> CrackParameters {
    CrackParameters::sliding(elevation, 1.0, 1e11, 0.5e11)
}

/// Hydrostatic pressure at the interface points, Pa.
pub fn hydrostatic(dam: &Dam) -> Vec<f64> {
    let depth = dam.parameters().water_depth;
    dam.wet_face().map_or(Vec::new(), |face| face.points().iter().map(|p| 9810.0 * (depth - p[1])).collect())
}

/// A dam at rest under its weight and water at time 0.
pub fn at_rest(parameters: DamParameters) -> Result<Dam, DamError> {
    let mut dam = Dam::new(parameters)?;
    dam.set(variable::HYDROSTATIC_PRESSURE.value_reference, &hydrostatic(&dam))?;
    dam.initialise(0.0)?;
    Ok(dam)
}

/// Values of a variable.
pub fn get(dam: &Dam, variable: &Variable) -> Vec<f64> {
    let mut values = vec![f64::NAN; dam.size(variable)];
    dam.get(variable.value_reference, &mut values).unwrap();
    values
}

/// Steps until the time `until` (s) with the ground acceleration `ground(t)` (m/s²) along x, and half of it along y.
pub fn shake(dam: &mut Dam, step: f64, until: f64, ground: impl Fn(f64) -> f64) -> Result<(), DamError> {
    while dam.state().time() < until - step / 2.0 {
        let time = dam.state().time();
        let a = ground(time + step);
        dam.set(variable::GROUND_ACCELERATION.value_reference, &[a, 0.5 * a])?;
        dam.step(time, step)?;
    }
    Ok(())
}

/// Three bursts of a 3 Hz sine of 0.5 g, each multiplied by a raised cosine.
pub fn bursts(time: f64) -> f64 {
    use std::f64::consts::TAU;
    let envelope = 0.5 - 0.5 * (TAU * time / 2.0).cos();
    if time < 6.0 { 0.5 * 9.81 * envelope * (TAU * 3.0 * time).sin() } else { 0.0 }
}

/// Nodes of the crest, from upstream to downstream.
pub fn top(mesh: &Mesh) -> Vec<usize> {
    let height = mesh.nodes.iter().map(|node| node[1]).fold(0.0, f64::max);
    (0..mesh.nodes.len()).filter(|&node| mesh.nodes[node][1] == height).collect()
}

pub const GRAVITY: f64 = 9.81;

pub fn stiff(young_modulus: f64) -> Material {
    Material { young_modulus, poisson_ratio: 0.0, density: 2500.0, ..Default::default() }
}

/// A block of `size` (m) in the middle of a fixed block that is 4 m wider and 1 m high; the meshes do not match.
pub fn block_on_ground<L: ContactLaw>(
    size: [f64; 2],
    young_modulus: f64,
    law: L,
    contacts: Integration,
) -> Structure<L> {
    let width = size[0] + 4.0;
    let mut mesh = Mesh::mapped(&Section::rectangle(width, 1.0), &[vec![0.0, 1.0]], 11);
    let rows: Vec<f64> = (0..=2).map(|i| size[1] * f64::from(i) / 2.0).collect();
    let upper = Mesh::mapped(&Section::rectangle(size[0], size[1]), &[rows], 4);
    let (nodes, cells, lower) = (mesh.nodes.len(), mesh.cells.len(), top(&mesh));
    mesh.nodes.extend(upper.nodes.iter().map(|[x, y]| [x + 2.0, y + 1.0]));
    mesh.cells.extend(upper.cells.iter().map(|cell| cell.map(|node| node + nodes)));
    mesh.blocks.push(Block { nodes: nodes..mesh.nodes.len(), cells: cells..mesh.cells.len() });
    let upper = upper.base.iter().map(|node| node + nodes).collect();
    mesh.seams.push(Seam { crack: 0, below: 0, above: 1, lower, upper });
    mesh.ground = mesh.nodes.len()..mesh.nodes.len();
    let fixed: Vec<usize> = (0..nodes).collect();
    Structure::new(mesh, &stiff(young_modulus), Kinematics::Corotational, [(law, contacts)], &fixed)
}

/// The critical time step of `structure`.
pub fn critical(
    structure: &Structure<impl ContactLaw>,
    damping: impl Into<DampingCoefficients>,
) -> CriticalTimeStep {
    CriticalTimeStep::of(structure, damping).expect("the highest frequency is found")
}

/// Steps under the constant acceleration `body` (m/s²) of all masses for `duration` (s).
pub fn run(
    structure: &Structure,
    damping: impl Into<DampingCoefficients>,
    motion: &mut Motion,
    body: [f64; 2],
    duration: f64,
) -> Work {
    let damping = damping.into();
    let forces = structure.weight(body);
    structure.accelerate(damping, motion, &forces);
    let steps = CentralDifference::covering(duration, 0.9 * critical(structure, damping).limit);
    let mut work = Work::default();
    steps.advance(structure, damping, motion, &LoadPath::constant(forces), &mut work);
    work
}

/// Mass-weighted mean of `field` over the free nodes of `block`.
pub fn mean(structure: &Structure<impl ContactLaw>, field: &[[f64; 2]], block: usize) -> [f64; 2] {
    let nodes = structure.mesh.blocks[block].nodes.clone();
    let mass: f64 = nodes.clone().map(|n| structure.mass[n]).sum();
    [0, 1].map(|d| nodes.clone().map(|n| structure.mass[n] * field[n][d]).sum::<f64>() / mass)
}

/// Momentum and moment of momentum about `origin`, and the sums of the sizes of their terms.
pub fn momenta(
    structure: &Structure<impl ContactLaw>,
    motion: &Motion,
    origin: [f64; 2],
) -> ([f64; 3], [f64; 3]) {
    let (mut sum, mut size) = ([0.0; 3], [0.0; 3]);
    for (node, mass) in structure.mass.iter().enumerate() {
        let (rest, u) = (structure.mesh.nodes[node], motion.displacement[node]);
        let place = [0, 1].map(|d| rest[d] - origin[d] + u[d]);
        let [p, q] = motion.velocity[node].map(|v| mass * v);
        let terms = [p, q, place[0] * q - place[1] * p];
        let sizes = [p.abs(), q.abs(), (place[0] * q).abs() + (place[1] * p).abs()];
        for i in 0..3 {
            sum[i] += terms[i];
            size[i] += sizes[i];
        }
    }
    (sum, size)
}

/// Mean of `field` over `nodes`, unweighted.
pub fn mean_at(field: &[[f64; 2]], nodes: &[usize]) -> [f64; 2] {
    [0, 1].map(|d| nodes.iter().map(|&n| field[n][d]).sum::<f64>() / nodes.len() as f64)
}

/// The records of the project.
pub const RECORDS: [&str; 3] = [
    "northridge-1994-canyon-country-270",
    "northridge-1994-beverly-hills-279",
    "loma-prieta-1989-corralitos-038",
];

/// Samples of an acceleration (m/s²), linear between the samples, 0 after the last one.
pub struct Record(Vec<[f64; 2]>);

impl Record {
    /// One of the records of the project.
    pub fn read(name: &str) -> Self {
        let path = format!("{}/../scenes/records/{name}.csv", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let pairs = text.lines().filter_map(|line| line.split_once(','));
        Self(pairs.filter_map(|(t, a)| Some([t.parse().ok()?, 9.80665 * a.parse::<f64>().ok()?])).collect())
    }

    pub fn at(&self, time: f64) -> f64 {
        let next = self.0.partition_point(|sample| sample[0] < time).clamp(1, self.0.len() - 1);
        let [[t0, a0], [t1, a1]] = [self.0[next - 1], self.0[next]];
        if time > t1 { 0.0 } else { a0 + (a1 - a0) * (time - t0) / (t1 - t0) }
    }
}

/// The same dam with Westergaard's added mass `⅞ ρ √(h(h − y))`.
pub fn with_water(parameters: DamParameters) -> DamParameters {
    let face = parameters.wet_face().unwrap().unwrap();
    let h = face.depth();
    let mass = |i: usize| 875.0 * (h * (h - face.points()[i][1])).sqrt();
    let row = |i: usize| (0..face.len()).map(|j| if i == j { mass(i) } else { 0.0 }).collect();
    DamParameters { added_mass: Some((0..face.len()).map(row).collect()), ..parameters }
}

/// Horizontal crest displacement (m) of the intact dam after each `step` (s), with `ground` linear within a
/// step, by superposition of all modes of the dam's matrices. Each mode is advanced over a step by the matrix
/// exponential of its equation of motion.
pub fn modal_crest(dam: &Dam, ground: impl Fn(f64) -> f64, step: f64, until: f64) -> Vec<f64> {
    let m = dam.system_matrices();
    let n = m.mass.len();
    let root: Vec<f64> = m.mass.iter().map(|mass| mass.sqrt()).collect();
    let mut scaled = DMatrix::zeros(n, n);
    m.stiffness.iter().for_each(|&(i, j, k)| scaled[(i, j)] = k / (root[i] * root[j]));
    let eigen = SymmetricEigen::new(scaled);
    let steps = (until / step).round() as usize;
    let mut crest = vec![0.0; steps];
    for (mode, &square) in eigen.eigenvalues.iter().enumerate() {
        let shape = eigen.eigenvectors.column(mode);
        let factor: f64 = (0..n).map(|i| -shape[i] * root[i] * m.ground_influence[0][i]).sum();
        let at_crest = shape[m.crest[0]] / root[m.crest[0]];
        let damping = m.damping.mass + m.damping.stiffness * square;
        // q, q̇, force, change of the force over the step
        let rate = Matrix4::new(
            0.0,
            step,
            0.0,
            0.0,
            -square * step,
            -damping * step,
            step,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            0.0,
        );
        let carry = rate.exp();
        let mut state = Vector4::zeros();
        for (k, crest) in crest.iter_mut().enumerate() {
            let [before, after] =
                [k, k + 1].map(|k| factor * if k == 0 { 0.0 } else { ground(k as f64 * step) });
            state = carry * Vector4::new(state[0], state[1], before, after - before);
            *crest += at_crest * state[0];
        }
    }
    crest
}
