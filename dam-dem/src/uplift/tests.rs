use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};

use super::*;

const GAMMA: f64 = 9810.0;

/// Horizontal joint at elevation 0.
fn base(length: f64, levels: [f64; 2]) -> JointWater {
    JointWater::new([[0.0, 0.0], [length, 0.0]], levels, [GAMMA; 2])
}

fn drained(position: f64, efficiency: f64, gallery_elevation: Option<f64>) -> Uplift {
    Uplift { drains: Some(Drains { position, efficiency, gallery_elevation }), ..Uplift::default() }
}

fn with_profile(profile: &[[f64; 2]]) -> Uplift {
    Uplift { profile: Some(profile.to_vec()), ..Uplift::default() }
}

fn assert_line(found: &[[f64; 2]], expected: &[[f64; 2]]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found} {expected}");
    }
}

#[test]
fn words_are_those_of_the_serialised_form() {
    for rule in UpliftRule::ALL {
        let word: StrDeserializer<'_, Error> = rule.word().into_deserializer();
        assert_eq!(UpliftRule::deserialize(word), Ok(rule));
        assert!(!rule.label().is_empty() && !rule.source().is_empty());
    }
    assert_eq!(Uplift::default().rule, UpliftRule::Unchanged);
}

#[test]
fn pressure_without_drains_is_linear() {
    let water = base(80.0, [100.0, 20.0]);
    let line = water.nodes(&Uplift::default(), [0.0; 2]);
    assert_line(&line, &[[0.0, 981e3], [80.0, 196.2e3]]);
    assert!((water.pressure(&Uplift::default(), [0.0; 2], 20.0) - 784.8e3).abs() < 1e-6);
    assert!((force(&line) - 80.0 * (981e3 + 196.2e3) / 2.0).abs() < 1e-4);
}

/// H3 = H2 + (1 − E)(H1 − H2)(L − x)/L: 29.7 m for case A3 of the check cases, 45 m for A3b.
#[test]
fn drains_reduce_the_head_by_their_efficiency() {
    let water = base(80.0, [100.0, 0.0]);
    for (efficiency, head) in [(0.0, 90.0), (0.5, 45.0), (0.67, 29.7), (1.0, 0.0)] {
        let line = water.nodes(&drained(8.0, efficiency, None), [0.0; 2]);
        assert_line(&line, &[[0.0, 981e3], [8.0, head * GAMMA], [80.0, 0.0]]);
    }
    // with tailwater: 20 + 0.33 · 80 · 0.9
    let line = base(80.0, [100.0, 20.0]).nodes(&drained(8.0, 0.67, None), [0.0; 2]);
    assert_line(&line, &[[0.0, 981e3], [8.0, 43.76 * GAMMA], [80.0, 196.2e3]]);
}

#[test]
fn gallery_above_the_tailwater_takes_its_place() {
    let water = base(80.0, [100.0, 20.0]);
    let head = |gallery| water.pressure(&drained(8.0, 0.67, Some(gallery)), [0.0; 2], 8.0) / GAMMA;
    // 30 + 0.33 · 70 · 0.9
    assert!((head(30.0) - 50.79).abs() < 1e-12);
    assert!((head(20.0) - 43.76).abs() < 1e-12);
    assert!((head(-5.0) - 43.76).abs() < 1e-12);
    // not above the reservoir
    assert!((head(130.0) - 100.0).abs() < 1e-12);
    // the pressure at the toe remains that of the tailwater
    assert_eq!(water.pressure(&drained(8.0, 0.67, Some(30.0)), [0.0; 2], 80.0), 20.0 * GAMMA);
}

#[test]
fn higher_tailwater_is_drained_towards_the_reservoir() {
    let mirrored = base(80.0, [20.0, 100.0]).nodes(&drained(72.0, 0.67, None), [0.0; 2]);
    assert_line(&mirrored, &[[0.0, 196.2e3], [72.0, 43.76 * GAMMA], [80.0, 981e3]]);
}

#[test]
fn crack_that_ends_before_the_drains_has_full_pressure() {
    let line = base(80.0, [100.0, 20.0]).nodes(&drained(8.0, 0.67, None), [5.0, 0.0]);
    assert_line(&line, &[[0.0, 981e3], [5.0, 981e3], [8.0, 43.76 * GAMMA], [80.0, 196.2e3]]);
}

#[test]
fn crack_that_reaches_the_drains_puts_them_out_of_service() {
    let water = base(80.0, [100.0, 20.0]);
    for crack in [8.0, 10.0] {
        let line = water.nodes(&drained(8.0, 0.67, None), [crack, 0.0]);
        assert_line(&line, &[[0.0, 981e3], [crack, 981e3], [80.0, 196.2e3]]);
    }
}

