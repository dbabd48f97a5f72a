"""A short run of the cracked dam that all tests look at."""

import os
import subprocess
import tomllib
from pathlib import Path

import fmus
import pytest

ROOT = Path(__file__).resolve().parents[2]
CASE = ROOT / "scenes" / "koyna-coarse"


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """The folder of a run of half a second of strong motion on a coarse mesh."""
    folder = tmp_path_factory.mktemp("run")
    text = (CASE / "scene.toml").read_text()
    record = (CASE / tomllib.loads(text)["ground_motion"]["record"]["file"]).resolve()
    text = text.replace("element_size = 5.0", "element_size = 10.0").replace("quiet = 5.0", "quiet = 0.1")
    text = text.replace('file = "../records/', f'start = 5.0\nend = 5.5\nfile = "{record.parent}/')
    (folder / "scene.toml").write_text(text)
    command = [os.environ["COFFERDAM"], "run", folder / "scene.toml", "--quiet", "--output", folder / "out"]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "out"


@pytest.fixture(scope="session")
def coarse(tmp_path_factory):
    """The FMUs of half a second of strong motion on a coarse mesh, by unit."""
    folder = tmp_path_factory.mktemp("fmus")
    return {unit: fmus.pack(folder, unit, fmus.COARSE_HALF_SECOND) for unit in ("dam", "reservoir")}
