//! Every mistake in a scene gets an error that names place, value and remedy, before any work; every doubtful choice
//! a warning. The snapshots are the catalogue of messages: each change of a shipped scene, and what is said about it.

use cofferdam_motion::RecordError;
use cofferdam_scene::{Invalid, LoadedScene, SceneWarning, Warning};
use miette::Diagnostic;
use std::collections::BTreeSet;
use whole_chain::scenario::{Scenario, binary, root};
use whole_chain::scene_text::{Desk, shipped};

/// A shipped scene and what is changed in it: text of the scene, other files, `--set`.
#[derive(Clone, Copy)]
struct Case {
    scene: &'static str,
    edits: &'static [(&'static str, &'static str)],
    file: Option<(&'static str, &'static str)>,
    set: &'static [&'static str],
}

const CRACKED: &str = "koyna-coarse";
const RAMP: &str = "rigid-dam-ramp";

const fn edit(edits: &'static [(&'static str, &'static str)]) -> Case {
    Case { scene: CRACKED, edits, file: None, set: &[] }
}

const fn ramp(edits: &'static [(&'static str, &'static str)]) -> Case {
    Case { scene: RAMP, ..edit(edits) }
}

const fn set(set: &'static [&'static str]) -> Case {
    Case { set, ..edit(&[]) }
}

const RECORD: &str = "\"../records/northridge-1994-canyon-country-270.csv\"";

const fn csv(content: &'static str) -> Case {
    Case { file: Some(("r.csv", content)), ..edit(&[(RECORD, "\"r.csv\"")]) }
}

const fn at2(content: &'static str) -> Case {
    Case { file: Some(("r.at2", content)), ..edit(&[(RECORD, "\"r.at2\"")]) }
}

const WRITING: &[Case] = &[
    edit(&[("depth = 91.75", "depth = 91,75")]),
    edit(&[("depth = 91.75", "depth = 91.75 m")]),
    edit(&[("depth = 91.75", "depth 91.75")]),
    edit(&[("[dam.material]", "[dam.material")]),
    edit(&[("upstream = [[0.0, 0.0], [0.0, 103.0]]", "upstream = [[0.0, 0.0], [0.0, 103.0]")]),
    edit(&[("sound_speed = 1440.0", "density = 1000.0")]),
    edit(&[("depth = 91.75", "\"depth\" = 91.75 m")]),
];

const KEYS: &[Case] = &[
    edit(&[("depth = 91.75", "dept = 91.75")]),
    edit(&[("poisson_ratio", "poisson")]),
    edit(&[("[dam.damping]", "[dam.dampng]")]),
    edit(&[
        ("element_size = 5.0", "element_size = 5.0\nfriction_coefficient = 1.0"),
        ("friction_coefficient = 1.0             # 45°", ""),
    ]),
    edit(&[("[coupling]", "[coupling]\nelement_size = 2.0")]),
    edit(&[("[time]", "[time]\ngravity = 9.81")]),
    edit(&[("[time]", "[time]\nfoo = 1")]),
    edit(&[
        ("[reservoir]", "[reservoir]\ntailwater_depth = 10"),
        ("[dam]", "[dam]\nfoundation_modulus = 1e10"),
    ]),
    set(&["dam.cracks.0.uplift=true", "ground_motion.vertical_scale=0.66", "reservoir.silt={depth=10}"]),
    edit(&[("depth = 91.75                          # m", "")]),
    edit(&[("title = \"Cracked Koyna dam, Northridge 1994, Canyon Country 270, coarse\"", "")]),
    ramp(&[(
        "[reservoir]\ndepth = 180.0                          # m\nsound_speed = 1440.0                   # m/s\nwave_reflection_coefficient = 1.0      # rigid bed",
        "",
    )]),
    edit(&[("depth = 91.75", "depth = \"91.75\"")]),
    edit(&[("depth = 91.75", "depth = \"91,75\"")]),
    edit(&[
        ("friction_coefficient = 1.0", "friction_angle = 45.0"),
        ("depth = 91.75", "water_level = 91.75"),
    ]),
    edit(&[("[19.25, 66.5]", "[19.25, 66.5, 0.0]")]),
    edit(&[("polarity = 1 ", "polarity = 1.0 ")]),
    edit(&[("polarity = 1 ", "polarity = 0xffffffffffffffffff ")]),
    edit(&[("tolerance = \"balanced\"", "iteration_limit = 100000000000000000000")]),
    edit(&[("tolerance = \"balanced\"", "iteration_limit = 1e300")]),
    edit(&[("\"compressible\"", "\"compresible\"")]),
    edit(&[("\"stress\"", "\"plain\"")]),
    set(&["reservoir.surface_waves=1"]),
    set(&["reservoir.method=radau"]),
    set(&["reservoir.element_order=quadratic"]),
    set(&["reservoir.bed=[-20, -3]"]),
];

const VALUES: &[Case] = &[
    set(&["report={client=\"a\\u0007\", limits={residual_sliding=-0.1, freeboard=nan}}"]),
    edit(&[("wave_reflection_coefficient = 0.9", "wave_reflection_coefficient = 1.5")]),
    edit(&[("depth = 91.75", "depth = -3")]),
    edit(&[("depth = 91.75", "depth = -1e300")]),
    edit(&[("scale = 1.0", "scale = 1e308")]),
    edit(&[("element_size = 5.0", "element_size = 0")]),
    edit(&[("depth = 91.75", "depth = 91.75\nelement_size = nan")]),
    edit(&[("depth = 91.75", "depth = 91.75\ninterface_size = 0.0")]),
    set(&["reservoir.bed_element_size=0"]),
    set(&["reservoir.corner_element_size=-1"]),
    edit(&[("friction_coefficient = 1.0", "friction_coefficient = 45.0")]),
    edit(&[("young_modulus = 31e9", "young_modulus = 31.0")]),
    edit(&[("poisson_ratio = 0.2", "poisson_ratio = 0.5")]),
    edit(&[("polarity = 1 ", "polarity = 2 ")]),
    edit(&[("tolerance = \"balanced\"", "tolerance = 0")]),
    edit(&[("tolerance = \"balanced\"", "tolerance = \"balance\"")]),
    edit(&[("tolerance = \"balanced\"", "tolerance = true")]),
    edit(&[("tolerance = \"balanced\"", "iteration_limit = 1")]),
    ramp(&[("panels = 16", "panels = -3")]),
    edit(&[("[1.0, 5.0]", "[5.0, 1.0]")]),
    set(&["dam.cracks.0.residual_friction_coefficient=1.2"]),
    set(&["snapshots.interval=0"]),
    set(&["snapshots.interval=1", "snapshots.from=2", "snapshots.until=1"]),
    set(&["dam.cracks.0.cohesion=-1", "dam.cracks.0.dilation=45"]),
];

