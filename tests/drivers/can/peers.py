"""A CAN bus of the kernel, and what the package dronecan needs to sit on it."""

from __future__ import annotations

import contextlib
import select
import socket
import struct
import time
from typing import TYPE_CHECKING, Any

import dronecan
from dronecan.driver.common import AbstractDriver, CANFrame
from dronecan.transport import Transfer

if TYPE_CHECKING:
    from collections.abc import Callable

BUS = "vcan0"
PATIENCE_S = 300.0  # for what must happen some time
FRAME = struct.Struct("=IB3x8s")
FILTER = struct.Struct("=II")
BUS_OFF, RESTARTED = 0x40, 0x100  # of linux/can/error.h

Filter = tuple[int, int]  # identifier and mask


def raw_socket(interface: str = BUS, filters: list[Filter] | None = None) -> socket.socket:
    bus = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    if filters is not None:
        packed = b"".join(FILTER.pack(*row) for row in filters)
        bus.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, packed)
    bus.bind((interface,))
    bus.settimeout(PATIENCE_S)
    return bus


class NeverCame(AssertionError):
    """A frame that was waited for."""


def next_frame(
    bus: socket.socket, wanted: Callable[[int], bool], patience_s: float = PATIENCE_S
) -> tuple[int, bytes]:
    """The next extended frame of a wanted identifier."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        identifier, length, data = FRAME.unpack(bus.recv(16))
        if identifier & socket.CAN_EFF_FLAG and wanted(identifier & socket.CAN_EFF_MASK):
            return identifier & socket.CAN_EFF_MASK, data[:length]
    raise NeverCame


def send(bus: socket.socket, identifier: int, data: bytes) -> None:
    bus.send(FRAME.pack(identifier, len(data), data))


class Driver(AbstractDriver):  # type: ignore[misc]
    """The bus for the package dronecan, whose own driver python-can 4.6 does not bear. What finds
    no bus, as it is down or full, is lost."""

    def __init__(self, interface: str = BUS, filters: list[Filter] | None = None) -> None:
        super().__init__()
        self.bus = raw_socket(interface, filters)
        self.bus.setblocking(False)

    def close(self) -> None:
        self.bus.close()

    def send_frame(self, frame: Any) -> None:
        with contextlib.suppress(OSError):
            send(self.bus, frame.id | socket.CAN_EFF_FLAG, bytes(frame.data))

    def receive(self, timeout: float | None = None) -> Any:
        if timeout != 0:
            select.select([self.bus], [], [], timeout)
        try:
            identifier, length, data = FRAME.unpack(self.bus.recv(16))
        except OSError:  # nothing there, or no bus
            return None
        extended = bool(identifier & socket.CAN_EFF_FLAG)
        now = time.monotonic()
        return CANFrame(identifier & socket.CAN_EFF_MASK, data[:length], extended, now, time.time())


def frames_of(payload: Any, node: int, transfer_id: int, priority: int) -> list[tuple[int, bytes]]:
    transfer = Transfer(
        payload=payload,
        source_node_id=node,
        transfer_id=transfer_id,
        transfer_priority=priority,
    )
    return [
        (frame.message_id | socket.CAN_EFF_FLAG, bytes(frame.bytes))
        for frame in transfer.to_frames()
    ]


class Part:
    """A node of the bus that only sends."""

    def __init__(self, bus: socket.socket, node: int) -> None:
        self.bus = bus
        self.node = node
        self.ids: dict[int, int] = {}

    def send(self, payload: Any, priority: int = 16) -> None:
        kind = dronecan.get_dronecan_data_type(payload).default_dtid
        transfer_id = self.ids.get(kind, 0)
        self.ids[kind] = (transfer_id + 1) % 32
        for identifier, data in frames_of(payload, self.node, transfer_id, priority):
            send(self.bus, identifier, data)
