"""Missions in virtual time, with the limits that the project promises; and each failsafe, flown.

Limits: graph/missions/*.yaml, except for what a test says. Faults: docs/simulation.md.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyulog import ULog

from stator.build.cmake import build
from stator.flight.log import read_flight, read_truth
from stator.flight.mission import MissionFlight, judge_mission
from stator.mission.read import read_mission
from stator.mission.store import write

ROOT = Path(__file__).parents[3]
MISSIONS = ROOT / "graph" / "missions"
PLANS = ROOT / "tests" / "codegen" / "mission" / "plans"
WINDY = ("--wind", "8", "--gusts", "moderate")


def fly(mission: str, log: Path, *arguments: str) -> dict[str, Any]:
    command = [ROOT / "stator", "fly", "--mission", MISSIONS / f"{mission}.yaml", "--json"]
    finished = subprocess.run(
        [*command, "-o", log, *arguments], cwd=ROOT, check=False, capture_output=True, text=True
    )
    assert finished.returncode in (0, 1), finished.stderr
    facts: dict[str, Any] = json.loads(finished.stdout)
    assert finished.returncode == (0 if facts["success"] else 1)
    return facts


def fly_many(mission: str, seeds: range, folder: Path, *options: str) -> dict[int, MissionFlight]:
    """Many flights of one mission, without a start of Stator for each."""
    program = build(ROOT / "graph" / "quad_outdoor.yaml", "sitl", executor="virtual")
    flown = read_mission(MISSIONS / f"{mission}.yaml")
    file, log, truth = folder / "mission", folder / "flight.ulg", folder / "flight.truth"
    write(flown, file)
    command = [program, "--mission", file, "--log", log, "--truth", truth, "--duration", "200"]
    results = {}
    for seed in seeds:
        finished = subprocess.run(
            [*command, "--seed", str(seed), *options], check=True, capture_output=True, text=True
        )
        ulog = ULog(str(log))
        flight = read_flight(ulog, read_truth(truth), json.loads(finished.stdout))
        results[seed] = judge_mission(ulog, flight, flown)
    return results


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--mission", "none.yaml"], "cannot read the mission 'none.yaml'"),
        (
            ["graph/quad.yaml", "--mission", "graph/missions/eight.yaml"],
            "missing node of app 'mission' in",
        ),
        (["--mission", "graph/quad.yaml"], "unknown key 'nodes'"),
        (["--mission", "graph/missions/eight.yaml", "--speed", "0"], "expected a factor above 0"),
    ],
)
def test_wrong_arguments(arguments: list[str], message: str) -> None:
    command = [ROOT / "stator", "fly", *arguments]
    finished = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    assert finished.returncode == 2
    assert finished.stdout == ""
    assert message in finished.stderr
    assert "Traceback" not in finished.stderr


def columns(log: Path, topic: str, *names: str) -> tuple[np.ndarray, np.ndarray]:
    data = next(d.data for d in ULog(str(log)).data_list if d.name == topic)
    return data["timestamp"] * 1e-6, np.column_stack([data[name] for name in names])


def truth(facts: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, position, tilt in deg."""
    flight = read_truth(Path(facts["truth"]))
    tilt = 1 - 2 * (flight.q[:, 1] ** 2 + flight.q[:, 2] ** 2)
    return flight.time_s, flight.position, np.degrees(np.arccos(np.clip(tilt, -1, 1)))


def modes(facts: dict[str, Any]) -> list[str]:
    return [m["mode"] if m["armed"] else "disarmed" for m in facts["modes"]]


# --- missions ---


@pytest.mark.parametrize("seed", [1, 2])
def test_square_home_and_down(seed: int, tmp_path: Path) -> None:
    facts = fly("square", tmp_path / "flight.ulg", "--seed", str(seed))
    assert facts["success"], facts["reason"]
    assert facts["items_reached"] == facts["items_total"] == 5
    assert modes(facts) == ["disarmed", "mission", "return", "landing", "disarmed"]
    assert facts["corridor_m"] <= 2.0
    assert facts["landing_error_m"] <= 1.0
    assert facts["touchdown_m_s"] < 1.0
    assert facts["lost_samples"] == 0


