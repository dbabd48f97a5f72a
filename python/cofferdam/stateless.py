"""A dam on a solver that only steps forward."""

import logging

import numpy as np

from .face import Face, westergaard
from .unit import Dam

_LIMITS = (
    "it saves no state: explicit schemes or the added-mass scheme only; a resumed run repeats all steps; repeatability is not tested"
)


class StatelessDam(Dam):
    """A dam on a solver that can neither save nor restore its state: forces go in, motion comes out, each step once.

    A class derived from it has these methods:

        boundary(self)          coordinates x and y of the solver's own nodes on the upstream face, from the heel up, m
        begin(self, forces, ground_acceleration)
                                takes what `advance` takes, at time 0, where the dam is at rest; nothing by default
        mass_of_water(self, m)  only for the added-mass scheme: adds the matrix m (kg/m, along n at these nodes) to its mass
        advance(self, time, communication_step, forces, ground_acceleration)
                                takes a step to the forces on these nodes along n (N/m) and the ground acceleration at its end;
                                returns displacement and velocity there, relative to the ground, along n

    `__init__` of the derived class calls the one of this class when `boundary` is available. With
    `coupling.scheme = "serial-explicit"` the water must be compressible. With `"added-mass"`, and the parameter
    `added_mass = "westergaard"` of the unit, water without memory moves with the dam:
    `reservoir.fidelity = "westergaard"` then returns the pressure.
    """

    def __init__(self, task):
        face, points = Face(task.points), task.points
        self._mapping = face.mapping(*self.boundary())
        self._normal = np.stack([points.normal_x, points.normal_y], axis=1)
        self._velocity, self._ground = np.zeros(len(points)), np.zeros(2)
        self._water = None
        wanted = task.parameters.get("added_mass")
        if wanted not in (None, "westergaard"):
            raise ValueError(f'`{task.name}.command.parameters.added_mass` is {wanted!r}; "westergaard" is known, or leave it out')
        if wanted:
            self._water = westergaard(points, task.depth, task.density)
            self.mass_of_water(self._mapping.added_mass(self._water))
            self.added_mass_included = True
        logging.getLogger(__name__).info(_LIMITS)

    def boundary(self):
        raise NotImplementedError(f"{type(self).__name__} needs a method `boundary`")

    def mass_of_water(self, matrix):
        raise NotImplementedError(f"{type(self).__name__} needs a method `mass_of_water`, or leave out the parameter `added_mass`")

    def begin(self, forces, ground_acceleration):
        pass

    def advance(self, time, communication_step, forces, ground_acceleration):
        raise NotImplementedError(f"{type(self).__name__} needs a method `advance`")

    def forces(self, pressure, ground_acceleration):
        """On the solver's own nodes along n, N/m; that of added mass which moves with the ground included."""
        if self._water is not None:
            pressure = pressure - self._water @ (self._normal @ ground_acceleration)
        return self._mapping.to_own(pressure)

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        self._ground = ground_acceleration
        self.begin(self.forces(pressure, ground_acceleration), ground_acceleration)

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        forces = self.forces(pressure, ground_acceleration)
        displacement, velocity = map(self._mapping.to_points, self.advance(time, communication_step, forces, ground_acceleration))
        mean_ground, before = 0.5 * (self._ground + ground_acceleration), self._velocity
        self._ground, self._velocity = ground_acceleration, velocity
        return displacement, velocity, (velocity - before) / communication_step + self._normal @ mean_ground
