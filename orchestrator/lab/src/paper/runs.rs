//! The runs: each figure's scene as it is, and with other choices where the paper leaves them open.

use super::response::Response;
use super::statements::{Earthquake, FLEXIBLE, RIGID};
use crate::study::{StudyError, run_each, unfit};
use cofferdam_assembly::read_scene;
use cofferdam_motion::{GroundMotion, STANDARD_GRAVITY};
use cofferdam_scene::{LoadedScene, OnFailure, PrescribedScene};
use std::path::{Path, PathBuf};

/// Distance of the far end of the finite elements, over the depth of the water.
const FAR: f64 = 4.0;
/// Of a coarse run: time before and after the strongest shaking, s; and size of elements, m.
const COARSE: [f64; 3] = [1.0, 0.75, 10.0];

/// Runs that do not belong to an open choice, and the run with all open choices combined.
pub const RIGID_DAM: &str = "rigid dam";
pub const FINITE_ELEMENTS: &str = "water of finite elements";
pub const ADDED_MASS: &str = "Westergaard's added mass";
const TOGETHER: &str = "those with the least sliding together";
const AS_IT_IS: &str = "as it is";

/// A run: its changes, its earthquake and, once completed, its results.
pub struct Run {
    /// The changes.
    pub what: String,
    /// The open choice to which it belongs; `None` for other runs.
    pub choice: Option<&'static str>,
    sets: Vec<String>,
    pub loaded: LoadedScene,
    pub response: Response,
}

/// Runs of one scene, the first one as it is.
pub struct Series {
    path: PathBuf,
    sets: Vec<String>,
    /// Whether the record is the user's.
    given: bool,
    pub runs: Vec<Run>,
}

impl Series {
    /// The scene `name` in `folder`, with the user's `record`, if there is one; a `coarse` one is short.
    ///
    /// **Errors**: every mistake of the scene; a record that cannot be used, with the `option` that names it.
    fn new(
        folder: &Path,
        name: &str,
        record: Option<&PathBuf>,
        option: &'static str,
        coarse: bool,
    ) -> Result<Self, StudyError> {
        let path = folder.join(name);
        let mut sets = Vec::new();
        if let Some(record) = record {
            GroundMotion::from_record(record, None, 0.0, f64::INFINITY, 1.0)
                .map_err(|cause| StudyError::Record { option, cause: Box::new(cause) })?;
            let file = std::path::absolute(record).unwrap_or_else(|_| record.clone());
            let file = toml::Value::String(file.to_string_lossy().into_owned());
            sets.push(format!("ground_motion.record={{file={file}}}"));
        }
        let loaded = read_scene(&path, &sets)?;
        if loaded.scene.ground_motion.record.is_none() || loaded.scene.dam.is_none() {
            return Err(unfit(format!("{name}: the study needs a dam that is computed, and a record")));
        }
        if coarse {
            let [before, after, element] = COARSE;
            let motion = &loaded.ground_motion;
            let (_, strongest) = motion.peak();
            let [start, end] = [(strongest - before).max(0.0), (strongest + after).min(motion.duration())];
            sets.extend([
                format!("ground_motion.record.start={start}"),
                format!("ground_motion.record.end={end}"),
                "time.quiet=0".into(),
                format!("dam.element_size={element}"),
            ]);
        }
        let mut series = Self { path, sets, given: record.is_some(), runs: Vec::new() };
        series.add(AS_IT_IS, None, Vec::new())?;
        Ok(series)
    }

    /// Adds the run with `sets` after those of all runs.
    fn add(
        &mut self,
        what: &str,
        choice: Option<&'static str>,
        sets: Vec<String>,
    ) -> Result<&mut Run, StudyError> {
        let mut loaded = read_scene(&self.path, &[&self.sets[..], &sets].concat())?;
        // A step that stays above its tolerance must not end the study; the text gives their number.
        loaded.scene.coupling.on_failure = OnFailure::Continue;
        let index = self.runs.len();
        self.runs.push(Run { what: what.to_owned(), choice, sets, loaded, response: Response::default() });
        Ok(&mut self.runs[index])
    }

    /// Adds the water of finite elements.
    fn add_finite_elements(&mut self) -> Result<(), StudyError> {
        let distance = FAR * self.base().loaded.scene.depth();
        let sets = vec![
            "reservoir.method=\"finite-elements\"".to_owned(),
            format!("reservoir.far_end_distance={distance}"),
        ];
        self.add(FINITE_ELEMENTS, None, sets).map(drop)
    }

