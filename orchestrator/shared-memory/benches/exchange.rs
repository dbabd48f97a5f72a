//! One exchange of 100 values each way between two processes, over shared memory, beside a Unix socket and
//! an in-process call: `cargo bench -p cofferdam-shared-memory --bench exchange`.
//!
//! The process that answers is this program again, or, if `PYTHON` names an interpreter that has the package of `python/`,
//! a unit in Python. Times are those of the whole call without the solve.

use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, IterationInfo, Measure, Scales};
use cofferdam_coupling::observer::{Observer, Start};
use cofferdam_coupling::participant::{
    AccelerationMeaning, Channel, ChannelShape, Description, Layout, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{Exchange, Interval, IterationReport, Purpose, UnitId, WindowReport};
use cofferdam_coupling::signal::Signal;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_log::{LogWriter, Preamble};
use cofferdam_shared_memory::{Brief, BriefPoints, Deadlines, Starting, UnitCommand, host};
use cofferdam_unit::Role;
use cofferdam_unit::{Capabilities, Fingerprint};
use std::error::Error;
use std::ffi::OsStr;
use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::process::{Child, Command, ExitCode};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const VALUES: usize = 100;
const WARM_UP: usize = 1_000;
const BYTES: usize = 64 + 8 * VALUES;

/// Answers each request with its values, after a solve of `solve`.
struct Echo {
    description: Description,
    solve: Duration,
}

impl Echo {
    fn new(solve: Duration) -> Result<Self, Box<dyn Error>> {
        let layout = |name: &str| {
            let (name, unit) = (name.to_owned(), "Pa".to_owned());
            Layout::new(vec![Channel {
                name,
                value_reference: 1,
                unit,
                size: VALUES,
                shape: ChannelShape::WetFace,
            }])
        };
        let description = Description {
            name: "dam".to_owned(),
            solver: "echo".to_owned(),
            fingerprint: Fingerprint::of("echo", &VALUES)?,
            inputs: layout("interface_pressure"),
            outputs: layout("interface_acceleration"),
            readable: Layout::default(),
            capabilities: Capabilities {
                variable_communication_step: true,
                directional_derivative: false,
                saved_state: true,
            },
        };
        Ok(Self { description, solve })
    }
}

impl Participant for Echo {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, _variable: &str) -> Result<Vec<f64>, ParticipantError> {
        Ok(Vec::new())
    }

    fn initialise(
        &mut self,
        _start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        outputs.copy_from_slice(inputs);
        Ok(())
    }

    fn step(
        &mut self,
        _occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        solve(self.solve);
        outputs.copy_from_slice(inputs);
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }
}

