"""The FMUs as an importer, FMPy, uses them."""

import gc
import subprocess
import sys
import threading
import tomllib
import zipfile
from ctypes import byref, c_void_p
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import fmi3FMUState
from fmpy.validation import validate_fmu
from fmus import COARSE_HALF_SECOND, H, ROOT, Unit, advance, initialised, load, names_of, outputs, pack
from lxml import etree

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
UNITS = ["dam", "reservoir"]


@pytest.fixture(scope="session", params=UNITS)
def path(request, coarse):
    """Each of the two FMUs of half a second of strong motion on a coarse mesh."""
    return coarse[request.param]


@pytest.fixture
def unpacked(path, tmp_path):
    """The same FMU, unpacked: its instances share one library."""
    return Path(fmpy.extract(path, unzipdir=tmp_path / path.stem))


@pytest.fixture
def said():
    """The messages of an instance made with `listening`: (status, category, text)."""
    return []


def listening(path, said, **arguments):
    """An instance in the state Instantiated; its messages are added to `said`."""

    def listen(_, status, category, text):
        said.append((status, category.decode(), text.decode()))

    return Unit(path, logger=listen, **arguments)


# Contents of the archive


def test_validate_is_clean(path):
    assert validate_fmu(path) == []
    command = [sys.executable, "-m", "fmpy", "validate", path]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and "No problems found" in done.stdout, done.stdout + done.stderr


def schema(name):
    return etree.XMLSchema(etree.parse(SCHEMAS / name))


def test_xml_is_valid(path):
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        schema("fmi3ModelDescription.xsd").assertValid(etree.fromstring(archive.read("modelDescription.xml")))
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        schema("fmi3TerminalsAndIcons.xsd").assertValid(terminals)
        page = etree.fromstring(archive.read("documentation/index.html"), etree.HTMLParser(recover=False))
        assert page.findtext(".//h1")
        names = set(archive.namelist())
    for name in ("resources/unit.toml", "resources/scene.toml", "documentation/licenses/license.txt"):
        assert name in names
    assert any(name.startswith("resources/mesh/") for name in names)


@pytest.mark.parametrize("unit", UNITS)
def test_the_contract_is_valid_too(unit):
    schema("fmi3ModelDescription.xsd").assertValid(etree.parse(ROOT / "modelDescription" / f"{unit}.xml"))


def test_starts_have_the_length_of_their_arrays_and_terminals_name_variables(coarse):
    members = {}
    for unit, path in coarse.items():
        description = fmpy.read_model_description(path)
        names = {v.name for v in description.modelVariables}
        for variable in description.modelVariables:
            if variable.start is not None:
                assert len(str(variable.start).split()) == np.prod(variable.shape, dtype=int), variable.name
        with zipfile.ZipFile(path) as archive:
            terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        (terminal,) = terminals.iter("Terminal")
        assert terminal.get("name") == "wet_face"
        assert {m.get("variableName") for m in terminal} <= names
        members[unit] = {m.get("memberName") for m in terminal}
    geometry = {"x", "y", "normal_x", "normal_y", "length"}
    assert members["reservoir"] == {"pressure", "hydrostatic_pressure", "acceleration"} | geometry
    assert members["dam"] - members["reservoir"] == {"displacement", "velocity", "acceleration_end"}
    assert members["reservoir"] < members["dam"]


def test_real_variables_have_declared_types_of_their_units(path):
    description = fmpy.read_model_description(path)
    for variable in description.modelVariables:
        if variable.causality == "independent":
            continue
        declared = variable.declaredType
        assert (declared is not None) == (variable.type == "Float64"), variable.name
        if declared is not None:
            assert (declared.unit, declared.displayUnit) == (variable.unit, variable.displayUnit), variable.name
            assert declared.quantity == declared.name
            assert declared.nominal is None or float(declared.nominal) > 0
    integers = {v.name for v in description.modelVariables if v.type == "Int32" and v.causality == "output"}
    assert integers == ({"crack_sticking", "crack_slipping", "crack_open"} if path.stem == "dam" else set())


