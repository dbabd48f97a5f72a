//! The commands that show a log: what they print and write is what the log and the tables beside it hold.

use crate::log::{cofferdam, entries, exchanges, logged, quick_scene, rewrite, text};
use cofferdam_assembly::units::RESERVOIR;
use cofferdam_coupling::participant::Layout;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_log::{Agreement, Entry, Log, LogReadError, LoggedExchange, worst};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use prost::Message;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use whole_chain::scenario::{Histories, Scenario};

/// A file beside a log.
fn beside(log: &Path, name: &str) -> PathBuf {
    log.with_file_name(name)
}

/// A message without the line breaks of the terminal.
fn unwrapped(said: &str) -> String {
    said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// Tables in a folder, by name.
fn tables(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let tables = files.filter(|path| path.extension().is_some_and(|e| e == "csv"));
    let named = |path: PathBuf| {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        (name, std::fs::read(&path).expect("a table"))
    };
    tables.map(named).collect()
}

#[test]
fn an_export_has_the_bytes_that_the_run_wrote() {
    let mut in_windows = quick_scene();
    in_windows.set("coupling.window", 3).set("time.duration", 0.3);
    in_windows.remove("ground_motion.record.end").remove("time.quiet");
    let mut adaptive = quick_scene();
    adaptive.set("time.communication_step", 0.01).set("coupling.tolerance", 1e-6);
    let scenes = [
        ("implicit", quick_scene()),
        ("in windows", in_windows),
        ("of long steps", adaptive),
        ("prescribed", Scenario::shipped("rigid-dam-ramp")),
    ];
    for (name, scenario) in scenes {
        let log = logged(&scenario, "run");
        let folder = scenario.folder().join("export");
        let (status, said) = cofferdam(&["log", "export", text(&log), "--output", text(&folder)]);
        assert_eq!(status, Some(0), "{name}: {said}");
        let mut written = tables(log.parent().expect("a folder"));
        written.remove("response_spectra.csv");
        // The log holds what is exchanged; the dam is asked for its outline beside.
        assert_eq!(written.remove("outline.csv").is_some(), name != "prescribed", "{name}");
        let exported = tables(&folder);
        assert!(exported["histories.csv"].len() > 10_000, "{name}");
        assert_eq!(exported.keys().collect::<Vec<_>>(), written.keys().collect::<Vec<_>>(), "{name}");
        for (table, bytes) in &exported {
            assert!(bytes == &written[table], "{name}: {table} differs");
        }
    }
}

#[test]
fn every_exchange_is_a_row_in_csv_and_in_parquet() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let folders = ["csv", "parquet"].map(|format| {
        let folder = scenario.folder().join(format);
        let arguments = ["log", "export", text(&log), "--iterations", "--format", format, "--output"];
        let (status, said) = cofferdam(&[&arguments[..], &[text(&folder)]].concat());
        assert_eq!(status, Some(0), "{said}");
        folder
    });
    let all = exchanges(&log)?;
    for (id, unit) in ["dam", "reservoir"].into_iter().enumerate() {
        let of_unit: Vec<&LoggedExchange> = all.iter().filter(|e| e.unit == UnitId(id)).collect();
        let mut reader = csv::Reader::from_path(folders[0].join(format!("{unit}-exchanges.csv")))?;
        let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let rows = reader.records().collect::<Result<Vec<_>, _>>()?;
        let file = std::fs::File::open(folders[1].join(format!("{unit}-exchanges.parquet")))?;
        let parquet = SerializedFileReader::new(file)?;
        let stored = parquet.get_row_iter(None)?.collect::<Result<Vec<_>, _>>()?;
        assert_eq!([rows.len(), stored.len()], [of_unit.len(); 2], "{unit}");
        for ((exchange, row), stored) in of_unit.into_iter().zip(&rows).zip(&stored) {
            let at = exchange.occasion;
            let outputs = exchange.outputs.as_ref().expect("an answer");
            let first = [f64::from(u8::from(exchange.accepted)), at.time, at.end()];
            let expected: Vec<u64> =
                first.iter().chain(&exchange.inputs).chain(outputs).map(|v| v.to_bits()).collect();
            let values: Vec<u64> =
                row.iter().skip(3).map(|v| v.parse().map(f64::to_bits)).collect::<Result<_, _>>()?;
            assert_eq!(values, expected, "{unit} {at}");
            let whole = [at.step, at.iteration.into(), at.attempt.into()];
            assert_eq!(row.iter().take(3).map(str::parse).collect::<Result<Vec<u64>, _>>()?, whole);
            for (index, (name, field)) in stored.get_column_iter().enumerate() {
                assert_eq!(*name, names[index]);
                match field {
                    Field::Long(value) => assert_eq!(*value as u64, whole[index], "{name}"),
                    Field::Bool(value) => assert_eq!(*value, exchange.accepted),
                    Field::Double(value) => assert_eq!(value.to_bits(), expected[index - 3], "{name}"),
                    field => panic!("{name}: {field}"),
                }
            }
        }
        // The place of a variable is that of its name.
        let head = Log::open(&log)?.head().clone();
        let layout = &head.units[id].inputs;
        let ground = 6 + layout.range("ground_acceleration").expect("a variable").start;
        assert_eq!(names[ground], "request.ground_acceleration.0 [m/s2]");
    }
    Ok(())
}

