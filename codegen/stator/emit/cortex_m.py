"""Rows of what bare metal needs besides the tasks: vectors and their handlers, lines, memory."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stator.diagnostics import UserError
from stator.emit.rows import VECTOR_WORD_BITS, watched
from stator.plan.hash import graph_hash
from stator.plan.plan import vector_of

if TYPE_CHECKING:
    from stator.emit.rows import WatchedRow
    from stator.graph.model import Device
    from stator.plan.plan import Plan, Task

LOWEST_LEVEL = 1
MEMORIES = ("flash", "ram", "ccm")


@dataclass(frozen=True)
class DispatchedLine:
    node: str
    device: str
    line: str
    min_interarrival_us: int


@dataclass(frozen=True)
class Dispatcher:
    """The handler of a vector whose lines are not one task's alone."""

    vector: int
    handler: str
    level: int
    comment: str
    lines: list[DispatchedLine] = field(default_factory=list)


@dataclass(frozen=True)
class VectorRow:
    number: int
    handler: str
    name: str


@dataclass(frozen=True)
class InterruptRow:
    vector: int | None
    level: int
    name: str


@dataclass(frozen=True)
class CortexProgram:
    dispatchers: list[Dispatcher]
    taken_lines: list[str]  # DEVICE_LINE
    board_interrupts: tuple[str, ...]
    vectors: list[VectorRow]
    interrupts: list[InterruptRow]
    timer_level: int
    task_count: int
    clock_hz: int
    watched: list[WatchedRow]
    topics: list[str]
    board: str
    graph: str
    graph_hash: str


@dataclass(frozen=True)
class LineBit:
    name: str
    wire: str
    word: int
    mask: str


@dataclass(frozen=True)
class MemoryRow:
    at: str
    bytes: int


def program(plan: Plan) -> CortexProgram:
    chip = plan.board.chip
    assert chip is not None
    dispatchers = _dispatchers(plan)
    handlers = {task.vector: f"tasks::{task.node.name}::run" for task in plan.tasks}
    handlers |= {row.vector: row.handler for row in dispatchers}
    handlers |= {chip.vectors[name]: f"board::{name}_interrupt" for name in plan.board.interrupts}
    names = {number: name for name, number in chip.vectors.items()}
    periodic = [t.level for t in plan.tasks if any(i.kind == "every" for i in t.node.triggers)]
    taken = [f"{line.device}_{line.line}" for row in dispatchers for line in row.lines]
    return CortexProgram(
        dispatchers=dispatchers,
        taken_lines=list(dict.fromkeys(taken)),  # each once, even if several vectors raise it
        board_interrupts=plan.board.interrupts,
        vectors=[
            VectorRow(
                number=number,
                handler=handlers.get(number, "stator_fault"),
                name=names.get(number, "not on this chip"),
            )
            for number in range(max(names) + 1)
        ],
        interrupts=[
            *(InterruptRow(task.vector, task.level, task.node.name) for task in plan.tasks),
            *(InterruptRow(row.vector, row.level, row.comment) for row in dispatchers),
        ],
        timer_level=max(periodic, default=LOWEST_LEVEL),
        task_count=len(plan.tasks),
        clock_hz=chip.clock_hz,
        watched=watched(plan),
        topics=list(plan.topics),
        board=plan.board.name,
        graph=plan.graph.name,
        graph_hash=graph_hash(plan),
    )


def _dispatchers(plan: Plan) -> list[Dispatcher]:
    """The handlers of lines that share a vector, or whose task has other triggers, too."""
    assert plan.board.chip is not None
    names = {number: name for name, number in plan.board.chip.vectors.items()}
    found: dict[int, Dispatcher] = {}
    for task in plan.tasks:
        for trigger, device, vector in _wires(plan, task):
            if vector == task.vector or device.driver == "none":
                continue
            # The most urgent task comes first, and gives the level.
            name = names[vector]
            row = found.setdefault(
                vector, Dispatcher(vector, f"dispatch_{name}", task.level, f"lines of {name}")
            )
            row.lines.append(DispatchedLine(task.node.name, device.name, *trigger))
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


def lines(plan: Plan) -> list[LineBit]:
    """The bit of each line of the board's bound devices; of the first of several wires."""
    assert plan.board.chip is not None
    found = []
    for device in plan.board.devices.values():
        for line, wires in device.lines.items() if device.driver != "none" else ():
            word, bit = divmod(plan.board.chip.vectors[vector_of(wires[0])], VECTOR_WORD_BITS)
            found.append(LineBit(f"{device.name}_{line}", wires[0], word, f"{1 << bit:#x}"))
    return found


def image(plan: Plan) -> dict[str, MemoryRow]:
    """The memories of the linker script. Raises `UserError` if the chip's file lacks one."""
    assert plan.board.chip is not None
    missing = [name for name in MEMORIES if name not in plan.board.chip.memory]
    if missing:
        raise UserError(
            f"error: missing memory {', '.join(missing)} of chip {plan.board.chip.name}\n"
            f'hint: add `memory: {{{missing[0]}: {{at: "0x20000000", bytes: 131072}}}}` to its file'
        )
    return {
        name: MemoryRow(f"{memory.at:#010x}", memory.bytes)
        for name, memory in plan.board.chip.memory.items()
    }
