//! What is known of a scene's cracks before the ground moves: factors of safety, and vibrations of blocks that slide.

use super::{Assembly, AssemblyError};
use cofferdam_dam::{DamParameters, Flutter, LimitEquilibrium};
use cofferdam_scene::{DamScene, DampingModel, DampingScene, Scene, Side, UpliftRuleScene, uplift};

/// Factors of safety of what lies above a crack, under weight and water at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// Against sliding.
    pub sliding: f64,
    /// What uplift would change in a crack under water that has none.
    pub with_uplift: Option<UpliftEffect>,
    /// Against overturning.
    pub overturning: f64,
}

/// What water in a crack would do to the safety of what lies above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpliftEffect {
    /// Factor of safety against sliding.
    pub sliding: f64,
}

impl Assembly<'_> {
    /// The limit equilibrium of each crack, from the base up, under weight and hydrostatic pressure.
    ///
    /// **Errors**: those of the dam.
    pub fn limit_equilibria(&self) -> Result<Vec<LimitEquilibrium>, AssemblyError> {
        let Some(dam) = self.scene.computed_dam() else { return Ok(Vec::new()) };
        Ok(self.dry_dam(dam)?.limit_equilibria(self.specific_weights())?)
    }

    /// The factors of safety of the cracks before the ground moves, by their indices.
    ///
    /// **Errors**: those of [`limit_equilibria`](Self::limit_equilibria).
    pub fn equilibria(&self) -> Result<Vec<(usize, Equilibrium)>, AssemblyError> {
        let equilibrium = |found: LimitEquilibrium| {
            let LimitEquilibrium { crack, sliding, overturning, .. } = found;
            (crack, Equilibrium { sliding, with_uplift: uplift_effect(self.scene, &found), overturning })
        };
        Ok(self.limit_equilibria()?.into_iter().map(equilibrium).collect())
    }

    /// The fastest growing vibration of each crack's blocks while they slide, with the mass of the water, and of those that
    /// grow, what changes of the damping would make them decay, as keys and values.
    ///
    /// **Errors**: those of the dam, and of the reservoir that the mass is taken from.
    pub fn flutter(&self) -> Result<Vec<(Flutter, Vec<String>)>, AssemblyError> {
        let Some(dam) = self.scene.computed_dam() else { return Ok(Vec::new()) };
        let specific_weights = self.specific_weights();
        let added_mass = if self.has_computed_waters() { Some(self.water_mass(true)?) } else { None };
        let of = |dam: &DamScene| -> Result<Vec<Flutter>, AssemblyError> {
            let parameters = DamParameters { added_mass: added_mass.clone(), ..self.dry_dam(dam)? };
            Ok(parameters.flutter(specific_weights)?)
        };
        let found = of(dam)?;
        let mut cured = Vec::new();
        if found.iter().any(|vibration| vibration.growth > 0.0) {
            for (key, change) in CURES {
                let mut other = dam.clone();
                let value = change(&mut other.damping);
                cured.push((format!("{key} = {value}"), of(&other)?));
            }
        }
        let cures = |index: usize| {
            let decays =
                cured.iter().filter(|(_, vibrations)| vibrations.get(index).is_some_and(|v| v.growth <= 0.0));
            decays.map(|(cure, _)| cure.clone()).collect()
        };
        Ok(found.into_iter().enumerate().map(|(index, vibration)| (vibration, cures(index))).collect())
    }

    /// ρ g of the water upstream and downstream, N/m³; 0 where there is none.
    fn specific_weights(&self) -> [f64; 2] {
        Side::BOTH.map(|side| self.specific_weight(side))
    }
}

/// What the uplift U that a scene leaves out does to the safety against sliding, `(c ℓ + μ (N − U))/V` with N − U ≥ 0; none where no
/// water would enter, or nothing pushes.
fn uplift_effect(scene: &Scene, equilibrium: &LimitEquilibrium) -> Option<UpliftEffect> {
    let dam = scene.dam.as_ref()?;
    let crack = dam.cracks.get(equilibrium.crack)?;
    if crack.uplift_rule(dam.uplift) != UpliftRuleScene::None {
        return None;
    }
    let LimitEquilibrium { sliding, normal_force, shear_force, .. } = *equilibrium;
    let (pressing, friction) = (normal_force.max(0.0), crack.friction_coefficient);
    let lost = uplift(scene, crack)?.force.min(pressing);
    (shear_force > 0.0).then(|| UpliftEffect { sliding: sliding - friction * lost / shear_force })
}

/// Keys of the scene, and changes to them that damp a sliding block's vibration; they return the new value.
type Cure = (&'static str, fn(&mut DampingScene) -> String);
const CURES: [Cure; 2] = [
    ("dam.damping.model", |damping| {
        damping.model = DampingModel::Stiffness;
        "\"stiffness\"".to_owned()
    }),
    ("dam.damping.ratio", |damping| {
        damping.ratio *= 2.0;
        damping.ratio.to_string()
    }),
];
