"""A dam of your own as a process; README.md says how to test and use it.

SI units, per metre of dam. x points downstream, y up from the heel; n is the unit normal of the wet face, out of the
water into the dam. Displacement and velocity are along n, relative to the ground, since the start; an acceleration is
total (that of the ground is in it) and along n. A pressure is the excess over hydrostatic, p > 0 in compression.
"""

import cofferdam
import numpy as np


class Dam(cofferdam.Dam):
    def __init__(self, task):
        """Made once, at rest; `task` has what the scene says."""
        self.mass = task.parameters.get("mass", @mass@)  # kg/m, that sways
        self.stiffness = task.parameters.get("stiffness", @stiffness@)  # Pa: force (N/m) over sway (m)
        ratio = task.parameters.get("damping_ratio", @damping_ratio@)
        self.damping = 2 * ratio * np.sqrt(self.mass * self.stiffness)
        self.normal = np.asarray(task.points.normal_x)
        # Force along x of a pressure: the sum of p n_x over the face.
        self.weight = np.asarray(task.points.tributary_length) * self.normal
        # Memory: displacement, velocity and acceleration of the sway along x, relative to the ground, and the
        # acceleration of the ground, at the end of the last step.
        self.sway = (0.0, 0.0, 0.0, 0.0)

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        """Displacement, velocity and acceleration, mean over the step, at the end of a step from `time`; all loads are
        those of the end. The dam sways as one body, m (a + a_ground) + c v + k u = force, by Newmark's method with the
        mean acceleration."""
        h, m, c, k = communication_step, self.mass, self.damping, self.stiffness
        u, v, a, ground_before = self.sway
        before, ground = a + ground_before, ground_acceleration[0]
        u, v = u + h * v + 0.25 * h * h * a, v + 0.5 * h * a
        load = float(self.weight @ pressure) - m * ground
        a = (load - c * v - k * u) / (m + 0.5 * h * c + 0.25 * h * h * k)
        v, u = v + 0.5 * h * a, u + 0.25 * h * h * a
        self.sway = (u, v, a, ground)
        mean = 0.5 * (before + a + ground)
        return u * self.normal, v * self.normal, mean * self.normal

    def save(self):
        """Everything that a step changes. After `restore`, the same step must give the same bits."""
        return self.sway

    def restore(self, state):
        """Back to what `save` gave. It may come several times with the same state, which must not change."""
        self.sway = state


if __name__ == "__main__":
    cofferdam.serve(Dam)
