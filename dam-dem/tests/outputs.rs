//! Outputs on which the coupling relies, and forces and stresses, against statics, elements and contacts.

use crate::support;

use cofferdam_dam::{CrackParameters, Dam, DamError, DamMotion, DamParameters, Fidelity, Material, Section};
use cofferdam_unit::{CoSimulation, variables::dam as variable};
use support::{GRAVITY, at_rest, bursts, get, hydrostatic, koyna, shake, stiff, with_water};

/// Force of the element stresses on the base, without damping, N/m.
fn elastic_base_force(dam: &Dam) -> [f64; 2] {
    let DamMotion::Nodes(motion) = dam.state().motion() else { return [f64::NAN; 2] };
    let structure = dam.structure();
    let mut forces = vec![[0.0; 2]; dam.node_count()];
    structure.cells.add_forces(&motion.displacement, &motion.velocity, 0.0, &mut [], &mut forces);
    let base = &structure.mesh.base;
    [0, 1].map(|d| base.iter().map(|&node| forces[node][d]).sum())
}

fn mass_of(dam: &Dam, nodes: std::ops::Range<usize>) -> f64 {
    nodes.map(|node| dam.structure().mass[node]).sum()
}

/// Forces of weight and hydrostatic pressure on the ground and across the crack.
#[test]
fn forces_at_rest_are_those_of_statics() -> Result<(), DamError> {
    for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }] {
        let dam = at_rest(DamParameters { fidelity, ..koyna(5.0) })?;
        let (all, above) = (0..dam.node_count(), dam.structure().mesh.blocks[1].nodes.clone());
        let thrust = |from: f64| 0.5 * 9810.0 * (91.75 - from) * (91.75 - from);
        let expected = [
            (variable::BASE_SHEAR, thrust(0.0)),
            (variable::BASE_NORMAL_FORCE, GRAVITY * mass_of(&dam, all)),
            (variable::CRACK_NORMAL_FORCE, GRAVITY * mass_of(&dam, above)),
            (variable::CRACK_SHEAR_FORCE, thrust(66.5)),
        ];
        for (variable, exact) in expected {
            let error = get(&dam, &variable)[0] / exact - 1.0;
            println!("{fidelity:?}: {} at rest {error:.1e}", variable.name);
            // normal and tangential to the sides, which are slightly inclined
            assert!(
                error.abs() < if variable.name.starts_with("base") { 1e-12 } else { 1e-3 },
                "{}",
                variable.name
            );
        }
        let [normal, shear] = [2, 3].map(|i| expected[i].1);
        let utilisation = get(&dam, &variable::CRACK_SHEAR_UTILISATION)[0];
        assert!((utilisation - shear / normal).abs() < 1e-3, "friction coefficient 1: {utilisation}");
    }
    Ok(())
}

/// The base force from the momentum balance against that from the element stresses at the base, an
/// independent computation. The latter belongs to one instant and does not include damping.
#[test]
fn the_base_carries_what_its_elements_do() -> Result<(), DamError> {
    let undamped = DamParameters { damping: cofferdam_dam::Damping::None, ..koyna(5.0) };
    for (name, parameters) in [("alone", undamped.clone()), ("with added mass", with_water(undamped))] {
        let mut dam = at_rest(parameters)?;
        let (step, mut worst, mut peak) = (2e-4, 0.0f64, 0.0f64);
        let mut before = elastic_base_force(&dam);
        while dam.state().time() < 1.0 {
            let until = dam.state().time() + step;
            shake(&mut dam, step, until, bursts)?;
            let now = elastic_base_force(&dam);
            // forces on fixed nodes act directly on the ground
            let base = &dam.structure().mesh.base;
            let mass: f64 = base.iter().map(|&node| dam.structure().mass[node]).sum();
            let a = (bursts(until - step) + bursts(until)) / 2.0;
            let mut pressure = hydrostatic(&dam);
            let accelerations = get(&dam, &variable::INTERFACE_ACCELERATION);
            for (row, p) in dam.parameters().added_mass.iter().flatten().zip(&mut pressure) {
                *p -= row.iter().zip(&accelerations).map(|(mass, a)| mass * a).sum::<f64>();
            }
            let water = dam.wet_face().map_or([0.0; 2], |face| face.nodal_forces(&pressure)[0]);
            let own = [water[0] - mass * a, water[1] - mass * (0.5 * a + GRAVITY)];
            let found = [get(&dam, &variable::BASE_SHEAR)[0], -get(&dam, &variable::BASE_NORMAL_FORCE)[0]];
            for d in 0..2 {
                let expected = (before[d] + now[d]) / 2.0 + own[d];
                worst = worst.max((found[d] - expected).abs());
                peak = peak.max(found[d].abs());
            }
            before = now;
        }
        println!("base force, {name}: {:.1e} of its peak of {:.1} MN/m", worst / peak, peak / 1e6);
        assert!(worst < 5e-3 * peak, "{name}");
    }
    Ok(())
}

