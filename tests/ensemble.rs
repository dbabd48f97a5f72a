//! `cofferdam ensemble`: the same numbers as single runs, the same bytes after interruptions, errors before any work.

use crate::report::{Page, loads_nothing, report, said};
use cofferdam_motion::GroundMotion;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use whole_chain::scenario::{Scenario, binary, root};

/// A plan of a coarse dam for half a second: two records, two polarities, three levels, two dams drawn, two meshes.
const PLAN: &str = r#"
set = ["time.quiet=0"]
polarities = [1, -1]
samples = 2
seed = 4
[intensity]
levels = [0.05, 0.4, 1.5]
[parameters]
"dam.material.young_modulus" = { lognormal = { median = 31e9, dispersion = 0.1 } }
[numerics]
"dam.element_size" = { values = [20.0, 15.0] }
[[limits]]
quantity = "peak sliding"
above = 0.3
[[limits]]
quantity = "peak sliding"
above = 1e6
[[limits]]
quantity = "residual sliding"
above = 1.0
"#;
/// Number of its samples.
const SAMPLES: usize = 2 * 2 * 2 * 2 * 3;

struct Study {
    folder: TempDir,
    scene: Scenario,
    plan: PathBuf,
}

impl Study {
    fn new(plan: &str) -> Self {
        Self::of_records(2, plan)
    }

    /// A plan for the first of the records.
    fn of_records(count: usize, plan: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = Scenario::quick(0.5);
        scene.remove("time.duration").write();
        let record = |name: &str| root().join("scenes/records").join(name);
        let records =
            ["northridge-1994-canyon-country-270.csv", "loma-prieta-1989-corralitos-038.csv"].map(record);
        let records: Vec<String> = (records.iter().zip(["start = 4.5, end = 5.0", "start = 3.0, end = 3.5"]))
            .take(count)
            .map(|(file, part)| format!("{{ file = {file:?}, {part} }}"))
            .collect();
        let text = format!("scene = {:?}\nrecords = [{}]\n{plan}", scene.folder(), records.join(", "));
        let plan = folder.path().join("plan.toml");
        std::fs::write(&plan, text).expect("a plan");
        Self { folder, scene, plan }
    }

    fn command(&self, output: &Path) -> Command {
        let mut command = Command::new(binary());
        command.arg("ensemble").arg(&self.plan).arg("--output").arg(output);
        command
    }

    fn run(&self, output: &Path, more: &[&str]) -> Output {
        let done = self.command(output).args(more).output().expect("cofferdam runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        done
    }
}

/// Names and bytes of what an ensemble leaves, samples included.
fn content(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for part in [folder.to_owned(), folder.join("samples")] {
        for entry in std::fs::read_dir(part).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_file() {
                let name = path.strip_prefix(folder).expect("in it").display().to_string();
                files.push((name, std::fs::read(path).expect("a file")));
            }
        }
    }
    files.sort();
    files
}

fn rows(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let headings = table.headers().expect("headings").iter().map(str::to_owned).collect();
    let rows = table.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect());
    (headings, rows.collect())
}

