"""`./stator perf`: measured times beside their bounds, for each task and chain that runs."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from stator.live.arguments import add_link_arguments
from stator.live.figures import (
    Row,
    against,
    chain_latency_us,
    facts_of,
    in_words,
    measure,
    number,
)
from stator.live.link import Link, plan_of

if TYPE_CHECKING:
    import argparse

    from stator.live.link import Info
    from stator.plan.plan import Plan

LOOK_S = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_link_arguments(parser)


def main(arguments: argparse.Namespace) -> int:
    with Link(arguments.link) as link:
        info = link.info()
        plan = plan_of(info, arguments.graph, arguments.link)
        time_us, rows = measure(link, info, plan, LOOK_S)
    chains = [
        {
            "chain": chain.name,
            "latency_max_us": chain_latency_us(chain, plan, rows),
            "deadline_us": chain.deadline_us,
        }
        for chain in plan.graph.chains
    ]
    if arguments.json:
        facts = {**facts_of(info, time_us), "tasks": [vars(row) for row in rows]}
        print(json.dumps({**facts, "chains": chains}, indent=2))
    else:
        _show(info, plan, rows, time_us)
    return 0


def _show(info: Info, plan: Plan, rows: list[Row], time_us: int) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(
        title=f"{info.graph} on {info.board}, {time_us * 1e-6:.1f} s since its start",
        caption=f"maximum values; {in_words(info)}; response: from the time of the trigger to the "
        "end; the response of a chain is that of its last task",
        box=box.SIMPLE_HEAD,
    )
    table.add_column("task or chain", overflow="fold")
    for name in ("activations", "execution", "budget", "response", "deadline"):
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(
            row.task,
            f"{row.activations:,}",
            against(row.max_us, row.budget_us),
            number(row.budget_us, 0),
            against(row.response_max_us, row.deadline_us, 0),
            number(row.deadline_us, 0),
        )
    for chain in plan.graph.chains:
        latency = chain_latency_us(chain, plan, rows)
        shown = against(latency, chain.deadline_us, 0)
        table.add_row(chain.name, "", "", "", shown, number(chain.deadline_us, 0))
    Console(highlight=False).print(table)
