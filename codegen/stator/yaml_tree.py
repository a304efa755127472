"""YAML text to a tree that knows the line and column of every key and value.

Scalars stay text: what they mean is decided by the key that holds them, so that `on`, `010`,
`12:30` and `1e3` never turn into something else on the way. Anchors, aliases, tags and duplicate
keys are refused, nesting and size are bounded, and nothing here recurses.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Union

import yaml

from stator.diagnostics import Mark, Report

if TYPE_CHECKING:
    from pathlib import Path

MOST_BYTES = 16 * 1024 * 1024
MOST_DEPTH = 32


@dataclass(frozen=True)
class Scalar:
    text: str
    mark: Mark
    quoted: bool = False

    @property
    def is_null(self) -> bool:
        return not self.quoted and self.text in ("", "null", "~")


@dataclass(frozen=True)
class Sequence:
    items: list[Tree]
    mark: Mark


@dataclass(frozen=True)
class Mapping:
    entries: dict[str, Tree]
    mark: Mark
    keys: dict[str, Mark] = field(default_factory=dict)


Tree = Union[Scalar, Sequence, Mapping]


def load(path: Path, report: Report) -> Tree | None:
    """Reads one file; None if it could not be understood (then the report says why)."""
    start = Mark(path, 1, 1)
    try:
        if path.stat().st_size > MOST_BYTES:
            report.error(start, "file-too-large", f"the file is larger than {MOST_BYTES} bytes")
            return None
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError as error:
        report.error(start, "encoding", f"not UTF-8 text: byte {error.start} is {error.reason}")
        return None
    except OSError as error:
        report.error(start, "file-missing", f"cannot read the file: {error.strerror}")
        return None
    return parse(text, path, report)


def parse(text: str, path: Path, report: Report) -> Tree | None:
    """Parses YAML text as if it were the content of `path`."""
    try:
        return _Builder(path, report).build(text)
    except yaml.MarkedYAMLError as error:
        position = error.problem_mark or error.context_mark
        line, column = (position.line + 1, position.column + 1) if position else (1, 1)
        report.error(Mark(path, line, column), "yaml-syntax", f"not YAML: {error.problem}")
    except yaml.YAMLError as error:
        report.error(Mark(path, 1, 1), "yaml-syntax", f"not YAML: {str(error).splitlines()[0]}")
    return None


@dataclass
class _Open:
    """A collection whose end has not come yet."""

    node: Sequence | Mapping
    key: str | None = None
    key_mark: Mark | None = None
    skip: bool = False  # the value belongs to a duplicate key


class _Builder:
    def __init__(self, path: Path, report: Report) -> None:
        self._path = path
        self._report = report
        self._stack: list[_Open] = []
        self._root: Tree | None = None

    def build(self, text: str) -> Tree | None:
        documents = 0
        for event in yaml.parse(text, Loader=yaml.CSafeLoader):
            if isinstance(event, yaml.ScalarEvent):
                mark = self._mark(event)
                if not self._plain(event, mark):
                    return None
                self._add(Scalar(event.value, mark, bool(event.style)))
            elif isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
                mark = self._mark(event)
                if not self._plain(event, mark) or not self._shallow(mark):
                    return None
                is_mapping = isinstance(event, yaml.MappingStartEvent)
                node = Mapping({}, mark) if is_mapping else Sequence([], mark)
                if not self._add(node):
                    return None
                self._stack.append(_Open(node))
            elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
                self._stack.pop()
            elif isinstance(event, yaml.AliasEvent):
                self._error(self._mark(event), "yaml-alias", f"alias '*{event.anchor}' is refused",
                            "write the value again, or use `include` with `with`")
                return None
            elif isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self._error(self._mark(event), "yaml-documents",
                                "a second document in one file", "remove the line `---`")
                    return None
        if self._root is None or (isinstance(self._root, Scalar) and self._root.is_null):
            self._error(Mark(self._path, 1, 1), "yaml-empty", "the file has no content")
            return None
        return self._root

    def _mark(self, event: yaml.Event) -> Mark:
        return Mark(self._path, event.start_mark.line + 1, event.start_mark.column + 1)

    def _error(self, mark: Mark, rule: str, message: str, hint: str = "") -> None:
        self._report.error(mark, rule, message, hint)

    def _plain(self, event: yaml.NodeEvent, mark: Mark) -> bool:
        if event.anchor is not None:
            self._error(mark, "yaml-alias", f"anchor '&{event.anchor}' is refused",
                        "write the value again, or use `include` with `with`")
            return False
        if getattr(event, "tag", None) is not None:
            self._error(mark, "yaml-tag", f"tag '{event.tag}' is refused",
                        "remove the tag; the key says what type its value has")
            return False
        return True

    def _shallow(self, mark: Mark) -> bool:
        if len(self._stack) < MOST_DEPTH:
            return True
        self._error(mark, "yaml-depth", f"nested deeper than {MOST_DEPTH} levels")
        return False

    def _add(self, node: Tree) -> bool:
        if not self._stack:
            self._root = node
            return True
        top = self._stack[-1]
        if isinstance(top.node, Sequence):
            top.node.items.append(node)
            return True
        if top.key is None:
            if not isinstance(node, Scalar):
                self._error(node.mark, "wrong-shape", "a key must be a name")
                return False
            top.key, top.key_mark = node.text, node.mark
            top.skip = node.text in top.node.entries
            if top.skip:
                first = top.node.keys[node.text]
                self._error(node.mark, "duplicate-key", f"key '{node.text}' stands here twice",
                            f"the other one is in line {first.line}; keep one of them")
            return True
        if not top.skip and top.key_mark is not None:
            top.node.entries[top.key] = node
            top.node.keys[top.key] = top.key_mark
        top.key = None
        return True
