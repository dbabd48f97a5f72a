use super::budget::Budget;
use super::content::{Content, LoggedExchanges};
use super::schema::{MessageType, Value};
use super::source::Source;
use super::types::{
    build_type, capitalised, checkpoint_type, end_type, exchange_type, iteration_type, repeated_name,
    scene_type, signal_type, step_type, unit_type, variable_type,
};
use super::{LogError, foxglove};
use crate::background::{Background, FLUSH_INTERVAL, Queue, Stopped};
use crate::results_file::ResultsFile;
use cofferdam_coupling::convergence::{Residuals, norm};
use cofferdam_coupling::observer::{Checkpoint, Ending, Observer, ObserverError, Start};
use cofferdam_coupling::participant::{Channel, Description, Layout, Message, Occasion};
use cofferdam_coupling::scheme::{
    Exchange, InterfaceReport, Interval, IterationReport, UnitId, WindowReport,
};
use mcap::records::MessageHeader;
use std::collections::BTreeMap;
use std::io::BufWriter;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::time::Instant;

/// The first entries of a log besides the units and the external signals.
#[derive(Clone, Debug, Default)]
pub struct Preamble {
    /// What the run computes, as text; of a scene of a dam, TOML with all defaults.
    pub scene: String,
    /// Version of the program.
    pub version: String,
    /// Git commit of the program.
    pub commit: String,
    /// Optimised or not.
    pub profile: String,
    /// The processor.
    pub processor: String,
    /// What the processor offers to the program beyond its architecture; results are equal, bit for bit, where this is equal.
    pub features: String,
    /// Operating system and architecture.
    pub system: String,
    /// When the run began, in UTC.
    pub started: String,
    /// The run that this one branched off from.
    pub parent: Option<Parent>,
    /// What is logged of the run.
    pub content: Content,
    /// Communication steps that are iterated together.
    pub window: usize,
}

/// The run that a branch shares its beginning with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parent {
    /// Its log.
    pub log: String,
    /// The last step that both share.
    pub step: u64,
    /// What was set otherwise from there on, `KEY=VALUE` a line.
    pub settings: String,
}

const CHUNK_SIZE: u64 = 1 << 20;

/// Writes the log of a run on a thread of its own.
///
/// `log_time` is the end of the window in simulated nanoseconds plus a counter inside the window, which usually is
/// one step; it never decreases, so that a window that is started again follows its first attempt. So a window is one range of
/// the index, in the order of the events. `publish_time` is the physical time of the data, the end of their step, and never
/// after `log_time`. `sequence` pairs a request with its answer, which is missing where the unit failed. Wall times are
/// fields.
pub struct LogWriter {
    path: PathBuf,
    /// Until the thread has it.
    writer: Option<Writer>,
    writing: Option<Background<Work, mcap::McapError>>,
    pending: Vec<Record>,
    types: Vec<MessageType>,
    /// Requests and answers of each unit.
    units: Vec<[Half; 2]>,
    topics: Option<Topics>,
    sequence: u32,
    next_log_time: u64,
    content: Content,
    window: usize,
    budget: Budget,
}

type Topic = usize;

/// Topics that are known after the declaration.
#[derive(Clone, Copy)]
struct Topics {
    message: Topic,
    iteration: Topic,
    step: Topic,
    checkpoint: Topic,
    end: Topic,
}

/// Requests or answers of a unit: their topic, the place of every variable and whether it is an array.
#[derive(Clone, Debug, Default)]
struct Half {
    topic: Topic,
    fields: Arc<[(Range<usize>, bool)]>,
}

/// What the writing thread is asked for.
enum Work {
    Records(Vec<Record>),
    /// To write what it has, and then to tell.
    Flush(SyncSender<()>),
}

struct Record {
    header: MessageHeader,
    data: Vec<u8>,
}

impl LogWriter {
    /// Creates the file `path`; the preamble is on the disk before anything else happens.
    pub fn create(path: &Path, preamble: &Preamble) -> Result<Self, LogError> {
        let file =
            ResultsFile::create(path).map_err(|cause| LogError::Create { path: path.to_owned(), cause })?;
        Self::of(file, path, preamble)
    }

