//! The coarse twins of the studies of `cofferdam-lab`: what docs/measurements/stability.md and docs/measurements/tradeoff.md show, small.

use std::path::Path;
use std::process::Command;
use whole_chain::peak;
use whole_chain::scenario::{Scenario, lab, root};

/// Rows of the table that the study leaves, by heading.
fn study(name: &str, scene: &str, settings: &[&str], output: &Path) -> Vec<Vec<String>> {
    let mut command = Command::new(lab());
    command.args([name, "--coarse", "--output"]).arg(output).arg(root().join("scenes").join(scene));
    for setting in settings {
        command.args(["--set", setting]);
    }
    let done = command.output().expect("cofferdam runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    println!("{}", String::from_utf8_lossy(&done.stdout));
    if ["rest", "ledger", "meshes", "seek"].contains(&name) {
        return table(name, output);
    }
    let picture = std::fs::read_to_string(output.join(format!("{name}.svg"))).expect("a picture");
    assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"), "{picture}");
    table(name, output)
}

/// Rows of the table in `output`.
fn table(name: &str, output: &Path) -> Vec<Vec<String>> {
    assert!(output.join(format!("{name}.md")).is_file());
    table_of(&output.join(format!("{name}.csv")))
}

/// Rows of the table in a file.
fn table_of(path: &Path) -> Vec<Vec<String>> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    table.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect()).collect()
}

#[test]
fn quasi_newton_converges_where_plain_iteration_diverges_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = study("stability", "koyna-intact", &[], &folder.path().join("s"));
    assert_eq!(rows.len(), 2 * 4 * 3 * 3);
    for row in rows {
        let [water, _, acceleration, density, step, verdict, mean, _] = &row[..] else { panic!("{row:?}") };
        let (density, step): (f64, f64) =
            (density.parse().expect("a number"), step.parse().expect("a number"));
        match &**acceleration {
            "interface-jacobian" | "iqn-ils" => {
                let most = if acceleration == "iqn-ils" { 12.0 } else { 4.0 };
                assert_eq!(verdict, "converges", "{row:?}");
                assert!(mean.parse::<f64>().is_ok_and(|mean| mean <= most), "{row:?}");
            }
            // Water of the concrete's weight or a third of it, on which short steps cannot lean.
            "constant" if water == "incompressible" && density > 0.3 && step < 0.01 => {
                assert_eq!(verdict, "diverges", "{row:?}");
            }
            _ if density < 0.1 => assert_eq!(verdict, "converges", "{row:?}"),
            _ => {}
        }
    }
}

#[test]
fn a_tighter_tolerance_brings_the_error_down_and_costs_iterations() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings =
        ["dam.element_size=20", "ground_motion.record.start=4", "ground_motion.record.end=5", "time.quiet=0"];
    let rows = study("tolerance", "koyna-intact", &settings, &folder.path().join("t"));
    let (balanced, rows) = rows.split_first().expect("rows");
    let number = |row: &Vec<String>, index: usize| -> f64 { row[index].parse().expect("a number") };
    let column = |index: usize| -> Vec<f64> { rows.iter().map(|row| number(row, index)).collect() };
    let (tolerance, iterations, crest) = (column(0), column(1), column(4));
    assert_eq!(balanced[0], "balanced");
    // Cheaper than 1e-4, and closer than 1e-2.
    assert!(number(balanced, 1) < iterations[1] && number(balanced, 4) < crest[0], "{balanced:?}");
    assert_eq!(tolerance, [1e-2, 1e-4, 1e-6, 1e-8]);
    assert!(iterations.windows(2).all(|pair| pair[0] <= pair[1]), "{iterations:?}");
    assert!(crest[1] < crest[0] && crest.windows(2).all(|pair| pair[1] <= pair[0]), "{crest:?}");
    for (tolerance, crest) in tolerance.iter().zip(&crest) {
        assert!(*crest < *tolerance, "{crest} at {tolerance}");
    }
}

