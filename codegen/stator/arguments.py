"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any


def path(text: str) -> Path:
    """An argument that names a file or folder."""
    if not text:
        raise argparse.ArgumentTypeError("expected a path, found nothing")
    return Path(text)


def add_graph_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", help="graph file, for example graph/quad.yaml")
    parser.add_argument("--board", help="build for this board instead of the graph's own")


def add_verbose_argument(parser: argparse.ArgumentParser) -> None:
    """For commands that build."""
    parser.add_argument(
        "--verbose",
        action=_Verbose,
        nargs=0,
        help="show the output of the build, with the compiler's command lines",
    )


class _Verbose(argparse.Action):
    """For this process, and for those that it starts."""

    def __call__(self, *_: Any) -> None:
        os.environ["STATOR_VERBOSE"] = "on"
