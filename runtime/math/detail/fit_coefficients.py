"""Fit the polynomials of Stator's maths and write coefficients.hpp.

Run it in Stator's Python environment, which has mpmath:
    python fit_coefficients.py | clang-format > coefficients.hpp
Each polynomial is a weighted least-squares fit on Chebyshev points, which is close to the best one.
Coefficients are rounded one by one, lowest power first, and the rest is fitted again each time, so
that later ones make up for the rounding of earlier ones.
"""

import math
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass

from mpmath import mp, mpf

mp.prec = 400

Function = Callable[[mpf], mpf]


@dataclass(frozen=True)
class Format:
    """A C++ floating-point type, and the digits of constants that multiply exactly."""

    name: str
    digits: int
    suffix: str
    ln2_high_digits: int  # times exponents
    half_pi_digits: int  # times counts of quarter turns


FLOAT = Format("float", 24, "F", 15, 14)
DOUBLE = Format("double", 53, "", 42, 32)


@dataclass(frozen=True)
class Fit:
    """A polynomial for `function` on [low, high] whose error counts times `weight`."""

    name: str
    what: str
    function: Function
    weight: Function
    low: mpf
    high: mpf
    extra_bits: int  # how far below the type's rounding the weighted error has to be


def rounded(x: mpf, digits: int) -> mpf:
    """Return x rounded to so many binary digits."""
    with mp.workprec(digits):
        return +x


def points(fit: Fit, count: int) -> list[mpf]:
    """Return Chebyshev points of the fit's interval."""
    middle, half = (fit.low + fit.high) / 2, (fit.high - fit.low) / 2
    return [middle + half * mp.cos(mp.pi * (2 * i + 1) / (2 * count)) for i in range(count)]


def solve(fit: Fit, fixed: list[mpf], count: int) -> list[mpf]:
    """Return `count` coefficients in all, of which the first ones are given."""
    xs = points(fit, 4 * count + 10)
    # In units of the interval's end, so that the matrix is not needlessly bad.
    powers = range(len(fixed), count)
    matrix = mp.matrix(len(xs), len(powers))
    right = mp.matrix(len(xs), 1)
    for row, x in enumerate(xs):
        weight = fit.weight(x)
        known = sum((c * x**n for n, c in enumerate(fixed)), mpf(0))
        right[row] = weight * (fit.function(x) - known)
        for column, n in enumerate(powers):
            matrix[row, column] = weight * (x / fit.high) ** n
    solution = mp.lu_solve(matrix, right)
    return fixed + [solution[i] / fit.high**n for i, n in enumerate(powers)]


def largest_error(fit: Fit, coefficients: list[mpf]) -> mpf:
    """Return the largest weighted error, found by sampling."""
    errors = []
    for x in points(fit, 500):
        value = sum((c * x**n for n, c in enumerate(coefficients)), mpf(0))
        errors.append(abs(fit.weight(x) * (value - fit.function(x))))
    return max(errors)


def best(fit: Fit, form: Format) -> tuple[list[mpf], mpf]:
    """Return the shortest polynomial with rounded coefficients that is good enough."""
    limit = mpf(2) ** -(form.digits + fit.extra_bits)
    for count in range(2, 24):
        if largest_error(fit, solve(fit, [], count)) > limit / 2:
            continue
        done: list[mpf] = []
        for n in range(count):
            done.append(rounded(solve(fit, done, count)[n], form.digits))
        error = largest_error(fit, done)
        if error <= limit:
            return done, error
    raise ValueError(f"{fit.name}: no polynomial of {form.name} is good enough")


def quotient(function: Function, series: list[int], power: int) -> Function:
    """Return (function - its first Taylor terms) / x^power, exact near 0 too."""

    def value(x: mpf) -> mpf:
        known = sum((mpf(c) * x**n for n, c in enumerate(series)), mpf(0))
        return (function(x) - known) / x**power

    return value


def log_quotient(z: mpf) -> mpf:
    """Return log((1+s)/(1-s))/s with z = s^2."""
    s = mp.sqrt(z)
    return mp.log((1 + s) / (1 - s)) / s


def fits() -> list[Fit]:
    """Return every polynomial."""

    def odd(function: Function) -> Function:
        return lambda z: quotient(function, [0, 1], 3)(mp.sqrt(z))

    def cos_rest(z: mpf) -> mpf:
        return (mp.cos(mp.sqrt(z)) - 1 + z / 2) / z**2

    quarter = (mp.pi / 4) ** 2
    eighth = (mp.sqrt(2) - 1) ** 2
    log_end = ((mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)) ** 2
    slack = mpf("1.0001")
    tiny = mpf("1e-12")
    return [
        Fit(
            "kSin",
            "(sin r - r) / r^3 in r^2, |r| <= pi/4",
            odd(mp.sin),
            lambda z: z,
            tiny,
            quarter * slack,
            6,
        ),
        Fit(
            "kCos",
            "(cos r - 1 + r^2/2) / r^4 in r^2, |r| <= pi/4",
            cos_rest,
            lambda z: z**2,
            tiny,
            quarter * slack,
            6,
        ),
        Fit(
            "kAtan",
            "(atan t - t) / t^3 in t^2, |t| <= tan(pi/8)",
            odd(mp.atan),
            lambda z: z,
            tiny,
            eighth * slack,
            6,
        ),
        Fit(
            "kAsin",
            "(asin x - x) / x^3 in x^2, |x| <= 1/2",
            odd(mp.asin),
            lambda z: z,
            tiny,
            mpf(1) / 4,
            6,
        ),
        Fit(
            "kExp",
            "(exp r - 1 - r) / r^2 in r, |r| <= log(2)/2",
            quotient(mp.exp, [1, 1], 2),
            lambda r: r**2,
            -mp.ln2 / 2 * slack,
            mp.ln2 / 2 * slack,
            6,
        ),
        Fit(
            "kLog",
            "(log((1+s)/(1-s)) - 2s) / s^3 in s^2, (1+s)/(1-s) in [sqrt(1/2), sqrt(2)]",
            lambda z: (log_quotient(z) - 2) / z,
            lambda z: z / 2,
            tiny,
            log_end * slack,
            6,
        ),
        Fit(
            "kLogRest",
            "the same less 2/3 + 2/5 s^2, by s^4",
            lambda z: ((log_quotient(z) - 2) / z - mpf(2) / 3 - 2 * z / 5) / z**2,
            lambda z: z**3 / 2,
            tiny,
            log_end * slack,
            16,
        ),
    ]


