"""A mission as the vehicle flies it: from place to place, with its jumps, and how long it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stator.mission.commands import (
    ABOVE_HOME,
    ABOVE_SEA,
    ALTITUDES,
    CHANGE_SPEED,
    CONDITION_ALTITUDE,
    CONDITION_DELAY,
    DELAY,
    EIGHT,
    ENDS,
    FLOWN,
    JUMP,
    LANDINGS,
    LOCAL,
    LOITER_TIME,
    LOITER_TURNS,
    LOITER_UNLIMITED,
    RETURN,
    TAKEOFFS,
    WAYPOINT,
)
from stator.mission.geodesy import to_local

if TYPE_CHECKING:
    from stator.mission.model import Item, Mission
    from stator.mission.vehicle import Vehicle

MAX_VISITS = 200_000  # of items; longer missions have jumps, and repeat themselves
ARMING_S = 10.0
LANDING_S = 10.0
# A stop and the wait for the vehicle to be there.
STOP_S = 4.0


@dataclass(frozen=True)
class Place:
    north: float
    east: float
    height: float

    @property
    def point(self) -> tuple[float, float]:
        return self.north, self.east


@dataclass(frozen=True)
class Visit:
    """One flight to the place of an item."""

    index: int
    item: Item
    before: Place
    place: Place
    seconds: float  # way and stay


@dataclass(frozen=True)
class Route:
    visits: tuple[Visit, ...]
    is_endless: bool  # it loiters or jumps for ever
    loops: Item | None  # a jump that leads round without a place
    waits: Item | None  # the first item that the mission waits behind for the pilot
    ends: str  # "return", "land", "loiter", "hold"
    speeds: tuple[float, float, float]  # at its end: level, climb, descent

    @property
    def flown(self) -> frozenset[int]:
        return frozenset(visit.index for visit in self.visits)


def origin_of(mission: Mission) -> tuple[float, float] | None:
    """The planned home, or else the first place on Earth; None: there is none."""
    if mission.home is not None:
        return mission.home.latitude, mission.home.longitude
    places = (i for i in mission.items if i.has_place and i.frame != LOCAL and i.command in FLOWN)
    return next(((item.x, item.y) for item in places), None)


def height_of(item: Item, mission: Mission) -> float:
    """Above home; not a number: it has none, or home's altitude is not known."""
    if item.frame in ABOVE_HOME or item.frame == LOCAL:
        return item.z
    if item.frame in ABOVE_SEA and mission.home is not None and mission.home.altitude is not None:
        return item.z - mission.home.altitude
    return math.nan


def walk(mission: Mission, vehicle: Vehicle) -> Route:
    """What the vehicle does: apps/navigator/sequence.hpp."""
    origin = origin_of(mission)
    speeds = {1: vehicle.speed, 2: vehicle.climb_rate, 3: vehicle.descent_rate}
    usual = dict(speeds)
    left: dict[int, float] = {}
    flown_before: dict[int, int] = {}
    visits: list[Visit] = []
    here = Place(0.0, 0.0, 0.0)
    at, since_place, delay = 0, 0, 0.0

    def route(
        *,
        endless: bool = False,
        loops: Item | None = None,
        waits: Item | None = None,
        ends: str = "hold",
    ) -> Route:
        at_end = (speeds[1], speeds[2], speeds[3])
        return Route(tuple(visits), endless, loops, waits, ends, at_end)

    while at < len(mission.items) and len(visits) < MAX_VISITS:
        item = mission.items[at]
        since_place += 1
        if since_place > 2 * len(mission.items) + 2:
            return route(endless=True, loops=item)
        if item.command == CHANGE_SPEED:
            kind = max(int(item.params[0]), 1)
            if item.params[1] == -2.0:
                speeds[kind] = usual[kind]
            elif item.params[1] > 0.0:
                speeds[kind] = item.params[1]
        elif item.command == CONDITION_DELAY:
            delay += max(item.params[0], 0.0)
        elif item.command == JUMP:
            target, repeats = item.params[:2]
            remaining = left.get(at, repeats)
            if remaining < 0.0 and at in left:
                # For ever, if it has flown anywhere since the jump before.
                has_flown = len(visits) > flown_before.get(at, 0)
                return route(endless=True, loops=None if has_flown else item)
            flown_before[at] = len(visits)
            left[at] = remaining - 1.0 if remaining > 0.0 else remaining
            if remaining == 0.0:
                left.pop(at)
            else:
                at = int(target)
                continue
        elif item.command in FLOWN:
            place = _place(item, here, mission, origin)
            seconds = max(_seconds(item, here, place, speeds, vehicle), delay)
            visits.append(Visit(at, item, here, place, seconds))
            here, since_place, delay = place, 0, 0.0
            if item.command in ENDS:
                ends = {RETURN: "return", LOITER_UNLIMITED: "loiter"}.get(item.command, "land")
                return route(endless=ends == "loiter", ends=ends)
            if not item.autocontinue:
                return route(waits=item)
        at += 1
    return route(endless=len(visits) == MAX_VISITS)


