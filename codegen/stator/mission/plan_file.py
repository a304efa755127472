"""Missions of QGroundControl: its .plan (JSON), and the .mission of its first versions."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

from stator.mission.builder import MAX_NUMBER, Builder
from stator.mission.complex_items import add_complex_item
from stator.mission.model import (
    MAX_AREAS,
    MAX_FENCE_ITEMS,
    MAX_RALLY_POINTS,
    NAN,
    Area,
    Home,
    Mission,
)

if TYPE_CHECKING:
    from stator.mission.problems import Problems

SAVE_AGAIN = "save the plan again in the ground station"
ARDUPILOT = 3  # MAV_AUTOPILOT
# MAV_TYPE: what a plan may be for.
MULTICOPTERS = frozenset((0, 2, 3, 4, 13, 14, 15, 29, 35))
VTOLS = frozenset(range(19, 26))
OTHER_VEHICLES = {
    1: "a fixed-wing plane", 7: "an airship", 8: "a balloon", 9: "a rocket", 10: "a rover",
    11: "a boat", 12: "a submarine", 16: "a flapping wing", 17: "a kite", 28: "a parafoil",
}  # fmt: skip
_VERSIONS = {"": (1,), "mission": (1, 2), "geoFence": (1, 2), "rallyPoints": (1, 2)}


def read_json(text: str, problems: Problems) -> Mission:
    try:
        plan = json.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also a number of 5000 digits
        problems.add(0, f"invalid JSON: {error}", SAVE_AGAIN)
        return Mission(())
    is_plan = isinstance(plan, dict) and plan.get("fileType") == "Plan"
    is_old = isinstance(plan, dict) and "fileType" not in plan and "items" in plan
    if not is_plan and not is_old:
        problems.add(
            0,
            "expected a plan with fileType 'Plan', found another file",
            "save it in the ground station as a plan",
        )
        return Mission(())
    mission = mapping(plan if is_old else plan.get("mission"))
    if is_plan:
        _check_versions(plan, problems)
    items = mission.get("items")
    planned = mission.get("plannedHomePosition")
    if isinstance(planned, dict):  # of a .mission
        planned = planned.get("coordinate")
    if not isinstance(items, list) or not isinstance(planned, list):
        problems.add(
            0, "missing mission with a planned home position", "plan a mission, and save it"
        )
        return Mission(())
    builder = Builder(problems, is_ardupilot=mission.get("firmwareType") == ARDUPILOT)
    _check_vehicle(mission.get("vehicleType"), builder)
    home = _home(planned, problems)
    for number, item in enumerate(items, 1):
        _add_item(builder, number, item)
    areas = _areas(mapping(plan.get("geoFence")), builder)
    rally = _rally_points(mapping(plan.get("rallyPoints")), problems)
    return Mission(builder.finish(), home, areas, rally=rally, notes=builder.notes)


def mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_place(value: Any) -> bool:
    """A list that begins with a latitude and a longitude."""
    return (
        isinstance(value, list)
        and len(value) >= 2
        and all(is_number(v) for v in value[:2])
        and abs(value[0]) < 90.0
        and abs(value[1]) <= 180.0
    )


def _check_versions(plan: dict[str, Any], problems: Problems) -> None:
    for key, known in _VERSIONS.items():
        part = mapping(plan.get(key)) if key else plan
        version = part.get("version", known[-1])
        if version not in known:
            what = f"version of {key}" if key else "version of the plan"
            problems.add(
                0,
                f"{what}: expected {' or '.join(map(str, known))}, found {str(version)[:40]}",
                SAVE_AGAIN,
            )


def _check_vehicle(kind: Any, builder: Builder) -> None:
    if kind is None or (is_number(kind) and kind in MULTICOPTERS):
        return
    if is_number(kind) and kind in VTOLS:
        builder.note("the plan is for a VTOL; it is flown without wings")
        return
    found = OTHER_VEHICLES.get(kind) if is_number(kind) else None
    builder.problems.add(
        0,
        f"expected a plan for a multicopter, found one for {found or f'vehicle type {kind}'}"[:200],
        "choose a multicopter in the ground station, and plan it again",
    )


def _home(planned: list[Any], problems: Problems) -> Home | None:
    """None if none was set. Only heights above the sea need its altitude."""
    if planned[:2] in ([0, 0], [None, None]):
        return None
    altitude = planned[2] if len(planned) > 2 else None
    is_good = is_place(planned) and (
        altitude is None or (is_number(altitude) and not abs(altitude) > MAX_NUMBER)
    )
    if not is_good:
        problems.add(
            0,
            "expected a planned home position of latitude, longitude and altitude, found another",
            "plan a mission, and save it",
        )
        return None
    known = None if altitude is None or not math.isfinite(altitude) else float(altitude)
    return Home(float(planned[0]), float(planned[1]), known)


# --- items ---


def _add_item(builder: Builder, number: int, item: Any) -> None:
    kind = item.get("type") if isinstance(item, dict) else None
    if kind == "ComplexItem":
        points = add_complex_item(builder, number, item)
        for point, inner in enumerate(points, 1):
            _add_simple_item(builder, number, f"item {number}, point {point}", inner)
    elif kind in ("SimpleItem", "missionItem"):
        _add_simple_item(builder, number, f"item {number}", item)
    else:
        shown = str(kind)[:40] if kind is not None else "another thing"
        builder.problems.add(
            number,
            f"item {number}: expected a SimpleItem or a ComplexItem, found {shown}",
            SAVE_AGAIN,
        )


def _add_simple_item(builder: Builder, number: int, label: str, item: Any) -> None:
    item = mapping(item)
    command, frame = _whole(item.get("command")), _whole(item.get("frame"))
    params = item.get("params")
    if params is None:  # the layout of the first versions
        coordinate = item.get("coordinate")
        params = [item.get(f"param{i}") for i in range(1, 5)]
        params += coordinate if isinstance(coordinate, list) else []
    is_list = isinstance(params, list) and len(params) == 7
    if command is None or frame is None or not is_list or not all(_is_param(v) for v in params):
        builder.problems.add(number, f"{label} is incomplete", SAVE_AGAIN)
        return
    values = [NAN if value is None else _float(value) for value in params]
    goes_on = item.get("autoContinue", True)
    builder.add(
        number,
        label,
        command,
        frame,
        values,
        autocontinue=goes_on is not False and goes_on != 0,
        jump_id=_whole(item.get("doJumpId", item.get("id"))),
    )


def _is_param(value: Any) -> bool:
    return value is None or is_number(value)


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # an integer of 400 digits
        return math.inf


def _whole(value: Any) -> int | None:
    if not is_number(value) or value != value or abs(value) > 65535 or int(value) != value:
        return None
    return int(value)


# --- fence and rally points ---


def _areas(fence: dict[str, Any], builder: Builder) -> tuple[Area, ...]:
    problems = builder.problems
    if fence.get("breachReturn"):
        builder.note("the breach return point is not used: a return leads home or to a rally point")
    areas = []
    for kind, read in (("circle", _circle), ("polygon", _polygon)):
        parts = fence.get(f"{kind}s") or []
        if fence.get("version") == 1 and kind == "polygon":
            parts = [{"polygon": fence["polygon"]}] if fence.get("polygon") else []
        if not isinstance(parts, list):
            parts = [parts]
        for number, part in enumerate(parts, 1):
            area = read(mapping(part), f"fence, {kind} {number}")
            if area is None:
                expected = {
                    "circle": "a center and a radius above 0",
                    "polygon": "3 places or more",
                }
                what = f"fence, {kind} {number}: expected {expected[kind]}, found another"
                problems.add(0, what, "draw the fence again, and save the plan")
            else:
                areas.append(area)
    count = sum(len(area.places) for area in areas)
    if len(areas) > MAX_AREAS or count > MAX_FENCE_ITEMS:
        problems.add(
            0,
            f"expected a fence of at most {MAX_AREAS} areas and {MAX_FENCE_ITEMS} places, found "
            f"{len(areas)} and {count}",
            "draw a simpler fence",
        )
    return tuple(areas)


def _circle(part: dict[str, Any], label: str) -> Area | None:
    circle = mapping(part.get("circle"))
    center: Any = circle.get("center")
    radius: Any = circle.get("radius")
    if not is_place(center) or not is_number(radius) or not 0.0 < radius <= MAX_NUMBER:
        return None
    place = (float(center[0]), float(center[1]))
    return Area(_includes(part), (place,), float(radius), label)


def _polygon(part: dict[str, Any], label: str) -> Area | None:
    places = part.get("polygon")
    if not isinstance(places, list) or len(places) < 3 or not all(is_place(p) for p in places):
        return None
    return Area(_includes(part), tuple((float(p[0]), float(p[1])) for p in places), 0.0, label)


def _includes(part: dict[str, Any]) -> bool:
    return part.get("inclusion", True) is not False


def _rally_points(
    rally: dict[str, Any], problems: Problems
) -> tuple[tuple[float, float, float], ...]:
    points = rally.get("points") or []
    if not isinstance(points, list):
        points = [points]
    for number, point in enumerate(points, 1):
        is_good = is_place(point) and len(point) == 3 and is_number(point[2])
        if not is_good or not abs(point[2]) <= MAX_NUMBER:
            problems.add(
                0,
                f"rally point {number}: expected latitude, longitude and height, found another",
                SAVE_AGAIN,
            )
            return ()
    if len(points) > MAX_RALLY_POINTS:
        what = f"expected at most {MAX_RALLY_POINTS} rally points, found {len(points)}"
        problems.add(0, what, "remove some")
        return ()
    return tuple((float(p[0]), float(p[1]), float(p[2])) for p in points)
