//! Factors of safety of a scene's joints by the gravity method, for each combination of loads.

use super::{Assembly, AssemblyError};
use cofferdam_dam::DamParameters;
use cofferdam_dam::loads::StaticLoad;
use cofferdam_dam::stability::{
    Authority, DamJoint, GravityMethod, Joint, JointLoad, JointState, LoadCase, LoadCombination, LoadedJoint,
    Mode, Requirement, SlidingBlock, required,
};
use cofferdam_dam::uplift::{Uplift, UpliftRule, moment};
use cofferdam_scene::{CombinationScene, DamScene, Scene, Side};

/// Share of the record's peak that acts as a constant inertia: sustained, not instantaneous.
const SUSTAINED: f64 = 2.0 / 3.0;

/// A joint under one combination of loads.
#[derive(Clone, Debug, PartialEq)]
pub struct JointStability {
    /// The crack, from the base up.
    pub crack: usize,
    /// Length of the joint, m.
    pub length: f64,
    /// The combination.
    pub combination: LoadCombination,
    /// What tables call it.
    pub name: String,
    /// The shock after which it is, from 0, in a run with several.
    pub shock: Option<usize>,
    /// Inertia downstream and downwards, shares of g.
    pub seismic: [f64; 2],
    /// Uplift in what is open; `None` for no water in the joint.
    pub rule: Option<UpliftRule>,
    /// Whether drains count.
    pub drained: bool,
    /// Forces on the part above, uplift not included.
    pub load: JointLoad,
    /// Its equilibrium.
    pub state: JointState,
    /// Factors against sliding with the peak and the residual strength; `None` where nothing pushes.
    pub sliding: [Option<f64>; 2],
    /// Factor against overturning about the downstream end; `None` where nothing turns.
    pub overturning: Option<f64>,
    /// What the authority requires; `None` where it requires nothing.
    pub requirement: Option<Requirement>,
    /// The required factor against sliding: the scene's own, or the authority's.
    pub required: Option<f64>,
    /// Whether it is the scene's own.
    pub is_own: bool,
    /// Whether the factor with the residual strength is compared with it.
    pub by_residual: bool,
}

/// Whether a joint meets what is required of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Meets,
    /// It does not.
    Fails,
    /// Nothing is required.
    NotRequired,
}

impl Verdict {
    /// The word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Meets => "meets",
            Self::Fails => "fails",
            Self::NotRequired => "no requirement",
        }
    }
}

impl JointStability {
    /// The factor against sliding that is compared.
    pub fn decisive(&self) -> Option<f64> {
        self.sliding[usize::from(self.by_residual)]
    }

    /// Whether the required factor and the zone of the resultant are met. A joint fails whatever is required
    /// if it overturns, or if a shear force without inertia exceeds its strength.
    pub fn verdict(&self) -> Verdict {
        let is_static = self.combination != LoadCombination::Seismic;
        if self.state.overturns() || is_static && self.decisive().is_some_and(|factor| factor < 1.0) {
            return Verdict::Fails;
        }
        let zone =
            self.requirement.is_none_or(|requirement| requirement.resultant.contains(self.state.zone()));
        match self.required {
            None => Verdict::NotRequired,
            Some(least) if zone && self.decisive().is_none_or(|factor| factor >= least) => Verdict::Meets,
            Some(_) => Verdict::Fails,
        }
    }
}

