"""Rows of what bare metal needs besides the tasks: vectors and their handlers, lines, memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import UserError
from stator.emit.rows import VECTOR_WORD_BITS, watched
from stator.plan.hash import graph_hash
from stator.plan.plan import vector_of

if TYPE_CHECKING:
    from stator.emit.rows import Row
    from stator.graph.model import Device
    from stator.plan.plan import Plan, Task

LOWEST_LEVEL = 1
MEMORIES = ("flash", "ram", "ccm")


def program(plan: Plan) -> Row:
    chip = plan.board.chip
    assert chip is not None
    dispatchers = _dispatchers(plan)
    handlers = {task.vector: f"tasks::{task.node.name}::run" for task in plan.tasks}
    handlers |= {row["vector"]: row["handler"] for row in dispatchers}
    handlers |= {chip.vectors[name]: f"board::{name}_interrupt" for name in plan.board.interrupts}
    names = {number: name for name, number in chip.vectors.items()}
    periodic = [t.level for t in plan.tasks if any(i.kind == "every" for i in t.node.triggers)]
    levels = [(task.vector, task.level, task.node.name) for task in plan.tasks]
    levels += [(row["vector"], row["level"], row["comment"]) for row in dispatchers]
    return {
        "dispatchers": dispatchers,
        # Once each, however many vectors raise a line.
        "taken_lines": list(
            dict.fromkeys(
                f"{line['device']}_{line['line']}" for row in dispatchers for line in row["lines"]
            )
        ),
        "board_interrupts": plan.board.interrupts,
        "vectors": [
            {
                "number": number,
                "handler": handlers.get(number, "stator_fault"),
                "name": names.get(number, "not on this chip"),
            }
            for number in range(max(names) + 1)
        ],
        "interrupts": [
            {"vector": vector, "level": level, "name": name} for vector, level, name in levels
        ],
        "timer_level": max(periodic, default=LOWEST_LEVEL),
        "task_count": len(plan.tasks),
        "clock_hz": chip.clock_hz,
        "watched": watched(plan),
        "topics": list(plan.topics),
        "board": plan.board.name,
        "graph": plan.graph.name,
        "graph_hash": graph_hash(plan),
    }


def _dispatchers(plan: Plan) -> list[Row]:
    """The handlers of lines that share a vector, or whose task has other triggers, too."""
    assert plan.board.chip is not None
    names = {number: name for name, number in plan.board.chip.vectors.items()}
    found: dict[int, Row] = {}
    for task in plan.tasks:
        for trigger, device, vector in _wires(plan, task):
            if vector == task.vector or device.driver == "none":
                continue
            # Tasks come most urgent first, so that the first one gives the level.
            name = names[vector]
            row = found.setdefault(
                vector,
                {
                    "vector": vector,
                    "handler": f"dispatch_{name}",
                    "level": task.level,
                    "comment": f"lines of {name}",
                    "lines": [],
                },
            )
            row["lines"].append(
                {
                    "node": task.node.name,
                    "device": device.name,
                    "line": trigger[0],
                    "min_interarrival_us": trigger[1],
                }
            )
    return [found[vector] for vector in sorted(found)]


def _wires(plan: Plan, task: Task) -> list[tuple[tuple[str, int], Device, int]]:
    """The lines that trigger a task: name and least time between two, device, vector."""
    assert plan.board.chip is not None
    if task.node.device is None:
        return []
    device = plan.board.devices[task.node.device]
    return [
        (
            (t.name, t.min_interarrival_us or 0),
            device,
            plan.board.chip.vectors[vector_of(wire)],
        )
        for t in task.node.triggers
        if t.kind == "irq"
        for wire in device.lines[t.name]
    ]


def lines(plan: Plan) -> list[Row]:
    """The bit of each line of the board's bound devices; of the first of several wires."""
    assert plan.board.chip is not None
    return [
        {"name": f"{device.name}_{line}", "wire": wires[0], **_bit(plan, vector_of(wires[0]))}
        for device in plan.board.devices.values()
        if device.driver != "none"
        for line, wires in device.lines.items()
    ]


def _bit(plan: Plan, name: str) -> Row:
    assert plan.board.chip is not None
    number = plan.board.chip.vectors[name]
    return {"word": number // VECTOR_WORD_BITS, "mask": f"{1 << number % VECTOR_WORD_BITS:#x}"}


def image(plan: Plan) -> Row:
    """The memories of the linker script. Raises `UserError` if the chip's file lacks one."""
    assert plan.board.chip is not None
    missing = [name for name in MEMORIES if name not in plan.board.chip.memory]
    if missing:
        raise UserError(
            f"error: missing memory {', '.join(missing)} of chip {plan.board.chip.name}\n"
            f'hint: add `memory: {{{missing[0]}: {{at: "0x20000000", bytes: 131072}}}}` to its file'
        )
    return {
        name: {"at": f"{memory.at:#010x}", "bytes": memory.bytes}
        for name, memory in plan.board.chip.memory.items()
    }
