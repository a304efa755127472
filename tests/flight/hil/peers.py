"""The other end of a link with HIL messages, for tests: a simulator or an autopilot of pymavlink.
Limits in wall time only end what hangs."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

os.environ["MAVLINK20"] = "1"  # before pymavlink is imported

from pymavlink.dialects.v20 import common as mavlink

from stator import HOME

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

OUTDOOR = HOME / "graph" / "quad_outdoor.yaml"
COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator"]
HANGS_S = 600.0
ACCEL, GYRO, MAG, BARO = 0x7, 0x38, 0x1C0, 0x1A00  # of fields_updated
ARMED, LOCKSTEP = mavlink.MAV_MODE_FLAG_SAFETY_ARMED, 1


def free_port() -> int:
    """A port that nothing uses."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@dataclass
class Ended:
    """Of a command in the background, once its block has ended."""

    status: int = -1
    facts: dict[str, Any] = field(default_factory=dict)
    errors: str = ""


@contextlib.contextmanager
def command(*arguments: str) -> Iterator[Ended]:
    """A command with --json beside the block."""
    ended = Ended()
    pipe = subprocess.PIPE
    line = [*COMMAND, *arguments, "--json"]
    with subprocess.Popen(line, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield ended
            output, ended.errors = process.communicate(timeout=HANGS_S)
        finally:
            process.kill()
    ended.status = process.returncode
    ended.facts = json.loads(output) if output else {}


def flying(port: int, log: Path, *options: str) -> contextlib.AbstractContextManager[Ended]:
    """Our graph as the autopilot."""
    return command("fly", str(OUTDOOR), "--hil", f"tcp:{port}", "-o", str(log), *options)


class Peer:
    """One side of an open connection."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        connection.settimeout(HANGS_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.mavlink = mavlink.MAVLink(None, srcSystem=1, srcComponent=51)
        self.heard: list[Any] = []

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        self.connection.close()

    def packed(self, message: Any) -> bytes:
        return bytes(message.pack(self.mavlink))

    def send(self, *messages: Any) -> None:
        self.connection.sendall(b"".join(map(self.packed, messages)))

    def receive(self, kind: str) -> Any:
        """The next message of this kind; None: the other side closed the connection."""
        while True:
            while self.heard:
                message = self.heard.pop(0)
                if message.get_type() == kind:
                    return message
            try:
                data = self.connection.recv(4096)
            except ConnectionResetError:
                return None
            if not data:
                return None
            self.heard += self.mavlink.parse_buffer(data) or []


def serve(port: int) -> Peer:
    """As a simulator: listens, and waits for the autopilot."""
    with socket.create_server(("127.0.0.1", port)) as server:
        server.settimeout(HANGS_S)
        return Peer(server.accept()[0])


def connect(port: int) -> Peer:
    """As an autopilot: connects once the simulator listens."""
    end = time.monotonic() + HANGS_S
    while True:
        try:
            return Peer(socket.create_connection(("127.0.0.1", port)))
        except ConnectionRefusedError:
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def sensor(time_us: int, fields: int = ACCEL | GYRO | MAG | BARO, **other: float) -> Any:
    """HIL_SENSOR of a vehicle that rests level, with its nose to the north, near Zurich."""
    values: dict[str, float] = {
        "xacc": 0.0, "yacc": 0.0, "zacc": -9.80665, "xgyro": 0.0, "ygyro": 0.0, "zgyro": 0.0,
        "xmag": 0.216, "ymag": 0.0125, "zmag": 0.433, "abs_pressure": 956.0, "diff_pressure": 0.0,
        "pressure_alt": 488.0, "temperature": 20.0,
    }  # fmt: skip
    return mavlink.MAVLink_hil_sensor_message(
        time_usec=time_us, fields_updated=fields, **(values | other)
    )


def fix(time_us: int, north_m: float = 0.0) -> Any:
    """HIL_GPS of the same vehicle, or of one further north."""
    return mavlink.MAVLink_hil_gps_message(
        time_usec=time_us, fix_type=3, lat=473977420 + round(north_m * 90.0), lon=85455940,
        alt=488000, eph=120, epv=240, vel=0, vn=12, ve=-34, vd=56, cog=0, satellites_visible=11,
    )  # fmt: skip


def at_rest(
    peer: Peer, seconds: float, start_us: int = 0, send: Callable[[Any], None] | None = None
) -> list[Any]:
    """Simulates a vehicle that rests, at 250 Hz in lockstep; the answers. `send`: sends a frame."""
    write = send or peer.send
    answers = []
    for step in range(round(seconds * 250)):
        time_us = start_us + 4000 * step
        if step % 50 == 25:
            write(fix(time_us))
        write(sensor(time_us, ACCEL | GYRO | (MAG | BARO if step % 5 == 0 else 0)))
        answers.append(peer.receive("HIL_ACTUATOR_CONTROLS"))
    return answers
