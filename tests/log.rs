//! Logs are read back, replayed, compared, cut off and damaged.

use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::participant::Prescribed;
use cofferdam_assembly::simulation::{scales, with_work};
use cofferdam_assembly::units::{DAM, RESERVOIR, pair};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure};
use cofferdam_coupling::difference::{Difference, Divergence, Half};
use cofferdam_coupling::observer::{Observer, Start};
use cofferdam_coupling::participant::{
    Description, InProcess, Level, Messages, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{Predictor, Scheme, Settings};
use cofferdam_coupling::simulation::Simulation;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_log::replay::{ReplayError, Unanswered, replay};
use cofferdam_log::{Entry, Log, LogReadError, LogWriter, LoggedExchange, Preamble, compare};
use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use whole_chain::koyna;
use whole_chain::scenario::{Scenario, binary, root};

/// A second of strong motion on coarse meshes.
fn short_scene() -> Scenario {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0).set("reservoir.element_size", 12.0);
    scenario.set("ground_motion.record.start", 4.0).set("ground_motion.record.end", 5.0);
    scenario.set("time.quiet", 0.0);
    scenario
}

/// The same with added mass, which needs no preparation.
pub(crate) fn quick_scene() -> Scenario {
    let mut scenario = short_scene();
    scenario.set("reservoir.fidelity", "westergaard").set("coupling.scheme", "serial-implicit");
    scenario
}

/// The log of a run of the scene into `output`.
pub(crate) fn logged(scenario: &Scenario, output: &str) -> PathBuf {
    let run = scenario.try_run(output);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    scenario.folder().join(output).join("log.mcap")
}

pub(crate) fn entries(path: &Path) -> Result<Vec<Entry>, LogReadError> {
    Log::open(path)?.entries()?.collect()
}

pub(crate) fn exchanges(path: &Path) -> Result<Vec<LoggedExchange>, LogReadError> {
    let exchange = |entry| if let Entry::Exchange(exchange) = entry { Some(exchange) } else { None };
    Ok(entries(path)?.into_iter().filter_map(exchange).collect())
}

/// Exit status and output of the program, errors last, without line breaks.
pub(crate) fn cofferdam(arguments: &[&str]) -> (Option<i32>, String) {
    let output = std::process::Command::new(binary()).args(arguments).output().expect("cofferdam runs");
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&said).into_owned())
}

pub(crate) fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// Copies a log record by record, new checksums included; `change` may alter a message of a topic.
pub(crate) fn rewrite(from: &Path, to: &Path, mut change: impl FnMut(&str, u32, &mut Vec<u8>)) {
    rewrite_all(from, to, |topic, sequence, mut data| {
        change(topic, sequence, &mut data);
        vec![data]
    });
}

/// The same; `change` gives the messages that replace one.
fn rewrite_all(from: &Path, to: &Path, mut change: impl FnMut(&str, u32, Vec<u8>) -> Vec<Vec<u8>>) {
    let bytes = std::fs::read(from).expect("a log");
    let file = std::fs::File::create(to).expect("a file");
    let options =
        mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4)).chunk_size(Some(1 << 16));
    let mut writer = options.create(std::io::BufWriter::new(file)).expect("a writer");
    let mut channels: HashMap<u16, u16> = HashMap::new();
    for message in mcap::MessageStream::new(&bytes).expect("MCAP") {
        let message = message.expect("a message");
        let channel = &message.channel;
        let id = *channels.entry(channel.id).or_insert_with(|| {
            let schema = channel.schema.as_ref().expect("a schema");
            let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data).expect("a schema");
            writer.add_channel(schema, &channel.topic, "protobuf", &channel.metadata).expect("a channel")
        });
        let mcap::Message { sequence, log_time, publish_time, .. } = message;
        for data in change(&channel.topic, sequence, message.data.to_vec()) {
            let header = mcap::records::MessageHeader { channel_id: id, sequence, log_time, publish_time };
            writer.write_to_known_channel(&header, &data).expect("written");
        }
    }
    writer.finish().expect("finished");
}

/// Places and opcodes of the records outside chunks, up to the end of the data.
pub(crate) fn records(bytes: &[u8]) -> Vec<(usize, u8)> {
    let (mut place, mut found) = (mcap::MAGIC.len(), Vec::new());
    loop {
        let length = bytes[place + 1..place + 9].try_into().map(u64::from_le_bytes).expect("a length");
        found.push((place, bytes[place]));
        if bytes[place] == mcap::records::op::DATA_END {
            return found;
        }
        place += 9 + length as usize;
    }
}

