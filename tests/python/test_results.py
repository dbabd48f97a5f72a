"""What runs and ensembles have written, opened with pandas and xarray: the numbers and units of the files."""

import csv
import os
import shutil
import subprocess
import sys
import tomllib

import cofferdam
import fmus
import numpy as np
import pytest


def table(path):
    """Headings and rows of a CSV file."""
    with open(path, newline="") as file:
        headings, *rows = csv.reader(file)
    return headings, rows


@pytest.fixture(scope="module")
def opened(run):
    return cofferdam.open_run(run)


def test_histories_are_those_of_the_file(run, opened):
    headings, rows = table(run / "histories.csv")
    values = np.array(rows, dtype=float)
    assert [opened.histories.index.name, *opened.histories.columns] == headings
    np.testing.assert_array_equal(opened.histories.index, values[:, 0])
    np.testing.assert_array_equal(opened.histories.to_numpy(), values[:, 1:])
    units = opened.histories.attrs["units"]
    assert [f"{name.rpartition(' [')[0]} [{units[name]}]" for name in headings] == headings
    assert units["dam.crest_displacement.x [m]"] == "m" and units["time [s]"] == "s"


def test_the_table_is_that_of_the_manifest(run, opened):
    manifest = tomllib.loads((run / "manifest.toml").read_text())
    assert opened.manifest == manifest
    quantities = manifest["result"]["quantities"]
    assert list(opened.table.index) == [quantity["name"] for quantity in quantities]
    for quantity in quantities:
        row = opened.table.loc[quantity["name"]]
        assert (row["value"], row["unit"]) == (quantity["value"], quantity["unit"])
        assert row["time"] == quantity["time"] if "time" in quantity else np.isnan(row["time"])


def test_wet_faces_have_the_points_of_the_manifest_and_the_numbers_of_the_files(run, opened):
    faces = opened.wet_faces
    files = {path.name: path for path in run.glob("*interface_*.csv")}
    assert {f"{name.replace('.', '-', 1)}.csv" for name in faces} == set(files)
    np.testing.assert_array_equal(np.transpose([faces.x, faces.y]), opened.manifest["wet_face"])
    for name, face in faces.items():
        headings, rows = table(files[f"{name.replace('.', '-', 1)}.csv"])
        np.testing.assert_array_equal(np.column_stack([face.time, face]), np.array(rows, dtype=float))
        assert all(heading.endswith(f" [{face.units}]") for heading in headings[1:])
    assert faces["reservoir.interface_pressure"].units == "Pa" and faces.y.units == "m" and not faces.attrs


def test_points_of_each_water_are_told_apart(tmp_path):
    """Of a run with a tailwater, and a reservoir that has points of its own."""
    sets = [*fmus.COARSE_HALF_SECOND, "ground_motion.record.end=5.05", "tailwater.depth=20", "reservoir.interface_size=8"]
    command = [os.environ["COFFERDAM"], "run", fmus.SCENES / "koyna-coarse", *fmus.settings(sets)]
    options = ["--quiet", "--no-report", "--transport", "in-process", "--output", tmp_path / "run"]
    subprocess.run([*command, *options], check=True, capture_output=True)
    opened = cofferdam.open_run(tmp_path / "run")
    faces, (tailwater,) = opened.wet_faces, opened.manifest["further_wet_faces"]
    for name, dimension, points in [
        ("dam.interface_displacement", "", opened.manifest["wet_face"]),
        ("reservoir.interface_pressure", "reservoir_own_", opened.manifest["reservoir_wet_face"]),
        ("dam.tailwater_interface_displacement", "tailwater_", tailwater["points"]),
        ("tailwater.interface_pressure", "tailwater_", tailwater["points"]),
    ]:
        _, rows = table(tmp_path / "run" / f"{name.replace('.', '-', 1)}.csv")
        assert faces[name].dims == ("time", f"{dimension}point")
        np.testing.assert_array_equal(faces[name], np.array(rows, dtype=float)[:, 1:])
        np.testing.assert_array_equal(np.transpose([faces[f"{dimension}x"], faces[f"{dimension}y"]]), points)
    assert len(set(faces.sizes.values())) == 4


def test_envelopes_have_the_extremes_of_the_table(opened):
    envelopes = opened.envelopes
    largest = opened.table.loc["largest tension in the dam"]
    assert largest["unit"] == "MPa"
    node = np.argmax(envelopes["major_principal_stress_max"].data)
    assert envelopes["major_principal_stress_max"].units == "Pa"
    np.testing.assert_allclose(1e-6 * envelopes["major_principal_stress_max"][node], largest["value"], rtol=1e-12)
    np.testing.assert_allclose([envelopes.x[node], envelopes.y[node]], largest["place"])
    assert envelopes.triangles.max() < envelopes.sizes["point"]
    opening = opened.table.loc["peak opening"]
    np.testing.assert_allclose(1e3 * opened.crack_envelopes["opening_max"].max(), opening["value"], rtol=1e-12)


def test_a_run_that_was_killed_is_read_up_to_its_last_whole_row(run, tmp_path):
    folder = tmp_path / "killed"
    shutil.copytree(run, folder)
    manifest = (folder / "manifest.toml").read_text()
    start, end = manifest.index("[result]"), manifest.index("[scene")
    (folder / "manifest.toml").write_text(manifest[:start] + manifest[end:])
    _, rows = table(folder / "histories.csv")
    for name, cut in [("histories.csv", 3), ("reservoir-interface_pressure.csv", 1)]:
        text = (folder / name).read_text()
        (folder / name).write_text(text[:-cut])
    killed = cofferdam.open_run(folder)
    assert len(killed.histories) == len(killed.wet_faces.time) == len(rows) - 1
    with pytest.raises(ValueError, match="the run has no results, its status is `completed`"):
        killed.table


def test_what_is_missing_is_named(run, tmp_path):
    with pytest.raises(FileNotFoundError, match=r"is not the folder of a run: manifest\.toml is missing; open_ensemble"):
        cofferdam.open_run(tmp_path)
    with pytest.raises(FileNotFoundError, match="is not the folder of a run"):
        cofferdam.open_run(run / "histories.csv")
    with pytest.raises(FileNotFoundError, match=r"a complete ensemble: ensemble\.toml is missing"):
        cofferdam.open_ensemble(run)
    shutil.copy(run / "manifest.toml", tmp_path)
    bare = cofferdam.open_run(tmp_path)
    for member, what in [
        ("histories", r"histories\.csv is missing; `cofferdam log export`"),
        ("wet_faces", r"reservoir-interface_pressure\.csv is missing; `cofferdam log export`"),
        ("envelopes", r"envelopes-dam\.vtu is missing; a run writes it at its end"),
    ]:
        with pytest.raises(FileNotFoundError, match=what):
            getattr(bare, member)


def test_a_unit_needs_none_of_the_packages_for_results(run, monkeypatch):
    needed = "import cofferdam, sys; print(*sorted({'dask', 'distributed', 'pandas', 'xarray'} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", needed], text=True) == "\n"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pandas is needed to open results: pip install"):
        cofferdam.open_run(run).histories
