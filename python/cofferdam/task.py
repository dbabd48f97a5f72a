"""What a unit is made from."""

import json
import subprocess
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass(frozen=True, eq=False)
class Points:
    """The points of the wet face, from the heel up; one value a point in each array."""

    x: np.ndarray
    """Coordinate x, from the heel, positive downstream, m."""
    y: np.ndarray
    """Coordinate y, from the heel, positive upwards, m."""
    normal_x: np.ndarray
    """x component of n, the unit normal from the water into the dam."""
    normal_y: np.ndarray
    """y component of n."""
    tributary_length: np.ndarray
    """Length of the face that belongs to the point, m."""

    def __len__(self):
        return len(self.x)


@dataclass(frozen=True, eq=False)
class Task:
    """What a unit is made from; the orchestrator writes it."""

    name: str
    """Name of the unit: `reservoir`, `dam`."""
    role: str
    """`fluid` or `structure`."""
    points: Points
    depth: float
    """Depth of the water, m."""
    density: float
    """Density of the water, kg/m³."""
    gravity: float
    """Gravitational acceleration, m/s²."""
    communication_step: float
    """Length H of a communication step, s; the first one, where it may vary."""
    duration: float
    """Duration of the run, s."""
    acceleration: str
    """What a reservoir's input `acceleration` is: the `mean` over the step, or the value at its `end`."""
    parameters: dict
    """The user's own parameters."""
    threads: int = 1
    """Threads that the unit may use."""
    scene: dict = field(default_factory=dict)
    """The scene with all defaults, as its TOML file has it; files by absolute paths."""

    @classmethod
    def from_json(cls, task):
        """The task in the first line of standard input."""
        brief = dict(task["brief"])
        points = {name: np.array(values, dtype=float) for name, values in brief.pop("points").items()}
        for values in points.values():
            values.flags.writeable = False
        scene = tomllib.loads(task["scene"])
        return cls(name=task["unit"], threads=task["threads"], points=Points(**points), scene=scene, **brief)

    @classmethod
    def of_scene(cls, scene, unit="dam", program="cofferdam", **parameters):
        """The task of `unit` in the scene at the path `scene`, to use a class without a run; `program` prints its points.

        `Task.scene` is then the file as it is: keys that it leaves out are missing.

        **Errors**: `subprocess.CalledProcessError`: the scene has an error, which `program` prints on standard error.
        """
        path = Path(scene)
        file = path / "scene.toml" if path.is_dir() else path
        command = [program, "points", path, "--unit", unit, "--format", "json"]
        told = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
        read = tomllib.loads(file.read_text())
        numbers = {name: told[name] for name in ("depth", "density", "gravity", "communication_step")}
        brief = {"role": "structure" if unit == "dam" else "fluid", "points": told["points"], "duration": 0.0, "acceleration": "mean"}
        task = {"unit": unit, "threads": 1, "brief": brief | numbers | {"parameters": parameters}, "scene": ""}
        made = cls.from_json(task)
        made.scene.update(read)
        return made
