use super::locate::locate;
use super::{DamScene, DampingScene, GroundMotion, Invalid, Scene, SceneError, SceneProblem};
use miette::NamedSource;
use std::path::Path;
use std::sync::Arc;

/// Parses a scene, fills in the defaults, reads its ground motion, and reports every problem.
pub fn parse(source: &str, folder: &Path, file: &Path) -> Result<(Scene, GroundMotion), SceneError> {
    let source = Arc::new(source.to_owned());
    let problem = |invalid, span: Option<std::ops::Range<usize>>| SceneProblem {
        invalid,
        source_code: NamedSource::new(file.to_string_lossy(), source.clone()).with_language("TOML"),
        span: span.map(Into::into),
    };
    let failed = |problems| SceneError { path: file.to_owned(), problems };
    let mut scene: Scene = toml::from_str(&source).map_err(|e| {
        let invalid = Invalid::Syntax { message: e.message().to_owned() };
        failed(vec![problem(invalid, e.span())])
    })?;
    let mut findings = Findings::default();
    findings.scene(&scene);
    let ground_motion = findings.ground_motion(&scene, folder);
    if let Some(motion) = &ground_motion {
        let steps = scene.duration(motion) / scene.time.communication_step;
        findings.at_most("time.communication_step", "communication steps", steps, 1e6);
    }
    match ground_motion {
        Some(ground_motion) if findings.0.is_empty() => {
            if let Some(dam) = &mut scene.dam {
                // The order in which the dam's results come.
                dam.cracks.sort_by(|a, b| a.elevation.total_cmp(&b.elevation));
            }
            scene.time.duration = Some(scene.duration(&ground_motion));
            let reservoir = &mut scene.reservoir;
            let panel = scene.dam.as_ref().map_or(f64::INFINITY, |dam| dam.element_size);
            reservoir.element_size.get_or_insert(panel.min(reservoir.depth / 16.0));
            reservoir.far_end_distance.get_or_insert(reservoir.depth / 2.0);
            if let Some(record) = &mut scene.ground_motion.record {
                // So that the resolved scene can be run from anywhere.
                let file = folder.join(&record.file);
                record.file = file.canonicalize().unwrap_or(file);
            }
            Ok((scene, ground_motion))
        }
        _ => {
            let located = |(key, invalid): (String, Invalid)| problem(invalid, locate(&source, &key));
            Err(failed(findings.0.into_iter().map(located).collect()))
        }
    }
}

/// What was found wrong, each with the key whose place shows it.
#[derive(Default)]
struct Findings(Vec<(String, Invalid)>);

impl Findings {
    fn add(&mut self, key: &str, invalid: Invalid) {
        self.0.push((key.to_owned(), invalid));
    }

    fn positive(&mut self, key: &str, value: f64) {
        if !(value > 0.0 && value.is_finite()) {
            self.add(key, Invalid::NotPositive { key: key.to_owned(), value });
        }
    }

    fn within(&mut self, key: &str, value: f64, least: f64, most: f64) {
        if !(least..=most).contains(&value) {
            self.add(key, Invalid::OutOfRange { key: key.to_owned(), value, least, most });
        }
    }

    fn count(&mut self, key: &str, value: u64, least: u64, most: u64) {
        if !(least..=most).contains(&value) {
            self.add(key, Invalid::Count { key: key.to_owned(), value, least, most });
        }
    }

