"""The shapes that single values in a file can have. Each shape reads a tree, reports what is wrong
with it, and describes itself as JSON Schema, so that checker and editors agree."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

from stator.diagnostics import Mark, Report
from stator.language.yaml_tree import Mapping, Scalar, Sequence, Tree
from stator.names import reserved_reason
from stator.quantities import with_symbols

NAME_PATTERN = "[a-z][a-z0-9_]{0,62}"
NAME_HINT = "use at most 63 lower case letters, digits and underscores; begin with a letter"
_NAME = re.compile(NAME_PATTERN)
_INTEGER = re.compile(r"[+-]?(0|[1-9][0-9]{0,18})")
GRAPH_NAME = "a graph name (the name of its file)"  # never a name in C++
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
        """The value of the tree; None after reporting what is wrong."""

    def schema(self) -> dict[str, Any]:
        """The shape as JSON Schema."""


def misshaped(tree: Tree, what: str, report: Report, hint: str = "") -> None:
    """Reports a value of another shape than `what`."""
    if isinstance(tree, Scalar) and tree.is_null:
        report.error(
            tree.mark,
            "wrong-shape",
            f"expected {what}, found null" if tree.text else f"expected {what}, found nothing",
            "null only removes a key that an include defines"
            if tree.text
            else hint or "write a value, or remove the key",
        )
        return
    kind = (
        "a mapping"
        if isinstance(tree, Mapping)
        else "a list"
        if isinstance(tree, Sequence)
        else quoted(tree.text)
    )
    report.error(
        tree.mark,
        "wrong-shape",
        f"expected {what}, found {kind}",
        hint or "write a single value; quote text that begins with a bracket",
    )


def scalar(tree: Tree, what: str, report: Report) -> Scalar | None:
    """The tree as a scalar that is not empty."""
    if isinstance(tree, Scalar) and not tree.is_null:
        if not (tree.text.startswith("${") and VARIABLE.fullmatch(tree.text)):
            return tree
        report.error(
            tree.mark,
            "variable-unknown",
            f"variable {tree.text[:60]} has no value",
            "include this file from another file, and give the value in `with`",
        )
        return None
    misshaped(tree, what, report)
    return None


@dataclass(frozen=True)
class Name:
    """A name that becomes a C++ name."""

    what: str = "a name"

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, _as_name(self.what), report)
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
            f"expected {_as_name(what)}, found {quoted(text)}",
            "write ${name} for a whole value; it cannot be a part of a value, or a key",
        )
    if not _NAME.fullmatch(text):
        return (
            "bad-name",
            f"expected {_as_name(what)}, found {quoted(text)}",
            NAME_HINT,
        )
    reason = "" if what == GRAPH_NAME else reserved_reason(text, what)
    if reason:
        plain = re.sub("_+", "_", text.strip("_"))
        plain = f"my_{plain}" if reserved_reason(plain, what) else plain
        return (
            "reserved-name",
            f"'{text}' cannot be {_as_name(what)}: {reason}",
            f"rename it, for example to '{plain}'",
        )
    return None


def _as_name(what: str) -> str:
    """`a node` -> `a node name`"""
    return what if "name" in what else f"{what} name"


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
                found.mark,
                self.rule,
                f"expected {self.what}, found {quoted(found.text)}",
                self.hint,
            )
            return None
        return Leaf(found.text, found.mark)

    def schema(self) -> dict[str, Any]:
        if self.pattern:
            return {"type": "string", "pattern": f"^({self.pattern})$"}
        return {"type": ["string", "number", "boolean"]}


@dataclass(frozen=True)
class UnitText(Text):
    """A unit as its symbol: values and hints compare it with others."""

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        leaf = Text.read(self, tree, report)
        if leaf is not None and (symbol := with_symbols(leaf.value)) != leaf.value:
            report.error(
                leaf.mark,
                "unit-unknown",
                f"expected the symbol of a unit, found {quoted(leaf.value)}",
                f"write {symbol}",
            )
            return None
        return leaf


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
                f"expected {what}, found {quoted(found.text)}",
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
                f"expected true or false, found {quoted(found.text)}",
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
                f"expected a whole number, found {quoted(found.text)}",
                f"write a number from {self.least} to {self.most}, without leading zeros",
            )
            return None
        value = int(found.text)
        if not self.least <= value <= self.most:
            report.error(
                found.mark,
                "out-of-range",
                f"expected a number from {self.least} to {self.most}, found {value}",
                f"write {self.least} or more"
                if value < self.least
                else f"write {self.most} or less",
            )
            return None
        return Leaf(value, found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.least, "maximum": self.most}


@dataclass(frozen=True)
class Raw:
    """A scalar whose type another file declares."""

    may_be_variable: bool = False  # ${name}, whose value an including file gives

    def read(self, tree: Tree, report: Report) -> Scalar | None:
        if self.may_be_variable and isinstance(tree, Scalar) and not tree.is_null:
            return tree
        return scalar(tree, "a single value", report)

    def schema(self) -> dict[str, Any]:
        return {"type": ["string", "number", "boolean"]}


@dataclass(frozen=True)
class RawOrNames:
    """A scalar whose type another file declares, or a list of names from there."""

    def read(self, tree: Tree, report: Report) -> Scalar | Sequence | None:
        if not isinstance(tree, Sequence):
            return Raw().read(tree, report)
        names = [scalar(item, "a name", report) for item in tree.items]
        return None if None in names else tree

    def schema(self) -> dict[str, Any]:
        return {"anyOf": [Raw().schema(), {"type": "array", "items": {"type": "string"}}]}
