"""The package for units in Python: what it says of itself, and tasks that it refuses.

What needs an orchestrator is tested in tests/foreign_units.rs.
"""

import json
import subprocess
import sys
from xml.etree import ElementTree

import cofferdam
import numpy as np
import pytest
from cofferdam import header, variables
from fmus import ROOT

EXAMPLES = ROOT / "examples" / "python"
SHAPES = {"wet-face": 1, "plane": 1, "scalar": 0}
POINTS = cofferdam.Points(*(np.ones(3) for _ in range(5)))


def task(role="fluid", **changes):
    brief = {
        "role": role,
        "points": {name: [1.0, 1.0] for name in ("x", "y", "normal_x", "normal_y", "tributary_length")},
        "depth": 2.0,
        "density": 1000.0,
        "gravity": 9.81,
        "communication_step": 0.01,
        "duration": 1.0,
        "acceleration": "mean",
        "parameters": {},
    }
    of_run = {"run": 7, "folder": "/dev/shm/no-such-run", "service": "ipc", "prefix": "no-such-run-"}
    return {"protocol": 6, **of_run, "unit": "reservoir", "threads": 1, "scene": "", "brief": brief, **changes}


def serve(program, line, *arguments):
    """Starts a unit with this line on its standard input."""
    command = [sys.executable, "-B", ROOT / program, *arguments]
    return subprocess.run(command, input=line, capture_output=True, text=True, timeout=60)


def refused(done):
    """The reason that a unit gave."""
    words = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    assert done.returncode == 4 and "failed" in words[-1], done.stdout + done.stderr
    return words[-1]["failed"]["text"]


@pytest.mark.parametrize("role, unit", [("fluid", "reservoir"), ("structure", "dam")])
def test_variables_are_those_of_the_model_descriptions(role, unit):
    described = ElementTree.parse(ROOT / "modelDescription" / f"{unit}.xml").getroot()
    known = {v.get("name"): v for v in described.find("ModelVariables")}
    for variable in variables.INPUTS[role] + variables.OUTPUTS[role] + variables.READABLE[role]:
        reference = known[variable.name]
        assert int(reference.get("valueReference")) == variable.value_reference, variable
        assert reference.get("unit", "1") == variable.unit, variable
        assert len(reference.findall("Dimension")) == SHAPES[variable.shape], variable


def test_the_header_is_that_of_the_document():
    """Name, type and offset in the table of docs/reference/protocol.md."""
    lines = (ROOT / "docs" / "reference" / "protocol.md").read_text().splitlines()
    rows = [[cell.strip(" `") for cell in line.split("|")[1:4]] for line in lines if line.startswith("| `")]
    fields = [(name, kind, int(offset)) for name, kind, offset in rows if kind in ("u32", "u64", "f64")]
    assert fields == header.FIELDS


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_examples_are_short(path):
    assert len(path.read_text().splitlines()) < 80


@pytest.mark.parametrize(
    "line, reason",
    [
        ("", "is no task"),
        ("[1]\n", "it names no unit"),
        ("no JSON\n", "is no task"),
    ],
)
def test_what_is_no_task_is_refused(line, reason):
    done = serve("examples/python/westergaard.py", line)
    assert done.returncode != 0 and reason in done.stderr and "cofferdam run" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "changes, reason",
    [
        ({"protocol": 7}, "the orchestrator speaks version 7 of the exchange protocol"),
        ({"service": "private-files"}, "for a built-in unit"),
        ({}, "No such file or directory: '/dev/shm/no-such-run'"),
    ],
)
def test_tasks_that_it_cannot_do_are_refused(changes, reason):
    done = serve("examples/python/westergaard.py", json.dumps(task(**changes)) + "\n")
    assert reason in refused(done)


def of(base, **members):
    return type("Unit", (base,), members)


def step(self, *_):
    return np.zeros(3)


@pytest.mark.parametrize(
    "cls, role, reason",
    [
        (dict, "fluid", "neither a cofferdam.Reservoir nor"),
        (of(cofferdam.Dam, step=step), "fluid", "is a structure, but a fluid is asked for"),
        (of(cofferdam.Reservoir, save=step), "fluid", "one of `save` and `restore`"),
        (of(cofferdam.Reservoir, serialise=step), "fluid", "one of `serialise` and `deserialise`"),
        (of(cofferdam.Reservoir, outputs=("pressure",)), "fluid", "names pressure; possible are interface_pressure"),
        (of(cofferdam.Dam, outputs=("interface_displacement",)), "structure", "lacks interface_acceleration"),
        (of(cofferdam.Reservoir, outputs=("interface_pressure",) * 2), "fluid", "names a variable twice"),
    ],
)
def test_classes_that_cannot_be_units_are_refused(cls, role, reason):
    from cofferdam.exchange import Exchange

    of_task = cofferdam.Task("unit", role, POINTS, 1.0, 1.0, 9.81, 0.1, 1.0, "mean", {})
    with pytest.raises((TypeError, ValueError), match=reason):
        Exchange(cls, of_task, "/dev/shm/no-such-run")


