//! The closed forms with which results are compared.

mod history;

use cofferdam_reservoir::analytical::{
    chakrabarti_chopra_1973, chopra_1967, fenves_chopra_1984, westergaard_1933,
};
use cofferdam_reservoir::{Complex64, Fidelity, ReservoirParameters};

/// Motion of a rigid dam and the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Downstream, together with the ground.
    Horizontal,
    /// Upwards, together with the bed.
    Vertical,
}

impl Motion {
    /// 0 for horizontal, 1 for vertical.
    pub fn axis(self) -> usize {
        match self {
            Self::Horizontal => 0,
            Self::Vertical => 1,
        }
    }

    /// The response at every point to a unit velocity of a rigid dam and the ground: `response` (points × points and
    /// two columns of the ground) times that motion.
    pub fn of_rigid_dam(
        self,
        response: &nalgebra::DMatrix<Complex64>,
        normals: &[[f64; 2]],
    ) -> Vec<Complex64> {
        let (points, axis) = (normals.len(), self.axis());
        let of_face = |row: usize| -> Complex64 {
            normals.iter().enumerate().map(|(point, n)| response[(row, point)] * n[axis]).sum()
        };
        (0..response.nrows()).map(|row| of_face(row) + response[(row, points + axis)]).collect()
    }
}

/// A closed form for the water of a scene, per unit acceleration of a rigid dam and the ground.
pub struct Exact {
    kind: Kind,
    density: f64,
    depth: f64,
    sound_speed: f64,
    alpha: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Horizontal motion over a rigid bed.
    Rigid,
    /// Horizontal motion over an absorbing bed.
    Absorbing,
    /// Horizontal motion, incompressible water.
    Incompressible,
    /// Vertical motion: a column of water.
    Column,
    /// Vertical motion, incompressible water.
    Still,
}

