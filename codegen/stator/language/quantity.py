"""A number with its unit, within a range: `1.535 kg`, `0.13 m`."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from stator.language.shapes import Leaf, quoted, scalar
from stator.quantities import CONVERSIONS, meant, shown, split

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.language.yaml_tree import Scalar, Tree


@dataclass(frozen=True)
class Quantity:
    """The value is a float in `unit`; "1" for a number without a unit."""

    unit: str
    least: float = -1e9
    most: float = 1e9
    is_above: bool = False  # the least value itself is too little

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, self._what, report)
        if found is None:
            return None
        parts = split(found.text)
        if parts is None:
            report.error(
                found.mark,
                "wrong-type",
                f"expected {self._what}, found {quoted(found.text)}",
                f"write a number{'' if self.unit == '1' else f' and its unit, {self.unit}'}",
            )
            return None
        number, unit = parts
        factor = factor_of(unit, self.unit, found, report)
        if factor is None:
            return None
        value = float(number * factor)
        if self.least <= value <= self.most and not (self.is_above and value == self.least):
            return Leaf(value, found.mark)
        self._refuse(value, found, report)
        return None

    @property
    def _what(self) -> str:
        return "a number" if self.unit == "1" else f"a value in {self.unit}"

    def _refuse(self, value: float, found: Scalar, report: Report) -> None:
        unit = "" if self.unit == "1" else f" {self.unit}"
        low, high = shown(Fraction(self.least)), shown(Fraction(self.most))
        is_low = value <= self.least
        bound = f"above {low}" if self.is_above else f"{low} or more"
        report.error(
            found.mark,
            "out-of-range",
            f"expected a value {bound}{unit}, found {quoted(found.text)}"
            if is_low
            else f"expected a value of {high}{unit} or less, found {quoted(found.text)}",
            f"write a value {bound}{unit}" if is_low else f"write {high}{unit} or less",
        )

    def schema(self) -> dict[str, Any]:
        if self.unit == "1":
            return {"type": "number"}
        units = "|".join(
            u.replace("^", r"\^") for u in (self.unit, *CONVERSIONS.get(self.unit, {}))
        )
        return {"type": "string", "pattern": rf"^[+-]?[0-9.]+([eE][+-]?[0-9]+)? *({units})$"}


def factor_of(
    unit: str, due: str, found: Scalar, report: Report, whom: str = ""
) -> Fraction | None:
    """From the unit that was written to the one that is due; None after reporting that there is
    none. `whom`: what the value is for, in messages."""
    if unit == due or (unit == "" and due == "1"):
        return Fraction(1)
    known = CONVERSIONS.get(due, {})
    if unit in known:
        return known[unit]
    choices = [u for u in (due, *known) if u != "1"]
    if unit == "":
        report.error(
            found.mark,
            "unit-missing",
            f"expected a number with its unit{whom}, found {quoted(found.text)}",
            "write " + " or ".join(f"{found.text} {u}" for u in choices),
        )
    elif due == "1":
        bare = found.text[: len(found.text) - len(unit)].strip()
        report.error(
            found.mark,
            "unit-unknown",
            f"expected a number without a unit{whom}, found {quoted(found.text)}",
            f"write {bare} or {bare} %",
        )
    else:
        same = meant(unit, choices)
        report.error(
            found.mark,
            "unit-unknown",
            f"expected a value in {due}{whom}, found {quoted(found.text)}",
            f"write {same}" if same else "use " + " or ".join(choices),
        )
    return None
