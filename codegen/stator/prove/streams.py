"""When activations come: the most in a window, and the earliest of each. All times are in ns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

ONCE = 10**15  # a period that no window reaches


@dataclass(frozen=True)
class Stream:
    """Activations with one source: one in each period, and each up to `jitter` late."""

    period: int
    jitter: int = 0
    distance: int = 0  # the least time between two of them
    count: int = 1  # that come at once

    def most(self, window: int) -> int:
        """In a window without its end."""
        if window <= 0:
            return 0
        number = -(-(window + self.jitter) // self.period)
        if self.distance:
            number = min(number, -(-window // self.distance))
        return self.count * number

    def earliest(self, number: int) -> int:
        """The least time from the first activation to this one, which counts from 1."""
        after = (number - 1) // self.count
        return max(0, after * self.period - self.jitter, after * self.distance)

    def late(self, latest: int) -> Stream:
        """The same, when each may come until so late after its source."""
        return replace(self, jitter=latest, distance=0)

    def times(self, count: int) -> Stream:
        return replace(self, count=self.count * count)

    def thinned(self, interval: int) -> Stream:
        """At most one in each interval of a grid, at any place in it. A burst has one timestamp, so
        it fires once."""
        if interval <= self.period:
            return replace(self, count=1)
        apart = max(self.distance, self.period - self.jitter, 0)
        return Stream(interval, interval + self.jitter, apart)


def arrivals(streams: Sequence[Stream], number: int) -> list[int]:
    """The earliest times of the first activations of all these streams together."""
    each = (stream.earliest(i) for stream in streams for i in range(1, number + 1))
    return sorted(each)[:number]


def thinned(streams: Sequence[Stream], interval: int) -> tuple[Stream, ...]:
    """Of samples that wake a reader at most once in each interval."""
    apart = tuple(stream.thinned(interval) for stream in streams)
    if sum(Fraction(1, stream.period) for stream in apart) <= Fraction(1, interval):
        return apart
    return (Stream(interval, interval + max(stream.jitter for stream in streams)),)
