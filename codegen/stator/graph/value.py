"""Reads a parameter's value from text, in the unit that its interface declares."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from stator.language.quantity import factor_of
from stator.language.shapes import quoted
from stator.quantities import shown, split

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.graph.model import Param, Value
    from stator.language.yaml_tree import Scalar

# A little inside the range in which a float keeps all its digits.
_MIN_FLOAT, _MAX_FLOAT = Fraction(1, 10**37), Fraction(10**37)


def read_value(
    param: Param, item: Scalar, report: Report, *, in_file: bool = False
) -> Value | None:
    """The value in the parameter's own unit. In the interface itself (`in_file`) numbers have no
    unit, because the key `unit` gives it."""
    if param.type == "bool":
        if item.text in ("true", "false"):
            return item.text == "true"
        report.error(
            item.mark,
            "wrong-type",
            f"expected true or false for '{param.name}', found {quoted(item.text)}",
            "write true or false",
        )
        return None
    parts = split(item.text)
    if parts is None:
        report.error(
            item.mark,
            "wrong-type",
            f"expected a number for '{param.name}', found {quoted(item.text)}",
            f"write a number{'' if param.unit == '1' else f' and its unit, {param.unit}'}",
        )
        return None
    number, unit = parts
    factor = (
        _bare(param, unit, item, report)
        if in_file
        else factor_of(unit, param.unit, item, report, f" for '{param.name}'")
    )
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
            f"expected a whole number of 32 bits for '{param.name}', found {quoted(item.text)}",
            f"write a number from {shown(param.least or Fraction(-(2**31) + 1))} "
            f"to {shown(param.most or Fraction(2**31 - 1))}",
        )
        return False
    if number == 0 or _MIN_FLOAT <= abs(number) <= _MAX_FLOAT:
        return True
    report.error(
        item.mark,
        "out-of-range",
        f"expected a magnitude from 1e-37 to 1e37, or 0, found {quoted(item.text)}",
        f"write a {'smaller' if abs(number) > 1 else 'larger'} number: a float cannot hold it",
    )
    return False


def _is_in_range(param: Param, number: Fraction, item: Scalar, report: Report) -> bool:
    least, most = param.least, param.most
    if (least is None or number >= least) and (most is None or number <= most):
        return True
    unit = "" if param.unit == "1" else f" {param.unit}"
    written = "" if item.text == shown(number) + unit else f", which is {shown(number)}{unit}"
    low, high = (shown(bound or Fraction(0)) for bound in (least, most))
    is_low = least is not None and number < least
    report.error(
        item.mark,
        "param-range",
        f"expected a value from {low} to {high}{unit} for '{param.name}', "
        f"found {quoted(item.text)}{written}",
        f"write {low}{unit} or more" if is_low else f"write {high}{unit} or less",
    )
    return False


def _bare(param: Param, unit: str, item: Scalar, report: Report) -> Fraction | None:
    if not unit:
        return Fraction(1)
    report.error(
        item.mark,
        "unit-unknown",
        f"expected a number without a unit, found {quoted(item.text)}",
        f"remove the unit: the key `unit` gives it ({param.unit})",
    )
    return None
