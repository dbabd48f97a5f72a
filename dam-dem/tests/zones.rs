//! Zones of other materials: identity with one material, layers in closed form, masses of polygons, energy.

use crate::support;

use cofferdam_dam::analytical::layered_column::{self, Layer};
use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::integrator::SparseNewton;
use cofferdam_dam::modal::{self, DegreesOfFreedom};
use cofferdam_dam::{
    Dam, DamError, DamParameters, Fidelity, Geometry, GeometryError, Kinematics, Material, Materials, Mesh,
    Plane, Section, StressRecovery, Structure, ZoneParameters,
};
use cofferdam_unit::{Packable, variables::dam as variable};
use support::GRAVITY;

fn zone(
    name: &str,
    polygon: &[[f64; 2]],
    young_modulus: f64,
    poisson_ratio: f64,
    density: f64,
) -> ZoneParameters {
    ZoneParameters {
        name: name.to_owned(),
        polygon: polygon.to_vec(),
        young_modulus: Some(young_modulus),
        poisson_ratio: Some(poisson_ratio),
        density: Some(density),
        ..Default::default()
    }
}

fn rectangle([left, bottom]: [f64; 2], [right, top]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[left, bottom], [right, bottom], [right, top], [left, top]]
}

fn meshed(section: &Section, zones: &[Vec<[f64; 2]>], element_size: f64) -> Mesh {
    Mesh::of_section(&Geometry {
        upstream: &section.upstream,
        downstream: &section.downstream,
        galleries: &section.galleries,
        cracks: &[],
        zones,
        upstream_levels: &[],
        downstream_levels: &[],
        element_size,
        crack_sizes: &[],
    })
    .expect("the section is meshed")
}

fn structure(mesh: Mesh, materials: impl Into<Materials>, kinematics: Kinematics) -> Structure {
    let none: [(Coulomb, Integration); 0] = [];
    let base = mesh.base.clone();
    Structure::new(mesh, materials, kinematics, none, &base)
}

/// Koyna with a soft facing and a heavy core.
fn zoned(element_size: f64) -> DamParameters {
    let facing = zone("facing", &rectangle([0.0, 0.0], [7.0, 103.0]), 18e9, 0.25, 2300.0);
    let core = zone("core", &[[20.0, 0.0], [45.0, 0.0], [30.0, 30.0], [20.0, 30.0]], 40e9, 0.15, 3000.0);
    DamParameters { zones: vec![facing, core], ..support::koyna(element_size) }
}

/// Some displacement or velocity of every node.
fn some(mesh: &Mesh, seed: f64) -> Vec<[f64; 2]> {
    mesh.nodes.iter().map(|[x, y]| [1e-3 * (seed * x - y).sin(), 1e-3 * (x + seed * y).cos()]).collect()
}

/// Zones of the dam's own material change no bit of forces, masses and energies on the same mesh.
#[test]
fn zones_of_the_same_material_are_no_zones() -> Result<(), DamError> {
    let mesh = zoned(6.0).mesh()?;
    assert!(mesh.zones.contains(&Some(0)) && mesh.zones.contains(&Some(1)) && mesh.zones.contains(&None));
    for kinematics in [Kinematics::Small, Kinematics::Corotational] {
        let whole = structure(mesh.clone(), &Material::default(), kinematics);
        let same = Materials { general: Material::default(), of_zones: vec![Material::default(); 2] };
        let zoned = structure(mesh.clone(), same, kinematics);
        assert_eq!(zoned.mass, whole.mass);
        let (u, v) = (some(&mesh, 0.7), some(&mesh, 1.3));
        let forces = |structure: &Structure| {
            let (mut viscous, mut forces) = (structure.cells.viscous_at_rest(), vec![[0.0; 2]; u.len()]);
            let power = structure.cells.add_forces(&u, &v, 1e-3, &mut viscous, &mut forces);
            (power, forces, structure.cells.strain_energy(&u))
        };
        assert_eq!(forces(&zoned), forces(&whole));
    }
    Ok(())
}

