"""What each task took at most in an emulated flight, as the firmware prints it at its end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stator.emulator.qemu import SHIFT
from stator.plan.text import text_table

if TYPE_CHECKING:
    from stator.plan.plan import Plan

FIGURES = "figures"  # boards/qemu_f405/link.hpp
_HEAD = "stator: task "


def printed_rows(console: str) -> list[list[int]]:
    """What the firmware printed: of each task its activations, and the longest execution and
    response, in ticks of its clock and in microseconds."""
    return [
        [int(word, 16) for word in line.removeprefix(_HEAD).split()]
        for line in console.splitlines()
        if line.startswith(_HEAD)
    ]


def figures_of(rows: list[list[int]], plan: Plan, tick_hz: int) -> list[dict[str, Any]]:
    """`rows`: in the order of the plan."""
    instructions_hz = 1_000_000_000 >> SHIFT
    return [
        {
            "task": task.node.name,
            "activations": activations,
            "instructions": round(ticks * instructions_hz / tick_hz),
            "response_us": latest_us if plan.is_timed(task.node.name) else None,
        }
        for task, (activations, ticks, latest_us) in zip(plan.tasks, rows, strict=True)
    ]


def figures_text(figures: list[dict[str, Any]]) -> str:
    rows = [("task", "activations", "most instructions", "longest response")]
    for row in figures:
        response = row["response_us"]
        shown = "" if response is None else f"{response} us"
        rows.append((row["task"], f"{row['activations']:,}", f"{row['instructions']:,}", shown))
    return "\n".join(text_table(rows)) + "\n"
