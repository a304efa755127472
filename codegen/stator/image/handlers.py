"""The handlers of an image and their levels: its vector table, and the plan of its graph."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.emit.cortex_m import program
from stator.image.functions import Memory
from stator.image.stack import THREAD, Root, Stack, stack_of
from stator.image.tools import addresses

if TYPE_CHECKING:
    from pathlib import Path

    from stator.plan.plan import Plan

# ARMv7-M, B1.5.2: the stack pointer, the reset, faults and calls, SysTick; then the chip's vectors.
RESET, FAULTS, SYSTICK, CHIP = 1, range(2, 15), 15, 16
BOARD_LEVEL = 16  # hardware priority 0, above every level of a graph
WORD = 4


def stack_of_graph(plan: Plan, image: Path) -> Stack:
    rows = program(plan)
    table, memory = addresses(image)["stator_vectors"], Memory(image)
    handler = [(memory.read(table + WORD * i, WORD) or 0) & ~1 for i in range(CHIP)]
    faults = {handler[i] for i in FAULTS}
    levels = {row.vector: (row.level, row.name) for row in rows.interrupts}
    roots = [
        Root(THREAD, handler[RESET], "start and monitor"),
        Root(rows.timer_level, handler[SYSTICK], "the timer's handler"),
    ]
    for row in rows.vectors:
        at = (memory.read(table + WORD * (CHIP + row.number), WORD) or 0) & ~1
        if at not in faults:
            level, name = levels.get(row.number, (BOARD_LEVEL, f"interrupt {row.name}"))
            roots.append(Root(level, at, name))
    return stack_of(image, roots, sorted(faults))
