//! What the READMEs say of each unit.

/// What a README says of a unit.
pub struct Text {
    /// Name of the source file, the library and the FMU.
    pub name: &'static str,
    /// What it is, as a heading begins.
    pub title: &'static str,
    /// What it computes as it is written.
    pub model: &'static str,
    /// Signs and times of its variables.
    pub signs: &'static str,
    /// A test of the FMU in Python.
    pub try_fmu: &'static str,
    /// A test of the Python class.
    pub try_python: &'static str,
    /// The FMU in a scene.
    pub fmu_in_scene: &'static str,
    /// The process in a scene.
    pub command_in_scene: &'static str,
}

pub const WATER: Text = Text {
    name: "water",
    title: "A reservoir",
    model: "As it is written it is Westergaard's water: p = −A a with A = 7/8 ρ √(h (h − y)), without memory.",
    signs: r#"- Pressure is the excess over hydrostatic, p > 0 in compression, at the end of the step.
- Acceleration is total (that of the ground is in it) and along n: a face that moves into the water, a < 0, gives p > 0.
- The acceleration of a step means what `acceleration` in the scene says. `"end"`: its value at the end of the step; water without
  memory answers p = −A a. `"mean"`: its mean ā_n over the step; then p = −A (1.5 ā_n − 0.5 ā_{n−1}) with equal steps, because
  p = −A ā_n would be half a step late."#,
    try_fmu: r#"from fmpy import read_model_description, simulate_fmu

(points,) = [v.shape[0] for v in read_model_description("water.fmu").modelVariables if v.name == "interface_y"]
inwards = {"interface_acceleration": [-1.0] * points}  # the face moves into the water: pressure, not suction
result = simulate_fmu("water.fmu", start_values=inwards, output=["interface_pressure"])
print(result["interface_pressure"][-1])
"#,
    try_python: r#"import json, subprocess
from types import SimpleNamespace

import numpy as np

from water import Water

said = subprocess.run(["cofferdam", "points", "SCENE", "--format", "json"], check=True, capture_output=True).stdout
task = json.loads(said, object_hook=lambda members: SimpleNamespace(**members))
task.acceleration, task.parameters = "end", {}
water = Water(task)
inwards = np.full(len(task.points.y), -1.0)  # the face moves into the water: pressure, not suction
print(water.step(0.0, task.communication_step, inwards, np.zeros(2)))
"#,
    fmu_in_scene: r#"[reservoir]
fidelity = "fmu"

[reservoir.fmu]
file = "water.fmu"
acceleration = "end"  # what the input means: as in water.c
"#,
    command_in_scene: r#"[reservoir]
fidelity = "command"

[reservoir.command]
argv = ["python3", "water.py"]
acceleration = "end"  # what `acceleration` of a step means: "mean" or "end"
"#,
};

pub const DAM: Text = Text {
    name: "dam",
    title: "A dam",
    model: "As it is written it is an oscillator of one degree of freedom: the face sways along x as one body, \
            m (a + a_ground) + c v + k u = force.\nMass, stiffness and damping ratio are parameters. Their first values are those of \
            a triangle of concrete, 0.8 of the depth wide, with a\nperiod of depth / 400 m/s: take your own.",
    signs: "\
- Pressure is the excess over hydrostatic, p > 0 in compression, at the end of the step; its force on the dam is p n. Hydrostatic
  pressure is fixed when the run begins: the dam starts at rest under it.
- Displacement and velocity are along n, relative to the ground, since the start, at the end of the step.
- Acceleration is total (that of the ground is in it) and along n, mean over the step: (v(t + H) − v(t)) / H and the ground's mean.
- The ground's acceleration is along x and y, at the end of the step.",
    try_fmu: r#"from fmpy import simulate_fmu

shaken = {"ground_acceleration": [1.0, 0.0]}  # a step of the ground: the dam lags behind, upstream
result = simulate_fmu("dam.fmu", start_values=shaken, output=["crest_displacement"])
print(result["crest_displacement"][:, 0].min(), result["crest_displacement"][-1, 0])
"#,
    try_python: r#"import json, subprocess
from types import SimpleNamespace

import numpy as np

from dam import Dam

said = subprocess.run(["cofferdam", "points", "SCENE", "--format", "json"], check=True, capture_output=True).stdout
task = json.loads(said, object_hook=lambda members: SimpleNamespace(**members))
task.acceleration, task.parameters = "mean", {}
dam, still, shaken = Dam(task), np.zeros(len(task.points.y)), np.array([1.0, 0.0])
for n in range(200):  # a step of the ground: the dam lags behind, upstream
    h = task.communication_step
    displacement, velocity, acceleration = dam.step(n * h, h, still, still, shaken)
print(displacement)
"#,
    fmu_in_scene: r#"[dam]
fidelity = "fmu"  # section and element_size stay: they say where the points of the wet face are

[dam.fmu]
file = "dam.fmu"
acceleration = "mean"  # what the output means: as in dam.c
parameters = { damping_ratio = 0.05 }
"#,
    command_in_scene: r#"[dam]
fidelity = "command"  # section and element_size stay: they say where the points of the wet face are

[dam.command]
argv = ["python3", "dam.py"]
acceleration = "mean"  # what the `acceleration` of `step` means
parameters = { damping_ratio = 0.05 }
"#,
};
