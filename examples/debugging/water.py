"""Westergaard's added mass with a fault that docs/guide/debugging.md finds. Do not copy it; ../python/westergaard.py is right."""

from collections import deque

import cofferdam


class Water(cofferdam.Reservoir):
    def __init__(self, task):
        self.added_mass = cofferdam.westergaard(task.points, task.depth, task.density)
        # Mean accelerations of the last steps, m/s².
        self.past = deque([0 * task.points.y], maxlen=400)

    def step(self, time, communication_step, acceleration, ground_acceleration):
        at_end = 1.5 * acceleration - 0.5 * self.past[-1]
        self.past.append(acceleration)
        return -self.added_mass @ at_end

    def save(self):
        return len(self.past)

    def restore(self, state):
        while len(self.past) > state:
            self.past.pop()


if __name__ == "__main__":
    cofferdam.serve(Water)