/// A zone around the whole dam is the dam's material: no bit differs in frequencies, states of rest, runs and factors of
/// safety, at every level of fidelity.
#[test]
fn a_zone_around_the_dam_is_its_material() -> Result<(), DamError> {
    let material = Material {
        young_modulus: 22e9,
        poisson_ratio: 0.25,
        density: 2450.0,
        plane: Plane::Strain,
        ..Default::default()
    };
    let mut whole = DamParameters { material, ..support::koyna(10.0) };
    // not in rows
    whole.cracks[0].element_size = Some(6.0);
    let around = rectangle([-9.0, -9.0], [99.0, 199.0]);
    let zones = vec![zone("all", &around, 22e9, 0.25, 2450.0)];
    let general = Material { plane: Plane::Strain, ..Default::default() };
    let zoned = DamParameters { material: general, zones, ..whole.clone() };
    for fidelity in [
        Fidelity::Dem,
        Fidelity::Reduced { modes: None },
        Fidelity::RigidBlocks,
        Fidelity::Intact { modes: None },
    ] {
        let run = |parameters: &DamParameters| -> Result<_, DamError> {
            let wet = support::with_water(DamParameters { fidelity, ..parameters.clone() });
            let frequencies = wet.natural_modes(3)?.frequencies;
            let factors = wet.limit_equilibria([9810.0, 0.0])?;
            let mut dam = support::at_rest(wet)?;
            support::shake(&mut dam, 2.5e-3, 0.3, support::bursts)?;
            let results = [
                &variable::CREST_STATIC_DISPLACEMENT,
                &variable::CREST_DISPLACEMENT,
                &variable::KINETIC_ENERGY,
                &variable::STRAIN_ENERGY,
                &variable::MAJOR_PRINCIPAL_STRESS,
                &variable::STRESS_XX,
                &variable::BASE_NORMAL_FORCE,
            ];
            let results: Vec<_> = results.map(|variable| support::get(&dam, variable)).into();
            Ok((frequencies, factors, dam.critical_time_step(), dam.damping_coefficients(), results))
        };
        let (of_zone, of_dam) = (run(&zoned)?, run(&whole)?);
        assert_eq!(of_zone, of_dam, "{fidelity:?}");
    }
    Ok(())
}

/// The vector kernel and the assembled stiffness agree, on any number of threads.
#[test]
fn forces_are_those_of_the_assembled_stiffness() -> Result<(), DamError> {
    let parameters = zoned(0.7);
    let mesh = parameters.mesh()?;
    let one = structure(mesh.clone(), parameters.materials(), Kinematics::Small);
    let two = one.clone().on_threads(2.try_into().expect("not 0"))?;
    let u = some(&mesh, 0.4);
    let [mut forces, mut threaded] = [0, 1].map(|_| vec![[0.0; 2]; u.len()]);
    one.cells.add_linear_forces(&u, &mut forces);
    two.cells.add_linear_forces(&u, &mut threaded);
    assert_eq!(forces, threaded);
    let largest = forces.as_flattened().iter().fold(0.0f64, |most, f| most.max(f.abs()));
    for (triangle, (nodes, area, gradients)) in one.cells.triangles().enumerate() {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let block = one.cells.stiffness_block(triangle, gradients[i], gradients[j]);
            let [x, y] = u[nodes[j]];
            (0..2).for_each(|d| forces[nodes[i]][d] += area * (block[d][0] * x + block[d][1] * y));
        }
    }
    let left = forces.as_flattened().iter().fold(0.0f64, |most, f| most.max(f.abs()));
    println!("{} triangles: {left:e} of {largest:e} N/m", one.cells.triangle_count());
    assert!(one.cells.triangle_count() > 20_000 && left < 1e-12 * largest);
    Ok(())
}

