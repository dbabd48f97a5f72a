//! The dam of a scene.

use super::error::MOST_TIME_STEPS;
use super::{Assembly, AssemblyError};
use cofferdam_coupling::participant::{InProcess, Messages, Participant};
use cofferdam_coupling::scheme::SchemeKind;
use cofferdam_dam::{Dam, DamParameters, GivenMesh};
use cofferdam_scene::{CrackScene, DamScene, Side, UpliftRuleScene, takes_water};

/// The water's inertia in the dam's mass matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaterMass {
    /// None: the water is another unit.
    None,
    /// That of water without memory; water with a memory is refused.
    Exact,
    /// That of the water as if it were incompressible and without waves.
    Still,
}

impl Assembly<'_> {
    /// The parameters of the dam, with the added mass of the water.
    ///
    /// **Errors**: [`AssemblyError::NoDam`], the wet face, and those of the reservoir that the mass is taken from.
    pub fn dam_parameters(&self, mass: WaterMass) -> Result<DamParameters, AssemblyError> {
        let mut parameters = self.dry_dam(self.scene.computed_dam().ok_or(AssemblyError::NoDam)?)?;
        if mass != WaterMass::None {
            parameters.added_mass = Some(self.water_mass(mass == WaterMass::Still)?);
        }
        Ok(parameters)
    }

    /// The inertia of the water in the dam's mass matrix that the scheme of the scene requires.
    pub(crate) fn scheme_mass(&self) -> WaterMass {
        if self.scene.scheme() == SchemeKind::OneWay { WaterMass::Exact } else { WaterMass::None }
    }

    /// The parameters of `dam` in this scene, without the mass of the water.
    pub(super) fn dry_dam(&self, dam: &DamScene) -> Result<DamParameters, AssemblyError> {
        let scene = self.scene;
        let DamScene {
            fidelity,
            modes,
            element_size,
            kinematics,
            time_step_safety,
            envelopes,
            section,
            mesh: _,
            material,
            zones,
            damping,
            uplift,
            cracks,
            // Other programs' dams, of which only the wet face is needed here.
            fmu: _,
            command: _,
            log: _,
        } = dam;
        Ok(DamParameters {
            section: section.into(),
            water_depth: scene.depth(),
            tailwater_depth: scene.tailwater.as_ref().and_then(|water| water.depth).unwrap_or(0.0),
            cracks: cracks.iter().map(|crack| crack.parameters(self.rule_for(*uplift, crack))).collect(),
            material: material.into(),
            damping: damping.into(),
            fidelity: fidelity.level().unwrap_or_default().with_modes(*modes),
            kinematics: *kinematics,
            element_size: *element_size,
            gravity: scene.gravity,
            time_step_safety: *time_step_safety,
            drags_blocks: damping.drags_blocks,
            zones: zones.iter().map(Into::into).collect(),
            given_mesh: given_mesh(dam)?,
            added_mass: None,
            water_densities: Side::BOTH.map(|side| {
                let water = scene.water(side).filter(|water| !water.is_empty());
                water.map_or(scene.reservoir.density, |water| water.density)
            }),
            static_loads: scene.static_loads().into_iter().map(|(_, load)| load).collect(),
            envelopes: *envelopes,
            inputs_held: 0.0,
        })
    }

    /// The rule of uplift for a crack where the rule of the dam is `of_dam`: none above the water.
    fn rule_for(&self, of_dam: UpliftRuleScene, crack: &CrackScene) -> UpliftRuleScene {
        if takes_water(self.scene, crack) { of_dam } else { UpliftRuleScene::None }
    }

    /// Makes the dam; also returns its time steps per communication step.
    ///
    /// **Errors**: those of the dam, and [`AssemblyError::TimeSteps`].
    pub fn make_dam(&self, parameters: DamParameters) -> Result<(Dam, usize), AssemblyError> {
        let dam = Dam::new(parameters)?;
        let time_steps = dam.time_steps_per(self.longest_step());
        if time_steps > MOST_TIME_STEPS {
            return Err(AssemblyError::TimeSteps { time_steps, limit: dam.time_step_limit() });
        }
        Ok((dam, time_steps))
    }

    /// The longest communication step, s.
    fn longest_step(&self) -> f64 {
        let time = &self.scene.time;
        time.adaptive.map_or(time.communication_step, |adaptive| adaptive.longest)
    }

    /// The value of `dam.time_step_safety` with which the dam takes time steps of this `part` of their length: 2 for half.
    ///
    /// **Errors**: those of the dam.
    pub fn safety_of_part(&self, part: f64) -> Result<f64, AssemblyError> {
        let (dam, _) = self.make_dam(self.dam_parameters(self.scheme_mass())?)?;
        Ok(dam.time_step_limit() / (part * dam.critical_time_step().limit))
    }

    /// The dam as a participant.
    pub(super) fn dam_participant(&self) -> Result<Box<dyn Participant>, AssemblyError> {
        let messages = Messages::default();
        let (dam, time_steps) =
            messages.listen(|| self.make_dam(self.dam_parameters(self.scheme_mass())?))?;
        let dam = dam.on_threads(self.making.threads)?;
        let (elements, nodes, version) = (dam.element_count(), dam.node_count(), env!("CARGO_PKG_VERSION"));
        let modes = dam.modes().map_or(0, |modes| modes.mode_count());
        let level = dam.parameters().fidelity.level();
        let model = match level.has_elements() {
            true => format!("{} {version}", level.label()),
            false => format!("{} {version}, {modes} modes", level.label()),
        };
        let calm = dam
            .calm_time_steps_per(self.longest_step())
            .map_or_else(String::new, |calm| format!("{calm} to "));
        let solver = format!(
            "{model}: {elements} elements, {nodes} nodes, {calm}{time_steps} time steps per communication step"
        );
        Ok(Box::new(InProcess::new(dam, &solver, messages)))
    }
}

/// The mesh from the dam's file, if it has one.
fn given_mesh(dam: &DamScene) -> Result<Option<GivenMesh>, AssemblyError> {
    let Some(mesh) = &dam.mesh else { return Ok(None) };
    let names: Vec<Option<String>> = dam.cracks.iter().map(|crack| crack.name.clone()).collect();
    Ok(Some(mesh.mesh(&names)?.into()))
}
