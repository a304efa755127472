"""Shares, their intervals, and what goes together: against figures from elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stator.campaign.statistics import (
    correlation,
    crossing,
    curve,
    is_significant,
    rising,
    wilson,
)


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [  # R. G. Newcombe (1998), Statistics in Medicine 17, table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_the_interval_of_a_share(count: int, total: int, low: float, high: float) -> None:
    assert wilson(count, total) == pytest.approx((low, high), abs=5e-5)
    assert wilson(total - count, total) == pytest.approx((1.0 - high, 1.0 - low), abs=5e-5)


def test_a_curve_that_never_falls() -> None:
    shares, weights = np.array([0.0, 0.2, 0.1, 0.5, 0.4, 0.3]), np.ones(6)
    assert rising(shares, weights) == pytest.approx([0.0, 0.15, 0.15, 0.4, 0.4, 0.4])
    heavy = np.array([1.0, 3.0, 1.0, 1.0, 1.0, 1.0])
    assert rising(shares, heavy)[1] == pytest.approx(0.175)


def test_ranks_with_ties_go_together_as_spearman_says() -> None:
    assert correlation([1, 2, 3, 4], [False, False, True, True]) == pytest.approx(
        0.894427, abs=1e-6
    )
    assert correlation([1, 1, 2, 2], [True, True, False, False]) == pytest.approx(-1.0)
    assert correlation([3, 3, 3], [True, False, True]) == 0.0
    assert correlation([1, 2, 3], [True, True, True]) == 0.0


def test_chance_alone_is_not_significant() -> None:
    assert not is_significant(0.1, 100)
    assert is_significant(0.3, 100)


def test_where_a_share_is_crossed() -> None:
    values = [v for v in (2.0, 4.0, 6.0, 8.0) for _ in range(100)]
    failed = [i % 100 < {2.0: 0, 4.0: 0, 6.0: 10, 8.0: 80}[v] for i, v in enumerate(values)]
    found = crossing(values, failed, 0.05)
    assert found.at == pytest.approx(5.0)
    assert 4.0 < found.low < 5.0 < found.high < 6.1
    assert math.isinf(crossing(values, [False] * 400, 0.01).at)
    assert crossing(values, failed, 0.05) == found


def test_many_values_are_shown_in_groups_of_equal_size() -> None:
    points = curve(list(np.linspace(0.0, 1.0, 120)), [i >= 60 for i in range(120)])
    assert [point.total for point in points] == [10] * 12
    assert [point.share for point in points] == [0.0] * 6 + [1.0] * 6
    few = curve([1.0, 2.0, 2.0], [True, False, True])
    assert [(point.at, point.failed, point.total) for point in few] == [(1.0, 1, 1), (2.0, 1, 2)]