def assert_hovers(seeds: range, folder: Path) -> None:
    """No flight fails, and the RMS to truth over all of them is under 1.0 m horizontally and 0.5 m
    vertically. A single one may have drifted further: in a minute a satellite fix wanders 0.4 m on
    each axis and the barometer 0.5 m (boards/world/world/navigation_sensors.hpp), one sigma."""
    flown = fly_many("hover", seeds, folder, *WINDY)
    assert [(seed, f.problems) for seed, f in flown.items() if f.problems] == []
    for key, most in (("hold_horizontal_rms_m", 1.0), ("hold_vertical_rms_m", 0.5)):
        rms = [f.facts[key] for f in flown.values()]
        assert np.sqrt(np.mean(np.square(rms))) < most


def test_hovers_in_wind_and_gusts(tmp_path: Path) -> None:
    assert_hovers(range(1, 3), tmp_path)


@pytest.mark.long
def test_hovers_in_wind_and_gusts_with_many_seeds(tmp_path: Path) -> None:
    assert_hovers(range(1, 21), tmp_path)


@pytest.mark.long
def test_99_of_100_varied_vehicles_fly_the_square(tmp_path: Path) -> None:
    """Mass, inertia, thrust, centre of gravity, delay and sensor biases as docs/simulation.md."""
    flown = fly_many("square", range(1, 101), tmp_path, "--vary", "yes")
    failed = {seed: f.problems for seed, f in flown.items() if f.problems}
    assert len(failed) <= 1, failed


@pytest.mark.long
def test_varied_vehicles_hover_in_wind_and_gusts(tmp_path: Path) -> None:
    """None is lost, though the weakest cannot always hold its place."""
    flown = fly_many("hover", range(1, 31), tmp_path, "--vary", "yes", *WINDY)
    lost = {s: f.problems for s, f in flown.items() if any("land" in p.text for p in f.problems)}
    assert lost == {}


@pytest.mark.parametrize(("wind", "most_m"), [("0", 0.4), ("6", 0.6)])
def test_eight_is_tracked(wind: str, most_m: float, tmp_path: Path) -> None:
    log = tmp_path / "flight.ulg"
    facts = fly("eight", log, "--wind", wind)
    assert facts["items_reached"] == facts["items_total"] == 2
    assert facts["tracking_rms_m"] <= most_m
    _, velocity = columns(log, "trajectory_setpoint", "velocity[0]", "velocity[1]")
    assert np.nanmax(np.hypot(*velocity.T)) == pytest.approx(5.0, abs=0.05)


@pytest.mark.parametrize("seed", [1, 2])
def test_step_of_5_m(seed: int, tmp_path: Path) -> None:
    """From the moment that the goal moves: within 0.3 m for good in 6 s, and at most 10 % beyond.
    Against the estimate, as a satellite's position wanders meanwhile."""
    log = tmp_path / "flight.ulg"
    facts = fly("step", log, "--seed", str(seed))
    assert facts["success"], facts["reason"]
    goal_time, goal = columns(log, "goto_setpoint", "position[0]", "number")
    last = np.flatnonzero(np.diff(goal[:, 0]) > 4.0)[-1] + 1
    time, x = columns(log, "vehicle_local_position", "x")
    during = (time >= goal_time[last]) & (time < goal_time[last] + 12.0)
    error = x[during, 0] - goal[last, 0]
    settled = time[during][np.abs(error) > 0.3].max() - goal_time[last]
    assert settled < 6.0
    assert error.max() < 0.5


