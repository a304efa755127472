"""`./stator`: the parser, and the one table of commands."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from importlib import import_module
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from stator.diagnostics import (
    INTERRUPTED,
    NOT_DONE,
    SIGNALLED,
    Ended,
    Failed,
    UserError,
    in_place,
    show_errors,
)

if TYPE_CHECKING:
    from types import FrameType


class Command(NamedTuple):
    """A command; its code is `commands/NAME.py`. ./stator reads these rows too, so write one row a
    line."""

    name: str
    needs: str  # sections of requirements-apt.txt, or all; tests: requirements-test.txt, too
    help: str


COMMANDS = (
    Command("check", "", "check a graph and show its plan"),
    Command("gen", "", "write the C++ of a graph"),
    Command("graph", "graphviz", "draw a graph"),
    Command("explain", "", "explain when a node runs, and why"),
    Command("prove", "", "prove that no task and no chain of a graph can be late"),
    Command("whatif", "", "show which bounds move if a rate, a priority or a budget changes"),
    Command("measure", "host firmware emulator", "measure budgets in the emulator, for prove"),
    Command("new", "", "write a new app or graph"),
    Command("fly", "host", "fly a graph in simulation and judge the flight"),
    Command("campaign", "host", "fly a graph many times with drawn inputs, and report"),
    Command("simulate", "host", "be the simulator of another autopilot, by HIL messages"),
    Command("debug", "host debugger", "fly a graph under a debugger, stopped where a node steps"),
    Command("run", "host", "run a graph in real time on this machine"),
    Command("build", "host firmware", "build the firmware of a graph and show its size"),
    Command("flash", "host firmware", "write the firmware of a graph to a board"),
    Command("emulate", "host firmware emulator", "fly the firmware of a graph in an emulator"),
    Command("view", "graphviz", "show a running vehicle, or a log, in the browser"),
    Command("top", "", "show the tasks of a running vehicle"),
    Command("listener", "", "print the samples of a topic of a running vehicle"),
    Command("perf", "", "show the measured times of a running vehicle beside their bounds"),
    Command("param", "", "list, change, save and load the parameters of a running vehicle"),
    Command("shell", "", "type commands to a running vehicle: top, listener, param"),
    Command("plot", "", "draw plots of a flight from its log"),
    Command("compare", "", "show what differs between flights, and draw them in one picture"),
    Command("convert", "", "write the log of a flight for other tools: MCAP, CSV, Parquet"),
    Command("replay", "host", "repeat a recorded flight and compare every sample"),
    Command("score", "host", "score an estimator on recorded sensor data"),
    Command("bench", "host tests", "compare speed with other software, as ratios within one run"),
    Command("test", "all", "run all tests"),
    Command("lint", "host tests", "check the format and style of the code"),
    Command("schema", "", "print the JSON Schema of graph files, for editors"),
    Command("completion", "", "print the completion of this command line for a shell"),
    Command("setup", "all", "install missing tools and packages"),  # done by ./stator itself
)


def main(argv: list[str]) -> int:
    """Runs one command; returns the exit status: see diagnostics.py."""
    try:
        return _run_or_complain(argv)
    except OSError:  # standard error cannot be written, either
        _give_up_output()
        return NOT_DONE


def _run_or_complain(argv: list[str]) -> int:
    try:
        try:
            return _run(argv)
        finally:  # here, where what it says is heard: at the end of the interpreter it is too late
            sys.stdout.flush()
    except Failed as failed:
        show_errors(failed)
    except UserError as failed:
        print(in_place(str(failed)), file=sys.stderr)
    except KeyboardInterrupt:
        print("stator: interrupted", file=sys.stderr)
        return INTERRUPTED
    except Ended as ended:
        print(f"stator: ended by {signal.Signals(ended.number).name}", file=sys.stderr)
        return SIGNALLED + ended.number
    except BrokenPipeError:
        _give_up_output()
    except OSError as failed:  # disk full, no permission, missing program
        if failed.filename is None:
            print(f"error: cannot write the output: {failed.strerror}", file=sys.stderr)
            _give_up_output()
            return NOT_DONE
        print(f"error: cannot use '{failed.filename}': {failed.strerror}", file=sys.stderr)
        if isinstance(failed, FileNotFoundError):
            print(
                in_place("hint: if it is a program, install it with ./stator setup"),
                file=sys.stderr,
            )
    return NOT_DONE


def _give_up_output() -> None:
    """What is still to be written goes nowhere, so that Python does not try again at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.__stdout__, sys.__stderr__):
        if stream is not None:
            os.dup2(nowhere, stream.fileno())


def _run(argv: list[str]) -> int:
    parser = _parser(argv[0] if argv else "")
    if not argv:
        print(parser.format_help(), end="", file=sys.stderr)
        return NOT_DONE
    arguments = parser.parse_args(argv)
    status: int = arguments.run(arguments)
    return status


class _Parser(argparse.ArgumentParser):
    """Its messages name commands as the user types them in the current folder."""

    def _print_message(self, message: str, file: IO[str] | None = None) -> None:  # type: ignore[override]
        super()._print_message(in_place(message), file)


class _ShowVersion(argparse.Action):
    """Unlike argparse's own action, it asks git only if it is used."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from stator.version import version_text

        print(version_text())
        parser.exit()


def _parser(chosen: str) -> _Parser:
    """Imports only the chosen command, so that `check` starts fast. `completion` needs all."""
    parser = _Parser(prog="stator", description="Flight software from one YAML graph.")
    parser.add_argument(
        "--version",
        action=_ShowVersion,
        nargs=0,
        help="show the version, the commit and the schema",
    )
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, _, text in COMMANDS:
        command = commands.add_parser(name, help=text, description=text)
        if chosen in (name, "completion") and name != "setup":
            module = import_module(f"stator.commands.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.main)
    if chosen == "completion":
        parser.set_defaults(parser=parser)
    return parser


def _end(number: int, _: FrameType | None) -> None:
    raise Ended(number)


def _start() -> int:
    """As a program: with signals, and with all three standard streams."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:  # nohup ignores one
            signal.signal(number, _end)
    closed = sys.stdout is None
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if closed:
        print("error: cannot write the output: standard output is closed", file=sys.stderr)
        return NOT_DONE
    return main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(_start())
