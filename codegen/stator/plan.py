"""Turns a checked graph into a plan: levels and their order, vectors, depths and slots.

The plan is made for the graph's own board; other executors follow its order.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from stator.collector import without_collector
from stator.diagnostics import Mark, Report
from stator.language import DEPTHS, MOST_LEVELS, MOST_LOGGED_BYTES, MOST_SLOTS
from stator.model import Message, TopicConfig
from stator.model import Topic as GraphTopic
from stator.quantities import shown

if TYPE_CHECKING:
    from stator.model import Board, Graph, Node

LOG_ALL_UP_TO_US = 10_000  # topics of at most 100 Hz are logged whole
LOG_ELSE_US = 20_000  # others at 50 Hz


@dataclass(frozen=True)
class Task:
    """A node with its place among the others."""

    node: Node
    level: int
    index: int  # in the order of urgency
    level_begin: int  # index of the first task of its level
    vector: int | None


@dataclass(frozen=True)
class TopicPlan:
    name: str
    message: Message
    publishers: tuple[str, ...]  # none: the parameters of a node, published at the start
    readers: tuple[tuple[str, str], ...]
    owner: str  # the node whose parameters these are; empty for the graph's own topics
    depth: int
    slots: int
    ceiling: int  # the highest publishing level if several levels publish, else 0
    kept_by: tuple[str, ...]  # publishers that a reader outranks
    log_us: int | None  # None: not logged; 0: every sample
    period_us: Fraction | None  # mean time between publications, if known


@dataclass(frozen=True)
class Plan:
    graph: Graph
    board: Board
    tasks: tuple[Task, ...]  # most urgent first
    topics: dict[str, TopicPlan]
    derived: bool  # priorities come from deadlines
    replanned: bool  # the board could not keep the order of the graph's own

    def task(self, name: str) -> Task:
        return next(task for task in self.tasks if task.node.name == name)


@without_collector
def plan(graph: Graph, board: Board) -> Plan:
    """Raises `Failed` with every rule that the graph breaks on its board."""
    report = Report()
    rates = Rates(graph)
    levels = _levels(graph, rates, report)
    report.stop_on_errors()
    tasks = _order(graph, graph.board, levels, report)
    replanned = False
    if board.chip is not None and board.name != graph.board.name:
        other = _order(graph, board, levels, report)
        replanned = [t.node.name for t in other] != [t.node.name for t in tasks]
        tasks = other
    topics = _topics(graph, levels, rates, report)
    report.stop_on_errors()
    derived = any(node.priority is None for node in graph.nodes.values())
    return Plan(graph, board, tasks, topics, derived, replanned)


class Rates:
    """Mean periods, as far as triggers tell them. None: unknown."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self._periods: dict[str, Fraction | None] = {}
        self._of_topics: dict[str, Fraction | None] = {}
        for name in _publishers_first(graph):
            self._periods[name] = self._of_node(graph.nodes[name])

    def node(self, name: str) -> Fraction | None:
        """Mean time between activations of a node."""
        return self._periods.get(name)

    def topic(self, name: str) -> Fraction | None:
        """Mean time between publications, one for each activation of a publisher."""
        if name not in self._of_topics:
            sums = [
                _sum_of_rates([self._periods.get(node) for node in together])
                for together in self._at_one_time(self.graph.topics[name].publishers)
            ]
            known = [period for period in sums if period is not None]
            self._of_topics[name] = min(known) if known and len(known) == len(sums) else None
        return self._of_topics[name]

    def _at_one_time(self, nodes: tuple[str, ...]) -> list[list[str]]:
        """Those of the nodes that run together, for each mode in which any does."""
        if len(nodes) == 1 or self.graph.modes is None:
            return [list(nodes)]
        sets = list(self.graph.modes.sets.values())
        always = [name for name in nodes if not any(name in names for names in sets)]
        together = [[*always, *(name for name in nodes if name in names)] for names in sets]
        return [names for names in together if names] or [list(nodes)]

    def _of_node(self, node: Node) -> Fraction | None:
        periods: list[Fraction | None] = []
        for trigger in node.triggers:
            if trigger.kind == "every":
                periods.append(Fraction(trigger.period_us))
            elif trigger.kind == "irq":
                least = trigger.min_interarrival_us
                periods.append(None if least is None else Fraction(least))
            else:
                period = self.topic(trigger.name)
                if trigger.min_interval_us is not None:
                    least = trigger.min_interval_us
                    period = Fraction(least) if period is None else max(period, Fraction(least))
                periods.append(period)
        return _sum_of_rates(periods)


def _sum_of_rates(periods: list[Fraction | None]) -> Fraction | None:
    known = [period for period in periods if period is not None]
    if not known or len(known) < len(periods):
        return None
    return 1 / sum((1 / period for period in known), Fraction(0))


