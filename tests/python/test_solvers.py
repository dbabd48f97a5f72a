"""What the package offers to units on other solvers, and the units of examples/solvers."""

import csv
import os
import subprocess
import sys
from dataclasses import replace

import cofferdam
import numpy as np
import pytest
import scipy.sparse
from fmus import ROOT, SCENES

EXAMPLES = ROOT / "examples" / "solvers"
sys.path[:0] = [str(EXAMPLES), str(ROOT / "tests" / "python")]
COFFERDAM = os.environ["COFFERDAM"]
COARSE = ["dam.element_size=10", "ground_motion.record.start=5", "ground_motion.record.end=6"]


def task(scene="koyna-intact", unit="dam", **parameters):
    return cofferdam.Task.of_scene(SCENES / scene, unit, COFFERDAM, **parameters)


def points(places):
    """Points of a face through these places; normals and lengths are not used."""
    x, y = np.array(places, float).T
    return cofferdam.Points(x, y, np.ones_like(x), np.zeros_like(x), np.ones_like(x))


def call(*arguments, status=0):
    done = subprocess.run([COFFERDAM, *arguments], capture_output=True, text=True)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout + done.stderr


def settings(**programs):
    """Options that replace units by programs of examples/solvers or of other folders."""
    for unit, program in programs.items():
        yield from ("--set", f"{unit}.fidelity=command")
        yield from ("--set", f"{unit}.command.argv=['{sys.executable}','-B','{EXAMPLES / program}']")


def run(folder, *arguments, scene="koyna-intact", until=0.15, changes=COARSE):
    options = [part for change in changes for part in ("--set", change)]
    return call("run", SCENES / scene, "--quiet", "--no-report", "--until", str(until), "--output", folder, *options, *arguments)


def column(folder, name, file="histories.csv"):
    """The last column whose title begins like this."""
    with open(folder / file) as lines:
        rows = list(csv.reader(lines))
    place = [i for i, title in enumerate(rows[0]) if title.startswith(name)][-1]
    return np.array([float(row[place]) for row in rows[1:]])


# The method of Newmark


@pytest.mark.parametrize("kind", [np.array, scipy.sparse.csr_array], ids=["dense", "sparse"])
def test_newmark_is_of_second_order_against_the_oscillator(kind):
    """m ü + c u̇ + k u = F sin(w t) from rest, against its closed form."""
    mass, ratio, omega, force, drive = 3.0, 0.1, 7.0, 2.0, 4.0
    damped = omega * np.sqrt(1 - ratio**2)
    steady = force / mass / (omega**2 - drive**2 + 2j * ratio * omega * drive)
    a, b = -steady.imag, -(drive * steady.real + ratio * omega * steady.imag) / damped
    free = lambda t: np.exp(-ratio * omega * t) * (a * np.cos(damped * t) + b * np.sin(damped * t))  # noqa: E731
    exact = (steady * np.exp(1j * drive * 2.0)).imag + free(2.0)
    errors = []
    for steps in (100, 200, 400):
        newmark = cofferdam.Newmark(*(kind([[value]]) for value in (mass, 2 * ratio * omega * mass, omega**2 * mass)))
        newmark.start(np.zeros(1))
        for n in range(1, steps + 1):
            newmark.step(2.0 / steps, np.array([force * np.sin(drive * n * 2.0 / steps)]))
        errors.append(abs(newmark.displacement[0] - exact))
    assert errors[0] < 2e-3 * abs(steady)
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 4.0, rtol=0.04)


