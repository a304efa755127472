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
        if item.kind == TAKEOFF and item.height < 0.5:
            raise refuse(number, f"a height of {item.height:g} m", "climb 0.5 m at least")
        distance = math.hypot(item.north, item.east)
        if item.kind != RETURN and distance > 100_000.0:
            raise refuse(number, f"{distance / 1000:.0f} km away", "is the origin the right one?")


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
