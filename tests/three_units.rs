//! A structure between two fluids, as three units: against the dense solution of all three together, in the log, replayed.
//!
//! ```text
//! structure   M a = −K u + Σᵢ Bᵢ pᵢ − M r g      u ← u + h v + h²/2 a,   v ← v + h a
//! fluid i     pᵢ = −(Aᵢ aᵢ + Cᵢ wᵢ)              aᵢ = Bᵢᵀ a,             wᵢ ← wᵢ + h aᵢ
//! ```
//!
//! Bᵢ picks the degrees of freedom of face i. The faces share a third of theirs, and each fluid is as heavy as the
//! structure: the interfaces act on each other strongly.

use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::units::wet_face_interface;
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
use cofferdam_coupling::scheme::{
    CouplingError, Graph, Interface, Port, Predictor, Scheme, SchemeKind, Settings, UnitId,
};
use cofferdam_coupling::simulation::Simulation;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_log::replay::replay;
use cofferdam_log::{Entry, Log, LogWriter, Preamble, compare};
use nalgebra::{DMatrix, DVector};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use whole_chain::scenario::root;
use whole_chain::small_unit::SmallUnit;

const FREEDOMS: usize = 12;
/// First degree of freedom and number of points of each face.
const FACES: [(usize, usize); 2] = [(0, 6), (4, 5)];
const PREFIXES: [&str; 2] = ["", "tailwater_"];
const STEP: f64 = 0.005;
const STEPS: u64 = 200;

/// A symmetric positive definite matrix, about `scale` times the unit matrix.
fn matrix(size: usize, seed: f64, scale: f64) -> DMatrix<f64> {
    let half = DMatrix::from_fn(size, size, |i, j| (seed + 3.7 * i as f64 + 1.3 * j as f64).sin());
    (DMatrix::identity(size, size) + &half * half.transpose() / size as f64) * scale
}

fn mass() -> DMatrix<f64> {
    matrix(FREEDOMS, 1.0, 1.0)
}

fn stiffness() -> DMatrix<f64> {
    matrix(FREEDOMS, 2.0, 400.0)
}

/// Aᵢ and Cᵢ.
fn water(face: usize) -> [DMatrix<f64>; 2] {
    let ((_, points), seed) = (FACES[face], face as f64);
    [matrix(points, 3.0 + seed, 1.5), matrix(points, 5.0 + seed, 20.0)]
}

/// Force of the ground's acceleration, M r g.
fn driven(ground: &[f64]) -> DVector<f64> {
    mass() * DVector::from_fn(FREEDOMS, |i, _| ground[i % 2])
}

/// Displacement and velocity.
type Motion = [DVector<f64>; 2];

fn at_rest() -> Motion {
    [DVector::zeros(FREEDOMS), DVector::zeros(FREEDOMS)]
}

fn move_on([u, v]: &mut Motion, a: &DVector<f64>, h: f64) {
    *u += &*v * h + a * (h * h / 2.0);
    *v += a * h;
}

/// M + h²/2 K.
fn implicit(h: f64) -> DMatrix<f64> {
    mass() + stiffness() * (h * h / 2.0)
}

fn structure() -> SmallUnit<Motion> {
    let faces = [0, 1].map(|i| (PREFIXES[i], FACES[i].1));
    let outputs = 2 * (FACES[0].1 + FACES[1].1);
    SmallUnit::structure("dam", &faces, at_rest(), vec![0.0; outputs], |motion, at, given, answer| {
        let (h, [u, v]) = (at.communication_step, &*motion);
        let mut force = -(stiffness() * (u + v * h) + driven(&given[given.len() - 2..]));
        let mut place = 0;
        for (first, points) in FACES {
            let mut face = force.rows_mut(first, points);
            face += DVector::from_column_slice(&given[place..place + points]);
            place += 2 * points;
        }
        let a = implicit(h).lu().solve(&force).expect("a regular matrix");
        move_on(motion, &a, h);
        let parts =
            FACES.iter().flat_map(|&(first, points)| [(&motion[0], first, points), (&a, first, points)]);
        let values = parts
            .flat_map(|(all, first, points)| all.rows(first, points).iter().copied().collect::<Vec<_>>());
        answer.iter_mut().zip(values).for_each(|(answer, value)| *answer = value);
    })
}

