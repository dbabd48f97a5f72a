//! Water on both faces of the dam: forces in closed form, and dams in the mirror.

use crate::support;

use cofferdam_dam::{Dam, DamError, DamParameters, Fidelity, Section};
use cofferdam_unit::{Causality, CoSimulation, Shape, Variable, variables::dam as variable};

const SPECIFIC_WEIGHT: f64 = 9810.0;
const STEP: f64 = 0.0025;

fn hydrostatic(face: Option<&cofferdam_unit::WetFace>) -> Vec<f64> {
    face.map_or(Vec::new(), |face| {
        face.points().iter().map(|p| SPECIFIC_WEIGHT * (face.depth() - p[1])).collect()
    })
}

/// A dam at rest under its weight and both waters.
fn at_rest(parameters: DamParameters) -> Result<Dam, DamError> {
    let mut dam = Dam::new(parameters)?;
    let [upstream, downstream] = [hydrostatic(dam.wet_face()), hydrostatic(dam.tailwater_face())];
    dam.set(variable::HYDROSTATIC_PRESSURE.value_reference, &upstream)?;
    dam.set(variable::TAILWATER_HYDROSTATIC_PRESSURE.value_reference, &downstream)?;
    dam.initialise(0.0)?;
    Ok(dam)
}

fn with_levels(section: Section, [water_depth, tailwater_depth]: [f64; 2]) -> DamParameters {
    DamParameters { section, water_depth, tailwater_depth, ..support::koyna(8.0) }
}

/// Horizontal: γ(h₁² − h₂²)/2. Vertical: the weight of the concrete, and of the water above the sloping face.
#[test]
fn the_base_carries_the_weight_and_the_thrust_of_both_waters() -> Result<(), DamError> {
    let [lower, upper] = [(70.0 - 19.25) / 66.5, (19.25 - 14.8) / 36.5];
    for (levels, above_slope) in [
        ([91.75, 40.0], lower * 40.0 * 40.0 / 2.0),
        ([60.0, 90.0], lower * 66.5 * (90.0 - 66.5 / 2.0) + upper * 23.5 * 23.5 / 2.0),
    ] {
        for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }, Fidelity::Intact { modes: None }] {
            let dam = at_rest(DamParameters { fidelity, ..with_levels(Section::default(), levels) })?;
            let [upstream, downstream] = levels;
            let thrust = SPECIFIC_WEIGHT * (upstream * upstream - downstream * downstream) / 2.0;
            let concrete = 2640.0 * 9.81 * dam.parameters().section.area();
            let weight = concrete + SPECIFIC_WEIGHT * above_slope;
            let found =
                [variable::BASE_SHEAR, variable::BASE_NORMAL_FORCE].map(|v| support::get(&dam, &v)[0]);
            println!("{levels:?} m, {fidelity:?}: {found:?} N/m; closed form {thrust}, {weight}");
            for (found, expected) in found.into_iter().zip([thrust, weight]) {
                assert!((found - expected).abs() < 1e-6 * weight);
            }
        }
    }
    Ok(())
}

/// Neither a shear at the base, nor one that a crack would have to carry.
#[test]
fn equal_levels_on_vertical_faces_cancel() -> Result<(), DamError> {
    let cracked = with_levels(Section::rectangle(16.0, 40.0), [32.0; 2]);
    let dam = at_rest(DamParameters { cracks: Vec::new(), ..cracked.clone() })?;
    let thrust = SPECIFIC_WEIGHT * 32.0 * 32.0 / 2.0;
    let shear = support::get(&dam, &variable::BASE_SHEAR)[0];
    println!("base shear {:.1e} of one thrust", shear / thrust);
    assert!(shear.abs() < 1e-9 * thrust);
    let crack = DamParameters { cracks: vec![support::crack_at(15.0)], ..cracked };
    let equilibrium = crack.limit_equilibria([SPECIFIC_WEIGHT; 2])?[0];
    assert!(equilibrium.sliding > 1e9, "{equilibrium:?}");
    assert!(crack.limit_equilibria([SPECIFIC_WEIGHT, 0.0])?[0].sliding < 10.0, "one water pushes");
    Ok(())
}

fn mirrored(section: &Section) -> Section {
    let width = section.downstream[0][0];
    let side = |points: &[[f64; 2]]| points.iter().map(|[x, y]| [width - x, *y]).collect();
    Section::new(side(&section.downstream), side(&section.upstream))
}

/// The variable of the face on the other side.
fn opposite(variable: &Variable) -> Variable {
    let name = match variable.name.strip_prefix("tailwater_") {
        Some(name) => name.to_owned(),
        None => format!("tailwater_{}", variable.name),
    };
    *variable::ALL.iter().find(|v| v.name == name).expect("both faces have the same variables")
}

