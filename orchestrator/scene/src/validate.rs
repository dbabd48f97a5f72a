//! What the values of a scene mean together; what each may be by itself stands on its type.

mod ground;

use super::{
    AdaptiveScene, CrackScene, DamScene, DampingScene, Invalid, LoadsScene, OnFailure, ReservoirScene, Scene,
    Side, Source, StopQuantity, shape,
};
use cofferdam_coupling::scheme::SchemeKind;
use cofferdam_motion::GroundMotion;
pub use ground::Shaking;
use std::collections::BTreeSet;
use std::path::Path;

/// What a unit has to say against the values of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Keys that it rests on, such as `dam.cracks.0.elevation`; the first is the one to change.
    pub keys: Vec<String>,
    /// What is wrong, and the remedy.
    pub message: String,
}

/// How the units of a scene are asked whether they can be made. Each gets the scene with all defaults.
#[derive(Clone, Copy)]
pub struct UnitChecks {
    /// What the dam says.
    pub dam: fn(&Scene) -> Vec<Refusal>,
    /// What the reservoir says, before a dam that has nothing to say.
    pub reservoir: fn(&Scene) -> Vec<Refusal>,
}

/// What is wrong with the values of a scene, each with its key, and what moves the ground if it can be made.
///
/// Nothing is said about keys that are `unsound`, nor about what rests on them. The record is sought from `folder`.
pub fn judge(
    scene: &Scene,
    folder: &Path,
    unsound: BTreeSet<String>,
    units: &UnitChecks,
) -> (Vec<(String, Invalid)>, Option<Shaking>) {
    let mut findings = Findings { found: Vec::new(), unsound };
    // First, because what follows rests on its section.
    if scene.dam.is_some() {
        findings.refuse((units.dam)(scene));
    }
    findings.scene(scene);
    findings.files(scene, folder);
    let shaking = findings.ground_motion(scene, folder);
    let ground_motion = shaking.as_ref().map(|shaking| &shaking.motion);
    if let Some(motion) = ground_motion
        && findings.sound(&["time.communication_step", "time.duration", "time.quiet", "time.longest_quiet"])
    {
        let (duration, communication_step) = (duration(scene, motion), scene.time.communication_step);
        let steps = duration / communication_step;
        findings.at_most("time.communication_step", "communication steps", steps, 1e6);
        if let Some(adaptive) = scene.time.adaptive.filter(|_| findings.sound(&["time.adaptive"])) {
            let most = duration / adaptive.shortest;
            findings.at_most("time.adaptive.shortest", "communication steps", most, 1e6);
        }
        if whole_steps(steps) < 1.0 {
            findings.add("time.duration", Invalid::NoStep { duration, communication_step });
        }
    }
    findings.longest_quiet(scene, ground_motion);
    findings.reservoir(scene, ground_motion, units);
    (findings.found, shaking)
}

/// What is wrong with the values of a scene, the record and the units aside.
pub fn judge_without_record(scene: &Scene, unsound: BTreeSet<String>) -> Vec<(String, Invalid)> {
    let mut findings = Findings { found: Vec::new(), unsound };
    findings.scene(scene);
    findings.found
}

/// Simulated time, s: as the scene says, or until the ground has been quiet for long enough.
pub fn duration(scene: &Scene, motion: &GroundMotion) -> f64 {
    let end = motion.rest_from().unwrap_or(motion.duration());
    scene.time.duration.unwrap_or(end + scene.time.longest_quiet.unwrap_or(scene.time.quiet))
}

/// Communication steps that reach the end of so many.
pub fn whole_steps(steps: f64) -> f64 {
    (steps - 1e-9).ceil()
}

/// What was found wrong, each with the key whose place shows it.
struct Findings {
    found: Vec<(String, Invalid)>,
    /// Keys about which something was said; what rests on them would be wrong too.
    unsound: BTreeSet<String>,
}

impl Findings {
    fn add(&mut self, key: &str, invalid: Invalid) {
        self.found.push((key.to_owned(), invalid));
        self.unsound.insert(key.to_owned());
    }

    /// Whether nothing was said about these keys, about a part of them, or about what they are part of.
    fn sound(&self, keys: &[&str]) -> bool {
        let part = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let touches = |key: &&str| self.unsound.iter().any(|bad| part(key, bad) || part(bad, key));
        !keys.iter().any(touches)
    }

