"""FMUs of other makers as the main scene's reservoir: python makers.py COFFERDAM SCENE FOLDER.

Westergaard's water by PythonFMU (FMI 2.0, scalars p[1], p[2], …), iterated, beside the built-in water; water that only damps,
p = −ρ c v, by UniFMU (FMI 2.0) beside the same as a process, staggered once, because UniFMU 0.0.3 crashes when its state is saved.
It needs pythonfmu, unifmu, pyzmq, numpy and the package cofferdam, and a Python with a shared library.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import numpy as np
from cofferdam import westergaard

PYTHONFMU = """
import json, os
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Water(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.mass = json.load(open(os.path.join(self.resources, "mass.json")))
        self.a, self.p = [[0.0] * len(self.mass) for _ in range(2)]
        for i in range(len(self.mass)):
            def put(value, i=i):
                self.a[i] = value
            self.register_variable(Real(f"a[{i + 1}]", causality=Fmi2Causality.input,
                                        getter=lambda i=i: self.a[i], setter=put))
            self.register_variable(Real(f"p[{i + 1}]", causality=Fmi2Causality.output, getter=lambda i=i: self.p[i]))

    def do_step(self, time, step):
        self.p = [-sum(m * a for m, a in zip(row, self.a)) for row in self.mass]
        return True
"""

UNIFMU = """
from fmi2 import Fmi2FMU, Fmi2Status

POINTS = %d

class Model(Fmi2FMU):
    def __init__(self, reference_to_attr=None):
        super().__init__(reference_to_attr)
        self.v = [0.0] * POINTS
        for i in range(POINTS):
            setattr(self, f"a[{i + 1}]", 0.0)
            setattr(self, f"p[{i + 1}]", 0.0)

    def do_step(self, time, step, no_step_prior):
        for i in range(POINTS):
            self.v[i] += step * getattr(self, f"a[{i + 1}]")
            setattr(self, f"p[{i + 1}]", -1440e3 * self.v[i] if i < POINTS - 1 else 0.0)
        return Fmi2Status.ok
"""

DASHPOT = """
import numpy as np
import cofferdam

class Dashpot(cofferdam.Reservoir):
    def __init__(self, task):
        self.v = np.zeros(len(task.points.y))

    def step(self, time, communication_step, acceleration, ground_acceleration):
        self.v = self.v + communication_step * acceleration
        pressure = -1440e3 * self.v
        pressure[-1] = 0
        return pressure

cofferdam.serve(Dashpot)
"""


def description(points):
    """The modelDescription.xml of the water by UniFMU."""
    scalar = '<ScalarVariable name="{}[{}]" valueReference="{}" variability="continuous" causality="{}"{}'
    inputs = [scalar.format("a", i + 1, i, "input", '><Real start="0.0"/></ScalarVariable>') for i in range(points)]
    outputs = [
        scalar.format("p", i + 1, points + i, "output", ' initial="calculated"><Real/></ScalarVariable>')
        for i in range(points)
    ]
    unknowns = "".join(f'<Unknown index="{points + i + 1}"/>' for i in range(points))
    return (
        '<?xml version="1.0" encoding="utf-8"?><fmiModelDescription fmiVersion="2.0" modelName="water" guid="1"'
        ' generationTool="UniFMU"><CoSimulation modelIdentifier="unifmu" needsExecutionTool="true"'
        ' canHandleVariableCommunicationStepSize="true"/><ModelVariables>'
        + "".join(inputs + outputs)
        + f"</ModelVariables><ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
        "</ModelStructure></fmiModelDescription>"
    )


def zipped(folder, file):
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                archive.write(path, path.relative_to(folder))


def crest(run):
    with open(run / "histories.csv") as file:
        rows = list(csv.reader(file))
    return np.array([float(row[rows[0].index("dam.crest_displacement.x [m]")]) for row in rows[1:]])


def main(cofferdam, scene, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    tools = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{tools}:{os.environ['PATH']}"}

    def run(name, *settings, **variables):
        options = [part for setting in ("time.duration=3", *settings) for part in ("--set", setting)]
        command = [cofferdam, "run", scene, "--quiet", "--output", folder / name, *options]
        with open(folder / f"{name}.txt", "w") as told:
            subprocess.run(command, check=True, env=environment | variables, stdout=told, stderr=told)
        return crest(folder / name)

    def apart(name, one, other):
        print(f"{name}: crest apart by {abs(one - other).max() / abs(other).max():.1e} of its peak")

    told = subprocess.run([cofferdam, "points", scene, "--format", "json"], capture_output=True, check=True)
    points = json.loads(told.stdout)
    place = type("Points", (), {axis: np.array(points["points"][axis]) for axis in "xy"})
    mass = westergaard(place, points["depth"], points["density"])
    names = ["reservoir.fidelity=fmu"] + [
        f"reservoir.fmu.variables.interface_{ours}={theirs}" for ours, theirs in [("pressure", "p"), ("acceleration", "a")]
    ]

    (folder / "mass.json").write_text(json.dumps(mass.tolist()))
    (folder / "water.py").write_text(PYTHONFMU)
    build = [tools / "pythonfmu", "build", "-f", "water.py", "--handle-state", "mass.json"]
    subprocess.run(build, check=True, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    iterated = ["coupling.scheme=serial-implicit", "coupling.acceleration=iqn-ils", "coupling.tolerance=1e-10"]
    built_in = run("built-in", "reservoir.fidelity=westergaard", *iterated)
    library = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("LDLIBRARY")
    inside = {"LD_PRELOAD": str(library), "PYTHONHOME": sys.base_prefix}
    packages = sysconfig.get_path("purelib")
    file = f"reservoir.fmu.file={folder / 'Water.fmu'}"
    end = "reservoir.fmu.acceleration=end"
    apart("PythonFMU", run("pythonfmu", *names, file, end, *iterated, **inside, PYTHONPATH=packages), built_in)

    subprocess.run([tools / "unifmu", "generate", "python", folder / "unifmu"], check=True, stdout=subprocess.DEVNULL)
    (folder / "unifmu/modelDescription.xml").write_text(description(len(mass)))
    (folder / "unifmu/resources/model.py").write_text(UNIFMU % len(mass))
    launch = folder / "unifmu/resources/launch.toml"
    launch.write_text(launch.read_text().replace('backend = "grpc"', 'backend = "zmq"'))
    zipped(folder / "unifmu", folder / "unifmu.fmu")
    (folder / "dashpot.py").write_text(DASHPOT)
    once = "coupling.scheme=serial-explicit"
    argv = f'reservoir.command.argv=["{sys.executable}", "{folder / "dashpot.py"}"]'
    process = run("process", "reservoir.fidelity=command", argv, once)
    apart("UniFMU", run("unifmu-run", *names, f"reservoir.fmu.file={folder / 'unifmu.fmu'}", once), process)


if __name__ == "__main__":
    main(*[Path(argument).resolve() for argument in sys.argv[1:]])