def test_more_outputs_are_one_answer():
    from cofferdam.exchange import Exchange, NotOffered

    outputs = ("interface_acceleration", "crest_displacement", "base_shear", "interface_displacement")
    dam = of(cofferdam.Dam, outputs=outputs, step=lambda *_: (np.full(3, 1.0), (2.0, 3.0), 4.0, [5.0, 6.0, 7.0]))
    of_task = cofferdam.Task("dam", "structure", POINTS, 1.0, 1.0, 9.81, 0.1, 1.0, "mean", {})
    exchange = Exchange(dam, of_task, "/dev/shm/no-such-run")
    request = header.Header(protocol_version=6, command=header.STEP, time=0.0, communication_step=0.1)
    assert exchange.answer(request, np.zeros(8)).tolist() == [1, 1, 1, 2, 3, 4, 5, 6, 7]
    request.command = header.SAVE_AND_STEP
    with pytest.raises(NotImplementedError, match="explicit scheme"):
        exchange.answer(request, np.zeros(8))
    # Commands that it need not know.
    for command in (header.SERIALISE, header.RESTORE_AND_SERIALISE, header.DESERIALISE):
        request.command = command
        assert exchange.values_needed(request) == 0
        with pytest.raises(NotOffered):
            exchange.answer(request, np.zeros(0))
    # One that it does not know: it may have any number of values.
    request.command = 9
    for asked in (exchange.values_needed, lambda unknown: exchange.answer(unknown, np.zeros(2))):
        with pytest.raises(NotOffered):
            asked(request)


def test_states_as_bytes_go_through_the_file_of_the_run(tmp_path):
    from cofferdam.exchange import Exchange

    class Sum(cofferdam.Reservoir):
        def start(self, *_):
            self.sum = np.zeros(3)

        def step(self, time, communication_step, acceleration, ground_acceleration):
            self.sum = self.sum + acceleration
            return self.sum

        def save(self):
            return self.sum

        def restore(self, state):
            self.sum = state

        def serialise(self):
            return self.sum.tobytes()

        def deserialise(self, state):
            self.sum = np.frombuffer(state)

    def ask(exchange, command, values=()):
        request = header.Header(protocol_version=6, command=command)
        return exchange.answer(request, np.array(values, dtype=float))

    of_task = cofferdam.Task("unit", "fluid", POINTS, 1.0, 1.0, 9.81, 0.1, 1.0, "mean", {})
    first, second, third = (Exchange(Sum, of_task, tmp_path) for _ in range(3))
    ask(first, header.INITIALISE, np.zeros(5))
    ask(first, header.STEP, [1, 2, 3, 0, 0])
    ask(first, header.SAVE_AND_STEP, [10, 20, 30, 0, 0])
    ask(first, header.SERIALISE)
    ask(second, header.DESERIALISE)
    assert ask(second, header.STEP, [100, 200, 300, 0, 0]).tolist() == [111, 222, 333]
    ask(first, header.RESTORE_AND_SERIALISE)
    ask(third, header.DESERIALISE)
    assert ask(third, header.STEP, [0.5, 0.5, 0.5, 0, 0]).tolist() == [1.5, 2.5, 3.5]
    assert ask(first, header.STEP, np.zeros(5)).tolist() == [1, 2, 3]


def test_a_class_is_tested_without_a_run():
    """The oscillator under a constant load against its closed form, and its saved states."""
    sys.path.insert(0, str(EXAMPLES))
    from oscillator_dam import OscillatorDam

    points = cofferdam.Points(np.zeros(2), np.array([0.0, 1.0]), np.ones(2), np.zeros(2), np.full(2, 0.5))
    parameters = {"mass": 4.0, "frequency": 3.0, "damping_ratio": 0.1}
    dam = OscillatorDam(cofferdam.Task("dam", "structure", points, 1.0, 1.0, 9.81, 0.1, 1.0, "mean", parameters))
    load = np.full(2, 8.0), np.zeros(2), np.zeros(2)
    dam.start(0.0, *load)
    for number in range(1, 41):
        state = dam.save()
        once = dam.step(0.1 * number, 0.1, *load)
        dam.restore(state)
        assert all((a == b).all() for a, b in zip(once, dam.step(0.1 * number, 0.1, *load)))
        time, decay, damped = 0.1 * number, 0.3, 3.0 * np.sqrt(0.99)
        free = np.cos(damped * time) + decay / damped * np.sin(damped * time)
        # F/(m ω²), F = 8 N/m on 1 m
        np.testing.assert_allclose(once[0], 8.0 / 36.0 * (1.0 - np.exp(-decay * time) * free), rtol=1e-12)


def test_fingerprint_covers_the_units_table_of_the_scene_but_not_its_place():
    from cofferdam.exchange import Exchange

    def fingerprint(scene):
        of_task = cofferdam.Task.from_json(task("structure") | {"unit": "dam", "scene": scene})
        unit = of(cofferdam.Dam, step=step)
        return Exchange(unit, of_task, "/dev/shm/no-such-run").description(task("structure")["brief"])["fingerprint"]

    same = fingerprint("[dam]\nsize = 5.0\n[dam.command]\nfolder = '/a'\n[reservoir]\ndepth = 1.0")
    assert same == fingerprint("[dam]\nsize = 5.0\n[dam.command]\nfolder = '/b'\n[reservoir]\ndepth = 2.0")
    assert same != fingerprint("[dam]\nsize = 2.5\n[dam.command]\nfolder = '/a'\n[reservoir]\ndepth = 1.0")


def test_a_dam_states_whether_its_mass_contains_the_water():
    from cofferdam.exchange import Exchange

    of_task = cofferdam.Task("dam", "structure", POINTS, 1.0, 1.0, 9.81, 0.1, 1.0, "mean", {})
    request = header.Header(protocol_version=6, command=header.READ, variable=61)
    for included in (False, True):
        unit = of(cofferdam.Dam, step=step, added_mass_included=included)
        assert Exchange(unit, of_task, "/dev/shm/no-such-run").answer(request, np.zeros(0)) == [float(included)]