/// Modes give the same forces and stresses until contacts open; later differences come from impacts.
#[test]
fn reduced_blocks_give_the_forces_of_the_full_model() -> Result<(), DamError> {
    let run = |fidelity| -> Result<Vec<[f64; 5]>, DamError> {
        let mut dam = at_rest(DamParameters { fidelity, ..with_water(koyna(10.0)) })?;
        let mut rows = Vec::new();
        for step in 1..=60 {
            shake(&mut dam, 5e-3, 5e-3 * f64::from(step), bursts)?;
            let value = |variable| get(&dam, variable)[0];
            let stress = get(&dam, &variable::MINOR_PRINCIPAL_STRESS);
            rows.push([
                value(&variable::BASE_SHEAR),
                value(&variable::CRACK_NORMAL_FORCE),
                value(&variable::CRACK_SHEAR_FORCE),
                stress[1],
                value(&variable::SMALLEST_PRINCIPAL_STRESS),
            ]);
        }
        Ok(rows)
    };
    let [full, reduced] = [run(Fidelity::Dem)?, run(Fidelity::Reduced { modes: None })?];
    let names = [
        "base shear",
        "normal force of the crack",
        "shear force of the crack",
        "stress at the toe",
        "largest compression",
    ];
    for (i, name) in names.into_iter().enumerate() {
        let norm = |rows: &mut dyn Iterator<Item = f64>| rows.map(|x| x * x).sum::<f64>().sqrt();
        let mean = full.iter().map(|row| row[i]).sum::<f64>() / full.len() as f64;
        let size = norm(&mut full.iter().map(|row| row[i] - mean));
        let error = norm(&mut full.iter().zip(&reduced).map(|(a, b)| a[i] - b[i])) / size;
        println!("{name}: reduced against full {error:.1e}");
        assert!(error < 2e-3, "{name}");
    }
    Ok(())
}

