"""A person types commands to the vehicle: as a ground station's console, and by ./stator shell."""

from __future__ import annotations

import os
import pty
import re
import select
import subprocess
import time
from typing import TYPE_CHECKING

from tests.flight.mavlink.vehicle import (
    COMMAND,
    HANGS_S,
    Lockstep,
    Station,
    flying,
    free_port,
    mavlink,
    wait_until_it_talks,
)

if TYPE_CHECKING:
    from pathlib import Path

SHELL = mavlink.SERIAL_CONTROL_DEV_SHELL
FLAGS = (
    mavlink.SERIAL_CONTROL_FLAG_RESPOND
    | mavlink.SERIAL_CONTROL_FLAG_EXCLUSIVE
    | mavlink.SERIAL_CONTROL_FLAG_MULTI
)


def type_text(station: Station, text: str) -> None:
    for at in range(0, max(len(text), 1), 70):
        data = text[at : at + 70].encode()
        padded = list(data.ljust(70, b"\0"))
        station.link.mav.serial_control_send(SHELL, FLAGS, 0, 0, len(data), padded)


def read_until(station: Station, end: str) -> str:
    text = ""
    while not text.endswith(end):
        reply = station.wait("SERIAL_CONTROL")
        assert reply.flags == mavlink.SERIAL_CONTROL_FLAG_REPLY
        text += bytes(reply.data[: reply.count]).decode()
    return text


def say(station: Station, line: str) -> str:
    type_text(station, f"{line}\n")
    text = read_until(station, "\n> ")
    assert text.startswith(f"{line}\n"), text
    return text.removeprefix(f"{line}\n").removesuffix("> ")


def consoles(first: Station, second: Station) -> None:
    for station in (first, second):
        station.connect()
        type_text(station, "")
        assert read_until(station, "> ") == "> "

    tasks = say(first, "top").splitlines()
    assert tasks[0].split()[:4] == ["lev", "task", "count", "/s"]
    rate_control = next(line.split() for line in tasks if "rate_control" in line)
    assert 900 <= int(rate_control[3]) <= 1010  # of 1 kHz, since the start
    assert any(line.split()[1] == "shell" for line in tasks[1:])

    for station in (first, second):
        type_text(station, "listener vehicle_status\nparam get MIS_TAKEOFF_ALT\n")
    for station in (first, second):
        sample = read_until(station, "\n> ")
        assert re.search(r"^  nav_state: \d+$", sample, re.MULTILINE), sample
        assert re.search(r"\* ?MIS_TAKEOFF_ALT|  MIS_TAKEOFF_ALT", read_until(station, "\n> "))
    assert "out of range" in say(first, "param set MIS_TAKEOFF_ALT -7")
    assert "7.5" in say(second, "param set MIS_TAKEOFF_ALT 7.5")
    first.link.mav.param_request_read_send(1, 1, b"MIS_TAKEOFF_ALT", -1)
    first.wait("PARAM_VALUE", lambda value: value.param_value == 7.5)
    assert len(say(first, "param list MPC_").splitlines()) > 5
    assert "unknown topic" in say(first, "listener nothing")


def test_consoles_of_two_stations(tmp_path: Path) -> None:
    """They ask at once, and each gets its own answers; a recording of it replays."""
    log = tmp_path / "shell.ulg"
    with Lockstep() as clock:
        first, second = Station(clock=clock), Station(system=251, clock=clock)
        lines = ["--mavlink", first.line, "--mavlink", second.line]
        with flying(log, *lines, clock=clock):
            consoles(first, second)
        first.close()
        second.close()
    replay = [*COMMAND, "replay", str(log)]
    subprocess.run(replay, check=True, capture_output=True)  # which may have to be built


def test_shell_command_on_a_terminal(tmp_path: Path) -> None:
    port = free_port()
    with flying(tmp_path / "shell.ulg", "--mavlink", f"udp:{port}", "--speed", "5"):
        wait_until_it_talks(port)
        terminal, ours = pty.openpty()
        command = [*COMMAND, "shell", "--mavlink", f"udp:{port}"]
        with subprocess.Popen(command, stdin=ours, stdout=ours, stderr=ours) as shell:
            os.close(ours)
            shown = _read_terminal(terminal, "> ")
            os.write(terminal, b"listener home_position\n")
            shown = _read_terminal(terminal, "\n> ")
            assert shown.count("listener home_position") == 1, "typed once, shown once"
            assert "valid_lpos" in shown or "no sample yet" in shown
            os.write(terminal, b"param get MIS_TAKEOFF_ALT\n")
            assert "navigator.takeoff_height" in _read_terminal(terminal, "\n> ")
            os.write(terminal, b"\x04")
            assert shell.wait(timeout=HANGS_S) == 0
        os.close(terminal)


def test_shell_command_in_a_pipe(tmp_path: Path) -> None:
    port = free_port()
    with flying(tmp_path / "shell.ulg", "--mavlink", f"udp:{port}", "--speed", "5"):
        wait_until_it_talks(port)
        command = [*COMMAND, "shell", "--mavlink", f"udp:{port}"]
        done = subprocess.run(
            command,
            input="help\nlistener\n",
            capture_output=True,
            text=True,
            check=True,
            timeout=HANGS_S,
        )
    assert done.stdout.startswith("> help\n")
    assert "vehicle_attitude\n" in done.stdout
    assert done.stdout.endswith("> ")


def _read_terminal(terminal: int, end: str) -> str:
    text = ""
    until = time.monotonic() + HANGS_S
    while not text.endswith(end):
        assert time.monotonic() < until, text
        if select.select([terminal], [], [], 0.2)[0]:
            text += os.read(terminal, 4096).decode().replace("\r\n", "\n")
    return text
