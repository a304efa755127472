"""The shapes that values in a file can have. Each shape reads a tree, reports what is wrong with it,
and describes itself as JSON Schema, so that checker and editors never disagree."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Protocol

from stator.diagnostics import Mark, Report, nearest
from stator.names import reserved_reason
from stator.quantities import UNITS, shown, split
from stator.yaml_tree import Mapping, Scalar, Sequence, Tree

NAME_PATTERN = "^[a-z][a-z0-9_]{0,62}$"
_NAME = re.compile(NAME_PATTERN)
_INTEGER = re.compile(r"[+-]?\d{1,20}")


@dataclass(frozen=True)
class Leaf:
    """A value that was read, and where it stood."""

    value: Any
    mark: Mark


@dataclass(frozen=True)
class Record:
    """A mapping that was read: what its keys hold, and where the keys stood."""

    values: dict[str, Any]
    mark: Mark
    keys: dict[str, Mark]

    def get(self, key: str) -> Any:
        """What the key holds; None if it is absent or was wrong."""
        return self.values.get(key)

    def value(self, key: str, default: Any = None) -> Any:
        """The bare value of a leaf."""
        leaf = self.values.get(key)
        return default if leaf is None else leaf.value


class Shape(Protocol):
    def read(self, tree: Tree, report: Report) -> Any:
        """The value of the tree, or None after reporting why there is none."""

    def schema(self) -> dict[str, Any]:
        """The shape as JSON Schema."""


def kind(tree: Tree) -> str:
    if isinstance(tree, Mapping):
        return "a mapping"
    return "a list" if isinstance(tree, Sequence) else "a single value"


def scalar(tree: Tree, what: str, report: Report) -> Scalar | None:
    """The tree as a scalar that is not empty."""
    if not isinstance(tree, Scalar):
        report.error(tree.mark, "wrong-shape", f"{what} is due here, not {kind(tree)}")
        return None
    if tree.is_null:
        report.error(tree.mark, "wrong-type", f"{what} is due here, and there is nothing")
        return None
    return tree


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
        return {"type": "string", "pattern": NAME_PATTERN}


def check_name(text: str, mark: Mark, what: str, report: Report) -> bool:
    if not _NAME.match(text):
        report.error(
            mark,
            "bad-name",
            f"{quoted(text)} cannot be {what}",
            "use lower case letters, digits and underscores, a letter first, 63 at most",
        )
        return False
    reason = reserved_reason(text)
    if reason:
        report.error(mark, "reserved-name", f"'{text}' cannot be {what}: {reason}",
                     f"for example '{text.strip('_')}0'")
        return False
    return True


def quoted(text: str) -> str:
    shown_text = "".join(c if c.isprintable() else "?" for c in text[:60])
    return f"'{shown_text}'" + ("..." if len(text) > 60 else "")


@dataclass(frozen=True)
class Text:
    """Any text of one line or more."""

    pattern: str = ""
    what: str = "text"
    rule: str = "wrong-type"

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, self.what, report)
        if found is None:
            return None
        if self.pattern and not re.fullmatch(self.pattern, found.text):
            report.error(found.mark, self.rule, f"{quoted(found.text)} is not {self.what}")
            return None
        return Leaf(found.text, found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": "string", **({"pattern": f"^{self.pattern}$"} if self.pattern else {})}


@dataclass(frozen=True)
class Choice:
    """One of a few words."""

    words: tuple[str, ...]

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        what = "one of " + ", ".join(self.words)
        found = scalar(tree, what, report)
        if found is None:
            return None
        if found.text not in self.words:
            report.error(found.mark, "wrong-type", f"{quoted(found.text)} is not {what}",
                         nearest(found.text, self.words))
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
            report.error(found.mark, "wrong-type", f"{quoted(found.text)} is not true or false",
                         "write true or false")
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
            report.error(found.mark, "wrong-type", f"{quoted(found.text)} is not a whole number")
            return None
        value = int(found.text)
        if not self.least <= value <= self.most:
            report.error(found.mark, "out-of-range",
                         f"{value} is not between {self.least} and {self.most}")
            return None
        return Leaf(value, found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.least, "maximum": self.most}


@dataclass(frozen=True)
class Period:
    """A time, also written as the rate whose period it is; whole microseconds."""

    least_us: int = 1
    most_us: int = 3_600_000_000

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, "a time with its unit", report)
        if found is None:
            return None
        value = period_us(found, report)
        if value is None:
            return None
        if not self.least_us <= value <= self.most_us:
            report.error(found.mark, "out-of-range", f"{quoted(found.text)} is {value} us, not "
                         f"between {self.least_us} us and {self.most_us} us")
            return None
        return Leaf(value, found.mark)

    def schema(self) -> dict[str, Any]:
        units = "|".join(UNITS)
        return {"type": "string", "pattern": rf"^[0-9.eE+-]+ *({units})$"}


def period_us(found: Scalar, report: Report) -> int | None:
    parts = split(found.text)
    if parts is None:
        report.error(found.mark, "wrong-type", f"{quoted(found.text)} is not a time",
                     "write a number and a unit, for example 250 us or 1 kHz")
        return None
    number, unit = parts
    if unit == "":
        text = shown(number)
        report.error(found.mark, "unit-missing", f"{quoted(found.text)} has no unit",
                     f"for example {text} us, {text} ms or {text} Hz")
        return None
    if unit not in UNITS:
        report.error(found.mark, "unit-unknown", f"{quoted(unit)} is not a unit of time",
                     "use us, ms, s, min, Hz, kHz or MHz")
        return None
    dimension, factor = UNITS[unit]
    exact = number * factor
    if dimension == "frequency":
        if exact <= 0:
            report.error(found.mark, "out-of-range", f"{quoted(found.text)} has no period")
            return None
        exact = 1_000_000 / exact
    if exact.denominator != 1:
        below = int(exact)
        hints = [f"{us} us ({shown(Fraction(1_000_000, us))} Hz)" for us in (below, below + 1) if us]
        report.error(found.mark, "period-not-whole",
                     f"{quoted(found.text)} is {shown(exact)} us, not a whole number of microseconds",
                     "write " + " or ".join(hints))
        return None
    return int(exact)


@dataclass(frozen=True)
class Raw:
    """A scalar whose type another file declares."""

    def read(self, tree: Tree, report: Report) -> Scalar | None:
        return scalar(tree, "a single value", report)

    def schema(self) -> dict[str, Any]:
        return {"type": ["string", "number", "boolean"]}


@dataclass(frozen=True)
class Anything:
    """A tree that is read elsewhere."""

    def read(self, tree: Tree, report: Report) -> Tree:  # noqa: ARG002
        return tree

    def schema(self) -> dict[str, Any]:
        return {}


@dataclass(frozen=True)
class Listing:
    item: Shape
    least: int = 0
    most: int = 100_000

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        if not isinstance(tree, Sequence):
            report.error(tree.mark, "wrong-shape", f"a list is due here, not {kind(tree)}")
            return None
        if not self.least <= len(tree.items) <= self.most:
            report.error(tree.mark, "out-of-range",
                         f"{len(tree.items)} items, not {self.least} to {self.most}")
            return None
        items = [self.item.read(item, report) for item in tree.items]
        return Leaf([item for item in items if item is not None], tree.mark)

    def schema(self) -> dict[str, Any]:
        bounds = {"minItems": self.least} if self.least else {}
        return {"type": "array", "items": self.item.schema(), **bounds}


@dataclass(frozen=True)
class Table:
    """A mapping whose keys are names that the user chose."""

    item: Shape
    what: str = "a name"
    key_pattern: str = ""  # instead of a name

    def read(self, tree: Tree, report: Report) -> Record | None:
        if not isinstance(tree, Mapping):
            report.error(tree.mark, "wrong-shape", f"a mapping is due here, not {kind(tree)}")
            return None
        values: dict[str, Any] = {}
        for key, item in tree.entries.items():
            if not self._key_fits(key, tree.keys[key], report):
                continue
            value = self.item.read(item, report)
            if value is not None:
                values[key] = value
        return Record(values, tree.mark, tree.keys)

    def _key_fits(self, key: str, mark: Mark, report: Report) -> bool:
        if not self.key_pattern:
            return check_name(key, mark, self.what, report)
        if re.fullmatch(self.key_pattern, key):
            return True
        report.error(mark, "bad-name", f"{quoted(key)} cannot be {self.what}")
        return False

    def schema(self) -> dict[str, Any]:
        pattern = f"^{self.key_pattern}$" if self.key_pattern else NAME_PATTERN
        return {
            "type": "object",
            "patternProperties": {pattern: self.item.schema()},
            "additionalProperties": False,
        }


@dataclass(frozen=True)
class Key:
    shape: Shape
    doc: str
    required: bool = False


@dataclass(frozen=True)
class Struct:
    """A mapping whose keys the language defines."""

    keys: dict[str, Key]
    reserved: dict[str, str] = field(default_factory=dict)

    def read(self, tree: Tree, report: Report) -> Record | None:
        if not isinstance(tree, Mapping):
            report.error(tree.mark, "wrong-shape", f"a mapping is due here, not {kind(tree)}",
                         "its keys: " + ", ".join(self.keys))
            return None
        values: dict[str, Any] = {}
        for name, item in tree.entries.items():
            mark = tree.keys[name]
            if name in self.reserved:
                report.error(mark, "reserved-key", f"key '{name}' is kept for later: "
                             f"{self.reserved[name]}", "remove it")
            elif name not in self.keys:
                hint = nearest(name, self.keys)
                if " " in name and isinstance(item, Scalar) and item.is_null:
                    hint = "text with a comma stands in quotes"
                report.error(mark, "unknown-key", f"there is no key {quoted(name)} here", hint)
            else:
                value = self.keys[name].shape.read(item, report)
                if value is not None:
                    values[name] = value
        for name, key in self.keys.items():
            if key.required and name not in tree.entries:
                report.error(tree.mark, "missing-key", f"key '{name}' is missing", key.doc)
        return Record(values, tree.mark, tree.keys)

    def schema(self) -> dict[str, Any]:
        properties = {}
        for name, key in self.keys.items():
            properties[name] = {**key.shape.schema(), "description": key.doc}
        required = [name for name, key in self.keys.items() if key.required]
        return {
            "type": "object",
            "properties": properties,
            "additionalProperties": False,
            **({"required": required} if required else {}),
        }


@dataclass(frozen=True)
class Short:
    """A mapping, or a scalar that stands for the mapping with only the key `key`."""

    key: str
    full: Struct

    def read(self, tree: Tree, report: Report) -> Record | None:
        if isinstance(tree, Scalar):
            value = self.full.keys[self.key].shape.read(tree, report)
            return None if value is None else Record({self.key: value}, tree.mark, {})
        return self.full.read(tree, report)

    def schema(self) -> dict[str, Any]:
        return {"anyOf": [self.full.keys[self.key].shape.schema(), self.full.schema()]}


@dataclass(frozen=True)
class OneOrMore:
    """A list, or its only item without the list."""

    item: Shape

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        if isinstance(tree, Sequence):
            return Listing(self.item, least=1).read(tree, report)
        value = self.item.read(tree, report)
        return None if value is None else Leaf([value], tree.mark)

    def schema(self) -> dict[str, Any]:
        return {"anyOf": [self.item.schema(), Listing(self.item, least=1).schema()]}
