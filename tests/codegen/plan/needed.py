"""Asks the full search of `needed_slots.cpp` how many slots topics need."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from stator.diagnostics import UserError

if TYPE_CHECKING:
    from collections.abc import Iterable

SOURCE = Path(__file__).with_name("needed_slots.cpp")
FOLDER = Path(__file__).resolve().parents[3] / "build" / "needed_slots"
FLAGS = ("-std=c++20", "-O2", "-Wall", "-Wextra", "-Werror")


def compiler() -> str:
    found = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if found is None:
        raise UserError("a C++ compiler is needed; ./stator setup installs one")
    return found


@cache
def _program() -> Path:
    FOLDER.mkdir(parents=True, exist_ok=True)
    program = FOLDER / "needed_slots"
    if not program.is_file() or program.stat().st_mtime < SOURCE.stat().st_mtime:
        subprocess.run([compiler(), *FLAGS, str(SOURCE), "-o", str(program)], check=True)
    return program


def needed_slots(topics: Iterable[str]) -> dict[str, int]:
    """By topic, as `needed_slots.cpp` spells it."""
    lines = list(dict.fromkeys(topics))
    result = subprocess.run(
        [str(_program())], input="\n".join(lines), capture_output=True, text=True, check=True
    )
    return dict(zip(lines, map(int, result.stdout.split()), strict=True))
