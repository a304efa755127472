"""The command line. Each command imports what it needs when it runs: `check` starts fast."""

from __future__ import annotations

import argparse
import json
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from stator.diagnostics import (
    ANSWER_IS_NO,
    INTERRUPTED,
    NOT_DONE,
    Failed,
    UserError,
    shown_path,
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
        elif name in _HERE:
            add_arguments, run = _HERE[name]
            add_arguments(command)
            command.set_defaults(run=run)
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


# --- check ---


def _graph_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", help="a graph file, such as graph/quad.yaml")
    parser.add_argument("--board", help="bind the devices of this board instead of the graph's own")


def _check_arguments(parser: argparse.ArgumentParser) -> None:
    _graph_arguments(parser)
    parser.add_argument("--plan", action="store_true", help="show the whole plan")
    parser.add_argument("--json", action="store_true", help="print what programs read")


def _check(arguments: argparse.Namespace) -> int:
    try:
        plan = make_plan(arguments.graph, arguments.board)
    except Failed as failed:
        if arguments.json:
            print(json.dumps({"errors": [error.as_json() for error in failed.errors]}, indent=2))
        else:
            show_errors(failed)
        return ANSWER_IS_NO
    if arguments.json:
        from stator.graph_hash import graph_hash

        print(
            json.dumps(
                {
                    "errors": [],
                    "graph": plan.graph.name,
                    "board": plan.board.name,
                    "nodes": len(plan.tasks),
                    "topics": len(plan.topics),
                    "hash": graph_hash(plan),
                },
                indent=2,
            )
        )
        return 0
    if arguments.plan:
        from stator.plan_text import plan_text

        print(plan_text(plan), end="")
        return 0
    levels = len({task.level for task in plan.tasks})
    slot_bytes = sum(t.message.bytes * t.slots for t in plan.topics.values())
    print(
        f"{shown_path(plan.graph.file)}: good: {_count(len(plan.tasks), 'node')} on "
        f"{_count(levels, 'level')}, {_count(len(plan.topics), 'topic')} in {slot_bytes} bytes of "
        f"slots, board {plan.board.name}"
    )
    show_notes(plan)
    return 0


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


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


# --- gen ---


def _gen_arguments(parser: argparse.ArgumentParser) -> None:
    _graph_arguments(parser)
    parser.add_argument(
        "-o", "--output", required=True, metavar="DIR", type=path, help="where to write"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--record", action="store_true", help="with a recording of each flight")
    what.add_argument("--replay", action="store_true", help="a program that replays recordings")


def _gen(arguments: argparse.Namespace) -> int:
    from stator.emit import emit, emit_replay, write

    if arguments.replay:
        files = emit_replay(make_plan(arguments.graph, arguments.board))
    else:
        plan = make_buildable_plan(arguments.graph, arguments.board)
        files = emit(plan, record=arguments.record)
    changed = write(files, arguments.output)
    print(f"{arguments.output}: {len(files)} files, {changed} changed")
    return 0


# --- explain, graph, schema ---


def _explain_arguments(parser: argparse.ArgumentParser) -> None:
    _graph_arguments(parser)
    parser.add_argument("node", help="a node or a topic of the graph")


def _explain(arguments: argparse.Namespace) -> int:
    from stator.diagnostics import nearest
    from stator.explain import explain

    plan = make_plan(arguments.graph, arguments.board)
    lines = explain(plan, arguments.node)
    if lines is None:
        known = [*plan.graph.nodes, *plan.topics]
        raise UserError(
            f"error: '{arguments.node}' is no node and no topic of {plan.graph.name}\n"
            f"hint: {nearest(arguments.node, known)}"
        )
    print("\n".join(lines))
    return 0


def _picture_arguments(parser: argparse.ArgumentParser) -> None:
    _graph_arguments(parser)
    parser.add_argument(
        "-o", "--output", required=True, metavar="FILE", type=path, help=".svg, .png or .dot"
    )


def _picture(arguments: argparse.Namespace) -> int:
    from stator.picture import draw

    draw(make_plan(arguments.graph, arguments.board), arguments.output)
    print(f"{arguments.output}: drawn")
    return 0


def _schema_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--reference", action="store_true", help="print docs/reference.md, for people, instead"
    )


def _schema(arguments: argparse.Namespace) -> int:
    from stator.json_schema import graph_schema

    if arguments.reference:
        from stator.reference import reference

        print(reference(), end="")
        return 0

    print(json.dumps(graph_schema(), indent=2))
    return 0


_HERE: dict[
    str, tuple[Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]
] = {
    "check": (_check_arguments, _check),
    "gen": (_gen_arguments, _gen),
    "explain": (_explain_arguments, _explain),
    "graph": (_picture_arguments, _picture),
    "schema": (_schema_arguments, _schema),
}
