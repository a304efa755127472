"""A mission as the bytes that the memory of the mission device holds:
drivers/mission/mission_store.hpp."""

from __future__ import annotations

import math
import struct
import zlib
from typing import TYPE_CHECKING

from stator.build.cpp_source import constant, layout
from stator.mission.commands import (
    CIRCLE_IN,
    CIRCLE_OUT,
    GLOBAL,
    LOCAL,
    NO_PLACE,
    POLYGON_IN,
    POLYGON_OUT,
    RALLY_POINT,
    RELATIVE,
)
from stator.mission.model import MAX_FENCE_ITEMS, MAX_ITEMS, MAX_RALLY_POINTS, NAN, Item

if TYPE_CHECKING:
    from pathlib import Path

    from stator.mission.model import Area, Mission

_FILE = "drivers/mission/mission_store.hpp"
_ITEM, _HEAD = layout(_FILE, "StoredItem"), layout(_FILE, "StoredHead")
_MAGIC = int(constant(_FILE, "kMagic"))
_HEAD_BYTES = int(constant(_FILE, "kHeadBytes"))
_CAPACITY = (MAX_ITEMS, MAX_FENCE_ITEMS, MAX_RALLY_POINTS)
_NOWHERE = 2**31 - 1  # kNoPlace
_AREAS = 2  # of each list: the one that counts, and the one that the next list is written into


def write(mission: Mission | None, file: Path) -> None:
    """The whole memory; what no list uses is a hole in the file. None: it is empty."""
    lists: tuple[list[Item], ...] = ([], [], [])
    if mission is not None:
        lists = (list(mission.items), fence_items(mission), rally_items(mission))
    address = _AREAS * _HEAD_BYTES * len(lists)
    with file.open("wb") as out:
        for number, (items, most) in enumerate(zip(lists, _CAPACITY, strict=True)):
            assert len(items) <= most
            content = b"".join(_packed(item) for item in items)
            head = (_MAGIC, 1, len(items), zlib.crc32(content))
            packed = struct.pack("<4I", *head)
            out.seek(_AREAS * _HEAD_BYTES * number)
            out.write(_HEAD.packed.pack(*head, zlib.crc32(packed)))
            out.seek(address)
            out.write(content)
            address += _AREAS * most * _ITEM.packed.size
        out.truncate(address)


def fence_items(mission: Mission) -> list[Item]:
    items = [item for area in mission.areas for item in _area_items(area, mission.ceiling)]
    has_ceiling = any(item.frame == LOCAL for item in items)
    if mission.ceiling > 0.0 and not has_ceiling:
        items.append(_home_circle(0.0, mission.ceiling))
    return items


def _area_items(area: Area, ceiling: float) -> list[Item]:
    if not area.places:
        return [_home_circle(area.radius, ceiling)]
    if area.radius:
        command, first = (CIRCLE_IN if area.includes else CIRCLE_OUT), area.radius
    else:
        command, first = (POLYGON_IN if area.includes else POLYGON_OUT), float(len(area.places))
    params = (first, 0.0, 0.0, 0.0)
    return [Item(command, GLOBAL, params, place[0], place[1], 0.0) for place in area.places]


def _home_circle(radius: float, ceiling: float) -> Item:
    return Item(CIRCLE_IN, LOCAL, (radius, 0.0, 0.0, 0.0), 0.0, 0.0, ceiling or NAN)


def rally_items(mission: Mission) -> list[Item]:
    none = (0.0, 0.0, 0.0, 0.0)
    return [Item(RALLY_POINT, RELATIVE, none, *point) for point in mission.rally]


def _whole(value: float) -> int:
    """The nearest one that fits."""
    return _NOWHERE if math.isnan(value) else round(max(-_NOWHERE, min(_NOWHERE - 1, value)))


def _packed(item: Item) -> bytes:
    is_local = item.frame == LOCAL
    unit = {LOCAL: 1e4, NO_PLACE: 1.0}.get(item.frame, 1e7)
    x, y = (_whole(v * unit) for v in (item.x, item.y))
    z = -item.z if is_local else item.z
    head = (item.command, item.frame, int(item.autocontinue))
    return _ITEM.packed.pack(*head, *item.params, x, y, z)