const GEOMETRY: &[Case] = &[
    edit(&[("depth = 91.75", "depth = 110.0")]),
    edit(&[("depth = 91.75", "depth = 1e3")]),
    edit(&[("depth = 91.75", "depth = 1e-5")]),
    edit(&[("depth = 91.75", "depth = 91.75\ninterface_size = 100.0")]),
    set(&["reservoir.bed=[[-20, -3], [5, -3]]"]),
    set(&["reservoir.bed=[[-20, 91.75]]"]),
    set(&["reservoir.bed=[[0, 0], [-20, -3]]"]),
    edit(&[("elevation = 66.5", "elevation = 1e-300")]),
    edit(&[("elevation = 66.5", "elevation = 120.0")]),
    edit(&[(
        "[coupling]",
        "[[dam.cracks]]\nelevation = 66.5\nfriction_coefficient = 1.0\nnormal_stiffness = 1e11\nshear_stiffness = 1e11\n\n[coupling]",
    )]),
    edit(&[("[[70.0, 0.0], [19.25, 66.5], [14.8, 103.0]]", "[[70.0, 0.0], [-5.0, 103.0]]")]),
    edit(&[("elevation = 66.5", "polyline = [[0.0, 60.0], [15.0, 58.5]]")]),
    set(&["dam.cracks.0.polyline=[[0, 60], [30, 57]]"]),
    set(&["dam.section.galleries=[[[-1, 10], [12, 10], [12, 13]]]"]),
    set(&["dam.uplift=unchanged", "dam.cracks.0.uplift={drains={position=25, efficiency=0.5}}"]),
    set(&["dam.uplift=unchanged", "dam.cracks.0.uplift={drains={position=2.5, efficiency=67}}"]),
    set(&[
        "dam.uplift=unchanged",
        "dam.cracks.0.uplift={drains={position=2.5, efficiency=0.67, gallery_elevation=120}}",
    ]),
    set(&["dam.uplift=unchanged", "dam.cracks.0.uplift={profile=[[0, 2.5e5], [30, 0]]}"]),
    set(&["dam.uplift=unchanged", "dam.cracks.0.uplift={factor=[[1, 1], [0, 0.5]]}"]),
    set(&["dam.uplift=full"]),
    set(&["loads.silt={depth=120, submerged_density=900}"]),
    set(&["loads.silt={depth=20, submerged_density=0.9}"]),
    set(&["loads.anchors=[{head=[5, 110], end=[30, -20], force=2e6}]"]),
    set(&["loads.ice={force=146e3, elevation=120}"]),
    set(&["loads.tailwater={depth=200}"]),
    set(&["loads.anchors=[{head=[5, 103], end=[-30, 200], force=2e6}]"]),
    set(&["loads.surcharges=[{point=[nan, 90], force=[0, -1e5]}]"]),
    Case { scene: "koyna-tailwater", ..set(&["loads.tailwater={depth=20}"]) },
    Case { scene: RAMP, ..set(&["loads.tailwater={depth=5}"]) },
    set(&["stability.seismic_coefficients=[nan, -5]"]),
    set(&["stability.combinations=[{kind=\"extreme\", water_level=9999}]"]),
    edit(&[(
        "[coupling]",
        "[[dam.zones]]\nname = \"core\"\npolygon = [[90, 0], [99, 0], [99, 9]]\n\n[coupling]",
    )]),
    edit(&[(
        "[coupling]",
        "[[dam.zones]]\nname = \"core\"\npolygon = [[0, 0], [9, 9], [9, 0], [0, 9]]\n\n[coupling]",
    )]),
    edit(&[("[coupling]", "[[dam.zones]]\nname = \"core\"\npolygon = [[0, 0], [9, 9]]\n\n[coupling]")]),
    edit(&[("[[0.0, 0.0], [0.0, 103.0]]", "[[1.0, 0.0], [1.0, 103.0]]")]),
    edit(&[("[[0.0, 0.0], [0.0, 103.0]]", "[[0.0, 0.0]]")]),
    edit(&[("depth = 91.75", "depth = 66.52")]),
    edit(&[("elevation = 66.5", "elevation = 66.6")]),
    set(&["tailwater={depth=110}"]),
    set(&["tailwater={depth=1e-5}"]),
    set(&["tailwater={depth=66.52}"]),
    set(&["tailwater={depth=30, interface_size=100}"]),
    set(&["tailwater={depth=30, bed=[[-20, 30]]}"]),
];

