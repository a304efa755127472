"""Missions as ground stations save them. The file is laid out as QGroundControl's documentation of
the format (file_formats/plan) has it; commands and frames are MAVLink's."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from stator.diagnostics import UserError
from stator.mission.model import (
    EIGHT,
    FOREVER_S,
    LAND,
    RETURN,
    TAKEOFF,
    WAYPOINT,
    Mission,
)
from stator.mission.plan_file import to_local
from stator.mission.read import read_mission

HOME = [47.397742, 8.545594, 488.0]
NORTH = 47.397742 + 20.0 / 111_183.0  # a degree of latitude there: 111,183 m


def item(command: int, *params: float | None, frame: int = 3) -> dict[str, Any]:
    """The last of `params` are latitude, longitude and altitude."""
    return {
        "type": "SimpleItem", "autoContinue": True, "command": command, "doJumpId": 1,
        "frame": frame, "params": list(params),
    }  # fmt: skip


TAKE_OFF = item(22, 0, 0, 0, None, 0, 0, 6)


def plan(*items: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "geoFence": {"circles": [], "polygons": [], "version": 2},
        "rallyPoints": {"points": [], "version": 2},
        "mission": {
            "version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 5,
            "plannedHomePosition": HOME, "items": list(items),
        },
        **more,
    }  # fmt: skip


def read(content: Any, folder: Path) -> Mission:
    file = folder / "flight.plan"
    text = content if isinstance(content, str) else json.dumps(content)
    file.write_text(text, encoding="utf-8")
    return read_mission(file)


def test_every_supported_item(tmp_path: Path) -> None:
    mission = read(
        plan(
            TAKE_OFF,
            item(178, 1, 3.5, -1, 0, 0, 0, 0, frame=2),
            item(16, 2, 1.5, 0, 90, NORTH, HOME[1], 8),
            item(16, 0, 0, 0, None, NORTH, HOME[1], 500, frame=0),
            item(19, 12, 0, 0, None, NORTH, HOME[1], 8),
            item(35, 10, 5, 0, 0, HOME[0], HOME[1], 9),
            item(20, 0, 0, 0, 0, 0, 0, 0, frame=2),
        ),
        tmp_path,
    )
    kinds = [i.kind for i in mission.items]
    assert kinds == [TAKEOFF, WAYPOINT, WAYPOINT, WAYPOINT, EIGHT, RETURN]
    assert mission.origin == (HOME[0], HOME[1])
    assert mission.items[0].height == 6.0
    assert math.isnan(mission.items[0].speed)
    first = mission.items[1]
    assert first.north == pytest.approx(20.0, abs=0.01)
    assert first.east == pytest.approx(0.0, abs=0.01)
    assert (first.height, first.hold, first.radius, first.speed) == (8.0, 2.0, 1.5, 3.5)
    assert first.heading == pytest.approx(math.pi / 2)
    assert mission.items[2].height == 12.0  # 500 m above the sea, home at 488 m
    assert math.isnan(mission.items[2].heading)
    assert mission.items[3].hold == 12.0
    assert (mission.items[4].radius, mission.items[4].height) == (20.0, 9.0)


def test_a_landing_goes_straight_down_at_its_place(tmp_path: Path) -> None:
    mission = read(plan(TAKE_OFF, item(21, 0, 0, 0, None, NORTH, HOME[1], 0)), tmp_path)
    assert mission.items[1].kind == LAND
    assert mission.items[1].north == pytest.approx(20.0, abs=0.01)
    assert mission.items[1].height == 6.0


def test_an_unlimited_loiter_lasts(tmp_path: Path) -> None:
    mission = read(plan(TAKE_OFF, item(17, 0, 0, 0, None, NORTH, HOME[1], 8)), tmp_path)
    assert mission.items[1].hold == FOREVER_S


def test_a_circle_about_home_is_the_fence(tmp_path: Path) -> None:
    circle = {"circle": {"center": HOME[:2], "radius": 80}, "inclusion": True, "version": 1}
    fence = {"circles": [circle], "polygons": [], "version": 2}
    assert read(plan(TAKE_OFF, geoFence=fence), tmp_path).fence_radius == 80.0


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            plan(TAKE_OFF, item(206, 25, 0, 1, 0, 0, 0, 0, frame=2)),
            "item 2 is 'camera trigger distance' (206), which is not supported",
        ),
        (plan(TAKE_OFF, item(4711, 0, 0, 0, 0, 0, 0, 0)), "item 2 is 'command' (4711)"),
        (
            plan(TAKE_OFF, {"type": "ComplexItem", "complexItemType": "survey"}),
            "item 2 is a survey, which is not supported",
        ),
        (
            plan(TAKE_OFF, item(16, 0, 0, 0, None, NORTH, HOME[1], 8, frame=10)),
            "item 2: frame 10 is not supported",
        ),
        (plan(TAKE_OFF, item(16, 0, 0)), "item 2 is incomplete"),
        (plan(TAKE_OFF, geoFence={"polygons": [{"polygon": []}]}), "the fence has a polygon"),
        (plan(item(16, 0, 0, 0, None, NORTH, HOME[1], 8)), "expected a takeoff as the first item"),
        (plan(), "expected at least one item, found none"),
        ({"fileType": "Parameters"}, "expected a plan with fileType 'Plan'"),
        (
            {"fileType": "Plan", "mission": {"items": []}},
            "missing mission with a planned home position",
        ),
        ("{", "invalid JSON"),
        ("QGC WPL 110\n0 1 0 16 x\n", "line 2: expected an item"),
    ],
)
def test_what_is_not_supported_is_named(content: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises(UserError) as refused:
        read(content, tmp_path)
    assert message in str(refused.value)
    assert "hint: " in str(refused.value)


def way(*params: float | None) -> dict[str, Any]:
    return item(16, *params)


def fenced(circles: Any) -> dict[str, Any]:
    return plan(TAKE_OFF, geoFence={"circles": circles, "polygons": []})


def text(command: str, *, frame: str = "3", altitude: str = "8") -> str:
    home = f"0 1 0 16 0 0 0 0 {HOME[0]} {HOME[1]} 488 1"
    return f"QGC WPL 110\n{home}\n1 0 {frame} {command} 0 0 0 0 0 0 {altitude} 1\n"


INFINITY = math.inf
NOT_A_CIRCLE = "expected a fence of one inclusion circle"
ALL_DIGITS = json.dumps(plan(TAKE_OFF, way(4711, 0, 0, 0, NORTH, HOME[1], 8)))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (text("nan"), "line 3: expected an item"),
        (text("inf"), "line 3: expected an item"),
        (text("22", frame="nan"), "line 3: expected an item"),
        (text("22", altitude="inf"), "item 1: parameter 7: expected a number from -1e+09 to 1e+09"),
        (fenced({"circle": 5}), NOT_A_CIRCLE),
        (fenced([5]), NOT_A_CIRCLE),
        (fenced([{"circle": 5, "inclusion": True}]), NOT_A_CIRCLE),
        (fenced([{"circle": {"center": 5, "radius": 80}, "inclusion": True}]), NOT_A_CIRCLE),
        (fenced([{"circle": {"center": [5], "radius": 80}, "inclusion": True}]), NOT_A_CIRCLE),
        (fenced([{"circle": {"center": HOME[:2], "radius": -8}, "inclusion": True}]), NOT_A_CIRCLE),
        (
            plan(TAKE_OFF, way(0, 0, 0, 0, 10**400, HOME[1], 8)),
            "item 2: parameter 5: expected a number",
        ),
        (ALL_DIGITS.replace("4711", "1" * 5000), "invalid JSON"),
        (
            plan(TAKE_OFF, way(0, 0, 0, 0, NORTH, HOME[1], -1e300)),
            "item 2: parameter 7: expected a number from -1e+09 to 1e+09",
        ),
        (
            plan(TAKE_OFF, way(INFINITY, 0, 0, 0, NORTH, HOME[1], 8)),
            "item 2: parameter 1: expected",
        ),
        (
            plan(TAKE_OFF, way(0, 0, 0, INFINITY, NORTH, HOME[1], 8)),
            "item 2: parameter 4: expected",
        ),
        (plan(TAKE_OFF, item(178, 1, INFINITY, -1, 0, 0, 0, 0)), "item 2: parameter 2: expected"),
        (
            plan(TAKE_OFF, way(0, 0, 0, 0, NORTH, HOME[1], 0)),
            "item 2, waypoint: expected a height above 0 m, found 0 m",
        ),
        (
            plan(TAKE_OFF, item(35, 0, 5, 0, 0, HOME[0], HOME[1], 9)),
            "item 2, figure of eight: expected a length of at least 2 m, found 0 m",
        ),
        (
            plan(TAKE_OFF, item(35, -10, 5, 0, 0, HOME[0], HOME[1], 9)),
            "item 2: expected a radius above 0 m for a figure of eight, found -10 m",
        ),
        (
            plan(TAKE_OFF, mission={"plannedHomePosition": [10**400, 0, 0], "items": []}),
            "missing mission with a planned home position",
        ),
    ],
)
def test_a_file_with_impossible_values_is_refused(
    content: Any, message: str, tmp_path: Path
) -> None:
    with pytest.raises(UserError) as refused:
        read(content, tmp_path)
    assert str(tmp_path / "flight.plan") in str(refused.value)
    assert message in str(refused.value)
    assert "hint: " in str(refused.value)


def test_the_older_text_format(tmp_path: Path) -> None:
    lines = [
        "QGC WPL 110",
        f"0\t1\t0\t16\t0\t0\t0\t0\t{HOME[0]}\t{HOME[1]}\t488\t1",
        "1\t0\t3\t22\t0\t0\t0\t0\t0\t0\t6\t1",
        f"2\t0\t3\t16\t3\t0\t0\t0\t{NORTH}\t{HOME[1]}\t8\t1",
        "3\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1",
    ]
    mission = read("\n".join(lines), tmp_path)
    assert [i.kind for i in mission.items] == [TAKEOFF, WAYPOINT, RETURN]
    assert mission.items[1].north == pytest.approx(20.0, abs=0.01)
    assert mission.items[1].hold == 3.0
    assert mission.origin == (HOME[0], HOME[1])


def test_local_metres_agree_with_a_known_distance() -> None:
    """One minute of arc at 45 degrees: 1852.24 m along the meridian, 1314.17 m along the parallel
    (WGS 84, from its radii of curvature there, 6367.38 and 6388.84 km)."""
    north, _ = to_local((45.0, 10.0), (45.0 + 1 / 60, 10.0))
    _, east = to_local((45.0, 10.0), (45.0, 10.0 + 1 / 60))
    assert north == pytest.approx(1852.24, abs=0.3)
    assert east == pytest.approx(1314.17, abs=0.3)