impl Assembly<'_> {
    /// The stability of every joint of the scene, combination by combination.
    ///
    /// `peak` is that of the record, m/s², from which the seismic coefficient follows if the scene gives none; `opened` are
    /// lengths (m) over which an earthquake has opened each crack, from the base up, after each shock of a run, none without a run; the
    /// combination after the earthquake is given for each of them; `rules` lists the uplift rules of
    /// the seismic combination to put side by side, `None` for no uplift; without any, that of each joint is taken.
    ///
    /// **Errors**: those of the dam.
    pub fn stability(
        &self,
        peak: f64,
        opened: &[Vec<f64>],
        rules: &[Option<UpliftRule>],
    ) -> Result<Vec<JointStability>, AssemblyError> {
        let Some(dam) = self.scene.computed_dam() else { return Ok(Vec::new()) };
        let method = self.gravity_method(dam)?;
        let drained = |joint: &DamJoint| joint.uplift.as_ref().is_some_and(|uplift| uplift.drains.is_some());
        let has_drains = method.joints().iter().any(drained);
        let mut found = Vec::new();
        for combination in combinations(self.scene, has_drains) {
            let case = self.load_case(&combination, peak);
            let still = method.under(&LoadCase { seismic: [0.0; 2], ..case.clone() })?;
            let loaded = method.under(&case)?;
            for ((joint, loaded), still) in method.joints().iter().zip(&loaded).zip(&still) {
                let rules: Vec<Option<Option<UpliftRule>>> = match combination.kind {
                    LoadCombination::Seismic if !rules.is_empty() => {
                        rules.iter().copied().map(Some).collect()
                    }
                    _ => vec![None],
                };
                let is_after = combination.kind == LoadCombination::PostEarthquake;
                let shocks = if is_after { opened.len().max(1) } else { 1 };
                for (rule, shock) in
                    rules.iter().flat_map(|rule| (0..shocks).map(move |shock| (*rule, shock)))
                {
                    let opened = opened.get(shock).map(Vec::as_slice);
                    let several =
                        is_after && opened.is_some() && !self.scene.ground_motion.sequence.is_empty();
                    let shock = several.then_some(shock);
                    let (combination, seismic) = (&combination, case.seismic);
                    let with = With { combination, seismic, still, opened, shock, rule };
                    found.push(self.of_joint(joint, loaded, &with));
                }
            }
        }
        found.sort_by_key(|joint| joint.crack);
        Ok(found)
    }

    /// Newmark's block on each joint that has equilibrium under usual loads, with its crack, from the base up: the body above with the
    /// water as Westergaard's added mass, and the uplift at rest.
    ///
    /// **Errors**: those of the dam.
    pub fn sliding_blocks(&self) -> Result<Vec<(usize, SlidingBlock)>, AssemblyError> {
        let Some(dam) = self.scene.computed_dam() else { return Ok(Vec::new()) };
        let method = self.gravity_method(dam)?;
        let case = self.load_case(&of_kind(LoadCombination::Usual), 0.0);
        let under = |seismic| method.under(&LoadCase { seismic, ..case.clone() });
        let [still, downstream, downwards] = [under([0.0, 0.0])?, under([1.0, 0.0])?, under([0.0, 1.0])?];
        let block = |(number, joint): (usize, &DamJoint)| {
            let loaded = &still[number];
            let dry = Uplift::default();
            let uplift = joint.uplift.as_ref();
            let state = Joint {
                water: &loaded.water,
                uplift: uplift.unwrap_or(&dry),
                uplift_factor: uplift.map_or(0.0, |uplift| uplift.factor_at(0.0)),
                load: loaded.load,
                strength: joint.strength[0],
            }
            .state(Mode::Static);
            let loads = [&still, &downstream, &downwards].map(|loaded| loaded[number].load);
            let block = || {
                SlidingBlock::new(
                    loads,
                    self.scene.gravity,
                    joint.tangent(),
                    state.uplift,
                    joint.strength,
                    state.bonded,
                )
            };
            (!state.overturns()).then(|| (joint.crack, block()))
        };
        Ok(method.joints().iter().enumerate().filter_map(block).collect())
    }

    fn gravity_method(&self, dam: &DamScene) -> Result<GravityMethod, AssemblyError> {
        // a flood may reach cracks that lie above the water of the run
        let cracks = dam.cracks.iter().map(|crack| crack.parameters(dam.uplift)).collect();
        Ok(GravityMethod::new(&DamParameters { cracks, ..self.dry_dam(dam)? })?)
    }

    fn of_joint(&self, joint: &DamJoint, loaded: &LoadedJoint, with: &With<'_>) -> JointStability {
        let With { combination, seismic, still, opened, shock, rule } = *with;
        let kind = combination.kind;
        let mut uplift = joint.uplift.clone();
        if let Some(rule) = rule {
            uplift = rule.map(|rule| Uplift { rule, ..uplift.unwrap_or_default() });
        }
        if let Some(uplift) = uplift.as_mut().filter(|_| !combination.drains) {
            uplift.drains = None;
        }
        let (wet, factor) = match &uplift {
            Some(uplift) => {
                let time = if kind == LoadCombination::PostEarthquake { f64::INFINITY } else { 0.0 };
                (uplift.clone(), uplift.factor_at(time))
            }
            None => (Uplift::default(), 0.0),
        };
        let [peak, residual] = joint.strength;
        let of =
            |load| Joint { water: &loaded.water, uplift: &wet, uplift_factor: factor, load, strength: peak };
        let length = loaded.water.length;
        let mode = match kind {
            LoadCombination::PostEarthquake => {
                let open = opened.map_or(length, |opened| opened.get(joint.crack).copied().unwrap_or(length));
                Mode::Given([open.min(length), 0.0])
            }
            LoadCombination::Seismic => {
                let before = of(still.load).state(Mode::Static).cracks;
                Mode::Seismic { rule: wet.rule, before }
            }
            _ => Mode::Static,
        };
        let analysed = of(loaded.load);
        let state = analysed.state(mode);
        let line = analysed.uplift_line(mode, state.open);
        let turns = loaded.moments[1] + moment(&line, length);
        let authority = self.scene.stability.authority;
        let requirement = required(authority, kind);
        let own = self.scene.stability.required.as_ref().and_then(|required| required.factor(kind));
        let is_after = kind == LoadCombination::PostEarthquake;
        let of_authority = requirement.map(|requirement| match requirement.sliding_without_cohesion {
            Some(without) if peak.cohesion == 0.0 || is_after => without,
            _ => requirement.sliding,
        });
        JointStability {
            crack: joint.crack,
            length,
            combination: kind,
            name: self.name_of(combination, shock),
            shock,
            seismic,
            rule: uplift.as_ref().map(|uplift| uplift.rule),
            drained: uplift.as_ref().is_some_and(|uplift| uplift.drains.is_some()),
            load: loaded.load,
            state,
            sliding: [state.sliding_factor, state.sliding_factor_with(residual.friction, residual.cohesion)],
            overturning: (turns > 0.0).then(|| loaded.moments[0] / turns),
            requirement,
            required: own.or(of_authority),
            is_own: own.is_some(),
            by_residual: is_after || own.is_none() && authority == Authority::Cda && peak.cohesion == 0.0,
        }
    }

    /// What tables call a combination, after a shock in a run with several.
    fn name_of(&self, combination: &CombinationScene, shock: Option<usize>) -> String {
        let name = combination.name.clone().unwrap_or_else(|| combination.kind.label().to_owned());
        let shocks = self.scene.ground_motion.shocks();
        match shock.and_then(|shock| shocks.get(shock)) {
            Some(shock) => format!("{name}, after {}", shock.label),
            None => name,
        }
    }

    fn load_case(&self, combination: &CombinationScene, peak: f64) -> LoadCase {
        let scene = self.scene;
        let tailwater = |load: &StaticLoad| match load {
            StaticLoad::Tailwater(water) => Some(water.clone()),
            _ => None,
        };
        let loads = scene.static_loads().into_iter().map(|(_, load)| load);
        let still = loads.clone().find_map(|load| tailwater(&load));
        let depth = |side| scene.water(side).filter(|water| !water.is_empty()).map(|_| scene.depth_of(side));
        let upstream = combination.water_level.or(depth(Side::Upstream)).unwrap_or(0.0);
        let downstream = combination
            .tailwater_level
            .or(depth(Side::Downstream))
            .or(still.as_ref().map(|water| water.depth))
            .unwrap_or(0.0);
        let density = |side| scene.water(side).map_or(scene.reservoir.density, |water| water.density);
        let downstream_density = still.map_or(density(Side::Downstream), |water| water.density);
        let acts = |load: &StaticLoad| match load {
            StaticLoad::Tailwater(_) => false,
            StaticLoad::Ice(_) => combination.ice,
            _ => true,
        };
        let seismic = match combination.kind {
            LoadCombination::Seismic => {
                let default = [SUSTAINED * peak / scene.gravity, 0.0];
                scene.stability.seismic_coefficients.unwrap_or(default)
            }
            _ => [0.0; 2],
        };
        LoadCase {
            levels: [upstream, downstream],
            specific_weights: [density(Side::Upstream), downstream_density]
                .map(|density| density * scene.gravity),
            seismic,
            static_loads: loads.filter(acts).collect(),
        }
    }
}

/// How a joint is analysed.
#[derive(Clone, Copy)]
struct With<'a> {
    combination: &'a CombinationScene,
    seismic: [f64; 2],
    /// The joint without the earthquake.
    still: &'a LoadedJoint,
    opened: Option<&'a [f64]>,
    /// The shock after which it is, if there are several.
    shock: Option<usize>,
    /// The rule in place of that of the joint.
    rule: Option<Option<UpliftRule>>,
}

/// The combinations of the scene, or those by default.
fn combinations(scene: &Scene, has_drains: bool) -> Vec<CombinationScene> {
    if !scene.stability.combinations.is_empty() {
        return scene.stability.combinations.clone();
    }
    let mut found = vec![of_kind(LoadCombination::Usual)];
    if has_drains {
        let name = Some("drains out of service".to_owned());
        found.push(CombinationScene { name, drains: false, ..of_kind(LoadCombination::Unusual) });
    }
    found.extend([LoadCombination::Seismic, LoadCombination::PostEarthquake].map(of_kind));
    found
}

/// The loads of the scene as they are.
fn of_kind(kind: LoadCombination) -> CombinationScene {
    CombinationScene { name: None, kind, water_level: None, tailwater_level: None, drains: true, ice: true }
}
