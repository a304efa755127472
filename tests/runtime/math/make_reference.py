"""Write reference.inc: arguments and true values of Stator's functions, from mpmath.

Run it in Stator's Python environment, which has mpmath: python make_reference.py > reference.inc
Each true value is the sum of two doubles, so that errors far below one unit in the last place can
be seen. Arguments are hard ones (next to where a function or its code changes, extreme, worst for
the reduction of angles) and random ones with a fixed seed.
"""

import itertools
import math
import random
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from mpmath import mp, mpf

mp.prec = 1400  # the largest double has 1024 bits before the point

Arguments = tuple[float, float]

# Next to multiples of pi/2 and, which is rare, with a carry between the two 64-bit words of the
# product with 2/pi; found by search.
CARRIES = tuple(float.fromhex(x) for x in ("0x1.cfe4f670535a4p+658", "0x1.eb3c429c1357ep+160"))


@dataclass(frozen=True)
class Format:
    """A C++ floating-point type."""

    name: str
    digits: int
    lowest: int  # exponent of the least subnormal number
    highest: int  # every number is below 2^highest
    random_count: int


@dataclass(frozen=True)
class Function:
    """A function, where to try it, and points that are hard for it."""

    name: str
    truth: Callable[[mpf, mpf], mpf]
    sample: Callable[[random.Random, Format], Arguments]
    hard: tuple[float, ...] = ()
    pairs: tuple[Arguments, ...] = ()


FORMATS = [Format("Float", 24, -149, 128, 50), Format("Double", 53, -1074, 1024, 100)]


def to_format(x: float, form: Format) -> float:
    """Return x as a number of the format."""
    if form.name == "Double":
        return x
    return float(struct.unpack("<f", struct.pack("<f", x))[0]) if abs(x) < 2.0**128 else 0.0


def neighbours(x: float, form: Format) -> list[float]:
    """Return x and the numbers next to it."""
    x = to_format(x, form)
    exponent = max(math.frexp(x)[1] - form.digits, form.lowest)
    return [x, x + math.ldexp(1.0, exponent), x - math.ldexp(1.0, exponent)]


