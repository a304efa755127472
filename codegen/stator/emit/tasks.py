"""Rows of the tasks: the actions and the state of the wrapper around each node.

The wrapper does only what the plan says can matter: where no publisher outranks a reader its pin
needs no mark, where each pend means a sample nothing is asked, and where time has one source
nothing is compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.emit import bridges, devices
from stator.emit.readers import is_gated, is_outranked, is_woken
from stator.emit.recording import blocks_with_recording
from stator.emit.rows import pend
from stator.plan.log_rate import blocks_at_once
from stator.plan.plan import owns_its_vector

if TYPE_CHECKING:
    from stator.diagnostics import Mark
    from stator.emit.recording import TaskRecording
    from stator.graph.model import Interface, Node, Trigger
    from stator.plan.plan import Plan, Task


@dataclass(frozen=True)
class InputRow:
    name: str
    topic: str
    kind: str  # one of _KINDS
    take: str
    max_age_us: int = 0
    may_leave: bool = False  # whether samples can be left when the activation ends
    now: str = ""


@dataclass(frozen=True)
class OutputRow:
    name: str
    topic: str
    keep: str
    burst: str


@dataclass(frozen=True)
class LineRow:
    name: str
    min_interarrival_us: int
    now: str


@dataclass(frozen=True)
class TimerRow:
    name: str
    bit: str
    period_us: int
    offset_us: int
    now: str


@dataclass(frozen=True)
class EntryRow:
    """The line whose vector is the task's."""

    line: str
    min_interarrival_us: int


@dataclass(frozen=True)
class TaskRow:
    name: str
    mark: Mark
    header: str
    class_name: str
    is_bound: bool
    device: str
    ports: str
    pend: str
    index: int
    is_timed: bool
    level: int
    level_begin: int
    entry: EntryRow | None
    lines: list[LineRow]
    timers: list[TimerRow]
    triggers: list[InputRow]
    thinned: list[InputRow]
    latest: list[InputRow]
    queues: list[InputRow]
    outputs: list[OutputRow]
    reads_log: bool
    reads_graph: bool
    publishes_params: bool
    reads_metadata: bool
    is_replayed: bool
    keeps_now: bool
    is_gated: bool
    switches_mode: bool
    is_restarted: bool  # its machine can be started again in virtual time
    recorded: TaskRecording | None

    @property
    def state(self) -> list[str]:
        """Members of the task's state."""
        fields = ["uint64_t now_us"] if self.keeps_now else []
        kind = "EntryState" if self.entry else "LineState"
        fields += [f"{kind} line_{line.name}" for line in self.lines]
        fields += [f"TimerState {timer.name}" for timer in self.timers]
        fields += [f"ThinnedState thinned_{i.topic}" for i in self.thinned]
        fields += [f"uint32_t {name}" for name in self._numbers()]
        fields += [f"uint32_t {i.name}_served" for i in self.thinned]
        if self.reads_log:
            fields.append("uint32_t log_lost")
        if self.is_gated:
            fields.append("ModeGate gate")
            # Shared: with threads, the next switch may come while the task begins.
            fields += [f"Shared<uint32_t> {name}_start" for name in self._started()]
        return fields

    def _numbers(self) -> list[str]:
        inputs = [*self.triggers, *self.thinned, *self.latest, *self.queues]
        return [f"{i.name}_number" for i in inputs]

    def _started(self) -> list[str]:
        """What a switch notes for the task that it starts."""
        inputs = [*self.triggers, *self.queues, *self.thinned]
        return [i.name for i in inputs] + [timer.name for timer in self.timers]

    @property
    def starts(self) -> list[str]:
        """Statements of the switch that starts the task."""
        heads = [
            f"state.{i.name}_start.store(head_of(topics::{i.topic}).load());"
            for i in [*self.triggers, *self.queues]
        ]
        fires = [(i.name, f"thinned_{i.topic}") for i in self.thinned]
        fires += [(timer.name, timer.name) for timer in self.timers]
        heads += [f"state.{name}_start.store(state.{of}.fires.load());" for name, of in fires]
        return heads

    @property
    def restart(self) -> list[str]:
        """Statements of the task when it begins after a switch."""
        begun = [i.name for i in (*self.triggers, *self.queues)]
        lines = [f"state.{name}_number = state.{name}_start.load();" for name in begun]
        lines += [
            f"state.{name} = 0;"
            for name in self._numbers()
            if name.removesuffix("_number") not in begun
        ]
        lines += [f"state.{i.name}_served = state.{i.name}_start.load();" for i in self.thinned]
        lines += [
            f"skip_to(state.{t.name}, state.{t.name}_start.load(), {t.period_us});"
            for t in self.timers
        ]
        return lines


