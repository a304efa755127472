"""A processor that runs a graph, event by event. It shares no code with the prover: it knows jobs,
pending bits, levels and samples, and measures how late each activation ends. Times are ns.

Execution times are random up to the budget, or equal to it. Lines come as fast as they may, all at
the same time, or later.
"""

from __future__ import annotations

import heapq
import random
from collections import defaultdict, deque
from dataclasses import dataclass, field

Root = tuple[int, tuple[str, ...]]  # when the first source came, and the tasks since then


@dataclass
class Task:
    name: str
    level: int
    order: int  # in its level
    budget: int
    lines: list[int] = field(default_factory=list)  # the least time between two
    timers: list[tuple[int, int]] = field(default_factory=list)  # period, offset
    topics: list[tuple[str, int]] = field(default_factory=list)  # and the least interval, or 0
    # Topic, publications in an activation, and the levels that a section around each one masks.
    outputs: list[tuple[str, int, int]] = field(default_factory=list)
    handler: str = ""  # of its lines; empty: the line pends the task itself


@dataclass
class Handler:
    name: str
    level: int
    order: int
    cost: int


@dataclass
class Seen:
    """The worst of each."""

    from_root: dict[tuple[str, tuple[str, ...]], int] = field(default_factory=dict)
    unread: dict[tuple[str, str], int] = field(default_factory=dict)  # of a topic, by a reader
    activations: int = 0


@dataclass
class _Run:
    """An activation that has begun: what is left of it, in steps."""

    name: str
    level: int
    order: int
    steps: deque[tuple[int, str, int]]  # time, what is done at its end, mask meanwhile
    roots: list[Root]
    thinned_roots: list[Root]


