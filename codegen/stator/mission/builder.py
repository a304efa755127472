"""Makes items of a mission from the fields of MAVLink that a file has, and says what is wrong with
them, or not done as they say."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from stator.mission.commands import (
    ABOVE_HOME,
    ABOVE_SEA,
    ABOVE_TERRAIN,
    ALTITUDES,
    CHANGE_SPEED,
    CONDITION_ALTITUDE,
    DELAY,
    EIGHT,
    FLOWN,
    JUMP,
    KNOWN,
    LOCAL,
    LOITER_TIME,
    LOITER_UNLIMITED,
    NO_PLACE,
    PASSED_BY,
    PLACES,
    REGION,
    REGION_NAV,
    REGION_PLACE,
    SPEED_TYPES,
    SPLINE,
    TAKEOFFS,
    VTOL_LAND,
    VTOL_TAKEOFF,
    WAYPOINT,
    missing_device,
    name_of,
)
from stator.mission.model import MAX_JUMPS, NAN, Item

if TYPE_CHECKING:
    from stator.mission.problems import Problems

MAX_NUMBER = 1e9
MARK = 189  # does nothing
SUPPORTED = (
    "waypoints, loiters, take-off, landing, return, figure of eight, delays and conditions, "
    "changes of speed and altitude, jumps, regions of interest"
)
REMOVE = f"remove it; supported: {SUPPORTED}; commands of cameras and gimbals are passed by"


def _with_zeros(item: Item) -> Item:
    """A parameter that is not given is 0, but for those where that means something."""
    if item.command in PASSED_BY | {CHANGE_SPEED, JUMP}:
        return item
    first, second, third = (0.0 if math.isnan(p) else p for p in item.params[:3])
    return replace(item, params=(first, second, third, item.params[3]))


def _without_values(item: Item) -> Item:
    command = item.command if item.command in FLOWN else MARK
    is_place = abs(item.x) <= 90.0 and abs(item.y) <= 180.0
    x, y = (item.x, item.y) if is_place else (NAN, NAN)
    z = item.z if abs(item.z) <= MAX_NUMBER else NAN
    params = (1.0, 0.0, 0.0, NAN)
    return replace(item, command=command, params=params, x=x, y=y, z=z)


class Builder:
    """Collects the items of one file."""

    def __init__(self, problems: Problems, *, is_ardupilot: bool = False) -> None:
        self.problems = problems
        self.items: list[Item] = []
        self._is_ardupilot = is_ardupilot  # does not use the heading of a waypoint; files have 0
        self._notes: dict[str, list[str]] = {}  # note -> labels of items
        self._ids: dict[int, int] = {}  # by which a jump names an item -> its index

    @property
    def notes(self) -> tuple[str, ...]:
        rows = []
        for note, labels in self._notes.items():
            first = [*dict.fromkeys(labels)]
            shown = ", ".join(first[:5]) + (f" and {len(first) - 5} more" if len(first) > 5 else "")
            rows.append(f"{shown}: {note}" if shown else note)
        return tuple(rows)

    def note(self, text: str, label: str = "") -> None:
        self._notes.setdefault(text, []).extend([label] if label else [])

    def add(
        self,
        number: int,
        label: str,
        command: int,
        frame: int,
        values: list[float],
        *,
        autocontinue: bool = True,
        jump_id: int | None = None,
        is_extra: bool = False,
    ) -> None:
        """`values`: seven parameters; not a number: not given."""
        if jump_id is not None:
            self._ids.setdefault(jump_id, len(self.items))
        item = Item(
            command,
            self._frame(number, label, command, frame),
            (values[0], values[1], values[2], values[3]),
            values[4],
            values[5],
            values[6],
            autocontinue,
            number,
            label,
            is_extra,
        )
        before = len(self.problems)
        if self._is_good(item, values):
            item = self._checked(_with_zeros(item))
        # One with an error stays only as a place, so that what follows can be checked.
        is_wrong = len(self.problems) > before
        self.items.append(_without_values(item) if is_wrong else item)

    def _error(self, item: Item, what: str, hint: str) -> None:
        self.problems.add(item.number, f"{item.label}, {item.name}: {what}", hint)

    def _frame(self, number: int, label: str, command: int, frame: int) -> int:
        """The frame, or none for a command that has no place."""
        if command not in PLACES | TAKEOFFS | ALTITUDES | {REGION, REGION_NAV, REGION_PLACE}:
            return NO_PLACE
        if frame in ABOVE_SEA | ABOVE_HOME | {LOCAL, NO_PLACE}:
            return frame
        what = "heights above terrain" if frame in ABOVE_TERRAIN else "its places"
        self.problems.add(
            number,
            f"{label}, {name_of(command)}: frame {frame} is not supported ({what})",
            "give heights above home (frame 3) or above mean sea level (frame 0)",
        )
        return NO_PLACE

    def _is_good(self, item: Item, values: list[float]) -> bool:
        before = len(self.problems)
        if item.command not in KNOWN | PASSED_BY:
            self.problems.add(
                item.number,
                f"{item.label} is '{item.name}' ({item.command}), which is not supported",
                REMOVE,
            )
            return False
        for index, value in enumerate(values, 1):
            if abs(value) > MAX_NUMBER:
                what = (
                    f"parameter {index}: expected a number from {-MAX_NUMBER:g} to {MAX_NUMBER:g}"
                )
                self._error(item, f"{what}, found another", "correct it, and save the plan again")
        is_on_earth = not abs(item.x) > 90.0 and not abs(item.y) > 180.0
        if item.frame not in (LOCAL, NO_PLACE) and not is_on_earth:
            what = f"expected a latitude and longitude, found {item.x:g}, {item.y:g}"
            self._error(item, what, "correct it, and save the plan again")
        return len(self.problems) == before

    def _checked(self, item: Item) -> Item:
        first, second, third, fourth = item.params
        if item.command in PASSED_BY:
            device = missing_device(item.command)
            if device:
                self.note(f"{item.name}: passed by, as this vehicle has no {device}", item.label)
        elif item.command == CHANGE_SPEED:
            self._check_speed(item)
        elif item.command in (WAYPOINT, SPLINE):
            if item.command == SPLINE:
                self.note("spline waypoint: flown in a straight line", item.label)
            elif third:
                self.note("the radius to pass it by is not used", item.label)
            if self._is_ardupilot and fourth == 0.0:
                return replace(item, params=(first, second, third, NAN))
        elif item.command == EIGHT and not first > 0.0:
            what = f"expected a radius above 0 m, found {first:g} m"
            self._error(
                item, what, "give a radius above 0; for the other direction turn its heading"
            )
        elif item.command in (LOITER_UNLIMITED, LOITER_TIME) and third:
            self.note("it hovers at the place: the radius is for vehicles with wings", item.label)
        elif item.command == DELAY and first < 0.0:
            what = "expected a delay in seconds, found a time of day, which is not supported"
            self._error(item, what, "give the seconds in parameter 1")
        elif item.command in (REGION, REGION_NAV) and first in (2.0, 4.0):
            kind = "an item" if first == 2.0 else "a moving target"
            what = f"expected a place to look at, found {kind}, which is not supported"
            self._error(item, what, "use the region of interest by location (195)")
        elif item.command in (VTOL_TAKEOFF, VTOL_LAND):
            self.note("flown without wings, as take-off and landing", item.label)
        elif item.command == CONDITION_ALTITUDE and not first >= 0.0:
            what = f"expected a climb rate of at least 0 m/s, found {first:g} m/s"
            self._error(item, what, "give the rate without a sign")
        if item.command in TAKEOFFS | ALTITUDES and not math.isfinite(item.z):
            self._error(item, "expected a height, found none", "give it a height above home")
        return item

    def _check_speed(self, item: Item) -> None:
        kind, speed, throttle, is_relative = item.params
        if kind not in SPEED_TYPES:
            known = ", ".join(f"{k} {name}" for k, name in SPEED_TYPES.items())
            self._error(item, f"unknown type of speed {kind:g}", f"known: {known}")
        elif kind == 0:
            note = "airspeed: taken as speed over ground, as this vehicle does not measure it"
            self.note(note, item.label)
        if not (speed > 0.0 or speed in (-1.0, -2.0)):
            what = f"expected a speed above 0 m/s, -1 or -2, found {speed:g}"
            self._error(item, what, "-1 changes nothing, -2 is the vehicle's own speed")
        if throttle > 0.0:
            self.note("the throttle of a change of speed is not used", item.label)
        if is_relative == 1.0:
            self._error(item, "a relative speed is not supported", "give the speed itself")

    def finish(self) -> tuple[Item, ...]:
        """The items, with jumps to their places in this list."""
        jumps = [index for index, item in enumerate(self.items) if item.command == JUMP]
        if len(jumps) > MAX_JUMPS:
            over = self.items[jumps[MAX_JUMPS]]
            what = f"expected at most {MAX_JUMPS} jumps, found {len(jumps)}"
            self._error(over, what, "write out what the jumps repeat")
        for index in jumps:
            item = self.items[index]
            target = self._ids.get(int(item.params[0])) if item.params[0].is_integer() else None
            repeats = item.params[1]
            good = target is not None and target != index and repeats >= -1.0
            if target is None or target == index:
                what = f"expected a jump to another item, found {item.params[0]:g}"
                self._error(item, what, "name the item that it jumps to")
            elif not repeats >= -1.0:
                what = f"expected how often to jump, or -1, found {repeats:g}"
                self._error(item, what, "-1 jumps for ever")
            params = (float(target or 0), repeats, 0.0, 0.0)
            self.items[index] = replace(item, params=params) if good else _without_values(item)
        return tuple(self.items)
