"""A unit's service over iceoryx2, which is used only here."""

import ctypes

import iceoryx2 as iox2
import numpy as np

from .header import PROTOCOL_VERSION, Header


class Service:
    """The one server of a unit's service: `cofferdam/<run>/<unit>`, in the folder of the run."""

    def __init__(self, task, layout, values):
        """Makes the service; its answers have up to `values` values."""
        iox2.set_log_level(iox2.LogLevel.Fatal)
        config = iox2.config.default()
        config.global_cfg.root_path = iox2.Path.new(task["folder"])
        config.global_cfg.prefix = iox2.FileName.new(task["prefix"])
        builder = iox2.NodeBuilder.new().config(config).signal_handling_mode(iox2.SignalHandlingMode.Disabled)
        self._node = builder.create(iox2.ServiceType.Ipc)
        name = iox2.ServiceName.new(f"cofferdam/{task['run']:016x}/{task['unit']}")
        values_of = iox2.Slice[ctypes.c_double]
        attributes = iox2.AttributeSpecifier.new()
        for key, value in (("protocol", str(PROTOCOL_VERSION)), ("layout", layout)):
            attributes = attributes.define(iox2.AttributeKey.new(key), iox2.AttributeValue.new(value))
        self._factory = (
            self._node.service_builder(name)
            .request_response(values_of, values_of)
            .request_header(Header)
            .response_header(Header)
            .max_clients(1)
            .max_servers(1)
            .max_nodes(4)
            .create_with_attributes(attributes)
        )
        self._server = (
            self._factory.server_builder()
            .initial_max_slice_len(max(values, 1))
            .allocation_strategy(iox2.AllocationStrategy.PowerOfTwo)
            .create()
        )

    def receive(self):
        """The next request, if there is one."""
        return self._server.receive()


def header_of(message):
    """The header of a request or answer, which lies in shared memory."""
    return Header.from_address(message.user_header_ptr)


def values_of(message, count):
    """The `count` values of a request or answer, which lie in shared memory: valid as long as the message.

    **Errors**: it has another number of values.
    """
    values = message.payload()
    # iceoryx2 0.10.0 gives the number of bytes as length.
    if values.len() not in (count, 8 * count):
        raise ValueError(f"a request has {values.len() // 8} values, {count} are needed")
    return np.ndarray((count,), float, (ctypes.c_double * count).from_address(values.as_ptr()))