/// Largest difference of a column in two histories over its largest magnitude, from the first row on.
fn relative(a: &[f64], b: &[f64]) -> (f64, usize) {
    let magnitude = a.iter().chain(b).fold(0.0_f64, |most, value| most.max(value.abs()));
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    let (row, largest) =
        differences.enumerate().fold((0, 0.0), |best, (row, d)| if d > best.1 { (row, d) } else { best });
    (if largest > 0.0 { largest / magnitude } else { 0.0 }, row)
}

#[test]
fn how_far_two_runs_are_apart_is_what_their_histories_say() -> Result<(), LogReadError> {
    let mut scenario = quick_scene();
    let a = logged(&scenario, "a");
    scenario.set("dam.cracks.0.friction_coefficient", 0.9);
    let b = logged(&scenario, "b");
    let logs = [Log::open(&a)?, Log::open(&b)?];
    let agreement = Agreement::of(logs.each_ref())?;
    let histories = [&a, &b].map(|log| Histories::read(&beside(log, "histories.csv")));
    let rows = histories[0].column("time").len();
    assert_eq!((agreement.ends.len(), agreement.steps), (rows, [rows as u64; 2]));
    let keys: Vec<_> = agreement.settings.iter().map(|setting| setting.key.as_str()).collect();
    assert_eq!(keys, ["dam.cracks.0.friction_coefficient", "[dam] fingerprint"]);

    let mut checked = 0;
    let mut first_beyond = usize::MAX;
    let tolerance = 1e-3;
    for measured in agreement.variables.iter().filter(|m| !m.variable.array) {
        let name = &measured.variable.name;
        if name == "dam.energy_balance_error" {
            continue;
        }
        let [a, b] = [0, 1].map(|log| histories[log].column(name));
        let (largest, row) = relative(a, b);
        let end = measured.worst();
        assert_eq!((measured.relative(end), end), (largest, row), "{name}");
        checked += 1;
        let magnitude = measured.scale;
        let first = a.iter().zip(b).position(|(a, b)| (a - b).abs() > tolerance * magnitude);
        first_beyond = first_beyond.min(first.unwrap_or(usize::MAX));
    }
    assert!(checked >= 12, "{checked} variables");
    // An array or a remainder may be beyond it earlier.
    let first = agreement.first_beyond(tolerance).expect("the runs differ");
    assert!(first <= first_beyond, "{first} {first_beyond}");
    let before = (0..first).filter_map(|end| agreement.largest(end)).all(|(_, d)| d <= tolerance);
    assert!(before && agreement.largest(first).is_some_and(|(_, d)| d > tolerance));

    // The first other number of contacts, and of iterations.
    let counts = ["sticking", "slipping", "open"].map(|state| format!("dam.crack_{state}.0"));
    let other = |column: &str| {
        let [a, b] = [0, 1].map(|log| histories[log].column(column));
        a.iter().zip(b).position(|(a, b)| a != b)
    };
    let contacts = counts.iter().filter_map(|column| other(column)).min();
    assert!(contacts.is_some_and(|row| row > 0 && row < rows));
    assert_eq!(agreement.events.contacts.as_ref().map(|event| event.end), contacts);
    assert_eq!(agreement.events.iterations.as_ref().map(|event| event.end), other("iterations"));
    assert_eq!(agreement.events.length, None);

    let (status, said) = cofferdam(&["log", "diff", text(&a), text(&b), "--tolerance", "1e-3"]);
    assert_eq!(status, Some(5), "{said}");
    let end = agreement.ends[first];
    let place = format!("beyond       in step {}, t = {:.6} s:", end.steps[0], end.time);
    assert!(said.contains(&place) && said.ends_with("beyond 1e-3\n"), "{place} is not in\n{said}");
    let event = agreement.events.contacts.expect("an event");
    let step = agreement.ends[event.end].steps[0];
    assert!(said.contains(&format!("contacts: in step {step}, ")), "{said}");
    assert_eq!(cofferdam(&["log", "diff", text(&a), text(&b), "--tolerance", "1"]).0, Some(0));
    let (status, said) = cofferdam(&["log", "diff", text(&a), text(&a), "--tolerance", "0"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("contacts: nowhere") && said.contains(&format!("at all {rows} ends")), "{said}");
    assert_eq!(cofferdam(&["log", "diff", text(&a), text(&b), "--tolerance", "-1"]).0, Some(2));
    Ok(())
}

#[test]
fn runs_with_other_steps_and_other_variables_are_compared_in_what_they_share() -> Result<(), LogReadError> {
    let mut scenario = quick_scene();
    let fine = logged(&scenario, "fine");
    scenario.set("time.communication_step", 0.005);
    let coarse = logged(&scenario, "coarse");
    let agreement = Agreement::of([&Log::open(&fine)?, &Log::open(&coarse)?])?;
    let [many, few] = agreement.steps;
    assert_eq!((agreement.ends.len() as u64, many - 1), (few, 2 * (few - 1)));
    assert!(agreement.ends.iter().all(|end| end.steps[0] == 2 * end.steps[1]));
    assert_eq!(agreement.events.length.map(|event| event.end), Some(1));

    scenario.set("time.communication_step", 0.0025).set("dam.cracks", Vec::<toml::Value>::new());
    let intact = logged(&scenario, "intact");
    let agreement = Agreement::of([&Log::open(&fine)?, &Log::open(&intact)?])?;
    assert!(
        agreement.apart.iter().any(|name| name == "dam.crack_sliding: only in a"),
        "{:?}",
        agreement.apart
    );
    let has = |name: &str| agreement.variables.iter().any(|m| m.variable.name == name);
    assert!(has("dam.crest_displacement") && has("reservoir.total_force") && !has("dam.crack_sliding"));
    assert_eq!(agreement.events.contacts, None);
    Ok(())
}

/// Points of the longest line of each panel of a picture.
fn lines(svg: &str) -> Vec<Vec<[f64; 2]>> {
    let points = svg.split("points=\"").skip(1).map(|rest| {
        let numbers = rest.split('"').next().expect("an attribute").split_whitespace();
        let pair = |pair: &str| pair.split(',').map(|n| n.parse().expect("a number")).collect::<Vec<f64>>();
        numbers.map(pair).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
    });
    points.filter(|points| points.len() > 100).collect()
}

#[test]
fn a_plot_shows_the_histories() {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let histories = Histories::read(&beside(&log, "histories.csv"));
    let names = ["dam.crest_displacement.x", "reservoir.total_force", "dam.crack_sliding[0]"];
    let picture = scenario.folder().join("plot.svg");
    let command = [&["log", "plot", text(&log)], &names[..], &["--output", text(&picture)]].concat();
    let (status, said) = cofferdam(&command);
    assert_eq!(status, Some(0), "{said}");
    let svg = std::fs::read_to_string(&picture).expect("a picture");
    let panels = lines(&svg);
    assert_eq!(panels.len(), 3);
    let time = histories.column("time");
    for (points, name) in
        panels.iter().zip(["dam.crest_displacement.x", "reservoir.total_force", "dam.crack_sliding.0"])
    {
        let values = histories.column(name);
        // Pixels grow to the right and downwards: a line through (time, value) has their extremes at the same places.
        let scale = |pixel: f64| {
            let [first, last] = [points[0][0], points[points.len() - 1][0]];
            (pixel - first) / (last - first) * (time[time.len() - 1] - time[0]) + time[0]
        };
        let resolution = 1.5 * scale(points[0][0] + 1.0) - 1.5 * time[0];
        let highest = points.iter().fold([0.0, f64::MAX], |best, p| if p[1] < best[1] { *p } else { best });
        let largest = values.iter().copied().fold(f64::MIN, f64::max);
        let near = time.iter().zip(values).filter(|(t, _)| (**t - scale(highest[0])).abs() <= resolution);
        let near = near.map(|(_, value)| *value).fold(f64::MIN, f64::max);
        let [low, high] = [values.iter().copied().fold(f64::MAX, f64::min), largest];
        // A pixel of 170.
        assert!(largest - near < 0.01 * (high - low), "{name}: {near} where {largest} should be");
    }
    for name in names {
        assert!(svg.contains(name), "{name}");
    }

    let refused = |arguments: &[&str], status, words: &str| {
        let (found, said) = cofferdam(&[&["log", "plot", text(&log)], arguments].concat());
        let said = unwrapped(&said);
        assert!(found == Some(status) && said.contains(words), "{arguments:?}: {found:?} {said}");
    };
    refused(&["iterations", "--output", text(&picture)], 1, "exists already");
    refused(&["iterations", "--output", "/proc/none/x.svg"], 1, "choose another --output");
    refused(&["dam.crest_displacment.x"], 2, "near to it are dam.crest_displacement (with [0] to [1])");
    refused(&["total_force"], 2, "reservoir.total_force");
    refused(&["dam.crest_displacement.2"], 2, "dam.crest_displacement (with [0] to [1])");
    refused(&["iterations", "--from", "50"], 2, "no step ends from 50 s on; the run goes to 1.01 s");
    let (status, said) =
        cofferdam(&["log", "plot", text(&log), "iterations", "--from", "0.5", "--until", "0.9"]);
    assert!(status == Some(0) && said.starts_with("<svg"), "{said}");
}

/// Fields of each topic's messages: whether they are repeated.
fn fields(log: &Path) -> BTreeMap<String, BTreeMap<String, bool>> {
    let bytes = std::fs::read(log).expect("a log");
    let summary = mcap::Summary::read(&bytes).expect("MCAP").expect("a finished log");
    let of_channel = |channel: &mcap::Channel<'_>| {
        let schema = channel.schema.as_ref().expect("a schema");
        let set = prost_types::FileDescriptorSet::decode(&*schema.data).expect("descriptors");
        let name = schema.name.rsplit('.').next().expect("a name");
        let mut messages = set.file.iter().flat_map(|file| &file.message_type);
        let message = messages.find(|message| message.name() == name).expect("the message");
        let repeated = prost_types::field_descriptor_proto::Label::Repeated;
        message.field.iter().map(|field| (field.name().to_owned(), field.label() == repeated)).collect()
    };
    summary.channels.values().map(|channel| (channel.topic.clone(), of_channel(channel))).collect()
}