def test_the_hydrostatic_pressure_is_a_parameter_of_the_dam(coarse, said):
    dam = listening(coarse["dam"], said)
    (variable,) = (v for v in dam.description.modelVariables if v.name == "hydrostatic_pressure")
    assert (variable.causality, variable.variability) == ("parameter", "fixed")
    value = dam.get("hydrostatic_pressure")
    dam.set("hydrostatic_pressure", value)
    dam.fmu.enterInitializationMode(startTime=0.0)
    dam.set("hydrostatic_pressure", 0.9 * value)
    dam.fmu.exitInitializationMode()
    for refused_value in (value, 0.9 * value):
        refused(said, "the variable is fixed when initialisation ends", dam.set, "hydrostatic_pressure", refused_value)
    np.testing.assert_array_equal(dam.get("hydrostatic_pressure"), 0.9 * value)


def test_outputs_change_by_steps_alone(path):
    unit = initialised(path)
    advance(unit, 0, 150)
    before = outputs(unit)
    for name in names_of(unit, causality="input"):
        unit.set(name, 7.0 + unit.get(name))
    assert outputs(unit) == before
    unit.fmu.doStep(150 * H, H)
    exchanged = "interface_displacement" if path.stem == "dam" else "interface_pressure"
    assert outputs(unit)[exchanged] != before[exchanged]


def test_declared_dependencies_are_those_of_the_directional_derivatives(path):
    unit = initialised(path)
    advance(unit, 0, 3)
    declared = {output.variable.name: {v.name for v in output.dependencies} for output in unit.description.outputs}
    offered = {name: set() for name in declared}
    for output in declared:
        for name in names_of(unit, causality="input"):
            (unknown, size), (known, points) = unit.references[output], unit.references[name]
            try:
                found = unit.fmu.getDirectionalDerivative(unknown, known, [1.0] * points, size)
            except FMICallException:
                continue
            assert any(found)
            offered[output].add(name)
    assert declared == offered
    assert any(declared.values()) == (path.stem == "reservoir")


def test_held_inputs_are_constant_within_a_step(coarse):
    """The crest is left behind by the ground, by a H²/2, or by a H²/6 if a grows linearly: until waves arrive, but for damping."""
    found = {}
    for held in (True, False):
        dam = Unit(coarse["dam"])
        dam.set("inputs_held", held)
        dam.fmu.enterInitializationMode(startTime=0.0)
        dam.fmu.exitInitializationMode()
        dam.set("ground_acceleration", [3.0, 0.0])
        dam.fmu.doStep(0.0, H)
        found[held] = dam.get("crest_displacement")[0]
    assert found[True] == pytest.approx(-3.0 * H**2 / 2, rel=0.06)
    assert found[False] == pytest.approx(-3.0 * H**2 / 6, rel=0.06)


def test_a_held_pressure_is_that_of_constant_inputs(coarse):
    """Where inputs never change it makes no difference whether they are held."""
    dams = [Unit(coarse["dam"]) for _ in range(2)]
    pressure = 1e5 * np.linspace(1.0, 0.0, dams[0].references["interface_pressure"][1])
    for held, dam in enumerate(dams):
        dam.set("inputs_held", [held == 1])
        dam.set("interface_pressure", pressure)
        dam.set("ground_acceleration", [1.0, 0.5])
        dam.fmu.enterInitializationMode(startTime=0.0)
        dam.fmu.exitInitializationMode()
        for n in range(20):
            dam.fmu.doStep(n * H, H)
    assert outputs(dams[0]) == outputs(dams[1])
    for dam in dams:
        dam.set("interface_pressure", 0 * pressure)
        dam.fmu.doStep(20 * H, H)
    assert outputs(dams[0]) != outputs(dams[1])


