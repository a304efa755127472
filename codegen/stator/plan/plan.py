"""Turns a checked graph into a plan: levels and their order, vectors, depths and slots.

The plan is made for the graph's own board; other executors follow its order.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from stator.collector import without_collector
from stator.diagnostics import Report
from stator.language.keys import MAX_LEVELS, MAX_TASKS_OF_THREAD
from stator.plan.log_rate import check_log_rate
from stator.plan.rates import Rates
from stator.plan.topics import TopicPlan, plan_topics
from stator.quantities import shown

if TYPE_CHECKING:
    from stator.graph.model import Board, Graph, Node


@dataclass(frozen=True)
class Task:
    """A node with its place among the others."""

    node: Node
    level: int
    index: int  # in the order of urgency
    level_begin: int  # index of the first task of its level
    vector: int | None

    @property
    def window_us(self) -> int | None:
        """The longest time between two activations; None: the task is not watched. It is two
        periods: one activation may come at the start of its period, and the next at the end."""
        written = [t.max_interval_us for t in self.node.triggers if t.max_interval_us is not None]
        periods = [2 * t.period_us for t in self.node.triggers if t.kind == "every"]
        return min(written or periods, default=None)


@dataclass(frozen=True)
class Plan:
    graph: Graph
    board: Board
    tasks: tuple[Task, ...]  # most urgent first
    topics: dict[str, TopicPlan]
    derived: bool  # priorities follow from deadlines
    replanned: bool  # the board could not keep the order of the graph's own

    def task(self, name: str) -> Task:
        return self._by_name[name]

    def is_timed(self, name: str) -> bool:
        """Whether this node has a deadline, or is the end of a chain, which has one."""
        ends = {chain.path[-1] for chain in self.graph.chains}
        return name in ends or self.graph.nodes[name].deadline_us is not None

    @cached_property
    def levels(self) -> list[int]:
        """The levels that have tasks, most urgent first."""
        return sorted({task.level for task in self.tasks}, reverse=True)

    @cached_property
    def _by_name(self) -> dict[str, Task]:
        return {task.node.name: task for task in self.tasks}


@without_collector
def plan(graph: Graph, board: Board) -> Plan:
    """Raises `Failed` with all errors of the plan."""
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
    _check_observers(tasks, report)
    if board.executor == "pthread":
        _check_level_sizes(tasks, board, report)
    topics = plan_topics(graph, levels, rates, report)
    check_log_rate(graph, topics, rates, report)
    report.stop_on_errors()
    derived = any(node.priority is None for node in graph.nodes.values())
    return Plan(graph, board, tasks, topics, derived, replanned)


def _levels(graph: Graph, rates: Rates, report: Report) -> dict[str, int]:
    nodes = graph.nodes.values()
    given = {node.name: node.priority for node in nodes if node.priority is not None}
    if given:
        return given  # for all nodes: graph/checks/nodes.py refuses a mixture
    deadlines: dict[str, Fraction] = {}
    for node in nodes:
        deadline = Fraction(node.deadline_us) if node.deadline_us else rates.node(node.name)
        if deadline is None:
            report.error(
                node.mark,
                "deadline-unknown",
                f"cannot derive a priority for '{node.name}': its deadline and period are unknown",
                f"add `deadline:`{_or_irq(node)}",
            )
        else:
            deadlines[node.name] = deadline
    distinct = sorted(set(deadlines.values()), reverse=True)
    if len(distinct) > MAX_LEVELS:
        _refuse_levels(graph, deadlines, distinct, report)
    level_of = {deadline: i + 1 for i, deadline in enumerate(distinct)}
    return {name: level_of[deadline] for name, deadline in deadlines.items()}


def _or_irq(node: Node) -> str:
    if any(t.kind == "irq" for t in node.triggers):
        return ", or `min_interarrival:` to its irq trigger"
    return ", or `min_interarrival:` to the irq trigger of the driver that its samples come from"


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
        f"expected at most {MAX_LEVELS} different deadlines, found {len(distinct)}: each needs a "
        "priority level",
        f"give some nodes the same deadline; the closest are '{first}' with {shown(short)} us and "
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


def _check_observers(tasks: tuple[Task, ...], report: Report) -> None:
    """On one core, a task that runs below all publishers needs no slot to copy a sample."""
    least = tasks[-1].level if tasks else 0
    for task in tasks:
        if task.node.interface.reads_graph and task.level > least:
            report.error(
                task.node.mark,
                "observer-level",
                f"expected the lowest priority for '{task.node.name}', which reads the whole "
                f"graph, found {task.level}, above '{tasks[-1].node.name}' with {least}",
                f"write `priority: {least}`, or give the other nodes more",
            )


def _check_level_sizes(tasks: tuple[Task, ...], board: Board, report: Report) -> None:
    """On a board where a level is a thread, its tasks are the bits of one word."""
    for task in tasks:
        if task.index - task.level_begin == MAX_TASKS_OF_THREAD:
            count = sum(other.level == task.level for other in tasks)
            report.error(
                task.node.mark,
                "level-large",
                f"expected at most {MAX_TASKS_OF_THREAD} nodes in a level of {board.name}, found "
                f"{count} in level {task.level}",
                "give some of them another priority",
            )


def _vectors(graph: Graph, board: Board, report: Report) -> dict[str, int]:
    """A task whose only trigger is one unshared line has the vector of that line. Every other task
    has a spare vector, in graph order from the lowest free one."""
    if board.chip is None:
        return {}
    lines: dict[str, list[tuple[str, str]]] = {}  # vector -> (device, line) of the whole board
    for device in board.devices.values():
        for line, wires in device.lines.items():
            for wire in wires:
                lines.setdefault(vector_of(wire), []).append((device.name, line))
    known = board.chip.vectors
    taken = {known[name] for name in (*lines, *board.reserved_vectors) if name in known}
    spare = [number for number in sorted(known.values()) if number not in taken]
    vectors: dict[str, int] = {}
    short, last = 0, None
    for node in graph.nodes.values():
        name = _only_line(board, node)
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
            f"expected at most {count} nodes that need a spare vector on {board.name}, found "
            f"{count + short}",
            "join nodes, or free the vectors of unused devices",
        )
    return vectors


def _only_line(board: Board, node: Node) -> str:
    """The vector of the line that is the node's only trigger; empty if there is no such line."""
    only = node.triggers[0]
    if len(node.triggers) != 1 or only.kind != "irq" or node.device is None:
        return ""
    wires = board.devices[node.device].lines.get(only.name, ())
    return vector_of(wires[0]) if len(wires) == 1 else ""


def owns_its_vector(plan: Plan, task: Task) -> bool:
    """Whether a task has the vector of its line, so that the line starts the task directly."""
    chip = plan.board.chip
    if chip is None or task.vector is None or plan.board.executor != "cortex_m":
        return False
    return chip.vectors.get(_only_line(plan.board, task.node)) == task.vector


def vector_of(wire: str) -> str:
    """The vector that a pin or a peripheral raises. Pins share vectors, as in all STM32F4 chips."""
    if wire.startswith("P") and wire[2:].isdigit():
        pin = int(wire[2:])
        if pin <= 4:
            return f"exti{pin}"
        return "exti9_5" if pin <= 9 else "exti15_10"
    return wire
