"""What `./stator build` does: the image of a graph, checked, and what each part takes."""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from stator.build import SLEEP, build
from stator.cli import make_buildable_plan, path
from stator.diagnostics import BuildFailed, UserError, shown_path
from stator.graph_hash import graph_hash
from stator.image_checks import faults_of
from stator.px4_file import write_px4

if TYPE_CHECKING:
    from stator.plan import Plan

TOOLS = "arm-none-eabi-"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", type=path, help="a graph file, such as graph/quad.yaml")
    parser.add_argument("--board", help="another board than the graph's own")
    parser.add_argument("--sleep", action="store_true", help="sleep when idle, instead of spinning")
    parser.add_argument("--json", action="store_true", help="print what programs read")


def main(arguments: argparse.Namespace) -> int:
    try:
        image = build_image(arguments.graph, arguments.board, sleep=arguments.sleep)
    except UserError as failed:
        print(failed, file=sys.stderr)
        return 2
    files = image_files(make_buildable_plan(str(arguments.graph), arguments.board), image)
    sizes = sizes_of(image.with_name(image.name + ".map"))
    total = total_of(image)
    if arguments.json:
        facts: dict[str, object] = {key: str(file) for key, file in files.items()}
        facts |= {"flash_bytes": total[0], "ram_bytes": total[1]}
        facts["parts"] = {
            name: dict(zip(("flash_bytes", "ram_bytes"), size, strict=True))
            for name, size in sizes.items()
        }
        print(json.dumps(facts, indent=2))
        return 0
    width = max(map(len, sizes))
    print(f"{'':{width}}  {'flash':>8}  {'ram':>8}")
    for name, size in [*sizes.items(), ("image", total)]:
        print(f"{name:{width}}  {size[0]:8,}  {size[1]:8,}")
    print("\n".join(f"{shown_path(file)}" for file in files.values()))
    return 0


def build_image(graph: Path, board: str | None, *, sleep: bool = False) -> Path:
    """The graph's image for bare metal. Raises `BuildFailed` if it holds what no image may."""
    image = build(graph, board, SLEEP if sleep else None, executor="cortex_m")
    faults = faults_of(image)
    if faults:
        raise BuildFailed("\n".join(f"error: {fault}" for fault in faults))
    return image


def total_of(image: Path) -> tuple[int, int]:
    """Bytes of flash and RAM. Parts may add up to a little more: the linker merges equal texts."""
    lines = subprocess.run(
        [TOOLS + "size", "-A", image], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    size = {line.split()[0]: int(line.split()[1]) for line in lines if line.startswith(".")}
    return size[".text"] + size[".data"], size[".data"] + size[".bss"]


def image_files(plan: Plan, image: Path) -> dict[str, Path]:
    """The image in the forms that tools want; for a ground station, if the board has an id."""
    files = {
        "elf": image,
        "bin": _convert(image, "binary", ".bin"),
        "hex": _convert(image, "ihex", ".hex"),
    }
    if plan.board.upload is not None:
        files["px4"] = image.with_name(f"{plan.graph.name}.px4")
        write_px4(plan, files["bin"].read_bytes(), files["px4"], graph_hash(plan))
    return files


def _convert(image: Path, kind: str, suffix: str) -> Path:
    result = image.with_suffix(suffix)
    subprocess.run([TOOLS + "objcopy", "-O", kind, image, result], check=True)
    return result


_SECTION = re.compile(
    r"^ (\.[\w.]*|COMMON)\S*\s+0x([0-9a-f]{8,16})\s+0x([0-9a-f]+)\s+(\S.*)$", re.MULTILINE
)


def sizes_of(map_file: Path) -> dict[str, tuple[int, int]]:
    """Bytes of flash and RAM of each part, the largest first, from the linker's map. Initialised
    data takes both; the stack is not in it."""
    text = map_file.read_text(encoding="utf-8")
    text = text[text.index("Linker script and memory map") :].replace("\n                ", " ")
    found: dict[str, list[int]] = {}
    for section, address, size, file in _SECTION.findall(text):
        if int(address, 16) == 0 or section.startswith((".debug", ".comment", ".ARM")):
            continue
        part = found.setdefault(_part(file), [0, 0])
        kind = section.split(".")[1] if "." in section else "bss"
        part[0] += int(size, 16) if kind != "bss" else 0
        part[1] += int(size, 16) if kind in ("bss", "data") else 0
    return {
        name: (sizes[0], sizes[1])
        for name, sizes in sorted(found.items(), key=lambda item: (-item[1][0], item[0]))
    }


def _part(file: str) -> str:
    """The folder that an object file comes from, as a person calls it."""
    library = re.search(r"lib(graph_program_|stator_)?(\w+)\.a\(", file)
    if library:
        prefix, name = library.groups()
        names = {"graph_program_": name, "stator_": f"runtime/{name}"}
        return names.get(prefix, "compiler's libraries")
    if "graph_program_generated" in file:
        return "generated"
    return "board" if "/boards/" in file else "compiler's libraries"
