"""Times in a graph: a time with a unit, or a rate, which stands for its period."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from stator.language.shapes import Leaf, quoted, scalar
from stator.quantities import UNITS, meant, shown, split

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.language.yaml_tree import Tree


@dataclass(frozen=True)
class Period:
    """A time in whole microseconds, written as a time or as a rate."""

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
        return 0, (
            "wrong-type",
            f"expected a time with its unit, found {quoted(text)}",
            "write a number and a unit, for example 250 us or 1 kHz",
        )
    number, unit = parts
    if unit == "":
        return 0, (
            "unit-missing",
            f"expected a time with its unit, found {quoted(text)}",
            f"add the unit, for example {text} us, {text} ms or {text} Hz",
        )
    if unit not in UNITS:
        same = meant(unit, UNITS)
        return 0, (
            "unit-unknown",
            f"unknown unit of time {quoted(unit)}",
            f"write {same}" if same else f"use {', '.join(UNITS)}",
        )
    dimension, factor = UNITS[unit]
    exact = number * factor
    if dimension == "frequency":
        if exact <= 0:
            return 0, (
                "out-of-range",
                f"expected a rate above 0 Hz, found {quoted(text)}",
                "write a rate above 0 Hz",
            )
        exact = 1_000_000 / exact
    too_short = exact < 0 or (exact.denominator == 1 and exact < least_us)
    if too_short or exact > most_us:
        return 0, (
            "out-of-range",
            f"expected a time from {spelled_us(least_us)} to {spelled_us(most_us)}, "
            f"found {quoted(text)}",
            f"write {spelled_us(least_us)} or more"
            if too_short
            else f"write {spelled_us(most_us)} or less",
        )
    if exact.denominator != 1:
        return 0, (
            "period-not-whole",
            f"expected a whole number of microseconds, found {quoted(text)}"
            + ("" if unit == "us" else f", which is {shown(exact)} us"),
            "write " + " or ".join(_neighbours(exact, dimension)),
        )
    return int(exact), None


def _neighbours(exact: Fraction, dimension: str) -> list[str]:
    """The nearest whole microseconds below and above; for a rate, also as rates."""
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
