use super::alignment::Alignment;
use super::{Entries, Entry, Log, LogReadError, LoggedExchange, LoggedUnit};
use cofferdam_coupling::difference::{Difference, Divergence, Half};
use cofferdam_coupling::signal::Signal;
use std::collections::BTreeMap;
use std::fmt;
use toml::{Table, Value};

/// Result of comparing two logs.
///
/// Wall times, the program's version and messages of the units are not compared, nor are outputs that only one log has: a unit of
/// another version may have more of them. They are among the differences of the settings.
#[derive(Debug)]
pub struct Comparison {
    /// Differences of the settings: keys of the scene, units, ground motion.
    pub settings: Vec<KeyDifference>,
    /// Exchanges that are identical, up to the first difference.
    pub identical: u64,
    /// How both logs end; `None` if the end was not reached.
    pub endings: [Option<String>; 2],
    /// The first difference of the exchanges, unless one log only has fewer of them.
    pub divergence: Option<Divergence>,
    /// Why a log could not be read further.
    pub error: Option<LogReadError>,
}

/// A setting that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyDifference {
    /// Its key, such as `dam.cracks.0.friction_coefficient`.
    pub key: String,
    /// Its values; `None` where it is not set.
    pub values: [Option<String>; 2],
}

impl fmt::Display for KeyDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.values.each_ref().map(|v| v.as_deref().unwrap_or("not set"));
        write!(f, "{}: {first} | {second}", self.key)
    }
}

impl Comparison {
    /// Both logs hold the same exchanges, and the same number of them.
    pub fn identical(&self) -> bool {
        self.divergence.is_none() && self.endings.iter().all(Option::is_some)
    }
}

/// Compares two logs up to the first exchange that differs in a bit, or that cannot be read.
///
/// **Errors**: a log can no longer be opened.
pub fn compare(logs: [&Log; 2]) -> Result<Comparison, LogReadError> {
    let [first, second] = logs;
    let mut comparison = Comparison {
        settings: settings(logs),
        identical: 0,
        endings: [None, None],
        divergence: None,
        error: None,
    };
    let (mut left, mut right) = (first.entries()?, second.entries()?);
    let alignments: Vec<_> = first.head().units.iter().zip(&second.head().units).map(alignment).collect();
    loop {
        let (a, b) = match (next(&mut left), next(&mut right)) {
            (Ok(Ok(a)), Ok(Ok(b))) => (a, b),
            (Ok(a), Ok(b)) => {
                comparison.endings = [a.err(), b.err()];
                return Ok(comparison);
            }
            (Err(error), _) | (_, Err(error)) => {
                comparison.error = Some(error);
                return Ok(comparison);
            }
        };
        let other = &second.head().unit(b.unit).name;
        if let Some(what) = difference(alignments.get(a.unit.0), other, &a, &b) {
            let unit = first.head().unit(a.unit).name.clone();
            let (occasion, before) = (a.occasion, comparison.identical);
            comparison.divergence = Some(Divergence { unit, occasion, before, what });
            return Ok(comparison);
        }
        comparison.identical += 1;
    }
}

/// The next exchange, or how the log ends.
fn next(entries: &mut Entries) -> Result<Result<LoggedExchange, String>, LogReadError> {
    loop {
        match entries.read()? {
            Entry::Exchange(exchange) => return Ok(Ok(exchange)),
            Entry::End(end) => return Ok(Err(end.status)),
            Entry::Cut(position) => return Ok(Err(format!("cut short at byte {position}"))),
            Entry::Damage(damage) => return Err(entries.missing(damage)),
            Entry::Iteration(_) | Entry::Step(_) | Entry::Checkpoint(_) | Entry::Message(_) => {}
        }
    }
}

/// The variables that two units have in common, in requests and in answers.
fn alignment((unit, other): (&LoggedUnit, &LoggedUnit)) -> [Alignment; 2] {
    [Alignment::of(&unit.inputs, &other.inputs), Alignment::of(&unit.outputs, &other.outputs)]
}

