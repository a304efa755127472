"""Arguments that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path


def path(text: str) -> Path:
    """An argument that names a file or folder."""
    if not text:
        raise argparse.ArgumentTypeError("expected a path, found nothing")
    return Path(text)


def add_graph_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", help="graph file, for example graph/quad.yaml")
    parser.add_argument("--board", help="build for this board instead of the graph's own")