#[test]
fn every_path_of_a_layout_is_in_the_log() -> Result<(), Box<dyn std::error::Error>> {
    for scenario in [quick_scene(), Scenario::shipped("rigid-dam-ramp")] {
        let log = logged(&scenario, "run");
        let fields = fields(&log);
        let head = Log::open(&log)?.head().clone();
        let size = |topic: &str, field: &str| {
            let unit = head.units.iter().find(|unit| topic == format!("/{}/answer", unit.name));
            unit.and_then(|unit| Layout::range(&unit.outputs, field)).map_or(0, |range| range.len())
        };
        let exists = |topic: &str, field: &str| {
            let (name, index) = match field.strip_suffix(']').and_then(|field| field.split_once('[')) {
                Some((name, index)) => (name, Some(index.parse::<usize>().expect("an index"))),
                None => (field, None),
            };
            let repeated = fields.get(topic).and_then(|fields| fields.get(name));
            assert_eq!(repeated, Some(&index.is_some()), "{topic} {field}");
            assert!(index.is_none_or(|index| index < size(topic, name)), "{topic} {field}");
        };

        let json = scenario.folder().join("layout.json");
        let (status, said) = cofferdam(&["log", "layout", text(&log), "--output", text(&json)]);
        assert_eq!(status, Some(0), "{said}");
        let layout: serde_json::Value = serde_json::from_slice(&std::fs::read(&json)?)?;
        let panels = layout["configById"].as_object().expect("panels");
        let mut foxglove = Vec::new();
        for (name, panel) in panels {
            assert!(layout["layout"].to_string().contains(&format!("\"{name}\"")), "{name} is not laid out");
            if !name.starts_with("Plot!") {
                assert!(
                    name.starts_with("RosOut!")
                        && fields.contains_key(panel["topicToRender"].as_str().expect("a topic"))
                );
                continue;
            }
            for path in panel["paths"].as_array().expect("paths") {
                let path = path["value"].as_str().expect("a path");
                let (topic, field) = path.rsplit_once('.').expect("a field");
                let (topic, filter) = topic.split_once('{').unwrap_or((topic, ""));
                assert!(
                    filter.is_empty()
                        || filter == "accepted==true}" && fields[topic].contains_key("accepted")
                );
                exists(topic, field);
                foxglove.push(format!("{topic}/{field}"));
            }
        }
        assert!(foxglove.contains(&"/step/iterations".to_owned()));
        assert!(foxglove.contains(&"/reservoir/answer/interface_pressure_norm".to_owned()));

        let (status, xml) = cofferdam(&["log", "layout", text(&log), "--for", "plotjuggler"]);
        assert_eq!(status, Some(0), "{xml}");
        let mut reader = quick_xml::Reader::from_str(&xml);
        let (mut curves, mut files) = (Vec::new(), Vec::new());
        loop {
            match reader.read_event()? {
                quick_xml::events::Event::Empty(tag) | quick_xml::events::Event::Start(tag) => {
                    let value = |name: &str| {
                        let attribute =
                            tag.try_get_attribute(name).expect("attributes").expect("the attribute");
                        attribute.value.into_owned()
                    };
                    match tag.name().as_ref() {
                        "curve" => curves.push(value("name")),
                        "fileInfo" => files.push(value("filename")),
                        "parameters" => {
                            let topics = value("selected_topics");
                            assert!(topics.split(';').all(|topic| fields.contains_key(topic)), "{topics}");
                        }
                        _ => {}
                    }
                }
                quick_xml::events::Event::Eof => break,
                _ => {}
            }
        }
        assert_eq!(files, [text(&log.canonicalize()?)]);
        curves.sort();
        foxglove.sort();
        assert_eq!(curves, foxglove, "both show the same");
        assert_eq!(
            cofferdam(&["log", "layout", text(&log), "--output", text(&json)]).0,
            Some(1),
            "it exists"
        );
    }
    Ok(())
}

