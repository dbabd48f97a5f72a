"""Draws docs/figures/water_pressure.png: the pressure in the water at four instants of the main scene, from its pictures for ParaView.

    cargo run --release -- run scenes/koyna-northridge-1994 --set snapshots.interval=0.02 --output runs/water
    python3 docs/figures/water_pressure.py runs/water docs/figures/water_pressure.png

It needs Python 3 with matplotlib.
"""

import math
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

PRESSURE = "hydrodynamic_pressure [Pa]"
INSTANTS = 4


def pictures(run, part):
    """Time and file of each picture of a part."""
    sets = xml.parse(run / "snapshots.pvd").iter("DataSet")
    return [(float(s.get("timestep")), run / s.get("file")) for s in sets if s.get("name") == part]


def grid(file):
    """Points and cells of a grid, and its fields by name."""
    arrays = {}
    for array in xml.parse(file).iter("DataArray"):
        numbers = [float(number) for number in (array.text or "").split()]
        arrays[array.get("Name")] = numbers
    points = list(zip(arrays["points"][0::3], arrays["points"][1::3]))
    ends = [int(end) for end in arrays["offsets"]]
    nodes = [int(node) for node in arrays["connectivity"]]
    return points, [nodes[a:b] for a, b in zip([0, *ends], ends)], arrays


def parts(cell):
    """A triangle of six nodes as four of three; others as they are."""
    if len(cell) != 6:
        return [cell]
    a, b, c, ab, bc, ca = cell
    return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]


def draw(axis, run, number, time, most):
    points, cells, fields = grid(run / f"snapshots/reservoir-{number:06}.vtu")
    triangles = [part for cell in cells for part in parts(cell)]
    levels = [most * (i / 14 - 1) for i in range(29)]
    pressure = [p / 1e3 for p in fields[PRESSURE]]
    shown = axis.tricontourf(*zip(*points), triangles, pressure, levels=levels, cmap="RdBu_r")
    points, cells, _ = grid(run / f"snapshots/dam-{number:06}.vtu")
    axis.tripcolor(*zip(*points), cells, facecolors=[0.5] * len(cells), cmap="Greys", vmin=0, vmax=1)
    axis.set_aspect("equal")
    axis.set_title(f"{time:.2f} s", fontsize=11)
    axis.set_xlim(right=75)
    return shown


def main(folder, picture):
    run = Path(folder)
    found = []
    for number_of, (time, file) in enumerate(pictures(run, "wet_face")):
        pressure = grid(file)[2][PRESSURE]
        found.append((max(map(abs, pressure)), time, int(file.stem.split("-")[-1]), number_of))
    most = max(found)
    # A quarter of a period of the water's first mode apart, some 0.07 s: from the largest pressure on.
    step = max(1, round(0.07 / (found[1][1] - found[0][1])))
    instants = [found[min(most[3] + i * step, len(found) - 1)] for i in range(INSTANTS)]
    figure, axes = plt.subplots(2, 2, figsize=(11, 5.4), layout="constrained", sharex=True, sharey=True)
    for axis, (_, time, number, _) in zip(axes.flat, instants):
        shown = draw(axis, run, number, time, math.ceil(most[0] / 7e4) * 70)
    figure.colorbar(shown, ax=axes, label="hydrodynamic pressure, kPa")
    figure.supxlabel("x, m")
    figure.supylabel("y, m")
    figure.savefig(picture, dpi=110)


main(*sys.argv[1:])
