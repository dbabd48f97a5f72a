"""A reservoir of your own as a process; README.md says how to test and use it.

SI units, per metre of dam. x points downstream, y up from the heel; n is the unit normal of the wet face, out of the
water into the dam. An acceleration is total (that of the ground is in it) and along n. A pressure is the excess over
hydrostatic, p > 0 in compression: a face that moves into the water, a < 0, has p > 0.
"""

import cofferdam
import numpy as np


class Water(cofferdam.Reservoir):
    def __init__(self, task):
        """Made once, at rest; `task` has what the scene says."""
        depth, y = task.depth, np.asarray(task.points.y)
        # Westergaard's added mass (Pa per m/s2): p = -A a.
        self.added_mass = 7 / 8 * task.density * np.sqrt(depth * (depth - y))
        # What `acceleration` of the scene says: "end", a at the end of the step, or "mean", its mean over the step.
        self.is_mean = task.acceleration == "mean"
        # Memory: what the next step has to know of this one.
        self.mean_before, self.length_before = np.zeros(len(y)), None

    def step(self, time, communication_step, acceleration, ground_acceleration):
        """The pressure (Pa) at the end of a step from `time`; the ground's acceleration (x, y) is that of the end."""
        a = np.asarray(acceleration)
        if self.is_mean:
            # At the end of the step: 1.5 mean - 0.5 mean of the step before, for steps of equal length.
            before = self.length_before or communication_step
            a = a + (a - self.mean_before) * communication_step / (communication_step + before)
        self.mean_before, self.length_before = np.array(acceleration), communication_step
        return -self.added_mass * a

    def save(self):
        """Everything that a step changes. After `restore`, the same step must give the same bits."""
        return self.mean_before.copy(), self.length_before

    def restore(self, state):
        """Back to what `save` gave. It may come several times with the same state, which must not change."""
        self.mean_before, self.length_before = state[0].copy(), state[1]


if __name__ == "__main__":
    cofferdam.serve(Water)
