"""Numbers with units, as exact fractions: `1 kHz`, `250 us`, `45 deg`."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

# unit -> (dimension, factor to the dimension's unit in the code)
UNITS: dict[str, tuple[str, Fraction]] = {
    "us": ("time", Fraction(1)),
    "ms": ("time", Fraction(1000)),
    "s": ("time", Fraction(1_000_000)),
    "min": ("time", Fraction(60_000_000)),
    "Hz": ("frequency", Fraction(1)),
    "kHz": ("frequency", Fraction(1000)),
    "MHz": ("frequency", Fraction(1_000_000)),
}

# The parameter's unit -> other units that a value may have, and the factor from each to the
# parameter's unit. The factor for degrees is pi / 180 to 40 digits, so that rounding the product
# gives the nearest float.
_DEGREE = Fraction("0.01745329251994329576923690768488612713442871888541725456")
CONVERSIONS: dict[str, dict[str, Fraction]] = {
    "rad": {"deg": _DEGREE},
    "rad/s": {"deg/s": _DEGREE},
    "rad/s^2": {"deg/s^2": _DEGREE},
    "m": {"km": Fraction(1000), "cm": Fraction(1, 100), "mm": Fraction(1, 1000)},
    "m/s": {"km/h": Fraction(10, 36), "cm/s": Fraction(1, 100)},
    "m/s^2": {"g": Fraction("9.80665")},
    "s": {"min": Fraction(60), "ms": Fraction(1, 1000), "us": Fraction(1, 1_000_000)},
    "ms": {"s": Fraction(1000), "us": Fraction(1, 1000)},
    "us": {"s": Fraction(1_000_000), "ms": Fraction(1000)},
    "Hz": {"kHz": Fraction(1000)},
    "kg": {"g": Fraction(1, 1000)},
    "V": {"mV": Fraction(1, 1000)},
    "A": {"mA": Fraction(1, 1000)},
    "Pa": {"hPa": Fraction(100), "kPa": Fraction(1000)},
    "C": {"Ah": Fraction(3600), "mAh": Fraction(36, 10)},
    "ohm": {"mohm": Fraction(1, 1000)},
    "kg m^2": {"g m^2": Fraction(1, 1000)},
    "m^2": {"cm^2": Fraction(1, 10_000)},
    "1": {"%": Fraction(1, 100)},
}

_NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]{1,3})?")
_MAX_LENGTH = 64
_NAMES = {
    **{"rad": "radian", "deg": "degree", "s": "second", "ms": "millisecond", "us": "microsecond"},
    **{"m": "metre", "km": "kilometre", "g": "gram", "kg": "kilogram", "N": "newton"},
    **{"V": "volt", "A": "ampere", "W": "watt", "Pa": "pascal", "J": "joule", "min": "minute"},
}
_SYMBOLS = {
    spelling: symbol
    for symbol, name in _NAMES.items()
    for one in (name, name.replace("metre", "meter"))
    for spelling in (one, f"{one}s")
} | {"sec": "s", "secs": "s", "amp": "A", "amps": "A", "hertz": "Hz", "percent": "%"}


def split(text: str) -> tuple[Fraction, str] | None:
    """`1.5 ms` -> (3/2, 'ms'); a bare number has the unit ''. None: not a number."""
    match = _NUMBER.match(text)
    if match is None or len(text) > _MAX_LENGTH:
        return None
    return Fraction(match.group(0)), text[match.end() :].strip()


def meant(unit: str, known: Iterable[str]) -> str:
    """The known unit that this is another spelling of, such as `µs`, `MS` or `m/s²`; else ''."""
    plain = _plain(unit)
    return next((name for name in known if _plain(name) == plain), "")


def _plain(unit: str) -> str:
    # NFKC makes one of the two micro signs, and 2 of a raised 2.
    text = unicodedata.normalize("NFKC", unit).casefold().replace("\u03bc", "u")
    text = text.replace("°", "deg").replace("^", "").replace(" ", "")
    return re.sub(r"sec(ond)?s?(?=$|/|[0-9])", "s", text)


def with_symbols(unit: str) -> str:
    """The unit with symbols in place of names: `metres/second` -> `m/s`."""
    return re.sub(r"[A-Za-z]+", lambda word: _SYMBOLS.get(word[0].lower(), word[0]), unit)


def shown(value: Fraction) -> str:
    """A number as a person writes it."""
    if abs(value) >= 10**15:
        return "more than 10^15" if value > 0 else "less than -10^15"
    if value.denominator == 1:
        return str(value.numerator)
    return f"{float(value):.6g}"
