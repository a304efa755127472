"""The plan as text: which task can preempt which, and what each topic needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.language.period import spelled_us
from stator.plan.hash import graph_hash

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stator.graph.model import Node
    from stator.plan.plan import Plan
    from stator.plan.topics import TopicPlan


def plan_text(plan: Plan) -> str:
    lines = [
        f"graph {plan.graph.name} on {plan.board.name} ({plan.board.executor}), "
        f"planned for {plan.graph.board.name}",
        f"hash {graph_hash(plan)}",
        "",
        *text_table(
            [
                ("level", "task", "vector", "triggers"),
                *(_task(plan, i) for i in range(len(plan.tasks))),
            ]
        ),
        "",
        *text_table(
            [
                ("topic", "message", "bytes", "depth", "slots", "masks", "log"),
                *(_topic(topic) for topic in plan.topics.values()),
            ]
        ),
    ]
    unbound = [d.name for d in plan.board.devices.values() if d.driver == "none"]
    if unbound:
        lines += ["", f"without driver: {', '.join(unbound)}"]
    return "\n".join(lines) + "\n"


def _task(plan: Plan, index: int) -> tuple[str, ...]:
    task = plan.tasks[index]
    vector = "-" if task.vector is None else str(task.vector)
    return (str(task.level), task.node.name, vector, triggers_text(task.node))


def triggers_text(node: Node) -> str:
    parts = []
    for trigger in node.triggers:
        if trigger.kind == "every":
            part = f"every {spelled_us(trigger.period_us or 0)}"
            part += f" + {spelled_us(trigger.offset_us)}" if trigger.offset_us else ""
        else:
            part = f"{trigger.kind} {trigger.name}"
        if trigger.min_interval_us:
            part += f" at most every {spelled_us(trigger.min_interval_us)}"
        parts.append(part)
    return ", ".join(parts)


def _topic(topic: TopicPlan) -> tuple[str, ...]:
    log = "none"
    if topic.log_us is not None:
        log = f"every {spelled_us(topic.log_us)}" if topic.log_us else "all"
    return (
        topic.name,
        topic.message.name,
        str(topic.message.bytes * topic.slots),
        str(topic.depth),
        str(topic.slots),
        f"levels to {topic.ceiling}" if topic.ceiling else "nothing",
        log,
    )


def text_table(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def unbound_devices(plan: Plan) -> list[str]:
    """Devices that the graph uses and its board has no driver for."""
    used = {task.node.device for task in plan.tasks}
    return [d.name for d in plan.board.devices.values() if d.driver == "none" and d.name in used]


def show_notes(plan: Plan) -> None:
    unbound = unbound_devices(plan)
    if unbound:
        print(
            f"note: board {plan.board.name} has no driver for {', '.join(unbound)}; these devices "
            "publish nothing"
        )
    if plan.replanned:
        print(
            f"note: board {plan.board.name} cannot keep the task order of "
            f"{plan.graph.board.name}; it has a plan and a hash of its own"
        )
