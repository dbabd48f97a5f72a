//! Units that are neither dams nor water: what their interfaces may be, what a log refuses, and replay by a unit with more outputs.

use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
use cofferdam_coupling::difference::{Difference, Half};
use cofferdam_coupling::observer::Status;
use cofferdam_coupling::participant::{
    Channel, Description, FunctionUnit, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{
    CouplingError, Direction, Field, Graph, Interface, Port, Predictor, Scheme, Settings, UnitId,
};
use cofferdam_coupling::simulation::Simulation;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_log::replay::replay;
use cofferdam_log::{Log, LogWriter, Preamble, compare};
use std::error::Error;
use std::path::Path;

/// A matrix: outputs y = M u, in channels of these sizes. It has no state.
struct Matrix {
    description: Description,
    rows: Vec<Vec<f64>>,
}

impl Matrix {
    fn boxed(
        name: &str,
        inputs: &[(&str, usize)],
        outputs: &[(&str, usize)],
        rows: &[&[f64]],
    ) -> Result<Box<dyn Participant>, Box<dyn Error>> {
        let channels = |variables: &[(&str, usize)]| {
            variables.iter().map(|(name, size)| Channel::new(name, "1", *size)).collect()
        };
        let description = Description::new(name, channels(inputs), channels(outputs))?;
        let rows = rows.iter().map(|row| row.to_vec()).collect();
        Ok(Box::new(Self { description, rows }))
    }
}

impl Participant for Matrix {
    fn description(&self) -> &Description {
        &self.description
    }

    fn initialise(&mut self, _: f64, _: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        outputs.fill(0.0);
        Ok(())
    }

    fn step(&mut self, _: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        for (output, row) in outputs.iter_mut().zip(&self.rows) {
            *output = 1.0 + row.iter().zip(inputs).map(|(m, u)| m * u).sum::<f64>();
        }
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }
}

fn simulation(
    units: [Box<dyn Participant>; 2],
    fields: Vec<Field>,
    measure: Measure,
    stepping: Stepping,
) -> Result<Simulation, CouplingError> {
    let interface = Interface::new(Port::of(UnitId(0)), Port::of(UnitId(1)), fields);
    let mut graph = Graph::new(units.into(), vec![interface])?;
    let measure = ConvergenceMeasure::new(&[measure], 1e-12, Scales { typical: 1.0, ..Scales::default() });
    let acceleration = Acceleration::new(AccelerationKind::IqnIls, 0.5, 1.0);
    let scheme =
        Scheme::new(&mut graph, Settings::default(), acceleration, Predictor::new(0), measure, Vec::new())?;
    Ok(Simulation::new(graph, scheme, stepping))
}

fn pump_and_pipe(pump_output: &str) -> Result<[Box<dyn Participant>; 2], Box<dyn Error>> {
    let pump =
        FunctionUnit::new("pump", &[("pressure", "Pa")], &[(pump_output, "m3/s")], 0.0, |_, _, u, y| {
            y[0] = 2.0 - u[0];
        })?;
    let pipe = FunctionUnit::new("pipe", &[("flow", "m3/s")], &[("pressure", "Pa")], 0.0, |_, _, u, y| {
        y[0] = u[0] / 2.0;
    })?;
    Ok([Box::new(pump), Box::new(pipe)])
}

fn flow_and_pressure(output: &str) -> Vec<Field> {
    vec![
        Field::new(Direction::Forward, output, "flow"),
        Field::new(Direction::Backward, "pressure", "pressure"),
    ]
}

fn logged(
    simulation: &mut Simulation,
    path: &Path,
    preamble: &Preamble,
) -> Result<Option<String>, Box<dyn Error>> {
    let mut log = LogWriter::create(path, preamble)?;
    let (_, failure) = simulation.run(&mut [&mut log], &false.into());
    Ok(failure.map(|error| error.to_string()))
}

/// x = 1 + A y over two fields of one and three values, y = 1 + B x over one of two: solved by hand as a linear system.
#[test]
fn fields_of_an_interface_have_sizes_of_their_own() -> Result<(), Box<dyn Error>> {
    let a: [&[f64]; 4] = [&[0.1, 0.2], &[0.0, 0.3], &[-0.2, 0.1], &[0.2, 0.0]];
    let b: [&[f64]; 2] = [&[0.3, 0.1, 0.0, -0.1], &[0.0, 0.2, 0.1, 0.2]];
    let first = Matrix::boxed("first", &[("back", 2)], &[("one", 1), ("three", 3)], &a)?;
    let second = Matrix::boxed("second", &[("one", 1), ("three", 3)], &[("back", 2)], &b)?;
    let fields = vec![
        Field::new(Direction::Forward, "one", "one"),
        Field::new(Direction::Forward, "three", "three"),
        Field::new(Direction::Backward, "back", "back"),
    ];
    let mut simulation = simulation([first, second], fields, Measure::Relative, Stepping::equal(1.0, 2))?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("log.mcap");
    assert_eq!(logged(&mut simulation, &path, &Preamble::default())?, None);
    // (I − B A) y = 1 + B 1.
    let product = |i: usize, j: usize| (0..4).map(|k| b[i][k] * a[k][j]).sum::<f64>();
    let right = b.map(|row| 1.0 + row.iter().sum::<f64>());
    let [[p, q], [r, s]] = [[1.0 - product(0, 0), -product(0, 1)], [-product(1, 0), 1.0 - product(1, 1)]];
    let determinant = p * s - q * r;
    let exact = [(s * right[0] - q * right[1]) / determinant, (p * right[1] - r * right[0]) / determinant];
    let mut last = None;
    for entry in Log::open(&path)?.entries()? {
        if let cofferdam_log::Entry::Exchange(exchange) = entry?
            && exchange.accepted
        {
            last = (exchange.unit == UnitId(1)).then_some(exchange.outputs).flatten().or(last);
        }
    }
    let last = last.ok_or("an answer of the second unit")?;
    assert!(last.iter().zip(exact).all(|(y, exact)| (y - exact).abs() < 1e-10), "{last:?}, {exact:?}");
    Ok(())
}

#[test]
fn a_change_of_nothing_never_converges() -> Result<(), Box<dyn Error>> {
    let refused = simulation(
        pump_and_pipe("flow")?,
        flow_and_pressure("flow"),
        Measure::Change,
        Stepping::equal(1.0, 1),
    );
    assert!(matches!(refused, Err(CouplingError::NotMonitored)));
    Ok(())
}

#[test]
fn a_log_refuses_what_it_could_not_tell() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let stepping = Stepping { window: 2, ..Stepping::equal(1.0, 4) };
    let mut windows =
        simulation(pump_and_pipe("flow")?, flow_and_pressure("flow"), Measure::Relative, stepping)?;
    let failure = logged(&mut windows, &folder.path().join("windows.mcap"), &Preamble::default())?;
    assert!(failure.is_some_and(|text| text.contains("windows of 1 steps, the run has windows of 2")));
    let mut names = simulation(
        pump_and_pipe("accepted")?,
        flow_and_pressure("accepted"),
        Measure::Relative,
        Stepping::equal(1.0, 1),
    )?;
    let failure = logged(&mut names, &folder.path().join("names.mcap"), &Preamble::default())?;
    assert!(failure.is_some_and(|text| text.contains("pump: the variable `accepted` cannot be logged")));
    Ok(())
}

