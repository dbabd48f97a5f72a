//! Logs as files: cut, damaged, recovered, still being written, and read from the middle on.

use crate::log::{cofferdam, entries, exchanges, logged, quick_scene, records, rewrite, rigid_run, text};
use cofferdam_log::{Entry, Log, LogReadError, Overview, recover};
use mcap::records::op;
use std::collections::HashMap;
use std::error::Error;
use std::path::Path;
use whole_chain::scenario::{Scenario, binary};

/// Topic, sequence number and bytes of a message.
type Said = (String, u32, Vec<u8>);

/// Every message of a sound file, by another reader.
fn messages(path: &Path) -> Vec<Said> {
    let bytes = std::fs::read(path).expect("a file");
    let messages = mcap::MessageStream::new(&bytes).expect("MCAP").map(|message| {
        let message = message.expect("a message");
        (message.channel.topic.clone(), message.sequence, message.data.into_owned())
    });
    messages.collect()
}

/// Copies a log into chunks of about `size` bytes; all channels are in the first, as the writer puts them.
fn in_chunks(from: &Path, to: &Path, size: u64) {
    let bytes = std::fs::read(from).expect("a log");
    let file = std::io::BufWriter::new(std::fs::File::create(to).expect("a file"));
    let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4)).chunk_size(Some(size));
    let mut writer = options.create(file).expect("a writer");
    let summary = mcap::read::Summary::read(&bytes).expect("a summary").expect("a finished log");
    let mut channels: Vec<_> = summary.channels.values().collect();
    channels.sort_by_key(|channel| channel.id);
    let mut numbers = HashMap::new();
    for channel in channels {
        let schema = channel.schema.as_ref().expect("a schema");
        let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data).expect("a schema");
        let new =
            writer.add_channel(schema, &channel.topic, "protobuf", &channel.metadata).expect("a channel");
        numbers.insert(channel.id, new);
    }
    for message in mcap::MessageStream::new(&bytes).expect("MCAP") {
        let mcap::Message { channel, sequence, log_time, publish_time, data } = message.expect("a message");
        let channel_id = numbers[&channel.id];
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time };
        writer.write_to_known_channel(&header, &data).expect("written");
    }
    writer.finish().expect("finished");
}

/// Ranges of bytes of the chunks of a sound file.
fn chunks(bytes: &[u8]) -> Vec<std::ops::Range<usize>> {
    let places = records(bytes);
    let ends = places.iter().skip(1).map(|(place, _)| *place);
    places
        .iter()
        .zip(ends)
        .filter(|((_, kind), _)| *kind == op::CHUNK)
        .map(|((at, _), end)| *at..end)
        .collect()
}

/// Number of messages in each chunk.
fn counts(bytes: &[u8]) -> Vec<usize> {
    let summary = mcap::read::Summary::read(bytes).expect("a summary").expect("a finished log");
    let mut indices = summary.chunk_indexes.clone();
    indices.sort_by_key(|index| index.chunk_start_offset);
    let count = |index| summary.stream_chunk(bytes, index).expect("a chunk").count();
    indices.iter().map(count).collect()
}

/// A small log in small chunks.
fn small(folder: &Path) -> Result<std::path::PathBuf, Box<dyn Error>> {
    let (run, path) = (folder.join("run.mcap"), folder.join("small.mcap"));
    assert!(!rigid_run(&run, u64::MAX, 12, None)?, "the run completes");
    in_chunks(&run, &path, 2500);
    Ok(path)
}

