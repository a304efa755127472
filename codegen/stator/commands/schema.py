"""`./stator schema`: prints the description of the language, for editors or for people."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from stator.schema.json_schema import graph_schema
from stator.schema.reference import reference

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--reference", action="store_true", help="print docs/reference.md, for people"
    )


def main(arguments: argparse.Namespace) -> int:
    if arguments.reference:
        print(reference(), end="")
        return 0
    print(json.dumps(graph_schema(), indent=2))
    return 0