def test_a_reservoirs_held_ground_has_the_same_means(coarse):
    """Ground g held over steps has the means of a linear one with u_n = 2 g_n - u_{n-1}."""
    held, linear = Unit(coarse["reservoir"]), Unit(coarse["reservoir"])
    held.set("inputs_held", True)
    for unit in (held, linear):
        unit.fmu.enterInitializationMode(startTime=0.0)
        unit.fmu.exitInitializationMode()
    before, points = np.zeros(2), held.references["interface_acceleration"][1]
    for n in range(40):
        ground = np.array([np.sin(0.3 * n), np.cos(0.2 * n)])
        before = 2 * ground - before
        for unit, value in ((held, ground), (linear, before)):
            unit.set("ground_acceleration", value)
            unit.set("interface_acceleration", [np.sin(n)] * points)
            unit.fmu.doStep(n * H, H)
        pressures = [unit.get("interface_pressure") for unit in (held, linear)]
        np.testing.assert_allclose(*pressures, rtol=1e-9, atol=1e-9 * abs(pressures[1]).max())


# States


def test_save_step_restore_step_gives_the_same_bits(path):
    unit = initialised(path)
    advance(unit, 0, 100)
    state = unit.fmu.getFMUState()
    advance(unit, 100, 120)
    first = outputs(unit)
    for _ in range(3):
        unit.fmu.setFMUState(state)
        assert unit.get("time") == 100 * H
        advance(unit, 100, 120)
        assert outputs(unit) == first
    again = initialised(path)
    advance(again, 0, 120)
    assert outputs(again) == first, "and without saving"


CONTINUE = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from fmus import Unit, advance, outputs
unit = Unit(sys.argv[2])
state = unit.fmu.deserializeFMUState(Path(sys.argv[3]).read_bytes())
unit.fmu.setFMUState(state)
advance(unit, 100, 120)
Path(sys.argv[4]).write_text(repr(outputs(unit)))
"""


def test_a_serialised_state_continues_in_another_process(path, tmp_path):
    unit = initialised(path)
    advance(unit, 0, 100)
    state = unit.fmu.getFMUState()
    (tmp_path / "state").write_bytes(unit.fmu.serializeFMUState(state))
    advance(unit, 100, 120)
    arguments = [Path(__file__).parent, path, tmp_path / "state", tmp_path / "outputs"]
    subprocess.run([sys.executable, "-B", "-c", CONTINUE, *arguments], check=True)
    assert (tmp_path / "outputs").read_text() == repr(outputs(unit))


def resident():
    """Memory of this process, bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.parametrize("reuse", [False, True])
def test_a_thousand_saves_do_not_grow_memory(path, reuse):
    unit = initialised(path)
    advance(unit, 0, 20)
    state = fmi3FMUState()

    def save(times):
        for _ in range(times):
            unit.fmu.fmi3GetFMUState(unit.fmu.component, byref(state))
            if not reuse:
                unit.fmu.freeFMUState(state)
                assert not state.value

    save(100)
    gc.collect()
    before, size = resident(), len(unit.fmu.serializeFMUState(unit.fmu.getFMUState()))
    save(1000)
    grown = resident() - before
    print(f"a state of {size} bytes, saved 1000 times: {grown} bytes more")
    assert grown < 100 * size, "a tenth of the growth if the states were kept"


def test_a_state_brings_its_parameters_into_another_instance(coarse):
    dam = Unit(coarse["dam"])
    dam.set("friction_coefficient", 0.5)
    dam.fmu.enterInitializationMode(startTime=0.0)
    dam.fmu.exitInitializationMode()
    advance(dam, 0, 60)
    written = dam.fmu.serializeFMUState(dam.fmu.getFMUState())
    advance(dam, 60, 80)
    other = Unit(coarse["dam"])
    other.fmu.setFMUState(other.fmu.deserializeFMUState(written))
    assert other.get("friction_coefficient") == 0.5 and other.get("time") == 60 * H
    advance(other, 60, 80)
    assert outputs(other) == outputs(dam)


