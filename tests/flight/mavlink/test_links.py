"""Bad links, and traffic that asks for nothing: everything arrives whole, and the flight is the
same. How long it takes is tested in virtual time, in tests/apps/mavlink."""

from __future__ import annotations

import random
import re
import socket
import subprocess
from contextlib import closing
from typing import TYPE_CHECKING, Any

from pymavlink.generator.mavcrc import x25crc
from pyulog import ULog
from tests.flight.mavlink.logs import LogReader
from tests.flight.mavlink.relay import Link, Relay, waiting
from tests.flight.mavlink.vehicle import (
    HANGS_S,
    NAN,
    OUTDOOR,
    STEP_S,
    Item,
    Lockstep,
    Station,
    flying,
    mavlink,
)

from stator.build.cmake import build

if TYPE_CHECKING:
    from pathlib import Path

BAD = Link(lost=0.1, garbage=0.05, flipped=0.02, twice=0.05)
RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
LOG_BYTES = 9216
AGAIN_S = 0.3  # until a client asks again


class Patient(Station):
    """A client that asks again."""

    def heard(self, kinds: list[str]) -> Any:
        """The next of these; None after a while."""
        return self.link.recv_match(type=kinds, blocking=True, timeout=AGAIN_S)

    def upload(self, items: list[Item], kind: int = 0) -> Any:
        until = self.clock.time() + HANGS_S
        asked = None
        while self.clock.time() < until:
            if asked is None:
                self.link.mav.mission_count_send(1, 1, len(items), kind)
            else:
                item = items[asked.seq]
                self.link.mav.mission_item_int_send(
                    1, 1, asked.seq, item[0], item[1], 0, 1, *item[2:], kind
                )
            told = self.heard(["MISSION_REQUEST_INT", "MISSION_ACK"])
            if told is not None and told.get_type() == "MISSION_ACK":
                return told
            asked = told or asked
        raise AssertionError("no MISSION_ACK")

    def ask(self, send: Any, kind: str, wanted: Any) -> Any:
        until = self.clock.time() + HANGS_S
        while self.clock.time() < until:
            send()
            told = self.heard([kind])
            if told is not None and wanted(told):
                return told
        raise AssertionError(f"no {kind}")

    def download(self, kind: int = 0) -> list[Any]:
        mav = self.link.mav
        count = self.ask(
            lambda: mav.mission_request_list_send(1, 1, kind), "MISSION_COUNT", lambda _: True
        ).count
        return [
            self.ask(
                lambda i=i: mav.mission_request_int_send(1, 1, i, kind),
                "MISSION_ITEM_INT",
                lambda item, i=i: item.seq == i,
            )
            for i in range(count)
        ]

    def parameters(self) -> dict[int, Any]:
        """By index: the list, and then each that is missing."""
        until = self.clock.time() + HANGS_S
        values: dict[int, Any] = {}
        self.link.param_fetch_all()
        while self.clock.time() < until:
            value = self.heard(["PARAM_VALUE"])
            if value is not None:
                if value.param_index != 65535:
                    values[value.param_index] = value
                if len(values) < value.param_count:
                    continue
            if values and len(values) == next(iter(values.values())).param_count:
                return values
            count = next(iter(values.values())).param_count if values else 1
            for index in [i for i in range(count) if i not in values][:10]:
                self.link.mav.param_request_read_send(1, 1, b"", index)
        raise AssertionError("not all parameters")


def exchange(station: Patient) -> bytes:
    """All parameters, a hundred items, and the beginning of the log, which it returns."""
    station.connect()
    station.wait_until_armable()
    values = station.parameters()
    ids = [values[i].param_id for i in range(len(values))]
    assert ids == sorted(ids)
    assert len(ids) > 100
    items: list[Item] = [
        (RELATIVE, 16, 0.0, 2.0, 0.0, NAN, *station.place(0.5 * i, 1.0), 6.0 + i)
        for i in range(100)
    ]
    assert station.upload(items).type == mavlink.MAV_MISSION_ACCEPTED
    back = station.download()
    assert [(i.frame, i.command, i.x, i.y, i.z) for i in back] == [
        (item[0], item[1], item[6], item[7], item[8]) for item in items
    ]
    logs = LogReader(station)
    assert list(logs.entries()) == [0]
    return logs.read(0, LOG_BYTES)


def test_a_bad_link_loses_nothing(tmp_path: Path) -> None:
    log = tmp_path / "bad.ulg"
    with (
        Lockstep() as clock,
        closing(Patient(clock=clock)) as station,
        closing(Relay(station.port, BAD)) as relay,
        flying(log, "--mavlink", relay.line, clock=clock) as facts,
    ):
        clock.pumps.append(relay.pump)
        part = exchange(station)
    assert part == log.read_bytes()[:LOG_BYTES]
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0