def _publishers_first(graph: Graph) -> list[str]:
    """Nodes such that whoever triggers a node by a topic stands before it (there is no cycle)."""
    unknown = {name: len(topic.publishers) for name, topic in graph.topics.items()}
    waits: dict[str, int] = {}
    woken: dict[str, list[str]] = {name: [] for name in graph.topics}
    for node in graph.nodes.values():
        sources = [t.name for t in node.triggers if t.kind == "topic"]
        waits[node.name] = len(sources)
        for topic in sources:
            woken[topic].append(node.name)
    ready = [name for name, count in waits.items() if not count]
    for name in ready:
        for output in graph.nodes[name].outputs.values():
            unknown[output.topic] -= 1
            if unknown[output.topic]:
                continue
            for reader in woken[output.topic]:
                waits[reader] -= 1
                if not waits[reader]:
                    ready.append(reader)
    return ready


# --- levels and order ---


def _levels(graph: Graph, rates: Rates, report: Report) -> dict[str, int]:
    nodes = graph.nodes.values()
    given = {node.name: node.priority for node in nodes if node.priority is not None}
    if given:
        return given  # for all, as the check has seen to
    deadlines: dict[str, Fraction] = {}
    for node in nodes:
        deadline = Fraction(node.deadline_us) if node.deadline_us else rates.node(node.name)
        if deadline is None:
            report.error(
                node.mark,
                "deadline-unknown",
                f"'{node.name}' has neither a deadline nor a "
                "known period to derive its priority from",
                f"add `deadline:`{_or_irq(node)}",
            )
        else:
            deadlines[node.name] = deadline
    distinct = sorted(set(deadlines.values()), reverse=True)
    if len(distinct) > MOST_LEVELS:
        _refuse_levels(graph, deadlines, distinct, report)
    level_of = {deadline: i + 1 for i, deadline in enumerate(distinct)}
    return {name: level_of[deadline] for name, deadline in deadlines.items()}


def _or_irq(node: Node) -> str:
    if any(t.kind == "irq" for t in node.triggers):
        return ", or `min_interarrival:` to its irq"
    return ", or `min_interarrival:` to the irq that starts its samples on their way"


def _refuse_levels(
    graph: Graph, deadlines: dict[str, Fraction], distinct: list[Fraction], report: Report
) -> None:
    long, short = min(pairwise(distinct), key=lambda pair: pair[0] / pair[1])
    first, second = (
        next(n for n, deadline in deadlines.items() if deadline == wanted)
        for wanted in (short, long)
    )
    report.error(
        graph.nodes[second].mark,
        "priority-levels",
        f"{len(distinct)} different deadlines need as many levels, and there are {MOST_LEVELS}",
        f"give some nodes the same deadline; closest are '{first}' with {shown(short)} us and "
        f"'{second}' with {shown(long)} us",
    )


def _order(graph: Graph, board: Board, levels: dict[str, int], report: Report) -> tuple[Task, ...]:
    vectors = _vectors(graph, board, report)
    place = {name: i for i, name in enumerate(graph.nodes)}
    names = sorted(graph.nodes, key=lambda n: (-levels[n], vectors.get(n, 0), place[n]))
    tasks: list[Task] = []
    for index, name in enumerate(names):
        same = bool(tasks) and tasks[-1].level == levels[name]
        begin = tasks[-1].level_begin if same else index
        tasks.append(Task(graph.nodes[name], levels[name], index, begin, vectors.get(name)))
    return tuple(tasks)


def _vectors(graph: Graph, board: Board, report: Report) -> dict[str, int]:
    """A task whose only trigger is one unshared line has that line's vector; every other task has a
    spare one, in graph order from the lowest free."""
    if board.chip is None:
        return {}
    lines: dict[str, list[tuple[str, str]]] = {}  # vector -> (device, line) of the whole board
    for device in board.devices.values():
        for line, wire in device.lines.items():
            lines.setdefault(vector_of(wire), []).append((device.name, line))
    known = board.chip.vectors
    taken = {known[name] for name in (*lines, *board.reserved_vectors) if name in known}
    spare = [number for number in sorted(known.values()) if number not in taken]
    vectors: dict[str, int] = {}
    short, last = 0, None
    for node in graph.nodes.values():
        only = node.triggers[0]
        if len(node.triggers) == 1 and only.kind == "irq" and node.device is not None:
            name = vector_of(board.devices[node.device].lines.get(only.name, ""))
            if name in known and len(lines[name]) == 1:
                vectors[node.name] = known[name]
                continue
        if spare:
            vectors[node.name] = spare.pop(0)
        else:
            short += 1
            last = node
    if last is not None:
        count = len(known) - len(taken)
        report.error(
            last.mark,
            "vectors-few",
            f"the nodes need {count + short} spare vectors, and {board.name} has {count}",
            "join nodes, or free vectors of devices that are not used",
        )
    return vectors


def vector_of(wire: str) -> str:
    """The vector that a pin or a peripheral raises; pins share as the chips of this family do."""
    if wire.startswith("P") and wire[2:].isdigit():
        pin = int(wire[2:])
        if pin <= 4:
            return f"exti{pin}"
        return "exti9_5" if pin <= 9 else "exti15_10"
    return wire


# --- topics ---


