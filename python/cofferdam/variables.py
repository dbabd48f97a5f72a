"""The variables that units exchange: names, value references, units and shapes of modelDescription/."""

import hashlib
from dataclasses import dataclass

from .header import FIELDS


@dataclass(frozen=True)
class Variable:
    name: str
    value_reference: int
    unit: str
    shape: str
    """`wet-face`: one value a point; `plane`: along x and y; `scalar`."""

    def size(self, points):
        return {"wet-face": points, "plane": 2, "scalar": 1}[self.shape]

    def described(self, points):
        return {
            "name": self.name,
            "value_reference": self.value_reference,
            "unit": self.unit,
            "size": self.size(points),
            "shape": self.shape,
        }


# What a unit is given, in the order of the arguments of `start` and `step`.
INPUTS = {
    "fluid": [
        Variable("interface_acceleration", 1, "m/s2", "wet-face"),
        Variable("ground_acceleration", 2, "m/s2", "plane"),
    ],
    "structure": [
        Variable("interface_pressure", 1, "Pa", "wet-face"),
        Variable("hydrostatic_pressure", 2, "Pa", "wet-face"),
        Variable("ground_acceleration", 3, "m/s2", "plane"),
    ],
}

# What a unit may answer.
OUTPUTS = {
    "fluid": [
        Variable("interface_pressure", 10, "Pa", "wet-face"),
        Variable("total_force", 12, "N/m", "scalar"),
        Variable("overturning_moment", 13, "N.m/m", "scalar"),
        Variable("base_pressure", 14, "Pa", "scalar"),
    ],
    "structure": [
        Variable("interface_displacement", 10, "m", "wet-face"),
        Variable("interface_velocity", 11, "m/s", "wet-face"),
        Variable("interface_acceleration", 12, "m/s2", "wet-face"),
        Variable("interface_acceleration_end", 16, "m/s2", "wet-face"),
        Variable("crest_displacement", 13, "m", "plane"),
        Variable("crest_acceleration", 14, "m/s2", "plane"),
        Variable("base_shear", 37, "N/m", "scalar"),
        Variable("base_normal_force", 38, "N/m", "scalar"),
    ],
}

# What is read once, after initialisation.
READABLE = {
    "fluid": [
        Variable("hydrostatic_pressure", 11, "Pa", "wet-face"),
        Variable("interface_x", 20, "m", "wet-face"),
        Variable("interface_y", 21, "m", "wet-face"),
        Variable("interface_normal_x", 22, "1", "wet-face"),
        Variable("interface_normal_y", 23, "1", "wet-face"),
        Variable("interface_length", 24, "m", "wet-face"),
    ],
    "structure": [
        Variable("interface_x", 40, "m", "wet-face"),
        Variable("interface_y", 41, "m", "wet-face"),
        Variable("interface_normal_x", 42, "1", "wet-face"),
        Variable("interface_normal_y", 43, "1", "wet-face"),
        Variable("interface_length", 44, "m", "wet-face"),
        Variable("added_mass_included", 61, "1", "scalar"),
    ],
}

_NEEDED = {
    "fluid": {"interface_pressure"},
    "structure": {"interface_displacement", "interface_acceleration"},
}


def outputs(unit):
    """The variables that the class `unit` answers."""
    known = {variable.name: variable for variable in OUTPUTS[unit.role]}
    unknown = [name for name in unit.outputs if name not in known]
    if unknown:
        raise ValueError(f"`outputs` of {unit.__name__} names {', '.join(unknown)}; possible are {', '.join(known)}")
    missing = _NEEDED[unit.role] - set(unit.outputs)
    if missing or len(set(unit.outputs)) < len(unit.outputs):
        wrong = f"lacks {', '.join(sorted(missing))}" if missing else "names a variable twice"
        raise ValueError(f"`outputs` of {unit.__name__} {wrong}")
    return [known[name] for name in unit.outputs]


def layout_hash(inputs, outputs, points):
    """Hash of how requests and answers are laid out; the orchestrator computes the same from the description."""
    lines = [f"header {name} {kind} {offset}" for name, kind, offset in FIELDS]
    for what, variables in (("input", inputs), ("output", outputs)):
        lines += [f"{what} {v.name} {v.value_reference} {v.size(points)}" for v in variables]
    return hashlib.sha256("".join(line + "\n" for line in lines).encode()).hexdigest()