/// A dam and the one in the mirror, with their waters exchanged and the ground and the pressures mirrored, move alike: also a
/// symmetric dam with equal levels, which is its own mirror image. What differs is rounding, which impacts at the crack
/// enlarge.
#[test]
fn a_dam_in_the_mirror_moves_as_its_image() -> Result<(), DamError> {
    let symmetric = Section::new(
        vec![[0.0, 0.0], [10.0, 40.0], [12.0, 103.0]],
        vec![[70.0, 0.0], [60.0, 40.0], [58.0, 103.0]],
    );
    for (section, levels) in [(symmetric, [80.0, 80.0]), (Section::default(), [91.75, 30.0])] {
        let parameters = with_levels(section, levels);
        let image = with_levels(mirrored(&parameters.section), [levels[1], levels[0]]);
        let mut dams = [at_rest(parameters)?, at_rest(image)?];
        let faces = [variable::INTERFACE_PRESSURE, variable::TAILWATER_INTERFACE_PRESSURE];
        for step in 0..400_u32 {
            let (time, end) = (f64::from(step) * STEP, f64::from(step + 1) * STEP);
            let a = support::bursts(end);
            for (dam, sign) in dams.iter_mut().zip([1.0, -1.0]) {
                dam.set(variable::GROUND_ACCELERATION.value_reference, &[sign * a, 0.3 * a])?;
                for (face, factor) in faces.iter().zip([-4e4, 1e4]) {
                    let of = if sign > 0.0 { *face } else { opposite(face) };
                    let pressure = vec![factor * a; dam.size(&of)];
                    dam.set(of.value_reference, &pressure)?;
                }
                dam.step(time, STEP)?;
            }
        }
        let [dam, image] = &dams;
        let points: Vec<_> = variable::ALL
            .iter()
            .filter(|v| matches!(v.shape, Shape::InterfacePoints | Shape::TailwaterPoints))
            .filter(|v| v.causality == Causality::Output)
            .collect();
        assert_eq!(points.len(), 8);
        for variable in points {
            let [here, there] = [support::get(dam, variable), support::get(image, &opposite(variable))];
            assert_eq!(here.len(), there.len());
            let largest = here.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let apart = here.iter().zip(&there).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()));
            println!("{}: {:.1e} apart, relative", variable.name, apart / largest);
            assert!(largest > 0.0 && apart < 1e-6 * largest);
        }
        for (variable, sign) in [
            (variable::BASE_SHEAR, -1.0),
            (variable::BASE_NORMAL_FORCE, 1.0),
            (variable::CRACK_SLIDING, -1.0),
            (variable::INPUT_WORK, 1.0),
            (variable::FRICTION_WORK, 1.0),
        ] {
            let [here, there] = [dam, image].map(|dam| support::get(dam, &variable)[0]);
            assert!((here - sign * there).abs() < 1e-6 * here.abs(), "{}: {here}, {there}", variable.name);
        }
    }
    Ok(())
}

/// A triangle as in `limit_equilibrium.rs`, with tailwater d above the crack on its slope m: V = γ(h² − d²)/2,
/// N = ρgbh/2 + γmd²/2; about the toe N and the tailwater's thrust hold. Tolerance: the tip is cut.
#[test]
fn tailwater_holds_what_stands_on_a_crack() -> Result<(), DamError> {
    let section = Section::new(vec![[0.0, 0.0], [0.0, 40.0]], vec![[28.0, 0.0], [0.28, 39.6], [0.28, 40.0]]);
    let dam = DamParameters {
        cracks: vec![support::crack_at(10.0)],
        element_size: 2.0,
        ..with_levels(section, [40.0, 25.0])
    };
    let (h, d, b, m) = (30.0, 15.0, 21.0, 0.7);
    let (concrete, water) = (2640.0 * 9.81 * b * h / 2.0, SPECIFIC_WEIGHT * m * d * d / 2.0);
    let [thrust, behind] = [h, d].map(|depth| SPECIFIC_WEIGHT * depth * depth / 2.0);
    let sliding = (concrete + water) / (thrust - behind);
    let holds = concrete * b * 2.0 / 3.0 + water * m * d / 3.0 + behind * d / 3.0;
    let overturning = holds / (thrust * h / 3.0);
    let found = dam.limit_equilibria([SPECIFIC_WEIGHT; 2])?[0];
    println!("{found:?}; a triangle: {sliding:.4}, {overturning:.4}");
    assert!((found.sliding / sliding - 1.0).abs() < 2e-3);
    assert!((found.overturning / overturning - 1.0).abs() < 2e-3);
    Ok(())
}

#[test]
fn without_tailwater_its_variables_are_empty_and_with_it_they_are_those_of_its_face() -> Result<(), DamError>
{
    let dry = Dam::new(support::koyna(8.0))?;
    let dam = Dam::new(with_levels(Section::default(), [91.75, 30.0]))?;
    let of_tailwater = || variable::ALL.iter().filter(|v| v.name.starts_with("tailwater_"));
    assert_eq!(of_tailwater().count(), 11);
    let face = dam.tailwater_face().expect("it has one");
    assert!((face.points()[0][0] - 70.0).abs() < 1e-12 && (face.depth() - 30.0).abs() < 1e-9);
    for variable in of_tailwater() {
        assert_eq!((dry.size(variable), dam.size(variable)), (0, face.len()), "{}", variable.name);
    }
    for wrong in [-1.0, 103.5, f64::NAN] {
        let refused = Dam::new(with_levels(Section::default(), [91.75, wrong]));
        assert!(matches!(refused, Err(DamError::WaterDepth { .. })), "{wrong}");
    }
    Ok(())
}
