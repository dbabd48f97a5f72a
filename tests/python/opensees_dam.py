"""The intact Koyna dam with compressible water in OpenSees, beside cofferdam: python opensees_dam.py COFFERDAM SCENE FOLDER.

Dam: enhanced four-node quadrilaterals in plane stress. Water: acoustic quadrilaterals (FSIFluidElement2D), joined to the
upstream face by FSIInterfaceElement2D; bed and far end by FSIFluidBoundaryElement2D, q = (1 − α)/((1 + α) c). Unknowns are
displacements relative to the ground and the pressure; steps by the average acceleration method. Nothing but the record and the
scene's numbers is common to both programs. It needs openseespy and numpy, and the libraries libblas3, liblapack3, libgfortran5.
"""

import csv
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import openseespy.opensees as ops

STANDARD_GRAVITY = 9.80665  # m/s², of records in g
LIMIT = 0.02  # of the relative L2 difference of the crest


class Model:
    """Dam, and water of the given length if it is not 0, in OpenSees; `size` is the elements' height in m."""

    def __init__(self, scene, size, length=0.0, reflection=1.0, water_size=5.0):
        dam, water = scene["dam"], scene["reservoir"]
        self.water = water
        upstream, downstream = [np.array(dam["section"][side]) for side in ("upstream", "downstream")]
        assert not upstream[:, 0].any(), "the upstream face is vertical at x = 0"
        levels = sorted({*downstream[:, 1], water["depth"]})
        parts = [np.linspace(a, b, round((b - a) / size + 0.5), endpoint=False) for a, b in zip(levels, levels[1:])]
        self.y = np.append(np.concatenate(parts), levels[-1])
        self.columns = round(downstream[0, 0] / size / 2)
        ops.wipe()
        self._dam(dam["material"], np.interp(self.y, downstream[:, 1], downstream[:, 0]))
        if length > 0:
            wet = int(np.searchsorted(self.y, water["depth"])) + 1
            self._water(self.y[:wet], np.linspace(0, -length, round(length / water_size) + 1), reflection)

    def _dam(self, material, width):
        ops.model("basic", "-ndm", 2, "-ndf", 2)
        ops.nDMaterial("ElasticIsotropic", 1, material["young_modulus"], material["poisson_ratio"], material["density"])
        rows, columns = len(self.y), self.columns
        tag = lambda row, column: 1 + row * (columns + 1) + column  # noqa: E731
        self.crest = tag(rows - 1, 0)
        self.face = [tag(row, 0) for row in range(rows)]
        self.places = {}
        for row in range(rows):
            for column in range(columns + 1):
                self.places[tag(row, column)] = (width[row] * column / columns, self.y[row])
                ops.node(tag(row, column), *map(float, self.places[tag(row, column)]))
        self.base = [tag(0, column) for column in range(columns + 1)]
        self.mass = dict.fromkeys(self.places, 0.0)
        self.elements = 0
        for row in range(rows - 1):
            for column in range(columns):
                corners = [tag(row, column), tag(row, column + 1), tag(row + 1, column + 1), tag(row + 1, column)]
                self.elements += 1
                ops.element("enhancedQuad", self.elements, *corners, 1.0, "PlaneStress2D", 1)
                for corner, area in zip(corners, corner_areas([self.places[c] for c in corners])):
                    self.mass[corner] += material["density"] * area
        self.nodes = len(self.places)

    def _water(self, y, x, reflection):
        c, density = float(self.water["sound_speed"]), self.water["density"]
        # The joints between dam and water carry displacements and pressure: dam and water follow them.
        ops.model("basic", "-ndm", 2, "-ndf", 3)
        joints = [self.nodes + 1 + row for row in range(len(y))]
        for joint, height in zip(joints, y):
            ops.node(joint, 0.0, float(height))
        self.pressure_load = dict.fromkeys(joints, 0.0)
        for below, above, a, b in zip(joints, joints[1:], y, y[1:]):
            self.elements += 1
            ops.element("FSIInterfaceElement2D", self.elements, below, above, density)  # n = (1, 0): into the dam
            for joint in (below, above):
                self.pressure_load[joint] += density * (b - a) / 2
        self.heel = joints[0]
        ops.fix(self.heel, 1, 1, 0)
        ops.fix(joints[-1], 0, 0, 1)
        for joint, node in zip(joints, self.face):
            ops.equalDOF_Mixed(joint, node, 2, 1, 1, 2, 2)
        self.base = self.base[1:]

        ops.model("basic", "-ndm", 2, "-ndf", 1)
        first = joints[-1] + 1
        tag = lambda row, column: first + column * len(y) + row  # noqa: E731
        for column, abscissa in enumerate(x):
            for row, height in enumerate(y):
                ops.node(tag(row, column), float(abscissa), float(height))
            if column > 0:
                ops.fix(tag(len(y) - 1, column), 1)
        for row, joint in enumerate(joints):
            ops.equalDOF_Mixed(joint, tag(row, 0), 1, 3, 1)
        for column in range(len(x) - 1):
            for row in range(len(y) - 1):
                self.elements += 1
                corners = [tag(row, column + 1), tag(row, column), tag(row + 1, column), tag(row + 1, column + 1)]
                ops.element("FSIFluidElement2D", self.elements, *corners, c)
        end = len(x) - 1
        edges = [(tag(0, column), tag(0, column + 1), reflection) for column in range(end)]
        edges += [(tag(row, end), tag(row + 1, end), 0.0) for row in range(len(y) - 1)]
        for one, other, alpha in edges:
            self.elements += 1
            ops.element("FSIFluidBoundaryElement2D", self.elements, one, other, c, float(alpha), 0.0)

    def frequencies(self, count=4):
        """Of the dam alone, rad/s."""
        for node in self.base:
            ops.fix(node, 1, 1)
        return np.sqrt(ops.eigen("-genBandArpack", count))

    def run(self, ground, interval, step, duration, rayleigh):
        """x of the crest relative to the ground, m, and the pressure at the heel, Pa, at every step from 0 on.

        The ground's acceleration is a load −M r, −ρ ∫ N n_x ds on the pressures: the program's own uniform excitation
        would accelerate the pressures as if they were displacements along x.
        """
        for node in self.base:
            ops.fix(node, 1, 1)
        ops.rayleigh(rayleigh[0], 0.0, rayleigh[1], 0.0)
        ops.timeSeries("Path", 1, "-dt", interval, "-values", *map(float, ground), 0.0)
        ops.pattern("Plain", 1, 1)
        for node, mass in self.mass.items():
            ops.load(node, -mass, 0.0)
        for joint, load in self.pressure_load.items():
            ops.load(joint, 0.0, 0.0, -load)
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("SparseGEN")
        ops.test("NormDispIncr", 1e-12, 1)
        ops.algorithm("Linear", "-factorOnce")
        ops.integrator("Newmark", 0.5, 0.25)
        ops.analysis("Transient")
        history = [(0.0, 0.0)]
        for _ in range(round(duration / step)):
            if ops.analyze(1, step) != 0:
                raise RuntimeError(f"OpenSees fails at {ops.getTime()} s")
            history.append((ops.nodeDisp(self.crest, 1), ops.nodeDisp(self.heel, 3)))
        return np.array(history).T


