"""Rows of what an executor of threads needs besides the tasks: its levels, and larger topics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.emit.rows import watched
from stator.graph.checks.parts import MODE_TOPIC
from stator.language.keys import DEPTHS
from stator.plan.hash import graph_hash

if TYPE_CHECKING:
    from stator.emit.rows import WatchedRow
    from stator.plan.plan import Plan
    from stator.plan.topics import TopicPlan


@dataclass(frozen=True)
class LevelRow:
    priority: int
    first_task: int
    task_count: int
    first_timer: int
    timer_count: int


@dataclass(frozen=True)
class ThreadProgram:
    levels: list[LevelRow]
    task_count: int
    timer_count: int
    watched: list[WatchedRow]
    topics: list[str]
    board: str
    graph: str
    graph_hash: str


def program(plan: Plan) -> ThreadProgram:
    first_timer = 0
    levels = []
    for level in plan.levels:
        tasks = [task for task in plan.tasks if task.level == level]
        timers = sum(t.kind == "every" for task in tasks for t in task.node.triggers)
        levels.append(LevelRow(level, tasks[0].level_begin, len(tasks), first_timer, timers))
        first_timer += timers
    return ThreadProgram(
        levels=levels,
        task_count=len(plan.tasks),
        timer_count=first_timer,
        watched=watched(plan),
        topics=list(plan.topics),
        board=plan.board.name,
        graph=plan.graph.name,
        graph_hash=graph_hash(plan),
    )


def depth(plan: Plan, topic: TopicPlan) -> int:
    """The planned depth, or the burst of one activation if it is larger: with threads, a reader
    that outranks its publisher does not run inside the publication."""
    if topic.owner or plan.graph.topics[topic.name].config.depth is not None:
        return topic.depth
    bursts = [
        output.port.burst
        for name in topic.publishers
        for output in plan.graph.nodes[name].outputs.values()
        if output.topic == topic.name
    ]
    return next(depth for depth in DEPTHS if depth >= max(topic.depth, *bursts))


def slots(plan: Plan, topic: TopicPlan) -> int:
    """D plus the samples that each level can hold, because levels run at the same time: the newest
    sample that it has read, one from the queue, and one that it builds; plus the newest sample
    that the link has sent. docs/topics.md has the argument."""
    held = {(name, _hold(plan, name, port)) for name, port in topic.readers}
    held |= {(name, "loan") for name in topic.publishers}
    if topic.owner:
        held |= {(name, "latest") for name in topic.publishers}
    if topic.log_us is not None or (topic.owner and topic.publishers):
        kind = "next" if topic.log_us == 0 else "latest"
        held |= {(t.node.name, kind) for t in plan.tasks if t.node.interface.reads_log}
    modes = plan.graph.modes
    if modes is not None and topic.name == MODE_TOPIC:
        held.add((modes.publisher, "latest"))  # the switch follows the newest
    by_the_start = 0 if topic.publishers else 1  # which publishes parameters
    levels = {(plan.task(name).level, kind) for name, kind in held}
    of_the_link = 1
    return depth(plan, topic) + len(levels) + by_the_start + of_the_link


def _hold(plan: Plan, name: str, port: str) -> str:
    node = plan.graph.nodes[name]
    is_next = port in node.inputs and node.way_of(node.inputs[port]) in ("trigger", "queue")
    return "next" if is_next else "latest"
