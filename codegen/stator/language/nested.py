"""Shapes that hold other shapes: lists, tables of names that users choose, and known keys."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

from stator.language.shapes import (
    NAME_HINT,
    NAME_PATTERN,
    Leaf,
    Record,
    Shape,
    check_name,
    misshaped,
    quoted,
)
from stator.language.yaml_tree import Mapping, Scalar, Sequence, Tree

if TYPE_CHECKING:
    from stator.diagnostics import Mark, Report


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
            report.error(
                tree.mark,
                "out-of-range",
                f"expected a list of {due} {'item' if due.endswith(' 1') else 'items'}, "
                f"found {len(tree.items)}",
                "add items, or remove the key"
                if len(tree.items) < self.least
                else f"remove {len(tree.items) - self.most} of them",
            )
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
            misshaped(tree, "a mapping", report, f"write {self.what} and its value as NAME: VALUE")
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
        report.error(
            mark,
            "bad-name",
            f"expected {self.what}, found {quoted(key)}",
            NAME_HINT,
        )
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

    @property
    def purpose(self) -> str:
        """The first sentence of `doc`, as the end of another sentence."""
        first = self.doc.split(". ")[0].rstrip(".")
        return first[:1].lower() + first[1:]


@dataclass(frozen=True)
class Struct:
    """A mapping whose keys the language defines."""

    keys: dict[str, Key]
    required: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        needed = tuple(name for name, key in self.keys.items() if key.required)
        object.__setattr__(self, "required", needed)

    def read(self, tree: Tree, report: Report) -> Record | None:
        if not isinstance(tree, Mapping):
            misshaped(tree, "a mapping", report, "known keys: " + ", ".join(self.keys))
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
                report.error(
                    tree.owner,
                    "missing-key",
                    f"missing key '{name}'",
                    f"add `{name}`: {self.keys[name].purpose}",
                )
        return Record(values, tree.mark, tree.keys, tree.owner)

    def _is_misspelt(self, name: str, tree: Mapping) -> bool:
        """Whether an unknown key, which has its own error, was meant to be this one."""
        return bool(get_close_matches(name, [key for key in tree.entries if key not in self.keys]))

    def _refuse(self, name: str, item: Tree, mark: Mark, report: Report) -> None:
        hint = report.nearest(name, self.keys)
        if isinstance(item, Scalar) and item.is_null and (" " in name or ":" in name):
            hint = "quote text that contains a comma, and write a space after ':'"
        report.error(mark, "unknown-key", f"unknown key {quoted(name)}", hint)

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
