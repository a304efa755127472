"""Missions in YAML: graph/missions/*.yaml, docs/missions.md."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from stator.diagnostics import Report
from stator.graph.model import Param
from stator.graph.value import read_value
from stator.language import yaml_tree
from stator.language.nested import Key, Listing, Struct
from stator.language.shapes import Leaf, Record, Text, misshaped, scalar
from stator.language.yaml_tree import Mapping, Scalar, Tree
from stator.mission.commands import (
    CHANGE_SPEED,
    EIGHT,
    LAND,
    LOCAL,
    LOITER_UNLIMITED,
    NO_PLACE,
    RELATIVE,
    RETURN,
    TAKEOFF,
    WAYPOINT,
)
from stator.mission.geodesy import from_local
from stator.mission.model import NAN, USUAL_RADIUS_M, Area, Home, Item, Mission

if TYPE_CHECKING:
    from pathlib import Path

    from stator.mission.problems import Problems


@dataclass(frozen=True)
class Quantity:
    """A number with a unit; the value is in the unit that missions use."""

    name: str
    unit: str
    least: float
    most: float

    def read(self, tree: Tree, report: Report) -> Leaf | None:
        found = scalar(tree, f"a number in {self.unit}", report)
        if found is None:
            return None
        least, most = Fraction(self.least), Fraction(self.most)
        param = Param(self.name, "float", self.unit, least, most, Fraction(0), "")
        value = read_value(param, found, report)
        return None if value is None else Leaf(float(value), found.mark)

    def schema(self) -> dict[str, Any]:
        return {"type": ["string", "number"]}


def _key(
    name: str, unit: str, least: float, most: float, doc: str, *, required: bool = False
) -> Key:
    return Key(Quantity(name, unit, least, most), doc, required)


def _item_key(doc: str, keys: dict[str, Key]) -> Key:
    return Key(Struct(keys), doc, required=True)


_HEIGHT = _key("height", "m", 0.5, 1000, "The height above home. Default: as before.")
_PLACE = {
    "north": _key("north", "m", -10_000, 10_000, "North of the origin. Default: as before."),
    "east": _key("east", "m", -10_000, 10_000, "East of the origin. Default: as before."),
    "height": _HEIGHT,
}
_SPEED = _key("speed", "m/s", 0.2, 15, "The highest horizontal speed.")
_HEADING = _key("heading", "rad", -6.3, 6.3, "The heading there. Default: towards the place.")
ITEMS: dict[str, Key] = {
    "takeoff": _item_key(
        "Climb. Every mission begins with it.",
        {"height": _key("height", "m", 0.5, 1000, "The height above home.", required=True)},
    ),
    "waypoint": _item_key(
        "Fly to a place, and continue.",
        {
            **_PLACE,
            "hold": _key("hold", "s", 0, 36_000, "The time to stay. 0: no stop."),
            "radius": _key(
                "radius", "m", 0.2, 100, "The distance at which the place counts as reached."
            ),
            "speed": _SPEED,
            "heading": _HEADING,
        },
    ),
    "loiter": _item_key(
        "Fly to a place, and stay there.",
        {
            **_PLACE,
            "time": _key("time", "s", 0.1, 36_000, "The time to stay. Default: without end."),
            "speed": _SPEED,
            "heading": _HEADING,
        },
    ),
    "eight": _item_key(
        "Fly a figure of eight around a place.",
        {
            **_PLACE,
            "length": _key(
                "length", "m", 2, 200, "The length; the width is half of it.", required=True
            ),
            "laps": _key("laps", "1", 1, 100, "The number of laps."),
            "speed": _key(
                "speed",
                "m/s",
                0.2,
                15,
                "The speed in the middle, which is the highest.",
                required=True,
            ),
            "heading": _key("heading", "rad", -6.3, 6.3, "The heading of the long axis."),
        },
    ),
    "return": _item_key("Fly home and land. Only as the last item.", {}),
    "land": _item_key("Fly to a place and land. Only as the last item.", {**_PLACE}),
}
# The limits of a successful flight, and the unit of each.
LIMITS: dict[str, Key] = {
    "corridor": _key(
        "corridor", "m", 0.01, 1000, "The greatest horizontal distance from the straight path."
    ),
    "landing_error": _key(
        "landing_error", "m", 0.01, 1000, "The greatest distance between take-off and landing."
    ),
    "touchdown_speed": _key(
        "touchdown_speed", "m/s", 0.01, 10, "The highest vertical speed at touchdown."
    ),
    "hold_horizontal_rms": _key(
        "hold_horizontal_rms",
        "m",
        0.01,
        100,
        "The largest horizontal RMS error of the true position while staying.",
    ),
    "hold_vertical_rms": _key(
        "hold_vertical_rms",
        "m",
        0.01,
        100,
        "The largest vertical RMS error of the true position while staying.",
    ),
    "tracking_rms": _key(
        "tracking_rms",
        "m",
        0.01,
        100,
        "The largest horizontal RMS distance between estimate and setpoint.",
    ),
}


@dataclass(frozen=True)
class _AnyItem:
    """`return`, or `waypoint: {...}`."""

    def read(self, tree: Tree, report: Report) -> tuple[str, Record] | None:
        if isinstance(tree, Mapping) and len(tree.entries) == 1:
            name, content = next(iter(tree.entries.items()))
            mark = tree.keys[name]
        elif isinstance(tree, Scalar) and not tree.is_null:
            name, content, mark = tree.text, Mapping({}, tree.mark, {}, tree.mark), tree.mark
        else:
            misshaped(tree, "one item", report, "write it in this form: `- waypoint: {north: 5 m}`")
            return None
        if name not in ITEMS:
            hint = report.nearest(name, ITEMS)
            report.error(mark, "unknown-key", f"unknown item '{name}'", hint)
            return None
        record = ITEMS[name].shape.read(content, report)
        return None if record is None else (name, record)

    def schema(self) -> dict[str, Any]:
        alone = [name for name, key in ITEMS.items() if "required" not in key.shape.schema()]
        mappings = [Struct({name: key}).schema() for name, key in ITEMS.items()]
        return {"anyOf": [{"enum": alone}, *mappings]}


MISSION = Struct(
    {
        "doc": Key(Text(), "What the mission is for."),
        "origin": Key(
            Struct(
                {
                    "latitude": _key("latitude", "deg", -89, 89, "The latitude.", required=True),
                    "longitude": _key(
                        "longitude", "deg", -180, 180, "The longitude.", required=True
                    ),
                }
            ),
            "The place that north and east count from. Default: home.",
        ),
        "fence": Key(
            Struct(
                {
                    "radius": _key(
                        "radius", "m", 1, 10_000, "The greatest horizontal distance from home."
                    ),
                    "height": _key("height", "m", 1, 1000, "The greatest height above home."),
                }
            ),
            "The vehicle turns back at this limit.",
        ),
        "items": Key(
            Listing(_AnyItem(), least=1),
            "The items, in the order in which the vehicle flies them.",
            required=True,
        ),
        "limits": Key(Struct(LIMITS), "The limits of a successful simulated flight."),
    }
)


def read_yaml(path: Path, problems: Problems) -> Mission:
    """Raises `Failed` with every error of the language; what is wrong with the items goes to
    `problems`."""
    report = Report()
    tree = yaml_tree.load(path, report)
    record = None if tree is None else MISSION.read(tree, report)
    report.stop_on_errors()
    assert record is not None
    fence, limits, home = record.get("fence"), record.get("limits"), record.get("origin")
    origin = None if home is None else Home(home.value("latitude"), home.value("longitude"))
    radius = 0.0 if fence is None else fence.value("radius", 0.0)
    area = Area(includes=True, places=(), radius=radius)
    if origin is not None:
        area = Area(True, ((origin.latitude, origin.longitude),), radius)
    return Mission(
        items=_Items(origin, problems).made_of(record.value("items")),
        home=origin,
        areas=(area,) if radius else (),
        ceiling=0.0 if fence is None else fence.value("height", 0.0),
        limits={} if limits is None else {k: leaf.value for k, leaf in limits.values.items()},
    )


class _Items:
    """Turns items of the YAML into those of MAVLink; a speed is an item of its own there."""

    def __init__(self, origin: Home | None, problems: Problems) -> None:
        self._origin = origin
        self._problems = problems
        self._place = {"north": 0.0, "east": 0.0, "height": 0.0}
        self._speed = NAN
        self._items: list[Item] = []

    def made_of(self, listed: list[tuple[str, Record]]) -> tuple[Item, ...]:
        ended = False
        for number, (name, record) in enumerate(listed, 1):
            label = f"item {number}, {name}"
            if (name == "takeoff") != (number == 1):
                first = number == 1
                what = "expected a takeoff as the first item" if first else "duplicate takeoff"
                hint = "add a takeoff in front" if first else "remove it"
                self._problems.add(number, f"{label}: {what}", hint)
            if ended:
                what = "never reached: the item before it ends the mission"
                hint = "remove this item and those behind it"
                self._problems.add(number, f"{label}: {what}", hint)
                break
            ended = name in ("return", "land") or (name == "loiter" and record.get("time") is None)
            self._add(number, name, record)
        return tuple(self._items)

    def _add(self, number: int, name: str, record: Record) -> None:
        height_before = self._place["height"]
        own = {key: record.value(key) for key in self._place if record.get(key) is not None}
        self._place |= own
        heading = record.value("heading", NAN)
        degrees, speed = math.degrees(heading), record.value("speed", NAN)
        usual = (0.0, USUAL_RADIUS_M, 0.0, degrees)
        match name:
            case "takeoff":
                self._append(number, TAKEOFF, (0.0, 0.0, 0.0, NAN))
            case "return":
                self._append(number, RETURN, (0.0, 0.0, 0.0, 0.0), has_place=False)
            case "land":
                if self._place["height"] != height_before:
                    # The height of a landing is that of the ground: it is reached before.
                    self._append(number, WAYPOINT, usual, is_extra=True)
                self._append(number, LAND, (0.0, 0.0, 0.0, NAN))
            case "loiter":
                self._change_speed(number, speed)
                hold = record.value("time", None)
                if hold is None:
                    self._append(number, LOITER_UNLIMITED, (0.0, 0.0, 0.0, degrees))
                else:
                    self._append(number, WAYPOINT, (hold, *usual[1:]))
            case "eight":
                self._change_speed(number, speed)
                half, laps = 0.5 * record.value("length"), record.value("laps", 1.0)
                self._append(number, EIGHT, (half, 0.5 * half, laps, heading))
            case _:
                self._change_speed(number, speed)
                hold, radius = record.value("hold", 0.0), record.value("radius", USUAL_RADIUS_M)
                self._append(number, WAYPOINT, (hold, radius, 0.0, degrees))

    def _change_speed(self, number: int, speed: float) -> None:
        if speed == self._speed or (math.isnan(speed) and math.isnan(self._speed)):
            return
        self._speed = speed
        value = -2.0 if math.isnan(speed) else speed
        params = (1.0, value, -1.0, 0.0)
        self._append(number, CHANGE_SPEED, params, has_place=False, is_extra=True)

    def _append(
        self,
        number: int,
        command: int,
        params: tuple[float, float, float, float],
        *,
        has_place: bool = True,
        is_extra: bool = False,
    ) -> None:
        x, y, z = self._place["north"], self._place["east"], self._place["height"]
        frame = LOCAL if has_place else NO_PLACE
        if has_place and self._origin is not None:
            frame = RELATIVE
            x, y = from_local((self._origin.latitude, self._origin.longitude), (x, y))
        label = f"item {number}"
        self._items.append(Item(command, frame, params, x, y, z, True, number, label, is_extra))
