"""Westergaard's added mass as the reservoir: p = −A a, with A of `cofferdam.westergaard`.

The orchestrator starts this program as the run's reservoir. It may take its input to mean the acceleration at the end of a
communication step, or the mean over the step.
"""

import numpy as np

import cofferdam


class Westergaard(cofferdam.Reservoir):
    def __init__(self, task):
        self.added_mass = cofferdam.westergaard(task.points, task.depth, task.density)
        self.means = task.acceleration == "mean"
        # Mean acceleration of the step before, m/s², and its length, s; 0 before the first step.
        self.before = np.zeros(len(task.points.y)), 0.0

    def step(self, time, communication_step, acceleration, ground_acceleration):
        at_end = acceleration
        if self.means:
            # Exact for an acceleration that is linear in time: 1.5 ā_n − 0.5 ā_{n−1} with equal steps (docs/theory/theory.md, 10b).
            # −A ā, the pressure of the mean, would come half a step late.
            mean_before, length_before = self.before
            share = communication_step / (communication_step + (length_before or communication_step))
            at_end = acceleration + (acceleration - mean_before) * share
            self.before = acceleration, communication_step
        return -self.added_mass @ at_end

    def save(self):
        return self.before

    def restore(self, state):
        self.before = state


if __name__ == "__main__":
    cofferdam.serve(Westergaard)
