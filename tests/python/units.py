"""Units for the tests of the shared-memory protocol; the argument names the class."""

import logging
import os
import sys
import time
import warnings

import cofferdam
import numpy as np


class Echo(cofferdam.Reservoir):
    """Answers what it is given."""

    def step(self, time, communication_step, acceleration, ground_acceleration):
        return acceleration


class EchoDam(cofferdam.Dam):
    """Answers the pressure as displacement, the hydrostatic pressure as velocity, the ground as acceleration."""

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        return pressure, hydrostatic_pressure, np.resize(ground_acceleration, len(pressure))


class Sum(cofferdam.Reservoir):
    """Answers the sum of all it was given, in an array that it continues to change."""

    def __init__(self, task):
        self.sum, self.steps = np.zeros(len(task.points)), 0

    def step(self, time, communication_step, acceleration, ground_acceleration):
        self.sum += communication_step * acceleration
        self.steps += 1
        return self.sum

    def save(self):
        return self.sum, {"steps": self.steps}

    def restore(self, state):
        self.sum, self.steps = state[0], state[1]["steps"]

    def serialise(self):
        return np.append(self.sum, self.steps).tobytes()

    def deserialise(self, state):
        *values, self.steps = np.frombuffer(state)
        self.sum = np.array(values)


class Sampled(cofferdam.Reservoir):
    """Westergaard's added mass, sampled at the points, so that a twin in another language can give the same bits."""

    def __init__(self, task):
        self.added_mass = 7 / 8 * task.density * np.sqrt(task.depth * (task.depth - task.points.y))
        self.means = task.acceleration == "mean"
        self.before = np.zeros(len(task.points)), 0.0

    def step(self, time, communication_step, acceleration, ground_acceleration):
        at_end = acceleration
        if self.means:
            mean_before, length_before = self.before
            share = communication_step / (communication_step + (length_before or communication_step))
            at_end = acceleration + (acceleration - mean_before) * share
            self.before = acceleration, communication_step
        return -self.added_mass * at_end

    def save(self):
        return self.before

    def restore(self, state):
        self.before = state


class Faulty(Echo):
    """Does what the second argument says: from the first step on, or when it is made."""

    def __init__(self, task):
        if sys.argv[2] == "cannot be made":
            raise ValueError(f"{task.parameters['colour']} is no colour")
        if sys.argv[2] == "exits early":
            sys.exit(7)

    def step(self, time, communication_step, acceleration, ground_acceleration):
        return FAULTS[sys.argv[2]](acceleration)

    def save(self):
        pass

    def restore(self, state):
        pass


def infinite(values):
    values[2] = np.inf
    return values


def hang(values):
    time.sleep(60)


def spin(values):
    while True:
        pass


def say(values):
    print("two lines\nof text")
    print("no end of line", end="")
    print('{"failed":{"text":"printed"}}')
    os.system("echo printed by a program")
    logging.getLogger("mine").info("logged")
    logging.getLogger("mine").debug("not logged")
    print("no Unicode: \udcff")
    warnings.warn("take care")
    return values


FAULTS = {
    "divides": lambda values: 1 / 0,
    "exits": lambda values: sys.exit(7),
    "aborts": lambda values: os.abort(),
    "nothing": lambda values: None,
    "a word": lambda values: "pressure",
    "short": lambda values: values[1:],
    "infinite": infinite,
    "hangs": hang,
    "spins": spin,
    "says": say,
}

print("a line before it serves")
print("and the beginning of one", end="")
cofferdam.serve(globals()[sys.argv[1]])