fn fluid(face: usize) -> SmallUnit<DVector<f64>> {
    let (name, points) = (["reservoir", "tailwater"][face], FACES[face].1);
    let [inertia, damping] = water(face);
    SmallUnit::fluid(
        name,
        points,
        DVector::zeros(points),
        vec![0.0; points],
        move |velocity, at, given, answer| {
            let a = DVector::from_column_slice(&given[..points]);
            *velocity += &a * at.communication_step;
            answer.copy_from_slice((-(&inertia * a + &damping * &*velocity)).as_slice());
        },
    )
}

fn ports() -> Vec<Interface> {
    let interface = |face: usize| {
        let structure = Port { unit: UnitId(0), prefix: PREFIXES[face].to_owned() };
        wet_face_interface(structure, Port::of(UnitId(face + 1)), 1.0)
    };
    vec![interface(0), interface(1)]
}

/// Runs the three into a log; the largest number of iterations of a step.
fn run(kind: SchemeKind, path: &Path) -> Result<u32, Box<dyn std::error::Error>> {
    let loaded = cofferdam_assembly::read_scene(&root().join("scenes/koyna-coarse"), &[])?;
    let mut graph = Graph::new(vec![Box::new(structure()), Box::new(fluid(0)), Box::new(fluid(1))], ports())?;
    let measure = ConvergenceMeasure::new(
        &[Measure::Relative],
        1e-13,
        Scales { typical: 10000.0, bound: 1e9, ..Scales::default() },
    );
    let acceleration = Acceleration::new(AccelerationKind::IqnIls, 0.1, 1.0);
    let settings = Settings { kind, ..Settings::default() };
    let signals = ground_signals(&loaded.ground_motion);
    let scheme = Scheme::new(&mut graph, settings, acceleration, Predictor::new(2), measure, signals)?;
    let scene = toml::to_string(&loaded.scene)?;
    let mut log = LogWriter::create(path, &Preamble { scene, ..Preamble::default() })?;
    let mut simulation = Simulation::new(graph, scheme, Stepping::equal(STEP, STEPS));
    let (_, failure) = simulation.run(&mut [&mut log], &AtomicBool::new(false));
    assert!(failure.is_none(), "{failure:?}");
    let iterations = Log::open(path)?.entries()?.filter_map(|entry| match entry {
        Ok(Entry::Step(step)) => Some(step.occasion.iteration),
        _ => None,
    });
    Ok(iterations.max().expect("a step"))
}

