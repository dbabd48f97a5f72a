"""FMUs packed for the tests, and functions to simulate them."""

import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import extract, instantiate_fmu, read_model_description

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "examples" / "fmpy"))

from unit import Unit, ground_acceleration  # noqa: E402, F401

SCENES = ROOT / "scenes"
RECORD = SCENES / "records" / "northridge-1994-canyon-country-270.csv"
STRONG_SECOND = ["ground_motion.record.start=5", "ground_motion.record.end=6", "time.quiet=0"]
HALF_SECOND = ["ground_motion.record.start=5", "ground_motion.record.end=5.5", "time.quiet=0"]
COARSE_HALF_SECOND = ["dam.element_size=10", "reservoir.element_size=20", "reservoir.method=radau2", *HALF_SECOND]
H = 0.0025


def settings(overrides):
    return [argument for override in overrides for argument in ("--set", override)]


def pack(folder, unit, overrides=(), scene="koyna-coarse", options=()):
    """The FMU of `unit` of a shipped scene with `overrides`."""
    path = folder / f"{unit}.fmu"
    command = [os.environ["COFFERDAM"], "export-fmu", SCENES / scene, "--unit", unit, "--output", path]
    subprocess.run([*command, "--force", *options, *settings(overrides)], check=True, capture_output=True)
    return path


def initialised(path, **inputs):
    """An instance at time 0, in Step Mode."""
    unit = Unit(path)
    unit.fmu.enterInitializationMode(startTime=0.0)
    for name, values in inputs.items():
        unit.set(name, values)
    unit.fmu.exitInitializationMode()
    return unit


def load(unit, n):
    """Sets inputs for the end of step `n`: loads that vary in time and from point to point."""
    size = len(unit.get("interface_x"))
    wave = [(i + 1) / size * (-1) ** (n // 7) * (1 + n % 5) for i in range(size)]
    if "crest_displacement" in unit.references:
        unit.set("interface_pressure", [1e4 * value for value in wave])
        unit.set("ground_acceleration", [wave[0] - 2.0, 0.0])
    else:
        unit.set("interface_acceleration", wave)


def advance(unit, first, last):
    """Takes the steps from `first` up to, not including, `last`."""
    for n in range(first, last):
        load(unit, n)
        unit.fmu.doStep(n * H, H)


def start_value(variable):
    """The start value of a scalar as a number."""
    return {"false": 0.0, "true": 1.0}.get(variable.start) if variable.type == "Boolean" else float(variable.start)


def names_of(unit, **attributes):
    """Names of the variables with these attributes."""
    variables = unit.description.modelVariables
    return [v.name for v in variables if all(getattr(v, key) == value for key, value in attributes.items())]


def outputs(unit):
    """All outputs, as bits."""
    return {name: unit.get(name).tobytes() for name in names_of(unit, causality="output")}


class Scalars:
    """An instance of an FMU of scalars, of FMI 2.0 or 3.0, whose values are set and read by name."""

    def __init__(self, path, said=None, **arguments):
        """Instantiates the FMU at `path` (an archive or an unpacked folder); its messages are added to `said`."""
        self.description, folder = read_model_description(path), Path(path).absolute()
        if not folder.is_dir():
            self.unpacked = tempfile.TemporaryDirectory()
            folder = Path(extract(path, unzipdir=self.unpacked.name))
        self.is_fmi2 = self.description.fmiVersion == "2.0"
        if said is not None:
            # FMI 2.0 passes the name of the instance too.
            arguments["logger"] = lambda *passed: said.append((passed[-3], passed[-2].decode(), passed[-1].decode()))
        self.fmu = instantiate_fmu(str(folder), self.description, **arguments)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.types = {v.name: v.type for v in self.description.modelVariables}

    def set(self, name, value):
        self.set_all({name: value})

    def set_all(self, values):
        for data_type, names in self.by_type(values).items():
            number = {"Integer": int, "Int32": int, "Boolean": bool}.get(data_type, float)
            setter = getattr(self.fmu, f"set{data_type}")
            setter([self.references[name] for name in names], [number(values[name]) for name in names])

    def get(self, name):
        return self.get_all([name])[0]

    def get_all(self, names):
        found = {}
        for data_type, own in self.by_type(names).items():
            values = getattr(self.fmu, f"get{data_type}")([self.references[name] for name in own])
            found.update(zip(own, map(float, values), strict=True))
        return [found[name] for name in names]

    def by_type(self, names):
        """The names by the types of their variables, which FMI sets and reads by functions of their own."""
        found = {}
        for name in names:
            found.setdefault(self.types[name], []).append(name)
        return found

    def time(self):
        """Simulated time, s; FMI 2.0 has no variable for it."""
        return self.fmu.getRealStatus(2) if self.is_fmi2 else self.get("time")

    def enter(self, stop_time=None):
        """Begins initialisation at time 0."""
        if self.is_fmi2:
            self.fmu.setupExperiment(startTime=0.0, stopTime=stop_time)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=0.0, stopTime=stop_time)

    def initialise(self, values=None, stop_time=None):
        """Sets `values`, and initialises at time 0."""
        self.set_all(values or {})
        self.enter(stop_time)
        self.fmu.exitInitializationMode()
        return self

    def names(self, *causalities):
        return [v.name for v in self.description.modelVariables if v.causality in causalities]

    def outputs(self):
        """All outputs by name, as bits."""
        names = self.names("output")
        return {name: struct.pack("d", value) for name, value in zip(names, self.get_all(names), strict=True)}
