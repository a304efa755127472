"""`./stator build`: builds and checks the image of a graph, and shows the size of each part."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from stator.arguments import add_verbose_argument, path
from stator.build.cmake import SLEEP
from stator.build.image import add_record_argument, build_image, image_files, recording_of
from stator.diagnostics import shown_path
from stator.image.checks import double_lines, sections_of
from stator.image.memory import sizes_of, total_of
from stator.pipeline import make_buildable_plan
from stator.plan.text import show_notes, unbound_devices
from stator.prove.gate import add_unproven_argument, is_for_a_vehicle, require_proof

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", type=path, help="graph file, for example graph/quad.yaml")
    parser.add_argument("--board", help="build for this board instead of the graph's own")
    parser.add_argument("--sleep", action="store_true", help="sleep when idle (default: busy loop)")
    add_record_argument(parser)
    add_unproven_argument(parser)
    add_verbose_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    plan = make_buildable_plan(str(arguments.graph), arguments.board)
    is_proven = require_proof(plan, unproven=arguments.unproven)
    variant = recording_of(plan) if arguments.record else {}
    variant |= SLEEP if arguments.sleep else {}
    image = build_image(arguments.graph, arguments.board, variant)
    files = image_files(plan, image, is_proven=is_proven)
    sizes = sizes_of(image)
    total = total_of(image)
    sections = sections_of(image)
    doubles = {
        name: {"lines": lines, "why": plan.graph.nodes[name].interface.double_precision}
        for name, lines in double_lines(image).items()
    }
    if arguments.json:
        facts: dict[str, object] = {key: str(file) for key, file in files.items()}
        facts |= {"flash_bytes": total[0], "ram_bytes": total[1]}
        facts["parts"] = {
            name: dict(zip(("flash_bytes", "ram_bytes"), size, strict=True))
            for name, size in sizes.items()
        }
        facts["sections"] = sections
        facts["double_precision"] = doubles
        facts["proven"] = is_proven if is_for_a_vehicle(plan) else None
        facts["unbound_devices"] = unbound_devices(plan)
        print(json.dumps(facts, indent=2))
        return 0
    width = max(map(len, sizes))
    print(f"{'':{width}}  {'flash':>8}  {'ram':>8}")
    for name, size in [*sizes.items(), ("image", total)]:
        print(f"{name:{width}}  {size[0]:8,}  {size[1]:8,}")
    for topic, operations in sections.items():
        longest = ", ".join(f"{name} {count}" for name, count in operations.items())
        print(f"critical sections of {topic} (instructions): {longest}")
    for name, fact in doubles.items():
        print(f"double precision in software: node {name}, {fact['lines']} lines: {fact['why']}")
    print("\n".join(f"{shown_path(file)}" for file in files.values()))
    show_notes(plan)
    if not is_proven:
        print("NOT PROVEN: any deadline may be missed; ./stator prove says why")
    return 0
