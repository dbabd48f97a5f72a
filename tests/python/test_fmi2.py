"""The FMUs of FMI 2.0 as an importer, FMPy, uses them, and compared with those of FMI 3.0."""

import re
import struct
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
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE, fmi2FMUstate, fmi2Real, fmi2ValueReference
from fmpy.validation import validate_fmu
from fmus import COARSE_HALF_SECOND, H, Scalars, Unit, pack, start_value
from lxml import etree

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
UNITS = ["dam", "reservoir", "coupled"]
NAN = float("nan")
LAST_SUCCESSFUL_TIME = 2


@pytest.fixture(scope="session")
def archives(tmp_path_factory):
    """The FMUs of FMI 2.0 of half a second of strong motion on a coarse mesh, by unit."""
    folder = tmp_path_factory.mktemp("fmi2")
    return {unit: pack(folder, unit, COARSE_HALF_SECOND, options=["--fmi", "2"]) for unit in UNITS}


@pytest.fixture(scope="session")
def folders(archives, tmp_path_factory):
    """The same FMUs, unpacked into a folder whose name has blanks, umlauts and a percent sign."""
    folder = tmp_path_factory.mktemp("Über 100 % größer")
    return {unit: Path(fmpy.extract(path, unzipdir=folder / unit)) for unit, path in archives.items()}


@pytest.fixture(params=UNITS)
def unit(request):
    return request.param


@pytest.fixture
def folder(unit, folders):
    return folders[unit]


