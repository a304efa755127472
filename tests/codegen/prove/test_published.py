"""Task sets from the literature, with the response times that the papers give.

Where a paper has times that are not whole, all are multiplied. Each set is also simulated in
`test_simulated.py`.
"""

from __future__ import annotations

from typing import NamedTuple

import pytest

from stator.prove.response import Job, responses
from stator.prove.streams import Stream


class Row(NamedTuple):
    """A task; the most urgent first."""

    cost: int
    period: int
    jitter: int = 0
    section: int = 0


def worst(rows: list[Row], *, one_level: bool = False, jitter: bool = True) -> list[int | None]:
    """From the source of each activation, or without its jitter from its arrival."""
    jobs = [
        Job(
            str(i),
            1 if one_level else len(rows) - i,
            row.cost,
            (Stream(row.period, row.jitter),),
            row.section,
        )
        for i, row in enumerate(rows)
    ]
    found = responses(jobs)
    return [None if r is None else r.from_source if jitter else r.from_arrival for r in found]


PREEMPTIVE = {
    # Burns and Wellings, Real-Time Systems and Programming Languages, 4th ed., section 11.
    "burns_wellings_b": ([Row(3, 7), Row(3, 12), Row(5, 20)], [3, 6, 20]),
    "burns_wellings_c": ([Row(5, 20), Row(10, 40), Row(40, 80)], [5, 15, 80]),
    "burns_wellings_a": ([Row(10, 30), Row(10, 40), Row(12, 50)], [10, 20, 52]),
    # The same with sections of less urgent tasks, for which the busy window begins later.
    "burns_wellings_b_blocked": (
        [Row(3, 7, 0, 2), Row(3, 12, 0, 2), Row(5, 20)],
        [5, 11, 20],
    ),
    # Lehoczky, Fixed priority scheduling of periodic task sets with arbitrary deadlines, RTSS 1990:
    # the fifth activation is the worst one.
    "lehoczky_1990": ([Row(26, 70), Row(62, 100)], [26, 118]),
    # Wang and Saksena, Scheduling fixed-priority tasks with preemption threshold, RTCSA 1999.
    "wang_saksena_1999": ([Row(20, 70), Row(20, 80), Row(35, 200)], [20, 40, 115]),
    # Liu and Layland, JACM 1973: periods that divide each other use the whole processor.
    "liu_layland_1973": ([Row(1, 2), Row(1, 4), Row(2, 8)], [1, 2, 8]),
    # The two tasks of its section 4: with the short period first, the other one may take 2 of its
    # 5; with the long period first, neither may take more than 1.
    "liu_layland_1973_short_first": ([Row(1, 2), Row(2, 5)], [1, 4]),
    "liu_layland_1973_long_first": ([Row(1, 5), Row(1, 2)], [1, 2]),
    "liu_layland_1973_too_much": ([Row(2, 5), Row(1, 2)], [2, 3]),
    # Sha and Goodenough, Real-time scheduling theory and Ada, IEEE Computer 1990: beyond the bound
    # of utilisation, but the last one ends at 300, before its 350.
    "sha_goodenough_1990": ([Row(40, 100), Row(40, 150), Row(100, 350)], [40, 80, 300]),
}
ONE_LEVEL = {
    # The same set of Wang and Saksena without preemption.
    "wang_saksena_1999": ([Row(20, 70), Row(20, 80), Row(35, 200)], [55, 75, 75]),
    # Davis, Burns, Bril and Lukkien, Controller Area Network (CAN) schedulability analysis:
    # Refuted, revisited and revised, Real-Time Systems 2007, times 10: the second one is the worst.
    "davis_2007": ([Row(10, 25), Row(10, 35), Row(10, 35)], [20, 30, 35]),
}


@pytest.mark.parametrize(("rows", "expected"), PREEMPTIVE.values(), ids=PREEMPTIVE)
def test_each_level_has_one_task(rows: list[Row], expected: list[int]) -> None:
    assert worst(rows) == expected


@pytest.mark.parametrize(("rows", "expected"), ONE_LEVEL.values(), ids=ONE_LEVEL)
def test_one_level_has_all_tasks(rows: list[Row], expected: list[int]) -> None:
    assert worst(rows, one_level=True) == expected


def test_jitter() -> None:
    """pyCPA, examples/spp_test.py, resource R1, whose response times do not count the jitter of the
    task's own arrivals."""
    rows = [Row(10, 30, 5), Row(3, 15, 6)]
    assert worst(rows, jitter=False) == [10, 13]
    assert worst(rows) == [15, 19]


def test_jitter_goes_on_to_the_next_resource() -> None:
    """The same example, resource R2: its two tasks are woken by those of R1, which take at least 5
    and 1. So the activations of the second one are at least 1 apart."""
    first = [Row(10, 30, 5), Row(3, 15, 6)]
    jitter = [5 + 10 - 5, 6 + 13 - 1]
    assert [r for r in worst(first, jitter=False) if r is not None] == [10, 13]
    jobs = [
        Job("T21", 2, 2, (Stream(30, jitter[0], 5),)),
        Job("T22", 1, 9, (Stream(15, jitter[1], 1),)),
    ]
    found = [row.from_arrival for row in responses(jobs) if row is not None]
    assert found == [2, 19]


def test_a_full_processor_has_no_bound() -> None:
    assert worst([Row(4, 7), Row(6, 14)]) == [4, 14]
    assert worst([Row(4, 7), Row(7, 14)]) == [4, None]