#[test]
fn crack_through_the_joint_has_the_pressure_of_the_reservoir() {
    let water = base(80.0, [100.0, 20.0]);
    for crack in [80.0, 90.0] {
        let line = water.nodes(&drained(8.0, 0.67, None), [crack, 0.0]);
        assert_line(&line, &[[0.0, 981e3], [80.0, 981e3]]);
        assert_eq!(water.pressure(&Uplift::default(), [crack, 0.0], 80.0), 981e3);
    }
}

#[test]
fn crack_from_downstream_has_the_pressure_of_the_tailwater() {
    let water = base(80.0, [100.0, 20.0]);
    let line = water.nodes(&Uplift::default(), [0.0, 30.0]);
    assert_line(&line, &[[0.0, 981e3], [50.0, 196.2e3], [80.0, 196.2e3]]);
    // cracks that meet: a jump
    let line = water.nodes(&Uplift::default(), [40.0, 50.0]);
    assert_line(&line, &[[0.0, 981e3], [40.0, 981e3], [40.0, 196.2e3], [80.0, 196.2e3]]);
}

#[test]
fn profile_is_followed_from_the_next_point_beyond_a_crack() {
    let water = base(80.0, [100.0, 20.0]);
    let uplift = with_profile(&[[0.0, 900e3], [10.0, 500e3], [60.0, 100e3]]);
    let line = water.nodes(&uplift, [0.0; 2]);
    assert_line(&line, &[[0.0, 900e3], [10.0, 500e3], [60.0, 100e3], [80.0, 100e3]]);
    let line = water.nodes(&uplift, [4.0, 0.0]);
    assert_line(&line, &[[0.0, 981e3], [4.0, 981e3], [10.0, 500e3], [60.0, 100e3], [80.0, 100e3]]);
    let line = water.nodes(&uplift, [4.0, 30.0]);
    assert_line(&line, &[[0.0, 981e3], [4.0, 981e3], [10.0, 500e3], [50.0, 196.2e3], [80.0, 196.2e3]]);
    // a profile up to the downstream end
    let line = water.nodes(&with_profile(&[[0.0, 900e3], [80.0, 50e3]]), [0.0; 2]);
    assert_line(&line, &[[0.0, 900e3], [80.0, 50e3]]);
}

#[test]
fn water_below_an_end_of_the_joint_exerts_no_pressure_there() {
    let lift = JointWater::new([[0.0, 66.5], [19.25, 66.5]], [91.75, 20.0], [GAMMA; 2]);
    assert_line(&lift.nodes(&Uplift::default(), [0.0; 2]), &[[0.0, 25.25 * GAMMA], [19.25, 0.0]]);
    let dry = JointWater { levels: [10.0, 20.0], ..lift };
    assert_line(&dry.nodes(&drained(2.0, 0.5, None), [5.0, 0.0]), &[[0.0, 0.0], [5.0, 0.0], [19.25, 0.0]]);
}

/// A joint of 50 m that falls by 14 m: total head, not pressure, is linear; at the drains it is
/// 30 + (1 − 0.5)(64 − 30)(40/50) = 43.6 m, at an elevation of −2.8 m.
#[test]
fn total_head_is_linear_along_a_sloping_joint() {
    let water = JointWater::new([[0.0, 0.0], [48.0, -14.0]], [64.0, 30.0], [GAMMA; 2]);
    assert_eq!(water.length, 50.0);
    assert!((water.elevation(10.0) + 2.8).abs() < 1e-12);
    let line = water.nodes(&drained(10.0, 0.5, None), [0.0; 2]);
    assert_line(&line, &[[0.0, 64.0 * GAMMA], [10.0, 46.4 * GAMMA], [50.0, 44.0 * GAMMA]]);
    let line = water.nodes(&drained(10.0, 0.5, None), [20.0, 0.0]);
    assert_line(&line, &[[0.0, 64.0 * GAMMA], [20.0, 69.6 * GAMMA], [50.0, 44.0 * GAMMA]]);
}

/// Rises by 30 m over 50 m. The reservoir stands at 20 m, the tailwater below the toe: the head falls from 20
/// m to the toe's elevation of 30 m, which the joint never lies below.
#[test]
fn pressure_is_never_negative() {
    let water = JointWater::new([[0.0, 0.0], [40.0, 30.0]], [20.0, 5.0], [GAMMA; 2]);
    // head 20 + 0.2 x, elevation 0.6 x
    assert_line(&water.nodes(&Uplift::default(), [0.0; 2]), &[[0.0, 20.0 * GAMMA], [50.0, 0.0]]);
    // with the head of the reservoir in a crack of 40 m, at its level 33.333 m along the joint
    let line = water.nodes(&Uplift::default(), [40.0, 0.0]);
    assert_line(&line, &[[0.0, 20.0 * GAMMA], [100.0 / 3.0, 0.0], [40.0, 0.0], [50.0, 0.0]]);
}

