"""From one end of a chain to the other: the worst reaction, and the greatest age of what it used.

A chain is cut where a node reads without being woken by what it reads. Each part between is as late
as its last task. A sample waits at a cut until the reader runs next (Davare et al. 2007: the sum of
periods and response times)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from stator.prove.system import US

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stator.graph.model import Chain, Graph
    from stator.prove.system import Solution


@dataclass(frozen=True)
class ChainBound:
    chain: Chain
    reaction_ns: int | None  # from the release of the first node to the end of the last
    age_ns: int | None  # of the sample that the last node used, when the next one replaces it

    @property
    def deadline_ns(self) -> int:
        return self.chain.deadline_us * US

    @property
    def holds(self) -> bool:
        return self.reaction_ns is not None and self.reaction_ns <= self.deadline_ns


def bound_chains(graph: Graph, solutions: Iterable[Solution]) -> tuple[ChainBound, ...]:
    """In the worst of the modes that run all nodes of the chain."""
    return tuple(_bound(graph, chain, list(solutions)) for chain in graph.chains)


def _bound(graph: Graph, chain: Chain, solutions: list[Solution]) -> ChainBound:
    reactions: list[int | None] = []
    ages: list[int | None] = []
    for solution in solutions:
        running = {job.name for job in solution.jobs}
        if not running.issuperset(chain.path):
            continue
        reaction = _reaction(graph, chain, solution)
        reactions.append(reaction)
        ages.append(None if reaction is None else reaction + _longest_period(solution, chain))
    return ChainBound(chain, _worst(reactions), _worst(ages))


def _worst(values: list[int | None]) -> int | None:
    """Without a bound in one mode there is none. A chain that no mode runs whole has none."""
    known = [value for value in values if value is not None]
    return max(known) if known and len(known) == len(values) else None


def _longest_period(solution: Solution, chain: Chain) -> int:
    return max(wake.stream.period for wake in solution.wakes[chain.path[0]])


def _reaction(graph: Graph, chain: Chain, solution: Solution) -> int | None:
    if any(name not in solution.responses for name in chain.path):
        return None
    parts = _parts(graph, chain.path)
    total = _part(solution, parts[0])
    for part in parts[1:]:
        total += _wait(solution, part[0]) + _part(solution, part)
    return total


def _parts(graph: Graph, path: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Runs of nodes of which each wakes the next by every sample."""
    parts = [[path[0]]]
    for before, name in pairwise(path):
        if _wakes(graph, before, name):
            parts[-1].append(name)
        else:
            parts.append([name])
    return [tuple(part) for part in parts]


def _wakes(graph: Graph, before: str, name: str) -> bool:
    """Whether each sample does."""
    topics = {output.topic for output in graph.nodes[before].outputs.values()}
    triggers = graph.nodes[name].triggers
    return any(t.kind == "topic" and t.name in topics and not t.is_thinned for t in triggers)


def _part(solution: Solution, part: tuple[str, ...]) -> int:
    """From the release of its first node to the end of its last."""
    first, *others = part
    released = solution.from_release(first)
    assert released is not None
    one_by_one = released + sum(solution.responses[name].from_arrival for name in others)
    last = solution.responses[part[-1]]
    through = [
        last.late(wake.stream)
        for wake in solution.wakes[part[-1]]
        if wake.path[-len(part) :] == part
    ]
    if not _has_own_source(solution, first) and _falls(solution, part):
        # In its window, the last one comes with the first one's source, or a publisher before that.
        one_by_one = min(one_by_one, last.from_arrival)
    if not through or any(wake.topic and not wake.path for wake in solution.wakes[part[-1]]):
        return one_by_one
    return min(one_by_one, max(through))


def _has_own_source(solution: Solution, name: str) -> bool:
    return any(len(wake.path) == 1 for wake in solution.wakes[name])


def _falls(solution: Solution, part: tuple[str, ...]) -> bool:
    """Whether the last one is the least urgent."""
    places = {job.name: i for i, job in enumerate(solution.jobs)}
    return all(places[name] < places[part[-1]] for name in part[:-1])


def _wait(solution: Solution, name: str) -> int:
    """From a publication to the next release of a node that reads it."""
    # Where the source itself releases the task, its jitter is in the response.
    return min(
        wake.stream.period if len(wake.path) == 1 else wake.gap for wake in solution.wakes[name]
    )
