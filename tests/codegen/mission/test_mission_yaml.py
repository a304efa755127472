"""Missions in YAML: what they mean, and what is said of a wrong one."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import pytest

from stator import HOME
from stator.diagnostics import Failed, UserError
from stator.mission.model import (
    EIGHT,
    FOREVER_S,
    LAND,
    MAX_ITEMS,
    RETURN,
    TAKEOFF,
    WAYPOINT,
    Mission,
    packed,
)
from stator.mission.read import read_mission


def read(text: str, folder: Path) -> Mission:
    file = folder / "mission.yaml"
    file.write_text(text, encoding="utf-8")
    return read_mission(file)


def refusal(text: str, folder: Path) -> str:
    try:
        read(text, folder)
    except Failed as failed:
        return "\n".join(error.text() for error in failed.errors)
    except UserError as failed:
        return str(failed)
    raise AssertionError("it was taken")


def test_items_take_place_and_height_from_the_one_before(tmp_path: Path) -> None:
    mission = read(
        """
        items:
          - takeoff: {height: 500 cm}
          - waypoint: {north: 20 m, heading: 90 deg, hold: 2 s, speed: 18 km/h, radius: 2 m}
          - waypoint: {east: 0.01 km, height: 7 m}
          - loiter: {time: 1 min}
          - eight: {length: 10 m, laps: 3, speed: 5 m/s}
          - land
        """,
        tmp_path,
    )
    kinds = [item.kind for item in mission.items]
    assert kinds == [TAKEOFF, WAYPOINT, WAYPOINT, WAYPOINT, EIGHT, LAND]
    places = [(item.north, item.east, item.height) for item in mission.items]
    assert places == [(0, 0, 5), (20, 0, 5), (20, 10, 7), (20, 10, 7), (20, 10, 7), (20, 10, 7)]
    second = mission.items[1]
    assert second.heading == pytest.approx(math.pi / 2)
    assert (second.hold, second.speed, second.radius) == (2.0, 5.0, 2.0)
    assert mission.items[2].hold == 0.0  # flies on
    assert mission.items[3].hold == 60.0
    assert (mission.items[4].radius, mission.items[4].hold) == (10.0, 3.0)
    assert math.isnan(mission.items[2].speed)


def test_a_loiter_without_time_lasts(tmp_path: Path) -> None:
    mission = read("items: [takeoff: {height: 5 m}, loiter: {}]", tmp_path)
    assert mission.items[1].hold == FOREVER_S


def test_origin_fence_and_limits(tmp_path: Path) -> None:
    mission = read(
        """
        origin: {latitude: 47.4 deg, longitude: 8.5 deg}
        fence: {radius: 50 m, height: 20 m}
        items: [takeoff: {height: 5 m}, return]
        limits: {corridor: 2 m, touchdown_speed: 80 cm/s}
        """,
        tmp_path,
    )
    assert mission.origin == (47.4, 8.5)
    assert (mission.fence_radius, mission.fence_height) == (50.0, 20.0)
    assert mission.limits == {"corridor": 2.0, "touchdown_speed": 0.8}
    assert mission.items[1].kind == RETURN


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("items: []", "expected a list of at least 1 item, found 0"),
        ("items: [return]", "item 1, return: expected a takeoff as the first item"),
        (
            "items: [takeoff: {height: 5}]",
            "expected a number with its unit for 'height', found '5'",
        ),
        ("items: [takeoff: {}]", "missing key 'height'"),
        ("items: [takeoff: {height: 5 m}, wait: {}]", "unknown item 'wait'"),
        ("items: [takeoff: {height: 5 m}, waypoint: {nort: 5 m}]", "did you mean 'north'?"),
        ("items: [takeoff: {height: 5 m}, takeoff: {height: 5 m}]", "duplicate takeoff"),
        (
            "items: [takeoff: {height: 5 m}, land, return]",
            "item 3, return: never reached: the item before it ends the mission",
        ),
        (
            "items: [takeoff: {height: 5 m}, loiter: {}, return]",
            "item 3, return: never reached",
        ),
        ("items: [takeoff: {height: 5 m}, eight: {length: 10 m}]", "missing key 'speed'"),
        ("items: [takeoff: {height: 5 m}, waypoint: {speed: 99 m/s}]", "99"),
        ("items: 5", "expected a list, found '5'"),
        ("items: [takeoff: {height: 5 m}]\nlimits: {colour: 5 m}", "unknown key 'colour'"),
        (
            f"items: [takeoff: {{height: 5 m}}{', waypoint: {}' * MAX_ITEMS}]",
            "expected at most 31 items, found 32",
        ),
    ],
)
def test_wrong_missions_are_refused(text: str, message: str, tmp_path: Path) -> None:
    assert message in refusal(text, tmp_path)


FENCED = "fence: {radius: 50 m, height: 20 m}\nitems: [takeoff: {height: 5 m}, "


@pytest.mark.parametrize(
    ("items", "message"),
    [
        (
            "waypoint: {north: 51 m}]",
            "item 2, waypoint: expected a distance of at most 50 m (the fence), found 51.0 m",
        ),
        (
            "land: {north: 51 m}]",
            "item 2, land: expected a distance of at most 50 m (the fence), found 51.0 m",
        ),
        (
            "land: {height: 21 m}]",
            "item 2, land: expected a height of at most 20 m (the fence), found 21 m",
        ),
        (
            "waypoint: {height: 21 m}]",
            "item 2, waypoint: expected a height of at most 20 m (the fence), found 21 m",
        ),
        (
            "eight: {north: 45 m, length: 12 m, speed: 3 m/s}]",
            "item 2, figure of eight: expected a distance of at most 50 m (the fence), found 51",
        ),
    ],
)
def test_what_leaves_the_fence_is_named(items: str, message: str, tmp_path: Path) -> None:
    said = refusal(FENCED + items, tmp_path)
    assert message in said
    assert "or enlarge the fence" in said


def test_a_take_off_above_the_fence_is_named(tmp_path: Path) -> None:
    text = "fence: {height: 4 m}\nitems: [takeoff: {height: 5 m}]"
    assert "item 1, takeoff: expected a height of at most 4 m (the fence), found 5 m" in refusal(
        text, tmp_path
    )


def test_what_no_vehicle_may_reach_is_refused(tmp_path: Path) -> None:
    text = "items: [takeoff: {height: 5 m}, land: {north: 9 km, east: 9 km}]"
    assert "item 2, land: expected a distance of at most 10 km, found 13 km" in refusal(
        text, tmp_path
    )


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"cannot read the mission '.*none.yaml'"):
        read_mission(tmp_path / "none.yaml")


@pytest.mark.parametrize("file", sorted((HOME / "graph" / "missions").glob("*.yaml")))
def test_the_missions_of_the_project_are_good(file: Path) -> None:
    assert len(read_mission(file).items) >= 2


def test_bytes_are_those_of_the_message(tmp_path: Path) -> None:
    """Offsets by hand from graph/messages/Mission.yaml: timestamp, origin (two doubles), the fence
    (two floats), count, 31 kinds, then seven times 31 floats."""
    data = packed(read("items: [takeoff: {height: 5 m}, waypoint: {north: 3 m}]", tmp_path))
    assert len(data) % 8 == 0
    latitude, longitude = struct.unpack_from("<2d", data, 8)
    assert math.isnan(latitude)
    assert math.isnan(longitude)
    assert data[32] == 2
    assert list(data[33:36]) == [TAKEOFF, WAYPOINT, 0]
    assert struct.unpack_from("<3f", data, 64) == (0.0, 3.0, 0.0)  # north
    assert struct.unpack_from("<2f", data, 64 + 2 * 31 * 4) == (5.0, 5.0)  # height