const LAYERS: [Layer; 2] = [
    Layer { height: 6.0, young_modulus: 31e9, density: 2640.0 },
    Layer { height: 4.0, young_modulus: 9e9, density: 2000.0 },
];
const WIDTH: f64 = 5.0;

/// The layers as a column, in an unstructured mesh.
fn column(element_size: f64, plane: Plane) -> Structure {
    let material = |layer: Layer| Material {
        young_modulus: layer.young_modulus,
        poisson_ratio: 0.0,
        density: layer.density,
        plane,
        ..Default::default()
    };
    let [lower, upper] = LAYERS;
    let height = lower.height + upper.height;
    let above = rectangle([-1.0, lower.height], [WIDTH + 1.0, height + 1.0]);
    let mesh = meshed(&Section::rectangle(WIDTH, height), &[above], element_size);
    let materials = Materials { general: material(lower), of_zones: vec![material(upper)] };
    structure(mesh, materials, Kinematics::Small)
}

/// Relative error of the settlement at every node, at most, under weight and a pressure on top.
fn settlement_error(element_size: f64, plane: Plane, gravity: f64, pressure: f64) -> Result<f64, DamError> {
    let structure = column(element_size, plane);
    let mut loads = structure.weight([0.0, -gravity]);
    let mut top = support::top(&structure.mesh);
    top.sort_by(|&a, &b| structure.mesh.nodes[a][0].total_cmp(&structure.mesh.nodes[b][0]));
    for (&node, length) in top.iter().zip(structure.mesh.tributary_lengths(&top)) {
        loads[node][1] -= pressure * length;
    }
    let mut motion = structure.at_rest();
    SparseNewton { tolerance: 1e-13, max_iterations: 10 }.relax(&structure, &mut motion, &loads)?;
    let settlement = |y: f64| layered_column::settlement(LAYERS, gravity, pressure, y);
    let errors = structure.mesh.nodes.iter().zip(&motion.displacement).map(|([_, y], [u, v])| {
        let exact = settlement(*y);
        u.abs().max((v + exact).abs())
    });
    Ok(errors.fold(0.0, f64::max) / settlement(LAYERS[0].height + LAYERS[1].height))
}

/// The strain of a weightless column jumps where the material does, along edges of the mesh: exact to rounding.
#[test]
fn a_column_of_two_layers_under_pressure_is_exact() -> Result<(), DamError> {
    for plane in [Plane::Stress, Plane::Strain] {
        for size in [1.7, 0.6] {
            let error = settlement_error(size, plane, 0.0, 1e6)?;
            println!("{plane:?}, {size} m: {error:e}");
            assert!(error < 1e-11, "{error:e}");
        }
    }
    Ok(())
}

/// Under its weight the settlement is quadratic in each layer: second order.
#[test]
fn a_column_of_two_layers_settles_under_its_weight() -> Result<(), DamError> {
    let errors: Vec<f64> = [1.6, 0.8, 0.4]
        .into_iter()
        .map(|size| settlement_error(size, Plane::Stress, GRAVITY, 0.0))
        .collect::<Result<_, _>>()?;
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("settlement: {errors:?}, order {order:.2}");
    assert!(order > 1.7 && errors[2] < 2e-3);
    Ok(())
}

