"""The coupled FMU (FMI 2.0), or dam and water as an SSP archive, in other importers, compared with the run of the same scene.

python importers.py libcosim|ecos FMU|SSP HISTORIES

`libcosim` needs libcosimpy, `ecos` needs ecospy and the library of the package tbb. The record is inside the FMU, so that
all values of all steps of the coupled FMU must be equal to those of histories.csv, bit for bit. The archive is coupled by the
importer, which does not iterate: its displacements must be within 1 % of the largest.
"""

import csv
import sys

OUTPUTS = {
    "crest_displacement.x": "dam.crest_displacement.x",
    "crack[1].sliding": "dam.crack_sliding.0",
    "base_pressure": "reservoir.base_pressure",
    "iterations": "iterations",
}


def by_libcosim(fmu, step):
    """Yields the outputs after each step."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(round(1e9 * step))
    slave = CosimLocalSlave(fmu, "dam")
    unit = execution.add_local_slave(slave)
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(unit)}
    assert execution.real_initial_value(unit, references["use_record"], 1.0)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    while True:
        assert execution.step(), "libcosim failed"
        yield observer.last_real_values(unit, [references[name] for name in OUTPUTS])


def by_ecos(fmu, step):
    """Yields the outputs after each step."""
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.EcosParameterSet import EcosParameterSet

    structure = EcosSimulationStructure()
    structure.add_model("dam", fmu)
    parameters = EcosParameterSet()
    parameters.add_real("dam::use_record", 1.0)
    structure.add_parameter_set("record", parameters)
    with EcosSimulation(structure=structure, step_size=step) as simulation:
        simulation.init(0.0, "record")
        while True:
            simulation.step()
            yield [simulation.get_real(f"dam::{name}") for name in OUTPUTS]


def archive_by_libcosim(ssp, step):
    """Yields the displacement of the crest after each step."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(ssp)  # the step is in the archive
    unit = execution.slave_index_from_instance_name("dam")
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(unit)}
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    while True:
        assert execution.step(), "libcosim failed"
        yield observer.last_real_values(unit, [references["crest_displacement.x"]])[0]


def archive_by_ecos(ssp, step):
    """Yields the displacement of the crest after each step."""
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=ssp, step_size=step) as simulation:
        simulation.init(0.0, "initialValues")
        while True:
            simulation.step()
            yield simulation.get_real("dam::crest_displacement.x")


def compare_archive(importer, ssp, step, expected):
    found = {"libcosim": archive_by_libcosim, "ecos": archive_by_ecos}[importer](ssp, step)
    largest = max(abs(value) for value in expected)
    error = max(abs(a - b) for a, b in zip(expected, found, strict=False)) / largest
    print(f"{importer}: crest displacements differ by {100 * error:.3f} % of the largest from the iterated run")
    sys.exit(error > 0.01)


def main(importer, fmu, histories):
    with open(histories, newline="") as file:
        header, *rows = csv.reader(file)
    names = [name.split(" [")[0] for name in header]
    step = float(rows[1][0]) - float(rows[0][0])
    if fmu.endswith(".ssp"):
        crest = names.index("dam.crest_displacement.x")
        compare_archive(importer, fmu, step, [float(row[crest]) for row in rows[1:]])
    expected = [[float(row[names.index(name)]) for name in OUTPUTS.values()] for row in rows[1:]]
    found = {"libcosim": by_libcosim, "ecos": by_ecos}[importer](fmu, step)
    differing = sum(a != b for row, values in zip(expected, found, strict=False) for a, b in zip(row, values, strict=True))
    print(f"{importer}: {differing} of {len(expected) * len(OUTPUTS)} values differ from the run")
    sys.exit(differing > 0)


if __name__ == "__main__":
    main(*sys.argv[1:])
