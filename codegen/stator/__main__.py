"""`./stator`: the parser, and the one table of commands."""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from typing import Any, NamedTuple

from stator.diagnostics import INTERRUPTED, NOT_DONE, Failed, UserError, show_errors


class Command(NamedTuple):
    """A command; its code is `commands/NAME.py`. ./stator reads these rows too, so write one row a
    line."""

    name: str
    packages: str  # of requirements-apt.txt: "", one name, "host" (all except Arm's) or "all"
    help: str


COMMANDS = (
    Command("check", "", "check a graph and show its plan"),
    Command("gen", "", "write the C++ of a graph"),
    Command("graph", "graphviz", "draw a graph"),
    Command("explain", "", "explain when a node runs, and why"),
    Command("new", "", "write a new app or graph"),
    Command("fly", "host", "fly a graph in simulation and judge the flight"),
    Command("run", "host", "run a graph in real time on this machine"),
    Command("build", "all", "build the firmware of a graph and show its size"),
    Command("flash", "all", "write the firmware of a graph to a board"),
    Command("emulate", "all", "fly the firmware of a graph in an emulator"),
    Command("top", "", "show the tasks of a running vehicle"),
    Command("listener", "", "print the samples of a topic of a running vehicle"),
    Command("perf", "", "show the measured times of a running vehicle beside their bounds"),
    Command("plot", "", "draw plots of a flight from its log"),
    Command("replay", "host", "repeat a recorded flight and compare every sample"),
    Command("score", "host", "score an estimator on recorded sensor data"),
    Command("bench", "host", "compare speed with other software, as ratios within one run"),
    Command("test", "all", "run all tests"),
    Command("lint", "host", "check the format and style of the code"),
    Command("schema", "", "print the JSON Schema of graph files, for editors"),
    Command("completion", "", "print the completion of this command line for a shell"),
    Command("setup", "all", "install missing tools and packages"),  # done by ./stator itself
)


def main(argv: list[str]) -> int:
    """Runs one command; returns the exit status: see diagnostics.py."""
    try:
        return _run(argv)
    except Failed as failed:
        show_errors(failed)
        return NOT_DONE
    except UserError as failed:
        print(failed, file=sys.stderr)
        return NOT_DONE
    except KeyboardInterrupt:
        print("stator: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()
        return NOT_DONE
    except OSError as failed:  # disk full, no permission, missing program
        print(f"error: cannot use '{failed.filename}': {failed.strerror}", file=sys.stderr)
        if isinstance(failed, FileNotFoundError):
            print("hint: if it is a program, install it with ./stator setup", file=sys.stderr)
        return NOT_DONE


def _run(argv: list[str]) -> int:
    parser = _parser(argv[0] if argv else "")
    if not argv:
        print(parser.format_help(), end="", file=sys.stderr)
        return NOT_DONE
    arguments = parser.parse_args(argv)
    status: int = arguments.run(arguments)
    return status


class _ShowVersion(argparse.Action):
    """Unlike argparse's own action, it asks git only if it is used."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from stator.version import version_text

        print(version_text())
        parser.exit()


def _parser(chosen: str) -> argparse.ArgumentParser:
    """Imports only the chosen command, so that `check` starts fast. `completion` needs all."""
    parser = argparse.ArgumentParser(
        prog="stator", description="Flight software from one YAML graph."
    )
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


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