/// Joints whose drains, or the tip of whose crack, lie above the head that the formula gives there.
#[test]
fn head_does_not_fall_below_the_joint() {
    // falls by 30 m over 50 m; perfect drains at −6 m, water downstream below the toe
    let falling = JointWater::new([[0.0, 0.0], [40.0, -30.0]], [20.0, -40.0], [GAMMA; 2]);
    let line = falling.nodes(&drained(10.0, 1.0, None), [0.0; 2]);
    assert_line(&line, &[[0.0, 20.0 * GAMMA], [10.0, 0.0], [50.0, 0.0]]);
    // rises by 30 m over 50 m; the reservoir stands 4 m below the tip, the tailwater 6 m above the toe
    let rising = JointWater::new([[0.0, 0.0], [40.0, 30.0]], [20.0, 36.0], [GAMMA; 2]);
    let line = rising.nodes(&Uplift::default(), [40.0, 0.0]);
    assert_line(&line, &[[0.0, 20.0 * GAMMA], [100.0 / 3.0, 0.0], [40.0, 0.0], [50.0, 6.0 * GAMMA]]);
    // and the same from downstream
    let mirrored = JointWater::new([[0.0, 30.0], [40.0, 0.0]], [36.0, 20.0], [GAMMA; 2]);
    let line = mirrored.nodes(&Uplift::default(), [0.0, 40.0]);
    assert_line(&line, &[[0.0, 6.0 * GAMMA], [10.0, 0.0], [50.0 / 3.0, 0.0], [50.0, 20.0 * GAMMA]]);
}

#[test]
fn dry_mouth_leaves_its_crack_without_pressure() {
    // falls downstream by 14 m; reservoir below the heel
    let water = JointWater::new([[0.0, 0.0], [48.0, -14.0]], [-3.0, 6.0], [GAMMA; 2]);
    let line = water.nodes(&Uplift::default(), [25.0, 0.0]);
    assert_line(&line, &[[0.0, 0.0], [25.0, 0.0], [50.0, 20.0 * GAMMA]]);
}

/// Muddy reservoir of 12 kN/m³ over 50 m, tailwater of 10 kN/m³ over 20 m, joint of 40 m.
#[test]
fn pressures_are_interpolated_between_waters_of_different_weight() {
    let water = JointWater::new([[0.0, 0.0], [40.0, 0.0]], [50.0, 20.0], [12e3, 10e3]);
    let at = |uplift: &Uplift, x| water.pressure(uplift, [0.0; 2], x);
    assert!((at(&Uplift::default(), 10.0) - 500e3).abs() < 1e-6);
    for (efficiency, expected) in [(0.0, 500e3), (0.5, 350e3), (1.0, 200e3)] {
        assert!((at(&drained(10.0, efficiency, None), 10.0) - expected).abs() < 1e-6);
    }
    // the gallery at 25 m: water of the reservoir, 300 kPa, + 0.5 · (600 − 300) · 0.75
    assert!((at(&drained(10.0, 0.5, Some(25.0)), 10.0) - 412.5e3).abs() < 1e-6);
}

/// Against sums over 1e5 strips; at a jump, the value beyond it.
#[test]
fn integrals_are_exact() {
    let line = [[0.0, 3.0], [2.0, 5.0], [2.0, 1.0], [7.0, 0.0], [10.0, 0.5]];
    let strips = 100_000;
    let (mut sum, mut arms) = (0.0, 0.0);
    for k in 0..strips {
        let x = (k as f64 + 0.5) * 10.0 / strips as f64;
        sum += interpolate(&line, x) * 10.0 / strips as f64;
        arms += interpolate(&line, x) * (10.0 - x) * 10.0 / strips as f64;
    }
    assert!((force(&line) - sum).abs() < 1e-9 && (force(&line) - 11.25).abs() < 1e-12);
    assert!((moment(&line, 10.0) - arms).abs() < 1e-7);
    assert_eq!([-1.0, 2.0, 20.0].map(|x| interpolate(&line, x)), [3.0, 1.0, 0.5]);
    assert_eq!(interpolate(&[], 1.0), 0.0);
}

#[test]
fn negative_values_are_clipped_with_a_point_at_zero() {
    assert_eq!(
        clipped(&[[0.0, -1.0], [2.0, 1.0], [4.0, -3.0]]),
        [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [2.5, 0.0], [4.0, 0.0]]
    );
    // a jump needs none
    assert_eq!(clipped(&[[1.0, 1.0], [1.0, -1.0]]), [[1.0, 1.0], [1.0, 0.0]]);
}