#[test]
fn a_log_that_is_cut_at_any_byte_of_its_last_chunk_is_recovered() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = small(folder.path())?;
    let (bytes, all) = (std::fs::read(&path)?, messages(&path));
    let (cut, saved) = (folder.path().join("cut.mcap"), folder.path().join("saved.mcap"));
    let last = chunks(&bytes).pop().expect("chunks");
    let before = all.len() - counts(&bytes).pop().expect("chunks");
    assert!(chunks(&bytes).len() > 10 && last.len() > 300, "{last:?}");
    let whole = entries(&path)?;
    for end in last.start..=last.end {
        std::fs::write(&cut, &bytes[..end])?;
        let mut read = entries(&cut)?;
        let ending = read.pop();
        assert!(whole.starts_with(&read), "cut at {end}");
        let recovery = recover(&cut, &saved)?;
        let found = messages(&saved);
        if end < last.end {
            assert!(matches!(ending, Some(Entry::Cut(_))), "cut at {end}: {ending:?}");
            assert_eq!(recovery.damage.len(), 1, "cut at {end}: {recovery:?}");
            assert_eq!(&found[..before], &all[..before], "cut at {end}");
            assert!(found.len() == before + 1 && found[before].0 == "/damage", "cut at {end}");
        } else {
            assert!(ending == whole.last().cloned() && found == all && recovery.damage.is_empty());
        }
        let mut again = entries(&saved)?;
        assert_eq!(matches!(again.pop(), Some(Entry::Cut(_))), end < last.end, "cut at {end}");
        assert!(again == read, "cut at {end}");
        assert_eq!(Overview::of(&Log::open(&saved)?)?.error.map(|e| e.to_string()), None);
        std::fs::remove_file(&saved)?;
    }
    Ok(())
}

/// One bit at 2000 places: nothing panics, every flip is noticed, and every message in a chunk that was not hit is saved.
#[test]
fn a_flipped_bit_costs_one_chunk_at_most_and_is_noticed_anywhere() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = small(folder.path())?;
    let (bytes, all) = (std::fs::read(&path)?, messages(&path));
    let (damaged, saved) = (folder.path().join("damaged.mcap"), folder.path().join("saved.mcap"));
    let (chunks, counts) = (chunks(&bytes), counts(&bytes));
    let (whole, places) = (entries(&path)?, 2000.min(bytes.len()));
    let mut lost = 0;
    for number in 0..places {
        let place = number * bytes.len() / places;
        let mut changed = bytes.clone();
        changed[place] ^= 1 << (number % 8);
        std::fs::write(&damaged, &changed)?;
        let at = format!("bit {} of byte {place} of {}", number % 8, bytes.len());
        let overview = Log::open(&damaged).and_then(|log| Overview::of(&log));
        assert!(
            overview.is_err() || overview.is_ok_and(|overview| overview.error.is_some()),
            "{at}: not noticed"
        );
        // What is read is true.
        if let Ok(log) = Log::open(&damaged) {
            let read: Vec<_> = log.entries()?.map_while(Result::ok).collect();
            assert!(whole.starts_with(&read), "{at}");
        }
        let recovery = recover(&damaged, &saved).unwrap_or_else(|error| panic!("{at}: {error}"));
        let found: Vec<_> = messages(&saved).into_iter().filter(|(topic, ..)| topic != "/damage").collect();
        if recovery.damage.is_empty() {
            assert!(found == all, "{at}: {recovery:?}");
        } else {
            let hit = chunks.iter().position(|chunk| chunk.contains(&place));
            let hit = hit.unwrap_or_else(|| panic!("{at}: {recovery:?}"));
            let before: usize = counts[..hit].iter().sum();
            let expected = [&all[..before], &all[before + counts[hit]..]].concat();
            assert!(found == expected && recovery.damage.len() == 1, "{at}: {recovery:?}");
            lost += 1;
        }
        if let Ok(log) = Log::open(&saved) {
            let overview = Overview::of(&log)?;
            assert!(overview.error.is_none(), "{at}: {:?}", overview.error);
            assert_eq!(overview.damage, recovery.damage, "{at}");
        }
        std::fs::remove_file(&saved)?;
    }
    println!("{lost} of {places} flipped bits cost a chunk");
    assert!(lost > places / 10);
    Ok(())
}

