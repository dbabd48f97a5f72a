//! Whether the ground can move as the scene says.

use super::super::{Invalid, Scene, Shock, VerticalScene};
use super::Findings;
use cofferdam_motion::{Component, Excerpt, GroundMotion, RecordError};
use std::path::Path;

/// What moves the ground.
#[derive(Clone, Debug)]
pub struct Shaking {
    /// The motion.
    pub motion: GroundMotion,
    /// The motion of each record by itself; none of a ramp.
    pub shocks: Vec<GroundMotion>,
}

impl Findings {
    pub(super) fn ground_motion(&mut self, scene: &Scene, folder: &Path) -> Option<Shaking> {
        let motion = &scene.ground_motion;
        let shocks = motion.shocks();
        for Shock { table, record, vertical, vertical_table, .. } in &shocks {
            let [start, end] = ["start", "end"].map(|name| format!("{table}.{name}"));
            if self.sound(&[&start]) {
                self.within(&end, record.end.unwrap_or(f64::INFINITY), record.start, f64::INFINITY);
            }
            self.polarity(format!("{table}.polarity"), record.polarity);
            if let Some(vertical) = vertical {
                self.vertical_itself(vertical_table, vertical, true);
            }
        }
        if let Some(vertical) = motion.vertical.as_ref().filter(|_| motion.record.is_none()) {
            self.vertical_itself("ground_motion.vertical", vertical, false);
        }
        self.sequence(scene, &shocks);
        let given = [motion.record.is_some(), motion.ramp.is_some()];
        if given == [true, true] || self.sound(&["ground_motion"]) {
            self.exactly_one("ground_motion.ramp", "[ground_motion.record]", "[ground_motion.ramp]", given);
        }
        match (&motion.record, &motion.ramp) {
            (Some(_), None) => self.records(scene, &shocks, folder),
            (None, Some(ramp)) => {
                if scene.time.duration.is_none() && self.sound(&["time.duration"]) {
                    self.add("ground_motion.ramp", Invalid::DurationMissing);
                }
                let keys = ["rise", "acceleration", "vertical_acceleration"];
                let keys = keys.map(|name| format!("ground_motion.ramp.{name}"));
                if keys.iter().any(|key| !self.sound(&[key])) {
                    return None;
                }
                self.sampling(scene, ramp.rise);
                let upwards = Some(ramp.vertical_acceleration).filter(|acceleration| *acceleration != 0.0);
                let vertical = upwards.map(|acceleration| Component::ramp(acceleration, ramp.rise));
                let motion = GroundMotion::ramp(ramp.acceleration, ramp.rise).with_vertical(vertical);
                Some(Shaking { motion, shocks: Vec::new() })
            }
            _ => None,
        }
    }

    /// What a vertical component says by itself.
    fn vertical_itself(&mut self, table: &str, vertical: &VerticalScene, has_record: bool) {
        self.polarity(format!("{table}.polarity"), vertical.polarity);
        let untold = vertical.file.is_none() && vertical.column.is_none();
        if !has_record {
            if self.sound(&["ground_motion.record"]) {
                self.add(table, Invalid::VerticalAlone);
            }
        } else if untold && self.sound(&[table]) {
            self.add(table, Invalid::VerticalUntold { table: table.to_owned() });
        }
    }