#[test]
fn a_replay_gives_the_same_bits_without_the_record() -> Result<(), LogReadError> {
    let mut scenario = short_scene();
    let record = root().join("scenes/records/northridge-1994-canyon-country-270.csv");
    std::fs::copy(record, scenario.folder().join("record.csv")).expect("a copy");
    scenario.set("ground_motion.record.file", "record.csv");
    let log = logged(&scenario, "run");
    std::fs::remove_file(scenario.folder().join("record.csv")).expect("removed");
    let count = exchanges(&log)?.len() / 2;
    assert!(count > 500, "{count}");

    let (status, said) = cofferdam(&["replay", text(&log), "--quiet"]);
    assert_eq!(status, Some(0), "{said}");
    for unit in ["dam", "reservoir"] {
        assert!(said.contains(&format!("\n{unit}: identical: {count} exchanges")), "{said}");
    }
    let folder = log.parent().expect("a folder");
    let (status, said) = cofferdam(&["replay", text(folder), "--unit", "reservoir", "--threads", "1"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("reservoir: identical") && !said.contains("dam: "), "{said}");

    let (status, said) = cofferdam(&["log", "info", text(folder)]);
    assert_eq!(status, Some(0), "{said}");
    let exchanges = 2 * count;
    for wanted in
        ["Cracked Koyna dam", "404, to t = 1.0100 s", &format!("{exchanges}\n"), "ended        completed"]
    {
        assert!(said.contains(wanted), "`{wanted}` is missing in:\n{said}");
    }
    Ok(())
}

#[test]
fn both_transports_exchange_the_same_bits() {
    let scenario = short_scene();
    let logs = ["shared-memory", "in-process"].map(|transport| {
        let mut command = scenario.command(transport);
        let status = command.args(["--transport", transport]).stdout(std::process::Stdio::null()).status();
        assert!(status.expect("cofferdam runs").success(), "{transport}");
        scenario.folder().join(transport).join("log.mcap")
    });
    let (status, said) = cofferdam(&["log", "diff", text(&logs[0]), text(&logs[1])]);
    assert_eq!(status, Some(0), "{said}");
    let count =
        |line: &str| line.strip_prefix("identical: ")?.strip_suffix(" exchanges")?.parse::<u64>().ok();
    assert!(said.lines().find_map(count).is_some_and(|exchanges| exchanges > 1000), "{said}");
    for log in &logs {
        let (status, said) = cofferdam(&["replay", "--quiet", text(log)]);
        assert_eq!(status, Some(0), "{said}");
        for unit in ["dam: identical: ", "reservoir: identical: "] {
            assert!(said.contains(unit), "{said}");
        }
    }
}

#[test]
fn a_flipped_bit_is_found_where_it_is() -> Result<(), LogReadError> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let all = exchanges(&log)?;
    let layout = Log::open(&log)?.head().unit(DAM).outputs.clone();
    let at = layout.range("interface_velocity").expect("a variable").start + 5;
    let index = all
        .iter()
        .position(|e| e.unit == DAM && e.occasion.step == 200 && e.occasion.iteration == 2)
        .expect("an exchange");
    let LoggedExchange { sequence, occasion, outputs, .. } = &all[index];
    let outputs = outputs.as_ref().expect("an answer");
    let (recorded, flipped) = (outputs[at], f64::from_bits(outputs[at].to_bits() ^ 1));
    let damaged = scenario.folder().join("flipped.mcap");
    rewrite(&log, &damaged, |topic, number, data| {
        if topic == "/dam/answer" && number == *sequence {
            let bytes = recorded.to_le_bytes();
            let found: Vec<usize> = (0..data.len() - 7).filter(|i| data[*i..*i + 8] == bytes).collect();
            assert_eq!(found.len(), 1, "the value stands once in its message");
            data[found[0]] ^= 1;
        }
    });

    let original = Log::open(&log)?;
    let found = compare([&original, &Log::open(&damaged)?])?;
    let what = |values| Difference::Value {
        half: Half::Answer,
        variable: "interface_velocity".to_owned(),
        index: Some(5),
        values,
    };
    let at = |before, values| Divergence {
        unit: "dam".to_owned(),
        occasion: *occasion,
        before,
        what: what(values),
    };
    assert_eq!(found.divergence, Some(at(index as u64, [recorded, flipped])));
    assert!(found.settings.is_empty(), "{:?}", found.settings);

    let asked = all[..index].iter().filter(|e| e.unit == DAM).count() as u64;
    let (status, said) = cofferdam(&["replay", text(&damaged), "--quiet"]);
    assert_eq!(status, Some(5), "{said}");
    let report = at(asked, [flipped, recorded]).report(["recorded", "replayed"]).to_string();
    assert!(said.contains(&report) && report.ends_with("1 ulp apart"), "{report}\nis not in\n{said}");
    assert!(said.contains("reservoir: identical"), "{said}");
    let (status, said) = cofferdam(&["log", "diff", text(&log), text(&damaged)]);
    assert_eq!(status, Some(5), "{said}");
    assert!(said.contains("in step 200 from t = 0.4975 s, iteration 2"), "{said}");

    // If the ground motions differ, one sample is named.
    let shaken = scenario.folder().join("shaken.mcap");
    rewrite(&log, &shaken, |topic, _, data| {
        if topic == "/ground_motion" {
            data[100] ^= 1;
            data[300] ^= 1;
        }
    });
    let settings = compare([&original, &Log::open(&shaken)?])?.settings;
    assert!(settings.len() == 1 && settings[0].key == "[ground motion] sample 11", "{settings:?}");

    // Without a change, the copy is the same log.
    let copy = scenario.folder().join("copy.mcap");
    rewrite(&log, &copy, |_, _, _| ());
    let (status, said) = cofferdam(&["log", "diff", text(&log), text(&copy)]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.ends_with(&format!("identical: {} exchanges\n", all.len())), "{said}");
    Ok(())
}

