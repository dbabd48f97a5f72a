"""An instance of an FMU whose variables are set and read by name, and the record of ground motion."""

import tempfile
import tomllib
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

STANDARD_GRAVITY = 9.80665  # m/s²


class Unit:
    def __init__(self, path, **arguments):
        """Instantiates the FMU at `path` (an archive or an unpacked folder); `arguments` go to instantiate_fmu."""
        # FMPy changes the working directory while it loads the library.
        self.description, folder = read_model_description(path), Path(path).absolute()
        if not Path(path).is_dir():
            self.unpacked = tempfile.TemporaryDirectory()
            folder = extract(path, unzipdir=self.unpacked.name)
        self.fmu = instantiate_fmu(folder, self.description, **arguments)
        self.scene = tomllib.loads((Path(folder) / "resources" / "scene.toml").read_text())
        variables = self.description.modelVariables
        self.references = {v.name: ([v.valueReference], int(np.prod(v.shape))) for v in variables}
        self.types = {v.name: v.type for v in variables}

    def set(self, name, values):
        setter = getattr(self.fmu, f"set{self.types[name]}")
        setter(self.references[name][0], np.ravel(values).tolist())

    def get(self, name):
        getter = getattr(self.fmu, f"get{self.types[name]}")
        return np.array(getter(*self.references[name]))


def refuse_strangers(dam, reservoir):
    """Refuses a dam and a reservoir that do not belong together."""
    if dam.get("added_mass_included")[0]:
        raise SystemExit("the dam's mass contains the water already, which would count twice: pack it without --added-mass")
    for name in ("x", "y", "normal_x", "normal_y"):
        of_dam, of_water = (unit.get(f"interface_{name}") for unit in (dam, reservoir))
        if of_dam.shape != of_water.shape or np.abs(of_dam - of_water).max() > 1e-9:
            raise SystemExit(f"the wet faces differ in interface_{name}: pack both units from the same scene")


def ground_acceleration(path, scene):
    """The CSV record `path`, cropped and scaled as in `scene`: acceleration (x, y), m/s², as a function of time, s."""
    record = scene["ground_motion"].get("record", {"file": "none"})
    if Path(path).name != record["file"]:
        raise SystemExit(f"{path} is not the scene's record, {record['file']}: pack a scene that has it")
    time, acceleration = np.loadtxt(path, delimiter=",", comments=["#", "time"], unpack=True)
    time = time - time[0]
    inside = (time > record.get("start", 0.0) - 1e-9) & (time < record.get("end", np.inf) + 1e-9)
    # After the last sample the record falls to zero within one interval.
    samples = STANDARD_GRAVITY * record["scale"] * record["polarity"] * np.append(acceleration[inside], 0.0)
    times = time[1] * np.arange(len(samples))
    return lambda t: np.array([np.interp(t, times, samples), 0.0])
