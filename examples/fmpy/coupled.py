"""Dam and water in one FMU, under the ground motion record of the scene.

cofferdam export-fmu scenes/koyna-coarse --unit coupled --fmi 2
python coupled.py [FMU [PICTURE [STOP_TIME]]]
"""

import sys
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu


def draw(history, slidings, picture):
    try:
        import matplotlib
    except ImportError:
        print("no picture: matplotlib is not installed")
        return
    matplotlib.use("Agg")  # writes files, needs no display
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, sharex=True)
    axes[0].plot(history["time"], 1e3 * history["crest_displacement.x"])
    axes[0].set_ylabel("crest displacement, mm")
    for name in slidings:
        axes[1].plot(history["time"], 1e3 * history[name], label=name)
    axes[1].set(xlabel="time, s", ylabel="sliding, mm")
    if slidings:
        axes[1].legend()
    figure.savefig(picture)
    print(f"picture: {picture}")


def main(path="koyna-coarse-coupled.fmu", picture=None, stop_time=None):
    # Without `output_interval`, FMPy lengthens the steps of a simulation with more than 1000 steps.
    step = float(read_model_description(path).defaultExperiment.stepSize)
    history = simulate_fmu(path, start_values={"use_record": 1}, output_interval=step, stop_time=stop_time)

    crest = 1e3 * history["crest_displacement.x"]
    for word, row in (("upstream", np.argmin(crest)), ("downstream", np.argmax(crest))):
        print(f"crest, peak {word}: {crest[row]:+.2f} mm at {history['time'][row]:.4f} s")
    slidings = [name for name in history.dtype.names if name.endswith(".sliding")]  # none in an intact dam
    for name in slidings:
        print(f"{name} at {history['time'][-1]:.2f} s: {1e3 * history[name][-1]:+.3f} mm")
    iterations, converged = (np.mean(history[name][1:]) for name in ("iterations", "converged"))  # row 0 is time 0
    print(f"{iterations:.2f} dam steps per communication step; {converged:.0%} of the steps converged")
    draw(history, slidings, picture or Path(path).with_suffix(".png"))


if __name__ == "__main__":
    main(*sys.argv[1:])
