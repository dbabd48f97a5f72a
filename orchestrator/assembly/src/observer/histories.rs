use crate::units::GROUND_ACCELERATION;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::participant::{Channel, ChannelShape, Layout};
use cofferdam_coupling::scheme::{Exchange, InterfaceWork, Interval, UnitId, WindowReport};
use cofferdam_coupling::signal::Signal;
use cofferdam_log::background::{Background, FLUSH_INTERVAL, Queue, Stopped};
use cofferdam_log::results_file::{ResultsFile, write_error};
use std::io::{BufWriter, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Time histories of a run: one row per communication point, one column per quantity.
///
/// Columns: `time [s]`, `ground_acceleration.x [m/s2]`, with vertical ground motion `ground_acceleration.y [m/s2]`; of the coupling:
/// `iterations [1]`, `converged [1]` (1 or 0),
/// `residual.pressure [Pa]`, `residual.displacement [1]` (0 in a step of one iteration), `interpolation_error [Pa]` (0 where there is no estimate),
/// `interface_work [J/m]` on the dam since the start and `interface_energy_produced [J/m]` by the coupling; the
/// lowest pressure on the wet face (hydrostatic and hydrodynamic, against the atmosphere's); and every accepted
/// output of both units except arrays over the wet face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histories {
    columns: Vec<Vec<f64>>,
    names: Vec<String>,
}

/// Histories that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum HistoriesError {
    /// The file cannot be read.
    #[error("{}: {cause}; `cofferdam log export` makes it from the log", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// A field that is no number, or a row of another length.
    #[error("{}:{line}: {what}; `cofferdam log export` makes the file again from the log", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
}

impl Histories {
    /// Reads `histories.csv`, the numbers bit for bit. A last row that a killed run did not finish is left out.
    ///
    /// **Errors**: [`HistoriesError`].
    pub fn read(path: &Path) -> Result<Self, HistoriesError> {
        let failed = |cause| HistoriesError::Read { path: path.to_owned(), cause };
        let text = std::fs::read_to_string(path).map_err(failed)?;
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let wrong = |line: usize, what: String| HistoriesError::Row { path: path.to_owned(), line, what };
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(whole.as_bytes());
        let mut row = csv::StringRecord::new();
        let mut found = Self::default();
        for line in 1.. {
            if !reader.read_record(&mut row).map_err(|cause| failed(cause.into()))? {
                break;
            }
            if line == 1 {
                found.names = row.iter().map(str::to_owned).collect();
                found.columns = vec![Vec::new(); row.len()];
                continue;
            }
            if row.len() != found.columns.len() {
                let what = format!("{} values stand under {} names", row.len(), found.columns.len());
                return Err(wrong(line, what));
            }
            for (column, field) in found.columns.iter_mut().zip(&row) {
                column.push(field.parse().map_err(|_| wrong(line, format!("`{field}` is no number")))?);
            }
        }
        match found.names.first().map(String::as_str) {
            Some("time [s]") => Ok(found),
            _ => Err(wrong(1, "the first column is not `time [s]`".to_owned())),
        }
    }

    /// The column whose name without unit is `name`, such as `dam.crest_displacement.x`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let position = self.names.iter().position(|n| n.split(" [").next() == Some(name))?;
        Some(&self.columns[position])
    }

    /// Names of the columns, units in brackets.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// A row, in the order of the names.
    ///
    /// # Panics
    ///
    /// There is no such row.
    pub fn row(&self, row: usize) -> Vec<f64> {
        self.columns.iter().map(|column| column[row]).collect()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}

