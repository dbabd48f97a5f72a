use super::*;
use crate::study::StudyError;

fn shipped() -> Vec<PathBuf> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let entries = std::fs::read_dir(scenes).expect("the shipped scenes");
    let mut all: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    all.retain(|path| path.join("scene.toml").is_file());
    all.sort();
    assert!(all.len() >= 15);
    all
}

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

fn request<'a>(scene: &'a Path, set: &'a [String], records: &'a [PathBuf]) -> Request<'a> {
    Request {
        scene,
        set,
        output: Path::new("never-written"),
        samples: 8,
        seed: 1,
        replicates: 2,
        records,
        keep_fidelity: false,
        threads: NonZeroUsize::MIN,
    }
}

/// The factors of a scene, and what it does not have; every setting alone and every joint one makes a valid scene.
fn factors_of(request: &Request<'_>) -> (Vec<Factor>, Vec<LeftOut>) {
    let base = Base::read(request).expect("a scene with a range");
    let records = records::read(request.records, &base.loaded).expect("records");
    let subject = Subject { loaded: &base.loaded, half_step: Some(0.1), replicates: 2, records: &records };
    let (factors, left_out) = factor::of(&subject);
    let one = plan::one_at_a_time(&factors, 1);
    let mut invalid = Vec::new();
    let valid = base.valid(request, one.clone(), &factors, &mut invalid).expect("runs");
    assert!(invalid.is_empty() && valid == one, "{}: {invalid:?}", request.scene.display());
    for run in plan::joint(&factors, 8, 1) {
        let made = base.scene(request, &run);
        assert!(made.is_ok(), "{}: {:?}: {:?}", request.scene.display(), run.sets, made.err());
    }
    (factors, left_out)
}

#[test]
fn every_setting_of_every_factor_makes_a_valid_scene_of_every_shipped_one() {
    for path in shipped() {
        let request = request(&path, &[], &[]);
        if path.ends_with("rigid-dam-ramp") {
            let refused = Base::read(&request).err().expect("a prescribed dam has no range").to_string();
            assert!(
                refused.contains("[prescribed]") && refused.contains("choose another scene"),
                "{refused}"
            );
            continue;
        }
        let (factors, left_out) = factors_of(&request);
        let names: Vec<&str> = factors.iter().map(|factor| &*factor.about.name).collect();
        let missing: Vec<&str> = left_out.iter().map(|left_out| &*left_out.what).collect();
        // Each is a factor or has a reason for being none.
        assert_eq!(names.len() + missing.len(), 15, "{names:?} {missing:?}");
        assert!(missing.contains(&"record") && left_out.iter().all(|left_out| !left_out.reason.is_empty()));
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let lacks = |factor: &str| missing.contains(&factor);
        match &*name {
            "koyna-northridge-1994" | "koyna-coarse" | "koyna-two-cracks" => {
                assert_eq!(missing, ["record"], "{name}")
            }
            "koyna-intact" | "pine-flat-taft" => {
                assert!(
                    lacks("friction coefficient") && lacks("uplift rule") && !lacks("plane condition"),
                    "{name}"
                );
            }
            "stacked-blocks" => {
                assert!(lacks("wave reflection coefficient") && lacks("uplift rule"), "{missing:?}")
            }
            "koyna-gmsh" => assert!(lacks("element size"), "{missing:?}"),
            _ => {}
        }
    }
}

/// The changes of one setting of a factor.
fn sets_of(factors: &[Factor], name: &str) -> Vec<Vec<String>> {
    let index = factors.iter().position(|factor| factor.about.name == name).expect("the factor");
    let runs = plan::one_at_a_time(factors, 1).into_iter();
    runs.filter(|run| run.part == Part::Alone(index)).map(|run| run.sets).collect()
}

