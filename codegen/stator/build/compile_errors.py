"""The errors in a compiler's output, as the user reads them: at the line of the user's own file,
and without what the compiler says around them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path

from stator import HOME
from stator.build.walls import ROOMS as NODE_ROOMS
from stator.diagnostics import Mark, shown_path, source_line

MAX_SHOWN = 10
_PLACE = r"(?P<file>[^:\n]+):(?P<line>\d+):(?P<column>\d+):"
_HEAD = re.compile(rf"^{_PLACE} (?P<kind>fatal error|error|warning|note): (?P<text>.*)$")
_REQUIRED = re.compile(rf"^{_PLACE} +(?:recursively )?required (?:from|by)\b")
_AROUND = re.compile(r"^(In file included from |\s+from |\S.*: (In|At) |ninja: |cc1plus: )")
# Texts of ours inside the compiler's.
_OWN_TEXT = re.compile(r"declared with attribute error: (.*)$|static assertion failed: (.*)$")
# A text that names the user's file: emit/templates/task.cpp.j2.
_NAMED = re.compile(r"(?P<file>(?:apps|drivers)/\S+\.hpp): (?P<text>.*)")
# A name that a header of the runtime declares, and the code does not include.
_UNKNOWN = re.compile(
    r"^'(?:[\w:]+::)?(\w+)' (?:was not declared in this scope|is not a member of 'stator\b)"
)
# What users do not write.
_OURS = (HOME / "runtime", HOME / "build", HOME / "boards")


@dataclass
class _Found:
    mark: Mark
    text: str
    below: list[str] = field(default_factory=list)  # the source line, a caret, a hint
    is_moved: bool = False


def errors_in(output: str, folder: Path) -> str:
    """The errors of the output; empty if there is none that is known. `folder`: of the build, from
    which the compiler names files."""
    found: list[_Found] = []
    required: list[Mark] = []  # the way into a template, up to the next error
    current: _Found | None = None
    for line in output.splitlines():
        head, way = _HEAD.match(line), _REQUIRED.match(line)
        if way is not None:
            required.append(_mark(way, folder))
            current = None
        elif head is not None:
            current = None
            if head["kind"] in ("error", "fatal error"):
                current = _Found(_mark(head, folder), _text(head["text"]))
                moved = _at_users_line(current, required)
                found.append(moved or current)
                current = None if moved else current
                required = []
        elif _AROUND.match(line):
            current = None
        elif current is not None:
            current.below.append(line)
    shown = list(dict.fromkeys(_shown(error) for error in _users_first(found)))
    left = len(shown) - MAX_SHOWN
    return "\n\n".join([*shown[:MAX_SHOWN], *([f"... and {left} more"] if left > 0 else [])])


def kept(output: str, folder: Path) -> str:
    """Writes the output to the build's folder. The hint that says so; empty if the disk is full."""
    whole = folder / "errors.log"
    try:
        whole.write_text(f"{output}\n", encoding="utf-8")
    except OSError:
        return ""
    return f"\nhint: the compiler's whole output is in {shown_path(whole)}"


def _users_first(found: list[_Found]) -> list[_Found]:
    """Errors in generated code and in templates follow from those in the user's, if there are
    any."""
    own = [error for error in found if not _is_ours(error.mark.file)]
    return [error for error in own if not error.is_moved] or own or found


def _at_users_line(error: _Found, required: list[Mark]) -> _Found | None:
    """An error in a template of ours, where the user's code takes it; None if it does not."""
    own = [mark for mark in required if not _is_ours(mark.file)]
    if not _is_ours(error.mark.file) or not own:
        return None
    source, caret = source_line(own[-1])
    below = [f"    {source}".rstrip(), " " * (4 + caret) + "^"]
    return _Found(own[-1], error.text, below, is_moved=True)


def _is_ours(file: Path) -> bool:
    return any(file.is_relative_to(folder) for folder in _OURS)


def _text(text: str) -> str:
    own = _OWN_TEXT.search(text)
    return text if own is None else str(own[1] or own[2])


def _mark(match: re.Match[str], folder: Path) -> Mark:
    path = Path(os.path.normpath(folder / match["file"]))
    return Mark(path, int(match["line"]), int(match["column"]))


def _shown(error: _Found) -> str:
    mark = error.mark
    named = _NAMED.match(error.text)
    if named is not None:
        return f"{named['file']}: error: {named['text']}"
    head = f"{shown_path(mark.file)}:{mark.line}:{mark.column}: error: {error.text}"
    return "\n".join([head, *error.below, *_header_hint(error.text)]).rstrip()


def _header_hint(text: str) -> list[str]:
    """What to include for a name of the runtime."""
    unknown = _UNKNOWN.match(text)
    if unknown is None:
        return []
    words = r"^(?:template <[^>]*> |[\w:<>]+ )+"
    declared = re.compile(rf"{words}{unknown[1]}\b[ ({{:]", re.MULTILINE)
    for room in NODE_ROOMS:
        folder = HOME / "runtime" / room / "stator"
        for header in sorted(folder.rglob("*.hpp")):
            if not declared.search(header.read_text(encoding="utf-8")):
                continue
            if header.parent != folder or header.name == "scalar.hpp":  # which includes the parts
                return [f'hint: stator::math::{unknown[1]} is in "stator/scalar.hpp"']
            return [f'hint: #include "stator/{header.name}"']
    return []
