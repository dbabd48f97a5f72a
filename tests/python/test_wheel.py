"""The wheel that carries the command works in a fresh environment."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_wheel_brings_the_command_and_the_fmus(tmp_path):
    programs = Path(os.environ["COFFERDAM"]).resolve().parent
    wheels = tmp_path / "wheels"
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", wheels, ROOT / "python"]
    subprocess.run(build, check=True, env=os.environ | {"COFFERDAM_PROGRAMS": str(programs)})
    (wheel,) = wheels.glob("cofferdam_seismic-*-py3-none-linux_x86_64.whl")

    environment = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    binaries = environment / "bin"
    subprocess.run([binaries / "python", "-m", "pip", "install", "--quiet", wheel], check=True)
    subprocess.run([binaries / "python", "-c", "import cofferdam; cofferdam.Reservoir"], check=True, cwd=tmp_path)
    scenes, command = ROOT / "scenes", binaries / "cofferdam"
    run = [command, "run", scenes / "rigid-dam-ramp", "--set", "time.duration=0.05", "--output", tmp_path / "run"]
    subprocess.run(run, check=True, capture_output=True)
    assert (tmp_path / "run" / "report.html").is_file()
    for unit in ("dam", "reservoir"):
        fmu = tmp_path / f"{unit}.fmu"
        export = [command, "export-fmu", scenes / "koyna-coarse", "--unit", unit, "--output", fmu]
        subprocess.run(export, check=True, capture_output=True)
        assert fmu.stat().st_size > 1e5