#[test]
fn relieved_line_is_zero_over_the_open_ends() {
    let line = [[0.0, 4.0], [4.0, 0.0]];
    let middle = [[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [3.0, 1.0], [3.0, 0.0], [4.0, 0.0]];
    assert_eq!(relieved(&line, 4.0, [1.0, 1.0]), middle);
    assert_eq!(relieved(&line, 4.0, [0.0; 2]), line);
    assert_eq!(relieved(&line, 4.0, [4.0, 0.0]), [[0.0, 0.0], [4.0, 0.0]]);
    assert_eq!(relieved(&line, 4.0, [0.0, 4.0]), [[0.0, 0.0], [4.0, 0.0]]);
    // at a jump, the value on its own side
    let jump = [[0.0, 4.0], [2.0, 4.0], [2.0, 1.0], [4.0, 1.0]];
    let from_tip = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [4.0, 1.0]];
    assert_eq!(relieved(&jump, 4.0, [2.0, 0.0]), from_tip);
}

#[test]
fn factor_is_linear_between_its_times_and_constant_outside() {
    let uplift = Uplift { factor: Some(vec![[1.0, 1.0], [3.0, 0.5]]), ..Uplift::default() };
    assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(|time| uplift.factor_at(time)), [1.0, 1.0, 0.75, 0.5, 0.5]);
    for factor in [None, Some(Vec::new())] {
        assert_eq!(Uplift { factor, ..Uplift::default() }.factor_at(5.0), 1.0);
    }
}

#[test]
fn accepts_valid_descriptions() {
    let water = base(70.0, [91.75, 20.0]);
    let with_factor = Uplift { factor: Some(vec![[0.0, 1.0]]), ..drained(7.0, 0.67, Some(103.0)) };
    for uplift in [Uplift::default(), with_factor, with_profile(&[[0.0, 9e5], [70.0, 0.0]])] {
        assert_eq!(uplift.check(&water, 103.0), Ok(()));
    }
}

/// Each with the key and a part of the message.
#[test]
fn rejects_invalid_descriptions() {
    let factor = |rows: &[[f64; 2]]| Uplift { factor: Some(rows.to_vec()), ..Uplift::default() };
    let both = Uplift { profile: Some(vec![[0.0, 1.0], [1.0, 1.0]]), ..drained(7.0, 0.67, None) };
    let cases = [
        (drained(0.0, 0.67, None), "drains.position", "is 0 m; it must lie within the joint"),
        (drained(70.0, 0.67, None), "drains.position", "less than 70 m"),
        (drained(f64::NAN, 0.67, None), "drains.position", "NaN"),
        (drained(7.0, 67.0, None), "drains.efficiency", "is 67; it must be between 0"),
        (drained(7.0, -0.1, None), "drains.efficiency", "-0.1"),
        (drained(7.0, f64::NAN, None), "drains.efficiency", "NaN"),
        (drained(7.0, 0.67, Some(103.5)), "drains.gallery_elevation", "103.5 m"),
        (drained(7.0, 0.67, Some(f64::NEG_INFINITY)), "drains.gallery_elevation", "crest at 103 m"),
        (both, "profile", "`drains` are given as well"),
        (with_profile(&[[0.0, 1.0]]), "profile", "has 1 points; give at least 2"),
        (with_profile(&[[1.0, 1.0], [2.0, 1.0]]), "profile", "starts at 1 m"),
        (with_profile(&[[f64::NAN, 1.0], [2.0, 1.0]]), "profile", "starts at NaN m"),
        (with_profile(&[[0.0, 1.0], [2.0, 1.0], [2.0, 1.0]]), "profile", "point 2 at 2 m"),
        (with_profile(&[[0.0, 1.0], [f64::NAN, 1.0]]), "profile", "must increase"),
        (with_profile(&[[0.0, 1.0], [70.5, 1.0]]), "profile", "beyond the joint, which is 70 m long"),
        (with_profile(&[[0.0, 1.0], [60.0, -5.0]]), "profile", "is -5 Pa; it must be 0 or more"),
        (with_profile(&[[0.0, f64::NAN], [60.0, 5.0]]), "profile", "NaN Pa"),
        (factor(&[]), "factor", "no rows"),
        (factor(&[[0.0, 1.0], [0.0, 1.0]]), "factor", "row 1, 0 s, does not follow the one before, 0 s"),
        (factor(&[[f64::INFINITY, 1.0]]), "factor", "row 0 is inf s; it must be finite"),
        (factor(&[[0.0, 1.0], [1.0, -0.5]]), "factor", "row 1 at 1 s is -0.5; it must be 0 or more"),
        (factor(&[[0.0, f64::NAN]]), "factor", "NaN"),
    ];
    for (uplift, key, part) in cases {
        let error = uplift.check(&base(70.0, [91.75, 20.0]), 103.0).unwrap_err();
        let message = error.to_string();
        assert_eq!(error.key(), key);
        assert!(message.starts_with(&format!("`{key}`")) && message.contains(part), "{message}");
    }
}
