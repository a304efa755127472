"""Reads what activates a node."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import beside
from stator.graph.model import Trigger
from stator.language.keys import MAX_TIMERS, TRIGGER
from stator.language.period import spelled_us

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.graph.model import Board, Interface
    from stator.language.shapes import Leaf, Record

KINDS = ("irq", "topic", "every")
# Keys that go with one kind of trigger only.
_OWNERS = {"min_interarrival": "irq", "min_interval": "topic", "offset": "every"}


class TriggerReader:
    def __init__(self, node: str, interface: Interface, record: Record, report: Report) -> None:
        self._node = node
        self._interface = interface
        self._record = record
        self._report = report

    def read(self, boards: list[Board]) -> tuple[Trigger, ...]:
        leaf = self._record.get("trigger")
        triggers: dict[tuple[str, str, int, int], Trigger] = {}
        for record in leaf.value if leaf is not None else ():
            trigger = self._trigger(record)
            if trigger is None:
                continue
            key = (trigger.kind, trigger.name, trigger.period_us, trigger.offset_us)
            if key in triggers:
                self._report.error(
                    record.mark,
                    "trigger-twice",
                    "duplicate trigger",
                    f"first one: {beside(record.mark, triggers[key].mark)}; keep one of them",
                )
                continue
            triggers[key] = trigger
            if trigger.kind == "irq":
                self._check_line(trigger, boards)
            elif trigger.kind == "topic":
                self._check_topic(trigger)
        self._check_timer(leaf)
        timers = sum(trigger.kind == "every" for trigger in triggers.values())
        if timers > MAX_TIMERS:
            self._report.error(
                leaf.mark,
                "out-of-range",
                f"expected at most {MAX_TIMERS} periods in one node, found {timers}",
                "move some of them to another node",
            )
        return tuple(triggers.values())

    def _check_timer(self, leaf: Leaf | None) -> None:
        if leaf is None or not self._interface.needs_timer:
            return
        if any("every" in record.keys for record in leaf.value):
            return
        self._report.error(
            leaf.mark,
            "timer-missing",
            f"missing trigger `every` of '{self._node}': app '{self._interface.name}' needs a "
            "timer",
            "add one, for example {every: 10 ms}",
        )

    def _trigger(self, record: Record) -> Trigger | None:
        kinds = [kind for kind in KINDS if kind in record.keys]
        if len(kinds) != 1:
            if all(key in TRIGGER.keys for key in record.keys):  # else that is the error
                self._refuse_kinds(record, kinds)
            return None
        kind = kinds[0]
        if record.get(kind) is None:
            return None
        for key, owner in _OWNERS.items():
            if key in record.keys and owner != kind:
                fitting = [other for other, its in _OWNERS.items() if its == kind]
                self._report.error(
                    record.keys[key],
                    "trigger-key",
                    f"key '{key}' belongs to trigger `{owner}`, found in trigger `{kind}`",
                    f"remove it, or write '{fitting[0]}'",
                )
        trigger = Trigger(
            kind=kind,
            name="" if kind == "every" else record.value(kind),
            mark=record.get(kind).mark,
            min_interarrival_us=record.value("min_interarrival"),
            min_interval_us=record.value("min_interval"),
            period_us=record.value("every", 0),
            offset_us=record.value("offset", 0),
            max_interval_us=record.value("max_interval"),
        )
        self._check_times(trigger, record)
        return trigger

    def _refuse_kinds(self, record: Record, kinds: list[str]) -> None:
        if not kinds:
            self._report.error(
                record.mark,
                "trigger-kind",
                "expected one of irq, topic, every in a trigger, found none",
                "add one, for example {every: 10 ms}",
            )
            return
        split = ", ".join("{" + kind + ": ...}" for kind in kinds)
        self._report.error(
            record.keys[kinds[1]],
            "trigger-kind",
            f"expected one of irq, topic, every in a trigger, found {' and '.join(kinds)}",
            f"write a list of triggers: [{split}]; each of them activates the node; a list also "
            "replaces the trigger of an included file",
        )

    def _check_times(self, trigger: Trigger, record: Record) -> None:
        if trigger.kind == "every" and trigger.offset_us >= trigger.period_us:
            self._report.error(
                record.get("offset").mark,
                "offset-range",
                f"expected an offset shorter than the period of {spelled_us(trigger.period_us)}, "
                f"found {spelled_us(trigger.offset_us)}",
                f"write {spelled_us(trigger.offset_us % trigger.period_us)}",
            )
        most = trigger.max_interval_us
        least = trigger.period_us or trigger.min_interval_us or trigger.min_interarrival_us or 0
        if most is not None and most < least:
            self._report.error(
                record.get("max_interval").mark,
                "interval-range",
                f"expected at least {spelled_us(least)} (the shortest time between two "
                f"activations), found {spelled_us(most)}",
                f"write {spelled_us(least)} or more",
            )

    def _check_topic(self, trigger: Trigger) -> None:
        inputs = self._record.get("inputs")
        if inputs is None and "inputs" in self._record.keys:
            return
        written = (
            {}
            if inputs is None
            else {value.value("topic"): key for key, value in inputs.values.items()}
        )
        name = written.get(trigger.name)
        if name is not None:
            self._check_read(trigger, name, inputs.values[name])
        elif inputs is None or (None not in written and len(inputs.values) == len(inputs.keys)):
            topics = [topic for topic in written if topic is not None]
            app = self._record.keys.get("app")
            if app is not None and app.file != trigger.mark.file:
                # The user replaces the app of an included node.
                self._report.error(
                    app,
                    "trigger-not-input",
                    f"no input of '{self._node}' reads topic '{trigger.name}', its trigger in "
                    f"{beside(app, trigger.mark)}",
                    f"give `{self._node}` a trigger in your file, such as `trigger: {{topic: "
                    f"{topics[0] if topics else 'TOPIC'}}}` or `trigger: {{every: 10 ms}}`",
                )
                return
            self._report.error(
                trigger.mark,
                "trigger-not-input",
                f"no input of '{self._node}' reads topic '{trigger.name}'",
                self._report.nearest(trigger.name, topics) or "connect an input to it",
            )

    def _check_read(self, trigger: Trigger, name: str, source: Record) -> None:
        read = source.get("read")
        if read is None or (trigger.is_thinned and read.value == "latest"):
            return
        if trigger.is_thinned:
            self._report.error(
                read.mark,
                "thinned-queue",
                f"expected `read: latest` with `min_interval` on '{trigger.name}', found queue",
                "remove `read: queue` or `min_interval`",
            )
            return
        self._report.error(
            read.mark,
            "trigger-read",
            f"input '{name}' triggers the node, which reads every sample in order",
            "remove `read`"
            + (", or add `min_interval` to the trigger" if read.value == "latest" else ""),
        )

    def _check_line(self, trigger: Trigger, boards: list[Board]) -> None:
        if "device" not in self._record.keys:
            self._report.error(
                trigger.mark,
                "irq-needs-device",
                f"'{self._node}' has no device: only a node with a device has irq triggers",
                "add `device:`, or use another trigger",
            )
            return
        lines = self._interface.lines
        if trigger.name not in lines:
            self._report.error(
                trigger.mark,
                "line-unknown",
                f"unknown line '{trigger.name}' of device class '{self._interface.name}'",
                self._report.nearest(trigger.name, lines) or "remove it: this class has no lines",
            )
            return
        device = self._record.value("device")
        for board in boards:
            if board.chip is None or trigger.name in board.devices[device].lines:
                continue
            self._report.error(
                trigger.mark,
                "line-not-on-board",
                f"board '{board.name}' does not connect line '{trigger.name}' of device '{device}'",
                f"add `lines: {{{trigger.name}: PIN}}` to '{device}' in its board.yaml",
            )
            return