def test_a_state_of_another_scene_is_refused(path, tmp_path, said):
    other = listening(pack(tmp_path, path.stem, [*COARSE_HALF_SECOND, "gravity=9.8"]), said)
    unit = initialised(path)
    advance(unit, 0, 3)
    written = unit.fmu.serializeFMUState(unit.fmu.getFMUState())
    with pytest.raises(FMICallException):
        other.fmu.deserializeFMUState(written)
    assert "the state belongs to another unit or scene" in said[-1][2]
    for damaged in (b"", b"x", written[:40], written[:-1], written + b"x"):
        with pytest.raises(FMICallException):
            listening(path, said).fmu.deserializeFMUState(damaged)
        assert "state" in said[-1][2]


# Instances


def test_reset_begins_anew_and_instances_do_not_touch_each_other(unpacked):
    unit, other = initialised(unpacked), initialised(unpacked)
    advance(unit, 0, 30)
    expected = outputs(unit)
    unit.fmu.terminate()
    unit.fmu.reset()
    unit.fmu.enterInitializationMode(startTime=0.0)
    unit.fmu.exitInitializationMode()
    for n in range(30):
        advance(unit, n, n + 1)
        advance(other, n, n + 1)
    assert outputs(unit) == outputs(other) == expected
    unit.fmu.freeInstance()
    advance(other, 30, 31)


def test_instances_run_at_once_in_threads(unpacked):
    units = [initialised(unpacked) for _ in range(3)]
    threads = [threading.Thread(target=advance, args=(unit, 0, 40)) for unit in units]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert outputs(units[0]) == outputs(units[1]) == outputs(units[2])


@pytest.mark.parametrize(
    "unit, variable, value, override",
    [
        ("dam", "friction_coefficient", 0.5, "dam.cracks.0.friction_coefficient=0.5"),
        ("dam", "young_modulus", 2.5e10, "dam.material.young_modulus=2.5e10"),
        ("dam", "damping_ratio", 0.02, "dam.damping.ratio=0.02"),
        ("reservoir", "wave_reflection_coefficient", 0.5, "reservoir.wave_reflection_coefficient=0.5"),
        ("reservoir", "sound_speed", 1500.0, "reservoir.sound_speed=1500"),
    ],
)
def test_a_parameter_set_is_that_of_the_scene(coarse, tmp_path, unit, variable, value, override):
    expected = initialised(pack(tmp_path, unit, [*COARSE_HALF_SECOND, override]))
    early, late = Unit(coarse[unit]), Unit(coarse[unit])
    early.set(variable, value)
    for instance in (early, late):
        instance.fmu.enterInitializationMode(startTime=0.0)
    late.get("interface_x")
    late.set(variable, value)
    for instance in (early, late):
        instance.fmu.exitInitializationMode()
        assert instance.get(variable) == value
    for instance in (expected, early, late):
        advance(instance, 0, 40)
    assert outputs(early) == outputs(late) == outputs(expected)
    unchanged = initialised(coarse[unit])
    advance(unchanged, 0, 40)
    assert outputs(unchanged) != outputs(expected)


def test_outputs_in_initialization_mode_follow_the_inputs(coarse):
    dam = Unit(coarse["dam"])
    dam.fmu.enterInitializationMode(startTime=0.0)
    full = dam.get("crest_static_displacement")
    hydrostatic = dam.get("hydrostatic_pressure")
    assert hydrostatic[0] == 1000.0 * 9.81 * 91.75
    dam.set("hydrostatic_pressure", 0 * hydrostatic)
    empty = dam.get("crest_static_displacement")
    assert empty[0] < full[0], "without water the dam leans upstream"
    dam.set("hydrostatic_pressure", hydrostatic)
    dam.set("ground_acceleration", [1.0, 0.0])
    np.testing.assert_array_equal(dam.get("crest_static_displacement"), full)
    dam.fmu.exitInitializationMode()
    np.testing.assert_array_equal(dam.get("crest_static_displacement"), full)
    water = Unit(coarse["reservoir"])
    water.fmu.enterInitializationMode(startTime=0.0)
    np.testing.assert_array_equal(water.get("hydrostatic_pressure"), hydrostatic)


