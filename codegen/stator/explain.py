"""Says why a node runs when and where it does, and what a topic takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import shown_path
from stator.plan_text import triggers_text
from stator.rates import Rates
from stator.shapes import quoted

if TYPE_CHECKING:
    from collections.abc import Iterable
    from fractions import Fraction

    from stator.model import Node
    from stator.plan import Plan, Task
    from stator.plan_topics import TopicPlan


LABEL_WIDTH = 36
WAYS = {
    "trigger": "each activation takes one, in order",
    "thinned": "latest",
    "queue": "all, in order",
    "latest": "latest",
}


def explain(plan: Plan, name: str) -> list[str] | None:
    """Lines for a node or a topic; None if the graph has neither."""
    if name in plan.graph.nodes:
        return _node(plan, plan.task(name))
    if name in plan.topics:
        return _topic(plan, plan.topics[name])
    return None


def _node(plan: Plan, task: Task) -> list[str]:
    node = task.node
    rates = Rates(plan.graph)
    lines = [
        f"{node.name}: {node.interface.doc}",
        _row("in", f"{shown_path(node.mark.file)}:{node.mark.line}"),
        _row("app" if node.device is None else "device", _what(plan, node)),
        _row("wakes on", triggers_text(node)),
        _row("at most every", _period(rates.node(node.name))),
        _row("level", _level(plan, task)),
    ]
    if task.vector is not None and plan.board.chip is not None:
        lines.append(
            _row(
                "vector",
                f"{task.vector} of {plan.board.chip.name.split('/')[-1]}, "
                + _vector_reason(plan, node),
            )
        )
    peers = [t.node.name for t in plan.tasks if t.level == task.level]
    if len(peers) > 1:
        lines.append(_row("order", f"in its level: {', '.join(peers)}"))
    lines.append(_row("preempted by", _names(t for t in plan.tasks if t.level > task.level)))
    lines.append(_row("preempts", _names(t for t in plan.tasks if t.level < task.level)))
    for key, source in node.inputs.items():
        topic = plan.topics[source.topic]
        kind = WAYS[node.way_of(source)]
        age = f", absent when older than {source.max_age_us} us" if source.max_age_us else ""
        lines.append(
            _row(
                f"reads {key}",
                f"{topic.name} ({topic.message.name}) from "
                f"{', '.join(topic.publishers)}; {kind}{age}",
            )
        )
    for key, output in node.outputs.items():
        readers = ", ".join(name for name, _ in plan.topics[output.topic].readers) or "nobody"
        lines.append(_row(f"writes {key}", f"{output.topic}, read by {readers}"))
    for key, param in node.interface.params.items():
        value = node.params[key]
        unit = "" if param.unit == "1" else f" {param.unit}"
        shown = str(value).lower() if isinstance(value, bool) else f"{float(value):g}{unit}"
        note = "" if value != param.default else " (default)"
        lines.append(_row(f"param {key}", f"{shown}{note}: {param.doc}"))
    return lines


def _level(plan: Plan, task: Task) -> str:
    levels = sorted({t.level for t in plan.tasks}, reverse=True)
    place = levels.index(task.level) + 1
    reason = "from its deadline, as the graph gives no priorities" if plan.derived else "as given"
    return f"{task.level}, number {place} in urgency of {len(levels)}; {reason}"


def _topic(plan: Plan, topic: TopicPlan) -> list[str]:
    levels = {task.node.name: task.level for task in plan.tasks}

    def with_level(name: str) -> str:
        return f"{name} (level {levels[name]})"

    log = {None: "not logged", 0: "every sample"}.get(topic.log_us, f"every {topic.log_us} us")
    guard = "no critical section: one level publishes"
    if topic.ceiling:
        guard = f"loan and commit keep levels up to {topic.ceiling} out: several levels publish"
    return [
        f"{topic.name}: {topic.message.doc}",
        _row("message", f"{topic.message.name}, {topic.message.bytes} bytes"),
        _row(
            "from",
            ", ".join(map(with_level, topic.publishers)) or f"the parameters of {topic.owner}",
        ),
        _row("read by", ", ".join(with_level(name) for name, _ in topic.readers) or "nobody"),
        _row("at most every", _period(topic.period_us)),
        _row("depth", str(topic.depth)),
        _row("slots", f"{topic.slots}, so {topic.slots * topic.message.bytes} bytes"),
        _row("publishing", guard),
        _row("log", log),
    ]


def _row(label: str, text: str) -> str:
    return f"  {label:<{LABEL_WIDTH}}{text}"


def _names(tasks: Iterable[Task]) -> str:
    return ", ".join(task.node.name for task in tasks) or "nobody"


def _period(period: Fraction | None) -> str:
    if period is None:
        return "not known"
    return f"{float(period):g} us ({1e6 / float(period):g} Hz)"


def _what(plan: Plan, node: Node) -> str:
    if node.device is None:
        return shown_path(node.interface.file.parent)
    driver = plan.board.devices[node.device].driver
    bound = "no driver yet" if driver == "none" else f"driver {driver}"
    return f"{quoted(node.device)} of class {node.interface.name}; {bound} on {plan.board.name}"


def _vector_reason(plan: Plan, node: Node) -> str:
    from stator.plan import vector_of

    only = node.triggers[0]
    if len(node.triggers) == 1 and only.kind == "irq" and node.device is not None:
        wire = plan.board.devices[node.device].lines[only.name]
        number = plan.board.chip.vectors.get(vector_of(wire)) if plan.board.chip else None
        if number == plan.task(node.name).vector:
            return f"that of its line {only.name} ({wire})"
    return "a spare one, pended by software"
