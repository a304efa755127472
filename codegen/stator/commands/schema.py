"""`./stator schema`: prints the description of the language, for editors or for people."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from stator.arguments import path
from stator.schema.json_schema import KINDS, schema
from stator.schema.reference import reference

if TYPE_CHECKING:
    import argparse
    from pathlib import Path


# Kind -> which files of a project are of this kind, for editors.
FILES = {
    "graph": "*.yaml",
    "message": "messages/*.yaml",
    "interface": "{apps,drivers}/*/*.yaml",
    "board": "boards/*/board.yaml",
    "budgets": "budgets/*.yaml",
    "failsafe": "apps/*/failsafe.yaml",
    "mission": "missions/*.yaml",
    "vehicle": "vehicles/*.yaml",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "kind",
        nargs="?",
        choices=sorted(KINDS),
        default="graph",
        help="kind of file (default: graph)",
    )
    parser.add_argument(
        "--folder",
        type=path,
        metavar="FOLDER",
        help="write the schemas of all kinds to this folder, and print the setting for an editor",
    )
    parser.add_argument(
        "--reference", action="store_true", help="print docs/reference.md, for people"
    )


def main(arguments: argparse.Namespace) -> int:
    if arguments.reference:
        print(reference(), end="")
    elif arguments.folder is not None:
        _write_all(arguments.folder)
    else:
        print(json.dumps(schema(arguments.kind), indent=2))
    return 0


def _write_all(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for kind in FILES:
        text = json.dumps(schema(kind), indent=2) + "\n"
        (folder / f"{kind}.json").write_text(text, encoding="utf-8")
    settings = {f"./{folder}/{kind}.json": [files] for kind, files in FILES.items()}
    print(json.dumps({"yaml.schemas": settings}, indent=2))
