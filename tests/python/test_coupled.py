"""Dam and reservoir as one coupled FMU of FMI 2.0 and 3.0, compared with `cofferdam run`."""

import csv
import gc
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import threading
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmus import COARSE_HALF_SECOND, SCENES, H, Scalars, pack, settings, start_value

STEPS = 204  # half a second of the record, and the steps in which it falls to zero
REQUIRED = {
    *("crest_displacement.x", "crest_acceleration.y", "crack[1].sliding", "crack[1].shear_force", "base_shear"),
    *("major_principal_stress[4]", "base_pressure", "total_force", "iterations", "converged", "residual"),
    *("interface_work", "interface_energy_produced", "lowest_pressure", "interpolation_error", "friction_work"),
}


def name_of(column):
    """Name of a column of histories.csv in the coupled FMU, without its unit."""
    name = column.split(" [")[0].removeprefix("dam.").removeprefix("reservoir.")
    if column.startswith("residual.pressure"):
        return "residual"
    if found := re.fullmatch(r"crack_(\w+)\.(\d+)", name):
        return f"crack[{int(found[2]) + 1}].{found[1]}"
    if found := re.fullmatch(r"(\w+)\.(\d+)", name):
        return f"{found[1]}[{int(found[2]) + 1}]"
    return name


def columns(path, name):
    with open(path, newline="") as file:
        head, *rows = csv.reader(file)
    return {name(column): [float(row[i]) for row in rows] for i, column in enumerate(head)}


def simulated(folder, overrides=(), scene="koyna-coarse", base=COARSE_HALF_SECOND, until=1.0):
    """Histories of a run by the names of the coupled FMU, and its ground acceleration."""
    command = [os.environ["COFFERDAM"], "run", SCENES / scene, "--transport", "in-process", "--quiet", "--no-report"]
    command += ["--log", "none", "--until", str(until), "--output", folder, *settings([*base, *overrides])]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = columns(folder / "histories.csv", name_of)
    points = columns(folder / "reservoir-interface_pressure.csv", lambda column: column.split(" [")[0])
    for name, values in points.items():
        if name != "time":
            found[f"interface_pressure[{int(name.split()[1]) + 1}]"] = values
    return found, found["ground_acceleration.x"]


@pytest.fixture(scope="session")
def histories(tmp_path_factory):
    return simulated(tmp_path_factory.mktemp("histories") / "out")


@pytest.fixture(scope="session")
def folders(tmp_path_factory):
    """The coupled FMU, unpacked, by version of FMI."""
    folder = tmp_path_factory.mktemp("coupled")
    found = {}
    for version in (2, 3):
        path = pack(folder, "coupled", COARSE_HALF_SECOND, options=["--fmi", str(version)])
        found[version] = Path(fmpy.extract(path, unzipdir=folder / f"fmi{version}"))
    return found


@pytest.fixture(params=[2, 3])
def folder(request, folders):
    """The coupled FMU of each version of FMI, unpacked."""
    return folders[request.param]


def drive(unit, n):
    """Sets the input for the end of step `n`: strong enough to open the crack."""
    unit.set("ground_acceleration", 8.0 * np.sin(0.07 * n) * (-1) ** (n // 40) + n % 3)


def advance(unit, first, last):
    """Takes the steps from `first` up to, not including, `last`."""
    for n in range(first, last):
        drive(unit, n)
        unit.fmu.doStep(n * H, H)


def with_record(unit, steps=STEPS):
    """Values of all outputs at the start and after each step of the scene's record, one list for each output."""
    unit.initialise({"use_record": 1.0})
    return recorded(unit, steps)


def recorded(unit, steps, before=lambda n: None):
    names = unit.names("output")
    rows = [unit.get_all(names)]
    for n in range(steps):
        before(n)
        unit.fmu.doStep(n * H, H)
        rows.append(unit.get_all(names))
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))


def bits(values):
    return [struct.pack("d", value) for value in values]