    /// The same beside the log `path`, in whose place it comes with [`replace`](Self::replace).
    pub fn beside(path: &Path, preamble: &Preamble) -> Result<Self, LogError> {
        let aside = aside(path);
        let file =
            ResultsFile::create(&aside).map_err(|cause| LogError::Create { path: aside.clone(), cause })?;
        Self::of(file.or(path), &aside, preamble)
    }

    /// Whether a log is being written at `path`, or beside it to take its place.
    pub fn is_busy(path: &Path) -> bool {
        let running = |path: &Path| Source::open(path, Arc::default()).is_ok_and(|source| source.running());
        running(path) || running(&aside(path))
    }

    /// Makes sure that all messages so far are in the file, and gives it the name of the log that it was made beside.
    ///
    /// **Errors**: it cannot be written, or renamed.
    pub fn replace(&mut self, path: &Path) -> Result<(), LogError> {
        let (tell, written) = sync_channel(1);
        self.flush();
        if let Some(writing) = &mut self.writing
            && (!writing.send(Work::Flush(tell)) || written.recv().is_err())
        {
            return self.ended();
        }
        std::fs::rename(aside(path), path)
            .map_err(|cause| LogError::Create { path: path.to_owned(), cause })?;
        path.clone_into(&mut self.path);
        Ok(())
    }

    fn of(file: ResultsFile, path: &Path, preamble: &Preamble) -> Result<Self, LogError> {
        let mut log = Self {
            path: path.to_owned(),
            writer: None,
            writing: None,
            pending: Vec::new(),
            types: Vec::new(),
            units: Vec::new(),
            topics: None,
            sequence: 0,
            next_log_time: 0,
            window: preamble.window.max(1),
            content: preamble.content,
            budget: Budget::new(0.0, 0),
        };
        log.open(file, preamble).map_err(|error| LogError::of_writer(path, error))?;
        Ok(log)
    }

    fn open(&mut self, file: ResultsFile, preamble: &Preamble) -> Result<(), mcap::McapError> {
        file.hold();
        let library = format!("cofferdam {}", preamble.version);
        let mut writer = options(&library).create(BufWriter::new(file))?;
        let scene = self.declare(&mut writer, "/scene", scene_type())?;
        let build = self.declare(&mut writer, "/build", build_type())?;
        let Preamble { version, commit, profile, processor, features, system, started, content, .. } =
            preamble;
        let window = preamble.window.max(1).to_string();
        let parent = preamble.parent.clone().unwrap_or_default();
        let parent_step = preamble.parent.as_ref().map_or_else(String::new, |parent| parent.step.to_string());
        let texts = [version, commit, profile, processor, features, system, started];
        let texts =
            texts.into_iter().chain([&parent.log, &parent_step, &parent.settings]).map(String::as_str);
        let texts = texts.chain([content.exchanges.word(), &window]);
        let texts: Vec<_> = texts.map(Value::Text).collect();
        for (topic, data) in [
            (scene, self.types[scene].encode([Value::Text(&preamble.scene)])),
            (build, self.types[build].encode(texts)),
        ] {
            let Record { header, data } = self.record(topic, 0, 0, data);
            writer.write_to_known_channel(&header, &data)?;
        }
        writer.flush()?;
        self.writer = Some(writer);
        Ok(())
    }

    /// Declares a topic and its message type; its channel in the file has the same number.
    fn declare(
        &mut self,
        writer: &mut Writer,
        topic: &str,
        kind: MessageType,
    ) -> Result<Topic, mcap::McapError> {
        self.declare_with(writer, topic, kind, &BTreeMap::new())
    }

    /// The same with metadata of the channel.
    fn declare_with(
        &mut self,
        writer: &mut Writer,
        topic: &str,
        kind: MessageType,
        metadata: &BTreeMap<String, String>,
    ) -> Result<Topic, mcap::McapError> {
        let schema = writer.add_schema(&kind.full_name(), "protobuf", &kind.descriptor_set())?;
        let channel = writer.add_channel(schema, topic, "protobuf", metadata)?;
        self.types.push(kind);
        debug_assert_eq!(usize::from(channel), self.types.len());
        Ok(self.types.len() - 1)
    }

