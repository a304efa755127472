"""What `./stator top` makes of the figures of two looks."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import pytest

from stator import HOME
from stator.live import figures as top
from stator.live.link import Info, Link, TaskFigures
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from collections.abc import Callable

QUAD = HOME / "graph" / "quad.yaml"
PERIOD_US, EXECUTION_US = 1000, 20
TICKS_IN_US = {"cpu_time": 1000, "cycles": 168}


class Vehicle:
    """Each of its tasks takes 20 of every 1000 us; its clock runs at a factor of the machine's."""

    def __init__(self, factor: float, unit: str) -> None:
        self._factor, self._unit = factor, unit
        self._machine_s = 10.0

    def monotonic(self) -> float:
        return self._machine_s

    def sleep(self, duration_s: float) -> None:
        self._machine_s += duration_s

    def tasks(self, count: int) -> tuple[int, list[TaskFigures]]:
        time_us = round(self._machine_s * self._factor * 1e6)
        activations = time_us // PERIOD_US
        each = EXECUTION_US * TICKS_IN_US[self._unit]
        figures = TaskFigures(activations, 0, activations * each % top.WRAP, each, each, 0, 0)
        return time_us, [figures] * count


@pytest.fixture
def rows_of(monkeypatch: pytest.MonkeyPatch) -> Callable[[float, str], list[top.Row]]:
    def measure(factor: float, unit: str) -> list[top.Row]:
        plan = make_plan(str(QUAD), "linux")
        ticks_per_s = TICKS_IN_US[unit] * 1_000_000
        count = len(plan.tasks)
        info = Info(False, False, unit, 1, ticks_per_s, 0, count, 0, "", "quad", "linux")
        vehicle = Vehicle(factor, unit)
        clock = SimpleNamespace(monotonic=vehicle.monotonic, sleep=vehicle.sleep)
        monkeypatch.setattr(top, "time", clock)
        return top.measure(cast("Link", vehicle), info, plan, 5.0)[1]

    return measure


@pytest.mark.parametrize("factor", [1.0, 0.5, 0.01])
def test_cpu_time_is_part_of_the_machines_time(
    rows_of: Callable[[float, str], list[top.Row]], factor: float
) -> None:
    """At half the speed a task runs half as often, and takes half as much of a processor."""
    for row in rows_of(factor, "cpu_time"):
        assert row.load_pct == pytest.approx(2.0 * factor)
        assert row.per_s == pytest.approx(1000.0)
        assert row.mean_us == pytest.approx(20.0)


def test_cycles_are_part_of_the_vehicles_time(
    rows_of: Callable[[float, str], list[top.Row]],
) -> None:
    """As in the emulator, which may be slower than time."""
    for row in rows_of(0.5, "cycles"):
        assert row.load_pct == pytest.approx(2.0)
