"""What the plan says of a task as reader of a topic."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.plan.plan import Plan, Task

# On these executors a job runs to its end before another of its level or below continues.
NESTING = ("cortex_m", "virtual")


def is_outranked(plan: Plan, task: Task, topic: str) -> bool:
    """Whether the topic may be published while the task reads it."""
    publishers = plan.topics[topic].publishers
    return bool(publishers) and (
        plan.board.executor not in NESTING
        or any(name == task.node.name or plan.task(name).level > task.level for name in publishers)
    )


def is_gated(plan: Plan, task: Task) -> bool:
    modes = plan.graph.modes
    return modes is not None and any(task.node.name in names for names in modes.sets.values())


def is_woken(plan: Plan, task: Task, port: str) -> bool:
    """Whether each activation has one sample of this input: the newest, which woke it."""
    source = task.node.inputs[port]
    return (
        task.node.way_of(source) == "trigger"
        and plan.topics[source.topic].depth == 1
        and len(task.node.triggers) == 1
        and not is_outranked(plan, task, source.topic)
        and not is_gated(plan, task)
    )
