"""The command line. Each command imports what it needs when it runs: `check` starts fast."""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from stator.diagnostics import (
    INTERRUPTED,
    NOT_DONE,
    Failed,
    UserError,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from stator.plan import Plan

COMMANDS = {
    "check": "check a graph and show what it needs",
    "gen": "write the C++ of a graph",
    "graph": "draw a graph",
    "explain": "say why a node runs when and where it does",
    "new": "write a new app or graph",
    "fly": "fly a graph in simulation and report",
    "run": "run a graph in real time on this machine and report",
    "build": "build a graph's firmware and show what it takes",
    "flash": "put a graph's firmware onto a board",
    "emulate": "fly a graph's firmware in an emulator and report",
    "top": "show what each task of a running vehicle does",
    "listener": "print samples of a topic of a running vehicle",
    "perf": "show measurements of a running vehicle beside their bounds",
    "plot": "draw a flight from its log",
    "replay": "repeat a recorded flight and compare every sample",
    "score": "score an estimator on recordings",
    "bench": "measure against peers, as ratios within one run",
    "test": "run every test",
    "lint": "check format and style",
    "schema": "print the JSON Schema of graph files, for editors",
    "setup": "install what is missing",
}
# Commands that have a module of their own, and those that read their arguments themselves.
MODULES = {
    "check": "stator.check_command",
    "gen": "stator.gen",
    "graph": "stator.picture",
    "explain": "stator.explain",
    "new": "stator.new",
    "fly": "stator.fly",
    "run": "stator.run",
    "build": "stator.firmware",
    "flash": "stator.flash",
    "emulate": "stator.emulate",
    "top": "stator.top",
    "listener": "stator.listener",
    "perf": "stator.perf",
    "plot": "stator.plot",
    "replay": "stator.replay",
    "score": "stator.score",
    "bench": "stator.bench",
    "schema": "stator.schema",
}
RAW = {"test": "stator.run_tests", "lint": "stator.lint"}


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
    except OSError as failed:  # of this machine: no room, no permission, no program
        print(f"error: cannot use '{failed.filename}': {failed.strerror}", file=sys.stderr)
        if isinstance(failed, FileNotFoundError):
            print("hint: if it is a program, ./stator setup installs it", file=sys.stderr)
        return NOT_DONE


def _run(argv: list[str]) -> int:
    if argv and argv[0] in RAW:
        run: Callable[[list[str]], int] = import_module(RAW[argv[0]]).main
        return run(argv[1:])
    parser = _parser(argv[0] if argv else "")
    if not argv:
        print(parser.format_help(), end="", file=sys.stderr)
        return NOT_DONE
    arguments = parser.parse_args(argv)
    command: Callable[[argparse.Namespace], int] = arguments.run
    return command(arguments)


def _parser(chosen: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="stator", description="Flight software from one YAML graph."
    )
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text)
        if name != chosen:
            continue
        if name in MODULES:
            module = import_module(MODULES[name])
            module.add_arguments(command)
            command.set_defaults(run=module.main)
    return parser


def make_plan(graph: str, board: str | None) -> Plan:
    """Checks and plans the graph file. Raises `Failed`."""
    from stator.check import check
    from stator.plan import plan

    return plan(*check(Path(graph), board))


def make_buildable_plan(graph: str, board: str | None) -> Plan:
    """The plan for a board whose executor there is. Raises `Failed` or `UserError`."""
    from stator.emit import EXECUTORS

    plan = make_plan(graph, board)
    if plan.board.executor not in EXECUTORS:
        raise UserError(
            f"error: board '{plan.board.name}' runs on the executor {plan.board.executor}, which "
            "this version cannot build\nhint: add --board sitl"
        )
    return plan


def path(text: str) -> Path:
    """An argument that names a file or folder."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


def show_errors(failed: Failed) -> None:
    shown = failed.errors[:100]
    print("\n\n".join(error.text() for error in shown), file=sys.stderr)
    count = len(failed.errors)
    more = f", {count - len(shown)} not shown" if count > len(shown) else ""
    print(f"\n{count} error{'s' if count > 1 else ''}{more}; nothing was written", file=sys.stderr)


def add_graph_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", help="a graph file, such as graph/quad.yaml")
    parser.add_argument("--board", help="bind the devices of this board instead of the graph's own")


def unbound_devices(plan: Plan) -> list[str]:
    """Those that the graph uses and its board has no driver for."""
    used = {task.node.device for task in plan.tasks}
    return [d.name for d in plan.board.devices.values() if d.driver == "none" and d.name in used]


def show_notes(plan: Plan) -> None:
    unbound = unbound_devices(plan)
    if unbound:
        print(
            f"note: no driver yet on {plan.board.name} for: {', '.join(unbound)}; "
            "these publish nothing there"
        )
    if plan.replanned:
        print(
            f"note: {plan.board.name} cannot keep the order of {plan.graph.board.name}; "
            "planned anew, with another hash"
        )