def test_a_plan_of_a_ground_station_is_flown(tmp_path: Path) -> None:
    """In the place on Earth where it was planned: a waypoint 30 m north, and a landing there."""
    degree_m = 111_200.0  # of latitude at 59 degrees north, roughly: the radius is 6,372 km
    north = 59.0 + 30.0 / degree_m
    items = [
        [22, [0, 0, 0, None, 0, 0, 6]],
        [16, [1, 0, 0, None, north, 10.0, 6]],
        [21, [0, 0, 0, None, north, 10.0, 0]],
    ]
    plan = {
        "fileType": "Plan",
        "mission": {
            "plannedHomePosition": [59.0, 10.0, 100.0],
            "items": [
                {"type": "SimpleItem", "command": command, "frame": 3, "params": params}
                for command, params in items
            ],
        },
    }
    file = tmp_path / "flight.plan"
    file.write_text(json.dumps(plan), encoding="utf-8")
    facts = fly(str(file.with_suffix("")), tmp_path / "flight.ulg", "--mission", str(file))
    assert facts["success"], facts["reason"]
    _, position, _ = truth(facts)
    assert position[-1, 0] == pytest.approx(30.0, abs=1.5)
    assert position[-1, 1] == pytest.approx(0.0, abs=1.5)


def fly_plan(name: str, log: Path, *arguments: str) -> dict[str, Any]:
    return fly("square", log, "--mission", str(PLANS / name), *arguments)


def test_a_return_leads_to_the_nearest_rally_point(tmp_path: Path) -> None:
    facts = fly_plan("rally.plan", tmp_path / "flight.ulg")
    assert facts["success"], facts["reason"]
    assert facts["landing_error_m"] < 1.0  # from the rally point
    _, position, _ = truth(facts)
    assert position[-1, :2] == pytest.approx([70.0, 60.0], abs=2.0)


def test_without_autocontinue_it_waits_and_then_returns(tmp_path: Path) -> None:
    facts = fly_plan("autocontinue.plan", tmp_path / "flight.ulg")
    assert facts["success"], facts["reason"]
    assert modes(facts)[1:-1] == ["mission", "hold", "return", "landing"]
    begin, end = (facts["modes"][i]["time_s"] for i in (2, 3))
    assert end - begin == pytest.approx(30.0, abs=0.1)
    _, position, _ = truth(facts)
    assert position[:, 1].max() < 5.0, "it never flew to the third item, 20 m east"
    assert "without autocontinue" in facts["mission_notes"][0]


def test_a_mission_that_ends_in_the_air_returns(tmp_path: Path) -> None:
    facts = fly_plan("no_end.plan", tmp_path / "flight.ulg")
    assert facts["success"], facts["reason"]
    assert modes(facts)[1:-1] == ["mission", "hold", "return", "landing"]
    assert "no landing at the end" in facts["mission_notes"][0]


def test_each_speed_has_its_direction(tmp_path: Path) -> None:
    """3 m/s over ground; then up with 0.8 m/s; then down with 0.6 m/s."""
    log = tmp_path / "flight.ulg"
    facts = fly_plan("speeds.plan", log)
    assert facts["success"], facts["reason"]
    time, velocity = columns(log, "trajectory_setpoint", *(f"velocity[{i}]" for i in range(3)))
    reached = {item["number"]: item["reached_s"] for item in facts["items"]}

    def between(first: int, last: int) -> np.ndarray:
        rows: np.ndarray = velocity[(time > reached[first]) & (time < reached[last])]
        return rows

    # A setpoint that begins before the one before has come to rest adds to it a little.
    assert np.hypot(*between(1, 3)[:, :2].T).max() == pytest.approx(3.0, abs=0.05)
    assert -between(3, 5)[:, 2].min() == pytest.approx(0.8, abs=0.05)
    assert between(5, 7)[:, 2].max() == pytest.approx(0.6, abs=0.05)


