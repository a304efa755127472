"""What is late, as help: where in the graph, who takes how much of the time, and changes that would
make it hold. Each change is proven before it is shown."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stator.diagnostics import Failed, Report
from stator.language.period import spelled_us
from stator.plan.plan import plan as make_plan
from stator.prove.proof import prove, utilisation
from stator.prove.system import US

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from stator.diagnostics import Error
    from stator.graph.model import Graph, Node
    from stator.plan.plan import Plan
    from stator.prove.chains import ChainBound
    from stator.prove.proof import Proof, TaskBound

SHARES_SHOWN = 5
MOST_HINTS = 3
MOST_LEVEL = 15
SLOWER = (2, 3, 4, 5, 8, 10)  # times the period
STEPS = 12  # of a search by halves


def problems(proof: Proof) -> list[Error]:
    """In order of position."""
    report = Report()
    change = _Changes(proof)
    for task in proof.tasks:
        if not task.holds:
            _late_task(proof, task, change, report)
    for chain in proof.chains:
        if not chain.holds:
            _late_chain(proof, chain, change, report)
    try:
        report.stop_on_errors()
    except Failed as failed:
        return failed.errors
    return []


def _late_task(proof: Proof, task: TaskBound, change: _Changes, report: Report) -> None:
    mark = proof.plan.graph.nodes[task.name].mark
    if task.response_ns is None:
        report.error(
            mark,
            "task-endless",
            f"task '{task.name}' has no bound: it waits for a level with too much to do",
            _hints(change, task.name, _names(proof)),
            (f"all tasks take {100 * proof.load:.1f} % of the processor", _largest(proof)),
        )
        return
    what = "deadline" if task.is_stated else "and has to end within its period of"
    report.error(
        mark,
        "task-late",
        f"task '{task.name}' may respond after {shown_ns(task.response_ns)}, "
        f"{what} {shown_ns(task.deadline_ns)}",
        _hints(change, task.name, [share.name for share in task.shares]),
        (_taken(task),),
    )


def _late_chain(proof: Proof, bound: ChainBound, change: _Changes, report: Report) -> None:
    chain = bound.chain
    names = [share.name for name in chain.path[::-1] for share in proof.task(name).shares]
    took = "has no bound"
    if bound.reaction_ns is not None:
        took = f"may take {shown_ns(bound.reaction_ns)}, deadline {shown_ns(bound.deadline_ns)}"
    report.error(
        chain.mark,
        "chain-late",
        f"chain '{chain.name}' {took}",
        _hints(change, chain.name, [*chain.path[::-1], *names]),
        (_taken(proof.task(chain.path[-1])),),
    )


def shown_ns(value: int) -> str:
    """A time as a person writes it: three digits, or whole microseconds."""
    us = value / US
    if us >= 1000:
        return f"{us / 1000:.4g} ms"
    return f"{us:.4g} us"


def _taken(task: TaskBound) -> str:
    """Who takes how much."""
    own = [share for share in task.shares if share.name == task.name]
    others = sorted(task.shares[len(own) :], key=lambda share: -share.cost)
    shown = [*own, *others[: SHARES_SHOWN - 1]]
    parts = [f"{share.name} {shown_ns(share.cost)}" for share in shown]
    rest = others[SHARES_SHOWN - 1 :]
    if rest:
        parts.append(f"{len(rest)} more {shown_ns(sum(share.cost for share in rest))}")
    return f"in the worst window of '{task.name}': {', '.join(parts)}"


def _largest(proof: Proof) -> str:
    largest = sorted(utilisation(proof).items(), key=lambda item: -item[1])[:SHARES_SHOWN]
    return "most of it: " + ", ".join(f"{name} {100 * load:.1f} %" for name, load in largest)


def _names(proof: Proof) -> list[str]:
    return [task.name for task in sorted(proof.tasks, key=lambda task: -task.budget_ns)]


def _hints(change: _Changes, subject: str, blamed: list[str]) -> tuple[str, ...]:
    nodes = [name for name in dict.fromkeys(blamed) if name in change.graph.nodes]
    found: list[str] = []
    for hint in change.proven(subject, nodes):
        found.append(hint)
        if len(found) == MOST_HINTS:
            break
    return tuple(found) or ("change several priorities, rates or budgets: one is not enough",)


class _Changes:
    """Proves changes of the graph. One helps if the subject then holds, and all that held still
    holds."""

    def __init__(self, proof: Proof) -> None:
        self.graph = proof.plan.graph
        self._proof = proof
        self._budgets = {task.name: task.budget_ns for task in proof.tasks}
        self._held = {*_held(proof)}

    def proven(self, subject: str, blamed: list[str]) -> Iterator[str]:
        """`subject`: a task or a chain. `blamed`: who takes its time, itself first."""
        if subject in self.graph.nodes:
            yield from self._more_urgent(subject)
        for name in blamed[:SHARES_SHOWN]:
            yield from self._rarer(subject, name)
        for name in blamed[:SHARES_SHOWN]:
            yield from self._smaller(subject, name)

    def _more_urgent(self, name: str) -> Iterator[str]:
        priority = self.graph.nodes[name].priority
        for level in range((priority or MOST_LEVEL) + 1, MOST_LEVEL + 1):
            if self._helps(name, self._planned(name, lambda n, p=level: replace(n, priority=p))):  # type: ignore[misc]
                yield f"write `priority: {level}` for '{name}'"
                return

    def _rarer(self, subject: str, name: str) -> Iterator[str]:
        """A timer that is slower, or a topic that wakes less often."""
        node = self.graph.nodes[name]
        for place, trigger in enumerate(node.triggers):
            old = trigger.period_us if trigger.kind == "every" else trigger.min_interval_us
            for factor in SLOWER if old else ():
                assert old is not None
                us = old * factor
                is_timer = trigger.kind == "every"
                new = (
                    replace(trigger, period_us=us)
                    if is_timer
                    else replace(trigger, min_interval_us=us)
                )
                triggers = (*node.triggers[:place], new, *node.triggers[place + 1 :])
                changed = self._planned(name, lambda n, t=triggers: replace(n, triggers=t))  # type: ignore[misc]
                if self._helps(subject, changed):
                    word = "every" if is_timer else "min_interval"
                    yield f"write `{word}: {spelled_us(us)}` for '{name}'"
                    break

    def _smaller(self, subject: str, name: str) -> Iterator[str]:
        """The largest budget with which it holds."""

        def helps(us: int) -> bool:
            return self._helps(subject, self._proof.plan, {**self._budgets, name: us * US})

        high = self._budgets[name] // US
        low = 0
        for _ in range(STEPS):
            middle = (low + high) // 2
            if middle in (low, high):
                break
            low, high = (middle, high) if helps(middle) else (low, middle)
        if low and helps(low):
            yield f"make '{name}' take at most {spelled_us(low)}"

    def _planned(self, name: str, change: Callable[[Node], Node]) -> Plan | None:
        nodes = dict(self.graph.nodes)
        nodes[name] = change(nodes[name])
        return planned(replace(self.graph, nodes=nodes), self._proof)

    def _helps(
        self, subject: str, plan: Plan | None, budgets: Mapping[str, int] | None = None
    ) -> bool:
        if plan is None:
            return False
        held = _held(prove(plan, budgets or self._budgets))
        return subject in held and self._held <= held


def planned(graph: Graph, proof: Proof) -> Plan | None:
    try:
        return make_plan(graph, proof.plan.board)
    except Failed:
        return None


def _held(proof: Proof) -> set[str]:
    return {task.name for task in proof.tasks if task.holds} | {
        bound.chain.name for bound in proof.chains if bound.holds
    }
