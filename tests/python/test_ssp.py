"""Dam and water as an SSP archive in FMPy, which does not iterate, compared with `cofferdam run`, which does."""

import csv
import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet, read_ssd, read_ssv
from fmpy.validation import validate_fmu
from fmus import SCENES, H, settings
from lxml import etree

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
INTACT = ["dam.cracks=[]", "ground_motion.record.start=3", "ground_motion.record.end=8", "time.quiet=0"]
SHORT = ["ground_motion.record.start=5", "ground_motion.record.end=6", "time.quiet=0"]
CREST = "dam.crest_displacement.x"


def cofferdam(*arguments):
    return subprocess.run([os.environ["COFFERDAM"], *arguments], capture_output=True, text=True)


def export(path, overrides=(), scene="koyna-coarse"):
    done = cofferdam("export-ssp", SCENES / scene, "--output", path, *settings(overrides))
    assert done.returncode == 0, done.stderr
    return path, done.stdout


def histories(folder, overrides=(), scene="koyna-coarse", until=None):
    """The histories of a run, without the values at time 0."""
    options = ["--transport", "in-process", "--quiet", "--no-report", "--log", "none", "--output", folder]
    options += ["--until", str(until)] if until else []
    done = cofferdam("run", SCENES / scene, *options, *settings(overrides))
    assert done.returncode == 0, done.stderr
    with open(folder / "histories.csv", newline="") as file:
        head, *rows = csv.reader(file)
    return {name.split(" [")[0]: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(head)}


def simulated(path, seconds, step=H, **arguments):
    """What FMPy computes: a row per step, with the values at its end."""
    # The last step begins before the stop time, which sums of steps may miss.
    return simulate_ssp(path, stop_time=seconds - step / 2, step_size=step, **arguments)


def errors(found, expected):
    """Of the largest value and of the whole history, over the largest value."""
    expected = expected[: len(found)]
    largest = np.abs(expected).max()
    return abs(np.abs(found).max() / largest - 1.0), np.abs(found - expected).max() / largest


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    return export(tmp_path_factory.mktemp("ssp") / "coarse.ssp", INTACT)[0]


def test_the_archive_is_valid(archive, tmp_path):
    system = read_ssd(archive)  # checked against the schema of SSP 1.0
    values = read_ssv(archive, "resources/dam.ssv")
    with zipfile.ZipFile(archive) as packed:
        assert packed.testzip() is None
        packed.extractall(tmp_path)
    names = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file())
    assert names == ["SystemStructure.ssd", "documentation/index.html"] + [
        f"resources/{name}" for name in ("dam.fmu", "dam.ssv", "reservoir.fmu")
    ]
    fmus = {name: tmp_path / "resources" / f"{name}.fmu" for name in ("dam", "reservoir")}
    described = {name: read_model_description(path) for name, path in fmus.items()}
    variables = {name: {v.name: v for v in one.modelVariables} for name, one in described.items()}
    for path in fmus.values():
        assert validate_fmu(str(path)) == []

    root = etree.parse(tmp_path / "SystemStructure.ssd").getroot()
    units = {unit.get("name") for unit in root.iter("{*}Unit")}
    kinds = {}
    for component in root.iter(f"{SSD}Component"):
        for connector in component.iter(f"{SSD}Connector"):
            of, name = component.get("name"), connector.get("name")
            assert variables[of][name].causality == connector.get("kind")
            unit = variables[of][name].unit or variables[of][name].declaredType.unit
            assert unit == connector[0].get("unit") and unit in units
            kinds[of, name] = connector.get("kind")
    # Every input has one source, and the importer has to drive none of them.
    ends = [(c.get("endElement"), c.get("endConnector")) for c in root.iter(f"{SSD}Connection")]
    inputs = [(of, name) for of, all in variables.items() for name, v in all.items() if v.causality == "input"]
    assert sorted(ends) == sorted(inputs) == sorted(key for key, kind in kinds.items() if kind == "input")
    for connection in root.iter(f"{SSD}Connection"):
        assert kinds[connection.get("startElement"), connection.get("startConnector")] == "output"
        assert connection.get("startConnector")[-4:].split("[")[1] == connection.get("endConnector")[-4:].split("[")[1]
    points = [sum(name.startswith("interface_pressure[") for name in of) for of in variables.values()]
    assert points[0] == points[1] > 15 and len(ends) == 2 * points[0]

    parameters = [v for v in variables["dam"].values() if v.causality == "parameter" and v.type == "Real"]
    starts = {v.name: float(v.start) for v in parameters}
    assert {p.name: float(p.value) for p in values.parameters} == starts
    assert starts["hydrostatic_pressure[1]"] == 9.81 * 1000.0 * 91.75
    experiment = root.find(f"{SSD}DefaultExperiment")
    step = experiment.find(".//{http://opensimulationplatform.com/SSP/OSPAnnotations}FixedStepAlgorithm")
    times = [float(described["dam"].defaultExperiment.stopTime), H]
    assert [float(experiment.get("stopTime")), float(step.get("baseStepSize"))] == times
    assert system.system.name == "koyna-coarse"