#[test]
fn ambient_vibration_makes_no_energy() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = ["dam.element_size=10", "reservoir.element_size=10"];
    let rows = study("ambient", "koyna-coarse", &settings, &folder.path().join("a"));
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let values: Vec<f64> = row.iter().map(|cell| cell.parse().expect("a number")).collect();
        let [_, stored, _, damped, _, missed, work, produced] = values[..] else { panic!("{row:?}") };
        assert!(damped > 0.0 && stored > 0.0, "{row:?}");
        assert!(missed.abs() < 2e-3 * stored.max(damped), "{row:?}");
        assert!(produced.abs() < 2e-3 * work.abs(), "{row:?}");
    }
}

/// Every model and method on a coarse dam for a second: the ladder leads to the best, and what is written of a state grows
/// with a run for the convolutions alone.
#[test]
fn each_level_of_the_water_is_closer_to_the_best_than_the_one_below() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [
        "dam.element_size=20",
        "ground_motion.record.start=4.5",
        "ground_motion.record.end=5.5",
        "time.quiet=0",
        "time.communication_step=0.005",
        "reservoir.wave_reflection_coefficient=0.5",
    ];
    let rows = study("fidelity", "koyna-coarse", &settings, &folder.path().join("f"));
    let of = |name: &str, column: usize| -> f64 {
        let row = rows.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("no row {name}"));
        row[column].parse().unwrap_or_else(|_| panic!("{name}: {row:?}"))
    };
    let [written, crest, above, base, rigid] = [2, 6, 7, 10, 11];
    let ladder = ["none", "Westergaard, parabola", "incompressible", "Radau, 3 stages"];
    let errors = ladder.map(|name| of(name, crest));
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    assert!(of("incompressible", above) == of("incompressible", crest), "the level above is the best");
    for name in ["recursion", "BDF2", "trapezoidal rule", "Radau, 2 stages", "Radau, 3 stages"] {
        assert!(of(name, crest) < 2e-2 && of(name, rigid) < 3e-2, "{name}");
        assert!(of(name, base) < 0.3, "{name}");
    }
    assert!(
        of("finite elements", rigid) > 5.0 * of("recursion", rigid),
        "a Sommerfeld end at h/2 sends waves back"
    );
    assert!(of("Radau, 2 stages", written) > of("recursion", written), "a history is longer than states");
}

#[test]
fn more_elements_bring_the_face_closer_to_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = study("resolution", "koyna-intact", &[], &folder.path().join("r"));
    assert_eq!(rows.len(), 4 * 2 * 3);
    let number = |row: &[String], column: usize| -> f64 { row[column].parse().expect("a number") };
    for kh in ["0.8", "2.4", "4"] {
        let errors = |shape: &str| -> Vec<f64> {
            let rows = rows.iter().filter(|row| row[1] == shape && row[2] == kh);
            rows.map(|row| number(row, 3)).collect()
        };
        let [constant, linear] = [errors("constant"), errors("linear")];
        assert!(
            [&constant, &linear]
                .iter()
                .all(|e| e.len() == 4 && e.windows(2).all(|pair| pair[1] < 0.6 * pair[0]))
        );
        assert!(linear.iter().zip(&constant).all(|(linear, constant)| *linear < 0.1 * constant));
        // Six elements a wave and more.
        assert!(linear[3] < 1e-4, "kh = {kh}: {linear:?}");
    }
}

#[test]
fn a_scene_without_a_closed_form_has_no_study_of_its_resolution() {
    let folder = tempfile::tempdir().expect("a folder");
    for (setting, why) in [
        ("reservoir.bed=[[-80.0, 15.0]]", "the bed is not level"),
        ("reservoir.surface_waves=true", "there are waves on the surface"),
        ("reservoir.fidelity=\"incompressible\"", "compressible water"),
    ] {
        let mut command = Command::new(lab());
        command.args(["resolution", "--output"]).arg(folder.path().join("n"));
        command.arg(root().join("scenes/koyna-intact")).args(["--set", setting]);
        let done = command.output().expect("cofferdam runs");
        let said = String::from_utf8_lossy(&done.stderr).replace('│', " ");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(done.status.code(), Some(2), "{said}");
        assert!(said.contains(why) && said.contains("choose another scene"), "{said}");
    }
}

