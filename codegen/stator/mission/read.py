"""Reads a mission from YAML or from a ground station's file, and checks it."""

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
    """Raises `UserError` or `Failed`."""

    try:
        start = path.read_bytes()[:64].lstrip()
    except OSError as error:
        raise UserError(
            f"error: cannot read the mission '{path}': {error.strerror}\n"
            "hint: give a mission, for example graph/missions/square.yaml or a ground station's "
            ".plan"
        ) from error
    is_plan = start.startswith((b"{", b"QGC WPL"))
    mission = read_plan(path) if is_plan else read_yaml(path)
    _check(path, mission)
    return mission


def _check(path: Path, mission: Mission) -> None:
    """Refuses what the vehicle would refuse later without a reason."""
    items = mission.items

    def refuse(number: int, what: str, hint: str) -> UserError:
        name = NAMES[items[number].kind] if items else "nothing"
        return UserError(f"error: {path}: item {number + 1}, {name}: {what}\nhint: {hint}")

    if not items:
        raise UserError(
            f"error: {path}: expected at least one item, found none\nhint: add a takeoff first"
        )
    if len(items) > MAX_ITEMS:
        what = f"expected at most {MAX_ITEMS} items, found {len(items)}"
        raise refuse(MAX_ITEMS, what, "fly the rest as another mission")
    for number, item in enumerate(items):
        if (item.kind == TAKEOFF) != (number == 0):
            first = number == 0
            what = "expected a takeoff as the first item" if first else "duplicate takeoff"
            raise refuse(number, what, "add a takeoff in front" if first else "remove it")
        ends = item.kind in (RETURN, LAND) or item.hold >= FOREVER_S
        if ends and number + 1 < len(items):
            raise refuse(
                number + 1,
                "never reached: the item before it ends the mission",
                "remove this item and those behind it",
            )
        fault = None if item.kind == RETURN else _fault(item, mission)
        if fault is not None:
            raise refuse(number, *fault)


def _fault(item: Item, mission: Mission) -> tuple[str, str] | None:
    """The error in the item's size or place, and the hint; None if there is none."""
    is_eight = item.kind == EIGHT
    if is_eight and not item.radius >= SHORTEST_EIGHT_M:
        least = f"{SHORTEST_EIGHT_M:g} m"
        what = f"expected a length of at least {least}, found {item.radius:g} m"
        return what, f"write {least} or more; the length is twice the radius"
    if item.kind == TAKEOFF and not item.height >= MIN_CLIMB_M:
        what = f"expected a height of at least {MIN_CLIMB_M:g} m, found {item.height:g} m"
        return what, f"write {MIN_CLIMB_M:g} m or more"
    if item.kind != LAND and not item.height > 0.0:
        what = f"expected a height above 0 m, found {item.height:g} m"
        return what, "give it a height above home"
    if 0.0 < mission.fence_height < item.height:
        what = (
            f"expected a height of at most {mission.fence_height:g} m (the fence), found "
            f"{item.height:g} m"
        )
        return what, "lower it, or enlarge the fence"
    if item.height > MAX_HEIGHT_M:
        what = f"expected a height of at most {MAX_HEIGHT_M:g} m, found {item.height:g} m"
        return what, "lower it"
    away = math.hypot(item.north, item.east) + (0.5 * item.radius if is_eight else 0.0)
    if away > MAX_AWAY_M:
        what = (
            f"expected a distance of at most {MAX_AWAY_M / 1000:g} km, found {away / 1000:.0f} km"
        )
        return what, "check the origin of the mission"
    if 0.0 < mission.fence_radius < away:
        what = (
            f"expected a distance of at most {mission.fence_radius:g} m (the fence), found "
            f"{away:.1f} m"
        )
        return what, "move it closer, or enlarge the fence"
    return None
