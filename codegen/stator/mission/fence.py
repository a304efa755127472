"""A fence as the vehicle has it (apps/navigator/geofence.hpp): inside are places that lie in at
least one area that includes, where there is one, and in none that exclude."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from stator.mission.geodesy import to_local

if TYPE_CHECKING:
    from stator.mission.model import Area

HOME_M = 0.01
Point = tuple[float, float]  # metres north and east of home


@dataclass(frozen=True)
class LocalArea:
    includes: bool
    corners: tuple[Point, ...]  # one: a circle
    radius: float
    label: str

    def contains(self, point: Point) -> bool:
        if len(self.corners) == 1:
            return math.dist(point, self.corners[0]) <= self.radius
        inside = False
        for a, b in self._edges():
            if (a[0] > point[0]) != (b[0] > point[0]):
                y = a[1] + (b[1] - a[1]) * (point[0] - a[0]) / (b[0] - a[0])
                inside ^= point[1] < y
        return inside

    def crossings(self, start: Point, end: Point) -> list[float]:
        """Where a straight way crosses the border, as parts of its length."""
        wx, wy = end[0] - start[0], end[1] - start[1]
        found = []
        if len(self.corners) == 1:
            fx, fy = start[0] - self.corners[0][0], start[1] - self.corners[0][1]
            a, b = wx * wx + wy * wy, fx * wx + fy * wy
            root2 = b * b - a * (fx * fx + fy * fy - self.radius**2)
            if a > 0.0 and root2 > 0.0:
                found = [(-b - math.sqrt(root2)) / a, (-b + math.sqrt(root2)) / a]
        else:
            for p, q in self._edges():
                ex, ey = q[0] - p[0], q[1] - p[1]
                tx, ty = p[0] - start[0], p[1] - start[1]
                across = wx * ey - wy * ex
                if across and 0.0 <= (tx * wy - ty * wx) / across <= 1.0:
                    found.append((tx * ey - ty * ex) / across)
        return [part for part in found if 0.0 < part < 1.0]

    def _edges(self) -> list[tuple[Point, Point]]:
        return [*zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True)]


class Fence:
    def __init__(self, areas: tuple[Area, ...], origin: tuple[float, float] | None) -> None:
        self._areas = [
            LocalArea(
                area.includes,
                tuple(to_local(origin or place, place) for place in area.places) or ((0.0, 0.0),),
                area.radius,
                area.label,
            )
            for area in areas
        ]

    @property
    def includes(self) -> bool:
        return any(area.includes for area in self._areas)

    @property
    def home_radius(self) -> float:
        """Of a fence whose one area that includes is a circle about home; else 0."""
        including = [area for area in self._areas if area.includes]
        if len(including) != 1 or len(including[0].corners) != 1:
            return 0.0
        is_at_home = math.hypot(*including[0].corners[0]) < HOME_M
        return including[0].radius if is_at_home else 0.0

    def left_at(self, point: Point) -> str:
        """How a place is outside; empty: it is inside."""
        for area in self._areas:
            if not area.includes and area.contains(point):
                return f"inside {area.label}, which excludes it"
        including = [area for area in self._areas if area.includes]
        if not including or any(area.contains(point) for area in including):
            return ""
        if len(including) > 1:
            return "outside all areas of the fence"
        only = including[0]
        if len(only.corners) == 1:
            away = math.dist(point, only.corners[0])
            return f"{away:.1f} m from the middle of {only.label}, which has {only.radius:g} m"
        return f"outside {only.label}"

    def left_between(self, start: Point, end: Point) -> str:
        parts = sorted({0.0, 1.0, *(p for a in self._areas for p in a.crossings(start, end))})
        for first, second in pairwise(parts):
            part = 0.5 * (first + second)
            middle = (start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))
            left = self.left_at(middle) if second - first > 1e-6 else ""
            if left:
                return left
        return ""
