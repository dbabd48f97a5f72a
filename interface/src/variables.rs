//! The variables of both units, one item each.
//!
//! `modelDescription/reservoir.xml` and `modelDescription/dam.xml` say the same for
//! importers; a test keeps the two equal.

/// Role of a variable, as FMI 3.0 names it.
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
    /// May be read after a step, and is not exchanged: fields for pictures.
    Local,
}

/// When a variable may change, as FMI 3.0 names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Constant after initialisation.
    Fixed,
    /// Changes at communication points.
    Discrete,
    /// Changes all the time.
    Continuous,
}

/// Number of values of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One value.
    Scalar,
    /// Two values: along x, along y.
    Plane,
    /// One value a point of the wet face.
    InterfacePoints,
    /// One value a crack, from the base up.
    Cracks,
    /// One value a point where stress is watched: heel, toe, and either face of the dam at each bend of one.
    StressPoints,
    /// One value a node of the dam's mesh.
    Nodes,
    /// One value a triangle of the dam's mesh.
    Triangles,
    /// One value a contact, crack after crack.
    Contacts,
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
    /// SI unit, per metre of dam where that applies; `1` for pure numbers.
    pub unit: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    /// Of an output: value references of the inputs that it depends on.
    pub dependencies: &'static [u32],
}

macro_rules! variables {
    ($($reference:literal $item:ident $name:literal $causality:ident $variability:ident $shape:ident $unit:literal $description:literal $(<- $($input:literal)+)?;)*) => {
        $(
            #[doc = concat!($description, "; unit `", $unit, "`")]
            pub const $item: Variable = Variable {
                name: $name,
                value_reference: $reference,
                causality: Causality::$causality,
                variability: Variability::$variability,
                shape: Shape::$shape,
                unit: $unit,
                description: $description,
                dependencies: &[$($($input),+)?],
            };
        )*
        /// All variables of the unit, by value reference.
        pub const ALL: &[Variable] = &[$($item),*];
    };
}

/// Variables of the reservoir unit.
pub mod reservoir {
    use super::{Causality, Shape, Variability, Variable};

    variables! {
        1 INTERFACE_ACCELERATION "interface_acceleration" Input Continuous InterfacePoints "m/s2" "total acceleration of the wet face along n, mean over the step";
        2 GROUND_ACCELERATION "ground_acceleration" Input Continuous Plane "m/s2" "acceleration of the ground at the step's end";
        10 INTERFACE_PRESSURE "interface_pressure" Output Continuous InterfacePoints "Pa" "hydrodynamic pressure on the wet face, excess over hydrostatic" <- 1;
        11 HYDROSTATIC_PRESSURE "hydrostatic_pressure" CalculatedParameter Fixed InterfacePoints "Pa" "hydrostatic pressure on the wet face";
        12 TOTAL_FORCE "total_force" Output Continuous Scalar "N/m" "hydrodynamic force on the wet face along x" <- 1;
        13 OVERTURNING_MOMENT "overturning_moment" Output Continuous Scalar "N.m/m" "moment of the hydrodynamic pressure about the heel, positive when it turns the dam downstream" <- 1;
        14 BASE_PRESSURE "base_pressure" Output Continuous Scalar "Pa" "hydrodynamic pressure at the heel" <- 1;
        20 INTERFACE_X "interface_x" CalculatedParameter Fixed InterfacePoints "m" "x of the interface points";
        21 INTERFACE_Y "interface_y" CalculatedParameter Fixed InterfacePoints "m" "y of the interface points";
        22 INTERFACE_NORMAL_X "interface_normal_x" CalculatedParameter Fixed InterfacePoints "1" "x component of n at the interface points";
        23 INTERFACE_NORMAL_Y "interface_normal_y" CalculatedParameter Fixed InterfacePoints "1" "y component of n at the interface points";
        24 INTERFACE_LENGTH "interface_length" CalculatedParameter Fixed InterfacePoints "m" "tributary length of the interface points";
        30 WATER_DEPTH "water_depth" CalculatedParameter Fixed Scalar "m" "depth of the water at the heel";
        31 WATER_DENSITY "water_density" Parameter Fixed Scalar "kg/m3" "density of the water";
        32 SOUND_SPEED "sound_speed" Parameter Fixed Scalar "m/s" "speed of sound in the water";
        33 WAVE_REFLECTION_COEFFICIENT "wave_reflection_coefficient" Parameter Fixed Scalar "1" "share of a pressure wave's amplitude that the bed reflects at normal incidence";
        34 GRAVITY "gravity" Parameter Fixed Scalar "m/s2" "gravitational acceleration";
        35 FIDELITY "fidelity" CalculatedParameter Fixed Scalar "1" "model of the water: 1 Westergaard's parabola, 2 incompressible, 3 compressible, 4 Westergaard's series";
        36 ELEMENT_SIZE "element_size" Parameter Fixed Scalar "m" "largest length of a boundary element";
        37 FAR_END_DISTANCE "far_end_distance" Parameter Fixed Scalar "m" "distance of the far end from the most upstream point of the wet face";
        38 COMMUNICATION_STEP "communication_step" CalculatedParameter Fixed Scalar "s" "length of a communication step";
        39 HORIZON "horizon" Parameter Fixed Scalar "s" "longest time that can be simulated";
    }
}

