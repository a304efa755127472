"""The part of a vehicle that flies by a wing: reads it, and refuses what cannot be steered."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.language.shapes import Leaf, Record

AIR_DENSITY = 1.225  # kg/m^3, ISO 2533 at sea level
Point = tuple[float, float, float]


@dataclass(frozen=True)
class Fading:
    """The part of an effect by the angle of attack: 1, and from `begin` to `end` down to `left`."""

    begin: float = 4.0  # beyond all angles
    end: float = 5.0
    left: float = 1.0


@dataclass(frozen=True)
class StallPoint:
    alpha: float
    lift: float
    drag: float
    pitch: float


Lateral = tuple[float, float, float]  # of sideslip, roll rate, yaw rate


@dataclass(frozen=True)
class Wing:
    area: float
    span: float
    chord: float
    reference: Point
    lift: tuple[float, float, float]  # zero, of alpha, of the pitch rate
    drag: tuple[float, ...]  # zero, alpha, alpha^2, beta, beta^2, lift^2, lift of least drag
    side: Lateral
    roll: Lateral
    pitch: tuple[float, float, float]
    yaw: Lateral
    stall_begins: float
    stall_blend: float
    curve: tuple[StallPoint, ...]
    roll_damping: Fading

    @property
    def most_lift(self) -> float:
        """The largest CL of the curve."""
        return max(point.lift for point in self.curve)


@dataclass(frozen=True)
class Surface:
    name: str
    least: float
    most: float
    rate: float
    time_constant: float
    lift: float
    drag: float
    drag2: float
    side: float
    roll: float
    pitch: float
    yaw: float
    fades: Fading


@dataclass(frozen=True)
class Propeller:
    at: Point
    turned: float
    raised: float
    is_cw: bool  # seen from behind
    diameter: float
    inertia: float
    thrust: tuple[float, ...]
    power: tuple[float, ...]
    most_advance: float
    shaft_power: tuple[float, ...]
    efficiency: float

    @property
    def static_thrust(self) -> float:
        """At full throttle, standing at sea level: CP rho n^3 D^5 = P, T = CT rho n^2 D^4."""
        cube = sum(self.shaft_power) / (self.power[0] * AIR_DENSITY * self.diameter**5)
        square = math.pow(cube, 2.0 / 3.0)
        return self.thrust[0] * AIR_DENSITY * square * self.diameter**4


@dataclass(frozen=True)
class Wheel:
    at: Point
    stiffness: float
    damping: float
    rolling: float
    brake: float
    steered_by: int  # number of a surface, or -1
    steering: float


def read_wing(record: Record | None, report: Report) -> Wing | None:
    if record is None:
        return None
    stall = record.get("stall")
    _check_curve(stall, report)
    drag = ("zero", "alpha", "alpha2", "beta", "beta2", "lift2", "least_lift")
    return Wing(
        area=record.value("area"),
        span=record.value("span"),
        chord=record.value("chord"),
        reference=point(record.get("reference")),
        lift=_longitudinal(record.get("lift")),
        drag=tuple(record.get("drag").value(name, 0.0) for name in drag),
        side=_lateral(record.get("side")),
        roll=_lateral(record.get("roll")),
        pitch=_longitudinal(record.get("pitch")),
        yaw=_lateral(record.get("yaw")),
        stall_begins=stall.value("begins"),
        stall_blend=stall.value("blend"),
        curve=tuple(
            StallPoint(**{name: row.value(name) for name in ("alpha", "lift", "drag", "pitch")})
            for row in stall.value("curve")
        ),
        roll_damping=_fading(stall.get("roll_damping"), report),
    )


def read_surfaces(leaf: Leaf | None, report: Report) -> tuple[Surface, ...]:
    surfaces: list[Surface] = []
    for row in [] if leaf is None else leaf.value:
        name = row.value("name")
        if name in [surface.name for surface in surfaces]:
            report.error(
                row.keys["name"],
                "surface-twice",
                f"duplicate surface '{name}'",
                "give each surface a name of its own",
            )
        most = row.value("most")
        effects = ("lift", "drag", "drag2", "side", "roll", "pitch", "yaw")
        surfaces.append(
            Surface(
                name=name,
                least=max(row.value("least", -most), -most),
                most=most,
                rate=row.value("rate"),
                time_constant=row.value("time_constant"),
                **{effect: row.value(effect, 0.0) for effect in effects},
                fades=_fading(row.get("fades"), report),
            )
        )
    return tuple(surfaces)


def read_propellers(leaf: Leaf | None, report: Report) -> tuple[Propeller, ...]:
    propellers = tuple(
        Propeller(
            at=point(row.get("at")),
            turned=row.value("turned", 0.0),
            raised=row.value("raised", 0.0),
            is_cw=row.value("turns") == "cw",
            diameter=row.value("diameter"),
            inertia=row.value("inertia"),
            thrust=_numbers(row.get("thrust")),
            power=_numbers(row.get("power")),
            most_advance=row.value("most_advance"),
            shaft_power=_numbers(row.get("shaft_power")),
            efficiency=row.value("efficiency"),
        )
        for row in ([] if leaf is None else leaf.value)
    )
    for propeller, row in zip(propellers, [] if leaf is None else leaf.value, strict=True):
        for key in ("thrust", "power"):
            if getattr(propeller, key)[0] > 0.0:
                continue
            report.error(
                row.keys[key],
                "propeller-impossible",
                f"expected a {key} coefficient above 0 at J = 0, found "
                f"{getattr(propeller, key)[0]:g}",
                "write the lowest power of J first",
            )
        if sum(propeller.shaft_power) <= 0.0:
            report.error(
                row.keys["shaft_power"],
                "propeller-impossible",
                f"expected shaft power at full throttle, found {sum(propeller.shaft_power):g} W",
                "write the lowest power of the throttle first",
            )
    return propellers


def read_wheels(
    leaf: Leaf | None, surfaces: tuple[Surface, ...], report: Report
) -> tuple[Wheel, ...]:
    names = [surface.name for surface in surfaces]
    wheels = []
    for row in [] if leaf is None else leaf.value:
        steered_by = row.value("steered_by")
        if steered_by is not None and steered_by not in names:
            report.error(
                row.keys["steered_by"],
                "surface-unknown",
                f"unknown surface '{steered_by}'",
                report.nearest(steered_by, names) or "name one of `surfaces`",
            )
            continue
        wheels.append(
            Wheel(
                at=point(row.get("at")),
                stiffness=row.value("stiffness"),
                damping=row.value("damping"),
                rolling=row.value("rolling"),
                brake=row.value("brake", row.value("rolling")),
                steered_by=-1 if steered_by is None else names.index(steered_by),
                steering=row.value("steering", 1.0),
            )
        )
    return tuple(wheels)


def check_surfaces(surfaces: tuple[Surface, ...], record: Record, report: Report) -> None:
    """A wing turns by its surfaces. It need not have a rudder, as it turns by banking."""
    for axis in ("roll", "pitch"):
        if any(getattr(surface, axis) != 0.0 for surface in surfaces):
            continue
        report.error(
            record.keys.get("surfaces", record.keys["wing"]),
            "surfaces-cannot-steer",
            f"expected a surface that makes {axis} torque, found none",
            f"give one of `surfaces` a value of `{axis}`",
        )


def _check_curve(stall: Record, report: Report) -> None:
    rows = stall.value("curve")
    for before, row in pairwise(rows):
        if row.value("alpha") > before.value("alpha"):
            continue
        report.error(
            row.keys["alpha"],
            "stall-curve",
            "expected a larger angle of attack than the one before, found "
            f"{math.degrees(row.value('alpha')):.4g} deg after "
            f"{math.degrees(before.value('alpha')):.4g} deg",
            "sort the points by `alpha`",
        )
    last = rows[-1].value("alpha")
    if last < math.pi * (1.0 - 1e-9):
        report.error(
            rows[-1].keys["alpha"],
            "stall-curve",
            f"expected a curve up to 180 deg, found {math.degrees(last):.4g} deg",
            "add points, for example of a flat plate",
        )
    if rows[0].value("alpha") > stall.value("begins"):
        report.error(
            rows[0].keys["alpha"],
            "stall-curve",
            "expected a curve from where the stall begins or below, found "
            f"{math.degrees(rows[0].value('alpha')):.4g} deg",
            "add the point where the stall begins",
        )


def _fading(record: Record | None, report: Report) -> Fading:
    if record is None:
        return Fading()
    begin, end = record.value("from"), record.value("to")
    if end <= begin:
        report.error(
            record.keys["to"],
            "out-of-range",
            f"expected an angle above `from`, found {math.degrees(end):.4g} deg",
            "write `to` above `from`",
        )
    return Fading(begin, end, record.value("left"))


def point(leaf: Leaf | None) -> Point:
    x, y, z = (0.0, 0.0, 0.0) if leaf is None else _numbers(leaf)
    return (x, y, z)


def _numbers(leaf: Leaf) -> tuple[float, ...]:
    return tuple(item.value for item in leaf.value)


def _lateral(record: Record) -> Lateral:
    return (
        record.value("beta", 0.0),
        record.value("roll_rate", 0.0),
        record.value("yaw_rate", 0.0),
    )


def _longitudinal(record: Record) -> tuple[float, float, float]:
    return (
        record.value("zero", 0.0),
        record.value("alpha", 0.0),
        record.value("pitch_rate", 0.0),
    )
