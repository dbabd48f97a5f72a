"""`cofferdam template`: what is written is an FMU, or a class, that computes what it says."""

import os
import re
import subprocess
import sys
import tomllib
from ctypes import CDLL
from pathlib import Path
from types import SimpleNamespace

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from fmus import RECORD, SCENES, STRONG_SECOND, Unit, names_of, outputs, pack, settings

HEADERS = Path(fmpy.__file__).parent / "c-code"
COFFERDAM = os.environ["COFFERDAM"]
# A face with a batter, and one with a crack and a kink.
BATTERED = ("rigid-dam-ramp", ["prescribed.batter=30", "prescribed.panels=7"])
CRACKED = ("koyna-coarse", ["dam.element_size=10", "dam.section.upstream=[[0,0],[2,20],[2,103]]"])
MEAN = ("#define ACCELERATION_IS_MEAN 0", "#define ACCELERATION_IS_MEAN 1")
NAMES = {"reservoir": "water", "dam": "dam"}
H = 0.0025


def write(folder, language, unit, scene=BATTERED, overrides=()):
    case, own = scene
    command = [COFFERDAM, "template", language, folder, "--scene", SCENES / case, "--unit", unit]
    subprocess.run([*command, *settings([*own, *overrides])], check=True, capture_output=True)
    return folder


def build(folder, *change):
    """Builds the FMU of a written folder, with a text of its source replaced by another."""
    (source,) = folder.glob("*.c")
    if change:
        before = source.read_text()
        assert change[0] in before
        source.write_text(before.replace(*change))
    subprocess.run([folder / "build.sh"], check=True, capture_output=True)
    return folder / f"{source.stem}.fmu"


@pytest.fixture(scope="session", params=[BATTERED, CRACKED], ids=["battered", "cracked"])
def scene(request):
    return request.param


@pytest.fixture(scope="session")
def fmus(scene, tmp_path_factory):
    """Both FMUs as they are written, by unit."""
    folder = tmp_path_factory.mktemp("own")
    return {unit: build(write(folder / unit, "c", unit, scene)) for unit in NAMES}


def added_mass(unit):
    """Westergaard's A, Pa per m/s²."""
    y, h, density = unit.get("interface_y"), unit.get("water_depth"), unit.get("water_density")
    return 7 / 8 * density * np.sqrt(h * (h - y))


def begun(path, **inputs):
    unit = Unit(path)
    unit.fmu.enterInitializationMode(startTime=0.0)
    for name, values in inputs.items():
        unit.set(name, values)
    unit.fmu.exitInitializationMode()
    return unit


def load(unit, n):
    """Inputs for the end of step `n` that vary in time and from point to point."""
    size = len(unit.get("interface_x"))
    wave = np.sin(0.3 * n + np.arange(size)) * (1 + n % 5)
    if "crest_displacement" in unit.references:
        unit.set("interface_pressure", 1e4 * wave)
    else:
        unit.set("interface_acceleration", wave)
    unit.set("ground_acceleration", [wave[0] - 0.2, 0.0])


def advance(unit, first, last):
    for n in range(first, last):
        load(unit, n)
        unit.fmu.doStep(n * H, H)


# The C