def test_newmark_balances_energy_and_restores_every_bit():
    """Without damping the trapezoidal rule keeps the energy and the work of the load, whatever the lengths of the steps."""
    generator = np.random.default_rng(1)
    root = generator.normal(size=(6, 6))
    mass, stiffness = np.diag(generator.uniform(1, 2, 6)), root @ root.T + np.eye(6)
    newmark = cofferdam.Newmark(mass, 0 * mass, stiffness)
    loads, work = generator.normal(size=(40, 6)), 0.0
    newmark.start(loads[0])
    for n, (before, after) in enumerate(zip(loads, loads[1:])):
        start, saved, as_bytes = newmark.displacement, newmark.save(), newmark.serialise()
        length = 0.05 * (1 + n % 7)
        once = newmark.step(length, after)
        newmark.step(0.3, before)
        newmark.restore(saved)
        assert all(map(np.array_equal, once, newmark.step(length, after)))
        other = cofferdam.Newmark(mass, 0 * mass, stiffness)
        other.deserialise(as_bytes)
        assert all(map(np.array_equal, once, other.step(length, after)))
        work += (before + after) / 2 @ (newmark.displacement - start)
    u, v = newmark.displacement, newmark.velocity
    assert (v @ mass @ v + u @ stiffness @ u) / 2 == pytest.approx(work, rel=1e-12)
    np.testing.assert_allclose(stiffness @ newmark.static(loads[0]), loads[0], rtol=1e-9)
    with pytest.raises(ValueError, match="18 are needed"):
        newmark.deserialise(as_bytes[8:])


# The mapping

FACES = {
    "vertical": [(0, 0), (0, 3), (0, 5), (0, 9), (0, 10)],
    "kinked, with a crack": [(0, 0), (1, 4), (1.5, 6), (1.5, 6), (1.5, 8), (1.5, 10)],
}


@pytest.mark.parametrize("places", FACES.values(), ids=FACES.keys())
@pytest.mark.parametrize("count", [4, 33])
def test_mapping_conserves_force_and_work_and_keeps_constants(places, count):
    face = cofferdam.Face(points(places))
    length = face.position[-1]
    s = np.linspace(0, 1.2 * length, count) ** 1.2 / (1.2 * length) ** 0.2
    on_face = lambda axis: np.interp(s, face.position, np.array(places, float)[:, axis])  # noqa: E731
    x, y = on_face(0), on_face(1) + np.maximum(s - length, 0)
    mapping = face.mapping(x, y)
    generator = np.random.default_rng(2)
    pressure, own = generator.normal(size=len(places)), generator.normal(size=count)
    forces = mapping.to_own(pressure)
    position = face.position
    assert forces.sum() == pytest.approx(np.trapezoid(pressure, position), rel=1e-12)
    assert own @ forces == pytest.approx(mapping.to_points(own) @ face.mass @ pressure, rel=1e-12)
    np.testing.assert_allclose(mapping.to_points(np.full(count, 3.0)), 3.0, rtol=1e-12)
    # A linear field comes back exactly, and its interpolation too.
    np.testing.assert_allclose(mapping.to_points(s), position, atol=1e-9)
    np.testing.assert_allclose(face.hats(x, y)[s <= length] @ position, s[s <= length], atol=1e-9)
    assert not face.hats(x, y)[s > 1.001 * length].any()
    water = mapping.added_mass(cofferdam.westergaard(points(places), 10.0, 1000.0))
    np.testing.assert_allclose(water, water.T, atol=1e-9 * water.max())
    assert water.sum() == pytest.approx(7 / 12 * 1000.0 * 10.0**2, rel=0.03)  # 7/12 ρ h² along y


def test_mapping_refuses_nodes_that_do_not_fit():
    face = cofferdam.Face(points(FACES["vertical"]))
    with pytest.raises(ValueError, match=r"\(0.2, 5\) lies 0.2 m off the wet face"):
        face.mapping([0, 0.2, 0], [0, 5, 10])
    with pytest.raises(ValueError, match="ordered from the heel up"):
        face.mapping([0, 0, 0], [0, 10, 5])
    with pytest.raises(ValueError, match="cover all of it"):
        face.mapping([0, 0], [0, 8])


# The section


def test_a_mesh_fills_the_section_and_follows_levels_and_cracks():
    section = cofferdam.Section(task("koyna-two-cracks").scene)
    x, y = section.outline.T
    area = abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2
    mesh = section.mesh(levels=[12.3], with_cracks=True)
    corners = mesh.nodes[mesh.quadrilaterals]
    sides = np.roll(corners, -1, axis=1)
    areas = (corners[..., 0] * sides[..., 1] - corners[..., 1] * sides[..., 0]).sum(axis=1) / 2
    assert (areas > 0).all() and areas.sum() == pytest.approx(area, rel=1e-12)
    assert {12.3, 91.75, 66.5} <= set(np.round(mesh.nodes[:, 1], 9))
    assert len(mesh.joints) == 2
    for below, above in mesh.joints:
        assert (mesh.nodes[below] == mesh.nodes[above]).all() and not set(below) & set(above)
    # No element touches both sides of a joint.
    assert not any(set(e) & set(below) and set(e) & set(above) for e in mesh.quadrilaterals for below, above in mesh.joints)