/// Largest difference of the accepted displacements and pressures from those of one system for all unknowns, over the
/// largest of each.
fn error(path: &Path) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let [upstream, downstream] = FACES.map(|(_, points)| points);
    let size = FREEDOMS + upstream + downstream;
    let mut together = DMatrix::zeros(size, size);
    together.view_mut((0, 0), (FREEDOMS, FREEDOMS)).copy_from(&implicit(STEP));
    for (face, (first, points)) in FACES.into_iter().enumerate() {
        let ([inertia, damping], row) = (water(face), FREEDOMS + face * upstream);
        for i in 0..points {
            together[(first + i, row + i)] = -1.0;
            together[(row + i, row + i)] = 1.0;
        }
        let impedance = inertia + damping * STEP;
        together.view_mut((row, first), (points, points)).copy_from(&impedance);
    }
    let together = together.lu();
    let (mut motion, mut velocity) = (at_rest(), FACES.map(|(_, points)| DVector::zeros(points)));
    let (mut difference, mut largest) = ([0.0f64; 2], [0.0f64; 2]);
    let mut expected = DVector::zeros(size);
    for entry in Log::open(path)?.entries()? {
        let Entry::Exchange(exchange) = entry? else { continue };
        if !exchange.accepted || exchange.occasion.step == 0 {
            continue;
        }
        let outputs = exchange.outputs.expect("it was accepted");
        // Every scheme asks the structure first.
        if exchange.unit == UnitId(0) {
            let [u, v] = &motion;
            let ground = &exchange.inputs[exchange.inputs.len() - 2..];
            let mut right = DVector::zeros(size);
            right.rows_mut(0, FREEDOMS).copy_from(&-(stiffness() * (u + v * STEP) + driven(ground)));
            for (face, velocity) in velocity.iter().enumerate() {
                let [_, damping] = water(face);
                right.rows_mut(FREEDOMS + face * upstream, velocity.len()).copy_from(&-(damping * velocity));
            }
            expected = together.solve(&right).expect("a regular matrix");
            let a = expected.rows(0, FREEDOMS).into_owned();
            move_on(&mut motion, &a, STEP);
            for (velocity, (first, points)) in velocity.iter_mut().zip(FACES) {
                *velocity += a.rows(first, points) * STEP;
            }
        }
        let (kind, found, expected) = match exchange.unit {
            UnitId(0) => (0, &outputs[..upstream], motion[0].rows(0, upstream)),
            UnitId(1) => (1, &outputs[..], expected.rows(FREEDOMS, upstream)),
            _ => (1, &outputs[..], expected.rows(FREEDOMS + upstream, downstream)),
        };
        for (found, expected) in found.iter().zip(&expected) {
            difference[kind] = difference[kind].max((found - expected).abs());
            largest[kind] = largest[kind].max(expected.abs());
        }
    }
    assert!(largest.into_iter().all(|largest| largest > 0.0), "the ground moved");
    Ok([difference[0] / largest[0], difference[1] / largest[1]])
}

#[test]
fn a_structure_between_two_fluids_is_as_one_system_and_replays() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    for kind in [SchemeKind::SerialImplicit, SchemeKind::ParallelImplicit] {
        let path = folder.path().join("first.mcap");
        let iterations = run(kind, &path)?;
        let [displacement, pressure] = error(&path)?;
        println!(
            "{kind:?}: at most {iterations} iterations; displacement {displacement:.1e}, pressure {pressure:.1e}"
        );
        assert!(displacement < 1e-10 && pressure < 1e-10);
        let log = Log::open(&path)?;
        let names: Vec<_> = log.head().units.iter().map(|unit| unit.name.as_str()).collect();
        assert_eq!(names, ["dam", "reservoir", "tailwater"]);
        let mut exchanges = 0;
        for id in 0..3 {
            let again = match id {
                0 => replay(&log, UnitId(0), &mut structure(), |_| ())?,
                _ => replay(&log, UnitId(id), &mut fluid(id - 1), |_| ())?,
            };
            assert_eq!(again.divergence, None);
            exchanges += again.identical;
        }
        let second = folder.path().join("second.mcap");
        run(kind, &second)?;
        let same = compare([&log, &Log::open(&second)?])?;
        assert!(same.identical() && same.identical == exchanges);
    }
    Ok(())
}

#[test]
fn units_that_do_not_fit_together_are_named() {
    let units = |names: [&str; 2]| -> Vec<Box<dyn cofferdam_coupling::participant::Participant>> {
        let [first, second] = names;
        let dam = SmallUnit::structure(first, &[("", 2)], (), Vec::new(), |_, _, _, _| ());
        vec![Box::new(dam), Box::new(SmallUnit::fluid(second, 2, (), Vec::new(), |_, _, _, _| ()))]
    };
    let between =
        |structure, fluid| wet_face_interface(Port::of(UnitId(structure)), Port::of(UnitId(fluid)), 1.0);
    let cases = [
        (["dam", "water"], vec![between(0, 2)], "an interface names unit 2, of 2 units"),
        (["dam", "water"], Vec::new(), "dam has no interface"),
        (
            ["dam", "water"],
            vec![between(0, 1), between(1, 0)],
            "dam is the first unit of an interface and the second of another",
        ),
        (["dam", "dam"], vec![between(0, 1)], "two units are called dam"),
    ];
    for (names, interfaces, expected) in cases {
        match Graph::new(units(names), interfaces) {
            Err(CouplingError::Graph { cause }) => assert_eq!(cause, expected),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("{expected} was not noticed"),
        }
    }
}
