"""Newmark's method, for units that have matrices and no time integration."""

import numpy as np


class Newmark:
    """M ü + C u̇ + K u = f by the average acceleration method: of second order, stable for any step, without numerical damping.

    Matrices are those of scipy.sparse, factorised sparsely, or dense ones of numpy. Steps may vary in length; the factors of the
    last four lengths are kept. A load f is given at the end of each step and taken as linear over it.
    """

    def __init__(self, mass, damping, stiffness):
        shapes = [np.shape(matrix) for matrix in (mass, damping, stiffness)]
        if len(set(shapes)) > 1 or len(shapes[0]) != 2 or shapes[0][0] != shapes[0][1]:
            raise ValueError(f"mass, damping and stiffness have the shapes {shapes}; three equal square ones are needed")
        self.mass, self.damping, self.stiffness = mass, damping, stiffness
        self._solvers = {}
        zero = np.zeros(shapes[0][0])
        self.displacement, self.velocity, self.acceleration = zero, zero, zero

    def start(self, force):
        """The acceleration at rest under the load `force`."""
        self.acceleration = _solver(self.mass)(force - self.damping @ self.velocity - self.stiffness @ self.displacement)

    def static(self, force):
        """The displacement K⁻¹ `force` of a static load; the state is unaffected."""
        return _solver(self.stiffness)(force)

    def step(self, length, force):
        """Steps by `length` (s) to the load `force` at its end; returns displacement, velocity and acceleration there."""
        half = 0.5 * length
        solve = self._solvers.get(length)
        if solve is None:
            while len(self._solvers) >= 4:
                del self._solvers[next(iter(self._solvers))]
            solve = self._solvers[length] = _solver(self.mass + half * self.damping + half**2 * self.stiffness)
        velocity = self.velocity + half * self.acceleration
        displacement = self.displacement + length * self.velocity + half**2 * self.acceleration
        self.acceleration = solve(force - self.damping @ velocity - self.stiffness @ displacement)
        self.velocity = velocity + half * self.acceleration
        self.displacement = displacement + half**2 * self.acceleration
        return self.displacement, self.velocity, self.acceleration

    # A step makes new arrays, so that what is saved needs no copy.

    def save(self):
        return self.displacement, self.velocity, self.acceleration

    def restore(self, state):
        self.displacement, self.velocity, self.acceleration = state

    def serialise(self):
        """The state as bytes, with all bits."""
        return np.concatenate(self.save()).tobytes()

    def deserialise(self, state):
        """The state from the bytes of `serialise`.

        **Errors**: they belong to another number of unknowns.
        """
        values = np.frombuffer(state)
        if len(values) != 3 * len(self.displacement):
            raise ValueError(f"a state of {len(values)} values, {3 * len(self.displacement)} are needed: it is that of another mesh")
        self.restore(tuple(values.reshape(3, -1).copy()))


def _solver(matrix):
    if hasattr(matrix, "tocsc"):
        # Imported here, as dense matrices and other units need numpy alone.
        from scipy.sparse.linalg import splu

        return splu(matrix.tocsc()).solve
    inverse = np.linalg.inv(matrix)
    return lambda right: inverse @ right
