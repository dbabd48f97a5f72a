//! Statements of the paper's text on its figures. No values are digitised from its pictures.

/// Largest relative difference that still counts as agreement: the paper calls 8 and 9 % between its two models of the water
/// "reasonable agreement" (figure 12).
pub const AGREEMENT: f64 = 0.1;
/// Largest relative difference that counts as little: the paper calls 2.41 compared with 2.89 g "a little smaller" (figure 8).
pub const LITTLE: f64 = 0.2;

/// Settings that the paper leaves open for its cracked dam.
pub const OPEN: &str = "the record (not given), its direction, kind and frequencies of the damping, mesh, stiffness of the crack, places \
                        of its contacts, its elevation, plane condition, and the length of its short windows (\"e.g. 0.1 s\"), which our runs do without";

/// One of the two earthquakes of the cracked dam, and the numbers of the text.
pub struct Earthquake {
    /// As the paper calls it.
    pub name: &'static str,
    /// Folder of the scene.
    pub scene: &'static str,
    /// Option that names the user's own record.
    pub option: &'static str,
    /// Why the paper's own record is not shipped.
    pub missing: &'static str,
    /// Largest acceleration of the ground, g.
    pub ground: f64,
    /// Figure of the accelerations.
    pub of_accelerations: u8,
    /// Largest acceleration of the block below the crack, over the ground's, as the text says it.
    pub amplification: f64,
    /// Largest accelerations of the blocks below and above the crack, at its level, g.
    pub accelerations: [f64; 2],
    /// Figure of the crest's displacements.
    pub of_crest: u8,
    /// First large displacement of the crest downstream, mm, and its time, s.
    pub first_swing: [f64; 2],
    /// Residual sliding, mm: with boundary elements, with finite elements for the water.
    pub sliding: [f64; 2],
    /// Largest rotation of the block above, mrad.
    pub rotation: f64,
}

pub const EARTHQUAKES: [Earthquake; 2] = [
    Earthquake {
        name: "Koyna 1967",
        scene: "paper-koyna-1967",
        option: "--koyna-record",
        missing: "no public copy of that record is known",
        ground: 0.49,
        of_accelerations: 8,
        amplification: 5.9,
        accelerations: [2.89, 2.41],
        of_crest: 10,
        first_swing: [26.5, 4.02],
        sliding: [13.1, 12.0],
        rotation: 1.8,
    },
    Earthquake {
        name: "Newhall 1994",
        scene: "paper-newhall-1994",
        option: "--newhall-record",
        missing: "its peak is not that of the public 360° component, 0.590 g, which may not be shipped either",
        ground: 0.678,
        of_accelerations: 9,
        amplification: 5.88,
        accelerations: [4.35, 3.62],
        of_crest: 11,
        first_swing: [55.6, 4.72],
        sliding: [20.3, 18.4],
        rotation: 2.6,
    },
];

/// The rigid dam of figure 3.
pub const RIGID: &str = "rigid-dam-ramp";

/// The flexible dam of figure 4: its scene, its record, and the option that names the user's own.
pub const FLEXIBLE: [&str; 3] = ["paper-figure-4", "El Centro 1940", "--el-centro-record"];

/// A figure of the paper.
pub struct Figure {
    pub number: u8,
    /// Title.
    pub title: &'static str,
    /// Statement of the text, shortened.
    pub says: &'static str,
    /// Open settings.
    pub open: &'static str,
}

/// The figures that show results, in their order.
pub const FIGURES: [Figure; 9] = [
    Figure {
        number: 3,
        title: "pressure at the base of a rigid dam under a ramp of acceleration",
        says: "h = 180 m, rigid bed, no surface waves: constant and linear boundary elements are compared with the exact solution, \
               C_p = P/ρah; no number is stated",
        open: "the rise of the ramp, the sound speed, the number of elements",
    },
    Figure {
        number: 4,
        title: "pressure at the base of a flexible dam",
        says: "180 m high, 15 m wide, El Centro 1940, c = 1440 m/s: the present method gives good results in comparison with finite \
               elements for dam and water; no number is stated",
        open: "modulus, density and damping of the dam, strength and component of the record, the far end of the finite elements",
    },
    Figure {
        number: 7,
        title: "pressure at the base, dam rigid or flexible",
        says: "as a ratio of the hydrostatic pressure; the effect of the dam's flexibility is considerable; no number is stated",
        open: OPEN,
    },
    Figure {
        number: 8,
        title: "accelerations at the crack and at the crest, Koyna 1967",
        says: "below the crack 2.89 g, about 5.9 times the ground's (further down in the text 5.4), above it a little smaller, 2.41 g; the \
               peak at the crest is approximately the same",
        open: OPEN,
    },
    Figure {
        number: 9,
        title: "accelerations at the crack and at the crest, Newhall 1994",
        says: "below the crack 4.35 g, above it 3.62 g; amplified 5.88 times, though 4.35 g over the ground's 0.678 g are 6.42 and 3.62 g 5.34",
        open: OPEN,
    },
    Figure {
        number: 10,
        title: "displacement of the crest, Koyna 1967 (the caption says Newhall)",
        says: "the first large displacement downstream is 2.65 cm at 4.02 s",
        open: OPEN,
    },
    Figure {
        number: 11,
        title: "displacement of the crest, Newhall 1994",
        says: "the first large displacement downstream is 5.56 cm at 4.72 s",
        open: OPEN,
    },
    Figure {
        number: 12,
        title: "sliding of the block above the crack",
        says: "residual 13.1 mm (Koyna) and 20.3 mm (Newhall); with finite elements for the water 12 and 18.4 mm, a reasonable agreement; \
               the response differs significantly from that with an added mass",
        open: OPEN,
    },
    Figure {
        number: 13,
        title: "rotation of the block above the crack",
        says: "at most 0.0018 (Koyna) and 0.0026 (Newhall): the block is safe against overturning",
        open: OPEN,
    },
];
