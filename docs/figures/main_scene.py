"""Draws docs/figures/main_scene.svg from the histories of a run of the main scene.

    cargo run --release -- run scenes/koyna-northridge-1994 --output runs/main
    python3 docs/figures/main_scene.py runs/main/histories.csv docs/figures/main_scene.svg

It needs Python 3 with matplotlib.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# (column without its unit, factor, label, colour)
PANELS = [
    ("ground_acceleration.x", 1 / 9.80665, "ground\nacceleration, g", "#7a4b00"),
    ("dam.crest_displacement.x", 1e3, "crest\ndisplacement, mm", "#1f77b4"),
    ("dam.crack_sliding.0", 1e3, "sliding at\nthe crack, mm", "#c8102e"),
]


def columns(path):
    """The columns of a CSV file by name, units in brackets removed."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        names = [name.split("[")[0].split("(")[0].strip() for name in next(rows)]
        values = zip(*(map(float, row) for row in rows))
        return dict(zip(names, map(list, values)))


def main(histories, picture):
    plt.rcParams.update({"svg.hashsalt": "main scene", "font.size": 12, "axes.grid": True, "grid.alpha": 0.4})
    data = columns(histories)
    figure, axes = plt.subplots(len(PANELS), 1, sharex=True, figsize=(9, 6.2), layout="constrained")
    for axis, (name, factor, label, colour) in zip(axes, PANELS):
        axis.plot(data["time"], [factor * value for value in data[name]], color=colour, linewidth=1.2)
        axis.set_ylabel(label)
    axes[0].set_title("Cracked Koyna dam, Northridge 1994; downstream is positive")
    axes[-1].set_xlabel("time, s")
    axes[-1].set_xlim(data["time"][0], data["time"][-1])
    # Neither date nor version of matplotlib: the same run gives the same file.
    figure.savefig(picture, metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
