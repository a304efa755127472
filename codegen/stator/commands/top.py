"""`./stator top`: a live table of the tasks of a running vehicle."""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
from typing import TYPE_CHECKING

from stator.live.arguments import add_link_arguments
from stator.live.fault_record import explain
from stator.live.figures import Row, against, facts_of, in_words, latest_end_us, measure, number
from stator.live.link import Info, Link, plan_of

if TYPE_CHECKING:
    from rich.table import Table

    from stator.plan.plan import Plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_link_arguments(parser)
    parser.add_argument(
        "--interval",
        type=_interval,
        default=1.0,
        metavar="S",
        help="seconds between two measurements (default: 1)",
    )
    parser.add_argument("--once", action="store_true", help="print one table, and end")


def _interval(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.05 <= value <= 20.0:
        raise argparse.ArgumentTypeError(f"expected seconds from 0.05 to 20, found '{text}'")
    return value


def main(arguments: argparse.Namespace) -> int:
    with Link(arguments.link) as link:
        info = link.info()
        plan = plan_of(info, arguments.graph, arguments.link)
        if arguments.once or arguments.json or not sys.stdout.isatty():
            _once(link, info, plan, arguments)
        else:
            with contextlib.suppress(KeyboardInterrupt):  # the usual end of this command
                _live(link, info, plan, arguments.interval)
    return 0


def _once(link: Link, info: Info, plan: Plan, arguments: argparse.Namespace) -> None:
    time_us, rows = measure(link, info, plan, arguments.interval)
    if arguments.json:
        facts = {**facts_of(info, time_us), "tasks": [vars(row) for row in rows]}
        print(json.dumps(facts, indent=2))
        return
    from rich.console import Console

    console = Console(highlight=False)
    console.print(_table(info, plan, time_us, rows))
    _tell_fault(link, info, plan)


def _tell_fault(link: Link, info: Info, plan: Plan) -> None:
    record = link.fault() if info.failed_before else None
    if record is not None:
        print("\n".join(explain(record, plan)).replace("error: the", "previous run: the", 1))


def _live(link: Link, info: Info, plan: Plan, interval_s: float) -> None:
    from rich.live import Live

    with Live(auto_refresh=False) as live:
        while True:
            time_us, rows = measure(link, info, plan, interval_s)
            live.update(_table(info, plan, time_us, rows), refresh=True)


def _table(info: Info, plan: Plan, time_us: int, rows: list[Row]) -> Table:
    from rich import box
    from rich.table import Table

    load = ", load " + number(sum(row.load_pct or 0.0 for row in rows)) + " %"
    load += " of one processor" if info.unit == "cpu_time" else ""
    load = "" if info.unit == "nothing" else load
    state = ", SAFE MODE: no task runs" if info.safe_mode else ""
    table = Table(
        title=f"{info.graph} on {info.board}, up {time_us * 1e-6:.1f} s{load}{state}",
        caption=in_words(info),
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    table.add_column("lev", justify="right")
    table.add_column("task", overflow="fold")
    for name in ("/s", "load%", "last", "mean", "max", "resp", "lost", "silent"):
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(
            str(row.level),
            row.task,
            f"{row.per_s:.0f}",
            number(row.load_pct),
            number(row.last_us),
            number(row.mean_us),
            against(row.max_us, row.budget_us),
            against(row.response_max_us, latest_end_us(row, plan), digits=0),
            _count(row.lost_samples),
            _count(row.missed_life_signs),
        )
    return table


def _count(value: int) -> str:
    return "-" if value == 0 else f"[yellow]{value}[/]"
