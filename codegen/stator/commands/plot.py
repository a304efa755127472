"""`./stator plot`: draws a flight as one picture, or topics of its log over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.arguments import path
from stator.diagnostics import shown_path
from stator.flight.plot import FORMATS, draw

if TYPE_CHECKING:
    import argparse
    from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "log", type=path, help="ULog file, for example build/flights/quad-seed1.ulg"
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="TOPIC[.FIELD]",
        help="draw this over time, instead of the flight; use it once for each panel",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="FILE",
        help=f"picture to write: {', '.join(FORMATS)} (default: a .png beside the log)",
    )


def main(arguments: argparse.Namespace) -> int:
    output: Path = arguments.output or arguments.log.with_suffix(".png")
    if arguments.topic:
        from stator.charts.topics import draw_topics

        if arguments.output is None:
            output = output.with_name(f"{arguments.log.stem}.topics.png")
        draw_topics([arguments.log], arguments.topic, output)
    else:
        draw(arguments.log, output)
    print(f"{shown_path(output)}: written")
    return 0