const AMOUNT: &[Case] = &[
    edit(&[("element_size = 5.0", "element_size = 1e-4")]),
    edit(&[("element_size = 5.0", "element_size = 200.0")]),
    edit(&[("depth = 91.75", "depth = 91.75\nelement_size = 1e-6")]),
    set(&["reservoir.interface_size=1e-3"]),
    set(&["reservoir.interface_size=0.1"]),
    set(&["reservoir.bed_element_size=0.03"]),
    set(&["reservoir.bed=[[-1e6, -3]]"]),
    edit(&[("communication_step = 0.0025", "communication_step = 1e-9")]),
    edit(&[("communication_step = 0.0025", "communication_step = 0.02")]),
    edit(&[("title = \"Cracked Koyna dam,", "title = \"Cracked\\tKoyna dam,")]),
    set(&["dam.cracks.0.name=\"ne\\u0001ck\""]),
    edit(&[(
        "[coupling]",
        "[[dam.cracks]]\nname = \"66.5 m\"\nelevation = 30\nfriction_coefficient = 1\nnormal_stiffness = 1e11\nshear_stiffness = 1e11\n\n[coupling]",
    )]),
    set(&["coupling.measures=[]"]),
    set(&["coupling.measures=[\"presure\"]"]),
    set(&["time.duration=1e308"]),
    set(&["time.communication_step=1e-310"]),
    set(&["reservoir.far_end_distance=1e308"]),
    set(&["time.duration=1e-12"]),
    set(&["dam.element_size=1e-200"]),
    csv("0,0\n1e308,0\n"),
    csv("time,acceleration (g)\n0,0\n20,0.1\n40,0.2\n"),
];

const CHOICES: &[Case] = &[
    set(&["reservoir.fidelity=fmu"]),
    set(&["reservoir.fidelity=fmu", "reservoir.fmu.file=nowhere.fmu"]),
    set(&["dam.fidelity=command"]),
    set(&["dam.fidelity=command", "dam.command.argv=[]"]),
    set(&["reservoir.fidelity=log", "reservoir.log.file=nowhere"]),
    set(&["dam.fidelity=log", "dam.log.file=.", "reservoir.fidelity=log", "reservoir.log.file=."]),
    set(&[
        "reservoir.fidelity=fmu",
        "reservoir.fmu={file='.', acceleration='begin', variables={interface_pressure=1}}",
    ]),
    set(&["reservoir.fidelity=command", "reservoir.command={argv=['water'], parameters={a={b=1}, c=['x']}}"]),
    edit(&[("[coupling]", "[prescribed]\npanels = 16\n\n[coupling]")]),
    ramp(&[(
        "[prescribed]                           # a rigid dam that moves with the ground\npanels = 16",
        "",
    )]),
    edit(&[("[reservoir]", "[ground_motion.ramp]\nacceleration = 1.0\nrise = 0.1\n\n[reservoir]")]),
    edit(&[("multiples_of_first = [1.0, 5.0]        # of ω₁ of the intact empty dam", "")]),
    ramp(&[("duration = 2.0                         # s", "")]),
    Case { scene: RAMP, ..set(&["reservoir.fidelity=none"]) },
    set(&["reservoir.fidelity=incompressible", "reservoir.surface_waves=true"]),
    set(&["dam.modes=20"]),
    set(&["dam.fidelity=\"rigid\""]),
    set(&["dam.fidelity=\"rigid-blocks\"", "dam.cracks=[]"]),
    set(&["dam.fidelity=reduced", "dam.damping.model=local"]),
    set(&["dam.cracks.0.friction_coefficient=0.1"]),
    Case { scene: RAMP, ..set(&["time.longest_quiet=20"]) },
    set(&["ground_motion={ramp={acceleration=1, rise=0.1}}", "time.duration=9", "time.longest_quiet=8"]),
    set(&["time.quiet=9", "time.longest_quiet=8"]),
    edit(&[("[coupling]", "[[stop]]\nquantity = \"slip\"\nabove = -1\n\n[coupling]")]),
    ramp(&[("[prescribed]", "[snapshots]\ninterval = 1\n\n[prescribed]")]),
    ramp(&[("[prescribed]", "[[stop]]\nquantity = \"sliding\"\nabove = 1\n\n[prescribed]")]),
    set(&["tailwater={fidelity='westergaard'}"]),
    set(&["tailwater={depth=30, fidelity='none'}"]),
    set(&["tailwater={depth=30, fidelity='incompressible', surface_waves=true}"]),
    set(&["tailwater={depth=30, sound_speed=-1, fill=1}"]),
    Case { scene: RAMP, ..set(&["tailwater={depth=30}"]) },
];

const COUPLING: &[Case] = &[
    set(&["coupling.scheme=added-mass"]),
    set(&["coupling.scheme=added-mass", "reservoir.fidelity=incompressible", "reservoir.bed=[[-80, 15]]"]),
    set(&["coupling.scheme=serial-explicit", "reservoir.fidelity=incompressible"]),
    Case { scene: RAMP, ..set(&["coupling.scheme=added-mass", "reservoir.fidelity=westergaard"]) },
    set(&["coupling.scheme=added-mass", "reservoir.fidelity=westergaard", "tailwater={depth=30}"]),
    set(&["coupling.scheme=serial-explicit", "tailwater={depth=30, fidelity='westergaard'}"]),
    set(&["coupling.on_failure=halve", "reservoir.method=recursive", "tailwater={depth=30}"]),
    set(&["coupling.on_failure=halve"]),
    set(&[
        "coupling.on_failure=halve",
        "reservoir.fidelity=westergaard",
        "coupling.window=4",
        "coupling.scheme=serial-implicit",
    ]),
    set(&["coupling.on_failure=halve", "reservoir.fidelity=westergaard"]),
    set(&[
        "time.adaptive={tolerance=1e-3, shortest=1e-9, longest=0.01}",
        ADAPTIVE,
        "coupling.scheme=serial-implicit",
    ]),
    set(&["coupling.window=0"]),
    set(&["coupling.window=4", "coupling.scheme=parallel-explicit"]),
    set(&["coupling.scheme=paralel-implicit"]),
    set(&["time.adaptive={tolerance=1e-3, shortest=1e-3, longest=0.01}", "reservoir.method=radau2"]),
    set(&["time.adaptive={tolerance=1e-3, shortest=1e-3, longest=0.01}", "reservoir.fidelity=westergaard"]),
    set(&[
        "time.adaptive={tolerance=0, shortest=0.005, longest=0.1}",
        ADAPTIVE,
        "coupling.scheme=serial-implicit",
    ]),
    set(&[
        "time.adaptive={tolerance=1e-3, shortest=-1, longest=0.01}",
        ADAPTIVE,
        "coupling.scheme=aded-mass",
    ]),
    set(&[
        "time.adaptive={tolerance=1e-3, shortest=0.005, longest=0.01}",
        ADAPTIVE,
        "coupling.scheme=serial-implicit",
    ]),
];

