"""The dam of the scene on scikit-fem: quadratic quadrilaterals of nine nodes, plane stress or strain, average acceleration.

Section, zones, material and Rayleigh damping are those of the scene, and so is the element size, unless the unit's parameter
`element_size` (m) gives another. Cracks are left out: the dam is intact and linear. The base is fixed to the ground.
"""

import numpy as np
from scipy.sparse.linalg import eigsh
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad, asm
from skfem.helpers import dot, sym_grad, trace
from skfem.models.elasticity import BilinearForm, ddot

import cofferdam


def moduli(young, poisson, plane):
    """Lamé's coefficients λ and μ of the plane problem, Pa."""
    shear = young / (2 * (1 + poisson))
    return young * poisson / ((1 + poisson) * (1 - poisson if plane == "stress" else 1 - 2 * poisson)), shear


@BilinearForm
def stiffness_form(u, v, w):
    strain, virtual = sym_grad(u), sym_grad(v)
    return w.lame * trace(strain) * trace(virtual) + 2 * w.shear * ddot(strain, virtual)


@BilinearForm
def mass_form(u, v, w):
    return w.density * dot(u, v)


class Discretisation:
    """Matrices of a mesh of the scene's section: without boundary conditions, and of the unknowns above the fixed base."""

    def __init__(self, task, with_cracks=False):
        section, dam = cofferdam.Section(task.scene), task.scene["dam"]
        self.parts = section.mesh(task.parameters.get("element_size"), task.points.y, with_cracks)
        self.mesh = MeshQuad(self.parts.nodes.T.copy(), self.parts.quadrilaterals.T.copy())
        self.basis = Basis(self.mesh, ElementVector(ElementQuad2()))
        x, y = self.basis.global_coordinates()
        young, poisson, density = (section.material(name, x, y) for name in ("young_modulus", "poisson_ratio", "density"))
        lame, shear = moduli(young, poisson, dam["material"].get("plane", "stress"))
        self.stiffness = asm(stiffness_form, self.basis, lame=lame, shear=shear)
        self.mass = asm(mass_form, self.basis, density=density)
        on_base = np.isin(self.mesh.facets, self.parts.base).all(axis=0)
        self.free = np.setdiff1d(np.arange(self.basis.N), self.basis.get_dofs(np.flatnonzero(on_base)).all())

    def frequencies(self, count=1):
        """The lowest ones of the dam without water, rad/s."""
        # A fixed start: the same bits in every process.
        start = np.ones(len(self.free))
        values = eigsh(self.of_free(self.stiffness), count, self.of_free(self.mass), sigma=0, v0=start, return_eigenvectors=False)
        return np.sqrt(np.sort(values))

    def of_free(self, matrix):
        return matrix[self.free][:, self.free].tocsc()

    def translations(self):
        """Rigid unit motions along x and y."""
        motions = np.zeros((self.basis.N, 2))
        for kind in (self.basis.nodal_dofs, self.basis.facet_dofs, self.basis.interior_dofs):
            motions[kind[0], 0] = motions[kind[1], 1] = 1.0
        return motions

    def mapping(self, face):
        """Between the pressure or motion along n at the points and forces or motion of the unknowns: C = ∫ (N · n) φᵀ ds."""
        on_face = np.isin(self.mesh.facets, self.parts.upstream).all(axis=0)
        basis = FacetBasis(self.mesh, self.basis.elem, facets=np.flatnonzero(on_face))
        x, y = basis.global_coordinates()
        hats = face.hats(x, y).reshape(*x.shape, -1)
        # The outward normal of the dam points into the water.
        form = LinearForm(lambda v, w: -w.hat * dot(v, w.n))
        columns = [asm(form, basis, hat=hats[..., point]) for point in range(hats.shape[-1])]
        return cofferdam.Mapping(face, np.stack(columns, axis=1)[self.free])


class ScikitFemDam(cofferdam.Dam):
    outputs = ("interface_displacement", "interface_velocity", "interface_acceleration", "crest_displacement")
    with_cracks = False

    def __init__(self, task):
        model = self.model = Discretisation(task, self.with_cracks)
        self.mass, self.stiffness = model.of_free(model.mass), model.of_free(model.stiffness)
        intact = Discretisation(task) if self.with_cracks else model
        alpha, beta = cofferdam.rayleigh(task.scene["dam"]["damping"], intact.frequencies()[0])
        self.damping = alpha * self.mass + beta * self.stiffness
        self.newmark = cofferdam.Newmark(self.mass, self.damping, self.stiffness)
        self.inertia = (model.mass @ model.translations())[model.free]
        self.mapping = model.mapping(cofferdam.Face(task.points))
        self.crest = np.searchsorted(model.free, model.basis.nodal_dofs[:, model.parts.upstream[-1]])
        self.normal = np.stack([task.points.normal_x, task.points.normal_y], axis=1)

    def load(self, pressure, ground_acceleration):
        return self.mapping.to_own(pressure) - self.inertia @ ground_acceleration

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        self.newmark.start(self.load(pressure, ground_acceleration))
        self.ground = ground_acceleration

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        before = self.newmark.velocity
        displacement, velocity, _ = self.newmark.step(communication_step, self.load(pressure, ground_acceleration))
        return self.motion(displacement, velocity, (velocity - before) / communication_step, ground_acceleration)

    def motion(self, displacement, velocity, mean_acceleration, ground_acceleration):
        """The outputs of a step; the acceleration along n is the total one, its mean over the step."""
        mean_ground, self.ground = 0.5 * (self.ground + ground_acceleration), ground_acceleration
        relative = (self.mapping.to_points(field) for field in (displacement, velocity, mean_acceleration))
        displacement_n, velocity_n, acceleration_n = relative
        return displacement_n, velocity_n, acceleration_n + self.normal @ mean_ground, displacement[self.crest]

    def save(self):
        return self.newmark.save(), self.ground

    def restore(self, state):
        motion, self.ground = state
        self.newmark.restore(motion)

    def serialise(self):
        return self.ground.tobytes() + self.newmark.serialise()

    def deserialise(self, state):
        self.ground = np.frombuffer(state[:16]).copy()
        self.newmark.deserialise(state[16:])


if __name__ == "__main__":
    cofferdam.serve(ScikitFemDam)
