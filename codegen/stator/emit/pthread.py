"""Rows of what an executor of threads needs besides the tasks: its levels, and larger topics."""

from __future__ import annotations

from collections import Counter, defaultdict
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
    if any(plan.graph.nodes[name].interface.reads_log for name in topic.publishers):
        return DEPTHS[-1]  # a busy machine may keep the storage waiting, and has the memory
    bursts = [
        output.port.burst
        for name in topic.publishers
        for output in plan.graph.nodes[name].outputs.values()
        if output.topic == topic.name
    ]
    return next(depth for depth in DEPTHS if depth >= max(topic.depth, *bursts))


def slots(plan: Plan, topic: TopicPlan) -> int:
    """D plus the samples that each level can hold, because levels run at the same time: the newest
    sample that it has read, those that one job reads beside it, one from the queue, and one that
    it builds; plus the newest sample that the link has sent. docs/topics.md has the argument."""
    holds: dict[str, Counter[str]] = defaultdict(Counter)
    for name, port in topic.readers:
        if port:  # else the publisher of parameters, see below
            holds[name][_hold(plan, name, port)] += 1
    if topic.log_us is not None or (topic.owner and topic.publishers):
        kind = "next" if topic.log_us == 0 else "latest"
        for task in plan.tasks:
            if task.node.interface.reads_log:
                holds[task.node.name][kind] += 1
    for task in plan.tasks:
        if task.node.interface.reads_graph:
            holds[task.node.name]["latest"] = max(holds[task.node.name]["latest"], 1)
    modes = plan.graph.modes
    for name in topic.publishers:
        holds[name]["loan"] = 1
        # It looks at what it has published last, for parameters and for the switch. While it does,
        # that sample is in the ring; its level keeps it.
        if topic.owner or (modes is not None and topic.name == MODE_TOPIC):
            holds[name]["latest"] = max(holds[name]["latest"], 1)
    levels: dict[int, Counter[str]] = defaultdict(Counter)
    for name, counts in holds.items():
        levels[plan.task(name).level] |= counts  # the greater of each kind
    held = sum(counts.total() for counts in levels.values())
    by_the_start = 0 if topic.publishers else 1  # which publishes parameters
    of_the_link = 1
    return depth(plan, topic) + held + by_the_start + of_the_link


def _hold(plan: Plan, name: str, port: str) -> str:
    node = plan.graph.nodes[name]
    is_next = port in node.inputs and node.way_of(node.inputs[port]) in ("trigger", "queue")
    return "next" if is_next else "latest"