#[test]
fn factors_change_what_they_name_by_what_they_say() {
    let path = scene("koyna-two-cracks");
    let (factors, _) = factors_of(&request(&path, &[], &[]));
    assert_eq!(sets_of(&factors, "damping ratio"), [["dam.damping.ratio=3e-2"], ["dam.damping.ratio=1e-1"]]);
    assert_eq!(
        sets_of(&factors, "damping model"),
        [["dam.damping.model=\"mass\""], ["dam.damping.model=\"stiffness\""]]
    );
    // Both stiffnesses and both cracks.
    assert!(sets_of(&factors, "joint stiffness").iter().all(|sets| sets.len() == 4));
    let bed = "reservoir.wave_reflection_coefficient";
    // An almost rigid bed cannot be stepped like others.
    assert_eq!(
        sets_of(&factors, "wave reflection coefficient"),
        [[format!("{bed}=8e-1")], [format!("{bed}=9.9e-1")]]
    );
    let rigid = ["reservoir.wave_reflection_coefficient=1".to_owned()];
    let (factors, _) = factors_of(&request(&path, &rigid, &[]));
    assert_eq!(sets_of(&factors, "wave reflection coefficient"), [[format!("{bed}=9e-1")]]);
    // The rule of one crack does not hide that of the dam.
    let own = ["dam.cracks.0.uplift={rule=\"full-where-open\"}".to_owned()];
    let (factors, _) = factors_of(&request(&path, &own, &[]));
    let rules = sets_of(&factors, "uplift rule");
    assert!(rules.len() == 4 && rules.iter().all(|sets| sets.len() == 2), "{rules:?}");
}

#[test]
fn what_does_not_apply_is_left_out_with_its_reason() {
    let reason = |path: &Path, set: &str, what: &str| {
        let sets = [set.to_owned()];
        let (_, left_out) = factors_of(&request(path, &sets, &[]));
        let found = left_out.into_iter().find(|left_out| left_out.what == what);
        found.unwrap_or_else(|| panic!("{what} with {set}")).reason
    };
    let path = scene("koyna-coarse");
    assert!(reason(&path, "dam.fidelity=\"rigid-blocks\"", "plane condition").contains("do not deform"));
    assert!(
        reason(&path, "reservoir.fidelity=\"westergaard\"", "wave reflection coefficient")
            .contains("compressible")
    );
    assert!(reason(&path, "dam.damping.ratio=0", "damping model").contains("no damping"));
    // Local damping keeps the elements.
    let local = ["dam.damping={model=\"local\", ratio=0.05}".to_owned()];
    let base = Base::read(&request(&path, &local, &[])).expect("a scene");
    assert!(base.model.contains("\"dem\"") && base.model.contains("local damping"), "{}", base.model);
}

#[test]
fn other_records_have_the_peak_of_the_scenes_and_run_to_their_end() {
    let path = scene("koyna-coarse");
    let record = scene("records").join("kern-county-1952-taft-s69e.csv");
    let given = [record.clone()];
    let of_scene = request(&path, &[], &given);
    let (factors, _) = factors_of(&of_scene);
    let base = Base::read(&of_scene).expect("a scene");
    let index = factors.iter().position(|factor| factor.about.kind == FactorKind::Records).expect("records");
    let runs = plan::one_at_a_time(&factors, 1);
    let run = runs.iter().find(|run| run.part == Part::Alone(index)).expect("a run");
    let other = base.scene(&of_scene, run).expect("a scene");
    let [peak, own] = [&other, &base.loaded].map(|loaded| loaded.ground_motion.largest());
    assert!((peak / own - 1.0).abs() < 1e-9, "{peak} {own}");
    let duration = other.scene.time.duration.expect("a duration");
    assert!((duration - other.ground_motion.rest_from().expect("rest") - 5.0).abs() < 1e-9, "{duration}");
    // In the joint sample the polarity turns the other record, too.
    let all = plan::joint(&factors, 8, 1);
    let turned =
        all.iter().filter(|run| run.sets.iter().any(|set| set == "ground_motion.record.polarity=-1"));
    let turned: Vec<_> = turned.filter(|run| run.sets[0].starts_with("ground_motion.record={")).collect();
    assert!(!turned.is_empty());
    for run in turned {
        assert_eq!(
            base.scene(&of_scene, run)
                .expect("a scene")
                .scene
                .ground_motion
                .record
                .expect("a record")
                .polarity,
            -1
        );
    }
}

