"""The image of a graph: build, check, file formats, and the size of each part."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

from stator.build.cmake import build
from stator.build.px4_file import write_px4
from stator.diagnostics import BuildFailed
from stator.image.checks import faults_of
from stator.image.handlers import stack_of_graph
from stator.pipeline import make_buildable_plan
from stator.plan.hash import graph_hash
from stator.processes import environment

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stator.plan.plan import Plan

TOOLS = "arm-none-eabi-"


def build_image(graph: Path, board: str | None, variant: Mapping[str, str] | None = None) -> Path:
    """Builds the image for bare metal. Raises `BuildFailed` if it breaks a rule of images."""
    image = build(graph, board, variant, executor="cortex_m")
    plan = make_buildable_plan(str(graph), board)
    stack = stack_of_graph(plan, image)
    faults = [*faults_of(image, plan.graph.nodes), *stack.faults, *stack.overflows()]
    if faults:
        raise BuildFailed("\n".join(faults))
    return image


def total_of(image: Path) -> tuple[int, int]:
    """Bytes of flash and RAM, without the stack."""
    lines = subprocess.run(
        [TOOLS + "size", "-A", image],
        env=environment(),
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    size = {line.split()[0]: int(line.split()[1]) for line in lines if line.startswith(".")}
    return size[".text"] + size[".data"], size[".data"] + size[".bss"]


def image_files(plan: Plan, image: Path) -> dict[str, Path]:
    """The image in all file formats; .px4, for ground stations, only if the board has an id."""
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
    command = [TOOLS + "objcopy", "-O", kind, str(image), str(result)]
    subprocess.run(command, env=environment(), check=True)
    return result


# The part that a symbol belongs to: by its namespace, else by its source file, else by its name.
_NAMESPACES = (
    (r"stator::tasks::(\w+)::", r"\1"),
    (r"stator::topics::", "topics"),
    (r"stator::board::", "board"),
    (r"stator::math::", "runtime/math"),
    (r"^stator_fault_stack$", "runtime/cortex_m"),
)
_FOLDERS = (
    (r"/generated/graph_program/tasks/(\w+)\.cpp", r"\1"),
    (r"/generated/", "generated"),
    (r"/apps/(\w+)/", r"\1"),
    (r"/drivers/(\w+)/(\w+)/", r"\1_\2"),
    (r"/runtime/(\w+)/", r"runtime/\1"),
    (r"/boards/", "board"),
    (r"/Eigen/", "Eigen"),
)
_OTHERS = ((r"^stator_vectors$|^stator::", "generated"), (r"", "compiler's libraries"))
_SYMBOL = re.compile(
    r"^[0-9a-f]+ (?P<bytes>[0-9a-f]+) (?P<kind>\w) (?P<name>[^\t]+)(\t(?P<file>.*):\d+)?$"
)


def sizes_of(image: Path) -> dict[str, tuple[int, int]]:
    """Bytes of flash and RAM of each part, the largest first. The compiler inlines nodes into their
    tasks, so a task's part includes its node. Initialised data takes both flash and RAM. The last
    part holds texts, which have no symbols, and gaps. The stack is not included."""
    found: dict[str, list[int]] = {}
    for match in map(_SYMBOL.match, _symbols(image)):
        if match is None or match["kind"] in "aAN":
            continue
        part = found.setdefault(_part(match["name"], match["file"] or ""), [0, 0])
        size = int(match["bytes"], 16)
        part[0] += size if match["kind"] not in "bB" else 0
        part[1] += size if match["kind"] in "bBdD" else 0
    sizes = sorted(found.items(), key=lambda item: (-item[1][0], item[0]))
    rest = [total - sum(s[i] for _, s in sizes) for i, total in enumerate(total_of(image))]
    return {name: (flash, ram) for name, (flash, ram) in [*sizes, ("texts and gaps", rest)]}


def _symbols(image: Path) -> list[str]:
    command = [TOOLS + "nm", "-S", "-l", "-C", "--defined-only", str(image)]
    finished = subprocess.run(
        command, env=environment(), check=True, capture_output=True, text=True
    )
    return finished.stdout.splitlines()


def _part(name: str, file: str) -> str:
    """The part that a symbol belongs to."""
    known = [(pattern, name, part) for pattern, part in _NAMESPACES]
    known += [(pattern, file, part) for pattern, part in _FOLDERS]
    known += [(pattern, name, part) for pattern, part in _OTHERS]
    matches = ((re.search(pattern, text), part) for pattern, text, part in known)
    return next(match.expand(part) for match, part in matches if match)