def corner_areas(corners):
    """∫ N dA of the four shape functions of a quadrilateral."""
    corners, areas = np.array(corners), np.zeros(4)
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    for point in signs / np.sqrt(3):
        shape = (1 + signs * point).prod(axis=1) / 4
        slope = signs * (1 + signs * point)[:, ::-1] / 4
        areas += shape * np.linalg.det(slope.T @ corners)
    return areas


def rayleigh_coefficients(damping, first):
    """α_M and β_K with the wanted ratio at two multiples of the first frequency."""
    low, high = [multiple * first for multiple in damping["multiples_of_first"]]
    return 2 * damping["ratio"] * low * high / (low + high), 2 * damping["ratio"] / (low + high)


def l2(history, reference):
    return np.linalg.norm(history - reference) / np.linalg.norm(reference)


class Comparison:
    """One motion of the ground and one bed in both programs."""

    def __init__(self, cofferdam, file, folder, reflection, start, duration):
        self.cofferdam, self.file, self.folder = cofferdam, file, folder
        self.reflection, self.start, self.duration = reflection, start, duration
        self.scene = tomllib.loads((file / "scene.toml").read_text())
        times, record = np.loadtxt(
            file / self.scene["ground_motion"]["record"]["file"], delimiter=",", comments=("#", "t"), unpack=True
        )
        self.interval = times[1] - times[0]
        first, last = round(start / self.interval), round((start + duration) / self.interval)
        self.ground = record[first : last + 1] * STANDARD_GRAVITY

    def with_cofferdam(self, size):
        """Crest and base pressure, at communication steps of the scene."""
        name = self.folder / f"{self.reflection}-{size}"
        settings = [
            "dam.fidelity=intact",
            f"dam.element_size={size}",
            f"reservoir.wave_reflection_coefficient={self.reflection}",
            f"ground_motion.record.start={self.start}",
            f"time.duration={self.duration}",
        ]
        options = [part for setting in settings for part in ("--set", setting)]
        command = [self.cofferdam, "run", self.file, "--quiet", "--transport", "in-process", "--output", name, *options]
        with open(self.folder / f"{name.name}.txt", "w") as told:
            subprocess.run(command, check=True, stdout=told, stderr=told)
        with open(name / "histories.csv") as file:
            rows = list(csv.reader(file))
        places = [rows[0].index(title) for title in ("dam.crest_displacement.x [m]", "reservoir.base_pressure [Pa]")]
        return np.array([[float(row[place]) for row in rows[1:]] for place in places])

    def with_opensees(self, size=2.5, depths=3.0, water_size=5.0, step=0.0025):
        first = Model(self.scene, size).frequencies()[0]
        model = Model(self.scene, size, depths * self.scene["reservoir"]["depth"], self.reflection, water_size)
        rayleigh = rayleigh_coefficients(self.scene["dam"]["damping"], first)
        return model.run(self.ground, self.interval, step, self.duration, rayleigh)

    def report(self, what, ours, theirs):
        """Prints how far two results are apart; the longer steps are those of OpenSees."""
        every = round((ours.shape[1] - 1) / (theirs.shape[1] - 1))
        crest, pressure = [l2(one[::every], other) for one, other in zip(ours, theirs)]
        peaks = [100 * (at(ours[0]) / at(theirs[0]) - 1) for at in (np.max, np.min)]
        print(
            f"{what:<70} crest L2 {100 * crest:6.2f} %, peaks {peaks[0]:+.2f}, {peaks[1]:+.2f} %, "
            f"base pressure L2 {100 * pressure:6.2f} %",
            flush=True,
        )
        return crest


