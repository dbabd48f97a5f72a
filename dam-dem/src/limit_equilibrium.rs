//! Whether what stands on a crack can stand there at all.

use crate::contact::MohrCoulomb;
use crate::loads::Wet;
use crate::structure::Structure;
use crate::{CrackParameters, DamError, DamParameters};

/// Limit equilibrium of the rigid body above a crack, under its weight and the pressure on its face.
///
/// ```text
/// sliding:     (c L + μ N) / |V|
/// overturning: (restoring moment + σ_t L²/2) / overturning moment, about the end where it is smaller
/// ```
///
/// with the resultants N (downwards) and V (downstream) on the crack and its length L. Both are infinite where nothing
/// pushes. Below 1 there is no state of rest. Peak friction counts; deformation, which may break a bond piece by piece,
/// does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitEquilibrium {
    /// Elevation of the crack, m.
    pub elevation: f64,
    /// Factor of safety against sliding.
    pub sliding: f64,
    /// Factor of safety against overturning.
    pub overturning: f64,
}

impl LimitEquilibrium {
    /// Of each of the `cracks` of `structure`, from the base up, with the `pressure` (Pa) at the interface points.
    pub(crate) fn of(
        structure: &Structure<MohrCoulomb>,
        cracks: &[CrackParameters],
        wet: Option<&Wet>,
        pressure: &[f64],
        gravity: f64,
    ) -> Vec<Self> {
        let mesh = &structure.mesh;
        let mut forces = structure.weight([0.0, -gravity]);
        if let Some(wet) = wet {
            wet.load.add(pressure, &mut forces);
        }
        let of_crack = |(crack, parameters): (usize, &CrackParameters)| {
            let bottom = &mesh.blocks[crack + 1].bottom;
            let ends = [bottom[0], bottom[bottom.len() - 1]].map(|node| mesh.nodes[node][0]);
            let elevation = parameters.elevation;
            let above = mesh.blocks[crack + 1].nodes.start;
            let (mut normal, mut shear) = (0.0, 0.0);
            // moments that hold the body and that turn it, about the upstream and about the downstream end
            let mut moments = [[0.0; 2]; 2];
            for (place, [x, y]) in mesh.nodes[above..].iter().zip(&forces[above..]) {
                normal -= y;
                shear += x;
                for (end, [holds, turns]) in moments.iter_mut().enumerate() {
                    let inwards = if end == 0 { 1.0 } else { -1.0 };
                    for moment in
                        [inwards * -y * (place[0] - ends[end]), inwards * x * (place[1] - elevation)]
                    {
                        *(if moment > 0.0 { &mut *holds } else { &mut *turns }) += moment.abs();
                    }
                }
            }
            let length = ends[1] - ends[0];
            let bond = parameters.tensile_strength * length * length / 2.0;
            let over = |resistance: f64, action: f64| {
                if action > 0.0 { resistance / action } else { f64::INFINITY }
            };
            let holding = parameters.cohesion * length + parameters.friction_coefficient * normal.max(0.0);
            Self {
                elevation,
                sliding: over(holding, shear.abs()),
                overturning: moments
                    .map(|[holds, turns]| over(holds + bond, turns))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min),
            }
        };
        cracks.iter().enumerate().map(of_crack).collect()
    }

    /// Refuses what cannot stand.
    ///
    /// **Errors**: [`DamError::CannotStand`] where a factor is below 1.
    pub fn check(&self) -> Result<(), DamError> {
        let Self { elevation, sliding, overturning } = *self;
        let (way, factor) =
            if sliding < overturning { ("slide", sliding) } else { ("overturn", overturning) };
        if factor < 1.0 { Err(DamError::CannotStand { elevation, way, factor }) } else { Ok(()) }
    }
}

impl DamParameters {
    /// The limit equilibrium of each crack, from the base up, under weight and hydrostatic pressure with these
    /// `specific_weights` of the water upstream and downstream (N/m³); none of an intact dam.
    ///
    /// **Errors**: as [`check`](Self::check), and [`DamError::WetFace`].
    pub fn limit_equilibria(&self, specific_weights: [f64; 2]) -> Result<Vec<LimitEquilibrium>, DamError> {
        self.check()?;
        if !self.fidelity.is_cracked() {
            return Ok(Vec::new());
        }
        let mut cracks = self.cracks.clone();
        cracks.sort_by(|a, b| a.elevation.total_cmp(&b.elevation));
        let mesh = self.mesh();
        let wet = Wet::below(&mesh, self.water_levels())?;
        let laws = cracks.iter().map(|crack| (MohrCoulomb::from(crack), crack.integration));
        let base = mesh.blocks[0].bottom.clone();
        let structure = Structure::new(mesh, &self.material, self.kinematics, laws, &base);
        let pressure = wet.as_ref().map_or_else(Vec::new, |wet| wet.hydrostatic(specific_weights));
        Ok(LimitEquilibrium::of(&structure, &cracks, wet.as_ref(), &pressure, self.gravity))
    }
}