/// A column under its own weight, with Poisson's ratio 0: σ = −ρ g (H − y), exact at the middle of every row.
#[test]
fn a_column_is_pressed_by_what_stands_on_it() -> Result<(), DamError> {
    let (height, rows) = (30.0, 30);
    let crack = CrackParameters::sliding(10.0, 0.5, 1e11, 1e11);
    let material: Material = stiff(30e9);
    let dam = at_rest(DamParameters {
        section: Section::rectangle(3.0, height),
        water_depth: 0.0,
        cracks: vec![crack],
        material,
        element_size: height / f64::from(rows),
        ..koyna(5.0)
    })?;
    let y = get(&dam, &variable::NODE_Y);
    let corners = [variable::TRIANGLE_NODE_1, variable::TRIANGLE_NODE_2, variable::TRIANGLE_NODE_3];
    let corners = corners.map(|corner| get(&dam, &corner));
    let [across, along, shear] =
        [variable::STRESS_XX, variable::STRESS_YY, variable::STRESS_XY].map(|s| get(&dam, &s));
    let mut means = vec![0.0; rows as usize];
    for triangle in 0..along.len() {
        let centroid = corners.iter().map(|c| y[c[triangle] as usize]).sum::<f64>() / 3.0;
        means[centroid as usize] += along[triangle] / (4.0 * 3.0);
        assert!(across[triangle].abs() + shear[triangle].abs() < 0.02 * 2500.0 * GRAVITY * height);
    }
    for (row, mean) in means.iter().enumerate() {
        let exact = -2500.0 * GRAVITY * (height - row as f64 - 0.5);
        assert!((mean - exact).abs() < 1e-5 * 2500.0 * GRAVITY * height, "row {row}: {mean} Pa, {exact} Pa");
    }
    let pressed = get(&dam, &variable::CONTACT_NORMAL_STRESS);
    let (contacts, x) = (pressed.len(), get(&dam, &variable::CONTACT_X));
    assert_eq!((contacts, x.len()), (8, 8));
    let exact = 2500.0 * GRAVITY * 20.0;
    for (stress, opening) in pressed.iter().zip(get(&dam, &variable::CONTACT_OPENING)) {
        assert!((stress / exact - 1.0).abs() < 0.03, "{stress} Pa, {exact} Pa");
        assert!((stress + 1e11 * opening).abs() < 1e-6 * exact);
    }
    let slips = get(&dam, &variable::CONTACT_SLIP);
    assert!(slips.iter().all(|slip| slip.abs() < 1e-6), "{slips:?}");
    Ok(())
}

/// The open share of a joint without tension under a rigid block of width b and height h, which a constant acceleration a
/// presses on its downstream edge: the stress is linear over the part that touches, so that with e = (a/g′) h/2 > b/6 the
/// open share is 1 − 3 (1/2 − e/b). Tolerance: the length of a contact, b/32.
#[test]
fn open_share_is_that_of_a_joint_without_tension() -> Result<(), DamError> {
    let (height, width) = (6.0, 4.0);
    let parameters = DamParameters {
        section: Section::rectangle(width, height + 2.0),
        water_depth: 0.0,
        cracks: vec![CrackParameters::sliding(2.0, 2.0, 1e10, 1e10)],
        element_size: width / 32.0,
        fidelity: Fidelity::RigidBlocks,
        ..koyna(5.0)
    };
    let mut dam = at_rest(parameters)?;
    assert_eq!(get(&dam, &variable::CRACK_OPEN_SHARE), [0.0], "closed at rest");
    assert!(get(&dam, &variable::CRACK_MOMENT)[0].abs() < 1e-6 * get(&dam, &variable::CRACK_NORMAL_FORCE)[0]);
    // Upstream, and half of it downwards, as `shake` has it.
    let mut at = 0.0;
    for acceleration in [2.0, 3.0] {
        shake(&mut dam, 1e-3, at + 4.0, |t| -(acceleration - 1.0 + ((t - at) / 2.0).min(1.0)))?;
        at += 4.0;
        let eccentricity = acceleration / (GRAVITY - acceleration / 2.0) * height / 2.0;
        let exact = 1.0 - 3.0 * (0.5 - eccentricity / width);
        let open = get(&dam, &variable::CRACK_OPEN_SHARE)[0];
        println!("{acceleration} m/s²: {open:.3} of the joint is open, exactly {exact:.3}");
        assert!((open - exact).abs() < 1.0 / 32.0, "{open}, exactly {exact}");
        let [moment, normal] =
            [variable::CRACK_MOMENT, variable::CRACK_NORMAL_FORCE].map(|output| get(&dam, &output)[0]);
        println!(
            "    its resultant is {:.4} m from the middle, exactly {eccentricity:.4} m",
            moment / normal
        );
        assert!((moment / normal - eccentricity).abs() < 5e-3, "{}", moment / normal);
    }
    Ok(())
}