/// Computes for `duration`.
fn solve(duration: Duration) {
    let began = Instant::now();
    while began.elapsed() < duration {
        std::hint::spin_loop();
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let microseconds = |text: &String| Duration::from_micros(text.parse().unwrap_or(0));
    match &arguments[..] {
        [unit, solve] if unit == "unit" => {
            host(|_| Echo::new(microseconds(solve)).map(|e| Box::new(e) as Box<dyn Participant>))
        }
        [socket, path, solve] if socket == "socket" => ended(serve_socket(path, microseconds(solve))),
        // cargo bench adds --bench.
        _ => ended(compare()),
    }
}

fn ended(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn compare() -> Result<(), Box<dyn Error>> {
    println!("{:<50} {:>9} {:>9} {:>9}", "µs, beside the solve", "median", "99 %", "99.9 %");
    for (solve, count) in [(Duration::ZERO, 100_000), (Duration::from_micros(500), 4_000)] {
        let title = |what: &str| match solve {
            Duration::ZERO => what.to_owned(),
            _ => format!("{what}, solves of {:.1} ms", 1e3 * solve.as_secs_f64()),
        };
        print(&title("in-process"), solve, measure(&mut Echo::new(solve)?, count, |_, _, _| Ok(()))?);
        print(&title("Unix socket"), solve, measure_socket(solve, count)?);
        for (what, brief) in [("shared memory", None), ("shared memory, usual service", Some(brief()))] {
            let mut unit = shared_memory(solve, brief)?;
            print(&title(what), solve, measure(&mut *unit, count, |_, _, _| Ok(()))?);
        }
        if let (Some(python), Duration::ZERO) = (std::env::var_os("PYTHON"), solve) {
            let mut unit = in_python(&python)?;
            print("shared memory, unit in Python", solve, measure(&mut *unit, count / 4, |_, _, _| Ok(()))?);
        }
        let mut unit = shared_memory(solve, None)?;
        let mut coupling = Coupling::new(unit.description().clone(), &title("log"))?;
        let times = measure(&mut *unit, count, |step, inputs, outputs| coupling.step(step, inputs, outputs))?;
        print(&title("shared memory, acceleration, both log records"), solve, times);
    }
    Ok(())
}

fn print(title: &str, solve: Duration, mut times: Vec<Duration>) {
    times.sort_unstable();
    let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize].saturating_sub(solve);
    let [median, high, highest] = [0.5, 0.99, 0.999].map(|share| 1e6 * at(share).as_secs_f64());
    println!("{title:<50} {median:>9.2} {high:>9.2} {highest:>9.2}");
}

/// Wall time of each of `count` steps and of what is done `after` it.
fn measure(
    unit: &mut dyn Participant,
    count: usize,
    mut after: impl FnMut(u64, &mut [f64], &[f64]) -> Result<(), Box<dyn Error>>,
) -> Result<Vec<Duration>, Box<dyn Error>> {
    let Description { inputs, outputs, .. } = unit.description();
    let (mut inputs, mut outputs) = (vec![0.25; inputs.size()], vec![0.0; outputs.size()]);
    unit.initialise(0.0, &inputs, &mut outputs)?;
    let mut times = Vec::with_capacity(count);
    for step in 1..=(WARM_UP + count) as u64 {
        let time = 1e-3 * step as f64;
        let occasion = Occasion { step, iteration: 1, attempt: 1, time, communication_step: 1e-3 };
        inputs.fill(time);
        let began = Instant::now();
        unit.save_state()?;
        unit.step(&occasion, &inputs, &mut outputs)?;
        after(step, &mut inputs, &outputs)?;
        times.push(began.elapsed());
    }
    Ok(times.split_off(WARM_UP))
}

/// What a unit that is not ours is made from; with it, a unit is reached over iceoryx2's usual service.
fn brief() -> Brief {
    let elevations = || (0..VALUES).map(|i| i as f64).collect::<Vec<_>>();
    let all = |value: f64| vec![value; VALUES];
    Brief {
        role: Role::Fluid,
        points: BriefPoints {
            x: all(0.0),
            y: elevations(),
            normal_x: all(1.0),
            normal_y: all(0.0),
            tributary_length: all(1.0),
        },
        depth: (VALUES - 1) as f64,
        density: 1000.0,
        gravity: 9.81,
        communication_step: 1e-3,
        duration: 1.0,
        acceleration: AccelerationMeaning::Mean,
        parameters: std::collections::BTreeMap::default(),
    }
}

fn shared_memory(solve: Duration, brief: Option<Brief>) -> Result<Box<dyn Participant>, Box<dyn Error>> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("unit").arg(solve.as_micros().to_string());
    started("dam", command, brief)
}

/// `examples/python/westergaard.py`.
fn in_python(interpreter: &OsStr) -> Result<Box<dyn Participant>, Box<dyn Error>> {
    let mut command = Command::new(interpreter);
    command.arg("-B").arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/python/westergaard.py"));
    started("reservoir", command, Some(brief()))
}

fn started(
    name: &str,
    command: Command,
    brief: Option<Brief>,
) -> Result<Box<dyn Participant>, Box<dyn Error>> {
    let deadlines = Deadlines { preparation: Duration::from_secs(10), step: Duration::from_secs(10) };
    let unit = UnitCommand { name: name.to_owned(), command, brief };
    let starting = Starting::new([unit], "", 1, deadlines)?;
    Ok(Box::new(starting.wait(&AtomicBool::new(false))?.remove(0)))
}

/// What the orchestrator does beside the exchange: residuals, acceleration, and a step's log records.
struct Coupling {
    acceleration: Acceleration,
    measure: ConvergenceMeasure,
    log: LogWriter,
    guess: Vec<f64>,
    _folder: tempfile::TempDir,
}

