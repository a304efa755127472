"""Flights in which something goes wrong, each of which once ended badly."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyulog import ULog

from stator import HOME
from stator.flight.log import read_truth, read_truth_columns

STABILIZED = str(HOME / "tests" / "flight" / "ends_well" / "graph" / "by_hand.yaml")
MISSIONS = HOME / "graph" / "missions"
HIGH = "items: [takeoff: {{height: {} m}}, waypoint: {{north: 30 m, hold: 60 s}}, return]\n"


def fly(folder: Path, *arguments: str, graph: str = "") -> dict[str, Any]:
    log = folder / "flight.ulg"
    command = [HOME / "stator", "fly", *([graph] if graph else []), "--json", "-o", log]
    finished = subprocess.run(
        [*command, "--no-record", *arguments], cwd=HOME, check=False, capture_output=True, text=True
    )
    assert finished.returncode in (0, 1), finished.stderr
    facts: dict[str, Any] = json.loads(finished.stdout)
    return facts


def fly_by_hand(folder: Path, rows: list[str], *arguments: str, graph: str = "") -> dict[str, Any]:
    """Rows as docs/simulation.md: seconds roll pitch yaw throttle mode_slot arm return kill."""
    script = folder / "pilot.txt"
    script.write_text("\n".join(rows) + "\n", encoding="utf-8")
    graph = graph or str(HOME / "graph" / "quad_outdoor.yaml")
    return fly(folder, "--pilot", str(script), *arguments, graph=graph)


def modes(facts: dict[str, Any]) -> list[str]:
    return [m["mode"] if m["armed"] else "disarmed" for m in facts["modes"]]


def height(facts: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    flown = read_truth(Path(facts["truth"]))
    return flown.time_s, flown.position[0, 2] - flown.position[:, 2]


def tilt_deg(facts: dict[str, Any]) -> np.ndarray:
    q = read_truth(Path(facts["truth"])).q
    return np.degrees(np.arccos(np.clip(1 - 2 * (q[:, 1] ** 2 + q[:, 2] ** 2), -1, 1)))


def stopped_s(facts: dict[str, Any]) -> float:
    """When the motors began to stand still for good."""
    columns = read_truth_columns(Path(facts["truth"]))
    turns = np.flatnonzero(sum(columns[f"rotor_{i + 1}"] for i in range(4)) > 100.0)
    return float(columns["time_us"][turns[-1]] * 1e-6)


@pytest.mark.parametrize(("metres", "seed"), [(60, 1), (80, 2)])
def test_a_blind_descent_ends_on_the_ground(metres: int, seed: int, tmp_path: Path) -> None:
    mission = tmp_path / "high.yaml"
    mission.write_text(HIGH.format(metres), encoding="utf-8")
    arguments = ["--mission", str(mission), "--seed", str(seed), "--duration", "400"]
    facts = fly(tmp_path, *arguments, "--fail", "gnss_loss@45")
    assert facts["broken_invariant"] is None
    assert modes(facts) == ["disarmed", "mission", "descend", "disarmed"]
    assert facts["touchdown_m_s"] < 1.0


PILOT_LANDS = [
    "1  0 0   0  0   3 0 0 0",
    "10 0 0   0  0   3 1 0 0",
    "12 0 0   0  0.8 3 1 0 0",
    "16 0 0.8 0  0   3 1 0 0",
    "22 0 0   0  0   3 1 0 0",
    "26 0 0   0 -0.7 3 1 0 0",
]


@pytest.mark.parametrize("fault", ["rc_loss@42", "battery_low=0.05@42", "gnss_loss@35"])
def test_what_has_landed_stays_there(fault: str, tmp_path: Path) -> None:
    facts = fly_by_hand(tmp_path, PILOT_LANDS, "--fail", fault, "--duration", "140")
    assert facts["broken_invariant"] is None
    assert modes(facts)[-2:] == ["position", "disarmed"]
    time, up = height(facts)
    assert up[time > facts["touchdown_s"] + 1.0].max() < 0.1


@pytest.mark.parametrize("slot", [2, 3, 1])
def test_after_a_landing_by_hand_it_can_be_disarmed(slot: int, tmp_path: Path) -> None:
    """In altitude, position and stabilized: down, and the switch off 5 s later."""
    climb, sink = ("0.1", "-0.1") if slot == 1 else ("0.5", "-0.7")
    rows = [
        f"1 0 0 0 -1 {slot} 0 0 0",
        f"10 0 0 0 -1 {slot} 1 0 0",
        f"12 0 0 0 {climb} {slot} 1 0 0",
        f"15 0 0 0 {sink} {slot} 1 0 0",
        f"35 0 0 0 -1 {slot} 1 0 0",
        f"40 0 0 0 -1 {slot} 0 0 0",
    ]
    facts = fly_by_hand(tmp_path, rows, "--duration", "60", graph=STABILIZED)
    assert facts["take_off_s"] is not None
    assert facts["broken_invariant"] is None
    assert modes(facts)[-1] == "disarmed"
    assert facts["duration_s"] < 45.0


@pytest.mark.parametrize(("motor", "seed"), [(1, 1), (2, 3)])
def test_without_a_motor_it_lands(motor: int, seed: int, tmp_path: Path) -> None:
    mission = str(MISSIONS / "square.yaml")
    arguments = ["--mission", mission, "--seed", str(seed), "--fail", f"motor_{motor}=0@20"]
    facts = fly(tmp_path, *arguments)
    assert facts["broken_invariant"] is None
    assert modes(facts) == ["disarmed", "mission", "landing", "disarmed"]
    assert "motor_lost" in facts["reason"]
    assert facts["touchdown_m_s"] < 1.0


@pytest.mark.parametrize(("other", "seed"), [(2, 1), (3, 3)])
def test_upside_down_the_motors_stop(other: int, seed: int, tmp_path: Path) -> None:
    """Two motors are too many."""
    mission = str(MISSIONS / "square.yaml")
    faults = ["--fail", "motor_1=0@20", "--fail", f"motor_{other}=0@20.5"]
    facts = fly(tmp_path, "--mission", mission, "--seed", str(seed), *faults)
    assert facts["broken_invariant"] is None
    assert "upside down" in facts["reason"]
    assert stopped_s(facts) - facts["touchdown_s"] < 2.0


@pytest.mark.parametrize(
    ("mission", "arguments"),
    [
        ("square", ["--fail", "battery_low=0.02@20"]),
        ("square", ["--wind", "14", "--fail", "battery_low=0.05@20"]),
        ("hover", ["--wind", "16"]),
        ("square", ["--wind", "8", "--gusts", "moderate", "--fail", "motor_2=0.5@20"]),
    ],
)
def test_a_landing_has_an_end(mission: str, arguments: list[str], tmp_path: Path) -> None:
    """Where the vehicle can, and soon: it does not wait for a place that it cannot reach."""
    file = str(MISSIONS / f"{mission}.yaml")
    facts = fly(tmp_path, "--mission", file, "--duration", "200", *arguments)
    assert facts["broken_invariant"] is None
    assert modes(facts)[-2:] == ["landing", "disarmed"]
    assert facts["duration_s"] < 60.0
    assert facts["touchdown_m_s"] < 1.3
    position = read_truth(Path(facts["truth"])).position
    assert np.hypot(position[-1, 0], position[-1, 1]) < 40.0


@pytest.mark.parametrize("seconds", [0.3, 1.0])
def test_an_accelerometer_that_clips_does_not_lift_the_vehicle(
    seconds: float, tmp_path: Path
) -> None:
    """Nor is its height said to be valid meanwhile."""
    mission = str(MISSIONS / "hover.yaml")
    fault = f"imu0.accel_z_offset=9.8@25+{seconds}"
    facts = fly(tmp_path, "--mission", mission, "--fail", fault)
    assert facts["broken_invariant"] is None
    time, up = height(facts)
    around = (time > 24.0) & (time < 32.0)
    before = up[time < 25.0][-1]
    assert up[around].max() - before < 1.0
    assert ("descend" in modes(facts)) == (seconds == 1.0)


def test_it_does_not_matter_which_height_comes_first(tmp_path: Path) -> None:
    mission = str(MISSIONS / "hover.yaml")
    faults = ["--fail", "baro_loss@0+2", "--fail", "gnss_loss@30+4.5"]
    facts = fly(tmp_path, "--mission", mission, *faults)
    assert facts["success"], facts["reason"]


def test_without_throttle_the_attitude_is_kept(tmp_path: Path) -> None:
    rows = [
        "1    0   0 0 -1  1 0 0 0",
        "10   0   0 0 -1  1 1 0 0",
        "12   0   0 0 0.6 1 1 0 0",
        "18   0   0 0 0   1 1 0 0",
        "20   0.5 0 0 0   1 1 0 0",
        "20.1 0   0 0 -1  1 1 0 0",
        "21.5 0   0 0 0.5 1 1 0 0",
        "26   0   0 0 0   1 1 0 0",
    ]
    facts = fly_by_hand(tmp_path, rows, "--duration", "30", graph=STABILIZED)
    assert tilt_deg(facts).max() < 40.0


def test_on_the_ground_the_setpoint_waits_for_the_vehicle(tmp_path: Path) -> None:
    rows = [
        "1  0 0 0 -1   3 0 0 0",
        "10 0 0 0 -1   3 1 0 0",
        "20 0 0 0  1   3 1 0 0",
        "24 0 0 0  0   3 1 0 0",
        "28 0 0 0 -0.7 3 1 0 0",
        "45 0 0 0 -1   3 0 0 0",
    ]
    facts = fly_by_hand(tmp_path, rows, "--duration", "70")
    assert facts["broken_invariant"] is None
    assert 20.0 < facts["take_off_s"] < 22.5
    assert modes(facts)[-1] == "disarmed"


@pytest.mark.parametrize("receiver", ["loss", "silence"])
def test_a_link_that_is_lost_leads_home(receiver: str, tmp_path: Path) -> None:
    mission = str(MISSIONS / "square.yaml")
    facts = fly(tmp_path, "--mission", mission, "--fail", f"radio0.{receiver}@20")
    assert facts["broken_invariant"] is None
    assert modes(facts) == ["disarmed", "mission", "return", "landing", "disarmed"]


def test_what_no_sensor_can_show_is_named(tmp_path: Path) -> None:
    mission = str(MISSIONS / "hover.yaml")
    facts = fly(tmp_path, "--mission", mission, "--fail", "gnss0.spoof=1@25")
    assert facts["unseen_failures"] == ["gnss0.spoof=1@25"]
    assert facts["broken_invariant"] is None


@pytest.mark.parametrize("node", ["rate_control", "allocation"])
def test_motors_that_nothing_commands_any_more_stop(node: str, tmp_path: Path) -> None:
    """A node of the innermost loop is silent: the vehicle falls, and its motors do not turn on the
    ground. The flight names the node."""
    mission = str(MISSIONS / "square.yaml")
    facts = fly(tmp_path, "--mission", mission, "--seed", "2", "--fail", f"{node}.stuck@20")
    assert facts["broken_invariant"] is None
    assert modes(facts)[-1] == "disarmed"
    assert stopped_s(facts) < 22.0
    assert facts["missed_life_signs"] > 0
    messages = {row.message for row in ULog(facts["log"]).logged_messages}
    assert f"no life sign of {node}" in messages
