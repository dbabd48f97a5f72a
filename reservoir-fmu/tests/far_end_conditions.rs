//! Errors of a far end that is left out, a wall, or at p = 0, against closed forms where they exist.

use crate::rectangular;

use cofferdam_reservoir::paper::{FarEndCondition, ShortWindows, pressure_before, response_before};
use cofferdam_reservoir::{Complex64, ReservoirError, ReservoirParameters, pressure_of_record};
use rectangular::{DEPTH, SOUND_SPEED, THREADS, difference, of_uniform_motion, parameters, projected};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

/// p/(ρa) (m) before a uniformly moving face, if every mode is reflected at `distance` with the factor `returned`.
fn with_reflections(s: Complex64, distance: f64, returned: f64, elevation: f64) -> Complex64 {
    (0..2000)
        .map(|m| {
            let lambda = f64::from(2 * m + 1) * PI / (2.0 * DEPTH);
            let kappa = (lambda * lambda + (s / SOUND_SPEED).powi(2)).sqrt();
            let back = returned * (-2.0 * kappa * distance).exp();
            let sign = if m % 2 == 0 { 2.0 } else { -2.0 };
            sign * (lambda * elevation).cos() / (lambda * DEPTH) / kappa * (1.0 + back) / (1.0 - back)
        })
        .sum()
}

/// Outgoing waves, a wall and p = 0 agree with their closed forms; a far end that is left out does not give outgoing waves.
/// Relative L2 difference on the face.
#[test]
fn ends_of_a_channel() -> Result<(), ReservoirError> {
    for distance in [1.0, 2.0, 8.0] {
        let water =
            ReservoirParameters { far_end_distance: distance * DEPTH, ..parameters(1.0, 12, 0.0025, 1.0) };
        let face = &water.wet_face;
        for ratio in [0.5, 0.99, 1.5] {
            let s = Complex64::new(1e-3, ratio) * CUT_OFF;
            let found = |far_end| -> Result<Vec<Complex64>, ReservoirError> {
                Ok(of_uniform_motion(&response_before(far_end, &water, &[s], THREADS)?[0], s))
            };
            let exact = |returned: f64| {
                projected(face, |elevations| {
                    let at = |y: &f64| with_reflections(s, distance * DEPTH, returned, *y);
                    elevations.iter().map(at).collect()
                })
            };
            let off = [
                (FarEndCondition::Outgoing, 0.0),
                (FarEndCondition::NoFlow, 1.0),
                (FarEndCondition::NoPressure, -1.0),
            ]
            .map(|(far_end, returned)| Ok(difference(face, &found(far_end)?, &exact(returned))));
            let off: Vec<f64> = off.into_iter().collect::<Result<_, ReservoirError>>()?;
            let left_out = difference(face, &found(FarEndCondition::LeftOut)?, &exact(0.0));
            let [leaving, wall, open] = [off[0], off[1], off[2]];
            println!(
                "L = {distance} h, ω = {ratio} ω₁: leaving {leaving:.1e}, wall {wall:.1e}, p = 0 {open:.1e}, left out \
                 {left_out:.2}"
            );
            // 12 linear elements per depth at 1.5 ω₁; a closed channel magnifies their error.
            assert!(off.iter().all(|off| *off < 5e-3));
            // Above the cut-off the wave is reflected from any distance; below it, its effect falls like e^{−κL}.
            assert!(if ratio > 1.0 { left_out > 0.1 } else { ratio > 0.9 || left_out < 0.1 });
        }
    }
    Ok(())
}

