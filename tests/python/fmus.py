"""FMUs packed for the tests, and functions to simulate them."""

import os
import subprocess
import sys
from pathlib import Path

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


def names_of(unit, **attributes):
    """Names of the variables with these attributes."""
    variables = unit.description.modelVariables
    return [v.name for v in variables if all(getattr(v, key) == value for key, value in attributes.items())]


def outputs(unit):
    """All outputs, as bits."""
    return {name: unit.get(name).tobytes() for name in names_of(unit, causality="output")}
