"""The second participant of the tests of examples/solvers/precice_bridge.py: an echo with memory, in the loop of the bridge."""

import runpy
from pathlib import Path

import cofferdam
import numpy as np

PLACES = np.column_stack([np.zeros(19), np.linspace(0, 91.75, 19)])


class Delayed(cofferdam.Reservoir):
    """p = −m (1.5 ā_n − 0.5 ā_{n−1}): Westergaard's mass at points, with memory."""

    def __init__(self, task):
        self.mass = 875.0 * np.sqrt(91.75 * (91.75 - PLACES[:, 1]))
        self.before = np.zeros(len(PLACES))

    def step(self, time, communication_step, acceleration, ground_acceleration):
        at_end, self.before = 1.5 * acceleration - 0.5 * self.before, acceleration
        return -self.mass * at_end

    def save(self):
        return self.before

    def restore(self, state):
        self.before = state


def main(participant):
    bridge = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "solvers" / "precice_bridge.py"))
    bridge["participate"](Delayed(None), participant, "Face", PLACES, ("Acceleration", "Pressure"))


if __name__ == "__main__":
    cofferdam.serve(Delayed)