    /// A derived number that decides over time and memory.
    fn at_most(&mut self, key: &str, what: &'static str, number: f64, most: f64) {
        if number.is_finite() && number > most {
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
        self.positive("gravity", scene.gravity);
        self.positive("time.communication_step", scene.time.communication_step);
        self.within("time.quiet", scene.time.quiet, 0.0, 1e6);
        if let Some(duration) = scene.time.duration {
            self.positive("time.duration", duration);
        }
        let water = &scene.reservoir;
        self.positive("reservoir.depth", water.depth);
        self.within("reservoir.density", water.density, 100.0, 1e5);
        self.within("reservoir.sound_speed", water.sound_speed, 1.0, 1e5);
        self.within("reservoir.wave_reflection_coefficient", water.wave_reflection_coefficient, 0.0, 1.0);
        for (key, value) in [
            ("reservoir.element_size", water.element_size),
            ("reservoir.far_end_distance", water.far_end_distance),
        ] {
            if let Some(value) = value {
                self.positive(key, value);
            }
        }
        let size = water.element_size.unwrap_or(water.depth / 16.0);
        let boundary = (2.0 * water.depth + water.far_end_distance.unwrap_or(water.depth / 2.0)) / size;
        self.at_most("reservoir.element_size", "boundary elements of the reservoir", boundary, 2000.0);
        self.exactly_one("title", "[dam]", "[prescribed]", [scene.dam.is_some(), scene.prescribed.is_some()]);
        if let Some(dam) = &scene.dam {
            self.dam(dam);
            self.rows(dam, water.depth);
            if let Some([_, crest]) = dam.section.upstream.last()
                && water.depth > *crest
            {
                let invalid = Invalid::WaterAboveCrest { depth: water.depth, crest: *crest };
                self.add("reservoir.depth", invalid);
            }
        }
        if let Some(prescribed) = &scene.prescribed {
            self.within("prescribed.batter", prescribed.batter, 0.0, 1e3);
            self.count("prescribed.panels", prescribed.panels as u64, 1, 1000);
        }
        let coupling = &scene.coupling;
        self.within("coupling.tolerance", coupling.tolerance, 1e-14, 0.1);
        self.count("coupling.iteration_limit", u64::from(coupling.iteration_limit), 2, 100_000);
        self.within("coupling.relaxation", coupling.relaxation, 1e-6, 1.5);
        self.count("coupling.predictor_order", coupling.predictor_order as u64, 0, 2);
    }

    fn dam(&mut self, dam: &DamScene) {
        self.positive("dam.element_size", dam.element_size);
        self.within("dam.time_step_safety", dam.time_step_safety, 1e-3, 1.0);
        let material = &dam.material;
        self.within("dam.material.young_modulus", material.young_modulus, 1e6, 1e13);
        self.within("dam.material.poisson_ratio", material.poisson_ratio, 0.0, 0.499);
        self.within("dam.material.density", material.density, 100.0, 1e5);
        self.damping(&dam.damping);
        self.section(dam);
        let Some([_, crest]) = dam.section.upstream.last().copied() else { return };
        for (index, crack) in dam.cracks.iter().enumerate() {
            let key = |name: &str| format!("dam.cracks.{index}.{name}");
            self.within(&key("friction_coefficient"), crack.friction_coefficient, 0.0, 5.0);
            self.positive(&key("normal_stiffness"), crack.normal_stiffness);
            self.positive(&key("shear_stiffness"), crack.shear_stiffness);
            let (key, elevation) = (key("elevation"), crack.elevation);
            if !(elevation > 0.0 && elevation < crest) {
                self.add(&key, Invalid::CrackOutside { key: key.clone(), elevation, crest });
            }
            let near = |other: &&super::CrackScene| (other.elevation - elevation).abs() <= SAME_LEVEL * crest;
            if let Some(other) = dam.cracks[..index].iter().find(near) {
                self.add(
                    &key,
                    Invalid::CracksCoincide { key: key.clone(), elevation, other: other.elevation },
                );
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
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = THINNEST_ROW * dam.element_size;
        for pair in levels.windows(2) {
            let [(lower, below), (upper, above)] = pair else { continue };
            if upper - lower > SAME_LEVEL * crest && upper - lower < least {
                let key = if above == "dam.section" { below } else { above };
                self.add(key, Invalid::ThinRow { lower: *lower, upper: *upper, least });
            }
        }
        let area = area_below(&dam.section.downstream) - area_below(&dam.section.upstream);
        let elements = 4.0 * area / (dam.element_size * dam.element_size);
        self.at_most("dam.element_size", "elements of the dam", elements, 1e6);
    }

    fn damping(&mut self, damping: &DampingScene) {
        self.within("dam.damping.ratio", damping.ratio, 0.0, 0.999);
        let (multiples, radians) = (damping.multiples_of_first, damping.radians_per_second);
        if damping.ratio != 0.0 || multiples.is_some() && radians.is_some() {
            let given = [multiples.is_some(), radians.is_some()];
            self.exactly_one("dam.damping", "multiples_of_first", "radians_per_second", given);
        }
        for (key, pair) in
            [("dam.damping.multiples_of_first", multiples), ("dam.damping.radians_per_second", radians)]
        {
            if let Some([low, high]) = pair
                && !(low > 0.0 && high > low && high.is_finite())
            {
                self.add(key, Invalid::Frequencies { key: key.to_owned(), low, high });
            }
        }
    }

    fn section(&mut self, dam: &DamScene) {
        let before = self.0.len();
        let sides = [
            ("dam.section.upstream", &dam.section.upstream),
            ("dam.section.downstream", &dam.section.downstream),
        ];
        for (key, side) in sides {
            if side.len() < 2 {
                self.add(key, Invalid::SideTooShort { key: key.to_owned(), points: side.len() });
            }
            for (index, &[x, y]) in side.iter().enumerate() {
                let follows = if index == 0 { y == 0.0 } else { y > side[index - 1][1] };
                if !(follows && x.is_finite() && y.is_finite()) {
                    self.add(key, Invalid::SideNotAscending { key: key.to_owned(), index, x, y });
                }
            }
        }
        if let Some(&[x, y]) = dam.section.upstream.first()
            && (x, y) != (0.0, 0.0)
        {
            self.add("dam.section.upstream", Invalid::NotAtHeel { x, y });
        }
        if self.0.len() > before {
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
        let given = [motion.record.is_some(), motion.ramp.is_some()];
        self.exactly_one("ground_motion", "[ground_motion.record]", "[ground_motion.ramp]", given);
        if let Some(ramp) = &motion.ramp {
            self.within("ground_motion.ramp.acceleration", ramp.acceleration, -1e3, 1e3);
            self.positive("ground_motion.ramp.rise", ramp.rise);
            self.sampling(scene, ramp.rise);
            if scene.time.duration.is_none() {
                self.add("ground_motion.ramp", Invalid::DurationMissing);
            }
            return Some(GroundMotion::ramp(ramp.acceleration, ramp.rise));
        }
        let record = motion.record.as_ref()?;
        let before = self.0.len();
        let end = record.end.unwrap_or(f64::INFINITY);
        self.positive("ground_motion.record.scale", record.scale);
        self.within("ground_motion.record.start", record.start, 0.0, 1e6);
        self.within("ground_motion.record.end", end, record.start, f64::INFINITY);
        if !matches!(record.polarity, 1 | -1) {
            self.add("ground_motion.record.polarity", Invalid::Polarity { value: record.polarity });
        }
        if self.0.len() > before {
            return None;
        }
        let factor = record.scale * f64::from(record.polarity);
        match GroundMotion::from_record(&folder.join(&record.file), record.start, end, factor) {
            Ok(ground_motion) => {
                self.sampling(scene, ground_motion.interval());
                Some(ground_motion)
            }
            Err(error) => {
                self.add("ground_motion.record.file", error.into());
                None
            }
        }
    }

    /// The units see the ground at communication points only: these must not be further apart than the samples.
    fn sampling(&mut self, scene: &Scene, interval: f64) {
        let communication_step = scene.time.communication_step;
        if communication_step > (1.0 + 1e-9) * interval {
            self.add("time.communication_step", Invalid::Undersampled { communication_step, interval });
        }
    }
}

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