    /// Declares the topic of messages of units. Its type is Foxglove's; the one added here only keeps the numbering.
    fn declare_messages(&mut self, writer: &mut Writer) -> Result<Topic, mcap::McapError> {
        let schema = writer.add_schema(foxglove::LOG, "protobuf", &foxglove::descriptor_set())?;
        writer.add_channel(schema, "/log", "protobuf", &BTreeMap::new())?;
        self.types.push(MessageType::new("Log", Vec::new()));
        Ok(self.types.len() - 1)
    }

    fn start(&mut self, mut writer: Writer, start: &Start<'_>) -> Result<(), mcap::McapError> {
        self.budget = Budget::new(self.content.checkpoint_share, start.units.len());
        let unit = self.declare(&mut writer, "/unit", unit_type())?;
        let signals = start.signals.iter().map(|signal| {
            let held = signal.held.to_string();
            let (input, quantity, unit) = (&signal.input, &signal.quantity, &signal.unit);
            let metadata = [("input", input), ("quantity", quantity), ("unit", unit), ("held", &held)];
            let metadata = metadata.map(|(key, value)| (key.to_owned(), value.clone()));
            let mut metadata = BTreeMap::from(metadata);
            if signal.component > 0 {
                metadata.insert("component".to_owned(), signal.component.to_string());
            }
            if !signal.parts.is_empty() {
                let parts: Vec<String> = signal.parts.iter().map(f64::to_string).collect();
                metadata.insert("parts".to_owned(), parts.join(","));
            }
            let topic = format!("/{}", signal.name);
            self.declare_with(&mut writer, &topic, signal_type(signal), &metadata)
        });
        let signals = signals.collect::<Result<Vec<_>, _>>()?;
        for description in &start.units {
            let name = &description.name;
            let mut half = |what: &str, layout: &Layout| -> Result<Half, mcap::McapError> {
                let kind = exchange_type(&format!("{}{what}", capitalised(name)), layout);
                let topic = self.declare(&mut writer, &format!("/{name}/{}", what.to_lowercase()), kind)?;
                Ok(Half {
                    topic,
                    fields: layout.channels().map(|(c, range)| (range, c.shape.is_array())).collect(),
                })
            };
            let halves = [half("Request", &description.inputs)?, half("Answer", &description.outputs)?];
            self.units.push(halves);
        }
        self.topics = Some(Topics {
            message: self.declare_messages(&mut writer)?,
            iteration: self.declare(&mut writer, "/iteration", iteration_type())?,
            step: self.declare(&mut writer, "/step", step_type(&start.units))?,
            checkpoint: self.declare(&mut writer, "/checkpoint", checkpoint_type())?,
            end: self.declare(&mut writer, "/end", end_type())?,
        });

        self.writing = Some(Background::begin(|queue| write_all(writer, queue))?);

        for description in &start.units {
            self.send(unit, 0, 0, self.encode_unit(unit, description));
        }
        for (topic, signal) in signals.into_iter().zip(start.signals) {
            let data = self.types[topic].encode([
                Value::Double(signal.interval),
                Value::Doubles(&signal.samples),
                Value::Text(&signal.source),
            ]);
            self.send(topic, 0, 0, data);
        }
        self.flush();
        Ok(())
    }

    fn encode_unit(&self, topic: Topic, description: &Description) -> Vec<u8> {
        let variable = variable_type();
        let encoded = |channel: &Channel| {
            variable.encode([
                Value::Text(&channel.name),
                Value::Unsigned(u64::from(channel.value_reference)),
                Value::Text(&channel.unit),
                Value::Unsigned(channel.size as u64),
                Value::Bool(channel.shape.is_array()),
            ])
        };
        let list = |layout: &Layout| layout.channels().map(|(c, _)| encoded(c)).collect::<Vec<_>>();
        let (inputs, outputs) = (list(&description.inputs), list(&description.outputs));
        let fingerprint = description.fingerprint.to_string();
        let texts = [&description.name, &description.solver, &fingerprint].map(|t| Value::Text(t));
        let lists = [Value::Messages(&inputs), Value::Messages(&outputs)];
        self.types[topic].encode(texts.into_iter().chain(lists))
    }