#[test]
fn an_ensemble_has_the_numbers_of_single_runs_and_its_tables_say_what_they_show() {
    let study = Study::new(PLAN);
    let output = study.folder.path().join("out");
    study.run(&output, &[]);
    let (headings, results) = rows(&output.join("results.csv"));
    assert_eq!(results.len(), SAMPLES);
    let column =
        |name: &str| headings.iter().position(|heading| heading == name).unwrap_or_else(|| panic!("{name}"));
    let number = |row: &[String], name: &str| -> f64 { row[column(name)].parse().expect("a number") };
    assert!(results.iter().all(|row| row[column("status")] == "completed"));
    // One of them as a run of its own.
    let row = &results[SAMPLES - 2];
    assert_eq!(row[column("polarity")], "-1");
    let single = study.folder.path().join("single");
    let set = |key: &str, value: &str| format!("--set={key}={value}");
    let done = Command::new(binary())
        .arg("run")
        .arg(study.scene.folder())
        .args(["--quiet", "--transport", "in-process", "--set", "time.quiet=0"])
        .arg(set(
            "ground_motion.record.file",
            &format!("{:?}", root().join("scenes/records/loma-prieta-1989-corralitos-038.csv")),
        ))
        .args([set("ground_motion.record.start", "3"), set("ground_motion.record.end", "3.5")])
        .arg(set("ground_motion.record.polarity", "-1"))
        .arg(set("ground_motion.record.scale", &row[column("scale")]))
        .arg(set("dam.material.young_modulus", &row[column("dam.material.young_modulus")]))
        .arg(set("dam.element_size", &row[column("dam.element_size")]))
        .arg("--output")
        .arg(&single)
        .output()
        .expect("cofferdam runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let manifest: toml::Table =
        std::fs::read_to_string(single.join("manifest.toml")).expect("a manifest").parse().expect("TOML");
    let mut compared = 0;
    for quantity in manifest["result"]["quantities"].as_array().expect("quantities") {
        let [name, unit] = ["name", "unit"].map(|key| quantity[key].as_str().expect("a word"));
        if name.starts_with("natural frequency") {
            continue;
        }
        let value = quantity["value"].as_float().expect("a number");
        assert_eq!(number(row, &format!("{name} [{unit}]")).to_bits(), value.to_bits(), "{name}");
        compared += 1;
    }
    assert!(compared > 20, "{compared}");
    // Level and scale belong together.
    let (first, strongest) = (&results[0], &results[2]);
    assert_eq!((&*first[column("PGA [g]")], &*strongest[column("PGA [g]")]), ("0.05", "1.5"));
    let ratio = number(strongest, "scale") / number(first, "scale");
    assert!((ratio / 30.0 - 1.0).abs() < 1e-12, "{ratio}");
    // The median of the table is that of the rows.
    let (_, statistics) = rows(&output.join("statistics.csv"));
    let of = |level: &str| {
        let row =
            statistics.iter().find(|row| row[0] == "peak sliding [mm]" && row[1] == level).expect("a row");
        (row[2].clone(), row[3].parse::<f64>().expect("a number"))
    };
    let mut at_level: Vec<f64> = results
        .iter()
        .filter(|row| row[column("PGA [g]")] == "1.5")
        .map(|row| number(row, "peak sliding [mm]"))
        .collect();
    at_level.sort_by(f64::total_cmp);
    let middle = (at_level[7] + at_level[8]) / 2.0;
    assert_eq!(at_level.len(), 16);
    let (count, median) = of("1.5 g");
    assert!(count == "16" && (median - middle).abs() < 1e-12 * middle.abs().max(1.0), "{median} {middle}");
    // One limit has a curve or says why not; the other one is never exceeded.
    let text = std::fs::read_to_string(output.join("ensemble.md")).expect("a text");
    let exceeding = results.iter().filter(|row| number(row, "peak sliding [mm]").abs() > 0.3).count();
    assert!(exceeding > 0 && exceeding < SAMPLES, "{exceeding}");
    assert!(text.contains(&format!("| peak sliding > 0.3 mm | {exceeding} of {SAMPLES} |")), "{text}");
    // Two records support no curve; stronger shaking is proposed for the limit that no run exceeds.
    assert!(text.contains("no curve: 2 independent records or pairs, at least 12 are needed"), "{text}");
    let proposal = "no run exceeds the limit; add 2.2 g, 3.4 g (16 runs each): --add-levels runs them; add 10 records or pairs";
    assert!(text.contains(proposal), "{text}");
    let (_, curves) = rows(&output.join("fragility.csv"));
    assert!(curves.iter().all(|row| row[1..].iter().all(String::is_empty)), "no curve, and no step either");
    // The share of a level has the exact interval of two records.
    let (_, levels) = rows(&output.join("exceedance.csv"));
    let share = |row: &[String], column: usize| -> f64 { row[column].parse().expect("a share") };
    let of_none: Vec<_> = levels.iter().filter(|row| row[0].ends_with("1000000 mm")).collect();
    assert_eq!(of_none.len(), 3);
    for row in of_none {
        assert_eq!(row[2..6], ["16", "0", "2", "0"]);
        let high = 1.0 - 0.025f64.sqrt();
        assert!(share(row, 6) == 0.0 && (share(row, 7) - high).abs() < 1e-9, "{row:?}");
    }
    // Without rest there is no residual sliding.
    assert!(
        text.contains(&format!(
            "{SAMPLES} runs lack this value, because they failed or their blocks still move"
        )),
        "{text}"
    );
    assert!(
        text.contains("| polarity | dam.material.young_modulus | dam.element_size (numerics) | rest |"),
        "{text}"
    );
    for picture in ["ida.svg", "fragility.svg"] {
        let text = std::fs::read_to_string(output.join(picture)).expect("a picture");
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"), "{picture}");
    }
    the_page_has_the_numbers_of_the_tables(&output);
}

/// The page of an ensemble of [`PLAN`].
fn the_page_has_the_numbers_of_the_tables(output: &Path) {
    let page = Page::read(&output.join("report.html"));
    let outside = loads_nothing(&page);
    // Below their headings, tables of the folder and of the page have the same rows: numbers with all digits, and words.
    let same = |class: &str, file: &str, columns: &[&str], rows_of: &dyn Fn(&[String]) -> bool| {
        let (headings, table) = rows(&output.join(file));
        let columns: Vec<usize> = columns
            .iter()
            .map(|name| {
                headings.iter().position(|heading| heading == name).unwrap_or_else(|| panic!("{name}"))
            })
            .collect();
        let shown = &page.rows[class][1..];
        let table: Vec<_> = table.into_iter().filter(|row| rows_of(row)).collect();
        assert_eq!(shown.len(), table.len(), "{class}");
        for (shown, row) in shown.iter().zip(&table) {
            let cells = columns.iter().map(|column| &row[*column]);
            let numbers = cells.clone().filter_map(|cell| cell.parse().ok());
            assert_eq!(shown.numbers, numbers.collect::<Vec<f64>>(), "{class}: {shown:?}");
            let words = cells.filter(|cell| !cell.is_empty() && cell.parse::<f64>().is_err());
            assert!(words.clone().all(|cell| shown.cells.contains(cell)), "{class}: {shown:?} {row:?}");
        }
        assert!(!table.is_empty(), "{class}");
    };
    let all = |_: &[String]| true;
    let of_table =
        ["quantity", "level", "runs", "median", "low", "high", "16 %", "84 %", "mean", "deviation"];
    same("statistics all", "statistics.csv", &of_table, &all);
    same("statistics", "statistics.csv", &of_table, &|row| {
        ["peak crest displacement", "residual sliding", "peak sliding", "peak opening"]
            .iter()
            .any(|shown| row[0].starts_with(shown))
    });
    let counts = ["limit", "exceeding", "runs", "left out", "records", "curve"];
    let of_curve = ["median [g]", "low", "high", "dispersion", "dispersion low", "dispersion high"];
    same("fits", "limits.csv", &[&counts[..], &of_curve, &["add levels", "remark"]].concat(), &all);
    same(
        "exceedance",
        "exceedance.csv",
        &["limit", "level", "runs", "exceeding", "records", "share", "low", "high", "curve"],
        &all,
    );
    let (headings, results) = rows(&output.join("results.csv"));
    let shown = &page.rows["results sortable"];
    let at =
        |name: &str| headings.iter().position(|heading| heading == name).unwrap_or_else(|| panic!("{name}"));
    let quantities =
        shown[0].cells.iter().filter(|heading| heading.ends_with(']') && !heading.starts_with("PGA"));
    let quantities: Vec<_> = quantities.map(String::as_str).collect();
    assert!(quantities.contains(&"peak sliding [mm]"), "{quantities:?}");
    let numbers = [
        &["sample", "polarity", "scale", "PGA [g]"][..],
        &["dam.material.young_modulus", "dam.element_size"],
        &quantities,
    ];
    for (shown, row) in shown[1..].iter().zip(&results) {
        let numbers = numbers.concat().into_iter().filter_map(|name| row[at(name)].parse().ok());
        assert_eq!(shown.numbers, numbers.collect::<Vec<f64>>(), "{shown:?}");
        assert!(
            shown.cells.contains(&row[at("status")]) && shown.cells.contains(&row[at("record")]),
            "{shown:?}"
        );
        assert!(shown.cells.contains(&row[at("hash")][..8].to_owned()));
        assert!(outside.contains(&format!("samples/{}.toml", row[at("hash")])));
    }
    assert_eq!((shown.len() - 1, outside.len()), (SAMPLES, SAMPLES));
    assert!(outside.iter().all(|link| output.join(link).is_file()));
    // What matters first: runs, failures, blocks that move; the limit with a curve.
    assert_eq!(page.figures[0].numbers, [SAMPLES as f64; 2]);
    assert_eq!(page.figures[1].numbers, [0.0, SAMPLES as f64]);
    // An exceedance is a count of rows.
    let exceeding = results.iter().filter(|row| {
        row[at("PGA [g]")] == "0.4"
            && row[at("peak sliding [mm]")].parse::<f64>().expect("a number").abs() > 0.3
    });
    let (_, exceedance) = rows(&output.join("exceedance.csv"));
    assert_eq!(exceedance[1][..4], ["peak sliding > 0.3 mm", "0.4 g", "16", &exceeding.count().to_string()]);
    // Origin: hashes of plan and records.
    let hash = |path: &Path| {
        let said = Command::new("sha256sum").arg(path).output().expect("sha256sum").stdout;
        String::from_utf8_lossy(&said)[..64].to_owned()
    };
    let records = root().join("scenes/records");
    for path in [output.join("plan.toml"), records.join("loma-prieta-1989-corralitos-038.csv")] {
        assert!(page.words.contains(&hash(&path)), "{}", path.display());
    }
    for words in [
        "lognormal, median 31000000000, dispersion 0.1",
        "medians have no interval",
        "no run exceeds the limit",
    ] {
        assert!(page.words.contains(words), "{words}");
    }
    assert_eq!(page.markup.matches("<figure class=\"curves\"><svg").count(), 2);
    // The command writes the same page, and says what a folder lacks.
    let place = output.join("again.html");
    let done = report(&[output, Path::new("--output"), &place]);
    assert!(done.status.success(), "{}", said(&done));
    assert_eq!(std::fs::read(&place).expect("a page"), page.text.as_bytes());
    std::fs::remove_file(output.join("limits.csv")).expect("removed");
    let done = report(&[output]);
    assert!(
        done.status.code() == Some(2)
            && said(&done).contains("samples already in the folder are not run again")
    );
}

/// Levels that curves lack are run with one option; what was there stays, and later commands know them.
#[test]
fn missing_levels_are_added_and_stay() {
    let study = Study::new(
        "set = [\"time.quiet=0\", \"dam.element_size=20\"]\n[intensity]\nlevels = [0.4, 1.5]\n[[limits]]\nquantity = \"peak sliding\"\n\
         above = 1e6\n",
    );
    let output = study.folder.path().join("out");
    study.run(&output, &[]);
    let before = content(&output);
    let done = study.run(&output, &["--add-levels"]);
    let told = said(&done);
    assert!(
        told.contains("levels that are added: 2.2 g, 3.4 g") && told.contains("8 samples, 4 of them"),
        "{told}"
    );
    assert_eq!(std::fs::read_to_string(output.join("added.toml")).expect("levels"), "levels = [2.2, 3.4]\n");
    let after = content(&output);
    let samples = before.iter().filter(|(name, _)| name.starts_with("samples"));
    assert!(samples.clone().count() == 4 && samples.clone().all(|sample| after.contains(sample)));
    let (headings, results) = rows(&output.join("results.csv"));
    let at = headings.iter().position(|heading| heading == "PGA [g]").expect("the measure");
    let levels: Vec<&str> = results.iter().map(|row| &*row[at]).collect();
    assert_eq!(levels, ["0.4", "1.5", "2.2", "3.4"].repeat(2));
    let page = Page::read(&output.join("report.html"));
    assert!(page.words.contains("2.2 g, 3.4 g added by --add-levels"), "{}", page.words);
    // Without the option the levels stay, and nothing is run or changed.
    study.run(&output, &[]);
    assert_eq!(content(&output), after);
    // Bad input is refused before any work.
    for (more, text, wanted) in [
        (&["--add-levels", "--part", "1/2"][..], "levels = [2.2]\n", "cannot be used with"),
        (&[], "levels = [26.0]\n", "`levels` has 26; levels lie between 0 and 10"),
    ] {
        std::fs::write(output.join("added.toml"), text).expect("a file");
        let done = study.command(&output).args(more).output().expect("cofferdam runs");
        assert_eq!(done.status.code(), Some(2));
        let told = said(&done);
        assert!(told.contains(wanted), "{told}");
    }
    let study = Study::new("[intensity]\nlevels = [0.4]\n");
    let done = study.command(&output).arg("--add-levels").output().expect("cofferdam runs");
    let told = said(&done);
    assert!(done.status.code() == Some(2) && told.contains("`limits` is an empty list"), "{told}");
}

/// Motions that differ a little: every method has the same ones, and the table of methods holds the ratio of their medians.
#[test]
fn methods_are_compared_on_the_same_perturbed_motions() {
    let study = Study::new(
        "set = [\"time.quiet=0\"]\nperturbation = { count = 3, noise = 0.05 }\n[intensity]\nlevels = [0.6]\n[numerics]\n\
         \"dam.element_size\" = { values = [20.0, 15.0] }\n",
    );
    let output = study.folder.path().join("out");
    study.run(&output, &["--no-report"]);
    assert!(!output.join("report.html").exists());
    let (headings, results) = rows(&output.join("results.csv"));
    assert_eq!(results.len(), 2 * 3 * 2);
    let column =
        |name: &str| headings.iter().position(|heading| heading == name).unwrap_or_else(|| panic!("{name}"));
    let peak = |row: &Vec<String>| -> f64 {
        row[column("peak crest displacement downstream [mm]")].parse().expect("a number")
    };
    let of_size = |size: &str| -> Vec<f64> {
        let rows = results.iter().filter(|row| row[column("dam.element_size")] == size);
        rows.map(peak).collect()
    };
    let [coarse, fine] = ["20.0", "15.0"].map(of_size);
    for values in [&coarse, &fine] {
        let mut different = values.clone();
        different.sort_by(f64::total_cmp);
        different.dedup();
        assert_eq!(different.len(), 6, "{values:?}");
        // Noise of 5 % moves the crest by some per cent, not by its whole.
        for of_record in values.chunks(3) {
            let mean = of_record.iter().sum::<f64>() / 3.0;
            assert!(of_record.iter().all(|peak| (peak / mean - 1.0).abs() < 0.3), "{values:?}");
        }
    }
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        (values[2] + values[3]) / 2.0
    };
    let (_, methods) = rows(&output.join("methods.csv"));
    let row = methods.iter().find(|row| row[0] == "peak crest displacement downstream [mm]").expect("a row");
    assert_eq!(row[2..5], ["element_size 20.0", "element_size 15.0", "6"]);
    let ratio: f64 = row[5].split(' ').next().expect("a ratio").parse().expect("a number");
    assert!((ratio / (median(coarse) / median(fine)) - 1.0).abs() < 0.01, "{row:?}");
    let done = report(&[&output]);
    assert!(done.status.success(), "{}", said(&done));
    let page = Page::read(&output.join("report.html"));
    let of_page = page.rows["methods"].iter().find(|of_page| of_page.cells[..5] == row[..5]).expect("a row");
    assert_eq!(of_page.cells[5..], row[5..]);
}

