"""How a value is drawn: `4 m/s`, `{uniform: [2 m/s, 12 m/s]}`, `{each: [4 m/s, 8 m/s]}`."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, Protocol

from stator.language.nested import Key, Listing, OneOrMore, Struct
from stator.language.quantity import Quantity
from stator.language.shapes import Choice, Leaf, Shape, Text
from stator.language.yaml_tree import Mapping

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.language.yaml_tree import Tree

DIGITS = 6  # so many are in the command that repeats a flight
WAYS = ("uniform", "log_uniform", "normal", "choice", "each")


@dataclass(frozen=True)
class Distribution:
    """`values`: the bounds, the mean and the standard deviation, or what is chosen from."""

    kind: str
    values: tuple[Any, ...]
    least: float | None = None
    most: float | None = None

    @property
    def ends(self) -> tuple[Any, ...]:
        """The values at which a range is checked."""
        if self.kind != "normal":
            return self.values
        return (self.values[0],)

    @property
    def varies(self) -> bool:
        return len(set(self.values)) > 1

    def within(self, least: float | None, most: float | None) -> Distribution:
        return replace(self, least=least, most=most)

    def draw(self, key: str, seed: int, row: int) -> Any:
        """A function of its arguments: no flight depends on another one."""
        if self.kind == "each":
            return self.values[row % len(self.values)]
        source = random.Random(f"campaign {seed}, flight {row}: {key}")
        if self.kind == "choice":
            return self.values[source.randrange(len(self.values))]
        low, high = self.values
        share = source.random()
        if self.kind == "uniform":
            value = low + (high - low) * share
        elif self.kind == "log_uniform":
            value = math.exp(math.log(low) + (math.log(high) - math.log(low)) * share)
        else:
            value = _normal(low, high, share, self.least, self.most)
        return float(f"{value:.{DIGITS}g}")


def _normal(
    mean: float, deviation: float, share: float, least: float | None, most: float | None
) -> float:
    """Of the normal distribution, only what lies within the range."""
    if deviation == 0.0:
        return mean
    normal = NormalDist(mean, deviation)
    low = 0.0 if least is None else normal.cdf(least)
    high = 1.0 if most is None else normal.cdf(most)
    part = min(max(low + (high - low) * share, 1e-12), 1.0 - 1e-12)
    value = normal.inv_cdf(part)
    value = value if least is None else max(value, least)
    return value if most is None else min(value, most)


class Number(Shape, Protocol):
    @property
    def unit(self) -> str: ...


@dataclass(frozen=True)
class Drawn:
    """A number, or how it is drawn."""

    item: Number

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        if not isinstance(tree, Mapping):
            leaf = self.item.read(tree, report)
            return None if leaf is None else Leaf(Distribution("each", (leaf.value,)), leaf.mark)
        record = self._struct().read(tree, report)
        if record is None or len(record.values) != len(tree.entries):
            return None  # reported
        if len(record.values) != 1:
            _expect_one(tree, report)
            return None
        kind, found = next(iter(record.values.items()))
        if kind == "normal":
            mean, deviation = found.get("mean"), found.get("deviation")
            if mean is None or deviation is None:
                return None
            least, most = getattr(self.item, "least", None), getattr(self.item, "most", None)
            values = (mean.value, deviation.value)
            return Leaf(Distribution(kind, values, least, most), tree.mark)
        values = tuple(leaf.value for leaf in found.value)
        if kind in ("uniform", "log_uniform") and not self._is_range(kind, values, found, report):
            return None
        return Leaf(Distribution(kind, values), tree.mark)

    def _is_range(self, kind: str, values: Any, found: Leaf, report: Report) -> bool:
        if len(values) != 2:
            return False  # a bound was wrong, and is reported
        low, high = values
        if any(isinstance(value, bool) or not isinstance(value, int | float) for value in values):
            report.error(
                found.mark, "wrong-type", f"expected two numbers for {kind}", "use `choice`"
            )
            return False
        if low >= high or (kind == "log_uniform" and low <= 0):
            above = " above 0" if kind == "log_uniform" else ""
            report.error(
                found.mark,
                "out-of-range",
                f"expected a lower and a higher bound{above}, found {low:g} and {high:g}",
                "write the lower one first",
            )
            return False
        return True

    def _struct(self) -> Struct:
        pair = Listing(self.item, least=2, most=2)
        normal = Struct(
            {
                "mean": Key(self.item, "The mean.", required=True),
                "deviation": Key(
                    Quantity(self.item.unit, 0.0), "The standard deviation.", required=True
                ),
            }
        )
        many = Listing(self.item, least=1)
        return Struct(
            {
                "uniform": Key(pair, "Equally likely between two bounds."),
                "log_uniform": Key(pair, "The same, of the logarithm."),
                "normal": Key(normal, "Normal, within the range of the key."),
                "choice": Key(many, "One of these at random."),
                "each": Key(many, "These in turn, flight by flight."),
            }
        )

    def schema(self) -> dict[str, Any]:
        return {"anyOf": [self.item.schema(), self._struct().schema()]}


@dataclass(frozen=True)
class Words:
    """A word, or one of several; `known`: the only ones."""

    known: tuple[str, ...] = ()

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        item: Shape = Choice(self.known) if self.known else Text()
        many = OneOrMore(item)
        if not isinstance(tree, Mapping):
            leaf = item.read(tree, report)
            return None if leaf is None else Leaf(Distribution("each", (leaf.value,)), leaf.mark)
        record = Struct(
            {"choice": Key(many, "One of these at random."), "each": Key(many, "These in turn.")}
        ).read(tree, report)
        if record is None or len(record.values) != len(tree.entries):
            return None
        if len(record.values) != 1:
            _expect_one(tree, report)
            return None
        kind, found = next(iter(record.values.items()))
        return Leaf(Distribution(kind, tuple(leaf.value for leaf in found.value)), tree.mark)

    def schema(self) -> dict[str, Any]:
        return {}


def _expect_one(tree: Mapping, report: Report) -> None:
    report.error(
        tree.mark,
        "wrong-shape",
        f"expected one way to draw, found {len(tree.entries)}",
        f"write one of {', '.join(WAYS)}",
    )
