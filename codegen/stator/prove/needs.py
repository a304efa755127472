"""What a proof needs: a board that says what it takes, budgets, and the distance of events."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import Report, UserError, shown_argument, shown_path

if TYPE_CHECKING:
    from stator.plan.plan import Plan

NAMES_SHOWN = 6


def require_provable(plan: Plan) -> None:
    """Raises `Failed` or `UserError`, with what to do."""
    board = plan.board
    if plan.graph.wires:
        raise UserError(
            f"error: cannot prove graph {plan.graph.name}: it has several machines, and the proof "
            "is for one\nhint: ./stator check shows the load and the bounds of its links"
        )
    if board.costs is None:
        what = "no key `costs`" if board.executor == "cortex_m" else f"executor {board.executor}"
        raise UserError(
            f"error: cannot prove a graph on board '{board.name}': {what}\n"
            "hint: "
            + (
                f"add `costs:` to {shown_path(board.file)}"
                if board.executor == "cortex_m"
                else "the proof is for boards with executor cortex_m, for example --board fmu_v2"
            )
        )
    report = Report()
    _check_budgets(plan, report)
    for task in plan.tasks:
        for trigger in task.node.triggers:
            if trigger.kind == "irq" and trigger.min_interarrival_us is None:
                report.error(
                    trigger.mark,
                    "interarrival-missing",
                    f"missing key 'min_interarrival' of line '{trigger.name}'",
                    "add the shortest time between two events, for example "
                    "`min_interarrival: 900 us`",
                )
    report.stop_on_errors()


def _check_budgets(plan: Plan, report: Report) -> None:
    """One error for all of them, at the first one."""
    missing = sorted((t.node for t in plan.tasks if t.node.budget is None), key=lambda n: n.mark)
    if not missing:
        return
    names = ", ".join(node.name for node in missing[:NAMES_SHOWN])
    more = f" and {len(missing) - NAMES_SHOWN} more" if len(missing) > NAMES_SHOWN else ""
    graph, board = shown_argument(plan.graph.file), plan.board.name
    first = missing[0]
    report.error(
        first.mark,
        "budget-missing",
        f"missing budget of {names}{more}",
        (
            f"measure: ./stator measure {graph} --board {board}",
            f"or write a guess: `{first.name}: 50 us` in budgets/{board}.yaml beside the graph",
        ),
    )