#[test]
fn a_record_of_a_scene_with_a_vertical_component_needs_one() {
    let path = scene("koyna-loads");
    let file = scene("records").join("loma-prieta-1989-corralitos-038.csv");
    let of = |given: PathBuf| {
        let given = [given];
        let request = request(&path, &[], &given);
        records::read(request.records, &Base::read(&request).expect("a scene").loaded)
    };
    let error = of(file.clone()).expect_err("no vertical component").to_string();
    assert!(error.contains("FILE,VERTICAL"), "{error}");
    let both = PathBuf::from(format!("{},{}", file.display(), file.display()));
    let sets = of(both.clone()).expect("both components")[0].sets.clone();
    assert!(sets.len() == 3 && sets[2].starts_with("ground_motion.vertical="), "{sets:?}");
    let given = [both];
    factors_of(&request(&path, &[], &given));
    let missing =
        of(PathBuf::from(format!("{},nowhere.csv", file.display()))).expect_err("no file").to_string();
    assert!(missing.contains("--record") && missing.contains("nowhere.csv"), "{missing}");
}

#[test]
fn a_recorded_unit_is_refused_before_any_run() {
    let path = scene("koyna-coarse");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.mcap"), "").expect("a file");
    let set = [
        "reservoir.fidelity=\"log\"".to_owned(),
        format!("reservoir.log={{file={:?}}}", folder.path().display().to_string()),
    ];
    let refused = run(&request(&path, &set, &[]), &Context::default()).expect_err("an open loop");
    assert!(matches!(refused, StudyError::Unfit { .. }), "{refused}");
    assert!(!Path::new("never-written").exists());
}

/// Half a second of strong shaking of the coarse main scene, with a number of changes.
fn short(further: &[&str]) -> Vec<String> {
    let of_all = [
        "dam.element_size=10",
        "reservoir.element_size=10",
        "reservoir.method=\"recursive\"",
        "ground_motion.record.start=4.4",
        "ground_motion.record.end=5.0",
        "time.quiet=0",
    ];
    of_all.iter().chain(further).map(|set| (*set).to_owned()).collect()
}

/// Rows of `range.csv`, by heading.
fn rows(folder: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut table = csv::Reader::from_path(folder.join("range.csv")).expect("a table");
    table.deserialize().map(|row| row.expect("a row")).collect()
}

#[test]
fn a_range_holds_every_run_whatever_the_number_of_threads() {
    let (path, set) = (scene("koyna-coarse"), short(&["dam.cracks.0.friction_coefficient=0.5"]));
    let folder = tempfile::tempdir().expect("a folder");
    let range = |name: &str, threads| {
        let output = folder.path().join(name);
        let threads = NonZeroUsize::new(threads).expect("not 0");
        let request = Request { output: &output, threads, ..request(&path, &set, &[]) };
        (run(&request, &Context::default()).expect("a range"), output)
    };
    let (record, output) = range("two", 2);
    assert!(record.failed.is_empty(), "{:?}", record.failed);
    let rows = rows(&output);
    assert_eq!(rows.len(), record.runs);
    let count = |part: &str| rows.iter().filter(|row| row["part"] == part).count();
    assert_eq!((count("as it is"), count("joint")), (1, 8));
    let sliding =
        record.quantities.iter().find(|quantity| quantity.name == "residual sliding").expect("sliding");
    let value = |row: &std::collections::BTreeMap<String, String>| -> f64 {
        row["residual sliding [mm]"].parse().expect("a number")
    };
    // A row says what its run was: made again, it gives the same.
    let again = |sets: &[&str]| {
        let all: Vec<String> = set
            .iter()
            .cloned()
            .chain(["dam.fidelity=\"reduced\"".to_owned()])
            .chain(sets.iter().map(|set| (*set).to_owned()))
            .collect();
        let loaded = read_scene(&path, &all).expect("a scene");
        let outcome =
            study::run_scene(&loaded.scene, &loaded.ground_motion, NonZeroUsize::MIN, &Context::default());
        quantities::of(&loaded.scene, &outcome.expect("a run")).value("residual sliding")
    };
    assert_eq!(value(&rows[0]), again(&[]));
    assert_eq!(sliding.as_it_is, again(&[]));
    let row = |name: &str| rows.iter().find(|row| row["run"] == name).expect("a row");
    assert_eq!(value(row("damping model: mass")), again(&["dam.damping.model=\"mass\""]));
    assert_eq!(value(row("model of the dam: every element")), again(&["dam.fidelity=\"dem\""]));
    // What changes nothing of the dam changes its answer little; another polarity changes it.
    let crest = record
        .quantities
        .iter()
        .find(|quantity| quantity.name == "peak crest displacement")
        .expect("a crest");
    let moved = |quantity: &cofferdam_report::RangeQuantity, factor: &str| {
        let swing = quantity.swings.iter().find(|swing| swing.factor == factor).expect("a swing");
        swing.size(quantity.as_it_is) / quantity.as_it_is.abs()
    };
    for (factor, most) in
        [("time step of the dam", 0.01), ("communication step", 0.01), ("model of the dam", 0.02)]
    {
        assert!(moved(crest, factor) <= most, "{factor}: {}", moved(crest, factor));
    }
    assert!(moved(sliding, "polarity") > 0.05, "{}", moved(sliding, "polarity"));
    // The ranges are those of the rows.
    let of = |factor: &str| sliding.swings.iter().find(|swing| swing.factor == factor).expect("a swing");
    let models = [row("damping model: mass"), row("damping model: stiffness")].map(value);
    assert_eq!(
        [of("damping model").low.value, of("damping model").high.value],
        [models[0].min(models[1]), models[0].max(models[1])]
    );
    let joint: Vec<f64> = rows.iter().filter(|row| row["part"] == "joint").map(value).collect();
    let combined = sliding.combined.as_ref().expect("a joint sample");
    let extremes =
        [joint.iter().copied().fold(f64::MAX, f64::min), joint.iter().copied().fold(f64::MIN, f64::max)];
    assert_eq!((combined.runs, combined.extremes), (8, extremes));
    assert!(extremes[0] < combined.interval[0] && combined.interval[1] < extremes[1]);
    // Half a second after slipping no block is at rest.
    assert!(record.notes.iter().any(|note| note.contains("not at rest")), "{:?}", record.notes);
    assert_eq!(RangeRecord::read(&output).expect("a record"), record);
    let (_, alone) = range("one", 1);
    for file in ["range.csv", "range.md", "range.toml", "range-residual-sliding.svg"] {
        let [a, b] =
            [&output, &alone].map(|folder| std::fs::read_to_string(folder.join(file)).expect("a file"));
        assert!(a == b, "{file} differs");
    }
}

