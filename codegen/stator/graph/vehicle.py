"""Reads a vehicle, and refuses what no rigid body is and what cannot fly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.diagnostics import Report
from stator.graph.sources import Sources
from stator.graph.wing import (
    AIR_DENSITY,
    Point,
    Propeller,
    Surface,
    Wheel,
    Wing,
    check_surfaces,
    point,
    read_propellers,
    read_surfaces,
    read_wheels,
    read_wing,
)
from stator.language.vehicle_keys import MAX_ROTORS, VEHICLE
from stator.language.wing_keys import MAX_SURFACES

if TYPE_CHECKING:
    from pathlib import Path

    from stator.diagnostics import Mark
    from stator.language.shapes import Leaf, Record

GRAVITY = 9.80665


@dataclass(frozen=True)
class Rotor:
    x: float
    y: float
    z: float
    is_ccw: bool  # seen from above
    in_wake: float


@dataclass(frozen=True)
class Rotors:
    thrust_per_speed2: float
    torque_per_thrust: float
    max_speed: float
    rise_time: float
    fall_time: float
    disc_area: float
    efficiency: float
    inflow_pitch: float
    drag: float
    rolling_moment: float
    places: tuple[Rotor, ...] = ()

    @property
    def most_thrust(self) -> float:
        return sum(self.thrust_per_speed2 * self.max_speed**2 * r.in_wake for r in self.places)


@dataclass(frozen=True)
class Ground:
    stiffness: float
    damping: float
    friction: float
    feet: tuple[Point, ...]
    hull: tuple[Point, ...]
    wheels: tuple[Wheel, ...]


@dataclass(frozen=True)
class Battery:
    cells: int
    capacity: float  # coulomb
    resistance: float
    nominal_voltage: float
    avionics_power: float


@dataclass(frozen=True)
class Vehicle:
    """SI units; lengths from the centre of mass, forward, to the right and down."""

    name: str
    file: Path
    doc: str
    mass: float
    inertia: tuple[float, float, float, float]  # xx, yy, zz, xz
    drag_area: Point
    rotors: Rotors | None
    ground: Ground
    battery: Battery
    wing: Wing | None
    surfaces: tuple[Surface, ...]
    propellers: tuple[Propeller, ...]

    @property
    def weight(self) -> float:
        return self.mass * GRAVITY

    @property
    def places(self) -> tuple[Rotor, ...]:
        return () if self.rotors is None else self.rotors.places

    @property
    def motor_count(self) -> int:
        """Rotors and, after them, propellers."""
        return len(self.places) + len(self.propellers)

    @property
    def most_thrust(self) -> float:
        """Up, or of a vehicle without rotors forward, standing at sea level."""
        if self.rotors is not None:
            return self.rotors.most_thrust
        return sum(propeller.static_thrust for propeller in self.propellers)

    @property
    def thrust_over_weight(self) -> float:
        return self.most_thrust / self.weight

    @property
    def hover_thrust(self) -> float:
        """What carries the weight, of all the thrust of the rotors."""
        assert self.rotors is not None
        return self.weight / self.rotors.most_thrust

    @property
    def stall_airspeed(self) -> float:
        """In straight flight at sea level."""
        assert self.wing is not None
        lift = AIR_DENSITY * self.wing.area * self.wing.most_lift
        return math.sqrt(2.0 * self.weight / lift)


def param_values(vehicle: Vehicle) -> dict[str, Fraction]:
    """What parameters may take from a vehicle, as a person writes it."""
    values: dict[str, Fraction] = {}
    if vehicle.rotors is not None:
        values["hover_thrust"] = _rounded(vehicle.hover_thrust, 3)
    values["rotor_count"] = Fraction(len(vehicle.places))
    for axis, moment in zip("xyz", vehicle.inertia, strict=False):
        values[f"gyration_{axis}"] = _rounded(math.sqrt(moment / vehicle.mass), 4)
    for i in range(MAX_ROTORS):
        values |= {f"rotor{i}_{what}": Fraction(0) for what in ("x", "y", "moment")}
    for i, rotor in enumerate(vehicle.places):
        assert vehicle.rotors is not None
        moment = vehicle.rotors.torque_per_thrust * (1.0 if rotor.is_ccw else -1.0)
        for what, value in (("x", rotor.x), ("y", rotor.y), ("moment", moment)):
            values[f"rotor{i}_{what}"] = Fraction(repr(value))
    values |= _wing_values(vehicle)
    return values


def _wing_values(vehicle: Vehicle) -> dict[str, Fraction]:
    """All 0 without a wing."""
    wing = vehicle.wing
    values = {
        "mass": _rounded(vehicle.mass, 4),
        "wing_area": _rounded(wing.area if wing else 0.0, 4),
        "wing_span": _rounded(wing.span if wing else 0.0, 4),
        "wing_chord": _rounded(wing.chord if wing else 0.0, 4),
        "stall_airspeed": _rounded(vehicle.stall_airspeed if wing else 0.0, 2),
        "propeller_count": Fraction(len(vehicle.propellers)),
        "surface_count": Fraction(len(vehicle.surfaces)),
    }
    # The torque of command 1, over dynamic pressure and wing area.
    span, chord = (wing.span, wing.chord) if wing else (0.0, 0.0)
    lengths = {"roll": span, "pitch": chord, "yaw": span}
    for i in range(MAX_SURFACES):
        surface = vehicle.surfaces[i] if i < len(vehicle.surfaces) else None
        for axis, length in lengths.items():
            effect = 0.0 if surface is None else getattr(surface, axis) * surface.most * length
            values[f"surface{i}_{axis}"] = _rounded(effect, 5)
    return values


def values_of(sources: Sources) -> dict[str, Fraction]:
    """What parameters may take from the graph's vehicle; without a graph from the usual one."""
    name = sources.vehicle
    path = sources.vehicles()[name]
    found = sources.once("vehicle", name, lambda: read_vehicle(sources, name, path))
    values: dict[str, Fraction] = sources.once("values", name, lambda: param_values(found))
    return values


