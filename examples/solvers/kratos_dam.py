"""The dam of the scene with elements of Kratos Multiphysics: four-node quadrilaterals of small displacement.

Kratos computes the matrices of the elements; `cofferdam.Newmark` takes the steps. Other elements need another name in `ELEMENT`, as
long as they have two unknowns per node. Section, zones, material and Rayleigh damping are those of the scene; cracks are left out.
Parameter of the unit: `element_size` (m; that of the scene).
"""

import KratosMultiphysics as Kratos
import KratosMultiphysics.StructuralMechanicsApplication as Structural
import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import eigsh

import cofferdam

ELEMENT = "SmallDisplacementElement2D4N"
LAWS = {"stress": Structural.LinearElasticPlaneStress2DLaw, "strain": Structural.LinearElasticPlaneStrain2DLaw}


class KratosDam(cofferdam.Dam):
    outputs = ("interface_displacement", "interface_velocity", "interface_acceleration", "crest_displacement")

    def __init__(self, task):
        section, dam = cofferdam.Section(task.scene), task.scene["dam"]
        mesh = section.mesh(task.parameters.get("element_size"), task.points.y)
        whole, mass = self.matrices(section, mesh, dam["material"].get("plane", "stress"))
        self.free = np.setdiff1d(np.arange(whole.shape[0]), np.append(2 * mesh.base, 2 * mesh.base + 1))
        stiffness, own_mass = (matrix[self.free][:, self.free] for matrix in (whole, mass))
        start = np.ones(len(self.free))
        lowest = eigsh(stiffness, 1, own_mass, sigma=0, v0=start, return_eigenvectors=False)[0]
        alpha, beta = cofferdam.rayleigh(dam["damping"], np.sqrt(lowest))
        self.newmark = cofferdam.Newmark(own_mass, alpha * own_mass + beta * stiffness, stiffness)
        self.inertia = (mass @ np.tile(np.eye(2), (len(mesh.nodes), 1)))[self.free]
        # From the motion of all nodes to that of the face along n; the face runs up.
        face, points = mesh.upstream, task.points
        along = np.gradient(mesh.nodes[face], axis=0)
        normals = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        place = np.repeat(np.arange(len(face)), 2), np.stack([2 * face, 2 * face + 1], axis=1).ravel()
        self.along_n = csc_matrix((normals.ravel(), place), (len(face), whole.shape[0]))[:, self.free]
        self.mapping = cofferdam.Face(points).mapping(*mesh.nodes[face].T)
        self.normal = np.stack([points.normal_x, points.normal_y], axis=1)
        self.crest = np.searchsorted(self.free, [2 * face[-1], 2 * face[-1] + 1])
        self.ground = np.zeros(2)

    @staticmethod
    def matrices(section, mesh, plane):
        """Stiffness and mass of all nodes; unknowns 2 k and 2 k + 1 are x and y of node k."""
        part = Kratos.Model().CreateModelPart("dam")
        part.ProcessInfo[Kratos.DOMAIN_SIZE] = 2
        part.AddNodalSolutionStepVariable(Kratos.DISPLACEMENT)
        part.AddNodalSolutionStepVariable(Kratos.VOLUME_ACCELERATION)
        for tag, (x, y) in enumerate(mesh.nodes.tolist(), 1):
            part.CreateNewNode(tag, x, y, 0.0)
        x, y = mesh.nodes[mesh.quadrilaterals].mean(axis=1).T
        values = [section.material(name, x, y).tolist() for name in ("young_modulus", "poisson_ratio", "density")]
        entries, unknowns = [], []
        for tag, (nodes, young, poisson, density) in enumerate(zip(mesh.quadrilaterals, *values), 1):
            properties = part.CreateNewProperties(tag)
            properties[Kratos.YOUNG_MODULUS], properties[Kratos.POISSON_RATIO] = young, poisson
            properties[Kratos.DENSITY], properties[Kratos.THICKNESS] = density, 1.0
            properties[Kratos.CONSTITUTIVE_LAW] = LAWS[plane]()
            element = part.CreateNewElement(ELEMENT, tag, (nodes + 1).tolist(), properties)
            element.Initialize(part.ProcessInfo)
            stiffness, mass = Kratos.Matrix(), Kratos.Matrix()
            element.CalculateLeftHandSide(stiffness, part.ProcessInfo)
            element.CalculateMassMatrix(mass, part.ProcessInfo)
            entries.append((np.array(stiffness), np.array(mass)))
            unknowns.append(np.stack([2 * nodes, 2 * nodes + 1], axis=1).ravel())
        unknowns = np.array(unknowns)
        width = unknowns.shape[1]
        place = np.repeat(unknowns, width, axis=1).ravel(), np.tile(unknowns, (1, width)).ravel()
        return [csc_matrix((np.ravel([pair[kind] for pair in entries]), place), 2 * (2 * len(mesh.nodes),)) for kind in (0, 1)]

    def load(self, pressure, ground_acceleration):
        return self.along_n.T @ self.mapping.to_own(pressure) - self.inertia @ ground_acceleration

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        self.newmark.start(self.load(pressure, ground_acceleration))
        self.ground = ground_acceleration

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        before = self.newmark.velocity
        displacement, velocity, _ = self.newmark.step(communication_step, self.load(pressure, ground_acceleration))
        mean_ground, self.ground = 0.5 * (self.ground + ground_acceleration), ground_acceleration
        fields = displacement, velocity, (velocity - before) / communication_step
        displacement_n, velocity_n, mean = (self.mapping.to_points(self.along_n @ field) for field in fields)
        return displacement_n, velocity_n, mean + self.normal @ mean_ground, displacement[self.crest]

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
    cofferdam.serve(KratosDam)
