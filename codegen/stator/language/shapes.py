"""The shapes that single values in a file can have. Each shape reads a tree, reports what is wrong
with it, and describes itself as JSON Schema, so that checker and editors never disagree."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

from stator.diagnostics import Mark, Report
from stator.language.yaml_tree import Mapping, Scalar, Sequence, Tree
from stator.names import reserved_reason

NAME_PATTERN = "[a-z][a-z0-9_]{0,62}"
_NAME = re.compile(NAME_PATTERN)
_INTEGER = re.compile(r"[+-]?(0|[1-9][0-9]{0,18})")
GRAPH_NAME = "the name of a graph, which is its file's"  # never a name in C++
VARIABLE = re.compile(r"\$\{([^}]*)\}")
_QUOTED_LENGTH = 60


class Leaf(NamedTuple):
    """A value that was read, and where it stood."""

    value: Any
    mark: Mark


class Record(NamedTuple):
    """A mapping that was read: what its keys hold, and where the keys stood."""

    values: dict[str, Any]
    mark: Mark
    keys: dict[str, Mark]
    owner: Mark  # the key that holds the mapping

    def get(self, key: str) -> Any:
        """What the key holds; None if it is absent or was wrong."""
        return self.values.get(key)

    def value(self, key: str, default: Any = None) -> Any:
        """The bare value of a leaf."""
        leaf = self.values.get(key)
        return default if leaf is None else leaf.value


def items(record: Record, key: str) -> list[tuple[str, Any]]:
    """Names and values of the table that a key holds; none if it is absent or was wrong."""
    table = record.get(key)
    return [] if table is None else list(table.values.items())


class Shape(Protocol):
    def read(self, tree: Tree, report: Report) -> Any:
        """The value of the tree, or None after reporting why there is none."""

    def schema(self) -> dict[str, Any]:
        """The shape as JSON Schema."""


def misshaped(tree: Tree, what: str, report: Report, hint: str = "") -> None:
    """Says that something of another shape is due."""
    if isinstance(tree, Scalar) and tree.is_null:
        report.error(
            tree.mark,
            "wrong-shape",
            f"{what} is due here, and there is nothing",
            "null removes only what an include brings"
            if tree.text
            else hint or "remove the key, or write its value",
        )
        return
    kind = (
        "a mapping"
        if isinstance(tree, Mapping)
        else "a list"
        if isinstance(tree, Sequence)
        else f"the single value {quoted(tree.text)}"
    )
    report.error(
        tree.mark,
        "wrong-shape",
        f"{what} is due here, not {kind}",
        hint or "write a single value; text that begins with a bracket stands in quotes",
    )


def scalar(tree: Tree, what: str, report: Report) -> Scalar | None:
    """The tree as a scalar that is not empty."""
    if isinstance(tree, Scalar) and not tree.is_null:
        if not (tree.text.startswith("${") and VARIABLE.fullmatch(tree.text)):
            return tree
        report.error(
            tree.mark,
            "variable-unknown",
            f"{tree.text[:60]} has no value",
            "include this file from another one, with `with`",
        )
        return None
    misshaped(tree, what, report)
    return None


@dataclass(frozen=True)
class Name:
    """A name that becomes a C++ name."""

    what: str = "a name"

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, self.what, report)
        if found is None or not check_name(found.text, found.mark, self.what, report):
            return None
        return Leaf(found.text, found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "pattern": f"^{NAME_PATTERN}$"}


def check_name(text: str, mark: Mark, what: str, report: Report) -> bool:
    fault = _name_fault(text, what)
    if fault is not None:
        report.error(mark, *fault)
    return fault is None


@lru_cache(maxsize=100_000)
def _name_fault(text: str, what: str) -> tuple[str, str, str] | None:
    """Rule, message and hint, if the text cannot be a name."""
    if "${" in text:
        return (
            "bad-name",
            f"{quoted(text)} cannot be {what}",
            "${name} stands for a whole value, never for a part of one or for a key",
        )
    if not _NAME.fullmatch(text):
        return (
            "bad-name",
            f"{quoted(text)} cannot be {what}",
            "use lower case letters, digits and underscores, a letter first, 63 at most",
        )
    reason = "" if what == GRAPH_NAME else reserved_reason(text, what)
    if reason:
        plain = re.sub("_+", "_", text.strip("_"))
        plain = f"my_{plain}" if reserved_reason(plain, what) else plain
        return "reserved-name", f"'{text}' cannot be {what}: {reason}", f"for example '{plain}'"
    return None


def quoted(text: str) -> str:
    shown_text = "".join(c if c.isprintable() else "?" for c in text[:_QUOTED_LENGTH])
    return f"'{shown_text}'" + ("..." if len(text) > _QUOTED_LENGTH else "")


@dataclass(frozen=True)
class Text:
    """Any text of one line or more."""

    pattern: str = ""
    what: str = "text"
    rule: str = "wrong-type"
    hint: str = ""

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, self.what, report)
        if found is None:
            return None
        if self.pattern and not re.fullmatch(self.pattern, found.text):
            report.error(
                found.mark, self.rule, f"{quoted(found.text)} is not {self.what}", self.hint
            )
            return None
        return Leaf(found.text, found.mark)

    def schema(self) -> dict[str, Any]:
        if self.pattern:
            return {"type": "string", "pattern": f"^({self.pattern})$"}
        return {"type": ["string", "number", "boolean"]}


@dataclass(frozen=True)
class Choice:
    """One of a few words."""

    words: tuple[str, ...]

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        what = " or ".join([", ".join(self.words[:-1]), self.words[-1]])
        found = scalar(tree, what, report)
        if found is None:
            return None
        if found.text not in self.words:
            report.error(
                found.mark,
                "wrong-type",
                f"{quoted(found.text)} is not {what}",
                report.nearest(found.text, self.words)
                if get_close_matches(found.text, self.words)
                else f"write {what}",
            )
            return None
        return Leaf(found.text, found.mark)

    def schema(self) -> dict[str, Any]:
        return {"enum": list(self.words)}


@dataclass(frozen=True)
class Boolean:
    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, "true or false", report)
        if found is None:
            return None
        if found.text not in ("true", "false"):
            report.error(
                found.mark,
                "wrong-type",
                f"{quoted(found.text)} is not true or false",
                "write true or false",
            )
            return None
        return Leaf(found.text == "true", found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": "boolean"}


@dataclass(frozen=True)
class Integer:
    least: int = 0
    most: int = 2**31 - 1

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, "a whole number", report)
        if found is None:
            return None
        if not _INTEGER.fullmatch(found.text):
            report.error(
                found.mark,
                "wrong-type",
                f"{quoted(found.text)} is not a whole number",
                f"write one from {self.least} to {self.most}, without leading zeros",
            )
            return None
        value = int(found.text)
        if not self.least <= value <= self.most:
            report.error(
                found.mark,
                "out-of-range",
                f"{value} is not between {self.least} and {self.most}",
                f"write {self.least if value < self.least else self.most}, or a number in between",
            )
            return None
        return Leaf(value, found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.least, "maximum": self.most}


@dataclass(frozen=True)
class Raw:
    """A scalar whose type another file declares."""

    may_be_variable: bool = False  # one that an including file gives its value

    def read(self, tree: Tree, report: Report) -> Scalar | None:
        if self.may_be_variable and isinstance(tree, Scalar) and not tree.is_null:
            return tree
        return scalar(tree, "a single value", report)

    def schema(self) -> dict[str, Any]:
        return {"type": ["string", "number", "boolean"]}