/// The lowest frequency along the column against the root of its transcendental equation: second order.
#[test]
fn a_column_of_two_layers_vibrates_with_the_root_of_its_equation() -> Result<(), DamError> {
    let exact = layered_column::first_frequency(LAYERS);
    let mut errors = Vec::new();
    for size in [2.0, 1.0, 0.5] {
        let structure = column(size, Plane::Stress);
        let dofs = DegreesOfFreedom::intact(&structure);
        let factors = modal::factor(&modal::stiffness(&structure, &dofs), dofs.count)?;
        let masses = dofs.masses(&structure);
        let (frequencies, modes) = modal::natural_modes(&factors, &masses, 6, 1e-11)?;
        // of all modes the one that has most of the mass that moves along the column
        let share = |mode: usize| {
            let upward = (1..masses.len()).step_by(2);
            upward.map(|i| masses[i] * modes[(i, mode)]).sum::<f64>().powi(2)
        };
        let along = (0..6).max_by(|&a, &b| share(a).total_cmp(&share(b))).expect("six modes");
        errors.push((frequencies[along] / exact - 1.0).abs());
    }
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("{exact:.3} rad/s: {errors:?}, order {order:.2}");
    assert!(order > 1.7 && errors[2] < 2e-3);
    Ok(())
}

/// Layers of one material are a bar of `π/2 √(E/ρ)/h`.
#[test]
fn the_equation_of_layers_has_the_root_of_a_bar() {
    let layer = |height| Layer { height, ..LAYERS[0] };
    let velocity = (LAYERS[0].young_modulus / LAYERS[0].density).sqrt();
    for height in [1.0, 5.0, 9.0] {
        let found = layered_column::first_frequency([layer(height), layer(10.0 - height)]);
        assert!((found / (std::f64::consts::FRAC_PI_2 * velocity / 10.0) - 1.0).abs() < 1e-14);
    }
}

/// Recovered stresses jump between zones: a uniform strain gives E ε in each, at the nodes between them both.
#[test]
fn recovered_stresses_jump_between_zones() {
    let mesh = meshed(&Section::rectangle(8.0, 10.0), &[rectangle([0.0, 0.0], [3.0, 10.0])], 1.0);
    let [soft, stiff] =
        [8e9, 32e9].map(|e| Material { young_modulus: e, poisson_ratio: 0.0, ..Default::default() });
    let materials = Materials { general: stiff, of_zones: vec![soft] };
    let structure = structure(mesh, materials, Kinematics::Small);
    let displacement: Vec<[f64; 2]> = structure.mesh.nodes.iter().map(|[_, y]| [0.0, -1e-4 * y]).collect();
    let recovery = StressRecovery::new(&structure.mesh);
    let stresses = recovery.stresses(&structure.cells, &displacement, Kinematics::Small);
    let mut between = 0;
    for (&node, [xx, yy, xy]) in recovery.nodes().iter().zip(stresses) {
        let x = structure.mesh.nodes[node][0];
        let here = recovery.nodes().iter().filter(|other| **other == node).count();
        assert_eq!(here, if x == 3.0 { 2 } else { 1 });
        let expected: &[f64] = if x == 3.0 {
            &[-8e5, -32e5]
        } else if x < 3.0 {
            &[-8e5]
        } else {
            &[-32e5]
        };
        assert!(expected.iter().any(|e| (yy / e - 1.0).abs() < 1e-10) && xx.abs().max(xy.abs()) < 1e-3);
        between += usize::from(x == 3.0 && (yy / -8e5 - 1.0).abs() < 1e-10);
    }
    assert!(between >= 9, "{between} nodes between the zones have the stress of the soft one");
}

/// Area, first moments and polar second moment about the origin of a polygon, counter-clockwise, by Green's theorem (C. Steger,
/// *On the calculation of arbitrary moments of polygons*, 1996).
fn moments(polygon: &[[f64; 2]]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (&[x, y], &[p, q]) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let cross = x * q - p * y;
        sum[0] += cross / 2.0;
        sum[1] += cross * (x + p) / 6.0;
        sum[2] += cross * (y + q) / 6.0;
        sum[3] += cross * (x * x + x * p + p * p + y * y + y * q + q * q) / 12.0;
    }
    sum
}

