"""`./stator graph`: draws a graph with Graphviz."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments, path
from stator.charts.graph import View, draw
from stator.pipeline import make_plan

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="FILE",
        type=path,
        help="picture to write: .svg, .png or .dot",
    )

    parser.add_argument(
        "--around", metavar="NODE", help="draw only this node and those that share a topic with it"
    )
    parser.add_argument(
        "--wakes",
        action="store_true",
        help="draw only what wakes a node, not what it reads besides",
    )
    parser.add_argument("--dark", action="store_true", help="light text on a dark background")


def main(arguments: argparse.Namespace) -> int:
    view = View(arguments.around, arguments.wakes, arguments.dark)
    draw(make_plan(arguments.graph, arguments.board), arguments.output, view)
    print(f"{arguments.output}: written")
    return 0