    /// Adds the dam held rigid.
    fn add_rigid(&mut self) -> Result<(), StudyError> {
        let scene = &mut self.add(RIGID_DAM, None, Vec::new())?.loaded.scene;
        let depth = scene.depth();
        if let Some(dam) = scene.dam.take() {
            let panels = (depth / dam.element_size).ceil().max(1.0) as usize;
            scene.prescribed = Some(PrescribedScene { batter: 0.0, panels });
        }
        Ok(())
    }

    /// The scene as it is.
    pub fn base(&self) -> &Run {
        &self.runs[0]
    }

    /// The run `what`; the scene as it is without one.
    pub fn run(&self, what: &str) -> &Run {
        self.runs.iter().find(|run| run.what == what).unwrap_or(self.base())
    }

    /// Those of the open choices, the scene as it is first.
    pub fn choices(&self) -> impl Iterator<Item = &Run> {
        std::iter::once(self.base()).chain(self.runs.iter().filter(|run| run.choice.is_some()))
    }

    /// Largest acceleration of the ground, g.
    pub fn ground(&self) -> f64 {
        self.base().loaded.ground_motion.peak().0.abs() / STANDARD_GRAVITY
    }

    /// Whose record moves the ground, and how far it is the paper's; the latter has a peak of `paper` (g), if it is stated.
    pub fn source(&self, name: &str, paper: Option<f64>, missing: &str) -> String {
        let (file, peak) = (self.base().loaded.ground_motion.source(), self.ground());
        match (self.given, paper) {
            (true, Some(paper)) => {
                format!("{name}: the user's {file}, peak {peak:.3} g, where the paper's has {paper} g")
            }
            (true, None) => format!("{name}: the user's {file}, peak {peak:.3} g"),
            (false, _) => {
                format!(
                    "{name}: {file} with a peak of {peak:.3} g stands in for the paper's record ({missing})"
                )
            }
        }
    }
}

/// Figure 3: both orders of the boundary elements, and other rises.
pub fn rigid_dam(folder: &Path, coarse: bool) -> Result<Series, StudyError> {
    let path = folder.join(RIGID);
    let mut sets = vec!["reservoir.method=\"radau2\"".to_owned()];
    if coarse {
        sets.push("time.duration=0.75".to_owned());
    }
    let loaded = read_scene(&path, &sets)?;
    let Some(ramp) = loaded.scene.ground_motion.ramp.filter(|_| loaded.scene.dam.is_none()) else {
        return Err(unfit(format!("{RIGID}: figure 3 needs a prescribed dam under a ramp")));
    };
    let mut series = Series { path, sets, given: false, runs: Vec::new() };
    for order in ["constant", "linear"] {
        series.add(order, None, vec![format!("reservoir.element_order={order:?}")])?;
    }
    let rises: &[f64] = if coarse { &[] } else { &[0.5, 2.0, 5.0] };
    for factor in rises {
        let rise = factor * ramp.rise;
        series.add(
            &format!("linear, rise {rise} s"),
            Some("rise"),
            vec![format!("ground_motion.ramp.rise={rise}")],
        )?;
    }
    Ok(series)
}

/// Figure 4: boundary and finite elements, a rigid dam, and other moduli and damping.
pub fn flexible_dam(folder: &Path, record: Option<&PathBuf>, coarse: bool) -> Result<Series, StudyError> {
    let [name, _, option] = FLEXIBLE;
    let mut series = Series::new(folder, name, record, option, coarse)?;
    series.add_finite_elements()?;
    series.add_rigid()?;
    let Some(dam) = series.base().loaded.scene.dam.clone() else { return Ok(series) };
    if !coarse {
        for (what, factor) in [("half the modulus", 0.5), ("twice the modulus", 2.0)] {
            let modulus = factor * dam.material.young_modulus;
            series.add(what, Some("modulus"), vec![format!("dam.material.young_modulus={modulus:e}")])?;
        }
        series.add("damping 1 %", Some("damping"), vec!["dam.damping.ratio=0.01".to_owned()])?;
    }
    Ok(series)
}

