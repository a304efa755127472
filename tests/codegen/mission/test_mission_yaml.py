"""Missions in YAML: what they mean, and what is said of a wrong one."""

from __future__ import annotations

from pathlib import Path

import pytest

from stator import HOME
from stator.diagnostics import Failed, UserError
from stator.mission.commands import (
    CHANGE_SPEED,
    EIGHT,
    LAND,
    LOCAL,
    LOITER_UNLIMITED,
    RELATIVE,
    RETURN,
    TAKEOFF,
    WAYPOINT,
)
from stator.mission.model import MAX_ITEMS, Mission
from stator.mission.read import read_mission
from stator.mission.vehicle import Vehicle


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
    # A speed is an item of its own.
    flown = [item for item in mission.items if item.command != CHANGE_SPEED]
    commands = [item.command for item in flown]
    assert commands == [TAKEOFF, WAYPOINT, WAYPOINT, WAYPOINT, EIGHT, LAND]
    places = [(item.x, item.y, item.z) for item in flown]
    assert places == [(0, 0, 5), (20, 0, 5), (20, 10, 7), (20, 10, 7), (20, 10, 7), (20, 10, 7)]
    assert {item.frame for item in flown} == {LOCAL}
    assert flown[1].params == (2.0, 2.0, 0.0, pytest.approx(90.0))
    assert flown[2].params[0] == 0.0  # flies on
    assert flown[3].params[0] == 60.0
    assert flown[4].params[:3] == (5.0, 2.5, 3.0)
    speeds = [(n, i.params[1]) for n, i in enumerate(mission.items) if i.command == CHANGE_SPEED]
    assert speeds == [(1, 5.0), (3, -2.0), (6, 5.0)]
    assert [item.number for item in flown] == [1, 2, 3, 4, 5, 6]


def test_a_loiter_without_time_lasts(tmp_path: Path) -> None:
    mission = read("items: [takeoff: {height: 5 m}, loiter: {}]", tmp_path)
    assert mission.items[1].command == LOITER_UNLIMITED
    assert mission.notes == (
        "it has no end: it goes on until the pilot or a failsafe ends it; "
        "hint: end it with a return",
    )


def test_origin_fence_and_limits(tmp_path: Path) -> None:
    mission = read(
        """
        origin: {latitude: 47.4 deg, longitude: 8.5 deg}
        fence: {radius: 50 m, height: 20 m}
        items: [takeoff: {height: 5 m}, waypoint: {north: 20 m}, return]
        limits: {corridor: 2 m, touchdown_speed: 80 cm/s}
        """,
        tmp_path,
    )
    assert mission.home is not None
    assert (mission.home.latitude, mission.home.longitude) == (47.4, 8.5)
    assert (mission.areas[0].radius, mission.ceiling) == (50.0, 20.0)
    assert mission.limits == {"corridor": 2.0, "touchdown_speed": 0.8}
    assert mission.items[1].frame == RELATIVE
    # A degree of latitude is 111,183 m there.
    assert mission.items[1].x == pytest.approx(47.4 + 20.0 / 111_183.0, abs=1e-7)
    assert mission.items[2].command == RETURN


def test_a_landing_at_another_height_goes_there_first(tmp_path: Path) -> None:
    mission = read("items: [takeoff: {height: 5 m}, land: {north: 9 m, height: 8 m}]", tmp_path)
    assert [item.command for item in mission.items] == [TAKEOFF, WAYPOINT, LAND]
    assert mission.items[1].z == 8.0
    assert not mission.items[1].is_reached
    assert {item.number for item in mission.items[1:]} == {2}


def test_it_is_held_against_the_limits_of_the_vehicle(tmp_path: Path) -> None:
    vehicle = Vehicle(fence_radius=500.0, fence_height=120.0, farthest=1000.0)
    for items, message in (
        ("waypoint: {north: 501 m}", "at most 500 m (the fence of the vehicle, navigator.fence_r"),
        ("waypoint: {height: 121 m}", "at most 120 m (the fence of the vehicle, navigator.fence_h"),
    ):
        file = tmp_path / "mission.yaml"
        file.write_text(f"items: [takeoff: {{height: 5 m}}, {items}]", encoding="utf-8")
        with pytest.raises(UserError, match="item 2, waypoint: expected") as refused:
            read_mission(file, vehicle)
        assert message in str(refused.value)
    fenced = "fence: {radius: 1500 m}\nitems: [takeoff: {height: 5 m}, waypoint: {north: 600 m}]"
    file.write_text(fenced, encoding="utf-8")
    assert read_mission(file, vehicle)
    file.write_text(fenced.replace("600", "1001"), encoding="utf-8")
    with pytest.raises(UserError, match=r"at most 1000 m \(navigator.farthest\), found 1001.0 m"):
        read_mission(file, vehicle)


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
            f"expected at most {MAX_ITEMS} items, found {MAX_ITEMS + 1}",
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