/// A log of many steps in small chunks, of windows of `window` steps; its path and entries.
fn long(window: u64) -> (Scenario, std::path::PathBuf, Vec<Entry>) {
    let mut scenario = quick_scene();
    scenario.set("coupling.window", i64::try_from(window).expect("a number"));
    if window > 1 {
        scenario.set("coupling.acceleration", "aitken");
    }
    let path = scenario.folder().join("long.mcap");
    in_chunks(&logged(&scenario, "run"), &path, 1 << 13);
    let all = entries(&path).expect("a sound log");
    (scenario, path, all)
}

/// Number of the first entry of the window that `step` belongs to.
fn first(all: &[Entry], step: u64, window: u64) -> usize {
    let begin = if step == 0 { 0 } else { step - (step - 1) % window };
    let there = |entry: &Entry| matches!(entry, Entry::Exchange(e) if e.occasion.step >= begin);
    all.iter().position(there).unwrap_or(all.len() - 1)
}

/// The entries from a step on, and the last of a topic before it, are those of reading everything, for a small share of
/// the bytes; in a finished log by its summary, in one that was cut by the frames of its records.
#[test]
fn a_step_is_found_without_reading_what_lies_before() -> Result<(), Box<dyn Error>> {
    for window in [1, 5] {
        let (scenario, path, all) = long(window);
        let bytes = std::fs::read(&path)?;
        let (chunks, cut) = (chunks(&bytes), scenario.folder().join("cut.mcap"));
        assert!(chunks.len() > 100, "{} chunks", chunks.len());
        let longest = chunks.iter().map(ExactSizeIterator::len).max().expect("chunks") as u64;
        let summary = (bytes.len() - records(&bytes).pop().expect("an end of the data").0) as u64;
        // In the middle of the last but one chunk.
        std::fs::write(&cut, &bytes[..chunks[chunks.len() - 2].end - 200])?;
        let until_cut = entries(&cut)?;
        let mut most = 0;
        for (path, all) in [(&path, &all), (&cut, &until_cut)] {
            let log = Log::open(path)?;
            for step in (0..420).step_by(31).chain([1, 2, 403, 404, u64::MAX]) {
                let before = log.bytes_read();
                let mut found = log.entries_from(step)?;
                let (begin, next) = (first(all, step, window), found.next().expect("an entry")?);
                assert!(
                    next == all[begin],
                    "window {window}, step {step}: {next:?} in place of {:?}",
                    all[begin]
                );
                // Of a window that is longer than chunks, the probes read several.
                let read = log.bytes_read() - before;
                most = most.max(read);
                // Frames and first bytes of all records, where there is no summary.
                let frames = 40 * 12 * chunks.len() as u64;
                assert!(read < summary + frames + 20 * longest, "window {window}, step {step}: {read} bytes");
                let rest: Vec<_> = found.take(100).collect::<Result<_, _>>()?;
                assert!(rest == all[begin + 1..][..rest.len()], "window {window}, step {step}");
                assert_eq!(rest.len(), 100.min(all.len() - begin - 1), "window {window}, step {step}");
            }
            for (topic, step) in [("/step", 0), ("/step", 200), ("/step", 1000), ("/log", 1000), ("/none", 9)]
            {
                let of_topic = |entry: &&Entry| match entry {
                    Entry::Step(_) => topic == "/step",
                    Entry::Message(_) => topic == "/log",
                    _ => false,
                };
                let last =
                    all.iter().filter(of_topic).rfind(|entry| entry.step().is_some_and(|own| own <= step));
                let before = log.bytes_read();
                assert_eq!(
                    log.last_before(topic, step)?.as_ref(),
                    last,
                    "window {window}, {topic} of {step}"
                );
                let read = log.bytes_read() - before;
                // The cut log's last chunk has no index.
                assert!(
                    read < summary + 40 * 12 * chunks.len() as u64 + 20 * longest,
                    "{topic}: {read} bytes"
                );
            }
            for time in [0.0, 0.00249, 0.0025, 0.3333, 1.0] {
                let mut found = log.entries_at(time)?;
                let Some(Ok(Entry::Exchange(exchange))) = found.next() else { panic!("t = {time}") };
                let window_end = exchange.occasion.time + window as f64 * 0.0025;
                let begin = exchange.occasion.time;
                assert!(
                    begin <= time && (time < window_end || window > 1),
                    "window {window}: {begin} for {time}"
                );
                assert!(time - begin < 0.0025 * window as f64 + 1e-9, "window {window}: {begin} for {time}");
            }
        }
        println!(
            "window of {window}: {most} bytes at the most of {} in {} chunks",
            bytes.len(),
            chunks.len()
        );
        assert!(most < bytes.len() as u64 / 3);
    }
    Ok(())
}

