"""How many samples of a topic can be unread at once: the depth that loses none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.prove.system import burst_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from stator.plan.plan import Plan
    from stator.plan.topics import TopicPlan
    from stator.prove.streams import Stream
    from stator.prove.system import Solution


@dataclass(frozen=True)
class QueueBound:
    """Of the reader that can be the furthest behind."""

    topic: str
    reader: str
    depth: int
    needed: int | None  # None: unbounded

    @property
    def lost(self) -> int | None:
        """Samples that the reader can lose in one such moment; each is counted at run time."""
        return None if self.needed is None else max(0, self.needed - self.depth)


def bound_queues(plan: Plan, solutions: Iterable[Solution]) -> tuple[QueueBound, ...]:
    found = []
    for topic in plan.topics.values():
        rows = [row for solution in solutions for row in _readers(plan, topic, solution)]
        if rows:
            found.append(max(rows, key=lambda row: (row.needed is None, row.needed or 0)))
    return tuple(found)


def _readers(plan: Plan, topic: TopicPlan, solution: Solution) -> Iterator[QueueBound]:
    graph = plan.graph
    running = {job.name for job in solution.jobs}
    for name, port in topic.readers:
        if topic.owner or name not in running:
            continue
        way = graph.nodes[name].way_of(graph.nodes[name].inputs[port])
        if way == "trigger":
            needed = _woken(solution, topic.name, name)
            if needed is not None and all(
                plan.task(name).level > plan.task(other).level for other in topic.publishers
            ):
                # It runs inside each publication, and one publisher at a time can be interrupted.
                needed = min(needed, 1)
            yield QueueBound(topic.name, name, topic.depth, needed)
        elif way == "queue":
            yield QueueBound(topic.name, name, topic.depth, _read(plan, topic, solution, name))
    for name in running & graph.nodes.keys():
        if graph.nodes[name].interface.reads_log and topic.log_us == 0:
            yield QueueBound(topic.name, name, topic.depth, _read(plan, topic, solution, name))


def _woken(solution: Solution, topic: str, name: str) -> int | None:
    """Each activation takes one. A sample is taken before the response time is over."""
    response = solution.responses.get(name)
    if response is None:
        return None
    streams = [w.stream for w in solution.wakes[name] if w.topic in (topic, "")]
    return sum(stream.most(response.from_arrival) for stream in streams)


def _read(plan: Plan, topic: TopicPlan, solution: Solution, name: str) -> int | None:
    """Each activation takes all."""
    response = solution.responses.get(name)
    published = list(_published(plan, topic, solution))
    if response is None or None in published:
        return None
    gap = min(wake.gap for wake in solution.wakes[name])
    streams = [stream for stream in published if stream is not None]
    return sum(stream.most(gap + response.from_arrival) for stream in streams)


def _published(plan: Plan, topic: TopicPlan, solution: Solution) -> Iterator[Stream | None]:
    running = {job.name for job in solution.jobs}
    for name in topic.publishers:
        if name not in running:
            continue
        response = solution.responses.get(name)
        if response is None:
            yield None
            continue
        for wake in solution.wakes[name]:
            stream = wake.stream.times(burst_of(plan, name, topic.name))
            yield stream.late(response.late(wake.stream))
