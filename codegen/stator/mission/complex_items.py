"""Patterns that QGroundControl saves as one item: survey, corridor scan, structure scan, landings.

A survey and a corridor scan have their waypoints in the file. Those of a structure scan follow
from its polygon, as QGroundControl makes them: round the polygon at a distance, layer by layer.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stator.mission.commands import (
    GLOBAL,
    LAND,
    LOITER_TO_ALTITUDE,
    RELATIVE,
    WAYPOINT,
)
from stator.mission.geodesy import from_local, to_local

if TYPE_CHECKING:
    from stator.mission.builder import Builder

LANDING_START = 189
MAX_LAYERS = 200
_ABSOLUTE, _TERRAIN = (2,), (3, 4)  # of DistanceMode
_SAVE_AGAIN = "open the plan in a newer QGroundControl, and save it again"


class _Wrong(Exception):
    """What is wrong with the pattern."""


def add_complex_item(builder: Builder, number: int, item: dict[str, Any]) -> list[Any]:
    """The simple items that it stands for."""
    kind = item.get("complexItemType")
    try:
        match kind:
            case "survey" | "CorridorScan":
                return _transects(item)
            case "StructureScan":
                return _structure(item)
            case "fwLandingPattern" | "vtolLandingPattern":
                return _landing(item)
    except _Wrong as wrong:
        builder.problems.add(number, f"item {number} is a {kind}: {wrong}", _SAVE_AGAIN)
        return []
    builder.problems.add(
        number,
        f"item {number} is a {str(kind)[:40]}, which is not supported",
        "fly it as single waypoints, or as a survey",
    )
    return []


def _simple(command: int, frame: int, params: list[float | None]) -> dict[str, Any]:
    return {"command": command, "frame": frame, "params": params}


def _mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _number(table: dict[str, Any], key: str, usual: float | None = None) -> float:
    value = table.get(key, usual)
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e7:
        return float(value)
    raise _Wrong(f"expected a number for {key}, found another")


def _places(value: Any, what: str, least: int) -> list[tuple[float, float]]:
    is_list = isinstance(value, list) and len(value) >= least
    if not is_list or not all(_is_place(place) for place in value):
        raise _Wrong(f"expected {least} or more places for {what}, found another")
    return [(float(place[0]), float(place[1])) for place in value]


def _is_place(place: Any) -> bool:
    return (
        isinstance(place, list)
        and len(place) >= 2
        and all(isinstance(v, int | float) and not isinstance(v, bool) for v in place[:2])
        and abs(place[0]) < 90.0
        and abs(place[1]) <= 180.0
    )


def _transects(item: dict[str, Any]) -> list[Any]:
    style = _mapping(item.get("TransectStyleComplexItem"))
    items = style.get("Items")
    if isinstance(items, list) and items:
        return items
    points = style.get("VisualTransectPoints")
    if not points:
        raise _Wrong("expected its waypoints, found none")
    camera = _mapping(style.get("CameraCalc"))
    mode = camera.get("DistanceMode")
    if mode in _TERRAIN or style.get("FollowTerrain") is True:
        raise _Wrong("heights above terrain are not supported")
    is_absolute = mode in _ABSOLUTE or camera.get("DistanceToSurfaceRelative") is False
    height = _number(camera, "DistanceToSurface")
    frame = GLOBAL if is_absolute else RELATIVE
    return [
        _simple(WAYPOINT, frame, [0, 0, 0, None, *place, height])
        for place in _places(points, "its transects", 1)
    ]


def _landing(item: dict[str, Any]) -> list[Any]:
    approach, land = item.get("landingApproachCoordinate"), item.get("landCoordinate")
    if not _is_place(approach) or not _is_place(land):
        raise _Wrong("expected a landing point and an approach, found another")
    assert isinstance(approach, list)
    assert isinstance(land, list)
    relative = item.get("altitudesAreRelative", item.get("loiterAltitudeRelative", True))
    height = _number({"altitude": approach[2] if len(approach) > 2 else None}, "altitude")
    loiters = item.get("useLoiterToAlt", True) is not False
    frame = RELATIVE if relative else GLOBAL
    first = LOITER_TO_ALTITUDE if loiters else WAYPOINT
    return [
        _simple(LANDING_START, 2, [0, 0, 0, 0, 0, 0, 0]),
        _simple(first, frame, [0, 0, 0, None, approach[0], approach[1], height]),
        _simple(LAND, RELATIVE, [0, 0, 0, None, land[0], land[1], 0]),
    ]


# --- structure scan ---


def _structure(item: dict[str, Any]) -> list[Any]:
    camera = _mapping(item.get("CameraCalc"))
    polygon = _places(item.get("polygon"), "its polygon", 3)
    distance = _number(camera, "DistanceToSurface")
    origin = polygon[0]
    corners = _offset([to_local(origin, place) for place in polygon], distance)
    layers = round(_number(item, "Layers", 1))
    if not 1 <= layers <= MAX_LAYERS:
        raise _Wrong(f"expected 1 to {MAX_LAYERS} layers, found {layers}")
    step = _number(camera, "AdjustedFootprintFrontal", 0.0)
    # Of version 2 the altitude is that of its lowest layer.
    lowest = _number(item, "ScanBottomAlt", _number(item, "Altitude", 0.0)) + 0.5 * step
    is_relative = item.get("altitudeRelative", True) is not False
    frame = RELATIVE if is_relative else GLOBAL
    entrance = _number(item, "EntranceAltitude", lowest + (layers - 1) * step)
    heights = [lowest + layer * step for layer in range(layers)]
    if item.get("StartFromTop", item.get("startFromTop")) is True:
        heights.reverse()
    middle = (sum(x for x, _ in corners) / len(corners), sum(y for _, y in corners) / len(corners))
    places = [from_local(origin, corner) for corner in corners]
    looks = [
        math.degrees(math.atan2(middle[1] - y, middle[0] - x)) % 360.0 for x, y in corners
    ]  # at the structure
    ways = [*zip(places, looks, strict=True)]
    ways.append(ways[0])
    items = [_simple(WAYPOINT, frame, [0, 0, 0, looks[0], *places[0], entrance])]
    for height in heights:
        items += [_simple(WAYPOINT, frame, [0, 0, 0, look, *place, height]) for place, look in ways]
    items.append(_simple(WAYPOINT, frame, [0, 0, 0, looks[0], *places[0], entrance]))
    return items


def _offset(corners: list[tuple[float, float]], distance: float) -> list[tuple[float, float]]:
    """Each edge moved outwards, and met with the next one."""
    count = len(corners)
    area2 = sum(
        corners[i][0] * corners[(i + 1) % count][1] - corners[(i + 1) % count][0] * corners[i][1]
        for i in range(count)
    )
    side = 1.0 if area2 > 0.0 else -1.0
    edges = []
    for i in range(count):
        (ax, ay), (bx, by) = corners[i], corners[(i + 1) % count]
        length = math.hypot(bx - ax, by - ay)
        if length < 1e-3:
            raise _Wrong("expected corners apart from each other, found two at one place")
        dx, dy = (bx - ax) / length, (by - ay) / length
        edges.append((ax + side * distance * dy, ay - side * distance * dx, dx, dy))
    moved = []
    for i in range(count):
        px, py, dx, dy = edges[i - 1]
        qx, qy, ex, ey = edges[i]
        across = dx * ey - dy * ex
        if abs(across) < 1e-6:  # in one line
            moved.append((qx, qy))
            continue
        along = ((qx - px) * ey - (qy - py) * ex) / across
        moved.append((px + along * dx, py + along * dy))
    return moved
