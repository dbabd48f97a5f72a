"""An ensemble on the workers of Dask: the bytes of `cofferdam ensemble`, whatever happens to workers."""

import csv
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import cofferdam
import numpy as np
import pytest
from cofferdam.ensemble import run_part
from distributed import Client, LocalCluster
from fmus import RECORD, ROOT, SCENES

COFFERDAM = os.environ["COFFERDAM"]
PLAN = f"""
scene = "{SCENES / "koyna-coarse"}"
set = ["time.quiet=0", "dam.element_size=20", "dam.fidelity=reduced", "reservoir.fidelity=westergaard",
       "coupling.scheme=serial-implicit"]
records = [{{ name = "1e5", file = "{RECORD}", start = 4.5, end = 5.0 }}]
polarities = [1, -1]
[intensity]
levels = [0.2, 0.4, 0.8]
[[limits]]
quantity = "peak sliding"
above = 0.3
"""
SAMPLES = 6
PARTS = 4
PATIENCE = 120
"""Time after which a test gives up, s."""

PROGRAM = """#!/bin/sh
case "$*" in
{trouble}
esac
exec "{program}" "$@"
"""
"""The program, but for some arguments."""


@pytest.fixture(scope="module")
def client():
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, env={"WORKER": "yes"}) as cluster,
        Client(cluster) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A plan, and its folder by `cofferdam ensemble` alone."""
    folder = tmp_path_factory.mktemp("study")
    plan = folder / "plan.toml"
    plan.write_text(PLAN)
    subprocess.run([COFFERDAM, "ensemble", plan, "--output", folder / "alone"], check=True, capture_output=True)
    return plan, folder / "alone"


def content(folder):
    """Names and bytes of all files."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def troubled(folder, trouble):
    """A program that meets with `trouble`: a case of a shell."""
    path = folder / "troubled"
    path.write_text(PROGRAM.format(trouble=trouble, program=COFFERDAM))
    path.chmod(0o755)
    return str(path)


def waited_for(condition):
    until = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < until:
        time.sleep(0.01)
    return condition()


