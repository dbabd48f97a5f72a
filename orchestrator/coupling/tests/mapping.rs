//! Mapping between wet faces whose points do not match: what is exact, what is kept, how it converges.

use cofferdam_coupling::mapping::{Mapping, MappingError};
use cofferdam_unit::{WetFace, WetFaceError};
use proptest::prelude::*;

/// A straight piece of a wet face: its end, its panels, and whether the next one starts at a point of its own.
type Piece = ([f64; 2], usize, bool);

fn face(pieces: &[Piece]) -> WetFace {
    let mut points = vec![[0.0, 0.0]];
    for &(end, panels, double) in pieces {
        let start = points[points.len() - 1];
        let at = |i: usize| i as f64 / panels as f64;
        let between = (1..panels).map(|i| [0, 1].map(|axis| start[axis] * (1.0 - at(i)) + end[axis] * at(i)));
        points.extend(between);
        points.extend(std::iter::repeat_n(end, if double { 2 } else { 1 }));
    }
    WetFace::new(points).expect("the pieces make a face")
}

const KINK: [f64; 2] = [4.0, 30.0];
const CRACK: [f64; 2] = [4.0, 55.0];
const LEVEL: [f64; 2] = [4.0, 90.0];

/// A dam battered up to a kink, with a crack above it, as the built-in dam gives it: two points at both.
fn cracked_dam(panels: [usize; 3]) -> WetFace {
    face(&[(KINK, panels[0], true), (CRACK, panels[1], true), (LEVEL, panels[2], false)])
}

/// Pairs of a dam's and a reservoir's face: finer, coarser and incommensurate, double points on one side or on both.
fn pairs() -> Vec<(WetFace, WetFace)> {
    let dam = || cracked_dam([3, 4, 5]);
    let straight = |panels| WetFace::straight([0.0, 90.0], panels).expect("a straight face");
    vec![
        (straight(6), straight(12)),
        (straight(12), straight(6)),
        (straight(7), straight(11)),
        (straight(1), straight(13)),
        (straight(13), straight(1)),
        (dam(), cracked_dam([6, 8, 10])),
        (dam(), cracked_dam([1, 1, 1])),
        (dam(), cracked_dam([5, 3, 7])),
        // No double points in the reservoir, and no point at all where the crack is.
        (dam(), face(&[(KINK, 2, false), (CRACK, 3, false), (LEVEL, 6, false)])),
        (dam(), face(&[(KINK, 4, true), (LEVEL, 7, false)])),
        (dam(), face(&[(KINK, 1, false), (LEVEL, 1, false)])),
        // A double point in the reservoir alone.
        (face(&[(KINK, 3, true), (LEVEL, 5, false)]), cracked_dam([2, 3, 4])),
        (dam(), dam().respaced(3.3).expect("a length of a panel")),
        (dam(), dam().respaced(21.0).expect("a length of a panel")),
    ]
}

fn to_reservoir(mapping: &Mapping, [_, reservoir]: [&WetFace; 2], motion: &[f64]) -> Vec<f64> {
    let mut mapped = vec![f64::NAN; reservoir.len()];
    mapping.forward(motion, &mut mapped);
    mapped
}

fn to_dam(mapping: &Mapping, [dam, _]: [&WetFace; 2], pressure: &[f64]) -> Vec<f64> {
    let mut mapped = vec![f64::NAN; dam.len()];
    mapping.adjoint(pressure, &mut mapped);
    mapped
}