def test_the_directional_derivative_is_the_difference_of_two_steps(coarse):
    water = initialised(coarse["reservoir"])
    advance(water, 0, 50)
    load(water, 50)
    state = water.fmu.getFMUState()
    names = ["interface_pressure", "total_force", "overturning_moment", "base_pressure"]
    unknowns = [water.references[name][0][0] for name in names]
    size = sum(water.references[name][1] for name in names)
    points = water.references["interface_acceleration"][1]
    seed = np.cos(np.arange(points))
    knowns = [water.references[name][0][0] for name in ("interface_acceleration", "ground_acceleration")]
    found = water.fmu.getDirectionalDerivative(unknowns, knowns, [*seed, 1.0, 1.0], size)

    def answer():
        water.fmu.doStep(50 * H, H)
        return np.concatenate([water.get(name) for name in names])

    before = answer()
    water.fmu.setFMUState(state)
    water.set("interface_acceleration", water.get("interface_acceleration") + seed)
    water.set("ground_acceleration", water.get("ground_acceleration") + 1.0)
    difference = answer() - before
    np.testing.assert_allclose(found, difference, rtol=1e-9, atol=1e-9 * abs(difference).max())
    with pytest.raises(FMICallException):
        initialised(coarse["dam"]).fmu.getDirectionalDerivative([10], [1], np.zeros(points), points)


# Wrong calls: status and message; the instance is unchanged


def refused(said, text, call, *arguments, **named):
    with pytest.raises(FMICallException) as caught:
        call(*arguments, **named)
    assert caught.value.status == 3 and said[-1][:2] == (3, "logStatusError")
    assert text in said[-1][2], said[-1][2]


