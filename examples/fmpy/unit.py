"""An instance of an FMU whose variables are set and got by name, and the record that moves the ground."""

import tomllib
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

STANDARD_GRAVITY = 9.80665  # m/s²


class Unit:
    def __init__(self, path):
        """Unpacks the FMU at `path` and instantiates it."""
        self.description = read_model_description(path)
        self.folder = Path(extract(path))
        self.fmu = instantiate_fmu(self.folder, self.description)
        self.scene = tomllib.loads((self.folder / "resources" / "scene.toml").read_text())
        variables = self.description.modelVariables
        self.references = {v.name: ([v.valueReference], int(np.prod(v.shape))) for v in variables}

    def set(self, name, values):
        self.fmu.setFloat64(self.references[name][0], np.ravel(values).tolist())

    def get(self, name):
        return np.array(self.fmu.getFloat64(*self.references[name]))


def ground_acceleration(path, scene):
    """The CSV record `path`, cropped and scaled as in `scene`: acceleration (x, y), m/s², as a function of time, s."""
    record = scene["ground_motion"]["record"]
    with open(path) as file:
        rows = [line for line in file if line[0].isdigit()]
    time, acceleration = np.loadtxt(rows, delimiter=",").T
    start, end = record.get("start", 0.0), record.get("end", np.inf)
    inside = (time > start - 1e-9) & (time < end + 1e-9)
    interval, samples = time[1] - time[0], acceleration[inside]
    # After its last sample the record falls to zero within one interval.
    samples = STANDARD_GRAVITY * record["scale"] * record["polarity"] * np.append(samples, 0.0)
    times = interval * np.arange(len(samples))
    return lambda t: np.array([np.interp(t, times, samples), 0.0])
