"""Rows of a recording and of its replay, as docs/recording.md has the format; how much it takes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.diagnostics import UserError, shown_path
from stator.emit import parameters as emit_parameters
from stator.emit import rows as emit_rows
from stator.graph.model import TYPES
from stator.names import upper_camel
from stator.plan.log_rate import (
    SECOND_US,
    block_bytes,
    blocks_at_once,
    faster,
    logged_bytes,
    logger_of,
    longest_period_us,
    most_blocks,
    too_slow,
)
from stator.plan.rates import Rates

if TYPE_CHECKING:
    from stator.graph.model import Message, Node
    from stator.plan.plan import Plan, Task

VERSION = 2  # of the format; 1 had CRC-32 of samples, and does not say so
START_LEVEL = 0  # of publications before the first task runs
# A stream holds the records of its level for this number of logger periods. Where levels are
# threads, a busy machine may keep the logger waiting for longer, and has the memory.
HELD_PERIODS = 4
HELD_BY_THREADS_US = 500_000
MIN_STREAM = 256
# Bytes of the parts of a record; rare records are larger.
HEAD_BYTES = 8  # task, end, what fired, time since the previous record
TAKE_BYTES = 2  # tag and number
HASH_BYTES = 4


@dataclass(frozen=True)
class Port:
    name: str
    topic: str
    kind: str  # trigger, thinned, latest, queue; of an output: hash, whole, stamp
    tag: int
    message: Message
    burst: int = 1  # of an output
    min_interval_us: int = 0  # of one that is published seldom


@dataclass(frozen=True)
class Recorded:
    """A task as a recording has it; `parameters` of a node are a task that runs once."""

    name: str
    kind: str  # app, driver, logger, parameters
    level: int
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    params: tuple[Port, ...]  # parameters that it publishes; also outputs
    timers: int
    lines: tuple[str, ...]


def is_recordable(plan: Plan) -> bool:
    """The logger is what takes a recording into the log."""
    return any(node.interface.reads_log for node in plan.graph.nodes.values())


def recorded_tasks(plan: Plan) -> list[Recorded]:
    tasks = [_of_task(plan, task) for task in plan.tasks]
    for topic in plan.topics.values():
        if topic.owner:
            port = Port("params", topic.name, "whole", 1, topic.message)
            tasks.append(Recorded(topic.name, "parameters", START_LEVEL, (), (port,), (), 0, ()))
    return tasks


def _of_task(plan: Plan, task: Task) -> Recorded:
    node = task.node
    is_driver = node.device is not None or node.interface.reads_graph
    kind = "driver" if is_driver else "app"
    kind = "logger" if node.interface.reads_log else kind
    inputs = [
        Port(key, i.topic, node.way_of(i), 0, plan.topics[i.topic].message)
        for key, i in node.inputs.items()
    ]
    if node.interface.params_message is not None:
        topic = f"{node.name}_params"
        inputs.append(Port("params", topic, "latest", 0, node.interface.params_message))
    how = {"app": "hash", "driver": "whole", "logger": "stamp"}[kind]
    outputs = [
        Port(
            key, o.topic, how, 0, plan.topics[o.topic].message, o.port.burst, o.port.min_interval_us
        )
        for key, o in node.outputs.items()
    ]
    params = [
        Port(row.topic, row.topic, how, 0, plan.topics[row.topic].message)
        for row in emit_parameters.published(plan, node)
    ]
    numbered = [
        replace(port, tag=tag) for tag, port in enumerate((*inputs, *outputs, *params), start=1)
    ]
    timers = sum(1 for t in node.triggers if t.kind == "every")
    lines = tuple(t.name for t in node.triggers if t.kind == "irq")
    split, end = len(inputs), len(inputs) + len(outputs)
    return Recorded(
        node.name,
        kind,
        task.level,
        tuple(numbered[:split]),
        tuple(numbered[split:end]),
        tuple(numbered[end:]),
        timers,
        lines,
    )


# --- definitions in a recording ---


def definitions(plan: Plan, file: str) -> list[str]:
    lines = [f"recording {VERSION}", f"graph {plan.graph.name} {plan.board.name} {file}"]
    if plan.graph.modes is not None:
        lines.append("modes " + " ".join(plan.graph.modes.sets))
    tasks = recorded_tasks(plan)
    messages = {
        port.topic: port.message
        for task in tasks
        for port in (*task.inputs, *task.outputs, *task.params)
    }
    lines += [f"topic {name} {layout(message)}" for name, message in messages.items()]
    lines += [task_line(task) for task in tasks]
    return lines


def layout(message: Message) -> str:
    """Fields as ULog spells them, with the padding at the end, and so the whole size."""
    parts = []
    for field in message.fields:
        count = "" if field.count is None else f"[{field.count}]"
        parts.append(f"{TYPES[field.type][1]}{count} {field.name};")
    return "".join(parts)


def task_line(task: Recorded) -> str:
    ports = [
        ",".join(f"{port.name}:{port.topic}:{port.kind}" for port in side) or "-"
        for side in (task.inputs, (*task.outputs, *task.params))
    ]
    return f"task {task.name} {task.level} {task.kind} {ports[0]} {ports[1]} {task.timers}"


# --- rows ---


@dataclass(frozen=True)
class PortRow:
    name: str
    topic: str
    kind: str
    tag: int
    how: str
    floats: list[str]
    burst: int
    age: str = ""  # the argument of a port that does not take samples of any age


@dataclass(frozen=True)
class TaskRecording:
    """What the wrapper of a task needs to record it."""

    index: int
    has_modes: bool
    is_gated: bool
    stream: str
    fired: str
    inputs: list[PortRow]
    outputs: list[PortRow]
    params: list[PortRow]
    starts: list[str]
    writes_in_step: bool  # else the whole record is written behind it

    @property
    def more_numbers(self) -> int:
        """At the end of the record, besides those of every record."""
        return int(self.has_modes) + (len(self.starts) if self.is_gated else 0)


@dataclass(frozen=True)
class StreamRow:
    name: str
    bytes: int


@dataclass(frozen=True)
class RecordingRow:
    streams: list[StreamRow]
    levels: list[str]
    definitions: list[str]
    blocks_at_once: int


def task_rows(plan: Plan) -> dict[str, TaskRecording]:
    return {task.name: _task_row(plan, i, task) for i, task in enumerate(recorded_tasks(plan))}


def _task_row(plan: Plan, index: int, task: Recorded) -> TaskRecording:
    modes = plan.graph.modes
    is_gated = modes is not None and any(task.name in names for names in modes.sets.values())
    fired = ["uint64_t{is_anew}"] if is_gated else []
    fired += ["(uint64_t{ports.fired.timers} << 1)"] if task.timers else []
    fired += [
        f"(uint64_t{{ports.fired.{line}}} << {1 + task.timers + i})"
        for i, line in enumerate(task.lines)
    ]
    return TaskRecording(
        index=index,
        has_modes=modes is not None,
        is_gated=is_gated,
        stream=f"streams::level_{task.level}",
        fired=" | ".join(fired) or "0",
        inputs=[port_row(port, _age(plan, task, port)) for port in task.inputs],
        outputs=[port_row(port) for port in task.outputs],
        params=[port_row(port) for port in task.params],
        starts=[p.name for p in task.inputs if p.kind in ("trigger", "queue")],
        writes_in_step=bool(task.outputs or task.params)
        or any(port.kind == "queue" for port in task.inputs),
    )


def _age(plan: Plan, task: Recorded, port: Port) -> str:
    source = plan.graph.nodes[task.name].inputs.get(port.name)
    return f", {source.max_age_us}" if source is not None and source.max_age_us else ""


def port_row(port: Port, age: str = "") -> PortRow:
    return PortRow(
        name=port.name,
        topic=port.topic,
        kind=port.kind,
        tag=port.tag,
        how=f"RecordedOutput::How::k{upper_camel(port.kind)}",
        floats=emit_rows.log_floats(port.message),
        burst=port.burst,
        age=age,
    )


def recording_row(plan: Plan, file: str) -> RecordingRow:
    sizes = stream_bytes(plan)
    return RecordingRow(
        streams=[StreamRow(f"level_{level}", size) for level, size in sorted(sizes.items())],
        levels=[f"level_{level}" if level in sizes else "none" for level in range(max(sizes) + 1)],
        definitions=definitions(plan, file),
        blocks_at_once=blocks_with_recording(plan),
    )


# --- the size of a recording ---


def stream_bytes(plan: Plan) -> dict[int, int]:
    """Bytes that each level's stream holds: a power of two."""
    rates, usual = Rates(plan.graph), Rates(plan.graph, usual=True)
    logger = logger_of(plan.graph)
    assert logger is not None
    period = rates.node(logger.name) or Fraction(0)
    held_us = HELD_PERIODS * period
    if plan.board.executor == "pthread":
        held_us = max(held_us, Fraction(HELD_BY_THREADS_US))
    bytes_per_us = Fraction(bytes_per_second(plan, usual=True), SECOND_US)
    blocks_per_us = bytes_per_us / block_bytes(plan.graph, plan.topics)
    sizes: dict[int, Fraction] = {}
    for task in recorded_tasks(plan):
        each = _record_bytes(plan, task, rates)
        activations = Fraction(1)
        blocks = Fraction(
            0
        )  # activations by blocks of the log, in which nothing seldom is published
        if _is_woken_by(logger, task):
            blocks = most_blocks(plan.graph) + held_us * blocks_per_us
            activations += held_us * (
                1 / _period_us(rates, task.name) - 1 / period if period else 0
            )
        elif task.kind != "parameters":
            activations += held_us / _period_us(rates, task.name)
        size = each * activations + _record_bytes(plan, task, usual) * blocks
        sizes[task.level] = sizes.get(task.level, Fraction(0)) + size
    return {level: _power_of_two(max(Fraction(MIN_STREAM), size)) for level, size in sizes.items()}