    fn within(&mut self, key: &str, value: f64, least: f64, most: f64) {
        if self.sound(&[key]) && !(least..=most).contains(&value) {
            self.add(key, Invalid::OutOfRange { key: key.to_owned(), value, least, most });
        }
    }

    /// A derived number that decides over time and memory.
    fn at_most(&mut self, key: &str, what: &'static str, number: f64, most: f64) {
        if number > most {
            self.add(key, Invalid::TooMany { key: key.to_owned(), what, number, most });
        }
    }

    fn exactly_one(&mut self, at: &str, first: &'static str, second: &'static str, given: [bool; 2]) {
        let found = given.into_iter().filter(|g| *g).count();
        if found != 1 {
            self.add(at, Invalid::ExactlyOne { first, second, found });
        }
    }

    /// The files of other programs' units.
    fn files(&mut self, scene: &Scene, folder: &Path) {
        for (table, source) in sources(scene) {
            let Some(file) = source.file() else { continue };
            let key =
                format!("{table}.{}.file", if matches!(source, Source::Fmu(_)) { "fmu" } else { "log" });
            let path = folder.join(file);
            if self.sound(&[&key])
                && let Err(cause) = std::fs::metadata(&path)
            {
                self.add(&key, Invalid::NoFile { path, cause });
            }
        }
    }

    /// Whether what computes a unit is told.
    fn sources(&mut self, scene: &Scene) {
        for (table, source) in sources(scene) {
            match source {
                Source::Untold(kind)
                    if self.sound(&[&format!("{table}.fidelity"), &format!("{table}.{kind}")]) =>
                {
                    let [key, table_name] = [format!("[{table}.{kind}]"), format!("`[{table}]`")];
                    let meaning = shape::Shape::field(&format!("{table}.{kind}"))
                        .map_or_else(String::new, shape::Field::summary);
                    self.add(
                        &format!("{table}.{kind}"),
                        Invalid::Missing { key, table: table_name, meaning },
                    );
                }
                Source::Command(command) if command.argv.first().is_none_or(String::is_empty) => {
                    self.add(&format!("{table}.command.argv"), Invalid::NoProgram);
                }
                _ => (),
            }
        }
        if sources(scene).iter().all(|(_, source)| matches!(source, Source::Log(_))) {
            self.add("dam.fidelity", Invalid::NothingButLogs);
        }
    }

    fn scene(&mut self, scene: &Scene) {
        self.printable("title".to_owned(), &scene.title);
        for (key, _, text) in scene.report.texts() {
            self.printable(format!("report.{key}"), text);
        }
        for (side, water) in scene.waters() {
            self.water(side, water);
        }
        self.emptiness(scene);
        self.sources(scene);
        self.stop(scene);
        self.snapshots(scene);
        if self.sound(&["dam", "prescribed"]) || scene.dam.is_some() && scene.prescribed.is_some() {
            let given = [scene.dam.is_some(), scene.prescribed.is_some()];
            self.exactly_one("prescribed", "[dam]", "[prescribed]", given);
        }
        if let Some(dam) = &scene.dam {
            self.dam(dam);
            for (side, _) in scene.waters() {
                let key = side.key("depth");
                if let Some([_, crest]) = dam.section.upstream.last()
                    && self.sound(&[&key, "dam.section.upstream"])
                {
                    let (depth, crest, least) = (scene.depth_of(side), *crest, SAME_LEVEL * crest);
                    if depth <= least {
                        self.add(&key.clone(), Invalid::WaterTooShallow { key, depth, crest, least });
                    }
                }
            }
        }
        for (side, water) in scene.waters() {
            self.interface(side, water, scene.depth_of(side));
        }
        if self.sound(&["coupling.measures"]) && scene.coupling.measures.is_empty() {
            self.add("coupling.measures", Invalid::NoMeasure);
        }
        self.stepping(scene);
        self.loads(scene);
    }

