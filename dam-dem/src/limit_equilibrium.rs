//! Whether what stands on a crack can stand there at all.

use crate::above::{Above, Resultants};
use crate::contact::MohrCoulomb;
use crate::model::Body;
use crate::structure::Structure;
use crate::{CrackParameters, DamError, DamParameters};

/// Limit equilibrium of the rigid body above a straight crack under the loads at rest, with the uplift of a crack that is closed.
///
/// ```text
/// sliding:     (c L + μ N) / |V|
/// overturning: (restoring moment + σ_t L²/2) / overturning moment, about the end where it is smaller
/// ```
///
/// with the resultants N (normal to the crack) and V (along it) and its length L. Both are infinite where nothing
/// pushes. Below 1 there is no state of rest. Peak friction counts; deformation, which may break a bond piece by piece,
/// does not. The body are all blocks that the ground carries across this crack alone; a crack beyond which there are none, as
/// where cracks cross, has no such equilibrium, and a crack with a kink none by which it could slide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitEquilibrium {
    /// Index of the crack, from the base up.
    pub crack: usize,
    /// Mean elevation of the crack, m.
    pub elevation: f64,
    /// Factor of safety against sliding.
    pub sliding: f64,
    /// Force that presses the crack together, N/m.
    pub normal_force: f64,
    /// Force along the crack, N/m.
    pub shear_force: f64,
    /// Factor of safety against overturning.
    pub overturning: f64,
}

impl LimitEquilibrium {
    /// Of each of the `cracks` of `structure` that has one, under these nodal `forces` (N/m).
    pub(crate) fn of(
        structure: &Structure<MohrCoulomb>,
        cracks: &[CrackParameters],
        forces: &[[f64; 2]],
    ) -> Vec<Self> {
        let of_crack = |(index, parameters): (usize, &CrackParameters)| {
            let above = Above::of(structure, index)?;
            let Resultants { normal, shear, moments } = above.resultants(&structure.mesh, forces);
            let bond = parameters.tensile_strength * above.length * above.length / 2.0;
            let over = |resistance: f64, action: f64| {
                if action > 0.0 { resistance / action } else { f64::INFINITY }
            };
            let holding =
                parameters.cohesion * above.length + parameters.friction_coefficient * normal.max(0.0);
            Some(Self {
                crack: index,
                elevation: parameters.line.elevation(),
                sliding: over(holding, shear.abs()),
                normal_force: normal,
                shear_force: shear.abs(),
                overturning: moments
                    .map(|[holds, turns]| over(holds + bond, turns))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min),
            })
        };
        cracks.iter().enumerate().filter_map(of_crack).collect()
    }

    /// Refuses what cannot stand.
    ///
    /// **Errors**: [`DamError::CannotStand`] where a factor is below 1.
    pub fn check(&self) -> Result<(), DamError> {
        let Self { elevation, sliding, overturning, .. } = *self;
        let (way, factor) =
            if sliding < overturning { ("slide", sliding) } else { ("overturn", overturning) };
        if factor < 1.0 { Err(DamError::CannotStand { elevation, way, factor }) } else { Ok(()) }
    }
}

impl DamParameters {
    /// The limit equilibrium of each crack that has one, from the base up, under the loads at rest, with these
    /// `specific_weights` of the water upstream and downstream (N/m³); none of an intact dam.
    ///
    /// **Errors**: as [`check`](Self::check), and [`DamError::WetFace`].
    pub fn limit_equilibria(&self, specific_weights: [f64; 2]) -> Result<Vec<LimitEquilibrium>, DamError> {
        self.check()?;
        if !self.fidelity.is_cracked() {
            return Ok(Vec::new());
        }
        let mut cracks = self.cracks.clone();
        cracks.sort_by(CrackParameters::from_the_base_up);
        let body = Body::dry(self, &cracks)?;
        let pressure = body.wet.as_ref().map_or_else(Vec::new, |wet| wet.hydrostatic(specific_weights));
        Ok(LimitEquilibrium::of(&body.structure, &cracks, &body.forces(&body.at_rest(0.0, pressure))))
    }
}