def assert_equal(found, histories, required=REQUIRED):
    """Every output that the histories have is equal from time 0 on, bit for bit."""
    common = [name for name in found if name in histories]
    assert required <= set(common), required - set(common)
    different = {}
    for name in common:
        pairs = zip(bits(found[name]), bits(histories[name]), strict=False)
        first = next((n for n, (own, other) in enumerate(pairs) if own != other), None)
        if first is not None:
            different[name] = (first, found[name][first], histories[name][first])
    assert not different, "first step, value and expected value of each output"


def refused(said, text, call, *arguments, **named):
    with pytest.raises(FMICallException) as caught:
        call(*arguments, **named)
    assert caught.value.status == 3 and said[-1][:2] == (3, "logStatusError")
    assert text in said[-1][2], said[-1][2]


# Equal to a run


def test_the_scenes_record_gives_the_histories_of_a_run(folder, histories):
    found = with_record(Scalars(folder))
    assert len(histories[1]) == STEPS + 1
    assert max(map(abs, found["crack[1].sliding"])) > 1e-3
    assert_equal(found, histories[0])


def test_the_record_as_input_gives_the_histories_of_a_run(folder, histories):
    unit, ground = Scalars(folder), histories[1]
    unit.initialise({"ground_acceleration": ground[0]})
    found = recorded(unit, STEPS, lambda n: unit.set("ground_acceleration", ground[n + 1]))
    assert_equal(found, histories[0])


@pytest.mark.parametrize("instant", ["in Initialization Mode", "after reading outputs"])
def test_an_input_set_during_initialisation_is_that_of_time_0(folder, histories, instant):
    unit, ground = Scalars(folder), histories[1]
    unit.enter()
    if instant == "after reading outputs":
        unit.get_all(unit.names("output", "calculatedParameter"))
    unit.set("ground_acceleration", ground[0])
    unit.fmu.exitInitializationMode()
    found = recorded(unit, 20, lambda n: unit.set("ground_acceleration", ground[n + 1]))
    assert_equal(found, histories[0])


PARAMETERS = [
    ("crack[1].friction_coefficient", 0.3, "dam.cracks.0.friction_coefficient=0.3"),
    ("crack[1].normal_stiffness", 5e10, "dam.cracks.0.normal_stiffness=5e10"),
    ("crack[1].shear_stiffness", 3e10, "dam.cracks.0.shear_stiffness=3e10"),
    ("young_modulus", 2.5e10, "dam.material.young_modulus=2.5e10"),
    ("poisson_ratio", 0.25, "dam.material.poisson_ratio=0.25"),
    ("density", 2500.0, "dam.material.density=2500"),
    ("damping_ratio", 0.02, "dam.damping.ratio=0.02"),
    ("water_density", 1100.0, "reservoir.density=1100"),
    ("sound_speed", 1500.0, "reservoir.sound_speed=1500"),
    ("wave_reflection_coefficient", 0.5, "reservoir.wave_reflection_coefficient=0.5"),
    ("coupling_tolerance", 1e-6, "coupling.tolerance=1e-6"),
    # Powers of two: with others, the samples of both are rounded differently.
    ("record_scale", 2.0, "ground_motion.record.scale=2"),
    ("record_scale", -1.0, "ground_motion.record.polarity=-1"),
]


@pytest.mark.parametrize("name, value, override", PARAMETERS, ids=[override for *_, override in PARAMETERS])
def test_a_parameter_set_is_that_of_the_scene(folders, histories, tmp_path, name, value, override):
    expected, _ = simulated(tmp_path / "out", [override], until=0.375)
    unit = Scalars(folders[2])
    unit.set(name, value)
    found = with_record(unit, 150)
    assert unit.get(name) == value
    assert_equal(found, expected)
    assert found["crest_displacement.x"] != histories[0]["crest_displacement.x"][:151]