def main(cofferdam, file, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    scene = tomllib.loads((file / "scene.toml").read_text())
    for size in (5.0, 2.5, 1.25):
        print(f"OpenSees, {size} m: dam alone, rad/s:", *[f"{omega:.2f}" for omega in Model(scene, size).frequencies()])

    bed = Comparison(cofferdam, file, folder, reflection=0.5, start=0.0, duration=25.0)
    ours = {size: bed.with_cofferdam(size) for size in (5.0, 2.5, 1.25)}
    theirs = bed.with_opensees()
    print("Bed of 0.5, the whole record; OpenSees 2.5 m, water of 3 depths, steps of 2.5 ms")
    apart = [bed.report(f"cofferdam, {size} m", ours[size], theirs) for size in ours]
    coarse = bed.with_opensees(step=0.005)
    bed.report("cofferdam, 1.25 m; OpenSees in steps of 5 ms", ours[1.25], coarse)
    variants = {
        "water of 1.5 depths": {"depths": 1.5},
        "water of 6 depths": {"depths": 6.0},
        "elements of 1.25 m, water's 2.5 m long": {"size": 1.25, "water_size": 2.5},
    }
    for what, change in variants.items():
        bed.report(f"OpenSees against itself, 5 ms: {what}", coarse, bed.with_opensees(step=0.005, **change))

    rigid = Comparison(cofferdam, file, folder, reflection=1.0, start=4.0, duration=4.0)
    # Waves need the whole 4 s to the far end and back.
    depths = 2.0 * scene["reservoir"]["sound_speed"] / scene["reservoir"]["depth"] + 0.1
    theirs = rigid.with_opensees(depths=depths)
    print(f"Rigid bed, 4 s from 4 s on; OpenSees 2.5 m, water of {depths:.0f} depths, steps of 2.5 ms")
    apart.append(rigid.report("cofferdam, 1.25 m", rigid.with_cofferdam(1.25), theirs))
    if max(apart[-2:]) > LIMIT:
        sys.exit(f"the crest is {100 * max(apart[-2:]):.2f} % apart, more than {100 * LIMIT:g} %")


if __name__ == "__main__":
    main(*[Path(argument).resolve() for argument in sys.argv[1:]])
