"""A bad link between a vehicle and a station: datagrams get lost, change, and come with garbage.
What happens to which one is drawn from a seed; when it happens is up to both ends."""

from __future__ import annotations

import contextlib
import random
import select
import socket
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tests.flight.mavlink.vehicle import in_background

if TYPE_CHECKING:
    import threading
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


@contextlib.contextmanager
def relay(vehicle_port: int, station_port: int, link: Link, seed: int = 1) -> Iterator[None]:
    """Passes on between the vehicle, which sends to `vehicle_port`, and the station."""
    draw = random.Random(seed)
    near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)  # to the vehicle
    far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    near.bind(("127.0.0.1", vehicle_port))
    far.bind(("127.0.0.1", 0))

    def run(ends: threading.Event) -> None:
        vehicle: tuple[str, int] | None = None
        while not ends.is_set():
            for ready in select.select([near, far], [], [], 0.1)[0]:
                with contextlib.suppress(ConnectionError):
                    data, source = ready.recvfrom(65536)
                    if ready is near:
                        vehicle = source
                    for part in _changed(data, link, draw, to_vehicle=ready is far):
                        if ready is near:
                            far.sendto(part, ("127.0.0.1", station_port))
                        elif vehicle is not None:
                            near.sendto(part, vehicle)

    with near, far, in_background(run):
        yield
