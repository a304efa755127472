"""The stack and the memory of an image as text, and as facts for programs."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from stator.image.stack import FPU_FRAME, PLAIN_FRAME, THREAD
from stator.plan.text import text_table

if TYPE_CHECKING:
    from stator.image.memory import Memory, Sizes
    from stator.image.stack import Stack
    from stator.plan.plan import Plan

DEEPEST_SHOWN = 4  # functions of a way
PARTS = ("topics", "tasks", "apps", "drivers", "nodes", "others")


def stack_facts(stack: Stack) -> dict[str, Any]:
    return {
        "stack_bytes": stack.bytes,
        "stack_limit_bytes": stack.limit,
        "fault_stack_bytes": stack.fault[0],
        "fault_stack_limit_bytes": stack.fault[1],
        "stack": [
            {
                "level": row.root.level,
                "name": row.root.name,
                "bytes": row.bytes,
                "frame_bytes": row.with_frame - row.bytes,
                "deepest": list(row.path),
            }
            for row in stack.roots
        ],
    }


def memory_facts(plan: Plan, memory: Memory) -> dict[str, Any]:
    assert plan.board.chip is not None
    regions = plan.board.chip.memory
    facts: dict[str, Any] = {
        "flash_bytes": memory.total[0],
        "flash_limit_bytes": regions["flash"].bytes,
        "ram_bytes": memory.total[1],
        "ram_limit_bytes": regions["ram"].bytes,
    }
    for part in PARTS:
        facts[part] = {
            name: {"flash_bytes": sizes[0], "ram_bytes": sizes[1]}
            for name, sizes in getattr(memory, part).items()
        }
    return facts


def stack_text(stack: Stack) -> list[str]:
    """The worst handler of each level."""
    rows = [("level", "worst of it", "bytes", "frame", "deepest way")]
    for level in sorted({row.root.level for row in stack.roots}, reverse=True):
        worst = stack.worst_of(level)
        way = [_brief(name) for name in worst.path]
        shown = [*way[:DEEPEST_SHOWN], *(["..."] if len(way) > DEEPEST_SHOWN else [])]
        rows.append(
            (
                "thread" if level == THREAD else str(level),
                worst.root.name,
                f"{worst.bytes:,}",
                str(FPU_FRAME if worst.uses_fpu else PLAIN_FRAME),
                " > ".join(shown),
            )
        )
    return [
        *text_table(rows),
        f"stack {stack.bytes:,} of {stack.limit:,} bytes; of the fault handler "
        f"{stack.fault[0]:,} of {stack.fault[1]:,}",
    ]


def _brief(name: str) -> str:
    """The last two parts of a function's name, without the arguments of templates."""
    while name != (shorter := re.sub(r"<[^<>]*>", "", name)):
        name = shorter
    return "::".join(name.split(" ")[-1].split("::")[-2:])


def memory_text(plan: Plan, memory: Memory) -> list[str]:
    assert plan.board.chip is not None
    regions = plan.board.chip.memory
    rows = [("memory", "flash", "ram")]

    def add(name: str, sizes: Sizes) -> None:
        rows.append((name, f"{sizes[0]:,}", f"{sizes[1]:,}"))

    largest = sorted(memory.nodes.items(), key=lambda item: (-sum(item[1]), item[0]))
    for name, sizes in largest:
        add(name, sizes)
    topics = list(memory.topics.values())
    add(f"{len(topics)} topics", (sum(t[0] for t in topics), sum(t[1] for t in topics)))
    named = [*memory.tasks.values(), *memory.apps.values(), *memory.drivers.values(), *topics]
    rest = tuple(memory.total[i] - sum(sizes[i] for sizes in named) for i in (0, 1))
    add("runtime, board, libraries", (rest[0], rest[1]))
    add("image", memory.total)
    add("limit", (regions["flash"].bytes, regions["ram"].bytes))
    return text_table(rows)
