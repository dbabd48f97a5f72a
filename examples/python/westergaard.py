"""Westergaard's added mass in the place of the reservoir: p = −A a, M A = ρ ∫ w N Nᵀ ds with w = ⅞ √(h (h − y)).

N are the hat functions of the points and M = ∫ N Nᵀ ds: sampled at the points, the root would lose mass beside the surface. The
orchestrator starts this program as the run's reservoir. It may take its input to mean the acceleration at the end of a
communication step, or the mean over the step.
"""

import numpy as np

import cofferdam


def added_mass(points, depth, density):
    """A of p = −A a, kg/m², by Gauss quadrature in u = √(h − y), in which all integrands are polynomials."""
    below, n = depth - points.y, len(points.y)
    mass, moved = np.zeros((n, n)), np.zeros((n, n))
    position, weight = np.polynomial.legendre.leggauss(8)
    for i in range(n - 1):
        length = np.hypot(points.x[i + 1] - points.x[i], points.y[i + 1] - points.y[i])
        if length == 0:  # The two sides of a crack.
            continue
        lower, upper = np.sqrt(below[i]), np.sqrt(max(below[i + 1], 0))
        u = (lower + upper) / 2 + (lower - upper) / 2 * position
        along = (below[i] - u**2) / (below[i] - below[i + 1])
        ds = 2 * u * (lower - upper) / 2 * weight * length / (below[i] - below[i + 1])
        hats = np.array([1 - along, along])
        panel = slice(i, i + 2)
        mass[panel, panel] += (hats * ds) @ hats.T
        moved[panel, panel] += density * (hats * ds * 7 / 8 * np.sqrt(depth) * u) @ hats.T
    return np.linalg.solve(mass, moved)


class Westergaard(cofferdam.Reservoir):
    def __init__(self, task):
        self.added_mass = added_mass(task.points, task.depth, task.density)
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
