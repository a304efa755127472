"""What the compiler tells a user about a mistake: where, what, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

from stator.rules import RULES


@dataclass(frozen=True)
class Mark:
    """A place in a file. Line and column count from 1."""

    file: Path
    line: int
    column: int


@dataclass(frozen=True)
class Error:
    mark: Mark
    rule: str
    message: str
    hint: str

    def text(self) -> str:
        """The error as a person reads it, with the source line and a caret."""
        mark = self.mark
        lines = [f"{shown_path(mark.file)}:{mark.line}:{mark.column}: error: {self.message}"]
        source = source_line(mark)
        if source.strip():
            lines += ["    " + source, "    " + " " * (mark.column - 1) + "^"]
        if self.hint:
            lines.append(f"hint: {self.hint}")
        return "\n".join(lines)

    def as_json(self) -> dict[str, object]:
        return {
            "file": shown_path(self.mark.file),
            "line": self.mark.line,
            "column": self.mark.column,
            "rule": self.rule,
            "message": self.message,
            "hint": self.hint,
        }


class Failed(Exception):
    """The graph has errors; nothing was written."""

    def __init__(self, errors: list[Error]) -> None:
        super().__init__(f"{len(errors)} errors")
        self.errors = errors


class Report:
    """Collects errors, so that a user sees all of them, in order of position."""

    MOST_SHOWN = 100

    def __init__(self) -> None:
        self._errors: dict[tuple[str, int, int, str], Error] = {}

    def error(self, mark: Mark, rule: str, message: str, hint: str = "") -> None:
        assert rule in RULES, f"rule '{rule}' is not listed in rules.py"
        key = (str(mark.file), mark.line, mark.column, rule)
        self._errors.setdefault(key, Error(mark, rule, message, hint))

    def __bool__(self) -> bool:
        return bool(self._errors)

    def stop_on_errors(self) -> None:
        """Ends the compilation here if anything was wrong so far."""
        if self._errors:
            raise Failed([self._errors[key] for key in sorted(self._errors)])


def nearest(name: str, names: Iterable[str]) -> str:
    """A hint that names what the user may have meant."""
    known = sorted(names)
    close = get_close_matches(name, known, n=1)
    if close:
        return f"did you mean '{close[0]}'?"
    if not known:
        return ""
    shown = ", ".join(known[:8])
    return f"known: {shown}" + (", ..." if len(known) > 8 else "")


def shown_path(path: Path) -> str:
    """Relative to where the user stands, if it lies below."""
    try:
        return str(path.relative_to(Path.cwd()))
    except ValueError:
        return str(path)


def source_line(mark: Mark) -> str:
    try:
        with mark.file.open(encoding="utf-8", errors="replace") as file:
            for number, line in enumerate(file, start=1):
                if number == mark.line:
                    text = "".join(c if c.isprintable() else " " for c in line.rstrip("\r\n"))
                    return text[:160]
    except OSError:
        pass
    return ""