def test_zones_have_their_own_material_and_the_last_one_applies():
    scene = task().scene
    scene["dam"]["zones"] = [
        {"name": "core", "polygon": [(0, 0), (40, 0), (40, 20), (0, 20)], "young_modulus": 1e9},
        {"name": "inner", "polygon": [(10, 5), (20, 5), (20, 15), (10, 15)], "young_modulus": 2e9, "density": 2000.0},
    ]
    section = cofferdam.Section(scene)
    x, y = np.array([15.0, 5.0, 50.0]), np.array([10.0, 10.0, 10.0])
    assert section.material("young_modulus", x, y).tolist() == [2e9, 1e9, 31e9]
    assert section.material("density", x, y).tolist() == [2000.0, 2640.0, 2640.0]


@pytest.mark.parametrize(
    "change, reason",
    [
        ({"upstream": [[0, 0], [0, 50], [1, 50], [1, 103]]}, "`dam.section.upstream` does not rise"),
        ({"galleries": [[[5, 5], [7, 5], [7, 7]]]}, "`dam.section.galleries`"),
        ({"downstream": [[70, 2], [14.8, 103]]}, "base and crest must be horizontal"),
    ],
)
def test_sections_that_rows_cannot_fill_are_refused(change, reason):
    scene = task().scene
    scene["dam"]["section"] |= change
    with pytest.raises(ValueError, match=reason):
        cofferdam.Section(scene).mesh()


# The units


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_examples_are_short(path):
    lines = path.read_text().splitlines()
    assert len(lines) < 150 and max(map(len, lines)) <= 140, path


def test_first_frequencies_are_those_to_which_the_built_in_dam_converges():
    from scikit_fem_dam import Discretisation

    own = Discretisation(task()).frequencies(4)
    errors = []
    for size in (10, 5, 2.5):
        told = call("check", SCENES / "koyna-intact", "--set", f"dam.element_size={size}")
        line = next(line for line in told.splitlines() if "natural frequencies" in line)
        built_in = np.array([float(value) for value in line.split(":")[1].removesuffix(" rad/s").split(",")])
        errors.append(built_in / own - 1)
    assert np.abs(errors[-1]).max() < 0.006
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (ratios > 2.2).all(), ratios


