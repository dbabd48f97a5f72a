"""The dam on scikit-fem as a solver that only steps forward, for the tests of `cofferdam.StatelessDam`."""

import sys
from pathlib import Path

import cofferdam
import numpy as np
from scipy.sparse import csc_matrix

sys.path.insert(0, str(Path(__file__).parents[2] / "examples" / "solvers"))
from scikit_fem_dam import Discretisation  # noqa: E402


class ForwardDam(cofferdam.StatelessDam):
    def __init__(self, task):
        self.model = model = Discretisation(task)
        facets = np.flatnonzero(np.isin(model.mesh.facets, model.parts.upstream).all(axis=0))
        dofs = np.append(model.basis.nodal_dofs[0, model.parts.upstream], model.basis.facet_dofs[0, facets])
        dofs = dofs[np.argsort(model.basis.doflocs[1, dofs])]
        self.places = model.basis.doflocs[:, dofs]
        # The heel is fixed.
        self.moving = np.isin(dofs, model.free)
        self.dofs = np.searchsorted(model.free, dofs[self.moving])
        self.mass, stiffness = model.of_free(model.mass), model.of_free(model.stiffness)
        alpha, beta = cofferdam.rayleigh(task.scene["dam"]["damping"], model.frequencies()[0])
        damping = alpha * self.mass + beta * stiffness
        super().__init__(task)
        self.newmark = cofferdam.Newmark(self.mass, damping, stiffness)
        self.ground_load = -(model.mass @ model.translations())[model.free]

    def boundary(self):
        return self.places

    def mass_of_water(self, matrix):
        water = np.zeros(self.mass.shape)
        water[np.ix_(self.dofs, self.dofs)] = matrix[np.ix_(self.moving, self.moving)]
        self.mass = self.mass + csc_matrix(water)

    def load(self, forces, ground_acceleration):
        load = self.ground_load @ ground_acceleration
        load[self.dofs] += forces[self.moving]
        return load

    def begin(self, forces, ground_acceleration):
        self.newmark.start(self.load(forces, ground_acceleration))

    def advance(self, time, communication_step, forces, ground_acceleration):
        displacement, velocity, _ = self.newmark.step(communication_step, self.load(forces, ground_acceleration))
        motion = np.zeros((2, len(self.moving)))
        motion[:, self.moving] = displacement[self.dofs], velocity[self.dofs]
        return motion


if __name__ == "__main__":
    cofferdam.serve(ForwardDam)