def test_wrong_calls_are_refused_with_a_message(path, unpacked, said):
    unit = listening(unpacked, said)
    fmu, size = unit.fmu, unit.references["interface_x"][1]
    wet = "interface_pressure" if path.stem == "dam" else "interface_acceleration"
    (wet,), calculated = unit.references[wet][0], unit.references["interface_x"][0]

    refused(said, "not allowed in the state Instantiated", fmu.doStep, 0.0, H)
    refused(said, "not allowed in the state Instantiated", fmu.exitInitializationMode)
    refused(said, "not allowed in the state Instantiated", fmu.terminate)
    refused(said, "the start time is NaN s", fmu.enterInitializationMode, startTime=float("nan"))
    fmu.enterInitializationMode(startTime=0.0)
    refused(said, "not allowed in Initialization Mode", fmu.doStep, 0.0, H)
    refused(said, "not allowed in Initialization Mode", fmu.enterInitializationMode, startTime=0.0)
    fmu.exitInitializationMode()
    advance(unit, 0, 5)
    load(unit, 5)
    state = fmu.getFMUState()
    fmu.doStep(5 * H, H)
    expected = outputs(unit)
    fmu.setFMUState(state)

    refused(said, "no variable has value reference 999", fmu.getFloat64, [999], 1)
    refused(said, "no variable has value reference 999", fmu.setFloat64, [999], [1.0])
    refused(said, f"the variables have {size} values together, {size - 1} were passed", fmu.setFloat64, [wet], [0.0] * (size - 1))
    refused(said, f"the variables have {size} values together, 1 were passed", fmu.getFloat64, [wet])
    refused(said, "[3] is NaN", fmu.setFloat64, [wet], [0.0] * 3 + [float("nan")] + [0.0] * (size - 4))
    refused(said, "is inf", fmu.setFloat64, [wet], [float("inf")] * size)
    refused(said, "`interface_x` cannot be set", fmu.setFloat64, calculated, [0.0] * size)
    refused(said, "`time` cannot be set", fmu.setFloat64, [0], [1.0])
    refused(said, "is of type Float64; use fmi3GetFloat64", fmu.getInt32, [wet], size)
    refused(said, "is of type Float64; use fmi3SetFloat64", fmu.setBoolean, [wet], [True] * size)
    refused(said, "is of type Boolean; use fmi3GetBoolean", fmu.getFloat64, unit.references["inputs_held"][0])
    refused(said, "fmi3GetInt8: this FMU does not offer this function", fmu.getInt8, [wet])
    refused(said, "fmi3EnterStepMode: this FMU does not offer this function", fmu.enterStepMode)
    refused(said, "the unit is at t =", fmu.doStep, 4 * H, H)
    refused(said, "the unit is at t =", fmu.doStep, float("nan"), H)
    for length in (0.0, -H, float("nan"), 1e6, 1e300, float("inf")):
        with pytest.raises(FMICallException):
            fmu.doStep(5 * H, length)
    refused(said, "is null, misaligned", fmu.fmi3GetFloat64, fmu.component, None, 1, None, 1)
    refused(said, "is null, misaligned", fmu.fmi3SetFloat64, fmu.component, None, 1, None, 1)
    refused(said, "is null, misaligned", fmu.fmi3GetFMUState, fmu.component, None)
    refused(said, "is null, misaligned", fmu.fmi3DoStep, fmu.component, 5 * H, H, True, None, None, None, None)
    refused(said, "not saved by this instance", fmu.setFMUState, fmi3FMUState())
    refused(said, "not saved by this instance", fmu.setFMUState, c_void_p(4242))
    for other in (initialised(unpacked), initialised(path)):
        refused(said, "not saved by this instance", fmu.setFMUState, other.fmu.getFMUState())
    for nobody in (None, c_void_p(4242)):
        with pytest.raises(FMICallException):
            fmu.fmi3Reset(nobody)
        fmu.fmi3FreeInstance(nobody)
    fmu.fmi3GetFloat64(fmu.component, None, 0, None, 0)

    fmu.doStep(5 * H, H)
    assert outputs(unit) == expected, "after all that"
    fmu.terminate()
    refused(said, "not allowed in the state Terminated", fmu.doStep, 6 * H, H)
    assert outputs(unit) == expected


def test_parameters_that_make_no_unit_are_refused_before_it_is_made(coarse, said):
    dam = listening(coarse["dam"], said)
    dam.set("poisson_ratio", 0.7)
    dam.set("interface_pressure", 0 * dam.get("interface_pressure"))
    refused(said, "poisson_ratio", dam.fmu.enterInitializationMode, startTime=0.0)
    refused(said, "`poisson_ratio`[0] cannot be NaN", dam.set, "poisson_ratio", float("nan"))
    dam.set("poisson_ratio", 0.2)
    dam.fmu.enterInitializationMode(startTime=0.0)
    dam.fmu.exitInitializationMode()
    refused(said, "not allowed in Step Mode", dam.set, "poisson_ratio", 0.2)
    water = listening(coarse["reservoir"], said)
    for name, value, text in [
        ("wave_reflection_coefficient", 1.5, "must be between 0"),
        ("horizon", 1e12, "communication steps"),
        ("horizon", 1e300, "communication steps"),
        ("element_size", 1e-9, "boundary elements"),
        ("element_size", 1e-300, "boundary elements"),
        ("far_end_distance", 1e12, "boundary elements"),
        ("sound_speed", 1e-9, "cut-off frequencies"),
    ]:
        water.set(name, value)
        refused(said, text, water.fmu.enterInitializationMode, startTime=0.0)
        water.fmu.reset()


def test_steps_that_the_reservoir_cannot_take_say_why(coarse, said):
    water = listening(coarse["reservoir"], said)
    water.fmu.enterInitializationMode(startTime=0.0)
    water.fmu.exitInitializationMode()
    refused(said, "it can only take 0.0025 s and whole multiples", water.fmu.doStep, 0.0, 1.5 * H)
    steps = round(water.get("horizon")[0] / H)
    water.fmu.doStep(0.0, 2 * H)
    advance(water, 2, steps)
    refused(said, "raise `horizon`", water.fmu.doStep, steps * H, H)