def task(plan: Plan, planned: Task, recorded: TaskRecording | None) -> TaskRow:
    node = planned.node
    interface = node.interface
    device = plan.board.devices[node.device] if node.device is not None else None
    driver = device.driver if device is not None else ""
    header, class_name = _class(interface, driver)
    modes = plan.graph.modes
    is_bound = device is None or driver != "none"
    entry = [t for t in node.triggers if is_bound and owns_its_vector(plan, planned)]
    keeps_now = not entry and not _has_one_clock(plan, node)
    inputs = [_input(plan, planned, key, keeps_now) for key in node.inputs]
    kinds = {kind: [i for i in inputs if i.kind == kind] for kind in _KINDS}
    if interface.params:
        kinds["latest"].append(_params(plan, planned))
    return TaskRow(
        name=node.name,
        mark=node.mark,
        header=f"{header}.hpp",
        class_name=class_name,
        is_bound=is_bound,
        device=node.device or "",
        ports=f"{interface.namespace}::{interface.class_name}Ports",
        pend=pend(plan, planned),
        index=planned.index,
        is_timed=plan.is_timed(node.name),
        level=planned.level,
        level_begin=planned.level_begin,
        entry=EntryRow(entry[0].name, entry[0].min_interarrival_us or 0) if entry else None,
        lines=[_line(t, keeps_now) for t in node.triggers if t.kind == "irq"],
        timers=[
            _timer(i, t, keeps_now)
            for i, t in enumerate(t for t in node.triggers if t.kind == "every")
        ],
        triggers=kinds["trigger"],
        thinned=kinds["thinned"],
        latest=kinds["latest"],
        queues=kinds["queue"],
        outputs=[
            OutputRow(
                name=key,
                topic=o.topic,
                keep="true" if node.name in plan.topics[o.topic].kept_by else "false",
                burst=_burst(plan, node, o.port.burst),
            )
            for key, o in node.outputs.items()
        ],
        reads_log=interface.reads_log,
        reads_graph=interface.reads_graph,
        publishes_params=interface.publishes_params,
        reads_metadata=interface.reads_metadata,
        is_replayed=device is None and not interface.is_observer,
        keeps_now=keeps_now,
        is_gated=is_gated(plan, planned),
        switches_mode=modes is not None and modes.publisher == node.name,
        is_restarted=bridges.is_restarted(plan, node),
        recorded=recorded,
    )


def _class(interface: Interface, driver: str) -> tuple[str, str]:
    """Header, without its end, and class of a node; of a device's its driver's."""
    if interface.bridge is not None:
        return bridges.header(interface), bridges.class_name(interface)
    if driver:
        return devices.header(driver), devices.class_name(driver)
    name = interface.name
    return f"apps/{name}/{name}", f"apps::{name}::{interface.class_name}"


_KINDS = ("trigger", "thinned", "latest", "queue")


def _has_one_clock(plan: Plan, node: Node) -> bool:
    """Whether what wakes the node tells a time that never goes back by itself."""
    if len(node.triggers) != 1:
        return False
    only = node.triggers[0]
    return only.kind != "topic" or len(plan.topics[only.name].publishers) == 1


def _now(expression: str, keeps_now: bool) -> str:
    if keeps_now:
        return f"state.now_us = later(state.now_us, {expression});"
    return f"ports.now = {expression};"


def _line(trigger: Trigger, keeps_now: bool) -> LineRow:
    return LineRow(
        name=trigger.name,
        min_interarrival_us=trigger.min_interarrival_us or 0,
        now=_now(f"state.line_{trigger.name}.clock_us.load()", keeps_now),
    )


def _timer(index: int, trigger: Trigger, keeps_now: bool) -> TimerRow:
    times = f"{trigger.period_us}, {trigger.offset_us}"
    return TimerRow(
        name=f"every_{index}",
        bit=f"{1 << index}U",
        period_us=trigger.period_us,
        offset_us=trigger.offset_us,
        now=_now(f"nominal_time_us(state.every_{index}, {times})", keeps_now),
    )


def _input(plan: Plan, planned: Task, key: str, keeps_now: bool) -> InputRow:
    node = planned.node
    source = node.inputs[key]
    kind = node.way_of(source)
    marks = is_outranked(plan, planned, source.topic)
    woken = is_woken(plan, planned, key)
    age = source.max_age_us
    limit = age or "kNoAgeLimit"
    arguments = f"topics::{source.topic}, state.{key}_number"
    tail = "" if marks else ", false"
    take = {
        "trigger": f"take_trigger({arguments}{tail})",
        "thinned": f"take_latest({arguments}, 0, kNoAgeLimit{tail})",
        "latest": f"take_latest({arguments}, ports.now, {limit}{tail})",
        "queue": f"open_queue({arguments}, ports.now, {limit}{tail})",
    }[kind]
    if woken:
        take = f"take_woken({arguments})"
    return InputRow(
        name=key,
        topic=source.topic,
        kind=kind,
        take=f"ports.{key}.{take};",
        max_age_us=age or 0,
        may_leave=not woken,
        now=_now(f"ports.{key}->timestamp", keeps_now) if kind in _KINDS[:2] else "",
    )


def _params(plan: Plan, planned: Task) -> InputRow:
    """Published before anything runs."""
    topic = f"{planned.node.name}_params"
    tail = "" if is_outranked(plan, planned, topic) else ", kNoAgeLimit, false"
    take = f"take_latest(topics::{topic}, state.params_number, ports.now{tail})"
    return InputRow("params", topic, "latest", f"ports.params.{take};")


def _burst(plan: Plan, node: Node, burst: int) -> str:
    """Publications of one activation; of the logger as many as its log needs."""
    if not node.interface.reads_log:
        return str(burst)
    return f"kRecords ? {blocks_with_recording(plan)} : {blocks_at_once(plan.graph, plan.topics)}"
