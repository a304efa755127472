"""`./stator gen`: writes the C++ of a graph."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments, path
from stator.emit.emit import write
from stator.pipeline import make_app_files, make_files, make_replay_files

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "-o", "--output", required=True, metavar="DIR", type=path, help="folder to write to"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--record", action="store_true", help="record each flight for replay")
    what.add_argument(
        "--apps",
        metavar="NAME,...",
        help="write what unit tests of these apps need; GRAPH is the folder of apps/",
    )
    what.add_argument(
        "--replay", action="store_true", help="write a program that replays recordings"
    )


def main(arguments: argparse.Namespace) -> int:
    if arguments.apps:
        files = make_app_files(Path(arguments.graph), arguments.apps.split(","))
    elif arguments.replay:
        files = make_replay_files(arguments.graph, arguments.board)
    else:
        files = make_files(arguments.graph, arguments.board, record=arguments.record)
    changed = write(files, arguments.output)
    print(f"{arguments.output}: {len(files)} files, {changed} changed")
    return 0
