"""A quadrotor that loses a motor comes down gently: it spins, and keeps its thrust upright."""

from __future__ import annotations

import json
import subprocess
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from tests.flight.ends_well.flights import program, vehicle

from stator.build.cmake import build
from stator.flight.arguments import memory_of, place_options
from stator.flight.log import read_truth_columns
from stator.mission.read import read_mission

if TYPE_CHECKING:
    from collections.abc import Callable

LAB = Path(__file__).parent / "graph" / "lab_20_m.yaml"
HIGH = """items:
  - takeoff: {height: 30 m}
  - waypoint: {north: 30 m, hold: 5 s}
  - waypoint: {east: 30 m, hold: 5 s}
  - return
"""
FAIL_S = 27.0
MOST_SPEED_M_S, MOST_TILT_DEG = 3.0, 30.0
SHARE = 0.9
WORKERS = 2
FEW, MANY = range(1, 7), range(1001, 1101)


class Touchdown(NamedTuple):
    """What the vehicle did when it first touched the ground after the failure."""

    seed: int
    height_before_m: float
    speed_m_s: float
    tilt_deg: float
    ended: str

    @property
    def is_gentle(self) -> bool:
        return self.speed_m_s < MOST_SPEED_M_S and self.tilt_deg < MOST_TILT_DEG


def fly(folder: Path, binary: Path, options: list[str], seed: int) -> Touchdown:
    """Loses a motor: another one and another moment with each seed."""
    truth, log = folder / f"{seed}.truth", folder / f"{seed}.ulg"
    from_s = FAIL_S + 0.37 * (seed % 20)
    command = [binary, "--seed", str(seed), "--log", log, "--truth", truth, "--duration", "200"]
    command += [*options, "--fail", f"motor_{seed % 4 + 1}.loss@{from_s:.2f}"]
    finished = subprocess.run(command, check=True, capture_output=True, text=True)
    columns = read_truth_columns(truth)
    truth.unlink()
    log.unlink()
    time = columns["time_us"] * 1e-6
    up = columns["position_d"][0] - columns["position_d"]
    row = int(np.flatnonzero((time > from_s) & (columns["on_ground"] != 0.0))[0]) - 1
    level = 1.0 - 2.0 * (columns["q_x"][row] ** 2 + columns["q_y"][row] ** 2)
    velocity = [columns[f"velocity_{axis}"][row] for axis in "ned"]
    return Touchdown(
        seed,
        float(up[np.searchsorted(time, from_s)]),
        float(np.linalg.norm(velocity)),
        float(np.degrees(np.arccos(level))),
        json.loads(finished.stdout)["ended"],
    )


def fly_all(flight: Callable[[int], Touchdown], seeds: range) -> list[Touchdown]:
    with ProcessPoolExecutor(WORKERS) as pool:
        flown = list(pool.map(flight, seeds))
    assert all(f.ended == "motors_stopped" for f in flown)
    return flown


def from_the_lab(folder: Path, seeds: range) -> list[Touchdown]:
    binary = build(LAB, "sitl", executor="virtual")
    flown = fly_all(partial(fly, folder, binary, []), seeds)
    assert all(f.height_before_m > 18.0 for f in flown)
    return flown


def on_a_mission(folder: Path, seeds: range, *more: str) -> list[Touchdown]:
    plan = folder / "mission.yaml"
    plan.write_text(HIGH, encoding="utf-8")
    mission = read_mission(plan, vehicle())
    with memory_of(mission) as memory:
        options = ["--mission", str(memory), *place_options(mission), *more]
        flown = fly_all(partial(fly, folder, program(), options), seeds)
    assert all(f.height_before_m > 27.0 for f in flown)
    return flown


def test_it_comes_down_gently_in_the_lab(tmp_path: Path) -> None:
    flown = from_the_lab(tmp_path, FEW)
    assert all(f.is_gentle for f in flown), flown


def test_it_comes_down_gently_on_a_mission(tmp_path: Path) -> None:
    flown = on_a_mission(tmp_path, FEW)
    assert all(f.is_gentle for f in flown), flown


@pytest.mark.long
def test_a_hundred_come_down_gently_in_the_lab(tmp_path: Path) -> None:
    flown = from_the_lab(tmp_path, MANY)
    assert sum(f.is_gentle for f in flown) >= SHARE * len(MANY), flown


@pytest.mark.long
def test_a_hundred_come_down_gently_on_a_mission(tmp_path: Path) -> None:
    flown = on_a_mission(tmp_path, MANY)
    assert sum(f.is_gentle for f in flown) >= SHARE * len(MANY), flown


@pytest.mark.long
def test_most_come_down_gently_in_wind(tmp_path: Path) -> None:
    """Or are carried along, which is no fall: 8 m/s and moderate gusts."""
    flown = on_a_mission(tmp_path, MANY, "--wind", "8", "--gusts", "moderate")
    assert sum(f.is_gentle for f in flown) >= 0.8 * len(MANY), flown
