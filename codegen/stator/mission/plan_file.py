"""Missions in the files of ground stations: QGroundControl's .plan (JSON), and the older text
format "QGC WPL 110" of Mission Planner and others. Commands and frames: MAVLink's common.xml."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from stator.diagnostics import UserError
from stator.mission.model import (
    EIGHT,
    FOREVER_S,
    LAND,
    NAN,
    RETURN,
    TAKEOFF,
    USUAL_RADIUS_M,
    WAYPOINT,
    Item,
    Mission,
)

if TYPE_CHECKING:
    from pathlib import Path

LOITER_UNLIMITED, LOITER_TIME, CHANGE_SPEED = 17, 19, 178
SUPPORTED = (
    "waypoint (16), loiter (17, 19), return (20), land (21), take-off (22), figure of eight (35) "
    "and change of speed (178)"
)
# Names of commands that plans often hold, so that an error can name them.
OTHERS = {
    18: "loiter turns", 31: "loiter to altitude", 82: "spline waypoint", 84: "VTOL take-off",
    85: "VTOL land", 93: "delay", 112: "condition delay", 115: "condition yaw", 177: "jump",
    179: "set home", 183: "set servo", 189: "landing start", 195: "region of interest",
    197: "no region of interest", 201: "region of interest", 203: "camera trigger",
    205: "mount control", 206: "camera trigger distance", 530: "camera mode", 2000: "take photos",
    2001: "stop photos", 2500: "start video", 2501: "stop video", 3000: "VTOL transition",
}  # fmt: skip
MAX_FENCE_OFFSET_M = 5.0
MAX_NUMBER = 1e9  # the same value as FOREVER_S
ABOVE_SEA, NO_PLACE, ABOVE_HOME = (0, 5), (2,), (3, 6)


@dataclass(frozen=True)
class _Row:
    """One item of a file: its number, counted from 1, and its MAVLink fields."""

    number: int
    command: int
    frame: int
    params: tuple[float, ...]  # seven; NaN: not given


class _Refusal(Exception):
    pass


def read_plan(path: Path) -> Mission:
    """Raises `UserError`, which names the wrong item."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        return _read_text(text) if text.startswith("QGC WPL") else _read_json(text)
    except (_Refusal, UnicodeDecodeError) as refusal:
        raise UserError(f"error: {path}: {refusal}") from refusal


# --- the two formats ---


def _read_json(text: str) -> Mission:
    try:
        plan = json.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also a number of 5000 digits
        raise _Refusal(f"invalid JSON: {error}\nhint: save the plan again") from error
    if not isinstance(plan, dict) or plan.get("fileType") != "Plan":
        raise _Refusal(
            "expected a plan with fileType 'Plan', found another file\n"
            "hint: save it in the ground station as a plan"
        )
    mission = plan.get("mission")
    items = mission.get("items") if isinstance(mission, dict) else None
    home = mission.get("plannedHomePosition") if isinstance(mission, dict) else None
    if not isinstance(items, list) or not _is_numbers(home, 3):
        raise _Refusal(
            "missing mission with a planned home position\nhint: plan a mission, and save it"
        )
    assert isinstance(home, list)
    rows = [_row_of(number, item) for number, item in enumerate(items, 1)]
    origin = (float(home[0]), float(home[1]))
    return Mission(_items(rows, origin, float(home[2])), origin, fence_radius=_fence(plan, origin))


def _is_numbers(value: Any, count: int) -> bool:
    return (
        isinstance(value, list)
        and len(value) == count
        and all(_is_number(v) and abs(v) <= MAX_NUMBER for v in value)
    )


def _row_of(number: int, item: Any) -> _Row:
    if not isinstance(item, dict) or item.get("type") != "SimpleItem":
        kind = item.get("complexItemType", "item") if isinstance(item, dict) else "item"
        raise _Refusal(
            f"item {number} is a {kind}, which is not supported\n"
            f"hint: fly it as single waypoints; supported items: {SUPPORTED}"
        )
    command, frame, params = (item.get(key) for key in ("command", "frame", "params"))
    if not isinstance(command, int) or not isinstance(frame, int) or not _is_params(params):
        raise _Refusal(f"item {number} is incomplete\nhint: save the plan again")
    assert isinstance(params, list)
    return _row(number, command, frame, [NAN if value is None else value for value in params])


def _row(number: int, command: int, frame: int, params: list[float]) -> _Row:
    for index, value in enumerate(params, 1):
        if abs(value) > MAX_NUMBER:
            raise _Refusal(
                f"item {number}: parameter {index}: expected a number from {-MAX_NUMBER:g} to "
                f"{MAX_NUMBER:g}, found another\nhint: correct it, and save the plan again"
            )
    return _Row(number, command, frame, tuple(float(value) for value in params))