    /// Adds a message to those that the next [`flush`](Self::flush) queues.
    fn send(&mut self, topic: Topic, sequence: u32, publish_time: u64, data: Vec<u8>) {
        self.budget.add(data.len() as u64);
        let record = self.record(topic, sequence, publish_time, data);
        self.pending.push(record);
    }

    /// A record with the next time of the log.
    fn record(&mut self, topic: Topic, sequence: u32, publish_time: u64, data: Vec<u8>) -> Record {
        let header = MessageHeader {
            channel_id: topic as u16 + 1,
            sequence,
            log_time: self.next_log_time,
            publish_time: publish_time.min(self.next_log_time),
        };
        self.next_log_time += 1;
        Record { header, data }
    }

    /// Queues what was sent, all at once; whether the thread still writes.
    fn flush(&mut self) -> bool {
        let pending = std::mem::take(&mut self.pending);
        self.writing.as_mut().is_some_and(|writing| writing.send(Work::Records(pending)))
    }

    /// Ends the writing thread, if `finish` or if it has failed, and returns its error.
    fn check(&mut self, finish: bool) -> Result<(), ObserverError> {
        if self.flush() && !finish {
            return Ok(());
        }
        Ok(self.ended()?)
    }

    /// Waits for the end of the writing thread.
    fn ended(&mut self) -> Result<(), LogError> {
        self.writing.take().map_or(Ok(()), |mut writing| writing.end()).map_err(|stopped| match stopped {
            Stopped::Failed(error) => LogError::of_writer(&self.path, error),
            Stopped::Panicked => LogError::Stopped { path: self.path.clone() },
        })
    }

    fn send_message(&mut self, topic: Topic, message: &Message) {
        let data = foxglove::encode(message);
        self.send(topic, self.sequence, nanoseconds(message.time), data);
    }

    fn send_iteration(&mut self, topic: Topic, report: &WindowReport, iterate: &IterationReport) {
        let IterationReport { iteration, purpose, correction, residuals, worst } = iterate;
        let residual = |of: fn(&Residuals) -> f64| residuals.as_ref().map_or(0.0, of);
        let secants = correction.secants;
        let count = |number: usize| Value::Unsigned(number as u64);
        let values = [
            Value::Unsigned(report.step()),
            count(report.steps.len()),
            Value::Unsigned(u64::from(report.attempt)),
            Value::Unsigned(u64::from(*iteration)),
            Value::Double(report.time()),
            Value::Double(report.end()),
            Value::Text(purpose.word()),
            Value::Bool(residuals.is_some()),
            Value::Double(residual(|r| r.norm)),
            Value::Double(residual(|r| r.relative_ratio)),
            Value::Double(residual(|r| r.reduction_ratio)),
            Value::Double(residual(|r| r.change)),
            Value::Unsigned(worst.map_or(0, |worst| worst.step)),
            count(worst.map_or(0, |worst| worst.interface)),
            count(worst.map_or(0, |worst| worst.point)),
            Value::Double(worst.map_or(0.0, |worst| worst.given)),
            Value::Double(worst.map_or(0.0, |worst| worst.answered)),
            Value::Text(correction.acceleration.word()),
            Value::Double(correction.relaxation),
            count(secants.known),
            count(secants.independent),
            count(secants.used),
            Value::Text(correction.jacobian.word()),
        ];
        let data = self.types[topic].encode(values);
        self.send(topic, self.sequence, nanoseconds(report.end()), data);
    }