/// Keeps the histories and writes them as CSV during the run.
///
/// `histories.csv` holds [`Histories`]; `dam-interface_displacement.csv` and its like hold one array over the wet
/// face each. Numbers are written with all digits, so that reading them gives the same bits. A thread of its own writes them, all rows to
/// the disk once a second.
pub struct HistoriesWriter {
    /// Output folder; `None` keeps them in memory only.
    folder: Option<PathBuf>,
    /// What was recorded so far.
    pub histories: Histories,
    /// Where the request to each unit has the acceleration of the ground.
    grounds: Vec<Option<Range<usize>>>,
    /// Components of this acceleration that have a column.
    components: usize,
    scalars: Vec<(UnitId, Range<usize>)>,
    faces: Vec<(UnitId, Range<usize>)>,
    /// Takes the rows of all tables at the end of a step, one after the other.
    writing: Option<Background<Vec<f64>, ObserverError>>,
    work: InterfaceWork,
}

pub(super) struct Table {
    path: PathBuf,
    writer: BufWriter<ResultsFile>,
    columns: usize,
    /// The last row as text.
    line: Vec<u8>,
}

/// Bytes of a table that are written at once: few calls of the system.
const BUFFER: usize = 1 << 16;

impl Table {
    pub fn create(path: PathBuf, header: &[String]) -> Result<Self, ObserverError> {
        let failed = |cause| write_error(path.clone(), cause);
        let file = ResultsFile::create(&path).map_err(failed)?;
        Self::of(file, path, header)
    }

    /// Begins a table in `file`, which is named `path` in errors.
    pub fn of(file: ResultsFile, path: PathBuf, header: &[String]) -> Result<Self, ObserverError> {
        let mut writer = BufWriter::with_capacity(BUFFER, file);
        let mut names = csv::Writer::from_writer(&mut writer);
        let result = names.write_record(header).map_err(of_system).and_then(|()| names.flush());
        drop(names);
        result.map_err(|cause| write_error(path.clone(), cause))?;
        Ok(Self { path, writer, columns: header.len(), line: Vec::new() })
    }

    pub fn write(&mut self, row: &[f64]) -> Result<(), ObserverError> {
        let mut text = zmij::Buffer::new();
        self.line.clear();
        for value in row {
            self.line.extend_from_slice(text.format(*value).as_bytes());
            self.line.push(b',');
        }
        if let Some(end) = self.line.last_mut() {
            *end = b'\n';
        }
        let result = self.writer.write_all(&self.line);
        result.map_err(|cause| write_error(self.path.clone(), cause))
    }

    pub fn flush(&mut self) -> Result<(), ObserverError> {
        self.writer.flush().map_err(|cause| write_error(self.path.clone(), cause))
    }
}

/// The error of the system behind one of a table, whose kind the remedy depends on.
fn of_system(error: csv::Error) -> std::io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(cause) => cause,
        other => std::io::Error::other(format!("{other:?}")),
    }
}

impl HistoriesWriter {
    /// Writes into the existing folder `folder`.
    pub fn new(folder: &Path) -> Self {
        Self { folder: Some(folder.to_owned()), ..Self::in_memory() }
    }

    /// Keeps the histories without writing them.
    pub fn in_memory() -> Self {
        Self {
            folder: None,
            histories: Histories::default(),
            grounds: Vec::new(),
            components: 1,
            scalars: Vec::new(),
            faces: Vec::new(),
            writing: None,
            work: InterfaceWork::default(),
        }
    }
}

