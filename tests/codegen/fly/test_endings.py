"""A signal ends a flight in order; Ctrl-C once more ends it at once."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

from stator.flight import restarts
from stator.flight.restarts import Endings

if TYPE_CHECKING:
    import pytest

INT, KILL = signal.SIGINT, signal.SIGKILL


def sent(times_s: list[float], monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """What a program gets, if this one hears SIGINT at these times."""
    got: list[int] = []
    clock = iter(times_s)
    monkeypatch.setattr(restarts.time, "monotonic", lambda: next(clock))
    with Endings() as endings:
        process = endings.start(["true"])
        monkeypatch.setattr(process, "send_signal", got.append)
        for _ in times_s:
            signal.raise_signal(INT)
        process.communicate()
    return got


def test_the_second_one_kills(monkeypatch: pytest.MonkeyPatch) -> None:
    assert sent([10.0, 12.0], monkeypatch) == [INT, KILL]


def test_one_that_arrives_twice_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """`timeout -s INT` signals the process, and then its whole group."""
    assert sent([10.0, 10.001, 12.0], monkeypatch) == [INT, INT, KILL]
