"""YAML text to a tree that knows the line and column of every key and value.

Scalars stay text: what they mean is decided by the key that holds them, so that `on`, `010`,
`12:30` and `1e3` never turn into something else on the way. Anchors, aliases, tags and duplicate
keys are refused, nesting and size are bounded, and nothing here recurses.
"""

from __future__ import annotations

import re
import stat
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import yaml

from stator.diagnostics import MAX_BYTES, Mark, Report, beside, shown_path

if TYPE_CHECKING:
    from pathlib import Path

MAX_DEPTH = 32
_REFUSED = re.compile(
    "[^\t\n\r\x20-\x7e\x85\xa0-\u1fff\u2010-\u2027\u2030-\u205f\u2070-\ud7ff\ue000-\ufefe\uff00-\ufffd"
    "\U00010000-\U0010ffff]"
)  # what YAML refuses, and what hides or reorders the text around it


class Scalar(NamedTuple):
    text: str
    mark: Mark
    quoted: bool = False

    @property
    def is_null(self) -> bool:
        return not self.quoted and self.text in ("", "null", "~")


class Sequence(NamedTuple):
    items: list[Tree]
    mark: Mark


class Mapping(NamedTuple):
    entries: dict[str, Tree]
    mark: Mark
    keys: dict[str, Mark]
    owner: Mark  # of the key that holds this mapping, else of the mapping itself


Tree: TypeAlias = Scalar | Sequence | Mapping


def load(path: Path, report: Report) -> Tree | None:
    """Reads one file; None if it could not be understood (then the report says why)."""
    start = Mark(path, 1, 1)
    try:
        state = path.stat()
        if not stat.S_ISREG(state.st_mode):
            what = "a folder" if stat.S_ISDIR(state.st_mode) else "no regular file"
            report.error(
                start,
                "file-missing",
                f"cannot read the file: it is {what}",
                report.nearest(
                    "", [shown_path(graph) for graph in sorted(path.glob("*.yaml"))[:8]]
                ),
            )
            return None
        if state.st_size > MAX_BYTES:
            report.error(
                start,
                "file-too-large",
                f"the file has {state.st_size} bytes, more than {MAX_BYTES}",
                "split the graph with `include`",
            )
            return None
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = error.object[: error.start]
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8")) + 1
        report.error(
            Mark(path, before.count(b"\n") + 1, column),
            "encoding",
            f"not UTF-8 text: {error.reason}",
            "save the file as UTF-8",
        )
        return None
    except OSError as error:
        others = [shown_path(other) for other in sorted(path.parent.glob("*.yaml"))[:200]]
        hint = "make it a file that you may read"
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            nearest = report.nearest(shown_path(path), others)
            hint = nearest or "name a graph file, such as graph/quad.yaml"
        report.error(start, "file-missing", f"cannot read the file: {error.strerror}", hint)
        return None
    return parse(text, path, report)


def parse(text: str, path: Path, report: Report) -> Tree | None:
    """Parses YAML text as if it were the content of `path`."""
    refused = _REFUSED.search(text)
    if refused is not None:
        before = text[: refused.start()]
        mark = Mark(path, before.count("\n") + 1, refused.start() - (before.rfind("\n") + 1) + 1)
        _refuse_character(mark, refused.group(0), report)
        return None
    builder = _Builder(path, report)
    try:
        return builder.build(text)
    except yaml.MarkedYAMLError as error:
        position = error.problem_mark or error.context_mark
        if "quoted scalar" in (error.context or "") and error.context_mark is not None:
            position = error.context_mark
        line, column = (position.line + 1, position.column + 1) if position else (1, 1)
        report.error(
            Mark(path, line, column),
            "yaml-syntax",
            f"not YAML: {error.problem}",
            _syntax_hint(error, text.splitlines(), line, column, builder.innermost),
        )
    except yaml.YAMLError as error:
        report.error(Mark(path, 1, 1), "yaml-syntax", f"not YAML: {str(error).splitlines()[0]}")
    return None


def _refuse_character(mark: Mark, character: str, report: Report) -> None:
    report.error(
        mark,
        "encoding",
        f"the character U+{ord(character):04X} cannot stand in a file",
        "remove it; it is invisible or a control character",
    )


def _syntax_hint(
    error: yaml.MarkedYAMLError, lines: list[str], line: int, column: int, innermost: Mark | None
) -> str:
    problem = error.problem or ""
    shown = lines[line - 1] if line <= len(lines) else ""
    if "\t" in shown[: len(shown) - len(shown.lstrip())] or shown[column - 1 : column] == "\t":
        return "indent with spaces, not with tabs"
    if "mapping values are not allowed" in problem:
        return "text with ': ' in it stands in quotes; or the indentation of this line is off"
    if innermost is not None and "flow" in (error.context or ""):
        bracket = lines[innermost.line - 1][innermost.column - 1 : innermost.column]
        return f"the '{bracket}' in line {innermost.line}, column {innermost.column} is not closed"
    if "quoted scalar" in (error.context or ""):
        return "this quote is not closed"
    if "block" in (error.context or "") or "expected ':'" in problem:
        return "the indentation of this line does not fit the lines above, or a ':' is missing"
    if "cannot start any token" in problem:
        return "text that begins with this character stands in quotes"
    return ""