impl HistoriesWriter {
    /// Begins the tables of `units`, given by name and layouts of their requests and answers, which receive `signals`.
    ///
    /// **Errors**: a file cannot be made, or no thread.
    pub fn open(&mut self, units: &[(&str, [&Layout; 2])], signals: &[Signal]) -> Result<(), ObserverError> {
        let mut names: Vec<String> = [
            "time [s]",
            "ground_acceleration.x [m/s2]",
            "iterations [1]",
            "converged [1]",
            "residual.pressure [Pa]",
            "residual.displacement [1]",
            "interpolation_error [Pa]",
            "interface_work [J/m]",
            "interface_energy_produced [J/m]",
            "lowest_pressure [Pa]",
        ]
        .map(str::to_owned)
        .to_vec();
        if signals.iter().any(|signal| signal.input == GROUND_ACCELERATION && signal.component == 1) {
            self.components = 2;
            names.insert(2, "ground_acceleration.y [m/s2]".to_owned());
        }
        let ground = |(_, [inputs, _]): &(&str, [&Layout; 2])| inputs.range(GROUND_ACCELERATION);
        self.grounds = units.iter().map(ground).collect();
        let mut tables = Vec::new();
        for (number, (name, [_, outputs])) in units.iter().enumerate() {
            let unit = UnitId(number);
            for (channel, range) in outputs.channels() {
                if channel.shape == ChannelShape::WetFace {
                    let Some(folder) = &self.folder else { continue };
                    let path = folder.join(format!("{name}-{}.csv", channel.name));
                    let points = (0..channel.size).map(|i| format!("point {i} [{}]", channel.unit));
                    let header: Vec<String> = std::iter::once("time [s]".to_owned()).chain(points).collect();
                    tables.push(Table::create(path, &header)?);
                    self.faces.push((unit, range));
                } else {
                    names.extend(column_names(&format!("{name}."), channel));
                    self.scalars.push((unit, range));
                }
            }
        }
        if let Some(folder) = &self.folder {
            let path = folder.join("histories.csv");
            tables.insert(0, Table::create(path.clone(), &names)?);
            let writing = Background::begin(|rows| write_all(tables, rows));
            self.writing = Some(writing.map_err(|cause| write_error(path, cause))?);
        }
        self.histories = Histories { columns: vec![Vec::new(); names.len()], names };
        Ok(())
    }

    /// Waits until all rows are on the disk.
    ///
    /// **Errors**: they cannot be written.
    pub fn finish(&mut self) -> Result<(), ObserverError> {
        self.writing.take().map_or(Ok(()), |mut writing| writing.end()).map_err(|stopped| match stopped {
            Stopped::Failed(error) => error,
            Stopped::Panicked => write_error(
                self.folder.clone().unwrap_or_default(),
                std::io::Error::other("the thread that writes histories stopped; report this as a defect"),
            ),
        })
    }

    /// Keeps the row of a step, and has it written.
    fn write(
        &mut self,
        report: &WindowReport,
        interval: &Interval,
        exchanges: &[&Exchange],
        lowest_pressure: f64,
    ) -> Result<(), ObserverError> {
        let outputs = |unit: UnitId| &exchanges[unit.0].outputs;
        // To the picosecond, so that 4.01 is not written as 4.010000000000001.
        let time = (interval.end() * 1e12).round() / 1e12;
        // A step of one iteration has no displacement to compare with.
        let compared = |ratio: f64| if ratio == f64::INFINITY { 0.0 } else { ratio };
        let residuals = report.residuals().map_or([0.0, 0.0], |r| [r.norm, compared(r.change)]);
        // As the units received it; one that a branch has moved is not that of the motion.
        let place = |exchange: &&Exchange| self.grounds[exchange.unit.0].clone();
        let ground = exchanges.iter().rev().find_map(|exchange| exchange.inputs.get(place(exchange)?));
        let mut acceleration = [0.0; 2];
        acceleration.iter_mut().zip(ground.unwrap_or(&[])).for_each(|(own, value)| *own = *value);
        let coupling = [
            f64::from(report.iterations()),
            f64::from(u8::from(report.converged)),
            residuals[0],
            residuals[1],
            report.interpolation_error.unwrap_or(0.0),
            self.work.on_first,
            self.work.produced(),
            lowest_pressure,
        ];
        let rest =
            self.scalars.iter().flat_map(|(unit, range)| outputs(*unit)[range.clone()].iter().copied());
        let ground = acceleration.into_iter().take(self.components);
        let mut row: Vec<f64> = std::iter::once(time).chain(ground).chain(coupling).chain(rest).collect();
        for (column, value) in self.histories.columns.iter_mut().zip(&row) {
            column.push(*value);
        }
        let Some(writing) = &mut self.writing else { return Ok(()) };
        for (unit, range) in &self.faces {
            row.push(time);
            row.extend_from_slice(&outputs(*unit)[range.clone()]);
        }
        if writing.send(row) { Ok(()) } else { self.finish() }
    }
}