    /// Whether the static loads and the combinations of loads can act on the dam.
    fn loads(&mut self, scene: &Scene) {
        let mut refuse = |key: &str, message: String| self.add(key, Invalid::Unit { message });
        if scene.computed_dam().is_none() && scene.loads != LoadsScene::default() {
            refuse(
                "loads",
                "`loads` act on a dam that this program computes; give one, or leave them out".to_owned(),
            );
        }
        if let Some([horizontal, vertical]) = scene.stability.seismic_coefficients
            && !((0.0..=2.0).contains(&horizontal) && (-1.0..=1.0).contains(&vertical))
        {
            refuse(
                "stability.seismic_coefficients",
                format!(
                    "`stability.seismic_coefficients` are [{horizontal}, {vertical}]; give shares of g, from 0 to 2 downstream and \
                     from -1 to 1 downwards"
                ),
            );
        }
        let crest = scene.height();
        for (index, combination) in scene.stability.combinations.iter().enumerate() {
            for (name, level) in
                [("water_level", combination.water_level), ("tailwater_level", combination.tailwater_level)]
            {
                if let Some(level) = level.filter(|level| *level > crest) {
                    let key = format!("stability.combinations.{index}.{name}");
                    refuse(
                        &key,
                        format!(
                            "`{key}` is {level} m, above the crest at {crest} m; overtopping is not covered; give a lower level"
                        ),
                    );
                }
            }
        }
        if scene.tailwater.is_some() && scene.loads.tailwater.is_some() {
            let (first, second) = ("[tailwater]", "[loads.tailwater]");
            self.add("loads.tailwater", Invalid::ExactlyOne { first, second, found: 2 });
        }
        for (index, combination) in scene.stability.combinations.iter().enumerate() {
            let name = combination.name.as_deref().unwrap_or_default();
            self.printable(format!("stability.combinations.{index}.name"), name);
        }
    }

    /// Whether there is a rest to wait for.
    fn longest_quiet(&mut self, scene: &Scene, motion: Option<&GroundMotion>) {
        let Some(longest_quiet) = scene.time.longest_quiet else { return };
        let why = if scene.dam.is_none() && self.sound(&["dam", "prescribed"]) {
            "a prescribed dam moves with the ground; leave it out"
        } else if motion.is_some_and(|motion| motion.rest_from().is_none()) {
            "the ramp is held and the ground never stops; leave it out"
        } else if longest_quiet < scene.time.quiet && self.sound(&["time.quiet", "time.longest_quiet"]) {
            "`time.quiet` is longer; make it that or longer, or leave it out"
        } else {
            return;
        };
        self.add("time.longest_quiet", Invalid::LongestQuiet { longest_quiet, why });
    }

    /// What the reservoir says, before a dam that has nothing to say.
    fn reservoir(&mut self, scene: &Scene, motion: Option<&GroundMotion>, checks: &UnitChecks) {
        let mut scene = scene.clone();
        scene.time.duration = motion.map(|motion| duration(&scene, motion)).or(scene.time.duration);
        // Its points come from the dam's mesh, its length in time from the record.
        let face = ["dam", "prescribed", "reservoir", "tailwater", "gravity", "time", "ground_motion"];
        if self.found.is_empty() && self.sound(&face) && scene.time.duration.is_some() {
            self.refuse((checks.reservoir)(&scene));
        }
    }

    fn refuse(&mut self, refusals: Vec<Refusal>) {
        for Refusal { keys, message } in refusals {
            let rests_on: Vec<&str> = keys.iter().map(String::as_str).collect();
            if let Some(key) = keys.first()
                && self.sound(&rests_on)
            {
                self.add(key, Invalid::Unit { message });
            }
        }
    }

    /// The own values of the water on a side.
    fn water(&mut self, side: Side, water: &ReservoirScene) {
        let [depth, fidelity, waves] = ["depth", "fidelity", "surface_waves"].map(|name| side.key(name));
        if water.depth.is_none() && !water.is_empty() && self.sound(&[&depth, &fidelity]) {
            let (key, table) = ("`depth`".to_owned(), format!("`[{}]`", side.table()));
            let meaning = shape::Shape::field(&depth).map_or_else(String::new, shape::Field::summary);
            self.add(&depth, Invalid::Missing { key, table, meaning });
        }
        if water.surface_waves
            && water.fidelity.is_solved()
            && !water.fidelity.has_memory()
            && self.sound(&[&waves, &fidelity])
        {
            self.add(&waves, Invalid::WavesWithoutMemory { table: side.table() });
        }
    }