    fn send_step(&mut self, topic: Topic, report: &WindowReport, interval: &Interval, index: usize) {
        let residuals = report.residuals();
        let residual = |of: fn(&Residuals) -> f64| residuals.as_ref().map_or(0.0, of);
        let work = report.work(index).unwrap_or_default();
        let interfaces = report.interfaces.get(index).map_or(&[][..], Vec::as_slice);
        let each = |of: fn(&InterfaceReport) -> f64| interfaces.iter().map(of).collect::<Vec<_>>();
        let [on_structure, by_fluid, lowest, mapping] = [
            each(|interface| interface.work.map_or(f64::NAN, |work| work.on_first)),
            each(|interface| interface.work.map_or(f64::NAN, |work| work.by_second)),
            each(|interface| interface.lowest),
            each(|interface| interface.mapping_error),
        ];
        let units = report.solver_time.iter().enumerate().flat_map(|(number, time)| {
            // The cost of a window is divided among its steps.
            let share = |total: u64| total.div_ceil(report.steps.len() as u64);
            let [calls, restores] = report.calls(UnitId(number)).map(share);
            let time = time.as_secs_f64() / report.steps.len() as f64;
            [Value::Unsigned(calls), Value::Unsigned(restores), Value::Double(time)]
        });
        let correction = report.correction();
        let values = [
            Value::Unsigned(interval.step),
            Value::Unsigned(u64::from(report.attempt)),
            Value::Double(interval.time),
            Value::Double(interval.end()),
            Value::Double(interval.communication_step),
            Value::Unsigned(u64::from(report.iterations())),
            Value::Bool(report.converged),
            Value::Bool(report.is_accepted()),
            Value::Text(&report.outcome),
            Value::Double(residual(|r| r.norm)),
            Value::Double(residual(|r| r.relative_ratio)),
            Value::Double(residual(|r| r.reduction_ratio)),
            Value::Double(residual(|r| r.change)),
            Value::Double(correction.map_or(1.0, |correction| correction.relaxation)),
            Value::Unsigned(correction.map_or(0, |correction| correction.secants.used as u64)),
            Value::Unsigned(u64::from(report.fallbacks)),
            Value::Double(report.interpolation_error.unwrap_or(0.0)),
            Value::Double(report.largest),
            Value::Double(report.rounding_floor.unwrap_or(0.0)),
            Value::Double(work.on_first),
            Value::Double(work.produced()),
            Value::Doubles(&on_structure),
            Value::Doubles(&by_fluid),
            Value::Doubles(&lowest),
            Value::Doubles(&mapping),
        ];
        let data = self.types[topic].encode(values.into_iter().chain(units));
        self.send(topic, self.sequence, nanoseconds(interval.end()), data);
    }

    fn send_exchange(&mut self, exchange: &Exchange) {
        let [request, answer] = self.units[exchange.unit.0].clone();
        self.sequence += 1;
        let Occasion { step, iteration, attempt, time, communication_step } = exchange.occasion;
        let end = nanoseconds(exchange.occasion.end());
        let halves =
            [(request, &exchange.inputs, exchange.sent), (answer, &exchange.outputs, exchange.answered)];
        for (Half { topic, fields }, values, wall_time) in halves {
            if values.is_empty() && !fields.is_empty() {
                // A unit that failed gave no answer.
                continue;
            }
            let header = [
                Value::Unsigned(step),
                Value::Unsigned(u64::from(iteration)),
                Value::Unsigned(u64::from(attempt)),
                Value::Bool(exchange.accepted),
                Value::Double(time),
                Value::Double(exchange.occasion.end()),
                Value::Double(communication_step),
                Value::Double(wall_time.as_secs_f64()),
            ];
            let fields = fields.iter().flat_map(|(range, array)| {
                let values = &values[range.clone()];
                let one = if *array { Value::Doubles(values) } else { Value::Double(values[0]) };
                let norm = array.then(|| Value::Double(norm(values.iter().copied())));
                std::iter::once(one).chain(norm)
            });
            let data = self.types[topic].encode(header.into_iter().chain(fields));
            self.send(topic, self.sequence, end, data);
        }
    }
}

