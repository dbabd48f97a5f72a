"""The dam of the scene in OpenSees: four-node quadrilaterals (SSPquad), lumped mass, Rayleigh damping, average acceleration.

The unit keeps displacement, velocity and acceleration of all nodes and hands them to OpenSees before each step, so that a step
depends on nothing else: states are exact, and are bytes. The material is elastic, without a history of its own. Section, zones,
material and damping are those of the scene; cracks are left out. Parameter of the unit: `element_size` (m; that of the scene).

openseespy needs the libraries libblas3, liblapack3 and libgfortran5.
"""

import numpy as np
import openseespy.opensees as ops

import cofferdam

MOTIONS = ops.setNodeDisp, ops.setNodeVel, ops.setNodeAccel
MOTIONS_OF = ops.nodeDisp, ops.nodeVel, ops.nodeAccel


class OpenSeesDam(cofferdam.Dam):
    outputs = ("interface_displacement", "interface_velocity", "interface_acceleration", "crest_displacement")

    def __init__(self, task):
        section, dam = cofferdam.Section(task.scene), task.scene["dam"]
        self.mesh = section.mesh(task.parameters.get("element_size"), task.points.y)
        self.masses = self.build(section, dam["material"].get("plane", "stress"))
        self.damping(dam["damping"])
        face, points = self.mesh.upstream, task.points
        self.mapping = cofferdam.Face(points).mapping(*self.mesh.nodes[face].T)
        self.normals = self.face_normals(face)
        self.normal = np.stack([points.normal_x, points.normal_y], axis=1)
        self.ground, self.motion = np.zeros(2), np.zeros((3, *self.mesh.nodes.shape))

    def build(self, section, plane):
        """Nodes, elements and lumped masses, kg/m. Tags are indices plus one."""
        ops.wipe()
        ops.model("basic", "-ndm", 2, "-ndf", 2)
        nodes, corners = self.mesh.nodes, self.mesh.nodes[self.mesh.quadrilaterals]
        for tag, place in enumerate(nodes, 1):
            ops.node(tag, *map(float, place))
        x, y = corners.mean(axis=1).T
        young, poisson, density = (section.material(name, x, y) for name in ("young_modulus", "poisson_ratio", "density"))
        for tag, (element, *material) in enumerate(zip(self.mesh.quadrilaterals, young, poisson), 1):
            ops.nDMaterial("ElasticIsotropic", tag, *map(float, material))
            ops.element("SSPquad", tag, *(int(node) + 1 for node in element), tag, f"Plane{plane.capitalize()}", 1.0)
        first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
        area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2
        masses = np.bincount(self.mesh.quadrilaterals.ravel(), np.repeat(density * area / 4, 4), len(nodes))
        for tag, mass in enumerate(masses, 1):
            ops.mass(tag, float(mass), float(mass))
        for node in self.mesh.base:
            ops.fix(int(node) + 1, 1, 1)
        return masses

    def damping(self, damping):
        alpha, beta = cofferdam.rayleigh(damping, np.sqrt(ops.eigen("-genBandArpack", 1)[0]))
        ops.rayleigh(float(alpha), 0.0, float(beta), 0.0)

    def face_normals(self, face):
        """n at the nodes of the face, into the dam; the face runs up."""
        along = np.gradient(self.mesh.nodes[face], axis=0)
        return np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]

    def loads(self, pressure, ground_acceleration):
        forces = -self.masses[:, None] * ground_acceleration
        forces[self.mesh.upstream] += self.mapping.to_own(pressure)[:, None] * self.normals
        return forces

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        # At rest the masses, which are lumped, take the whole load.
        self.motion[2] = self.loads(pressure, ground_acceleration) / self.masses[:, None]
        self.motion[2, self.mesh.base] = 0.0
        self.ground = ground_acceleration

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        before, forces = self.motion[1], self.loads(pressure, ground_acceleration)
        self.analyse(communication_step, forces)
        mean_ground, self.ground = 0.5 * (self.ground + ground_acceleration), ground_acceleration
        displacement, velocity, acceleration = (
            self.mapping.to_points((field[self.mesh.upstream] * self.normals).sum(axis=1))
            for field in (self.motion[0], self.motion[1], (self.motion[1] - before) / communication_step)
        )
        crest = self.motion[0, self.mesh.upstream[-1]]
        return displacement, velocity, acceleration + self.normal @ mean_ground, crest

    def analyse(self, length, forces):
        ops.remove("loadPattern", 1)
        ops.remove("timeSeries", 1)
        ops.timeSeries("Constant", 1)
        ops.pattern("Plain", 1, 1)
        for tag, force in enumerate(forces.tolist(), 1):
            ops.load(tag, *force)
        for put, field in zip(MOTIONS, self.motion.tolist()):
            for tag, (x, y) in enumerate(field, 1):
                put(tag, 1, x, "-commit")
                put(tag, 2, y, "-commit")
        ops.setTime(0.0)
        # A new integrator takes the motion of the nodes as its own.
        ops.wipeAnalysis()
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("SparseGEN")
        ops.algorithm("Linear")
        ops.integrator("Newmark", 0.5, 0.25)
        ops.analysis("Transient")
        if ops.analyze(1, length) != 0:
            raise RuntimeError("OpenSees fails to solve the step")
        self.motion = np.array([[get(tag) for tag in range(1, len(forces) + 1)] for get in MOTIONS_OF])

    def save(self):
        return self.motion, self.ground

    def restore(self, state):
        self.motion, self.ground = state

    def serialise(self):
        return np.append(self.motion, self.ground).tobytes()

    def deserialise(self, state):
        values = np.frombuffer(state).copy()
        self.motion, self.ground = values[:-2].reshape(self.motion.shape), values[-2:]


if __name__ == "__main__":
    cofferdam.serve(OpenSeesDam)
