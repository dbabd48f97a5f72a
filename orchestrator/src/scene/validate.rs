//! What values a scene may have.

use super::record::STRONGEST;
use super::{
    AdaptiveScene, DamFidelityScene, DamScene, DampingModelScene, DampingScene, FidelityScene, GroundMotion,
    Invalid, MethodScene, OnFailure, RecordError, RecordScene, Scene, StopQuantity,
};
use crate::scheme::SchemeKind;
use std::collections::BTreeSet;
use std::path::Path;

/// What is wrong with the values of a scene, each with its key, and the ground motion if it can be made.
///
/// Nothing is said about keys that are `unsound`, nor about what rests on them. The record is sought from `folder`.
pub fn judge(
    scene: &Scene,
    folder: &Path,
    unsound: BTreeSet<String>,
) -> (Vec<(String, Invalid)>, Option<GroundMotion>) {
    let mut findings = Findings { found: Vec::new(), unsound };
    findings.scene(scene);
    let ground_motion = findings.ground_motion(scene, folder);
    if let Some(motion) = &ground_motion
        && findings.sound(&["time.communication_step", "time.duration", "time.quiet"])
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
    (findings.found, ground_motion)
}

/// What is wrong with the values of a scene, the record aside.
pub fn judge_without_record(scene: &Scene, unsound: BTreeSet<String>) -> Vec<(String, Invalid)> {
    let mut findings = Findings { found: Vec::new(), unsound };
    findings.scene(scene);
    findings.found
}