#[test]
fn a_step_is_shown_with_every_iteration_and_value() -> Result<(), LogReadError> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let all = entries(&log)?;
    let step = 200;
    let of_step: Vec<&LoggedExchange> = all
        .iter()
        .filter_map(|entry| match entry {
            Entry::Exchange(exchange) if exchange.occasion.step == step => Some(exchange),
            _ => None,
        })
        .collect();
    let (status, said) = cofferdam(&["log", "show", text(&log), "--step", "200", "--values"]);
    assert_eq!(status, Some(0), "{said}");
    let most = of_step.iter().map(|e| e.occasion.iteration).max().expect("iterations");
    assert!(most >= 2 && said.contains(&format!("{most} iterations, converged, accepted")), "{said}");
    let sequences: Vec<String> = of_step.iter().map(|e| format!("(exchange {}", e.sequence)).collect();
    let places: Vec<_> = sequences.iter().map(|sequence| said.find(sequence)).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{said}");
    let pressure = Log::open(&log)?.head().unit(RESERVOIR).outputs.range("interface_pressure");
    let values =
        &of_step.last().and_then(|e| e.outputs.as_ref()).expect("an answer")[pressure.expect("a variable")];
    for value in values {
        assert!(said.contains(&format!("{value:e}")), "{value:e} is missing in\n{said}");
    }
    let mut iterations = 0;
    for entry in &all {
        if let Entry::Iteration(iteration) = entry
            && iteration.steps[0] == step
        {
            iterations += 1;
            let report = iteration.report;
            let residual = report.residuals.expect("compared").norm;
            assert!(said.contains(&format!("residual: {residual:.3e} Pa")), "{said}");
            let worst = report.worst.expect("a point");
            assert!(said.contains(&format!("farthest: point {} ", worst.point)), "{said}");
        }
    }
    assert_eq!(iterations, most);
    let (_, first) = cofferdam(&["log", "show", text(&log), "--step", "200", "--iteration", "1"]);
    assert!(
        first.contains("iteration 1\n    guess: of the predictor") && !first.contains("iteration 2\n"),
        "{first}"
    );
    let (_, rest) = cofferdam(&["log", "show", text(&log), "--step", "0"]);
    assert!(rest.starts_with("step 0: initialisation") && rest.contains("messages"), "{rest}");

    for (arguments, words) in [
        (vec!["--step", "405"], "there is no step 405; the log holds steps 0 to 404"),
        (vec!["--step", "200", "--iteration", "90"], "step 200 has no iteration 90"),
        (vec!["--step", "200", "--attempt", "2"], "step 200 has no attempt 2; it has attempts 1 to 1"),
    ] {
        let (status, said) = cofferdam(&[&["log", "show", text(&log)], &arguments[..]].concat());
        let said = unwrapped(&said);
        assert!(status == Some(2) && said.contains(words), "{said}");
    }

    // The list of the worst leads to the first of them.
    let (_, said) = cofferdam(&["log", "worst", text(&log), "--count", "3"]);
    let command = said.lines().last().and_then(|line| line.split_once("cofferdam ")).expect("a command").1;
    let (status, said) = cofferdam(&command.split_whitespace().collect::<Vec<_>>());
    let most = worst(&Log::open(&log)?, 1)?[0].occasion;
    assert!(status == Some(0) && said.starts_with(&format!("step {}, attempt 1", most.step)), "{said}");
    assert!(said.contains(&format!("  {} iterations", most.iteration)), "{said}");
    Ok(())
}