#[test]
fn other_dilation_is_found_where_a_run_with_it_parts() -> Result<(), LogReadError> {
    let mut scenario = short_scene();
    let log = logged(&scenario, "run");
    scenario.set("dam.cracks.0.dilation", 1e-9);
    let other = logged(&scenario, "other");
    let found = compare([&Log::open(&log)?, &Log::open(&other)?])?;
    let keys: Vec<_> = found.settings.iter().map(|s| s.key.as_str()).collect();
    assert_eq!(keys, ["dam.cracks.0.dilation", "[dam] fingerprint"]);
    let mut divergence = found.divergence.expect("a difference");
    println!("{}", divergence.report(["a", "b"]));
    // Dilation acts on the dam first, and from the first sliding on.
    assert_eq!(divergence.unit, "dam");
    assert!(divergence.occasion.step > 0);
    let before = |e: &&LoggedExchange| e.unit == DAM && e.occasion.step < divergence.occasion.step;
    let asked = exchanges(&log)?.iter().filter(before).count() as u64;
    divergence.before = asked + u64::from(divergence.occasion.iteration) - 1;

    let set = "dam.cracks.0.dilation=1e-9";
    let (status, said) = cofferdam(&["replay", text(&log), "--quiet", "--set", set]);
    assert_eq!(status, Some(5), "{said}");
    assert!(said.contains(&divergence.report(["recorded", "replayed"]).to_string()), "{said}");
    assert!(said.contains("warning: dam: made from other parameters"), "{said}");
    assert!(said.contains("reservoir: identical"), "{said}");

    let (status, said) = cofferdam(&["replay", text(&log), "--set", "dam.cracks.0.friction_coefficient=9"]);
    assert_eq!(status, Some(2), "{said}");
    let (status, said) =
        cofferdam(&["replay", text(&log), "--quiet", "--unit", "dam", "--set", "dam.cracks=[]"]);
    assert_eq!(status, Some(5), "{said}");
    assert!(said.contains("other variables"), "{said}");
    Ok(())
}

#[test]
fn a_log_that_is_cut_anywhere_is_read_up_to_there() -> Result<(), LogReadError> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    // In chunks of 64 KiB, so that most cuts lose a single chunk.
    let whole = scenario.folder().join("whole.mcap");
    rewrite(&log, &whole, |_, _, _| ());
    let (bytes, all) = (std::fs::read(&whole).expect("a log"), entries(&whole)?);
    let cut = scenario.folder().join("cut.mcap");
    let steps = (1..20).map(|i| i * bytes.len() / 20);
    let (mut read, mut most) = (0, 0);
    for end in [0, 5, 8, 17, 40, 300, 5000].into_iter().chain(steps).chain([bytes.len() - 1]) {
        std::fs::write(&cut, &bytes[..end]).expect("written");
        match entries(&cut) {
            Ok(found) => {
                let (last, before) = found.split_last().expect("an ending");
                assert!(before == &all[..before.len()], "cut at {end}");
                match last {
                    Entry::Cut(position) => assert!(*position <= end as u64 && before.len() < all.len()),
                    last => assert_eq!(Some(last), all.last(), "cut at {end}, behind the run's end"),
                }
                read += 1;
                most = most.max(before.len());
            }
            Err(LogReadError::Empty { .. }) => assert_eq!(end, 0),
            Err(LogReadError::Headless { position, .. }) => assert!(position <= end as u64 && end < 70_000),
            Err(error) => panic!("cut at {end}: {error}"),
        }
    }
    assert!(
        read >= 15 && most > all.len() / 2,
        "{read} of the cut logs could be read, {most} entries the most"
    );

    std::fs::write(&cut, &bytes[..bytes.len() / 2]).expect("written");
    let (status, said) = cofferdam(&["replay", text(&cut), "--quiet"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("where the log is cut short"), "{said}");
    let (_, said) = cofferdam(&["log", "info", text(&cut)]);
    assert!(said.contains("ended        cut short at byte"), "{said}");
    let (status, said) = cofferdam(&["log", "diff", text(&whole), text(&cut)]);
    assert_eq!(status, Some(5), "{said}");
    assert!(said.contains("b is shorter (cut short at byte"), "{said}");
    Ok(())
}