/// What differs between two exchanges; `alignments` are those of the unit of the first with the unit of its number in the other log.
fn difference(
    alignments: Option<&[Alignment; 2]>,
    other: &str,
    a: &LoggedExchange,
    b: &LoggedExchange,
) -> Option<Difference> {
    let Some([inputs, outputs]) = alignments.filter(|_| (a.unit, a.occasion) == (b.unit, b.occasion)) else {
        return Some(Difference::Asked { unit: other.to_owned(), occasion: b.occasion });
    };
    // What a unit is given decides its answer, so that all of it must be the same.
    if !inputs.fits() || inputs.lonely.iter().any(|lonely| !lonely.is_empty()) {
        return Some(Difference::Layout { half: Half::Request });
    }
    if !outputs.fits() {
        return Some(Difference::Layout { half: Half::Answer });
    }
    inputs.difference(Half::Request, &a.inputs, &b.inputs).or_else(|| match (&a.outputs, &b.outputs) {
        (Some(a), Some(b)) => outputs.difference(Half::Answer, a, b),
        (Some(_), None) => Some(Difference::Answer { first: true }),
        (None, Some(_)) => Some(Difference::Answer { first: false }),
        (None, None) => None,
    })
}

/// The settings of a run by their keys: the scene, the units, the intervals of the signals.
fn values(log: &Log) -> BTreeMap<String, String> {
    let head = log.head();
    let mut values = BTreeMap::new();
    flatten("", &Value::Table(head.scene_text.parse::<Table>().unwrap_or_default()), &mut values);
    for unit in &head.units {
        values.insert(format!("[{}] solver", unit.name), unit.solver.clone());
        values.insert(format!("[{}] fingerprint", unit.name), unit.fingerprint.clone());
        for (half, layout) in [("request", &unit.inputs), ("answer", &unit.outputs)] {
            for (channel, _) in layout.channels() {
                let key = format!("[{}] {half} {}", unit.name, channel.name);
                values.insert(key, format!("{} values in {}", channel.size, channel.unit));
            }
        }
    }
    for signal in &head.signals {
        values.insert(format!("[{}] interval", in_words(signal)), format!("{:?} s", signal.interval));
    }
    values
}

/// Number of keys that both scenes have with the same value.
pub fn equal_keys(logs: [&Log; 2]) -> usize {
    let [a, b] = logs.map(values);
    a.iter().filter(|(key, value)| !key.starts_with('[') && b.get(*key) == Some(value)).count()
}

/// All differences of the settings: the scenes key by key, the units, the signals.
pub fn settings(logs: [&Log; 2]) -> Vec<KeyDifference> {
    let all = logs.map(values);
    let keys: std::collections::BTreeSet<&String> = all.iter().flat_map(BTreeMap::keys).collect();
    let values = |key: &String| all.each_ref().map(|values| values.get(key).cloned());
    let differing = keys.into_iter().map(|key| KeyDifference { key: key.clone(), values: values(key) });
    let mut differing: Vec<_> = differing.filter(|d| d.values[0] != d.values[1]).collect();
    differing.sort_by_key(|d| d.key.starts_with('['));
    for signal in &logs[0].head().signals {
        let other = logs[1].head().signals.iter().find(|other| other.name == signal.name);
        differing.extend(other.and_then(|other| first_sample(signal, other)));
    }
    differing
}

/// The name of a signal without underscores.
fn in_words(signal: &Signal) -> String {
    signal.name.replace('_', " ")
}

/// The first sample of a signal that differs; a list of all would be too long.
fn first_sample(signal: &Signal, other: &Signal) -> Option<KeyDifference> {
    let samples = [&signal.samples, &other.samples];
    let bits = |samples: &[f64], index: usize| samples.get(index).map(|v| v.to_bits());
    let count = samples[0].len().max(samples[1].len());
    let index = (0..count).find(|i| bits(samples[0], *i) != bits(samples[1], *i))?;
    let values = samples.map(|samples| samples.get(index).map(|v| format!("{v:?} {}", signal.unit)));
    Some(KeyDifference { key: format!("[{}] sample {index}", in_words(signal)), values })
}

fn flatten(prefix: &str, value: &Value, into: &mut BTreeMap<String, String>) {
    let mut inner = |name: &str, value: &Value| match prefix {
        "" => flatten(name, value, into),
        _ => flatten(&format!("{prefix}.{name}"), value, into),
    };
    match value {
        Value::Table(table) => table.iter().for_each(|(name, value)| inner(name, value)),
        Value::Array(array) => array.iter().enumerate().for_each(|(i, value)| inner(&i.to_string(), value)),
        _ => drop(into.insert(prefix.to_owned(), value.to_string())),
    }
}