/// The paper's way loses most of the pressure on a rigid dam, and moves the crest and the block otherwise.
#[test]
fn short_windows_forget_the_reservoir() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [
        "dam.element_size=10",
        "dam.damping.drags_blocks=true",
        "ground_motion.record.start=4",
        "ground_motion.record.end=5.5",
        "time.quiet=0",
    ];
    let output = folder.path().join("w");
    let rows = study("windows", "koyna-coarse", &settings, &output);
    let share = |cell: &str| cell.trim_end_matches(" %").parse::<f64>().expect("a percentage") / 100.0;
    // 0.1 s, 128 steps, and all of it at once, where only the end of the record presses at its beginning.
    assert_eq!(rows.iter().map(|row| &*row[0]).collect::<Vec<_>>(), ["40", "128", "604"]);
    let base: Vec<f64> = rows.iter().map(|row| share(&row[2])).collect();
    assert!(base[0] > 0.5 && base[1] > 0.3 && base[2] < base[1], "{base:?}");
    for row in &rows[..2] {
        assert_eq!(row[8], "at the end", "{row:?}");
        assert!(row[4].parse::<f64>().is_ok_and(|mean| mean > 5.0) && share(&row[6]) > 0.02, "{row:?}");
    }
    let text = std::fs::read_to_string(output.join("far-end.csv")).expect("a table");
    let ends: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(
        ends.iter().map(|row| row[0]).collect::<Vec<_>>(),
        ["waves leave", "left out", "wall", "p = 0"]
    );
    for row in &ends {
        let errors: Vec<f64> = row[2..].iter().map(|cell| share(cell)).collect();
        match row[0] {
            "waves leave" => assert!(errors.iter().all(|error| *error < 1e-3), "{row:?}"),
            // At 0.99 ω₁, and under the record.
            _ => assert!(errors[1] > 0.2 && errors[4] > 0.2, "{row:?}"),
        }
    }
}

/// A block that vibrates by itself walks on after the ground has stopped, and with stiffness damping comes to rest; none walks that
/// does not shake itself; what cannot stand has no run.
#[test]
fn what_grows_walks_and_what_decays_comes_to_rest() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [
        "dam.section={upstream = [[0.0, 0.0], [0.0, 40.0]], downstream = [[32.0, 0.0], [5.0, 34.0], [5.0, 40.0]]}",
        "dam.cracks.0.elevation=1",
        "reservoir.depth=36",
        "reservoir.method=\"recursive\"",
        "ground_motion.record.start=5",
        "ground_motion.record.end=7",
        "time.quiet=6",
    ];
    let rows = study("rest", "koyna-coarse", &settings, &folder.path().join("s"));
    let verdicts: Vec<&str> = rows.iter().map(|row| &*row[12]).collect();
    assert_eq!(verdicts, ["moves", "at rest", "cannot stand", "at rest"], "{rows:?}");
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().expect("a number");
    assert!(number(0, 7) > 5.0 && number(0, 9) > 5.0 && number(3, 7) < 0.2 * number(0, 7), "{rows:?}");
    assert!([1, 3].iter().all(|&row| number(row, 9).abs() < 0.1 && number(row, 11) > 50.0), "{rows:?}");
}

/// The error of the energy balance falls with every halving of the time step. At the usual step it is so small that no order can be read from
/// these two seconds: of the whole main scene docs/measurements/validation.md has it.
#[test]
fn the_ledger_closes_with_the_time_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [
        "dam.element_size=10",
        "reservoir.method=\"recursive\"",
        "ground_motion.record.start=4",
        "ground_motion.record.end=6",
        "time.quiet=0",
    ];
    let rows = study("ledger", "koyna-coarse", &settings, &folder.path().join("s"));
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let number = |column: usize| row[column].parse::<f64>().expect("a number");
        assert!(number(1) < 3e-4 && number(2) < number(1) && number(3) < 0.7 * number(2), "{rows:?}");
    }
}