def test_less_friction_slides_farther(folder):
    rough, smooth = Scalars(folder), Scalars(folder)
    smooth.set("crack[1].friction_coefficient", 0.3)
    slid = [max(map(abs, with_record(unit)["crack[1].sliding"])) for unit in (rough, smooth)]
    assert slid[1] > 1.5 * slid[0]


def test_a_parameter_changed_during_initialisation_is_that_set_before(folder):
    early, late = Scalars(folder), Scalars(folder)
    early.initialise({"young_modulus": 2e10, "ground_acceleration": 2.0})
    late.set("ground_acceleration", 2.0)
    late.enter()
    late.get("crest_displacement.x")
    late.set("young_modulus", 2e10)
    late.fmu.exitInitializationMode()
    for unit in (early, late):
        advance(unit, 0, 20)
    assert early.outputs() == late.outputs()


def test_record_scale_has_no_effect_on_an_input(folder):
    plain, scaled = Scalars(folder), Scalars(folder)
    plain.initialise()
    scaled.initialise({"record_scale": 100.0})
    for unit in (plain, scaled):
        advance(unit, 0, 60)
    assert plain.outputs() == scaled.outputs()


def test_the_input_has_no_effect_on_the_record(folder):
    unit, driven = Scalars(folder), Scalars(folder)
    unit.initialise({"use_record": 1.0})
    driven.initialise({"use_record": 1.0, "ground_acceleration": 5.0})
    for n in range(40):
        unit.fmu.doStep(n * H, H)
    advance(driven, 0, 40)
    assert unit.outputs() == driven.outputs()


def numbered(name, cracks):
    """The same name with the number of the crack instead of its name."""
    found = re.fullmatch(r"crack\.(\w+)\.(\w+)", name)
    return f"crack[{cracks.index(found[1]) + 1}].{found[2]}" if found else name


COARSE = ["dam.element_size=10", "reservoir.element_size=20", "time.duration=0.1"]
STRONG = ["ground_motion.record.start=5", "ground_motion.record.end=5.5"]


@pytest.mark.parametrize(
    "scene, overrides",
    [
        ("koyna-tailwater", STRONG),
        ("koyna-two-cracks", STRONG),
        ("koyna-base-joint", STRONG),
        ("koyna-coarse", [*STRONG, "reservoir.method=recursive"]),
        ("koyna-coarse", [*STRONG, 'reservoir.fidelity="westergaard"']),
        ("koyna-coarse", [*STRONG, 'dam.fidelity="reduced"']),
        ("koyna-coarse", [*STRONG, 'coupling.scheme="serial-explicit"']),
        ("koyna-coarse", [*STRONG, 'coupling.scheme="parallel-implicit"']),
    ],
)
def test_other_scenes_equal_their_runs(tmp_path, scene, overrides):
    overrides = [*COARSE, *overrides]
    path = pack(tmp_path, "coupled", overrides, scene=scene, options=["--fmi", "2"])
    expected, _ = simulated(tmp_path / "out", overrides, scene=scene, base=())
    unit = Scalars(path)
    found = with_record(unit, 40)
    names = list(dict.fromkeys(re.findall(r"crack\.(\w+)\.", " ".join(found))))
    renamed = {numbered(name, names): values for name, values in found.items()}
    assert_equal(renamed, expected, {"crest_displacement.x", "base_pressure", "iterations", "converged"})
    cracks = {name for name in expected if re.fullmatch(r"crack\[\d\]\.sliding", name)}
    assert cracks == {name for name in renamed if re.fullmatch(r"crack\S*\.sliding", name)}


# Steps


def test_a_step_of_two_is_two_steps_with_the_input_between_interpolated(folder):
    whole, single = Scalars(folder), Scalars(folder)
    for unit in (whole, single):
        unit.initialise({"ground_acceleration": 1.0})
    before = 1.0
    for n in range(0, 60, 2):
        after = 9.0 * np.sin(0.05 * n)
        whole.set("ground_acceleration", after)
        whole.fmu.doStep(n * H, 2 * H)
        for number, value in enumerate((before + 0.5 * (after - before), after)):
            single.set("ground_acceleration", value)
            single.fmu.doStep((n + number) * H, H)
        assert whole.outputs() == single.outputs(), n
        before = after


