"""A participant of preCICE as the reservoir of a run, and a unit in Python as a participant of preCICE.

`Water` is the first participant of a serial-implicit coupling scheme of preCICE. The orchestrator decides when an iteration has
converged, and preCICE follows: the datum `flag` is the only one with a convergence measure. It changes in each iteration, so that
preCICE repeats the time window. When the next step begins, the accepted acceleration is written once more with the same flag, and
the window ends. `participate` is the usual loop around a unit, here of the second participant.

Parameters of the unit: `configuration` (file of preCICE), `participant`, `mesh`, and the names of the data `acceleration`,
`pressure` and `flag`. See docs/guide/precice.md.
"""

import atexit
import copy

import numpy as np
import precice

import cofferdam


class Water(cofferdam.Reservoir):
    # The time window of preCICE is fixed.
    variable_communication_step = False

    def __init__(self, task):
        named = task.parameters
        self.mesh, self.acceleration, self.pressure, self.flag = (
            named.get(key, default)
            for key, default in (("mesh", "Face"), ("acceleration", "Acceleration"), ("pressure", "Pressure"), ("flag", "Flag"))
        )
        self.participant = precice.Participant(named.get("participant", "Cofferdam"), named["configuration"], 0, 1)
        places = np.column_stack([task.points.x, task.points.y])
        self.vertices = self.participant.set_mesh_vertices(self.mesh, places)
        self.participant.initialize()
        window = self.participant.get_max_time_step_size()
        if abs(window - task.communication_step) > 1e-9 * window:
            given = f"`time-window-size` is {window:g} s and `time.communication_step` {task.communication_step:g} s"
            raise ValueError(f"{given}; make them equal")
        self.window, self.toggle, self.tried = window, 0.0, None
        self.begin()
        atexit.register(self.close)

    def begin(self):
        if not self.participant.requires_writing_checkpoint():
            raise RuntimeError("preCICE does not iterate: choose `coupling-scheme:serial-implicit`")

    def exchange(self, acceleration):
        """One iteration of preCICE, which returns when the other participant has computed the window."""
        self.participant.write_data(self.mesh, self.acceleration, self.vertices, acceleration)
        self.participant.write_data(self.mesh, self.flag, self.vertices, np.full(len(acceleration), self.toggle))
        self.participant.advance(self.window)

    def step(self, time, communication_step, acceleration, ground_acceleration):
        self.toggle = 1.0 - self.toggle
        self.exchange(acceleration)
        if not self.participant.requires_reading_checkpoint():
            raise RuntimeError("preCICE has ended the iteration: give `flag` the only convergence measure, and raise `max-iterations`")
        self.tried = acceleration
        return self.participant.read_data(self.mesh, self.pressure, self.vertices, 0.0)

    def accept(self):
        """Ends the window of the last step: with the same flag as before preCICE finds it converged."""
        self.exchange(self.tried)
        self.tried = None
        if self.participant.requires_reading_checkpoint() or not self.participant.is_time_window_complete():
            raise RuntimeError("preCICE does not find `flag` converged")

    # The state belongs to the other participant, which returns to its checkpoint in each iteration.

    def save(self):
        if self.tried is not None:
            self.accept()
            self.begin()

    def restore(self, state):
        pass

    def close(self):
        if self.tried is not None:
            self.accept()
        self.participant.finalize()


def participate(unit, participant, mesh, places, data):
    """Makes a Reservoir in Python a participant of preCICE: reads `data[0]`, the acceleration, and writes `data[1]`, the pressure.

    A Dam differs in what `step` takes and returns; a built-in unit is an FMU in such a loop (examples/fmpy/coupled.py).
    """
    vertices = participant.set_mesh_vertices(mesh, places)
    participant.initialize()
    time, still = 0.0, np.zeros(2)
    while participant.is_coupling_ongoing():
        if participant.requires_writing_checkpoint():
            state = copy.deepcopy(unit.save())
        length = participant.get_max_time_step_size()
        # The value at the end of the window; the mean over it, if the other participant writes means.
        acceleration = participant.read_data(mesh, data[0], vertices, length)
        participant.write_data(mesh, data[1], vertices, unit.step(time, length, acceleration, still))
        participant.advance(length)
        if participant.requires_reading_checkpoint():
            unit.restore(copy.deepcopy(state))
        else:
            time += length
    participant.finalize()


if __name__ == "__main__":
    cofferdam.serve(Water)
