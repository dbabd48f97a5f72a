"""The dam of the scene with its horizontal cracks, on scikit-fem: penalty contact with Coulomb friction at nodes along each crack.

The blocks are those of scikit_fem_dam.py; rotations are small. With gaps g = B u (opening, slip) of the contacts, contact forces F(g)
and A = M + h/2 C + h²/4 K, a time step of the average acceleration method is u = û − h²/4 A⁻¹ Bᵀ F, so that only

    g − ĝ + h²/4 (B A⁻¹ Bᵀ) F(g) = 0

is solved by Newton's method: two unknowns per contact. The dam starts in equilibrium under weight and hydrostatic pressure.

Parameter of the unit: `time_steps` per communication step, 5 by default. Mass damping acts on the blocks' motion as a whole, too
(`drags_blocks` of the built-in dam).
"""

import pickle

import numpy as np
from scikit_fem_dam import ScikitFemDam
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

import cofferdam

NEWTON_LIMIT = 60
STATE = ("displacement", "velocity", "acceleration", "slipped", "now", "ground", "static", "at_rest")
NOT_MODELLED = ("cohesion", "tensile_strength", "dilation", "residual_friction_coefficient", "polyline")


class Contacts:
    """Springs and friction between the two sides of all cracks, at corners and middles of the elements, by Simpson's rule."""

    def __init__(self, model, dam):
        cracks = sorted(dam.get("cracks", []), key=lambda crack: crack.get("elevation", 0.0))
        wrong = [key for crack in cracks for key in NOT_MODELLED if crack.get(key) and crack[key] != crack["friction_coefficient"]]
        if wrong or dam.get("uplift", "unchanged") != "none" or any("uplift" in crack for crack in cracks):
            raise ValueError(f"`dam.cracks`: {', '.join(wrong) or 'uplift'} is not modelled here")
        if not cracks or len(model.parts.joints) != len(cracks):
            raise ValueError(f"{len(model.parts.joints)} of {len(cracks)} cracks lie inside the section; one at least, and all, must")
        pairs, springs = [], []
        for crack, sides in zip(cracks, model.parts.joints):
            (below, length), (above, _) = (self.side(model, nodes) for nodes in sides)
            pairs.append(np.stack([below, above]))
            stiffness = [crack["normal_stiffness"] * length, crack["shear_stiffness"] * length]
            springs.append([*stiffness, np.full_like(length, crack["friction_coefficient"])])
        self.normal, self.shear, self.friction = np.concatenate(springs, axis=1)
        below, above = np.concatenate(pairs, axis=2)
        # Openings of all contacts, then slips.
        rows, places = np.arange(above.size), np.concatenate([above[1], above[0], below[1], below[0]])
        entries = np.repeat([1.0, -1.0], above.size), (np.tile(rows, 2), np.searchsorted(model.free, places))
        self.gaps = csr_matrix(entries, (above.size, len(model.free)))

    @staticmethod
    def side(model, nodes):
        """Unknowns along x and y and length of each contact."""
        basis, mesh = model.basis, model.mesh
        facets = np.flatnonzero(np.isin(mesh.facets, nodes).all(axis=0))
        dofs = np.concatenate([basis.nodal_dofs[:, nodes], basis.facet_dofs[:2, facets]], axis=1)
        ends = mesh.p[0, mesh.facets[:, facets]]
        lengths = np.abs(ends[1] - ends[0])
        corners = np.bincount(mesh.facets[:, facets].ravel(), np.tile(lengths / 6, 2), minlength=mesh.p.shape[1])[nodes]
        order = np.argsort(basis.doflocs[0, dofs[0]])
        return dofs[:, order], np.append(corners, lengths * 4 / 6)[order]

    def forces(self, gap, slipped):
        """Forces of the contacts on the upper side, with reversed sign, their derivatives, and the slip that springs do not take."""
        opening, slip = gap.reshape(2, -1)
        closed = opening < 0
        pressure = np.where(closed, -self.normal * opening, 0.0)
        trial, limit = self.shear * (slip - slipped), self.friction * pressure
        shear = np.clip(trial, -limit, limit)
        sticks = closed & (np.abs(trial) <= limit)
        count = len(opening)
        slope, k = np.zeros((2 * count, 2 * count)), np.arange(count)
        slope[k, k] = np.where(closed, self.normal, 0.0)
        slope[count + k, count + k] = np.where(sticks, self.shear, 0.0)
        slope[count + k, k] = np.where(closed & ~sticks, -np.sign(trial) * self.friction * self.normal, 0.0)
        return np.append(-pressure, shear), slope, slip - shear / self.shear


