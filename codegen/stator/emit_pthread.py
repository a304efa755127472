"""Rows of what an executor of threads needs besides the tasks: its levels, and larger topics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.emit_rows import watched
from stator.language import DEPTHS

if TYPE_CHECKING:
    from stator.emit_rows import Row
    from stator.plan import Plan
    from stator.plan_topics import TopicPlan


def program(plan: Plan) -> Row:
    first_timer = 0
    levels = []
    for level in plan.levels:
        tasks = [task for task in plan.tasks if task.level == level]
        timers = sum(t.kind == "every" for task in tasks for t in task.node.triggers)
        levels.append(
            {
                "priority": level,
                "first_task": tasks[0].level_begin,
                "task_count": len(tasks),
                "first_timer": first_timer,
                "timer_count": timers,
            }
        )
        first_timer += timers
    return {
        "levels": levels,
        "task_count": len(plan.tasks),
        "timer_count": first_timer,
        "watched": watched(plan),
    }


def depth(plan: Plan, topic: TopicPlan) -> int:
    """As planned; but a reader that outranks its publisher does not run inside the publication
    here, so that the burst of one activation is to be held for it, too."""
    if not topic.publishers or plan.graph.topics[topic.name].config.depth is not None:
        return topic.depth
    bursts = [
        output.port.burst
        for name in topic.publishers
        for output in plan.graph.nodes[name].outputs.values()
        if output.topic == topic.name
    ]
    return next(depth for depth in DEPTHS if depth >= max(topic.depth, *bursts))


def slots(plan: Plan, topic: TopicPlan) -> int:
    """D + sum over levels of the most slots that one job holds besides: levels truly run at once.
    docs/topics.md has the argument."""
    readers = {name for name, _ in topic.readers}
    if topic.log_us is not None:
        readers |= {t.node.name for t in plan.tasks if t.node.interface.reads_log}
    held: dict[int, int] = {}
    for name in sorted(readers | set(topic.publishers)):
        level = plan.task(name).level
        held[level] = max(held.get(level, 0), (name in readers) + (name in topic.publishers))
    by_the_start = 0 if topic.publishers else 1  # which publishes parameters
    return depth(plan, topic) + sum(held.values()) + by_the_start