/// Writes the rows of all tables, to the disk once a second, until no more come.
fn write_all(mut tables: Vec<Table>, rows: Queue<Vec<f64>>) -> Result<(), ObserverError> {
    let mut flushed = Instant::now();
    for row in rows {
        let row = row.unwrap_or_default();
        let mut rest = &row[..];
        for table in tables.iter_mut().filter(|_| !row.is_empty()) {
            let (row, others) = rest.split_at(table.columns);
            table.write(row)?;
            rest = others;
        }
        if flushed.elapsed() > FLUSH_INTERVAL {
            flushed = Instant::now();
            tables.iter_mut().try_for_each(Table::flush)?;
        }
    }
    tables.iter_mut().try_for_each(Table::flush)
}

/// Column names of a channel: with `.x`, `.y` or an index where it has several values.
fn column_names(prefix: &str, channel: &Channel) -> Vec<String> {
    let name = |suffix: &str| format!("{prefix}{}{suffix} [{}]", channel.name, channel.unit);
    match channel.shape {
        ChannelShape::Scalar => vec![name("")],
        ChannelShape::Plane => vec![name(".x"), name(".y")],
        ChannelShape::WetFace | ChannelShape::List => {
            (0..channel.size).map(|i| name(&format!(".{i}"))).collect()
        }
    }
}

impl Observer for HistoriesWriter {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        let units: Vec<_> =
            start.units.iter().map(|unit| (unit.name.as_str(), [&unit.inputs, &unit.outputs])).collect();
        self.open(&units, start.signals)
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        for (index, interval) in report.steps.iter().enumerate() {
            let of = |number| report.accepted(UnitId(number), interval.step);
            if let Some(exchanges) = (0..self.grounds.len()).map(of).collect::<Option<Vec<_>>>() {
                self.work += report.work(index).unwrap_or_default();
                let lowest_pressure = report.lowest(index).unwrap_or(0.0);
                self.write(report, interval, &exchanges, lowest_pressure)?;
            }
        }
        Ok(())
    }

    fn end(&mut self, _ending: &Ending) -> Result<(), ObserverError> {
        self.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_the_system_keeps_its_kind() {
        let kind = std::io::ErrorKind::FileTooLarge;
        assert_eq!(of_system(std::io::Error::from(kind).into()).kind(), kind);
    }

    #[test]
    fn histories_are_read_as_they_were_written_and_a_cut_row_is_left_out() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("histories.csv");
        let read = |text: &str| {
            std::fs::write(&path, text)?;
            Ok::<_, std::io::Error>(Histories::read(&path).map_err(|error| error.to_string()))
        };
        let third = 1.0 / 3.0;
        let whole = format!("time [s],a.b [Pa]\n0.0,{third}\n0.5,NaN\n");
        let histories = read(&whole)?.expect("histories");
        assert_eq!((histories.rows(), histories.column("time")), (2, Some(&[0.0, 0.5][..])));
        let values = histories.column("a.b").expect("a column");
        assert!(values[0] == third && values[1].is_nan());
        // Of `1.25`, whose row a killed run did not finish.
        assert_eq!(read(&(whole.clone() + "1.0,1.2"))?.expect("histories").rows(), 2);
        for (text, what) in [
            (whole.clone() + "1.0\n", ":4: 1 values stand under 2 names"),
            (whole.clone() + "1.0,x\n", ":4: `x` is no number"),
            ("a,b\n".to_owned(), ":1: the first column is not"),
            (String::new(), ":1: the first column is not"),
        ] {
            let error = read(&text)?.expect_err(what);
            assert!(error.contains(what) && error.contains("log export"), "{error}");
        }
        Ok(())
    }
}
