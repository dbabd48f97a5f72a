//! Several FMUs of FMI 2.0 with their connections as an archive of the standard System Structure and Parameterization (SSP) 1.0.
//!
//! ```text
//! SystemStructure.ssd          description: components, connectors, connections, units, times
//! resources/<component>.fmu    the FMUs
//! resources/<component>.ssv    parameters of a component that has any, bound to it
//! documentation/index.html     documentation
//! ```
//!
//! **Source**: MAP System Structure and Parameterization 1.0; for the step of the master, which SSP 1.0 has no place for, the
//! annotation of the Open Simulation Platform that libcosim reads.

use super::model_description::Times;
use super::scalars::Scalar;
use super::variables::{self, number};
use super::xml::{Xml, around, document, empty, section};
use super::{FmuError, Package, archive, scalars, write_file};
use cofferdam_unit::{BaseUnits, Causality, DataType, Packable, Shape};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// The namespaces, with the prefixes that importers expect.
const NAMESPACES: [(&str, &str); 4] = [
    ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
    ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
    ("xmlns:osp", "http://opensimulationplatform.com/SSP/OSPAnnotations"),
];

/// Name of the parameter sets; importers choose one by this name, which is the customary one.
const PARAMETER_SET: &str = "initialValues";

/// What a connector is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Input,
    Output,
    /// A parameter with its value.
    Parameter,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Output => "output",
            Self::Parameter => "parameter",
        }
    }
}

/// A scalar of a component that the system shows.
struct Connector {
    name: String,
    kind: Kind,
    unit: &'static str,
    base_units: BaseUnits,
    start: Option<f64>,
}

/// An FMU in a system.
pub struct Component {
    name: &'static str,
    fmu: Vec<u8>,
    connectors: Vec<Connector>,
}

impl Component {
    /// The FMU of `package`, which must be of FMI 2.0, as the component `name`. Connectors are the inputs and outputs that are
    /// `exchanged`, all parameters, and the outputs that do not belong to points, of those that are real numbers.
    ///
    /// **Errors**: those of the package.
    pub fn new<U: Packable>(
        name: &'static str,
        package: &Package<U>,
        exchanged: &[String],
    ) -> Result<Self, FmuError> {
        let variables = variables::of::<U>(&package.contents, package.bounds)?;
        let connector = |scalar: Scalar<'_>| {
            let variable = scalar.of.variable;
            let is_exchanged = exchanged.iter().any(|name| name == variable.name);
            let few = matches!(variable.shape, Shape::Scalar | Shape::Plane | Shape::Cracks);
            let kind = match variable.causality {
                // connectors are real numbers
                _ if variable.data_type != DataType::Real => return None,
                _ if variable.is_fixed_input() => Kind::Parameter,
                Causality::Input if is_exchanged => Kind::Input,
                Causality::Parameter => Kind::Parameter,
                Causality::Output if few || is_exchanged => Kind::Output,
                _ => return None,
            };
            let (unit, base_units) = (variable.unit, variable.base_units());
            Some(Connector { name: scalar.name, kind, unit, base_units, start: scalar.start })
        };
        let connectors = scalars::of(&variables, &package.cracks).into_iter().filter_map(connector).collect();
        Ok(Self { name, fmu: package.bytes()?, connectors })
    }

    fn parameters(&self) -> impl Iterator<Item = &Connector> {
        self.connectors.iter().filter(|connector| connector.kind == Kind::Parameter)
    }

    /// Path of the parameters in the archive; none without parameters.
    fn parameter_file(&self) -> Option<String> {
        self.parameters().next().map(|_| format!("resources/{}.ssv", self.name))
    }
}

