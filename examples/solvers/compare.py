"""Runs scenes with the units of this folder and with the built-in ones, and prints a Markdown table: compare.py COFFERDAM [UNITS…].

The exit status is 1 if a peak differs by more than 5 %. With `--write`, the table replaces the one between the markers of
README.md. UNITS selects rows of `ROWS` by their names.
"""

import csv
import os
import subprocess
import sys
import tempfile
import tomllib
from datetime import date
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import numpy as np

HERE = Path(__file__).resolve().parent
UNTIL = 8.0  # s; the strong motion is over
LIMIT = 0.05  # of the difference of a peak from the first row of the scene
MARKERS = "<!-- table -->", "<!-- end of the table -->"
# By name: scene, programs in place of units, further settings.
ROWS = {
    "built-in": ("koyna-intact", {}, []),
    "built-in, 2.5 m": ("koyna-intact", {}, ["dam.element_size=2.5"]),
    "scikit-fem dam": ("koyna-intact", {"dam": "scikit_fem_dam.py"}, []),
    "scikit-fem water": ("koyna-intact", {"reservoir": "scikit_fem_water.py"}, []),
    "scikit-fem dam and water": ("koyna-intact", {"dam": "scikit_fem_dam.py", "reservoir": "scikit_fem_water.py"}, []),
    "OpenSees dam": ("koyna-intact", {"dam": "opensees_dam.py"}, []),
    "Kratos dam": ("koyna-intact", {"dam": "kratos_dam.py"}, []),
    "built-in, cracked": ("koyna-coarse", {}, ["dam.damping.drags_blocks=true"]),
    "built-in, cracked, 2.5 m": ("koyna-coarse", {}, ["dam.damping.drags_blocks=true", "dam.element_size=2.5"]),
    "scikit-fem cracked dam": ("koyna-coarse", {"dam": "scikit_fem_cracked_dam.py"}, []),
}
# Rows without these packages are left out.
NEEDED = {"opensees_dam.py": "openseespy", "kratos_dam.py": "KratosMultiphysics"}
TITLES = ["units", "scene", "crest downstream", "crest upstream", "dam steps per step", "interface work", "wall time"]


class Run:
    """A run of a row, in the folder `output`."""

    def __init__(self, cofferdam, output, scene, programs, settings):
        for unit, program in programs.items():
            settings = [*settings, f"{unit}.fidelity=command", f"{unit}.command.argv=['{sys.executable}','{HERE / program}']"]
        options = [part for setting in settings for part in ("--set", setting)]
        command = [cofferdam, "run", HERE.parents[1] / "scenes" / scene, "--quiet", "--no-report", "--log", "none"]
        began = perf_counter()
        done = subprocess.run([*command, "--until", str(UNTIL), "--output", output, *options], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{output.name}: exit status {done.returncode}\n{done.stderr}")
        self.wall = perf_counter() - began
        quantities = tomllib.loads((output / "manifest.toml").read_text())["result"]["quantities"]
        values = {quantity["name"]: quantity["value"] for quantity in quantities}
        self.steps = values["dam steps per communication step, mean"]
        with open(output / "histories.csv") as file:
            titles, *rows = csv.reader(file)
        at = {title.split(" [")[0]: place for place, title in enumerate(titles)}
        crest = np.array([float(row[at["dam.crest_displacement.x"]]) for row in rows])
        self.peaks = 1e3 * crest.max(), 1e3 * crest.min()  # mm
        self.work = float(rows[-1][at["interface_work"]]) / 1e3  # kJ/m

    def differences(self, reference):
        return [own / other - 1 for own, other in zip(self.peaks, reference.peaks)]

    def cells(self, reference):
        """Peaks with their differences from the run `reference`, and the other columns."""
        peaks = [f"{own:.2f} mm ({100 * apart:+.2f} %)" for own, apart in zip(self.peaks, self.differences(reference))]
        return [*peaks, f"{self.steps:.2f}", f"{self.work:.1f} kJ/m", f"{self.wall:.1f} s"]


def table(cofferdam, names):
    lines, reference, far = [TITLES, ["---"] * len(TITLES)], {}, []
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(names):
            scene, programs, settings = ROWS[name]
            if scene not in reference:
                first = next(row for row in ROWS.values() if row[0] == scene)
                reference[scene] = Run(cofferdam, Path(folder, scene), *first)
            run = Run(cofferdam, Path(folder, str(number)), scene, programs, settings) if programs or settings else reference[scene]
            lines.append([name, f"`{scene}`", *run.cells(reference[scene])])
            far += [name] if max(map(abs, run.differences(reference[scene]))) > LIMIT else []
            print(f"{number + 1} of {len(names)}: {name}", file=sys.stderr)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines), far


def write(text):
    page = HERE / "README.md"
    before, rest = page.read_text().split(MARKERS[0])
    commit = subprocess.run(["git", "describe", "--always", "--abbrev=12"], cwd=HERE, capture_output=True, text=True).stdout.strip()
    stamp = f"Measured on {date.today()}, commit {commit}, {os.cpu_count()} cores, Python {sys.version.split()[0]}."
    page.write_text(f"{before}{MARKERS[0]}\n\n{text}\n\n{stamp}\n\n{MARKERS[1]}{rest.split(MARKERS[1])[1]}")


def main(cofferdam, *names):
    chosen = [name for name in names if name != "--write"]
    unknown = [name for name in chosen if name not in ROWS]
    if unknown:
        raise SystemExit(f"{', '.join(unknown)}: not one of {', '.join(ROWS)}")
    packages = {name: [NEEDED[program] for program in row[1].values() if program in NEEDED] for name, row in ROWS.items()}
    there = [name for name in chosen or ROWS if all(map(find_spec, packages[name]))]
    if left_out := [name for name in chosen or ROWS if name not in there]:
        print(f"left out, as packages are missing: {', '.join(left_out)}", file=sys.stderr)
    text, far = table(cofferdam, there)
    (write if "--write" in names else print)(text)
    if far:
        raise SystemExit(f"a peak differs by more than {100 * LIMIT:g} %: {', '.join(far)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