def values(array, n):
    """Values of an input at the end of step `n`, which vary in time and from point to point."""
    size = len(array)
    return [(i + 1) / size * (-1) ** (n // 7) * (1 + n % 5) for i in range(size)]


def inputs(unit, n):
    """Values of all inputs by their names at the end of step `n`."""
    pressures = [name for name in unit.names("input") if "pressure" in name]
    others = [name for name in unit.names("input") if "pressure" not in name]
    waves = {name: 1e4 * value for name, value in zip(pressures, values(pressures, n), strict=True)}
    return waves | dict(zip(others, values(others, n), strict=True))


def advance(unit, first, last):
    """Takes the steps from `first` up to, not including, `last`."""
    for n in range(first, last):
        unit.set_all(inputs(unit, n))
        unit.fmu.doStep(n * H, H)


def refused(said, text, call, *arguments, **named):
    with pytest.raises(FMICallException) as caught:
        call(*arguments, **named)
    assert caught.value.status == 3 and said[-1][:2] == (3, "logStatusError")
    assert text in said[-1][2], said[-1][2]


# Contents of the archive


def test_validate_is_clean(archives, unit):
    assert validate_fmu(archives[unit]) == []


def test_xml_is_valid(archives, unit):
    with zipfile.ZipFile(archives[unit]) as archive:
        assert archive.testzip() is None
        description = etree.fromstring(archive.read("modelDescription.xml"))
        etree.XMLSchema(etree.parse(SCHEMA)).assertValid(description)
        page = etree.fromstring(archive.read("documentation/index.html"), etree.HTMLParser(recover=False))
        assert page.findtext(".//h1")
        names = set(archive.namelist())
    identifier = description.find("CoSimulation").get("modelIdentifier")
    assert any(re.fullmatch(rf"binaries/(linux|win|darwin)64/{identifier}\.(so|dll|dylib)", name) for name in names)
    assert not any(re.match(r"binaries/\w+-\w+/|terminalsAndIcons/", name) for name in names), "of FMI 3.0"
    assert {"resources/unit.toml", "resources/scene.toml"} <= names


def test_scalars_are_the_elements_of_the_arrays_of_fmi3(coarse, archives):
    for name in ("dam", "reservoir"):
        arrays = {v.name: v for v in fmpy.read_model_description(coarse[name]).modelVariables}
        scalars = {v.name: v for v in fmpy.read_model_description(archives[name]).modelVariables}
        counted = {}
        for scalar in scalars.values():
            array, index = element(scalar.name, arrays)
            counted[array] = counted.get(array, 0) + 1
            whole = arrays[array]
            assert (scalar.description, scalar.unit) == (whole.description, whole.unit)
            if whole.start is not None:
                assert scalar.start.split()[0] == str(whole.start).split()[index], scalar.name
        for array, whole in arrays.items():
            assert array in counted or array == "time" or whole.causality == "local" or len(whole.dimensions) == 1, array
            assert counted.get(array, 0) in (0, np.prod(whole.shape, dtype=int)), array


def element(name, arrays):
    """The array of FMI 3.0 with this scalar, and the index in it."""
    if found := re.fullmatch(r"crack\[(\d+)\]\.(\w+)", name):
        known = [array for array in (f"crack_{found[2]}", found[2]) if array in arrays]
        return known[0], int(found[1]) - 1
    if found := re.fullmatch(r"(\w+)\[(\d+)\]", name):
        return found[1], int(found[2]) - 1
    if found := re.fullmatch(r"(\w+)\.([xy])", name):
        return found[1], "xy".index(found[2])
    return name, 0


def test_there_is_no_variable_for_the_time(archives, unit):
    """FMI allows none with a start value, and some importers demand one."""
    with zipfile.ZipFile(archives[unit]) as archive:
        description = etree.fromstring(archive.read("modelDescription.xml"))
    for variable in description.iter("ScalarVariable"):
        (value,) = variable
        calculated = variable.get("initial") == "calculated"
        assert (value.get("start") is None) == calculated, variable.get("name")


def test_outputs_of_a_reservoir_depend_on_what_it_derives_by(archives, unit):
    description = fmpy.read_model_description(archives[unit])
    declared = {output.variable.name: {v.name for v in output.dependencies} for output in description.outputs}
    known = {v.name for v in description.modelVariables if v.causality == "input"}
    assert set(map(frozenset, declared.values())) == {frozenset(known if unit == "reservoir" else ())}


def test_parameters_have_bounds(archives):
    variables = {v.name: v for v in fmpy.read_model_description(archives["coupled"]).modelVariables}
    for name, least, most in (
        ("crack[1].friction_coefficient", 0.0, None),
        ("wave_reflection_coefficient", 0.0, 1.0),
        ("coupling_tolerance", 0.0, 0.1),
    ):
        found = variables[name]
        assert float(found.min) == least and (most is None or float(found.max) == most), name
    assert variables["damping_ratio"].max is not None
    assert (variables["use_record"].type, variables["iterations"].type) == ("Boolean", "Integer")


def test_start_values_are_those_of_a_fresh_instance(folder):
    fresh = Scalars(folder)
    starts = {v.name: start_value(v) for v in fresh.description.modelVariables if v.start is not None}
    assert len(starts) > 5
    assert dict(zip(starts, fresh.get_all(starts), strict=True)) == starts


def test_named_cracks_are_in_the_names(tmp_path):
    overrides = [*COARSE_HALF_SECOND, 'dam.cracks.0.name="lift joint (12 m)"']
    path = pack(tmp_path, "dam", overrides, options=["--fmi", "2"])
    assert validate_fmu(path) == []
    names = {v.name for v in fmpy.read_model_description(path).modelVariables}
    assert {"crack.lift_joint__12_m_.sliding", "crack.lift_joint__12_m_.friction_coefficient"} <= names


# The same as in FMI 3.0


@pytest.mark.parametrize("unit", ["dam", "reservoir"])
def test_the_same_inputs_give_the_same_bits_in_both_versions(coarse, folders, unit):
    second, third = Scalars(folders[unit]).initialise(), Unit(coarse[unit])
    third.fmu.enterInitializationMode(startTime=0.0)
    third.fmu.exitInitializationMode()
    arrays = third.references
    read = second.names("output", "calculatedParameter", "parameter", "input")
    for n in range(40):
        given = inputs(second, n)
        second.set_all(given)
        whole = {}
        for name, value in given.items():
            array, index = element(name, arrays)
            whole.setdefault(array, np.zeros(arrays[array][1]))[index] = value
        for array, value in whole.items():
            third.set(array, value)
        for instance in (second, third):
            instance.fmu.doStep(n * H, H)
        found = {array: third.get(array) for array in {element(name, arrays)[0] for name in read}}
        expected = [found[array][index] for array, index in (element(name, arrays) for name in read)]
        assert struct.pack(f"{len(read)}d", *second.get_all(read)) == struct.pack(f"{len(read)}d", *expected), n
    assert any(expected)


def test_the_directional_derivative_is_that_of_fmi3(coarse, folders):
    second, third = Scalars(folders["reservoir"]).initialise(), Unit(coarse["reservoir"])
    third.fmu.enterInitializationMode(startTime=0.0)
    third.fmu.exitInitializationMode()
    size = third.references["interface_acceleration"][1]
    seed = [float(np.cos(i)) for i in range(size)]
    unknown = [*(f"interface_pressure[{i + 1}]" for i in range(size)), "total_force", "base_pressure"]
    known = [f"interface_acceleration[{i + 1}]" for i in range(size)]
    found = second.fmu.getDirectionalDerivative(
        [second.references[name] for name in unknown], [second.references[name] for name in known], seed
    )
    whole = [third.references[name][0][0] for name in ("interface_pressure", "total_force", "base_pressure")]
    expected = third.fmu.getDirectionalDerivative(
        whole, third.references["interface_acceleration"][0], seed, size + 2
    )
    assert found == list(expected) and all(found)
    # Columns one by one, in another order of the unknowns.
    columns = [
        second.fmu.getDirectionalDerivative([second.references[name] for name in reversed(unknown)], [reference], [1.0])
        for reference in (second.references[name] for name in known)
    ]
    np.testing.assert_allclose(np.transpose(columns)[::-1] @ seed, expected, rtol=1e-12, atol=1e-9 * max(map(abs, expected)))


# States


def test_restored_states_repeat_with_the_same_bits(folder):
    instance = Scalars(folder).initialise()
    advance(instance, 0, 30)
    state = instance.fmu.getFMUstate()
    advance(instance, 30, 40)
    expected = instance.outputs()
    for _ in range(3):
        instance.fmu.setFMUstate(state)
        advance(instance, 30, 40)
        assert instance.outputs() == expected
    instance.fmu.freeFMUstate(state)
    assert not state.value


CONTINUE = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from fmus import Scalars
from test_fmi2 import advance
unit = Scalars(sys.argv[2])
unit.fmu.setFMUstate(unit.fmu.deSerializeFMUstate(Path(sys.argv[3]).read_bytes()))
advance(unit, 30, 50)
Path(sys.argv[4]).write_text(repr(unit.outputs()))
"""


def test_a_serialised_state_continues_in_another_process(folder, tmp_path):
    instance = Scalars(folder).initialise()
    advance(instance, 0, 30)
    (tmp_path / "state").write_bytes(instance.fmu.serializeFMUstate(instance.fmu.getFMUstate()))
    advance(instance, 30, 50)
    arguments = [Path(__file__).parent, folder, tmp_path / "state", tmp_path / "outputs"]
    subprocess.run([sys.executable, "-B", "-c", CONTINUE, *arguments], check=True)
    assert (tmp_path / "outputs").read_text() == repr(instance.outputs())


def test_reset_begins_again(folder):
    instance = Scalars(folder).initialise()
    advance(instance, 0, 20)
    expected = instance.outputs()
    instance.fmu.terminate()
    assert instance.outputs() == expected
    instance.fmu.reset()
    instance.initialise()
    advance(instance, 0, 20)
    assert instance.outputs() == expected


# Derivatives of inputs


def slopes(instance, n):
    """Derivatives of the inputs during step `n`, per second."""
    return {name: 7.0 * value for name, value in inputs(instance, n + 3).items()}


def set_slopes(instance, given):
    references = [instance.references[name] for name in given]
    instance.fmu.setRealInputDerivatives(references, [1] * len(references), list(given.values()))


def test_input_derivatives_are_values_at_the_end_of_the_step(folder):
    sloped, plain = Scalars(folder).initialise(), Scalars(folder).initialise()
    for n in range(20):
        start, slope = inputs(sloped, n), slopes(sloped, n)
        sloped.set_all(start)
        set_slopes(sloped, slope)
        ends = {name: value + H * slope[name] for name, value in start.items()}
        plain.set_all(ends)
        for instance in (sloped, plain):
            instance.fmu.doStep(n * H, H)
        assert sloped.outputs() == plain.outputs(), n
        assert sloped.get_all(ends) == list(ends.values())
    for n in range(20, 22):
        for instance in (sloped, plain):
            instance.fmu.doStep(n * H, H)
        assert sloped.outputs() == plain.outputs(), "derivatives are those of one step"


def test_derivatives_of_held_inputs_are_refused(folder):
    said = []
    instance = Scalars(folder, said).initialise({"inputs_held": True})
    reference = instance.references[instance.names("input")[0]]
    refused(said, "`inputs_held` is true", instance.fmu.setRealInputDerivatives, [reference], [1], [0.0])
    advance(instance, 0, 3)


@pytest.mark.parametrize(
    "time, length",
    [(4 * H, 2 * H), (20 * H, NAN), (NAN, 2 * H), (20 * H, -H), (20 * H, 0.0), (20 * H, 1e6)],
)
def test_a_refused_step_keeps_the_derivatives(folder, time, length):
    said = []
    instance, other = Scalars(folder, said), Scalars(folder)
    for each in (instance, other):
        each.initialise(stop_time=1.0)
        advance(each, 0, 20)
        set_slopes(each, slopes(each, 20))
    refused(said, "", instance.fmu.doStep, time, length)
    for each in (instance, other):
        each.fmu.doStep(20 * H, H)
    assert instance.outputs() == other.outputs()


def test_a_state_has_the_derivatives(folder):
    instance = Scalars(folder).initialise()
    advance(instance, 0, 20)
    set_slopes(instance, slopes(instance, 20))
    state = instance.fmu.getFMUstate()
    instance.fmu.doStep(20 * H, H)
    expected = instance.outputs()
    instance.fmu.setFMUstate(state)
    instance.fmu.doStep(20 * H, H)
    assert instance.outputs() == expected


def test_wrong_input_derivatives_are_refused(folder):
    said = []
    instance, other = Scalars(folder, said).initialise(), Scalars(folder).initialise()
    name, output = instance.names("input")[0], instance.names("output")[0]
    good, bad, whole = instance.references[name], instance.references[output], name.split("[")[0].split(".")[0]
    call = instance.fmu.setRealInputDerivatives
    for order in (0, 2, -1):
        refused(said, f"derivative {order} of `{whole}`", call, [good], [order], [1.0])
    refused(said, f"`{output.split('.')[0].split('[')[0]}`", call, [good, bad], [1, 1], [1.0, 1.0])
    refused(said, whole, call, [good], [1], [NAN])
    refused(said, "value reference 4294967295", call, [good, 4294967295], [1, 1], [1.0, 1.0])
    fmu, one = instance.fmu, (fmi2ValueReference * 1)(good)
    refused(said, "`order` is null", fmu.fmi2SetRealInputDerivatives, fmu.component, one, 1, None, (fmi2Real * 1)(1.0))
    for each in (instance, other):
        advance(each, 0, 5)
    assert instance.outputs() == other.outputs()


# Wrong calls: status and message; the instance is unchanged


def test_calls_in_the_wrong_order_are_refused(folder):
    said = []
    instance = Scalars(folder, said)
    fmu = instance.fmu
    refused(said, "fmi2DoStep is not allowed in the state Instantiated", fmu.doStep, 0.0, H)
    refused(said, "fmi2ExitInitializationMode is not allowed", fmu.exitInitializationMode)
    refused(said, "fmi2Terminate is not allowed", fmu.terminate)
    refused(said, "the start time is NaN s", fmu.setupExperiment, startTime=NAN)
    refused(said, "the stop time -1 s", fmu.setupExperiment, startTime=0.0, stopTime=-1.0)
    fmu.setupExperiment(startTime=0.0, stopTime=10 * H)
    fmu.enterInitializationMode()
    refused(said, "fmi2DoStep is not allowed in Initialization Mode", fmu.doStep, 0.0, H)
    refused(said, "fmi2SetupExperiment is not allowed", fmu.setupExperiment, startTime=0.0)
    refused(said, "fmi2EnterInitializationMode is not allowed", fmu.enterInitializationMode)
    fmu.exitInitializationMode()
    refused(said, "fmi2EnterInitializationMode is not allowed in Step Mode", fmu.enterInitializationMode)
    parameter = instance.names("parameter")[0]
    refused(said, "is not allowed", instance.set, parameter, 1.0)
    assert re.search(r"fmi2Set(Real|Boolean)|" + parameter.split("[")[0], said[-1][2])
    advance(instance, 0, 10)
    refused(said, "passes the stop time of 0.025 s", fmu.doStep, 10 * H, H)
    fmu.terminate()
    refused(said, "fmi2DoStep is not allowed in the state Terminated", fmu.doStep, 10 * H, H)
    refused(said, "fmi2SetReal is not allowed in the state Terminated", instance.set, instance.names("input")[0], 0.0)
    other = Scalars(folder).initialise()
    advance(other, 0, 10)
    assert instance.outputs() == other.outputs()


def test_wrong_arguments_are_refused(folder, folders):
    said = []
    instance, other = Scalars(folder, said).initialise(), Scalars(folder).initialise()
    for each in (instance, other):
        advance(each, 0, 5)
        each.set_all(inputs(each, 5))
    fmu, component = instance.fmu, instance.fmu.component
    names = instance.names("input")
    name, output = names[0], instance.names("output")[0]
    whole = output.split(".")[0].split("[")[0]
    good, one, place = instance.references[name], (fmi2ValueReference * 1)(instance.references[name]), (fmi2Real * 1)()

    for reference in (999, 4294967295, good + 60000, instance.references[output] + 60000):
        refused(said, f"no variable has value reference {reference}", fmu.getReal, [reference])
        refused(said, f"no variable has value reference {reference}", fmu.setReal, [good, reference], [1.0, 1.0])
    refused(said, f"`{whole}` cannot be set", fmu.setReal, [good, instance.references[output]], [1.0, 1.0])
    fixed = instance.names("calculatedParameter")[0]
    refused(said, f"`{fixed.split('.')[0].split('[')[0]}` cannot be set", instance.set, fixed, 1.0)
    refused(said, "`time` cannot be set", fmu.setReal, [0], [1.0])
    index = len(names) - 1 if "[" in names[-1] else 0
    for value, text in ((NAN, "NaN"), (float("inf"), "inf"), (float("-inf"), "-inf")):
        refused(said, f"is {text}", fmu.setReal, [good, instance.references[names[index]]], [1.0, value])
        assert re.match(r"\w+", names[index])[0] in said[-1][2]
    refused(said, "fmi2GetString: this FMU does not offer this function", fmu.getString, [good])
    whole = name.split(".")[0].split("[")[0]
    for get, set, kind in ((fmu.getInteger, fmu.setInteger, "Integer"), (fmu.getBoolean, fmu.setBoolean, "Boolean")):
        refused(said, f"fmi2Get{kind}: `{whole}` is of type Real; use fmi2GetReal", get, [good])
        refused(said, f"fmi2Set{kind}: `{whole}` is of type Real; use fmi2SetReal", set, [good], [1])
    for typed in (v for v in instance.description.modelVariables if v.type != "Real"):
        refused(said, f"is of type {typed.type}; use fmi2Get{typed.type}", fmu.getReal, [typed.valueReference])
        refused(said, f"is of type {typed.type}; use fmi2Set{typed.type}", fmu.setReal, [typed.valueReference], [1.0])
    refused(said, "fmi2GetRealOutputDerivatives: this FMU does not offer", fmu.getRealOutputDerivatives, [good], [1])
    refused(said, "fmi2CancelStep: this FMU does not offer", fmu.cancelStep)
    refused(said, "fmi2GetStatus: this FMU does not offer", fmu.getStatus, 0)
    refused(said, "fmi2GetRealStatus: this FMU does not offer", fmu.getRealStatus, 0)
    refused(said, 'there is no log category "noise"', fmu.setDebugLogging, True, ["noise"])

    refused(said, "fmi2GetReal: `", fmu.fmi2GetReal, component, None, 1, place)
    refused(said, "fmi2GetReal: `", fmu.fmi2GetReal, component, one, 1, None)
    refused(said, "fmi2SetReal: `", fmu.fmi2SetReal, component, one, 1, None)
    refused(said, "fmi2SetReal: `", fmu.fmi2SetReal, component, None, 1, place)
    refused(said, "fmi2GetFMUstate: `", fmu.fmi2GetFMUstate, component, None)
    refused(said, "fmi2GetRealStatus: `", fmu.fmi2GetRealStatus, component, LAST_SUCCESSFUL_TIME, None)
    fmu.fmi2GetReal(component, None, 0, None)

    state, others = fmu.getFMUstate(), other.fmu.getFMUstate()
    freed = c_void_p(state.value)
    refused(said, "fmi2SerializedFMUstateSize: `", fmu.fmi2SerializedFMUstateSize, component, state, None)
    refused(said, "the buffer has 3", fmu.fmi2SerializeFMUstate, component, state, b"xyz", 3)
    fmu.freeFMUstate(state)
    fmu.fmi2FreeFMUstate(component, byref(fmi2FMUstate()))
    for handle in (freed, c_void_p(4242), fmi2FMUstate(), others):
        refused(said, "fmi2SetFMUstate: the state was not saved by this instance", fmu.setFMUstate, handle)
        refused(said, "the state was not saved by this instance", fmu.serializeFMUstate, handle)
    refused(said, "fmi2FreeFMUstate: the state was not saved by this instance", fmu.freeFMUstate, freed)
    for damaged in (b"", b"x", b"x" * 1000):
        refused(said, "state", fmu.deSerializeFMUstate, damaged)
    for nobody in (None, c_void_p(4242)):
        with pytest.raises(FMICallException):
            fmu.fmi2Reset(nobody)
        fmu.fmi2FreeInstance(nobody)

    assert instance.outputs() == other.outputs()
    for each in (instance, other):
        each.fmu.doStep(5 * H, H)
        advance(each, 6, 12)
    assert instance.outputs() == other.outputs(), "after all that"


@pytest.mark.parametrize(
    "time, length",
    [(4 * H, H), (NAN, H), (float("inf"), H), *((5 * H, length) for length in (0.0, -H, NAN, float("inf"), 1e6))],
)
def test_wrong_steps_change_nothing(folder, time, length):
    said = []
    instance, other = Scalars(folder, said).initialise(), Scalars(folder).initialise()
    for each in (instance, other):
        advance(each, 0, 5)
    refused(said, "", instance.fmu.doStep, time, length)
    assert instance.time() == other.time() == instance.fmu.getReal([0])[0]
    assert instance.outputs() == other.outputs()
    for each in (instance, other):
        advance(each, 5, 10)
    assert instance.outputs() == other.outputs()


def instantiated(folder, said, name=b"unit", kind=1, guid=None, location=None, callbacks=True):
    """What fmi2Instantiate returns, called with the pointers themselves and a logger that does not format."""

    def listen(environment, instance, status, category, text):
        said.append((environment, instance, status, category.decode(), text.decode()))

    kept = Scalars(folder)
    given = fmi2CallbackFunctions(logger=fmi2CallbackLoggerTYPE(listen), componentEnvironment=4711)
    guid = kept.description.guid.encode() if guid is None else guid
    location = (folder / "resources").as_uri().encode() if location is None else location
    found = kept.fmu.fmi2Instantiate(name, kind, guid, location, byref(given) if callbacks else None, 0, 0)
    return found, kept, given


@pytest.mark.parametrize(
    "arguments, text",
    [
        ({"guid": b"another"}, "the instantiation token is another"),
        ({"guid": b""}, "the instantiation token is "),
        ({"guid": b"\xff"}, "`fmuGUID` is not UTF-8"),
        ({"name": b"\xff"}, "`instanceName` is not UTF-8"),
        ({"kind": 0}, "fmi2Instantiate"),
        ({"location": b"https://example.org/resources"}, "is no local folder"),
        ({"location": b"file://elsewhere/tmp"}, "is no local folder"),
        ({"location": b"resources"}, "is no local folder"),
        ({"location": b""}, "is no local folder"),
        ({"location": b"file:///tmp/%zz"}, "is no local folder"),
        ({"location": b"file:///nowhere/resources"}, "/nowhere/resources"),
    ],
)
def test_wrong_instantiations_are_refused(folder, arguments, text):
    said = []
    found, kept, _ = instantiated(folder, said, **arguments)
    assert not found
    ((environment, _, status, category, message),) = said
    assert environment == 4711 and status in (3, 4) and category == "logStatusError"
    assert text in message
    kept.initialise()
    advance(kept, 0, 2)


@pytest.mark.parametrize("argument", ["instanceName", "fmuGUID", "fmuResourceLocation"])
def test_null_texts_are_refused(folders, argument):
    said, folder = [], folders["dam"]
    _, kept, callbacks = instantiated(folder, said)
    texts = {"instanceName": b"unit", "fmuGUID": kept.description.guid.encode(), "fmuResourceLocation": b"/tmp"}
    texts[argument] = None
    name, guid, location = texts.values()
    assert not kept.fmu.fmi2Instantiate(name, 1, guid, location, byref(callbacks), 0, 0)
    assert f"`{argument}` is null" in said[-1][-1]


def test_an_instance_without_callbacks_is_refused_on_standard_error(folder, capfd):
    found, _, _ = instantiated(folder, [], callbacks=False)
    assert not found
    assert "`functions` is null" in capfd.readouterr().err


def test_locations_are_uris_or_paths(folder):
    expected = Scalars(folder).initialise()
    advance(expected, 0, 5)
    path = folder / "resources"
    for location in (path.as_uri(), path.as_uri().replace("file://", "file:"), path.as_uri() + "/", str(path)):
        instance, kept, _ = instantiated(folder, [], location=location.encode())
        assert instance, location
        kept.fmu.fmi2FreeInstance(kept.fmu.component)
        kept.fmu.component = instance
        kept.initialise()
        advance(kept, 0, 5)
        assert kept.outputs() == expected.outputs()


def test_messages_are_formats_with_escaped_percent_signs(folder):
    said = []
    instantiated(folder, said, name=b"100 %s", guid=b"50 %s %n %% off")
    ((_, name, _, _, text),) = said
    assert name == b"100 %s"
    assert "50 %%s %%n %%%% off" in text and "%" not in text.replace("%%", "")
    formatted = []
    instance = Scalars(folder, formatted)
    refused(formatted, '"50 %s %n %% off"', instance.fmu.setDebugLogging, True, ["50 %s %n %% off"])


def test_units_say_what_they_do_if_asked(folder):
    said, silent = [], []
    Scalars(folder, said, debug_logging=True).initialise()
    Scalars(folder, silent).initialise()
    assert {category for _, category, _ in said} == {"logEvents"} and not silent
    later = []
    instance = Scalars(folder, later)
    instance.fmu.setDebugLogging(True, ["logEvents"])
    instance.initialise()
    assert {category for _, category, _ in later} == {"logEvents"}


def test_version_and_platform_are_those_of_fmi2(folders):
    fmu = Scalars(folders["dam"]).fmu
    assert (fmu.getVersion(), fmu.getTypesPlatform()) == ("2.0", "default")


# Instances


def test_instances_run_at_once_in_threads(folder):
    instances = [Scalars(folder).initialise() for _ in range(2)]
    threads = [threading.Thread(target=advance, args=(instance, 0, 40)) for instance in instances]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = Scalars(folder).initialise()
    advance(alone, 0, 40)
    assert instances[0].outputs() == instances[1].outputs() == alone.outputs()


# FMPy's own loop


def test_simulate_fmu_with_the_record_is_the_loop(folders):
    arguments = {"stop_time": 40 * H, "output_interval": H}
    arguments["output"] = ["crest_displacement.x", "base_pressure", "iterations", "converged"]
    found = simulate_fmu(str(folders["coupled"]), start_values={"use_record": 1}, **arguments)
    assert found["converged"].dtype == bool and found["iterations"].dtype == np.int32
    instance = Scalars(folders["coupled"]).initialise({"use_record": 1.0})
    for n in range(40):
        instance.fmu.doStep(n * H, H)
    assert len(found) == 41
    assert [found[name][-1] for name in arguments["output"]] == instance.get_all(arguments["output"])


def test_simulate_fmu_with_inputs_is_the_loop(folders):
    """FMPy sets the inputs of time t before the step from t."""
    times = np.arange(0, 41) * H
    table = np.array([(t, 3.0 * np.sin(40.0 * t)) for t in times], dtype=[("time", float), ("ground_acceleration", float)])
    names = ["crest_displacement.x", "base_pressure"]
    found = simulate_fmu(str(folders["coupled"]), input=table, stop_time=40 * H, output_interval=H, output=names)
    instance = Scalars(folders["coupled"]).initialise()
    for n in range(40):
        instance.set("ground_acceleration", table["ground_acceleration"][n])
        instance.fmu.doStep(n * H, H)
    for name in names:
        assert found[name][-1] == pytest.approx(instance.get(name), rel=1e-9), name


def test_the_scene_is_inside(archives, unit):
    with zipfile.ZipFile(archives[unit]) as archive:
        scene = tomllib.loads(archive.read("resources/scene.toml").decode())
    assert scene["time"]["duration"] == pytest.approx(0.51, abs=0.02)
