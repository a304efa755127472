"""What `./stator gen` does: writes the C++ of a graph."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.cli import add_graph_arguments, make_buildable_plan, make_plan, path
from stator.emit import emit, emit_replay, write

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "-o", "--output", required=True, metavar="DIR", type=path, help="where to write"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--record", action="store_true", help="with a recording of each flight")
    what.add_argument("--replay", action="store_true", help="a program that replays recordings")


def main(arguments: argparse.Namespace) -> int:
    if arguments.replay:
        files = emit_replay(make_plan(arguments.graph, arguments.board))
    else:
        plan = make_buildable_plan(arguments.graph, arguments.board)
        files = emit(plan, record=arguments.record)
    changed = write(files, arguments.output)
    print(f"{arguments.output}: {len(files)} files, {changed} changed")
    return 0
