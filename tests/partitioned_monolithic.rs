//! The intact dam and its water as two units, or with tailwater as three, iterated, against one assembled system that is
//! solved without iterating.
//!
//! The assembled system has dense matrices, a time stepping of its own, and for every communication step the one linear
//! equation of the pressures at all interfaces: with the dam's motion ā = ā₀ + S p₁ (S from its matrices) and the water's
//! pressure p₁ = h + D ā (h from its history, D the exact derivative, with a block for each water),
//!
//! ```text
//! (1 − D S) p₁ = h + D ā₀
//! ```

use cofferdam_assembly::simulation::scales;
use cofferdam_assembly::units::{DAM, GROUND_ACCELERATION, wet_face_interface};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure};
use cofferdam_coupling::participant::{InProcess, Messages, Participant};
use cofferdam_coupling::scheme::{Graph, Interval, Port, Predictor, Scheme, SchemeKind, Settings, UnitId};
use cofferdam_coupling::signal::Signal;
use cofferdam_dam::{Dam, SystemMatrices};
use cofferdam_reservoir::{Fidelity, Reservoir, ReservoirParameters};
use cofferdam_unit::{CoSimulation, variables};
use nalgebra::{DMatrix, DVector};
use std::num::NonZeroUsize;
use whole_chain::koyna;

const H: f64 = 0.0025;
const STEPS: u64 = 240;
const SIZE: f64 = 10.0;

type Failure = Box<dyn std::error::Error>;

fn ground(step: u64) -> [f64; 2] {
    let t = step as f64 * H;
    [if t < 0.3 { 3.0 * (40.0 * t).sin() * (9.0 * t).cos() } else { 0.0 }, 0.0]
}

/// The dam's matrices, dense, and its motion relative to the ground.
#[derive(Clone)]
struct Assembled {
    inverse_mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    concrete: DVector<f64>,
    damping: cofferdam_dam::RayleighCoefficients,
    pressure_forces: DMatrix<f64>,
    interface_motion: DMatrix<f64>,
    /// Load of a unit ground acceleration along x, kg/m, and its part at the interface points.
    inertia: DVector<f64>,
    shown: DVector<f64>,
    /// Memory of the stiffness damping, and its current rate.
    memory: f64,
    rate: DVector<f64>,
    time_steps: usize,
    crest: usize,
    displacement: DVector<f64>,
    velocity: DVector<f64>,
    acceleration: DVector<f64>,
}

impl Assembled {
    fn new(dam: &Dam) -> Result<Self, Failure> {
        let m: SystemMatrices = dam.system_matrices();
        let faces = || dam.wet_face().into_iter().chain(dam.tailwater_face());
        let normals: Vec<f64> =
            faces().flat_map(cofferdam_unit::WetFace::normals).map(|normal| normal[0]).collect();
        let (n, points) = (m.mass.len(), normals.len());
        let concrete = DVector::from_vec(m.mass.clone());
        let mut mass = DMatrix::from_diagonal(&concrete);
        let mut stiffness = DMatrix::zeros(n, n);
        let (mut forces, mut motion) = (DMatrix::zeros(n, points), DMatrix::zeros(points, n));
        m.added_mass.iter().for_each(|&(i, j, x)| mass[(i, j)] += x);
        m.stiffness.iter().for_each(|&(i, j, k)| stiffness[(i, j)] += k);
        m.pressure_forces.iter().for_each(|&(i, j, b)| forces[(i, j)] += b);
        m.interface_motion.iter().for_each(|&(i, j, x)| motion[(i, j)] += x);
        let inertia =
            DVector::from_fn(n, |i, _| m.mass[i] * m.ground_influence[0][i] + m.added_ground_inertia[0][i]);
        Ok(Self {
            inverse_mass: mass.try_inverse().ok_or("a mass matrix has an inverse")?,
            stiffness,
            concrete,
            damping: m.damping,
            pressure_forces: forces,
            interface_motion: motion,
            inertia,
            shown: DVector::from_vec(normals),
            memory: dam.damping_coefficients().memory,
            rate: DVector::zeros(n),
            time_steps: dam.time_steps_per(H),
            crest: m.crest[0],
            displacement: DVector::zeros(n),
            velocity: DVector::zeros(n),
            acceleration: DVector::zeros(n),
        })
    }

