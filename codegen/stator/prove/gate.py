"""What is for a vehicle has to be proven first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import Failed, UserError, shown_argument
from stator.prove.needs import require_provable
from stator.prove.problems import problems
from stator.prove.proof import prove

if TYPE_CHECKING:
    import argparse

    from stator.plan.plan import Plan

HELP = "also an image whose deadlines are not proven; its .px4 file says so"


def add_unproven_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--unproven", action="store_true", help=HELP)


def is_for_a_vehicle(plan: Plan) -> bool:
    """Whether the board is hardware: an image can be uploaded to it."""
    return plan.board.upload is not None


def require_proof(plan: Plan, *, unproven: bool) -> bool:
    """Whether it is proven; raises `UserError` if it is not and has to be."""
    why = why_unproven(plan) if is_for_a_vehicle(plan) else ""
    if not why or unproven:
        return not why
    graph, board = shown_argument(plan.graph.file), plan.board.name
    raise UserError(
        f"{why}\n\nerror: the deadlines of {plan.graph.name} on {board} are not proven\n"
        f"hint: ./stator prove {graph} --board {board} shows all bounds; "
        "--unproven builds the image all the same"
    )


def why_unproven(plan: Plan) -> str:
    """The errors of its proof; empty if it holds. A missing budget names what measures it."""
    try:
        require_provable(plan)
    except Failed as failed:
        return "\n\n".join(error.text() for error in failed.errors)
    except UserError as error:
        return str(error)
    return "\n\n".join(error.text() for error in problems(prove(plan)))
