"""What the results of many flights say."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stator.flight.log import Floats

Z = 1.959964  # 95 %
BINS = 12
MOST_VALUES = 24
DRAWS = 400
USUAL_SEED = 1


def wilson(count: int, total: int) -> tuple[float, float]:
    """The 95 % interval of a share, E. B. Wilson (1927)."""
    if total == 0:
        return 0.0, 1.0
    share, z2 = count / total, Z * Z
    middle = (share + z2 / (2 * total)) / (1 + z2 / total)
    half = Z * math.sqrt(share * (1 - share) / total + z2 / (4 * total**2)) / (1 + z2 / total)
    low = 0.0 if count == 0 else max(middle - half, 0.0)
    high = 1.0 if count == total else min(middle + half, 1.0)
    return low, high


class Point(NamedTuple):
    """Flights whose input is about `at`."""

    at: float
    failed: int
    total: int

    @property
    def share(self) -> float:
        return self.failed / self.total

    @property
    def interval(self) -> tuple[float, float]:
        return wilson(self.failed, self.total)


def curve(values: Sequence[float], failed: Sequence[bool]) -> list[Point]:
    """The flights by value; many values in groups of equal size."""
    x, y = np.asarray(values, float), np.asarray(failed, bool)
    known = np.unique(x)
    if known.size <= MOST_VALUES:
        return [Point(float(v), int(y[x == v].sum()), int((x == v).sum())) for v in known]
    order = np.argsort(x, kind="stable")
    return [
        Point(float(x[part].mean()), int(y[part].sum()), int(part.size))
        for part in np.array_split(order, BINS)
        if part.size
    ]


def correlation(values: Sequence[float], failed: Sequence[bool]) -> float:
    """Spearman's: of the ranks of the input with failure. 0 if one of them does not vary."""
    x, y = _ranks(np.asarray(values, float)), np.asarray(failed, float)
    if x.size < 2 or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return 0.0
    return float(np.corrcoef(x, y)[0, 1])


def is_significant(strength: float, total: int) -> bool:
    """Whether chance alone gives such a correlation in less than 5 % of such campaigns."""
    return total > 2 and abs(strength) * math.sqrt(total - 1) > Z


def _ranks(x: Floats) -> Floats:
    _, where, counts = np.unique(x, return_inverse=True, return_counts=True)
    ends = np.cumsum(counts)
    ranks: Floats = (ends - 0.5 * (counts - 1))[where]
    return ranks


class Crossing(NamedTuple):
    """The value from which on more than the share fails, and its 95 % interval. Infinite: beyond
    all values that were flown."""

    at: float
    low: float
    high: float


def crossing(values: Sequence[float], failed: Sequence[bool], share: float) -> Crossing:
    """Where a curve that never falls, the nearest to the flights, goes beyond the share; the
    interval from flights drawn again."""
    x, y = np.asarray(values, float), np.asarray(failed, float)
    draw = np.random.Generator(np.random.PCG64(USUAL_SEED))
    again = []
    for _ in range(DRAWS):
        chosen = draw.integers(0, x.size, x.size)
        again.append(_crossing(x[chosen], y[chosen], share))
    low, high = np.quantile(again, [0.025, 0.975], method="closest_observation")
    return Crossing(_crossing(x, y, share), float(low), float(high))


def _crossing(x: Floats, y: Floats, share: float) -> float:
    known, where = np.unique(x, return_inverse=True)
    total = np.bincount(where).astype(float)
    fit = rising(np.bincount(where, weights=y) / total, total)
    over = np.flatnonzero(fit > share)
    if over.size == 0:
        return math.inf
    first = int(over[0])
    if first == 0:
        return float(known[0])
    rise = (share - fit[first - 1]) / (fit[first] - fit[first - 1])
    return float(known[first - 1] + rise * (known[first] - known[first - 1]))


def rising(shares: Floats, weights: Floats) -> Floats:
    """The curve that never falls and is nearest to the shares: pool adjacent violators."""
    blocks: list[list[float]] = []  # share, weight, how many
    for share, weight in zip(shares, weights, strict=True):
        blocks.append([float(share), float(weight), 1])
        while len(blocks) > 1 and blocks[-2][0] >= blocks[-1][0]:
            share_b, weight_b, many_b = blocks.pop()
            share_a, weight_a, many_a = blocks.pop()
            both = weight_a + weight_b
            mean = (share_a * weight_a + share_b * weight_b) / both
            blocks.append([mean, both, many_a + many_b])
    return np.repeat([b[0] for b in blocks], [int(b[2]) for b in blocks])
