"""`./stator whatif`: which bounds move if a rate, a priority, a budget or the board changes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments
from stator.diagnostics import ANSWER_IS_NO
from stator.pipeline import make_plan
from stator.plan.text import text_table
from stator.prove.changes import HINT, changed
from stator.prove.needs import require_provable
from stator.prove.problems import shown_ns
from stator.prove.proof import prove

if TYPE_CHECKING:
    import argparse

    from stator.prove.proof import Proof


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "--set", nargs="+", action="extend", default=[], metavar="NODE.KEY=VALUE", help=HINT
    )
    parser.add_argument("--on", metavar="BOARD", help="another board, as a change")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    """1 if the changed graph is not proven."""
    plan = make_plan(arguments.graph, arguments.board)
    require_provable(plan)
    other = make_plan(arguments.graph, arguments.on or arguments.board)
    require_provable(other)
    before, after = prove(plan), prove(changed(other, arguments.set))
    rows = _bounds(before), _bounds(after)
    moved = [name for name in rows[1] if rows[0].get(name) != rows[1][name]]
    if arguments.json:
        bounds = {
            name: {"before_ns": rows[0][name][0], "after_ns": rows[1][name][0]} for name in moved
        }
        proven = {"proven_before": before.holds, "proven_after": after.holds}
        print(json.dumps({**proven, "bounds": bounds}, indent=2))
    else:
        _show(rows, moved)
        print("proven" if after.holds else "NOT PROVEN", end="")
        print("" if before.holds else "; before the change it was not proven")
    return 0 if after.holds else ANSWER_IS_NO


Bounds = dict[str, tuple[int | None, int]]  # name: response or reaction, and deadline


def _bounds(proof: Proof) -> Bounds:
    found: Bounds = {task.name: (task.response_ns, task.deadline_ns) for task in proof.tasks}
    for bound in proof.chains:
        found[f"chain {bound.chain.name}"] = (bound.reaction_ns, bound.deadline_ns)
    return found


def _show(rows: tuple[Bounds, Bounds], moved: list[str]) -> None:
    table = [("bound", "before", "after", "deadline", "")]
    for name in moved:
        (before, _), (after, deadline) = rows[0][name], rows[1][name]
        late = after is None or after > deadline
        table.append(
            (name, _shown(before), _shown(after), shown_ns(deadline), "LATE" if late else "")
        )
    print("\n".join(text_table(table)) if moved else "no bound moves")


def _shown(value: int | None) -> str:
    return "no bound" if value is None else shown_ns(value)