/// Two meshes of the crack in half a second with a slip: a row for each with either kind of contacts, two for the shaking, and
/// three sums of them; meshes without rows are other meshes, and the crest moves alike.
#[test]
fn one_crack_in_other_meshes_moves_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [
        "dam.element_size=10",
        "reservoir.method=\"recursive\"",
        "ground_motion.record.start=4",
        "ground_motion.record.end=5",
        "time.quiet=0",
    ];
    let rows = study("meshes", "koyna-coarse", &settings, &folder.path().join("s"));
    assert_eq!(rows.len(), 4 + 2 + 3);
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().expect("a number");
    assert_ne!(number(0, 1), number(1, 1));
    assert!((0..6).all(|row| (number(row, 2) / number(0, 2) - 1.0).abs() < 0.2), "{rows:?}");
}

#[test]
fn a_step_of_a_long_log_is_found_by_reading_a_small_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [
        "reservoir.fidelity=\"westergaard\"",
        "coupling.scheme=\"serial-implicit\"",
        "dam.element_size=10",
        "ground_motion.record.start=4",
        "ground_motion.record.end=5",
        "time.quiet=0",
    ];
    let output = folder.path().join("s");
    // A size is an argument of this study alone; the default would take a minute.
    let scene = root().join("scenes/koyna-coarse");
    let mut command = Command::new(lab());
    command.args(["seek", "--coarse", "--size", "60MB", "--output"]).arg(&output).arg(scene);
    for setting in settings {
        command.args(["--set", setting]);
    }
    let done = command.output().expect("cofferdam runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    println!("{}", String::from_utf8_lossy(&done.stdout));
    let rows = table("seek", &output);
    assert_eq!(rows.len(), 4);
    for row in rows {
        let most: f64 = row[5].parse().expect("a number");
        assert!(most < 12.0, "{row:?}: MB of 60");
    }
    assert!(!output.join("log.mcap").exists(), "the log is removed");
}

