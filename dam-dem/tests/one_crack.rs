//! One crack in five meshes of the same fineness, and a crack that never opens.

use cofferdam_dam::contact::{Coulomb, Integration, MohrCoulomb};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::modal::natural_frequencies;
use cofferdam_dam::{
    Block, CrackLine, CrackParameters, DamError, DamParameters, DampingCoefficients, Kinematics, Mesh,
    RayleighCoefficients, Section, Structure,
};
use cofferdam_unit::{CoSimulation, variables::dam as variable};

use crate::support::{self, Record, assembly};

/// Koyna's crack at the neck (μ = 0.3, so that the block slides and does not rock) in five meshes with seven segments a
/// crack at `size` = 5 m.
fn meshes(size: f64, integration: Integration) -> [(&'static str, DamParameters); 5] {
    const ALONG: f64 = 2.75 / 5.0;
    let sliding = |line: CrackLine, along: Option<f64>| CrackParameters {
        line,
        element_size: along,
        integration,
        ..CrackParameters::sliding(66.5, 0.3, 1e11, 0.5e11)
    };
    let dam = |crack: CrackParameters, element_size: f64| DamParameters {
        cracks: vec![crack],
        element_size,
        ..support::koyna(5.0)
    };
    let along = Some(ALONG * size);
    let level = || sliding(CrackLine::Level(66.5), along);
    let line = |points: &[[f64; 2]]| sliding(CrackLine::Polyline(points.to_vec()), along);
    let mut bent = dam(line(&[[19.25, 66.5], [0.0, 66.5]]), 1.1 * size);
    bent.section.upstream.insert(1, [0.0, 37.0]);
    [
        ("rows", dam(sliding(CrackLine::Level(66.5), None), size)),
        ("without rows", dam(level(), size)),
        ("finer beside the crack's size", dam(level(), 0.8 * size)),
        ("a point at 7 m", dam(line(&[[0.0, 66.5], [7.0, 66.5], [19.25, 66.5]]), size)),
        ("drawn upstream, a point on the face", bent),
    ]
}

/// Ground acceleration along x, m/s²: 1 g upstream, as sin² over half a second.
fn pulse(time: f64) -> f64 {
    let share = time / 0.5;
    if (0.0..1.0).contains(&share) {
        -support::GRAVITY * (std::f64::consts::PI * share).sin().powi(2)
    } else {
        0.0
    }
}

/// Slip of the block and its crest's displacement after the pulse, m.
fn pushed(parameters: DamParameters) -> Result<[f64; 2], DamError> {
    let mut dam = support::at_rest(parameters)?;
    let step = 2.5e-3;
    while dam.state().time() < 1.5 - step / 2.0 {
        let time = dam.state().time();
        dam.set(variable::GROUND_ACCELERATION.value_reference, &[pulse(time + step), 0.0])?;
        dam.step(time, step)?;
    }
    Ok([variable::CRACK_SLIDING, variable::CREST_DISPLACEMENT].map(|what| support::get(&dam, &what)[0]))
}

/// One push, no impacts: the slip of 2 m is the same to 0.1 % in every mesh, and the meshes differ the less the finer they are.
#[test]
fn five_meshes_slide_alike() -> Result<(), DamError> {
    let mut means = Vec::new();
    for integration in [Integration::Nodal, Integration::Gauss] {
        let mut found = Vec::new();
        for size in [10.0, 5.0] {
            let mut slips = Vec::new();
            for (name, parameters) in meshes(size, integration) {
                let cells = parameters.mesh()?.cells.len();
                let [slip, crest] = pushed(parameters)?;
                println!(
                    "{integration:?}, {size} m, {name}, {cells} cells: slip {slip:.5} m, crest {crest:.5} m"
                );
                slips.push(slip);
            }
            let mean = slips.iter().sum::<f64>() / 5.0;
            let spread = slips.iter().map(|slip| (slip / mean - 1.0).abs()).fold(0.0, f64::max);
            println!("{integration:?}, {size} m: mean {mean:.5} m, largest distance from it {spread:.1e}");
            found.push([mean, spread]);
        }
        let [[coarse, wide], [fine, narrow]] = found[..] else { panic!("two sizes") };
        let order = (wide / narrow).log2();
        println!(
            "{integration:?}: {:.1e} between the sizes, order of the spread {order:.1}",
            coarse / fine - 1.0
        );
        assert!(wide < 1e-3 && order > 1.0 && (coarse / fine - 1.0).abs() < 2e-3);
        means.push(fine);
    }
    assert!((means[0] / means[1] - 1.0).abs() < 1e-3, "nodes and Gauss points: {means:?} m");
    Ok(())
}

/// The mesh with its cracks welded: one block, and no seams.
fn welded(mesh: &Mesh) -> Mesh {
    let mut kept: Vec<usize> = (0..mesh.nodes.len()).collect();
    mesh.doubled_nodes().for_each(|(lower, upper)| kept[upper] = lower);
    let mut numbers = vec![usize::MAX; kept.len()];
    let mut nodes = Vec::new();
    for node in 0..kept.len() {
        if kept[node] == node {
            numbers[node] = nodes.len();
            nodes.push(mesh.nodes[node]);
        }
    }
    let number = |node: usize| numbers[kept[node]];
    let cells: Vec<[usize; 5]> = mesh.cells.iter().map(|cell| cell.map(number)).collect();
    Mesh {
        zones: Vec::new(),
        blocks: vec![Block { nodes: 0..nodes.len(), cells: 0..cells.len() }],
        seams: Vec::new(),
        upstream: mesh.upstream.iter().map(|&node| number(node)).collect(),
        downstream: mesh.downstream.iter().map(|&node| number(node)).collect(),
        base: mesh.base.iter().map(|&node| number(node)).collect(),
        ground: nodes.len()..nodes.len(),
        nodes,
        cells,
    }
}

/// A structure with stiffness damping that has a memory, so that stiff joints do not shorten its time steps.
fn damped(structure: &Structure<MohrCoulomb>, first: f64) -> (DampingCoefficients, f64) {
    let rayleigh = RayleighCoefficients::through(0.05, [first, 5.0 * first]);
    let highest = support::critical(structure, RayleighCoefficients::default()).highest_frequency;
    let memory = rayleigh.memory_reaching(0.5, highest);
    let damping = DampingCoefficients { rayleigh, memory, ..DampingCoefficients::NONE };
    (damping, 0.9 * support::critical(structure, damping).limit)
}

/// The crest's displacement without water and weight in 2 s of a shipped record, m.
fn crest(structure: &Structure<MohrCoulomb>, damping: DampingCoefficients, limit: f64) -> Vec<f64> {
    let top = support::top(&structure.mesh);
    let record = Record::read(support::RECORDS[0]);
    let (from, step) = (4.0, 5e-3);
    let steps = CentralDifference::covering(step, limit);
    let load = |time: f64| structure.weight([-record.at(time), 0.0]);
    let mut motion = structure.at_rest();
    structure.accelerate(damping, &mut motion, &load(from));
    let advance = |k: i32| {
        let [start, end] = [f64::from(k), f64::from(k + 1)].map(|k| load(from + k * step));
        let change = start.iter().zip(&end).map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        steps.advance(structure, damping, &mut motion, &LoadPath { start, change }, &mut Work::default());
        support::mean_at(&motion.displacement, &top)[0]
    };
    (0..400).map(advance).collect()
}

/// The crack is bonded, and the same mesh with its crack welded has the same time steps. The springs of the joint are as soft
/// as 0.3 m of concrete at 10¹¹ Pa/m; what they change falls as 1/k.
#[test]
fn a_crack_that_never_opens_is_no_crack() -> Result<(), DamError> {
    let section = Section::default();
    let material = support::koyna(10.0).material;
    let line = vec![[-1.0, 66.5], [71.0, 66.5]];
    let of_rows = Mesh::new(&section, &[66.5], &[], 10.0);
    let without_rows = assembly::unstructured(&section, &[line], 12.0);
    let sloping = assembly::unstructured(&section, &[vec![[0.0, 60.0], [30.0, 57.0]]], 12.0);
    for (name, mesh, integration) in [
        ("rows", of_rows.clone(), Integration::Nodal),
        ("rows", of_rows, Integration::Gauss),
        ("without rows", without_rows, Integration::Nodal),
        ("sloping", sloping, Integration::Nodal),
    ] {
        let whole = welded(&mesh);
        assert_eq!(whole.nodes.len() + mesh.doubled_nodes().count(), mesh.nodes.len());
        let base = whole.base.clone();
        let whole = Structure::new(whole, &material, Kinematics::Corotational, [], &base);
        let first = natural_frequencies(&whole, 1)?[0];
        let errors = [1e11, 1e12, 1e13].map(|stiffness| {
            let shear_stiffness = stiffness / 2.0;
            let law = MohrCoulomb {
                residual: Coulomb { friction: 1.0, normal_stiffness: stiffness, shear_stiffness },
                friction: 1.0,
                cohesion: 1e12,
                tensile_strength: 1e12,
                dilation: 0.0,
                dilation_slip: 1.0,
            };
            let base = mesh.base.clone();
            let bonded = Structure::new(
                mesh.clone(),
                &material,
                Kinematics::Corotational,
                [(law, integration)],
                &base,
            );
            let (damping, limit) = damped(&bonded, first);
            let [found, exact] = [&bonded, &whole].map(|structure| crest(structure, damping, limit));
            let apart: f64 = found.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum();
            (apart / exact.iter().map(|u| u * u).sum::<f64>()).sqrt()
        });
        let listed = errors.map(|error| format!("{error:.1e}")).join(", ");
        println!(
            "{name}, {integration:?}: crest history, relative L2, k_n = 1e11, 1e12, 1e13 Pa/m: {listed}"
        );
        assert!(errors[1] < 5e-3);
        assert!(
            (5.0..15.0).contains(&(errors[0] / errors[1])) && (5.0..15.0).contains(&(errors[1] / errors[2]))
        );
    }
    Ok(())
}