def literal(x: mpf, form: Format) -> str:
    """Return a hex literal of exactly x, which must be a number of the format."""
    value = float(x)
    if mpf(value) != x:
        raise ValueError(f"{x} is no {form.name}")
    if form is FLOAT and struct.unpack("<f", struct.pack("<f", value))[0] != value:
        raise ValueError(f"{x} is no float")
    digits, exponent = value.hex().split("p")
    return digits.rstrip("0").rstrip(".") + "p" + exponent + form.suffix


def words(x: mpf, form: Format, high_digits: int | None = None) -> list[mpf]:
    """Return x as a sum of two numbers, the first of them shortened."""
    high = rounded(x, high_digits or form.digits)
    return [high, rounded(x - high, form.digits)]


def constants(form: Format) -> list[str]:
    """Return the constants that need more than one number."""
    lines = []
    pairs = [
        ("kPi", mp.pi, None),
        ("kHalfPi", mp.pi / 2, None),
        ("kQuarterPi", mp.pi / 4, None),
        ("kLn2", mp.ln2, form.ln2_high_digits),
        ("kTwoThirds", mpf(2) / 3, None),
        ("kTwoFifths", mpf(2) / 5, None),
    ]
    for name, value, high_digits in pairs:
        high, low = (literal(part, form) for part in words(value, form, high_digits))
        lines.append(f"    static constexpr DoubleWord<{form.name}> {name}{{{high}, {low}}};")
    parts: list[mpf] = []
    for digits in (form.half_pi_digits, form.half_pi_digits, form.digits):
        parts.append(rounded(mp.pi / 2 - sum(parts, mpf(0)), digits))
    numbers = ", ".join(literal(part, form) for part in parts)
    lines.append(f"    static constexpr {form.name} kHalfPiParts[] = {{{numbers}}};")
    two_over_pi = literal(rounded(2 / mp.pi, form.digits), form)
    lines.append(f"    static constexpr {form.name} kTwoOverPiRounded = {two_over_pi};")
    log2_e = literal(rounded(1 / mp.ln2, form.digits), form)
    lines.append(f"    static constexpr {form.name} kLog2E = {log2_e};")
    return lines


def table(form: Format) -> list[str]:
    """Return the struct of one format."""
    lines = ["template <>", f"struct Coefficients<{form.name}> {{"]
    for fit in fits():
        coefficients, error = best(fit, form)
        lines.append(f"    // {fit.what}. Error 2^{float(mp.log(error, 2)):.1f}.")
        values = ", ".join(literal(c, form) for c in coefficients)
        lines.append(f"    static constexpr {form.name} {fit.name}[] = {{{values}}};")
        print(f"{form.name} {fit.name}: {len(coefficients)} terms", file=sys.stderr)
    return [
        *lines,
        "    // As sums; kLn2's first part leaves room for an exact product with an exponent.",
        *constants(form),
        "};",
        "",
    ]


def two_over_pi() -> list[str]:
    """Return 64 zero bits and then the first bits of 2/pi, as 32-bit words."""
    # The largest double needs bits up to 970 + 3 * 64; one more word is read for the shift.
    count = math.ceil((62 + 971 + 192) / 32) + 1 - 2
    bits = int(mp.floor(2 / mp.pi * mpf(2) ** (32 * count)))
    values = [0, 0] + [(bits >> (32 * (count - 1 - i))) & 0xFFFFFFFF for i in range(count)]
    text = ", ".join(f"0x{value:08x}" for value in values)
    return [
        "// 64 zero bits, then 2/pi from its first binary digit after the point on.",
        f"inline constexpr std::uint32_t kTwoOverPi[] = {{{text}}};",
        "",
    ]


def main() -> None:
    """Write the header to standard output."""
    mp.prec = 2000
    head = [
        "// Polynomials and constants of the functions in this folder. Written by",
        "// fit_coefficients.py, which says how; clang-format wraps the lines.",
        "#pragma once",
        "",
        "#include <cstdint>",
        "",
        '#include "detail/double_word.hpp"',
        "",
        "namespace stator::math::detail {",
        "",
        *two_over_pi(),
        "template <std::floating_point T>",
        "struct Coefficients;",
        "",
    ]
    mp.prec = 400
    lines = [*head, *table(FLOAT), *table(DOUBLE), "}  // namespace stator::math::detail"]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