const ADAPTIVE: &str = "reservoir.fidelity=westergaard";

const RECORDS: &[Case] = &[
    edit(&[("-270.csv", "-720.csv")]),
    edit(&[("-270.csv", "-270.txt")]),
    csv("time,acc\n0,0.1\n0.01,NaN\n"),
    csv("0,0.1\n0.01,0\n0.03,0\n"),
    csv("0,0.1\n0,0\n"),
    csv("0,0\n1e300,0\n2e301,0\n"),
    csv("0,0\n1e-300,0\n"),
    csv("0,490.0\n0.01,0\n"),
    csv("# nothing\ntime,acc\n"),
    csv("time (s),velocity (cm/s)\n0,0.1\n0.01,0\n"),
    csv("time (s)\tacc (mm/s²)\n0\t0.1\n0.01\t0\n"),
    Case { set: &["ground_motion.record.units=g"], ..csv("t [s],a [m/s2]\n0,0.1\n0.01,0\n") },
    at2("PEER\nevent\nDISPLACEMENT TIME SERIES IN UNITS OF CM\nNPTS= 2, DT= .01 SEC\n0.1 0.2\n"),
    csv("0,0.1\n0.01,0\n0.02;0\n"),
    csv("0,O.5\n0.01,0\n0.02,0\n"),
    at2("1\n2\n3\nNPTS= 3, DT= .01 SEC\n0.1 0.2\n"),
    at2("1\n2\n3\n4\n0.1 0.2\n"),
    at2("1\n2\n3\nNPTS= 2, DT= inf SEC\n0.1 0.2\n"),
    at2("1\n2\n3\nNPTS= 1e30, DT= .01 SEC\n0.1 0.2\n"),
    set(&["ground_motion.record.sha256=\"0123\""]),
    edit(&[("scale = 1.0", "start = 30.0")]),
    edit(&[("scale = 1.0", "start = 3.0\nend = 60.0")]),
    csv("t,x,y\n0,0.1,0.2\n0.01,0,0\n"),
    csv("0,05 0,1\n0,06 0,2\n"),
    Case { set: &["ground_motion.record.column=3"], ..csv("t,x,y\n0,0.1,0.2\n0.01,0,0\n") },
    Case { set: &["ground_motion.record.column=1"], ..at2("1\n2\n3\nNPTS= 2, DT= .01 SEC\n0.1 0.2\n") },
    set(&["ground_motion.vertical={scale=0.5}"]),
    set(&["ground_motion.vertical={column=2}"]),
    set(&["ground_motion.vertical={column=0, scale=0}"]),
    set(&["ground_motion.vertical={file='absent.csv', polarity=2}"]),
    Case { scene: RAMP, ..set(&["ground_motion.vertical={column=2}"]) },
    Case { scene: RAMP, ..set(&["ground_motion.ramp.vertical_acceleration=1e4"]) },
    upwards(&["ground_motion.vertical.file=up.csv", "ground_motion.vertical.sha256=\"0123\""]),
    upwards(&["ground_motion.vertical.file=up.csv", "ground_motion.record.start=0.01"]),
    upwards(&["ground_motion.vertical.file=up.csv", "ground_motion.record.start=4"]),
    upwards(&["ground_motion.vertical={file='up.csv', scale=1e5}"]),
    upwards(&["ground_motion.vertical={file='up.csv', units='m/s2', column=2}"]),
];

const SEQUENCES: &[Case] = &[
    set(&["ground_motion.sequence=[{file='absent.csv', vertical={file='absent.csv', polarity=0}}]"]),
    set(&["ground_motion.sequence=[{rest=5}]"]),
    edit(&[("[ground_motion.record]", "[[ground_motion.sequence]]")]),
    Case { scene: RAMP, ..set(&["ground_motion.sequence=[{file='absent.csv'}]"]) },
    upwards(&["ground_motion.sequence=[{file='up.csv', rest=-1}, {file='up.csv', rest=nan}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', rest=1001}, {file='up.csv', rest='10 s'}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', pause=5}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', name=' '}, {file='up.csv', name=\"a\\u0007\"}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv'}, {file='up.csv', name='shock 2'}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', name='shock 3'}, {file='up.csv'}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', polarity=2, vertical={scale=2}}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', start=4}, {file='up.csv', scale=1e5}]"]),
    upwards(&["ground_motion.sequence=[{file='up.csv', sha256='0123'}]"]),
    upwards(&[
        "ground_motion.sequence=[{file='up.csv', rest=1000}, {file='up.csv', rest=1000}, {file='up.csv', rest=1000}]",
    ]),
    Case {
        file: Some(("up.csv", "0,0\n0.995,0.1\n1.99,0\n")),
        ..upwards(&["ground_motion.sequence=[{file='up.csv'}]"])
    },
    Case {
        file: Some(("up.csv", "0,0\n0.0001,0.1\n0.0002,0\n")),
        ..upwards(&["ground_motion.sequence=[{file='up.csv', rest=1000}]"])
    },
];

/// Samples every 8 ms, with a start and an end at rest.
const fn upwards(set: &'static [&'static str]) -> Case {
    Case { set, file: Some(("up.csv", "t,a [g]\n0,0\n0.008,0.1\n0.016,-0.1\n0.024,0\n")), ..edit(&[]) }
}

