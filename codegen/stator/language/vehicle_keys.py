"""The keys of a vehicle: its masses, rotors, wing, body, landing gear and battery.

Lengths are from the centre of mass: x forward, y to the right, z down.
"""

from __future__ import annotations

from stator.language.nested import Key, Listing, Struct
from stator.language.quantity import Quantity
from stator.language.shapes import Choice, Integer, Text
from stator.language.wing_keys import (
    LENGTH,
    MAX_PROPELLERS,
    MAX_SURFACES,
    MAX_WHEELS,
    POINT,
    PROPELLER,
    SURFACE,
    WHEEL,
    WING,
    above_zero,
    from_zero,
)

LEAST_ROTORS, MAX_ROTORS = 4, 12  # ActuatorMotors.control
LEAST_FEET, MAX_CONTACTS = 3, 32  # the bits of a word in boards/world/world/ground.hpp

INERTIA = Struct(
    {
        "xx": Key(above_zero("kg m^2"), "About the forward axis.", required=True),
        "yy": Key(above_zero("kg m^2"), "About the axis to the right.", required=True),
        "zz": Key(above_zero("kg m^2"), "About the axis down.", required=True),
        "xz": Key(
            Quantity("kg m^2"),
            "The product of inertia, the integral of x z over the mass; 0 if left out. The plane "
            "of x and z is a plane of symmetry.",
        ),
    }
)

ROTOR = Struct(
    {
        "x": Key(LENGTH, "Forward of the centre of mass.", required=True),
        "y": Key(LENGTH, "To the right of it.", required=True),
        "z": Key(LENGTH, "Below it; 0 if left out. A rotor thrusts up."),
        "turns": Key(Choice(("ccw", "cw")), "Which way it turns, seen from above.", required=True),
        "in_wake": Key(
            Quantity("1", least=0.0, most=1.0, is_above=True),
            "The part of its thrust that a rotor has in the wake of another one; 1 if left out.",
        ),
    }
)

ROTORS = Struct(
    {
        "thrust_per_speed2": Key(
            above_zero("N s^2"), "Thrust of a rotor over its speed squared.", required=True
        ),
        "torque_per_thrust": Key(
            above_zero("m"), "Torque that turning the air costs, over the thrust.", required=True
        ),
        "max_speed": Key(above_zero("rad/s"), "The speed at full command.", required=True),
        "rise_time": Key(
            above_zero("s"), "Time constant of a rotor that speeds up.", required=True
        ),
        "fall_time": Key(
            above_zero("s"), "Time constant of a rotor that slows down.", required=True
        ),
        "disc_area": Key(above_zero("m^2"), "The area that one rotor sweeps.", required=True),
        "efficiency": Key(
            Quantity("1", least=0.0, most=1.0, is_above=True),
            "Part of the electric power that pushes air: losses of propeller, motor and "
            "controller.",
            required=True,
        ),
        "inflow_pitch": Key(
            above_zero("m/rad"),
            "A rotor that climbs at this times its speed has no thrust left.",
            required=True,
        ),
        "drag": Key(
            from_zero("N s^2/m"),
            "Force across the axis, over speed of the rotor and of the air; 0 if left out.",
        ),
        "rolling_moment": Key(
            from_zero("N s^2"),
            "Torque of the wind across the axis, over both speeds; 0 if left out.",
        ),
        "places": Key(
            Listing(ROTOR, least=LEAST_ROTORS, most=MAX_ROTORS),
            "The rotors, in the order of the motors' commands.",
            required=True,
        ),
    }
)

GROUND = Struct(
    {
        "stiffness": Key(above_zero("N/m"), "Of each point that touches.", required=True),
        "damping": Key(above_zero("N s/m"), "Of each point that touches.", required=True),
        "friction": Key(Quantity("1", least=0.0, most=2.0), "Its coefficient.", required=True),
        "feet": Key(
            Listing(POINT, least=LEAST_FEET, most=MAX_CONTACTS // 2),
            "What the vehicle stands on, each as [x, y, z]; none if it has wheels.",
        ),
        "wheels": Key(
            Listing(WHEEL, least=LEAST_FEET, most=MAX_WHEELS), "What the vehicle rolls on."
        ),
        "hull": Key(
            Listing(POINT, most=MAX_CONTACTS // 2),
            "Other points that may touch the ground: of a vehicle that has turned over.",
        ),
    }
)

BATTERY = Struct(
    {
        "cells": Key(Integer(1, 48), "Cells in series, of lithium polymer.", required=True),
        "capacity": Key(above_zero("C"), "The charge of a full battery.", required=True),
        "resistance": Key(above_zero("ohm"), "Of all cells and the wires.", required=True),
        "nominal_voltage": Key(
            above_zero("V"), "The voltage for which the speeds of rotors hold.", required=True
        ),
        "avionics_power": Key(from_zero("W"), "What is drawn beside the motors; 0 if left out."),
    }
)

VEHICLE = Struct(
    {
        "doc": Key(Text(), "What the vehicle is, and where its numbers are from.", required=True),
        "mass": Key(above_zero("kg"), "All of it, ready to fly.", required=True),
        "inertia": Key(INERTIA, "About the centre of mass.", required=True),
        "drag_area": Key(
            Listing(from_zero("m^2"), least=3, most=3),
            "Drag coefficient times area of the airframe, along x, y and z; 0 if left out.",
        ),
        "rotors": Key(ROTORS, "The rotors that lift; none if it flies by a wing."),
        "wing": Key(WING, "The wing, with tail and fuselage; none if it flies by rotors."),
        "surfaces": Key(
            Listing(SURFACE, least=1, most=MAX_SURFACES),
            "The control surfaces of the wing, in the order of the servos' commands.",
        ),
        "propellers": Key(
            Listing(PROPELLER, least=1, most=MAX_PROPELLERS),
            "What pulls or pushes the wing; their commands follow those of the rotors.",
        ),
        "ground": Key(GROUND, "Where and how the vehicle touches the ground.", required=True),
        "battery": Key(BATTERY, "What feeds the motors.", required=True),
    }
)