/// The paper's figures, coarse, with a user's record in m/s² for one earthquake and the stand-in for the other.
#[test]
fn the_papers_figures_stand_beside_its_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let (output, record) = (folder.path().join("p"), folder.path().join("own.csv"));
    let shipped = root().join("scenes/records/loma-prieta-1989-corralitos-038.csv");
    let text = std::fs::read_to_string(&shipped).expect("a record");
    let samples = text.lines().filter_map(|line| line.split_once(',')?.0.parse::<f64>().ok().map(|_| line));
    let metres: Vec<String> = samples
        .map(|line| line.split_once(',').expect("two columns"))
        .map(|(time, a)| format!("{time},{}", 9.806_65 * a.parse::<f64>().expect("a number")))
        .collect();
    std::fs::write(&record, format!("time_s,acceleration_m/s2\n{}\n", metres.join("\n"))).expect("a file");
    let study = |record: &Path| {
        let mut command = Command::new(lab());
        command.args(["paper", "--coarse", "--koyna-record"]).arg(record).arg("--output").arg(&output);
        command.arg("--scenes").arg(root().join("scenes")).output().expect("cofferdam runs")
    };
    let refused = study(&folder.path().join("none.csv"));
    let said = String::from_utf8_lossy(&refused.stderr).replace('│', " ");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("--koyna-record (a path from where") && said.contains("a record is a text file"),
        "{said}"
    );
    let done = study(&record);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    println!("{}", String::from_utf8_lossy(&done.stdout));

    // Every figure is drawn, says whose record it is, and has what the paper states.
    let user = "the user's own.csv, peak 0.484 g, where the paper's has 0.49 g";
    let stand_in = "northridge-1994-canyon-country-270.csv with a peak of 0.678 g stands in";
    for (figure, parts) in [
        (3, vec!["closed form", "constant elements"]),
        (4, vec!["beverly-hills-279.csv with a peak of 0.516 g stands in", "finite elements"]),
        (7, vec![user, stand_in, "rigid dam"]),
        (8, vec![user, "paper: 2.89 g", "paper: 2.41 g"]),
        (9, vec![stand_in, "paper: 4.35 g", "paper: 3.62 g"]),
        (10, vec![user, "26.5 mm at 4.02 s"]),
        (11, vec![stand_in, "55.6 mm at 4.72 s"]),
        (12, vec![user, stand_in, "13.1 mm", "20.3 mm", "Westergaard's added mass"]),
        (13, vec![user, stand_in, "1.8 mrad", "2.6 mrad"]),
    ] {
        let picture =
            std::fs::read_to_string(output.join(format!("figure-{figure}.svg"))).expect("a picture");
        assert!(picture.starts_with("<svg") && picture.contains("<polyline"), "figure {figure}");
        // Lines of text are wrapped, each an element of its own.
        let words = picture.replace("</text>", " ");
        let words = words.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text.trim());
        let words =
            words.filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" ").replace("&apos;", "'");
        for part in parts {
            assert!(words.contains(part), "figure {figure}: `{part}` is missing: {words}");
        }
    }
    assert!(output.join("paper.svg").is_file());

    // The numbers of the paper's text, and verdicts that follow from ours.
    let rows = table("paper", &output);
    let stated: Vec<&str> = rows.iter().map(|row| &*row[4]).collect();
    let koyna = ["2.89", "2.41", "5.9", "26.5", "4.02", "13.1", "12", "1.8"];
    let newhall = ["4.35", "3.62", "5.88", "55.6", "4.72", "20.3", "18.4", "2.6"];
    let of = |name: &str| -> Vec<&Vec<String>> { rows.iter().filter(|row| row[1] == name).collect() };
    assert_eq!(stated.len(), 16);
    let number = |cell: &str| -> f64 { cell.parse().unwrap_or_else(|_| panic!("{cell} is no number")) };
    for (name, stated) in [("Koyna 1967", koyna), ("Newhall 1994", newhall)] {
        assert_eq!(of(name).iter().map(|row| &*row[4]).collect::<Vec<_>>(), stated);
    }
    for row in &rows {
        let [paper, ours] = [4, 5].map(|column| number(&row[column]));
        let difference: f64 = number(row[6].trim_end_matches(" %"));
        assert!((difference - 100.0 * (ours / paper - 1.0)).abs() < 1.5, "{row:?}");
        if row[7] == "–" {
            assert_eq!(row[9], "not swept", "{row:?}");
            continue;
        }
        let [least, most] = [7, 8].map(|column| number(&row[column]));
        assert!(least <= ours && ours <= most, "{row:?}");
        let verdict = match paper {
            paper if paper < least => "below all of ours",
            paper if paper > most => "above all of ours",
            _ => "within ours",
        };
        assert_eq!(row[9], verdict, "{row:?}");
    }

    // The same numbers as a run of the same scene.
    let mut scenario = Scenario::shipped("paper-newhall-1994");
    // From 1 s before the record's peak to 0.75 s after it.
    scenario.set("ground_motion.record.start", 4.03).set("ground_motion.record.end", 5.78);
    scenario.set("time.quiet", 0.0).set("dam.element_size", 10.0).set("coupling.on_failure", "continue");
    let histories = scenario.run();
    let column = |name: &str| histories.column(name);
    let time = column("time");
    let sliding = column("dam.crack_sliding.0");
    let last = time.iter().filter(|t| **t >= time[time.len() - 1] - 1.0).count();
    let mean = sliding[sliding.len() - last..].iter().sum::<f64>() / last as f64;
    let of_run = [
        ("largest acceleration below the crack", peak(column("dam.crack_acceleration_below.0")) / 9.806_65),
        ("largest acceleration above the crack", peak(column("dam.crack_acceleration_above.0")) / 9.806_65),
        ("residual sliding", 1e3 * mean),
        ("largest rotation", 1e3 * peak(column("dam.crack_rotation.0"))),
    ];
    for (quantity, value) in of_run {
        let row = of("Newhall 1994").into_iter().find(|row| row[2] == quantity).expect("a row");
        assert!((number(&row[5]) - value).abs() <= 5.1e-4, "{value}: {row:?}");
    }

    // Words: the verdict is that of the numbers.
    let claims = table_of(&output.join("claims.csv"));
    assert_eq!(claims.len(), 14);
    for name in ["Koyna 1967", "Newhall 1994"] {
        let [below, above] = [0, 1].map(|row| number(&of(name)[row][5]));
        let claim =
            claims.iter().find(|row| row[1] == name && row[2].contains("above the crack")).expect("a row");
        let smaller = above < below && above >= 0.8 * below;
        assert_eq!(claim[5], if smaller { "holds" } else { "does not hold" }, "{claim:?}");
        let [boundary, finite] = [5, 6].map(|row| number(&of(name)[row][5]));
        let claim = claims.iter().find(|row| row[1] == name && row[2].contains("finite")).expect("a row");
        let close = (finite / boundary - 1.0).abs() <= 0.1;
        assert_eq!(claim[5], if close { "holds" } else { "does not hold" }, "{claim:?}");
    }
    // Other choices of the user's record: another strength, and the same shaking from the other side.
    let open = table_of(&output.join("open.csv"));
    for run in [
        "the paper",
        "as it is",
        "scaled to the paper's peak",
        "polarity reversed*",
        "damping of mass alone*",
    ] {
        assert!(open.iter().any(|row| row[0] == "Koyna 1967" && row[1] == run), "{run}: {open:?}");
    }
    // All choices together, where one of them slides less than the scene.
    for name in ["Koyna 1967", "Newhall 1994"] {
        let rows: Vec<_> = open.iter().filter(|row| row[0] == name).collect();
        let slid = |run: &str| {
            let row = rows.iter().find(|row| row[1].starts_with(run))?;
            Some(number(&row[7]).abs())
        };
        let scene = slid("as it is").expect("a row");
        let less = ["polarity", "damping"].iter().any(|run| slid(run).is_some_and(|slid| slid < scene));
        assert_eq!(slid("those with the least sliding together").is_some(), less, "{rows:?}");
    }
}

