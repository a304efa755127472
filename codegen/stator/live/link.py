"""The terminal's side of the link to firmware, or to a graph on Linux: docs/link.md."""

from __future__ import annotations

import os
import select
import socket
import stat
import struct
import termios
import time
import tty
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import UserError, shown_path
from stator.live.fault_record import LAYOUT, FaultRecord, decode
from stator.live.place import graph_of, served_places

if TYPE_CHECKING:
    from stator.plan.plan import Plan

INFO, TASKS, SAMPLE, FAULT, PARAMETER = 1, 2, 3, 4, 5
VERSION = 1
ANSWER_S = 0.5  # until a request is sent again
MAX_TRIES = 10
UNITS = ("cycles", "instructions", "cpu_time")
TASK = struct.Struct("<7I")


class NoLink(UserError):
    """There is no vehicle, or it does not answer; the message says what to do."""


@dataclass(frozen=True)
class Info:
    safe_mode: bool
    failed_before: bool
    unit: str  # of execution times; "nothing": not measured
    ticks_per_unit: int
    ticks_per_s: int
    time_us: int
    tasks: int
    topics: int
    graph_hash: str  # its first digits
    graph: str
    board: str


@dataclass(frozen=True)
class TaskFigures:
    """The vehicle's counters, modulo 2^32; execution times in ticks."""

    activations: int
    lost: int
    ticks: int
    last_ticks: int
    most_ticks: int
    latest_us: int
    missed_life_signs: int


# --- frames ---


def frame(body: bytes) -> bytes:
    """The body and its CRC-32, coded without zeros, then a zero."""
    data = body + struct.pack("<I", zlib.crc32(body))
    coded = bytearray()
    for i, run in enumerate(runs := data.split(b"\0")):
        while len(run) >= 254:
            coded += b"\xff" + run[:254]
            run = run[254:]
            if not run and i == len(runs) - 1:
                break
        else:
            coded += bytes([len(run) + 1]) + run
    return bytes(coded) + b"\0"


def unframe(coded: bytes) -> bytes | None:
    """The body of the bytes between two zeros; None if they are damaged."""
    data = bytearray()
    at = 0
    while at < len(coded):
        length = coded[at]
        run = coded[at + 1 : at + length]
        if length == 0 or len(run) != length - 1:
            return None
        data += run
        at += length
        if length != 255 and at < len(coded):
            data.append(0)
    body, crc = bytes(data[:-4]), bytes(data[-4:])
    return body if len(data) >= 4 and struct.pack("<I", zlib.crc32(body)) == crc else None


# --- the link ---


