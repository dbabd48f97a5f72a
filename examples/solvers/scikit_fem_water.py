"""Compressible water on scikit-fem: the wave equation, quadratic quadrilaterals of nine nodes, average acceleration.

With ψ = ∫ p dt, (1/c²) ψ̈ = Δψ and ∂ψ/∂n = −ρ v_n on the face, so that p = ψ̇. Free surface: ψ = 0. Bed: ∂p/∂n = −q ṗ with
q = (1 − α)/((1 + α) c). Far end: ∂p/∂n = −ṗ/c, exact for the plane wave alone; Sommerfeld's condition needs distance.

Depth, density, speed of sound and α are those of the scene. Parameters of the unit: `element_size` along the face (m; a tenth
of the depth by default), `length` of the water (m; twelve depths by default). The bed is level and does not move.
"""

import numpy as np
from skfem import Basis, BilinearForm, ElementQuad2, FacetBasis, LinearForm, MeshQuad, asm
from skfem.helpers import dot, grad

import cofferdam

NOT_MODELLED = {"bed": "a bed that is not level", "surface_waves": "gravity waves"}


@BilinearForm
def gradients(u, v, _):
    return dot(grad(u), grad(v))


@BilinearForm
def products(u, v, _):
    return u * v


def mesh_of(points, depth, size, length):
    """Rows of quadrilaterals from the face to the far end, which grow from `size` to three times as long."""
    marks = np.unique(np.round(points.y, 9))
    parts = [np.linspace(a, b, max(round((b - a) / size), 1), endpoint=False) for a, b in zip(marks, marks[1:])]
    y = np.append(np.concatenate(parts), depth)
    face = np.interp(y, points.y, points.x)
    growth = np.minimum(1.1 ** np.arange(12), 3.0)
    steps = np.cumsum(size * np.append(growth, np.full(int(length / size) + 1, 3.0)))
    share = np.append(0.0, steps[: np.searchsorted(steps, length) + 1])
    share /= share[-1]
    x = face[:, None] + share * (-length - face[:, None])
    tags = np.arange(x.size).reshape(x.shape)
    corners = [tags[:-1, 1:], tags[:-1, :-1], tags[1:, :-1], tags[1:, 1:]]
    return MeshQuad(np.stack([x.ravel(), np.repeat(y, x.shape[1])]), np.stack([c.ravel() for c in corners])), tags


class ScikitFemWater(cofferdam.Reservoir):
    def __init__(self, task):
        water, points, depth = task.scene[task.name], task.points, task.depth
        for key, what in NOT_MODELLED.items():
            if water.get(key):
                raise ValueError(f"`{task.name}.{key}`: {what} is not modelled here")
        if task.acceleration != "mean":
            raise ValueError(f'`{task.name}.command.acceleration` must be "mean", as the velocity is linear within a step')
        size = task.parameters.get("element_size", depth / 10)
        mesh, tags = mesh_of(points, depth, size, task.parameters.get("length", 12 * depth))
        c, alpha = water["sound_speed"], water["wave_reflection_coefficient"]
        basis = Basis(mesh, ElementQuad2())
        sides = [np.isin(mesh.facets, nodes).all(axis=0) for nodes in (tags[:, 0], tags[:, -1], tags[0], tags[-1])]
        face, end, bed, surface = (np.flatnonzero(side) for side in sides)
        on_end, on_bed = (asm(products, FacetBasis(mesh, basis.elem, facets=facets)) for facets in (end, bed))
        self.free = np.setdiff1d(np.arange(basis.N), basis.get_dofs(surface).all())
        mass = asm(products, basis) / c**2
        damping = on_end / c + on_bed * (1 - alpha) / ((1 + alpha) * c)
        of_free = [matrix[self.free][:, self.free].tocsc() for matrix in (mass, damping, asm(gradients, basis))]
        self.newmark = cofferdam.Newmark(*of_free)
        self.mapping, self.density = self.mapping_of(FacetBasis(mesh, basis.elem, facets=face), points), task.density
        self.velocity = np.zeros(len(points))

    def mapping_of(self, basis, points):
        """Between the points and the unknowns on the face: C = ∫ N φᵀ ds."""
        face, (x, y) = cofferdam.Face(points), basis.global_coordinates()
        hats = face.hats(x, y).reshape(*x.shape, -1)
        form = LinearForm(lambda v, w: w.hat * v)
        columns = [asm(form, basis, hat=hats[..., point]) for point in range(len(points))]
        return cofferdam.Mapping(face, np.stack(columns, axis=1)[self.free])

    def start(self, time, acceleration, ground_acceleration):
        # At rest with a velocity of zero, which then changes by the accelerations.
        return np.zeros(len(self.task.points))

    def step(self, time, communication_step, acceleration, ground_acceleration):
        if ground_acceleration[1] != 0:
            raise ValueError("the ground moves along y: a moving bed is not modelled here")
        self.velocity = self.velocity + communication_step * acceleration
        load = -self.density * self.mapping.to_own(self.velocity)
        _, pressure, _ = self.newmark.step(communication_step, load)
        return self.mapping.to_points(pressure)

    def save(self):
        return self.newmark.save(), self.velocity

    def restore(self, state):
        potential, self.velocity = state
        self.newmark.restore(potential)

    def serialise(self):
        return self.velocity.tobytes() + self.newmark.serialise()

    def deserialise(self, state):
        size = self.velocity.nbytes
        self.velocity = np.frombuffer(state[:size]).copy()
        self.newmark.deserialise(state[size:])


if __name__ == "__main__":
    cofferdam.serve(ScikitFemWater)