/// A connection of all values of two variables of equal size: component and name of an output, then of an input. Importers
/// need a connection to every connector that is an input.
pub type Connection = [(&'static str, String); 2];

/// A system of components.
pub struct System {
    /// Name of the system.
    pub name: String,
    /// What it is, in one line.
    pub title: String,
    /// Its components.
    pub components: Vec<Component>,
    /// Its connections.
    pub connections: Vec<Connection>,
    /// Step of the master and end of the simulation.
    pub times: Times,
    /// The text of documentation/index.html.
    pub documentation: String,
}

impl System {
    /// Writes the archive to `path`, replacing a file of that name, and returns its size in bytes. The same system gives the
    /// same bytes.
    ///
    /// **Errors**: [`FmuError::Xml`], and a file that cannot be written. No incomplete file is left behind.
    pub fn write(self, path: &Path) -> Result<u64, FmuError> {
        let mut entries = vec![("SystemStructure.ssd".to_owned(), self.description()?.into_bytes())];
        for component in &self.components {
            if let Some(file) = component.parameter_file() {
                entries.push((file, parameter_values(component)?.into_bytes()));
            }
        }
        entries.push(("documentation/index.html".to_owned(), self.documentation.into_bytes()));
        entries
            .extend(self.components.into_iter().map(|one| (format!("resources/{}.fmu", one.name), one.fmu)));
        write_file(path, &archive(&entries).map_err(FmuError::Archive)?)
    }

    fn description(&self) -> Result<String, FmuError> {
        let tool = format!("cofferdam {}", env!("CARGO_PKG_VERSION"));
        let attributes = NAMESPACES.into_iter().chain([
            ("version", "1.0"),
            ("name", &self.name),
            ("description", &self.title),
            ("generationTool", &tool),
        ]);
        document(|xml| {
            let root = xml.create_element("ssd:SystemStructureDescription").with_attributes(attributes);
            let content = root.write_inner_content(|xml| {
                let system = [("name", &*self.name), ("description", &*self.title)];
                let system = xml.create_element("ssd:System").with_attributes(system);
                system.write_inner_content(|xml| {
                    section(xml, "ssd:Elements", |xml| {
                        self.components.iter().try_for_each(|one| component(xml, one))
                    })?;
                    section(xml, "ssd:Connections", |xml| self.connections(xml))
                })?;
                let connectors = self.components.iter().flat_map(|one| &one.connectors);
                units(xml, "ssd:Units", connectors)?;
                self.experiment(xml)
            });
            content.map(drop)
        })
    }

    fn connections(&self, xml: &mut Xml) -> io::Result<()> {
        for [(source, output), (target, input)] in &self.connections {
            let names = |name: &str, of: &str| {
                let found = self.components.iter().find(|one| one.name == name).into_iter();
                let (whole, first) = (of.to_owned(), format!("{of}["));
                let values = found.flat_map(|one| one.connectors.iter().map(|connector| &connector.name));
                values.filter(move |name| **name == whole || name.starts_with(&first)).collect::<Vec<_>>()
            };
            for (output, input) in names(source, output).into_iter().zip(names(target, input)) {
                let attributes = [
                    ("startElement", *source),
                    ("startConnector", output),
                    ("endElement", *target),
                    ("endConnector", input),
                ];
                empty(xml, "ssd:Connection", &attributes)?;
            }
        }
        Ok(())
    }

    fn experiment(&self, xml: &mut Xml) -> io::Result<()> {
        let (end, step) = (number(self.times.end), number(self.times.communication_step));
        let experiment = [("startTime", "0.0"), ("stopTime", &*end)];
        let experiment = xml.create_element("ssd:DefaultExperiment").with_attributes(experiment);
        let written = experiment.write_inner_content(|xml| {
            section(xml, "ssd:Annotations", |xml| {
                let annotation = xml.create_element("ssc:Annotation");
                let annotation = annotation.with_attribute(("type", "com.opensimulationplatform"));
                let step = [("baseStepSize", &*step)];
                let inner = ("osp:FixedStepAlgorithm", step.as_slice());
                annotation.write_inner_content(|xml| around(xml, ("osp:Algorithm", &[]), inner)).map(drop)
            })
        });
        written.map(drop)
    }
}

fn component(xml: &mut Xml, of: &Component) -> io::Result<()> {
    let source = format!("resources/{}.fmu", of.name);
    let attributes = [("name", of.name), ("type", "application/x-fmu-sharedlibrary"), ("source", &*source)];
    let element = xml.create_element("ssd:Component").with_attributes(attributes);
    let written = element.write_inner_content(|xml| {
        section(xml, "ssd:Connectors", |xml| {
            of.connectors.iter().try_for_each(|Connector { name, kind, unit, .. }| {
                let attributes = [("name", &**name), ("kind", kind.word())];
                around(xml, ("ssd:Connector", &attributes), ("ssc:Real", &[("unit", unit)]))
            })
        })?;
        let Some(file) = of.parameter_file() else { return Ok(()) };
        section(xml, "ssd:ParameterBindings", |xml| {
            let binding = [("type", "application/x-ssp-parameter-set"), ("source", &*file)];
            empty(xml, "ssd:ParameterBinding", &binding)
        })
    });
    written.map(drop)
}

/// The parameters of a component as SystemStructureParameterValues, by the names of its variables.
fn parameter_values(of: &Component) -> Result<String, FmuError> {
    let namespaces = NAMESPACES.into_iter().filter(|(prefix, _)| ["xmlns:ssv", "xmlns:ssc"].contains(prefix));
    let attributes = namespaces.chain([("version", "1.0"), ("name", PARAMETER_SET)]);
    document(|xml| {
        let root = xml.create_element("ssv:ParameterSet").with_attributes(attributes);
        let content = root.write_inner_content(|xml| {
            section(xml, "ssv:Parameters", |xml| {
                of.parameters().try_for_each(|Connector { name, unit, start, .. }| {
                    let value = number(start.unwrap_or_default());
                    let real = [("value", &*value), ("unit", unit)];
                    around(xml, ("ssv:Parameter", &[("name", name)]), ("ssv:Real", &real))
                })
            })?;
            units(xml, "ssv:Units", of.parameters())
        });
        content.map(drop)
    })
}

/// The units of connectors, in the order of their names.
fn units<'a>(xml: &mut Xml, name: &str, connectors: impl Iterator<Item = &'a Connector>) -> io::Result<()> {
    let used: BTreeMap<_, _> = connectors.map(|connector| (connector.unit, connector.base_units)).collect();
    section(xml, name, |xml| {
        used.into_iter().try_for_each(|(unit, powers)| {
            let powers: Vec<_> = powers.iter().map(|(name, power)| (*name, power.to_string())).collect();
            let powers: Vec<_> = powers.iter().map(|(name, power)| (*name, &**power)).collect();
            around(xml, ("ssc:Unit", &[("name", unit)]), ("ssc:BaseUnit", &powers))
        })
    })
}