class Link:
    """Requests to the vehicle, over a Unix socket (Linux, emulator) or a serial port."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._tag = 0
        self._waiting = b""
        self._socket: socket.socket | None = None
        try:
            self._file = self._open()
        except (OSError, termios.error) as error:
            why = "it is not a serial port"
            if isinstance(error, OSError):
                why = error.strerror or str(error)
            raise NoLink(
                f"error: cannot connect to {shown_path(path)}: {why}\n{_place_hint()}"
            ) from None

    def _open(self) -> int:
        if stat.S_ISCHR(self.path.stat().st_mode):
            file = os.open(self.path, os.O_RDWR | os.O_NOCTTY)
            try:
                tty.setraw(file)
                speed = termios.tcgetattr(file)
                speed[4] = speed[5] = termios.B115200
                termios.tcsetattr(file, termios.TCSANOW, speed)
            except termios.error:
                os.close(file)
                raise
            return file
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.connect(str(self.path))
        return self._socket.fileno()

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        else:
            os.close(self._file)

    def __enter__(self) -> Link:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def ask(self, kind: int, argument: int = 0, more: bytes = b"") -> bytes:
        """The body of the answer, without its head. Raises `NoLink` if there is no answer."""
        for _ in range(MAX_TRIES):
            self._tag = (self._tag + 1) % 256
            head = bytes([kind, self._tag])
            try:
                os.write(self._file, b"\0" + frame(head + struct.pack("<H", argument) + more))
                body = self._answer(head)
            except OSError as error:
                raise self._gone(error.strerror or "") from None
            if body is not None:
                return body
        raise NoLink(
            f"error: no answer from {shown_path(self.path)}\n"
            "hint: check that Stator runs there, and that it is not stopped"
        )

    def _answer(self, head: bytes) -> bytes | None:
        end = time.monotonic() + ANSWER_S
        while (left := end - time.monotonic()) > 0:
            while b"\0" in self._waiting:
                coded, _, self._waiting = self._waiting.partition(b"\0")
                body = unframe(coded)
                if body is not None and body[:2] == head:
                    return body[2:]
            if select.select([self._file], [], [], left)[0]:
                data = os.read(self._file, 4096)
                if not data:
                    raise self._gone("it ended")
                self._waiting += data
        return None

    def _gone(self, why: str) -> NoLink:
        return NoLink(f"error: lost the connection to {shown_path(self.path)}: {why}")

    def info(self) -> Info:
        body = self.ask(INFO)
        if body[0] != VERSION:
            raise NoLink(
                f"error: expected version {VERSION} of the link, found {body[0]}\n"
                "hint: use the ./stator that built the vehicle's software"
            )
        safe, cause, unit, per_unit, ticks_per_s, time_us, tasks, topics = struct.unpack_from(
            "<4BIQHH", body, 1
        )
        at = 1 + struct.calcsize("<4BIQHH")
        graph_hash = body[at : at + 16].decode(errors="replace")
        graph, rest = _text(body[at + 16 :])
        board, _ = _text(rest)
        return Info(
            safe_mode=bool(safe),
            failed_before=bool(cause),
            unit=_unit(unit) if ticks_per_s != 0 else "nothing",
            ticks_per_unit=max(per_unit, 1),
            ticks_per_s=ticks_per_s,
            time_us=time_us,
            tasks=tasks,
            topics=topics,
            graph_hash=graph_hash,
            graph=graph,
            board=board,
        )

    def tasks(self, count: int) -> tuple[int, list[TaskFigures]]:
        """The vehicle's time in us, and the counters of each task, most urgent first."""
        figures: list[TaskFigures] = []
        time_us = 0
        while len(figures) < count:
            body = self.ask(TASKS, len(figures))
            time_us, first = struct.unpack_from("<QH", body)
            rows = [TaskFigures(*row) for row in TASK.iter_unpack(body[10:])]
            if first != len(figures) or not rows:
                raise NoLink("error: the vehicle sent fewer tasks than it announced")
            figures += rows
        return time_us, figures

    def sample(self, topic: int) -> tuple[int, bytes]:
        """The number of the newest sample of a topic, and its bytes; none: no sample yet."""
        body = self.ask(SAMPLE, topic)
        _, number = struct.unpack_from("<HI", body)
        return number, body[6:]

    def ask_parameter(self, index: int, request: bytes) -> bytes:
        """How far a request for a parameter is: docs/link.md."""
        return self.ask(PARAMETER, index, request)

    def fault(self) -> FaultRecord | None:
        body = self.ask(FAULT)
        record = decode(body[: LAYOUT.packed.size])
        return record if record.cause else None


def _place_hint() -> str:
    others = [f"--link {shown_path(place)}" for place in served_places()]
    if others:
        return f"hint: running here: {' or '.join(others)}"
    return (
        "hint: start ./stator run, or ./stator emulate --link --speed 1; or give the serial port, "
        "for example --link /dev/ttyACM0"
    )


def _unit(code: int) -> str:
    return UNITS[code] if code < len(UNITS) else "ticks"


def _text(data: bytes) -> tuple[str, bytes]:
    return data[1 : 1 + data[0]].decode(errors="replace"), data[1 + data[0] :]


def plan_of(info: Info, graph: Path | None, link: Path) -> Plan:
    """The plan of the running graph: the given one, the one that the link names, or one of Stator's
    own. Raises `UserError` if the file holds another graph."""
    from stator.pipeline import make_plan
    from stator.plan.hash import graph_hash

    file = graph or graph_of(link) or HOME / "graph" / f"{info.graph}.yaml"
    if not file.is_file():
        raise UserError(
            f"error: missing file '{shown_path(file)}' of the running graph '{info.graph}'\n"
            "hint: give its file: --graph FILE"
        )
    plan = make_plan(str(file), info.board)
    if graph_hash(plan)[:16] != info.graph_hash:
        raise UserError(
            f"error: the vehicle runs another version of the graph {shown_path(file)}\n"
            "hint: build and start it again, or give the file of its graph: --graph FILE"
        )
    return plan
