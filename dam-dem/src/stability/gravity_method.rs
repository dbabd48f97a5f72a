//! Loads of a dam on its joints.

use super::{JointLoad, Strength};
use crate::above::Above;
use crate::loads::face::{self, Side};
use crate::loads::{Constant, LoadBasis, StaticLoad, water_at};
use crate::model::Body;
use crate::uplift::{JointWater, Uplift};
use crate::{CrackParameters, DamError, DamParameters};

/// Share of the distance between its ends on which a joint without galleries has contact.
const WHOLE: f64 = 1.0 - 1e-6;

/// Loads of one combination, uplift aside.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadCase {
    /// Levels of reservoir and tailwater above the heel, m; 0 for none.
    pub levels: [f64; 2],
    /// Specific weights of the two, N/m³.
    pub specific_weights: [f64; 2],
    /// Seismic coefficients, as shares of g: inertia of dam and water downstream, and downwards.
    pub seismic: [f64; 2],
    /// Other static loads.
    pub static_loads: Vec<StaticLoad>,
}

/// A joint of a dam: a straight crack, with the rigid body that it alone carries.
#[derive(Clone, Debug)]
pub struct DamJoint {
    /// The crack, from the base up.
    pub crack: usize,
    /// Mean elevation, m.
    pub elevation: f64,
    /// Uplift; `None` for no water in the joint.
    pub uplift: Option<Uplift>,
    /// Peak and residual strength.
    pub strength: [Strength; 2],
    above: Above,
}

impl DamJoint {
    /// Direction of the joint, downstream.
    pub fn tangent(&self) -> [f64; 2] {
        self.above.tangent
    }
}

/// A joint under the loads of one combination.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedJoint {
    /// The water at its ends.
    pub water: JointWater,
    /// Resultants without uplift.
    pub load: JointLoad,
    /// Moments about the downstream end that hold the body above and that turn it, without uplift, N.
    pub moments: [f64; 2],
}

/// The gravity method: rigid bodies above the joints of a dam, and the resultants of the loads on them.
#[derive(Clone, Debug)]
pub struct GravityMethod {
    body: Body,
    gravity: f64,
    joints: Vec<DamJoint>,
}

impl GravityMethod {
    /// The joints of a dam: its cracks that are straight, carry a body by themselves and have no gallery in between.
    ///
    /// **Errors**: as [`DamParameters::check`], and [`DamError::WetFace`].
    pub fn new(parameters: &DamParameters) -> Result<Self, DamError> {
        parameters.check()?;
        let mut cracks = parameters.cracks.clone();
        cracks.sort_by(CrackParameters::from_the_base_up);
        let body = Body::dry(parameters, &cracks)?;
        let joint = |(crack, parameters): (usize, &CrackParameters)| {
            let peak = parameters.friction_coefficient;
            let residual = parameters.residual_friction_coefficient.unwrap_or(peak);
            let above = Above::of(&body.structure, crack)?;
            let [[x0, y0], [x1, y1]] = above.ends;
            let length = (x1 - x0).hypot(y1 - y0);
            (above.length > WHOLE * length).then(|| DamJoint {
                crack,
                elevation: parameters.line.elevation(),
                uplift: parameters.uplift.clone(),
                strength: [
                    Strength {
                        friction: peak,
                        cohesion: parameters.cohesion,
                        tensile_strength: parameters.tensile_strength,
                    },
                    Strength { friction: residual, ..Strength::default() },
                ],
                above,
            })
        };
        let joints = cracks.iter().enumerate().filter_map(joint).collect();
        Ok(Self { gravity: parameters.gravity, joints, body })
    }

    /// The joints, from the base up.
    pub fn joints(&self) -> &[DamJoint] {
        &self.joints
    }

    /// The joints under a `case` of loads, in their order.
    ///
    /// The mass of the dam takes part in the inertia with its whole weight, the water by Westergaard's added mass on the vertical
    /// projection of the upstream side, and vertically with its own weight.
    ///
    /// **Errors**: [`DamError::PointOutside`].
    pub fn under(&self, case: &LoadCase) -> Result<Vec<LoadedJoint>, DamError> {
        let structure = &self.body.structure;
        let mesh = &structure.mesh;
        let [horizontal, vertical] = case.seismic;
        let weight = self.gravity * (1.0 + vertical);
        let mut forces: Vec<[f64; 2]> =
            structure.mass.iter().map(|m| [m * self.gravity * horizontal, -m * weight]).collect();
        let mut add = |basis: &LoadBasis, factor: f64| basis.add(&[factor], &mut forces);
        for (side, index) in [(Side::Upstream, 0), (Side::Downstream, 1)] {
            let specific_weight = case.specific_weights[index] * (1.0 + vertical);
            add(&face::of_depth(mesh, side, case.levels[index], [specific_weight; 2]), 1.0);
        }
        add(&face::westergaard(mesh, case.levels[0], horizontal * case.specific_weights[0]), 1.0);
        for load in &case.static_loads {
            add(Constant::new(load, mesh, self.gravity)?.nodal(), 1.0);
        }
        let loaded = |joint: &DamJoint| {
            let resultants = joint.above.resultants(mesh, &forces);
            let moments = resultants.moments[1];
            let load = JointLoad {
                normal: resultants.normal,
                shear: resultants.shear,
                moment: moments[0] - moments[1],
            };
            let water = water_at(mesh, joint.crack, (case.levels, case.specific_weights))?;
            Some(LoadedJoint { water, load, moments })
        };
        Ok(self.joints.iter().filter_map(loaded).collect())
    }
}
