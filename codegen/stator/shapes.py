"""The shapes that values in a file can have. Each shape reads a tree, reports what is wrong with it,
and describes itself as JSON Schema, so that checker and editors never disagree."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

from stator.diagnostics import Mark, Report
from stator.names import reserved_reason
from stator.quantities import UNITS, shown, split
from stator.yaml_tree import Mapping, Scalar, Sequence, Tree

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
        report.error(tree.mark, "wrong-shape", f"{what} is due here, and there is nothing",
                     "null removes only what an include brings" if tree.text else
                     hint or "remove the key, or write its value")
        return
    kind = "a mapping" if isinstance(tree, Mapping) else \
        "a list" if isinstance(tree, Sequence) else f"the single value {quoted(tree.text)}"
    report.error(tree.mark, "wrong-shape", f"{what} is due here, not {kind}",
                 hint or "write a single value; text that begins with a bracket stands in quotes")


def scalar(tree: Tree, what: str, report: Report) -> Scalar | None:
    """The tree as a scalar that is not empty."""
    if isinstance(tree, Scalar) and not tree.is_null:
        if not (tree.text.startswith("${") and VARIABLE.fullmatch(tree.text)):
            return tree
        report.error(tree.mark, "variable-unknown", f"{tree.text[:60]} has no value",
                     "include this file from another one, with `with`")
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
        return ("bad-name", f"{quoted(text)} cannot be {what}",
                "${name} stands for a whole value, never for a part of one or for a key")
    if not _NAME.fullmatch(text):
        return ("bad-name", f"{quoted(text)} cannot be {what}",
                "use lower case letters, digits and underscores, a letter first, 63 at most")
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
            report.error(found.mark, self.rule, f"{quoted(found.text)} is not {self.what}", self.hint)
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
            report.error(found.mark, "wrong-type", f"{quoted(found.text)} is not {what}",
                         report.nearest(found.text, self.words) if get_close_matches(
                             found.text, self.words) else f"write {what}")
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
            report.error(found.mark, "wrong-type", f"{quoted(found.text)} is not a whole number",
                         f"write one from {self.least} to {self.most}, without leading zeros")
            return None
        value = int(found.text)
        if not self.least <= value <= self.most:
            report.error(found.mark, "out-of-range",
                         f"{value} is not between {self.least} and {self.most}",
                         f"write {self.least if value < self.least else self.most}, "
                         "or a number in between")
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
        value, fault = _period(found.text, self.least_us, self.most_us)
        if fault is not None:
            report.error(found.mark, *fault)
            return None
        return Leaf(value, found.mark)

    def schema(self) -> dict[str, Any]:
        units = "|".join(UNITS)
        return {"type": "string", "pattern": rf"^[+-]?[0-9.]+([eE][+-]?[0-9]+)? *({units})$"}


@lru_cache(maxsize=10_000)
def _period(text: str, least_us: int, most_us: int) -> tuple[int, tuple[str, str, str] | None]:
    """Microseconds; or rule, message and hint."""
    parts = split(text)
    if parts is None:
        return 0, ("wrong-type", f"{quoted(text)} is not a time",
                   "write a number and a unit, for example 250 us or 1 kHz")
    number, unit = parts
    if unit == "":
        return 0, ("unit-missing", f"{quoted(text)} has no unit",
                   f"for example {text} us, {text} ms or {text} Hz")
    if unit not in UNITS:
        same = [known for known in UNITS if known.lower() == unit.lower()]
        return 0, ("unit-unknown", f"{quoted(unit)} is not a unit of time",
                   f"write {same[0]}" if same else f"use {', '.join(UNITS)}")
    dimension, factor = UNITS[unit]
    exact = number * factor
    if dimension == "frequency":
        if exact <= 0:
            return 0, ("out-of-range", f"{quoted(text)} has no period", "write a rate above 0 Hz")
        exact = 1_000_000 / exact
    too_short = exact < 0 or (exact.denominator == 1 and exact < least_us)
    if too_short or exact > most_us:
        return 0, ("out-of-range", f"{quoted(text)} is not between {spelled_us(least_us)} and "
                   f"{spelled_us(most_us)}", f"write {spelled_us(least_us)} or more" if too_short
                   else f"write {spelled_us(most_us)} or less")
    if exact.denominator != 1:
        return 0, ("period-not-whole", f"{quoted(text)} is {shown(exact)} us, not a whole number of "
                   "microseconds", "write " + " or ".join(_neighbours(exact, dimension)))
    return int(exact), None


def _neighbours(exact: Fraction, dimension: str) -> list[str]:
    """The next whole microseconds on both sides; of a rate also as rates."""
    found = [us for us in (int(exact), int(exact) + 1) if us]
    if dimension != "frequency":
        return [f"{us} us" for us in found]
    return [f"{us} us ({shown(Fraction(1_000_000, us))} Hz)" for us in found]


def spelled_us(value: int) -> str:
    """A time in the largest unit in which it is whole."""
    for unit, (dimension, factor) in reversed(UNITS.items()):
        if value and dimension == "time" and value % factor == 0:
            return f"{value // factor} {unit}"
    return f"{value} us"


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
    what: str = ""

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        if not isinstance(tree, Sequence):
            hint = f"write [{tree.text}]" if isinstance(tree, Scalar) and not tree.is_null else ""
            misshaped(tree, "a list", report, hint)
            return None
        if not self.least <= len(tree.items) <= self.most:
            due = f"{self.least} to {self.most}" if self.most < 1000 else f"at least {self.least}"
            due = str(self.least) if self.least == self.most else due
            report.error(tree.mark, "out-of-range",
                         f"the list has {len(tree.items)} of {due} items",
                         "add what is missing, or remove the key" if len(tree.items) < self.least
                         else "remove what is too much")
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
            misshaped(tree, "a mapping", report, f"write {self.what} and its value, as NAME: VALUE")
            return None
        values: dict[str, Any] = {}
        for key, item in tree.entries.items():
            if not self._key_fits(key, tree.keys[key], report):
                continue
            value = self.item.read(item, report)
            if value is not None:
                values[key] = value
        return Record(values, tree.mark, tree.keys, tree.owner)

    def _key_fits(self, key: str, mark: Mark, report: Report) -> bool:
        if not self.key_pattern:
            return check_name(key, mark, self.what, report)
        if re.fullmatch(self.key_pattern, key):
            return True
        report.error(mark, "bad-name", f"{quoted(key)} cannot be {self.what}",
                     "use lower case letters, digits and underscores, a letter first, 63 at most")
        return False

    def schema(self) -> dict[str, Any]:
        return {
            "type": "object",
            "patternProperties": {f"^{self.key_pattern or NAME_PATTERN}$": self.item.schema()},
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
    required: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        needed = tuple(name for name, key in self.keys.items() if key.required)
        object.__setattr__(self, "required", needed)

    def read(self, tree: Tree, report: Report) -> Record | None:
        if not isinstance(tree, Mapping):
            misshaped(tree, "a mapping", report, "its keys: " + ", ".join(self.keys))
            return None
        values: dict[str, Any] = {}
        for name, item in tree.entries.items():
            key = self.keys.get(name)
            if key is None:
                self._refuse(name, item, tree.keys[name], report)
                continue
            value = key.shape.read(item, report)
            if value is not None:
                values[name] = value
        for name in self.required:
            if name not in tree.entries and not self._is_misspelt(name, tree):
                report.error(tree.owner, "missing-key", f"key '{name}' is missing",
                             f"{name}: {self.keys[name].doc}")
        return Record(values, tree.mark, tree.keys, tree.owner)

    def _is_misspelt(self, name: str, tree: Mapping) -> bool:
        """Whether an unknown key, which has its own error, was meant to be this one."""
        return bool(get_close_matches(name, [key for key in tree.entries if key not in self.keys]))

    def _refuse(self, name: str, item: Tree, mark: Mark, report: Report) -> None:
        if name in self.reserved:
            report.error(mark, "reserved-key", f"key '{name}' is kept for later: "
                         f"{self.reserved[name]}", "remove it")
            return
        hint = report.nearest(name, self.keys)
        if isinstance(item, Scalar) and item.is_null and (" " in name or ":" in name):
            hint = "text with a comma in it stands in quotes; so does a value behind ':' without space"
        report.error(mark, "unknown-key", f"there is no key {quoted(name)} here", hint)

    def schema(self) -> dict[str, Any]:
        properties = {}
        for name, key in self.keys.items():
            properties[name] = {**key.shape.schema(), "description": key.doc}
        return {
            "type": "object",
            "properties": properties,
            "additionalProperties": False,
            **({"required": list(self.required)} if self.required else {}),
        }


@dataclass(frozen=True)
class Short:
    """A mapping, or a scalar that stands for the mapping with only the key `key`."""

    key: str
    full: Struct

    def read(self, tree: Tree, report: Report) -> Record | None:
        if isinstance(tree, Scalar):
            value = self.full.keys[self.key].shape.read(tree, report)
            return None if value is None else Record({self.key: value}, tree.mark, {}, tree.mark)
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
