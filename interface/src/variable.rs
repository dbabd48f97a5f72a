use crate::units::{BaseUnits, base_units};

/// Role of a variable, as FMI 3.0 defines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Fixed when the unit is made; an importer of its FMU may change it before that.
    Parameter,
    /// Follows from the scene and the parameters; readable after initialisation.
    CalculatedParameter,
    /// Set by the caller before a step.
    Input,
    /// Read by the caller after a step.
    Output,
    /// Readable after a step but not exchanged between the units: fields for pictures.
    Local,
}

impl Causality {
    /// Name in FMI 3.0.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parameter => "parameter",
            Self::CalculatedParameter => "calculatedParameter",
            Self::Input => "input",
            Self::Output => "output",
            Self::Local => "local",
        }
    }
}

/// When a variable may change, as FMI 3.0 defines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Constant after initialisation.
    Fixed,
    /// Changes at communication points.
    Discrete,
    /// Changes all the time.
    Continuous,
}

impl Variability {
    /// Name in FMI 3.0.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Discrete => "discrete",
            Self::Continuous => "continuous",
        }
    }
}

/// What the values of a variable are to an importer of FMUs. Within this program all are `f64`: an integer is a whole number, a
/// Boolean is 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// A real number.
    Real,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
}

impl DataType {
    /// Name in FMI 2.0.
    pub const fn fmi2_name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
        }
    }

    /// Name in FMI 3.0.
    pub const fn fmi3_name(self) -> &'static str {
        match self {
            Self::Real => "Float64",
            Self::Integer => "Int32",
            Self::Boolean => "Boolean",
        }
    }
}

/// Number of values of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One value.
    Scalar,
    /// Two values: along x, along y.
    Plane,
    /// Four values: of the four lowest natural modes, from the lowest up.
    Modes,
    /// One value per point of the wet face.
    InterfacePoints,
    /// One value per point of the wet face of the tailwater.
    TailwaterPoints,
    /// One value per crack, from the base up.
    Cracks,
    /// One value per stress point: heel, toe, and both faces of the dam at each elevation where one of them bends.
    StressPoints,
    /// One value per node of the dam's mesh.
    Nodes,
    /// One value per triangle of the dam's mesh.
    Triangles,
    /// One value per contact, crack after crack.
    Contacts,
}

/// The number of values of a [`Shape`] where no scene fixes it: a structural parameter of FMI 3.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructuralParameter {
    /// Name in `snake_case`.
    pub name: &'static str,
    /// FMI value reference, unique within the unit.
    pub value_reference: u32,
    /// Smallest number that makes sense, the start value.
    pub least: usize,
    /// What is counted.
    pub description: &'static str,
}

/// What a shape's size is.
enum Size {
    Always(usize),
    OfScene(StructuralParameter),
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 10] = [
        Self::Scalar,
        Self::Plane,
        Self::Modes,
        Self::InterfacePoints,
        Self::TailwaterPoints,
        Self::Cracks,
        Self::StressPoints,
        Self::Nodes,
        Self::Triangles,
        Self::Contacts,
    ];

    const fn size(self) -> Size {
        let (name, value_reference, least, description) = match self {
            Self::Scalar => return Size::Always(1),
            Self::Plane => return Size::Always(2),
            Self::Modes => return Size::Always(4),
            Self::InterfacePoints => ("interface_points", 900, 2, "number of points of the wet face"),
            Self::TailwaterPoints => {
                ("tailwater_points", 906, 2, "number of points of the wet face of the tailwater")
            }
            Self::Cracks => ("cracks", 901, 1, "number of cracks"),
            Self::StressPoints => ("stress_points", 902, 2, "number of points at which stress is computed"),
            Self::Nodes => ("nodes", 903, 3, "number of nodes of the mesh"),
            Self::Triangles => ("triangles", 904, 1, "number of triangles of the mesh"),
            Self::Contacts => ("contacts", 905, 2, "number of contacts in all cracks"),
        };
        Size::OfScene(StructuralParameter { name, value_reference, least, description })
    }

    /// Whether there is one value for each part of a mesh.
    pub const fn is_of_mesh(self) -> bool {
        matches!(self, Self::Nodes | Self::Triangles | Self::Contacts)
    }

    /// The number of values, where it is the same in every scene.
    pub const fn fixed_size(self) -> Option<usize> {
        match self.size() {
            Size::Always(size) => Some(size),
            Size::OfScene(_) => None,
        }
    }

    /// The structural parameter that stands for the number of values, where that depends on the scene.
    pub const fn structural_parameter(self) -> Option<StructuralParameter> {
        match self.size() {
            Size::Always(_) => None,
            Size::OfScene(parameter) => Some(parameter),
        }
    }

    /// The number of values of the smallest unit that makes sense.
    pub const fn least_size(self) -> usize {
        match self.size() {
            Size::Always(size) => size,
            Size::OfScene(parameter) => parameter.least,
        }
    }
}

/// One variable of a unit. All values are `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Name in `snake_case`, unique within the unit.
    pub name: &'static str,
    /// FMI value reference, unique within the unit.
    pub value_reference: u32,
    /// Role.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// Number of values.
    pub shape: Shape,
    /// What the values are.
    pub data_type: DataType,
    /// SI unit, per metre of dam where that applies; `1` for pure numbers.
    pub unit: &'static str,
    /// What it is and what its sign means, in one line.
    pub description: &'static str,
    /// Of an output: value references of the inputs that it depends on.
    pub dependencies: &'static [u32],
}

impl Variable {
    /// Whether it is an input that is fixed when initialisation ends: a parameter to importers of FMUs.
    pub fn is_fixed_input(&self) -> bool {
        (self.causality, self.variability) == (Causality::Input, Variability::Discrete)
    }

    /// Name of value `index` where variables are scalars: `crest_displacement.x`, `interface_pressure[1]`, and
    /// `crack.neck.sliding` with the names of the `cracks`, `crack[1].sliding` for one without.
    pub fn value_name(&self, index: usize, cracks: &[String]) -> String {
        match self.shape {
            Shape::Scalar => self.name.to_owned(),
            Shape::Plane => format!("{}.{}", self.name, if index == 0 { "x" } else { "y" }),
            Shape::Cracks => {
                let what = self.name.strip_prefix("crack_").unwrap_or(self.name);
                match cracks.get(index).filter(|name| !name.is_empty()) {
                    Some(name) => format!("crack.{name}.{what}"),
                    None => format!("crack[{}].{what}", index + 1),
                }
            }
            _ => format!("{}[{}]", self.name, index + 1),
        }
    }

    /// Unit in which people read the variable, and its factor on the SI value; none if that is the SI unit.
    pub fn display_unit(&self) -> Option<(&'static str, f64)> {
        match self.unit {
            "Pa" if self.name.ends_with("modulus") => Some(("GPa", 1e-9)),
            "Pa" => Some(("MPa", 1e-6)),
            "N/m" => Some(("MN/m", 1e-6)),
            "m" if ["displacement", "sliding", "opening"].iter().any(|word| self.name.contains(word)) => {
                Some(("mm", 1e3))
            }
            _ => None,
        }
    }

    /// Powers of the SI base units in the variable's unit; empty for a pure number.
    pub fn base_units(&self) -> BaseUnits {
        base_units(self.unit).unwrap_or_default()
    }
}