class _Open:
    """A collection whose end has not come yet."""

    __slots__ = ("entries", "items", "key", "key_mark", "keys", "mark", "skip")

    def __init__(self, node: Sequence | Mapping) -> None:
        self.mark = node.mark
        self.items = node.items if isinstance(node, Sequence) else None
        self.entries = node.entries if isinstance(node, Mapping) else {}
        self.keys = node.keys if isinstance(node, Mapping) else {}
        self.key: str | None = None
        self.key_mark: Mark | None = None
        self.skip = False  # the value belongs to a duplicate key


class _Builder:
    def __init__(self, path: Path, report: Report) -> None:
        self._path = path
        self._report = report
        self._stack: list[_Open] = []
        self._root: Tree | None = None

    @property
    def innermost(self) -> Mark | None:
        """The last collection that is still open."""
        return self._stack[-1].mark if self._stack else None

    def build(self, text: str) -> Tree | None:
        """One pass over the events; stops at the first thing that is refused, except that all
        duplicate keys are reported."""
        documents = 0
        for event in yaml.parse(text, Loader=yaml.CSafeLoader):
            if isinstance(event, yaml.ScalarEvent):
                mark = self._mark(event)
                if not self._is_plain(event, mark) or not self._is_shown(event.value, mark):
                    return None
                if not self._add(Scalar(event.value, mark, bool(event.style))):
                    return None
            elif isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
                mark = self._mark(event)
                if not self._is_plain(event, mark) or not self._is_shallow(mark):
                    return None
                node = self._collection(isinstance(event, yaml.MappingStartEvent), mark)
                if not self._add(node):
                    return None
                self._stack.append(_Open(node))
            elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
                self._stack.pop()
            elif isinstance(event, yaml.AliasEvent):
                self._refuse_alias(self._mark(event), f"alias '*{event.anchor}'")
                return None
            elif isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self._report.error(
                        self._mark(event),
                        "yaml-documents",
                        "a second document in one file",
                        "remove the line `---`",
                    )
                    return None
        if self._root is None or (isinstance(self._root, Scalar) and self._root.is_null):
            self._report.error(
                Mark(self._path, 1, 1),
                "yaml-empty",
                "the file has no content",
                "write it, or remove the file",
            )
            return None
        return self._root

    def _mark(self, event: yaml.Event) -> Mark:
        place = event.start_mark
        assert place is not None  # only events that are made by hand have none
        return Mark(self._path, place.line + 1, place.column + 1)

    def _collection(self, is_mapping: bool, mark: Mark) -> Sequence | Mapping:
        if not is_mapping:
            return Sequence([], mark)
        key_mark = self._stack[-1].key_mark if self._stack else None
        return Mapping({}, mark, {}, key_mark or mark)

    def _refuse_alias(self, mark: Mark, what: str) -> None:
        self._report.error(
            mark,
            "yaml-alias",
            f"{what} is refused",
            "write the value again, or use `include` with `with`",
        )

    def _is_plain(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent, mark: Mark) -> bool:
        if event.anchor is not None:
            self._refuse_alias(mark, f"anchor '&{event.anchor}'")
            return False
        if event.tag is not None:
            self._report.error(
                mark,
                "yaml-tag",
                f"tag '{event.tag}' is refused",
                "remove the tag; the key says what type its value has",
            )
            return False
        return True

    def _is_shown(self, text: str, mark: Mark) -> bool:
        """Escapes such as \\0 bring in characters that the file itself could not hold."""
        refused = None if text.isprintable() else _REFUSED.search(text)
        if refused is None:
            return True
        _refuse_character(mark, refused.group(0), self._report)
        return False

    def _is_shallow(self, mark: Mark) -> bool:
        if len(self._stack) < MAX_DEPTH:
            return True
        self._report.error(
            mark,
            "yaml-depth",
            f"nested deeper than {MAX_DEPTH} levels",
            "no file of Stator needs more than eight",
        )
        return False

    def _add(self, node: Tree) -> bool:
        if not self._stack:
            self._root = node
            return True
        top = self._stack[-1]
        if top.items is not None:
            top.items.append(node)
            return True
        if top.key is None:
            return self._begin_entry(top, node)
        if not top.skip and top.key_mark is not None:
            top.entries[top.key] = node
            top.keys[top.key] = top.key_mark
        top.key = None
        return True

    def _begin_entry(self, top: _Open, key: Tree) -> bool:
        if not isinstance(key, Scalar):
            self._report.error(
                key.mark,
                "wrong-shape",
                "a key must be a name",
                "text that begins with a bracket stands in quotes",
            )
            return False
        top.key, top.key_mark = key.text, key.mark
        top.skip = key.text in top.entries
        if top.skip:
            first = top.keys[key.text]
            self._report.error(
                key.mark,
                "duplicate-key",
                f"key '{key.text[:60]}' stands here twice",
                f"the other one is in {beside(key.mark, first)}; keep one of them",
            )
        return True
