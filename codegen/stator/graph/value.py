"""Reads a parameter's value from text, in the unit that its interface declares."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from stator.language.shapes import quoted
from stator.quantities import CONVERSIONS, shown, split

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.graph.model import Param, Value
    from stator.language.yaml_tree import Scalar

# Of the magnitudes that a float holds with all its digits, a little less.
_MIN_FLOAT, _MAX_FLOAT = Fraction(1, 10**37), Fraction(10**37)


def read_value(
    param: Param, item: Scalar, report: Report, *, in_file: bool = False
) -> Value | None:
    """The value in the parameter's own unit. In the interface itself (`in_file`) numbers are bare,
    as the unit stands beside them."""
    if param.type == "bool":
        if item.text in ("true", "false"):
            return item.text == "true"
        report.error(
            item.mark,
            "wrong-type",
            f"'{param.name}' is true or false, not {quoted(item.text)}",
            "write true or false",
        )
        return None
    parts = split(item.text)
    if parts is None:
        report.error(
            item.mark,
            "wrong-type",
            f"'{param.name}' is a number, not {quoted(item.text)}",
            f"write a number{'' if param.unit == '1' else f' and its unit, {param.unit}'}",
        )
        return None
    number, unit = parts
    factor = _bare(param, unit, item, report) if in_file else _factor(param, unit, item, report)
    if factor is None:
        return None
    number *= factor
    if not _fits_type(param, number, item, report) or not _is_in_range(param, number, item, report):
        return None
    return int(number) if param.type == "int32" else number


def _fits_type(param: Param, number: Fraction, item: Scalar, report: Report) -> bool:
    if param.type == "int32":
        if number.denominator == 1 and abs(number) < 2**31:
            return True
        report.error(
            item.mark,
            "wrong-type",
            f"'{param.name}' is a whole number of 32 bits, not {quoted(item.text)}",
            f"write one from {shown(param.least or Fraction(-(2**31) + 1))} "
            f"to {shown(param.most or Fraction(2**31 - 1))}",
        )
        return False
    if number == 0 or _MIN_FLOAT <= abs(number) <= _MAX_FLOAT:
        return True
    report.error(
        item.mark,
        "out-of-range",
        f"{quoted(item.text)} is too {'large' if abs(number) > 1 else 'small'} for a float",
        "its magnitude lies between 1e-37 and 1e37, or is 0",
    )
    return False


def _is_in_range(param: Param, number: Fraction, item: Scalar, report: Report) -> bool:
    least, most = param.least, param.most
    if (least is None or number >= least) and (most is None or number <= most):
        return True
    unit = "" if param.unit == "1" else f" {param.unit}"
    written = "" if item.text == shown(number) + unit else f", which is {shown(number)}{unit},"
    report.error(
        item.mark,
        "param-range",
        f"{quoted(item.text)}{written} is outside the range of '{param.name}'",
        f"write a value from {shown(least or Fraction(0))} to {shown(most or Fraction(0))}{unit}",
    )
    return False


def _bare(param: Param, unit: str, item: Scalar, report: Report) -> Fraction | None:
    if not unit:
        return Fraction(1)
    report.error(
        item.mark,
        "unit-unknown",
        "numbers in an interface are bare",
        f"remove the unit here; the key `unit` says {param.unit}",
    )
    return None


def _factor(param: Param, unit: str, item: Scalar, report: Report) -> Fraction | None:
    if unit == param.unit or (unit == "" and param.unit == "1"):
        return Fraction(1)
    known = CONVERSIONS.get(param.unit, {})
    if unit in known:
        return known[unit]
    choices = [u for u in (param.unit, *known) if u != "1"]
    if unit == "":
        report.error(
            item.mark,
            "unit-missing",
            f"'{param.name}' needs a unit",
            "write " + " or ".join(f"{item.text} {u}" for u in choices),
        )
    elif param.unit == "1":
        bare = item.text[: len(item.text) - len(unit)].strip()
        report.error(
            item.mark,
            "unit-unknown",
            f"'{param.name}' has no unit, and {quoted(unit)} is one",
            f"write {bare} or {bare} %",
        )
    else:
        report.error(
            item.mark,
            "unit-unknown",
            f"'{param.name}' is in {param.unit}, not in {quoted(unit)}",
            "use " + " or ".join(choices),
        )
    return None
