"""The examples for FMPy are short, and their results are right."""

import csv
import os
import subprocess
import sys

import loop_cost
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmus import H, RECORD, ROOT, SCENES, STRONG_SECOND, pack, settings

EXAMPLES = ROOT / "examples" / "fmpy"


def start(name, *arguments):
    command = [sys.executable, "-B", EXAMPLES / name, *arguments]
    return subprocess.run(command, capture_output=True, text=True)


def example(name, *arguments):
    """Runs an example and returns what it printed."""
    done = start(name, *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout)
    return done.stdout


def run(folder, scene, overrides=()):
    """The histories of a run of the orchestrator, by name without unit."""
    command = [os.environ["COFFERDAM"], "run", SCENES / scene, "--quiet", "--output", folder, *settings(overrides)]
    subprocess.run(command, check=True, capture_output=True)
    with open(folder / "histories.csv", newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip((name.split(" [")[0] for name in header), np.array(rows, dtype=float).T))


def table(path):
    return np.genfromtxt(path, delimiter=",", names=True, deletechars="")


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_examples_are_short(path):
    assert len(path.read_text().splitlines()) < 80


def test_the_fixed_point_is_the_orchestrators(tmp_path):
    """One second of strong motion in the main scene: the crest agrees to 1e-9, and the same calls give the same bits."""
    aitken = [*STRONG_SECOND, "coupling.acceleration=aitken", "coupling.tolerance=1e-6"]
    fmus = [pack(tmp_path, unit, aitken) for unit in ("dam", "reservoir")]
    said = [example("fixed_point.py", *fmus, RECORD, tmp_path / f"{n}.csv") for n in (1, 2)]
    assert said[0] == said[1] and (tmp_path / "1.csv").read_bytes() == (tmp_path / "2.csv").read_bytes()
    histories = run(tmp_path / "run", "koyna-coarse", aitken)
    found, expected = table(tmp_path / "1.csv"), histories["dam.crest_displacement.x"][1:]
    assert len(found) == len(expected) >= 400
    difference = np.abs(found["crest_x"] - expected).max() / np.abs(expected).max()
    print(f"crest: largest difference {difference:.1e} of the peak")
    assert difference < 1e-9


def test_water_without_memory_counts_once(tmp_path):
    """By default a dam is packed without the water's inertia: coupled with Westergaard's water it is the staggered run."""
    westergaard = ["reservoir.fidelity=westergaard", "dam.element_size=8", "coupling.acceleration=aitken", *STRONG_SECOND]
    fmus = [pack(tmp_path, unit, westergaard) for unit in ("dam", "reservoir")]
    example("fixed_point.py", *fmus, RECORD, tmp_path / "results.csv")
    staggered = [*westergaard, "coupling.scheme=serial-implicit", "coupling.tolerance=1e-6"]
    expected = run(tmp_path / "run", "koyna-coarse", staggered)["dam.crest_displacement.x"][1:]
    found = table(tmp_path / "results.csv")["crest_x"]
    # Both stop within a tolerance of 1e-6, though not at the same iterate.
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_pairs_that_do_not_belong_together_are_refused(tmp_path):
    coarse = ["dam.element_size=10", "reservoir.fidelity=westergaard", "coupling.acceleration=aitken", *STRONG_SECOND]
    for name in ("with", "moved", "fewer"):
        (tmp_path / name).mkdir()
    dam, water = (pack(tmp_path, unit, coarse) for unit in ("dam", "reservoir"))
    with_mass = pack(tmp_path / "with", "dam", coarse, options=["--added-mass"])
    moved, fewer = (
        pack(tmp_path / name, "reservoir", [*coarse, f"reservoir.depth={depth}"])
        for name, depth in (("moved", 91), ("fewer", 70))
    )
    pairs = [("count twice", with_mass, water), ("faces differ", dam, fewer), ("faces differ", dam, moved)]
    for word, *pair in pairs:
        done = start("fixed_point.py", *pair, RECORD)
        assert done.returncode == 1 and word in done.stderr, done.stderr


def test_the_reservoir_alone_is_the_orchestrators(tmp_path):
    fmu = pack(tmp_path, "reservoir", scene="rigid-dam-ramp")
    example("reservoir_alone.py", fmu, tmp_path / "results.csv")
    histories = run(tmp_path / "run", "rigid-dam-ramp")
    found, expected = table(tmp_path / "results.csv"), histories["reservoir.base_pressure"]
    np.testing.assert_allclose(found["base_pressure"], expected, rtol=0, atol=1e-9 * expected.max())


