"""A console over MAVLink's SERIAL_CONTROL: the vehicle's own shell."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from typing import TYPE_CHECKING, Any

from stator.diagnostics import UserError

if TYPE_CHECKING:
    from collections.abc import Iterator

SHELL = 10  # SERIAL_CONTROL_DEV_SHELL
RESPOND, EXCLUSIVE, MULTI = 2, 4, 16  # SERIAL_CONTROL_FLAG
REPLY = 1
DATA_BYTES = 70
PROMPT = "> "
FOUND_S = 10.0  # until a vehicle is heard
ANSWER_S = 1.0  # until the first prompt is asked for again
QUIET_S = 5.0  # without an answer, once all is typed
LOOK_S = 0.02
HEARTBEAT_S = 1.0
SILENT_S = 2.0  # then the next line is sent
# Between two looks. A machine that stalls for longer stalls the vehicle, too: it was not silent.
MOST_LOOK_S = 0.1


def talk(place: str) -> None:
    """Until the end of the standard input. Raises `UserError` if no vehicle answers."""
    with _connected(place) as link:
        _Session(link).run()


@contextlib.contextmanager
def _connected(place: str) -> Iterator[Any]:
    os.environ["MAVLINK20"] = "1"  # before pymavlink is imported
    from pymavlink import mavutil

    kind, _, rest = place.partition(":")
    url, options = f"udpin:0.0.0.0:{rest.rpartition(':')[2]}", {}
    if kind == "tcp":
        url = f"tcp:127.0.0.1:{rest}"
    elif kind == "serial":
        path, _, baud = rest.rpartition(":")
        url, options = path, {"baud": int(baud)}
    try:
        link = mavutil.mavlink_connection(
            url, source_system=254, source_component=190, dialect="common", retries=1, **options
        )
    except OSError as error:
        raise UserError(
            f"error: cannot open --mavlink {place}: {error.strerror or error}\n"
            "hint: if a ground station has this port, start the vehicle with a second --mavlink"
        ) from None
    try:
        if link.wait_heartbeat(timeout=FOUND_S) is None:
            raise UserError(
                f"error: heard no vehicle on {place} for {FOUND_S:.0f} s\n"
                f"hint: start one with --mavlink {place}"
            )
        yield link
    finally:
        link.close()


class _Echo:
    """Leaves out the vehicle's echo of what a terminal has shown already."""

    def __init__(self, *, is_terminal: bool) -> None:
        self.is_terminal = is_terminal
        self.typed: list[str] = []  # lines whose echo is still to come
        self.waiting = ""
        self.at_prompt = False
        self.end = ""  # the last characters that were shown
        self.prompts = 0

    def shown(self, text: str) -> str:
        """What of it to show."""
        out = ""
        self.waiting += text
        while self.waiting:
            if self.is_terminal and self.at_prompt and self.typed:
                echo = self.typed[0]
                if self.waiting.startswith(echo):
                    self.waiting = self.waiting[len(echo) :]
                    self.typed.pop(0)
                    self.at_prompt, self.end = False, "\n"
                    continue
                if echo.startswith(self.waiting):
                    return out  # the rest comes
            out += self.waiting[0]
            self.end = (self.end + self.waiting[0])[-3:]
            self.waiting = self.waiting[1:]
            self.at_prompt = self.end in (PROMPT, "\n" + PROMPT)
            self.prompts += self.at_prompt
        return out


class _Session:
    def __init__(self, link: Any) -> None:
        self.link = link
        self.echo = _Echo(is_terminal=sys.stdin.isatty())
        self.waiting = b""  # typed, not sent
        self.sent = 0  # lines
        self.now_s = 0.0
        self.looked_s = time.monotonic()
        self.heard_s = 0.0
        self.beat_s = -HEARTBEAT_S

    def run(self) -> None:
        has_input = True
        asked_s = -ANSWER_S
        try:
            while has_input or not self._is_done():
                try:
                    self._look_at_clock()
                    if self.echo.prompts == 0 and self.now_s - asked_s > ANSWER_S:
                        asked_s = self.now_s
                        self._send(b"")
                    if has_input and select.select([sys.stdin], [], [], LOOK_S)[0]:
                        has_input = self._read_line()
                    if not has_input:
                        time.sleep(LOOK_S)
                    self._send_next()
                    self._receive()
                except KeyboardInterrupt:
                    self.waiting = b""
                    self._send(b"\x03")
        finally:
            self._send(b"", flags=0)  # the console is free for others

    def _look_at_clock(self) -> None:
        before_s, self.looked_s = self.looked_s, time.monotonic()
        self.now_s += min(self.looked_s - before_s, MOST_LOOK_S)

    def _read_line(self) -> bool:
        """False: it was the last one."""
        line = sys.stdin.readline()
        if not line:
            self.heard_s = self.now_s
            return False
        line = line.rstrip("\n")[: DATA_BYTES * 2 - 1] + "\n"
        self.echo.typed.append(line)
        self.waiting += line.encode("ascii", errors="replace")
        return True

    def _send_next(self) -> None:
        """A line at a time, once the vehicle waits for one, or is silent for long: a line with
        losses may have lost the one before."""
        is_silent = self.now_s - self.heard_s > SILENT_S
        if not self.waiting or self.echo.prompts == 0:
            return
        if self.echo.prompts <= self.sent and not is_silent:
            return
        line, _, self.waiting = self.waiting.partition(b"\n")
        line += b"\n"
        self.sent += 1
        self.heard_s = self.now_s
        for at in range(0, len(line), DATA_BYTES):
            self._send(line[at : at + DATA_BYTES])

    def _is_done(self) -> bool:
        all_done = not self.waiting and self.echo.prompts > self.sent
        return all_done or self.now_s - self.heard_s > QUIET_S

    def _receive(self) -> None:
        if self.now_s - self.beat_s > HEARTBEAT_S:
            self.beat_s = self.now_s
            self.link.mav.heartbeat_send(6, 8, 0, 0, 4)
        while (message := self.link.recv_match(type="SERIAL_CONTROL", blocking=False)) is not None:
            if message.device != SHELL or not message.flags & REPLY:
                continue
            self.heard_s = self.now_s
            text = bytes(message.data[: message.count]).decode("ascii", errors="replace")
            print(self.echo.shown(text), end="", flush=True)

    def _send(self, data: bytes, flags: int = RESPOND | EXCLUSIVE | MULTI) -> None:
        padded = list(data.ljust(DATA_BYTES, b"\0"))
        self.link.mav.serial_control_send(SHELL, flags, 0, 0, len(data), padded)
