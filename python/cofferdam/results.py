"""Folders of runs and ensembles as tables of pandas and data sets of xarray: docs/guide/running.md, docs/guide/ensembles.md."""

import csv
import io
import tomllib
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

import numpy as np


class Run:
    """The folder of a run, also of one that continues or was killed. Every file is read when it is first asked for."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.manifest = _manifest(self.folder, "manifest.toml", "a run", "open_ensemble opens that of an ensemble")
        """The manifest as a dictionary: `status`, `scene`, `build`, `result` and others."""

    @cached_property
    def table(self):
        """The results, a row a quantity: `value`, `unit` and, where there are, `subject`, `time` (s), `place` (m), `band`."""
        if "result" not in self.manifest:
            status = self.manifest["status"]
            raise ValueError(f"{self.folder}: the run has no results, its status is `{status}`; its histories are there")
        return _import("pandas").DataFrame(self.manifest["result"]["quantities"]).set_index("name")

    @cached_property
    def histories(self):
        """`histories.csv`: index `time [s]`, columns with their names in the file; `attrs["units"]` has the units by column."""
        return _histories(self.folder / "histories.csv")

    @cached_property
    def wet_faces(self):
        """Motion and pressure of the wet faces over `time` and their points, from the heel (toe) up; each variable has its `units`.

        Variables are named as in the histories: `dam.interface_displacement`, `reservoir.interface_pressure`. Dimension `point`, with
        the coordinates `x` and `y`, is that of the reservoir's face, `tailwater_point` that of a tailwater's; a water with points
        of its own has `reservoir_own_point`, `tailwater_own_point`.
        """
        xarray = _import("xarray")
        manifest, variables = self.manifest, []
        # Prefix of the dimensions, name of the water, its variables of the dam, points of the dam, own points.
        waters = [("", "reservoir", "", manifest["wet_face"], manifest.get("reservoir_wet_face"))]
        for face in manifest.get("further_wet_faces", []):
            water = face["water"]
            waters.append((f"{water}_", water, f"{water}_", face["points"], face.get("own_points")))
        for prefix, water, of_dam, points, own in waters:
            own_prefix = f"{water}_own_" if own else prefix
            for unit, start, places, dimension in [("dam", of_dam, points, prefix), (water, "", own or points, own_prefix)]:
                for path in sorted(self.folder.glob(f"{unit}-{start}interface_*.csv")):
                    frame = _histories(path)
                    x, y = ((f"{dimension}point", column, {"units": "m"}) for column in np.transpose(places))
                    time = ("time", frame.index, {"units": "s"})
                    variables.append(
                        xarray.DataArray(
                            frame.to_numpy(),
                            {"time": time, f"{dimension}x": x, f"{dimension}y": y},
                            ("time", f"{dimension}point"),
                            name=path.stem.replace("-", ".", 1),
                            attrs={"units": frame.attrs["units"][frame.columns[0]]},
                        )
                    )
        if not variables:
            raise FileNotFoundError(_missing(self.folder / "reservoir-interface_pressure.csv", _EXPORT))
        # Of a run that was killed one file may have a row more than another.
        faces = xarray.merge(variables, join="inner", compat="equals")
        # Those of the first variable.
        faces.attrs.clear()
        return faces

    @cached_property
    def envelopes(self):
        """Extremes over the run at the nodes of the dam; each variable has its `units`. `triangles` are the nodes of each triangle."""
        return _grid(self.folder / "envelopes-dam.vtu")

    @cached_property
    def crack_envelopes(self):
        """Largest opening, least and most slip at the contacts of the cracks."""
        return _grid(self.folder / "envelopes-cracks.vtu")


class Ensemble:
    """The folder of an ensemble. Every file is read when it is first asked for."""

    def __init__(self, folder):
        self.folder = Path(folder)
        remedy = "the command without --part writes it when all parts are done; open_run opens the folder of a run"
        self.manifest = _manifest(self.folder, "ensemble.toml", "a complete ensemble", remedy)
        """What it was made from, as a dictionary: `records`, `levels`, `parameters`, `build` and others."""

    @cached_property
    def results(self):
        """`results.csv`: a row a run, index `sample`."""
        return self.table("results").set_index("sample")

    @cached_property
    def statistics(self):
        """`statistics.csv`: index `quantity` and `level`."""
        return self.table("statistics").set_index(["quantity", "level"])

    def table(self, name):
        """The table `name`.csv, such as `fragility` or `variance`; `attrs["units"]` has the units of columns that name one."""
        tables = sorted(path.stem for path in self.folder.glob("*.csv"))
        words = ("hash", "status", "record", "pair", "warnings", "quantity", "level", "limit", "remark")
        # Not converted: a record may be named 1e5 or NA.
        remedy = f"tables here: {', '.join(tables)}; `cofferdam ensemble` with the same plan writes them again"
        return _csv(self.folder / f"{name}.csv", remedy, words)


def open_run(folder):
    """Opens the folder of a run.

    **Errors**: `FileNotFoundError`, which names what is missing.
    """
    return Run(folder)


def open_ensemble(folder):
    """Opens the folder of an ensemble.

    **Errors**: `FileNotFoundError`, which names what is missing.
    """
    return Ensemble(folder)


_EXPORT = "`cofferdam log export` makes it from the log"


def _import(name):
    """pandas or xarray, which a unit does without."""
    try:
        return __import__(name)
    except ImportError:
        raise ImportError(f"{name} is needed to open results: pip install './python[runs]'") from None


def _missing(path, remedy):
    return f"{path} is missing; {remedy}"


def _manifest(folder, name, what, remedy):
    try:
        with open(folder / name, "rb") as file:
            return tomllib.load(file)
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(f"{folder} is not the folder of {what}: {name} is missing; {remedy}") from None


def _csv(path, remedy, words=()):
    """A CSV file, the numbers bit for bit, the columns `words` as they are. A row that a killed run did not finish is left out."""
    pandas = _import("pandas")
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise FileNotFoundError(_missing(path, remedy)) from None
    names, *rows = csv.reader(io.StringIO(text[: text.rfind("\n") + 1]))
    if any(len(row) != len(names) for row in rows):
        raise ValueError(f"{path}: its rows differ in length; {remedy}")
    columns = {name: [row[column] for row in rows] for column, name in enumerate(names)}
    frame = pandas.DataFrame({name: values if name in words else _numbers(values) for name, values in columns.items()})
    frame.attrs["units"] = {name: _parted(name)[1] for name in names if name.endswith("]")}
    return frame


def _numbers(values):
    """The values as numbers, where all are; an empty one is none."""
    for kind in (int, lambda value: float(value or "nan")):
        try:
            return [kind(value) for value in values]
        except ValueError:
            pass
    return values


def _histories(path):
    frame = _csv(path, _EXPORT)
    units = frame.attrs["units"]
    frame = frame.set_index("time [s]")
    frame.attrs["units"] = units
    return frame


def _parted(heading):
    """Name and unit of a heading such as `peak sliding [mm]`."""
    name, _, unit = heading.removesuffix("]").rpartition(" [")
    return name, unit


def _grid(path):
    """The points of a `.vtu` file of a run, with their fields."""
    xarray = _import("xarray")
    try:
        piece = ElementTree.parse(path).find("UnstructuredGrid/Piece")
    except FileNotFoundError:
        remedy = "a run writes it at its end, if its dam is computed and, for contacts, cracked; not with `dam.envelopes = false`"
        raise FileNotFoundError(_missing(path, remedy)) from None
    numbers = lambda array, kind=float: np.array((array.text or "").split(), dtype=kind)
    x, y, _ = numbers(piece.find("Points/DataArray")).reshape(-1, 3).T
    fields = {}
    for array in piece.findall("PointData/DataArray"):
        name, unit = _parted(array.get("Name"))
        fields[name] = ("point", numbers(array), {"units": unit})
    cells = {array.get("Name"): numbers(array, int) for array in piece.findall("Cells/DataArray")}
    if (cells["types"] == 5).all():
        fields["triangles"] = (("triangle", "corner"), cells["connectivity"].reshape(-1, 3))
    places = {"x": ("point", x, {"units": "m"}), "y": ("point", y, {"units": "m"})}
    return xarray.Dataset(fields, places)