/// In time: exact until the first wave has returned from the end, with large errors afterwards.
#[test]
fn a_ramp_before_a_wall() -> Result<(), ReservoirError> {
    let (h, count, distance) = (0.005, 401, 2.0 * DEPTH);
    let water = ReservoirParameters { far_end_distance: distance, ..parameters(1.0, 12, h, 2.0) };
    let points = water.wet_face.len();
    let motion = nalgebra::DMatrix::from_fn(points + 2, count, |row, n| {
        if row < points { -(n as f64 * h / 0.1).min(1.0) } else { 0.0 }
    });
    let exact = pressure_of_record(&water, &motion, THREADS)?;
    let peak = exact.row(0).amax();
    for far_end in [FarEndCondition::LeftOut, FarEndCondition::NoFlow, FarEndCondition::NoPressure] {
        let found = pressure_before(far_end, &water, &motion, THREADS)?;
        let back = (2.0 * distance / SOUND_SPEED / h) as usize;
        let off = |from: usize, to: usize| {
            (from..to).fold(0.0, |most: f64, n| most.max((found[(0, n)] - exact[(0, n)]).abs())) / peak
        };
        let [before, after] = [off(0, back), off(back, count)];
        println!("ramp, {far_end:?} at 2h: {before:.1e} of the peak before the echo, {after:.2} after it");
        assert!(before < 2e-3 || far_end == FarEndCondition::LeftOut);
        assert!(after > 0.05);
    }
    Ok(())
}

/// The windows are right for a motion that is periodic in the window, after the initial transient has gone, and only
/// then. Force relative to that of the whole record, α = 0.5.
#[test]
fn short_windows_are_right_where_all_is_periodic() -> Result<(), ReservoirError> {
    let (h, steps) = (0.005, 128);
    let water = parameters(0.5, 12, h, 1.0);
    let (points, windows) = (water.wet_face.len(), 20);
    let omega = 2.0 * PI * 3.0 / (steps as f64 * h);
    let velocity = |n: usize| -(omega * n as f64 * h).sin() / omega;
    let acceleration = |n: usize| -(omega * n as f64 * h).cos();
    let all = nalgebra::DMatrix::from_fn(points + 2, windows * steps + 1, |row, n| {
        if row < points { acceleration(n) } else { 0.0 }
    });
    let means = nalgebra::DMatrix::from_fn(points + 2, steps, |row, n| {
        if row < points { (velocity(n + 1) - velocity(n)) / h } else { 0.0 }
    });
    let exact = pressure_of_record(&water, &all, THREADS)?;
    let found = ShortWindows::new(&water, steps, THREADS)?.pressure(&means)?;
    let off = |window: usize| {
        let exact = exact.columns(window * steps + 1, steps);
        (&found - exact).norm() / exact.norm()
    };
    let [first, last] = [off(0), off(windows - 1)];
    println!(
        "windows of 0.64 s, a periodic motion: {first:.2} off in the first, {last:.1e} in the twentieth"
    );
    // Frequencies are damped by 1e-3, and means have an error of (ωH)²/24 = 9e-4 of the acceleration.
    assert!(first > 0.1 && last < 5e-3);
    Ok(())
}

#[test]
fn windows_that_cannot_be_are_refused() -> Result<(), ReservoirError> {
    let water = parameters(1.0, 4, 0.005, 1.0);
    let refused = |steps| ShortWindows::new(&water, steps, THREADS).err().map(|error| error.to_string());
    assert_eq!(refused(1), Some("a window has 1 steps; it needs two or more".to_owned()));
    let waves = ReservoirParameters { surface_waves: true, ..water.clone() };
    let error = ShortWindows::new(&waves, 8, THREADS).err();
    assert!(matches!(error, Some(ReservoirError::GravityWaves { .. })), "{error:?}");
    let windows = ShortWindows::new(&water, 8, THREADS)?;
    for shape in [(7, 9), (6, 8)] {
        let error = windows.pressure(&nalgebra::DMatrix::zeros(shape.0, shape.1)).unwrap_err();
        assert!(matches!(error, ReservoirError::RecordShape { expected: 7, .. }), "{error}");
    }
    // A window of 0.1 s with 180 m of water meets a cut-off frequency of a rigid bed, but the response is finite.
    assert!(
        ShortWindows::new(&water, 20, THREADS)?.pressure(&nalgebra::DMatrix::zeros(7, 20))?.norm() == 0.0
    );
    Ok(())
}