/// Variables of the dam unit.
pub mod dam {
    use super::{Causality, Shape, Variability, Variable};

    variables! {
        1 INTERFACE_PRESSURE "interface_pressure" Input Continuous InterfacePoints "Pa" "hydrodynamic pressure on the wet face at the step's end";
        2 HYDROSTATIC_PRESSURE "hydrostatic_pressure" Input Discrete InterfacePoints "Pa" "hydrostatic pressure on the wet face, fixed when initialisation ends";
        3 GROUND_ACCELERATION "ground_acceleration" Input Continuous Plane "m/s2" "acceleration of the ground at the step's end";
        10 INTERFACE_DISPLACEMENT "interface_displacement" Output Continuous InterfacePoints "m" "displacement of the wet face relative to the ground along n, since time 0" <- 1 3;
        11 INTERFACE_VELOCITY "interface_velocity" Output Continuous InterfacePoints "m/s" "velocity of the wet face relative to the ground along n" <- 1 3;
        12 INTERFACE_ACCELERATION "interface_acceleration" Output Continuous InterfacePoints "m/s2" "total acceleration of the wet face along n, mean over the step" <- 1 3;
        13 CREST_DISPLACEMENT "crest_displacement" Output Continuous Plane "m" "displacement of the upstream crest corner relative to the ground, since time 0" <- 1 3;
        14 CREST_ACCELERATION "crest_acceleration" Output Continuous Plane "m/s2" "total acceleration of the upstream crest corner, mean over the step" <- 1 3;
        15 CREST_STATIC_DISPLACEMENT "crest_static_displacement" CalculatedParameter Fixed Plane "m" "displacement of the upstream crest corner under weight and hydrostatic pressure";
        20 CRACK_SLIDING "crack_sliding" Output Continuous Cracks "m" "mean slip of the block above, positive downstream, since time 0" <- 1 3;
        21 CRACK_OPENING "crack_opening" Output Continuous Cracks "m" "largest gap along the crack" <- 1 3;
        22 CRACK_ROTATION "crack_rotation" Output Continuous Cracks "rad" "rotation of the block above against the block below, positive counter-clockwise, since time 0" <- 1 3;
        23 CRACK_STICKING "crack_sticking" Output Discrete Cracks "1" "number of contacts that stick" <- 1 3;
        24 CRACK_SLIPPING "crack_slipping" Output Discrete Cracks "1" "number of contacts that slip" <- 1 3;
        25 CRACK_OPEN "crack_open" Output Discrete Cracks "1" "number of contacts that are open" <- 1 3;
        26 CRACK_ACCELERATION_BELOW "crack_acceleration_below" Output Continuous Cracks "m/s2" "total horizontal acceleration of the lower side, mean along the crack and over the step" <- 1 3;
        27 CRACK_ACCELERATION_ABOVE "crack_acceleration_above" Output Continuous Cracks "m/s2" "total horizontal acceleration of the upper side, mean along the crack and over the step" <- 1 3;
        28 CRACK_NORMAL_FORCE "crack_normal_force" Output Continuous Cracks "N/m" "force across the crack, positive in compression" <- 1 3;
        29 CRACK_SHEAR_FORCE "crack_shear_force" Output Continuous Cracks "N/m" "force along the crack on the block below, positive downstream" <- 1 3;
        30 KINETIC_ENERGY "kinetic_energy" Output Continuous Scalar "J/m" "kinetic energy relative to the ground" <- 1 3;
        31 STRAIN_ENERGY "strain_energy" Output Continuous Scalar "J/m" "strain energy since time 0" <- 1 3;
        32 CONTACT_ENERGY "contact_energy" Output Continuous Scalar "J/m" "energy in the contact springs since time 0" <- 1 3;
        33 FRICTION_WORK "friction_work" Output Continuous Scalar "J/m" "energy lost to friction since time 0" <- 1 3;
        34 DAMPING_WORK "damping_work" Output Continuous Scalar "J/m" "energy lost to damping, contact dashpots included, since time 0" <- 1 3;
        35 INPUT_WORK "input_work" Output Continuous Scalar "J/m" "work of weight, water and ground inertia since time 0" <- 1 3;
        36 ENERGY_BALANCE_ERROR "energy_balance_error" Output Continuous Scalar "J/m" "input work minus all other energies" <- 1 3;
        37 BASE_SHEAR "base_shear" Output Continuous Scalar "N/m" "horizontal force of the dam on its ground, positive downstream, mean over the step" <- 1 3;
        38 BASE_NORMAL_FORCE "base_normal_force" Output Continuous Scalar "N/m" "vertical force of the dam on its ground, positive in compression, mean over the step" <- 1 3;
        39 CRACK_SHEAR_UTILISATION "crack_shear_utilisation" Output Continuous Cracks "1" "shear force over shear strength, the inverse of the safety against sliding" <- 1 3;
        40 INTERFACE_X "interface_x" CalculatedParameter Fixed InterfacePoints "m" "x of the interface points";
        41 INTERFACE_Y "interface_y" CalculatedParameter Fixed InterfacePoints "m" "y of the interface points";
        42 INTERFACE_NORMAL_X "interface_normal_x" CalculatedParameter Fixed InterfacePoints "1" "x component of n at the interface points";
        43 INTERFACE_NORMAL_Y "interface_normal_y" CalculatedParameter Fixed InterfacePoints "1" "y component of n at the interface points";
        44 INTERFACE_LENGTH "interface_length" CalculatedParameter Fixed InterfacePoints "m" "tributary length of the interface points";
        45 STRESS_POINT_X "stress_point_x" CalculatedParameter Fixed StressPoints "m" "x of the points where stress is watched";
        46 STRESS_POINT_Y "stress_point_y" CalculatedParameter Fixed StressPoints "m" "y of the points where stress is watched";
        47 MAJOR_PRINCIPAL_STRESS "major_principal_stress" Output Continuous StressPoints "Pa" "larger principal stress, tension positive, that of rest included" <- 1 3;
        48 MINOR_PRINCIPAL_STRESS "minor_principal_stress" Output Continuous StressPoints "Pa" "smaller principal stress, tension positive, that of rest included" <- 1 3;
        50 YOUNG_MODULUS "young_modulus" Parameter Fixed Scalar "Pa" "elastic modulus of the concrete";
        51 POISSON_RATIO "poisson_ratio" Parameter Fixed Scalar "1" "Poisson's ratio of the concrete";
        52 DENSITY "density" Parameter Fixed Scalar "kg/m3" "density of the concrete";
        53 FRICTION_COEFFICIENT "friction_coefficient" Parameter Fixed Cracks "1" "Coulomb friction coefficient of the crack";
        54 NORMAL_STIFFNESS "normal_stiffness" Parameter Fixed Cracks "Pa/m" "normal stiffness of the crack";
        55 SHEAR_STIFFNESS "shear_stiffness" Parameter Fixed Cracks "Pa/m" "shear stiffness of the crack";
        56 DAMPING_RATIO "damping_ratio" Parameter Fixed Scalar "1" "damping ratio at the named frequencies; of local damping at all";
        57 DAMPING_FREQUENCY_LOW "damping_frequency_low" CalculatedParameter Fixed Scalar "rad/s" "lower frequency at which the damping ratio holds";
        58 DAMPING_FREQUENCY_HIGH "damping_frequency_high" CalculatedParameter Fixed Scalar "rad/s" "upper frequency at which the damping ratio holds";
        59 ELEMENT_SIZE "element_size" CalculatedParameter Fixed Scalar "m" "nominal length of an element's side";
        60 TIME_STEP_LIMIT "time_step_limit" CalculatedParameter Fixed Scalar "s" "longest stable time step, safety factor included";
        61 ADDED_MASS_INCLUDED "added_mass_included" CalculatedParameter Fixed Scalar "1" "1 if the mass matrix has the inertia of the water, beside which interface_pressure then acts, else 0";
        70 NODE_X "node_x" CalculatedParameter Fixed Nodes "m" "x of the nodes without load";
        71 NODE_Y "node_y" CalculatedParameter Fixed Nodes "m" "y of the nodes without load";
        72 TRIANGLE_NODE_1 "triangle_node_1" CalculatedParameter Fixed Triangles "1" "first node of the triangles, counted from 0";
        73 TRIANGLE_NODE_2 "triangle_node_2" CalculatedParameter Fixed Triangles "1" "second node of the triangles, counter-clockwise";
        74 TRIANGLE_NODE_3 "triangle_node_3" CalculatedParameter Fixed Triangles "1" "third node of the triangles";
        75 CONTACT_X "contact_x" CalculatedParameter Fixed Contacts "m" "x of the contacts without load";
        76 CONTACT_Y "contact_y" CalculatedParameter Fixed Contacts "m" "y of the contacts without load";
        77 NODE_DISPLACEMENT_X "node_displacement_x" Local Continuous Nodes "m" "displacement along x relative to the ground, since time 0";
        78 NODE_DISPLACEMENT_Y "node_displacement_y" Local Continuous Nodes "m" "displacement along y relative to the ground, since time 0";
        79 STRESS_XX "stress_xx" Local Continuous Triangles "Pa" "stress across x, tension positive, that of rest included";
        80 STRESS_YY "stress_yy" Local Continuous Triangles "Pa" "stress across y, tension positive, that of rest included";
        81 STRESS_XY "stress_xy" Local Continuous Triangles "Pa" "shear stress, that of rest included";
        82 CONTACT_OPENING "contact_opening" Local Continuous Contacts "m" "gap of the contacts; negative is penetration";
        83 CONTACT_SLIP "contact_slip" Local Continuous Contacts "m" "slip of the block above at the contacts, positive downstream, from where there is no load";
        84 CONTACT_NORMAL_STRESS "contact_normal_stress" Local Continuous Contacts "Pa" "normal stress of the contacts, positive in compression";
        85 CONTACT_SHEAR_STRESS "contact_shear_stress" Local Continuous Contacts "Pa" "shear stress of the contacts on the block below, positive downstream";
    }
}