WRONG_STEPS = {
    "later": (31 * H, H),
    "earlier": (0.0, H),
    "half a step more": (30 * H, 1.5 * H),
    "no length": (30 * H, 0.0),
    "backwards": (30 * H, -H),
    "time NaN": (float("nan"), H),
    "length NaN": (30 * H, float("nan")),
    "time infinite": (float("inf"), H),
    "length infinite": (30 * H, float("inf")),
    "past the end": (30 * H, STEPS * H),
}


@pytest.mark.parametrize("time, length", WRONG_STEPS.values(), ids=WRONG_STEPS.keys())
def test_a_wrong_step_changes_nothing(folder, time, length):
    said = []
    unit, other = Scalars(folder, said).initialise(), Scalars(folder).initialise()
    for instance in (unit, other):
        advance(instance, 0, 30)
    before = unit.outputs()
    refused(said, "", unit.fmu.doStep, time, length)
    assert unit.time() == other.time() and unit.outputs() == before
    for instance in (unit, other):
        advance(instance, 30, 35)
    assert unit.outputs() == other.outputs()


@pytest.mark.parametrize("count, acceleration", [(1, 1e200), (4, 4e7)])
def test_a_step_that_fails_changes_nothing(folder, count, acceleration):
    """With a ground acceleration that no dam survives; of four communication steps the first succeeds."""
    said = []
    unit, other = Scalars(folder, said).initialise(), Scalars(folder).initialise()
    for instance in (unit, other):
        advance(instance, 0, 20)
    before = unit.outputs()
    unit.set("ground_acceleration", acceleration)
    refused(said, "", unit.fmu.doStep, 20 * H, count * H)
    assert (count == 1) == ("t = 0.05 s" in said[-1][2] or "t = 0.0525" in said[-1][2]), said[-1][2]
    assert unit.time() == other.time() and unit.outputs() == before
    for instance in (unit, other):
        advance(instance, 20, 25)
    assert unit.outputs() == other.outputs()


@pytest.mark.parametrize(
    "acceleration, overrides",
    [
        # The third iteration leaves all bounds, when the acceleration has learnt from two.
        (3e7, ["acceleration=iqn-ils", "tolerance=1e-8"]),
        # It needs more iterations than are allowed.
        (300.0, ["acceleration=aitken", "tolerance=1e-6", "iteration_limit=4"]),
    ],
)
@pytest.mark.parametrize("bonds", [[], ["dam.cracks.0.cohesion=1e5", "dam.cracks.0.tensile_strength=1e5"]])
def test_after_a_failed_step_nothing_tells_of_it(tmp_path, acceleration, overrides, bonds):
    overrides = [*COARSE_HALF_SECOND, *(f"coupling.{override}" for override in overrides), *bonds]
    path = pack(tmp_path, "coupled", overrides, options=["--fmi", "2"])
    folder, said = fmpy.extract(path, unzipdir=tmp_path / "coupled"), []
    unit, other, restored = Scalars(folder, said).initialise(), Scalars(folder).initialise(), Scalars(folder)

    def mild(instance, first, last):
        for n in range(first, last):
            instance.set("ground_acceleration", 2.0 * np.sin(0.07 * n))
            instance.fmu.doStep(n * H, H)

    for instance in (unit, other):
        mild(instance, 0, 20)
    for _ in range(2):
        unit.set("ground_acceleration", acceleration)
        refused(said, "step 21", unit.fmu.doStep, 20 * H, H)
    assert "iteration" in said[-1][2]
    state = unit.fmu.getFMUState()
    unit.fmu.setFMUState(state)
    restored.fmu.setFMUState(restored.fmu.deserializeFMUState(unit.fmu.serializeFMUState(state)))
    for n in range(20, 40):
        for instance in (unit, other, restored):
            mild(instance, n, n + 1)
        assert unit.outputs() == other.outputs() == restored.outputs(), n