def test_a_step_that_fmpy_chooses_is_the_reservoirs_own_steps(coarse):
    """FMPy lengthens the steps of a simulation of more than 1000: for the main scene to 0.04 s."""
    whole, single = initialised(coarse["reservoir"]), initialised(coarse["reservoir"])
    for n in range(5):
        for unit, own in ((whole, 1), (single, 16)):
            unit.set("interface_acceleration", np.cos(n + np.arange(len(unit.get("interface_x")))))
            for k in range(own):
                unit.fmu.doStep((16 * n + k) * H, 16 * H / own)
        assert outputs(whole) == outputs(single)


def test_what_is_prepared_is_used_for_the_packed_parameters_only(coarse, tmp_path, said):
    expected = initialised(coarse["reservoir"])
    advance(expected, 0, 40)
    folder = Path(fmpy.extract(coarse["reservoir"], unzipdir=tmp_path / "reservoir"))
    prepared = folder / "resources" / "prepared.bin"
    content = bytearray(prepared.read_bytes())
    content[-100] ^= 1
    prepared.write_bytes(content)
    damaged = listening(folder, said)
    refused(said, "prepared.bin cannot be used", damaged.fmu.enterInitializationMode, startTime=0.0)
    damaged.set("sound_speed", 1500.0)
    damaged.fmu.enterInitializationMode(startTime=0.0)
    prepared.unlink()
    without = initialised(folder)
    advance(without, 0, 40)
    assert outputs(without) == outputs(expected)


def test_a_relative_folder_is_found_from_elsewhere(unpacked, monkeypatch, tmp_path):
    monkeypatch.chdir(unpacked.parent)
    unit = Unit(unpacked.name)
    monkeypatch.chdir(tmp_path.parent)
    unit.fmu.enterInitializationMode(startTime=0.0)
    unit.fmu.exitInitializationMode()
    advance(unit, 0, 2)


