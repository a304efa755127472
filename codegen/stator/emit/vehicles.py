"""The vehicle of a graph as text for the simulated world."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.graph.vehicle import Vehicle


def world_lines(vehicle: Vehicle) -> list[str]:
    """The vehicle as the simulated world reads it: boards/world/world/vehicle.hpp."""
    rotors, ground, battery = vehicle.rotors, vehicle.ground, vehicle.battery
    rows: list[tuple[str, tuple[float, ...]]] = [
        ("mass", (vehicle.mass,)),
        ("inertia", vehicle.inertia),
        ("drag_area", vehicle.drag_area),
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
    ]
    rows += [
        ("rotor", (r.x, r.y, r.z, 1.0 if r.is_ccw else -1.0, r.in_wake)) for r in rotors.places
    ]
    rows += [
        ("stiffness", (ground.stiffness,)),
        ("damping", (ground.damping,)),
        ("friction", (ground.friction,)),
        *(("foot", point) for point in ground.feet),
        *(("hull", point) for point in ground.hull),
        ("cells", (float(battery.cells),)),
        ("capacity", (battery.capacity,)),
        ("resistance", (battery.resistance,)),
        ("nominal_voltage", (battery.nominal_voltage,)),
        ("avionics_power", (battery.avionics_power,)),
    ]
    return [" ".join([name, *(repr(value) for value in values)]) for name, values in rows]