def has_ended(process):
    """Whether it is gone, or waits for nothing but a parent that asks."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2].startswith("Z")
    except FileNotFoundError:
        return True


def test_a_worker_that_is_killed_loses_nothing(client, study, tmp_path):
    plan, alone = study
    hung, killed = tmp_path / "hung", []
    # Whoever is first at this part stays there.
    stay = f'mkdir "{hung}" && echo $PPID $$ >"{hung}/new" && mv "{hung}/new" "{hung}/processes" && exec sleep {5 * PATIENCE}'
    program = troubled(tmp_path, f'*"--part 2/"*) {stay} ;;')

    def kill():
        if waited_for((hung / "processes").exists):
            worker, of_part = map(int, (hung / "processes").read_text().split())
            os.kill(worker, signal.SIGKILL)
            killed.append(of_part)

    killer = threading.Thread(target=kill)
    killer.start()
    output = cofferdam.run_ensemble(plan, tmp_path / "out", client, program=program, parts=PARTS)
    killer.join()
    assert len(killed) == 1
    assert waited_for(lambda: has_ended(killed[0])), "what the lost worker ran continues"
    assert len(list((output / "samples").iterdir())) == SAMPLES
    assert content(output) == content(alone)


def test_a_client_that_is_killed_keeps_what_is_done(client, study, tmp_path):
    plan, alone = study
    output, process = tmp_path / "out", tmp_path / "process"
    program = troubled(tmp_path, f'*"--part {PARTS}/"*) echo $$ >"{process}.new" && mv "{process}.new" "{process}" && exec sleep {5 * PATIENCE} ;;')
    script = (
        "import cofferdam, distributed, sys; plan, output, address, program = sys.argv[1:];"
        f" cofferdam.run_ensemble(plan, output, distributed.Client(address), program, {PARTS})"
    )
    killed = subprocess.Popen([sys.executable, "-c", script, plan, output, client.scheduler.address, program])
    # All parts but the last, which has one sample; one worker is enough.
    done = lambda: len(list(output.glob("samples/*.toml"))) == SAMPLES - 1 and process.exists()
    assert waited_for(done)
    killed.kill()
    killed.wait()
    os.kill(int(process.read_text()), signal.SIGKILL)
    kept = content(output / "samples")
    assert kept.items() < content(alone / "samples").items()
    cofferdam.run_ensemble(plan, output, client, program=COFFERDAM, parts=PARTS)
    assert content(output) == content(alone)


def test_a_part_that_kills_every_worker_is_named_and_the_rest_is_kept(client, study, tmp_path):
    plan, alone = study
    program = troubled(tmp_path, f'*"--part 2/"*) kill -9 $PPID && exec sleep {5 * PATIENCE} ;;')
    scheduler = client.cluster.scheduler
    before, scheduler.allowed_failures = scheduler.allowed_failures, 1
    try:
        with pytest.raises(cofferdam.EnsembleError, match=rf"parts (\d, )*2(, \d)* of {PARTS} were given up"):
            cofferdam.run_ensemble(plan, tmp_path / "out", client, program=program, parts=PARTS)
    finally:
        scheduler.allowed_failures = before
    kept = content(tmp_path / "out" / "samples")
    assert 0 < len(kept) < SAMPLES and kept.items() < content(alone / "samples").items()


def test_samples_that_are_there_are_not_run_again(client, study, tmp_path, monkeypatch):
    """Paths are those of the caller: the workers are in another folder."""
    plan, alone = study
    monkeypatch.chdir(tmp_path)
    output = tmp_path / "out"
    shutil.copytree(alone / "samples", output / "samples")
    shutil.copy(plan, output / "plan.toml")
    lost, torn, marked, *_ = sorted((output / "samples").iterdir())
    lost.unlink()
    torn.write_bytes(torn.read_bytes()[:100])
    # As no run would write it.
    lines = marked.read_text().splitlines(keepends=True)
    marked.write_text("".join("simulated_time = 123.0\n" if "simulated_time" in line else line for line in lines))
    expected = {**content(alone / "samples"), marked.name: marked.read_bytes()}
    cofferdam.run_ensemble(*map(os.path.relpath, (plan, output)), client, program=os.path.relpath(COFFERDAM), parts=PARTS)
    assert content(output / "samples") == expected
    results = cofferdam.open_ensemble(output).results
    assert results["simulated time [s]"].eq(123.0).sum() == 1


def test_added_levels_are_run_by_the_workers_too(client, study, tmp_path):
    plan, alone = study
    more, output = tmp_path / "more", tmp_path / "out"
    shutil.copytree(alone, more)
    subprocess.run([COFFERDAM, "ensemble", plan, "--output", more, "--add-levels"], check=True, capture_output=True)
    assert len(list((more / "samples").iterdir())) > SAMPLES
    shutil.copytree(alone / "samples", output / "samples")
    for name in ("plan.toml", "added.toml"):
        shutil.copy(more / name, output)
    cofferdam.run_ensemble(plan, output, client, program=COFFERDAM, parts=PARTS)
    assert content(output) == content(more)


@pytest.mark.parametrize(
    "trouble, wanted",
    [
        ('--version) [ "$WORKER" ] && echo "cofferdam 0.0.9" && exit ;;', r"worker tcp.*: `.*` is cofferdam 0\.0\.9, on the client"),
        ('*"--part 2/"*) echo "the disk is full" >&2; exit 1 ;;', r"worker tcp.*: cofferdam ended with status 1:\nthe disk is full"),
        (
            f'*--part*) [ "$WORKER" ] && "{COFFERDAM}" "$@" && cd "$4/samples" && for s in *; do mv $s 0$s; done && exit ;;',
            rf"{SAMPLES} of {SAMPLES} samples have other hashes",
        ),
    ],
    ids=["version", "failure", "sources"],
)
def test_workers_that_do_not_fit_are_refused(client, study, tmp_path, trouble, wanted):
    plan, _ = study
    with pytest.raises(cofferdam.EnsembleError, match=wanted):
        cofferdam.run_ensemble(plan, tmp_path / "out", client, program=troubled(tmp_path, trouble), parts=PARTS)
    assert not (tmp_path / "out" / "results.csv").exists()


def test_a_worker_without_the_package_is_named(client, study, tmp_path):
    plan, _ = study

    def hide(hidden):
        if hidden:
            sys.modules["cofferdam.ensemble"] = None
        else:
            del sys.modules["cofferdam.ensemble"]

    client.run(hide, True)
    try:
        with pytest.raises(cofferdam.EnsembleError, match="worker on .*; install the Python package cofferdam there"):
            cofferdam.run_ensemble(plan, tmp_path / "out", client, program=COFFERDAM, parts=PARTS)
    finally:
        client.run(hide, False)


def test_a_plan_that_is_not_the_same_everywhere_is_refused(client, study):
    plan, _ = study
    version = subprocess.check_output([COFFERDAM, "--version"], text=True).strip()
    for path, text, wanted in [
        (plan, b"another", "is another plan than on the client"),
        (plan.parent / "none", b"", "No such file or directory: .*; plan, scene and records must be at the same paths"),
    ]:
        with pytest.raises(cofferdam.EnsembleError, match=wanted):
            client.submit(run_part, 1, PARTS, path, text, COFFERDAM, version, {}).result()


def test_what_is_wrong_here_is_said_before_any_task(study, tmp_path):
    plan, _ = study
    (tmp_path / "plan.toml").write_text(PLAN.replace("polarities", "polarity"))
    with pytest.raises(cofferdam.EnsembleError, match=r"(?s)this machine: cofferdam ended with status 2:\n.*unknown field `polarity`"):
        cofferdam.run_ensemble(tmp_path / "plan.toml", tmp_path / "out", None, program=COFFERDAM)
    with pytest.raises(cofferdam.EnsembleError, match="this machine: there is no program `no-cofferdam`; install it there"):
        cofferdam.run_ensemble(plan, tmp_path / "out", None, program="no-cofferdam")
    with pytest.raises(cofferdam.EnsembleError, match="(?s)this machine: cofferdam ended with status 1:.* contains\\s"):
        cofferdam.run_ensemble(plan, tmp_path, None, program=COFFERDAM)
    assert not (tmp_path / "out").exists()


def test_the_script_of_the_document_runs(study, tmp_path):
    plan, alone = study
    script = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "guide" / "ensembles.md").read_text(), re.DOTALL)[1]
    # On a machine with many cores, too.
    (tmp_path / "script.py").write_text(script.replace("LocalCluster()", "LocalCluster(n_workers=1, threads_per_worker=2)"))
    shutil.copy(plan, tmp_path)
    where = {**os.environ, "PATH": f"{Path(COFFERDAM).parent}:{os.environ['PATH']}"}
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, env=where, check=True, capture_output=True, text=True)
    assert "0.8 g" in done.stdout
    assert content(tmp_path / "study") == content(alone)


def test_an_ensemble_is_opened_with_the_numbers_of_its_files(study):
    _, alone = study
    opened = cofferdam.open_ensemble(alone)
    headings, *rows = csv.reader((alone / "results.csv").open(newline=""))
    assert [opened.results.index.name, *opened.results.columns] == headings and len(opened.results) == SAMPLES
    for name, values in zip(headings[1:], list(zip(*rows))[1:]):
        column = opened.results[name]
        if name in ("hash", "status", "record", "pair", "warnings"):
            assert tuple(column) == values
        else:
            expected = np.array([float(value or "nan") for value in values])
            np.testing.assert_array_equal(column.to_numpy(dtype=float), expected, err_msg=name)
    assert opened.results.attrs["units"]["peak sliding [mm]"] == "mm"
    headings, *rows = csv.reader((alone / "statistics.csv").open(newline=""))
    for quantity, level, runs, *numbers in rows:
        row = opened.statistics.loc[(quantity, level)]
        assert row["runs"] == int(runs)
        np.testing.assert_array_equal(row.to_numpy(dtype=float)[1:], [float(value or "nan") for value in numbers])
    assert opened.manifest["polarities"] == [1, -1]
    assert opened.table("limits")["limit"].tolist() == ["peak sliding > 0.3 mm"]
    with pytest.raises(FileNotFoundError, match=r"methods\.csv is missing; tables here: exceedance, fragility"):
        opened.table("methods")