/// Mass, centre of mass and moment of inertia of a dam with zones: those of polygons. The first two are exact; lumped masses
/// have the moment of inertia to second order.
#[test]
fn masses_are_those_of_polygons() -> Result<(), DamError> {
    let section = Section::default();
    let mut outline = section.upstream.clone();
    outline.reverse();
    let outline: Vec<[f64; 2]> = [&section.downstream[..], &outline].concat();
    let mut errors = Vec::new();
    for size in [8.0, 4.0, 2.0, 1.0] {
        let dam = DamParameters { cracks: Vec::new(), ..zoned(size) };
        let mut exact = moments(&outline).map(|moment| 2640.0 * moment);
        for (zone, density) in dam.zones.iter().zip([2300.0, 3000.0]) {
            for (sum, moment) in exact.iter_mut().zip(moments(&zone.polygon)) {
                *sum += (density - 2640.0) * moment;
            }
        }
        let structure = structure(dam.mesh()?, dam.materials(), Kinematics::Small);
        let sum = |of: fn([f64; 2]) -> f64| -> f64 {
            structure.mass.iter().zip(&structure.mesh.nodes).map(|(mass, node)| mass * of(*node)).sum()
        };
        let found = [sum(|_| 1.0), sum(|[x, _]| x), sum(|[_, y]| y), sum(|[x, y]| x * x + y * y)];
        for moment in 0..3 {
            assert!((found[moment] / exact[moment] - 1.0).abs() < 1e-12, "{found:?} of {exact:?}");
        }
        errors.push((found[3] / exact[3] - 1.0).abs());
    }
    let order = (errors[0] / errors[3]).log2() / 3.0;
    println!("moment of inertia: {errors:?}, order {order:.2}");
    assert!(order > 1.5 && errors[3] < 2e-4);
    Ok(())
}

/// A block of two zones on a crack: its weight in the factor of safety, and its acceleration when it is rigid and slides
/// without friction, are those of its mass.
#[test]
fn a_block_weighs_what_its_zones_do() -> Result<(), DamError> {
    let section = Section::rectangle(20.0, 30.0);
    let heavy = zone("heavy", &[[-1.0, 20.0], [12.0, 20.0], [12.0, 31.0], [-1.0, 31.0]], 31e9, 0.2, 4000.0);
    let mut crack = support::crack_at(10.0);
    crack.friction_coefficient = 0.8;
    let dam = DamParameters {
        section,
        water_depth: 30.0,
        cracks: vec![crack],
        zones: vec![heavy],
        fidelity: Fidelity::RigidBlocks,
        ..support::koyna(4.0)
    };
    let mass = 20.0 * 20.0 * 2640.0 + 12.0 * 10.0 * (4000.0 - 2640.0);
    let thrust = 9810.0 * 20.0 * 20.0 / 2.0;
    let found = dam.limit_equilibria([9810.0, 0.0])?[0];
    assert!((found.sliding / (0.8 * mass * 9.81 / thrust) - 1.0).abs() < 1e-10, "{found:?}");
    // moments about the toe of the block
    let lever = (400.0 * 2640.0 * 10.0 + 120.0 * 1360.0 * 14.0) * 9.81;
    assert!((found.overturning / (lever / (thrust * 20.0 / 3.0)) - 1.0).abs() < 1e-10, "{found:?}");
    let base = support::get(&support::at_rest(dam)?, &variable::CRACK_NORMAL_FORCE)[0];
    assert!((base / (mass * 9.81) - 1.0).abs() < 1e-6, "{base}");
    Ok(())
}

/// Largest error of the energy balance over the peak kinetic energy, and the slip, after bursts of 0.5 g.
fn ledger(parameters: DamParameters) -> Result<[f64; 2], DamError> {
    let mut dam = support::at_rest(parameters)?;
    let (mut peak, mut worst) = (0.0f64, 0.0f64);
    while dam.state().time() < 2.0 {
        let until = dam.state().time() + 2.5e-3;
        support::shake(&mut dam, 2.5e-3, until, support::bursts)?;
        peak = peak.max(support::get(&dam, &variable::KINETIC_ENERGY)[0]);
        worst = worst.max(support::get(&dam, &variable::ENERGY_BALANCE_ERROR)[0].abs());
    }
    Ok([worst / peak, support::get(&dam, &variable::CRACK_SLIDING)[0]])
}

