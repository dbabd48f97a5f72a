"""Cost of FMPy's loop in addition to the solvers: time per iteration and unit, at about 40 interface points.

The dam is measured on a coarse mesh too, whose short steps need little of the processor's caches.

COFFERDAM=target/release/cofferdam target/python/bin/python tests/python/loop_cost.py
"""

import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from fmus import H, HALF_SECOND, initialised, pack

FORTY_POINTS = "dam.element_size=2.42"
COARSE = "dam.element_size=10"


def clocked(fmu, name):
    """Returns a list whose only item sums the time spent in the C function `name` of `fmu`."""
    function, spent = fmu._functions[name], [0.0]

    def call(*arguments):
        began = perf_counter()
        status = function(*arguments)
        spent[0] += perf_counter() - began
        return status

    call.argnames, call.argtypes, call.restype = function.argnames, function.argtypes, function.restype
    fmu._functions[name] = call
    return spent


def main(iterations=400):
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh, given, answered in [
            ("reservoir", FORTY_POINTS, "interface_acceleration", ["interface_pressure"]),
            ("dam", COARSE, "interface_pressure", ["interface_acceleration", "interface_displacement"]),
            ("dam", FORTY_POINTS, "interface_pressure", ["interface_acceleration", "interface_displacement"]),
        ]:
            unit = initialised(pack(Path(folder), name, [*HALF_SECOND, "reservoir.element_size=20", mesh]))
            points = unit.references[given][1]
            values, state = np.ones(points), unit.fmu.getFMUState()
            stepping, restoring = clocked(unit.fmu, "fmi3DoStep"), clocked(unit.fmu, "fmi3SetFMUState")
            loop = []
            for _ in range(iterations):
                before = stepping[0] + restoring[0]
                began = perf_counter()
                unit.fmu.setFMUState(state)
                unit.set(given, values)
                unit.fmu.doStep(0.0, H)
                for variable in answered:
                    unit.get(variable)
                loop.append(perf_counter() - began - (stepping[0] + restoring[0] - before))
            microseconds = [1e6 * np.percentile(loop, percent) for percent in (50, 99)]
            solver, states = (1e6 * spent[0] / iterations for spent in (stepping, restoring))
            print(
                f"{name}: {points} points, {len(answered)} arrays got; loop median {microseconds[0]:.1f} us, "
                f"p99 {microseconds[1]:.1f} us beside {solver:.1f} us in steps and {states:.1f} us in restoring"
            )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
