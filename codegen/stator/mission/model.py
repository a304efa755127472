"""Missions, read from YAML or from the files of ground stations, and sent as one message.

North and east are metres from the origin of the mission; height is metres above home.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stator import HOME
from stator.build.cpp_source import constant
from stator.diagnostics import Mark, Report
from stator.graph.messages import find_message, own_field
from stator.graph.model import TYPES
from stator.graph.sources import Sources

if TYPE_CHECKING:
    from stator.graph.model import Field

MAX_ITEMS = own_field("Mission", "kind").count or 0
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
USUAL_RADIUS_M = 1.0  # the distance at which a waypoint counts as reached
SHORTEST_EIGHT_M = constant("apps/navigator/route.cpp", "kShortestEight")
MIN_CLIMB_M = 0.5
# The limits of the parameters `farthest` of the navigator and `fence_height` of the commander.
MAX_AWAY_M = MAX_HEIGHT_M = 10_000.0


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
    fence_radius: float = 0.0  # m; 0: the commander's parameter
    fence_height: float = 0.0
    limits: dict[str, float] = field(default_factory=dict)  # of a successful flight: see LIMITS

    @property
    def seconds(self) -> float:
        """Roughly how long it takes, without items that have no end."""
        total, here = 60.0, (0.0, 0.0, 0.0)
        for item in self.items:
            there = (item.north, item.east, item.height)
            speed = 3.0 if math.isnan(item.speed) else item.speed
            total += math.dist(here, there) / min(speed, 1.0) + 10.0
            laps = 3.0 * item.radius * item.hold / speed
            total += laps if item.kind == EIGHT else min(item.hold, 600.0)
            here = there
        return total


def packed(mission: Mission) -> bytes:
    """The bytes of the message Mission, as the compiler lays it out."""
    report = Report()
    message = find_message(Sources(HOME, report), "Mission", Mark(HOME, 1, 1))
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
