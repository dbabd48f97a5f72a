"""A dam of one degree of freedom in the place of the dam: it moves as a rigid body along x, on a spring and a damper.

m ü + 2 ζ ω m u̇ + ω² m u = F − m a_g, with the displacement u relative to the ground, the ground's acceleration a_g, and the
force F of the water. Pressure and ground acceleration are linear in time within a communication step, and for such a load
the equation is solved exactly, whatever the step's length.

Parameters, each per metre of dam: `mass`, kg/m; `frequency` ω, rad/s; `damping_ratio` ζ, between 0 and 1, 0.05 by default.
"""

from math import cos, exp, sin, sqrt

import cofferdam


class OscillatorDam(cofferdam.Dam):
    def __init__(self, task):
        parameters = task.parameters
        self.mass, self.frequency = float(parameters["mass"]), float(parameters["frequency"])
        self.damping_ratio = float(parameters.get("damping_ratio", 0.05))
        self.normal_x, self.normal_y = task.points.normal_x, task.points.normal_y
        # The traction of the water is p n.
        self.force_of_pressure = task.points.tributary_length * self.normal_x
        self.displacement, self.velocity = 0.0, 0.0

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        self.accept(pressure, ground_acceleration)

    def accept(self, pressure, ground_acceleration):
        """Keeps the load (m/s²) and the ground acceleration at the step's end for the next step."""
        force = float(self.force_of_pressure @ pressure)
        self.load, self.ground = force / self.mass - ground_acceleration[0], ground_acceleration

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        h, w, z = communication_step, self.frequency, self.damping_ratio
        load_before, ground_before, velocity_before = self.load, self.ground, self.velocity
        self.accept(pressure, ground_acceleration)
        rate = (self.load - load_before) / h
        # Particular solution, constant plus linear, and free vibration that starts at the difference.
        constant, velocity = load_before / w**2 - 2 * z * rate / w**3, rate / w**2
        damped, decay = w * sqrt(1 - z**2), exp(-z * w * h)
        a = self.displacement - constant
        b = (self.velocity - velocity + z * w * a) / damped
        c, s = decay * cos(damped * h), decay * sin(damped * h)
        self.displacement = constant + velocity * h + a * c + b * s
        self.velocity = velocity + (b * damped - z * w * a) * c - (a * damped + z * w * b) * s
        # Total acceleration along n, its mean over the step.
        mean_ground = 0.5 * (ground_before + ground_acceleration)
        mean = (self.velocity - velocity_before) / h + mean_ground[0]
        acceleration = mean * self.normal_x + mean_ground[1] * self.normal_y
        return self.displacement * self.normal_x, self.velocity * self.normal_x, acceleration

    def save(self):
        return self.displacement, self.velocity, self.load, self.ground

    def restore(self, state):
        self.displacement, self.velocity, self.load, self.ground = state


if __name__ == "__main__":
    cofferdam.serve(OscillatorDam)
