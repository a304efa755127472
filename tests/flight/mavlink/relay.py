"""A bad link between a vehicle and a station: datagrams get lost, change, and come with garbage.
What happens to which one is drawn from a seed."""

from __future__ import annotations

import contextlib
import random
import socket
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


@dataclass(frozen=True)
class Link:
    """Parts of all datagrams."""

    lost: float = 0.0  # both ways
    garbage: float = 0.0  # of both ways, which come in addition
    flipped: float = 0.0  # with one bit, towards the vehicle
    twice: float = 0.0  # both ways


def _changed(data: bytes, link: Link, draw: random.Random, *, to_vehicle: bool) -> list[bytes]:
    """What arrives of a datagram."""
    arriving = [] if draw.random() < link.lost else [data]
    if draw.random() < link.twice:
        arriving *= 2
    if to_vehicle and arriving and draw.random() < link.flipped:
        flipped = bytearray(data)
        flipped[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
        arriving[0] = bytes(flipped)
    if draw.random() < link.garbage:
        # A start of a frame that claims a length of 255 is the worst garbage.
        arriving.insert(0, b"\xfd\xff" + draw.randbytes(draw.randrange(1, 40)))
    return arriving


class Relay:
    """Passes on between the vehicle, which sends to `line`, and the station at a port."""

    def __init__(self, station_port: int, link: Link, seed: int = 1) -> None:
        self._draw = random.Random(seed)
        self._link = link
        self._near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)  # to the vehicle
        self._far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for end in (self._near, self._far):
            end.bind(("127.0.0.1", 0))
            end.setblocking(False)
        self._station = ("127.0.0.1", station_port)
        self._vehicle: tuple[str, int] | None = None

    def close(self) -> None:
        self._near.close()
        self._far.close()

    @property
    def line(self) -> str:
        return f"udp:{self._near.getsockname()[1]}"

    def pump(self) -> None:
        """All that has arrived."""
        for data, source in waiting(self._near):
            self._vehicle = source
            for part in _changed(data, self._link, self._draw, to_vehicle=False):
                self._far.sendto(part, self._station)
        for data, _ in waiting(self._far):
            for part in _changed(data, self._link, self._draw, to_vehicle=True):
                if self._vehicle is not None:
                    self._near.sendto(part, self._vehicle)


def waiting(end: socket.socket) -> Iterator[tuple[bytes, tuple[str, int]]]:
    """Datagrams that have arrived, and who sent them."""
    with contextlib.suppress(BlockingIOError):
        while True:
            yield end.recvfrom(65536)
