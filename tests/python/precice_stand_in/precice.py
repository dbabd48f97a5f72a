"""A stand-in for pyprecice 3: two participants, threads of one process, in a serial-implicit scheme of one mesh.

It refuses what preCICE refuses: calls out of order, checkpoints that are not asked for, data of a wrong size. The configuration is a
JSON file: `first`, `second`, `window` and `max_time` (s), `flag` (the datum whose change must be below 1e-6), `max_iterations`,
and `program`, a Python file with `main(participant)` for the second participant.
"""

import json
import queue
import runpy
import threading

import numpy as np


class Error(Exception):
    pass


def need(condition, text):
    if not condition:
        raise Error(text)


class _Link:
    def __init__(self, configuration):
        self.to_first, self.to_second = queue.Queue(), queue.Queue()
        self.iterations = self.windows = 0
        self.configuration = configuration


_LINKS = {}


class Participant:
    def __init__(self, name, configuration, rank, size):
        told = json.loads(open(configuration).read())
        need(name in (told["first"], told["second"]), f"no participant {name}")
        self.first = name == told["first"]
        if self.first:
            _LINKS[configuration] = _Link(told)
        self.link, self.told, self.path = _LINKS[configuration], told, configuration
        self.state, self.time, self.values, self.received = "made", 0.0, {}, {}
        self.write_checkpoint = self.read_checkpoint = self.complete = False
        self.last_flag, self.iteration = None, 0

    def set_mesh_vertices(self, mesh, coordinates):
        need(self.state == "made" and np.ndim(coordinates) == 2, "vertices come before `initialize`, one row each")
        self.count = len(coordinates)
        return np.arange(self.count)

    def initialize(self):
        need(self.state == "made", "`initialize` is called once")
        self.state, self.write_checkpoint = "coupling", True
        if self.first:
            other = Participant(self.told["second"], self.path, 0, 1)
            main = runpy.run_path(self.told["program"])["main"]
            self.thread = threading.Thread(target=main, args=[other], daemon=True)
            self.thread.start()
        else:
            self.received = self.link.to_second.get()

    def get_max_time_step_size(self):
        return self.told["window"]

    def requires_writing_checkpoint(self):
        needed, self.write_checkpoint = self.write_checkpoint, False
        return needed

    def requires_reading_checkpoint(self):
        needed, self.read_checkpoint = self.read_checkpoint, False
        return needed

    def write_data(self, mesh, name, vertices, values):
        need(self.state == "coupling", "`write_data` comes after `initialize`")
        need(len(values) == len(vertices) == self.count and np.isfinite(values).all(), f"{name}: one number for each vertex")
        self.values[name] = np.array(values, float)

    def read_data(self, mesh, name, vertices, relative_read_time):
        need(0 <= relative_read_time <= self.told["window"], "no such time in the window")
        return self.received[name].copy()

    def advance(self, length):
        need(self.state == "coupling", "`advance` comes after `initialize`")
        need(not self.write_checkpoint, "a checkpoint must be written: `requires_writing_checkpoint` was not called")
        need(not self.read_checkpoint, "a checkpoint must be read: `requires_reading_checkpoint` was not called")
        need(length == self.told["window"], "the time step is not the time window")
        need(self.is_coupling_ongoing(), "the coupling has ended")
        (self._advance_first if self.first else self._advance_second)()

    def _advance_first(self):
        self.link.to_second.put(dict(self.values))
        self.received, converged = self.link.to_first.get(timeout=20)
        self._finish(converged)

    def _advance_second(self):
        flag = self.received[self.told["flag"]]
        self.iteration += 1
        self.link.iterations += 1
        same = self.last_flag is not None and np.abs(flag - self.last_flag).max() < 1e-6
        converged = same or self.iteration >= self.told["max_iterations"]
        self.last_flag = None if converged else flag
        if converged:
            self.iteration, self.link.windows = 0, self.link.windows + 1
        self.link.to_first.put((dict(self.values), converged))
        self._finish(converged)
        if self.is_coupling_ongoing():
            self.received = self.link.to_second.get()
            if self.received is None:
                self.state = "left"

    def _finish(self, converged):
        self.complete, self.read_checkpoint = converged, not converged
        if converged:
            self.time += self.told["window"]
            self.write_checkpoint = self.is_coupling_ongoing()

    def is_coupling_ongoing(self):
        return self.state == "coupling" and self.time < self.told["max_time"] - self.told["window"] / 2

    def is_time_window_complete(self):
        return self.complete

    def finalize(self):
        need(self.state != "finalized", "`finalize` is called once")
        if self.first:
            self.link.to_second.put(None)
            self.thread.join(5)
            if "report" in self.told:
                with open(self.told["report"], "w") as file:
                    json.dump({"iterations": self.link.iterations, "windows": self.link.windows}, file)
        self.state = "finalized"
