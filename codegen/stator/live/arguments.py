"""Arguments of the commands that talk to a running vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stator.live.place import DEFAULT

if TYPE_CHECKING:
    import argparse


def add_link_arguments(parser: argparse.ArgumentParser, *, has_json: bool = True) -> None:
    parser.add_argument(
        "--link",
        type=Path,
        default=DEFAULT,
        metavar="PATH",
        help="socket or serial port of the vehicle (default: the socket of run or emulate --link)",
    )
    parser.add_argument(
        "--graph",
        type=Path,
        metavar="FILE",
        help="graph file (default: the one that run or emulate has; for a serial port, one of "
        "Stator's own graphs)",
    )
    if has_json:
        parser.add_argument("--json", action="store_true", help="print the result as JSON")