def test_loiter_turns_are_circles(tmp_path: Path) -> None:
    """Two turns of 5 m about a place 20 m north."""
    log = tmp_path / "flight.ulg"
    fly_plan("loiters.plan", log, "--duration", "60")
    time, setpoint = columns(log, "trajectory_setpoint", "position[0]", "position[1]")
    goal_time, goal = columns(log, "goto_setpoint", "kind", "position[0]", "position[1]")
    circle = np.flatnonzero(goal[:, 0] == 4)
    rows = (time > goal_time[circle[0]] + 0.05) & (time < goal_time[circle[-1]])
    out = setpoint[rows] - goal[circle[0], 1:]
    assert np.hypot(*out.T) == pytest.approx(5.0, abs=0.05)
    turned = np.unwrap(np.arctan2(out[:, 1], out[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(4 * np.pi, abs=0.2), "clockwise, from above"


def test_it_looks_at_the_region_of_interest(tmp_path: Path) -> None:
    """15 m north and 10 m east of home, on the way from home to a place 30 m north."""
    log = tmp_path / "flight.ulg"
    facts = fly_plan("region_of_interest.plan", log)
    assert facts["success"], facts["reason"]
    reached = {item["number"]: item["reached_s"] for item in facts["items"]}
    time, position, _ = truth(facts)
    yaw_time, yaw = columns(log, "trajectory_setpoint", "yaw")
    for at in np.arange(reached[1] + 3.0, reached[3], 0.5):
        here = position[np.searchsorted(time, at)] - position[0]
        wanted = np.arctan2(10.0 - here[1], 15.0 - here[0])
        off = yaw[np.searchsorted(yaw_time, at), 0] - wanted
        assert abs(np.arctan2(np.sin(off), np.cos(off))) < 0.35


def test_a_thousand_items_begin_to_be_flown(tmp_path: Path) -> None:
    """Places 2 m apart, round and round a square of 20 m. All are looked at before it arms."""
    items = ["takeoff: {height: 6 m}"]
    for i in range(998):
        side, step = divmod(i % 40, 10)
        along = 2 * step
        north, east = ((along, 0), (20, along), (20 - along, 20), (0, 20 - along))[side]
        items.append(f"waypoint: {{north: {north} m, east: {east} m, radius: 1.5 m, speed: 5 m/s}}")
    file = tmp_path / "dense.yaml"
    text = "".join(f"  - {item}\n" for item in [*items, "return"])
    file.write_text(f"items:\n{text}", encoding="utf-8")
    assert len(read_mission(file).items) == 1001  # one for the speed
    facts = fly("square", tmp_path / "flight.ulg", "--mission", str(file), "--duration", "100")
    assert facts["modes"][1]["mode"] == "mission"
    assert facts["modes"][1]["time_s"] < 6.0
    assert facts["items_total"] == 999
    assert facts["items_reached"] > 90
    assert facts["corridor_m"] < 2.5


def test_the_duration_is_that_of_the_mission(tmp_path: Path) -> None:
    """12 laps of 40 m at 6 m/s take 356 s: 2 pi sqrt(2) 20 m / 6 m/s each."""
    file = tmp_path / "eight.yaml"
    eight = "eight: {length: 40 m, laps: 12, speed: 6 m/s}"
    file.write_text(f"items: [takeoff: {{height: 10 m}}, {eight}, return]", encoding="utf-8")
    facts = fly("square", tmp_path / "flight.ulg", "--mission", str(file), "--no-record")
    assert facts["success"], facts["reason"]
    assert facts["duration_s"] > 380.0


def test_a_landing_far_from_its_place_is_no_success(tmp_path: Path) -> None:
    """The mission has no limit for it: satellites that are 40 m off while it lands."""
    file = tmp_path / "plain.yaml"
    file.write_text("items: [takeoff: {height: 10 m}, waypoint: {north: 9 m}, return]\n")
    options = ("--mission", str(file), "--fail", "gnss_glitch=40@12")
    facts = fly("square", tmp_path / "flight.ulg", *options)
    assert not facts["success"]
    assert "landing error" in facts["reason"]
    assert "(limit 5 m)" in facts["reason"]


@pytest.mark.parametrize(
    ("items", "message"),
    [
        ("waypoint: {north: 501 m}", "item 2, waypoint: expected a distance of at most 500 m"),
        ("waypoint: {height: 121 m}", "item 2, waypoint: expected a height of at most 120 m"),
    ],
)
def test_what_the_fence_of_the_graph_forbids_does_not_take_off(
    items: str, message: str, tmp_path: Path
) -> None:
    file = tmp_path / "mission.yaml"
    file.write_text(f"items: [takeoff: {{height: 5 m}}, {items}, return]", encoding="utf-8")
    command = [ROOT / "stator", "fly", "--mission", file]
    finished = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    assert finished.returncode == 2
    assert message in finished.stderr


def test_the_same_seed_flies_the_same_mission_again(tmp_path: Path) -> None:
    logs = [
        fly("square", tmp_path / name, "--wind", "5", "--duration", "20")["log_sha256"]
        for name in ("a.ulg", "b.ulg")
    ]
    assert logs[0] == logs[1]


def test_the_speed_does_not_change_the_flight(tmp_path: Path) -> None:
    logs = [
        fly("square", tmp_path / name, "--duration", "6", *more)["log_sha256"]
        for name, more in (("a.ulg", ("--speed", "20")), ("b.ulg", ()))
    ]
    assert logs[0] == logs[1]


# --- failsafes: what happens, and that it ends on the ground ---


def assert_comes_down(facts: dict[str, Any], event: str, expected: list[str]) -> None:
    assert modes(facts) == ["disarmed", *expected, "disarmed"]
    assert facts["modes"][2]["failsafe"] == event
    assert not facts["success"]
    assert f"failsafe {event}" in facts["reason"]
    assert "not landed" not in facts["reason"]
    assert "on its side" not in facts["reason"]
    assert facts["touchdown_m_s"] < 1.0


@pytest.mark.parametrize(
    ("fault", "event", "expected"),
    [
        ("rc_loss@20", "rc_lost", ["mission", "return", "landing"]),
        ("battery_low=0.1@20", "battery_low", ["mission", "return", "landing"]),
        ("battery_low=0.06@20", "battery_critical", ["mission", "landing"]),
        ("mission_loss@20", "mission_lost", ["mission", "return", "landing"]),
        ("gnss_loss@20", "position_lost", ["mission", "descend"]),
    ],
)
def test_fault_in_a_mission(fault: str, event: str, expected: list[str], tmp_path: Path) -> None:
    facts = fly("square", tmp_path / "flight.ulg", "--fail", fault)
    assert_comes_down(facts, event, expected)
    if expected[-2:] == ["return", "landing"]:
        assert facts["landing_error_m"] < 1.0


def test_short_faults_are_flown_through(tmp_path: Path) -> None:
    """Sticks that are gone for less than half a second, and satellites for 3 s."""
    faults = ("--fail", "rc_loss@15+0.3", "--fail", "gnss_loss@20+3")
    facts = fly("square", tmp_path / "flight.ulg", *faults)
    assert facts["success"], facts["reason"]


def test_without_position_it_descends_nearly_level(tmp_path: Path) -> None:
    facts = fly("hover", tmp_path / "flight.ulg", "--fail", "gnss_loss@30")
    assert_comes_down(facts, "position_lost", ["mission", "descend"])
    time, _, tilt = truth(facts)
    begin = facts["modes"][2]["time_s"]
    assert begin - 30.0 < 7.0  # dead reckoning is believed for 5 s, and the loss for half a second
    falling = (time > begin + 1.0) & (time < facts["touchdown_s"] - 0.1)
    assert tilt[falling].max() < 10.0


def test_without_an_estimate_it_descends(tmp_path: Path) -> None:
    """Neither satellites nor pressure: nothing says how high it is."""
    facts = fly("hover", tmp_path / "f.ulg", "--fail", "gnss_loss@30", "--fail", "baro_loss@30")
    assert modes(facts)[:3] == ["disarmed", "mission", "descend"]
    _, position, _ = truth(facts)
    assert position[-1, 2] > -0.2
    assert facts["touchdown_m_s"] < 3.0
    assert modes(facts)[-1] == "disarmed"


def test_outside_the_fence_it_turns_back(tmp_path: Path) -> None:
    """The pilot flies away in position mode; the mission brings the fence, 60 m."""
    pilot = tmp_path / "pilot.txt"
    rows = ["0 0 0 0 0 3 0 0 0", "8 0 0 0 0 3 1 0 0", "10 0 0 0 1 3 1 0 0", "15 0 1 0 0 3 1 0 0"]
    pilot.write_text("\n".join(rows) + "\n", encoding="utf-8")
    facts = fly("square", tmp_path / "flight.ulg", "--pilot", str(pilot))
    assert_comes_down(facts, "geofence", ["position", "return", "landing"])
    _, position, _ = truth(facts)
    assert 59.0 < np.hypot(position[:, 0], position[:, 1]).max() < 70.0
    assert facts["landing_error_m"] < 1.0


def test_before_an_area_that_excludes_it_turns_back(tmp_path: Path) -> None:
    """By hand to where the plan excludes a circle of 25 m: the nose of seed 1 points there."""
    home, middle = (47.397742, 8.545594), (33.0, 73.0)
    metre_east = 1.0 / (111_183.0 * np.cos(np.radians(home[0])))
    center = [home[0] + middle[0] / 111_183.0, home[1] + middle[1] * metre_east]
    circle = {"center": center, "radius": 25.0}
    take_off = {
        "type": "SimpleItem", "autoContinue": True, "command": 22, "doJumpId": 1, "frame": 3,
        "params": [0, 0, 0, None, 0, 0, 6],
    }  # fmt: skip
    plan = {
        "fileType": "Plan", "version": 1, "groundStation": "QGroundControl",
        "geoFence": {
            "circles": [{"circle": circle, "inclusion": False, "version": 1}],
            "polygons": [], "version": 2,
        },
        "rallyPoints": {"points": [], "version": 2},
        "mission": {
            "version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 5,
            "plannedHomePosition": [*home, 488.0], "items": [take_off],
        },
    }  # fmt: skip
    file = tmp_path / "excluded.plan"
    file.write_text(json.dumps(plan), encoding="utf-8")
    pilot = tmp_path / "pilot.txt"
    rows = ["0 0 0 0 0 3 0 0 0", "8 0 0 0 0 3 1 0 0", "10 0 0 0 1 3 1 0 0", "15 0 1 0 0 3 1 0 0"]
    pilot.write_text("\n".join(rows) + "\n", encoding="utf-8")
    arguments = ["--mission", str(file), "--pilot", str(pilot)]
    facts = fly("square", tmp_path / "flight.ulg", *arguments)
    assert_comes_down(facts, "geofence", ["position", "return", "landing"])
    _, position, _ = truth(facts)
    nearest = np.hypot(position[:, 0] - middle[0], position[:, 1] - middle[1]).min()
    assert 15.0 < nearest < 25.5
    assert facts["broken_invariant"] is None


# --- by hand ---


def test_by_hand_the_sticks_are_the_attitude(tmp_path: Path) -> None:
    """Mode slot 2 is altitude, 5 mission, 4 hold. Sideways at full stick, then hold, then down."""
    pilot = tmp_path / "pilot.txt"
    rows = [
        "0 0 0 0 -1 2 0 0 0", "8 0 0 0 -1 2 1 0 0", "9 0 0 0 1 2 1 0 0", "13 0 0 0 0 2 1 0 0",
        "15 0 0.5 0 0 2 1 0 0", "18 0 0 0 0 4 1 0 0", "25 0 0 0 0 6 1 0 0",
    ]  # fmt: skip
    pilot.write_text("\n".join(rows) + "\n", encoding="utf-8")
    facts = fly("square", tmp_path / "flight.ulg", "--pilot", str(pilot))
    assert modes(facts) == ["disarmed", "altitude", "hold", "landing", "disarmed"]
    time, _, tilt = truth(facts)
    # Half stick of 0.4 rad: the tangent of the tilt is half that of 22.9 deg.
    assert tilt[(time > 16) & (time < 17.5)].mean() == pytest.approx(11.9, abs=2.0)
    assert facts["touchdown_m_s"] < 1.0