#[test]
fn a_log_that_is_being_written_is_called_running() -> Result<(), Box<dyn Error>> {
    let scenario = quick_scene();
    let run = logged(&scenario, "run");
    assert!(!Log::open(&run)?.is_running());
    let (bytes, path) = (std::fs::read(&run)?, scenario.folder().join("half.mcap"));
    std::fs::write(&path, &bytes[..bytes.len() / 2])?;
    let ending = |path: &Path| Ok::<_, LogReadError>(Overview::of(&Log::open(path)?)?.ending());
    assert!(ending(&path)?.starts_with("cut short at byte"));
    let file = std::fs::File::open(&path)?;
    file.lock()?;
    assert!(Log::open(&path)?.is_running());
    let (status, said) = cofferdam(&["log", "info", text(&path)]);
    assert!(status == Some(0) && said.contains("ended        running: so far step "), "{said}");
    drop(file);
    assert!(ending(&path)?.starts_with("cut short at byte"));
    Ok(())
}

/// The command saves what it can beside the damaged log, which it leaves alone, and overwrites nothing.
#[test]
fn recover_writes_a_new_log_and_says_what_is_missing() -> Result<(), Box<dyn Error>> {
    let scenario = quick_scene();
    let run = logged(&scenario, "run");
    let (path, whole) = (scenario.folder().join("log.mcap"), scenario.folder().join("whole.mcap"));
    in_chunks(&run, &whole, 1 << 14);
    let bytes = std::fs::read(&whole)?;
    let chunks = chunks(&bytes);
    let middle = &chunks[chunks.len() / 2];
    let mut changed = bytes.clone();
    changed[middle.start + 200] ^= 4;
    std::fs::write(&path, &changed)?;
    let (status, said) = cofferdam(&["log", "info", text(&path)]);
    assert!(status == Some(1) && said.contains("log recover"), "{said}");
    let (status, said) = cofferdam(&["log", "recover", text(scenario.folder())]);
    assert_eq!(status, Some(0), "{said}");
    let missing = format!("missing      bytes {} to {}: ", middle.start, middle.end - 1);
    assert!(said.contains(&missing), "{missing} is not in {said}");
    assert_eq!(std::fs::read(&path)?, changed);
    let saved = scenario.folder().join("log-recovered.mcap");
    let (status, said) = cofferdam(&["log", "info", text(&saved)]);
    assert!(
        status == Some(0) && said.contains(&missing) && said.contains("ended        completed"),
        "{said}"
    );
    // Whole exchanges before and behind the gap, and none that is half.
    let (all, found) = (exchanges(&whole)?, exchanges(&saved)?);
    let gap = all.iter().zip(&found).position(|(a, b)| a != b).expect("a gap");
    let missing = all.len() - found.len();
    assert!(gap > 100 && missing > 3 && found[gap..] == all[gap + missing..], "{gap}, {missing}");
    let (status, said) = cofferdam(&["replay", "--quiet", text(&saved)]);
    assert!(status == Some(1) && said.contains("exchanges are missing here"), "{said}");
    let (status, said) = cofferdam(&["log", "diff", text(&whole), text(&saved)]);
    assert!(
        status == Some(1) && said.contains(&format!("{gap} identical exchanges before the damage")),
        "{said}"
    );
    // Nothing is overwritten.
    let (status, said) = cofferdam(&["log", "recover", text(&path)]);
    assert!(status == Some(1) && said.contains("nothing is overwritten"), "{said}");
    let (status, said) = cofferdam(&["log", "recover", text(&path), "--output", text(&path)]);
    assert!(status == Some(1) && said.contains("nothing is overwritten"), "{said}");
    assert_eq!(std::fs::read(&path)?, changed);
    // A log that is only cut is replayed like one, after its recovery too.
    let (cut, mended) = (scenario.folder().join("cut.mcap"), scenario.folder().join("mended.mcap"));
    std::fs::write(&cut, &bytes[..middle.start + 5])?;
    recover(&cut, &mended)?;
    assert_eq!(exchanges(&cut)?, exchanges(&mended)?);
    let (status, said) = cofferdam(&["replay", "--quiet", text(&mended)]);
    assert!(status == Some(0) && said.contains("where the log is cut short"), "{said}");
    Ok(())
}