    /// A communication step; returns the mean total acceleration of the interface points.
    fn step(&mut self, pressure: [&DVector<f64>; 2], ground: [f64; 2]) -> DVector<f64> {
        let load = |p: &DVector<f64>, a: f64| &self.pressure_forces * p - &self.inertia * a;
        let (start, end) = (load(pressure[0], ground[0]), load(pressure[1], ground[1]));
        let change = end - &start;
        let before = self.velocity.clone();
        let dt = H / self.time_steps as f64;
        self.velocity += &self.acceleration * (dt / 2.0);
        for step in 1..=self.time_steps {
            self.displacement += &self.velocity * dt;
            let share = step as f64 / self.time_steps as f64;
            self.rate = &self.rate * self.memory + &self.velocity * (1.0 - self.memory);
            let strained = &self.displacement + &self.rate * self.damping.stiffness;
            let damped = self.concrete.component_mul(&self.velocity) * self.damping.mass;
            let force = &start + &change * share - &self.stiffness * strained - damped;
            self.acceleration = &self.inverse_mass * force;
            let advance = if step < self.time_steps { dt } else { dt / 2.0 };
            self.velocity += &self.acceleration * advance;
        }
        let mean = (&self.velocity - before) / H;
        &self.interface_motion * mean + &self.shown * ((ground[0] + ground[1]) / 2.0)
    }
}

/// The water alone: its pressure for a mean acceleration, from the saved state.
struct Water {
    unit: Reservoir,
    derivative: DMatrix<f64>,
    points: usize,
}

impl Water {
    fn new(parameters: ReservoirParameters) -> Result<Self, Failure> {
        let mut unit = Reservoir::new(parameters, NonZeroUsize::MIN)?;
        unit.initialise(0.0)?;
        let points = unit.parameters().wet_face.len();
        let mut derivative = DMatrix::zeros(points, points);
        let [p, a] = [
            variables::reservoir::INTERFACE_PRESSURE.value_reference,
            variables::reservoir::INTERFACE_ACCELERATION.value_reference,
        ];
        for j in 0..points {
            let seed: Vec<f64> = (0..points).map(|i| f64::from(u8::from(i == j))).collect();
            let mut column = vec![0.0; points];
            unit.directional_derivative(p, a, &seed, &mut column)?;
            derivative.set_column(j, &DVector::from_vec(column));
        }
        Ok(Self { unit, derivative, points })
    }

    fn step(&mut self, step: u64, acceleration: &DVector<f64>) -> Result<DVector<f64>, Failure> {
        let [p, a] = [
            variables::reservoir::INTERFACE_PRESSURE.value_reference,
            variables::reservoir::INTERFACE_ACCELERATION.value_reference,
        ];
        self.unit.set(a, acceleration.as_slice())?;
        self.unit.step((step - 1) as f64 * H, H)?;
        let mut pressure = vec![0.0; self.points];
        self.unit.get(p, &mut pressure)?;
        Ok(DVector::from_vec(pressure))
    }
}

/// All waters of the dam, one after another.
struct Waters {
    waters: Vec<Water>,
    derivative: DMatrix<f64>,
    points: usize,
}

impl Waters {
    fn new(parameters: &[ReservoirParameters]) -> Result<Self, Failure> {
        let waters = parameters.iter().cloned().map(Water::new).collect::<Result<Vec<_>, _>>()?;
        let points = waters.iter().map(|water| water.points).sum();
        let mut derivative = DMatrix::zeros(points, points);
        let mut first = 0;
        for water in &waters {
            let size = (water.points, water.points);
            derivative.view_mut((first, first), size).copy_from(&water.derivative);
            first += water.points;
        }
        Ok(Self { waters, derivative, points })
    }

    fn step(&mut self, step: u64, acceleration: &DVector<f64>) -> Result<DVector<f64>, Failure> {
        let mut pressure = DVector::zeros(self.points);
        let mut first = 0;
        for water in &mut self.waters {
            let own = acceleration.rows(first, water.points).into_owned();
            pressure.rows_mut(first, water.points).copy_from(&water.step(step, &own)?);
            first += water.points;
        }
        Ok(pressure)
    }

    /// The answer to a step, from which the waters return.
    fn tried(&mut self, step: u64, acceleration: &DVector<f64>) -> Result<DVector<f64>, Failure> {
        let saved: Vec<_> = self.waters.iter().map(|water| water.unit.save_state()).collect();
        let pressure = self.step(step, acceleration)?;
        for (water, state) in self.waters.iter_mut().zip(&saved) {
            water.unit.restore_state(state)?;
        }
        Ok(pressure)
    }
}

/// Crest displacement and the pressures at all communication points.
type History = (Vec<f64>, Vec<f64>);