class ScikitFemCrackedDam(ScikitFemDam):
    with_cracks = True

    def __init__(self, task):
        super().__init__(task)
        self.contacts = Contacts(self.model, task.scene["dam"])
        self.substeps, self.solvers = int(task.parameters.get("time_steps", 5)), {}

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        self.static = self.mapping.to_own(hydrostatic_pressure) - self.inertia[:, 1] * self.task.gravity
        gaps, slipped = self.contacts.gaps, np.zeros_like(self.contacts.normal)
        # All contacts are closed and stick in the first iteration.
        displacement, rest, slope = 0.0, self.static, np.diag(np.append(self.contacts.normal, self.contacts.shear))
        for _ in range(NEWTON_LIMIT):
            displacement = displacement + splu((self.stiffness + gaps.T @ csr_matrix(slope) @ gaps).tocsc()).solve(rest)
            forces, slope, _ = self.contacts.forces(gaps @ displacement, slipped)
            rest = self.static - self.stiffness @ displacement - gaps.T @ forces
            if np.abs(rest).max() < 1e-9 * np.abs(self.static).max():
                break
        else:
            raise RuntimeError("no equilibrium under weight and hydrostatic pressure: does a block slide at rest?")
        self.at_rest, self.displacement, self.velocity = displacement, displacement, np.zeros_like(displacement)
        self.slipped = self.contacts.forces(gaps @ displacement, slipped)[2]
        self.now, self.ground = self.load(pressure, ground_acceleration), ground_acceleration
        self.acceleration = splu(self.mass).solve(self.now + rest)

    def substep(self, length, load):
        if length not in self.solvers:
            solve = splu((self.mass + length / 2 * self.damping + length**2 / 4 * self.stiffness).tocsc()).solve
            moved = length**2 / 4 * solve(self.contacts.gaps.T.toarray())
            self.solvers = {length: (solve, moved, self.contacts.gaps @ moved)}
        solve, moved, flexibility = self.solvers[length]
        velocity = self.velocity + length / 2 * self.acceleration
        start = self.displacement + length * self.velocity + length**2 / 4 * self.acceleration
        free = start + length**2 / 4 * solve(load - self.damping @ velocity - self.stiffness @ start)
        free_gap, gap = self.contacts.gaps @ free, self.contacts.gaps @ self.displacement
        for _ in range(NEWTON_LIMIT):
            forces, slope, slipped = self.contacts.forces(gap, self.slipped)
            rest = gap - free_gap + flexibility @ forces
            if np.abs(rest).max() < 1e-12:
                break
            gap = gap - np.linalg.solve(np.eye(len(gap)) + flexibility @ slope, rest)
        else:
            raise RuntimeError("the contacts do not converge; more `time_steps`")
        self.displacement, self.slipped = free - moved @ forces, slipped
        self.acceleration = (self.displacement - start) * 4 / length**2
        self.velocity = velocity + length / 2 * self.acceleration

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        before, old, self.now = self.velocity, self.now, self.load(pressure, ground_acceleration)
        for part in range(1, self.substeps + 1):
            load = self.static + old + (self.now - old) * part / self.substeps
            self.substep(communication_step / self.substeps, load)
        mean = (self.velocity - before) / communication_step
        return self.motion(self.displacement - self.at_rest, self.velocity, mean, ground_acceleration)

    def save(self):
        return [getattr(self, name) for name in STATE]

    def restore(self, state):
        vars(self).update(zip(STATE, state))

    def serialise(self):
        return pickle.dumps(self.save())

    def deserialise(self, state):
        self.restore(pickle.loads(state))


if __name__ == "__main__":
    cofferdam.serve(ScikitFemCrackedDam)
