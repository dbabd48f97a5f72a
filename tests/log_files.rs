//! Logs as files: cut, damaged, recovered, still being written, and read from the middle on.

use crate::log::{cofferdam, entries, exchanges, records, rigid_run, text};
use mcap::records::op;
use orchestrator::log::{Entry, Log, LogReadError, Overview, recover};
use std::collections::HashMap;
use std::error::Error;
use std::path::Path;

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
