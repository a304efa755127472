"""Arguments of the commands that talk to something that runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stator.live.place import DEFAULT

if TYPE_CHECKING:
    import argparse


def add_link_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--link",
        type=Path,
        default=DEFAULT,
        metavar="PATH",
        help="socket or serial port of what runs (default: that of run, or of emulate --link)",
    )
    parser.add_argument(
        "--graph", type=Path, metavar="FILE", help="the graph's file, if it is none of Stator's own"
    )
    parser.add_argument("--json", action="store_true", help="print what programs read")