#[test]
fn messages_are_listed_by_unit_and_level() -> Result<(), LogReadError> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let messages: Vec<_> = entries(&log)?
        .into_iter()
        .filter_map(|entry| if let Entry::Message(message) = entry { Some(message) } else { None })
        .collect();
    let of_dam = messages.iter().filter(|message| message.unit == "dam").count();
    assert!(of_dam > 0 && of_dam < messages.len());
    let (status, said) = cofferdam(&["log", "messages", text(&log)]);
    assert_eq!((status, said.lines().count()), (Some(0), messages.len()), "{said}");
    let (_, said) = cofferdam(&["log", "messages", text(&log), "--unit", "dam"]);
    assert!(
        said.lines().count() == of_dam && said.contains("information: dam (cofferdam_dam::dam): "),
        "{said}"
    );
    let (status, said) = cofferdam(&["log", "messages", text(&log), "--level", "error"]);
    assert_eq!((status, said.as_str()), (Some(0), "no such message\n"));
    let (status, said) = cofferdam(&["log", "messages", text(&log), "--unit", "tailwater"]);
    assert!(status == Some(2) && unwrapped(&said).contains("its units are dam, reservoir"), "{said}");
    Ok(())
}

#[test]
fn what_is_left_of_a_log_is_shown_and_the_damage_reported() {
    let scenario = quick_scene();
    let folder = scenario.folder();
    let log = logged(&scenario, "run");
    let whole = folder.join("whole.mcap");
    // In chunks of 64 KiB, so that a cut or a damage loses few.
    rewrite(&log, &whole, |_, _, _| ());
    let bytes = std::fs::read(&whole).expect("a log");
    let (cut, damaged) = (folder.join("cut.mcap"), folder.join("damaged.mcap"));
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).expect("written");
    let mut changed = bytes.clone();
    // Within a chunk, not in the index after it, which no checksum covers.
    changed[bytes.len() / 2 + (1 << 12)] ^= 0x10;
    std::fs::write(&damaged, changed).expect("written");
    let all = Histories::read(&beside(&log, "histories.csv")).column("time").to_vec();
    for (path, status, words) in [(&cut, 0, ""), (&damaged, 1, "the log is damaged here")] {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let (found, said) = cofferdam(&["log", "messages", text(path)]);
        assert!(
            found == Some(status) && said.contains("cofferdam_dam::dam") && said.contains(words),
            "{said}"
        );
        let tables = folder.join(format!("{name}-tables"));
        let (found, said) = cofferdam(&["log", "export", text(path), "--output", text(&tables)]);
        assert!(found == Some(status) && said.contains(words), "{said}");
        let rows = Histories::read(&tables.join("histories.csv")).column("time").to_vec();
        assert!(
            rows.len() > 50 && rows.len() < all.len() && rows == all[..rows.len()],
            "{} rows",
            rows.len()
        );
        let picture = folder.join(format!("{name}.svg"));
        let (found, said) = cofferdam(&["log", "plot", text(path), "iterations", "--output", text(&picture)]);
        assert!(found == Some(status) && picture.exists() && said.contains(words), "{said}");
        let (found, said) = cofferdam(&["log", "diff", text(&whole), text(path), "--tolerance", "1e-9"]);
        assert!(
            found == Some(status) && said.contains("within 1e-9 at all") && said.contains(words),
            "{said}"
        );
        let (found, said) = cofferdam(&["log", "show", text(path), "--step", "20"]);
        assert!(found == Some(0) && said.starts_with("step 20, attempt 1"), "{said}");
        // A step behind the damage is found without reading what lies before.
        let (found, said) = cofferdam(&["log", "show", text(path), "--step", "400"]);
        let shown = found == Some(0) && said.starts_with("step 400, attempt 1");
        assert!(if status == 0 { found == Some(2) } else { shown }, "{said}");
    }
    let (status, said) = cofferdam(&["log", "export", text(&log), "--output", text(folder)]);
    assert!(status == Some(1) && unwrapped(&said).contains("exists already"), "{said}");
    let (status, said) = cofferdam(&["log", "export", text(&log), "--output", "/proc/none"]);
    assert!(status == Some(1) && unwrapped(&said).contains("choose another --output"), "{said}");
}
