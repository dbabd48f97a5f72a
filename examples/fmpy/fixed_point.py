"""Dam and reservoir, coupled in Python: each communication step is repeated until both agree.

python fixed_point.py dam.fmu reservoir.fmu record.csv [results.csv]
"""

import sys

import numpy as np

from unit import Unit, ground_acceleration, refuse_strangers


def predicted(accepted):
    """The pressure extrapolated from the last accepted ones, at most three."""
    weights = {1: [1.0], 2: [-1.0, 2.0], 3: [1.0, -3.0, 3.0]}[len(accepted)]
    return sum(weight * pressure for weight, pressure in zip(weights, accepted))


def main(dam, reservoir, record, results=None):
    dam, reservoir = Unit(dam), Unit(reservoir)
    scene, coupling = dam.scene, dam.scene["coupling"]
    step, tolerance = scene["time"]["communication_step"], coupling["tolerance"]
    tolerance = 1e-6 if tolerance == "balanced" else tolerance  # of which only numbers are written out here
    steps = round(float(dam.description.defaultExperiment.stopTime) / step)
    ground = ground_acceleration(record, scene)
    written_out = {"acceleration": "aitken", "predictor_order": 2, "measures": ["pressure"]}
    if any(coupling[key] != value for key, value in written_out.items()):
        raise SystemExit(f"this example implements {written_out} only: pack with --set coupling.acceleration=aitken")

    for unit in (reservoir, dam):
        unit.set("ground_acceleration", ground(0.0))
        unit.fmu.enterInitializationMode(startTime=0.0)
        if unit is dam:
            refuse_strangers(dam, reservoir)
            dam.set("hydrostatic_pressure", hydrostatic)
        hydrostatic = unit.get("hydrostatic_pressure")
        unit.fmu.exitInitializationMode()
    pressure_floor = 0.01 * tolerance * hydrostatic[0]

    accepted, relaxation, iterations, rows = [np.zeros_like(hydrostatic)], coupling["relaxation"], 0, []
    for n in range(steps):
        time, guess = n * step, predicted(accepted)
        for unit in (dam, reservoir):
            unit.set("ground_acceleration", ground((n + 1) * step))
        # A saved state contains the inputs, so inputs set before saving need not be set again after restoring.
        saved = [unit.fmu.getFMUState() for unit in (dam, reservoir)]
        residual = None
        for _ in range(coupling["iteration_limit"]):
            dam.set("interface_pressure", guess)
            dam.fmu.doStep(time, step)
            reservoir.set("interface_acceleration", dam.get("interface_acceleration"))
            reservoir.fmu.doStep(time, step)
            answer = reservoir.get("interface_pressure")
            iterations += 1

            before, residual = residual, answer - guess
            if np.linalg.norm(residual) <= tolerance * np.linalg.norm(answer) + pressure_floor:
                break
            if before is not None and (change := residual - before).any():
                aitken = -relaxation * (before @ change) / (change @ change)
                relaxation = np.clip(aitken, 0.01, 1.5) if aitken > 0 else relaxation
            guess = guess + relaxation * residual
            for unit, state in zip((dam, reservoir), saved):
                unit.fmu.setFMUState(state)
        else:
            raise SystemExit(f"the step at {time} s did not converge")
        for unit, state in zip((dam, reservoir), saved):
            unit.fmu.freeFMUState(state)
        accepted = [*accepted[-2:], answer]
        rows.append([(n + 1) * step, *dam.get("crest_displacement")])

    crest = np.array(rows)[:, 1]
    print(f"crest {1e3 * crest.min():+.2f} to {1e3 * crest.max():+.2f} mm, {iterations / steps:.2f} dam steps per communication step")
    if results:
        np.savetxt(results, rows, delimiter=",", header="time,crest_x,crest_y", comments="")


if __name__ == "__main__":
    main(*sys.argv[1:])