#[test]
fn failed_runs_are_named_and_in_no_number() {
    // The block can just stand: tan φ = 0.194 is needed. With 10 % less friction it cannot.
    let (path, set) = (
        scene("koyna-coarse"),
        short(&["dam.cracks.0.friction_coefficient=0.21", "ground_motion.record.end=4.5"]),
    );
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("range");
    let request = Request { output: &output, samples: 12, ..request(&path, &set, &[]) };
    let record = run(&request, &Context::default()).expect("a range");
    let alone = record.left_out.iter().find(|left_out| left_out.what == "friction coefficient: × 0.9");
    assert!(alone.is_some_and(|left_out| left_out.reason.contains("would slide")), "{:?}", record.left_out);
    let joint = record.failed.iter().filter(|failed| failed.run.starts_with("joint sample")).count();
    let sliding = &record.quantities[0];
    assert!(joint >= 2, "{:?}", record.failed);
    assert_eq!(sliding.combined.as_ref().expect("a sample").runs + joint, 12);
    let rows = rows(&output);
    let failed: Vec<_> = rows.iter().filter(|row| row["status"] == "failed").collect();
    assert_eq!(failed.len(), record.failed.len());
    assert!(failed.iter().all(|row| row["residual sliding [mm]"].is_empty()));
    let text = std::fs::read_to_string(output.join("range.md")).expect("a text");
    assert!(text.contains(&format!("{} of {} runs failed", record.failed.len(), record.runs)), "{text}");
    // The scene as it is must not fail.
    let cannot_stand = short(&["dam.cracks.0.friction_coefficient=0.15"]);
    let output = folder.path().join("none");
    let failed = run(&Request { output: &output, set: &cannot_stand, ..request }, &Context::default());
    assert!(matches!(failed, Err(StudyError::Scene(_))), "{failed:?}");
    // A folder with something in it is left alone.
    let taken = run(&Request { output: folder.path(), ..request }, &Context::default());
    assert!(matches!(taken, Err(StudyError::OutputTaken { .. })), "{taken:?}");
}