    /// Whether there is a shock before those of the sequence, and whether results can tell them apart.
    fn sequence(&mut self, scene: &Scene, shocks: &[Shock<'_>]) {
        let motion = &scene.ground_motion;
        if !motion.sequence.is_empty() && motion.record.is_none() && self.sound(&["ground_motion.record"]) {
            let why = match &motion.ramp {
                Some(_) => "a ramp is held and never ends; give a record instead, or leave the sequence out",
                None => "there is no `[ground_motion.record]`; give it, or leave the sequence out",
            };
            self.add("ground_motion.sequence", Invalid::SequenceAlone { why });
        }
        for (index, shock) in motion.sequence.iter().enumerate() {
            let key = format!("ground_motion.sequence.{index}.name");
            match shock.name.as_deref() {
                Some(name) if name.trim().is_empty() && self.sound(&[&key]) => {
                    self.add(&key, Invalid::EmptyName { key: key.clone() });
                }
                Some(name) => self.printable(key, name),
                None => (),
            }
        }
        for (second, shock) in shocks.iter().enumerate() {
            let first = shocks[..second].iter().find(|other| other.label == shock.label);
            if let Some(first) = first {
                // the one that has a name
                let is_named = second > 0 && motion.sequence[second - 1].name.is_some();
                let named = if is_named { shock } else { first };
                let key = format!("{}.name", named.table);
                if self.sound(&[&key]) {
                    let [first, second] = [first, shock].map(|shock| shock.table.clone());
                    self.add(&key, Invalid::SameShocks { first, second, label: shock.label.clone() });
                }
            }
        }
    }

    /// The motions of all records, joined.
    fn records(&mut self, scene: &Scene, shocks: &[Shock<'_>], folder: &Path) -> Option<Shaking> {
        // every mistake at once
        let found: Vec<_> = shocks.iter().map(|shock| self.record(scene, shock, folder)).collect();
        let found: Vec<GroundMotion> = found.into_iter().collect::<Option<_>>()?;
        if !self.sound(&["ground_motion.sequence"]) {
            return None;
        }
        let mut rests = shocks.iter().map(|shock| shock.rest).zip(found.iter().cloned());
        let (_, first) = rests.next()?;
        match first.followed_by(&rests.collect::<Vec<_>>()) {
            Ok(motion) => Some(Shaking { motion, shocks: found }),
            Err(error) => {
                self.add("ground_motion.sequence", error.into());
                None
            }
        }
    }

    fn record(&mut self, scene: &Scene, shock: &Shock<'_>, folder: &Path) -> Option<GroundMotion> {
        let Shock { record, table, .. } = shock;
        let key = |name: &str| format!("{table}.{name}");
        if ["file", "column", "units", "start", "end"].iter().any(|name| !self.sound(&[&key(name)])) {
            return None;
        }
        let end = record.end.unwrap_or(f64::INFINITY);
        // The interval can be judged whatever the factor is.
        let sound = self.sound(&[&key("scale"), &key("polarity")]);
        let factor = if sound { record.scale * record.polarity as f64 } else { 1.0 };
        let path = folder.join(&record.file);
        let column = record.column.or(shock.shares_file().then_some(1));
        let (units, start) = (record.units, record.start);
        let excerpt = Excerpt { path: &path, column, units, start, end, factor, follows: false };
        match Component::from_record(&excerpt) {
            Ok(horizontal) => {
                self.known(&key("sha256"), &path, record.sha256.as_deref(), &horizontal);
                self.sampling(scene, horizontal.interval());
                let vertical = match shock.vertical {
                    Some(vertical) => {
                        let start = excerpt.begins(horizontal.interval());
                        let excerpt = Excerpt { start, follows: true, ..excerpt };
                        Some(self.vertical(scene, shock, vertical, excerpt, folder)?)
                    }
                    None => None,
                };
                Some(GroundMotion::from(horizontal).with_vertical(vertical))
            }
            Err(error) => {
                let name = match error {
                    RecordError::Crop { .. } if record.end.is_some() => "end",
                    RecordError::Crop { .. } => "start",
                    RecordError::TooStrong { .. } if record.scale != 1.0 => "scale",
                    RecordError::Column { .. } | RecordError::NoColumns { .. } if record.column.is_some() => {
                        "column"
                    }
                    _ => "file",
                };
                self.add(&key(name), error.into());
                None
            }
        }
    }

    /// The vertical component of a shock, where `horizontal` is the excerpt of its record.
    fn vertical(
        &mut self,
        scene: &Scene,
        shock: &Shock<'_>,
        vertical: &VerticalScene,
        horizontal: Excerpt<'_>,
        folder: &Path,
    ) -> Option<Component> {
        let key = |name: &str| format!("{}.{name}", shock.vertical_table);
        let of_record = |name: &str| format!("{}.{name}", shock.table);
        if ["file", "column", "units"].iter().any(|name| !self.sound(&[&key(name)])) {
            return None;
        }
        let sound = self.sound(&[&of_record("scale")]) && self.sound(&[&key("scale"), &key("polarity")]);
        let scale = shock.record.scale;
        let factor = if sound { scale * vertical.scale * vertical.polarity as f64 } else { 1.0 };
        let path = vertical.file.as_ref().map(|file| folder.join(file));
        let units = vertical.units.or(shock.record.units.filter(|_| path.is_none()));
        let path = path.as_deref().unwrap_or(horizontal.path);
        match Component::from_record(&Excerpt { path, column: vertical.column, units, factor, ..horizontal })
        {
            Ok(component) => {
                self.known(&key("sha256"), path, vertical.sha256.as_deref(), &component);
                self.sampling(scene, component.interval());
                Some(component)
            }
            Err(error) => {
                let key = match error {
                    RecordError::Clock { .. } => of_record("start"),
                    RecordError::TooStrong { .. } if vertical.scale != 1.0 => key("scale"),
                    RecordError::TooStrong { .. } if scale != 1.0 => of_record("scale"),
                    RecordError::Column { .. } | RecordError::NoColumns { .. } => key("column"),
                    _ => key("file"),
                };
                self.add(&key, error.into());
                None
            }
        }
    }

    fn polarity(&mut self, key: String, value: i64) {
        if self.sound(&[&key]) && !matches!(value, 1 | -1) {
            self.add(&key.clone(), Invalid::Polarity { key, value });
        }
    }

    /// Whether the file of a component, at `path`, is the one that is `wanted`.
    fn known(&mut self, key: &str, path: &Path, wanted: Option<&str>, component: &Component) {
        if let (Some(file), Some(wanted)) = (component.file(), wanted)
            && self.sound(&[key])
            && !file.sha256.eq_ignore_ascii_case(wanted)
        {
            self.add(key, RecordError::Another { path: path.to_owned(), found: file.sha256.clone() }.into());
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

#[cfg(test)]
mod tests {
    use crate::{LoadedScene, Scene, UnitChecks, reference};
    use std::path::Path;

    const RECORD: &str = "file='../records/northridge-1994-canyon-country-270.csv'";

    /// A shipped scene with changed values, or what is wrong with it.
    fn read(scene: &str, overrides: &[&str]) -> Result<LoadedScene, Vec<String>> {
        let checks = UnitChecks { dam: |_| Vec::new(), reservoir: |_| Vec::new() };
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes")).join(scene);
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        LoadedScene::read(&folder, &overrides, &checks)
            .map_err(|error| error.problems.iter().map(|problem| problem.invalid.to_string()).collect())
    }

    #[test]
    fn a_sequence_is_read_joined_and_written_whole() {
        let sequence = format!(
            "ground_motion.sequence=[{{{RECORD}, start=4, end=5, rest=2, scale=0.5}}, {{{RECORD}, name='last', polarity=-1, \
             vertical={{{RECORD}, scale=0.7}}}}]"
        );
        let loaded = read("koyna-coarse", &[&sequence]).expect("a scene");
        let (scene, motion) = (&loaded.scene, &loaded.ground_motion);
        let alone = read("koyna-coarse", &[]).expect("a scene").ground_motion;
        let (count, interval) = (alone.acceleration().len(), alone.interval());
        // the first record, then 4 s to 5 s of it halved, then all of it reversed
        let samples = motion.acceleration();
        assert_eq!((&samples[..count], motion.interval()), (alone.acceleration(), interval));
        let [_, second, third] = motion.begins()[..] else { panic!("{:?}", motion.begins()) };
        assert!((second - (count as f64 * interval + 2.0)).abs() < 1e-9, "{second}");
        let first_of = |begin: f64| (begin / interval).round() as usize + 1;
        assert_eq!(samples[first_of(second)], 0.5 * alone.acceleration()[400]);
        assert_eq!(samples[first_of(third) + 500], -alone.acceleration()[500]);
        let vertical = motion.vertical().expect("a component").acceleration();
        assert!(vertical[..first_of(third)].iter().all(|a| *a == 0.0));
        assert!((vertical[first_of(third) + 500] - 0.7 * alone.acceleration()[500]).abs() < 1e-12);
        // the second lasts for 101 samples and has 2 s of rest, by default 10 s come before the third
        assert!((third - second - (102.0 * interval + 10.0)).abs() < 1e-9, "{third}");
        let end = motion.rest_from().expect("an end");
        assert_eq!(scene.time.duration, Some(end + scene.time.quiet));
        let labels: Vec<String> = scene.ground_motion.shocks().into_iter().map(|shock| shock.label).collect();
        assert_eq!(labels, ["shock 1", "shock 2", "last"]);
        let record = scene.ground_motion.record.as_ref().expect("a record");
        for shock in &scene.ground_motion.sequence {
            assert!(shock.record.sha256.is_some() && shock.record.sha256 == record.sha256);
            assert!(shock.record.file.is_absolute() && shock.record.units == record.units);
        }
        let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        let has = |text: &str| warnings.iter().any(|warning| warning.contains(text));
        assert!(has("`ground_motion.sequence.0.rest` is 2 s: no residual sliding"), "{warnings:?}");
        assert!(has("`ground_motion.sequence.0` has no vertical component"), "{warnings:?}");
        // as logs and manifests hold it
        let text = toml::to_string(scene).expect("TOML");
        assert_eq!(toml::from_str::<Scene>(&text).as_ref(), Ok(scene));
        assert_eq!(&Scene::resolved(&text, &[], Path::new("log")).expect("a scene"), scene);
        let unknown = text.replace("name = \"last\"", "nome = \"last\"");
        assert!(toml::from_str::<Scene>(&unknown).is_err_and(|error| error.message().contains("nome")));
        // settings for all shocks
        let louder = scene.ground_motion.scaled(2.0);
        let sets: Vec<&str> = std::iter::once(&sequence).chain(&louder).map(String::as_str).collect();
        let louder = read("koyna-coarse", &sets).expect("a scene").ground_motion;
        assert!(louder.acceleration().iter().zip(samples).all(|(louder, own)| *louder == 2.0 * own));
    }

    #[test]
    fn mistakes_in_a_sequence_name_the_key_the_value_and_the_remedy() {
        let of = |shocks: &[&str]| {
            let shocks: Vec<String> = shocks.iter().map(|keys| format!("{{{RECORD}{keys}}}")).collect();
            format!("ground_motion.sequence=[{}]", shocks.join(", "))
        };
        let cases = [
            (of(&[", rest=-1"]), "`ground_motion.sequence.0.rest` is -1"),
            (of(&["", ", rest=nan"]), "`ground_motion.sequence.1.rest` is NaN"),
            (of(&[", rest=1001"]), "`ground_motion.sequence.0.rest` is 1001"),
            (of(&[", pause=3"]), "`pause`"),
            (of(&[", name=' '"]), "`ground_motion.sequence.0.name` is empty; give a name"),
            (
                of(&["", ", name='shock 2'"]),
                "are both called \"shock 2\" in results; give them different names",
            ),
            (of(&[", name='a'", ", name='a'"]), "`ground_motion.sequence.0` and `ground_motion.sequence.1`"),
            (of(&[", polarity=0"]), "`ground_motion.sequence.0.polarity` is 0"),
            (of(&[", vertical={scale=2}"]), "`[ground_motion.sequence.vertical]` names neither"),
            (of(&[", sha256='0123'"]), "not `sha256`: it is another record"),
            (of(&[", start=900"]), "900"),
            (of(&[", end=900"]), "900"),
            (of(&[", scale=1e5"]), "times `scale` 1e5, is more than"),
            (of(&[", rest=1000", ", rest=1000", ", rest=1000"]), "communication steps"),
            ("ground_motion.sequence=[{file='absent.csv'}]".to_owned(), "absent.csv"),
            ("ground_motion.sequence=[{rest=5}]".to_owned(), "`file`"),
        ];
        for (set, expected) in cases {
            let found = read("koyna-coarse", &[&set]).expect_err(&set);
            assert!(
                found.len() == 1 && found[0].contains(expected),
                "{set}: {found:?} instead of {expected}"
            );
        }
        let found = read("rigid-dam-ramp", &[&of(&[""])]).expect_err("a ramp");
        assert!(found[0].contains("a ramp is held and never ends; give a record instead"), "{found:?}");
    }

    #[test]
    fn the_reference_has_the_keys_of_a_sequence() {
        let text = reference();
        assert!(text.contains("### `[[ground_motion.sequence]]`"));
        for row in [
            "rest` | s | 0 to 1000 | `10` |",
            "file` |  |  | required |",
            "name` |",
            "scale` |",
            "start` | s |",
        ] {
            assert!(text.contains(&format!("| `ground_motion.sequence.{row}")), "{row}");
        }
        assert!(text.contains("those of `[ground_motion.vertical]`"));
    }
}
