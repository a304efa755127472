"""Between latitude and longitude, and metres in a local frame, as runtime/math/stator/geodesy.hpp
has it."""

from __future__ import annotations

import math

_FLATTENING = 1.0 / 298.257223563
_ECCENTRICITY2 = _FLATTENING * (2.0 - _FLATTENING)
_EQUATOR_M = 6378137.0


def _radii(latitude: float) -> tuple[float, float, float]:
    w2 = 1.0 - _ECCENTRICITY2 * math.sin(latitude) ** 2
    transverse = _EQUATOR_M / math.sqrt(w2)
    meridional = transverse * (1.0 - _ECCENTRICITY2) / w2
    return meridional, transverse, 0.5 * transverse * math.sin(latitude) * math.cos(latitude)


def to_local(origin: tuple[float, float], place: tuple[float, float]) -> tuple[float, float]:
    """Metres north and east."""
    meridional, transverse, bend = _radii(math.radians(origin[0]))
    dlat = math.radians(place[0] - origin[0])
    dlon = math.remainder(math.radians(place[1] - origin[1]), math.tau)
    return (
        meridional * dlat + bend * dlon**2,
        transverse * math.cos(math.radians(place[0])) * dlon,
    )


def from_local(origin: tuple[float, float], place: tuple[float, float]) -> tuple[float, float]:
    """The inverse: latitude and longitude."""
    meridional, transverse, bend = _radii(math.radians(origin[0]))
    latitude, dlon = origin[0], 0.0
    for _ in range(4):
        latitude = origin[0] + math.degrees((place[0] - bend * dlon**2) / meridional)
        dlon = place[1] / (transverse * math.cos(math.radians(latitude)))
    longitude = math.remainder(origin[1] + math.degrees(dlon), 360.0)
    return latitude, longitude
