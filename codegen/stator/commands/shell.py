"""`./stator shell`: a console of a vehicle that runs: top, listener, param, help."""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys

from stator.flight.mavlink import place_of
from stator.live.arguments import add_link_arguments
from stator.live.console import talk
from stator.live.link import Link, plan_of

PROMPT = "> "
HELP = """top [--once]          what each task does
listener TOPIC        samples of a topic, until Ctrl-C
param list [--changed], get NAME, set NAME VALUE
help                  these lines; Ctrl-D ends"""
WORDS = ("top", "listener", "perf", "param")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_link_arguments(parser)
    parser.add_argument(
        "--mavlink",
        type=place_of,
        metavar="PLACE",
        help="through this MAVLink line, as QGroundControl's console does: the vehicle's own shell "
        "(udp:[HOST:]PORT, tcp:PORT or serial:PATH:BAUD, as --mavlink of fly and run)",
    )


def main(arguments: argparse.Namespace) -> int:
    if arguments.mavlink is not None:
        talk(arguments.mavlink)
    else:
        with Link(arguments.link) as link:  # before the first command: is there a vehicle?
            plan_of(link.info(), arguments.graph, arguments.link)
        _serve(arguments)
    return 0


def _serve(arguments: argparse.Namespace) -> None:
    """Each line is a command of ./stator on the same link."""
    options = ["--link", str(arguments.link)]
    if arguments.graph is not None:
        options += ["--graph", str(arguments.graph)]
    while (words := _words()) is not None:
        if words[:1] == ["help"]:
            print(HELP)
        elif words and words[0] not in WORDS:
            print(f"unknown command '{words[0]}'; `help` shows all")
        elif words:
            command = [sys.executable, "-I", "-X", "utf8", "-m", "stator", *words, *options]
            try:
                subprocess.run(command, check=False)
            except KeyboardInterrupt:  # the command has heard it, too
                print()


def _words() -> list[str] | None:
    """Of the next line; None at the end."""
    while True:
        try:
            return shlex.split(input(PROMPT))
        except EOFError:
            print()
            return None
        except KeyboardInterrupt:
            print()
        except ValueError as error:
            print(f"cannot read this line: {error}")
