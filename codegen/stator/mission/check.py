"""Refuses before the flight what the vehicle would refuse, or would turn back from."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stator.mission.commands import (
    ABOVE_SEA,
    ALTITUDES,
    DELAY,
    EIGHT,
    FLOWN,
    LANDINGS,
    LOITER_TURNS,
    PLACES,
    RETURN,
    TAKEOFFS,
)
from stator.mission.fence import Fence
from stator.mission.geodesy import to_local
from stator.mission.model import (
    MAX_AWAY_M,
    MAX_HEIGHT_M,
    MAX_ITEMS,
    MIN_CLIMB_M,
    SHORTEST_EIGHT_M,
)
from stator.mission.route import origin_of, walk

if TYPE_CHECKING:
    from stator.mission.model import Item, Mission
    from stator.mission.problems import Problems
    from stator.mission.route import Route, Visit
    from stator.mission.vehicle import Vehicle

BELOW_CEILING = 0.9  # apps/navigator/navigator.cpp


def check(mission: Mission, vehicle: Vehicle, problems: Problems) -> tuple[str, ...]:
    """What is worth a note but no error."""
    if not any(item.command in FLOWN for item in mission.items):
        if not len(problems):
            problems.add(0, "expected at least one item, found none", "add a takeoff first")
        return ()
    if len(mission.items) > MAX_ITEMS:
        over = mission.items[MAX_ITEMS]
        what = f"expected at most {MAX_ITEMS} items, found {len(mission.items)}"
        problems.add(over.number, f"{over.label}: {what}", "fly the rest as another mission")
    if not _check_heights(mission, problems):
        return ()
    route = walk(mission, vehicle)
    if route.loops is not None:
        what = f"{route.loops.label}, jump: it leads round without a place to fly to"
        problems.add(route.loops.number, what, "jump to an item in front of a waypoint")
    checker = _Checker(mission, vehicle, problems)
    for visit in route.visits:
        checker.check_visit(visit)
    checker.check_rally_points()
    return (*_notes(mission, route), *checker.notes())


def _check_heights(mission: Mission, problems: Problems) -> bool:
    """Whether all heights are known."""
    has_altitude = mission.home is not None and mission.home.altitude is not None
    above_sea = [
        item
        for item in mission.items
        if item.frame in ABOVE_SEA
        and item.command in (PLACES | TAKEOFFS | ALTITUDES) - LANDINGS
        and math.isfinite(item.z)
    ]
    if above_sea and not has_altitude:
        first = above_sea[0]
        problems.add(
            first.number,
            f"{first.label}, {first.name}: its height is above the sea, and the planned home has "
            "no altitude",
            "set the altitude of the planned home, or give heights above home",
        )
        return False
    return True


def _notes(mission: Mission, route: Route) -> list[str]:
    notes = []
    first = route.visits[0].item if route.visits else None
    if first is not None and first.command not in TAKEOFFS | {DELAY, RETURN}:
        notes.append(f"no take-off: it climbs to the height of {first.label} first")
    if route.waits is not None:
        notes.append(f"{route.waits.label}: without autocontinue, the mission waits behind it")
    elif route.ends == "hold" and not route.is_endless:
        notes.append("no landing at the end: it holds there, then returns; hint: add a return")
    elif route.is_endless:
        notes.append(
            "it has no end: it goes on until the pilot or a failsafe ends it; "
            "hint: end it with a return"
        )
    flown = route.flown
    never = [
        item.label
        for index, item in enumerate(mission.items)
        if item.command in FLOWN and index not in flown
    ]
    if never and route.waits is None and not route.is_endless:
        shown = ", ".join(dict.fromkeys(never[:3])) + (" and more" if len(never) > 3 else "")
        notes.append(f"{shown}: never flown, as the mission ends before")
    return notes


class _Checker:
    """Each problem once for each item, however often it is flown."""

    def __init__(self, mission: Mission, vehicle: Vehicle, problems: Problems) -> None:
        self._mission = mission
        self._vehicle = vehicle
        self._problems = problems
        self._origin = origin_of(mission)
        self._fence = Fence(mission.areas, self._origin)
        self._faulty: set[int] = set()
        own = mission.ceiling > 0.0
        self._ceiling = mission.ceiling if own else vehicle.fence_height
        self._lid = "the fence" if own else "the fence of the vehicle, navigator.fence_height"
        self._radius = 0.0 if self._fence.includes else vehicle.fence_radius

    def check_visit(self, visit: Visit) -> None:
        if visit.index in self._faulty:
            return
        item = visit.item
        fault = self._fault_of_values(item) or self._fault_of_place(visit)
        if fault is None and item.command not in (RETURN, DELAY):
            left = self._fence.left_between(visit.before.point, visit.place.point)
            if left:
                fault = (
                    f"expected a way inside the fence, found one that leads {left}",
                    "add a waypoint to lead around, or change the fence",
                )
        if fault is not None:
            self._faulty.add(visit.index)
            self._problems.add(item.number, f"{item.label}, {item.name}: {fault[0]}", fault[1])

    @staticmethod
    def _fault_of_values(item: Item) -> tuple[str, str] | None:
        length = 2.0 * item.params[0]
        if item.command == EIGHT and not length >= SHORTEST_EIGHT_M:
            least = f"{SHORTEST_EIGHT_M:g} m"
            what = f"expected a length of at least {least}, found {length:g} m"
            return what, f"write {least} or more; the length is twice the radius"
        return None

    def _fault_of_place(self, visit: Visit) -> tuple[str, str] | None:
        item, height = visit.item, visit.place.height
        if item.command in (RETURN, DELAY):
            return None
        if item.command in TAKEOFFS and not height >= MIN_CLIMB_M:
            what = f"expected a height of at least {MIN_CLIMB_M:g} m, found {height:g} m"
            return what, f"write {MIN_CLIMB_M:g} m or more"
        if item.command not in LANDINGS and not height > 0.0:
            what = f"expected a height above 0 m, found {height:g} m"
            return what, "give it a height above home"
        if 0.0 < self._ceiling < height:
            what = f"expected a height of at most {self._ceiling:g} m ({self._lid}), found"
            return f"{what} {height:g} m", "lower it, or enlarge the fence"
        if height > MAX_HEIGHT_M:
            what = f"expected a height of at most {MAX_HEIGHT_M:g} m, found {height:g} m"
            return what, "lower it"
        return self._fault_of_distance(visit)

    def _fault_of_distance(self, visit: Visit) -> tuple[str, str] | None:
        item, point = visit.item, visit.place.point
        reach = {EIGHT: item.params[0], LOITER_TURNS: abs(item.params[2])}.get(item.command, 0.0)
        away = math.hypot(*point) + reach
        if away > MAX_AWAY_M:
            most = f"{MAX_AWAY_M / 1000:g} km"
            what = f"expected a distance of at most {most}, found {away / 1000:.0f} km"
            return what, "check the origin of the mission"
        for limit, name in (
            (self._radius, "fence_radius"),
            (self._vehicle.farthest, "farthest"),
        ):
            if 0.0 < limit < away:
                kind = "the fence of the vehicle, " if name == "fence_radius" else ""
                what = f"expected a distance of at most {limit:g} m ({kind}navigator.{name})"
                hint = f"move it closer, or raise navigator.{name} in the graph"
                if name == "fence_radius":
                    hint += "; a fence in the mission takes its place"
                return f"{what}, found {away:.1f} m", hint
        own = self._fence.home_radius
        if 0.0 < own < away:
            what = f"expected a distance of at most {own:g} m (the fence), found {away:.1f} m"
            return what, "move it closer, or enlarge the fence"
        around = [point]
        if reach > 0.0:
            start = math.atan2(point[1], point[0])
            for turn in range(8):
                angle = start + turn * math.pi / 4
                around.append(
                    (point[0] + reach * math.cos(angle), point[1] + reach * math.sin(angle))
                )
        for place in around:
            left = self._fence.left_at(place)
            if left:
                what = f"expected a place inside the fence, found it {left}"
                return what, "move it closer, or enlarge the fence"
        return None

    def check_rally_points(self) -> None:
        for number, (latitude, longitude, height) in enumerate(self._mission.rally, 1):
            place = (latitude, longitude)
            point = to_local(self._origin or place, place)
            left = self._fence.left_at(point)
            away = math.hypot(*point)
            if not left and 0.0 < self._radius < away:
                left = f"{away:.1f} m from home, farther than the fence of the vehicle"
            if not left and 0.0 < self._ceiling < height:
                left = f"{height:g} m high, above the fence of {self._ceiling:g} m"
            if left:
                what = f"rally point {number}: expected it inside the fence, found it {left}"
                self._problems.add(0, what, "move it, or enlarge the fence")

    def notes(self) -> list[str]:
        most = BELOW_CEILING * self._ceiling
        if not 0.0 < most < self._vehicle.return_height:
            return []
        height = f"{self._vehicle.return_height:g} m"
        return [f"a return stays below the fence: at {most:g} m, in place of {height}"]
