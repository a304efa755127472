"""The proof of a plan: the bound of each task in every mode, and in each change between two; of
each chain, and of each queue."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from stator.language.keys import PROVENANCES
from stator.plan.rates import Rates
from stator.prove.chains import ChainBound, bound_chains
from stator.prove.queues import QueueBound, bound_queues
from stator.prove.system import US, Solution, System

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stator.graph.model import Node
    from stator.plan.plan import Plan
    from stator.prove.response import Response, Share


@dataclass(frozen=True)
class TaskBound:
    name: str
    level: int
    budget_ns: int
    source: str  # of the budget: one of PROVENANCES
    response_ns: int | None  # from its release to its end; None: unbounded
    deadline_ns: int
    is_stated: bool  # whether the graph gives the deadline; else it is the period
    shares: tuple[Share, ...]
    window: Response | None  # of the worst activation

    @property
    def holds(self) -> bool:
        return self.response_ns is not None and self.response_ns <= self.deadline_ns

    @property
    def slack_ns(self) -> int | None:
        return None if self.response_ns is None else self.deadline_ns - self.response_ns


@dataclass(frozen=True)
class Proof:
    plan: Plan
    tasks: tuple[TaskBound, ...]  # in the order of the plan
    chains: tuple[ChainBound, ...]
    queues: tuple[QueueBound, ...]
    solutions: tuple[Solution, ...]  # of each mode and each change between two
    load: float  # of the processor, in the worst mode

    @property
    def weakest_source(self) -> str:
        costs = self.plan.board.costs
        assert costs is not None
        return min([costs.source, *(task.source for task in self.tasks)], key=PROVENANCES.index)

    @property
    def holds(self) -> bool:
        return all(task.holds for task in self.tasks) and all(c.holds for c in self.chains)

    def task(self, name: str) -> TaskBound:
        return next(task for task in self.tasks if task.name == name)


def prove(plan: Plan, budgets: Mapping[str, int] | None = None) -> Proof:
    """`budgets`: in ns, instead of the graph's, which `require_provable` has found complete."""
    graph = plan.graph
    if budgets is None:
        budgets = {name: (node.budget_us or 0) * US for name, node in graph.nodes.items()}
    solutions = solve(plan, budgets)
    rates = Rates(graph)
    tasks = []
    for task in plan.tasks:
        node = task.node
        bounds = [
            (solution.from_release(node.name), solution)
            for solution in solutions
            if any(job.name == node.name for job in solution.jobs)
        ]
        endless = [row for row in bounds if row[0] is None]
        response, solution = (endless or [max(bounds, key=lambda row: row[0] or 0)])[0]
        tasks.append(
            TaskBound(
                node.name,
                task.level,
                budgets[node.name],
                PROVENANCES[0] if node.budget is None else node.budget.source,
                response,
                deadline_ns(node, rates),
                node.deadline_us is not None,
                solution.shares.get(node.name, ()),
                solution.responses.get(node.name),
            )
        )
    return Proof(
        plan,
        tuple(tasks),
        bound_chains(graph, solutions),
        bound_queues(plan, solutions),
        tuple(solutions),
        max(map(_load, solutions)),
    )


def utilisation(proof: Proof) -> dict[str, float]:
    """Of the processor, by each job, in the worst mode."""
    loads: dict[str, float] = {}
    for solution in proof.solutions:
        for job in solution.jobs:
            load = sum(stream.count * job.cost / stream.period for stream in job.streams)
            loads[job.name] = max(loads.get(job.name, 0.0), load)
    return loads


def deadline_ns(node: Node, rates: Rates) -> int:
    """A node without one has to end before it is woken again."""
    if node.deadline_us is not None:
        return node.deadline_us * US
    period = rates.node(node.name)
    assert period is not None
    return int(period * US)


def solve(plan: Plan, budgets: Mapping[str, int]) -> list[Solution]:
    """For each two modes: the nodes of both, as the mode may change at any time. Where it may
    change more than once while a task waits: the nodes of all."""
    modes = plan.graph.modes
    if modes is None:
        return [System(plan, budgets).solve()]
    sets = [set(names) for names in modes.sets.values()]
    gated = set[str]().union(*sets)
    always = plan.graph.nodes.keys() - gated
    if len(sets) == 1:
        return [System(plan, budgets, always | gated).solve()]
    found = [
        System(plan, budgets, always | first | second, first ^ second).solve()
        for first, second in combinations(sets, 2)
    ]
    if all(_changes_once(solution, modes.publisher) for solution in found):
        return found
    return [System(plan, budgets, always | gated, gated, changes=True).solve()]


def _changes_once(solution: Solution, publisher: str) -> bool:
    """Whether each busy window is over before the mode can change a second time."""
    if len(solution.responses) < len(solution.jobs):
        return True  # unbounded, whatever the modes do
    wakes = solution.wakes[publisher]
    response = solution.responses[publisher]
    if len(wakes) != 1:
        return False
    apart = wakes[0].stream.late(response.late(wakes[0].stream)).earliest(2)
    return all(row.window <= apart for row in solution.responses.values())


def _load(solution: Solution) -> float:
    return sum(
        stream.count * job.cost / stream.period for job in solution.jobs for stream in job.streams
    )