const OVERRIDES: &[Case] = &[
    set(&["dam.element_size=-5"]),
    set(&["dam.\"element_size\"=-5"]),
    set(&["dam.elment_size=2.5"]),
    set(&["reservoir.fidelity=westergard"]),
    set(&["dam.cracks.0.friction_coefficient=true"]),
    set(&["dam.cracks.7.elevation=60"]),
    set(&["dam.element_size"]),
    set(&["reservoir.element_size=2", "dam.cracks.0.elevation=66.6"]),
];

const WARNINGS: &[Case] = &[
    set(&["dam.cracks.0.cohesion=1e6"]),
    set(&["dam.cracks.0.uplift={drains={position=2.5, efficiency=0.5}}"]),
    set(&["dam.fidelity=intact", "dam.cracks.0.uplift={rule=\"unchanged\"}"]),
    set(&["dam.element_size=25", "reservoir.element_size=5"]),
    edit(&[("depth = 91.75", "depth = 91.75\nelement_size = 30.0")]),
    edit(&[("communication_step = 0.0025", "communication_step = 0.01")]),
    edit(&[("communication_step = 0.0025", "communication_step = 0.003")]),
    edit(&[("scale = 1.0", "start = 4.0")]),
    edit(&[("scale = 1.0", "scale = 9.81")]),
    edit(&[("quiet = 5.0", "quiet = 1.0")]),
    edit(&[("quiet = 5.0", "duration = 10.0")]),
    edit(&[("tolerance = \"balanced\"", "tolerance = 1e-2")]),
    edit(&[("ratio = 0.05", "ratio = 0.0")]),
    edit(&[("young_modulus = 31e9", "young_modulus = 31e7"), ("element_size = 5.0", "element_size = 2.0")]),
    edit(&[("title =", "gravity = 981.0\ntitle =")]),
    edit(&[("[[0.0, 0.0], [0.0, 103.0]]", "[[0.0, 0.0], [0.0, 95.0]]")]),
    set(&[
        "dam.cracks.0.cohesion=1",
        "dam.cracks.0.friction_coefficient=3.8",
        "dam.material.tensile_strength=3000",
    ]),
    set(&["reservoir.fidelity=westergaard", "reservoir.bed=[[-20, -3]]", "reservoir.method=bdf2"]),
    set(&["reservoir.fidelity=westergaard", "reservoir.interface_size=2.0"]),
    set(&["reservoir.method=finite-elements", "reservoir.element_order=constant"]),
    set(&["reservoir.fidelity=none"]),
    set(&["reservoir.fidelity=log", "reservoir.log.file=."]),
    set(&[]),
    set(&["dam.fidelity=\"rigid-blocks\""]),
    Case { scene: RAMP, ..set(&["reservoir.element_size=1000"]) },
    upwards(&["ground_motion.vertical={file='up.csv', scale=30}"]),
    upwards(&[
        "ground_motion.vertical={file='up.csv'}",
        "ground_motion.sequence=[{file='up.csv', rest=2}, {file='up.csv', scale=30, vertical={file='up.csv'}}]",
    ]),
    set(&["tailwater={depth=80}"]),
    set(&["tailwater={depth=30, element_size=20, sound_speed=144}"]),
    set(&["tailwater={depth=30, fidelity='westergaard', method='bdf2'}"]),
    set(&[
        "reservoir.fidelity=westergaard",
        "tailwater={depth=30, fidelity='westergaard', interface_size=2}",
    ]),
];

const FIVE: &[Case] = &[edit(&[
    ("quiet = 5.0", "quiet = 5,0"),
    ("scale = 1.0", "scale = -1.0"),
    ("depth = 91.75", "dept = 91.75"),
    ("element_size = 5.0", "element_size = \"5 m\""),
    ("poisson_ratio = 0.2\n", ""),
])];

/// A triangle of 70 m on 100 m of one element, with a point at the water level.
const MSH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n1 1 \"upstream\"\n1 2 \"downstream\"\n1 3 \"base\"\n1 4 \"neck\"\n\
    $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 70 0 0\n3 0 100 0\n4 0 91.75 0\n$EndNodes\n$Elements\n7\n1 1 2 1 1 1 4\n2 1 2 1 1 4 3\n\
    3 1 2 2 2 2 3\n4 1 2 3 3 1 2\n5 1 2 4 4 4 2\n6 2 2 0 1 1 2 4\n7 2 2 0 1 2 3 4\n$EndElements\n";

const fn msh(content: &'static str, edits: &'static [(&'static str, &'static str)]) -> Case {
    Case { scene: "koyna-gmsh", file: Some(("koyna.msh", content)), ..edit(edits) }
}

const MESHES: &[Case] = &[
    msh("", &[]),
    msh("$MeshFormat\n4.1 1 8\n", &[]),
    msh("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1 1 1\n2 1 0 1\n1\n0 zero 0\n$EndNodes\n", &[]),
    msh(MSH, &[("name = \"neck\"", "name = \"throat\"")]),
    msh(
        MSH,
        &[
            ("name = \"neck\"", "name = \"neck\"\nelevation = 66.5"),
            ("uplift = \"none\"", "uplift = \"none\"\nelement_size = 5.0"),
        ],
    ),
    msh(MSH, &[("depth = 91.75", "depth = 90.0")]),
    msh(MSH, &[("file = \"koyna.msh\"", "file = \"absent.msh\"")]),
    msh(MSH, &[("file = \"koyna.msh\"", "file = \"koyna.msh\"\nsha256 = \"00\"")]),
];

const ALL: &[&[Case]] = &[
    WRITING, KEYS, VALUES, GEOMETRY, AMOUNT, CHOICES, COUPLING, RECORDS, SEQUENCES, MESHES, OVERRIDES,
    WARNINGS, FIVE,
];

impl Case {
    fn text(&self) -> String {
        self.edits.iter().fold(shipped(self.scene), |text, (old, new)| {
            assert_eq!(text.matches(old).count(), 1, "`{old}` stands once in {}", self.scene);
            text.replace(old, new)
        })
    }

