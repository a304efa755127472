"""The vehicle of a graph as text for the simulated world."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.graph.vehicle import Rotors, Vehicle
    from stator.graph.wing import Fading, Propeller, Surface, Wheel, Wing


Row = tuple[str, tuple[float, ...]]


def world_lines(vehicle: Vehicle) -> list[str]:
    """The vehicle as the simulated world reads it: boards/world/world/vehicle_text.hpp."""
    rows: list[Row] = [
        ("mass", (vehicle.mass,)),
        ("inertia", vehicle.inertia),
        ("drag_area", vehicle.drag_area),
    ]
    if vehicle.rotors is not None:
        rows += _rotors(vehicle.rotors)
    if vehicle.wing is not None:
        rows += _wing(vehicle.wing)
    rows += [_surface(surface) for surface in vehicle.surfaces]
    for propeller in vehicle.propellers:
        rows += _propeller(propeller)
    ground, battery = vehicle.ground, vehicle.battery
    rows += [
        ("stiffness", (ground.stiffness,)),
        ("damping", (ground.damping,)),
        ("friction", (ground.friction,)),
        *(("foot", point) for point in ground.feet),
        *(("hull", point) for point in ground.hull),
        *(_wheel(wheel) for wheel in ground.wheels),
        ("cells", (float(battery.cells),)),
        ("capacity", (battery.capacity,)),
        ("resistance", (battery.resistance,)),
        ("nominal_voltage", (battery.nominal_voltage,)),
        ("avionics_power", (battery.avionics_power,)),
    ]
    return [" ".join([name, *(repr(value) for value in values)]) for name, values in rows]


def _rotors(rotors: Rotors) -> list[Row]:
    return [
        ("thrust_per_speed2", (rotors.thrust_per_speed2,)),
        ("torque_per_thrust", (rotors.torque_per_thrust,)),
        ("max_speed", (rotors.max_speed,)),
        ("rise_time", (rotors.rise_time,)),
        ("fall_time", (rotors.fall_time,)),
        ("disc_area", (rotors.disc_area,)),
        ("efficiency", (rotors.efficiency,)),
        ("inflow_pitch", (rotors.inflow_pitch,)),
        ("drag", (rotors.drag,)),
        ("rolling_moment", (rotors.rolling_moment,)),
        *(("rotor", (r.x, r.y, r.z, 1.0 if r.is_ccw else -1.0, r.in_wake)) for r in rotors.places),
    ]


def _wing(wing: Wing) -> list[Row]:
    return [
        ("wing", (wing.area, wing.span, wing.chord, *wing.reference)),
        ("wing_lift", wing.lift),
        ("wing_drag", wing.drag),
        ("wing_side", wing.side),
        ("wing_roll", wing.roll),
        ("wing_pitch", wing.pitch),
        ("wing_yaw", wing.yaw),
        ("stall", (wing.stall_begins, wing.stall_blend)),
        *(("stall_point", (p.alpha, p.lift, p.drag, p.pitch)) for p in wing.curve),
        ("roll_damping", _fading(wing.roll_damping)),
    ]


def _fading(fading: Fading) -> tuple[float, float, float]:
    return (fading.begin, fading.end, fading.left)


def _surface(s: Surface) -> Row:
    motion = (s.least, s.most, s.rate, s.time_constant)
    effects = (s.lift, s.drag, s.drag2, s.side, s.roll, s.pitch, s.yaw)
    return ("surface", (*motion, *effects, *_fading(s.fades)))


def _propeller(p: Propeller) -> list[Row]:
    turns = 1.0 if p.is_cw else -1.0
    direction = (p.turned, p.raised, turns)
    return [
        ("propeller", (*p.at, *direction, p.diameter, p.inertia, p.most_advance, p.efficiency)),
        ("propeller_thrust", p.thrust),
        ("propeller_power", p.power),
        ("shaft_power", p.shaft_power),
    ]


def _wheel(w: Wheel) -> Row:
    return (
        "wheel",
        (*w.at, w.stiffness, w.damping, w.rolling, w.brake, float(w.steered_by), w.steering),
    )