    /// Whether there is a dam or water to compute where the scene has a table for it.
    fn emptiness(&mut self, scene: &Scene) {
        if let Some(tailwater) = &scene.tailwater {
            if tailwater.is_empty() && self.sound(&["tailwater.fidelity"]) {
                self.add("tailwater.fidelity", Invalid::EmptyTailwater);
            }
            if scene.dam.is_none()
                && scene.prescribed.is_some()
                && self.sound(&["dam", "prescribed", "tailwater"])
            {
                self.add("tailwater", Invalid::NoDownstreamFace);
            }
        }
        let water = &scene.reservoir;
        if water.is_empty()
            && scene.prescribed.is_some()
            && scene.dam.is_none()
            && self.sound(&["reservoir.fidelity", "dam", "prescribed"])
        {
            self.add("reservoir.fidelity", Invalid::NothingToCompute);
        }
    }

    /// Whether the scheme, its window and steps that vary go together.
    fn stepping(&mut self, scene: &Scene) {
        if let Some(AdaptiveScene { shortest, longest, .. }) = scene.time.adaptive {
            let communication_step = scene.time.communication_step;
            if self.sound(&["time.adaptive", "time.communication_step"])
                && !(shortest..=longest).contains(&communication_step)
            {
                self.add("time.adaptive", Invalid::AdaptiveBounds { shortest, longest, communication_step });
            }
        }
        if !self.sound(&[
            "coupling.scheme",
            "reservoir.fidelity",
            "tailwater.fidelity",
            "dam",
            "time.adaptive",
            "coupling.on_failure",
        ]) {
            return;
        }
        let any = |has: fn(&ReservoirScene) -> bool| {
            scene.waters().find(|(_, water)| has(water)).map(|(side, _)| side)
        };
        let (scheme, empty) = (scene.scheme(), !scene.has_water() || scene.is_open_loop());
        let memory = any(|water| water.fidelity.has_memory()).is_some();
        let at_once = any(|water| water.fidelity.is_memoryless()).is_some();
        let halves = scene.coupling.on_failure == OnFailure::Halve;
        if halves && !scheme.is_implicit() && !empty {
            self.add("coupling.on_failure", Invalid::NothingToHalve);
        }
        let equal_steps = any(ReservoirScene::needs_equal_steps);
        for (key, varies) in
            [("time.adaptive", scene.time.adaptive.is_some()), ("coupling.on_failure", halves)]
        {
            if let Some(side) = equal_steps.filter(|_| varies) {
                self.add(key, Invalid::FixedStep { key, table: side.table() });
            }
        }
        if scheme == SchemeKind::OneWay {
            let why = match scene.dam {
                _ if memory => Some("compressible water has a memory that no mass has"),
                None => Some("a dam that is prescribed has no mass matrix"),
                Some(_) if scene.bed_presses() => Some(
                    "the bed moves the water, and an added mass of the dam does not represent that pressure",
                ),
                Some(_) => None,
            };
            if let Some(why) = why {
                self.add("coupling.scheme", Invalid::AddedMassScheme { why });
            }
        }
        let explicit = matches!(scheme, SchemeKind::SerialExplicit | SchemeKind::ParallelExplicit);
        if explicit && at_once && scene.dam.is_some() {
            self.add("coupling.scheme", Invalid::ExplicitAtOnce);
        }
        let tells_no_error = empty || matches!(scheme, SchemeKind::OneWay | SchemeKind::ParallelExplicit);
        if scene.time.adaptive.is_some() && equal_steps.is_none() && tells_no_error {
            self.add("time.adaptive", Invalid::AdaptiveScheme);
        }
        let window = scene.coupling.window;
        if window > 1 && self.sound(&["coupling.window"]) {
            let why = if scene.time.adaptive.is_some() || halves {
                Some("steps that vary are taken one by one")
            } else if !scheme.is_implicit() {
                Some("only implicit schemes iterate")
            } else {
                None
            };
            if let Some(why) = why {
                self.add("coupling.window", Invalid::Window { window, why });
            }
        }
    }

