"""Reads a vehicle, and refuses what no rigid body is and what cannot fly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.diagnostics import Report
from stator.graph.sources import Sources
from stator.language.vehicle_keys import MAX_ROTORS, VEHICLE

if TYPE_CHECKING:
    from pathlib import Path

    from stator.diagnostics import Mark
    from stator.language.shapes import Leaf, Record

GRAVITY = 9.80665
Point = tuple[float, float, float]


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
    places: tuple[Rotor, ...]

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
    rotors: Rotors
    ground: Ground
    battery: Battery

    @property
    def thrust_over_weight(self) -> float:
        return 1.0 / self.hover_thrust

    @property
    def hover_thrust(self) -> float:
        """What carries the weight, of all the thrust that there is."""
        return self.mass * GRAVITY / self.rotors.most_thrust


def param_values(vehicle: Vehicle) -> dict[str, Fraction]:
    """What parameters may take from a vehicle, as a person writes it."""
    values: dict[str, Fraction] = {
        "hover_thrust": _rounded(vehicle.hover_thrust, 3),
        "rotor_count": Fraction(len(vehicle.rotors.places)),
    }
    for axis, moment in zip("xyz", vehicle.inertia, strict=False):
        values[f"gyration_{axis}"] = _rounded(math.sqrt(moment / vehicle.mass), 4)
    for i in range(MAX_ROTORS):
        values |= {f"rotor{i}_{what}": Fraction(0) for what in ("x", "y", "moment")}
    for i, rotor in enumerate(vehicle.rotors.places):
        moment = vehicle.rotors.torque_per_thrust * (1.0 if rotor.is_ccw else -1.0)
        for what, value in (("x", rotor.x), ("y", rotor.y), ("moment", moment)):
            values[f"rotor{i}_{what}"] = Fraction(repr(value))
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
        drag_area=_point(record.get("drag_area")),
        rotors=_rotors(rotors),
        ground=_ground(record.get("ground")),
        battery=_battery(record.get("battery")),
    )
    _check_inertia(vehicle, record.keys["inertia"], sources.report)
    if _are_apart(vehicle, rotors.get("places"), sources.report):
        _check_steering(vehicle, rotors.keys["places"], sources.report)
    _check_thrust(vehicle, record.keys["rotors"], sources.report)
    return None if len(sources.report) > count else vehicle


def _point(leaf: Leaf | None) -> Point:
    if leaf is None:
        return (0.0, 0.0, 0.0)
    x, y, z = (item.value for item in leaf.value)
    return (x, y, z)


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


def _ground(record: Record) -> Ground:
    return Ground(
        stiffness=record.value("stiffness"),
        damping=record.value("damping"),
        friction=record.value("friction"),
        feet=tuple(map(_point, record.value("feet"))),
        hull=tuple(map(_point, record.value("hull", []))),
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
    for i, rotor in enumerate(vehicle.rotors.places):
        same = [
            other
            for other in vehicle.rotors.places[:i]
            if (other.x, other.y, other.z) == (rotor.x, rotor.y, rotor.z)
        ]
        if same:
            report.error(
                places.value[i].mark,
                "rotor-place",
                f"duplicate place of a rotor: rotors {vehicle.rotors.places.index(same[0]) + 1} "
                f"and {i + 1} are at the same point",
                "move one of them; a coaxial pair has two values of z",
            )
    return len(report) == count


def effectiveness(vehicle: Vehicle) -> list[list[float]]:
    """Roll, pitch, yaw torque and lift of a unit of thrust, a row for each rotor."""
    moment = vehicle.rotors.torque_per_thrust
    return [
        [
            -r.y * r.in_wake,
            r.x * r.in_wake,
            (moment if r.is_ccw else -moment) * r.in_wake,
            r.in_wake,
        ]
        for r in vehicle.rotors.places
    ]


def _check_steering(vehicle: Vehicle, mark: Mark, report: Report) -> None:
    """Torque about each axis apart from the others, and from lift."""
    rows = effectiveness(vehicle)
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
    weight = vehicle.mass * GRAVITY
    if vehicle.rotors.most_thrust <= weight:
        report.error(
            mark,
            "thrust-too-small",
            f"expected more thrust than the weight of {weight:.4g} N, "
            f"found {vehicle.rotors.most_thrust:.4g} N of all rotors at max_speed",
            "check thrust_per_speed2, max_speed and mass",
        )
