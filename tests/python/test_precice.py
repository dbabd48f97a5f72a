"""examples/solvers/precice_bridge.py with a stand-in for preCICE: the bits of the same unit without it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmus import ROOT, SCENES

HERE = Path(__file__).parent
WATER = HERE / "precice_water.py"
STEPS, H = 30, 0.0025
SETTINGS = ["ground_motion.record.start=5", "dam.fidelity=intact", "coupling.scheme=serial-implicit", "coupling.tolerance=1e-6"]


def run(folder, program, *settings):
    unit = ["reservoir.fidelity=command", f"reservoir.command.argv=['{sys.executable}','-B','{program}']"]
    options = [part for setting in [*SETTINGS, *unit, *settings] for part in ("--set", setting)]
    command = [os.environ["COFFERDAM"], "run", SCENES / "koyna-intact", "--quiet", "--no-report", "--until", str(STEPS * H)]
    environment = os.environ | {"PYTHONPATH": str(HERE / "precice_stand_in")}
    return subprocess.run([*command, "--output", folder, *options], capture_output=True, text=True, env=environment)


def configuration(folder, **changes):
    told = {"first": "Cofferdam", "second": "Water", "window": H, "max_time": STEPS * H, "flag": "Flag", "max_iterations": 100}
    path = folder / "coupling.json"
    path.write_text(json.dumps(told | {"program": str(WATER), "report": str(folder / "report.json")} | changes))
    return f"reservoir.command.parameters.configuration='{path}'"


def test_a_participant_of_precice_as_reservoir_gives_the_bits_of_the_unit_itself(tmp_path):
    done = [run(tmp_path / "unit", WATER)]
    done += [run(tmp_path / "precice", ROOT / "examples" / "solvers" / "precice_bridge.py", configuration(tmp_path))]
    assert [one.returncode for one in done] == [0, 0], [one.stderr for one in done]
    histories = [(tmp_path / name / "histories.csv").read_text() for name in ("unit", "precice")]
    assert histories[0] == histories[1] and len(histories[0].splitlines()) == STEPS + 2
    report = json.loads((tmp_path / "report.json").read_text())
    rows = np.genfromtxt(tmp_path / "unit" / "histories.csv", delimiter=",", names=True)
    iterations = int(sum(rows[next(name for name in rows.dtype.names if name.startswith("iterations"))]))
    # One further step of the other participant in each window; tests of repeatability come on top.
    assert report["windows"] == STEPS
    assert STEPS + iterations <= report["iterations"] <= STEPS + iterations + 12


@pytest.mark.parametrize(
    "changes, reason",
    [({"window": 0.005}, "`time-window-size` is 0.005 s"), ({"max_iterations": 1}, "raise `max-iterations`")],
)
def test_configurations_that_do_not_obey_are_refused(tmp_path, changes, reason):
    done = run(tmp_path / "precice", ROOT / "examples" / "solvers" / "precice_bridge.py", configuration(tmp_path, **changes))
    assert done.returncode == 4 and reason in " ".join(done.stderr.replace("│", " ").split())


def test_the_stand_in_keeps_the_order_of_calls(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(HERE / "precice_stand_in"))
    precice = pytest.importorskip("precice")
    configuration(tmp_path)
    participant = precice.Participant("Cofferdam", str(tmp_path / "coupling.json"), 0, 1)
    vertices = participant.set_mesh_vertices("Face", np.zeros((19, 2)))
    with pytest.raises(precice.Error, match="after `initialize`"):
        participant.write_data("Face", "Flag", vertices, np.zeros(19))
    participant.initialize()
    with pytest.raises(precice.Error, match="`requires_writing_checkpoint` was not called"):
        participant.advance(H)
    assert participant.requires_writing_checkpoint()
    for name in ("Acceleration", "Flag"):
        participant.write_data("Face", name, vertices, np.zeros(19))
    participant.advance(H)
    with pytest.raises(precice.Error, match="`requires_reading_checkpoint` was not called"):
        participant.advance(H)
    assert participant.requires_reading_checkpoint() and not participant.is_time_window_complete()
    participant.advance(H)
    assert participant.is_time_window_complete() and participant.requires_writing_checkpoint()