fn sampled(face: &WetFace, field: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
    face.points().iter().map(|point| field(*point)).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn constant_and_linear_fields_pass_exactly_both_ways() -> Result<(), MappingError> {
    let mut worst = 0.0f64;
    for (dam, reservoir) in pairs() {
        let mapping = Mapping::between(["dam", "reservoir"], &dam, &reservoir)?;
        let faces = [&dam, &reservoir];
        // Of the order of 1 all of them; the third is the hydrostatic pressure.
        let fields: [fn([f64; 2]) -> f64; 4] =
            [|_| 1.0, |p| p[1] / 90.0, |p| 1.0 - p[1] / 90.0, |p| 0.3 * p[0] - 0.01 * p[1] + 0.2];
        for field in fields {
            let (on_dam, on_reservoir) = (sampled(&dam, field), sampled(&reservoir, field));
            let motion = to_reservoir(&mapping, faces, &on_dam);
            let pressure = to_dam(&mapping, faces, &on_reservoir);
            worst = worst.max(largest_difference(&motion, &on_reservoir));
            worst = worst.max(largest_difference(&pressure, &on_dam));
        }
    }
    println!("constant and linear fields: {worst:.1e}");
    // Some hundred additions of rounding 1e-16.
    assert!(worst < 1e-13, "{worst:e}");
    Ok(())
}

#[test]
fn a_jump_where_both_have_two_points_passes_exactly() -> Result<(), MappingError> {
    let (dam, reservoir) = (cracked_dam([3, 4, 5]), cracked_dam([4, 3, 7]));
    let mapping = Mapping::between(["dam", "reservoir"], &dam, &reservoir)?;
    // The block above the crack slides; each piece of the face has a normal of its own.
    let stepped = |face: &WetFace| -> Vec<f64> {
        let pieces = face.straight_pieces();
        let value = |k: usize, y: f64| [1.0, 0.97, -3.0][k] + [0.02, 0.01, 0.05][k] * y;
        let on = |(k, piece): (usize, &[usize; 2])| -> Vec<f64> {
            face.points()[piece[0]..=piece[1]].iter().map(|p| value(k, p[1])).collect()
        };
        pieces.iter().enumerate().flat_map(on).collect()
    };
    let faces = [&dam, &reservoir];
    let motion = to_reservoir(&mapping, faces, &stepped(&dam));
    let pressure = to_dam(&mapping, faces, &stepped(&reservoir));
    assert!(largest_difference(&motion, &stepped(&reservoir)) < 1e-13, "{motion:?}");
    assert!(largest_difference(&pressure, &stepped(&dam)) < 1e-13, "{pressure:?}");
    Ok(())
}

#[test]
fn a_finer_face_takes_a_field_as_it_is() -> Result<(), MappingError> {
    // Every field of the coarse face is one of the fine face too, which has its points.
    let (coarse, fine) = (cracked_dam([2, 3, 4]), cracked_dam([4, 9, 8]));
    let field: Vec<f64> = (0..coarse.len()).map(|i| (1.7 * i as f64).sin()).collect();
    let interpolated: Vec<f64> = (0..coarse.straight_pieces().len())
        .flat_map(|k| {
            let ([a, b], [c, d]) = (coarse.straight_pieces()[k], fine.straight_pieces()[k]);
            let finer = (d - c) / (b - a);
            let field = &field;
            (0..=d - c).map(move |i| {
                let (panel, part) = ((i / finer).min(b - a - 1), (i - (i / finer).min(b - a - 1) * finer));
                let t = part as f64 / finer as f64;
                field[a + panel] * (1.0 - t) + field[a + panel + 1] * t
            })
        })
        .collect();
    let pressure = to_dam(&Mapping::between(["dam", "reservoir"], &fine, &coarse)?, [&fine, &coarse], &field);
    let motion =
        to_reservoir(&Mapping::between(["dam", "reservoir"], &coarse, &fine)?, [&coarse, &fine], &field);
    assert!(largest_difference(&pressure, &interpolated) < 1e-13);
    assert!(largest_difference(&motion, &interpolated) < 1e-13);
    Ok(())
}

#[test]
fn matching_points_are_copied_bit_for_bit() -> Result<(), MappingError> {
    let dam = cracked_dam([3, 4, 5]);
    let moved: Vec<[f64; 2]> = dam.points().iter().map(|p| [p[0], p[1] * (1.0 + 1e-12)]).collect();
    let nearly = WetFace::new(moved).expect("points ascend");
    let awkward = [-0.0, f64::MIN_POSITIVE / 8.0, 1e300, 1.0 / 3.0, f64::NAN];
    let field: Vec<f64> = (0..dam.len()).map(|i| awkward[i % 5]).collect();
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for reservoir in [&dam, &nearly] {
        let mapping = Mapping::between(["dam", "reservoir"], &dam, reservoir)?;
        assert!(mapping.is_identity());
        assert_eq!(bits(&to_reservoir(&mapping, [&dam, reservoir], &field)), bits(&field));
        assert_eq!(bits(&to_dam(&mapping, [&dam, reservoir], &field)), bits(&field));
        assert_eq!(mapping.work_error(&field, &field), 0.0);
    }
    assert!(!Mapping::between(["dam", "reservoir"], &dam, &cracked_dam([3, 4, 6]))?.is_identity());
    assert_eq!(
        Mapping::between(["dam", "reservoir"], &dam, &cracked_dam([4, 4, 5]))?
            .work_error(&[0.0; 16], &[0.0; 15]),
        0.0,
        "nothing does no work"
    );
    Ok(())
}

/// Force along x and y and moment about the heel of the nodal forces, and the sums of their terms' magnitudes.
fn resultants(face: &WetFace, pressure: &[f64]) -> ([f64; 3], [f64; 3]) {
    let forces = face.nodal_forces(pressure);
    let mut sums = ([0.0; 3], [0.0; 3]);
    for ([fx, fy], [x, y]) in forces.iter().zip(face.points()) {
        for (k, term) in [*fx, *fy, fx * y - fy * x].into_iter().enumerate() {
            sums.0[k] += term;
            sums.1[k] += term.abs();
        }
    }
    sums
}

/// Panels of three pieces, and whether there are two points at the two ends between them.
fn divisions() -> impl Strategy<Value = ([usize; 3], [bool; 2])> {
    (prop::array::uniform3(1usize..12), prop::array::uniform2(any::<bool>()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn force_moment_and_work_are_kept(
        dam_panels in prop::array::uniform3(1usize..12),
        crack in any::<bool>(),
        (panels, double) in divisions(),
        values in prop::collection::vec(-1e6..1e6f64, 80),
    ) {
        // The dam's kink has two points, so that its normal is a field of the dam.
        let [a, b, c] = dam_panels;
        let dam = face(&[(KINK, a, true), (CRACK, b, crack), (LEVEL, c, false)]);
        let [d, e, f] = panels;
        let reservoir = face(&[(KINK, d, double[0]), (CRACK, e, double[1]), (LEVEL, f, false)]);
        let mapping = Mapping::between(["dam", "reservoir"], &dam, &reservoir)?;
        let pressure = &values[..reservoir.len()];
        let velocity = &values[40..40 + dam.len()];
        let mapped = to_dam(&mapping, [&dam, &reservoir], pressure);
        let (given, magnitudes) = resultants(&reservoir, pressure);
        let (taken, _) = resultants(&dam, &mapped);
        for k in 0..3 {
            // A hundred terms or so, rounded to 1e-16 each.
            prop_assert!((given[k] - taken[k]).abs() < 1e-13 * magnitudes[k], "{k}: {given:?} {taken:?}");
        }
        if crack {
            let above = |face: &WetFace, p: &[f64]| -> f64 {
                let panels = face.panels().filter(|panel| face.points()[panel.start][1] >= CRACK[1]);
                panels.map(|panel| panel.length * (p[panel.start] + p[panel.start + 1]) / 2.0).sum()
            };
            let (given, taken) = (above(&reservoir, pressure), above(&dam, &mapped));
            prop_assert!((given - taken).abs() < 1e-13 * magnitudes[0], "above the crack {given} {taken}");
        }
        let error = mapping.work_error(pressure, velocity);
        prop_assert!(error < 1e-14, "{error:e}");
    }
}

/// `∫ p v ds` of two fields on one face, by Simpson's rule, which is exact on a panel.
fn work(face: &WetFace, p: &[f64], v: &[f64]) -> f64 {
    let on = |panel: cofferdam_unit::Panel| {
        let (i, j) = (panel.start, panel.start + 1);
        panel.length / 6.0 * (p[i] * v[i] + (p[i] + p[j]) * (v[i] + v[j]) + p[j] * v[j])
    };
    face.panels().map(on).sum()
}

#[test]
fn the_work_error_is_that_of_the_work_on_either_face() -> Result<(), MappingError> {
    for (dam, reservoir) in pairs() {
        let mapping = Mapping::between(["dam", "reservoir"], &dam, &reservoir)?;
        let pressure: Vec<f64> = (0..reservoir.len()).map(|i| 1e5 * (2.3 * i as f64).cos()).collect();
        let velocity: Vec<f64> = (0..dam.len()).map(|i| (0.9 * i as f64).sin() + 0.1).collect();
        let on_dam = work(&dam, &to_dam(&mapping, [&dam, &reservoir], &pressure), &velocity);
        let on_reservoir =
            work(&reservoir, &pressure, &to_reservoir(&mapping, [&dam, &reservoir], &velocity));
        let magnitude = 1e5 * 90.0;
        assert!((on_dam - on_reservoir).abs() < 1e-14 * magnitude, "{on_dam} {on_reservoir}");
        assert!(mapping.work_error(&pressure, &velocity) < 1e-14);
    }
    Ok(())
}

#[test]
fn a_smooth_field_converges_with_order_2() -> Result<(), MappingError> {
    let field = |[x, y]: [f64; 2]| (0.05 * y + 0.1 * x).sin();
    let errors = |n: usize| -> Result<[f64; 2], MappingError> {
        // Incommensurate, with a crack in the dam alone.
        let dam = cracked_dam([3 * n, 3 * n, 4 * n]);
        let reservoir = face(&[(KINK, 2 * n, false), (LEVEL, 5 * n, false)]);
        let mapping = Mapping::between(["dam", "reservoir"], &dam, &reservoir)?;
        let faces = [&dam, &reservoir];
        let motion = to_reservoir(&mapping, faces, &sampled(&dam, field));
        let pressure = to_dam(&mapping, faces, &sampled(&reservoir, field));
        Ok([
            largest_difference(&motion, &sampled(&reservoir, field)),
            largest_difference(&pressure, &sampled(&dam, field)),
        ])
    };
    let measured = [2, 4, 8, 16].map(errors);
    let mut coarser: Option<[f64; 2]> = None;
    for errors in measured {
        let errors = errors?;
        if let Some(coarser) = coarser {
            let orders = [0, 1].map(|k| (coarser[k] / errors[k]).log2());
            println!(
                "motion {:.2e}, order {:.2}; pressure {:.2e}, order {:.2}",
                errors[0], orders[0], errors[1], orders[1]
            );
            assert!(orders.iter().all(|order| (1.9..2.2).contains(order)), "{orders:?}");
        }
        coarser = Some(errors);
    }
    Ok(())
}

#[test]
fn faces_that_are_not_the_same_polygon_are_refused() -> Result<(), WetFaceError> {
    let dam = cracked_dam([3, 4, 5]);
    let lower = WetFace::new(vec![[0.0, 0.0], KINK, [4.0, 89.0]])?;
    let cutting = WetFace::new(vec![[0.0, 0.0], LEVEL])?;
    let bulging = WetFace::new(vec![[0.0, 0.0], KINK, [4.25, 60.0], LEVEL])?;
    let short = WetFace::new(vec![[0.0, 0.0], KINK, [4.0, 60.0], [4.0, 60.0 + 5e-5], LEVEL])?;
    let said = |dam: &WetFace, reservoir: &WetFace| {
        Mapping::between(["dam", "reservoir"], dam, reservoir).expect_err("the faces are refused").to_string()
    };
    assert_eq!(
        said(&dam, &lower),
        "the wet face ends at (4, 90) in the dam and at (4, 89) in the reservoir; both need the same end, at one level"
    );
    assert_eq!(
        said(&dam, &bulging),
        "point 2 of the reservoir's wet face, (4.25, 60), lies 2.500e-1 m beside the dam's; 9e-5 m are the most, so give \
         both the same outline"
    );
    // The kink lies 4·60/√(4² + 90²) m beside the line from heel to water level.
    let error = Mapping::between(["dam", "reservoir"], &dam, &cutting).expect_err("a kink is cut off");
    let MappingError::Apart { unit, other, index: 4, x: 4.0, y: 30.0, distance, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!([unit, other], ["dam", "reservoir"]);
    assert!((distance - 4.0 * 60.0 / 4f64.hypot(90.0)).abs() < 1e-13, "{distance}");
    assert!(said(&cutting, &dam).contains("of the reservoir's wet face, "), "{}", said(&cutting, &dam));
    assert!(
        said(&dam, &short)
            .starts_with("the panel above point 2 of the reservoir's wet face, (4, 60), is 5.000e-5 m"),
        "{}",
        said(&dam, &short)
    );
    assert!(
        said(&short, &dam)
            .starts_with("the panel above point 2 of the dam's wet face, (4, 60), is 5.000e-5 m")
    );
    Ok(())
}

#[test]
fn faces_that_agree_within_the_tolerance_pass_constants_exactly() -> Result<(), MappingError> {
    // As from a file with seven digits.
    let dam = cracked_dam([3, 4, 5]);
    let rounded = |face: WetFace| {
        let points = face.points().iter().map(|p| p.map(|x| (x * 1e4).round() / 1e4)).collect();
        WetFace::new(points).expect("points ascend")
    };
    let reservoir = rounded(cracked_dam([7, 6, 11]));
    let mapping = Mapping::between(["dam", "reservoir"], &dam, &reservoir)?;
    let faces = [&dam, &reservoir];
    let motion = to_reservoir(&mapping, faces, &vec![1.0; dam.len()]);
    let pressure = to_dam(&mapping, faces, &vec![1.0; reservoir.len()]);
    assert!(motion.iter().chain(&pressure).all(|one| (one - 1.0).abs() < 1e-13));
    Ok(())
}
