"""Missions in the text format "QGC WPL 110", of Mission Planner and others: one item a line, with
index, current, frame, command, seven numbers, autocontinue."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stator.mission.builder import Builder
from stator.mission.commands import ABOVE_SEA, WAYPOINT
from stator.mission.model import Home, Mission

if TYPE_CHECKING:
    from stator.mission.problems import Problems

VERSIONS = ("110", "120")
_COLUMNS = 12
_MAX_SHOWN = 40


def read_text(text: str, problems: Problems) -> Mission:
    # Not splitlines, for which a form feed ends a line as well.
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    version = lines[0].split()[2:3]
    if version and version[0] not in VERSIONS:
        problems.add(
            0,
            f"expected format QGC WPL 110, found {version[0][:_MAX_SHOWN]}",
            "save the mission again with a newer program",
        )
        return Mission(())
    rows: list[tuple[int, list[float]]] = []
    for number, line in enumerate(lines[1:], 2):
        words = line.split()
        if words and not words[0].startswith("#"):
            values = _numbers(words)
            if values is None:
                shown = " ".join(words)[:_MAX_SHOWN]
                problems.add(
                    number,
                    f"line {number}: expected an item of 12 numbers, found '{shown}'",
                    "save the mission again",
                )
            else:
                rows.append((number, values))
    home = None
    if rows and _is_home(rows[0][1]):
        home = _home(rows[0][1])
        del rows[0]
    return _mission(rows, home, problems)


def _numbers(words: list[str]) -> list[float] | None:
    try:
        values = [float(word) for word in words]
    except ValueError:
        return None
    is_whole = len(values) == _COLUMNS and all(
        value.is_integer() and 0 <= value <= 65535 for value in (values[0], *values[2:4])
    )
    return values if is_whole else None


def _is_home(row: list[float]) -> bool:
    """Most programs save home as item 0; some leave it out."""
    return row[0] == 0 and row[3] == WAYPOINT and row[2] in ABOVE_SEA


def _home(row: list[float]) -> Home | None:
    latitude, longitude, altitude = row[8:11]
    is_place = abs(latitude) < 90.0 and abs(longitude) <= 180.0 and (latitude, longitude) != (0, 0)
    known = altitude if math.isfinite(altitude) else None
    return Home(latitude, longitude, known) if is_place else None


def _mission(rows: list[tuple[int, list[float]]], home: Home | None, problems: Problems) -> Mission:
    """A jump names an item by its index in the file."""
    builder = Builder(problems, is_ardupilot=True)
    for number, (line, row) in enumerate(rows, 1):
        builder.add(
            line,  # as errors of lines, so that all are in order
            f"item {number} (line {line})",
            int(row[3]),
            int(row[2]),
            row[4:11],
            autocontinue=row[11] != 0.0,
            jump_id=int(row[0]),
        )
    return Mission(builder.finish(), home, notes=builder.notes)