def test_the_error_beside_the_iterated_run_is_of_third_order(archive, tmp_path):
    found = {}
    for step in (0.01, 0.005, H):
        overrides = [*INTACT, f"time.communication_step={step}"]
        path = archive if step == H else export(tmp_path / f"{step}.ssp", overrides)[0]
        run = histories(tmp_path / f"run{step}", [*overrides, "coupling.tolerance=1e-8"])
        found[step] = errors(simulated(path, 4.5, step)[CREST], run[CREST])
        print(f"H = {step} s: peak {found[step][0]:.1e}, history {found[step][1]:.1e}")
    histories_of = [error for _, error in found.values()]
    assert histories_of[0] > 6 * histories_of[1] > 36 * histories_of[2]
    assert found[H][0] < 2e-4 and found[H][1] < 5e-4


def test_a_cracked_dam_is_as_close(tmp_path):
    """Sliding begins here; a run is uncertain by more than this."""
    path, said = export(tmp_path / "cracked.ssp")
    assert "components: dam, reservoir" in said and "always by 0.0025 s" in said and "third order" in said
    run = histories(tmp_path / "run", until=6)
    result = simulated(path, 6)
    peak, history = errors(result[CREST], run[CREST])
    sliding = errors(result["dam.crack[1].sliding"], run["dam.crack_sliding.0"])
    print(f"peak {peak:.1e}, history {history:.1e}, sliding {sliding[0]:.1e}")
    assert peak < 0.01 and history < 0.03
    # The force of the water is that of a step before.
    force = errors(result["reservoir.base_pressure"][1:], run["reservoir.base_pressure"])
    assert force[0] < 0.05


@pytest.mark.parametrize("fidelity", ["westergaard", "incompressible"])
def test_water_without_memory_is_the_added_mass_of_the_run(tmp_path, fidelity):
    overrides = [*SHORT, f'reservoir.fidelity="{fidelity}"']
    path, said = export(tmp_path / "mass.ssp", overrides)
    assert 'scheme "added-mass"' in said
    run = histories(tmp_path / "run", overrides)
    assert errors(simulated(path, 1)[CREST], run[CREST])[1] < 1e-6


def test_a_tailwater_is_a_component_of_its_own(tmp_path):
    overrides = [*SHORT, "dam.cracks=[]"]
    path, said = export(tmp_path / "tailwater.ssp", overrides, "koyna-tailwater")
    assert "components: dam, reservoir, tailwater" in said
    run = histories(tmp_path / "run", overrides, "koyna-tailwater")
    assert errors(simulated(path, 1)[CREST], run[CREST])[1] < 1e-3


def test_parameters_of_the_dam_can_be_changed(archive, tmp_path):
    parameters = ParameterSet(name="soft", parameters=[Parameter(name="dam.young_modulus", type="Real", value="2e10")])
    found = simulated(archive, 0.5, parameter_set=parameters)
    soft = export(tmp_path / "soft.ssp", [*INTACT, "dam.material.young_modulus=2e10"])[0]
    assert np.array_equal(found[CREST], simulated(soft, 0.5)[CREST])
    assert not np.array_equal(found[CREST], simulated(archive, 0.5)[CREST])


def test_only_the_step_of_the_scene_is_taken(archive):
    # In a process of its own: the last logger that any FMU of the process was given gets the message, and those of other tests are gone.
    code = f"from fmpy.ssp.simulation import simulate_ssp; simulate_ssp({str(archive)!r}, stop_time=0.09, step_size={2 * H})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and "FMICallException" in done.stderr, done.stderr


@pytest.mark.parametrize(
    "scene, overrides, text",
    [
        ("rigid-dam-ramp", [], "no dam to pack"),
        ("koyna-coarse", ['reservoir.fidelity="none"'], "reservoir is empty"),
        ("koyna-coarse", ["time.adaptive={tolerance=1e-3,shortest=0.000625,longest=0.0025}"], "time.adaptive"),
        ("koyna-coarse", ['reservoir.fidelity="command"', 'reservoir.command.argv=["true"]'], "reservoir.fidelity"),
    ],
)
def test_scenes_that_cannot_be_exported_are_refused(tmp_path, scene, overrides, text):
    path = tmp_path / "refused.ssp"
    done = cofferdam("export-ssp", SCENES / scene, "--output", path, *settings(overrides))
    assert done.returncode in (1, 2) and text in " ".join(done.stderr.split()), done.stderr
    assert not path.exists()


def test_files_are_overwritten_only_on_demand(archive):
    before = archive.read_bytes()
    done = cofferdam("export-ssp", SCENES / "koyna-coarse", "--output", archive, *settings(INTACT))
    assert done.returncode == 1 and "--force" in done.stderr
    done = cofferdam("export-ssp", SCENES / "koyna-coarse", "--output", archive, "--force", *settings(INTACT))
    assert done.returncode == 0 and archive.read_bytes() == before
