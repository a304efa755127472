"""Missions as ground stations save them. The files are laid out as QGroundControl's documentation
of the format (file_formats/plan) has it; commands and frames are MAVLink's."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stator.diagnostics import UserError
from stator.mission.commands import (
    CHANGE_SPEED,
    EIGHT,
    JUMP,
    LAND,
    LOITER_TO_ALTITUDE,
    RETURN,
    TAKEOFF,
    WAYPOINT,
)
from stator.mission.geodesy import from_local, to_local
from stator.mission.model import MAX_ITEMS, Mission
from stator.mission.read import read_mission
from stator.mission.route import seconds_of, walk
from stator.mission.vehicle import Vehicle

PLANS = Path(__file__).parent / "plans"
HOME = [47.397742, 8.545594, 488.0]
DEGREE_M = 111_183.0  # of latitude there
NORTH = 47.397742 + 20.0 / DEGREE_M
VEHICLE = Vehicle(fence_radius=500.0, fence_height=120.0, farthest=1000.0)


def item(command: int, *params: float | None, frame: int = 3, **more: Any) -> dict[str, Any]:
    """The last of `params` are latitude, longitude and altitude."""
    return {
        "type": "SimpleItem", "autoContinue": True, "command": command, "doJumpId": 1,
        "frame": frame, "params": list(params), **more,
    }  # fmt: skip


TAKE_OFF = item(22, 0, 0, 0, None, 0, 0, 6)


def plan(*items: Any, **more: Any) -> dict[str, Any]:
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "geoFence": {"circles": [], "polygons": [], "version": 2},
        "rallyPoints": {"points": [], "version": 2},
        "mission": {
            "version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 5,
            "plannedHomePosition": HOME, "items": list(items), **more.pop("mission", {}),
        },
        **more,
    }  # fmt: skip


def read(content: Any, folder: Path, vehicle: Vehicle = VEHICLE) -> Mission:
    file = folder / "flight.plan"
    text = content if isinstance(content, str) else json.dumps(content)
    file.write_text(text, encoding="utf-8")
    return read_mission(file, vehicle)


def refusal(content: Any, folder: Path) -> str:
    with pytest.raises(UserError) as refused:
        read(content, folder)
    text = str(refused.value)
    assert text.count("hint: ") == text.count("error: ")
    return text


def way(*params: float | None, frame: int = 3) -> dict[str, Any]:
    return item(16, *params, frame=frame)


# --- files of each kind, in plans/ ---


def kept(name: str) -> Mission:
    return read_mission(PLANS / name, VEHICLE)


def corners(mission: Mission) -> list[tuple[float, float, float]]:
    """The places that it flies to, north and east of home, and the height."""
    return [
        (round(v.place.north, 1) + 0.0, round(v.place.east, 1) + 0.0, round(v.place.height, 1))
        for v in walk(mission, VEHICLE).visits
        if v.item.command != RETURN
    ]


def assert_leads(mission: Mission, places: list[Any]) -> None:
    found = corners(mission)
    assert len(found) == len(places), found
    assert np.allclose(found, places, atol=0.1), found


SQUARE = [(0, 0, 10), (20, 0, 10), (20, 20, 10)]


@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("mission_planner.waypoints", SQUARE),
        ("windows.waypoints", SQUARE),
        ("blanks.waypoints", SQUARE),
        ("null_home_altitude.waypoints", SQUARE),
        # Without home it counts from the first place: the take-off has none.
        ("no_home.waypoints", [(0, 0, 10), (0, 0, 10), (0, 20, 10)]),
        ("first_version.mission", SQUARE[:2]),
        ("null_home.plan", SQUARE[:2]),
        ("above_sea.plan", [(0, 0, 10), (20, 0, 12)]),
        ("spline.plan", [*SQUARE, (0, 20, 10)]),
        ("survey.plan", [(0, 0, 10), (10, 0, 12), (30, 0, 12), (30, 10, 12), (10, 10, 12)]),
        ("corridor_scan.plan", [(0, 0, 10), (5, 5, 10), (25, 5, 10), (25, 10, 10), (5, 10, 10)]),
        ("landing_pattern.plan", [*SQUARE[:2], (30, 30, 15), (0, 5, 15)]),
        ("vtol.plan", [(0, 0, 10), (30, 0, 10), (20, 0, 10)]),
        ("jumps.plan", [*SQUARE, *SQUARE[1:], *SQUARE[1:]]),
        ("jump_by_index.waypoints", [*SQUARE, *SQUARE[1:], (0, 0, 10)]),
        ("autocontinue.plan", SQUARE[:2]),
        ("no_end.plan", SQUARE[:2]),
        ("no_take_off.plan", [(20, 0, 8)]),
        ("altitudes.plan", [(0, 0, 10), (10, 0, 10), (10, 0, 16), (10, 0, 12)]),
        ("loiters.plan", [*SQUARE, (0, 20, 16), (0, 10, 12)]),
        ("fence.plan", [(0, 0, 10), (20, 0, 10), (20, 40, 10), (0, 40, 10)]),
        ("rally.plan", [(0, 0, 10), (60, 0, 10), (60, 60, 10)]),
        ("speeds.plan", [(0, 0, 10), (30, 0, 10), (30, 10, 16), (0, 10, 10)]),
        ("region_of_interest.plan", [(0, 0, 10), (30, 0, 10), (30, 20, 10), (0, 20, 10)]),
        ("camera.plan", SQUARE),
        (
            "delays.plan",
            [(0, 0, 10), (0, 0, 10), (20, 0, 10), (40, 0, 10), (20, 20, 10), (0, 20, 10)],
        ),
    ],
)
def test_a_plan_leads_where_it_was_planned(name: str, places: list[tuple[float, ...]]) -> None:
    assert_leads(kept(name), places)


def test_each_plan_has_its_test_and_a_time() -> None:
    for file in PLANS.iterdir():
        assert 40.0 < seconds_of(read_mission(file, VEHICLE), VEHICLE) < 200.0, file


def test_a_structure_scan_goes_round_its_polygon_layer_by_layer() -> None:
    """The polygon is 10 m wide, from 20 m to 30 m north; it stays 6 m away from it. Layers of 4 m
    from 6 m on: at 8 m and 12 m. In and out at 20 m."""
    mission = kept("structure_scan.plan")
    ring = [(14, -6), (36, -6), (36, 16), (14, 16), (14, -6)]
    expected = [(0, 0, 10), (14, -6, 20)]
    expected += [(*place, height) for height in (8, 12) for place in ring]
    expected += [(14, -6, 20)]
    assert_leads(mission, expected)
    # The nose points at the middle, 25 m north and 5 m east.
    assert mission.items[2].params[3] == pytest.approx(45.0, abs=0.2)


def test_what_no_device_does_is_kept_and_said() -> None:
    mission = kept("camera.plan")
    assert [i.command for i in mission.items[1:4]] == [530, 206, 2000]
    said = "\n".join(mission.notes)
    assert "item 3: camera trigger distance: passed by, as this vehicle has no camera" in said
    assert "item 7: gimbal pitch and yaw: passed by, as this vehicle has no gimbal" in said
    assert "item 13: set servo: passed by, as this vehicle has no servo" in said
    survey = "\n".join(kept("survey.plan").notes)
    assert "item 3, point 2, item 3, point 6: camera trigger distance" in survey


def test_what_ends_without_a_landing_is_said() -> None:
    assert "no landing at the end: it holds there, then returns" in kept("no_end.plan").notes[0]
    assert kept("autocontinue.plan").notes == (
        "item 2: without autocontinue, the mission waits behind it",
    )
    assert "it has no end" in kept("loiters.plan").notes[-1]
    assert kept("jumps.plan").notes == ()


def test_a_jump_names_its_item_as_the_file_does() -> None:
    jumps = [i.params[:2] for i in kept("jumps.plan").items if i.command == JUMP]
    assert jumps == [(1.0, 2.0)]  # counted from 0
    jumps = [i.params[:2] for i in kept("jump_by_index.waypoints").items if i.command == JUMP]
    assert jumps == [(1.0, 1.0)]


def test_fence_and_rally_points() -> None:
    mission = kept("fence.plan")
    kinds = [(area.includes, len(area.places), area.radius) for area in mission.areas]
    assert kinds == [(True, 1, 120.0), (False, 1, 10.0), (False, 4, 0.0)]
    assert [point[2] for point in kept("rally.plan").rally] == [12.0, 12.0]


def test_heading_0_of_ardupilot_is_none(tmp_path: Path) -> None:
    """Its waypoints have no heading, and its programs write 0."""
    assert math.isnan(kept("mission_planner.waypoints").items[1].params[3])
    waypoint = way(0, 0, 0, 0, NORTH, HOME[1], 8)
    assert read(plan(TAKE_OFF, waypoint), tmp_path).items[1].params[3] == 0.0
    ardupilot = plan(TAKE_OFF, waypoint, mission={"firmwareType": 3})
    assert math.isnan(read(ardupilot, tmp_path).items[1].params[3])


# --- single fields ---


def test_every_field_of_an_item(tmp_path: Path) -> None:
    mission = read(
        plan(
            TAKE_OFF,
            item(178, 1, 3.5, -1, 0, 0, 0, 0, frame=2),
            way(2, 1.5, 0, 90, NORTH, HOME[1], 8),
            item(35, 10, 5, 0, 0, HOME[0], HOME[1], 9),
            item(20, 0, 0, 0, 0, 0, 0, 0, frame=2),
        ),
        tmp_path,
    )
    commands = [i.command for i in mission.items]
    assert commands == [TAKEOFF, CHANGE_SPEED, WAYPOINT, EIGHT, RETURN]
    assert mission.home is not None
    assert mission.home.altitude == HOME[2]
    assert mission.items[1].params[:2] == (1.0, 3.5)
    assert mission.items[2].params == (2.0, 1.5, 0.0, 90.0)
    assert (mission.items[2].x, mission.items[2].y, mission.items[2].z) == (NORTH, HOME[1], 8.0)
    assert mission.items[3].params[0] == 10.0


def test_a_fixed_wing_landing_pattern_is_flown_too(tmp_path: Path) -> None:
    pattern = {
        "type": "ComplexItem", "complexItemType": "fwLandingPattern", "useLoiterToAlt": True,
        "landCoordinate": [*HOME[:2], 0], "landingApproachCoordinate": [NORTH, HOME[1], 30],
    }  # fmt: skip
    mission = read(plan(TAKE_OFF, pattern), tmp_path)
    assert [i.command for i in mission.items] == [TAKEOFF, 189, LOITER_TO_ALTITUDE, LAND]


def test_ten_thousand_items_are_read(tmp_path: Path) -> None:
    ring = [
        way(0, 0, 0, None, HOME[0] + 1e-4 * math.sin(i), HOME[1] + 1e-4 * math.cos(i), 8)
        for i in range(MAX_ITEMS - 2)
    ]
    end = item(20, 0, 0, 0, 0, 0, 0, 0, frame=2)
    assert len(read(plan(TAKE_OFF, *ring, end), tmp_path).items) == MAX_ITEMS
    said = refusal(plan(TAKE_OFF, *ring, ring[0], end), tmp_path)
    assert f"item {MAX_ITEMS + 1}: expected at most {MAX_ITEMS} items, found 10001" in said


def test_all_errors_come_at_once_and_in_order(tmp_path: Path) -> None:
    said = refusal(
        plan(
            TAKE_OFF,
            item(179, 1, 0, 0, 0, 0, 0, 0),
            way(0, 0, 0, None, NORTH, HOME[1], 8, frame=10),
            item(178, 7, 3, -1, 0, 0, 0, 0, frame=2),
            way(0, 0, 0, None, HOME[0] + 0.01, HOME[1], 8),
            way(0, 0, 0, None, NORTH, HOME[1], 150),
            item(177, 99, 1, 0, 0, 0, 0, 0, frame=2),
            rallyPoints={"points": [[0]], "version": 2},
        ),
        tmp_path,
    )
    errors = [line.split("flight.plan: ")[1] for line in said.splitlines() if "error: " in line]
    assert errors == [
        "rally point 1: expected latitude, longitude and height, found another",
        "item 2 is 'set home' (179), which is not supported",
        "item 3, waypoint: frame 10 is not supported (heights above terrain)",
        "item 4, change of speed: unknown type of speed 7",
        "item 5, waypoint: expected a distance of at most 500 m (the fence of the vehicle, "
        "navigator.fence_radius), found 1111.8 m",
        "item 6, waypoint: expected a height of at most 120 m (the fence of the vehicle, "
        "navigator.fence_height), found 150 m",
        "item 7, jump: expected a jump to another item, found 99",
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (plan(TAKE_OFF, item(4711, 0, 0, 0, 0, 0, 0, 0)), "item 2 is 'unknown command' (4711)"),
        (
            plan(TAKE_OFF, item(601, 1, 1, 0, 0, 0, 0, 0)),
            "item 2 is 'jump to tag' (601), which is not supported",
        ),
        (
            plan(TAKE_OFF, {"type": "ComplexItem", "complexItemType": "spiral"}),
            "item 2 is a spiral, which is not supported",
        ),
        (
            plan(TAKE_OFF, {"type": "ComplexItem", "complexItemType": "survey"}),
            "item 2 is a survey: expected its waypoints, found none",
        ),
        (plan(TAKE_OFF, {"type": "OtherItem"}), "item 2: expected a SimpleItem or a ComplexItem"),
        (plan(TAKE_OFF, 5), "item 2: expected a SimpleItem or a ComplexItem"),
        (
            plan(TAKE_OFF, way(0, 0, 0, None, NORTH, HOME[1], 8, frame=11)),
            "frame 11 is not supported (heights above terrain)",
        ),
        (
            plan(TAKE_OFF, way(0, 0, 0, None, NORTH, HOME[1], 8, frame=8)),
            "frame 8 is not supported (its places)",
        ),
        (plan(TAKE_OFF, item(16, 0, 0)), "item 2 is incomplete"),
        (plan(), "expected at least one item, found none"),
        ({"fileType": "Parameters"}, "expected a plan with fileType 'Plan'"),
        (
            {"fileType": "Plan", "mission": {"items": []}},
            "missing mission with a planned home position",
        ),
        ("{", "invalid JSON"),
        ("QGC WPL 110\n0 1 0 16 x\n", "line 2: expected an item of 12 numbers, found '0 1 0 16 x'"),
        ("QGC WPL 100\n", "expected format QGC WPL 110, found 100"),
        (plan(TAKE_OFF) | {"version": 3}, "version of the plan: expected 1, found 3"),
        (
            plan(TAKE_OFF, mission={"version": 9}),
            "version of mission: expected 1 or 2, found 9",
        ),
        (
            plan(TAKE_OFF, mission={"vehicleType": 1}),
            "expected a plan for a multicopter, found one for a fixed-wing plane",
        ),
        (plan(TAKE_OFF, mission={"vehicleType": 10}), "found one for a rover"),
        (plan(TAKE_OFF, mission={"vehicleType": "x"}), "found one for vehicle type x"),
        (
            plan(
                TAKE_OFF,
                way(0, 0, 0, None, NORTH, HOME[1], 500, frame=0),
                mission={"plannedHomePosition": [*HOME[:2], None]},
            ),
            "item 2, waypoint: its height is above the sea, and the planned home has no altitude",
        ),
        (
            plan(TAKE_OFF, item(93, -1, 12, 0, 0, 0, 0, 0, frame=2)),
            "item 2, delay: expected a delay in seconds, found a time of day",
        ),
        (
            plan(TAKE_OFF, item(201, 2, 1, 0, 0, 0, 0, 0)),
            "expected a place to look at, found an item, which is not supported",
        ),
        (
            plan(TAKE_OFF, item(178, 1, 0, -1, 0, 0, 0, 0, frame=2)),
            "item 2, change of speed: expected a speed above 0 m/s, -1 or -2, found 0",
        ),
        (plan(TAKE_OFF, item(178, 1, 5, -1, 1, 0, 0, 0, frame=2)), "a relative speed is not"),
        (plan(item(22, 0, 0, 0, None, 0, 0, None)), "item 1, takeoff: expected a height"),
        (
            plan(TAKE_OFF, item(177, 1, 2, 0, 0, 0, 0, 0, frame=2, doJumpId=2))
            | {"note": "jumps to the take-off"},
            "",
        ),
        (
            plan(
                TAKE_OFF,
                item(177, 3, -1, 0, 0, 0, 0, 0, frame=2, doJumpId=2),
                item(177, 2, -1, 0, 0, 0, 0, 0, frame=2, doJumpId=3),
            ),
            "jump: it leads round without a place to fly to",
        ),
        (
            plan(TAKE_OFF, *[item(177, 1, 2, 0, 0, 0, 0, 0, doJumpId=i) for i in range(2, 19)]),
            "expected at most 16 jumps, found 17",
        ),
        (
            plan(TAKE_OFF, way(0, 0, 0, None, 91.0, HOME[1], 8)),
            "expected a latitude and longitude, found 91, 8.54559",
        ),
    ],
)
def test_what_is_not_supported_is_named(content: Any, message: str, tmp_path: Path) -> None:
    if message:
        assert message in refusal(content, tmp_path)
    else:
        assert read(content, tmp_path)


def fenced(circles: Any = (), polygons: Any = (), *items: Any) -> dict[str, Any]:
    fence = {"circles": circles, "polygons": polygons, "version": 2}
    return plan(TAKE_OFF, *items, geoFence=fence)


def circle(radius: float, north: float = 0.0, *, includes: bool = True) -> dict[str, Any]:
    center = [HOME[0] + north / DEGREE_M, HOME[1]]
    return {"circle": {"center": center, "radius": radius}, "inclusion": includes, "version": 1}


def box(north: float, *, includes: bool) -> dict[str, Any]:
    """10 m wide, from there on, across the meridian of home."""
    places = [(north, -5.0), (north + 10.0, -5.0), (north + 10.0, 5.0), (north, 5.0)]
    corner = [list(from_local((HOME[0], HOME[1]), place)) for place in places]
    return {"inclusion": includes, "polygon": corner, "version": 1}


AWAY = way(0, 0, 0, None, HOME[0] + 50.0 / DEGREE_M, HOME[1], 8)
BEYOND = way(0, 0, 0, None, HOME[0] + 600.0 / DEGREE_M, HOME[1], 8)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (fenced([circle(80)], [], AWAY), ""),
        (fenced([circle(40)], [], AWAY), "at most 40 m (the fence), found 50.0 m"),
        (fenced([circle(700)], [], BEYOND), ""),
        (fenced([circle(20, 35, includes=False)], [], AWAY), "fence, circle 1, which excludes it"),
        (
            fenced([circle(5, 25, includes=False)], [], AWAY),
            "item 2, waypoint: expected a way inside the fence, found one that leads inside fence, "
            "circle 1, which excludes it",
        ),
        (fenced([], [box(45, includes=False)], AWAY), "inside fence, polygon 1, which excludes it"),
        (fenced([], [box(20, includes=False)], AWAY), "a way inside the fence, found one"),
        (fenced([], [box(60, includes=False)], AWAY), ""),
        (fenced([], [box(-5, includes=True)], AWAY), "outside fence, polygon 1"),
        (
            fenced([], [box(-5, includes=True), box(45, includes=True)], AWAY),
            "a way inside the fence, found one that leads outside all areas of the fence",
        ),
        (fenced([circle(30)], [box(25, includes=True), box(45, includes=True)], AWAY), "leads out"),
        (fenced([circle(40)], [box(25, includes=True), box(32, includes=True)]), ""),
        (fenced([circle(80)], [], item(35, 35, 5, 0, 0, *AWAY["params"][4:])), "(the fence)"),
        (fenced({"circle": 5}), "fence, circle 1: expected a center and a radius above 0"),
        (fenced([5]), "fence, circle 1: expected"),
        (fenced([{"circle": {"center": 5, "radius": 80}}]), "fence, circle 1: expected"),
        (fenced([{"circle": {"center": HOME[:2], "radius": -8}}]), "fence, circle 1: expected"),
        (fenced([], [{"polygon": [HOME[:2]] * 2}]), "polygon 1: expected 3 places or more"),
        (fenced([circle(80)] * 17), "at most 16 areas and 128 places, found 17 and 17"),
        (fenced([], [{"polygon": [HOME[:2]] * 129}]), "and 128 places, found 1 and 129"),
    ],
)
def test_a_fence_is_kept_by_places_and_ways(content: Any, message: str, tmp_path: Path) -> None:
    if message:
        assert message in refusal(content, tmp_path)
    else:
        assert read(content, tmp_path)


def test_a_rally_point_outside_the_fence_is_named(tmp_path: Path) -> None:
    points = {"points": [[*HOME[:2], 10], [HOME[0] + 0.01, HOME[1], 10]], "version": 2}
    said = refusal(plan(TAKE_OFF, rallyPoints=points), tmp_path)
    assert "rally point 2: expected it inside the fence, found it 1111.8 m from home" in said
    points = {"points": [[*HOME[:2], 130]], "version": 2}
    assert "130 m high, above the fence of 120 m" in refusal(
        plan(TAKE_OFF, rallyPoints=points), tmp_path
    )


def test_a_return_below_a_low_fence_is_said(tmp_path: Path) -> None:
    low = Vehicle(fence_radius=500.0, fence_height=7.0, farthest=1000.0, return_height=8.0)
    assert read(plan(TAKE_OFF), tmp_path, low).notes[-1] == (
        "a return stays below the fence: at 6.3 m, in place of 8 m"
    )


def test_a_fence_of_the_first_version_and_a_breach_return(tmp_path: Path) -> None:
    old = {"parameters": [], "polygon": box(-5, includes=True)["polygon"], "version": 1}
    assert len(read(plan(TAKE_OFF, geoFence=old), tmp_path).areas) == 1
    returns = {"circles": [], "polygons": [], "version": 2, "breachReturn": [*HOME[:2], 20]}
    assert (
        "breach return point is not used"
        in read(plan(TAKE_OFF, geoFence=returns), tmp_path).notes[0]
    )


def text(command: str, *, frame: str = "3", altitude: str = "8") -> str:
    home = f"0 1 0 16 0 0 0 0 {HOME[0]} {HOME[1]} 488 1"
    return f"QGC WPL 110\n{home}\n1 0 {frame} {command} 0 0 0 0 0 0 {altitude} 1\n"


INFINITY = math.inf
ALL_DIGITS = json.dumps(plan(TAKE_OFF, way(4711, 0, 0, 0, NORTH, HOME[1], 8)))
NUMBERS = "expected a number from -1e+09 to 1e+09"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (text("nan"), "line 3: expected an item"),
        (text("inf"), "line 3: expected an item"),
        (text("22", frame="nan"), "line 3: expected an item"),
        (text("22", altitude="inf"), f"item 1 (line 3), takeoff: parameter 7: {NUMBERS}"),
        (
            plan(TAKE_OFF, way(0, 0, 0, 0, 10**400, HOME[1], 8)),
            f"item 2, waypoint: parameter 5: {NUMBERS}",
        ),
        (ALL_DIGITS.replace("4711", "1" * 5000), "invalid JSON"),
        (plan(TAKE_OFF, way(0, 0, 0, 0, NORTH, HOME[1], -1e300)), f"parameter 7: {NUMBERS}"),
        (plan(TAKE_OFF, way(INFINITY, 0, 0, 0, NORTH, HOME[1], 8)), "parameter 1: expected"),
        (plan(TAKE_OFF, way(0, 0, 0, INFINITY, NORTH, HOME[1], 8)), "parameter 4: expected"),
        (plan(TAKE_OFF, item(178, 1, INFINITY, -1, 0, 0, 0, 0)), "parameter 2: expected"),
        (
            plan(TAKE_OFF, way(0, 0, 0, 0, NORTH, HOME[1], 0)),
            "item 2, waypoint: expected a height above 0 m, found 0 m",
        ),
        (
            plan(TAKE_OFF, item(35, 0.5, 5, 0, 0, HOME[0], HOME[1], 9)),
            "item 2, figure of eight: expected a length of at least 2 m, found 1 m",
        ),
        (
            plan(TAKE_OFF, item(35, -10, 5, 0, 0, HOME[0], HOME[1], 9)),
            "item 2, figure of eight: expected a radius above 0 m, found -10 m",
        ),
        (
            plan(TAKE_OFF, mission={"plannedHomePosition": [10**400, 0, 0]}),
            "expected a planned home position",
        ),
        (plan(TAKE_OFF, mission={"plannedHomePosition": 5}), "missing mission with a planned"),
    ],
)
def test_a_file_with_impossible_values_is_refused(
    content: Any, message: str, tmp_path: Path
) -> None:
    said = refusal(content, tmp_path)
    assert str(tmp_path / "flight.plan") in said
    assert message in said


def test_a_home_that_was_not_set_counts_from_the_first_place(tmp_path: Path) -> None:
    unset = plan(TAKE_OFF, AWAY, mission={"plannedHomePosition": [0, 0, 0]})
    mission = read(unset, tmp_path)
    assert mission.home is None
    assert corners(mission)[1] == (0.0, 0.0, 8.0)


def test_local_metres_agree_with_a_known_distance() -> None:
    """One minute of arc at 45 degrees: 1852.24 m along the meridian, 1314.17 m along the parallel
    (WGS 84, from its radii of curvature there, 6367.38 and 6388.84 km)."""
    north, _ = to_local((45.0, 10.0), (45.0 + 1 / 60, 10.0))
    _, east = to_local((45.0, 10.0), (45.0, 10.0 + 1 / 60))
    assert north == pytest.approx(1852.24, abs=0.3)
    assert east == pytest.approx(1314.17, abs=0.3)
    assert to_local((45.0, 179.99), from_local((45.0, 179.99), (800.0, 2000.0))) == pytest.approx(
        (800.0, 2000.0), abs=1e-6
    )
