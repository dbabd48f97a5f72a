"""Crest displacement and sliding over the friction of the cracks, in parallel; with Dask if it is installed.

cofferdam export-fmu scenes/koyna-coarse --unit coupled --fmi 2
python friction_study.py [FMU [STOP_TIME]]
"""

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu

FRICTIONS = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1]


def simulate(folder, stop_time, friction):
    """Peak crest displacement and largest sliding at the end, m, of the FMU that is unpacked in `folder`."""
    description = read_model_description(folder)
    names = [variable.name for variable in description.modelVariables]
    frictions = [name for name in names if name.endswith(".friction_coefficient")]
    slidings = [name for name in names if name.endswith(".sliding")]
    if not frictions:
        raise ValueError("the dam has no crack")
    history = simulate_fmu(
        folder,
        model_description=description,
        start_values={"use_record": 1, **dict.fromkeys(frictions, friction)},
        output=["crest_displacement.x", *slidings],
        output_interval=float(description.defaultExperiment.stepSize),
        stop_time=stop_time,
    )
    sliding = max((history[name][-1] for name in slidings), key=abs)
    return np.abs(history["crest_displacement.x"]).max(), sliding


def in_processes(function, values):
    """The function of every value. FMPy changes the working directory while it loads an FMU: threads are not safe."""
    try:
        import dask
    except ImportError:
        with ProcessPoolExecutor() as pool:
            return list(pool.map(function, values))
    return dask.compute(*(dask.delayed(function)(value) for value in values), scheduler="processes")


def main(path="koyna-coarse-coupled.fmu", stop_time=None):
    with tempfile.TemporaryDirectory() as folder:
        extract(path, unzipdir=folder)  # once for all processes
        results = in_processes(partial(simulate, folder, stop_time), FRICTIONS)
    print("friction   crest, mm   sliding, mm")
    for friction, (crest, sliding) in zip(FRICTIONS, results):
        print(f"{friction:8.2f} {1e3 * crest:11.2f} {1e3 * sliding:13.3f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
