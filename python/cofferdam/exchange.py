"""A unit of the user's own behind the commands of the protocol."""

import copy
import hashlib
import inspect
import json
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np

from . import header, variables
from .unit import _Unit

VERSION = "0.1.0"


class NotOffered(Exception):
    """A command that the unit need not know."""


class Exchange:
    """Makes a unit of the class `cls` and answers requests by it; `folder` is that of the run."""

    def __init__(self, cls, task, folder):
        if not (isinstance(cls, type) and issubclass(cls, _Unit)):
            raise TypeError(f"{cls!r} is neither a cofferdam.Reservoir nor a cofferdam.Dam")
        if cls.role != task.role:
            wrong = f"{cls.__name__} is a {cls.role}, but a {task.role} is asked for"
            raise TypeError(f"{wrong}: derive a structure from cofferdam.Dam, a fluid from cofferdam.Reservoir")
        self.task, self._points = task, len(task.points)
        self._inputs, self._outputs = variables.INPUTS[task.role], variables.outputs(cls)
        self._readable = variables.READABLE[task.role]
        self._can_save, self._in_bytes = cls.can_save(), cls.can_serialise()
        self._state_file = Path(folder) / f"{task.name}.state"
        self._answers = [(variable.name, variable.size(self._points)) for variable in self._outputs]
        ends = list(accumulate((variable.size(self._points) for variable in self._inputs), initial=0))
        self._inputs_size, self._ranges = ends[-1], [slice(*pair) for pair in pairwise(ends)]
        self._saved = None
        self._unit = cls(task)
        self.layout = variables.layout_hash(self._inputs, self._outputs, self._points)
        self.most_values = max(sum(size for _, size in self._answers), self._points)

    def description(self, brief):
        cls = type(self._unit)
        described = lambda of: [variable.described(self._points) for variable in of]
        return {
            "name": self.task.name,
            "solver": f"{cls.__name__} in Python, cofferdam {VERSION}",
            "fingerprint": list(_fingerprint(cls, self.task, brief)),
            "inputs": described(self._inputs),
            "outputs": described(self._outputs),
            "readable": described(self._readable),
            "capabilities": {
                "variable_communication_step": cls.variable_communication_step,
                "directional_derivative": False,
                "saved_state": self._can_save,
            },
        }

    def values_needed(self, request):
        """Number of values of the request with the header `request`.

        **Errors**: `NotOffered`, as a command that is not known may have any number.
        """
        self._check_known(request)
        given = (header.INITIALISE, header.STEP, header.SAVE_AND_STEP, header.RESTORE_AND_STEP)
        return self._inputs_size if request.command in given else 0

    def answer(self, request, values):
        """The values that answer a request with this header and these values.

        **Errors**: those of the unit; `NotOffered`.
        """
        if request.protocol_version != header.PROTOCOL_VERSION:
            raise ValueError(f"a request of version {request.protocol_version} of the protocol")
        if request.command == header.READ:
            return self._read(request.variable)
        if request.command in (header.SERIALISE, header.RESTORE_AND_SERIALISE, header.DESERIALISE):
            self._pass_state(request.command)
            return ()
        self._check_known(request)
        # A copy, because the unit may keep its inputs.
        values = values.copy()
        given = [values[range] for range in self._ranges]
        if request.command == header.INITIALISE:
            return self._checked("start", self._unit.start(request.time, *given))
        if request.command in (header.SAVE_AND_STEP, header.RESTORE_AND_STEP):
            self._return_or_save(request.command)
        return self._checked("step", self._unit.step(request.time, request.communication_step, *given))

    def _check_known(self, request):
        if request.command not in header.COMMANDS:
            raise NotOffered(f"{request.command} is no command that a unit in Python knows")

    def _return_or_save(self, command):
        if not self._can_save:
            raise NotImplementedError("it has neither `save` nor `restore`; write both, or use an explicit scheme")
        if command == header.SAVE_AND_STEP:
            self._saved = (copy.deepcopy(self._unit.save()),)
        elif self._saved is None:
            raise RuntimeError("no state has been saved")
        else:
            self._unit.restore(copy.deepcopy(self._saved[0]))

    def _pass_state(self, command):
        """Writes the state to the run's file for it, or takes it from there."""
        if not self._in_bytes:
            raise NotOffered("it has neither `serialise` nor `deserialise`")
        if command == header.DESERIALISE:
            self._unit.deserialise(self._state_file.read_bytes())
            return
        if command == header.RESTORE_AND_SERIALISE:
            self._return_or_save(header.RESTORE_AND_STEP)
        state = self._unit.serialise()
        if not isinstance(state, bytes):
            raise TypeError(f"`serialise` returned {_kind(state)}, bytes are needed")
        self._state_file.write_bytes(state)

    def _read(self, value_reference):
        name = next((v.name for v in self._readable if v.value_reference == value_reference), None)
        points = self.task.points
        if name is None:
            raise ValueError(f"no variable has the value reference {value_reference}")
        if name == "hydrostatic_pressure":
            return self._array("hydrostatic_pressure", name, self._points, self._unit.hydrostatic_pressure())
        if name == "added_mass_included":
            return np.array([float(self._unit.added_mass_included)])
        return {
            "interface_x": points.x,
            "interface_y": points.y,
            "interface_normal_x": points.normal_x,
            "interface_normal_y": points.normal_y,
            "interface_length": points.tributary_length,
        }[name]

    def _checked(self, method, answer):
        """What `method` returned, in one array."""
        if answer is None and method == "start":
            return np.zeros(sum(size for _, size in self._answers))
        if len(self._answers) == 1:
            return self._array(method, *self._answers[0], answer)
        if not isinstance(answer, tuple) or len(answer) != len(self._answers):
            names = ", ".join(name for name, _ in self._answers)
            raise TypeError(f"`{method}` returned {_kind(answer)}, a tuple of {names} is needed")
        parts = zip(self._answers, answer)
        return np.concatenate([self._array(method, *wanted, part) for wanted, part in parts])

    def _array(self, method, name, size, values):
        try:
            if values is None:
                raise TypeError
            array = np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            raise TypeError(f"`{method}` returned {_kind(values)} as {name}, {size} numbers are needed") from None
        if size == 1 and array.ndim == 0:
            return array.reshape(1)
        if array.shape != (size,):
            raise ValueError(f"`{method}` returned values of shape {array.shape} as {name}, ({size},) is needed")
        return array


def _kind(value):
    return "nothing" if value is None else f"a value of type {type(value).__name__}"


def _fingerprint(cls, task, brief):
    """Hash of everything that the unit is made from, as far as it is known: task, its table of the scene, class and its source."""
    try:
        source = Path(inspect.getsourcefile(cls)).read_bytes()
    except (OSError, TypeError):
        source = b""
    # `command` says where the program is; its parameters are in the brief.
    table = {key: value for key, value in task.scene.get(task.name, {}).items() if key != "command"}
    made_from = json.dumps([task.name, cls.__qualname__, VERSION, brief, table], sort_keys=True, default=str).encode()
    return hashlib.sha256(made_from + b"\0" + source).digest()
