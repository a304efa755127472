"""Reads a mission from YAML or from what ground stations save, and checks it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stator.diagnostics import UserError
from stator.mission.model import (
    EIGHT,
    FOREVER_S,
    LAND,
    MAX_AWAY_M,
    MAX_HEIGHT_M,
    MAX_ITEMS,
    MIN_CLIMB_M,
    NAMES,
    RETURN,
    SHORTEST_EIGHT_M,
    TAKEOFF,
    Item,
    Mission,
)
from stator.mission.plan_file import read_plan
from stator.mission.yaml import read_yaml

if TYPE_CHECKING:
    from pathlib import Path


def read_mission(path: Path) -> Mission:
    """Raises `UserError` or `Failed` with what is wrong, and where."""

    try:
        start = path.read_bytes()[:64].lstrip()
    except OSError as error:
        raise UserError(
            f"error: cannot read the mission '{path}': {error.strerror}\n"
            "hint: name a mission such as graph/missions/square.yaml, or a ground station's .plan"
        ) from error
    is_plan = start.startswith((b"{", b"QGC WPL"))
    mission = read_plan(path) if is_plan else read_yaml(path)
    _check(path, mission)
    return mission


def _check(path: Path, mission: Mission) -> None:
    """What the vehicle would refuse later, without saying why."""
    items = mission.items

    def refuse(number: int, what: str, hint: str) -> UserError:
        name = NAMES[items[number].kind] if items else "nothing"
        return UserError(f"error: {path}: item {number + 1}, {name}: {what}\nhint: {hint}")

    if not items:
        raise UserError(f"error: {path}: the mission has no items\nhint: begin with a take-off")
    if len(items) > MAX_ITEMS:
        hint = f"a vehicle takes at most {MAX_ITEMS}; fly the rest as another mission"
        raise refuse(MAX_ITEMS, f"the mission has {len(items)} items", hint)
    for number, item in enumerate(items):
        if (item.kind == TAKEOFF) != (number == 0):
            first = number == 0
            what = "a mission begins with a take-off" if first else "a second take-off"
            raise refuse(number, what, "put a take-off in front" if first else "remove it")
        ends = item.kind in (RETURN, LAND) or item.hold >= FOREVER_S
        if ends and number + 1 < len(items):
            raise refuse(
                number + 1,
                "is never reached: the item before ends the mission",
                "remove what stands behind the end",
            )
        fault = None if item.kind == RETURN else _fault(item, mission)
        if fault is not None:
            raise refuse(number, *fault)


def _fault(item: Item, mission: Mission) -> tuple[str, str] | None:
    """What is wrong with its size or place, and what to do."""
    is_eight = item.kind == EIGHT
    if is_eight and not item.radius >= SHORTEST_EIGHT_M:
        least = f"{SHORTEST_EIGHT_M:g} m"
        return f"a length of {item.radius:g} m", f"make it {least} long at least: twice its radius"
    if item.kind == TAKEOFF and not item.height >= MIN_CLIMB_M:
        return f"a height of {item.height:g} m", f"climb {MIN_CLIMB_M:g} m at least"
    if item.kind != LAND and not item.height > 0.0:
        return f"a height of {item.height:g} m above home", "give it a height above home"
    if 0.0 < mission.fence_height < item.height:
        what = f"{item.height:g} m high, the fence ends at {mission.fence_height:g} m"
        return what, "lower it, or widen the fence"
    if item.height > MAX_HEIGHT_M:
        return f"{item.height:g} m high", f"lower it to {MAX_HEIGHT_M:g} m at most"
    away = math.hypot(item.north, item.east) + (0.5 * item.radius if is_eight else 0.0)
    if away > MAX_AWAY_M:
        return f"{away / 1000:.0f} km away", "is the origin the right one?"
    if 0.0 < mission.fence_radius < away:
        what = f"leads {away:.1f} m away, the fence ends at {mission.fence_radius:g} m"
        return what, "bring it nearer, or widen the fence"
    return None