/// Simulated time, s: as the scene says, or until the ground has been quiet for long enough.
pub fn duration(scene: &Scene, motion: &GroundMotion) -> f64 {
    let end = motion.rest_from().unwrap_or(motion.duration());
    scene.time.duration.unwrap_or(end + scene.time.quiet)
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

    fn positive(&mut self, key: &str, value: f64) {
        if self.sound(&[key]) && !(value > 0.0 && value.is_finite()) {
            self.add(key, Invalid::NotPositive { key: key.to_owned(), value });
        }
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

    fn scene(&mut self, scene: &Scene) {
        // Neither a terminal nor XML takes them.
        let unprintable = |c: &char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
        if let Some(character) = scene.title.chars().find(unprintable) {
            self.add("title", Invalid::Title { character });
        }
        self.positive("gravity", scene.gravity);
        self.positive("time.communication_step", scene.time.communication_step);
        self.within("time.quiet", scene.time.quiet, 0.0, 1e6);
        if let Some(duration) = scene.time.duration {
            self.within("time.duration", duration, 0.0, 1e6);
        }
        self.water(scene);
        self.stop(scene);
        self.snapshots(scene);
        if self.sound(&["dam", "prescribed"]) || scene.dam.is_some() && scene.prescribed.is_some() {
            let given = [scene.dam.is_some(), scene.prescribed.is_some()];
            self.exactly_one("prescribed", "[dam]", "[prescribed]", given);
        }
        if let Some(dam) = &scene.dam {
            self.dam(dam);
            if let Some([_, crest]) = dam.section.upstream.last()
                && self.sound(&["reservoir.depth", "dam.section.upstream"])
            {
                let (depth, crest, least) = (scene.depth(), *crest, SAME_LEVEL * crest);
                if depth > crest {
                    self.add("reservoir.depth", Invalid::WaterAboveCrest { depth, crest });
                } else if depth <= least {
                    self.add("reservoir.depth", Invalid::WaterTooShallow { depth, crest, least });
                }
            }
            self.rows(dam, scene.depth());
        }
        self.interface(scene);
        self.boundary(scene);
        if let Some(prescribed) = &scene.prescribed {
            self.within("prescribed.batter", prescribed.batter, 0.0, 1e3);
        }
        let coupling = &scene.coupling;
        self.within("coupling.tolerance", coupling.tolerance, 1e-14, 0.1);
        if self.sound(&["coupling.measures"]) && coupling.measures.is_empty() {
            self.add("coupling.measures", Invalid::NoMeasure);
        }
        self.within("coupling.relaxation", coupling.relaxation, 1e-6, 1.5);
        self.stepping(scene);
    }

    /// The reservoir's own values.
    fn water(&mut self, scene: &Scene) {
        let water = &scene.reservoir;
        match water.depth {
            Some(depth) => self.within("reservoir.depth", depth, 1e-6, 1e4),
            None if water.fidelity != FidelityScene::Empty
                && self.sound(&["reservoir.depth", "reservoir.fidelity"]) =>
            {
                let [key, table, meaning] =
                    ["`depth`", "`[reservoir]`", "Depth of the water, m"].map(str::to_owned);
                self.add("reservoir.depth", Invalid::Missing { key, table, meaning });
            }
            None => {}
        }
        self.within("reservoir.density", water.density, 100.0, 1e5);
        self.within("reservoir.sound_speed", water.sound_speed, 1.0, 1e5);
        self.within("reservoir.wave_reflection_coefficient", water.wave_reflection_coefficient, 0.0, 1.0);
        for (key, value) in [
            ("reservoir.interface_size", water.interface_size),
            ("reservoir.element_size", water.element_size),
            ("reservoir.bed_element_size", water.bed_element_size),
            ("reservoir.corner_element_size", water.corner_element_size),
            ("reservoir.far_end_distance", water.far_end_distance),
        ] {
            if let Some(value) = value {
                self.positive(key, value);
            }
        }
        if self.sound(&["reservoir.bed", "reservoir.depth"]) {
            let depth = scene.depth();
            let stands = |index: usize| {
                let [x, y] = water.bed[index];
                let before = if index == 0 { [0.0, 0.0] } else { water.bed[index - 1] };
                x <= 0.0 && x.is_finite() && y < depth && y.is_finite() && [x, y] != before
            };
            if let Some(index) = (0..water.bed.len()).find(|index| !stands(*index)) {
                let [x, y] = water.bed[index];
                self.add(&format!("reservoir.bed.{index}"), Invalid::BedCorner { index, x, y, depth });
            }
        }
        if water.surface_waves
            && water.fidelity == FidelityScene::Incompressible
            && self.sound(&["reservoir.surface_waves", "reservoir.fidelity"])
        {
            self.add("reservoir.surface_waves", Invalid::WavesWithoutMemory);
        }
        if water.fidelity == FidelityScene::Empty
            && scene.prescribed.is_some()
            && scene.dam.is_none()
            && self.sound(&["reservoir.fidelity", "dam", "prescribed"])
        {
            self.add("reservoir.fidelity", Invalid::NothingToCompute);
        }
    }

    /// Whether the scheme, its window and steps that vary go together.
    fn stepping(&mut self, scene: &Scene) {
        if let Some(AdaptiveScene { tolerance, shortest, longest }) = scene.time.adaptive {
            self.within("time.adaptive.tolerance", tolerance, 1e-12, 1.0);
            self.positive("time.adaptive.shortest", shortest);
            self.positive("time.adaptive.longest", longest);
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
            "dam",
            "time.adaptive",
            "coupling.on_failure",
        ]) {
            return;
        }
        let (scheme, memory) = (scene.scheme(), scene.reservoir.fidelity.has_memory());
        let empty = scene.reservoir.fidelity == FidelityScene::Empty;
        let halves = scene.coupling.on_failure == OnFailure::Halve;
        if halves && !scheme.is_implicit() && !empty {
            self.add("coupling.on_failure", Invalid::NothingToHalve);
        }
        let equal_steps = memory && scene.reservoir.method != MethodScene::Recursive;
        for (key, varies) in
            [("time.adaptive", scene.time.adaptive.is_some()), ("coupling.on_failure", halves)]
        {
            if varies && equal_steps {
                self.add(key, Invalid::FixedStep { key });
            }
        }
        if scheme == SchemeKind::AddedMass {
            let why = match scene.dam {
                _ if memory => Some("compressible water has a memory that no mass has"),
                None => Some("a dam that is prescribed has no mass matrix"),
                Some(_) => None,
            };
            if let Some(why) = why {
                self.add("coupling.scheme", Invalid::AddedMassScheme { why });
            }
        }
        let tells_no_error = empty || matches!(scheme, SchemeKind::AddedMass | SchemeKind::ParallelExplicit);
        if scene.time.adaptive.is_some() && !equal_steps && tells_no_error {
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

    /// The reservoir's own panels on the wet face.
    fn interface(&mut self, scene: &Scene) {
        let key = "reservoir.interface_size";
        if let Some(size) = scene.reservoir.interface_size
            && self.sound(&[key, "reservoir.depth"])
        {
            let depth = scene.depth();
            if size > depth {
                self.add(key, Invalid::PanelTooLong { size, depth });
            }
            self.at_most(key, "panels of the reservoir on the wet face", depth / size, 1000.0);
        }
    }

    /// How many boundary elements there are.
    fn boundary(&mut self, scene: &Scene) {
        let water = &scene.reservoir;
        if self.sound(&[
            "reservoir.element_size",
            "reservoir.bed_element_size",
            "reservoir.bed",
            "reservoir.depth",
            "reservoir.far_end_distance",
            "reservoir.interface_size",
            "dam.element_size",
        ]) {
            let (size, far_end) = (scene.boundary_element_size(), scene.far_end_distance());
            let bed_size = water.bed_element_size.unwrap_or(size);
            let corners = std::iter::once([0.0, 0.0]).chain(water.bed.iter().copied());
            let lengths = corners.zip(&water.bed).map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]));
            let (bed, last) = (lengths.sum::<f64>(), water.bed.last().copied().unwrap_or_default());
            let depth = scene.depth();
            let surface = if water.surface_waves { far_end - last[0] } else { 0.0 };
            // Divided first: the sum may be too large for a number.
            let elements = depth / size
                + [depth - last[1], far_end, bed, surface]
                    .map(|length| length / bed_size)
                    .iter()
                    .sum::<f64>();
            let key = match (water.far_end_distance, water.element_size) {
                _ if bed_size < size => "reservoir.bed_element_size",
                _ if bed > 2.0 * depth.max(far_end) => "reservoir.bed",
                (Some(_), _) if far_end > 2.0 * depth => "reservoir.far_end_distance",
                (_, None) if size < depth / 16.0 => match water.interface_size {
                    Some(_) => "reservoir.interface_size",
                    None => "dam.element_size",
                },
                _ => "reservoir.element_size",
            };
            self.at_most(key, "boundary elements of the reservoir", elements, 2000.0);
        }
    }

    fn dam(&mut self, dam: &DamScene) {
        self.positive("dam.element_size", dam.element_size);
        self.within("dam.time_step_safety", dam.time_step_safety, 1e-3, 1.0);
        let material = &dam.material;
        self.within("dam.material.young_modulus", material.young_modulus, 1e6, 1e13);
        self.within("dam.material.poisson_ratio", material.poisson_ratio, 0.0, 0.499);
        self.within("dam.material.density", material.density, 100.0, 1e5);
        self.damping(&dam.damping);
        self.fidelity(dam);
        self.section(dam);
        let Some([_, crest]) = dam.section.upstream.last().copied() else { return };
        let size = dam.element_size;
        if self.sound(&["dam.element_size", "dam.section.upstream"]) && size > crest {
            self.add("dam.element_size", Invalid::ElementTooLarge { size, crest });
        }
        for (index, crack) in dam.cracks.iter().enumerate() {
            let key = |name: &str| format!("dam.cracks.{index}.{name}");
            self.within(&key("friction_coefficient"), crack.friction_coefficient, 0.0, 5.0);
            if let Some(residual) = crack.residual_friction_coefficient {
                let peak = crack.friction_coefficient.clamp(0.0, 5.0);
                self.within(&key("residual_friction_coefficient"), residual, 0.0, peak);
            }
            self.within(&key("cohesion"), crack.cohesion, 0.0, 1e12);
            self.within(&key("tensile_strength"), crack.tensile_strength, 0.0, 1e12);
            self.within(&key("dilation"), crack.dilation, 0.0, 1.0);
            if let Some(slip) = crack.dilation_slip {
                self.within(&key("dilation_slip"), slip, 0.0, 1e3);
            }
            self.positive(&key("normal_stiffness"), crack.normal_stiffness);
            self.positive(&key("shear_stiffness"), crack.shear_stiffness);
            let (key, elevation) = (key("elevation"), crack.elevation);
            let inside = elevation > SAME_LEVEL * crest && elevation < (1.0 - SAME_LEVEL) * crest;
            if self.sound(&[&key, "dam.section.upstream"]) && !inside {
                self.add(&key, Invalid::CrackOutside { key: key.clone(), elevation, crest });
            }
            let near = |other: &&super::CrackScene| (other.elevation - elevation).abs() <= SAME_LEVEL * crest;
            if let Some(other) = dam.cracks[..index].iter().find(near)
                && self.sound(&[&key])
            {
                let other = other.elevation;
                self.add(&key, Invalid::CracksCoincide { key: key.clone(), elevation, other });
            }
        }
    }

    /// Rows of elements end at vertices, cracks and the water level; two of these close together make flat
    /// elements, whose time step is next to nothing.
    fn rows(&mut self, dam: &DamScene, depth: f64) {
        let sides = dam.section.upstream.iter().chain(&dam.section.downstream);
        let crest = dam.section.upstream.last().map_or(0.0, |p| p[1]);
        let mut levels: Vec<(f64, String)> = sides.map(|p| (p[1], "dam.section".to_owned())).collect();
        levels.push((depth, "reservoir.depth".to_owned()));
        let cracks = dam.cracks.iter().enumerate();
        levels.extend(cracks.map(|(i, crack)| (crack.elevation, format!("dam.cracks.{i}.elevation"))));
        levels.retain(|(_, key)| self.sound(&[key]));
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        if !self.sound(&["dam.element_size"]) {
            return;
        }
        let least = THINNEST_ROW * dam.element_size;
        for pair in levels.windows(2) {
            let [(lower, below), (upper, above)] = pair else { continue };
            if upper - lower > SAME_LEVEL * crest && upper - lower < least {
                let key = if above == "dam.section" { below } else { above };
                self.add(key, Invalid::ThinRow { lower: *lower, upper: *upper, least });
            }
        }
        if !self.sound(&["dam.element_size", "dam.section"]) {
            return;
        }
        let area = area_below(&dam.section.downstream) - area_below(&dam.section.upstream);
        let elements = 4.0 * area / (dam.element_size * dam.element_size);
        self.at_most("dam.element_size", "elements of the dam", elements, 1e6);
    }

    fn snapshots(&mut self, scene: &Scene) {
        let Some(plan) = &scene.snapshots else { return };
        self.within("snapshots.interval", plan.interval, SHORTEST, LATEST);
        self.within("snapshots.from", plan.from, 0.0, LATEST);
        if let Some(until) = plan.until {
            self.within("snapshots.until", until, plan.from, LATEST);
        }
        if scene.dam.is_none() && self.sound(&["dam", "prescribed"]) {
            self.add("snapshots", Invalid::NothingToShow);
        }
    }

    fn stop(&mut self, scene: &Scene) {
        for (index, condition) in scene.stop.iter().enumerate() {
            let of = |name: &str| format!("stop.{index}.{name}");
            self.positive(&of("above"), condition.above);
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

    fn fidelity(&mut self, dam: &DamScene) {
        if !self.sound(&["dam.fidelity"]) {
            return;
        }
        if dam.modes.is_some() && !dam.fidelity.has_modes() {
            self.add("dam.modes", Invalid::NoModes);
        }
        if dam.fidelity == DamFidelityScene::RigidBlocks
            && dam.cracks.is_empty()
            && self.sound(&["dam.cracks"])
        {
            self.add("dam.fidelity", Invalid::RigidWithoutCrack);
        }
        let local = dam.damping.model == DampingModelScene::Local && dam.damping.ratio > 0.0;
        if local && dam.fidelity != DamFidelityScene::Dem && self.sound(&["dam.damping"]) {
            let fidelity = dam.fidelity.word();
            self.add("dam.damping.model", Invalid::LocalDampingOfModes { fidelity });
        }
    }

    fn damping(&mut self, damping: &DampingScene) {
        // a local coefficient of π times the ratio stays below 1
        let most = if damping.model == DampingModelScene::Local { 0.3 } else { 0.999 };
        self.within("dam.damping.ratio", damping.ratio, 0.0, most);
        let pairs = [
            ("dam.damping.multiples_of_first", damping.multiples_of_first),
            ("dam.damping.radians_per_second", damping.radians_per_second),
        ];
        for (key, pair) in pairs {
            if let Some([low, high]) = pair
                && self.sound(&[key])
                && !(low > 0.0 && high > low && high.is_finite())
            {
                self.add(key, Invalid::Frequencies { key: key.to_owned(), low, high });
            }
        }
        let given = pairs.map(|(_, pair)| pair.is_some());
        let both = given == [true, true];
        let needed = damping.ratio != 0.0 && damping.model != DampingModelScene::Local;
        if both || needed && self.sound(&["dam.damping"]) {
            self.exactly_one("dam.damping", "multiples_of_first", "radians_per_second", given);
        }
    }

    fn section(&mut self, dam: &DamScene) {
        let sides = [
            ("dam.section.upstream", &dam.section.upstream),
            ("dam.section.downstream", &dam.section.downstream),
        ];
        if let Some(&[x, y]) = dam.section.upstream.first()
            && self.sound(&["dam.section.upstream"])
            && (x, y) != (0.0, 0.0)
        {
            self.add("dam.section.upstream", Invalid::NotAtHeel { x, y });
        }
        for (key, side) in sides {
            if !self.sound(&[key]) {
                continue;
            }
            if side.len() < 2 {
                self.add(key, Invalid::SideTooShort { key: key.to_owned(), points: side.len() });
            }
            let follows = |index: usize| {
                if index == 0 { side[0][1] == 0.0 } else { side[index][1] > side[index - 1][1] }
            };
            let wrong = |index: &usize| !(follows(*index) && side[*index].iter().all(|c| c.is_finite()));
            if let Some(index) = (0..side.len()).find(wrong) {
                let [x, y] = side[index];
                self.add(key, Invalid::SideNotAscending { key: key.to_owned(), index, x, y });
            }
        }
        if !self.sound(&["dam.section"]) {
            return;
        }
        let top = |side: &[[f64; 2]]| side[side.len() - 1][1];
        let (upstream, downstream) = (&dam.section.upstream, &dam.section.downstream);
        let elevations = upstream.iter().chain(downstream).map(|p| p[1]);
        let width = |y: f64| side_at(downstream, y) - side_at(upstream, y);
        let crossing = elevations.filter(|y| width(*y) <= 0.0).reduce(f64::min);
        let uneven = (top(upstream) != top(downstream)).then(|| top(upstream).min(top(downstream)));
        if let Some(elevation) = crossing.or(uneven) {
            self.add("dam.section", Invalid::SidesCross { elevation, width: width(elevation) });
        }
    }

    fn ground_motion(&mut self, scene: &Scene, folder: &Path) -> Option<GroundMotion> {
        let motion = &scene.ground_motion;
        if let Some(ramp) = &motion.ramp {
            self.within("ground_motion.ramp.acceleration", ramp.acceleration, -STRONGEST, STRONGEST);
            self.positive("ground_motion.ramp.rise", ramp.rise);
        }
        if let Some(record) = &motion.record {
            self.within("ground_motion.record.scale", record.scale, 1e-6, 1e6);
            self.within("ground_motion.record.start", record.start, 0.0, 1e6);
            if self.sound(&["ground_motion.record.start"]) {
                let end = record.end.unwrap_or(f64::INFINITY);
                self.within("ground_motion.record.end", end, record.start, f64::INFINITY);
            }
            if self.sound(&["ground_motion.record.polarity"]) && !matches!(record.polarity, 1 | -1) {
                self.add("ground_motion.record.polarity", Invalid::Polarity { value: record.polarity });
            }
        }
        let given = [motion.record.is_some(), motion.ramp.is_some()];
        if given == [true, true] || self.sound(&["ground_motion"]) {
            self.exactly_one("ground_motion.ramp", "[ground_motion.record]", "[ground_motion.ramp]", given);
        }
        match (&motion.record, &motion.ramp) {
            (Some(record), None) => self.record(scene, record, folder),
            (None, Some(ramp)) => {
                if scene.time.duration.is_none() && self.sound(&["time.duration"]) {
                    self.add("ground_motion.ramp", Invalid::DurationMissing);
                }
                if !self.sound(&["ground_motion.ramp.rise", "ground_motion.ramp.acceleration"]) {
                    return None;
                }
                self.sampling(scene, ramp.rise);
                Some(GroundMotion::ramp(ramp.acceleration, ramp.rise))
            }
            _ => None,
        }
    }

    fn record(&mut self, scene: &Scene, record: &RecordScene, folder: &Path) -> Option<GroundMotion> {
        let key = |name: &str| format!("ground_motion.record.{name}");
        if ["file", "start", "end"].iter().any(|name| !self.sound(&[&key(name)])) {
            return None;
        }
        let end = record.end.unwrap_or(f64::INFINITY);
        // The interval can be judged whatever the factor is.
        let sound = self.sound(&[&key("scale"), &key("polarity")]);
        let factor = if sound { record.scale * record.polarity as f64 } else { 1.0 };
        match GroundMotion::from_record(&folder.join(&record.file), record.start, end, factor) {
            Ok(ground_motion) => {
                self.sampling(scene, ground_motion.interval());
                Some(ground_motion)
            }
            Err(error) => {
                let key = match error {
                    RecordError::Crop { .. } if record.end.is_some() => "ground_motion.record.end",
                    RecordError::Crop { .. } => "ground_motion.record.start",
                    RecordError::TooStrong { .. } if record.scale != 1.0 => "ground_motion.record.scale",
                    _ => "ground_motion.record.file",
                };
                self.add(key, error.into());
                None
            }
        }
    }

    /// The units see the ground at communication points only: these must not be further apart than the samples.
    fn sampling(&mut self, scene: &Scene, interval: f64) {
        let longest = scene.time.adaptive.map(|adaptive| ("time.adaptive.longest", adaptive.longest));
        for (key, communication_step) in
            std::iter::once(("time.communication_step", scene.time.communication_step)).chain(longest)
        {
            if self.sound(&[key]) && communication_step > (1.0 + 1e-9) * interval {
                self.add(key, Invalid::Undersampled { key, communication_step, interval });
            }
        }
    }
}

/// Time from one picture to the next, s, that is never too long, and time that none needs to be later than.
const SHORTEST: f64 = 1e-6;
const LATEST: f64 = 1e6;
/// Elevations closer than this share of the height count as one.
const SAME_LEVEL: f64 = 1e-6;
/// Least height of a row of elements over their nominal size.
const THINNEST_ROW: f64 = 0.1;

/// Area between a side and the y axis, m².
fn area_below(side: &[[f64; 2]]) -> f64 {
    side.windows(2).map(|s| 0.5 * (s[0][0] + s[1][0]) * (s[1][1] - s[0][1])).sum()
}

/// x of a side at elevation `y`, m; beyond its ends that of the end.
fn side_at(side: &[[f64; 2]], y: f64) -> f64 {
    let above = side.iter().position(|p| p[1] >= y).unwrap_or(side.len() - 1);
    if above == 0 {
        return side[0][0];
    }
    let ([x0, y0], [x1, y1]) = (side[above - 1], side[above]);
    x0 + ((y - y0) / (y1 - y0)).min(1.0) * (x1 - x0)
}
