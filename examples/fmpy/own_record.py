"""Dam and water in one FMU, under a ground motion record of your own, with and without correction of FMPy's delay.

cofferdam export-fmu scenes/koyna-coarse --unit coupled --fmi 2
python own_record.py [FMU [RECORD [STOP_TIME]]]

The FMU takes its input as the value at the end of a step and varies it linearly within the step. FMPy sets the value of
time t before the step from t to t + H, so the ground moves one step late. Remedy: give the value of t + H at time t.

The default record is that of the scene, for a comparison with `use_record` = 1.
"""

import sys
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu

STANDARD_GRAVITY = 9.80665  # m/s²
RECORDS = Path(__file__).parents[2] / "scenes" / "records"


def ground_acceleration(record):
    """The CSV file `record` (time, s; acceleration, g) as a function of time, s: acceleration, m/s²."""
    time, acceleration = np.loadtxt(record, delimiter=",", comments=["#", "time"], unpack=True)
    # After the last sample the ground comes to rest within one interval, as in `cofferdam run`.
    times = np.append(time, time[-1] + time[1] - time[0]) - time[0]
    samples = STANDARD_GRAVITY * np.append(acceleration, 0.0)
    return lambda t: np.interp(t, times, samples)


def table(times, values):
    """The input as FMPy expects it."""
    signals = np.zeros(len(times), [("time", float), ("ground_acceleration", float)])
    signals["time"], signals["ground_acceleration"] = times, values
    return signals


def as_recorded(ground, step, steps):
    times = step * np.arange(steps + 1)
    return table(times, ground(times))


def shifted(ground, step, steps):
    """The value of t + H at time t.

    Of two rows at time 0, FMPy takes the first for the initialisation and the second for the first step, but only if
    another row precedes them.
    """
    ends = step * np.arange(1, steps + 1)
    return table(np.append([-step, 0.0], ends - step), ground(np.append([0.0, 0.0], ends)))


def main(path="koyna-coarse-coupled.fmu", record=RECORDS / "northridge-1994-canyon-country-270.csv", stop_time=8.0):
    step, stop_time = float(read_model_description(path).defaultExperiment.stepSize), float(stop_time)
    arguments = {"output": ["crest_displacement.x"], "output_interval": step, "stop_time": stop_time}
    crests = {"record inside the FMU": simulate_fmu(path, start_values={"use_record": 1}, **arguments)}
    ground = ground_acceleration(record)
    for name, signals in (("input as recorded", as_recorded), ("input one step earlier", shifted)):
        crests[name] = simulate_fmu(path, input=signals(ground, step, round(stop_time / step)), **arguments)

    crests = {name: 1e3 * history["crest_displacement.x"] for name, history in crests.items()}
    inside = crests["record inside the FMU"]
    print("ground motion            crest upstream, downstream   largest difference")
    for name, crest in crests.items():
        difference = np.abs(crest - inside).max()
        print(f"{name:24} {crest.min():+8.2f} mm {crest.max():+11.2f} mm {difference:14.1e} mm")


if __name__ == "__main__":
    main(*sys.argv[1:])
