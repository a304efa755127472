"""Worst response times on one processor whose interrupt controller is the scheduler.

A level preempts every lower one. Within a level nothing preempts, and of the jobs that wait the
first in the planned order runs (fixed-priority scheduling with preemption thresholds: Wang and
Saksena 1999; Keskin, Bril and Lukkien 2010). A level with one job is the usual preemptive case
(Lehoczky 1990; Tindell, Burns and Wellings 1994). Times are whole numbers of one unit.

Each activation in the busy window counts, not only the first: without preemption a later one can
be the worst (Davis, Burns, Bril and Lukkien 2007).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from stator.prove.streams import Stream, arrivals

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Integers = NDArray[np.int64]

# A busy window that grows beyond this has no end in practice: 100 s, in ns.
LONGEST = 10**11
FAR = 2**62 // 2


@dataclass(frozen=True)
class Job:
    name: str
    level: int  # a higher one is more urgent
    cost: int  # of one activation, with entry and exit
    streams: tuple[Stream, ...]
    section: int = 0  # the longest section of a less urgent job that keeps this one out


@dataclass(frozen=True)
class Share:
    """What a job takes of a response."""

    name: str
    cost: int
    # How many activations of each of its streams, as the job at hand sees them.
    job: Job | None = None
    numbers: tuple[int, ...] = ()


@dataclass(frozen=True)
class Response:
    """Of one job. Both count to the end of the latest activation."""

    from_arrival: int
    # From the time at which a source without jitter would have come; with several sources, from
    # the arrival plus the largest jitter.
    from_source: int
    window: int  # the longest time without a pause at its level and above
    # Of the activation that responds last after its arrival: its number in the window, its begin
    # and its end there.
    number: int
    start: int
    end: int
    run: int  # the longest time from the begin of an activation to its end

    def late(self, stream: Stream) -> int:
        """The latest end of an activation by this stream, counted from its source."""
        return min(self.from_arrival + stream.jitter, self.from_source)


def responses(jobs: Sequence[Job]) -> list[Response | None]:
    """For each job; None: unbounded. `jobs`: the most urgent first, those of a level in
    their planned order."""
    processor = Processor(jobs)
    return [processor.response(i) for i in range(len(jobs))]


class Processor:
    """Jobs, the most urgent first, those of a level in their planned order. `others`: less urgent
    ones that are not bounded, but may have begun."""

    def __init__(self, jobs: Sequence[Job], others: Sequence[Job] = ()) -> None:
        self._jobs = list(jobs)
        rows = [(job, stream) for job in jobs for stream in job.streams]
        self._period = _column(stream.period for _, stream in rows)
        self._jitter = _column(stream.jitter for _, stream in rows)
        distances = [stream.distance for _, stream in rows]
        self._distance = _column(distance or FAR for distance in distances)
        self._free = np.array([not distance for distance in distances], dtype=bool)
        self._cost = _column(stream.count * job.cost for job, stream in rows)
        self._first = list(accumulate((len(job.streams) for job in jobs), initial=0))
        # The first job of each job's level, and the end of the level.
        begin: dict[int, int] = {}
        self._begin = [begin.setdefault(job.level, i) for i, job in enumerate(jobs)]
        self._blocker = _blockers([*jobs, *others])
        loads = (Fraction(s.count * job.cost, s.period) for job, s in rows)
        load = list(accumulate(loads, initial=Fraction(0)))
        self._load = [load[end] for end in self._first[1:]]

    def replace_streams(self, i: int, streams: tuple[Stream, ...]) -> None:
        """By as many others, of the same periods and counts."""
        self._jobs[i] = replace(self._jobs[i], streams=streams)
        for k, stream in enumerate(streams, self._first[i]):
            self._jitter[k] = stream.jitter
            self._distance[k] = stream.distance or FAR
            self._free[k] = not stream.distance

    def response(self, i: int) -> Response | None:
        """None: unbounded."""
        job = self._jobs[i]
        if not job.streams:
            return Response(job.cost, job.cost, job.cost, 1, 0, job.cost, job.cost)
        if self._load[i] > 1:
            return None
        blocked = self._blocker[i].cost
        window = self._window(i, blocked)
        run = self._longest_run(i)
        if window is None or run is None:
            return None
        number = sum(stream.most(window) for stream in job.streams)
        earliest = arrivals(job.streams, number)
        only = job.streams[0] if len(job.streams) == 1 else None
        start, worst, from_source = 0, (-1, 0, 0, 0), 0
        for q in range(1, number + 1):
            start = self._start(i, q, blocked, start)
            end = self._end(i, start)
            worst = max(worst, (end - earliest[q - 1], q, start, end))
            if only is not None:
                source = (q - 1) // only.count * only.period - only.jitter
                from_source = max(from_source, end - source)
        from_arrival = worst[0]
        if only is None:
            from_source = from_arrival + max(stream.jitter for stream in job.streams)
        return Response(from_arrival, from_source, window, *worst[1:], run)

    def _window(self, i: int, blocked: int) -> int | None:
        end = self._first[i + 1]
        window = blocked + int(self._cost[:end].sum())
        while window <= LONGEST:
            more = blocked + self._sum(window, 0, end)
            if more == window:
                return window
            window = more
        return None

    def _start(self, i: int, q: int, blocked: int, known: int) -> int:
        """When the q-th activation of the window begins at the latest."""
        end = self._first[i]
        own = blocked + (q - 1) * self._jobs[i].cost
        start = max(known, own)
        while True:
            later = own + self._sum_closed(start, 0, end)
            if later == start:
                return start
            start = later

    def _end(self, i: int, start: int) -> int:
        """Once it has begun, only higher levels come between."""
        above = self._first[self._begin[i]]
        fixed = start + self._jobs[i].cost - self._sum_closed(start, 0, above)
        end = start + self._jobs[i].cost
        while True:
            later = fixed + self._sum(end, 0, above, at_least=start)
            if later == end:
                return end
            end = later

    def _sum(self, window: int, begin: int, end: int, at_least: int | None = None) -> int:
        """What these streams take in a window without its end; at least what they take in a
        shorter one with its end."""
        part = slice(begin, end)
        number = self._most(window, part)
        if at_least is not None:
            number = np.maximum(number, self._closed(at_least, part))
        return int(number @ self._cost[part])

    def _sum_closed(self, window: int, begin: int, end: int) -> int:
        part = slice(begin, end)
        return int(self._closed(window, part) @ self._cost[part])

    def _most(self, window: int, part: slice) -> Integers:
        number = -(-(window + self._jitter[part]) // self._period[part])
        most = np.where(self._free[part], number, -(-window // self._distance[part]))
        found: Integers = np.minimum(number, most)
        return found

    def _closed(self, window: int, part: slice) -> Integers:
        number = (window + self._jitter[part]) // self._period[part] + 1
        most = np.where(self._free[part], number, window // self._distance[part] + 1)
        found: Integers = np.minimum(number, most)
        return found

    def _longest_run(self, i: int) -> int | None:
        """From the begin of an activation to its end, with what comes between."""
        job, above = self._jobs[i], self._first[self._begin[i]]
        run = job.cost
        while run <= LONGEST:
            more = job.cost + self._sum(run, 0, above)
            if more == run:
                return run
            run = more
        return None

    def shares(self, i: int, response: Response) -> tuple[Share, ...]:
        """Who takes how much of the time from the start of the window to the end of the worst
        activation: the job itself, what it waits for, and the more urgent jobs."""
        job = self._jobs[i]
        above, own = self._first[self._begin[i]], self._first[i]
        number = self._closed(response.start, slice(0, own))
        number[:above] = np.maximum(number[:above], self._most(response.end, slice(0, above)))
        taken = number * self._cost[:own]
        found = [Share(job.name, response.number * job.cost, job), self._blocker[i]]
        for k, other in enumerate(self._jobs[:i]):
            part = slice(self._first[k], self._first[k + 1])
            numbers = tuple(number[part].tolist())
            found.append(Share(other.name, int(taken[part].sum()), other, numbers))
        return tuple(share for share in found if share.cost)


def _blockers(jobs: Sequence[Job]) -> list[Share]:
    """For each job: the one less urgent job that has just begun, or its section."""
    found: list[Share] = []
    peer = Share("", 0)
    for i in range(len(jobs) - 1, -1, -1):
        job = jobs[i]
        if i + 1 == len(jobs) or jobs[i + 1].level != job.level:
            peer = Share("", 0)
        else:
            peer = max(peer, Share(jobs[i + 1].name, jobs[i + 1].cost), key=lambda s: s.cost)
        section = Share("a section", job.section)
        found.append(max(section, peer, key=lambda s: s.cost))
    return found[::-1]


def _column(values: object) -> Integers:
    return np.fromiter(values, dtype=np.int64)  # type: ignore[call-overload,no-any-return]
