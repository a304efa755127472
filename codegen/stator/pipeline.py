"""The compiler on one screen: load -> check -> plan -> emit."""

from __future__ import annotations

from pathlib import Path

from stator.diagnostics import Mark, Report, UserError
from stator.emit.emit import EXECUTORS, emit, emit_apps, emit_replay
from stator.graph.check import check
from stator.graph.interfaces import find_app
from stator.graph.sources import Sources
from stator.machines.cut import join
from stator.machines.links import check_links
from stator.plan.plan import Plan, plan


def make_plan(graph: str, board: str | None) -> Plan:
    """Loads, checks and plans the graph file. Raises `Failed`."""
    checked, bound = check(Path(graph), board)
    if checked.machines:
        checked, bound = join(checked, bound)
        report = Report()
        check_links(checked, report)
        report.stop_on_errors()
    return plan(checked, bound)


def make_buildable_plan(graph: str, board: str | None) -> Plan:
    """The plan, for a board whose executor exists. Raises `Failed` or `UserError`."""
    made = make_plan(graph, board)
    if made.board.executor not in EXECUTORS:
        raise UserError(
            f"error: cannot build for board '{made.board.name}': its executor "
            f"{made.board.executor} is not implemented\nhint: add --board sitl"
        )
    if made.graph.wires and made.board.executor != "virtual":
        raise UserError(
            f"error: cannot build for board '{made.board.name}': graph {made.graph.name} has "
            "several machines, which fly in virtual time only\nhint: add --board sitl"
        )
    return made


def make_files(graph: str, board: str | None, *, record: bool) -> dict[str, str]:
    """The generated C++: path below the output folder -> text. Raises `Failed` or `UserError`.
    `record`: each flight is recorded for replay."""
    return emit(make_buildable_plan(graph, board), record=record)


def make_replay_files(graph: str, board: str | None) -> dict[str, str]:
    """The C++ of the program that replays recordings of the graph. Raises `Failed`."""
    return emit_replay(make_plan(graph, board))


def make_app_files(folder: Path, names: list[str]) -> dict[str, str]:
    """What unit tests of apps need; the apps are found as those of a graph in the folder. Raises
    `Failed`."""
    report = Report()
    sources = Sources(folder, report)
    apps = [find_app(sources, name, Mark(folder / "apps" / name, 1, 1)) for name in names]
    report.stop_on_errors()
    return emit_apps([app for app in apps if app is not None], sources.files)
