"""Missions in YAML: graph/missions/*.yaml, docs/missions.md."""

from __future__ import annotations

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
from stator.mission.model import (
    EIGHT,
    FOREVER_S,
    LAND,
    NAN,
    RETURN,
    TAKEOFF,
    WAYPOINT,
    Item,
    Mission,
)

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True)
class Quantity:
    """A number with its unit, in the mission's own one."""

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


_HEIGHT = _key("height", "m", 0.5, 1000, "Above home; left out: as before.")
_PLACE = {
    "north": _key("north", "m", -10_000, 10_000, "Of the origin; left out: as before."),
    "east": _key("east", "m", -10_000, 10_000, "Of the origin; left out: as before."),
    "height": _HEIGHT,
}
_SPEED = _key("speed", "m/s", 0.2, 15, "Fastest horizontally.")
_HEADING = _key("heading", "rad", -6.3, 6.3, "There; left out: towards it.")
ITEMS: dict[str, Key] = {
    "takeoff": _item_key(
        "Straight up; the first item of every mission.",
        {"height": _key("height", "m", 0.5, 1000, "Above home.", required=True)},
    ),
    "waypoint": _item_key(
        "To a place, and on.",
        {
            **_PLACE,
            "hold": _key("hold", "s", 0, 36_000, "How long to stay; 0: flies on without a stop."),
            "radius": _key("radius", "m", 0.2, 100, "How near is there."),
            "speed": _SPEED,
            "heading": _HEADING,
        },
    ),
    "loiter": _item_key(
        "To a place, and stays there.",
        {
            **_PLACE,
            "time": _key("time", "s", 0.1, 36_000, "How long to stay; left out: for ever."),
            "speed": _SPEED,
            "heading": _HEADING,
        },
    ),
    "eight": _item_key(
        "Round a figure of eight about a place.",
        {
            **_PLACE,
            "length": _key("length", "m", 2, 200, "Its length; half as wide.", required=True),
            "laps": _key("laps", "1", 1, 100, "How often round."),
            "speed": _key("speed", "m/s", 0.2, 15, "In its middle, the fastest.", required=True),
            "heading": _key("heading", "rad", -6.3, 6.3, "Of its long axis."),
        },
    ),
    "return": _item_key("Home, and down; the last item.", {}),
    "land": _item_key("To a place, and down; the last item.", {**_PLACE}),
}
# Limits that make a flight a success, and the unit of each.
LIMITS: dict[str, Key] = {
    "corridor": _key(
        "corridor", "m", 0.01, 1000, "Most horizontal distance from the straight way."
    ),
    "landing_error": _key("landing_error", "m", 0.01, 1000, "From where it took off."),
    "touchdown_speed": _key("touchdown_speed", "m/s", 0.01, 10, "Downwards, at the ground."),
    "hold_horizontal_rms": _key("hold_horizontal_rms", "m", 0.01, 100, "While staying, to truth."),
    "hold_vertical_rms": _key("hold_vertical_rms", "m", 0.01, 100, "While staying, to truth."),
    "tracking_rms": _key("tracking_rms", "m", 0.01, 100, "Estimate to setpoint, horizontally."),
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
            misshaped(tree, "one item", report, "write it as `- waypoint: {north: 5 m}`")
            return None
        if name not in ITEMS:
            hint = report.nearest(name, ITEMS)
            report.error(mark, "unknown-key", f"there is no item '{name}'", hint)
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
                    "latitude": _key("latitude", "deg", -89, 89, "Latitude.", required=True),
                    "longitude": _key("longitude", "deg", -180, 180, "Longitude.", required=True),
                }
            ),
            "The place that north and east count from; left out: home.",
        ),
        "fence": Key(
            Struct(
                {
                    "radius": _key("radius", "m", 1, 10_000, "Most distance from home."),
                    "height": _key("height", "m", 1, 1000, "Most height above home."),
                }
            ),
            "Outside, the vehicle turns back.",
        ),
        "items": Key(Listing(_AnyItem(), least=1), "What to do, in order.", required=True),
        "limits": Key(Struct(LIMITS), "What makes a simulated flight a success."),
    }
)


def read_yaml(path: Path) -> Mission:
    """Raises `Failed` with every error."""
    report = Report()
    tree = yaml_tree.load(path, report)
    record = None if tree is None else MISSION.read(tree, report)
    report.stop_on_errors()
    assert record is not None
    origin, fence = record.get("origin"), record.get("fence")
    limits = record.get("limits")
    return Mission(
        items=_items(record.value("items")),
        origin=None if origin is None else (origin.value("latitude"), origin.value("longitude")),
        fence_radius=0.0 if fence is None else fence.value("radius", 0.0),
        fence_height=0.0 if fence is None else fence.value("height", 0.0),
        limits={} if limits is None else {k: leaf.value for k, leaf in limits.values.items()},
    )


def _items(listed: list[tuple[str, Record]]) -> tuple[Item, ...]:
    items = []
    place = {"north": 0.0, "east": 0.0, "height": 0.0}
    for name, record in listed:
        place |= {key: record.value(key) for key in place if record.get(key) is not None}
        items.append(_item(name, record, place))
    return tuple(items)


def _item(name: str, record: Record, place: dict[str, float]) -> Item:
    heading, speed = record.value("heading", NAN), record.value("speed", NAN)
    match name:
        case "takeoff":
            return Item(TAKEOFF, **place)
        case "return":
            return Item(RETURN, **place)
        case "land":
            return Item(LAND, **place)
        case "loiter":
            hold = record.value("time", FOREVER_S)
            return Item(WAYPOINT, **place, heading=heading, hold=hold, speed=speed)
        case "eight":
            laps, length = record.value("laps", 1.0), record.value("length")
            return Item(EIGHT, **place, heading=heading, radius=length, hold=laps, speed=speed)
    radius, hold = record.value("radius", 1.0), record.value("hold", 0.0)
    return Item(WAYPOINT, **place, heading=heading, radius=radius, hold=hold, speed=speed)