#[test]
fn measure_writes_table_and_stamp_and_keeps_the_rest_of_the_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("page.md");
    let scene = root().join("scenes/koyna-coarse");
    let command = format!(
        "cofferdam-lab variants {} --set dam.fidelity=rigid-blocks --set time.duration=0.1 \\\n  --case dam.damping.ratio=0.1",
        scene.display()
    );
    let block =
        format!("# A page\n\n```measure\n{command}\n```\n\nold\n<!-- end of measurement -->\n\nafter\n");
    std::fs::write(&page, &block).expect("a page");
    let measure = |more: &[&str]| {
        let done = Command::new(lab()).arg("measure").arg(&page).args(more).output().expect("the lab runs");
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    // No command contains this text.
    assert_eq!(measure(&["--only", "rest"]).0, Some(0));
    assert_eq!(std::fs::read_to_string(&page).expect("a page"), block);
    assert_eq!(measure(&[]).0, Some(0));
    let written = std::fs::read_to_string(&page).expect("a page");
    assert!(written.starts_with("# A page\n\n```measure\ncofferdam-lab variants"), "{written}");
    assert!(
        written.ends_with("<!-- end of measurement -->\n\nafter\n") && !written.contains("old"),
        "{written}"
    );
    assert!(
        written.contains("| `dam.damping.ratio=0.1` |") && written.contains("Measured on 20"),
        "{written}"
    );
    // This commit has written the block already.
    assert_eq!(measure(&[]).0, Some(0));
    assert_eq!(std::fs::read_to_string(&page).expect("a page"), written);
    std::fs::write(&page, block.replace("rigid-blocks", "rigid")).expect("a page");
    let (status, said) = measure(&[]);
    assert!(status == Some(1) && said.contains("page.md") && said.contains("dam.fidelity"), "{said}");
}