def _rounded(value: float, digits: int) -> Fraction:
    return Fraction(repr(round(value, digits)))


def find_vehicle(sources: Sources, leaf: Leaf | None, owner: Mark) -> Vehicle | None:
    """The vehicle that a graph names, or the usual one; parameters take their values from it."""
    name = sources.vehicle if leaf is None else leaf.value
    sources.vehicle = name
    path = sources.vehicles().get(name)
    if path is None:
        sources.report.error(
            owner if leaf is None else leaf.mark,
            "vehicle-unknown",
            f"unknown vehicle '{name}'",
            sources.report.nearest(name, sources.vehicles())
            or f"write vehicles/{name}.yaml beside the graph",
        )
        return None
    found: Vehicle | None = sources.once("vehicle", name, lambda: read_vehicle(sources, name, path))
    return found


def check_vehicle(path: Path) -> Vehicle:
    """The vehicle of a file alone, without a graph. Raises `Failed`."""
    report = Report()
    sources = Sources(path.parent, report)
    vehicle = read_vehicle(sources, path.stem, path)
    report.stop_on_errors()
    assert vehicle is not None
    return vehicle


def read_vehicle(sources: Sources, name: str, path: Path) -> Vehicle | None:
    count = len(sources.report)
    record = sources.read(path, VEHICLE)
    if record is None or len(sources.report) > count:
        return None
    rotors = record.get("rotors")
    inertia = record.get("inertia")
    surfaces = read_surfaces(record.get("surfaces"), sources.report)
    vehicle = Vehicle(
        name=name,
        file=path,
        doc=record.value("doc"),
        mass=record.value("mass"),
        inertia=(
            inertia.value("xx"),
            inertia.value("yy"),
            inertia.value("zz"),
            inertia.value("xz", 0.0),
        ),
        drag_area=point(record.get("drag_area")),
        rotors=None if rotors is None else _rotors(rotors),
        ground=_ground(record.get("ground"), surfaces, sources.report),
        battery=_battery(record.get("battery")),
        wing=read_wing(record.get("wing"), sources.report),
        surfaces=surfaces,
        propellers=read_propellers(record.get("propellers"), sources.report),
    )
    _check_inertia(vehicle, record.keys["inertia"], sources.report)
    _check_parts(vehicle, record, sources.report)
    if vehicle.rotors is not None:
        if _are_apart(vehicle, rotors.get("places"), sources.report):
            _check_steering(vehicle.rotors, rotors.keys["places"], sources.report)
        _check_thrust(vehicle, record.keys["rotors"], sources.report)
    if vehicle.wing is not None:
        check_surfaces(surfaces, record, sources.report)
    return None if len(sources.report) > count else vehicle


def _check_parts(vehicle: Vehicle, record: Record, report: Report) -> None:
    """A vehicle has what lifts it, what moves it, and what it stands on."""
    missing: list[tuple[Mark, str, str]] = []
    if vehicle.rotors is None and vehicle.wing is None:
        missing.append((record.owner, "rotors", "what lifts: rotors, or a `wing`"))
    if vehicle.wing is not None and not vehicle.propellers:
        missing.append((record.keys["wing"], "propellers", "what moves the wing through the air"))
    if vehicle.wing is None:
        for key in ("surfaces", "propellers"):
            if key in record.keys:
                missing.append((record.keys[key], "wing", f"what `{key}` belong to"))
    if not vehicle.ground.feet and not vehicle.ground.wheels:
        missing.append((record.keys["ground"], "feet", "what it stands on: feet, or `wheels`"))
    for mark, key, why in missing:
        report.error(mark, "missing-key", f"missing key '{key}'", f"add `{key}`: {why}")
    if vehicle.motor_count > MAX_ROTORS:
        report.error(
            record.keys["propellers"],
            "out-of-range",
            f"expected at most {MAX_ROTORS} rotors and propellers, found {vehicle.motor_count}",
            f"remove {vehicle.motor_count - MAX_ROTORS} of them",
        )


