//! Whether what stands on a crack can stand there at all.

use crate::contact::MohrCoulomb;
use crate::loads::Wet;
use crate::structure::Structure;
use crate::{CrackParameters, DamError, DamParameters};

/// Limit equilibrium of the rigid body above a straight crack, under its weight and the pressure on its face.
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

/// Distance from the straight line between its ends, as a share of its length, from which a crack has a kink.
const STRAIGHT: f64 = 1e-6;

impl LimitEquilibrium {
    /// Of each of the `cracks` of `structure` that has one, with the `pressure` (Pa) at the interface points.
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
        let of_crack = |(index, parameters): (usize, &CrackParameters)| {
            let seams = || mesh.seams.iter().filter(move |seam| seam.crack == index);
            let chain: Vec<usize> = seams().flat_map(|seam| seam.upper.iter().copied()).collect();
            let above = beyond(structure, index);
            let (&first, &last) = (chain.first()?, chain.last()?);
            let tangent = mesh.direction(&[first, last]);
            let normal = [-tangent[1], tangent[0]];
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            let from = |end: usize, node: usize| [0, 1].map(|d| mesh.nodes[node][d] - mesh.nodes[end][d]);
            // a gallery in between is no part of it
            let length: f64 =
                seams().map(|seam| mesh.length(&[seam.upper[0], seam.upper[seam.upper.len() - 1]])).sum();
            let off = |&node: &usize| dot(from(first, node), normal).abs() > STRAIGHT * length;
            // all of the upper side must be of the body that would move
            let carries = seams().all(|seam| above.contains(&seam.above));
            if !carries || chain.iter().any(off) {
                return None;
            }
            let (mut pressing, mut shear) = (0.0, 0.0);
            // moments that hold the body and that turn it, about the upstream and about the downstream end
            let mut moments = [[0.0; 2]; 2];
            for node in above.iter().flat_map(|&block| mesh.blocks[block].nodes.clone()) {
                let [across, along] = [normal, tangent].map(|axis| dot(forces[node], axis));
                pressing -= across;
                shear += along;
                for (end, [holds, turns]) in [first, last].into_iter().zip(&mut moments) {
                    let inwards = if end == first { 1.0 } else { -1.0 };
                    let place = from(end, node);
                    for moment in
                        [inwards * -across * dot(place, tangent), inwards * along * dot(place, normal)]
                    {
                        *(if moment > 0.0 { &mut *holds } else { &mut *turns }) += moment.abs();
                    }
                }
            }
            let bond = parameters.tensile_strength * length * length / 2.0;
            let over = |resistance: f64, action: f64| {
                if action > 0.0 { resistance / action } else { f64::INFINITY }
            };
            let holding = parameters.cohesion * length + parameters.friction_coefficient * pressing.max(0.0);
            Some(Self {
                crack: index,
                elevation: parameters.line.elevation(),
                sliding: over(holding, shear.abs()),
                normal_force: pressing,
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

/// The blocks that nothing carries without this `crack`.
fn beyond(structure: &Structure<MohrCoulomb>, crack: usize) -> Vec<usize> {
    let mesh = &structure.mesh;
    let mut carried: Vec<bool> = mesh.blocks.iter().map(|block| structure.is_held(block)).collect();
    carried.push(true);
    loop {
        let next = mesh.seams.iter().find_map(|seam| match (seam.below, seam.above) {
            _ if seam.crack == crack => None,
            (below, above) if carried[below] && !carried[above] => Some(above),
            (below, above) if carried[above] && !carried[below] => Some(below),
            _ => None,
        });
        match next {
            Some(block) => carried[block] = true,
            None => return (0..mesh.blocks.len()).filter(|&block| !carried[block]).collect(),
        }
    }
}

impl DamParameters {
    /// The limit equilibrium of each crack that has one, from the base up, under weight and hydrostatic pressure with these
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
        let mesh = self.mesh()?;
        let wet = Wet::below(&mesh, self.water_levels())?;
        let laws = cracks.iter().map(|crack| (MohrCoulomb::from(crack), crack.integration));
        let base = mesh.base.clone();
        let structure = Structure::new(mesh, self.materials(), self.kinematics, laws, &base);
        let pressure = wet.as_ref().map_or_else(Vec::new, |wet| wet.hydrostatic(specific_weights));
        Ok(LimitEquilibrium::of(&structure, &cracks, wet.as_ref(), &pressure, self.gravity))
    }
}
