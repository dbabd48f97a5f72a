"""What a unit is made from."""

import tomllib
from dataclasses import dataclass, field

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
