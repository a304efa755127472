"""What the processor runs for a graph, what wakes it, and the responses that follow.

A publication wakes its subscribers while the publisher runs, so the jitter of a subscriber is the
publisher's response, and both grow together until nothing changes (compositional performance
analysis: Richter 2005; pyCPA).

Publishers that are more urgent than task i add no jitter in its window. From the arrival of a
source until the last job that it wakes has ended, one of these jobs is always waiting or running,
if all of them are more urgent than i. So they count as if they came with their source. Only the
publishers that are less urgent than i delay those behind them. This also bounds the time from the
source to the end of i."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stator.plan.log_rate import blocks_at_once
from stator.plan.plan import owns_its_vector, vector_of
from stator.plan.rates import Rates, publishers_first
from stator.prove.response import LONGEST, Job, Processor, Response, Share
from stator.prove.streams import ONCE, Stream, thinned

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from stator.graph.model import Costs, Node, Trigger
    from stator.plan.plan import Plan

US = 1000  # ns
BOARD_LEVEL = 16  # hardware priority 0, above every level of a graph
RELEASE = "the timer's handler"
# The timer for periods is armed again at least so often (runtime/cortex_m/release.cpp).
LONGEST_SLEEP_US = 50_000
SYSTICK = -1  # where it stands in the order of vectors: before all of them
MOST_STREAMS = 12  # of one task; beyond, those of one period are joined


@dataclass(frozen=True)
class Wake:
    """One source that wakes a task. The jitter of its stream counts from the source."""

    stream: Stream
    path: tuple[str, ...] = ()  # the tasks through which it comes, the first one first
    topic: str = ""  # each sample of which wakes
    interval: int = 0  # of a reader that not every sample wakes
    source_period: int = 0  # of these samples

    @property
    def gap(self) -> int:
        """The longest time to the next arrival, if the source comes as often as it may. An interval
        ends, and then a sample comes."""
        if self.interval:
            return self.stream.jitter + self.source_period
        return self.stream.period + self.stream.jitter


Wakes = tuple[Wake, ...]


@dataclass(frozen=True)
class Solution:
    """Bounds of the jobs of some nodes that run at one time."""

    jobs: tuple[Job, ...]  # the most urgent first; their streams as they see them themselves
    responses: dict[str, Response]  # without those that have no bound
    shares: dict[str, tuple[Share, ...]]
    wakes: dict[str, Wakes]

    def from_release(self, name: str) -> int | None:
        """The worst time from what releases a task to its end. A period releases it at its nominal
        time, a line when it is raised, a topic when a more urgent publisher's source came, or at
        the publication by a less urgent one."""
        response = self.responses.get(name)
        if response is None:
            return None
        ends = [
            response.late(wake.stream) if len(wake.path) == 1 else response.from_arrival
            for wake in self.wakes[name]
        ]
        return max(ends, default=response.from_arrival)


@dataclass(frozen=True)
class _Entry:
    name: str
    level: int
    vector: int
    cost: int


class System:
    """`budgets`: of all nodes, in ns. `nodes`: those that run. `switched`: those of them that a
    change of the mode may start. `changes`: the mode may change again and again, and not only
    once while a task waits."""

    def __init__(
        self,
        plan: Plan,
        budgets: Mapping[str, int],
        nodes: Collection[str] | None = None,
        switched: Collection[str] = (),
        *,
        changes: bool = False,
    ) -> None:
        assert plan.board.costs is not None
        self._plan = plan
        self._budgets = budgets
        self._costs: Costs = plan.board.costs
        self._nodes = set(plan.graph.nodes if nodes is None else nodes)
        self._switched = set(switched)
        self._changes = changes
        self._order = [name for name in publishers_first(plan.graph) if name in self._nodes]
        self._lines = self._dispatched_lines()
        self._timers = self._release_streams()
        self._entries = sorted(self._all_entries(), key=lambda e: (-e.level, e.vector))
        self._place = {entry.name: i for i, entry in enumerate(self._entries)}
        self._woken: dict[str, list[str]] = defaultdict(list)
        for name in self._order:
            for waker in self._wakers(name):
                self._woken[waker].append(name)

    def solve(self) -> Solution:
        """What has no bound takes the bounds of all that it can delay or wake; the rest is solved
        without it."""
        count = len(self._entries)
        while True:
            found = self._fixpoint(count)
            solved = found.responses.keys()
            bad = {entry.name for entry in self._entries[:count] if entry.name not in solved}
            bad |= self._behind(bad | {entry.name for entry in self._entries[count:]})
            if not bad & {entry.name for entry in self._entries[:count]}:
                return found
            count = min(self._place[name] for name in bad)

    def _fixpoint(self, count: int) -> Solution:
        known: dict[str, Response] = {}
        while True:
            found = self._pass(count, known)
            if found.responses == known or len(found.responses) < count:
                return found
            known = found.responses

    def _behind(self, names: Collection[str]) -> set[str]:
        """Those that these wake, and so on."""
        waiting, found = list(names), set[str]()
        while waiting:
            new = [name for name in self._woken[waiting.pop()] if name not in found]
            found.update(new)
            waiting += new
        return found

    def _pass(self, count: int, known: Mapping[str, Response]) -> Solution:
        """From the least urgent job up. To those above it, a job that is done is a publisher that
        may be late."""
        done: dict[str, Response] = {}
        own: dict[str, Wakes] = {}
        seen = self._sources(known)  # what wakes each task, as the job at hand sees it
        for name in self._order:
            seen[name] = self._wakes(name, known, seen, done, own)
        entries = self._entries[:count]
        all_jobs = [self._job(entry, seen.get(entry.name, ())) for entry in self._entries]
        processor = Processor(all_jobs[:count], all_jobs[count:])
        jobs, blamed = [], {}
        for i, entry in reversed(list(enumerate(entries))):
            name = entry.name
            jobs.append(self._job(entry, seen[name]))
            response = processor.response(i)
            if response is None or _is_endless(seen[name]):
                continue
            own[name], done[name] = seen[name], response
            blamed[name] = processor.shares(i, response)
            behind = self._behind([name])
            for other in self._order if behind else ():
                if other in behind:
                    seen[other] = self._wakes(other, known, seen, done, own)
                    if self._place[other] < i:
                        streams = tuple(wake.stream for wake in seen[other])
                        processor.replace_streams(self._place[other], streams)
        return Solution((*reversed(jobs), *all_jobs[count:]), done, blamed, own)

    def _wakers(self, name: str) -> list[str]:
        """The jobs that wake a task."""
        node = self._plan.graph.nodes[name]
        found = []
        for trigger in node.triggers:
            if trigger.kind == "every":
                found.append(RELEASE)
            elif trigger.kind == "topic":
                found += self._publishers(trigger)
            else:
                found += self._handlers(name, trigger)
        return found

    # --- jobs ---

    def _all_entries(self) -> list[_Entry]:
        costs = self._costs
        found = [
            _Entry(
                task.node.name,
                task.level,
                task.index if task.vector is None else task.vector,
                self._budgets[task.node.name] + costs.task_ns,
            )
            for task in self._plan.tasks
            if task.node.name in self._nodes
        ]
        if self._timers:
            count = sum(t.kind == "every" for n in self._all_nodes() for t in n.triggers)
            found.append(
                _Entry(
                    RELEASE, self._timer_level(), SYSTICK, costs.release_ns + count * costs.timer_ns
                )
            )
        for handler, (vector, lines) in self._lines.items():
            level = max(self._plan.task(name).level for name, _ in lines)
            cost = costs.dispatch_ns + len(lines) * costs.line_ns
            found.append(_Entry(handler, level, vector, cost))
        chip = self._plan.board.chip
        for name, row in self._board_interrupts():
            vector = 0 if chip is None else chip.vectors.get(name, 0)
            found.append(_Entry(f"interrupt {name}", BOARD_LEVEL, vector, row))
        return found

    def _job(self, entry: _Entry, wakes: Wakes = ()) -> Job:
        streams = tuple(wake.stream for wake in wakes)
        return Job(entry.name, entry.level, entry.cost, streams, self._section(entry.level))

    def _section(self, level: int) -> int:
        """Whether a less urgent job may mask this level for a moment."""
        for topic in self._plan.topics.values():
            if topic.ceiling >= level and any(
                self._plan.task(name).level < level
                for name in topic.publishers
                if name in self._nodes
            ):
                return self._costs.section_ns
        return 0

    def _all_nodes(self) -> list[Node]:
        return [task.node for task in self._plan.tasks]

    def _timer_level(self) -> int:
        return max(
            task.level
            for task in self._plan.tasks
            if any(trigger.kind == "every" for trigger in task.node.triggers)
        )

    def _board_interrupts(self) -> list[tuple[str, int]]:
        """Their costs. One that serves devices counts where the graph has one of these."""
        buses: dict[str, bool] = defaultdict(bool)
        used = {node.device for node in self._all_nodes()}
        for device in self._plan.board.devices.values():
            buses[device.bus] = buses[device.bus] or device.name in used
        return [
            (name, row.budget_ns)
            for name, row in self._costs.interrupts.items()
            if buses.get(name, True)
        ]

    def _dispatched_lines(self) -> dict[str, tuple[int, list[tuple[str, str]]]]:
        """The handlers of vectors that are not one task's alone: vector, and the lines (node, line)
        that it serves."""
        chip = self._plan.board.chip
        found: dict[str, tuple[int, list[tuple[str, str]]]] = {}
        if chip is None:
            return found
        names = {number: name for name, number in chip.vectors.items()}
        for task in self._plan.tasks:
            if task.node.name not in self._nodes or task.node.device is None:
                continue
            device = self._plan.board.devices[task.node.device]
            for trigger in task.node.triggers:
                if trigger.kind != "irq" or owns_its_vector(self._plan, task):
                    continue
                for wire in device.lines.get(trigger.name, ()):
                    vector = chip.vectors[vector_of(wire)]
                    handler = f"the handler of {names[vector]}"
                    row = found.setdefault(handler, (vector, []))
                    row[1].append((task.node.name, trigger.name))
        return found

    # --- what wakes them ---

    def _release_streams(self) -> list[Stream]:
        """Instants at which some period begins. One that always coincides with one of a shorter
        period is the same activation of the handler."""
        times = sorted(
            {
                (trigger.period_us, trigger.offset_us % trigger.period_us)
                for node in self._all_nodes()
                for trigger in node.triggers
                if trigger.kind == "every"
            }
        )
        kept: list[tuple[int, int]] = []
        for period, offset in times:
            if not any(period % p == 0 and (offset - o) % p == 0 for p, o in kept):
                kept.append((period, offset))
        if kept and min(kept)[0] > LONGEST_SLEEP_US:
            kept.append((LONGEST_SLEEP_US, 0))
        return [Stream(period * US) for period, _ in kept]

    def _sources(self, known: Mapping[str, Response]) -> dict[str, Wakes]:
        """What wakes the jobs that are not tasks."""
        found: dict[str, Wakes] = {}
        for name, row in self._costs.interrupts.items():
            found[f"interrupt {name}"] = (Wake(Stream(row.min_interarrival_us * US)),)
        late = self._late_arming(known)
        found[RELEASE] = tuple(Wake(stream.late(late)) for stream in self._timers)
        for handler, (_, lines) in self._lines.items():
            found[handler] = tuple(Wake(Stream(self._interarrival(*line))) for line in lines)
        return found

    def _late_arming(self, known: Mapping[str, Response]) -> int:
        """The handler reads the clock, and arms the timer for the time that is left. What comes
        between the two delays the next release."""
        return self._costs.clock_ns + (known[RELEASE].run if RELEASE in known else 0)

    def _wakes(
        self,
        name: str,
        known: Mapping[str, Response],
        seen: Mapping[str, Wakes],
        done: Mapping[str, Response],
        own: Mapping[str, Wakes],
    ) -> Wakes:
        """What wakes a task, as a job sees it that is more urgent than those that are done."""
        node = self._plan.graph.nodes[name]
        found: list[Wake] = []
        for trigger in node.triggers:
            if trigger.kind == "every":
                late = self._late_arming(known)
                late += done[RELEASE].from_arrival if RELEASE in done else 0
                found.append(Wake(Stream(trigger.period_us * US, late), (name,)))
            elif trigger.kind == "irq":
                handlers = self._handlers(name, trigger)
                late = max((done[h].from_arrival for h in handlers if h in done), default=0)
                stream = Stream(self._interarrival(name, trigger.name), late)
                found.append(Wake(stream, (name,)))
            else:
                found += self._by_topic(name, trigger, seen, done, own)
        if name in self._switched:
            found += self._switches(known)
        return _joined(found)

    def _by_topic(
        self,
        name: str,
        trigger: Trigger,
        seen: Mapping[str, Wakes],
        done: Mapping[str, Response],
        own: Mapping[str, Wakes],
    ) -> list[Wake]:
        found = []
        for publisher in self._publishers(trigger):
            burst = burst_of(self._plan, publisher, trigger.name)
            response = done.get(publisher)
            for wake in seen[publisher] if response is None else own[publisher]:
                stream = wake.stream.times(burst)
                if response is not None:
                    stream = stream.late(response.late(wake.stream))
                path = (*wake.path, name) if wake.path else ()
                found.append(Wake(stream, path, trigger.name))
        if not found or trigger.min_interval_us is None:
            return found
        interval = trigger.min_interval_us * US
        apart = thinned([wake.stream for wake in found], interval)
        shortest = min(wake.stream.period for wake in found)
        if len(apart) == len(found):
            return [
                replace(w, stream=s, topic="", interval=interval, source_period=w.stream.period)
                if s.period == interval
                else replace(w, stream=s, topic="")
                for w, s in zip(found, apart, strict=True)
            ]
        return [Wake(s, interval=interval, source_period=shortest) for s in apart]

    def _switches(self, known: Mapping[str, Response]) -> list[Wake]:
        """A change of the mode wakes each task that it starts."""
        modes = self._plan.graph.modes
        if not self._changes or modes is None:
            return [Wake(Stream(ONCE))]
        publisher = known.get(modes.publisher)
        late = 0 if publisher is None else publisher.from_source
        node = self._plan.graph.nodes[modes.publisher]
        rates = Rates(self._plan.graph)
        period = rates.node(node.name)
        assert period is not None
        return [Wake(Stream(int(period * US), late))]

    def _handlers(self, name: str, trigger: Trigger) -> list[str]:
        """Those that pend the task when a line is raised; none if the line does that itself."""
        line = (name, trigger.name)
        return [handler for handler, (_, lines) in self._lines.items() if line in lines]

    def _publishers(self, trigger: Trigger) -> list[str]:
        topic = self._plan.graph.topics[trigger.name]
        return [name for name in topic.publishers if name in self._nodes]

    def _interarrival(self, name: str, line: str) -> int:
        triggers = self._plan.graph.nodes[name].triggers
        found = next(t for t in triggers if t.kind == "irq" and t.name == line)
        assert found.min_interarrival_us is not None
        return found.min_interarrival_us * US


def burst_of(plan: Plan, name: str, topic: str) -> int:
    """The most publications of one activation, without a recording."""
    node = plan.graph.nodes[name]
    outputs = node.outputs.values()
    if node.interface.reads_log:
        return blocks_at_once(plan.graph, plan.topics)
    return max(output.port.burst for output in outputs if output.topic == topic)


def _is_endless(wakes: Wakes) -> bool:
    return any(wake.stream.jitter > LONGEST for wake in wakes)


def _joined(wakes: list[Wake]) -> Wakes:
    """Streams of one period as one, if there are many: with the largest jitter, and all at once."""
    if len(wakes) <= MOST_STREAMS:
        return tuple(wakes)
    rows: dict[int, list[Wake]] = defaultdict(list)
    for wake in wakes:
        rows[wake.stream.period].append(wake)
    return tuple(
        Wake(
            Stream(
                period,
                max(w.stream.jitter for w in row),
                count=sum(w.stream.count for w in row),
            )
        )
        for period, row in rows.items()
    )
