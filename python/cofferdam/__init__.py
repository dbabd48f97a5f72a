"""A subsolver of one's own takes the place of the reservoir or of the dam in a run of cofferdam.

    import cofferdam

    class MyWater(cofferdam.Reservoir):
        def __init__(self, task): ...
        def step(self, time, communication_step, acceleration, ground_acceleration): return pressure
        def save(self): return state
        def restore(self, state): ...

    cofferdam.serve(MyWater)

`open_run` and `open_ensemble` open what runs have written (pandas, xarray); `run_ensemble` runs an ensemble on a Dask cluster.

Conventions (docs/reference/conventions.md): SI units, per metre of dam; x downstream, y up, origin at the heel; n is the unit normal
from the water into the dam; pressure is the excess over hydrostatic, positive in compression; acceleration is total
(relative plus ground) along n.
"""

from .ensemble import EnsembleError, run_ensemble
from .face import Face, Mapping, westergaard
from .newmark import Newmark
from .process import serve
from .results import open_ensemble, open_run
from .section import Mesh, Section, rayleigh
from .stateless import StatelessDam
from .task import Points, Task
from .unit import Dam, Reservoir

__all__ = [
    "Dam",
    "EnsembleError",
    "Face",
    "Mapping",
    "Mesh",
    "Newmark",
    "Points",
    "Reservoir",
    "Section",
    "StatelessDam",
    "Task",
    "open_ensemble",
    "open_run",
    "rayleigh",
    "run_ensemble",
    "serve",
    "westergaard",
]
