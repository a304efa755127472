"""Errors as the user reads them: where, what is wrong, and what to do."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import sys
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from stator import HOME
from stator.rules import PROOF_RULES, RULES

if TYPE_CHECKING:
    from collections.abc import Iterable

# Exit statuses, the same for all commands: docs/json.md. 0 is success.
ANSWER_IS_NO = 1  # the command ran, and the answer is no: errors found, a failed flight
NOT_DONE = 2  # the command could not run
INTERRUPTED = 130
SIGNALLED = 128  # and the number of the signal that ended it

MAX_BYTES = 16 * 1024 * 1024  # of one file
# A longer source line is shown in part, around the caret.
MAX_COLUMNS = 160
MAX_CHARACTERS = 400  # of a message or a hint
# Names compared for hints, over all errors of one run: a file full of mistakes must not take
# minutes.
MAX_COMPARED = 200_000
_COMMAND = re.compile(r"(?<![\w./-])\./stator(?![\w./-])")
_LINE_END = re.compile("\r\n|[\n\r\x85\u2028\u2029]")  # the ends of a line in YAML


class Mark(NamedTuple):
    """A place in a file. Line and column count from 1."""

    file: Path
    line: int
    column: int


@dataclass(frozen=True)
class Error:
    mark: Mark
    rule: str
    message: str
    hint: str  # several: a line each
    notes: tuple[str, ...] = ()

    def text(self) -> str:
        """The error as a person reads it, with the source line and a caret."""
        mark = self.mark
        lines = [f"{shown_path(mark.file)}:{mark.line}:{mark.column}: error: {self.message}"]
        source, caret = source_line(mark)
        if source.strip():
            lines += [f"    {source}".rstrip(), " " * (4 + caret) + "^"]
        lines += [f"note: {note}" for note in self.notes]
        lines += [f"hint: {hint}" for hint in self.hint.splitlines()]
        return "\n".join(lines)

    def as_json(self) -> dict[str, object]:
        return {
            "file": shown_path(self.mark.file),
            "line": self.mark.line,
            "column": self.mark.column,
            "rule": self.rule,
            "message": self.message,
            "hint": self.hint,
            **({"notes": list(self.notes)} if self.notes else {}),
        }


class Failed(Exception):
    """The graph has errors; nothing was written."""

    def __init__(self, errors: list[Error]) -> None:
        super().__init__(f"{len(errors)} errors")
        self.errors = errors


class UserError(Exception):
    """The command cannot do what the user asked; the message says why, and what to do."""


class BuildFailed(UserError):
    """CMake or the compiler failed; the message is their output."""


class Ended(BaseException):
    """A signal asks this process to end: what it has begun is ended in order."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class Report:
    """Collects errors; the user sees all of them, in order of position."""

    def __init__(self) -> None:
        self._errors: dict[tuple[Mark, str, str], Error] = {}
        self._compared = 0

    def error(
        self,
        mark: Mark,
        rule: str,
        message: str,
        hint: str | tuple[str, ...] = "",
        notes: tuple[str, ...] = (),
    ) -> None:
        """`hint`: several are alternatives. `notes`: facts behind the message."""
        assert rule in RULES or rule in PROOF_RULES, f"rule '{rule}' is not listed in rules.py"
        hints = "\n".join(map(_one_line, (hint,) if isinstance(hint, str) else hint))
        error = Error(mark, rule, _one_line(message), hints, notes)
        self._errors.setdefault((mark, rule, error.message), error)

    def nearest(self, name: str, names: Iterable[str]) -> str:
        """A hint with the name that the user may have meant."""
        known = list(names)
        self._compared += len(known)
        return nearest(name, known) if self._compared <= MAX_COMPARED else ""

    def __len__(self) -> int:
        return len(self._errors)

    def stop_on_errors(self) -> None:
        """Raises `Failed` if there is an error so far."""
        if self._errors:
            raise Failed([self._errors[key] for key in sorted(self._errors)])


def _one_line(text: str) -> str:
    """Messages quote the user's text, which may hold any character and be long."""
    shown = text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)
    return shown if len(shown) <= MAX_CHARACTERS else shown[:MAX_CHARACTERS] + "..."


def nearest(name: str, names: Iterable[str]) -> str:
    known = sorted(names)
    close = get_close_matches(name[:100], known, n=1)
    if close:
        return f"did you mean '{close[0]}'?"
    if not known:
        return ""
    shown = ", ".join(known[:8])
    return f"known: {shown}" + (", ..." if len(known) > 8 else "")


def beside(mark: Mark, other: Mark) -> str:
    """Where `other` is, for an error at `mark`."""
    if other.file == mark.file:
        return f"line {other.line}"
    return f"{shown_path(other.file)}:{other.line}"


def entry() -> str:
    """How `./stator` is called from the current folder."""
    called = os.environ.get("STATOR_ENTRY", "")  # set by ./stator itself
    if Path.cwd() == HOME:
        return "./stator"
    for name in (Path(called).name, called):
        found = shutil.which(name) if name else None
        if found is not None and os.path.realpath(found) == str(HOME / "stator"):
            return shlex.quote(name)
    return shlex.quote(str(HOME / "stator"))


def in_place(text: str) -> str:
    """A text for the user, with commands as they are typed in the current folder."""
    return _COMMAND.sub(lambda _: entry(), text) if "./stator" in text else text


def shown_argument(path: Path) -> str:
    """A path as a word of a command that is typed in the current folder."""
    shown = shown_path(path)
    return shlex.quote(f"./{shown}" if shown.startswith("-") else shown)


def shown_path(path: Path) -> str:
    """Relative to the current folder, if the path is below it."""
    try:
        return str(path.relative_to(Path.cwd()))
    except ValueError:
        return str(path)


def source_line(mark: Mark) -> tuple[str, int]:
    """The line, or a part of it around the mark, and the number of characters before the mark."""
    try:
        state = mark.file.stat()
        if state.st_size > MAX_BYTES:
            return "", 0
        lines = _lines(mark.file, state.st_mtime_ns, state.st_size)
    except (OSError, ValueError):
        return "", 0
    if mark.line > len(lines):
        return "", 0
    text, before = lines[mark.line - 1], mark.column - 1
    start = max(0, before - MAX_COLUMNS // 2) if len(text) > MAX_COLUMNS else 0
    part = text[start : start + MAX_COLUMNS]
    return "".join(c if c.isprintable() else " " for c in part), before - start


@lru_cache(maxsize=4)
def _lines(file: Path, mtime_ns: int, size: int) -> list[str]:  # time and size: a key of the cache
    if not Path(file).is_file():
        return []
    text = Path(file).read_bytes().decode("utf-8-sig", errors="replace")
    return _LINE_END.split(text)


def show_errors(failed: Failed) -> None:
    shown = failed.errors[:100]
    print("\n\n".join(error.text() for error in shown), file=sys.stderr)
    count = len(failed.errors)
    more = f", {count - len(shown)} not shown" if count > len(shown) else ""
    print(f"\n{count} error{'s' if count > 1 else ''}{more}; nothing was written", file=sys.stderr)