impl Coupling {
    fn new(dam: Description, name: &str) -> Result<Self, Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let mut log = LogWriter::create(&folder.path().join(name), &Preamble::default())?;
        let reservoir = Description { name: "reservoir".to_owned(), ..dam.clone() };
        let ramp =
            Signal { held: true, ..Signal::new("ground_motion", "ground_acceleration", 1.0, vec![0.0, 1.0]) };
        log.begin(&Start {
            units: vec![dam, reservoir],
            signals: &[ramp],
            stepping: Stepping::equal(1e-3, 1),
        })?;
        let acceleration = Acceleration::new(AccelerationKind::Aitken, 0.9, 1.0);
        let measure = ConvergenceMeasure::new(
            &[Measure::Change, Measure::Relative],
            1e-6,
            Scales { change: 1e-7, typical: 1e6, bound: 1e10, ..Scales::default() },
        );
        Ok(Self { acceleration, measure, log, guess: vec![0.0; VALUES], _folder: folder })
    }

    fn step(&mut self, step: u64, inputs: &mut [f64], outputs: &[f64]) -> Result<(), Box<dyn Error>> {
        let residuals =
            self.measure.residuals(outputs, Some(inputs), [&self.guess, outputs], IterationInfo::default());
        let residual: Vec<f64> = outputs.iter().zip(&self.guess).map(|(q, p)| q - p).collect();
        self.acceleration.begin_step();
        self.acceleration.accelerate(&mut self.guess, &residual);
        let time = 1e-3 * step as f64;
        let interval = Interval::new(step, time, 1e-3);
        let exchange = Exchange {
            unit: UnitId(0),
            occasion: Occasion { step, iteration: 1, attempt: 1, time, communication_step: 1e-3 },
            accepted: true,
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            sent: Duration::ZERO,
            answered: Duration::ZERO,
        };
        self.log.window(&WindowReport {
            steps: vec![interval],
            attempt: 1,
            exchanges: vec![exchange],
            converged: true,
            iterates: vec![IterationReport {
                iteration: 1,
                purpose: Purpose::Solution,
                correction: self.acceleration.correction(),
                residuals: Some(residuals),
                worst: None,
            }],
            ..WindowReport::default()
        })?;
        Ok(())
    }
}

/// A process that answers over a Unix socket, header and values as over shared memory.
struct Socket {
    stream: UnixStream,
    process: Child,
}

impl Drop for Socket {
    fn drop(&mut self) {
        // It ends with its socket; it is only waited for.
        let _ = self.stream.shutdown(std::net::Shutdown::Both);
        let _ = self.process.wait();
    }
}

fn measure_socket(solve: Duration, count: usize) -> Result<Vec<Duration>, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("socket");
    let listener = UnixListener::bind(&path)?;
    let mut command = Command::new(std::env::current_exe()?);
    let process = command.arg("socket").arg(&path).arg(solve.as_micros().to_string()).spawn()?;
    let mut socket = Socket { stream: listener.accept()?.0, process };
    let (mut values, mut bytes) = (vec![0.25; VALUES], [0; BYTES]);
    let mut times = Vec::with_capacity(count);
    for step in 0..WARM_UP + count {
        values.fill(step as f64);
        let began = Instant::now();
        for (to, value) in bytes[BYTES - 8 * VALUES..].chunks_exact_mut(8).zip(&values) {
            to.copy_from_slice(&value.to_le_bytes());
        }
        socket.stream.write_all(&bytes)?;
        socket.stream.read_exact(&mut bytes)?;
        for (value, from) in values.iter_mut().zip(bytes[BYTES - 8 * VALUES..].chunks_exact(8)) {
            *value = f64::from_le_bytes(from.try_into()?);
        }
        times.push(began.elapsed());
        assert_eq!(values[VALUES - 1], step as f64);
    }
    Ok(times.split_off(WARM_UP))
}

fn serve_socket(path: &str, solving: Duration) -> Result<(), Box<dyn Error>> {
    let mut stream = UnixStream::connect(path)?;
    let mut bytes = [0; BYTES];
    while stream.read_exact(&mut bytes).is_ok() {
        solve(solving);
        stream.write_all(&bytes)?;
    }
    Ok(())
}