/// The pump of a later version has one more output: what both have is compared, in replay and between logs.
#[test]
fn a_unit_with_more_outputs_is_compared_in_the_common_ones() -> Result<(), Box<dyn Error>> {
    let later = |slope: f64| {
        FunctionUnit::new(
            "pump",
            &[("pressure", "Pa")],
            &[("power", "W"), ("flow", "m3/s")],
            0.0,
            move |_, _, u, y| {
                y[1] = 2.0 - slope * u[0];
                y[0] = u[0] * y[1];
            },
        )
    };
    let folder = tempfile::tempdir()?;
    let paths = ["earlier.mcap", "later.mcap"].map(|name| folder.path().join(name));
    let [pump, pipe] = pump_and_pipe("flow")?;
    let stepping = Stepping::equal(1.0, 3);
    let mut run = simulation([pump, pipe], flow_and_pressure("flow"), Measure::Relative, stepping)?;
    assert_eq!(logged(&mut run, &paths[0], &Preamble::default())?, None);
    let [_, pipe] = pump_and_pipe("flow")?;
    let mut run =
        simulation([Box::new(later(1.0)?), pipe], flow_and_pressure("flow"), Measure::Relative, stepping)?;
    assert_eq!(logged(&mut run, &paths[1], &Preamble::default())?, None);
    let logs = [Log::open(&paths[0])?, Log::open(&paths[1])?];

    let replayed = replay(&logs[0], UnitId(0), &mut later(1.0)?, |_| ())?;
    assert!(replayed.divergence.is_none() && replayed.identical > 3, "{replayed:?}");
    assert_eq!(replayed.uncompared, [Vec::new(), vec!["power".to_owned()]]);
    let replayed = replay(&logs[0], UnitId(0), &mut later(1.5)?, |_| ())?;
    let what = replayed.divergence.ok_or("another pump")?.what;
    assert!(matches!(what, Difference::Value { half: Half::Answer, variable, .. } if variable == "flow"));

    let comparison = compare([&logs[0], &logs[1]])?;
    assert!(comparison.identical(), "{comparison:?}");
    assert!(comparison.settings.iter().any(|setting| setting.key.contains("power")));
    assert_eq!(comparison.endings, [Some(Status::Completed.to_string()), Some("completed".to_owned())]);
    Ok(())
}
