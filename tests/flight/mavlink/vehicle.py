"""A simulated vehicle with MAVLink, and a ground station of pymavlink, for tests. All times of the
vehicle are of its own clock, from its messages and its log; limits in wall time only end what
hangs."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

os.environ["MAVLINK20"] = "1"  # before pymavlink is imported

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from stator import HOME

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

OUTDOOR = HOME / "graph" / "quad_outdoor.yaml"
COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator"]
HANGS_S = 120.0  # of wall time
BUILDS_S = 10.0 * HANGS_S  # a vehicle that is not built yet
NAN = math.nan


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    """A port that nothing uses."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@contextlib.contextmanager
def flying(log: Path, *options: str, how: str = "fly") -> Iterator[dict[str, Any]]:
    """A flight in the background, which ends with the block. Then the result has its facts.
    `how`: the command."""
    result: dict[str, Any] = {}
    command = [*COMMAND, how, str(OUTDOOR), *options, "-o", str(log), "--json"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield result
        finally:
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=HANGS_S)
    assert output, errors
    result |= json.loads(output)


@contextlib.contextmanager
def in_background(work: Callable[[threading.Event], None]) -> Iterator[None]:
    """Runs a function beside the block. It returns once its event is set, at the block's end."""
    ends = threading.Event()
    thread = threading.Thread(target=work, args=(ends,))
    thread.start()
    try:
        yield
    finally:
        ends.set()
        thread.join()


def wait_until_it_talks(port: int) -> None:
    """A vehicle that is not built yet takes its time, which no client waits for."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", port))
        probe.settimeout(BUILDS_S)
        probe.recv(1)


# Frame, command, four parameters, x, y, z.
Item = tuple[int, int, float, float, float, float, int, int, float]


class Station:
    """A ground station."""

    def __init__(self, url: str, system: int = 250) -> None:
        self.link = mavutil.mavlink_connection(
            url,
            source_system=system,
            source_component=190,
            dialect="common",
            retries=int(HANGS_S),  # one a second, until the vehicle listens
        )
        self.system = system
        self.home: Any = None

    def close(self) -> None:
        self.link.close()

    def wait(
        self,
        kind: str | list[str],
        wanted: Callable[[Any], bool] = lambda _: True,
        limit_s: float = HANGS_S,
    ) -> Any:
        until = time.monotonic() + limit_s
        while time.monotonic() < until:
            message = self.link.recv_match(type=kind, blocking=True, timeout=0.2)
            if message is not None and wanted(message):
                return message
        raise AssertionError(f"no {kind} that is wanted")

    def connect(self) -> Any:
        beat = self.wait("HEARTBEAT", limit_s=BUILDS_S)
        self.link.target_system = beat.get_srcSystem()
        return beat

    def command(self, number: int, *params: float) -> int:
        """The result."""
        p = [*params, *[0.0] * (7 - len(params))]
        self.link.mav.command_long_send(1, 1, number, 0, *p)
        ack = self.wait("COMMAND_ACK", lambda a: a.command == number)
        assert (ack.target_system, ack.target_component) == (self.system, 190)
        result: int = ack.result
        return result

    def accept(self, number: int, *params: float) -> None:
        assert self.command(number, *params) == mavlink.MAV_RESULT_ACCEPTED

    def wait_until_armable(self) -> None:
        bit = mavlink.MAV_SYS_STATUS_PREARM_CHECK
        self.wait("SYS_STATUS", lambda s: s.onboard_control_sensors_health & bit)
        self.home = self.wait("HOME_POSITION")

    def wait_mode(self, *names: str) -> Any:
        return self.wait("HEARTBEAT", lambda h: mavutil.mode_string_v10(h) in names)

    def wait_armed(self, is_armed: bool) -> Any:
        bit = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
        return self.wait("HEARTBEAT", lambda h: bool(h.base_mode & bit) == is_armed)

    def place(self, north: float, east: float) -> tuple[int, int]:
        """Latitude and longitude from home, as integers."""
        latitude = self.home.latitude * 1e-7
        meters = 111319.5 * math.cos(math.radians(latitude))
        longitude = self.home.longitude * 1e-7 + east / meters
        return round((latitude + north / 111319.5) * 1e7), round(longitude * 1e7)

    def take_off(self) -> None:
        self.accept(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        self.wait_armed(True)
        self.accept(mavlink.MAV_CMD_NAV_TAKEOFF, NAN, 0, 0, NAN, NAN, NAN, NAN)
        self.wait("GLOBAL_POSITION_INT", lambda p: p.relative_alt > 4500)

    def upload(self, items: list[Item], kind: int = 0) -> Any:
        """The MISSION_ACK."""
        mav = self.link.mav
        mav.mission_count_send(1, 1, len(items), kind)
        while True:
            asked = self.wait(["MISSION_REQUEST_INT", "MISSION_ACK"])
            if asked.get_type() == "MISSION_ACK":
                return asked
            item = items[asked.seq]
            mav.mission_item_int_send(
                1, 1, asked.seq, item[0], item[1], asked.seq == 0, 1, *item[2:], kind
            )

    def download(self, kind: int = 0) -> list[Any]:
        self.link.mav.mission_request_list_send(1, 1, kind)
        count = self.wait("MISSION_COUNT").count
        items = []
        for i in range(count):
            self.link.mav.mission_request_int_send(1, 1, i, kind)
            items.append(self.wait("MISSION_ITEM_INT", lambda item, i=i: item.seq == i))
        self.link.mav.mission_ack_send(1, 1, mavlink.MAV_MISSION_ACCEPTED, kind)
        return items


@contextlib.contextmanager
def met(log: Path, *options: str) -> Iterator[tuple[Station, dict[str, Any]]]:
    """A flight, and a station that has waited until the vehicle can be armed."""
    port = free_port()
    with flying(log, "--mavlink", f"udp:{port}", *options) as facts:
        station = Station(f"udpin:127.0.0.1:{port}")
        station.connect()
        station.wait_until_armable()
        try:
            yield station, facts
        finally:
            station.close()