HEARTBEAT = re.compile(rb"\xfd\x09\x00\x00.\x01\x01\x00\x00\x00", re.DOTALL)  # of system 1
DURATION_S = 36
FRAMES = 8  # of each listener, in a step
# Seconds, four sticks, mode slot, and the switches arm, return and kill: a flight in altitude
# and position mode, hold, and a landing.
PILOT = """
0  0   0   0   -1 2 0 0 0
8  0   0   0   -1 2 1 0 0
9  0   0   0    1 2 1 0 0
13 0   0.2 0.3  0 2 1 0 0
15 0.3 0   0    0 3 1 0 0
18 0   0   0    0 4 1 0 0
22 0   0   0    0 6 1 0 0
"""


def frame(source: int, ident: int, payload: bytes, extra: int, sequence: int) -> bytes:
    """A frame of MAVLink 2."""
    head = bytes([len(payload), 0, 0, sequence % 256, source, 190])
    body = head + ident.to_bytes(3, "little") + payload
    crc = x25crc(body + bytes([extra])).crc
    return b"\xfd" + body + crc.to_bytes(2, "little")


def traffic(draw: random.Random) -> bytes:
    """Garbage, requests, and other vehicles' frames; nothing that changes the vehicle."""
    mav = mavlink.MAVLink(None, srcSystem=draw.randrange(2, 250), srcComponent=190)
    kind = draw.randrange(6)
    if kind == 0:
        return draw.randbytes(draw.randrange(1, 60))
    if kind == 1:
        return bytes(mav.param_request_read_encode(1, 1, b"", draw.randrange(300)).pack(mav))
    if kind == 2:
        return bytes(mav.mission_request_list_encode(1, 1, draw.randrange(4)).pack(mav))
    if kind == 3:
        return bytes(mav.ping_encode(0, draw.randrange(1000), 0, 0).pack(mav))
    if kind == 4:
        arm = mav.command_long_encode(7, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)  # another vehicle
        return bytes(arm.pack(mav))
    return frame(9, draw.randrange(1 << 16), draw.randbytes(20), draw.randrange(256), 0)


def flown(folder: Path, name: str, *, noisy: bool) -> dict[str, Any]:
    """Topics of the flight by sticks, and what was received."""
    pilot = folder / "pilot.txt"
    pilot.write_text(PILOT)
    log = folder / f"{name}.ulg"
    beats = [0, 0]
    with Lockstep() as clock:
        listeners = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in beats]
        draws = [random.Random(seed) for seed in range(len(beats))]
        vehicles: list[Any] = [None, None]
        for listener in listeners:
            listener.bind(("127.0.0.1", 0))
            listener.setblocking(False)

        def disturb() -> None:
            for i, listener in enumerate(listeners):
                for data, vehicles[i] in waiting(listener):
                    beats[i] += len(HEARTBEAT.findall(data))
                if vehicles[i] is None or not noisy:
                    continue
                for _ in range(FRAMES):
                    listener.sendto(traffic(draws[i]), vehicles[i])

        command = [build(OUTDOOR, "sitl"), "--log", log, "--duration", str(DURATION_S)]
        command += ["--pilot", pilot, "--lockstep", clock.path]
        for listener in listeners:
            command += ["--mavlink", f"udp:{listener.getsockname()[1]}"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as clock.flight:
            with clock.repeated(disturb, STEP_S):
                for _ in range(round(DURATION_S / STEP_S) - 1):
                    clock.go()
            clock.leave()
        for listener in listeners:
            listener.close()
    assert clock.flight.returncode == 0
    assert min(beats) >= DURATION_S - 2, beats
    return {data.name: data.data for data in ULog(str(log)).data_list}


def test_traffic_does_not_touch_the_flight(tmp_path: Path) -> None:
    """The same control outputs, bit for bit, and a heartbeat each second."""
    quiet = flown(tmp_path, "quiet", noisy=False)
    noisy = flown(tmp_path, "noisy", noisy=True)
    assert quiet["telem1_status"]["received"][-1] == 0
    assert noisy["telem1_status"]["received"][-1] > 50_000
    height = -quiet["vehicle_local_position"]["z"]
    assert height.max() > 2.0  # it flew
    names = ("actuator_motors", "vehicle_rates_setpoint", "vehicle_status", "trajectory_setpoint")
    whole_us = (DURATION_S - 1) * 1_000_000  # what of the last moment is written differs
    for name in names:
        rows, others = (log[name]["timestamp"] < whole_us for log in (quiet, noisy))
        for field, values in quiet[name].items():
            other = noisy[name][field]
            assert values[rows].tobytes() == other[others].tobytes(), (name, field)
