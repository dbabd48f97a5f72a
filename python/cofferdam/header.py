"""The header of requests and answers: docs/reference/protocol.md."""

import ctypes

PROTOCOL_VERSION = 6

COMMANDS = range(1, 9)
READ, INITIALISE, STEP, SAVE_AND_STEP, RESTORE_AND_STEP, SERIALISE, RESTORE_AND_SERIALISE, DESERIALISE = COMMANDS
DONE, FAILED, NOT_OFFERED = range(3)

_TYPES = {ctypes.c_uint32: "u32", ctypes.c_uint64: "u64", ctypes.c_double: "f64"}


class Header(ctypes.Structure):
    _fields_ = [
        ("protocol_version", ctypes.c_uint32),
        ("command", ctypes.c_uint32),
        ("run", ctypes.c_uint64),
        ("step", ctypes.c_uint64),
        ("iteration", ctypes.c_uint32),
        ("attempt", ctypes.c_uint32),
        ("time", ctypes.c_double),
        ("communication_step", ctypes.c_double),
        ("variable", ctypes.c_uint32),
        ("status", ctypes.c_uint32),
        ("busy", ctypes.c_uint64),
        ("words", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name():
        """The name by which iceoryx2 compares the types of both sides."""
        return "cofferdam.Header"


FIELDS = [(name, _TYPES[kind], getattr(Header, name).offset) for name, kind in Header._fields_]
