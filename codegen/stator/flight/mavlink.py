"""The lines with MAVLink of a flight."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import sys
import termios
import tty
from typing import TYPE_CHECKING

from stator import HOME
from stator.arguments import path
from stator.diagnostics import UserError, shown_path
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

MAX_LINES = 2  # boards/world/world/options.hpp
ENDLESS_S = 86_400.0  # a flight that others end, at most
_FORMS = "udp:[HOST:]PORT, tcp:PORT or serial:PATH:BAUD"
_UDP = re.compile(r"udp:(?:([0-9.]+|localhost):)?(\d+)")
_TCP = re.compile(r"tcp:(\d+)")
_SERIAL = re.compile(r"serial:([^:]+):(\d+)")
_MAX_PORT = 65535


def add_mavlink_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--mavlink",
        action="append",
        default=[],
        type=place_of,
        metavar="PLACE",
        help="where a MAVLink line goes: udp:[HOST:]PORT sends there (default host: 127.0.0.1) and "
        "answers who writes, tcp:PORT listens on 127.0.0.1, serial:PATH:BAUD. The first is for a "
        "ground station, the second for a computer on board. The pilot then leaves the switches "
        "alone, and the flight goes on until Ctrl-C (docs/mavlink.md)",
    )


def add_lockstep_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--lockstep",
        metavar="SOCKET",
        help="with --mavlink: fly 10 ms each time the program that listens at this Unix socket "
        "sends a byte, and answer with a byte, so that a test does not depend on the machine's "
        "load (docs/mavlink.md)",
    )


def add_signing_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--signing-key",
        type=path,
        metavar="FILE",
        help="with --mavlink: the key of signatures, in place of the one that the vehicle keeps: "
        "64 hexadecimal digits, or a phrase whose SHA-256 it is (docs/mavlink.md)",
    )


def place_of(text: str) -> str:
    """With the host written out."""
    udp = _UDP.fullmatch(text)
    port = udp[2] if udp else (_TCP.fullmatch(text) or ("", "0"))[1]
    if _SERIAL.fullmatch(text):
        return text
    if not 0 < int(port) <= _MAX_PORT:
        raise argparse.ArgumentTypeError(f"expected {_FORMS}, found '{text}'")
    return f"udp:{udp[1] or '127.0.0.1'}:{port}" if udp else text


def complete_mavlink(arguments: argparse.Namespace) -> None:
    """The defaults of a flight with MAVLink, which others fly and end."""
    if arguments.mavlink:
        if getattr(arguments, "lockstep", None) is None:
            arguments.speed = arguments.speed or 1.0
        arguments.duration = arguments.duration or ENDLESS_S
        arguments.graph = arguments.graph or HOME / "graph" / "quad_outdoor.yaml"


def check_mavlink(arguments: argparse.Namespace) -> None:
    """Raises `UserError` if the graph cannot have these lines."""
    places: Sequence[str] = arguments.mavlink
    if getattr(arguments, "lockstep", None) is not None:
        if not places:
            raise UserError("error: --lockstep: missing --mavlink\nhint: add --mavlink udp:14550")
        if arguments.speed is not None:
            raise UserError("error: --speed: not with --lockstep\nhint: omit --speed")
    if getattr(arguments, "signing_key", None) is not None and not places:
        raise UserError("error: --signing-key: missing --mavlink\nhint: add --mavlink udp:14550")
    if not places:
        return
    if len(places) > MAX_LINES:
        raise UserError(
            f"error: --mavlink: expected at most {MAX_LINES} lines, found {len(places)}"
        )
    plan = make_plan(str(arguments.graph), arguments.board)
    if any(node.interface.name == "mavlink" for node in plan.graph.nodes.values()):
        return
    raise UserError(
        f"error: missing node of app 'mavlink' in {shown_path(arguments.graph)}\n"
        "hint: include parts/mavlink.yaml in your graph, or use graph/quad_outdoor.yaml"
    )


def mavlink_options(arguments: argparse.Namespace) -> list[str]:
    """Options of the flight program."""
    words = [word for place in arguments.mavlink for word in ("--mavlink", place)]
    for option in ("lockstep", "signing_key"):
        value = getattr(arguments, option, None)
        words += [] if value is None else [f"--{option.replace('_', '-')}", str(value)]
    return words


def tell_mavlink(arguments: argparse.Namespace) -> None:
    if arguments.mavlink and not arguments.json:
        places = " and ".join(arguments.mavlink)
        print(f"note: MAVLink on {places}; Ctrl-C ends the flight", file=sys.stderr)


@contextlib.contextmanager
def serial_lines(arguments: argparse.Namespace) -> Iterator[None]:
    """Sets serial lines to raw bytes and to their rates, and keeps them so. Raises `UserError`."""
    found = [match for match in map(_SERIAL.fullmatch, arguments.mavlink) if match]
    with contextlib.ExitStack() as stack:
        for path, baud in ((match[1], match[2]) for match in found):
            try:
                descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
                stack.callback(os.close, descriptor)
                tty.setraw(descriptor)
                settings = termios.tcgetattr(descriptor)
                settings[2] |= termios.CLOCAL | termios.CREAD
                settings[4] = settings[5] = getattr(termios, f"B{baud}")
                termios.tcsetattr(descriptor, termios.TCSANOW, settings)
            except AttributeError:
                raise UserError(
                    f"error: --mavlink 'serial:{path}:{baud}': unknown baud rate {baud}\n"
                    "hint: use a usual one, such as 57600 or 921600"
                ) from None
            except (OSError, termios.error) as problem:
                reason = os.strerror(problem.args[0])
                raise UserError(f"error: --mavlink 'serial:{path}:{baud}': {reason}") from None
        yield
