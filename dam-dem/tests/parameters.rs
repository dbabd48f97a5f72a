//! Every invalid parameter gives its own error.

use crate::support;

use cofferdam_dam::{
    CrackLine, CrackParameters, Dam, DamError, DamParameters, Damping, DampingFrequencies, Feature,
    GeometryError,
};

fn error(change: impl Fn(&mut DamParameters)) -> DamError {
    let mut parameters = support::koyna(10.0);
    change(&mut parameters);
    let Err(error) = Dam::new(parameters) else { panic!("an invalid parameter was accepted") };
    println!("{error}");
    error
}

fn rayleigh(ratio: f64, frequencies: [f64; 2]) -> Damping {
    Damping::Rayleigh { ratio, frequencies: DampingFrequencies::RadiansPerSecond(frequencies) }
}

#[test]
fn bad_sections_are_refused() {
    let geometry = |change: &dyn Fn(&mut DamParameters)| match error(change) {
        DamError::Geometry(error) => error,
        error => panic!("{error}"),
    };
    let few = geometry(&|p| p.section.upstream.truncate(1));
    assert!(matches!(few, GeometryError::TooFewPoints { feature: Feature::Upstream, found: 1, .. }));
    let low = geometry(&|p| p.section.downstream[2][1] = -1.0);
    assert!(matches!(low, GeometryError::BelowBase { feature: Feature::Downstream, index: 2, .. }), "{low}");
    let shifted = geometry(&|p| p.section.upstream[0] = [1.0, 0.0]);
    assert!(matches!(shifted, GeometryError::HeelNotAtOrigin { .. }));
    let crossing = geometry(&|p| p.section.downstream[1][0] = -3.0);
    assert!(matches!(crossing, GeometryError::OutlineCrosses { .. }), "{crossing}");
    let dangling = geometry(&|p| p.cracks[0].line = CrackLine::Polyline(vec![[-1.0, 50.0], [9.0, 50.0]]));
    assert!(matches!(dangling, GeometryError::CrackEndsInside { crack: 0, .. }), "{dangling}");
    let mut cut = support::koyna(10.0);
    cut.section.galleries = vec![vec![[4.0, 10.0], [8.0, 10.0], [80.0, 14.0]]];
    let keys = cut.problems().remove(0).keys;
    assert_eq!(keys[0], "section.galleries.0");
}

#[test]
fn bad_water_and_cracks_are_refused() {
    for depth in [-1.0, 103.5, f64::NAN] {
        assert!(matches!(error(|p| p.water_depth = depth), DamError::WaterDepth { .. }));
    }
    for elevation in [1e-5, 103.0, -4.0, f64::NAN] {
        assert!(matches!(
            error(|p| p.cracks[0].line = CrackLine::Level(elevation)),
            DamError::CrackOutside { .. }
        ));
    }
    assert!(matches!(error(|p| p.cracks.push(p.cracks[0].clone())), DamError::DuplicateCrack { .. }));
}

#[test]
fn values_out_of_range_are_refused() {
    let crack = |change: fn(&mut CrackParameters)| error(|p| change(&mut p.cracks[0]));
    let cases: [(DamError, &str); 17] = [
        (crack(|c| c.friction_coefficient = -0.1), "friction_coefficient"),
        (crack(|c| c.normal_stiffness = 0.0), "normal_stiffness"),
        (crack(|c| c.shear_stiffness = f64::INFINITY), "shear_stiffness"),
        (error(|p| p.material.young_modulus = 0.0), "young_modulus"),
        (error(|p| p.material.poisson_ratio = 0.5), "poisson_ratio"),
        (error(|p| p.material.poisson_ratio = -1.0), "poisson_ratio"),
        (error(|p| p.material.density = -1.0), "density"),
        (error(|p| p.element_size = 0.0), "element_size"),
        (error(|p| p.element_size = f64::NAN), "element_size"),
        (error(|p| p.gravity = -9.81), "gravity"),
        (error(|p| p.time_step_safety = 0.0), "time_step_safety"),
        (error(|p| p.time_step_safety = 1.1), "time_step_safety"),
        (error(|p| p.damping = rayleigh(0.0, [1.0, 2.0])), "damping ratio"),
        (error(|p| p.damping = rayleigh(1.0, [1.0, 2.0])), "damping ratio"),
        (error(|p| p.damping = rayleigh(0.05, [0.0, 2.0])), "lower damping frequency"),
        (error(|p| p.damping = rayleigh(0.05, [2.0, 2.0])), "upper damping frequency"),
        (error(|p| p.damping = rayleigh(0.05, [2.0, f64::NAN])), "upper damping frequency"),
    ];
    for (error, name) in cases {
        assert!(matches!(error, DamError::OutOfRange { parameter, .. } if parameter == name), "{name}");
    }
}

#[test]
fn too_many_frequencies_are_refused() -> Result<(), DamError> {
    let dam = Dam::new(support::koyna(20.0))?;
    assert!(matches!(dam.natural_frequencies(10_000), Err(DamError::TooManyFrequencies { .. })));
    Ok(())
}

/// Where no row of elements ends at the water's level, and a vertex lies too close to it for a point of its own.
#[test]
fn water_that_the_mesh_would_lower_is_refused() {
    let sloping = CrackParameters {
        line: CrackLine::Polyline(vec![[-1.0, 60.0], [80.0, 50.0]]),
        ..support::crack_at(60.0)
    };
    let at =
        |water_depth| DamParameters { water_depth, cracks: vec![sloping.clone()], ..support::koyna(3.0) };
    for depth in [103.0, 102.0, 91.75] {
        assert_eq!(at(depth).check(), Ok(()), "{depth}");
        let face = at(depth).wet_face().expect("a face").expect("water");
        assert!((face.depth() - depth).abs() < 1e-9);
    }
    let error = at(102.9).check().expect_err("the crest is too near").to_string();
    assert!(error.contains("102.9 m deep") && error.contains("`element_size`"), "{error}");
}