def test_a_step_past_the_scene_is_refused_with_a_remedy_that_the_fmu_has(folder):
    said = []
    unit = Scalars(folder, said).initialise()
    advance(unit, 0, STEPS)
    expected = unit.outputs()
    refused(said, "0.51", unit.fmu.doStep, STEPS * H, H)
    assert unit.outputs() == expected
    remedies = re.findall(r"`(\w[\w.]*)`", said[-1][2])
    assert remedies and all(name in unit.references or name.startswith("time.") for name in remedies), said[-1][2]


def test_a_step_past_the_stop_time_is_refused(folder):
    said = []
    unit = Scalars(folder, said).initialise(stop_time=10 * H)
    advance(unit, 0, 10)
    refused(said, "passes the stop time of 0.025 s", unit.fmu.doStep, 10 * H, H)


def test_a_held_input_is_constant_within_a_step(folder):
    """The crest is left behind by the ground, by a H²/2, or by a H²/6 if a grows linearly: until waves arrive, but for damping."""
    found = {}
    for held in (True, False):
        unit = Scalars(folder).initialise({"inputs_held": held})
        unit.set("ground_acceleration", 3.0)
        unit.fmu.doStep(0.0, H)
        found[held] = unit.get("crest_displacement.x")
    assert found[True] == pytest.approx(-3.0 * H**2 / 2, rel=0.06)
    assert found[False] == pytest.approx(-3.0 * H**2 / 6, rel=0.06)


def test_a_held_input_is_that_of_all_steps_of_a_call(folder):
    whole, single = (Scalars(folder).initialise({"inputs_held": True}) for _ in range(2))
    for n in range(0, 40, 2):
        for unit in (whole, single):
            unit.set("ground_acceleration", 9.0 * np.sin(0.05 * n))
        whole.fmu.doStep(n * H, 2 * H)
        for k in (n, n + 1):
            single.fmu.doStep(k * H, H)
        assert whole.outputs() == single.outputs(), n


def test_held_inputs_do_not_concern_the_record(folder):
    plain, held = Scalars(folder), Scalars(folder)
    held.set("inputs_held", True)
    found = [with_record(unit, 30) for unit in (plain, held)]
    assert found[0] == found[1]


def test_messages_of_a_run_that_begins_later_say_so(folder):
    said = []
    unit = Scalars(folder, said)
    if unit.is_fmi2:
        unit.fmu.setupExperiment(startTime=10.0)
        unit.fmu.enterInitializationMode()
    else:
        unit.fmu.enterInitializationMode(startTime=10.0)
    unit.fmu.exitInitializationMode()
    unit.fmu.doStep(10.0, H)
    unit.set("ground_acceleration", 1e200)
    refused(said, "(times count from the start at 10 s)", unit.fmu.doStep, 10.0 + H, H)


# States


def test_restored_states_repeat_with_the_same_bits(folder):
    chance = random.Random(20)
    instants = sorted(chance.sample(range(STEPS - 20), 20))
    unit = Scalars(folder).initialise({"ground_acceleration": 1.0})
    states, reference = {}, []
    for n in range(STEPS):
        if n in instants:
            states[n] = unit.fmu.getFMUState()
        advance(unit, n, n + 1)
        reference.append(unit.outputs())
    chance.shuffle(instants)
    for n in instants:
        unit.fmu.setFMUState(states[n])
        assert unit.time() == pytest.approx(n * H, abs=1e-12)
        steps = chance.randint(1, 6)
        for k in range(n, n + steps):
            unit.set("ground_acceleration", chance.uniform(-20, 20))
            unit.fmu.doStep(k * H, H)
        assert unit.outputs() != reference[n + steps - 1], "other inputs"
        unit.fmu.setFMUState(states[n])
        if n:
            assert unit.outputs() == reference[n - 1]
        for k in range(n, n + 12):
            advance(unit, k, k + 1)
            assert unit.outputs() == reference[k], (n, k)


