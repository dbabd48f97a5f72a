//! Contents of the report of an ensemble, independent of their layout.

use super::folder::{EnsembleFolder, Table};
use super::grid::{Cell, Grid};
use crate::page::data::{Group, Row};
use crate::summary::NOT_AT_REST;
use cofferdam_coupling::observer::Status;

/// Start of the name of the column with the number of records for a width of all intervals, in percentage points.
const RECORDS_FOR: &str = "records for ";
/// Columns of a curve.
const OF_CURVES: [&str; 6] = ["median [g]", "low", "high", "dispersion", "dispersion low", "dispersion high"];
/// Maximum number of failed runs listed by name.
const LISTED: usize = 8;
/// Smallest number of independent values whose median has an interval.
const LEAST_OF_MEDIANS: usize = 6;
/// The column of the pairs in the table of records.
const PAIR: usize = 2;
/// Sentence of runs whose blocks still move.
const MOVING: &str = "blocks still moved at the end: no residual sliding";

/// Everything that a report of an ensemble shows, in its order. What it does not have is empty.
#[derive(Clone, Debug, PartialEq)]
pub struct EnsembleData {
    /// Title of the plan, or of its scene.
    pub title: String,
    /// Title of the scene.
    pub scene: String,
    /// Number of all runs.
    pub runs: usize,
    /// Number of completed runs.
    pub completed: usize,
    /// Number of completed runs with blocks still moving at the end.
    pub moving: usize,
    /// For each limit whose curve the runs support: its name, then median and dispersion, each with its interval.
    pub curves: Vec<(String, [[f64; 3]; 2])>,
    /// For each kind of sliding, the joint that governs most runs: quantity, joint, remark.
    pub governing_joints: Vec<[String; 3]>,
    /// Name of the intensity measure, in g.
    pub measure: String,
    /// Warnings.
    pub warnings: Vec<String>,
    /// What is not modelled, each in a sentence.
    pub not_modelled: Vec<String>,
    /// The plan.
    pub plan: Group,
    /// The records.
    pub records: Grid,
    /// Varied keys with their variations.
    pub varied: Grid,
    /// Factors of the records to a target spectrum.
    pub target: Grid,
    /// The scaled spectra and their target, SVG.
    pub spectra: Option<String>,
    /// Governing joint.
    pub joints: Grid,
    /// Governing polarity.
    pub polarities: Grid,
    /// Number of records that the exact intervals need for a stated width, if curves are not supported.
    pub advice: Option<String>,
    /// Median and dispersion of each limit.
    pub limits: Grid,
    /// Share of the runs that exceed each limit at each level, and the curve there.
    pub exceedance: Grid,
    /// The fragility curves, SVG.
    pub fragility: Option<String>,
    /// The incremental dynamic analysis, SVG.
    pub analysis: Option<String>,
    /// Statistics of the key figures.
    pub statistics: Grid,
    /// Statistics of all quantities.
    pub all_statistics: Grid,
    /// Shares of the variance.
    pub variance: Grid,
    /// Comparison of methods.
    pub methods: Grid,
    /// All runs.
    pub results: Grid,
    /// Program, machine, hashes.
    pub provenance: Group,
    /// The plan's file.
    pub plan_text: String,
}