def _is_params(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 7
        and all(v is None or _is_number(v) for v in value)
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _read_text(text: str) -> Mission:
    """One item a line: index, current, frame, command, seven numbers, autocontinue. The first item
    is home."""
    rows = []
    for number, line in enumerate(text.splitlines()[1:]):
        words = line.split()
        if not words:
            continue
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if len(values) != 12 or not all(value.is_integer() for value in values[2:4]):
            raise _Refusal(
                f"line {number + 2}: expected an item of 12 numbers, found another text\n"
                "hint: save the mission again"
            )
        rows.append(_row(number, int(values[3]), int(values[2]), values[4:11]))
    if not rows or not all(math.isfinite(v) for v in rows[0].params[4:]):
        raise _Refusal("missing home position\nhint: save the mission again")
    latitude, longitude, altitude = rows[0].params[4:]
    return Mission(_items(rows[1:], (latitude, longitude), altitude), (latitude, longitude))


def _fence(plan: dict[str, Any], origin: tuple[float, float]) -> float:
    """The radius of the fence. A vehicle can watch one circle around home."""
    fence = _mapping(plan.get("geoFence"))
    if fence.get("polygons"):
        raise _Refusal(
            "the fence has a polygon, which is not supported\nhint: draw a circle around home"
        )
    circles = fence.get("circles") or []
    if not circles:
        return 0.0
    only = _mapping(circles[0]) if isinstance(circles, list) and len(circles) == 1 else {}
    circle = _mapping(only.get("circle"))
    center: Any = circle.get("center")
    radius: Any = circle.get("radius")
    is_circle = _is_numbers(center, 2) and _is_numbers([radius], 1) and radius > 0.0
    if not only.get("inclusion") or not is_circle:
        raise _Refusal(
            "expected a fence of one inclusion circle, found another fence\n"
            "hint: draw one circle around home, and remove the others"
        )
    if math.hypot(*to_local(origin, (center[0], center[1]))) > MAX_FENCE_OFFSET_M:
        raise _Refusal(
            "expected the fence's circle around the planned home, found it elsewhere\n"
            "hint: move the circle to the planned home"
        )
    return float(radius)


def _mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


# --- what the items mean ---


def _items(rows: list[_Row], origin: tuple[float, float], home_altitude: float) -> tuple[Item, ...]:
    items: list[Item] = []
    speed = NAN
    here = Item(WAYPOINT, 0.0, 0.0, 0.0)
    for row in rows:
        if row.command == CHANGE_SPEED:
            speed = row.params[1] if row.params[1] > 0.0 else speed
            continue
        here = _item(row, replace(here, speed=speed), origin, home_altitude)
        items.append(here)
    return tuple(items)


def _item(row: _Row, before: Item, origin: tuple[float, float], home_altitude: float) -> Item:
    """`before` gives the place if the row has none."""
    first, second, _, fourth, latitude, longitude, _ = row.params
    if row.command == RETURN:
        return replace(before, kind=RETURN, hold=0.0)
    kind = {LOITER_UNLIMITED: WAYPOINT, LOITER_TIME: WAYPOINT}.get(row.command, row.command)
    if kind not in (WAYPOINT, LAND, TAKEOFF, EIGHT):
        name = OTHERS.get(row.command, "command")
        raise _Refusal(
            f"item {row.number} is '{name}' ({row.command}), which is not supported\n"
            f"hint: remove it; supported items: {SUPPORTED}"
        )
    north, east = before.north, before.east
    if math.isfinite(latitude) and math.isfinite(longitude) and (latitude, longitude) != (0.0, 0.0):
        north, east = to_local(origin, (latitude, longitude))
    height = _height(row, before, home_altitude)
    heading = math.radians(fourth)  # NaN stays NaN
    place = Item(kind, north, east, height, heading, speed=before.speed)
    if row.command == LOITER_UNLIMITED:
        return replace(place, hold=FOREVER_S)
    if row.command == EIGHT:
        if first < 0.0:
            raise _Refusal(
                f"item {row.number}: expected a radius above 0 m for a figure of eight, found "
                f"{first:g} m\nhint: reverse the direction, and give a radius above 0"
            )
        return replace(place, heading=fourth, radius=2.0 * first, hold=1.0)
    if row.command == LOITER_TIME:
        return replace(place, hold=max(first, 0.1))
    if row.command == LAND:
        return replace(place, height=before.height)  # it descends from there
    hold = first if first > 0.0 and row.command == WAYPOINT else 0.0
    return replace(place, hold=hold, radius=second if second > 0.0 else USUAL_RADIUS_M)


def _height(row: _Row, before: Item, home_altitude: float) -> float:
    altitude = row.params[6]
    if row.frame in NO_PLACE or not math.isfinite(altitude):
        return before.height
    if row.frame in ABOVE_HOME:
        return altitude
    if row.frame in ABOVE_SEA:
        return altitude - home_altitude
    raise _Refusal(
        f"item {row.number}: frame {row.frame} is not supported\n"
        "hint: give heights above home or above mean sea level"
    )


def to_local(origin: tuple[float, float], place: tuple[float, float]) -> tuple[float, float]:
    """Metres north and east, as in runtime/math/stator/geodesy.hpp."""
    flattening = 1.0 / 298.257223563
    eccentricity2 = flattening * (2.0 - flattening)
    latitude = math.radians(origin[0])
    w2 = 1.0 - eccentricity2 * math.sin(latitude) ** 2
    transverse = 6378137.0 / math.sqrt(w2)
    meridional = transverse * (1.0 - eccentricity2) / w2
    bend = 0.5 * transverse * math.sin(latitude) * math.cos(latitude)
    dlat = math.radians(place[0] - origin[0])
    dlon = math.remainder(math.radians(place[1] - origin[1]), math.tau)
    return (
        meridional * dlat + bend * dlon**2,
        transverse * math.cos(math.radians(place[0])) * dlon,
    )