def near_quarter_turns(form: Format, count: int) -> list[float]:
    """Return the numbers that come nearest to a multiple of pi/2, by continued fractions."""
    found: list[tuple[mpf, float]] = []
    for exponent in range(1 - form.digits, form.highest - form.digits):
        turns = mp.mpf(2) ** exponent * 2 / mp.pi
        for integer in convergents(turns, 2**form.digits):
            factor = max(1, 2 ** (form.digits - 1) // integer)
            for multiple in (factor, factor + 1):
                if 2 ** (form.digits - 1) <= integer * multiple < 2**form.digits:
                    value = mpf(integer * multiple) * mp.mpf(2) ** exponent
                    distance = abs(value * 2 / mp.pi - mp.nint(value * 2 / mp.pi))
                    found.append((distance, float(value)))
    return [x for _, x in sorted(set(found))[:count]]


def convergents(x: mpf, limit: int) -> Iterator[int]:
    """Yield the denominators of the continued fraction of x."""
    before, last = 0, 1
    rest = x - mp.floor(x)
    while rest > mpf(2) ** -1000:
        rest = 1 / rest
        before, last = last, int(mp.floor(rest)) * last + before
        if last >= limit:
            return
        yield last
        rest -= mp.floor(rest)


def wide(rng: random.Random, form: Format) -> Arguments:
    """Return a number of any size."""
    low, high = form.lowest + form.digits, form.highest - 1
    return (rng.choice([-1, 1]) * math.ldexp(1 + rng.random(), rng.randint(low, high - 1)), 0.0)


def angle(rng: random.Random, form: Format) -> Arguments:
    """Return an angle, mostly a few turns."""
    return (rng.uniform(-20, 20), 0.0) if rng.random() < 0.7 else wide(rng, form)


def positive(rng: random.Random, form: Format) -> Arguments:
    """Return a positive number, often near 1."""
    return (rng.uniform(0.5, 2), 0.0) if rng.random() < 0.4 else (abs(wide(rng, form)[0]), 0.0)


def unit(rng: random.Random, _: Format) -> Arguments:
    """Return a number in [-1, 1]."""
    return (rng.uniform(-1, 1), 0.0)


def exponent_range(rng: random.Random, form: Format) -> Arguments:
    """Return an argument whose exponential is a number."""
    high = form.highest * math.log(2)
    return (rng.uniform(-2, 2) if rng.random() < 0.4 else rng.uniform(-high * 1.04, high), 0.0)


def ratio(rng: random.Random, form: Format) -> Arguments:
    """Return y and x of atan2."""
    x = wide(rng, form)[0]
    y = x * math.ldexp(rng.uniform(-1, 1), rng.randint(-3, 4))
    return (y, x) if abs(y) < 2.0 ** (form.highest - 1) else (x, 1.0)


def power(rng: random.Random, form: Format) -> Arguments:
    """Return base and exponent with a result in range."""
    base = positive(rng, form)[0]
    high = (form.highest - 1) * math.log(2)
    return (base, rng.uniform(-high, high) / (math.log(base) or 1.0))


def wrapped(x: mpf, form: Format) -> mpf:
    """Return the angle x in [-pi, pi], but x itself up to pi as rounded to the format."""
    if abs(x) <= to_format(math.pi, form):
        return x
    return x - 2 * mp.pi * mp.nint(x / (2 * mp.pi))


def functions(form: Format) -> list[Function]:
    """Return all functions with hard points for one format."""
    turns = tuple(near_quarter_turns(form, 20))
    angles = (
        1e-30,
        1e-4,
        0.5,
        math.pi / 4,
        math.pi / 2,
        math.pi,
        3 * math.pi / 2,
        2 * math.pi,
        1e4,
        1e22,
        *turns,
        *CARRIES,
    )
    least = math.ldexp(1.0, form.lowest)
    third = math.tan(math.pi / 8)
    big = math.ldexp(1.0, form.highest - 2)
    logs = (least, 3 * least, 0.5**0.5, 2**0.5, 1 - 1e-5, 1 + 1e-5, 2.0, 10.0, big)
    exps = (
        1e-20,
        -1e-20,
        math.log(2) / 2,
        math.log(2),
        1.0,
        10.0,
        form.highest * math.log(2) - 1e-3,
        (form.lowest + form.digits - 1) * math.log(2),
        (form.lowest + 1) * math.log(2),
    )
    ratios = (
        (1.0, 1.0),
        (third, 1.0),
        (1.0, third),
        (least, 1.0),
        (least, least * 3),
        (big, big / 3),
        (1.0, -1e-6),
        (1e-6, -1.0),
        (big, 1.0),
        (1.0, -big),
        (-1e-3, 1e-3),
        (0.3, -0.7),
        (-5.0, -1e-3),
    )
    powers = (
        (2.0, 0.5),
        (10.0, -3.0),
        (1 + 2.0 ** (1 - form.digits), 2.0 ** (form.digits + 2)),
        (1 - 2.0**-form.digits, 2.0 ** (form.digits + 3)),
        (least, 0.3),
        (big, -1.0),
        (0.9999, 1e4),
        (1.0001, -1e4),
        (3.0, 40.0),
        (1.2, 5.255),
    )
    return [
        Function("Sin", lambda x, _: mp.sin(x), angle, angles),
        Function("Cos", lambda x, _: mp.cos(x), angle, angles),
        Function("Tan", lambda x, _: mp.tan(x), angle, angles),
        Function("WrapPi", lambda x, _: wrapped(x, form), angle, angles),
        Function(
            "Atan", lambda x, _: mp.atan(x), wide, (0.1, third, 1.0, 1 / third, 10.0, least, big)
        ),
        Function("Asin", lambda x, _: mp.asin(x), unit, (1e-30, 1e-5, 0.5, 0.7071, 0.99999, 1.0)),
        Function(
            "Acos",
            lambda x, _: mp.acos(x),
            unit,
            (1e-30, 1e-5, 0.5, -0.5, 0.7071, 0.99999, -0.99999, -1.0),
        ),
        Function("Exp", lambda x, _: mp.exp(x), exponent_range, exps),
        Function("Log", lambda x, _: mp.log(x), positive, logs),
        Function("Sqrt", lambda x, _: mp.sqrt(x), positive, logs),
        Function("Atan2", mp.atan2, ratio, (), ratios),
        Function("Pow", mp.power, power, (), powers),
    ]


def arguments(function: Function, form: Format) -> Iterator[Arguments]:
    """Yield every point of a function's table."""
    rng = random.Random(function.name + form.name)
    for x in function.hard:
        yield from ((near, 0.0) for near in neighbours(x, form))
    yield from function.pairs
    for _ in range(form.random_count):
        yield function.sample(rng, form)


def hexadecimal(x: float) -> str:
    """Return a short hex literal."""
    digits, _, exponent = x.hex().partition("p")
    return (
        digits.rstrip("0").rstrip(".") + "p" + exponent
        if "." in digits
        else digits + "p" + exponent
    )


def row(function: Function, form: Format, point: Arguments) -> str | None:
    """Return the line for one point, or None where there is no finite true value."""
    x, y = (to_format(value, form) for value in point)
    if (function.name in {"Asin", "Acos"} and abs(x) > 1) or (
        function.name in {"Log", "Sqrt", "Pow"} and x <= 0
    ):
        return None
    truth = function.truth(mpf(x), mpf(y))
    # Below 2^-960 the second double would not hold what the first leaves over.
    least = max(form.lowest, -960)
    if truth == 0 or not mpf(2) ** least <= abs(truth) < mpf(2) ** form.highest * (
        1 - mpf(2) ** -form.digits
    ):
        return None
    high = float(truth)
    low = float(truth - mpf(high))
    return "{" + ", ".join(hexadecimal(value) for value in (x, y, high, low)) + "},"


def main() -> None:
    """Write the tables to standard output."""
    print("// True values from mpmath: {x, y, high, low}, f(x) or f(x, y) = high + low.")
    print("// Written by make_reference.py, which says how.")
    for form in FORMATS:
        for function in functions(form):
            rows = (row(function, form, point) for point in arguments(function, form))
            lines = dict.fromkeys(itertools.filterfalse(lambda line: line is None, rows))
            print(f"inline constexpr Reference k{function.name}{form.name}[] = {{")
            print("\n".join(str(line) for line in lines))
            print("};")


if __name__ == "__main__":
    main()
