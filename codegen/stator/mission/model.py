"""A mission as ground and vehicle have it: items with the fields of MAVLink's MISSION_ITEM_INT,
a fence, rally points."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from stator.build.cpp_source import constant
from stator.mission.commands import LOCAL, NO_PLACE, PLACES, TAKEOFFS, name_of

NAN = math.nan
USUAL_RADIUS_M = constant("apps/navigator/item.hpp", "kUsualRadius")
SHORTEST_EIGHT_M = constant("apps/navigator/item.hpp", "kShortestEight")
_STORE = "drivers/mission/mission_store.hpp"
MAX_ITEMS = int(constant(_STORE, "kMaxItems"))
MAX_FENCE_ITEMS = int(constant(_STORE, "kMaxFenceItems"))
MAX_RALLY_POINTS = int(constant(_STORE, "kMaxRallyPoints"))
MAX_AREAS = int(constant("apps/navigator/geofence.hpp", "kMaxAreas"))
MAX_JUMPS = int(constant("apps/navigator/sequence.hpp", "kMaxJumps"))
MIN_CLIMB_M = 0.5
# The limits of the navigator's parameters `farthest` and `fence_height`.
MAX_AWAY_M = MAX_HEIGHT_M = 10_000.0


@dataclass(frozen=True)
class Item:
    """`x`, `y`: latitude and longitude in deg, in the local frame metres north and east of home;
    not a number: none. `z`: the height, also in the local frame."""

    command: int
    frame: int
    params: tuple[float, float, float, float]
    x: float = NAN
    y: float = NAN
    z: float = NAN
    autocontinue: bool = True
    number: int = 0  # in its file, from 1
    label: str = ""  # how messages name it: "item 3", "item 3, point 5"
    is_extra: bool = False  # the file has no item for it

    @property
    def name(self) -> str:
        return name_of(self.command)

    @property
    def has_place(self) -> bool:
        if self.frame == NO_PLACE or not (math.isfinite(self.x) and math.isfinite(self.y)):
            return False
        return self.frame == LOCAL or (self.x, self.y) != (0.0, 0.0)

    @property
    def is_reached(self) -> bool:
        """Whether a report counts it."""
        return self.command in PLACES | TAKEOFFS and not self.is_extra


@dataclass(frozen=True)
class Area:
    """A part of a fence: the places of a polygon, or a circle about its one place. A circle about
    home has none."""

    includes: bool
    places: tuple[tuple[float, float], ...]  # latitude, longitude
    radius: float = 0.0  # of a circle
    label: str = "the fence"


@dataclass(frozen=True)
class Home:
    latitude: float
    longitude: float
    altitude: float | None = None  # above mean sea level


@dataclass(frozen=True)
class Mission:
    items: tuple[Item, ...]
    home: Home | None = None  # where it was planned; None: where it is flown
    areas: tuple[Area, ...] = ()
    ceiling: float = 0.0  # m above home; 0: the navigator's parameter
    rally: tuple[tuple[float, float, float], ...] = ()  # latitude, longitude, height above home
    notes: tuple[str, ...] = ()  # what is not done as the file has it
    limits: dict[str, float] = field(default_factory=dict)  # of a successful flight: see LIMITS