/// A sliding block with dilation: slip of the contacts on both sides, and their stresses at the strength.
#[test]
fn contacts_of_either_side_slip_downstream_at_their_strength() -> Result<(), DamError> {
    let crack = CrackParameters { dilation: 0.2, ..CrackParameters::sliding(2.0, 0.3, 1e10, 1e10) };
    let parameters = DamParameters {
        section: Section::rectangle(8.0, 4.0),
        water_depth: 0.0,
        cracks: vec![crack],
        element_size: 1.0,
        ..koyna(5.0)
    };
    let mut dam = at_rest(parameters)?;
    // the ground accelerates upstream, so that the block slides downstream relative to it
    shake(&mut dam, 1e-3, 0.25, |_| -6.0)?;
    let [sliding, normal, shear, utilisation] = [
        variable::CRACK_SLIDING,
        variable::CRACK_NORMAL_FORCE,
        variable::CRACK_SHEAR_FORCE,
        variable::CRACK_SHEAR_UTILISATION,
    ]
    .map(|variable| get(&dam, &variable)[0]);
    println!(
        "sliding {sliding:.4} m; {shear:.4e} N/m under {normal:.4e} N/m, {utilisation:.6} of the strength"
    );
    assert!(sliding > 0.01 && (utilisation - 1.0).abs() < 1e-9, "{sliding} m, {utilisation}");
    assert!((shear / normal - 0.3).abs() < 1e-9, "{shear} N/m, {normal} N/m");
    let slips = get(&dam, &variable::CONTACT_SLIP);
    assert!(slips.iter().all(|slip| (slip / sliding - 1.0).abs() < 0.02), "{slips:?}");
    let stresses = [variable::CONTACT_NORMAL_STRESS, variable::CONTACT_SHEAR_STRESS].map(|v| get(&dam, &v));
    for (normal, shear) in stresses[0].iter().zip(&stresses[1]) {
        assert!((shear - 0.3 * normal).abs() < 1e-9 * 1e6, "{shear} Pa, {normal} Pa");
    }
    Ok(())
}

/// `interface_acceleration` is the mean total acceleration along n: the change of velocity over the step
/// length, plus the mean acceleration of the ground. At the fixed heel it is that of the ground alone.
/// Tolerance: rounding.
#[test]
fn interface_acceleration_is_the_mean_of_the_total_motion() -> Result<(), DamError> {
    let mut dam = support::at_rest(support::koyna(7.0))?;
    support::shake(&mut dam, 2.5e-3, 0.3, support::bursts)?;
    let (step, ground) = (4e-3, [support::bursts(0.3), 2.5]);
    let before = support::get(&dam, &variable::INTERFACE_VELOCITY);
    let position = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    dam.set(variable::GROUND_ACCELERATION.value_reference, &[ground[1], 0.0])?;
    dam.step(dam.state().time(), step)?;
    let after = support::get(&dam, &variable::INTERFACE_VELOCITY);
    let acceleration = support::get(&dam, &variable::INTERFACE_ACCELERATION);
    let mean_ground = (ground[0] + ground[1]) / 2.0;
    let mut error = 0.0f64;
    for i in 0..after.len() {
        error = error.max((acceleration[i] - (after[i] - before[i]) / step - mean_ground).abs());
    }
    println!("interface acceleration against the change of velocity: {error:.1e} m/s²");
    assert!(error < 1e-9 && (acceleration[0] - mean_ground).abs() < 1e-12);

    let moved = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    let top = after.len() - 1;
    let trapezoid = position[top] + step * (before[top] + after[top]) / 2.0;
    println!("displacement against the trapezoid of velocity: {:.1e} m", moved[top] - trapezoid);
    assert!((moved[top] - trapezoid).abs() < 1e-2 * step * (before[top].abs() + after[top].abs()));
    Ok(())
}

