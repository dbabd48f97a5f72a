//! The points of the wet face whose pressure is shown, and the force on the face.

use super::{Failure, unfit};
use cofferdam_reservoir::Complex64;
use cofferdam_unit::WetFace;
use std::ops::{Add, Mul};

/// A point between two interface points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Elevation, m.
    pub elevation: f64,
    /// Index of the lower one.
    start: usize,
    /// Relative position towards the upper one.
    share: f64,
}

/// The requested points.
#[derive(clap::Args)]
pub struct Points {
    /// Elevation of a point whose pressure is shown, m (repeatable; default: base and mid-height)
    #[arg(long = "at", value_name = "Y")]
    at: Vec<f64>,
}

impl Points {
    /// The points of `face`.
    ///
    /// **Errors**: an elevation that is not on the face.
    pub fn on(&self, face: &WetFace) -> Result<Vec<Shown>, Failure> {
        let depth = face.depth();
        let default = [0.0, 0.5 * depth];
        let elevations = if self.at.is_empty() { &default } else { self.at.as_slice() };
        let place = |&elevation: &f64| {
            let panel = face.panels().find(|panel| elevation <= face.points()[panel.start + 1][1]);
            let panel = panel.filter(|_| elevation >= 0.0).ok_or_else(|| {
                unfit(format!(
                    "--at {elevation} is not on the wet face; give an elevation from 0 to {depth} m"
                ))
            })?;
            let [low, high] = [0, 1].map(|end| face.points()[panel.start + end][1]);
            Ok(Shown { elevation, start: panel.start, share: (elevation - low) / (high - low) })
        };
        elevations.iter().map(place).collect()
    }
}

impl Shown {
    /// Its pressure, linear along the panel.
    pub fn of<T: Copy + Mul<f64, Output = T> + Add<Output = T>>(&self, pressure: &[T]) -> T {
        pressure[self.start] * (1.0 - self.share) + pressure[self.start + 1] * self.share
    }

    /// Rounded elevation for columns and legends.
    pub fn label(&self) -> String {
        format!("{} m", (self.elevation * 1e6).round() / 1e6)
    }
}

/// Force along x (N/m) of a pressure (Pa) that is linear along the panels.
pub fn force(face: &WetFace, pressure: &[Complex64]) -> Complex64 {
    let part = |part: fn(&Complex64) -> f64| -> f64 {
        let pressure: Vec<f64> = pressure.iter().map(part).collect();
        force_and_moment(face, &pressure)[0]
    };
    Complex64::new(part(|p| p.re), part(|p| p.im))
}

/// Force along x (N/m) and moment about the heel, positive turning the dam downstream (N·m/m), of a pressure (Pa)
/// that is linear along the panels.
pub fn force_and_moment(face: &WetFace, pressure: &[f64]) -> [f64; 2] {
    let forces = face.nodal_forces(pressure);
    forces
        .iter()
        .zip(face.points())
        .fold([0.0; 2], |[force, moment], (f, p)| [force + f[0], moment + f[0] * p[1] - f[1] * p[0]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_between_points_is_linear_and_elevations_off_the_face_are_refused() {
        let face = WetFace::new(vec![[0.0, 0.0], [1.0, 4.0], [1.0, 4.0], [1.0, 10.0]]).expect("a face");
        let pressure: Vec<Complex64> =
            [3.0, 1.0, 2.0, 0.0].map(|p| Complex64::new(p, -2.0 * p)).into_iter().collect();
        let on = |at: &[f64]| Points { at: at.to_vec() }.on(&face);
        let shown = on(&[0.0, 2.0, 7.0, 10.0]).expect("on the face");
        let values: Vec<f64> = shown.iter().map(|point| point.of(&pressure).re).collect();
        assert_eq!(values, [3.0, 2.0, 1.0, 0.0]);
        // (3 + 1)/2 · 4 + (2 + 0)/2 · 6
        assert!((force(&face, &pressure) - Complex64::new(14.0, -28.0)).norm() < 1e-12);
        for wrong in [-1e-9, 10.1, f64::NAN] {
            assert!(on(&[wrong]).is_err(), "{wrong}");
        }
        let middle = on(&[]).expect("on the face");
        assert_eq!(middle.iter().map(|point| point.elevation).collect::<Vec<_>>(), [0.0, 5.0]);
    }
}
