"""The worst window of a task as a schedule: who runs when. Every job comes as early as it may, all
first activations at once, behind the one that has just begun."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.prove.streams import arrivals

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stator.prove.proof import TaskBound


@dataclass(frozen=True)
class Run:
    """A job without a pause, in ns from the begin of the window."""

    name: str
    begin: int
    end: int


@dataclass
class _Waiting:
    comes: int
    level: int
    place: int  # in the order within its level; the first one runs first
    name: str
    left: int
    has_begun: bool = False


def timeline(task: TaskBound) -> list[Run]:
    """Up to the end of the activation that responds last; empty without a bound."""
    if task.window is None:
        return []
    waiting = sorted(_activations(task), key=lambda job: job.comes)
    runs: list[Run] = []
    now = 0
    while now < task.window.end:
        ready = [job for job in waiting if job.comes <= now and job.left]
        later = min((job.comes for job in waiting if job.comes > now), default=task.window.end)
        if not ready:
            now = later
            continue
        # A level preempts those below it; within a level, the one that has begun goes on.
        job = max(ready, key=lambda job: (job.level, job.has_begun, -job.place))
        job.has_begun = True
        until = min(now + job.left, later, task.window.end)
        job.left -= until - now
        if runs and runs[-1].name == job.name and runs[-1].end == now:
            runs[-1] = Run(job.name, runs[-1].begin, until)
        else:
            runs.append(Run(job.name, now, until))
        now = until
    return runs


def _activations(task: TaskBound) -> Iterator[_Waiting]:
    assert task.window is not None
    own = task.shares[0]
    assert own.job is not None
    times = arrivals(own.job.streams, task.window.number) or [0]
    last = len(task.shares)
    for comes in times:
        yield _Waiting(comes, task.level, last, task.name, own.job.cost)
    for place, share in enumerate(task.shares[1:]):
        if share.job is None:  # what blocks has begun just before the window
            yield _Waiting(0, task.level, -1, share.name, share.cost, has_begun=True)
            continue
        for stream, number in zip(share.job.streams, share.numbers, strict=True):
            for i in range(1, number * stream.count + 1):
                level, cost = share.job.level, share.job.cost
                yield _Waiting(stream.earliest(i), level, place, share.name, cost)