def bytes_per_second(plan: Plan, *, usual: bool = False) -> int:
    """What a log with a full recording takes, as a rule at most. `usual`: outputs that are
    published seldom count with their `min_interval`."""
    rates = Rates(plan.graph, usual=usual)
    recorded = sum(
        _record_bytes(plan, task, rates) / _period_us(rates, task.name)
        for task in recorded_tasks(plan)
        if task.kind != "parameters"
    )
    return round(recorded * SECOND_US + logged_bytes(plan.topics, rates if usual else None))


def blocks_with_recording(plan: Plan) -> int:
    """That an activation of the logger publishes at most."""
    return blocks_at_once(plan.graph, plan.topics, Fraction(bytes_per_second(plan)))


def check_recording_rate(plan: Plan) -> None:
    """Raises `UserError` for a logger that is too slow for a full recording."""
    logger = logger_of(plan.graph)
    period = None if logger is None else Rates(plan.graph).node(logger.name)
    if logger is None or period is None:
        return
    wanted = Fraction(bytes_per_second(plan))
    longest = longest_period_us(plan.graph, plan.topics, wanted)
    if period > longest:
        mark = logger.triggers[0].mark
        raise UserError(
            f"{shown_path(mark.file)}:{mark.line}:{mark.column}: error: with the recording, "
            f"{too_slow(logger, period, wanted, longest)}\n"
            f"hint: {faster(longest)}; --no-record flies without the recording"
        )