impl EnsembleData {
    /// What the files of an ensemble say.
    pub fn of(folder: &EnsembleFolder) -> Self {
        let EnsembleFolder {
            manifest,
            results,
            limits,
            statistics,
            variance,
            methods,
            target,
            polarities,
            ..
        } = folder;
        let status = results.column("status");
        let is_completed =
            |row: &&Vec<String>| status.is_some_and(|at| row[at] == Status::Completed.to_string());
        let said = results.column("warnings");
        let moves = |row: &&Vec<String>| said.is_some_and(|at| row[at].contains(NOT_AT_REST));
        let is_shown =
            |label: &str| manifest.shown.iter().any(|shown| label.starts_with(&format!("{shown} [")));
        let advised: Vec<&str> =
            limits.headings.iter().map(String::as_str).filter(|name| name.starts_with(RECORDS_FOR)).collect();
        let all = |table: &Table| (0..table.headings.len()).collect::<Vec<_>>();
        let share = |grid: Grid, from: usize| Grid {
            rows: grid
                .rows
                .into_iter()
                .map(|row| row.into_iter().enumerate().map(shares(from)).collect())
                .collect(),
            ..grid
        };
        Self {
            title: if manifest.title.is_empty() { manifest.scene.clone() } else { manifest.title.clone() },
            scene: manifest.scene.clone(),
            runs: results.rows.len(),
            completed: results.rows.iter().filter(is_completed).count(),
            moving: results.rows.iter().filter(is_completed).filter(moves).count(),
            curves: curves(limits),
            governing_joints: governing_joints(&folder.joints),
            measure: manifest.measure.clone(),
            warnings: warnings(folder),
            not_modelled: manifest.not_modelled.clone(),
            plan: plan(folder),
            records: records(folder),
            varied: varied(folder),
            target: Grid::of(target, &all(target), |_| true),
            spectra: folder.spectra.clone(),
            joints: Grid::of(&folder.joints, &all(&folder.joints), |_| true)
                .without_empty(&["lowest limit [mm]"]),
            polarities: governing(polarities),
            advice: advice(limits),
            limits: Grid::of(
                limits,
                &without(limits, &[&["quantity", "above", "unit"], &advised[..]].concat()),
                |_| true,
            )
            .without_empty(&OF_CURVES)
            .without_empty(&["add levels", "remark"]),
            exceedance: exceedance(&folder.exceedance),
            fragility: folder.fragility.clone(),
            analysis: folder.analysis.clone(),
            statistics: Grid::of(statistics, &all(statistics), |row| is_shown(&row[0]))
                .without_empty(&["low", "high"]),
            all_statistics: Grid::of(statistics, &all(statistics), |_| true).without_empty(&["low", "high"]),
            variance: share(Grid::of(variance, &all(variance), |row| is_shown(&row[0])), 1),
            methods: Grid::of(methods, &all(methods), |_| true),
            results: runs(folder, &is_shown),
            provenance: provenance(folder),
            plan_text: folder.plan.clone(),
        }
    }
}

/// Numbers from the column `from` on become shares.
fn shares(from: usize) -> impl Fn((usize, Cell)) -> Cell {
    move |(column, cell)| match cell {
        Cell::Number(share) if column >= from => Cell::Share(share),
        other => other,
    }
}

/// Governing polarity. The last column, which names it, is text: a number would lose its sign.
fn governing(table: &Table) -> Grid {
    let mut grid = Grid::of(table, &without(table, &[]), |_| true);
    for (cells, row) in grid.rows.iter_mut().zip(&table.rows) {
        if let (Some(cell), Some(polarity)) = (cells.last_mut(), row.last()) {
            *cell = Cell::Text(polarity.clone());
        }
    }
    grid
}

fn without(table: &Table, left_out: &[&str]) -> Vec<usize> {
    (0..table.headings.len()).filter(|column| !left_out.contains(&&*table.headings[*column])).collect()
}

/// Median and dispersion of the limits whose curve is supported.
fn curves(limits: &Table) -> Vec<(String, [[f64; 3]; 2])> {
    let text = |row: &[String], name: &str| limits.column(name).map(|column| row[column].clone());
    let number = |row: &[String], name: &str| text(row, name)?.parse::<f64>().ok();
    let of = |row: &Vec<String>| {
        if text(row, "curve")? != "supported" {
            return None;
        }
        let mut values = [0.0; 6];
        for (value, name) in values.iter_mut().zip(OF_CURVES) {
            *value = number(row, name)?;
        }
        let [a, b, c, d, e, f] = values;
        Some((row.first()?.clone(), [[a, b, c], [d, e, f]]))
    };
    limits.rows.iter().filter_map(of).collect()
}

