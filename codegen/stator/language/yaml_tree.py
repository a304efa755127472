"""YAML text to a tree that knows the line and column of every key and value.

Scalars stay text, so that `on`, `010`, `12:30` and `1e3` do not change: the key that holds a
scalar decides what it means. Anchors, aliases, tags and duplicate keys are refused. Nesting and
size have limits, and no function here calls itself.
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
)  # characters that YAML refuses, that are invisible, or that reorder the text around them


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
    """Reads one file; None after reporting why it cannot be read."""
    start = Mark(path, 1, 1)
    try:
        state = path.stat()
        if not stat.S_ISREG(state.st_mode):
            what = "a folder" if stat.S_ISDIR(state.st_mode) else "a device or socket"
            report.error(
                start,
                "file-missing",
                f"expected a file, found {what}",
                report.nearest(
                    "", [shown_path(graph) for graph in sorted(path.glob("*.yaml"))[:8]]
                ),
            )
            return None
        if state.st_size > MAX_BYTES:
            report.error(
                start,
                "file-too-large",
                f"expected a file of at most {MAX_BYTES} bytes, found {state.st_size}",
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
            f"expected UTF-8 text: {error.reason}",
            "save the file as UTF-8",
        )
        return None
    except OSError as error:
        others = [shown_path(other) for other in sorted(path.parent.glob("*.yaml"))[:200]]
        hint = "check the permissions of the file"
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            nearest = report.nearest(shown_path(path), others)
            hint = nearest or "give a graph file, for example graph/quad.yaml"
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
            f"invalid YAML: {error.problem}",
            _syntax_hint(error, text.splitlines(), line, column, builder.innermost),
        )
    except yaml.YAMLError as error:
        report.error(Mark(path, 1, 1), "yaml-syntax", f"invalid YAML: {str(error).splitlines()[0]}")
    return None


def _refuse_character(mark: Mark, character: str, report: Report) -> None:
    report.error(
        mark,
        "encoding",
        f"character U+{ord(character):04X} is not allowed",
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
        return "quote text that contains ': ', or correct the indentation of this line"
    if innermost is not None and "flow" in (error.context or ""):
        bracket = lines[innermost.line - 1][innermost.column - 1 : innermost.column]
        return f"close the '{bracket}' of line {innermost.line}, column {innermost.column}"
    if "quoted scalar" in (error.context or ""):
        return "close this quote"
    if "block" in (error.context or "") or "expected ':'" in problem:
        return "indent this line like the lines above, or add the missing ':'"
    if "cannot start any token" in problem:
        return "quote text that begins with this character"
    return ""


class _Open:
    """A list or mapping whose end is not read yet."""

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
        """The innermost list or mapping that is still open."""
        return self._stack[-1].mark if self._stack else None

    def build(self, text: str) -> Tree | None:
        """One pass over the events. It stops at the first error, except for duplicate keys, which
        are all reported."""
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
                        "expected one document, found a second one",
                        "remove the line `---`",
                    )
                    return None
        if self._root is None or (isinstance(self._root, Scalar) and self._root.is_null):
            self._report.error(
                Mark(self._path, 1, 1),
                "yaml-empty",
                "the file is empty",
                "write its content, or remove the file",
            )
            return None
        return self._root

    def _mark(self, event: yaml.Event) -> Mark:
        place = event.start_mark
        assert place is not None  # the parser sets it
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
            f"{what} is not allowed",
            "repeat the value, or use `include` with `with`",
        )

    def _is_plain(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent, mark: Mark) -> bool:
        if event.anchor is not None:
            self._refuse_alias(mark, f"anchor '&{event.anchor}'")
            return False
        if event.tag is not None:
            self._report.error(
                mark,
                "yaml-tag",
                f"tag '{event.tag}' is not allowed",
                "remove the tag; the key defines the type of its value",
            )
            return False
        return True

    def _is_shown(self, text: str, mark: Mark) -> bool:
        """An escape such as \\0 can stand for a character that is not allowed in the file."""
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
            f"expected at most {MAX_DEPTH} levels of nesting, found more",
            "nest less: a graph needs at most eight levels",
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
                f"expected a key, found {'a list' if isinstance(key, Sequence) else 'a mapping'}",
                "quote text that begins with a bracket",
            )
            return False
        top.key, top.key_mark = key.text, key.mark
        top.skip = key.text in top.entries
        if top.skip:
            first = top.keys[key.text]
            self._report.error(
                key.mark,
                "duplicate-key",
                f"duplicate key '{key.text[:60]}'",
                f"first one: {beside(key.mark, first)}; keep one of them",
            )
        return True