    fn read(&self, desk: &Desk) -> Result<LoadedScene, cofferdam_scene::SceneError> {
        if let Some((name, content)) = self.file {
            std::fs::write(desk.file(name), content).expect("the file is written");
        }
        desk.read(self.text(), self.set)
    }

    /// What is changed, and what is said about it.
    fn shown(&self, desk: &Desk) -> String {
        let one_line = |text: &str| text.replace('\n', "⏎");
        let edits = self.edits.iter().map(|(old, new)| format!("# {} → {}\n", one_line(old), one_line(new)));
        let files = self.file.iter().map(|(name, content)| format!("# {name}: {}\n", one_line(content)));
        let sets = self.set.iter().map(|set| format!("# --set {set}\n"));
        let head: String = edits.chain(files).chain(sets).collect();
        let show = |diagnostic: &dyn Diagnostic| desk.shown(diagnostic);
        let said: Vec<String> = match self.read(desk) {
            Ok(loaded) => {
                // Said of every crack under water; shown where nothing else is said.
                let (general, own): (Vec<_>, Vec<_>) =
                    loaded.warnings.iter().partition(|w| matches!(w.warning, Warning::NoUplift { .. }));
                if own.is_empty() { general } else { own }.into_iter().map(|w| show(w)).collect()
            }
            Err(error) => error.problems.iter().map(|p| show(p)).collect(),
        };
        assert!(!said.is_empty(), "nothing is said about\n{head}");
        head + &said.join("\n")
    }
}

/// Compares what is said about the cases with the snapshot `name`.
fn compare(name: &str, cases: &[Case]) {
    let desk = Desk::default();
    let shown: Vec<String> = cases.iter().map(|case| case.shown(&desk)).collect();
    let mut settings = insta::Settings::clone_current();
    settings.set_omit_expression(true);
    settings.set_prepend_module_to_snapshot(false);
    settings.bind(|| insta::assert_snapshot!(name, shown.join("\n")));
}

#[test]
fn what_is_no_toml() {
    compare("writing", WRITING);
}

#[test]
fn keys_and_types() {
    compare("keys", KEYS);
}

#[test]
fn values_out_of_range() {
    compare("values", VALUES);
}

#[test]
fn geometry_that_makes_no_dam() {
    compare("geometry", GEOMETRY);
}

#[test]
fn more_than_can_be_computed() {
    compare("amount", AMOUNT);
}

#[test]
fn none_or_both_of_two() {
    compare("choices", CHOICES);
}

#[test]
fn couplings_that_cannot_be() {
    compare("coupling", COUPLING);
}

#[test]
fn records_that_cannot_be_used() {
    compare("records", RECORDS);
}

#[test]
fn sequences_that_cannot_be_joined() {
    compare("sequences", SEQUENCES);
}

#[test]
fn meshes_that_cannot_be_used() {
    compare("meshes", MESHES);
}

#[test]
fn overrides_that_are_wrong() {
    compare("overrides", OVERRIDES);
}

#[test]
fn doubtful_choices() {
    compare("warnings", WARNINGS);
}

#[test]
fn a_scene_that_is_wrong_in_five_places_shows_five_errors_with_lines() {
    compare("five", FIVE);
    let desk = Desk::default();
    let text = FIVE[0].text();
    let error = FIVE[0].read(&desk).expect_err("the scene is wrong");
    let line = |p: &cofferdam_scene::SceneProblem| {
        let offset = p.span.expect("a place").offset();
        text[..offset].matches('\n').count() + 1
    };
    let lines: Vec<usize> = error.problems.iter().map(line).collect();
    assert_eq!(lines, [6, 10, 14, 21, 28]);
}

/// The name of each variant of an enum, kept complete by the compiler.
macro_rules! variants {
    ($names:ident, $name:ident, $of:ident: $($variant:ident)*) => {
        const $names: &[&str] = &[$(stringify!($variant)),*];
        fn $name(value: &$of) -> &'static str {
            match value {
                $($of::$variant { .. } => stringify!($variant),)*
            }
        }
    };
}

variants!(INVALID, invalid, Invalid:
    Unreadable Override Syntax Misspelt Misplaced NotModelled Unknown Missing Type Word NotPositive OutOfRange
    WaterTooShallow WavesWithoutMemory EmptyTailwater NoDownstreamFace NothingToWatch NothingToShow NoModes NothingToCompute NothingButLogs NoFile NoProgram PanelTooLong TooMany NoStep NoMeasure FixedStep Window AddedMassScheme AdaptiveScheme ExplicitAtOnce NothingToHalve AdaptiveBounds
    LongestQuiet
    Unprintable SameCracks Undersampled
    ExactlyOne Polarity VerticalAlone VerticalUntold SequenceAlone EmptyName SameShocks Sequence Count Unit DurationMissing Record Mesh ReplacedByMesh);
variants!(RECORD_ERRORS, record_error, RecordError:
    Read Format Line NoAcceleration OtherUnits Columns Column NoColumns Clock NonFinite NonUniform Interval Empty Truncated Another Crop TooStrong);
variants!(DOUBTS, doubt, Warning:
    CoarseDam CoarseReservoir CoarseFace CoarseStep ClippedSamples Drift Peak LevelShock ShortRest NoResidual LooseTolerance UndampedCrack NoUplift BrittleBond UpliftWithoutEffect SlopingCrest RigidBlocks OpenLoop WithoutEffect
    PanelsOfTheReport Unusual);

#[test]
fn every_message_is_in_a_snapshot() {
    let desk = Desk::default();
    // A scene that is not there has no text to change; `a_scene_that_is_not_there` shows it.
    let mut seen = BTreeSet::from(["Unreadable"]);
    for case in ALL.iter().copied().flatten() {
        match case.read(&desk) {
            Ok(loaded) => seen.extend(loaded.warnings.iter().map(|w| doubt(&w.warning))),
            Err(error) => {
                for problem in &error.problems {
                    seen.insert(invalid(&problem.invalid));
                    if let Invalid::Record(error) = &problem.invalid {
                        seen.insert(record_error(error));
                    }
                }
            }
        }
    }
    let all: BTreeSet<&str> = [INVALID, RECORD_ERRORS, DOUBTS].concat().into_iter().collect();
    let unseen: Vec<&&str> = all.difference(&seen).collect();
    assert!(unseen.is_empty(), "no case shows {unseen:?}");
}