def test_a_failure_that_nobody_listens_to_is_on_standard_error(unpacked):
    library = next((unpacked / "binaries").glob("*/*.so"))
    script = f"""
import ctypes
instantiate = ctypes.CDLL({str(library)!r}).fmi3InstantiateCoSimulation
instantiate.restype = ctypes.c_void_p
resources = {str(unpacked / "resources")!r}.encode()
assert not instantiate(b"x", b"another token", resources, 0, 0, 0, 0, None, 0, None, None, None)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0 and "another token" in done.stderr, done.stderr


def test_there_is_no_event_mode(path, said):
    with pytest.raises(Exception, match="Failed to instantiate"):
        listening(path, said, event_mode_used=True)
    assert "has no event mode" in said[-1][2]


def test_units_say_what_they_do_if_asked(path, said):
    unit = listening(path, said, debug_logging=True)
    unit.fmu.enterInitializationMode(startTime=0.0)
    unit.fmu.exitInitializationMode()
    assert {category for _, category, _ in said} == {"logEvents"}
    assert any("interface points" in text or "elements" in text for _, _, text in said)


# From the command line


def test_fmpy_simulate_with_an_input_csv(path, tmp_path):
    """`fmpy simulate` sets the inputs of time t before the step from t."""
    unit = initialised(path)
    name = "ground_acceleration" if path.stem == "dam" else "interface_acceleration"
    size = unit.references[name][1]
    pattern = [1.0, 0.0] if path.stem == "dam" else [1.0] * size
    table = np.array([[0.01 * n, *((n % 3 - 1.0) * value for value in pattern)] for n in range(20)])
    text = "".join(f"{row[0]},{' '.join(map(str, row[1:]))}\n" for row in table)
    (tmp_path / "input.csv").write_text(f"time,{name}\n{text}")
    command = [sys.executable, "-m", "fmpy", "simulate", path, "--input-file", tmp_path / "input.csv"]
    command += ["--output-file", tmp_path / "output.csv", "--stop-time", "0.1", "--output-interval", str(H)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    found = np.genfromtxt(tmp_path / "output.csv", delimiter=",", names=True, dtype=None, encoding=None)
    scalar = "kinetic_energy" if path.stem == "dam" else "total_force"
    again = Unit(path)
    again.fmu.enterInitializationMode(startTime=0.0)
    again.set(name, table[0, 1:])
    again.fmu.exitInitializationMode()
    expected = [again.get(scalar)[0]]
    for n in range(40):
        again.set(name, [np.interp(n * H, table[:, 0], column) for column in table[:, 1:].T])
        again.fmu.doStep(n * H, H)
        expected.append(again.get(scalar)[0])
    np.testing.assert_allclose(found[scalar], expected, rtol=1e-12, atol=1e-12 * max(map(abs, expected)))
    assert len(found) == 41 and max(map(abs, expected)) > 0


def test_simulate_fmu_with_start_values(coarse):
    dam = Unit(coarse["dam"])
    values = {"friction_coefficient": 0.4, "hydrostatic_pressure": 0.5 * dam.get("hydrostatic_pressure")}
    arguments = {"output": ["crest_displacement"], "stop_time": 0.05, "output_interval": H}
    result = simulate_fmu(coarse["dam"], start_values={**values, "ground_acceleration": [3.0, 0.0]}, **arguments)
    for name, value in values.items():
        dam.set(name, value)
    dam.set("ground_acceleration", [3.0, 0.0])
    dam.fmu.enterInitializationMode(startTime=0.0)
    dam.fmu.exitInitializationMode()
    for n in range(20):
        dam.fmu.doStep(n * H, H)
    np.testing.assert_allclose(result["crest_displacement"][-1], dam.get("crest_displacement"), rtol=1e-12)
    assert result["time"][-1] == pytest.approx(0.05)


@pytest.mark.parametrize(
    "scene, overrides",
    [
        ("koyna-intact", COARSE_HALF_SECOND[:1]),
        ("koyna-coarse", [*COARSE_HALF_SECOND, 'reservoir.fidelity="westergaard"', 'title="a < b & \'c\' 坝"']),
    ],
)
@pytest.mark.parametrize("unit", UNITS)
def test_other_scenes_are_as_described(tmp_path, scene, overrides, unit):
    """Every start value in the description is what a fresh instance has, and the unit runs."""
    path = pack(tmp_path, unit, overrides, scene=scene)
    assert validate_fmu(path) == []
    instance = Unit(path)
    starts = {v.name: v.start for v in instance.description.modelVariables if v.start is not None}
    assert len(starts) > 5
    for name, start in starts.items():
        numbers = [{"false": 0.0, "true": 1.0}.get(text) or float(text.replace("false", "0")) for text in str(start).split()]
        assert numbers == instance.get(name).tolist(), name
    instance.fmu.enterInitializationMode(startTime=0.0)
    instance.fmu.exitInitializationMode()
    instance.fmu.doStep(0.0, float(instance.description.defaultExperiment.stepSize))
    assert all(np.isfinite(instance.get(v.name)).all() for v in instance.description.modelVariables)


def test_a_variable_that_the_description_does_not_have_cannot_be_got(tmp_path, said):
    """Without damping there is no damping ratio, without cracks there are no variables of cracks."""
    dam = listening(pack(tmp_path, "dam", ["dam.damping.ratio=0", "dam.element_size=10"], scene="koyna-intact"), said)
    for reference in (20, 53, 56):
        refused(said, f"no variable has value reference {reference}", dam.fmu.getFloat64, [reference], 1)


def test_the_scene_is_inside(path):
    with zipfile.ZipFile(path) as archive:
        scene = tomllib.loads(archive.read("resources/scene.toml").decode())
    assert scene["time"]["duration"] == pytest.approx(0.51, abs=0.02)