    /// The own panels of the water on a side.
    fn interface(&mut self, side: Side, water: &ReservoirScene, depth: f64) {
        let key = side.key("interface_size");
        if let Some(size) = water.interface_size
            && self.sound(&[&key, &side.key("depth")])
        {
            if size > depth {
                self.add(&key, Invalid::PanelTooLong { key: key.clone(), size, depth });
            }
            self.at_most(&key, "panels of the reservoir on the wet face", depth / size, 1000.0);
        }
    }

    /// Checks a text that terminals and XML show.
    fn printable(&mut self, key: String, text: &str) {
        let unprintable = |c: &char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
        if let Some(character) = text.chars().find(unprintable) {
            self.add(&key.clone(), Invalid::Unprintable { key, character });
        }
    }

    /// What a scene says in more than one key, and the dam in one.
    fn dam(&mut self, dam: &DamScene) {
        if dam.modes.is_some() && !dam.fidelity.has_modes() && self.sound(&["dam.fidelity"]) {
            self.add("dam.modes", Invalid::NoModes);
        }
        for (index, crack) in dam.cracks.iter().enumerate() {
            let table = format!("dam.cracks.{index}");
            let given = [crack.elevation.is_some(), crack.polyline.is_some()];
            if given == [true, true] || self.sound(&[&table, "dam.cracks.elevation", "dam.cracks.polyline"]) {
                self.exactly_one(&table, "elevation", "polyline", given);
            }
            self.printable(format!("{table}.name"), crack.name.as_deref().unwrap_or_default());
            // Two that are level lie in the same place, which the dam refuses.
            let can_be_told = crack.name.is_some() || crack.polyline.is_some();
            let has_results = !dam.fidelity.is_foreign() && !dam.fidelity.is_intact();
            let same = |other: &CrackScene| other.label() == crack.label();
            if let Some(first) = dam.cracks[..index].iter().position(same)
                && can_be_told
                && has_results
                && self.sound(&["dam.cracks.elevation", "dam.cracks.polyline"])
            {
                let same = Invalid::SameCracks { first, second: index, label: crack.label() };
                self.add(&format!("{table}.name"), same);
            }
        }
        for (index, zone) in dam.zones.iter().enumerate() {
            self.printable(format!("dam.zones.{index}.name"), &zone.name);
        }
        self.damping(&dam.damping);
    }

    fn snapshots(&mut self, scene: &Scene) {
        let Some(plan) = &scene.snapshots else { return };
        if let Some(until) = plan.until {
            self.within("snapshots.until", until, plan.from, f64::INFINITY);
        }
        if scene.dam.is_none() && self.sound(&["dam", "prescribed"]) {
            self.add("snapshots", Invalid::NothingToShow);
        }
    }

    fn stop(&mut self, scene: &Scene) {
        for (index, condition) in scene.stop.iter().enumerate() {
            let of = |name: &str| format!("stop.{index}.{name}");
            let quantity = condition.quantity;
            let of_crack =
                matches!(quantity, StopQuantity::Sliding | StopQuantity::Opening | StopQuantity::Rotation);
            let (dam, cracked) = match &scene.dam {
                Some(dam) => (true, !dam.cracks.is_empty()),
                None => (false, false),
            };
            let known = quantity.variable().is_none() || dam && (cracked || !of_crack);
            if !known && self.sound(&["dam", "dam.cracks", "prescribed"]) {
                let (key, quantity) = (of("quantity"), quantity.word());
                self.add(&key.clone(), Invalid::NothingToWatch { key, quantity });
            }
        }
    }

    fn damping(&mut self, damping: &DampingScene) {
        let pairs = [damping.multiples_of_first, damping.radians_per_second];
        let given = pairs.map(|pair| pair.is_some());
        let both = given == [true, true];
        let needed = damping.ratio != 0.0 && damping.model.has_frequencies();
        if both || needed && self.sound(&["dam.damping"]) {
            self.exactly_one("dam.damping", "multiples_of_first", "radians_per_second", given);
        }
    }
}

/// Who computes the units, each with its table.
fn sources(scene: &Scene) -> Vec<(&'static str, Source<'_>)> {
    let dam = scene.dam.iter().map(|dam| ("dam", dam.source()));
    dam.chain(scene.waters().map(|(side, water)| (side.table(), water.source()))).collect()
}

/// Elevations closer than this share of the height count as one.
const SAME_LEVEL: f64 = 1e-6;