#[test]
fn a_run_with_twins_tells_the_band_of_each_number() {
    let mut scene = Scenario::quick(1.5);
    scene.set("ground_motion.record.start", 4.0).set("dam.element_size", 20.0);
    let run = |output: &str, more: &[&str]| {
        let mut command = scene.command(output);
        let done =
            command.args(["--band", "4", "--transport", "in-process"]).args(more).output().expect("it runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let text =
            std::fs::read_to_string(scene.folder().join(output).join("manifest.toml")).expect("a manifest");
        let told =
            String::from_utf8(done.stdout).expect("text").split_whitespace().collect::<Vec<_>>().join(" ");
        (told, text.parse::<toml::Table>().expect("TOML"))
    };
    let (told, manifest) = run("band", &[]);
    assert!(
        told.contains(
            "16 %, median and 84 % of 4 perturbed replicates (1 % noise on the motion), with the reduced model"
        ),
        "{told}"
    );
    let quantities = manifest["result"]["quantities"].as_array().expect("quantities");
    let crest = quantities.iter().find(|q| q["name"].as_str() == Some("peak crest displacement downstream"));
    let crest = crest.expect("the crest");
    let band: Vec<f64> = crest["band"]
        .as_array()
        .expect("a band")
        .iter()
        .map(|value| value.as_float().expect("a number"))
        .collect();
    assert!(band[0] < band[1] && band[1] < band[2], "{band:?}");
    let value = crest["value"].as_float().expect("a number");
    assert!((band[1] / value - 1.0).abs() < 0.2, "{band:?} {value}");
    let rows = told
        .split("replicates: 16 % ")
        .skip(1)
        .filter_map(|rest| rest.split([',', ' ']).next()?.parse().ok());
    let told_lowest: Vec<f64> = rows.collect();
    assert!(told_lowest.iter().any(|told| (told / band[0] - 1.0).abs() < 1e-3), "{told}");
    // Modes know no local damping: the run is whole, and says that it has no band.
    let (told, _) = run("none", &["--set", "dam.damping.model=\"local\""]);
    assert!(told.contains("WARNING: no band: "), "{told}");
}

/// Killed at several moments and gone on with, in two parts, or by one thread: the same bytes everywhere.
#[test]
fn interrupted_or_divided_ensembles_end_with_the_same_bytes() {
    let study = Study::new(PLAN);
    let [whole, killed, parts] = ["whole", "killed", "parts"].map(|name| study.folder.path().join(name));
    study.run(&whole, &["--threads", "1"]);
    let expected = content(&whole);
    assert_eq!(expected.iter().filter(|(name, _)| name.starts_with("samples/")).count(), SAMPLES);
    let kept = |folder: &Path| std::fs::read_dir(folder.join("samples")).map_or(0, Iterator::count);
    let kills = std::env::var("COFFERDAM_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(3);
    for kill in 0..kills {
        let mut child = study.command(&killed).stdout(Stdio::null()).spawn().expect("cofferdam starts");
        let (target, began) = (1 + (SAMPLES - 2) * kill / kills, Instant::now());
        while kept(&killed) < target && child.try_wait().expect("a child").is_none() {
            assert!(began.elapsed() < Duration::from_secs(120), "no sample is written");
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
    }
    assert!(kept(&killed) >= 1, "the last kill came before the first sample");
    // What a kill left of a file that was being written does no harm; a torn sample is run again.
    let torn =
        std::fs::read_dir(killed.join("samples")).expect("samples").next().expect("one").expect("one").path();
    let half = std::fs::read(&torn).expect("a sample");
    std::fs::write(&torn, &half[..half.len() / 2]).expect("a torn sample");
    study.run(&killed, &[]);
    let whole_samples = |content: Vec<(String, Vec<u8>)>| -> Vec<(String, Vec<u8>)> {
        content.into_iter().filter(|(name, _)| !name.contains("/.tmp")).collect()
    };
    assert_eq!(whole_samples(content(&killed)), expected);
    let told = String::from_utf8(study.run(&parts, &["--part", "2/2"]).stdout).expect("text");
    assert!(told.contains(&format!("{} samples, {} of them to be run", SAMPLES / 2, SAMPLES / 2)), "{told}");
    assert!(!parts.join("results.csv").exists() && !parts.join("report.html").exists());
    let done = report(&[&parts]);
    assert!(
        done.status.code() == Some(2) && said(&done).contains("is missing: `cofferdam ensemble"),
        "{}",
        said(&done)
    );
    study.run(&parts, &["--part", "1/2"]);
    let told = String::from_utf8(study.run(&parts, &[]).stdout).expect("text");
    assert!(told.contains(&format!("{SAMPLES} samples, 0 of them to be run")), "{told}");
    assert_eq!(content(&parts), expected);
}

/// The scaled spectra have the target in the geometric mean over 0.2 to 2 times the period, and the larger polarity governs.
#[test]
fn records_are_scaled_to_a_target_spectrum() {
    let study = Study::new(
        "set = [\"time.quiet=0\"]\npolarities = [1, -1]\n[intensity]\nperiod = 0.3\nscales = [0.5, 1.0]\n\
         target = { spectrum = \"spectrum.csv\" }",
    );
    let spectrum = |period: f64| 0.4 * (period / 0.3).powf(-0.5);
    let lines = [0.06, 0.6].map(|period| format!("{period},{}\n", spectrum(period)));
    std::fs::write(study.folder.path().join("spectrum.csv"), format!("period_s,sa [g]\n{}", lines.concat()))
        .expect("a spectrum");
    let output = study.folder.path().join("out");
    study.run(&output, &[]);
    let (_, fits) = rows(&output.join("target.csv"));
    let (headings, results) = rows(&output.join("results.csv"));
    let column =
        |name: &str| headings.iter().position(|heading| heading == name).unwrap_or_else(|| panic!("{name}"));
    let number = |row: &[String], at: usize| -> f64 { row[at].parse().expect("a number") };
    assert_eq!((fits.len(), results.len()), (2, 8));
    let records =
        [("northridge-1994-canyon-country-270", [4.5, 5.0]), ("loma-prieta-1989-corralitos-038", [3.0, 3.5])];
    for (fit, (record, [start, end])) in fits.iter().zip(records) {
        let factor = number(fit, 1);
        for row in results.iter().filter(|row| row[column("record")] == record) {
            let ratio = number(row, column("scale")) / factor;
            assert!([0.5, 1.0].contains(&ratio), "{record}: {ratio}");
        }
        let file = root().join("scenes/records").join(record).with_extension("csv");
        let motion = GroundMotion::from_record(&file, None, start, end, factor).expect("a record");
        let periods: Vec<f64> = (0..61).map(|i| 0.06 * 10f64.powf(f64::from(i) / 60.0)).collect();
        let scaled = motion.response_spectrum(&periods, 0.05);
        let over = |(sa, period): (&f64, &f64)| (sa / 9.80665 / spectrum(*period)).ln();
        let mean = scaled.iter().zip(&periods).map(over).sum::<f64>() / 61.0;
        assert!(mean.abs() < 1e-9, "{record}: {mean}");
    }
    let (_, polarities) = rows(&output.join("polarities.csv"));
    let crest = "peak crest displacement downstream";
    let of_crest: Vec<_> = polarities.iter().filter(|row| row[0].starts_with(crest)).collect();
    assert_eq!(of_crest.len(), 2 * 2);
    for row in of_crest {
        let larger = if number(row, 3) > number(row, 4) { "+1" } else { "-1" };
        let of_run = |polarity: &str| {
            let level = if row[1] == "target × 1" { 1.0 } else { 0.5 };
            let factor =
                fits.iter().find(|fit| fit[0] == row[2]).map(|fit| number(fit, 1)).expect("a factor");
            let run = results.iter().find(|run| {
                run[column("record")] == row[2]
                    && run[column("polarity")] == polarity
                    && number(run, column("scale")) == level * factor
            });
            number(run.expect("a run"), column(&row[0])).abs()
        };
        assert_eq!((number(row, 3), number(row, 4), &*row[5]), (of_run("1"), of_run("-1"), larger));
    }
    let read = |name: &str| std::fs::read_to_string(output.join(name)).expect("a file");
    assert!(read("spectra.svg").contains("geometric mean"));
    // The page has both: the spectra with the records' factors, and who governs.
    let page = read("report.html");
    let section = |id: &str| {
        let from = page.find(&format!("<section id=\"{id}\"")).unwrap_or_else(|| panic!("no section {id}"));
        page[from..].split("</section>").next().unwrap_or_default().to_owned()
    };
    let [target, governs] = ["target", "polarities"].map(section);
    assert!(target.contains("geometric mean"));
    assert!(fits.iter().all(|fit| target.contains(&fit[0]) && target.contains(&fit[1])), "{fits:?}");
    assert_eq!(governs.matches(crest).count(), 2 * 2);
    assert_eq!(
        governs.matches("<td>+1</td>").count() + governs.matches("<td>-1</td>").count(),
        polarities.len()
    );
}

#[test]
fn a_plan_that_is_wrong_is_refused_before_any_run() {
    let taken = tempfile::tempdir().expect("a folder");
    std::fs::write(taken.path().join("other"), "x").expect("a file");
    let refused = |plan: &str, output: &Path, status: i32, wanted: &str| {
        let study = Study::new(plan);
        let done = study.command(output).output().expect("cofferdam runs");
        // Without the bar before lines that are continued.
        let message = String::from_utf8_lossy(&done.stderr);
        let words = message.split_whitespace().filter(|word| *word != "│");
        let message = words.collect::<Vec<_>>().join(" ");
        assert_eq!(done.status.code(), Some(status), "{message}");
        assert!(message.contains(wanted), "{message}\nwanted: {wanted}");
    };
    let folder = tempfile::tempdir().expect("a folder");
    let new = folder.path().join("new");
    refused("polarity = 1", &new, 2, "unknown field `polarity`");
    refused("[parameters]\n\"dam.no_key\" = { values = [1] }", &new, 2, "`no_key` is no key");
    refused("[parameters]\n\"dam.element_size\" = { values = [-1.0] }", &new, 2, "dam.element_size");
    refused(
        "[[limits]]\nquantity = \"peak slidign\"\nabove = 1.0",
        &new,
        2,
        "\"peak sliding\"? The runs have",
    );
    refused("[intensity]\nlevels = [20]", &new, 2, "they are in g");
    refused("[dear]\nset = [\"dam.element_size=5\"]", &new, 2, "`[dear]` is no longer supported");
    let target = "[intensity]\nperiod = 0.3\ntarget = { spectrum = \"no.csv\" }";
    refused(target, &new, 2, "no.csv: No such file");
    assert!(!new.exists(), "nothing is written for a plan that is wrong");
    refused("", taken.path(), 1, "contains no ensemble or one of another plan");
}
