"""Checks a graph and freezes it into the model: each step reports all it finds."""

from __future__ import annotations

import os
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.collector import without_collector
from stator.diagnostics import Mark, Report
from stator.graph.boards import find_board
from stator.graph.checks.machines import check_machines, read_machines
from stator.graph.checks.names import check_generated_names
from stator.graph.checks.nodes import read_nodes
from stator.graph.checks.parts import read_chains, read_modes
from stator.graph.checks.replaced import check_replaced
from stator.graph.checks.topics import connect
from stator.graph.model import Board, Budget, Graph
from stator.graph.sources import Sources
from stator.graph.vehicle import find_vehicle
from stator.language import keys as language
from stator.language.compose import Composer, check_variables
from stator.language.shapes import GRAPH_NAME, check_name

if TYPE_CHECKING:
    from stator.language.shapes import Record


@without_collector
def check(path: Path, board_name: str | None = None) -> tuple[Graph, Board]:
    """Reads and checks a graph. Returns it, bound to its own board, and the board to build for.

    Raises `Failed` with every error.
    """
    report = Report()
    path = Path(os.path.realpath(path))
    composer = Composer(report, (path.parent, HOME / "graph"))
    tree = composer.compose(path)
    if tree is None:
        report.stop_on_errors()
    assert tree is not None
    check_name(path.stem, Mark(path, 1, 1), GRAPH_NAME, report)
    if not composer.is_complete:
        report.stop_on_errors()  # a missing file could cause more errors: do not report those
    check_variables(tree, report)
    record = language.GRAPH.read(tree, report)
    assert record is not None
    if record.get("nodes") is None:
        report.stop_on_errors()
    if not record.get("nodes").keys:
        report.error(
            record.keys["nodes"],
            "out-of-range",
            "expected at least one node, found none",
            "add a node, for example `counter: {trigger: {every: 10 ms}}`",
        )

    sources = Sources(path.parent, report)
    vehicle = find_vehicle(sources, record.get("vehicle"), record.owner)
    if vehicle is None:
        report.stop_on_errors()  # parameters lack their values: do not report those
    own, board = _boards(record, board_name, sources)
    machines = read_machines(record, own, board, sources)
    nodes = read_nodes(record, machines, sources, _budgets(path, board, record, sources))
    topics = connect(record, nodes, report)
    modes = read_modes(record, nodes, report)
    chains = read_chains(record, nodes, report)
    check_machines(machines, nodes.good, topics, modes, chains, report)
    if board is not None:
        check_generated_names(nodes.good, topics, board, report)
        check_replaced(nodes.good.values(), board, sources, report)
    report.stop_on_errors()
    assert own is not None
    assert board is not None
    assert vehicle is not None
    graph = Graph(
        name=path.stem,
        file=path,
        doc=record.value("doc", ""),
        board=own,
        vehicle=vehicle,
        nodes=nodes.good,
        topics=topics,
        modes=modes,
        chains=chains,
        files=tuple(dict.fromkeys([*composer.files, *sources.files])),
        machines=machines.good,
    )
    return graph, board


def _boards(
    record: Record, name: str | None, sources: Sources
) -> tuple[Board | None, Board | None]:
    """The graph's own board, and the one to build for."""
    leaf = record.get("board")
    own = None if leaf is None else find_board(sources, leaf.value, leaf.mark)
    if name is None:
        return own, own
    mark = record.owner if leaf is None else leaf.mark
    return own, find_board(sources, name, mark, " (given with --board)")


def _budgets(
    path: Path, board: Board | None, record: Record, sources: Sources
) -> dict[str, Budget]:
    """The measured budgets of this board, if there are any."""
    if board is None:
        return {}
    file = path.parent / "budgets" / f"{board.name}.yaml"
    table = sources.read(file, language.BUDGETS) if file.is_file() else None
    if table is None:
        return {}
    # The graphs of a folder share the file: NODE is for all of them, GRAPH.NODE for one, and counts
    # there. A node of another graph is not an error here, but a name that resembles a node without
    # a budget is, unless an app has it.
    own = f"{path.stem}."
    keys = {key.removeprefix(own): key for key in table.values if "." not in key}
    keys |= {key.removeprefix(own): key for key in table.values if key.startswith(own)}
    without = [name for name in record.get("nodes").keys if name not in keys]
    for name, key in keys.items():
        close = get_close_matches(name, without, n=1, cutoff=0.8)
        if name in record.get("nodes").keys or name in sources.apps():
            continue
        if not close or _letters(name) == _letters(close[0]):
            continue
        sources.report.error(
            table.keys[key],
            "budget-node",
            f"unknown node '{name}' in {path.name}",
            f"did you mean '{close[0]}'?",
        )
    return {
        name: Budget(
            table.values[key].value("budget"),
            table.values[key].value("from", language.PROVENANCES[0]),
        )
        for name, key in keys.items()
        if table.values[key].value("budget") is not None
    }


def _letters(name: str) -> str:
    """A name without its number: imu1 is not a misspelt imu0."""
    return name.rstrip("0123456789")