/// The assembled system; `exchanged` where the water is not in the mass matrix.
fn monolithic(dam: &Dam, mut water: Waters, exchanged: bool) -> Result<History, Failure> {
    let mut assembled = Assembled::new(dam)?;
    let points = water.points;
    let rest = DVector::zeros(points);
    let mut response = DMatrix::zeros(points, points);
    for j in 0..points {
        let mut unit = DVector::zeros(points);
        unit[j] = 1.0;
        response.set_column(j, &assembled.clone().step([&rest, &unit], [0.0; 2]));
    }
    let system = DMatrix::identity(points, points) - &water.derivative * &response;
    let system = system.lu();
    let (mut crest, mut pressures, mut before) = (Vec::new(), Vec::new(), rest.clone());
    for step in 1..=STEPS {
        let ground = [ground(step - 1)[0], ground(step)[0]];
        if exchanged {
            let alone = assembled.clone().step([&before, &rest], ground);
            let history = water.tried(step, &DVector::zeros(points))?;
            let right = history + &water.derivative * alone;
            let pressure = system.solve(&right).ok_or("the interface equation has a solution")?;
            let acceleration = assembled.step([&before, &pressure], ground);
            let answered = water.step(step, &acceleration)?;
            assert!((&answered - &pressure).norm() <= 1e-9 * pressure.norm() + 1e-6, "the equation holds");
            before = pressure;
        } else {
            let acceleration = assembled.step([&rest, &rest], ground);
            before = water.step(step, &acceleration)?;
        }
        crest.push(assembled.displacement[assembled.crest]);
        pressures.extend_from_slice(before.as_slice());
    }
    Ok((crest, pressures))
}

fn partitioned(
    dam: Dam,
    waters: Vec<Reservoir>,
    kind: SchemeKind,
    tolerance: f64,
) -> Result<(History, f64), Failure> {
    let base = 1000.0 * 9.81 * koyna::DEPTH;
    let interface = |number: usize| {
        let structure = Port { unit: DAM, prefix: ["", "tailwater_"][number].to_owned() };
        wet_face_interface(structure, Port::of(UnitId(number + 1)), 1000.0 * koyna::DEPTH)
    };
    let interfaces = (0..waters.len()).map(interface).collect();
    let mut units: Vec<Box<dyn Participant>> =
        vec![Box::new(InProcess::new(dam, "dam", Messages::default()))];
    for water in waters {
        units.push(Box::new(InProcess::new(water, "water", Messages::default())));
    }
    let mut graph = Graph::new(units, interfaces)?;
    let fluids: Vec<UnitId> = graph.ids().skip(1).collect();
    let range = |range: Option<std::ops::Range<usize>>| range.ok_or("the contract's variables");
    let crest_range = range(graph[DAM].description().outputs.range("crest_displacement"))?;
    let pressure_range = |&id: &UnitId| range(graph[id].description().outputs.range("interface_pressure"));
    let pressure_ranges = fluids.iter().map(pressure_range).collect::<Result<Vec<_>, _>>()?;
    let measure = ConvergenceMeasure::new(&[Measure::Relative], tolerance, scales(koyna::CREST, base));
    let acceleration = Acceleration::new(AccelerationKind::InterfaceJacobian, 0.5, 1e-4 * base);
    let settings = Settings { kind, ..Settings::default() };
    let samples = (0..=STEPS).map(|step| ground(step)[0]).collect();
    let signals = vec![Signal::new("ground_motion", GROUND_ACCELERATION, H, samples)];
    let mut scheme = Scheme::new(&mut graph, settings, acceleration, Predictor::new(2), measure, signals)?;
    scheme.initialise(&mut graph, 0.0)?;
    let (mut crest, mut pressures, mut iterations) = (Vec::new(), Vec::new(), 0);
    for step in 1..=STEPS {
        let time = (step - 1) as f64 * H;
        let interval = Interval { signal_time: step as f64 * H, ..Interval::new(step, time, H) };
        let report = scheme.advance(&mut graph, &[interval])?;
        iterations += report.iterations();
        let of = |side| report.accepted(side, step).ok_or("an accepted exchange");
        crest.push(of(DAM)?.outputs[crest_range.clone()][0]);
        for (fluid, range) in fluids.iter().zip(&pressure_ranges) {
            pressures.extend_from_slice(&of(*fluid)?.outputs[range.clone()]);
        }
    }
    Ok(((crest, pressures), f64::from(iterations) / STEPS as f64))
}

/// ‖a − b‖₂ / ‖b‖₂
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    (square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut b.iter().copied())).sqrt()
}

