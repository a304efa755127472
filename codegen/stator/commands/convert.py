"""`./stator convert`: writes a flight's log for other tools."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from stator.arguments import path
from stator.convert.formats import FORMATS
from stator.convert.topics import topics_of
from stator.diagnostics import UserError, shown_path
from stator.flight.pictures import open_log

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "log", type=path, help="ULog file, for example build/flights/quad-seed1.ulg"
    )
    parser.add_argument(
        "--to",
        choices=FORMATS,
        required=True,
        help="mcap: one file for Foxglove, rosbag2 and PlotJuggler, with ROS 2 messages; csv, "
        "parquet: a folder with a table for each topic; plotjuggler, foxglove: a layout with the "
        "standard plots",
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="TOPIC",
        help="only this topic; use it once for each (default: all)",
    )
    parser.add_argument(
        "-o", "--output", type=path, metavar="PATH", help="what to write (default: beside the log)"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    form = FORMATS[arguments.to]
    log: Path = arguments.log
    output: Path = arguments.output or log.with_name(log.name.removesuffix(".ulg") + form.suffix)
    topics = topics_of(open_log(log), log, arguments.topic)
    try:
        form.write(topics, output)
    except OSError as error:
        raise UserError(
            f"error: cannot write '{error.filename or output}': {error.strerror}\n"
            "hint: name another place with -o"
        ) from None
    samples = sum(len(topic.time_us) for topic in topics)
    if arguments.json:
        facts = {"output": str(output.resolve()), "topics": len(topics), "samples": samples}
        print(json.dumps(facts, indent=2))
    else:
        print(f"{shown_path(output)}: written, {samples} samples of {len(topics)} topics")
    return 0
