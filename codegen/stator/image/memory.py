"""How much flash and RAM each part of an image takes."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.image.tools import run

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from stator.plan.plan import Plan

Sizes = tuple[int, int]  # bytes of flash and RAM


def total_of(image: Path) -> tuple[int, int]:
    """Bytes of flash and RAM, without the stack."""
    lines = run("size", "-A", str(image)).splitlines()
    size = {line.split()[0]: int(line.split()[1]) for line in lines if line.startswith(".")}
    return size[".text"] + size[".data"], size[".data"] + size[".bss"]


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


def sizes_of(image: Path) -> dict[str, Sizes]:
    """Bytes of flash and RAM of each part, the largest first. The compiler inlines nodes into their
    tasks, so a task's part includes its node. Initialised data takes both flash and RAM. The last
    part holds texts, which have no symbols, and gaps. The stack is not included."""
    sizes = sorted(_summed(image, _part).items(), key=lambda item: (-item[1][0], item[0]))
    rest = [total - sum(s[i] for _, s in sizes) for i, total in enumerate(total_of(image))]
    return {name: (flash, ram) for name, (flash, ram) in [*sizes, ("texts and gaps", rest)]}


@dataclass(frozen=True)
class Memory:
    """Bytes of flash and RAM."""

    topics: dict[str, Sizes]
    tasks: dict[str, Sizes]  # with the code of their nodes that is inlined there
    apps: dict[str, Sizes]  # code of a folder that is not inlined, for all nodes of it
    drivers: dict[str, Sizes]  # likewise
    nodes: dict[str, Sizes]  # the task, and its app's or driver's part
    others: dict[str, Sizes]
    total: Sizes


def memory_of(plan: Plan, image: Path) -> Memory:
    parts = _summed(image, _kind)
    by_kind: dict[str, dict[str, Sizes]] = defaultdict(dict)
    for key, sizes in sorted(parts.items()):
        kind, _, name = key.partition(" ")
        by_kind[kind][name] = sizes
    nodes = {}
    for task in plan.tasks:
        node = task.node
        own = by_kind["task"].get(node.name, (0, 0))
        folder = by_kind["app"].get(node.interface.file.parent.name, (0, 0))
        if node.device is not None:
            driver = plan.board.devices[node.device].driver
            folder = by_kind["driver"].get(driver, (0, 0))
        nodes[node.name] = (own[0] + folder[0], own[1] + folder[1])
    return Memory(
        topics=by_kind["topic"],
        tasks=by_kind["task"],
        apps=by_kind["app"],
        drivers=by_kind["driver"],
        nodes=nodes,
        others=by_kind["other"],
        total=total_of(image),
    )


def _summed(image: Path, part_of: Callable[[str, str], str]) -> dict[str, Sizes]:
    found: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for match in map(_SYMBOL.match, _symbols(image)):
        if match is None or match["kind"] in "aAN":
            continue
        part = found[part_of(match["name"], match["file"] or "")]
        size = int(match["bytes"], 16)
        part[0] += size if match["kind"] not in "bB" else 0
        part[1] += size if match["kind"] in "bBdD" else 0
    return {name: (flash, ram) for name, (flash, ram) in found.items()}


def _kind(name: str, file: str) -> str:
    """What a symbol is of, and which."""
    for pattern, text, kind in (
        (r"stator::topics::(\w+?)(_parts)?(::|$)", name, "topic"),
        (r"stator::tasks::(\w+)::", name, "task"),
        (r"/generated/graph_program/tasks/(\w+)\.cpp", file, "task"),
        (r"stator::apps::(\w+)::", name, "app"),
        (r"/apps/(\w+)/", file, "app"),
    ):
        if match := re.search(pattern, text):
            return f"{kind} {match[1]}"
    driver = re.search(r"stator::drivers::(\w+)::(\w+)::", name)
    driver = driver or re.search(r"/drivers/(\w+)/(\w+)/", file)
    return f"driver {driver[1]}/{driver[2]}" if driver else f"other {_part(name, file)}"


def _symbols(image: Path) -> list[str]:
    return run("nm", "-S", "-l", "-C", "--defined-only", str(image)).splitlines()


def _part(name: str, file: str) -> str:
    """The part that a symbol belongs to."""
    known = [(pattern, name, part) for pattern, part in _NAMESPACES]
    known += [(pattern, file, part) for pattern, part in _FOLDERS]
    known += [(pattern, name, part) for pattern, part in _OTHERS]
    matches = ((re.search(pattern, text), part) for pattern, text, part in known)
    return next(match.expand(part) for match, part in matches if match)
