"""Finds what a graph names: apps, messages, device classes, drivers, boards, chips.

Looked for beside the graph first, then in Stator itself. Each file is read once.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import yaml_tree
from stator.read_board import read_board
from stator.read_interface import read_interface
from stator.read_message import read_message

if TYPE_CHECKING:
    from collections.abc import Callable

    from stator.diagnostics import Mark, Report
    from stator.model import Board, Interface, Message
    from stator.shapes import Record, Shape

HOME = Path(__file__).resolve().parents[2]


class Library:
    def __init__(self, beside: Path, report: Report) -> None:
        self.report = report
        self.files: list[Path] = []
        self._bases = [beside] if beside == HOME else [beside, HOME]
        self._cache: dict[tuple[str, str], Any] = {}

    # --- where things are ---

    def apps(self) -> dict[str, Path]:
        return self._folders("apps", "*/", lambda p: p.name, lambda p: p / f"{p.name}.yaml")

    def boards(self) -> dict[str, Path]:
        return self._folders("boards", "*/", lambda p: p.name, lambda p: p / "board.yaml")

    def classes(self) -> dict[str, Path]:
        return self._folders("drivers", "*/", lambda p: p.name, lambda p: p / f"{p.name}.yaml")

    def drivers(self) -> dict[str, Path]:
        def header(p: Path) -> Path:
            return p / f"{p.parent.name}_{p.name}.hpp"

        return self._folders("drivers", "*/*/", lambda p: f"{p.parent.name}/{p.name}", header)

    def messages(self) -> dict[str, Path]:
        def find() -> dict[str, Path]:
            found: dict[str, Path] = {}
            for base in self._bases:
                for folder in (base / "messages", base / "graph" / "messages"):
                    for path in sorted(folder.glob("*.yaml")):
                        found.setdefault(path.stem, path)
            return found

        result: dict[str, Path] = self._once("folders", "messages", find)
        return result

    def _folders(
        self, top: str, pattern: str, name: Callable[[Path], str], file: Callable[[Path], Path]
    ) -> dict[str, Path]:
        def find() -> dict[str, Path]:
            found: dict[str, Path] = {}
            for base in self._bases:
                for folder in sorted((base / top).glob(pattern)):
                    if file(folder).is_file():
                        found.setdefault(name(folder), file(folder))
            return found

        result: dict[str, Path] = self._once("folders", top + pattern, find)
        return result

    def chips(self, board: Path) -> dict[str, Path]:
        """Those that this board may name, by their path below boards/: beside it, then our own."""
        found: dict[str, Path] = {}
        for folder in (board.parents[1], HOME / "boards"):
            for path in sorted(folder.glob("*/*.yaml")):
                if path.name != "board.yaml":
                    found.setdefault(str(path.relative_to(folder).with_suffix("")), path)
        return found

    def read(self, path: Path, shape: Shape) -> Record | None:
        """A file in the given shape; None after saying what is wrong with it."""
        self.files.append(path)
        tree = yaml_tree.load(path, self.report)
        record: Record | None = None if tree is None else shape.read(tree, self.report)
        return record

    def _once(self, what: str, name: str, make: Callable[[], Any]) -> Any:
        if (what, name) not in self._cache:
            self._cache[what, name] = make()
        return self._cache[what, name]

    # --- what they are; `mark` is where they are named ---

    def message(self, name: str, mark: Mark) -> Message | None:
        path = self.messages().get(name)
        if path is None:
            self.report.error(
                mark,
                "message-unknown",
                f"there is no message '{name}'",
                self.report.nearest(name, self.messages())
                or f"make messages/{name}.yaml beside the graph",
            )
            return None
        found: Message | None = self._once("message", name, lambda: read_message(self, name, path))
        return found

    def app(self, name: str, mark: Mark) -> Interface | None:
        path = self.apps().get(name)
        if path is None:
            self.report.error(
                mark,
                "app-unknown",
                f"there is no app '{name}'",
                self.report.nearest(name, self.apps()) or f"make apps/{name}/{name}.yaml",
            )
            return None
        found: Interface | None = self._once(
            "app", name, lambda: read_interface(self, name, path, is_app=True)
        )
        return found

    def device_class(self, name: str, mark: Mark) -> Interface | None:
        path = self.classes().get(name)
        if path is None:
            self.report.error(
                mark,
                "class-unknown",
                f"there is no device class '{name}'",
                self.report.nearest(name, self.classes()) or f"make drivers/{name}/{name}.yaml",
            )
            return None
        found: Interface | None = self._once(
            "class", name, lambda: read_interface(self, name, path, is_app=False)
        )
        return found

    def board(self, name: str, mark: Mark, note: str = "") -> Board | None:
        path = self.boards().get(name)
        if path is None:
            self.report.error(
                mark,
                "board-unknown",
                f"there is no board '{name}'{note}",
                self.report.nearest(name, self.boards()),
            )
            return None
        found: Board | None = self._once("board", name, lambda: read_board(self, name, path))
        return found
