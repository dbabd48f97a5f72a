"""The reservoir alone: the water before a rigid dam that is accelerated towards it by a ramp, then held.

python reservoir_alone.py reservoir.fmu [results.csv]
"""

import sys

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.util import write_csv

ACCELERATION = -1.0  # m/s², along n: the dam moves towards the water
RISE = 0.1  # s


def velocity(time):
    """Velocity of the dam, m/s: the integral of the ramp."""
    return ACCELERATION * np.where(time < RISE, time**2 / (2 * RISE), time - RISE / 2)


def main(path, results=None):
    description = read_model_description(path)
    sizes = {v.name: int(np.prod(v.shape)) for v in description.modelVariables}
    starts = {v.name: v.start for v in description.modelVariables}
    step = float(description.defaultExperiment.stepSize)
    stop = float(description.defaultExperiment.stopTime)

    # FMPy sets the inputs of time t before the step from t, and the reservoir takes
    # `interface_acceleration` as that step's mean: so a row holds the mean from its time on.
    time = np.arange(round(stop / step)) * step
    points = sizes["interface_acceleration"]
    signals = np.zeros(len(time), [("time", float), ("interface_acceleration", float, points)])
    signals["time"] = time
    signals["interface_acceleration"] = ((velocity(time + step) - velocity(time)) / step)[:, np.newaxis]

    outputs = ["base_pressure", "total_force", "interface_pressure"]
    history = simulate_fmu(path, input=signals, output=outputs, stop_time=stop, output_interval=step)

    pressure = history["base_pressure"]
    peak = np.argmax(pressure)
    print(f"pressure at the base: peak {pressure[peak]:.1f} Pa at {history['time'][peak]:.4f} s")
    print(f"pressure at the base at last: {pressure[-1]:.1f} Pa")
    print(f"water of {starts['water_density']} kg/m3, sound at {starts['sound_speed']} m/s, {len(time)} steps of {step} s")
    if results:
        write_csv(results, history[["time", "base_pressure", "total_force"]])


if __name__ == "__main__":
    main(*sys.argv[1:])