def storage_bytes_per_second(plan: Plan) -> int | None:
    """What the storage takes on the board that the graph is for; None: its file does not say."""
    devices = (d for d in plan.graph.board.devices.values() if d.bytes_per_s is not None)
    return next((d.bytes_per_s for d in devices), None)


def _period_us(rates: Rates, node: str) -> Fraction:
    """Of a node that nothing is known of: 1 ms."""
    return rates.node(node) or Fraction(1000)


def _is_woken_by(logger: Node, task: Recorded) -> bool:
    blocks = {output.topic for output in logger.outputs.values()}
    return any(port.kind == "trigger" and port.topic in blocks for port in task.inputs)


def _record_bytes(plan: Plan, task: Recorded, rates: Rates) -> Fraction:
    total = Fraction(HEAD_BYTES)
    for port in task.inputs:
        samples = Fraction(1)
        if port.kind == "queue" and (published := rates.topic(port.topic)):
            samples = _period_us(rates, task.name) / published
        total += TAKE_BYTES * samples
    for port in task.outputs:
        content = {"whole": port.message.bytes, "hash": HASH_BYTES, "stamp": 0}[port.kind]
        samples = Fraction(port.burst)
        if rates.usual and port.min_interval_us:
            samples = min(samples, _period_us(rates, task.name) / port.min_interval_us)
        total += samples * (TAKE_BYTES + content)
    return total + (TAKE_BYTES + HASH_BYTES if task.params else 0)  # of one node at a time


def _power_of_two(size: Fraction) -> int:
    result = 1
    while result < size:
        result *= 2
    return result