/// With zones the ledger closes as well as without, on the kind of mesh that zones have, and the better the shorter the time step.
#[test]
fn the_ledger_closes_with_zones() -> Result<(), DamError> {
    for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }, Fidelity::RigidBlocks] {
        let mut plain = DamParameters { fidelity, ..support::koyna(8.0) };
        plain.cracks[0].element_size = Some(8.0);
        let zoned = DamParameters { fidelity, ..zoned(8.0) };
        let finer = |dam: &DamParameters| DamParameters { time_step_safety: 0.05, ..dam.clone() };
        let [error, slip] = ledger(zoned.clone())?;
        let [[without, _], [finer, _], [finer_without, _]] =
            [ledger(plain.clone())?, ledger(finer(&zoned))?, ledger(finer(&plain))?];
        println!(
            "{fidelity:?}: slip {slip:.4} m, balance error {error:.2e}, without zones {without:.2e}; \
             in short time steps {finer:.2e}, {finer_without:.2e}"
        );
        // Two meshes move in two ways: a tenth more, which goes with the time step.
        assert!(slip.abs() > 1e-3 && error < 1.1 * without.max(3e-3));
        assert!(finer < error / 4.0 && finer < finer_without.max(1e-4));
    }
    Ok(())
}

/// Values of a zone that are wrong, with their keys; the dam's own are named once.
#[test]
fn wrong_zones_are_named() {
    let keys = |change: fn(&mut DamParameters)| {
        let mut dam = zoned(10.0);
        change(&mut dam);
        dam.problems().into_iter().map(|problem| (problem.keys, problem.error)).collect::<Vec<_>>()
    };
    assert!(keys(|_| ()).is_empty());
    let found = keys(|dam| dam.zones[1].young_modulus = Some(-1.0));
    assert_eq!(found[0].0, ["zones.1.young_modulus"]);
    let found = keys(|dam| dam.zones[0].poisson_ratio = Some(0.5));
    assert_eq!(found[0].0, ["zones.0.poisson_ratio"]);
    let found = keys(|dam| {
        dam.material.density = 0.0;
        dam.zones[0].density = None;
    });
    assert!(found.iter().all(|(keys, _)| keys == &["material.density"]) && !found.is_empty(), "{found:?}");
    let found = keys(|dam| dam.zones[1].polygon = rectangle([90.0, 0.0], [99.0, 9.0]));
    assert_eq!(found[0].0, ["zones.1.polygon"]);
    assert!(matches!(found[0].1, DamError::Geometry(GeometryError::EmptyZone { zone: 1 })));
    let found = keys(|dam| dam.zones[0].polygon.truncate(2));
    assert_eq!(found[0].0, ["zones.0.polygon"]);
}

/// What an importer sets of the dam's material holds where a zone has none of its own.
#[test]
fn a_zone_takes_what_it_does_not_have_from_the_dam() -> Result<(), DamError> {
    let mut parameters = zoned(10.0);
    parameters.zones[0].density = None;
    let numbers = Dam::numbers(&mut parameters, &variable::DENSITY);
    numbers.into_iter().for_each(|density| *density = 2500.0);
    let dam = support::at_rest(parameters)?;
    let densities: Vec<f64> = dam.parameters().materials().of_zones.iter().map(|zone| zone.density).collect();
    assert_eq!(densities, [2500.0, 3000.0]);
    let weight = support::get(&dam, &variable::BASE_NORMAL_FORCE)[0];
    let mass: f64 = dam.structure().mass.iter().sum();
    println!("{weight} N/m, {} N/m", mass * 9.81);
    assert!((weight / (mass * 9.81) - 1.0).abs() < 1e-3);
    Ok(())
}
