"""`./stator prove`: the worst response time of each task and chain, against its deadline."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments
from stator.diagnostics import ANSWER_IS_NO, in_place
from stator.pipeline import make_plan
from stator.prove.changes import shortest_period_us
from stator.prove.needs import require_provable
from stator.prove.problems import problems
from stator.prove.proof import prove
from stator.prove.report import facts, text

if TYPE_CHECKING:
    import argparse

    from stator.plan.plan import Plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "--max-rate",
        metavar="NODE",
        help="find the shortest period of this node's line or timer with which all still holds",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    plan = make_plan(arguments.graph, arguments.board)
    require_provable(plan)
    if arguments.max_rate is not None:
        return _max_rate(plan, arguments)
    proof = prove(plan)
    errors = problems(proof)
    if arguments.json:
        shown = {**facts(proof), "errors": [error.as_json() for error in errors]}
        print(json.dumps(shown, indent=2))
    else:
        print(text(proof), end="")
        sys.stdout.flush()
        for error in errors:
            print(in_place(f"\n{error.text()}"), file=sys.stderr)
    return 0 if proof.holds else ANSWER_IS_NO


def _max_rate(plan: Plan, arguments: argparse.Namespace) -> int:
    name = arguments.max_rate
    us = shortest_period_us(plan, name)
    if arguments.json:
        print(json.dumps({"node": name, "shortest_period_us": us}, indent=2))
    elif us is None:
        print(f"{name}: the graph is not proven with its own rate; see ./stator prove without it")
    else:
        print(f"{name}: proven down to {us} us ({1e6 / us:.0f} Hz)")
    return ANSWER_IS_NO if us is None else 0