def _rotors(record: Record) -> Rotors:
    return Rotors(
        thrust_per_speed2=record.value("thrust_per_speed2"),
        torque_per_thrust=record.value("torque_per_thrust"),
        max_speed=record.value("max_speed"),
        rise_time=record.value("rise_time"),
        fall_time=record.value("fall_time"),
        disc_area=record.value("disc_area"),
        efficiency=record.value("efficiency"),
        inflow_pitch=record.value("inflow_pitch"),
        drag=record.value("drag", 0.0),
        rolling_moment=record.value("rolling_moment", 0.0),
        places=tuple(
            Rotor(
                x=row.value("x"),
                y=row.value("y"),
                z=row.value("z", 0.0),
                is_ccw=row.value("turns") == "ccw",
                in_wake=row.value("in_wake", 1.0),
            )
            for row in record.value("places")
        ),
    )


def _ground(record: Record, surfaces: tuple[Surface, ...], report: Report) -> Ground:
    return Ground(
        stiffness=record.value("stiffness"),
        damping=record.value("damping"),
        friction=record.value("friction"),
        feet=tuple(map(point, record.value("feet", []))),
        hull=tuple(map(point, record.value("hull", []))),
        wheels=read_wheels(record.get("wheels"), surfaces, report),
    )


def _battery(record: Record) -> Battery:
    return Battery(
        cells=record.value("cells"),
        capacity=record.value("capacity"),
        resistance=record.value("resistance"),
        nominal_voltage=record.value("nominal_voltage"),
        avionics_power=record.value("avionics_power", 0.0),
    )


def principal(inertia: tuple[float, float, float, float]) -> list[float]:
    """The principal moments, the smallest first."""
    xx, yy, zz, xz = inertia
    middle, half = 0.5 * (xx + zz), math.hypot(0.5 * (xx - zz), xz)
    return sorted([middle - half, yy, middle + half])


def _check_inertia(vehicle: Vehicle, mark: Mark, report: Report) -> None:
    """Each moment is an integral of two squared coordinates, the other two of one of these each and
    of the third."""
    small, middle, large = principal(vehicle.inertia)
    if small > 0.0 and large <= (small + middle) * (1.0 + 1e-9):
        return
    report.error(
        mark,
        "inertia-impossible",
        "expected the inertia of a rigid body, whose largest principal moment is at most the sum "
        f"of the other two, found {large:.4g} against {small:.4g} + {middle:.4g} kg m^2",
        "compute xx, yy, zz and xz about the centre of mass, for one set of axes",
    )


def _are_apart(vehicle: Vehicle, places: Leaf, report: Report) -> bool:
    count = len(report)
    rotors = vehicle.places
    for i, rotor in enumerate(rotors):
        same = [
            other
            for other in rotors[:i]
            if (other.x, other.y, other.z) == (rotor.x, rotor.y, rotor.z)
        ]
        if same:
            report.error(
                places.value[i].mark,
                "rotor-place",
                f"duplicate place of a rotor: rotors {rotors.index(same[0]) + 1} "
                f"and {i + 1} are at the same point",
                "move one of them; a coaxial pair has two values of z",
            )
    return len(report) == count


def effectiveness(rotors: Rotors) -> list[list[float]]:
    """Roll, pitch, yaw torque and lift of a unit of thrust, a row for each rotor."""
    moment = rotors.torque_per_thrust
    return [
        [
            -r.y * r.in_wake,
            r.x * r.in_wake,
            (moment if r.is_ccw else -moment) * r.in_wake,
            r.in_wake,
        ]
        for r in rotors.places
    ]


def _check_steering(rotors: Rotors, mark: Mark, report: Report) -> None:
    """Torque about each axis apart from the others, and from lift."""
    rows = effectiveness(rotors)
    left: list[list[float]] = []
    for name, axis in (("lift", 3), ("roll", 0), ("pitch", 1), ("yaw", 2)):
        column = [row[axis] for row in rows]
        whole = math.hypot(*column)
        for other in left:
            along = sum(a * b for a, b in zip(column, other, strict=True))
            column = [a - along * b for a, b in zip(column, other, strict=True)]
        rest = math.hypot(*column)
        if rest <= 1e-3 * max(whole, 1e-9):
            report.error(
                mark,
                "rotors-cannot-steer",
                f"expected rotors that make {name} torque alone, found none",
                "let as many rotors turn cw as ccw"
                if name == "yaw"
                else "place rotors on both sides of the centre of mass",
            )
            return
        left.append([value / rest for value in column])


def _check_thrust(vehicle: Vehicle, mark: Mark, report: Report) -> None:
    if vehicle.most_thrust <= vehicle.weight:
        report.error(
            mark,
            "thrust-too-small",
            f"expected more thrust than the weight of {vehicle.weight:.4g} N, "
            f"found {vehicle.most_thrust:.4g} N of all rotors at max_speed",
            "check thrust_per_speed2, max_speed and mass",
        )
