"""The reservoir alone, before a rigid dam whose acceleration upstream rises in a ramp and then stays constant.

python reservoir_alone.py reservoir.fmu [results.csv]
"""

import sys

import numpy as np
from fmpy import simulate_fmu
from fmpy.util import write_csv

from unit import Unit

ACCELERATION = -1.0  # m/s², along x: the dam moves towards the water
RISE = 0.1  # s


def velocity(time):
    """Velocity of the dam, m/s: the integral of the ramp."""
    return ACCELERATION * np.where(time < RISE, time**2 / (2 * RISE), time - RISE / 2)


def main(path, results=None):
    water = Unit(path)
    experiment = water.description.defaultExperiment
    step, stop = float(experiment.stepSize), float(experiment.stopTime)
    normal = water.get("interface_normal_x")

    # FMPy sets the inputs of time t before the step from t, and the reservoir takes `interface_acceleration`
    # as the mean over that step: the row of time t therefore holds the mean from t to t + H.
    time = np.arange(round(stop / step)) * step
    signals = np.zeros(len(time), [("time", float), ("interface_acceleration", float, len(normal))])
    signals["time"] = time
    signals["interface_acceleration"] = np.outer((velocity(time + step) - velocity(time)) / step, normal)

    outputs = ["base_pressure", "total_force", "interface_pressure"]
    experiment = {"input": signals, "output": outputs, "stop_time": stop, "output_interval": step}
    history = simulate_fmu(path, fmu_instance=water.fmu, model_description=water.description, **experiment)

    pressure = history["base_pressure"]
    peak = np.argmax(pressure)
    print(f"pressure at the base: peak {pressure[peak]:.1f} Pa at {history['time'][peak]:.4f} s")
    print(f"pressure at the base at last: {pressure[-1]:.1f} Pa")
    if results:
        write_csv(results, history[["time", "base_pressure", "total_force"]])


if __name__ == "__main__":
    main(*sys.argv[1:])