def _place(
    item: Item, before: Place, mission: Mission, origin: tuple[float, float] | None
) -> Place:
    """What an item leaves out is as before."""
    if item.command in (RETURN, DELAY):
        return before
    height = height_of(item, mission)
    result = before if math.isnan(height) else replace(before, height=height)
    if item.command in LANDINGS:
        result = before
    if not item.has_place or item.command in TAKEOFFS | ALTITUDES:
        return result
    north, east = (
        (item.x, item.y) if item.frame == LOCAL else to_local(origin or (0, 0), (item.x, item.y))
    )
    return replace(result, north=north, east=east)


def _seconds(
    item: Item, before: Place, place: Place, speeds: dict[int, float], vehicle: Vehicle
) -> float:
    first, _, third, _ = item.params
    climb = place.height - before.height
    rate = speeds[2] if climb > 0.0 else speeds[3]
    if item.command == CONDITION_ALTITUDE and first > 0.0:
        rate = first
    speed = speeds[1]
    level = math.dist(before.point, place.point)
    way = max(level / speed, abs(climb) / rate) + speed / vehicle.acceleration
    stay = 0.0
    if item.command in (WAYPOINT, LOITER_TIME, DELAY) and first > 0.0:
        stay = first
    elif item.command == EIGHT:
        # The speed in the middle is sqrt(2) A p', once round is 2 pi.
        stay = max(third, 1.0) * math.tau * math.sqrt(2.0) * first / speed
        stay += speed / vehicle.eight_acceleration
    elif item.command == LOITER_TURNS and third:
        pace = min(speed, math.sqrt(vehicle.eight_acceleration * abs(third)))
        stay = math.tau * abs(third) * first / pace + pace / vehicle.eight_acceleration
    is_passed = item.command == WAYPOINT and first <= 0.0
    return way + stay + (0.0 if is_passed else STOP_S)


def seconds_of(mission: Mission, vehicle: Vehicle) -> float:
    """How long the flight takes, to the end of the landing. What has no end counts once."""
    route = walk(mission, vehicle)
    total = ARMING_S + vehicle.spool_up_time + sum(visit.seconds for visit in route.visits)
    last = route.visits[-1].place if route.visits else Place(0.0, 0.0, 0.0)
    speed, climb, descent = route.speeds
    if route.ends in ("hold", "loiter"):
        total += vehicle.wait_limit
        speed, climb, descent = vehicle.speed, vehicle.climb_rate, vehicle.descent_rate
    height = last.height
    if route.ends != "land":
        height = max(height, vehicle.return_height)
        total += math.hypot(*last.point) / speed + 2 * STOP_S
        total += (height - last.height) / climb
    total += max(height - vehicle.landing_height, 0.0) / descent
    return total + vehicle.landing_height / vehicle.landing_rate + LANDING_S