class Machine:
    def __init__(
        self, tasks: list[Task], handlers: list[Handler], section: int, dice: random.Random
    ) -> None:
        self._tasks = {task.name: task for task in tasks}
        self._handlers = {handler.name: handler for handler in handlers}
        self._section = section
        self._dice = dice
        self._full = dice.random() < 0.6  # each activation takes its whole budget
        self._events: list[tuple[int, int, str, str, int]] = []
        self._count = 0
        self._now = 0
        self._pending: set[str] = set()
        self._stack: list[_Run] = []
        self._raised: dict[str, list[tuple[str, int]]] = defaultdict(list)  # handler: task, time
        self._fired: dict[str, list[int]] = defaultdict(list)  # nominal times
        self._unread: dict[tuple[str, str], deque[Root]] = defaultdict(deque)
        self._due: dict[tuple[str, str], int] = {}
        self._thinned: dict[str, list[Root]] = defaultdict(list)
        self._readers: dict[str, list[tuple[Task, int]]] = defaultdict(list)
        for task in tasks:
            for topic, interval in task.topics:
                self._readers[topic].append((task, interval))
        self.seen = Seen()

    def run(self, horizon: int) -> Seen:
        together = self._dice.random() < 0.5
        for task in self._tasks.values():
            for least in task.lines:
                first = 0 if together else self._dice.randrange(least)
                self._at(first, "line", task.name, least)
            for period, offset in task.timers:
                self._at(offset, "timer", task.name, period)
        while self._events:
            time, _, kind, name, number = heapq.heappop(self._events)
            if time > horizon:
                break
            if time > self._now:  # what comes at one instant comes before anything runs
                self._work_until(time)
            self._occur(kind, name, number)
        self._work_until(horizon + 10**9)
        return self.seen

    def _at(self, time: int, kind: str, name: str, number: int) -> None:
        self._count += 1
        heapq.heappush(self._events, (time, self._count, kind, name, number))

    def _occur(self, kind: str, name: str, number: int) -> None:
        task = self._tasks[name]
        if kind == "line":
            late = 0 if self._dice.random() < 0.8 else self._dice.randrange(number)
            self._at(self._now + number + late, kind, name, number)
            if task.handler:
                self._raised[task.handler].append((name, self._now))
            else:
                self._fired[name].append(self._now)
            self._pending.add(task.handler or name)
        else:
            self._at(self._now + number, kind, name, number)
            self._raised["timers"].append((name, self._now))
            self._pending.add("timers")

    # --- the processor ---

    def _work_until(self, end: int) -> None:
        while True:
            self._preempt()
            if not self._stack:
                self._now = max(self._now, end)
                return
            run = self._stack[-1]
            time, what, mask = run.steps[0]
            if self._now + time > end:
                run.steps[0] = (time - (end - self._now), what, mask)
                self._now = end
                return
            self._now += time
            run.steps.popleft()
            self._do(run, what)

    def _preempt(self) -> None:
        """Begins what is more urgent than what runs, and not masked."""
        while self._pending:
            name = min(self._pending, key=self._urgency)
            job = self._tasks.get(name) or self._handlers[name]
            floor = 0
            if self._stack:
                floor = max(self._stack[-1].level, self._stack[-1].steps[0][2])
            if job.level <= floor:
                return
            self._pending.discard(name)
            self._begin(job)

    def _urgency(self, name: str) -> tuple[int, int]:
        job = self._tasks.get(name) or self._handlers[name]
        return (-job.level, job.order)

    def _begin(self, job: Task | Handler) -> None:
        if isinstance(job, Handler):
            before = self._dice.randrange(job.cost + 1)
            steps = [(before, "pend", 0), (job.cost - before, "end", 0)]
            self._stack.append(_Run(job.name, job.level, job.order, deque(steps), [], []))
            return
        roots: list[Root] = [(time, (job.name,)) for time in self._fired.pop(job.name, [])]
        for topic, interval in job.topics:
            unread = self._unread[topic, job.name]
            if not interval and unread:
                time, path = unread.popleft()
                roots.append((time, (*path, job.name)))
        thinned = [(time, (*path, job.name)) for time, path in self._thinned.pop(job.name, [])]
        run = _Run(job.name, job.level, job.order, deque(), roots, thinned)
        run.steps = deque(self._steps(job) if roots or thinned else [(0, "end", 0)])
        self.seen.activations += bool(roots or thinned)
        self._stack.append(run)

    def _steps(self, task: Task) -> list[tuple[int, str, int]]:
        """Publications at any time within the execution, each in its section."""
        least = task.budget if self._full else task.budget // 2
        total = self._dice.randint(least, task.budget)
        wanted = [(t, mask) for t, count, mask in task.outputs for _ in range(count)]
        masked = sum(self._section for _, mask in wanted if mask)
        free = max(0, total - masked)
        cuts = sorted(self._dice.choice((0, free, self._dice.randrange(free + 1))) for _ in wanted)
        steps, at = [], 0
        for cut, (topic, mask) in zip(cuts, wanted, strict=True):
            steps.append((cut - at, "", 0))
            steps.append((min(self._section, total) if mask else 0, f"publish {topic}", mask))
            at = cut
        return [*steps, (free - at, "end", 0)]

    def _do(self, run: _Run, what: str) -> None:
        if what == "pend":
            for name, time in self._raised.pop(run.name, []):
                self._fired[name].append(time)
                self._pending.add(name)
        elif what.startswith("publish "):
            self._publish(run, what.removeprefix("publish "))
        elif what == "end":
            self._stack.pop()
            if run.name in self._tasks:
                self._finish(run)

    def _publish(self, run: _Run, topic: str) -> None:
        """The newest source that woke the publisher gives the sample its time."""
        root = max(run.roots + run.thinned_roots)
        for task, interval in self._readers[topic]:
            if not interval:
                unread = self._unread[topic, task.name]
                for source in run.roots + run.thinned_roots:
                    if source == root:
                        unread.append(source)
                key = (topic, task.name)
                self.seen.unread[key] = max(self.seen.unread.get(key, 0), len(unread))
                self._pending.add(task.name)
                continue
            due = self._due.setdefault((topic, task.name), root[0])
            if root[0] >= due:
                missed = (root[0] - due) // interval
                self._due[topic, task.name] = due + (missed + 1) * interval
                self._thinned[task.name].append(root)
                self._pending.add(task.name)

    def _finish(self, run: _Run) -> None:
        for time, path in run.roots + run.thinned_roots:
            key = (run.name, path)
            self.seen.from_root[key] = max(self.seen.from_root.get(key, 0), self._now - time)
        for topic, interval in self._tasks[run.name].topics:
            if not interval and self._unread[topic, run.name]:
                self._pending.add(run.name)