@pytest.mark.parametrize("unit", NAMES)
def test_every_function_is_that_of_the_headers(unit, scene, tmp_path):
    """FMI's own headers, included before, are what the compiler holds all definitions against; none is missing."""
    folder = write(tmp_path / "own", "c", unit, scene)
    source = f"{NAMES[unit]}.c"
    compiler = ["cc", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I", HEADERS, "-include", "fmi3Functions.h"]
    subprocess.run([*compiler, source], cwd=folder, check=True)
    declared = re.findall(r"FMI3_Export\s+fmi3\w+TYPE\s+(fmi3\w+);", (HEADERS / "fmi3Functions.h").read_text())
    assert len(declared) == 75
    build(folder)
    (library,) = folder.glob("fmu/binaries/*/*.so")
    exported = CDLL(str(library))
    assert all(hasattr(exported, name) for name in declared)
    own = set(re.findall(r"^EXPORT .*?\b(fmi3[A-Z]\w*)\(", (folder / source).read_text(), re.M))
    assert len(own) == 17 and own <= set(declared)


def test_a_wrong_argument_is_noticed_by_the_headers(tmp_path):
    folder = write(tmp_path / "own", "c", "reservoir")
    text = (folder / "fmi3.h").read_text()
    (folder / "fmi3.h").write_text(text.replace("fmi3Float64 time))", "fmi3Float32 time))", 1))
    compiler = ["cc", "-fsyntax-only", "-I", HEADERS, "-include", "fmi3Functions.h", "water.c"]
    assert subprocess.run(compiler, cwd=folder, capture_output=True).returncode != 0


@pytest.mark.parametrize("unit", NAMES)
def test_validate_is_clean_and_values_are_those_of_the_export(unit, fmus, scene, tmp_path):
    """References, units and terminal are those of the program's own FMU, and so are the points and the pressure at rest."""
    assert validate_fmu(fmus[unit]) == []
    own = begun(fmus[unit])
    if unit == "dam" and scene is BATTERED:
        return  # There is no dam to export.
    built_in = begun(pack(tmp_path, unit, scene[1], scene[0]))
    theirs = {v.name: v for v in built_in.description.modelVariables}
    shared = [v for v in own.description.modelVariables if v.name in theirs]
    assert len(shared) >= 12
    for variable in shared:
        other = theirs[variable.name]
        for attribute in ("valueReference", "causality", "variability", "unit", "shape"):
            # The template has real variables only; flags have no unit.
            if attribute != "unit" or variable.type == other.type:
                assert getattr(variable, attribute) == getattr(other, attribute), variable.name
    assert {v.name for v in own.description.modelVariables} - theirs.keys() <= {"mass", "stiffness"}
    names = ["interface_x", "interface_y", "interface_normal_x", "interface_normal_y", "interface_length"]
    for name in [*names, *(["hydrostatic_pressure", "water_depth"] if unit == "reservoir" else [])]:
        assert own.get(name).tobytes() == built_in.get(name).tobytes(), name

    def terminal(path):
        folder = fmpy.extract(path, unzipdir=tmp_path / f"{path.parent.name}-{unit}")
        text = (Path(folder) / "terminalsAndIcons" / "terminalsAndIcons.xml").read_text()
        return re.findall(r'memberName="(\w+)" variableName="(\w+)"', text)

    assert terminal(fmus[unit]) == terminal(tmp_path / f"{unit}.fmu") != []


@pytest.mark.parametrize("unit", NAMES)
def test_a_repeated_step_gives_the_same_bits(unit, fmus):
    one = begun(fmus[unit])
    advance(one, 0, 20)
    state = one.fmu.getFMUState()
    written = bytes(one.fmu.serializeFMUState(state))
    advance(one, 20, 30)
    first = outputs(one)
    for _ in range(2):
        one.fmu.setFMUState(state)
        advance(one, 20, 30)
        assert outputs(one) == first
    # In another instance, from bytes; and the whole again after a reset.
    other = begun(fmus[unit])
    other.fmu.setFMUState(other.fmu.deserializeFMUState(written))
    advance(other, 20, 30)
    assert outputs(other) == first
    other.fmu.reset()
    other.fmu.enterInitializationMode(startTime=0.0)
    other.fmu.exitInitializationMode()
    advance(other, 0, 30)
    assert outputs(other) == first
    one.fmu.freeFMUState(state)


def test_the_water_is_westergaards_under_a_ramp(fmus):
    """p = −A a at the end of each step: the acceleration grows by 1 m/s² within 0.1 s, into the water, and is held."""
    unit = begun(fmus["reservoir"])
    normal = unit.get("interface_normal_x")
    size, times = len(normal), H * np.arange(1, 81)
    ramp = -np.minimum(times / 0.1, 1.0)
    signals = np.zeros(81, [("time", float), ("interface_acceleration", float, size)])
    signals["time"] = np.append(times - H, times[-1])
    # FMPy sets inputs before a step, and the unit takes them for its end.
    signals["interface_acceleration"][:-1] = ramp[:, None] * normal
    signals["interface_acceleration"][-1] = signals["interface_acceleration"][-2]
    arguments = {"output_interval": H, "stop_time": times[-1], "output": ["interface_pressure"]}
    result = simulate_fmu(fmus["reservoir"], input=signals, **arguments)
    pressure = result["interface_pressure"][1:]
    wanted = -added_mass(unit) * ramp[:, None] * normal
    np.testing.assert_allclose(pressure, wanted, rtol=1e-12, atol=1e-9)
    assert (pressure[:, 0] > 0).all()


def test_means_are_taken_to_the_end_of_the_step(tmp_path):
    """The other meaning of the input: exact for an acceleration that grows evenly, with steps of any length."""
    unit = begun(build(write(tmp_path / "own", "c", "reservoir"), *MEAN))
    mass, size, time = added_mass(unit), len(unit.get("interface_x")), 0.0
    for length in (0.01, 0.01, 0.025, 0.0025):
        unit.set("interface_acceleration", np.full(size, 2.0 + 3.0 * (time + length / 2)))
        unit.fmu.doStep(time, length)
        time += length
        if time > 0.011:
            np.testing.assert_allclose(unit.get("interface_pressure"), -mass * (2.0 + 3.0 * time), rtol=1e-12)


def test_parameters_are_set_before_the_first_step(fmus):
    unit = Unit(fmus["reservoir"])
    unit.set("water_density", 800.0)
    unit.fmu.enterInitializationMode(startTime=0.0)
    unit.set("gravity", 10.0)
    wanted = 8000.0 * (unit.get("water_depth") - unit.get("interface_y"))
    np.testing.assert_allclose(unit.get("hydrostatic_pressure"), wanted)
    unit.fmu.exitInitializationMode()
    np.testing.assert_allclose(unit.get("hydrostatic_pressure"), wanted)
    with pytest.raises(FMICallException):
        unit.set("gravity", 9.0)


def sway(unit, mass, time):
    """Displacement of an oscillator of this mass that starts at rest when the ground begins to accelerate by 1 m/s²."""
    k, m = unit.get("stiffness"), unit.get("mass")
    omega = np.sqrt(k / mass)
    ratio = unit.get("damping_ratio") * np.sqrt(k * m) / np.sqrt(k * mass)
    damped = omega * np.sqrt(1 - ratio**2)
    decay = np.exp(-ratio * omega * time) * (np.cos(damped * time) + ratio * omega / damped * np.sin(damped * time))
    return -(1 - decay) / omega**2


def coupled(fmus, steps, length):
    """The sway of both units, each step repeated until they agree: the largest error against the closed form."""
    dam, water = (begun(fmus[unit], ground_acceleration=[1.0, 0.0]) for unit in ("dam", "reservoir"))
    weight = dam.get("interface_length") * dam.get("interface_normal_x")
    moved = (added_mass(water) * weight * dam.get("interface_normal_x")).sum()
    mass = dam.get("mass")[0] + moved
    relaxation, repeated, error, largest = dam.get("mass")[0] / mass, 0, 0.0, 0.0
    guess = np.zeros(len(weight))
    for n in range(steps):
        saved = [unit.fmu.getFMUState() for unit in (dam, water)]
        for _ in range(20):
            dam.set("interface_pressure", guess)
            dam.fmu.doStep(n * length, length)
            water.set("interface_acceleration", dam.get("interface_acceleration_end"))
            water.fmu.doStep(n * length, length)
            residual = water.get("interface_pressure") - guess
            if np.abs(residual).max() < 1e-8 * np.abs(guess).max() + 1e-9:
                break
            guess = guess + relaxation * residual
            repeated += 1
            for unit, state in zip((dam, water), saved):
                unit.fmu.setFMUState(state)
        else:
            raise AssertionError(f"step {n} did not converge")
        for unit, state in zip((dam, water), saved):
            unit.fmu.freeFMUState(state)
        exact = sway(dam, mass, (n + 1) * length)[0]
        error, largest = max(error, abs(dam.get("crest_displacement")[0] - exact)), max(largest, abs(exact))
    assert repeated > steps
    return error / largest


def test_dam_and_water_together_are_an_oscillator_with_added_mass(fmus):
    """Coupled, every step repeated from saved states, they converge at second order to the closed form of m + m_w."""
    errors = [coupled(fmus, steps, 0.4 / steps) for steps in (50, 100)]
    print(f"error of the coupled sway {errors[0]:.1e}, {errors[1]:.1e} with half the step")
    # Newmark's period is too long by (ωH)²/12 of it, which shifts the phase by ωt (ωH)²/12, here by up to 1e-2.
    assert errors[1] < 3e-3 and 3.6 < errors[0] / errors[1] < 4.4


def test_the_dam_is_an_oscillator(fmus):
    """Mean accelerations are those of the velocities; the static sway is the hydrostatic force over the stiffness."""
    dam = Unit(fmus["dam"])
    still = 9810.0 * (dam.get("interface_y")[-1] - dam.get("interface_y"))
    dam = begun(fmus["dam"], hydrostatic_pressure=still, ground_acceleration=[1.0, 0.0])
    normal, weight = dam.get("interface_normal_x"), dam.get("interface_length") * dam.get("interface_normal_x")
    np.testing.assert_allclose(dam.get("crest_static_displacement"), [still @ weight / dam.get("stiffness")[0], 0.0])
    velocity = dam.get("interface_velocity")
    for n in range(40):
        dam.fmu.doStep(n * H, H)
        mean = (dam.get("interface_velocity") - velocity) / H + normal
        np.testing.assert_allclose(dam.get("interface_acceleration"), mean, rtol=0, atol=1e-11)
        velocity = dam.get("interface_velocity")
    exact = sway(dam, dam.get("mass")[0], 40 * H)
    np.testing.assert_allclose(dam.get("interface_displacement"), exact * normal, rtol=2e-3)


def test_refused_calls_say_why(fmus, tmp_path):
    said = []
    unit = Unit(fmus["reservoir"], logger=lambda _, status, category, text: said.append((status, text.decode())))
    size = len(unit.get("interface_x"))

    def refused(word, call):
        before = len(said)
        with pytest.raises(FMICallException):
            call()
        assert len(said) == before + 1 and said[-1][0] == 3 and word in said[-1][1], said[before:]

    refused("initialise the instance first", lambda: unit.fmu.doStep(0.0, H))
    unit.fmu.enterInitializationMode(startTime=0.0)
    unit.fmu.exitInitializationMode()
    refused("a step from 0.5 s, but the unit stands at 0 s", lambda: unit.fmu.doStep(0.5, H))
    refused("length must be above 0", lambda: unit.fmu.doStep(0.0, -H))
    refused("value 1 is not finite", lambda: unit.set("interface_acceleration", [0.0, np.nan] + [0.0] * (size - 2)))
    refused("only inputs can be set", lambda: unit.set("interface_x", np.zeros(size)))
    refused("the variables have", lambda: unit.fmu.setFloat64([1], [0.0] * (size - 1)))
    refused("the variables have", lambda: unit.fmu.getFloat64([1], size + 1))
    refused("no variable has value reference 999", lambda: unit.fmu.getFloat64([999], 1))
    refused("of type Float64", lambda: unit.fmu.getInt32([1], 1))
    refused("does not offer it", lambda: unit.fmu.enterEventMode())
    other = begun(build(write(tmp_path / "own", "c", "reservoir", BATTERED, ["reservoir.depth=179"])))
    foreign = bytes(other.fmu.serializeFMUState(other.fmu.getFMUState()))
    refused("no state of this unit", lambda: unit.fmu.deserializeFMUState(foreign))
    unit.fmu.doStep(0.0, H)


def test_the_dam_takes_part_in_the_examples(tmp_path):
    """The written dam before the program's own water, by the example of the whole coupling."""
    overrides = [*STRONG_SECOND, "dam.element_size=10", "coupling.acceleration=aitken"]
    case = ("koyna-coarse", overrides)
    dam = build(write(tmp_path / "own", "c", "dam", case))
    water = pack(tmp_path, "reservoir", [*overrides, "reservoir.element_size=20"])
    example = SCENES.parent / "examples" / "fmpy" / "fixed_point.py"
    done = subprocess.run([sys.executable, "-B", example, dam, water, RECORD], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    low, high = map(float, re.search(r"crest (\S+) to (\S+) mm", done.stdout).groups())
    # A third of a g at a period of some 0.3 s: centimetres, to both sides.
    assert -100 < low < -1 and 1 < high < 100


# The Python


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A stand-in for the package, of which the classes use only the names of their base classes."""
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "cofferdam.py").write_text("class Reservoir: pass\nclass Dam: pass\ndef serve(unit): pass\n")
    monkeypatch.syspath_prepend(folder)
    return folder


def made(folder, unit, points, meaning):
    """The class of a written folder, and an instance for the face of an FMU."""
    name = NAMES[unit]
    source = {"__name__": name}
    exec(compile((folder / f"{name}.py").read_text(), name, "exec"), source)
    get = points.get
    face = SimpleNamespace(
        x=get("interface_x"),
        y=get("interface_y"),
        normal_x=get("interface_normal_x"),
        normal_y=get("interface_normal_y"),
        tributary_length=get("interface_length"),
    )
    water = {"depth": face.y[-1], "density": 1000.0, "gravity": 9.81, "communication_step": H}
    task = SimpleNamespace(points=face, acceleration=meaning, parameters={}, **water)
    return source[name.capitalize()](task)


@pytest.mark.parametrize("meaning", ["end", "mean"])
def test_water_in_python_is_that_in_c(meaning, scene, package, tmp_path):
    fmu = begun(build(write(tmp_path / "c", "c", "reservoir", scene), *(MEAN if meaning == "mean" else ())))
    water = made(write(tmp_path / "python", "python", "reservoir", scene), "reservoir", fmu, meaning)
    for n in range(20):
        load(fmu, n)
        fmu.fmu.doStep(n * H, H)
        before, wanted = water.save(), fmu.get("interface_pressure")
        arguments = (n * H, H, fmu.get("interface_acceleration"), np.zeros(2))
        first = water.step(*arguments)
        np.testing.assert_allclose(first, wanted, rtol=1e-12, atol=1e-9)
        for _ in range(2):
            water.restore(before)
            assert water.step(*arguments).tobytes() == first.tobytes()


def test_dam_in_python_is_that_in_c(scene, package, tmp_path):
    fmu = begun(build(write(tmp_path / "c", "c", "dam", scene)))
    dam = made(write(tmp_path / "python", "python", "dam", scene), "dam", fmu, "mean")
    for n in range(20):
        load(fmu, n)
        fmu.fmu.doStep(n * H, H)
        before = dam.save()
        arguments = (n * H, H, fmu.get("interface_pressure"), None, fmu.get("ground_acceleration"))
        first = dam.step(*arguments)
        for name, values in zip(("displacement", "velocity", "acceleration"), first):
            wanted = fmu.get(f"interface_{name}")
            np.testing.assert_allclose(values, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())
        for _ in range(2):
            dam.restore(before)
            assert np.array(dam.step(*arguments)).tobytes() == np.array(first).tobytes()


# The READMEs


@pytest.mark.parametrize("unit", NAMES)
@pytest.mark.parametrize("language", ["c", "python"])
def test_what_the_readme_says_works(unit, language, package, tmp_path):
    """Its commands and its Python are run as they are; `SCENE` stands for the author's."""
    folder = write(tmp_path / "own", language, unit)
    text = (folder / "README.md").read_text()
    for name in re.findall(r"^\| `([^`]+)` \|", text, re.M):
        assert (folder / name).exists(), name
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "cofferdam").symlink_to(COFFERDAM)
    (programs / "python3").symlink_to(sys.executable)
    site = os.pathsep.join([str(package), str(Path(np.__file__).parents[1])])
    environment = {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": site}
    for block in re.findall(r"^```\n(.*?)^```", text, re.M | re.S):
        subprocess.run(["sh", "-e"], input=block, text=True, cwd=folder, env=environment, check=True, capture_output=True)
    (program,) = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    program = program.replace("SCENE", str(SCENES / "rigid-dam-ramp"))
    command = [sys.executable, "-B", "-c", program]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    values = [float(word) for word in re.findall(r"-?\d[\d.e+-]*", done.stdout)]
    if unit == "reservoir":
        # 7/8 ρ h at the heel, none at the surface.
        assert abs(values[0] - 7 / 8 * 1000 * 180) < 1 and values[-1] == 0 and min(values) == 0
    else:
        assert min(values) < 0
    # The scene's table is TOML, and names what is there.
    (table,) = re.findall(r"^```toml\n(.*?)^```", text, re.M | re.S)
    table = tomllib.loads(table)[unit]
    word = "fmu" if language == "c" else "command"
    assert table["fidelity"] == word and table[word]["acceleration"] in ("end", "mean")
    named = table["fmu"]["file"] if language == "c" else table["command"]["argv"][-1]
    assert (folder / named).exists(), named