/// Pressure pushes the dam downstream, along n.
#[test]
fn pressure_pushes_downstream() -> Result<(), DamError> {
    let mut dam = support::at_rest(support::koyna(10.0))?;
    let pressure = vec![1e4; dam.wet_face().map_or(0, |face| face.len())];
    dam.set(variable::INTERFACE_PRESSURE.value_reference, &pressure)?;
    for _ in 0..10 {
        dam.step(dam.state().time(), 2.5e-3)?;
    }
    let face = support::get(&dam, &variable::INTERFACE_DISPLACEMENT);
    let crest = support::get(&dam, &variable::CREST_DISPLACEMENT)[0];
    println!("10 kPa for 25 ms: crest {crest:.1e} m");
    assert!(face.iter().all(|&u| u >= 0.0) && crest > 0.0);
    assert!(support::get(&dam, &variable::INPUT_WORK)[0] > 0.0);
    Ok(())
}

/// The resultant in a joint that a gallery interrupts acts where that of weight and water does: the moments of both parts count about
/// the middle of the whole joint.
#[test]
fn resultant_of_a_joint_with_a_gallery_is_that_of_statics() -> Result<(), DamError> {
    for galleries in [vec![], vec![vec![[2.0, 6.0], [2.0, 8.0], [4.0, 8.0], [4.0, 6.0]]]] {
        let parameters = DamParameters {
            section: Section { galleries: galleries.clone(), ..Section::rectangle(12.0, 20.0) },
            water_depth: 15.0,
            cracks: vec![CrackParameters::sliding(7.0, 1.0, 1e10, 1e10)],
            element_size: 0.5,
            ..koyna(5.0)
        };
        let dam = at_rest(parameters)?;
        let above = dam.structure().mesh.blocks[1].nodes.clone();
        let weight = GRAVITY * mass_of(&dam, above.clone());
        let arms = above
            .map(|node| GRAVITY * dam.structure().mass[node] * (dam.structure().mesh.nodes[node][0] - 6.0));
        let thrust = 0.5 * 9810.0 * 8.0 * 8.0;
        let exact = arms.sum::<f64>() + thrust * 8.0 / 3.0;
        let [moment, normal] =
            [variable::CRACK_MOMENT, variable::CRACK_NORMAL_FORCE].map(|output| get(&dam, &output)[0]);
        println!(
            "{} galleries: moment {moment:.1} ({exact:.1}), {normal:.1} ({weight:.1}) N",
            galleries.len()
        );
        assert!((moment / exact - 1.0).abs() < 2e-3, "{moment}, exactly {exact}");
        assert!((normal / weight - 1.0).abs() < 1e-3);
    }
    Ok(())
}

/// A bonded joint under a block that is pulled upstream loses its bond where the tension passes its strength, and for good.
#[test]
fn bonded_share_falls_where_bonds_break() -> Result<(), DamError> {
    let joint = CrackParameters {
        cohesion: 1e6,
        tensile_strength: 5e4,
        ..CrackParameters::sliding(2.0, 1.0, 1e10, 1e10)
    };
    let parameters = DamParameters {
        section: Section::rectangle(4.0, 8.0),
        water_depth: 0.0,
        cracks: vec![joint],
        element_size: 0.25,
        fidelity: Fidelity::RigidBlocks,
        ..koyna(5.0)
    };
    let mut dam = at_rest(parameters.clone())?;
    assert_eq!(get(&dam, &variable::CRACK_BONDED_SHARE), [1.0]);
    shake(&mut dam, 1e-3, 2.0, |t| -3.5 * t.min(1.0))?;
    let broken = get(&dam, &variable::CRACK_BONDED_SHARE)[0];
    shake(&mut dam, 1e-3, 4.0, |t| -3.5 * (3.0 - t).max(0.0))?;
    let [after, open] =
        [variable::CRACK_BONDED_SHARE, variable::CRACK_OPEN_SHARE].map(|output| get(&dam, &output)[0]);
    println!("bonded {broken:.3} under the push, {after:.3} after it, open {open:.3}");
    assert!((0.2..0.95).contains(&broken) && after == broken && open < 1e-6);
    let unbonded =
        DamParameters { cracks: vec![CrackParameters::sliding(2.0, 1.0, 1e10, 1e10)], ..parameters };
    assert_eq!(at_rest(unbonded)?.size(&variable::CRACK_BONDED_SHARE), 0, "no output without bonds");
    Ok(())
}