/// How many records make the exact intervals as narrow as stated, if a limit has no supported curve and fewer records.
fn advice(limits: &Table) -> Option<String> {
    let [curve, have] = [limits.column("curve")?, limits.column("records")?];
    let wanted = limits.headings.iter().position(|name| name.starts_with(RECORDS_FOR))?;
    let width = limits.headings[wanted].strip_prefix(RECORDS_FOR)?.split(' ').next()?;
    let number = |text: &str| text.parse::<usize>().ok();
    let row = limits
        .rows
        .iter()
        .find(|row| row[curve] != "supported" && number(&row[have]) < number(&row[wanted]))?;
    Some(format!(
        "The intervals of levels are those of {} independent records or pairs; with {} each is at most {width} percentage points wide.",
        row[have], row[wanted]
    ))
}

/// For each kind of sliding the joint that governs in most runs, over all levels.
fn governing_joints(table: &Table) -> Vec<[String; 3]> {
    let [Some(quantity), Some(joint), Some(runs), Some(governs), Some(by)] =
        ["quantity", "joint", "runs", "governs", "by"].map(|name| table.column(name))
    else {
        return Vec::new();
    };
    let count = |row: &[String], column: usize| row[column].parse::<usize>().unwrap_or(0);
    let mut found: Vec<[String; 3]> = Vec::new();
    for rows in table.rows.chunk_by(|a, b| a[quantity] == b[quantity]) {
        let mut joints: Vec<(&str, usize, usize)> = Vec::new();
        for row in rows {
            match joints.iter_mut().find(|(name, ..)| *name == row[joint]) {
                Some((_, governed, all)) => {
                    *governed += count(row, governs);
                    *all += count(row, runs);
                }
                None => joints.push((&row[joint], count(row, governs), count(row, runs))),
            }
        }
        let most = joints.iter().max_by_key(|(_, governed, _)| *governed);
        let Some((name, governed, all)) = most.filter(|(_, governed, _)| *governed > 0) else { continue };
        let remark = format!("the largest {} in {governed} of {all} runs", rows[0][by]);
        found.push([rows[0][quantity].clone(), (*name).to_owned(), remark]);
    }
    found
}

/// Failures, warnings of the runs, and statistics with too few runs.
fn warnings(folder: &EnsembleFolder) -> Vec<String> {
    let EnsembleFolder { manifest, results, limits, statistics, .. } = folder;
    let mut warnings = failures(results);
    let said = results.column("warnings").map_or_else(Vec::new, |at| {
        results.rows.iter().flat_map(|row| row[at].split(" | ")).filter(|said| !said.is_empty()).collect()
    });
    // Sentences that differ in their numbers only are one.
    let mut kinds: Vec<(String, &str, usize)> = Vec::new();
    for sentence in said {
        let kind =
            sentence.chars().filter(|c| !c.is_ascii_digit() && !".-+e".contains(*c)).collect::<String>();
        match kinds.iter_mut().find(|(known, _, _)| *known == kind) {
            Some((_, _, count)) => *count += 1,
            None => kinds.push((kind, sentence, 1)),
        }
    }
    let runs = results.rows.len();
    warnings.extend(kinds.into_iter().map(|(_, first, count)| {
        let what = if first.contains(NOT_AT_REST) { format!("{MOVING}; ") } else { String::new() };
        format!("in {count} of {runs} runs {what}for example: {first}")
    }));
    if let (Some(limit), Some(remark)) = (limits.column("limit"), limits.column("remark")) {
        let told = limits.rows.iter().filter(|row| !row[remark].is_empty());
        warnings.extend(told.map(|row| format!("{}: {}", row[limit], row[remark])));
    }
    if let (Some(count), Some(low)) = (statistics.column("runs"), statistics.column("low")) {
        let lacks = statistics.rows.iter().filter(|row| row[count] != "0" && row[low].is_empty()).count();
        let (records, all) = (manifest.independent, statistics.rows.len());
        if lacks > 0 && records < LEAST_OF_MEDIANS {
            warnings.push(format!(
                "medians have no interval: it needs at least {LEAST_OF_MEDIANS} independent records or pairs of records, these are {records}"
            ));
        } else if lacks > 0 {
            warnings.push(format!(
                "{lacks} of {all} medians have no interval: fewer than {LEAST_OF_MEDIANS} independent records or pairs of records have a value"
            ));
        }
    }
    warnings.extend(manifest.warnings.iter().cloned());
    warnings
}