def repeated(unit, width):
    """Steps a unit, each step repeated from its saved state and in another object from its bytes."""
    generator = np.random.default_rng(3)
    inputs = lambda: [generator.normal(size=size) for size in width]  # noqa: E731
    unit.start(0.0, *inputs())
    other = type(unit)(unit.task)
    for n in range(6):
        given, wrong, saved, as_bytes = inputs(), inputs(), unit.save(), unit.serialise()
        length = unit.task.communication_step / (1 + n // 3)
        unit.step(0.01 * n, length, *wrong)
        unit.restore(saved)
        once = unit.step(0.01 * n, length, *given)
        other.deserialise(as_bytes)
        again = other.step(0.01 * n, length, *given)
        for one, two in zip(*(answer if isinstance(answer, tuple) else (answer,) for answer in (once, again))):
            assert np.array_equal(one, two) and np.any(one)


def test_dam_repeats_every_bit():
    from scikit_fem_dam import ScikitFemDam

    of_dam = task(element_size=20.0)
    n = len(of_dam.points)
    repeated(ScikitFemDam(of_dam), (n, n, 2))


def cracked(friction=1.0):
    from scikit_fem_cracked_dam import ScikitFemCrackedDam

    of_dam = task("koyna-coarse", element_size=15.0)
    of_dam.scene["dam"]["cracks"][0]["friction_coefficient"] = friction
    return ScikitFemCrackedDam(of_dam), 9810.0 * (91.75 - of_dam.points.y)


def test_cracked_dam_repeats_every_bit():
    unit, hydrostatic = cracked()
    start = unit.start
    unit.start = lambda time, pressure, _, ground: start(time, pressure, hydrostatic, ground)
    n = len(hydrostatic)
    repeated(unit, (n, n, 2))


def test_crack_carries_the_block_above_and_slides_against_friction():
    """At rest the contacts carry weight and water above 66.5 m; pushed beyond μ N the block accelerates by (F − μ N)/m."""
    friction, level, h, push = 0.25, 66.5, 0.0025, 2.0
    unit, hydrostatic = cracked(friction)
    still = np.zeros(len(hydrostatic))
    unit.start(0.0, still, hydrostatic, np.zeros(2))

    def carried():
        forces, *_ = unit.contacts.forces(unit.contacts.gaps @ unit.displacement, unit.slipped)
        return -forces.reshape(2, -1).sum(axis=1)

    mass = 2640.0 * (103 - level) * (19.25 + 14.8) / 2
    water = 9810.0 * (91.75 - level) ** 2 / 2
    np.testing.assert_allclose(carried() * [1, -1], (mass * 9.81, water), rtol=1e-6)
    above = unit.inertia[:, 0] * (unit.model.basis.doflocs[1, unit.model.free] > level + 0.1)
    velocities = []
    for k in range(1, 161):
        # The ground leaves the block behind, downstream.
        unit.step(k * h, h, still, hydrostatic, np.array([-push * min(k / 40, 1.0), 0.0]))
        velocities.append(above @ unit.velocity / above.sum())
        normal, shear = carried()
        assert abs(shear) <= friction * normal * (1 + 1e-9)
    # The mass part of the damping takes α v.
    alpha = cofferdam.rayleigh(unit.task.scene["dam"]["damping"], 18.9)[0]
    expected = push + water / mass - friction * 9.81 - alpha * np.mean(velocities[60:])
    assert (velocities[-1] - velocities[60]) / (99 * h) == pytest.approx(expected, rel=0.05)


def water(**changes):
    from scikit_fem_water import ScikitFemWater

    of_water = task(unit="reservoir")
    of_water.scene["reservoir"] |= changes
    return ScikitFemWater(of_water)


def test_water_repeats_every_bit():
    from scikit_fem_water import ScikitFemWater

    class OnLevelGround(ScikitFemWater):
        def step(self, time, communication_step, acceleration, ground_acceleration):
            return super().step(time, communication_step, acceleration, ground_acceleration * [1, 0])

    of_water = task(unit="reservoir")
    repeated(OnLevelGround(of_water), (len(of_water.points), 2))


def test_water_is_a_plane_wave_at_the_heel_until_the_surface_is_heard():
    unit, h, c = water(wave_reflection_coefficient=1.0), 0.0025, 1440.0
    velocity = 0.0
    for n in range(20):  # 0.05 s; waves from the surface need 0.064 s
        mean = (np.sin(np.pi * (n + 1) / 24) - np.sin(np.pi * n / 24)) / h
        velocity += h * mean
        pressure = unit.step(n * h, h, np.full(len(unit.task.points), mean), np.zeros(2))
        if n > 6:
            assert pressure[0] == pytest.approx(-1000.0 * c * velocity, abs=0.03 * 1000.0 * c)


def test_slow_motion_meets_the_added_mass_of_incompressible_water():
    """Total force 0.543 ρ h² a of Westergaard's series, which a sound speed far above all frequencies leaves alone."""
    unit, h = water(sound_speed=3e4, wave_reflection_coefficient=0.5), 0.01
    depth, forces = unit.task.depth, []
    for n in range(60):
        mean = np.full(len(unit.task.points), min((n + 0.5) / 30, 1.0))
        pressure = unit.step(n * h, h, mean, np.zeros(2))
        forces.append(np.trapezoid(pressure, unit.task.points.y))
    assert np.mean(forces[-20:]) == pytest.approx(-0.543 * 1000.0 * depth**2, rel=0.01)


def test_water_refuses_what_it_does_not_model():
    with pytest.raises(ValueError, match="`reservoir.surface_waves`: gravity waves"):
        water(surface_waves=True)
    unit = water()
    with pytest.raises(ValueError, match="along y"):
        unit.step(0.0, 0.01, np.zeros(len(unit.task.points)), np.array([0.0, 1.0]))
    from scikit_fem_water import ScikitFemWater

    with pytest.raises(ValueError, match='must be "mean"'):
        ScikitFemWater(replace(task(unit="reservoir"), acceleration="end"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run of 0.15 s of strong motion with the dam on scikit-fem."""
    folder = tmp_path_factory.mktemp("whole") / "whole"
    run(folder, *settings(dam="scikit_fem_dam.py"))
    return folder


def test_dam_and_water_agree_with_the_built_in_units(tmp_path):
    run(tmp_path / "own", *settings(dam="scikit_fem_dam.py", reservoir="scikit_fem_water.py"))
    fine = [change.replace("dam.element_size=10", "dam.element_size=2.5") for change in COARSE]
    run(tmp_path / "built-in", "--transport", "in-process", changes=fine)
    own, built_in = (column(tmp_path / name, "dam.crest_displacement.x") for name in ("own", "built-in"))
    assert len(own) == len(built_in) == 61 and np.abs(built_in).max() > 2e-3
    assert np.linalg.norm(own - built_in) < 0.02 * np.linalg.norm(built_in)


def test_resumed_and_branched_runs_have_the_same_bits(whole, tmp_path):
    run(tmp_path / "stopped", *settings(dam="scikit_fem_dam.py"), until=0.05)
    call("resume", tmp_path / "stopped", "--quiet", "--no-report", "--until", "0.15")
    call("branch", whole, "--quiet", "--no-report", "--step", "41", "--until", "0.15", "--output", tmp_path / "branch")
    expected = (whole / "histories.csv").read_text()
    assert (tmp_path / "stopped" / "histories.csv").read_text() == expected
    assert (tmp_path / "branch" / "histories.csv").read_text().splitlines()[-20:] == expected.splitlines()[-20:]


def test_a_part_of_a_run_is_replayed_bit_for_bit(whole):
    assert "dam: identical" in call("replay", whole, "--quiet", "--unit", "dam", "--from", "50")


def test_a_dam_without_state_is_refused_before_the_run_and_works_with_explicit_schemes(whole, tmp_path):
    dam = list(settings(dam=ROOT / "tests" / "python" / "stateless_dam.py"))
    told = run_refused(tmp_path / "implicit", *dam)
    assert "dam cannot save its state" in told and not (tmp_path / "implicit" / "histories.csv").exists()
    run(tmp_path / "explicit", *dam, "--set", "coupling.scheme=serial-explicit")
    own, other = (column(folder, "point", "dam-interface_displacement.csv") for folder in (tmp_path / "explicit", whole))
    assert np.linalg.norm(own - other) < 0.01 * np.linalg.norm(other)


def run_refused(folder, *arguments):
    options = [part for change in COARSE for part in ("--set", change)]
    command = ["run", SCENES / "koyna-intact", "--quiet", "--output", folder, *options, *arguments]
    done = subprocess.run([COFFERDAM, *command], capture_output=True, text=True)
    assert done.returncode != 0
    return done.stdout + done.stderr


def test_water_without_memory_moves_with_a_dam_without_state(tmp_path):
    """In the added-mass scheme, against the built-in dam on a mesh fine enough."""
    memoryless = ["reservoir.fidelity=westergaard", "coupling.scheme=added-mass"]
    dam = list(settings(dam=ROOT / "tests" / "python" / "stateless_dam.py"))
    dam += ["--set", "dam.command.parameters.added_mass=westergaard"]
    changes = [change for change in COARSE if "element_size" not in change] + memoryless
    run(tmp_path / "own", *dam, changes=[*changes, "dam.element_size=5"])
    run(tmp_path / "built-in", "--transport", "in-process", changes=[*changes, "dam.element_size=2.5"])
    own, built_in = (column(tmp_path / name, "point", "dam-interface_displacement.csv") for name in ("own", "built-in"))
    assert np.abs(built_in).max() > 2e-3
    assert np.linalg.norm(own - built_in) < 0.02 * np.linalg.norm(built_in)