#[test]
fn iterated_units_give_what_one_assembled_system_gives() -> Result<(), Failure> {
    for (fidelity, kind) in [
        (Fidelity::Compressible, SchemeKind::SerialImplicit),
        (Fidelity::Compressible, SchemeKind::ParallelImplicit),
        (Fidelity::Incompressible, SchemeKind::SerialImplicit),
        (Fidelity::Incompressible, SchemeKind::OneWay),
        (Fidelity::Westergaard, SchemeKind::SerialImplicit),
        (Fidelity::Westergaard, SchemeKind::OneWay),
    ] {
        let mut parameters = koyna::dam(SIZE, false);
        let face = parameters.wet_face()?.ok_or("a dam in water")?;
        let water = cofferdam_reservoir::ReservoirParameters {
            fidelity,
            ..koyna::reservoir(face, H, STEPS as f64 * H)
        };
        if kind == SchemeKind::OneWay {
            let mass = cofferdam_reservoir::added_mass(&water)?;
            parameters.added_mass = Some(mass.row_iter().map(|row| row.iter().copied().collect()).collect());
        }
        let exchanged = kind != SchemeKind::OneWay;
        let dam = Dam::new(parameters)?;
        let (crest, pressure) = monolithic(&dam, Waters::new(std::slice::from_ref(&water))?, exchanged)?;
        let unit = Reservoir::new(water, NonZeroUsize::MIN)?;
        let ((crest_too, pressure_too), iterations) = partitioned(dam, vec![unit], kind, 1e-10)?;
        let errors = [apart(&crest_too, &crest), apart(&pressure_too, &pressure)];
        println!(
            "{fidelity:?}, {kind:?}: crest {:.1e}, pressure {:.1e} (relative L2), {iterations:.2} dam steps per communication step",
            errors[0], errors[1]
        );
        assert!(errors.iter().all(|error| *error <= 1e-6), "{errors:?}");
        assert!(crest.iter().any(|u| u.abs() > 1e-3), "it moves");
    }
    Ok(())
}

/// Tailwater of 40 m beside the reservoir. The iterations go on until rounding; what remains is the rounding of both paths.
#[test]
fn a_dam_between_two_waters_is_as_one_assembled_system() -> Result<(), Failure> {
    const TAILWATER: f64 = 40.0;
    for (fidelities, kind) in [
        ([Fidelity::Compressible, Fidelity::Compressible], SchemeKind::SerialImplicit),
        ([Fidelity::Compressible, Fidelity::Compressible], SchemeKind::ParallelImplicit),
        ([Fidelity::Westergaard, Fidelity::Compressible], SchemeKind::SerialImplicit),
        ([Fidelity::Incompressible, Fidelity::Westergaard], SchemeKind::OneWay),
    ] {
        let mut parameters =
            cofferdam_dam::DamParameters { tailwater_depth: TAILWATER, ..koyna::dam(SIZE, false) };
        let faces = [parameters.wet_face()?, parameters.tailwater_face()?];
        let mut waters = Vec::new();
        for (face, fidelity) in faces.into_iter().flatten().zip(fidelities) {
            let like_koyna = koyna::reservoir(face, H, STEPS as f64 * H);
            waters.push(ReservoirParameters { fidelity, ..like_koyna });
        }
        assert_eq!(waters.iter().map(|water| water.toe).collect::<Vec<_>>(), [None, Some(70.0)]);
        if kind == SchemeKind::OneWay {
            let [upstream, downstream] = [&waters[0], &waters[1]].map(cofferdam_reservoir::added_mass);
            let (upstream, downstream) = (upstream?, downstream?);
            let (m, n) = (upstream.nrows(), downstream.nrows());
            let mut both = DMatrix::zeros(m + n, m + n);
            both.view_mut((0, 0), (m, m)).copy_from(&upstream);
            both.view_mut((m, m), (n, n)).copy_from(&downstream);
            parameters.added_mass = Some(both.row_iter().map(|row| row.iter().copied().collect()).collect());
        }
        let dam = Dam::new(parameters)?;
        let exchanged = kind != SchemeKind::OneWay;
        let (crest, pressure) = monolithic(&dam, Waters::new(&waters)?, exchanged)?;
        let units = waters.into_iter().map(|water| Reservoir::new(water, NonZeroUsize::MIN));
        let units = units.collect::<Result<Vec<_>, _>>()?;
        let ((crest_too, pressure_too), iterations) = partitioned(dam, units, kind, 1e-13)?;
        let errors = [apart(&crest_too, &crest), apart(&pressure_too, &pressure)];
        println!(
            "{fidelities:?}, {kind:?}: crest {:.1e}, pressures {:.1e} (relative L2), {iterations:.2} dam steps per communication step",
            errors[0], errors[1]
        );
        assert!(errors.iter().all(|error| *error <= 1e-10), "{errors:?}");
        assert!(crest.iter().any(|u| u.abs() > 1e-3), "it moves");
    }
    Ok(())
}
