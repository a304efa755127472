"""Reads a parameter's value from text, in the unit that its interface declares."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from stator.language.quantity import factor_of
from stator.language.shapes import misshaped, quoted
from stator.language.yaml_tree import Scalar, Sequence
from stator.quantities import shown, split

if TYPE_CHECKING:
    from stator.diagnostics import Mark, Report
    from stator.graph.model import Param, Value

# A little inside the range in which a float keeps all its digits.
_MIN_FLOAT, _MAX_FLOAT = Fraction(1, 10**37), Fraction(10**37)


def read_value(
    param: Param, item: Scalar | Sequence, report: Report, *, in_file: bool = False
) -> Value | None:
    """The value in the parameter's own unit. In the interface itself (`in_file`) numbers have no
    unit, because the key `unit` gives it."""
    if isinstance(item, Sequence):
        return _flags(param, item, report)
    named = dict(param.values)
    if item.text in named:
        return named[item.text]
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
            f"expected {_expected(param)} for '{param.name}', found {quoted(item.text)}",
            _how_to_write(param),
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


def as_written(param: Param, text: str, mark: Mark) -> Scalar | Sequence:
    """A value from a command line: of flags, names with commas or a number."""
    if not param.flags or split(text) is not None:
        return Scalar(text, mark)
    names = text.removeprefix("[").removesuffix("]").split(",")
    return Sequence([Scalar(name.strip(), mark) for name in names if name.strip()], mark)


def _expected(param: Param) -> str:
    if param.flags:
        return "a list of flags"
    return "a name or a number" if param.values else "a number"


def _how_to_write(param: Param) -> str:
    if param.flags:
        return f"write a list, such as [{', '.join(param.flags[:2])}]"
    if param.values:
        return f"write {' or '.join(name for name, _ in param.values)}"
    return f"write a number{'' if param.unit == '1' else f' and its unit, {param.unit}'}"


def _flags(param: Param, names: Sequence, report: Report) -> int | None:
    """The sum of the named bits."""
    if not param.flags:
        misshaped(names, f"a single value for '{param.name}'", report)
        return None
    value = 0
    for item in names.items:
        assert isinstance(item, Scalar)  # as RawOrNames has read it
        if item.text not in param.flags:
            report.error(
                item.mark,
                "param-flag",
                f"unknown flag {quoted(item.text)} of '{param.name}'",
                report.nearest(item.text, param.flags) or f"use {', '.join(param.flags)}",
            )
            return None
        value |= 1 << param.flags.index(item.text)
    return value


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
