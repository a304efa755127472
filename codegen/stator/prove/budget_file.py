"""`budgets/BOARD.yaml` beside the graphs: what was measured, and what is a guess."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.diagnostics import Report
from stator.language import keys as language
from stator.language.keys import PROVENANCES
from stator.language.yaml_tree import load

if TYPE_CHECKING:
    from pathlib import Path

# Of an emulated activation: a flight does not show the longest path through a node.
MARGIN = 2
GUESSED, EMULATED, HARDWARE = PROVENANCES


@dataclass(frozen=True)
class Row:
    budget_us: int
    source: str
    instructions: int | None = None

    def text(self, name: str) -> str:
        counted = "" if self.instructions is None else f", instructions: {self.instructions}"
        return f"{name}: {{budget: {self.budget_us} us, from: {self.source}{counted}}}\n"


def counted(instructions: int, instruction_ns: int) -> Row:
    budget_ns = MARGIN * instructions * instruction_ns
    return Row(-(-budget_ns // 1000), EMULATED, instructions)


def read_rows(file: Path) -> dict[str, Row]:
    """Raises `Failed`."""
    report = Report()
    tree = load(file, report) if file.is_file() else None
    table = None if tree is None else language.BUDGETS.read(tree, report)
    report.stop_on_errors()
    if table is None:
        return {}
    return {
        name: Row(row.value("budget"), row.value("from", GUESSED), row.value("instructions"))
        for name, row in table.values.items()
    }


def own(graph: str, node: str) -> str:
    """The key of what a graph's own flights have counted."""
    return f"{graph}.{node}"


def join(old: dict[str, Row], new: dict[str, Row]) -> dict[str, Row]:
    """The larger count of two flights holds. What hardware has measured stays."""
    found = dict(old)
    for name, row in new.items():
        before = old.get(name)
        if before is None or before.source == GUESSED:
            found[name] = row
        elif before.source == EMULATED:
            found[name] = max(before, row, key=lambda r: (r.instructions or 0, r.budget_us))
    return found


def file_text(rows: dict[str, Row], board: str, instruction_ns: int) -> str:
    return (
        f"# Written by ./stator measure for {board}. Emulated: the most instructions that QEMU "
        "counted in one\n"
        f"# activation, times {instruction_ns} ns (`instruction_ns` in board.yaml), times a margin "
        f"of {MARGIN}. Hardware has not\n"
        "# measured any of these. GRAPH.NODE is for one graph, NODE for those without a row of\n"
        "# their own. Write guesses here for what the emulator has not.\n"
        + "".join(rows[name].text(name) for name in sorted(rows))
    )
