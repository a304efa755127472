"""Measurements of the tasks and chains of a running vehicle."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.live.link import Info, Link, TaskFigures

if TYPE_CHECKING:
    from stator.graph.model import Chain
    from stator.plan.plan import Plan, Task

WRAP = 2**32
# Sums of nanoseconds wrap after 4.3 s of a busy processor.
LONGEST_LOOK_S = 2.0


@dataclass(frozen=True)
class Row:
    """Figures of a task, in the interval and since its start. None: not measured, or no bound."""

    task: str
    level: int
    activations: int
    per_s: float
    load_pct: float | None
    last_us: float | None
    mean_us: float | None
    max_us: float | None
    budget_us: int | None
    response_max_us: int | None
    deadline_us: int | None
    lost_samples: int
    missed_life_signs: int


@dataclass(frozen=True)
class Span:
    """The length of the interval: on the graph's clock, and on the clock of execution times."""

    graph_us: int
    machine_us: float


def facts_of(info: Info, time_us: int) -> dict[str, object]:
    return {
        "graph": info.graph,
        "board": info.board,
        "uptime_s": time_us / 1e6,
        "safe_mode": info.safe_mode,
        "measured_in": info.unit,
    }


def measure(link: Link, info: Info, plan: Plan, interval_s: float) -> tuple[int, list[Row]]:
    """The vehicle's time, and a row for each task over the interval."""
    begin_us, first = link.tasks(info.tasks)
    begin_s = time.monotonic()
    before, busy = first, [0] * info.tasks
    end_s = begin_s + interval_s
    while (left_s := end_s - time.monotonic()) > 0:
        time.sleep(min(left_s, LONGEST_LOOK_S))
        end_us, after = link.tasks(info.tasks)
        for i in range(info.tasks):
            busy[i] += (after[i].ticks - before[i].ticks) % WRAP
        before = after
    span_us = max(end_us - begin_us, 1)
    # CPU time is on the machine's clock, which may be faster than the graph's (run --speed).
    machine_us = (time.monotonic() - begin_s) * 1e6 if info.unit == "cpu_time" else span_us
    span = Span(span_us, machine_us)
    return end_us, [
        _row(task, first[i], before[i], busy[i], span, plan, info)
        for i, task in enumerate(plan.tasks)
    ]


def _row(
    task: Task,
    before: TaskFigures,
    after: TaskFigures,
    busy: int,
    span: Span,
    plan: Plan,
    info: Info,
) -> Row:
    count = (after.activations - before.activations) % WRAP

    def us(ticks: int) -> float | None:
        return ticks * 1e6 / info.ticks_per_s if info.ticks_per_s else None

    busy_us = us(busy)
    return Row(
        task=task.node.name,
        level=task.level,
        activations=after.activations,
        per_s=count * 1e6 / span.graph_us,
        load_pct=None if busy_us is None else 100.0 * busy_us / span.machine_us,
        last_us=us(after.last_ticks),
        mean_us=busy_us / count if busy_us is not None and count else None,
        max_us=us(after.most_ticks),
        budget_us=task.node.budget_us,
        response_max_us=after.latest_us if is_timed(plan, info, task) else None,
        deadline_us=task.node.deadline_us,
        lost_samples=after.lost,
        missed_life_signs=after.missed_life_signs,
    )


def is_timed(plan: Plan, info: Info, task: Task) -> bool:
    return info.ticks_per_s != 0 and plan.is_timed(task.node.name)


def in_words(info: Info) -> str:
    return {
        "cycles": "execution times in us, counted as cycles",
        "instructions": "execution times in emulated us, counted as instructions",
        "cpu_time": "execution times in us of CPU time",
        "nothing": "no times: built without STATOR_COUNTERS",
    }.get(info.unit, f"execution times in us, counted as {info.unit}")


def number(value: float | None, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def against(value: float | None, bound: float | None, digits: int = 1) -> str:
    """A figure, in red if it exceeds its bound."""
    text = number(value, digits)
    is_over = value is not None and bound is not None and value > bound
    return f"[bold red]{text}[/]" if is_over else text


# --- chains, for perf ---


def latest_end_us(row: Row, plan: Plan) -> int | None:
    """The earliest deadline of the task and of the chains that end with it."""
    chains = plan.graph.chains
    ends = [
        chain.deadline_us
        for chain in chains
        if chain.path[-1] == row.task and _carries_time(chain, plan)
    ]
    return min([end for end in (row.deadline_us, *ends) if end is not None], default=None)


def chain_latency_us(chain: Chain, plan: Plan, rows: list[Row]) -> int | None:
    """The longest time from the trigger of the first node to the end of the last; None: unknown."""
    last = next(row for row in rows if row.task == chain.path[-1])
    return last.response_max_us if _carries_time(chain, plan) else None


def _carries_time(chain: Chain, plan: Plan) -> bool:
    """Whether `now` passes along the chain: each link is the only trigger of its reader."""
    nodes = plan.graph.nodes
    for first, second in zip(chain.path, chain.path[1:], strict=False):
        sent = {output.topic for output in nodes[first].outputs.values()}
        woken = {t.name for t in nodes[second].triggers if t.kind == "topic" and not t.is_thinned}
        if len(nodes[second].triggers) != 1 or not sent & woken:
            return False
    return True
