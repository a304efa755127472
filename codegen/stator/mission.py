"""Missions: read from YAML or from what ground stations save, given to the vehicle as one message.

North, east and height are metres, from the mission's origin and above home.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stator.diagnostics import Mark, Report, UserError
from stator.library import HOME, Library
from stator.model import TYPES

if TYPE_CHECKING:
    from pathlib import Path

    from stator.model import Field

# Of graph/messages/Mission.yaml.
MOST_ITEMS = 31
NAN = math.nan
FOREVER_S = 1e9
WAYPOINT, RETURN, LAND, TAKEOFF, EIGHT = 16, 20, 21, 22, 35
NAMES = {
    WAYPOINT: "waypoint",
    RETURN: "return",
    LAND: "land",
    TAKEOFF: "takeoff",
    EIGHT: "figure of eight",
}
USUAL_RADIUS_M = 1.0  # how near is there
SHORTEST_EIGHT_M = 2.0  # of apps/navigator/route.cpp
LEAST_CLIMB_M = 0.5
# No vehicle's parameters allow more: `farthest` of the navigator, `fence_height` of the commander.
MOST_AWAY_M = MOST_HEIGHT_M = 10_000.0


@dataclass(frozen=True)
class Item:
    kind: int
    north: float
    east: float
    height: float
    heading: float = NAN
    radius: float = USUAL_RADIUS_M  # of an eight: its length
    hold: float = 0.0  # s; of an eight: its laps
    speed: float = NAN


@dataclass(frozen=True)
class Mission:
    items: tuple[Item, ...]
    origin: tuple[float, float] | None = None  # latitude and longitude in deg; None: home
    fence_radius: float = 0.0  # m; 0: as the commander says
    fence_height: float = 0.0
    limits: dict[str, float] = field(default_factory=dict)  # that make a success: see LIMITS

    @property
    def seconds(self) -> float:
        """Roughly how long it takes, not counting what lasts for ever."""
        total, here = 60.0, (0.0, 0.0, 0.0)
        for item in self.items:
            there = (item.north, item.east, item.height)
            speed = 3.0 if math.isnan(item.speed) else item.speed
            total += math.dist(here, there) / min(speed, 1.0) + 10.0
            laps = 3.0 * item.radius * item.hold / speed
            total += laps if item.kind == EIGHT else min(item.hold, 600.0)
            here = there
        return total


def read_mission(path: Path) -> Mission:
    """Raises `UserError` or `Failed` with what is wrong, and where."""
    from stator.mission_plan import read_plan
    from stator.mission_yaml import read_yaml

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
    if len(items) > MOST_ITEMS:
        hint = f"a vehicle takes at most {MOST_ITEMS}; fly the rest as another mission"
        raise refuse(MOST_ITEMS, f"the mission has {len(items)} items", hint)
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
    if item.kind == TAKEOFF and not item.height >= LEAST_CLIMB_M:
        return f"a height of {item.height:g} m", f"climb {LEAST_CLIMB_M:g} m at least"
    if item.kind != LAND and not item.height > 0.0:
        return f"a height of {item.height:g} m above home", "give it a height above home"
    if 0.0 < mission.fence_height < item.height:
        what = f"{item.height:g} m high, the fence ends at {mission.fence_height:g} m"
        return what, "lower it, or widen the fence"
    if item.height > MOST_HEIGHT_M:
        return f"{item.height:g} m high", f"lower it to {MOST_HEIGHT_M:g} m at most"
    away = math.hypot(item.north, item.east) + (0.5 * item.radius if is_eight else 0.0)
    if away > MOST_AWAY_M:
        return f"{away / 1000:.0f} km away", "is the origin the right one?"
    if 0.0 < mission.fence_radius < away:
        what = f"leads {away:.1f} m away, the fence ends at {mission.fence_radius:g} m"
        return what, "bring it nearer, or widen the fence"
    return None


def packed(mission: Mission) -> bytes:
    """The bytes of the message Mission, as the compiler lays it out."""
    report = Report()
    message = Library(HOME, report).message("Mission", Mark(HOME, 1, 1))
    assert message is not None
    values = _values(mission)
    return b"".join(_packed(f, values.get(f.name, [])) for f in message.fields)


def _values(mission: Mission) -> dict[str, list[float]]:
    origin = mission.origin or (NAN, NAN)
    columns = ("kind", "north", "east", "height", "heading", "radius", "hold", "speed")
    return {
        "origin_lat": [origin[0]],
        "origin_lon": [origin[1]],
        "fence_radius": [mission.fence_radius],
        "fence_height": [mission.fence_height],
        "count": [len(mission.items)],
        **{name: [getattr(item, name) for item in mission.items] for name in columns},
    }


_CODES = {"uint8": "B", "uint64": "Q", "float": "f", "double": "d"}


def _packed(item: Field, values: list[float]) -> bytes:
    count = item.count or 1
    filled = [*values, *[0] * (count - len(values))]
    data = struct.pack(f"<{count}{_CODES[item.type]}", *filled)
    assert len(data) == TYPES[item.type][2] * count
    return data