#[test]
fn the_log_of_a_run_that_was_killed_is_readable() -> Result<(), LogReadError> {
    let mut scenario = quick_scene();
    scenario.remove("ground_motion.record.end");
    let mut run = scenario.command("run").stdout(std::process::Stdio::null()).spawn().expect("a run");
    let log = scenario.folder().join("run/log.mcap");
    // The head is written at once, exchanges every second.
    let mut found = Vec::new();
    while found.len() < 100 {
        assert!(run.try_wait().expect("a run").is_none(), "the run ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(50));
        found = entries(&log).unwrap_or_default();
    }
    assert!(Log::open(&log).is_ok_and(|log| log.is_running()));
    let (status, said) = cofferdam(&["log", "info", text(&log)]);
    assert!(status == Some(0) && said.contains("ended        running: so far step"), "{said}");
    run.kill().expect("killed");
    run.wait().expect("an ending");
    let found = entries(&log)?;
    assert!(matches!(found.last(), Some(Entry::Cut(_))), "{:?}", found.last());
    assert!(!Log::open(&log)?.is_running(), "the lock ends with the process");
    let (status, said) = cofferdam(&["replay", text(&log), "--quiet"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("dam: identical: ") && said.contains("where the log is cut short"), "{said}");
    Ok(())
}

#[test]
fn a_log_that_is_damaged_anywhere_gives_nothing_false() -> Result<(), LogReadError> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let (bytes, all) = (std::fs::read(&log).expect("a log"), entries(&log)?);
    let damaged = scenario.folder().join("damaged.mcap");
    let mut noticed = 0;
    for place in (0..40).map(|i| i * bytes.len() / 40 + 7 * i) {
        let mut changed = bytes.clone();
        changed[place] ^= 0x10;
        std::fs::write(&damaged, &changed).expect("written");
        let Ok(log) = Log::open(&damaged) else { continue };
        for (index, entry) in log.entries()?.enumerate() {
            match entry {
                Ok(Entry::Cut(_)) => panic!("byte {place}: a finished file is no cut one"),
                Ok(entry) => assert!(entry == all[index], "byte {place}, entry {index}"),
                Err(LogReadError::Damaged { position, .. }) => {
                    assert!(position <= place as u64);
                    noticed += 1;
                }
                Err(error) => panic!("byte {place}: {error}"),
            }
        }
    }
    // The other changes are in parts that are not read: indices, times, the summary.
    assert!(noticed >= 20, "{noticed} damages were noticed");
    Ok(())
}

/// A chunk that says to hold gigabytes, or a text longer than itself, is damage before memory is asked for; and so is one
/// whose content no checksum covers.
#[test]
fn a_chunk_that_says_what_cannot_be_is_damage() {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let bytes = std::fs::read(&log).expect("a log");
    // Opcode and length of the first record, the header; of the next ones until the first chunk, whose opcode is 6.
    let mut place = mcap::MAGIC.len();
    let length = |bytes: &[u8], place: usize| {
        u64::from_le_bytes(bytes[place + 1..place + 9].try_into().expect("8 bytes")) as usize
    };
    while bytes[place] != 6 {
        place += 9 + length(&bytes, place);
    }
    let damaged = scenario.folder().join("damaged.mcap");
    let text = 0xc94e_0c0f_u32.to_le_bytes();
    let refused = |at: usize, value: &[u8], words: &str| {
        let mut bytes = bytes.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        std::fs::write(&damaged, &bytes).expect("written");
        let error = entries(&damaged).expect_err("it is damaged");
        assert!(
            matches!(error, LogReadError::Damaged { .. }) && error.to_string().contains(words),
            "{error}"
        );
    };
    let chunk = place + 9;
    for size in [3_u64 << 30, 300 * length(&bytes, place) as u64, u64::MAX] {
        refused(chunk + 16, &size.to_le_bytes(), "holds more than it can");
    }
    refused(chunk + 24, &[0; 4], "a chunk has no checksum");
    refused(chunk + 28, &text, "a text is longer than its record");
    refused(mcap::MAGIC.len() + 9, &text, "a text is longer than its record");
}

#[test]
fn what_cannot_be_read_is_named() -> Result<(), LogReadError> {
    let scenario = quick_scene();
    let log = logged(&scenario, "run");
    let folder = scenario.folder();
    let said = |name: &str| {
        let path = folder.join(name);
        let Err(error) = entries(&path) else { panic!("{name} is read to its end") };
        let said = error.to_string().replace(text(folder), "");
        // Places depend on the length of the program's version, and on compression.
        match said.split_once(": byte ") {
            Some((before, after)) => {
                format!("{before}: byte N{}", after.trim_start_matches(|c: char| c.is_ascii_digit()))
            }
            None => said,
        }
    };
    insta::assert_snapshot!(said("nothing.mcap"), @"/nothing.mcap: No such file or directory (os error 2); give the log.mcap of a run, or the run's folder");
    std::fs::write(folder.join("empty.mcap"), "").expect("written");
    insta::assert_snapshot!(said("empty.mcap"), @"/empty.mcap: the file is empty; its run ended before it wrote anything, run it again");
    std::fs::write(folder.join("text.mcap"), "time,acceleration\n").expect("written");
    insta::assert_snapshot!(said("text.mcap"), @"/text.mcap: byte N: this is no MCAP file; give the log.mcap of a run, or the run's folder");
    let bytes = std::fs::read(&log).expect("a log");
    std::fs::write(folder.join("headless.mcap"), &bytes[..60]).expect("written");
    insta::assert_snapshot!(said("headless.mcap"), @"/headless.mcap: byte N: the log is cut short before it says what was run; nothing can be read from it, run the scene again");

    // The log of another program: its only topic is not one of a run's.
    let file = std::fs::File::create(folder.join("other.mcap")).expect("a file");
    let options = mcap::WriteOptions::new().library("rosbag2").compression(None);
    let mut writer = options.create(std::io::BufWriter::new(file)).expect("a writer");
    let schema = writer.add_schema("Image", "ros2msg", b"uint8[] data").expect("a schema");
    let channel = writer.add_channel(schema, "/camera", "cdr", &Default::default()).expect("a channel");
    let header =
        mcap::records::MessageHeader { channel_id: channel, sequence: 1, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, b"image").expect("written");
    writer.finish().expect("finished");
    insta::assert_snapshot!(said("other.mcap"), @"/other.mcap: byte N: this MCAP file (written by `rosbag2`) has no `/scene` before its first exchange; only the logs of `cofferdam run` can be read");

    // Messages that lack a field, hold another number of values, or are missing.
    let all = exchanges(&log)?;
    let first = all.iter().find(|e| e.unit == DAM && e.occasion.step == 3).expect("an exchange");
    rewrite(&log, &folder.join("short.mcap"), |topic, sequence, data| {
        if topic == "/dam/request" && sequence == first.sequence {
            // The first array of a request: its key, its length in bytes, its values.
            let place = data.windows(2).position(|w| w == [0x4a, 96]).expect("a pressure");
            data[place + 1] = 88;
            data.drain(place + 2..place + 10);
        }
    });
    insta::assert_snapshot!(said("short.mcap"), @"/short.mcap: byte N: topic `/dam/request`: `interface_pressure` has 11 values, the unit's layout says 12; read the log with the version that wrote it");

    // A scalar cannot have several values.
    rewrite(&log, &folder.join("size.mcap"), |topic, _, data| {
        let single = |w: &[u8]| matches!(w, [0x20, 1, 0x28, 0] | [0x20, 1, 0x22 | 0x2a, _]);
        if topic == "/unit"
            && let Some(place) = data.windows(4).position(single)
        {
            data[place + 1] = 9;
        }
    });
    insta::assert_snapshot!(said("size.mcap"), @"/size.mcap: byte N: topic `/unit`: `size` is `9`, which is not valid here; read the log with the version that wrote it");
    let made = std::process::Command::new("mkfifo").arg(folder.join("pipe")).status();
    assert!(made.is_ok_and(|status| status.success()), "a pipe");
    insta::assert_snapshot!(said("pipe"), @"/pipe: is no regular file; copy it to one");

    // The head is flushed by itself, scene and build before the units; nothing follows it.
    let chunks = records(&bytes).into_iter().filter(|(_, kind)| *kind == mcap::records::op::CHUNK);
    let third = chunks.map(|(place, _)| place).nth(2).expect("a third chunk");
    std::fs::write(folder.join("head.mcap"), &bytes[..third]).expect("written");
    let (status, message) = cofferdam(&["replay", text(&folder.join("head.mcap")), "--quiet"]);
    assert_eq!(status, Some(1), "{message}");
    assert!(message.contains("dam: nothing to compare") && !message.contains("identical"), "{message}");

    // An invalid scene is not replayed.
    rewrite(&log, &folder.join("scene.mcap"), |topic, _, data| {
        let key = b"communication_step = 0.0025";
        if topic == "/scene"
            && let Some(place) = data.windows(key.len()).position(|w| w == key)
        {
            data[place + key.len() - 2..place + key.len()].fill(b'0');
        }
    });
    let (status, message) = cofferdam(&["replay", text(&folder.join("scene.mcap")), "--quiet"]);
    assert!(status == Some(1) && message.contains("communication_step"), "{message}");

    // Most of the file is chunks; damage elsewhere does no harm.
    let noticed = (1..20).map(|i| i * bytes.len() / 20).find_map(|place| {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1;
        std::fs::write(folder.join("damaged.mcap"), damaged).expect("written");
        entries(&folder.join("damaged.mcap")).err().map(|error| error.to_string())
    });
    let message = noticed.expect("a damaged chunk is noticed");
    assert!(message.contains("the log is damaged here:") && message.contains("fetch it again"), "{message}");
    let (status, message) = cofferdam(&["replay", text(&folder.join("damaged.mcap")), "--quiet"]);
    assert_eq!(status, Some(1), "{message}");
    assert_eq!(message.matches("identical exchanges before the damage").count(), 2, "{message}");
    assert_eq!(message.matches('×').count(), 2, "both units say why: {message}");
    let (status, message) = cofferdam(&["log", "info", text(&folder.join("damaged.mcap"))]);
    assert_eq!(status, Some(1), "{message}");
    assert!(message.contains("ended        unknown: damaged after step"), "{message}");
    let (status, message) = cofferdam(&["log", "diff", text(&log), text(&folder.join("damaged.mcap"))]);
    assert_eq!(status, Some(1), "{message}");
    assert!(message.contains("identical exchanges before the damage"), "{message}");
    let (status, message) = cofferdam(&["log", "info", text(&folder.join("text.mcap"))]);
    assert_eq!(status, Some(1), "{message}");
    Ok(())
}

#[test]
fn a_difference_is_reported_in_words() {
    let occasion = Occasion { step: 45, iteration: 2, attempt: 1, time: 0.11, communication_step: 0.0025 };
    let report = |what| {
        let divergence = Divergence { unit: "dam".to_owned(), occasion, before: 150, what };
        divergence.report(["recorded", "b"]).to_string()
    };
    let value = |values| Difference::Value {
        half: Half::Answer,
        variable: "crest_displacement".to_owned(),
        index: Some(0),
        values,
    };
    let scalar =
        |values| Difference::Value { half: Half::Request, variable: "gain".to_owned(), index: None, values };
    insta::assert_snapshot!(report(scalar([0.0, 0.5])), @r"
    dam: different in step 45 from t = 0.11 s, iteration 2, attempt 1, after 150 identical exchanges
      request, gain
        recorded  0.0
        b         0.5
        4602678819172646912 ulps apart
    ");
    insta::assert_snapshot!(report(value([0.1, 0.1 + 3e-17])), @r"
    dam: different in step 45 from t = 0.11 s, iteration 2, attempt 1, after 150 identical exchanges
      answer, crest_displacement[0]
        recorded  0.1
        b         0.10000000000000003
        2 ulps apart, 2.8e-16 of the first
    ");
    insta::assert_snapshot!(report(value([-0.0, 0.0])), @r"
    dam: different in step 45 from t = 0.11 s, iteration 2, attempt 1, after 150 identical exchanges
      answer, crest_displacement[0]
        recorded  -0.0
        b         0.0
        1 ulp apart
    ");
    let payload = f64::from_bits(0x7ff8_0000_0000_0007);
    insta::assert_snapshot!(report(value([1e-300, payload])), @r"
    dam: different in step 45 from t = 0.11 s, iteration 2, attempt 1, after 150 identical exchanges
      answer, crest_displacement[0]
        recorded  1e-300
        b         NaN (0x7ff8000000000007)
        not comparable
    ");
    insta::assert_snapshot!(report(Difference::Answer { first: true }), @r"
    dam: different in step 45 from t = 0.11 s, iteration 2, attempt 1, after 150 identical exchanges
      recorded has an answer, b has none
    ");
    let asked = Difference::Asked { unit: "reservoir".to_owned(), occasion };
    insta::assert_snapshot!(report(asked), @r"
    dam: different in step 45 from t = 0.11 s, iteration 2, attempt 1, after 150 identical exchanges
      recorded asks the dam here, b asks the reservoir in step 45 from t = 0.11 s, iteration 2
    ");
}

#[test]
fn help_teaches() {
    for (command, words) in [
        (&["replay", "--help"][..], ["Examples:", "Exit status: 0", "--set"]),
        (&["log", "diff", "--help"], ["Examples:", "Exit status: 0", "bit for bit"]),
        (&["log", "info", "--help"], ["Example:", "Exit status: 0", "cut short"]),
        (&["log", "messages", "--help"], ["Examples:", "Exit status: 0", "cut short"]),
        (&["log", "show", "--help"], ["Examples:", "Exit status: 0", "2 there is no such step"]),
        (&["log", "plot", "--help"], ["Examples:", "Exit status: 0", "histories.csv"]),
        (&["log", "export", "--help"], ["Examples:", "Exit status: 0", "--iterations"]),
        (&["log", "layout", "--help"], ["Examples:", "Exit status: 0", "PlotJuggler"]),
    ] {
        let (status, help) = cofferdam(command);
        assert_eq!(status, Some(0));
        for word in words {
            assert!(help.contains(word), "`{word}` is missing in:\n{help}");
        }
    }
}

#[test]
fn what_units_say_is_in_the_log() -> Result<(), LogReadError> {
    let scenario = short_scene();
    let messages: Vec<_> = entries(&logged(&scenario, "run"))?
        .into_iter()
        .filter_map(|entry| if let Entry::Message(message) = entry { Some(message) } else { None })
        .collect();
    println!("{messages:#?}");
    let said: Vec<_> = messages.iter().map(|m| (m.unit.as_str(), m.source.as_str(), m.level)).collect();
    let information = Level::Information;
    let expected = [
        ("dam", "cofferdam_dam::dam", information),
        ("dam", "cofferdam_dam::dam::rest", information),
        ("reservoir", "cofferdam_reservoir::reservoir", information),
    ];
    assert_eq!(said, expected);
    for (message, word) in messages.iter().zip(["132 elements", "state of rest", "states fitted to"]) {
        assert!(message.text.contains(word), "{message:?}");
        assert_eq!((message.step, message.time), (0, 0.0));
    }
    Ok(())
}

/// A unit that fails in one step, or gives an answer that is not finite.
struct Failing {
    unit: Box<dyn Participant>,
    step: u64,
    value: Option<f64>,
}

impl Participant for Failing {
    fn description(&self) -> &Description {
        self.unit.description()
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        self.unit.read(variable)
    }

    fn initialise(&mut self, time: f64, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        self.unit.initialise(time, inputs, outputs)
    }

    fn step(&mut self, at: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        self.unit.step(at, inputs, outputs)?;
        match self.value {
            _ if at.step < self.step => Ok(()),
            Some(value) => {
                outputs[3] = value;
                let (participant, variable) = ("reservoir".to_owned(), "interface_pressure".to_owned());
                Err(ParticipantError::NonFinite { participant, variable, index: 3, value, time: at.end() })
            }
            None => Err(ParticipantError::Unit { participant: "reservoir".to_owned(), cause: "dry".into() }),
        }
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.unit.save_state()
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.unit.restore_state()
    }
}

fn water(step: u64, value: Option<f64>) -> Result<Failing, Box<dyn std::error::Error>> {
    let face = cofferdam_unit::WetFace::straight([0.0, koyna::DEPTH], 9)?;
    let reservoir =
        cofferdam_reservoir::Reservoir::new(koyna::reservoir(face, 0.0025, 0.5), NonZeroUsize::MIN)?;
    let unit = Box::new(InProcess::new(reservoir, "reservoir", Messages::default()));
    Ok(Failing { unit, step, value })
}

/// The log of a rigid dam with water that fails in step 7.
fn failed_run(path: &Path, value: Option<f64>) -> Result<(), Box<dyn std::error::Error>> {
    assert!(rigid_run(path, 7, 100, value)?, "the run fails");
    Ok(())
}

/// The log of `steps` steps of a rigid dam with water that fails in step `failing`; whether it did.
pub(crate) fn rigid_run(
    path: &Path,
    failing: u64,
    steps: u64,
    value: Option<f64>,
) -> Result<bool, Box<dyn std::error::Error>> {
    let loaded = cofferdam_assembly::read_scene(&root().join("scenes/rigid-dam-ramp"), &[])?;
    let scene = toml::to_string(&loaded.scene)?;
    let mut log = LogWriter::create(path, &Preamble { scene, ..Preamble::default() })?;
    let dam = Prescribed::new(cofferdam_unit::WetFace::straight([0.0, koyna::DEPTH], 9)?)?;
    let mut graph = pair(Box::new(dam), Box::new(water(failing, value)?))?;
    let scheme = Scheme::new(
        &mut graph,
        Settings::default(),
        Acceleration::new(AccelerationKind::Aitken, 0.9, 1.0),
        Predictor::new(2),
        ConvergenceMeasure::new(
            &[Measure::Change, Measure::Relative],
            1e-6,
            scales(koyna::DEPTH, 1000.0 * 9.81 * koyna::DEPTH),
        ),
        ground_signals(&loaded.ground_motion),
    )?;
    let scheme = with_work(scheme, &mut graph)?;
    let mut simulation = Simulation::new(graph, scheme, Stepping::equal(0.0025, steps));
    let (_, failure) = simulation.run(&mut [&mut log], &AtomicBool::new(false));
    Ok(failure.is_some())
}

#[test]
fn a_run_that_failed_is_replayed_up_to_its_failure() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("failed.mcap");
    failed_run(&path, None)?;
    let all = exchanges(&path)?;
    let last = all.last().expect("an exchange");
    assert_eq!((last.unit, last.occasion.step, last.occasion.iteration), (RESERVOIR, 7, 1));
    assert!(last.outputs.is_none() && !last.inputs.is_empty(), "a failed answer is none");
    assert!(all[..all.len() - 1].iter().all(|e| e.outputs.is_some()));
    let log = Log::open(&path)?;
    let answered = all.iter().filter(|e| e.unit == RESERVOIR).count() as u64 - 1;
    for (step, failure) in [(7, Some("reservoir: dry".to_owned())), (8, None)] {
        let again = replay(&log, RESERVOIR, &mut water(step, None)?, |_| ())?;
        assert_eq!((again.identical, again.divergence), (answered, None));
        assert_eq!(again.unanswered, Some(Unanswered { occasion: last.occasion, failure }));
        assert_eq!(again.ending, Some(Ok("failed: reservoir: dry".to_owned())));
    }
    let early = replay(&log, RESERVOIR, &mut water(5, None)?, |_| ()).expect_err("fails earlier");
    assert_eq!(
        early.to_string(),
        "in step 5 from t = 0.01 s, iteration 1, where the recorded unit gave an answer: reservoir: dry"
    );
    let same = compare([&log, &log])?;
    assert!(same.identical() && same.identical == all.len() as u64);
    Ok(())
}

#[test]
fn a_flipped_bit_of_the_framing_hides_nothing() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let (path, damaged) = (folder.path().join("failed.mcap"), folder.path().join("damaged.mcap"));
    failed_run(&path, None)?;
    let (mut bytes, all) = (std::fs::read(&path)?, entries(&path)?);
    let (mut noticed, mut flipped) = (0, 0);
    for (place, kind) in records(&bytes) {
        for bit in 0..72 {
            bytes[place + bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&damaged, &bytes)?;
            bytes[place + bit / 8] ^= 1 << (bit % 8);
            let found: Vec<_> = match Log::open(&damaged).and_then(|log| log.entries()) {
                Ok(entries) => entries.collect(),
                Err(error) => vec![Err(error)],
            };
            let sound: Vec<_> = found.iter().filter_map(|e| e.as_ref().ok()).collect();
            let at = format!("bit {bit} of record {kind} at byte {place}");
            assert!(sound.iter().zip(&all).all(|(found, entry)| *found == entry), "{at}");
            assert!(sound.len() == all.len() || found.last().is_some_and(Result::is_err), "{at}");
            flipped += 1;
            noticed += u32::from(sound.len() < all.len());
        }
    }
    println!("{noticed} of {flipped} damages were noticed, the others are behind the run's end");
    assert!(noticed >= 144, "those of the header and of the chunks at the least");
    Ok(())
}

#[test]
fn what_is_missing_from_a_finished_log_is_damage() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let (path, changed) = (folder.path().join("failed.mcap"), folder.path().join("changed.mcap"));
    failed_run(&path, None)?;
    let all = exchanges(&path)?;
    let message = || match entries(&changed) {
        Err(LogReadError::Damaged { cause, .. }) => cause,
        other => panic!("{other:?}"),
    };
    let lost = &all[all.len() / 2];
    rewrite_all(&path, &changed, |topic, sequence, data| {
        let gone = sequence == lost.sequence && topic.ends_with("/answer");
        if gone { Vec::new() } else { vec![data] }
    });
    assert_eq!(message(), format!("exchange {} has no answer", lost.sequence));
    let mut water = water(8, None)?;
    let error = replay(&Log::open(&changed)?, RESERVOIR, &mut water, |_| ()).expect_err("damaged");
    let before = all[..all.len() / 2].iter().filter(|e| e.unit == RESERVOIR).count() as u64;
    assert!(
        matches!(error, ReplayError::Log { identical, .. } if identical == before && before > 0),
        "{error:?}"
    );
    let found = compare([&Log::open(&path)?, &Log::open(&changed)?])?;
    assert_eq!((found.identical, found.identical()), (all.len() as u64 / 2, false));
    assert!(found.error.is_some() && found.divergence.is_none());

    rewrite(&path, &changed, |topic, _, data| {
        if topic == "/end" {
            *data = b"\x0a\x09completed".to_vec();
        }
    });
    assert_eq!(message(), format!("exchange {} has no answer", all.len()));
    rewrite_all(&path, &changed, |topic, _, data| if topic == "/end" { Vec::new() } else { vec![data] });
    assert_eq!(message(), "the file is complete but has no `/end`");
    rewrite_all(&path, &changed, |topic, _, data| vec![data; if topic == "/unit" { 2 } else { 1 }]);
    assert_eq!(message(), "two `/unit` of the name dam");
    let (status, said) = cofferdam(&["log", "diff", text(&path), text(&path)]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("exchanges; a: failed: reservoir: dry; b: failed: reservoir: dry"), "{said}");
    Ok(())
}

#[test]
fn what_was_run_is_on_the_disk_at_once() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let loaded = cofferdam_assembly::read_scene(&root().join("scenes/rigid-dam-ramp"), &[])?;
    let dam = Prescribed::new(cofferdam_unit::WetFace::straight([0.0, koyna::DEPTH], 9)?)?;
    let start = Start {
        units: vec![dam.description().clone(), water(1, None)?.description().clone()],
        signals: &ground_signals(&loaded.ground_motion),
        stepping: Stepping::equal(0.0025, 1),
    };
    for run in 0..5 {
        let path = folder.path().join(format!("{run}.mcap"));
        let preamble = Preamble { scene: toml::to_string(&loaded.scene)?, ..Preamble::default() };
        let mut log = LogWriter::create(&path, &preamble)?;
        log.begin(&start)?;
        let began = std::time::Instant::now();
        while Log::open(&path).is_err() {
            assert!(began.elapsed().as_millis() < 800, "the head waits for the next flush");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
    Ok(())
}

#[test]
fn an_answer_that_is_not_finite_keeps_its_bits() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("failed.mcap");
    let odd = f64::from_bits(0x7ff8_0000_0000_0abc);
    failed_run(&path, Some(odd))?;
    let all = exchanges(&path)?;
    assert_eq!(all.last().and_then(|e| Some(e.outputs.as_ref()?[3].to_bits())), Some(odd.to_bits()));
    let log = Log::open(&path)?;
    let same = replay(&log, RESERVOIR, &mut water(7, Some(odd))?, |_| ())?;
    assert_eq!((same.divergence, same.unanswered), (None, None));
    let other = f64::from_bits(odd.to_bits() ^ 1);
    let differs = replay(&log, RESERVOIR, &mut water(7, Some(other))?, |_| ())?;
    let divergence = differs.divergence.expect("another NaN");
    assert!(matches!(divergence.what, Difference::Value { index: Some(3), .. }), "{divergence:?}");
    Ok(())
}