/// Lengths and counts that a file claims, and contents that swell when they are read, take less than 1 GiB of address space.
#[test]
fn a_claimed_length_takes_no_memory() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let (path, changed) = (small(folder.path())?, folder.path().join("changed.mcap"));
    let bytes = std::fs::read(&path)?;
    let look = |what: &str| {
        for arguments in [&["log", "info"][..], &["log", "recover", "--output", "/dev/null/x"]] {
            let mut command = std::process::Command::new("sh");
            command.args(["-c", r#"ulimit -v 1048576; exec "$0" "$@""#]).arg(binary());
            let done = command.args(arguments).arg(&changed).output().expect("sh runs");
            let said = String::from_utf8_lossy(&done.stderr);
            let fine = done.status.code().is_some_and(|code| code <= 1);
            assert!(fine && !said.contains("panicked") && !said.contains("memory"), "{what}: {said}");
        }
    };
    // Fields of lengths in the frames of records, in the headers of chunks and in the summary.
    let fields = records(&bytes)
        .into_iter()
        .take(8)
        .flat_map(|(place, _)| [place + 1, place + 25, place + 37, place + 44]);
    for field in fields.chain((1..6).map(|i| bytes.len() - 37 - 600 * i)) {
        for value in [u64::MAX, 1 << 28] {
            let mut bytes = bytes.clone();
            bytes[field..field + 8].copy_from_slice(&value.to_le_bytes());
            std::fs::write(&changed, &bytes)?;
            look(&format!("{value} at byte {field}"));
        }
    }
    // Contents with a checksum that fits: texts, lists and schemas of many megabytes that compress to little.
    type Content = fn() -> Vec<u8>;
    let swollen: [(&str, &str, Content); 4] = [
        ("a scene of blanks", "/scene", || field(1, &vec![b' '; 40 << 20])),
        ("empty variables", "/unit", || [0x22, 0].repeat(20 << 20)),
        ("samples one by one", "/ground_motion", || [0x11, 0, 0, 0, 0, 0, 0, 0, 0].repeat(5 << 20)),
        ("unknown fields", "/dam/answer", || [0xf8, 0x07, 1].repeat(10 << 20)),
    ];
    for (what, topic, content) in swollen {
        let mut once = false;
        rewrite(&path, &changed, |of, _, data| {
            if of == topic && !std::mem::replace(&mut once, true) {
                *data = content();
            }
        });
        look(what);
    }
    // The first is as long as schemas may be.
    for length in [500 << 10, 10 << 20] {
        let descriptor = field(1, &field(4, &[0x12, 0].repeat(length)));
        let file = std::io::BufWriter::new(std::fs::File::create(&changed)?);
        let mut writer = mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4)).create(file)?;
        let schema = writer.add_schema("cofferdam.Scene", "protobuf", &descriptor)?;
        let channel_id = writer.add_channel(schema, "/scene", "protobuf", &Default::default())?;
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, b"")?;
        writer.finish()?;
        look("a schema of empty fields");
    }
    Ok(())
}

/// A protobuf field of bytes.
fn field(number: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![number << 3 | 2];
    let mut length = content.len();
    while length > 0x7f {
        bytes.push(length as u8 | 0x80);
        length >>= 7;
    }
    bytes.push(length as u8);
    bytes.extend_from_slice(content);
    bytes
}
