"""The two classes from which a subsolver derives."""


class _Unit:
    # Optional, both or none; without them no step can be repeated, and only explicit schemes can use the unit:
    #   save(self)            returns everything that later steps depend on
    #   restore(self, state)  returns to it, any number of times
    # What `save` returns is copied, so it may be arrays with which the unit continues to compute.
    save = None
    restore = None
    # Optional, both or none; with them a run can be continued, and a part of it replayed, without all steps before:
    #   serialise(self)           returns the same as bytes
    #   deserialise(self, state)  takes these bytes, perhaps in another process, in place of `start`
    # The bytes that come are those of a unit with the same task and source, undamaged.
    serialise = None
    deserialise = None

    variable_communication_step = True
    """Whether steps may differ in length; if not, the orchestrator refuses a scene that asks for it."""

    def __new__(cls, task, *_, **__):
        # So that a class of the user's own need not call this class's __init__ to have the task.
        unit = super().__new__(cls)
        unit.task = task
        return unit

    def __init__(self, task):
        """Makes the unit of a `cofferdam.Task`, which is `self.task` already."""

    @classmethod
    def can_save(cls):
        """Whether states can be saved and restored."""
        if (cls.save is None) != (cls.restore is None):
            raise TypeError(f"{cls.__name__} has one of `save` and `restore`; it needs both, or none of them")
        return cls.save is not None

    @classmethod
    def can_serialise(cls):
        """Whether states can be given and taken as bytes."""
        if (cls.serialise is None) != (cls.deserialise is None):
            raise TypeError(f"{cls.__name__} has one of `serialise` and `deserialise`; it needs both, or none of them")
        return cls.serialise is not None


class Reservoir(_Unit):
    """In place of the reservoir: takes the acceleration of the wet face and answers the pressure on it.

    After a restore, a step with the same inputs must give the same pressure, bit for bit.
    """

    role = "fluid"
    outputs = ("interface_pressure",)
    """What `start` and `step` return: this value, or a tuple, if there are several. Their names are those of
    modelDescription/reservoir.xml; `cofferdam.variables` lists which."""

    def start(self, time, acceleration, ground_acceleration):
        """The pressure at the start `time` (s), Pa; `None` is zero."""

    def step(self, time, communication_step, acceleration, ground_acceleration):
        """Steps from `time` by `communication_step` (s); returns the pressure at its end, Pa, positive in compression.

        `acceleration`: total acceleration of the points along n, m/s²; the mean over the step or the value at its end, as
        `task.acceleration` says. `ground_acceleration`: along x and y at the step's end, m/s².
        """
        raise NotImplementedError(f"{type(self).__name__} needs a method `step`")

    def hydrostatic_pressure(self):
        """The hydrostatic pressure at the points, ρ g (h − y), Pa."""
        return self.task.density * self.task.gravity * (self.task.depth - self.task.points.y)


class Dam(_Unit):
    """In place of the dam: takes the pressure on the wet face and answers its motion.

    After a restore, a step with the same inputs must give the same motion, bit for bit.
    """

    role = "structure"
    outputs = ("interface_displacement", "interface_velocity", "interface_acceleration")
    """What `start` and `step` return, as a tuple. The names are those of modelDescription/dam.xml; the velocity may be left
    out, and `cofferdam.variables` lists what may be added."""
    added_mass_included = False
    """Whether the mass of the dam contains that of the water, for `coupling.scheme = "added-mass"` and water without memory. The
    pressure is then only the rest of the water's pressure, which is 0 without memory."""

    def start(self, time, pressure, hydrostatic_pressure, ground_acceleration):
        """The motion at the start `time` (s); `None` is rest."""

    def step(self, time, communication_step, pressure, hydrostatic_pressure, ground_acceleration):
        """Steps from `time` by `communication_step` (s); returns the motion at its end.

        `pressure` (Pa, at the points) and `ground_acceleration` (m/s², along x and y) are those at the step's end and vary
        linearly over it. Displacement (m) and velocity (m/s) of the points are relative to the ground, along n; the
        acceleration (m/s²) is the total one, relative plus ground, along n, its mean over the step.
        """
        raise NotImplementedError(f"{type(self).__name__} needs a method `step`")