impl Exact {
    /// The closed form, or the reason why there is none.
    pub fn of(parameters: &ReservoirParameters, motion: Motion) -> Result<Self, &'static str> {
        let ReservoirParameters { wet_face, wave_reflection_coefficient: alpha, .. } = parameters;
        let depth = wet_face.depth();
        if wet_face.points().iter().any(|point| point[0].abs() > 1e-9 * depth) {
            return Err("the face is not vertical");
        }
        if parameters.fidelity.is_solved() && parameters.bed.iter().any(|corner| corner[1] != 0.0) {
            return Err("the bed is not level");
        }
        if parameters.fidelity.has_memory() && parameters.surface_waves {
            return Err("there are waves on the surface");
        }
        let kind = match (motion, parameters.fidelity.has_memory()) {
            (Motion::Horizontal, true) if *alpha == 1.0 => Kind::Rigid,
            (Motion::Horizontal, true) => Kind::Absorbing,
            (Motion::Horizontal, false) => Kind::Incompressible,
            (Motion::Vertical, true) => Kind::Column,
            (Motion::Vertical, false) if parameters.fidelity == Fidelity::Incompressible => Kind::Still,
            (Motion::Vertical, false) => return Err("an added mass does not depend on the bed"),
        };
        let ReservoirParameters { density, sound_speed, .. } = *parameters;
        Ok(Self { kind, density, depth, sound_speed, alpha: *alpha })
    }

    /// The closed form if it is known over time, or the reason why there is none.
    pub fn with_history(self) -> Result<Self, &'static str> {
        match self.kind {
            Kind::Rigid => Ok(self),
            Kind::Absorbing => Err("the bed absorbs"),
            _ => Err("the dam does not move horizontally before water with a memory"),
        }
    }

    /// Pressure (Pa) at the base at `time` (s) over a rigid bed, for a piecewise linear acceleration downstream, (s,
    /// m/s²), held after its end.
    pub fn base_pressure(&self, record: &[(f64, f64)], time: f64) -> f64 {
        let Self { density, depth, sound_speed, .. } = *self;
        -density * sound_speed * chopra_1967::base_pressure(record, depth, sound_speed, time)
    }

    /// Author and year.
    pub fn source(&self) -> &'static str {
        match self.kind {
            Kind::Rigid => "Chopra (1967)",
            Kind::Absorbing => "Fenves and Chopra (1984)",
            Kind::Incompressible => "Westergaard's series (1933)",
            Kind::Column | Kind::Still => "a column of water (Chakrabarti and Chopra 1973)",
        }
    }

    /// Pressure (Pa per m/s²) at every elevation (m) and force along x (N/m per m/s²), for the acceleration `e^{st}`
    /// downstream or up. Motion away from the water gives suction, motion of the bed upwards gives compression.
    pub fn at(&self, s: Complex64, elevations: &[f64]) -> (Vec<Complex64>, Complex64) {
        let Self { density, depth, sound_speed, alpha, .. } = *self;
        let each = |pressure: &dyn Fn(f64) -> Complex64| -> Vec<Complex64> {
            elevations.iter().map(|y| density * pressure(*y)).collect()
        };
        match self.kind {
            Kind::Rigid => (
                each(&|y| -chopra_1967::pressure(s, depth, sound_speed, y)),
                -density * chopra_1967::force(s, depth, sound_speed),
            ),
            Kind::Absorbing => {
                let pressure = fenves_chopra_1984::pressures(s, depth, sound_speed, alpha, elevations);
                let force = fenves_chopra_1984::force(s, depth, sound_speed, alpha);
                (pressure.iter().map(|p| -density * p).collect(), -density * force)
            }
            Kind::Incompressible => (
                each(&|y| (-westergaard_1933::series_pressure(depth, y)).into()),
                (-density * chopra_1967::STATIC_FORCE * depth * depth).into(),
            ),
            Kind::Column => (
                each(&|y| chakrabarti_chopra_1973::pressure(s, depth, sound_speed, alpha, y)),
                density * chakrabarti_chopra_1973::force(s, depth, sound_speed, alpha),
            ),
            Kind::Still => (each(&|y| (depth - y).into()), (density * 0.5 * depth * depth).into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::WetFace;

    fn parameters() -> ReservoirParameters {
        ReservoirParameters::before(WetFace::straight([0.0, 90.0], 8).expect("a face"))
    }

    /// Both are sums of the same modes; the force over an absorbing bed uses fewer.
    #[test]
    fn an_absorbing_bed_that_is_rigid_gives_the_rigid_ones_numbers() {
        let s = Complex64::new(1.0, 30.0);
        let rigid = Exact::of(&parameters(), Motion::Horizontal).expect("a closed form");
        let (p, force) = rigid.at(s, &[0.0, 45.0]);
        let (q, other) = Exact { kind: Kind::Absorbing, ..rigid }.at(s, &[0.0, 45.0]);
        let off = [(p[0] - q[0]).norm() / p[0].norm(), (p[1] - q[1]).norm() / p[1].norm()];
        let of_force = (force - other).norm() / force.norm();
        println!("pressure off by {off:?}, force by {of_force:.1e}");
        assert!(off.iter().all(|off| *off < 1e-6) && of_force < 1e-5);
    }

    #[test]
    fn there_is_none_for_other_water() {
        let of = |parameters, motion| Exact::of(&parameters, motion).map(|exact| exact.source());
        assert_eq!(of(parameters(), Motion::Vertical), Ok("a column of water (Chakrabarti and Chopra 1973)"));
        let absorbing = ReservoirParameters { wave_reflection_coefficient: 0.5, ..parameters() };
        assert_eq!(of(absorbing, Motion::Horizontal), Ok("Fenves and Chopra (1984)"));
        let still = ReservoirParameters { fidelity: Fidelity::Westergaard, ..parameters() };
        assert_eq!(of(still.clone(), Motion::Horizontal), Ok("Westergaard's series (1933)"));
        assert!(of(still, Motion::Vertical).is_err());
        let waves = ReservoirParameters { surface_waves: true, ..parameters() };
        let sloped = ReservoirParameters { bed: vec![[-30.0, -3.0]], ..parameters() };
        let leaning = WetFace::straight([3.0, 90.0], 8).expect("a face");
        for other in [waves, sloped, ReservoirParameters::before(leaning)] {
            assert!(of(other, Motion::Horizontal).is_err());
        }
    }
}