def test_the_dam_alone_is_that_of_simulate_fmu(tmp_path):
    """FMPy sets inputs at the beginning of a step: a record shifted by one step gives the same result."""
    fmu = pack(tmp_path, "dam", [*STRONG_SECOND, "dam.element_size=10"])
    said = example("dam_alone.py", fmu, RECORD, tmp_path / "results.csv")
    results = table(tmp_path / "results.csv")
    error = np.abs(results["energy_balance_error[1]"]).max() / results["kinetic_energy[1]"].max()
    assert error < 0.01 and "residual sliding" in said

    record = np.loadtxt(RECORD, delimiter=",", comments=["#", "time"])
    signals = np.zeros(len(results), [("time", float), ("ground_acceleration", float, 2)])
    signals["time"] = results["time"] - H
    times, samples = np.append(record[500:601, 0] - 5.0, 1.01), np.append(record[500:601, 1], 0.0)
    signals["ground_acceleration"][:, 0] = 9.80665 * np.interp(results["time"], times, samples)
    start = {"ground_acceleration": [9.80665 * samples[0], 0.0]}
    again = simulate_fmu(fmu, input=signals, start_values=start, output_interval=H, output=["crest_displacement"])
    crest = again["crest_displacement"][1:, 0]
    # In the first step a(H) is used instead of a(0).
    np.testing.assert_allclose(crest, results["crest_displacement[1]"], rtol=0, atol=2e-3 * np.abs(crest).max())


SIX_SECONDS = ["dam.element_size=10", "time.duration=6"]


@pytest.fixture(scope="module")
def six_seconds(tmp_path_factory):
    """The histories of a coarse run of six seconds."""
    return run(tmp_path_factory.mktemp("six-seconds") / "run", "koyna-coarse", SIX_SECONDS)


@pytest.fixture(scope="module", params=["2", "3"])
def coupled(request, tmp_path_factory):
    """The same scene as a coupled FMU of each version."""
    return pack(tmp_path_factory.mktemp("coupled"), "coupled", SIX_SECONDS, options=["--fmi", request.param])


def test_the_coupled_fmu_is_the_run(six_seconds, coupled):
    said = example("coupled.py", coupled)
    crest, sliding = (1e3 * six_seconds[name] for name in ("dam.crest_displacement.x", "dam.crack_sliding.0"))
    assert f"upstream: {crest.min():+.2f} mm" in said and f"downstream: {crest.max():+.2f} mm" in said
    assert f"at 6.00 s: {sliding[-1]:+.3f} mm" in said and "100% of the steps converged" in said


def test_an_input_one_step_earlier_is_the_record(coupled):
    inside, late, shifted = example("own_record.py", coupled, RECORD, "6").splitlines()[1:]
    differences = [float(line.split()[-2]) for line in (inside, late, shifted)]
    assert differences[0] == 0.0 and differences[1] > 0.1 and differences[2] < 1e-8


@pytest.mark.parametrize("coupled", ["2"], indirect=True)
def test_more_friction_means_less_sliding(six_seconds, coupled):
    rows = [line.split() for line in example("friction_study.py", coupled).splitlines()[1:]]
    results = {float(friction): (float(crest), float(sliding)) for friction, crest, sliding in rows}
    assert len(results) == 7 and results[0.5][1] > results[0.8][1] > results[1.1][1]
    expected = [1e3 * np.abs(six_seconds["dam.crest_displacement.x"]).max(), 1e3 * six_seconds["dam.crack_sliding.0"][-1]]
    np.testing.assert_allclose(results[1.0], expected, rtol=0, atol=0.006)


def test_the_friction_study_needs_no_dask(monkeypatch):
    import friction_study  # fmus makes the examples importable

    monkeypatch.setitem(sys.modules, "dask", None)
    assert friction_study.in_processes(abs, [-1, 2]) == [1, 2]


def test_the_cost_of_the_loop_can_be_measured(capsys):
    """The script runs; figures are in docs/measurements/performance.md, because they depend on the machine."""
    loop_cost.main(iterations=5)
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 3 and all("loop median" in line for line in said)
