"""Paths that the programs of a build cannot take: known before anything is built."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import BuildFailed

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from stator.plan.plan import Plan

# What one of CMake (lists, patterns, variables), ninja or the shell reads as something else.
REFUSED = '[];\\$"#*?<>|`'


def input_paths(plan: Plan) -> list[Path]:
    """The folders of all that the graph is made of."""
    return list(dict.fromkeys(file.parent for file in plan.graph.files))


def check_paths(paths: Iterable[Path]) -> None:
    """Raises `BuildFailed` for the first one that cannot be built from."""
    for path in paths:
        found = [c for c in dict.fromkeys(str(path)) if c in REFUSED or not c.isprintable()]
        if found:
            named = " ".join("a line break" if c == "\n" else c for c in found)
            raise BuildFailed(
                f"error: cannot build in '{path}': CMake and the compilers do not take {named} in "
                "a path\nhint: rename the folder, or move the project to another one"
            )
