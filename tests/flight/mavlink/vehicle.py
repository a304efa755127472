"""A simulated vehicle with MAVLink, and a ground station of pymavlink, for tests.

Vehicle and station share one clock, the vehicle's: it goes on while the station waits, 10 ms at a
time (`--lockstep`), so that no test depends on how fast the machine is. Clients that live by the
machine's own clock fly at `--speed`; limits in wall time only end what hangs."""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

os.environ["MAVLINK20"] = "1"  # before pymavlink is imported

from pymavlink import mavftp, mavparm, mavutil
from pymavlink.dialects.v20 import common as mavlink

from stator import HOME

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

OUTDOOR = HOME / "graph" / "quad_outdoor.yaml"
COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator"]
HANGS_S = 600.0
START_S = 1800.0  # of wall time, until the vehicle is built and flies
STEP_S = 0.01  # boards/sitl/main.cpp
NAN = math.nan


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    """A port that nothing uses, and that the system gives to nobody who asks for any."""
    while True:
        port = random.SystemRandom().randrange(10_000, 32_000)
        with socket.socket(socket.AF_INET, kind) as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port


class Lockstep:
    """The clock of a vehicle that waits for its station; stands in for the module `time`."""

    def __init__(self) -> None:
        self.steps = 0
        self.flight: subprocess.Popen[str] | None = None
        self.pumps: list[Callable[[], None]] = []  # of what is between vehicle and station
        self._repeated: list[tuple[int, Callable[[], None]]] = []
        self._vehicle: socket.socket | None = None

    def __enter__(self) -> Lockstep:
        self._folder = tempfile.TemporaryDirectory(prefix="step-")
        self.path = f"{self._folder.name}/s"
        self._server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._server.bind(self.path)
        self._server.listen(1)
        self._server.settimeout(1.0)
        for module in (mavutil, mavftp, mavparm):
            module.time = self
        return self

    def __exit__(self, *_: object) -> None:
        for module in (mavutil, mavftp, mavparm):
            module.time = time
        self._server.close()
        self.leave()
        self._folder.cleanup()

    def leave(self) -> None:
        """The flight goes on by itself."""
        if self._vehicle is not None:
            self._vehicle.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)

    def time(self) -> float:
        return self.steps * STEP_S

    def sleep(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            self.go()

    def go(self) -> None:
        """One step. All that the vehicle sends in it has arrived."""
        vehicle = self._vehicle or self._meet()
        for period, send in self._repeated:
            if self.steps % period == 0:
                send()
        for pump in self.pumps:
            pump()
        self.steps += 1
        vehicle.sendall(b".")
        assert vehicle.recv(1), "the flight has ended"
        for pump in self.pumps:
            pump()

    def _meet(self) -> socket.socket:
        until = time.monotonic() + START_S
        while self._vehicle is None:
            assert self.flight is not None and self.flight.poll() is None, "nothing flies"
            assert time.monotonic() < until
            with contextlib.suppress(TimeoutError):
                self._vehicle = self._server.accept()[0]
        self._vehicle.settimeout(HANGS_S)
        return self._vehicle

    @contextlib.contextmanager
    def repeated(self, send: Callable[[], None], every_s: float) -> Iterator[None]:
        """Sends while the block runs."""
        row = (round(every_s / STEP_S), send)
        self._repeated.append(row)
        try:
            yield
        finally:
            self._repeated.remove(row)


@contextlib.contextmanager
def flying(
    log: Path, *options: str, how: str = "fly", clock: Lockstep | None = None
) -> Iterator[dict[str, Any]]:
    """A flight in the background, which ends with the block. Then the result has its facts.
    `how`: the command."""
    result: dict[str, Any] = {}
    steps = ["--lockstep", clock.path] if clock else []
    command = [*COMMAND, how, str(OUTDOOR), *options, *steps, "-o", str(log), "--json"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        if clock:
            clock.flight = process
        try:
            yield result
        finally:
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=HANGS_S)
    assert output, errors
    result |= json.loads(output)


def wait_until_it_talks(port: int) -> None:
    """A vehicle that is not built yet takes its time, which no client waits for."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", port))
        probe.settimeout(START_S)
        probe.recv(1)


# Frame, command, four parameters, x, y, z.
Item = tuple[int, int, float, float, float, float, int, int, float]


class Station:
    """A ground station."""

    def __init__(
        self, url: str = "udpin:127.0.0.1:0", system: int = 250, clock: Lockstep | None = None
    ) -> None:
        self.link = mavutil.mavlink_connection(
            url,
            source_system=system,
            source_component=190,
            dialect="common",
            retries=int(START_S),  # one a second, until the vehicle listens
        )
        self.clock = clock or time
        if clock:
            self._wait_in_step(clock)
        self.system = system
        self.home: Any = None

    def _wait_in_step(self, clock: Lockstep) -> None:
        """Whenever it looks for a message and finds none, the vehicle flies on."""
        receive = self.link.recv_msg

        def receive_in_step() -> Any:
            message = receive()
            if message is None:
                clock.go()
                message = receive()
            return message

        self.link.recv_msg = receive_in_step
        self.link.select = lambda _: True

    @property
    def port(self) -> int:
        number: int = self.link.port.getsockname()[1]
        return number

    @property
    def line(self) -> str:
        """Where the vehicle is to send."""
        return f"udp:{self.port}"

    def close(self) -> None:
        self.link.close()

    def wait(
        self,
        kind: str | list[str],
        wanted: Callable[[Any], bool] = lambda _: True,
        limit_s: float = HANGS_S,
    ) -> Any:
        until = self.clock.time() + limit_s
        while self.clock.time() < until:
            message = self.link.recv_match(type=kind, blocking=True, timeout=0.2)
            if message is not None and wanted(message):
                return message
        raise AssertionError(f"no {kind} that is wanted")

    def connect(self) -> Any:
        beat = self.wait("HEARTBEAT", limit_s=START_S)
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
def met(
    log: Path, *options: str, kind: type[Station] = Station
) -> Iterator[tuple[Any, dict[str, Any]]]:
    """A flight, and a station that has waited until the vehicle can be armed."""
    with (
        Lockstep() as clock,
        contextlib.closing(kind(clock=clock)) as station,
        flying(log, "--mavlink", station.line, *options, clock=clock) as facts,
    ):
        station.connect()
        station.wait_until_armable()
        yield station, facts