@pytest.mark.parametrize(
    "overrides",
    [
        ["dam.fidelity=reduced"],
        ["dam.cracks.0.cohesion=1e5", "dam.cracks.0.tensile_strength=1e5"],
    ],
)
def test_a_restored_state_owes_nothing_to_later_attempts(tmp_path, overrides):
    path = pack(tmp_path, "coupled", [*COARSE_HALF_SECOND, *overrides], options=["--fmi", "2"])
    unit = Scalars(fmpy.extract(path, unzipdir=tmp_path / "coupled")).initialise({"ground_acceleration": 1.0})
    advance(unit, 0, 20)
    state = unit.fmu.getFMUState()

    def attempt(acceleration):
        unit.fmu.setFMUState(state)
        found = []
        for n in range(20, 40):
            unit.set("ground_acceleration", acceleration)
            unit.fmu.doStep(n * H, H)
            found.append(unit.outputs())
        return found

    weak = attempt(2.0)
    assert attempt(-25.0) != weak
    assert attempt(25.0) != weak
    assert attempt(2.0) == weak


def test_a_failed_initialisation_is_undone(folder):
    said = []
    unit = Scalars(folder, said)
    unit.enter()
    unit.set("ground_acceleration", 1e308)
    try:
        unit.fmu.exitInitializationMode()
    except FMICallException:
        unit.set("ground_acceleration", 0.0)
        unit.fmu.exitInitializationMode()
    other = Scalars(folder).initialise({"ground_acceleration": 0.0})
    unit.fmu.reset()
    unit.initialise({"ground_acceleration": 0.0})
    for instance in (unit, other):
        advance(instance, 0, 4)
    assert unit.outputs() == other.outputs()


def test_states_of_the_record_repeat_too(folder):
    unit = Scalars(folder).initialise({"use_record": 1.0})
    for n in range(100):
        if n == 60:
            state = unit.fmu.getFMUState()
        unit.fmu.doStep(n * H, H)
    expected = unit.outputs()
    other = Scalars(folder)
    for repeated in (unit, other):
        written = unit.fmu.serializeFMUState(state)
        repeated.fmu.setFMUState(repeated.fmu.deserializeFMUState(written))
        for n in range(60, 100):
            repeated.fmu.doStep(n * H, H)
        assert repeated.outputs() == expected
        assert repeated.get("use_record") == 1.0


def test_a_state_before_initialisation_and_a_reset_begin_again(folder):
    unit = Scalars(folder)
    new = unit.fmu.getFMUState()
    unit.initialise({"ground_acceleration": 1.0})
    start = unit.fmu.getFMUState()
    advance(unit, 0, 30)
    expected = unit.outputs()
    unit.fmu.setFMUState(start)
    advance(unit, 0, 30)
    assert unit.outputs() == expected
    for begin in (lambda: unit.fmu.setFMUState(new), unit.fmu.reset):
        begin()
        assert unit.get("ground_acceleration") == 0.0
        unit.initialise({"ground_acceleration": 1.0})
        advance(unit, 0, 30)
        assert unit.outputs() == expected