#[test]
fn a_scene_that_is_not_there() {
    let error =
        cofferdam_assembly::read_scene(std::path::Path::new("absent"), &[]).expect_err("no such scene");
    insta::assert_snapshot!(
        error.problems[0].to_string(),
        @"absent: No such file or directory (os error 2); give a folder with scene.toml, or a .toml file"
    );
}

#[test]
fn a_crack_at_the_water_level_and_the_shipped_scenes_are_right() {
    let desk = Desk::default();
    assert!(edit(&[("depth = 91.75", "depth = 66.5")]).read(&desk).is_ok());
    for case in [CRACKED, RAMP, "koyna-intact", "koyna-tailwater"] {
        let loaded =
            cofferdam_assembly::read_scene(&root().join("scenes").join(case), &[]).expect("a shipped scene");
        let dry = |w: &&SceneWarning| !matches!(w.warning, Warning::NoUplift { .. });
        assert_eq!(loaded.warnings.iter().find(dry).map(|w| w.to_string()), None, "{case}");
        assert!(loaded.scene.time.duration.is_some());
    }
}

#[test]
fn a_byte_order_mark_and_quoted_keys_are_no_mistakes() -> Result<(), cofferdam_scene::SceneError> {
    let desk = Desk::default();
    let text = shipped(CRACKED).replace("title =", "\u{feff}\"title\" =").replace("[dam.mat", "['dam'.\"mat");
    let text = text.replace("material]", "material\"]");
    let loaded = desk.read(text, &["dam.\"element_size\"=4", "'dam' . cracks.0.elevation = 60"])?;
    let dam = loaded.scene.dam.expect("a dam");
    assert_eq!((dam.element_size, dam.cracks[0].elevation, dam.material.density), (4.0, Some(60.0), 2640.0));
    Ok(())
}

#[test]
fn a_record_that_is_no_text() {
    let desk = Desk::default();
    std::fs::write(desk.file("r.csv"), [0xff, 0xfe, 0x30]).expect("the file is written");
    let error = desk.read(edit(&[(RECORD, "\"r.csv\"")]).text(), &[]).expect_err("the record is no text");
    let said = error.problems[0].to_string();
    assert!(
        said.ends_with("valid UTF-8; a record is a text file, named relative to the scene's folder"),
        "{said}"
    );
}

/// What the program said, without the line breaks and bars of its layout.
fn flat(said: &[u8]) -> String {
    String::from_utf8_lossy(said).replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What only the dam itself finds, when it is made or brought to rest, `check` finds as `run` does.
#[test]
fn joints_too_stiff_or_too_soft_end_with_status_4() {
    let ends = |keys: [(&str, f64); 3], words: [&str; 2]| {
        let mut scenario = Scenario::shipped(CRACKED);
        scenario.set("reservoir.fidelity", "westergaard");
        keys.into_iter().for_each(|(key, value)| _ = scenario.set(key, value));
        let mut check = std::process::Command::new(binary());
        check.arg("check").arg(scenario.write());
        for (mut command, status) in [(scenario.command("run"), 4), (check, 2)] {
            let output = command.output().expect("cofferdam runs");
            assert_eq!(output.status.code(), Some(status), "{output:?}");
            let said = flat(&output.stderr);
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        }
    };
    let stiff = ("dam.cracks.0.normal_stiffness", 1e15);
    ends(
        [stiff, ("dam.element_size", 2.0), ("time.communication_step", 0.01)],
        ["time steps", "lower the joint stiffness"],
    );
    // The thrust would move the block by hundreds of metres before friction bears.
    let soft = ("dam.cracks.0.shear_stiffness", 1e3);
    ends(
        [soft, ("dam.element_size", 20.0), ("dam.material.young_modulus", 3e12)],
        ["static start", "the cracked dam may not stand under weight and water"],
    );
}

#[test]
fn the_program_points_at_the_line_and_ends_with_status_2() {
    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("reservoir.depth", -1.0);
    let output = scenario.try_run("run");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let source = std::fs::read_to_string(scenario.folder().join("scene.toml")).expect("the scene");
    let line = source.lines().position(|l| l.starts_with("depth")).expect("a line") + 1;
    assert!(said.contains(&format!("scene.toml:{line}:")), "{said}");
    assert!(said.contains("depth = -1.0"), "{said}");
    assert!(!scenario.folder().join("run").exists(), "a wrong scene leaves nothing behind");
}

#[test]
fn check_says_what_a_run_would_be() {
    let check = |arguments: &[&str]| {
        let mut command = std::process::Command::new(binary());
        let output =
            command.arg("check").args(arguments).current_dir(root()).output().expect("cofferdam runs");
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), flat(&output.stderr))
    };
    let (status, said, complaint) = check(&["scenes/koyna-coarse", "scenes/rigid-dam-ramp/scene.toml"]);
    // 19.98 s of record, 0.01 s in which it falls to zero, 5 s of rest.
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 12, "{said}");
    // Area of the section above 66.5 m, and 25.25 m of water there.
    let (weight, thrust) = (36.5 * (19.25 + 14.8) / 2.0 * 2640.0, 1000.0 * 25.25f64.powi(2) / 2.0);
    for estimate in [lines[7], lines[11]] {
        assert!(estimate.starts_with("  a run takes about ") && estimate.ends_with(" MB of disk"), "{said}");
    }
    let start =
        "  factor of safety of the crack at 66.5 m before the ground moves, by limit equilibrium: sliding ";
    let safety = lines[8].strip_prefix(start);
    let sliding: f64 = safety.and_then(|text| text.split([',', ' ']).next()?.parse().ok()).expect("a number");
    assert!((sliding - weight / thrust).abs() < 0.01, "{said}");
    assert_eq!(
        [lines[0], lines[4], lines[9]],
        [
            "scenes/koyna-coarse/scene.toml can be run: 9996 communication steps of 0.0025 s, 24.99 s; 1 warning",
            "  ground: northridge-1994-canyon-country-270.csv, 19.98 s: at most 0.482 g, 0.449 m/s, 0.125 m; Arias intensity 1.974 m/s, 5 to 95 % of it within 5.56 s",
            "scenes/rigid-dam-ramp/scene.toml can be run: 800 communication steps of 0.0025 s, 2 s; 0 warnings",
        ]
    );
    // Columns: area/height/5 m, 7; rows: 13 below the crack, 5 to the water level, 2 above.
    let (mesh, limit) = (lines[2], lines[3]);
    assert!(
        mesh.starts_with("  mesh: 140 cells, 560 elements, 316 nodes, 2 blocks; smallest angle "),
        "{mesh}"
    );
    assert!(
        limit.starts_with("  time step of the dam: at most ")
            && limit.contains("set by a contact of the crack at 66.5 m at ("),
        "{limit}"
    );
    let frequencies =
        lines[5].strip_prefix("  natural frequencies of the dam, intact and empty: ").expect("a line");
    let frequencies = frequencies.strip_suffix(" rad/s").expect("a unit").split(", ");
    let frequencies: Vec<f64> = frequencies.map(|value| value.parse().expect("a number")).collect();
    // Chopra and Chakrabarti (1973), as in Abaqus' example manual: E = 31.027 GPa, ν = 0.15, 2643 kg/m³; the mesh of
    // 5 m is up to 2.5 % too stiff.
    let published =
        [18.86, 49.97, 68.16, 98.27].map(|omega: f64| omega * (31.0 / 31.027 * 2643.0 / 2640.0_f64).sqrt());
    assert_eq!(frequencies.len(), published.len());
    for (found, published) in frequencies.iter().zip(published) {
        assert!((found / published - 1.0).abs() < 0.025, "{found} against {published}");
    }
    assert!(
        status == Some(0) && complaint.matches('⚠').count() == 1 && complaint.contains("uplift"),
        "{complaint}"
    );
    let (status, said, complaint) = check(&["scenes/koyna-coarse", "--set", "time.quiet=1"]);
    assert!(
        said.contains("20.99 s; 2 warnings\n") && complaint.contains("no residual sliding"),
        "{said}{complaint}"
    );
    assert_eq!(status, Some(0));
    let (status, said, complaint) =
        check(&["scenes/koyna-intact", "scenes/rigid-dam-ramp", "--set", "dam.element_size=0"]);
    assert_eq!((status, said.as_str()), (Some(2), ""));
    assert!(complaint.contains("koyna-intact") && complaint.contains("rigid-dam-ramp"), "{complaint}");
}