impl Observer for LogWriter {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        let Some(writer) = self.writer.take() else { return Ok(()) };
        let (preamble, run) = (self.window, start.stepping.window.max(1));
        if preamble != run {
            return Err(LogError::Window { preamble, run }.into());
        }
        if let Some((unit, variable)) = repeated_name(&start.units) {
            return Err(LogError::Name { unit, variable }.into());
        }
        self.start(writer, start).map_err(|error| LogError::of_writer(&self.path, error).into())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        let Some(topics) = self.topics else { return Ok(()) };
        self.next_log_time = self.next_log_time.max(nanoseconds(report.end()));
        let logged = self.content.exchanges;
        let every = logged == LoggedExchanges::Every || !report.is_accepted();
        for exchange in &report.exchanges {
            if logged != LoggedExchanges::None && (every || exchange.accepted) {
                self.send_exchange(exchange);
            }
        }
        for message in &report.messages {
            self.send_message(topics.message, message);
        }
        if logged == LoggedExchanges::None {
            return self.check(false);
        }
        for iterate in &report.iterates {
            self.send_iteration(topics.iteration, report, iterate);
        }
        for (index, interval) in report.steps.iter().enumerate() {
            self.send_step(topics.step, report, interval, index);
        }
        self.check(false)
    }

    fn end(&mut self, ending: &Ending) -> Result<(), ObserverError> {
        if let Some(topics) = self.topics {
            let status = ending.status.to_string();
            let wall_time = ending.wall.total.as_secs_f64();
            let data = self.types[topics.end].encode([
                Value::Text(&status),
                Value::Double(ending.time),
                Value::Double(wall_time),
                Value::Unsigned(ending.statistics.unconverged),
                Value::Unsigned(ending.statistics.rejected),
                Value::Double(ending.statistics.rounding_floor.unwrap_or(0.0)),
            ]);
            self.send(topics.end, self.sequence, nanoseconds(ending.time), data);
        }
        self.check(true)
    }

    fn wants_checkpoint(&self) -> Option<Vec<bool>> {
        let begun = self.topics.filter(|_| self.content.exchanges != LoggedExchanges::None);
        begun.and_then(|_| self.budget.wishes())
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) -> Result<(), ObserverError> {
        let Some(topics) = self.topics else { return Ok(()) };
        let Checkpoint { step, time, run, units } = checkpoint;
        let sizes: Vec<_> =
            units.iter().map(|state| state.as_ref().map(|bytes| bytes.len() as u64)).collect();
        let states: Vec<Vec<u8>> = units.iter().map(|state| state.clone().unwrap_or_default()).collect();
        let data = self.types[topics.checkpoint].encode([
            Value::Unsigned(*step),
            Value::Double(*time),
            Value::Messages(std::slice::from_ref(run)),
            Value::Messages(&states),
        ]);
        self.send(topics.checkpoint, self.sequence, nanoseconds(*time), data);
        self.budget.written(run.len() as u64, &sizes);
        self.check(false)
    }
}

type Writer = mcap::Writer<BufWriter<ResultsFile>>;

/// How logs are written: with checksums of the chunks, of the data and of the summary.
pub fn options(library: &str) -> mcap::WriteOptions {
    mcap::WriteOptions::new()
        .compression(Some(mcap::Compression::Lz4))
        .chunk_size(Some(CHUNK_SIZE))
        .calculate_chunk_crcs(true)
        .calculate_data_section_crc(true)
        .calculate_summary_section_crc(true)
        .library(library)
}

/// Writes records until the queue closes; flushes the first ones at once, later ones every second.
fn write_all(mut writer: Writer, queue: Queue<Work>) -> Result<(), mcap::McapError> {
    let mut flushed: Option<Instant> = None;
    for work in queue {
        let mut asked = None;
        match work {
            Some(Work::Records(records)) => {
                for record in records {
                    writer.write_to_known_channel(&record.header, &record.data)?;
                }
            }
            Some(Work::Flush(tell)) => asked = Some(tell),
            None => {}
        }
        if asked.is_some() || flushed.is_none_or(|f| f.elapsed() > FLUSH_INTERVAL) {
            writer.flush()?;
            flushed = Some(Instant::now());
        }
        // Who asked waits.
        asked.map(|tell| tell.send(()));
    }
    writer.finish().map(|_| ())
}

/// Where a log is written that takes the place of the one at `path`.
fn aside(path: &Path) -> PathBuf {
    path.with_extension("mcap.new")
}

/// Simulated time in whole nanoseconds.
fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}
