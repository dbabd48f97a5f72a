"""The dam alone under a ground motion record; the water acts with its hydrostatic pressure only.

python dam_alone.py dam.fmu record.csv [results.csv]
"""

import sys

import numpy as np

from unit import Unit, ground_acceleration


def main(path, record, results=None):
    dam = Unit(path)
    experiment = dam.description.defaultExperiment
    step, stop = float(experiment.stepSize), float(experiment.stopTime)
    ground = ground_acceleration(record, dam.scene)

    # Inputs that are set before initialisation ends hold at time 0. The hydrostatic pressure of the scene is a
    # start value of the FMU: during initialisation the dam comes to rest under its weight and this pressure.
    dam.set("ground_acceleration", ground(0.0))
    dam.fmu.enterInitializationMode(startTime=0.0)
    dam.fmu.exitInitializationMode()
    static = dam.get("crest_static_displacement")

    names = ["crest_displacement", "crest_acceleration", "crack_sliding", "kinetic_energy", "energy_balance_error"]
    names = [name for name in names if name in dam.references]  # an intact dam has no sliding
    rows = []
    for n in range(round(stop / step)):
        # Inputs are set for the step's end; the dam keeps those at its start.
        dam.set("ground_acceleration", ground((n + 1) * step))
        dam.fmu.doStep(n * step, step)
        rows.append(np.concatenate([[(n + 1) * step], *map(dam.get, names)]))
    rows = np.array(rows)

    crest = rows[:, 1]
    print(f"crest under weight and water: {1e3 * static[0]:+.2f} mm downstream")
    print(f"crest in the earthquake: {1e3 * crest.min():+.2f} to {1e3 * crest.max():+.2f} mm")
    if "crack_sliding" in dam.references:
        print(f"residual sliding, crack by crack: {1e3 * dam.get('crack_sliding')} mm")
    error = np.abs(rows[:, -1]).max() / rows[:, -2].max()
    print(f"energy: balanced to {100 * error:.4f} % of the peak kinetic energy")
    if results:
        columns = [f"{name}[{i + 1}]" for name in names for i in range(dam.references[name][1])]
        np.savetxt(results, rows, delimiter=",", header=",".join(["time", *columns]), comments="")


if __name__ == "__main__":
    main(*sys.argv[1:])
