"""The lives of a run, of programs that are a few lines."""

from __future__ import annotations

import os
import signal
import sys
from typing import TYPE_CHECKING

import pytest

from stator.flight.restarts import run_lives

if TYPE_CHECKING:
    from pathlib import Path

# Writes a log, says how long it lived, and asks for a restart.
ASKS = """
import os, sys, time
folder, life_s, number, parent = sys.argv[1:]
open(folder + "/a.ulg", "w").close()
open(folder + "/lives", "a").write("x")
if number != "0":
    os.kill(int(parent), int(number))
    time.sleep(0.3)
print('{"simulated_s": %s}' % life_s)
sys.exit(3)
"""


def lives(
    folder: Path, duration_s: float, life_s: float = 0.5, number: int = 0
) -> tuple[int, list[str], int]:
    """Exit status, the names of the logs before, and how often it ran."""
    words = [str(folder), str(life_s), f"{number:d}", str(os.getpid())]
    command = [sys.executable, "-S", "-c", ASKS, *words]
    finished, earlier = run_lives(lambda _: command, folder / "a.ulg", duration_s)
    ran = len((folder / "lives").read_text(encoding="utf-8"))
    return finished.returncode, [path.name for path in earlier], ran


def test_a_program_that_always_restarts_ends_with_the_duration(tmp_path: Path) -> None:
    assert lives(tmp_path, 1.8) == (3, ["a.1.ulg", "a.2.ulg", "a.3.ulg"], 4)


def test_a_life_of_no_time_counts(tmp_path: Path) -> None:
    """As a tenth of a second."""
    status, earlier, ran = lives(tmp_path, 0.45, life_s=0.0)
    assert (status, len(earlier), ran) == (3, 3, 4)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_that_a_life_does_not_hear_ends_the_run(tmp_path: Path, number: int) -> None:
    """One that cannot hear it yet, or any more, is not killed; no life comes after it."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)  # also where tests run under nohup
    try:
        assert lives(tmp_path, 100.0, number=number) == (128 + number, [], 1)
    finally:
        signal.signal(signal.SIGHUP, before)
