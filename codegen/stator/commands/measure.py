"""`./stator measure`: flies a graph in the emulator, and writes budgets from what it counts."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from typing import TYPE_CHECKING, Any

from stator.arguments import add_graph_arguments
from stator.diagnostics import NOT_DONE, UserError, shown_path
from stator.emulator import chip
from stator.pipeline import make_plan
from stator.plan.text import text_table, unbound_devices
from stator.prove.budget_file import Row, counted, file_text, join, own, read_rows

if TYPE_CHECKING:
    import argparse

    from stator.graph.model import Board, Node

EMULATED_BOARD = "qemu_f405"  # of images that the emulator of their own chip cannot fly


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "--flight",
        default="",
        metavar="ARGUMENTS",
        help='of ./stator emulate, for example --flight="--wind 8 --seed 3"',
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    """0, also after a flight that failed: what it took, it took."""
    plan = make_plan(arguments.graph, arguments.board)
    board = plan.board
    instruction_ns = None if board.costs is None else board.costs.instruction_ns
    if instruction_ns is None:
        raise UserError(
            f"error: cannot measure for board '{board.name}': it does not say how long an "
            f"instruction takes\nhint: add `costs:` with `instruction_ns:` to "
            f"{shown_path(board.file)}"
        )
    flies_itself = board.name == chip.BOARD and not unbound_devices(plan)
    emulated = board if flies_itself else make_plan(arguments.graph, EMULATED_BOARD).board
    figures = _fly(arguments.graph, emulated.name, shlex.split(arguments.flight))
    new: dict[str, Row] = {}
    missing: dict[str, str] = {}
    for row in figures:
        why = _why_not(plan.graph.nodes[row["task"]], row, board, emulated)
        if why:
            missing[row["task"]] = why
        else:
            key = own(plan.graph.name, row["task"])
            new[key] = counted(row["instructions"], instruction_ns)
    file = plan.graph.file.parent / "budgets" / f"{board.name}.yaml"
    rows = join(read_rows(file), new)
    file.parent.mkdir(exist_ok=True)
    file.write_text(file_text(rows, board.name, instruction_ns), encoding="utf-8")
    missing = {name: why for name, why in missing.items() if name in plan.graph.nodes}
    if arguments.json:
        shown = {name: vars(row) for name, row in rows.items()}
        print(json.dumps({"file": str(file), "budgets": shown, "missing": missing}, indent=2))
    else:
        _show(plan.graph.name, new, rows, missing)
        print(f"{shown_path(file)}: written")
    return 0


def _fly(graph: str, board: str, options: list[str]) -> list[dict[str, Any]]:
    command = [sys.executable, "-m", "stator", "emulate", graph, "--board", board, "--no-record"]
    finished = subprocess.run(
        [*command, "--figures", "--json", *options], stdout=subprocess.PIPE, text=True, check=False
    )
    if finished.returncode >= NOT_DONE or not finished.stdout:
        raise UserError("error: the emulated flight did not end; its message is above")
    found: list[dict[str, Any]] = json.loads(finished.stdout)["figures"]
    return found


def _why_not(node: Node, row: dict[str, Any], board: Board, emulated: Board) -> str:
    """Why the count says nothing about this board; empty if it does."""
    if node.device is not None:
        own, other = board.devices[node.device].driver, emulated.devices[node.device].driver
        if own != other:
            return f"driver {own} instead of {other}"
    return "" if row["activations"] else "never activated in this flight"


def _show(graph: str, new: dict[str, Row], rows: dict[str, Row], missing: dict[str, str]) -> None:
    shown = [("task", "instructions", "budget", "")]
    shown += [
        (
            key.removeprefix(own(graph, "")),
            str(row.instructions),
            f"{rows[key].budget_us} us",
            _note(row, rows[key]),
        )
        for key, row in new.items()
    ]
    print("\n".join(text_table(shown)))
    for name, why in missing.items():
        kept = rows.get(own(graph, name)) or rows.get(name)
        has = "no budget" if kept is None else f"budget {kept.budget_us} us, {kept.source}"
        print(f"{name}: not measured, {why}; {has}")


def _note(new: Row, kept: Row) -> str:
    if new == kept:
        return ""
    if kept.instructions is None:
        return f"kept, {kept.source}"
    return f"kept, another flight took {kept.instructions} instructions"