/// A block whose vibration grows while it slides is named with its frequency, and with a damping that cures it.
#[test]
fn check_warns_of_a_block_that_shakes_itself() {
    let joint = [
        "reservoir.depth=37",
        "dam.section={upstream = [[0.0, 0.0], [0.0, 40.0]], downstream = [[32.0, 0.0], [5.0, 34.0], [5.0, 40.0]]}",
        "dam.material={young_modulus = 25e9, poisson_ratio = 0.2, density = 2400.0}",
        "dam.cracks.0.elevation=1",
        "dam.cracks.0.friction_coefficient=0.507",
        "dam.element_size=2.5",
    ];
    let check = |more: &[&str]| {
        let mut command = std::process::Command::new(binary());
        command.args(["check", "scenes/koyna-coarse"]).current_dir(root());
        joint.iter().chain(more).for_each(|set| _ = command.args(["--set", set]));
        let output = command.output().expect("cofferdam runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        (String::from_utf8_lossy(&output.stdout).into_owned(), flat(&output.stderr))
    };
    let (said, complaint) = check(&[]);
    let vibration = said.lines().find_map(|line| {
        line.strip_prefix("  while the block above 1 m slides downstream: vibration at ")?
            .split_once(" Hz grows by ")
    });
    let frequency: f64 = vibration.and_then(|(hertz, _)| hertz.parse().ok()).expect("a frequency");
    // in time, with water, the block shakes at 25 Hz
    assert!((24.0..28.0).contains(&frequency), "{said}");
    let cure = "the vibration would decay with dam.damping.model = \"stiffness\"";
    assert!(complaint.contains("the vibration is self-excited") && complaint.contains(cure), "{complaint}");
    let (said, complaint) = check(&["dam.damping.model=\"stiffness\""]);
    assert!(said.contains("slides downstream: vibration at") && !said.contains("grows"), "{said}");
    assert!(!complaint.contains("the vibration is self-excited"), "{complaint}");
}

#[test]
fn a_run_shows_the_warnings_and_goes_on() {
    let mut scenario = Scenario::shipped(RAMP);
    scenario.set("time.duration", 0.01).set("gravity", 1.62);
    let output = scenario.try_run("run");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("⚠ `gravity` is 1.62 m/s²; the usual range of the Earth is 9.7 to 9.9 m/s²"),
        "{said}"
    );
}

#[test]
fn an_output_folder_that_cannot_be_made_or_is_taken() {
    let scenario = Scenario::shipped(RAMP);
    std::fs::write(scenario.folder().join("file"), "").expect("a file");
    let output = scenario.try_run("file/run");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("file/run") && said.contains("choose another --output"), "{said}");

    std::fs::create_dir(scenario.folder().join("taken")).expect("a folder");
    std::fs::write(scenario.folder().join("taken/histories.csv"), "precious").expect("a file");
    let output = scenario.try_run("taken");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("is not empty"), "{said}");
}