def _topics(
    graph: Graph, levels: dict[str, int], rates: Rates, report: Report
) -> dict[str, TopicPlan]:
    logger = next((n for n in graph.nodes.values() if n.interface.reads_log), None)
    plans: dict[str, TopicPlan] = {}
    for topic in graph.topics.values():
        plans[topic.name] = _topic(graph, topic, levels, rates, logger, report)
    for node in graph.nodes.values():
        message = node.interface.params_message
        if message is None:
            continue
        name = f"{node.name}_params"
        plans[name] = TopicPlan(
            name, message, (), ((node.name, "params"),), node.name, 1, 2, 0, (), None, None
        )
    return plans


def _topic(
    graph: Graph,
    topic: GraphTopic,
    levels: dict[str, int],
    rates: Rates,
    logger: Node | None,
    report: Report,
) -> TopicPlan:
    period = rates.topic(topic.name)
    log_us = _log(graph, topic, period, logger)
    queue_readers = [node for node, port in topic.readers if graph.nodes[node].inputs[port].queue]
    if log_us == 0 and logger is not None:
        queue_readers.append(logger.name)
    depth = _depth(topic, queue_readers, rates, report)
    publishing = {levels[name] for name in topic.publishers}
    top = max(publishing)
    reading = [levels[name] for name, _ in topic.readers]
    if log_us is not None and logger is not None:
        reading.append(levels[logger.name])
    slots = slots_needed(topic, levels, reading, depth)
    if slots > MOST_SLOTS:
        mark = topic.config.mark or _output_mark(topic, graph)
        report.error(
            mark,
            "slots-many",
            f"topic '{topic.name}' needs {slots} slots, and {MOST_SLOTS} are the most",
            f"give it a smaller depth (now {depth}), or its readers and publishers fewer levels",
        )
    kept_by = tuple(n for n in topic.publishers if any(level > levels[n] for level in reading))
    ceiling = top if len(publishing) > 1 else 0
    return TopicPlan(
        topic.name,
        topic.message,
        topic.publishers,
        topic.readers,
        "",
        depth,
        slots,
        ceiling,
        kept_by,
        log_us,
        period,
    )


def slots_needed(topic: GraphTopic, levels: dict[str, int], reading: list[int], depth: int) -> int:
    """(D - 1) + max(keep, pins at Lw) + loans at Lw + sum over levels L < Lw of c(L)."""
    top = max(levels[name] for name in topic.publishers)
    reads = {name for name, _ in topic.readers}
    keep = 1 if any(level > top for level in reading) else 0
    pins_at_top = int(any(levels[n] == top and n in reads for n in topic.publishers))
    held: dict[int, int] = {level: 1 for level in reading if level < top}
    for name in topic.publishers:
        if levels[name] < top:
            held[levels[name]] = max(held.get(levels[name], 1), 2 if name in reads else 1)
    return (depth - 1) + max(keep, pins_at_top) + 1 + sum(held.values())


def _log(
    graph: Graph, topic: GraphTopic, period: Fraction | None, logger: Node | None
) -> int | None:
    config: TopicConfig = topic.config
    own = logger is not None and logger.name in topic.publishers
    if logger is None or own or config.log == "none" or topic.message.bytes > MOST_LOGGED_BYTES:
        return None
    if config.log == "all":
        return 0
    if isinstance(config.log, int):
        return config.log
    slow = period is not None and period >= LOG_ALL_UP_TO_US
    return 0 if slow else LOG_ELSE_US


def _depth(topic: GraphTopic, queue_readers: list[str], rates: Rates, report: Report) -> int:
    """The smallest depth that holds what is published between two activations of each reader."""
    config = topic.config
    mark = config.mark or _output_mark(topic, rates.graph)
    needed, slowest = 1, ""
    for name in queue_readers:
        published, read = rates.topic(topic.name), rates.node(name)
        if published is not None and read is not None:
            # One more for the phase, as neither releases at an agreed time.
            count = -(-read // published) + 1
            needed, slowest = max((needed, slowest), (count, name))
        elif config.depth is None:
            unknown = topic.publishers[0] if published is None else name
            report.error(
                mark,
                "depth-rate-unknown",
                f"'{name}' reads every sample of '{topic.name}', "
                f"and how often '{unknown}' runs is not known",
                "add `min_interarrival:` to "
                f"the irq behind it, or `topics: {{{topic.name}: {{depth: 4}}}}`",
            )
            break
    fitting = next((depth for depth in DEPTHS if depth >= needed), None)
    if fitting is None:
        report.error(
            mark,
            "depth-small",
            f"'{topic.name}' would need a depth of {needed} for "
            f"'{slowest}', and {DEPTHS[-1]} is the most",
            f"activate '{slowest}' more often, or let it read the latest sample only",
        )
    elif config.depth is not None and config.depth < needed:
        report.error(
            mark,
            "depth-small",
            f"depth {config.depth} of '{topic.name}' is too small: "
            f"{needed} samples can come between two activations of '{slowest}'",
            f"write {fitting}, or leave it out",
        )
    return config.depth or fitting or DEPTHS[-1]


def _output_mark(topic: GraphTopic, graph: Graph) -> Mark:
    """Where the topic gets its first publisher."""
    outputs = graph.nodes[topic.publishers[0]].outputs.values()
    return next(output.mark for output in outputs if output.topic == topic.name)
