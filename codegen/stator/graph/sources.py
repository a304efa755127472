"""Finds what a graph names: apps, messages, vehicles, device classes, drivers, boards, chips.

Searches the folder of the graph first, then Stator itself. Reads each file once.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import HOME
from stator.language import yaml_tree

if TYPE_CHECKING:
    from collections.abc import Callable

    from stator.diagnostics import Report
    from stator.language.shapes import Record, Shape


class Sources:
    def __init__(self, beside: Path, report: Report) -> None:
        self.report = report
        self.files: list[Path] = []
        self.vehicle = "iris"  # of the graph, once it is known
        self._bases = [beside] if beside == HOME else [beside, HOME]
        self._cache: dict[tuple[str, str], Any] = {}

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
        return self._files("messages")

    def vehicles(self) -> dict[str, Path]:
        return self._files("vehicles")

    def _files(self, kind: str) -> dict[str, Path]:
        def find() -> dict[str, Path]:
            found: dict[str, Path] = {}
            for base in self._bases:
                for folder in (base / kind, base / "graph" / kind):
                    for path in sorted(folder.glob("*.yaml")):
                        found.setdefault(path.stem, path)
            return found

        result: dict[str, Path] = self.once("folders", kind, find)
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

        result: dict[str, Path] = self.once("folders", top + pattern, find)
        return result

    def chips(self, board: Path) -> dict[str, Path]:
        """The chips that this board may name, by their path below boards/. Files beside the board
        come before Stator's own."""
        found: dict[str, Path] = {}
        for folder in (board.parents[1], HOME / "boards"):
            for path in sorted(folder.glob("*/*.yaml")):
                if path.name != "board.yaml":
                    found.setdefault(str(path.relative_to(folder).with_suffix("")), path)
        return found

    def read(self, path: Path, shape: Shape) -> Record | None:
        """The file as `shape` reads it; None after reporting what is wrong."""
        self.files.append(path)
        tree = yaml_tree.load(path, self.report)
        record: Record | None = None if tree is None else shape.read(tree, self.report)
        return record

    def once(self, what: str, name: str, make: Callable[[], Any]) -> Any:
        """The result of the first call of `make` for this name."""
        if (what, name) not in self._cache:
            self._cache[what, name] = make()
        return self._cache[what, name]