CONTINUE = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from fmus import Scalars
from test_coupled import advance
unit = Scalars(sys.argv[2])
unit.fmu.setFMUState(unit.fmu.deserializeFMUState(Path(sys.argv[3]).read_bytes()))
advance(unit, 100, 140)
Path(sys.argv[4]).write_text(repr(unit.outputs()))
"""


def test_a_serialised_state_continues_in_another_process(folder, tmp_path):
    unit = Scalars(folder)
    unit.set("crack[1].friction_coefficient", 0.7)
    unit.initialise()
    advance(unit, 0, 100)
    (tmp_path / "state").write_bytes(unit.fmu.serializeFMUState(unit.fmu.getFMUState()))
    advance(unit, 100, 140)
    arguments = [Path(__file__).parent, folder, tmp_path / "state", tmp_path / "outputs"]
    subprocess.run([sys.executable, "-B", "-c", CONTINUE, *arguments], check=True)
    assert (tmp_path / "outputs").read_text() == repr(unit.outputs())


def test_damaged_and_foreign_states_are_refused(folders, tmp_path):
    said = []
    unit = Scalars(folders[2], said).initialise()
    advance(unit, 0, 5)
    expected, written = unit.outputs(), unit.fmu.serializeFMUState(unit.fmu.getFMUState())
    middle = bytearray(written)
    middle[len(middle) // 2] ^= 1
    for damaged in (b"", b"x", written[:40], written[:-1], written + b"x", bytes(middle)):
        refused(said, "state", unit.fmu.deserializeFMUState, damaged)
    other = Scalars(pack(tmp_path, "coupled", [*COARSE_HALF_SECOND, "dam.damping.ratio=0.04"], options=["--fmi", "2"]), said)
    refused(said, "the state belongs to another unit or scene", other.fmu.deserializeFMUState, written)
    assert unit.outputs() == expected


# Instances


def test_ten_instances_in_ten_threads_give_the_same_bits(folder):
    units = [Scalars(folder).initialise() for _ in range(10)]
    threads = [threading.Thread(target=advance, args=(unit, 0, 40)) for unit in units]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = Scalars(folder).initialise()
    advance(alone, 0, 40)
    assert all(unit.outputs() == alone.outputs() for unit in units)


def resident():
    """Memory of this process, bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def cycle(folder):
    unit = Scalars(folder).initialise()
    advance(unit, 0, 3)
    state = unit.fmu.getFMUState()
    unit.fmu.serializeFMUState(state)
    unit.fmu.setFMUState(state)
    unit.fmu.freeFMUState(state)
    unit.fmu.terminate()
    unit.fmu.freeInstance()


def test_instances_do_not_grow_memory(folders, cycles=100):
    folder = folders[2]
    kept = Scalars(folder)
    for _ in range(20):
        cycle(folder)
    gc.collect()
    before = resident()
    for _ in range(cycles):
        cycle(folder)
    gc.collect()
    grown = resident() - before
    print(f"{cycles} instances: {grown} bytes more")
    assert grown < 20e6, "an eighth of what the instances need"
    assert kept.get("use_record") == 0.0


def test_the_library_can_be_unloaded_and_loaded_again(folders):
    script = "import sys; sys.path.insert(0, sys.argv[1]); import test_coupled as t; [t.cycle(sys.argv[2]) for _ in range(5)]"
    subprocess.run([sys.executable, "-B", "-c", script, Path(__file__).parent, folders[2]], check=True)


WITHOUT_SHARED_MEMORY = """
umount -l /dev/shm && rmdir /dev/shm 2>/dev/null
mount -t tmpfs -o ro,size=4k none /dev/shm 2>/dev/null
touch /dev/shm/x 2>/dev/null && exit 77
exec "$@"
"""


def test_no_shared_memory_is_needed(folders, tmp_path):
    folder = folders[2]
    unshare = shutil.which("unshare")
    command = [unshare or "", "--mount", "--propagation", "private", "sh", "-c", WITHOUT_SHARED_MEMORY, "sh"]
    if not unshare or subprocess.run([*command, "true"], capture_output=True).returncode:
        pytest.skip("/dev/shm cannot be taken away here")
    script = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[1]); import test_coupled as t\n"
        "unit = t.Scalars(sys.argv[2]).initialise(); t.advance(unit, 0, 20)\n"
        "Path(sys.argv[3]).write_text(repr(unit.outputs()))"
    )
    arguments = [sys.executable, "-B", "-c", script, Path(__file__).parent, folder, tmp_path / "outputs"]
    subprocess.run([*command, *arguments], check=True)
    unit = Scalars(folder).initialise()
    advance(unit, 0, 20)
    assert (tmp_path / "outputs").read_text() == repr(unit.outputs())


# Refusals