/// The runs that did not reach their end, with the reasons.
fn failures(results: &Table) -> Vec<String> {
    let [Some(status), Some(sample), Some(record), Some(polarity), Some(scale)] =
        ["status", "sample", "record", "polarity", "scale"].map(|name| results.column(name))
    else {
        return Vec::new();
    };
    let failed: Vec<_> =
        results.rows.iter().filter(|row| row[status] != Status::Completed.to_string()).collect();
    let named = failed.iter().take(LISTED).map(|row| {
        let scale = Cell::of(&row[scale]);
        let scale = if let Cell::Number(scale) = scale { format!("{scale:.4}") } else { String::new() };
        format!(
            "run {} ({}, polarity {}, scale {scale}) is excluded from the statistics: {}",
            row[sample], row[record], row[polarity], row[status]
        )
    });
    let mut said: Vec<String> = named.collect();
    if failed.len() > LISTED {
        said.push(format!("and {} more; the table of all runs gives the reasons", failed.len() - LISTED));
    }
    said
}

fn plan(folder: &EnsembleFolder) -> Group {
    let manifest = &folder.manifest;
    let polarities: Vec<&str> =
        manifest.polarities.iter().map(|p| if *p < 0 { "upstream" } else { "downstream" }).collect();
    let mut rows = vec![
        Row::text("scene", manifest.scene.clone()),
        Row::text("intensity measure", manifest.measure.clone()),
        match manifest.added.is_empty() {
            true => Row::text("levels of shaking", manifest.levels.join(", ")),
            false => Row::text("levels of shaking", manifest.levels.join(", "))
                .with(format!("{} added by --add-levels", manifest.added.join(", "))),
        },
        Row::text(
            if manifest.records.len() == 1 {
                "independent motions of the record"
            } else {
                "independent records or pairs"
            },
            manifest.independent.to_string(),
        ),
        Row::text("positive accelerations point", polarities.join(" and ")),
        Row::text("realisations per record and polarity", manifest.samples.to_string()),
        Row::text("seed", manifest.seed.to_string()),
    ];
    rows.extend(manifest.perturbation.map(|(count, noise)| {
        Row::text("perturbed motions per record", count.to_string())
            .with(format!("noise of {} %", 100.0 * noise))
    }));
    rows.extend(manifest.set.iter().map(|set| Row::code("changed in all runs", set.clone())));
    Group { name: "Plan".to_owned(), rows }
}

fn records(folder: &EnsembleFolder) -> Grid {
    let manifest = &folder.manifest;
    let headings =
        ["record", "file", "pair", "factor", &format!("{} as recorded, g", manifest.measure), "SHA-256"];
    let row = |record: &crate::EnsembleRecord| {
        vec![
            Cell::Text(record.name.clone()),
            Cell::Code(record.file.clone()),
            Cell::Text(record.pair.clone()),
            Cell::Number(record.factor),
            Cell::Number(record.measure),
            Cell::Code(record.sha256.clone()),
        ]
    };
    let mut grid = Grid {
        headings: headings.map(str::to_owned).to_vec(),
        rows: manifest.records.iter().map(row).collect(),
    };
    if manifest.records.iter().any(|record| record.vertical.is_some()) {
        let headings = ["vertical component", "its factor, positive upwards", "its SHA-256"];
        grid.headings.extend(headings.map(str::to_owned));
        for (row, record) in grid.rows.iter_mut().zip(&manifest.records) {
            row.extend(match &record.vertical {
                Some(crate::EnsembleVertical { file, column, scale, polarity, sha256 }) => {
                    let column = column.map_or_else(String::new, |column| format!(", column {column}"));
                    let factor = record.factor * scale * *polarity as f64;
                    [Cell::Code(format!("{file}{column}")), Cell::Number(factor), Cell::Code(sha256.clone())]
                }
                None => [(); 3].map(|()| Cell::Text(String::new())),
            });
        }
    }
    if manifest.records.iter().all(|record| record.pair.is_empty()) {
        grid.headings.remove(PAIR);
        grid.rows.iter_mut().for_each(|row| drop(row.remove(PAIR)));
    }
    grid
}

