"""An ensemble by the workers of a Dask cluster: docs/guide/ensembles.md."""

import logging
import os
import re
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

_LOG = logging.getLogger(__name__)

_NO_SAMPLE = f"{10**9}/{10**9}"
"""A part that holds no sample: the plan is checked and the folder made, nothing is run."""

_ADDED = "added.toml"
"""Levels that `--add-levels` added to the plan, in the folder of an ensemble."""

_TIED = "import ctypes, os, sys; ctypes.CDLL(None).prctl(1, 9); os.execvp(sys.argv[1], sys.argv[1:])"
"""Becomes the program of its arguments, which the system kills when the caller dies (PR_SET_PDEATHSIG, SIGKILL)."""


class EnsembleError(RuntimeError):
    """Why an ensemble is not complete: what is wrong, where, and the remedy. Samples that came before are kept."""


def run_ensemble(plan, output, client, program="cofferdam", parts=None):
    """Runs the ensemble of the file `plan` into the folder `output` by the workers of `client`, a `distributed.Client`.

    The study is divided into `parts` tasks, each a `cofferdam ensemble --part` of one thread in a scratch folder of the worker;
    by default eight for each thread that the cluster has, and at least 32. The samples of a task are kept in `output` as soon as
    it is done, whole or not at all. Samples that are in `output` before are not run again. Dask gives the tasks of a lost worker to
    others. At the end `program` writes the tables here. Everything in `output` is, byte for byte, what `cofferdam ensemble`
    alone writes.

    Plan, scene and records must be at the same paths on the workers, `program` in their `PATH` or at the same path, and this package
    must be installed there; `output` is needed here alone. Returns `output` as a path.

    **Errors**: `EnsembleError`. The same call continues from the samples that are kept.
    """
    from distributed import KilledWorker, as_completed

    # Not resolved: a link may lead elsewhere on a worker.
    plan, output = Path(os.path.abspath(plan)), Path(output)
    if os.sep in (program := str(program)):
        program = os.path.abspath(program)
    version = _version(program, "this machine")
    _call([program, "ensemble", plan, "--output", output, "--part", _NO_SAMPLE], "this machine")
    samples = output / "samples"
    kept = {path.name: path.read_bytes() for path in [*samples.glob("*.toml"), *output.glob(_ADDED)]}
    if parts is None:
        parts = 8 * max(4, sum(client.nthreads().values()))
    # A task, not scattered data: that would be lost with the worker that holds it.
    held = client.submit(dict, kept, pure=False)
    told = (parts, plan, plan.read_bytes(), program, version, held)
    sent = _sent()
    tasks = {client.submit(sent, number, *told, pure=False): number for number in range(1, parts + 1)}
    killed = []
    try:
        for done, task in enumerate(as_completed(tasks), start=1):
            try:
                returned = task.result()
            except KilledWorker:
                killed.append(tasks[task])
                continue
            except RuntimeError as error:
                raise EnsembleError(str(error)) from None
            for name, content in returned.items():
                _keep(samples / name, content)
            _LOG.info("%d of %d parts, %d new samples in this one", done, parts, len(returned))
            task.release()
    finally:
        client.cancel([held, *tasks])
    if killed:
        raise EnsembleError(
            f"parts {', '.join(map(str, sorted(killed)))} of {parts} were given up, because every worker that ran them died; look"
            " into the workers' logs (memory, time limits of jobs); the same call continues, perhaps with more `parts` or a larger"
            " `distributed.scheduler.allowed-failures`"
        )
    _write_tables(program, plan, output)
    return output


def _sent():
    """`run_part` as Dask sends it: by value. Of the function itself the module would be sent by name, and a worker without it dies."""

    def part(*arguments):
        try:
            from cofferdam.ensemble import run_part
        except ImportError as error:
            raise RuntimeError(f"worker on {socket.gethostname()}: {error}; install the Python package cofferdam there") from None
        return run_part(*arguments)

    return part


def run_part(number, parts, plan, text, program, version, held):
    """The task of a worker: runs part `number` of `parts`; returns names and bytes of the samples that are not `held`."""
    from distributed import get_worker

    worker = get_worker()
    where = f"worker {worker.address} on {socket.gethostname()}"
    found = _version(program, where)
    if found != version:
        raise EnsembleError(f"{where}: `{program}` is {found}, on the client it is {version}; install the same build on all machines")
    try:
        there = plan.read_bytes()
    except OSError as error:
        raise EnsembleError(f"{where}: {error}; plan, scene and records must be at the same paths on all machines") from None
    if there != text:
        raise EnsembleError(f"{where}: {plan} is another plan than on the client; copy it there")
    with tempfile.TemporaryDirectory(prefix="cofferdam-", dir=worker.local_directory) as scratch:
        samples = Path(scratch) / "samples"
        samples.mkdir()
        # By its plan the program knows the folder as that of the same ensemble.
        (samples.parent / "plan.toml").write_bytes(text)
        for name, content in held.items():
            (samples.parent if name == _ADDED else samples).joinpath(name).write_bytes(content)
        part = ["--part", f"{number}/{parts}", "--threads", "1"]
        _call([program, "ensemble", plan, "--output", scratch, *part], where)
        now = {path.name: path.read_bytes() for path in samples.glob("*.toml")}
    return {name: content for name, content in now.items() if content != held.get(name)}


def _version(program, where):
    """What `--version` says."""
    try:
        return _call([program, "--version"], where, tied=False).strip()
    except FileNotFoundError:
        remedy = "install it there, or name it in full by `program`"
        raise EnsembleError(f"{where}: there is no program `{program}`; {remedy}") from None
    except OSError as error:
        raise EnsembleError(f"{where}: {error}") from None


def _call(command, where, tied=True):
    """Runs a command to its end and returns what it printed; `tied`: it does not outlive this process."""
    command = [sys.executable, "-I", "-c", _TIED, *command] if tied else command
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        _fail(where, done.returncode, done.stderr)
    return done.stdout


def _fail(where, status, said):
    how = f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"
    raise EnsembleError(f"{where}: cofferdam {how}:\n{said.strip()}")


def _keep(path, content):
    """Writes a sample whole or not at all."""
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".tmp", delete=False) as beside:
        beside.write(content)
    # A temporary file is its owner's alone; others may continue with a study.
    mask = os.umask(0)
    os.umask(mask)
    os.chmod(beside.name, 0o666 & ~mask)
    os.replace(beside.name, path)


def _write_tables(program, plan, output):
    """Lets the program write tables and pictures of samples that are all there."""
    command = [program, "ensemble", plan, "--output", output]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as tables:
        said = ""
        for line in tables.stdout:
            said += line
            counts = re.fullmatch(r"(\d+) samples, (\d+) of them to be run", line.strip())
            if counts and counts[2] != "0":
                tables.kill()
                raise EnsembleError(
                    f"{counts[2]} of {counts[1]} samples have other hashes than those that the workers returned: scene, records or the"
                    f" sources of `{program}` are others there than here; make them the same and call again (`cofferdam ensemble"
                    f" {plan} --output {output}` runs these samples on this machine)"
                )
    if tables.returncode != 0:
        _fail("this machine", tables.returncode, said)