@pytest.mark.parametrize(
    "name, value",
    [
        # A scene allows 1e-14 to 0.1.
        *(("coupling_tolerance", value) for value in (1.0, -1e-6, 1e-300, 0.5)),
        *(("record_scale", value) for value in (1e308,)),
        *(("crack[1].friction_coefficient", value) for value in (-1.0,)),
        *(("wave_reflection_coefficient", value) for value in (1.5, -0.1)),
        *(("sound_speed", value) for value in (-1.0, 0.0)),
        *(("water_density", value) for value in (-1.0, 0.0)),
        *(("poisson_ratio", value) for value in (0.7,)),
        *(("young_modulus", value) for value in (0.0,)),
    ],
)
def test_invalid_parameters_are_refused_by_name(folders, name, value):
    said = []
    unit = Scalars(folders[2], said)
    unit.set_all({name: value, "use_record": True})
    with pytest.raises(FMICallException):
        unit.initialise()
    names = {name.removeprefix("crack[1]."), name.replace("_", " ")}
    assert any(re.search(rf"(?<![\w.]){re.escape(name)}", said[-1][2]) for name in names), said[-1][2]


def test_an_instance_works_after_its_parameters_were_refused(folder):
    unit = Scalars(folder, [])
    for name, value in (("coupling_tolerance", 2.0), ("wave_reflection_coefficient", 1.5), ("young_modulus", 0.0)):
        unit.set(name, value)
        with pytest.raises(FMICallException):
            unit.enter()
        unit.fmu.reset()
    unit.initialise()
    advance(unit, 0, 10)
    expected = Scalars(folder).initialise()
    advance(expected, 0, 10)
    assert unit.outputs() == expected.outputs()


@pytest.mark.parametrize("name", ["record_scale", "coupling_tolerance", "ground_acceleration"])
def test_values_that_are_not_finite_are_refused_by_name(folder, name):
    said = []
    unit = Scalars(folder, said)
    for value in (float("nan"), float("inf")):
        refused(said, name, unit.set, name, value)


def test_derivatives_are_refused(folder):
    said = []
    unit = Scalars(folder, said).initialise()
    crest, ground = unit.references["crest_displacement.x"], unit.references["ground_acceleration"]
    seed = [[1.0]] if unit.is_fmi2 else [[1.0], 1]
    refused(said, "derivative", unit.fmu.getDirectionalDerivative, [crest], [ground], *seed)


@pytest.mark.parametrize(
    "scene, overrides, text",
    [
        ("rigid-dam-ramp", [], "prescribed"),
        ("koyna-coarse", ["time.adaptive={tolerance=1e-3,shortest=0.000625,longest=0.0025}"], "time.adaptive"),
        ("koyna-coarse", ["coupling.window=4"], "coupling.window"),
        ("koyna-coarse", ['coupling.on_failure="halve"'], "coupling.on_failure"),
    ],
)
def test_scenes_that_cannot_be_coupled_are_refused(tmp_path, scene, overrides, text):
    command = [os.environ["COFFERDAM"], "export-fmu", SCENES / scene, "--unit", "coupled", "--fmi", "2"]
    command += ["--output", tmp_path / "coupled.fmu", *settings(overrides)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode in (1, 2), done.stdout + done.stderr
    assert text in done.stderr and "cannot be one coupled unit" in " ".join(done.stderr.split()), done.stderr
    assert not (tmp_path / "coupled.fmu").exists()


def test_the_description_says_what_the_unit_is(folder):
    unit = Scalars(folder)
    assert unit.names("input") == ["ground_acceleration"]
    variables = {v.name: v for v in unit.description.modelVariables}
    assert [variables[name].start for name in ("use_record", "inputs_held")] == ["false", "false"]
    assert [float(variables[name].start) for name in ("record_scale", "coupling_tolerance")] == [1.0, 0.0]
    starts = {name: start_value(v) for name, v in variables.items() if v.start is not None}
    assert dict(zip(starts, unit.get_all(starts), strict=True)) == starts
    assert float(unit.description.defaultExperiment.stepSize) == H