fn varied(folder: &EnsembleFolder) -> Grid {
    let manifest = &folder.manifest;
    let kinds = [("uncertain", &manifest.parameters), ("numerics", &manifest.numerics)];
    let row = |kind: &str, varied: &crate::VariedKey| {
        vec![Cell::Code(varied.key.clone()), Cell::Text(varied.by.clone()), Cell::Text(kind.to_owned())]
    };
    Grid {
        headings: ["key", "values or distribution", "kind"].map(str::to_owned).to_vec(),
        rows: kinds
            .iter()
            .flat_map(|(kind, keys)| keys.iter().map(move |varied| row(kind, varied)))
            .collect(),
    }
}

/// Shares in per cent.
fn exceedance(table: &Table) -> Grid {
    let shares: Vec<bool> = table
        .headings
        .iter()
        .map(|name| ["share", "low", "high", "curve", "curve low", "curve high"].contains(&name.as_str()))
        .collect();
    let cell = |(text, share): (&String, &bool)| if *share { Cell::share(text) } else { Cell::of(text) };
    Grid {
        headings: table.headings.clone(),
        rows: table.rows.iter().map(|row| row.iter().zip(&shares).map(cell).collect()).collect(),
    }
    .without_empty(&["curve", "curve low", "curve high"])
}

/// A row a run: what it was, how it ended, what matters first.
fn runs(folder: &EnsembleFolder, is_shown: &dyn Fn(&str) -> bool) -> Grid {
    let EnsembleFolder { manifest, results, .. } = folder;
    let keys: Vec<&str> =
        manifest.parameters.iter().chain(&manifest.numerics).map(|varied| &*varied.key).collect();
    let measure = format!("{} [g]", manifest.measure);
    let filled = |column: usize| results.rows.iter().any(|row| !row[column].is_empty());
    let of_sample = ["sample", "hash", "record", "polarity", "perturbation", "scale", &measure, "status"];
    let wanted: Vec<usize> = (0..results.headings.len())
        .filter(|column| {
            let heading = &*results.headings[*column];
            (of_sample.contains(&heading) || keys.contains(&heading) || is_shown(heading)) && filled(*column)
        })
        .collect();
    let mut grid = Grid::of(results, &wanted, |_| true);
    for (column, heading) in grid.headings.iter_mut().enumerate() {
        match &**heading {
            "sample" => "run".clone_into(heading),
            "hash" => {
                "file".clone_into(heading);
                for (row, cells) in grid.rows.iter_mut().enumerate() {
                    cells[column] = Cell::Sample(results.rows[row][wanted[column]].clone());
                }
            }
            // The last part of a key says what it is.
            key if keys.contains(&key) => *heading = key.rsplit('.').next().unwrap_or(key).replace('_', " "),
            _ => {}
        }
    }
    grid
}

fn provenance(folder: &EnsembleFolder) -> Group {
    let manifest = &folder.manifest;
    let build = &manifest.build;
    let rows = vec![
        Row::text("program", format!("cofferdam {}, {}", build.version, build.profile)),
        Row::code("commit", build.commit.clone()),
        Row::code("sources", &manifest.sources).with("hash of the program's sources"),
        Row::text("machine", format!("{}, {} cores", build.processor, build.cores)),
        Row::text("system", build.system.clone()).with(build.features.clone()),
        Row::code("plan", &manifest.plan_sha256).with("SHA-256 of plan.toml"),
        Row::code("scene", &manifest.scene_sha256)
            .with("SHA-256 of the first run's scene with all defaults, without its record"),
    ];
    Group { name: "Provenance".to_owned(), rows }
}