/// Figures 7 to 13: the cracked dam under one of the earthquakes.
pub fn cracked_dam(
    folder: &Path,
    earthquake: &Earthquake,
    record: Option<&PathBuf>,
    coarse: bool,
) -> Result<Series, StudyError> {
    let mut series = Series::new(folder, earthquake.scene, record, earthquake.option, coarse)?;
    let scene = series.base().loaded.scene.clone();
    let (Some(dam), Some(record)) = (&scene.dam, &scene.ground_motion.record) else { return Ok(series) };
    let [crack] = &dam.cracks[..] else {
        return Err(unfit(format!("{}: the study needs a dam with one crack", earthquake.scene)));
    };
    series.add_rigid()?;
    series.add_finite_elements()?;
    series.add(ADDED_MASS, None, vec!["reservoir.fidelity=\"westergaard\"".to_owned()])?;
    if (series.ground() / earthquake.ground - 1.0).abs() > 0.005 {
        let scale = record.scale * earthquake.ground / series.ground();
        series.add(
            "scaled to the paper's peak",
            None,
            vec![format!("ground_motion.record.scale={scale}")],
        )?;
    }
    let joints = |factor: f64| {
        [("normal", crack.normal_stiffness), ("shear", crack.shear_stiffness)]
            .map(|(kind, stiffness)| format!("dam.cracks.0.{kind}_stiffness={:e}", factor * stiffness))
            .to_vec()
    };
    let one = |set: &str| vec![set.to_owned()];
    let mut choices = vec![
        (
            "polarity reversed",
            "polarity",
            vec![format!("ground_motion.record.polarity={}", -record.polarity)],
        ),
        ("damping of mass alone", "damping", one("dam.damping.model=\"mass\"")),
    ];
    if !coarse {
        choices.extend([
            ("damping of stiffness alone", "damping", one("dam.damping.model=\"stiffness\"")),
            ("damping held at ω₁ and 20 ω₁", "damping", one("dam.damping.multiples_of_first=[1.0, 20.0]")),
            ("damping that drags blocks", "drag", one("dam.damping.drags_blocks=true")),
            ("plane strain", "plane", one("dam.material.plane=\"strain\"")),
            ("contacts at Gauss points", "contacts", one("dam.cracks.0.integration=\"gauss\"")),
            ("crack a tenth as stiff", "stiffness", joints(0.1)),
            ("crack ten times as stiff", "stiffness", joints(10.0)),
            ("elements half as long", "mesh", vec![format!("dam.element_size={}", 0.5 * dam.element_size)]),
        ]);
    }
    for (what, choice, sets) in choices {
        series.add(what, Some(choice), sets)?;
    }
    Ok(series)
}

/// Runs what has not run yet, on all cores.
///
/// **Errors**: a unit cannot be made, or a run ends early.
pub fn solve(series: &mut [&mut Series]) -> Result<(), StudyError> {
    let mut open: Vec<&mut Run> = series
        .iter_mut()
        .flat_map(|series| &mut series.runs)
        .filter(|run| run.response.time().is_empty())
        .collect();
    let scenes: Vec<&LoadedScene> = open.iter().map(|run| &run.loaded).collect();
    let names: Vec<&str> = open.iter().map(|run| &*run.what).collect();
    let responses = run_each(&scenes, |index, outcome| {
        let what = format!("{}, {}", scenes[index].name, names[index]);
        Ok(Response::of(scenes[index], &outcome.completed(&what)?))
    })?;
    for (run, response) in open.iter_mut().zip(responses) {
        run.response = response;
    }
    Ok(())
}

impl Series {
    /// Adds the run with every open choice, but for the mesh, as it slides least, if any of them slides less than the scene.
    ///
    /// **Errors**: the scene is refused.
    pub fn add_together(&mut self) -> Result<(), StudyError> {
        let slid = |run: &Run| run.response.residual.abs();
        let mut least: Vec<&Run> = Vec::new();
        for run in self.runs.iter().filter(|run| run.choice.is_some_and(|choice| choice != "mesh")) {
            match least.iter_mut().find(|other| other.choice == run.choice) {
                Some(other) if slid(run) < slid(other) => *other = run,
                Some(_) => {}
                None => least.push(run),
            }
        }
        least.retain(|run| slid(run) < slid(self.base()));
        if least.is_empty() {
            return Ok(());
        }
        let sets = least.iter().flat_map(|run| run.sets.clone()).collect();
        self.add(TOGETHER, Some("together"), sets).map(drop)
    }
}
