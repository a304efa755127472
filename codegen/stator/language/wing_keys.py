"""The keys of a vehicle that flies by a wing: wing, control surfaces, propellers, wheels.

Coefficients are as flight mechanics has them: forces in wind axes over dynamic pressure and wing
area, moments over these and the span (roll, yaw) or the chord (pitch); angles in radians, rates as
p b / 2V, q c / 2V, r b / 2V.
"""

from __future__ import annotations

import math

from stator.language.nested import Key, Listing, Struct
from stator.language.quantity import Quantity
from stator.language.shapes import Choice, Name

MAX_SURFACES = 8  # ActuatorServos.control
MAX_PROPELLERS = 2
MAX_WHEELS = 6
_FARTHEST = 50.0

LENGTH = Quantity("m", least=-_FARTHEST, most=_FARTHEST)
POINT = Listing(LENGTH, least=3, most=3)
_COEFFICIENT = Quantity("1", least=-1000.0, most=1000.0)
_ANGLE = Quantity("rad", least=0.0, most=math.pi)


def above_zero(unit: str) -> Quantity:
    return Quantity(unit, least=0.0, is_above=True)


def from_zero(unit: str) -> Quantity:
    return Quantity(unit, least=0.0)


def _coefficients(**docs: str) -> Struct:
    return Struct({name: Key(_COEFFICIENT, f"{doc}; 0 if left out.") for name, doc in docs.items()})


_LONGITUDINAL = _coefficients(
    zero="At no angle of attack", alpha="Of that angle", pitch_rate="Of q c / 2V"
)
_LATERAL = _coefficients(
    beta="Of the sideslip, positive for air from the right",
    roll_rate="Of p b / 2V",
    yaw_rate="Of r b / 2V",
)

FADING = Struct(
    {
        "from": Key(_ANGLE, "The angle of attack up to which all of it is there.", required=True),
        "to": Key(_ANGLE, "The angle of attack from which `left` is there.", required=True),
        "left": Key(Quantity("1", least=-1.0, most=1.0), "That part.", required=True),
    }
)

STALL = Struct(
    {
        "begins": Key(_ANGLE, "The angle of attack where the derivatives end.", required=True),
        "blend": Key(above_zero("rad"), "Over what angle the curve takes over.", required=True),
        "curve": Key(
            Listing(
                Struct(
                    {
                        "alpha": Key(_ANGLE, "The angle of attack.", required=True),
                        "lift": Key(_COEFFICIENT, "CL there.", required=True),
                        "drag": Key(from_zero("1"), "CD there.", required=True),
                        "pitch": Key(_COEFFICIENT, "Cm there.", required=True),
                    }
                ),
                least=2,
                most=64,
            ),
            "Without rates and deflections, by rising angle from the stall to 180 deg; mirrored "
            "for negative angles.",
            required=True,
        ),
        "roll_damping": Key(FADING, "How `roll: roll_rate` fades; it stays if left out."),
    }
)

WING = Struct(
    {
        "area": Key(above_zero("m^2"), "That coefficients are over.", required=True),
        "span": Key(above_zero("m"), "That those of roll and yaw are over.", required=True),
        "chord": Key(above_zero("m"), "That those of pitch are over.", required=True),
        "reference": Key(POINT, "The point where the forces act; the centre of mass if left out."),
        "lift": Key(_LONGITUDINAL, "CL.", required=True),
        "drag": Key(
            _coefficients(
                zero="The least",
                alpha="Of the angle of attack",
                alpha2="Of its square",
                beta="Of the sideslip",
                beta2="Of its square",
                lift2="Of (CL - least_lift)^2",
                least_lift="The CL of least drag",
            ),
            "CD.",
            required=True,
        ),
        "side": Key(_LATERAL, "CY, positive to the right.", required=True),
        "roll": Key(_LATERAL, "Cl, positive to the right.", required=True),
        "pitch": Key(_LONGITUDINAL, "Cm, positive nose up.", required=True),
        "yaw": Key(_LATERAL, "Cn, positive nose right.", required=True),
        "stall": Key(STALL, "What is beyond the derivatives.", required=True),
    }
)

SURFACE = Struct(
    {
        "name": Key(Name(), "Of the surface: aileron, elevator, rudder.", required=True),
        "most": Key(above_zero("rad"), "Its deflection at command 1.", required=True),
        "least": Key(
            Quantity("rad", least=-math.pi, most=0.0),
            "Its deflection at command -1 is -`most`, but not below this; -`most` if left out.",
        ),
        "rate": Key(above_zero("rad/s"), "The most that its servo turns it.", required=True),
        "time_constant": Key(from_zero("s"), "Of its servo.", required=True),
        **_coefficients(
            lift="CL of a radian",
            drag="CD of a radian, whichever way",
            drag2="CD of its square",
            side="CY of a radian",
            roll="Cl of a radian",
            pitch="Cm of a radian",
            yaw="Cn of a radian",
        ).keys,
        "fades": Key(FADING, "How its effect fades in a stall; it stays if left out."),
    }
)

_POLYNOMIAL = Listing(_COEFFICIENT, least=1, most=8)

PROPELLER = Struct(
    {
        "at": Key(POINT, "Where its hub is.", required=True),
        "turned": Key(
            Quantity("rad", least=-math.pi, most=math.pi),
            "Of its thrust, to the right of forward; 0 if left out.",
        ),
        "raised": Key(
            Quantity("rad", least=-math.pi / 2, most=math.pi / 2),
            "Of its thrust, above forward; 0 if left out.",
        ),
        "turns": Key(Choice(("cw", "ccw")), "Which way, seen from behind.", required=True),
        "diameter": Key(above_zero("m"), "Of the propeller.", required=True),
        "inertia": Key(above_zero("kg m^2"), "Of all that spins.", required=True),
        "thrust": Key(
            _POLYNOMIAL,
            "CT = T / (rho n^2 D^4) by J = V / (n D), the lowest power first.",
            required=True,
        ),
        "power": Key(
            _POLYNOMIAL,
            "CP = P / (rho n^3 D^5) by J, the lowest power first.",
            required=True,
        ),
        "most_advance": Key(
            above_zero("1"),
            "The J up to which the polynomials hold; then they stay.",
            required=True,
        ),
        "shaft_power": Key(
            Listing(Quantity("W"), least=1, most=8),
            "What the motor gives by the throttle, 0 to 1, the lowest power first, at the nominal "
            "voltage; it goes with the square of the voltage.",
            required=True,
        ),
        "efficiency": Key(
            Quantity("1", least=0.0, most=1.0, is_above=True),
            "Shaft power over electric power.",
            required=True,
        ),
    }
)

WHEEL = Struct(
    {
        "at": Key(POINT, "Where it touches the ground, unloaded.", required=True),
        "stiffness": Key(above_zero("N/m"), "Of its spring.", required=True),
        "damping": Key(from_zero("N s/m"), "Of its damper.", required=True),
        "rolling": Key(from_zero("1"), "Friction coefficient along the wheel.", required=True),
        "brake": Key(
            from_zero("1"),
            "The same while the vehicle waits with its motors stopped; `rolling` if left out.",
        ),
        "steered_by": Key(Name(), "The surface whose servo steers it."),
        "steering": Key(
            Quantity("1", least=-10.0, most=10.0),
            "Its angle, positive to the right, over the deflection of that surface; 1 if left out.",
        ),
    }
)
