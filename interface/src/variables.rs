//! The variables of the units, one item each.
//!
//! `modelDescription/reservoir.xml` and `modelDescription/dam.xml` are generated from these tables: `tests/contract.rs`
//! compares them, and writes them again with `INSTA_UPDATE=always`.

/// Value reference of the independent variable, `time` (s), in both units.
pub const TIME: u32 = 0;

macro_rules! variables {
    (@type) => { DataType::Real };
    (@type $type:ident) => { DataType::$type };
    ($($reference:literal $item:ident $name:literal $causality:ident $variability:ident $shape:ident $unit:literal $description:literal $(<- $($input:literal)+)? $(as $type:ident)?;)*) => {
        $(
            #[doc = concat!($description, "; unit `", $unit, "`")]
            pub const $item: Variable = Variable {
                name: $name,
                value_reference: $reference,
                causality: Causality::$causality,
                variability: Variability::$variability,
                shape: Shape::$shape,
                data_type: variables!(@type $($type)?),
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
    use crate::{Causality, DataType, Shape, Variability, Variable};

    variables! {
        1 INTERFACE_ACCELERATION "interface_acceleration" Input Continuous InterfacePoints "m/s2" "total acceleration (relative plus ground) of the wet face along n, the unit normal from the water into the dam; mean over the step";
        2 GROUND_ACCELERATION "ground_acceleration" Input Continuous Plane "m/s2" "acceleration of the ground along x (downstream) and y (up) at the end of the step";
        10 INTERFACE_PRESSURE "interface_pressure" Output Continuous InterfacePoints "Pa" "hydrodynamic pressure on the wet face: excess over hydrostatic, positive in compression" <- 1 2;
        11 HYDROSTATIC_PRESSURE "hydrostatic_pressure" CalculatedParameter Fixed InterfacePoints "Pa" "hydrostatic pressure on the wet face, positive in compression";
        12 TOTAL_FORCE "total_force" Output Continuous Scalar "N/m" "hydrodynamic force on the wet face along x, per metre of dam, positive downstream" <- 1 2;
        13 OVERTURNING_MOMENT "overturning_moment" Output Continuous Scalar "N.m/m" "moment of the hydrodynamic pressure about the heel, per metre of dam, positive when it turns the dam downstream" <- 1 2;
        14 BASE_PRESSURE "base_pressure" Output Continuous Scalar "Pa" "hydrodynamic pressure at the heel, positive in compression; of a tailwater at the toe" <- 1 2;
        20 INTERFACE_X "interface_x" CalculatedParameter Fixed InterfacePoints "m" "x coordinate of the interface points, from the heel, positive downstream";
        21 INTERFACE_Y "interface_y" CalculatedParameter Fixed InterfacePoints "m" "y coordinate of the interface points, from the heel, positive upwards";
        22 INTERFACE_NORMAL_X "interface_normal_x" CalculatedParameter Fixed InterfacePoints "1" "x component of n, the unit normal from the water into the dam, at the interface points";
        23 INTERFACE_NORMAL_Y "interface_normal_y" CalculatedParameter Fixed InterfacePoints "1" "y component of n, the unit normal from the water into the dam, at the interface points";
        24 INTERFACE_LENGTH "interface_length" CalculatedParameter Fixed InterfacePoints "m" "tributary length of the interface points along the wet face";
        30 WATER_DEPTH "water_depth" CalculatedParameter Fixed Scalar "m" "depth of the water at the heel; of a tailwater at the toe";
        31 WATER_DENSITY "water_density" Parameter Fixed Scalar "kg/m3" "density of the water";
        32 SOUND_SPEED "sound_speed" Parameter Fixed Scalar "m/s" "speed of sound in the water";
        33 WAVE_REFLECTION_COEFFICIENT "wave_reflection_coefficient" Parameter Fixed Scalar "1" "ratio of reflected to incident pressure amplitude at the bed, at normal incidence";
        34 GRAVITY "gravity" Parameter Fixed Scalar "m/s2" "gravitational acceleration";
        35 FIDELITY "fidelity" CalculatedParameter Fixed Scalar "1" "model of the water: 1 Westergaard parabola, 2 incompressible, 3 compressible, 4 Westergaard series" as Integer;
        36 ELEMENT_SIZE "element_size" Parameter Fixed Scalar "m" "largest length of a boundary element";
        37 FAR_END_DISTANCE "far_end_distance" Parameter Fixed Scalar "m" "distance of the far end from the most upstream point of wet face and bed";
        38 COMMUNICATION_STEP "communication_step" CalculatedParameter Fixed Scalar "s" "length of a communication step for which the unit was made";
        39 HORIZON "horizon" Parameter Fixed Scalar "s" "longest time that can be simulated by convolution; a recursion and finite elements have no such limit";
        42 INPUTS_HELD "inputs_held" Parameter Fixed Scalar "1" "whether ground_acceleration has the value that is set over the whole next step, as FMI has it for inputs without derivatives; otherwise it changes linearly within the step, from its value before to the one that is set. interface_acceleration is a mean and constant within the step in any case" as Boolean;
        40 RECURSION_ERROR "recursion_error" CalculatedParameter Fixed Scalar "1" "largest relative error of the recursion against the frequency response, its loss included; 0 for another method";
        41 RECURSION_LOSS "recursion_loss" CalculatedParameter Fixed Scalar "1" "resistance that was added to the recursion so that it produces no energy, over density times speed of sound; 0 for another method";
    }
}

/// Variables of the dam unit.
pub mod dam {
    use crate::{Causality, DataType, Shape, Variability, Variable};

    variables! {
        1 INTERFACE_PRESSURE "interface_pressure" Input Continuous InterfacePoints "Pa" "hydrodynamic pressure on the wet face at the end of the step, positive in compression";
        2 HYDROSTATIC_PRESSURE "hydrostatic_pressure" Input Discrete InterfacePoints "Pa" "hydrostatic pressure on the wet face, positive in compression; fixed when initialisation ends";
        3 GROUND_ACCELERATION "ground_acceleration" Input Continuous Plane "m/s2" "acceleration of the ground along x (downstream) and y (up) at the end of the step";
        10 INTERFACE_DISPLACEMENT "interface_displacement" Output Continuous InterfacePoints "m" "displacement of the wet face relative to the ground along n, the unit normal from the water into the dam; since time 0" <- 1 3 90;
        11 INTERFACE_VELOCITY "interface_velocity" Output Continuous InterfacePoints "m/s" "velocity of the wet face relative to the ground along n, the unit normal from the water into the dam" <- 1 3 90;
        12 INTERFACE_ACCELERATION "interface_acceleration" Output Continuous InterfacePoints "m/s2" "total acceleration (relative plus ground) of the wet face along n, the unit normal from the water into the dam; mean over the step" <- 1 3 90;
        16 INTERFACE_ACCELERATION_END "interface_acceleration_end" Output Continuous InterfacePoints "m/s2" "total acceleration (relative plus ground) of the wet face along n, the unit normal from the water into the dam; at the end of the step, extrapolated from the means over this step and the one before" <- 1 3 90;
        13 CREST_DISPLACEMENT "crest_displacement" Output Continuous Plane "m" "displacement of the upstream crest corner relative to the ground along x (downstream) and y (up), since time 0" <- 1 3 90;
        14 CREST_ACCELERATION "crest_acceleration" Output Continuous Plane "m/s2" "total acceleration of the upstream crest corner along x (downstream) and y (up), mean over the step" <- 1 3 90;
        15 CREST_STATIC_DISPLACEMENT "crest_static_displacement" CalculatedParameter Fixed Plane "m" "displacement of the upstream crest corner along x (downstream) and y (up) under weight and hydrostatic pressure";
        20 CRACK_SLIDING "crack_sliding" Output Continuous Cracks "m" "mean slip of the block above the crack, positive downstream, since time 0" <- 1 3 90;
        21 CRACK_OPENING "crack_opening" Output Continuous Cracks "m" "largest gap along the crack, 0 where it is closed" <- 1 3 90;
        22 CRACK_ROTATION "crack_rotation" Output Continuous Cracks "rad" "rotation of the block above the crack relative to the block below, positive counter-clockwise, since time 0" <- 1 3 90;
        23 CRACK_STICKING "crack_sticking" Output Discrete Cracks "1" "number of sticking contacts of the crack" <- 1 3 90 as Integer;
        24 CRACK_SLIPPING "crack_slipping" Output Discrete Cracks "1" "number of slipping contacts of the crack" <- 1 3 90 as Integer;
        25 CRACK_OPEN "crack_open" Output Discrete Cracks "1" "number of open contacts of the crack" <- 1 3 90 as Integer;
        26 CRACK_ACCELERATION_BELOW "crack_acceleration_below" Output Continuous Cracks "m/s2" "total horizontal acceleration of the lower side of the crack, positive downstream, mean along the crack and over the step" <- 1 3 90;
        27 CRACK_ACCELERATION_ABOVE "crack_acceleration_above" Output Continuous Cracks "m/s2" "total horizontal acceleration of the upper side of the crack, positive downstream, mean along the crack and over the step" <- 1 3 90;
        28 CRACK_NORMAL_FORCE "crack_normal_force" Output Continuous Cracks "N/m" "force across the crack that its contacts carry, the effective normal force, per metre of dam, positive in compression" <- 1 3 90;
        29 CRACK_SHEAR_FORCE "crack_shear_force" Output Continuous Cracks "N/m" "force along the crack on the block below, per metre of dam, positive downstream" <- 1 3 90;
        30 KINETIC_ENERGY "kinetic_energy" Output Continuous Scalar "J/m" "kinetic energy relative to the ground, per metre of dam" <- 1 3 90;
        31 STRAIN_ENERGY "strain_energy" Output Continuous Scalar "J/m" "change of the strain energy since time 0, per metre of dam" <- 1 3 90;
        32 CONTACT_ENERGY "contact_energy" Output Continuous Scalar "J/m" "change of the energy in the contact springs since time 0, per metre of dam" <- 1 3 90;
        33 FRICTION_WORK "friction_work" Output Continuous Scalar "J/m" "energy dissipated by friction since time 0, per metre of dam" <- 1 3 90;
        34 DAMPING_WORK "damping_work" Output Continuous Scalar "J/m" "energy dissipated by damping since time 0, contact dashpots included, per metre of dam" <- 1 3 90;
        35 INPUT_WORK "input_work" Output Continuous Scalar "J/m" "work of weight, water pressure, uplift, static loads and ground inertia since time 0, per metre of dam" <- 1 3 90;
        36 ENERGY_BALANCE_ERROR "energy_balance_error" Output Continuous Scalar "J/m" "input work minus all other energies, per metre of dam" <- 1 3 90;
        37 BASE_SHEAR "base_shear" Output Continuous Scalar "N/m" "horizontal force of the dam on the ground, per metre of dam, positive downstream, mean over the step" <- 1 3 90;
        38 BASE_NORMAL_FORCE "base_normal_force" Output Continuous Scalar "N/m" "vertical force of the dam on the ground, per metre of dam, positive in compression, mean over the step" <- 1 3 90;
        39 CRACK_SHEAR_UTILISATION "crack_shear_utilisation" Output Continuous Cracks "1" "shear force over shear strength of the crack: the inverse of the factor of safety against sliding" <- 1 3 90;
        49 CRACK_OPEN_SHARE "crack_open_share" Output Continuous Cracks "1" "open length of the crack over its whole length, 0 to 1" <- 1 3 90;
        67 CRACK_UPLIFT_FORCE "crack_uplift_force" Output Continuous Cracks "N/m" "force of the water in the crack on the block above, normal to the crack, per metre of dam; crack_normal_force is what the contacts carry beside it" <- 1 3 90;
        68 CRACK_MOMENT "crack_moment" Output Continuous Cracks "N.m/m" "moment of the normal forces that the contacts of the crack carry about its middle, per metre of dam, positive if they press more downstream: the resultant acts at crack_moment / crack_normal_force downstream of the middle" <- 1 3 90;
        69 CRACK_BONDED_SHARE "crack_bonded_share" Output Continuous Cracks "1" "length on which the crack is bonded over its whole length, 0 to 1; a broken bond does not recover" <- 1 3 90;
        40 INTERFACE_X "interface_x" CalculatedParameter Fixed InterfacePoints "m" "x coordinate of the interface points, from the heel, positive downstream";
        41 INTERFACE_Y "interface_y" CalculatedParameter Fixed InterfacePoints "m" "y coordinate of the interface points, from the heel, positive upwards";
        42 INTERFACE_NORMAL_X "interface_normal_x" CalculatedParameter Fixed InterfacePoints "1" "x component of n, the unit normal from the water into the dam, at the interface points";
        43 INTERFACE_NORMAL_Y "interface_normal_y" CalculatedParameter Fixed InterfacePoints "1" "y component of n, the unit normal from the water into the dam, at the interface points";
        44 INTERFACE_LENGTH "interface_length" CalculatedParameter Fixed InterfacePoints "m" "tributary length of the interface points along the wet face";
        45 STRESS_POINT_X "stress_point_x" CalculatedParameter Fixed StressPoints "m" "x coordinate of the stress points, from the heel, positive downstream";
        46 STRESS_POINT_Y "stress_point_y" CalculatedParameter Fixed StressPoints "m" "y coordinate of the stress points, from the heel, positive upwards";
        47 MAJOR_PRINCIPAL_STRESS "major_principal_stress" Output Continuous StressPoints "Pa" "larger principal stress at the stress points, tension positive, static stress included" <- 1 3 90;
        48 MINOR_PRINCIPAL_STRESS "minor_principal_stress" Output Continuous StressPoints "Pa" "smaller principal stress at the stress points, tension positive, static stress included" <- 1 3 90;
        63 LARGEST_PRINCIPAL_STRESS "largest_principal_stress" Output Continuous Scalar "Pa" "largest principal stress of the whole dam, tension positive, static stress included" <- 1 3 90;
        64 SMALLEST_PRINCIPAL_STRESS "smallest_principal_stress" Output Continuous Scalar "Pa" "smallest principal stress of the whole dam, tension positive, static stress included" <- 1 3 90;
        65 LARGEST_PRINCIPAL_STRESS_PLACE "largest_principal_stress_place" Output Discrete Plane "m" "where the largest principal stress is: x and y without load, from the heel, positive downstream and upwards" <- 1 3 90;
        66 SMALLEST_PRINCIPAL_STRESS_PLACE "smallest_principal_stress_place" Output Discrete Plane "m" "where the smallest principal stress is: x and y without load, from the heel, positive downstream and upwards" <- 1 3 90;
        50 YOUNG_MODULUS "young_modulus" Parameter Fixed Scalar "Pa" "elastic modulus of the concrete";
        51 POISSON_RATIO "poisson_ratio" Parameter Fixed Scalar "1" "Poisson ratio of the concrete";
        52 DENSITY "density" Parameter Fixed Scalar "kg/m3" "density of the concrete";
        53 FRICTION_COEFFICIENT "friction_coefficient" Parameter Fixed Cracks "1" "Coulomb friction coefficient of the cracks";
        54 NORMAL_STIFFNESS "normal_stiffness" Parameter Fixed Cracks "Pa/m" "normal stiffness of the cracks";
        55 SHEAR_STIFFNESS "shear_stiffness" Parameter Fixed Cracks "Pa/m" "shear stiffness of the cracks";
        56 DAMPING_RATIO "damping_ratio" Parameter Fixed Scalar "1" "damping ratio at the two damping frequencies; with local damping, at all frequencies";
        130 INPUTS_HELD "inputs_held" Parameter Fixed Scalar "1" "whether an input has the value that is set over the whole next step, as FMI has it for inputs without derivatives; otherwise it changes linearly within the step, from its value before to the one that is set" as Boolean;
        57 DAMPING_FREQUENCY_LOW "damping_frequency_low" CalculatedParameter Fixed Scalar "rad/s" "lower frequency at which the damping ratio holds";
        58 DAMPING_FREQUENCY_HIGH "damping_frequency_high" CalculatedParameter Fixed Scalar "rad/s" "upper frequency at which the damping ratio holds";
        59 ELEMENT_SIZE "element_size" CalculatedParameter Fixed Scalar "m" "nominal side length of an element";
        60 TIME_STEP_LIMIT "time_step_limit" CalculatedParameter Fixed Scalar "s" "longest stable time step, safety factor included";
        61 ADDED_MASS_INCLUDED "added_mass_included" CalculatedParameter Fixed Scalar "1" "whether the mass matrix contains the added mass of the water, so that interface_pressure is only the rest of the pressure" as Boolean;
        62 NATURAL_FREQUENCY "natural_frequency" CalculatedParameter Fixed Modes "rad/s" "natural frequencies of the intact dam on an empty reservoir, from the lowest up";
        70 NODE_X "node_x" CalculatedParameter Fixed Nodes "m" "x coordinate of the nodes without load, from the heel, positive downstream";
        71 NODE_Y "node_y" CalculatedParameter Fixed Nodes "m" "y coordinate of the nodes without load, from the heel, positive upwards";
        72 TRIANGLE_NODE_1 "triangle_node_1" CalculatedParameter Fixed Triangles "1" "first node of the triangles, counted from 0" as Integer;
        73 TRIANGLE_NODE_2 "triangle_node_2" CalculatedParameter Fixed Triangles "1" "second node of the triangles, counted from 0, counter-clockwise" as Integer;
        74 TRIANGLE_NODE_3 "triangle_node_3" CalculatedParameter Fixed Triangles "1" "third node of the triangles, counted from 0, counter-clockwise" as Integer;
        75 CONTACT_X "contact_x" CalculatedParameter Fixed Contacts "m" "x coordinate of the contacts without load, from the heel, positive downstream";
        76 CONTACT_Y "contact_y" CalculatedParameter Fixed Contacts "m" "y coordinate of the contacts without load, from the heel, positive upwards";
        77 NODE_DISPLACEMENT_X "node_displacement_x" Local Continuous Nodes "m" "displacement of the nodes along x relative to the ground, positive downstream, since time 0";
        78 NODE_DISPLACEMENT_Y "node_displacement_y" Local Continuous Nodes "m" "displacement of the nodes along y relative to the ground, positive upwards, since time 0";
        79 STRESS_XX "stress_xx" Local Continuous Triangles "Pa" "normal stress of the triangles along x, tension positive, static stress included";
        80 STRESS_YY "stress_yy" Local Continuous Triangles "Pa" "normal stress of the triangles along y, tension positive, static stress included";
        81 STRESS_XY "stress_xy" Local Continuous Triangles "Pa" "shear stress xy of the triangles, static stress included; positive where a face with normal +x is pushed along +y";
        82 CONTACT_OPENING "contact_opening" Local Continuous Contacts "m" "gap of the contacts; negative where the sides penetrate each other";
        83 CONTACT_SLIP "contact_slip" Local Continuous Contacts "m" "slip of the block above at the contacts, positive downstream, measured from the unloaded state";
        84 CONTACT_NORMAL_STRESS "contact_normal_stress" Local Continuous Contacts "Pa" "normal stress of the contacts, positive in compression";
        85 CONTACT_SHEAR_STRESS "contact_shear_stress" Local Continuous Contacts "Pa" "shear stress of the contacts on the block below, positive downstream";
        86 TRIANGLE_ZONE "triangle_zone" CalculatedParameter Fixed Triangles "1" "zone of the triangles, counted from 1 in the order of the zones of the dam; 0 in its general material" as Integer;
        110 ENVELOPE_END "envelope_end" Local Discrete Scalar "s" "time up to which the envelopes reach, from the end of initialisation on; they are sampled there and at the end of every step";
        111 ENVELOPE_MAJOR_PRINCIPAL_STRESS "envelope_major_principal_stress" Local Discrete Nodes "Pa" "largest of the larger principal stress over time, tension positive, static stress included";
        112 ENVELOPE_MAJOR_PRINCIPAL_STRESS_TIME "envelope_major_principal_stress_time" Local Discrete Nodes "s" "when the larger principal stress was largest";
        113 ENVELOPE_MINOR_PRINCIPAL_STRESS "envelope_minor_principal_stress" Local Discrete Nodes "Pa" "smallest of the smaller principal stress over time, tension positive, static stress included";
        114 ENVELOPE_MINOR_PRINCIPAL_STRESS_TIME "envelope_minor_principal_stress_time" Local Discrete Nodes "s" "when the smaller principal stress was smallest";
        115 ENVELOPE_DISPLACEMENT_X_LEAST "envelope_displacement_x_least" Local Discrete Nodes "m" "smallest displacement along x relative to the ground, positive downstream, since time 0";
        116 ENVELOPE_DISPLACEMENT_X_MOST "envelope_displacement_x_most" Local Discrete Nodes "m" "largest displacement along x relative to the ground, positive downstream, since time 0";
        117 ENVELOPE_DISPLACEMENT_Y_LEAST "envelope_displacement_y_least" Local Discrete Nodes "m" "smallest displacement along y relative to the ground, positive upwards, since time 0";
        118 ENVELOPE_DISPLACEMENT_Y_MOST "envelope_displacement_y_most" Local Discrete Nodes "m" "largest displacement along y relative to the ground, positive upwards, since time 0";
        119 ENVELOPE_DISPLACEMENT_MAGNITUDE "envelope_displacement_magnitude" Local Discrete Nodes "m" "largest length of the displacement relative to the ground, since time 0";
        120 ENVELOPE_OVERSTRESS_DURATION "envelope_overstress_duration" Local Discrete Nodes "s" "lengths of the steps at whose ends the larger principal stress was above the tensile strength, added up";
        121 ENVELOPE_DEMAND_CAPACITY_RATIO "envelope_demand_capacity_ratio" Local Discrete Nodes "1" "largest of the larger principal stress over time, over the tensile strength; 0 where it was never tension, or there is no strength";
        122 ENVELOPE_CONTACT_OPENING "envelope_contact_opening" Local Discrete Contacts "m" "largest gap of the contacts over time; 0 where they never opened";
        123 ENVELOPE_CONTACT_SLIP_LEAST "envelope_contact_slip_least" Local Discrete Contacts "m" "smallest slip of the block above at the contacts, positive downstream, measured from the unloaded state";
        124 ENVELOPE_CONTACT_SLIP_MOST "envelope_contact_slip_most" Local Discrete Contacts "m" "largest slip of the block above at the contacts, positive downstream, measured from the unloaded state";
        90 TAILWATER_INTERFACE_PRESSURE "tailwater_interface_pressure" Input Continuous TailwaterPoints "Pa" "hydrodynamic pressure on the wet face of the tailwater at the end of the step, positive in compression";
        91 TAILWATER_HYDROSTATIC_PRESSURE "tailwater_hydrostatic_pressure" Input Discrete TailwaterPoints "Pa" "hydrostatic pressure on the wet face of the tailwater, positive in compression; fixed when initialisation ends";
        92 TAILWATER_INTERFACE_DISPLACEMENT "tailwater_interface_displacement" Output Continuous TailwaterPoints "m" "displacement of the wet face of the tailwater relative to the ground along n, the unit normal from the water into the dam; since time 0" <- 1 3 90;
        93 TAILWATER_INTERFACE_VELOCITY "tailwater_interface_velocity" Output Continuous TailwaterPoints "m/s" "velocity of the wet face of the tailwater relative to the ground along n, the unit normal from the water into the dam" <- 1 3 90;
        94 TAILWATER_INTERFACE_ACCELERATION "tailwater_interface_acceleration" Output Continuous TailwaterPoints "m/s2" "total acceleration (relative plus ground) of the wet face of the tailwater along n, the unit normal from the water into the dam; mean over the step" <- 1 3 90;
        95 TAILWATER_INTERFACE_ACCELERATION_END "tailwater_interface_acceleration_end" Output Continuous TailwaterPoints "m/s2" "total acceleration (relative plus ground) of the wet face of the tailwater along n, the unit normal from the water into the dam; at the end of the step, extrapolated from the means over this step and the one before" <- 1 3 90;
        96 TAILWATER_INTERFACE_X "tailwater_interface_x" CalculatedParameter Fixed TailwaterPoints "m" "x coordinate of the points of the tailwater, from the heel, positive downstream";
        97 TAILWATER_INTERFACE_Y "tailwater_interface_y" CalculatedParameter Fixed TailwaterPoints "m" "y coordinate of the points of the tailwater, from the heel, positive upwards";
        98 TAILWATER_INTERFACE_NORMAL_X "tailwater_interface_normal_x" CalculatedParameter Fixed TailwaterPoints "1" "x component of n, the unit normal from the water into the dam, at the points of the tailwater";
        99 TAILWATER_INTERFACE_NORMAL_Y "tailwater_interface_normal_y" CalculatedParameter Fixed TailwaterPoints "1" "y component of n, the unit normal from the water into the dam, at the points of the tailwater";
        100 TAILWATER_INTERFACE_LENGTH "tailwater_interface_length" CalculatedParameter Fixed TailwaterPoints "m" "tributary length of the points of the tailwater along the wet face of the tailwater";
    }
}

/// Variables of dam and waters as one coupled unit.
pub mod coupled {
    use crate::{Causality, DataType, Shape, Variability, Variable};

    variables! {
        1 GROUND_ACCELERATION "ground_acceleration" Input Continuous Scalar "m/s2" "horizontal acceleration of the ground at the end of the step, positive downstream; not used while use_record is true";
        2 GROUND_ACCELERATION_VERTICAL "ground_acceleration_vertical" Input Continuous Scalar "m/s2" "vertical acceleration of the ground at the end of the step, positive upwards; not used while use_record is true; only of a scene with vertical ground motion";
        13 CREST_DISPLACEMENT "crest_displacement" Output Continuous Plane "m" "displacement of the upstream crest corner relative to the ground along x (downstream) and y (up), since time 0" <- 1 2;
        14 CREST_ACCELERATION "crest_acceleration" Output Continuous Plane "m/s2" "total acceleration of the upstream crest corner along x (downstream) and y (up), mean over the step" <- 1 2;
        15 CREST_STATIC_DISPLACEMENT "crest_static_displacement" CalculatedParameter Fixed Plane "m" "displacement of the upstream crest corner along x (downstream) and y (up) under weight and hydrostatic pressure";
        20 CRACK_SLIDING "crack_sliding" Output Continuous Cracks "m" "mean slip of the block above the crack, positive downstream, since time 0" <- 1 2;
        21 CRACK_OPENING "crack_opening" Output Continuous Cracks "m" "largest gap along the crack, 0 where it is closed" <- 1 2;
        22 CRACK_ROTATION "crack_rotation" Output Continuous Cracks "rad" "rotation of the block above the crack relative to the block below, positive counter-clockwise, since time 0" <- 1 2;
        25 CRACK_OPEN "crack_open" Output Discrete Cracks "1" "number of open contacts of the crack" <- 1 2 as Integer;
        28 CRACK_NORMAL_FORCE "crack_normal_force" Output Continuous Cracks "N/m" "force across the crack, per metre of dam, positive in compression" <- 1 2;
        29 CRACK_SHEAR_FORCE "crack_shear_force" Output Continuous Cracks "N/m" "force along the crack on the block below, per metre of dam, positive downstream" <- 1 2;
        39 CRACK_SHEAR_UTILISATION "crack_shear_utilisation" Output Continuous Cracks "1" "shear force over shear strength of the crack: the inverse of the factor of safety against sliding" <- 1 2;
        49 CRACK_OPEN_SHARE "crack_open_share" Output Continuous Cracks "1" "open length of the crack over its whole length, 0 to 1" <- 1 2;
        37 BASE_SHEAR "base_shear" Output Continuous Scalar "N/m" "horizontal force of the dam on the ground, per metre of dam, positive downstream, mean over the step" <- 1 2;
        38 BASE_NORMAL_FORCE "base_normal_force" Output Continuous Scalar "N/m" "vertical force of the dam on the ground, per metre of dam, positive in compression, mean over the step" <- 1 2;
        30 KINETIC_ENERGY "kinetic_energy" Output Continuous Scalar "J/m" "kinetic energy relative to the ground, per metre of dam" <- 1 2;
        31 STRAIN_ENERGY "strain_energy" Output Continuous Scalar "J/m" "change of the strain energy since time 0, per metre of dam" <- 1 2;
        32 CONTACT_ENERGY "contact_energy" Output Continuous Scalar "J/m" "change of the energy in the contact springs since time 0, per metre of dam" <- 1 2;
        33 FRICTION_WORK "friction_work" Output Continuous Scalar "J/m" "energy dissipated by friction since time 0, per metre of dam" <- 1 2;
        34 DAMPING_WORK "damping_work" Output Continuous Scalar "J/m" "energy dissipated by damping since time 0, contact dashpots included, per metre of dam" <- 1 2;
        35 INPUT_WORK "input_work" Output Continuous Scalar "J/m" "work of weight, water pressure and ground inertia since time 0, per metre of dam" <- 1 2;
        36 ENERGY_BALANCE_ERROR "energy_balance_error" Output Continuous Scalar "J/m" "input work minus all other energies, per metre of dam" <- 1 2;
        63 LARGEST_PRINCIPAL_STRESS "largest_principal_stress" Output Continuous Scalar "Pa" "largest principal stress of the whole dam, tension positive, static stress included" <- 1 2;
        64 SMALLEST_PRINCIPAL_STRESS "smallest_principal_stress" Output Continuous Scalar "Pa" "smallest principal stress of the whole dam, tension positive, static stress included" <- 1 2;
        47 MAJOR_PRINCIPAL_STRESS "major_principal_stress" Output Continuous StressPoints "Pa" "larger principal stress at the stress points, tension positive, static stress included" <- 1 2;
        48 MINOR_PRINCIPAL_STRESS "minor_principal_stress" Output Continuous StressPoints "Pa" "smaller principal stress at the stress points, tension positive, static stress included" <- 1 2;
        210 INTERFACE_PRESSURE "interface_pressure" Output Continuous InterfacePoints "Pa" "hydrodynamic pressure on the wet face: excess over hydrostatic, positive in compression" <- 1 2;
        212 TOTAL_FORCE "total_force" Output Continuous Scalar "N/m" "hydrodynamic force on the wet face along x, per metre of dam, positive downstream" <- 1 2;
        213 OVERTURNING_MOMENT "overturning_moment" Output Continuous Scalar "N.m/m" "moment of the hydrodynamic pressure about the heel, per metre of dam, positive when it turns the dam downstream" <- 1 2;
        214 BASE_PRESSURE "base_pressure" Output Continuous Scalar "Pa" "hydrodynamic pressure at the heel, positive in compression" <- 1 2;
        310 ITERATIONS "iterations" Output Discrete Scalar "1" "dam steps of the last communication step" <- 1 2 as Integer;
        311 CONVERGED "converged" Output Discrete Scalar "1" "whether the units agree to the tolerance at the end of the last step" <- 1 2 as Boolean;
        312 RESIDUAL "residual" Output Discrete Scalar "Pa" "residual of the pressure in the last step (2-norm over the points)" <- 1 2;
        313 INTERPOLATION_ERROR "interpolation_error" Output Discrete Scalar "Pa" "estimate of the coupling error of the last step (2-norm over the points), 0 where there is none" <- 1 2;
        314 INTERFACE_WORK "interface_work" Output Continuous Scalar "J/m" "work of the water on the dam since the start, per metre of dam" <- 1 2;
        315 INTERFACE_ENERGY_PRODUCED "interface_energy_produced" Output Continuous Scalar "J/m" "energy produced by the coupling since the start, per metre of dam; negative if it was lost" <- 1 2;
        316 LOWEST_PRESSURE "lowest_pressure" Output Discrete Scalar "Pa" "lowest total pressure on the wet faces in the last step, hydrostatic included, relative to the atmosphere" <- 1 2;
        220 INTERFACE_X "interface_x" CalculatedParameter Fixed InterfacePoints "m" "x coordinate of the interface points, from the heel, positive downstream";
        221 INTERFACE_Y "interface_y" CalculatedParameter Fixed InterfacePoints "m" "y coordinate of the interface points, from the heel, positive upwards";
        230 WATER_DEPTH "water_depth" CalculatedParameter Fixed Scalar "m" "depth of the water at the heel; of a tailwater at the toe";
        238 COMMUNICATION_STEP "communication_step" CalculatedParameter Fixed Scalar "s" "length of a communication step for which the unit was made";
        45 STRESS_POINT_X "stress_point_x" CalculatedParameter Fixed StressPoints "m" "x coordinate of the stress points, from the heel, positive downstream";
        46 STRESS_POINT_Y "stress_point_y" CalculatedParameter Fixed StressPoints "m" "y coordinate of the stress points, from the heel, positive upwards";
        300 USE_RECORD "use_record" Parameter Fixed Scalar "1" "true: the ground moves as in the scene; false: as the input ground_acceleration says" as Boolean;
        301 RECORD_SCALE "record_scale" Parameter Fixed Scalar "1" "factor of the ground motion of the scene, negative for the opposite polarity; without effect while use_record is false";
        302 COUPLING_TOLERANCE "coupling_tolerance" Parameter Fixed Scalar "1" "tolerance of the iteration relative to the norm of the pressure; 0 for the balanced tolerance";
        303 INPUTS_HELD "inputs_held" Parameter Fixed Scalar "1" "whether an input has the value that is set over the whole next step, as FMI has it for inputs without derivatives; otherwise it changes linearly within the step, from its value before to the one that is set" as Boolean;
        50 YOUNG_MODULUS "young_modulus" Parameter Fixed Scalar "Pa" "elastic modulus of the concrete";
        51 POISSON_RATIO "poisson_ratio" Parameter Fixed Scalar "1" "Poisson ratio of the concrete";
        52 DENSITY "density" Parameter Fixed Scalar "kg/m3" "density of the concrete";
        53 FRICTION_COEFFICIENT "friction_coefficient" Parameter Fixed Cracks "1" "Coulomb friction coefficient of the cracks";
        54 NORMAL_STIFFNESS "normal_stiffness" Parameter Fixed Cracks "Pa/m" "normal stiffness of the cracks";
        55 SHEAR_STIFFNESS "shear_stiffness" Parameter Fixed Cracks "Pa/m" "shear stiffness of the cracks";
        56 DAMPING_RATIO "damping_ratio" Parameter Fixed Scalar "1" "damping ratio at the two damping frequencies; with local damping, at all frequencies";
        231 WATER_DENSITY "water_density" Parameter Fixed Scalar "kg/m3" "density of the water";
        232 SOUND_SPEED "sound_speed" Parameter Fixed Scalar "m/s" "speed of sound in the water";
        239 HORIZON "horizon" Parameter Fixed Scalar "s" "longest time that can be simulated by convolution; a recursion and finite elements have no such limit";
        233 WAVE_REFLECTION_COEFFICIENT "wave_reflection_coefficient" Parameter Fixed Scalar "1" "ratio of reflected to incident pressure amplitude at the bed, at normal incidence";
    }
}
