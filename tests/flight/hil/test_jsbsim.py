"""Our graph flies a quadrotor in JSBSim, an engine that shares no code with our world."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from tests.flight.hil.jsbsim_bridge import Quad, install, simulate
from tests.flight.hil.peers import OUTDOOR, flying, free_port, serve

from stator.build.cmake import RECORDING, build

if TYPE_CHECKING:
    from pathlib import Path

MISSION = """\
items:
  - takeoff: {height: 4 m}
  - waypoint: {north: 6 m, east: 0 m, hold: 1 s}
  - waypoint: {north: 6 m, east: 6 m, hold: 1 s}
  - waypoint: {north: 0 m, east: 6 m, hold: 1 s}
  - waypoint: {north: 0 m, east: 0 m, hold: 2 s}
  - land
"""


@pytest.fixture(scope="module", autouse=True)
def _programs() -> None:
    install()
    build(OUTDOOR, "sitl", RECORDING, executor="virtual")


def fly(folder: Path) -> list[tuple[float, ...]]:
    folder.mkdir()
    mission = folder / "square.yaml"
    mission.write_text(MISSION, encoding="utf-8")
    port = free_port()
    options = ["--mission", str(mission), "--duration", "90"]
    with flying(port, folder / "log.ulg", *options) as autopilot, serve(port) as peer:
        rows = simulate(Quad(), peer, 90.0)
    assert autopilot.status == 0, autopilot
    assert autopilot.facts["missed_life_signs"] == 0
    return rows


def test_a_square_in_jsbsim_and_again_the_same(tmp_path: Path) -> None:
    rows = fly(tmp_path / "one")
    landed, since = rows[-1], 0
    for corner in ((6.0, 0.0), (6.0, 6.0), (0.0, 6.0), (0.0, 0.0)):  # in this order, at 4 m
        wanted = pytest.approx((*corner, -4.0), abs=0.7)
        since = next((i for i in range(since, len(rows)) if rows[i][1:4] == wanted), -1)
        assert since >= 0, corner
    time_s, north, east, down, tilt_deg = landed
    assert abs(north) < 0.7
    assert abs(east) < 0.7
    assert -down == pytest.approx(0.1, abs=0.03)  # on its feet
    assert tilt_deg < 3.0
    assert time_s < 60.0

    again = fly(tmp_path / "two")
    assert again[-1] == landed
    logs = [(tmp_path / name / "log.ulg").read_bytes() for name in ("one", "two")]
    assert logs[0] == logs[1]
